"""G150 of Haas's mills: a pocket of any shape, whose outline a subprogram has (Haas mill operator's manual, "G150").

The tool goes to X Y, inside the pocket, and down from R in steps of Q. At each it goes around the outline, K off, and clears what lies
inside in rows J apart in Y, or I apart in X; at the floor it goes around once more, without K. The first move of the subprogram leads to
the outline, the others are the outline. A bridge, a line there and back, leads to an island. Rows and the ways between them are our own
choice (`contour_pockets`).
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from cncgen.gcode.block import Block
from cncgen.gcode.codes.contour_pockets import area, around, check, clear, closed, free, room
from cncgen.gcode.codes.cutter_compensation import tool_of_radius
from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.codes.lines import check_feed
from cncgen.gcode.codes.pockets import Clearing
from cncgen.gcode.codes.table import ROTARY_PATH, TOOL_POINT, Code
from cncgen.gcode.codes.tools import whole
from cncgen.gcode.codes.turning_profiles import TINY, Segment, check_cuts, recording
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import PLAIN_MOTIONS, Stage
from cncgen.gcode.text.labels import Cursor
from cncgen.records import replace

_NAME = "G150"
_Z = 2
_M99 = 990
#: Words and codes of a line that make the outline.
_WORDS = frozenset(("x", "y", "i", "j", "r", ",c", ",r"))
_CODES = frozenset((*PLAIN_MOTIONS, 900, 910))


class _EndOfOutlineError(Exception):
    """M99 ends the subprogram of an outline."""


def _outline(ip: Interpreter, block: Block) -> list[Segment]:
    """Return the moves of the subprogram in X and Y, the first one leads to the outline."""
    flow = ip.flow_control()
    here = Cursor(block.source, block.offset, block.line)
    number = whole(block, "p", _NAME)
    try:
        first = flow.line_numbered(here, number, "P")
    except BlockError:
        try:
            first = flow.subroutines.find(float(number), here, ("program", "sub")).cursor
        except BlockError as error:
            error.word = "P"
            raise
    with recording(ip, 17) as recorder:

        def take(line: Block) -> None:
            ip.check(line)
            words = line.only(_WORDS)
            codes = tuple(code for code in line.g if code in _CODES)
            if words or codes:
                made = replace(line, words=words, g=codes, m=())
                if ip.guard is not None:
                    ip.guard(ip, made)
                ip.execute(made)
            if _M99 in line.m:
                raise _EndOfOutlineError

        with suppress(_EndOfOutlineError):
            flow.run_profile(take, first, float(number), "P")
    return recorder.segments


def _parted(contour: list[Segment]) -> list[list[Segment]]:
    """Return a contour and the islands that bridges lead to, lines that are gone there and back."""
    for k, there in enumerate(contour):
        for n in range(k + 1, len(contour)):
            back = contour[n]
            if (
                there.centre is back.centre is None
                and abs(there.end - back.start) < TINY
                and abs(there.start - back.end) < TINY
            ):
                return [*_parted(contour[:k] + contour[n + 1 :]), *_parted(contour[k + 1 : n])]
    return [contour] if contour else []


def _steps(ip: Interpreter, words: dict[str, float]) -> tuple[float, bool]:
    """Return how far rows are apart, and whether they lie along Y; raise where a word is missing, or not above 0."""
    missing = [letter.upper() for letter in "zqpr" if letter not in words]
    if missing:
        hint = "Z is the floor, Q the depth of a step, R the height above the part, P the subprogram of the outline"
        raise BlockError("cycle-words", f"{_NAME} has no {missing[0]}", _NAME, hint=hint)
    given = [letter for letter in "ij" if letter in words]
    if len(given) != 1:
        message = f"{_NAME} has {'both I and J' if given else 'neither I nor J'}"
        raise BlockError("cycle-words", message, _NAME, hint="I steps aside along X, J along Y")
    for letter in (given[0], "q"):
        if words[letter] <= 0.0:
            message = f"{letter.upper()}{words[letter]:g} of {_NAME} is to be above 0"
            raise BlockError("cycle-infeed", message, letter.upper())
    return words[given[0]], given[0] == "i"


def _levels(start: float, floor: float, infeed: float) -> tuple[float, ...]:
    """Return the levels from R down to the floor, Q apart; the last step is what is left."""
    if floor >= start:
        raise BlockError("cycle-level", f"the floor Z{floor:g} of {_NAME} lies above R{start:g}", "Z")
    check_cuts(start, floor, infeed, _NAME, "Q")
    levels, level = [], start - infeed
    while level > floor + TINY:
        levels.append(level)
        level -= infeed
    return (*levels, floor)


def pocket(ip: Interpreter, block: Block) -> None:
    """G150 X Y Z F I (or J) K P Q R D, with G41 or G42."""
    state, words = ip.state, block.words
    side = state.compensation
    if state.plane != 17 or not state.absolute or side == 40:
        hint = "G150 G41 D1 X1. Y1. Z-0.5 R0.1 Q0.2 J0.2 K0.01 P1000 F15."
        raise BlockError("cycle-plane", f"{_NAME} is read in G17 and G90, with G41 or G42", _NAME, hint=hint)
    ip.end_compensation()
    check_feed(ip, block, _NAME)
    step, upright = _steps(ip, words)
    # It is 0 where no table gives the diameter.
    radius = abs(tool_of_radius(ip, block, _NAME).diameter) * ip.table_scale() / 2.0
    finish = words.get("k", 0.0)
    begin = ip.end_point(replace(block, words={letter: words[letter] for letter in "xy" if letter in words}))
    ip.go(begin, rapid=True)
    # Where rows lie along Y, all is seen turned by a right angle.
    turn = 1j if upright else 1.0 + 0j
    moves = [
        Segment(s.start / turn, s.end / turn, None if s.centre is None else s.centre / turn, s.spin)
        for s in _outline(ip, block)
    ]
    parts = [closed(part, _NAME) for part in _parted(moves[1:])] or [closed([], _NAME)]
    if (area(parts[0]) > 0.0) != (side == 41):
        message = f"the outline of {_NAME} goes {'counter-' if side == 42 else ''}clockwise, and G{side} is on its outside"
        hint = "G41 with an outline counter-clockwise, G42 with one clockwise"
        raise BlockError("not-read", message, "P", hint=hint)
    contours = [(part, k > 0) for k, part in enumerate(parts)]
    check(contours, _NAME)
    radius = radius or ip.cutting_radius(
        _NAME, room(contours, _NAME, step, step / 8.0, finish, side == 41) / 0.8
    )
    levels = _levels(words["r"], words["z"], words["q"])
    how = Clearing(radius, step, levels, words["r"], state.feed, state.feed)
    _mill(FlatCutter(ip, 0j, turn), contours, how, finish, complex(*begin[:2]) / turn, side == 41)
    state.moved = True


def _mill(
    tool: FlatCutter,
    contours: Sequence[tuple[Sequence[Segment], bool]],
    how: Clearing,
    finish: float,
    begin: complex,
    climb: bool,
) -> None:
    """Clear the pocket level by level from a place inside it, and go around the walls at last."""
    shapes = [contour for contour, _ in contours]
    walls = [segment for shape in shapes for segment in shape]

    def enter(place: complex, level: float, above: float) -> None:
        tool.to(z=how.start, rapid=True)
        tool.to(place, rapid=True)
        tool.to(z=above, rapid=True)
        tool.to(z=level)

    def go_around(level: float, above: float, off: float) -> complex:
        at = begin
        enter(at, level, above)
        for way in around(contours, how.radius + off, _NAME, climb=climb):
            if not free(at, way[0].start, walls, how.radius + off):
                enter(way[0].start, level, above)
            tool.to(way[0].start)
            for segment in way:
                tool.follow(segment)
            at = way[-1].end
        return at

    clear(tool.ip, shapes, how.radius + finish, how, 0.0, _NAME, turn=tool.turn,
          opened=lambda level, above: go_around(level, above, finish))  # fmt: skip
    if finish > 0.0:
        go_around(how.levels[-1], how.levels[-1], 0.0)
        tool.to(z=how.start, rapid=True)


CODES = (
    Code("G", 1500, "non-modal", Stage.MOTION, pocket, "pocket of any shape, outline in P (Haas)", "xyzijkpqrd", "own",
        dialects=("fanuc",), takes="d", moves="plane", calls="p", refused=("is a pocket cycle", ROTARY_PATH | TOOL_POINT),
        without="lathes"),
)  # fmt: skip

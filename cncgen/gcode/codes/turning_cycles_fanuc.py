"""Cycles of profiles on FANUC's lathes: G71 along Z, G72 along X and G73 in passes like it rough them, G70 finishes.

The profile is the lines from N P to N Q of the program. The cycle reads them, and the program goes on behind them. The first line
leads to the profile. G71 and G72 cut it in levels from where the tool stands, moved by the allowances U and W: at each they feed along
to the profile, lift off at 45 degrees and go back; at last they follow it. Where the first line of the profile has both X and Z (type
II) it may have pockets, each of which is cut at every level; the way from one to the next, over the stock, is our own. G70 executes
the lines (B-64304EN-1, 4.4.1 to 4.4.4).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from itertools import pairwise

from cncgen.gcode.block import Block, Jump
from cncgen.gcode.codes.lathe_fanuc import (
    ALLOWANCE,
    DEEP,
    LIFT,
    ONLY,
    Turning,
    check_idle,
    depth_of,
    length_of,
    turning_of,
)
from cncgen.gcode.codes.lathe_words import X, Z, turned
from cncgen.gcode.codes.lines import check_feed
from cncgen.gcode.codes.table import IS_TURNING, PROFILE, Code
from cncgen.gcode.codes.tools import whole
from cncgen.gcode.codes.turning_cycles import Lathe
from cncgen.gcode.codes.turning_profiles import MAX_CUTS, ROUNDED, TINY, Segment, check_cuts, recording
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import PLAIN_MOTIONS, Stage
from cncgen.gcode.text.labels import Cursor
from cncgen.records import replace

#: Words and codes of a line that make the profile, where it is roughed.
_WORDS = frozenset(("x", "z", "r", "i", "k", ",c", ",r"))


def _run(ip: Interpreter, block: Block, name: str, take: Callable[[Block], None]) -> None:
    """Run the lines of the profile that P and Q of a cycle name; `take` receives their blocks."""
    missing = [letter.upper() for letter in "pq" if letter not in block.words]
    if missing:
        hint = "P and Q are the N words of the first and last line of the profile"
        raise BlockError("profile-missing", f"{name} has no {missing[0]}", name, hint=hint)
    flow, here = ip.flow_control(), Cursor(block.source, block.offset, block.line)
    numbers, places = (whole(block, "p", name), whole(block, "q", name)), turning_of(ip).places
    if name != "G70" or numbers not in places:
        # G70 finishes the lines that were roughed, where their numbers stand elsewhere too.
        places[numbers] = (
            flow.line_numbered(here, numbers[0], "P"),
            flow.line_numbered(here, numbers[1], "Q"),
        )
    first, last = places[numbers]
    if last.offset < first.offset:
        message = f"the profile ends in line {last.line}, above its beginning in line {first.line}"
        raise BlockError("profile-missing", message, "Q", hint="P is its first line, Q its last")

    def checked(line: Block) -> None:
        refused = next((row for row in ip.codes.of(line) if row.refused[1] & PROFILE), None)
        if refused is not None:
            message = f"{refused.name} {refused.refused[0]}"
            raise BlockError("profile-flow", message, refused.name, hint="a profile is moves alone")
        take(line)

    flow.run_profile(checked, first, last, "P")


def _execute(ip: Interpreter, block: Block) -> None:
    """Execute a line of a profile."""
    if ip.guard is not None:
        ip.guard(ip, block)
    ip.execute(block)


def _end_corner(ip: Interpreter) -> None:
    """Let a chamfer or rounding of the last line say that no motion follows it."""
    if ip.guard is not None:
        ip.guard(ip, Block({}, m=(20,)))


def _profile(ip: Interpreter, block: Block, name: str) -> tuple[list[Segment], bool, int, bool]:
    """Return the moves of a profile in Z and X, the first one leads to it; whether that one is a traverse; how many traverses end it;
    and whether its first line has both X and Z.
    """
    rapid, away, both = None, 0, False
    with recording(ip) as recorder:

        def take(written: Block) -> None:
            nonlocal rapid, away, both
            before, line = len(recorder.segments), turned(ip, written)
            # The moves of a line are taken alone; codes and words that nobody knows are faults all the same.
            ip.check(line)
            codes = tuple(number for number in line.g if number in PLAIN_MOTIONS)
            words = line.only(_WORDS)
            if codes or words:
                _execute(ip, replace(line, words=words, g=codes, m=()))
            if rapid is None and (recorder.segments or {"x", "z"} <= words.keys()):
                rapid = ip.state.motion == 0
                both = {"x", "z"} <= words.keys()
            added = len(recorder.segments) - before
            away = away + added if ip.state.motion == 0 else 0 if added else away

        _run(ip, block, name, take)
        _end_corner(ip)
    if len(recorder.segments) < 2:
        raise BlockError("profile-length", f"the profile of {name} has fewer than two moves", "P")
    return recorder.segments, bool(rapid), away, both


def _allowance(ip: Interpreter, block: Block, name: str) -> complex:
    """Return the allowances W and U, this one a diameter, along Z and X."""
    along, across = (
        length_of(ip, block, letter, name, ALLOWANCE) if letter in block.words else 0.0 for letter in "wu"
    )
    return complex(along, 0.5 * across)


def _contour(
    ip: Interpreter, block: Block, name: str, swap: bool
) -> tuple[complex, complex, complex, list[Segment], bool]:
    """Return signs of travel and depth, and seen along them: where the cuts begin, where the tool stands, and the profile with its
    allowances; and whether its first line is a traverse.

    Traverses at its end that go back lead away from the part, and are left out.
    """
    moves, rapid, away, both = _profile(ip, block, name)
    allowance, position = _allowance(ip, block, name), ip.state.position
    start = complex(position[Z], position[X])
    for left_out in (0, away) if 0 < away < len(moves) - 1 else (0,):
        part = moves[: len(moves) - left_out]
        profile = [segment.shifted(allowance) for segment in part[1:]]
        way, above = part[-1].end - part[0].end, start - part[0].end
        travel, height = (way.imag, above.real) if swap else (way.real, above.imag)
        across = complex(_sign(travel), _sign(height))
        path = [segment.seen(across, swap) for segment in profile]
        if all(segment.advances(ROUNDED) and segment.rises(ROUNDED) for segment in path):
            break
    else:
        if both and all(segment.advances(ROUNDED) for segment in path):
            left_out = 0
        elif both:
            message = f"the profile of {name} goes back along {'X' if swap else 'Z'}"
            hint = "cut what lies behind in a cycle of its own, or use G73"
            raise BlockError("profile-not-monotonic", message, "P", hint=hint)
        else:
            message = f"the profile of {name} does not rise all the way, and its first line has not both X and Z (type II)"
            hint = "W0 (of G72 U0) in its first line says that it has pockets"
            raise BlockError("profile-not-monotonic", message, "P", hint=hint)
    if left_out:
        message = f"the traverse at the end of the profile of {name} goes back: it is taken as the way off, and not roughed"
        ip.warn("profile-way-off", message, "Q", "let Q name the line before it")
    _check_sides(ip, name, allowance, complex(travel, height), swap)
    here = Segment(start, start)
    top = here.shifted(profile[0].start - moves[0].end)
    begin, home = top.seen(across, swap).start, here.seen(across, swap).start
    return across, begin, home, path, rapid


def _check_sides(ip: Interpreter, name: str, allowance: complex, way: complex, swap: bool) -> None:
    """Warn of an allowance that moves the rough profile into the part; `way` is the travel, and on which side the stock lies."""
    along, deep = (allowance.imag, allowance.real) if swap else (allowance.real, allowance.imag)
    letters = "UW" if swap else "WU"
    for letter, value, inside in zip(
        letters, (along, deep), (along * way.real, -deep * way.imag), strict=True
    ):
        if inside > 0.0:
            behind = abs(value) * ip.state.unit_mm
            message = (
                f"{letter} of {name} points into the part: roughing cuts {behind:g} mm behind the profile"
            )
            hint = f"with the other sign of {letter} that much is left for G70"
            ip.warn("allowance-inside", message, letter, hint)


def _without_compensation(ip: Interpreter, name: str) -> None:
    """End cutter compensation for a roughing cycle, and note which one to begin again behind it."""
    kept, code = turning_of(ip), ip.state.compensation
    kept.compensation = 0
    if code != 40:
        ip.end_compensation()
        kept.compensation = 410 if code == 41 else 420
        message = f"{name} under G{code} roughs without the radius of the tool's nose; newer controls move the passes by it"
        hint = "the allowances U and W take what is left; G70 finishes with the radius"
        ip.warn("comp-roughing", message, name, hint)


def _compensate_again(ip: Interpreter, block: Block) -> None:
    """Begin the cutter compensation again that a roughing cycle ended."""
    code = turning_of(ip).compensation
    if code:
        ip.execute(block.beside({}, (code,)))


def _sign(value: float) -> float:
    return 1.0 if value >= 0.0 else -1.0


def _rough(ip: Interpreter, block: Block, name: str, swap: bool) -> None:
    """G71, or G72 with `swap`."""
    depth_word = "w" if swap else "u"
    words, kept = block.words, turning_of(ip)
    if "p" not in words and "q" not in words:
        hint = f"before the block with P and Q it takes {depth_word.upper()} and R"
        check_idle(ip, block, name, depth_word + "r", hint)
        if depth_word in words:
            kept.depth = abs(length_of(ip, block, depth_word, name, DEEP))
        if "r" in words:
            kept.escape = abs(length_of(ip, block, "r", name, LIFT))
        return
    check_feed(ip, block, name)
    hint = "how far it lifts off is R of a block before it; R1 of Haas is type II, as X and Z are in line P"
    check_idle(ip, block, name, "pquwd", hint)
    _without_compensation(ip, name)
    if "d" in words:
        kept.depth = depth_of(ip, block, name)
    if kept.depth <= 0.0:
        hint = f"write {name} {depth_word.upper()}2 R1 before it: depth of a cut, and how far it lifts off"
        raise BlockError("profile-step", f"{name} has no depth of its cuts", name, hint=hint)
    across, begin, home, path, rapid = _contour(ip, block, name, swap)
    lathe = Lathe(ip, across, swap)
    levels(lathe, path, begin, kept, rapid, name)
    lathe.rapid(home)
    _compensate_again(ip, block)
    ip.state.moved = True
    ip.jump = Jump("past", whole(block, "q", name))


def levels(lathe: Lathe, path: list[Segment], begin: complex, kept: Turning, rapid: bool, name: str) -> None:
    """Cut level by level above a path, then along it; raise where there are too many levels."""
    down = lathe.rapid if rapid else lathe.feed
    bottom = path[0].start
    lowest = min(p.imag for segment in path for p in segment.extremes())
    check_cuts(begin.imag, lowest, kept.depth, name)
    level = begin.imag - kept.depth
    lathe.rapid(begin)
    while level > lowest + TINY:
        for k, (left, right) in enumerate(_free(path, begin.real, level)):
            if left > begin.real + TINY:
                # A pocket: over the stock that is left, down to what the level before left of it, and into it.
                lathe.rapid(complex(left, begin.imag))
                lathe.rapid(complex(left, min(level + kept.depth, begin.imag)))
                lathe.feed(complex(left, level))
            elif k == 0:
                down(complex(begin.real, level))
            hit = complex(right, level)
            lathe.feed(hit)
            lift = min(kept.escape, right - left)
            lathe.rapid(hit + complex(-lift, lift))
            if left > begin.real + TINY:
                lathe.rapid(complex(hit.real - lift, begin.imag))
                lathe.rapid(begin)
            else:
                lathe.rapid(complex(begin.real, level + lift))
        level -= kept.depth
    down(complex(begin.real, bottom.imag))
    if abs(bottom.real - begin.real) > TINY:
        down(bottom)
    for segment in path:
        lathe.follow(segment, segment.end)


def _free(path: list[Segment], begin: float, level: float) -> Iterator[tuple[float, float]]:
    """Yield from where to where the path lies below a level, along the travel from `begin` on."""
    places = sorted({begin, path[-1].end.real, *(p.real for segment in path for p in segment.crossings(level)),
                     *(segment.end.real for segment in path if abs(segment.end.imag - level) <= TINY)})  # fmt: skip
    open_at: float | None = None
    for left, right in pairwise(places):
        if right - left <= TINY:
            continue
        highest = max((p.imag for one in path for p in _over(one, 0.5 * (left + right))), default=-math.inf)
        if left < path[0].start.real - TINY or highest < level - TINY:
            open_at = left if open_at is None else open_at
        elif open_at is not None:
            yield open_at, left
            open_at = None
    if open_at is not None:
        yield open_at, places[-1]


def _over(segment: Segment, at: float) -> list[complex]:
    """Return the points of a segment at a place of the travel."""
    if segment.centre is None and segment.start.real == segment.end.real == at:
        return [segment.start, segment.end]
    return [complex(p.imag, p.real) for p in segment.seen(1.0 + 1.0j, True).crossings(at)]


def like_it(ip: Interpreter, block: Block) -> None:
    """G73: passes along the profile, from the way of all passes and the allowances U W down to these.

    The way and the number of passes stand in a block before it (G73 U W R), or in the same one (I K D, radii, as on Haas's lathes and
    FANUC's series 10 to 15).
    """
    words, kept = block.words, turning_of(ip)
    alone = "p" not in words and "q" not in words
    across, along, often = "uwr" if alone else "ikd"
    x, z, count = kept.pattern
    count = whole(block, often, "G73") if often in words else count
    if not 1 <= count <= MAX_CUTS:
        message = f"{often.upper()}{count} of G73 must be from 1 to {MAX_CUTS}"
        raise BlockError("profile-passes", message, often.upper())
    x, z = (
        length_of(ip, block, letter, "G73", DEEP) if letter in words else before
        for letter, before in ((across, x), (along, z))
    )
    kept.pattern = x, z, count
    used = "uwr" if alone else "pquwikd"
    hint = "way and number of passes are U W R before the block with P and Q, or I K D in it"
    check_idle(ip, block, "G73", used, hint)
    if alone:
        return
    check_feed(ip, block, "G73")
    _without_compensation(ip, "G73")
    moves, *_ = _profile(ip, block, "G73")
    start = complex(ip.state.position[Z], ip.state.position[X])
    allowance, way = _allowance(ip, block, "G73"), complex(z, x)
    lathe = Lathe(ip, complex(1.0, 1.0), False)
    for index in range(count):
        left = 1.0 - index / (count - 1) if count > 1 else 1.0
        by = allowance + way * left
        lathe.rapid(start + by)
        path = [segment.shifted(by) for segment in moves]
        lathe.rapid(path[0].end)
        for segment in path[1:]:
            lathe.follow(segment, segment.end)
    lathe.rapid(start)
    _compensate_again(ip, block)
    ip.state.moved = True
    ip.jump = Jump("past", whole(block, "q", "G73"))


def finish(ip: Interpreter, block: Block) -> None:
    """G70: execute the lines of the profile, F and cutter compensation with them, and go back."""
    start = ip.state.position.copy()
    hint = "the profile is finished as it is written; allowances belong to G71 to G73"
    check_idle(ip, block, "G70", "pq", hint)
    _run(ip, block, "G70", ip.flow_control().execute)
    _end_corner(ip)
    back = ip.state.position.copy()
    back[X], back[Z] = start[X], start[Z]
    ip.sink.block = block
    ip.go(back, rapid=True)


CODES = tuple(
    Code("G", number, "non-modal", Stage.MOTION, run, text, words, "own", dialects=ONLY, axis_words="sizes", moves="XZ",
        refused=IS_TURNING)
    for number, run, text, words in (
        (700, finish, "finish the profile of lines N P to N Q", "pquwd"),
        (710, partial(_rough, name="G71", swap=False), "rough a profile along Z; first U R alone: depth (or D of Haas), lift", "pquwrd"),
        (720, partial(_rough, name="G72", swap=True), "rough a profile along X; first W R alone: depth (or D of Haas), lift", "pquwrd"),
        (730, like_it, "rough a profile in passes like it; way and number by U W R alone before it, or by I K D", "pquwrikd"),
    )
)  # fmt: skip

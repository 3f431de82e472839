"""Chamfers ``,C`` and corner roundings ``,R`` of FANUC, between the motion of their block and the next one.

``G1 X50 ,C5`` cuts the corner at X50 so that 5 are taken off both moves, measured from the corner; ``,R5`` puts an arc
there that touches both. The moves are lines or arcs in the plane in force (FANUC B-64484EN, "Optional chamfering and
corner R").

The motion of the block waits. The next motion is first run on a recorder, which gives its direction from the corner. Then the waiting
motion is shortened and passed on, followed by the chamfer or arc. The sink takes a motion by its end, and an arc by its centre as
well, so that the next one needs no change.
"""

from __future__ import annotations

import cmath
import math
from functools import partial

from cncgen.diagnostics import Severity
from cncgen.gcode.block import AXES, Block
from cncgen.gcode.budget import CORNER
from cncgen.gcode.codes.table import Code
from cncgen.gcode.codes.turning_profiles import Segment, fillet
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import PassingSink, Point, Sink, TryingSink
from cncgen.gcode.state.modal import PLANE_AXES, Stage, in_plane
from cncgen.records import dataclass

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

#: Moves that turn by less than this have no corner: the chamfer or arc between them has no length (ibid.).
_STRAIGHT_RAD = math.radians(1.0)
#: A move may be too short for its corner by this much, because programs round their numbers (program units).
_DIGITS = 1e-6
_HINTS = {
    "corner-motion": "write it in the block of the move that leads to the corner",
    "corner-next": "the move away from the corner must follow at once",
    "corner-plane": "G17, G18 and G19 choose the plane of corners",
    "corner-size": "make it smaller, or leave it out",
}
#: How dialects write them; CHF of SINUMERIK is ,H here.
_NAMES = {
    "sinumerik": {",R": "RND=", ",M": "RNDM=", ",C": "CHR=", ",H": "CHF="},
    "heidenhain": {",R": "RND R", ",C": "CHF "},
}
#: Words that decide where a motion leads, and groups of codes that do; Heidenhain's arcs and polar lines are groups of their own.
_WORDS = frozenset((*"xyzabcuvwijkrp", "dr", "pa", "ipa", "pr", "ipr"))
_GROUPS = frozenset(("motion", "plane", "units", "distance", "C", "CR", "CP", "LP"))
#: Blocks without a motion that SINUMERIK lets stand between the two motions of a corner (MD20200, its usual value), and the change of a
#: tool, which is none of them.
_MOST_BETWEEN, _TOOL_CHANGE = 3, 60
#: Part of a corner's size by which it may stay below the largest one that fits.
_NEARLY = 1e-12


@dataclass(slots=True)
class _Motion:
    """A motion as the sink takes it; `centre` and `turns` are those of an arc in `plane`."""

    end: Point
    centre: complex | None = None
    turns: int = 0
    plane: int = 0

    def segment(self, start: Point, plane: int) -> Segment:
        """Return it in the plane of a corner."""
        spin = (self.turns > 0) - (self.turns < 0)
        return Segment(in_plane(start, plane), in_plane(self.end, plane), self.centre, spin)

    def tell(self, sink: Sink, end: Point) -> None:
        """Tell a sink the motion up to a point of it."""
        if self.centre is None:
            sink.straight_feed(end)
        else:
            sink.arc_feed(end, self.centre.real, self.centre.imag, self.turns, self.plane)


class _Holding(PassingSink):
    """Keeps the feed motion of a block instead of passing it on."""

    motion: _Motion | None = None

    def straight_feed(self, end: Point) -> None:
        self.motion = _Motion(list(end))

    def arc_feed(self, end: Point, first: float, second: float, turns: int, plane: int) -> None:
        self.motion = _Motion(list(end), complex(first, second), turns, plane)


class _Trying(_Holding, TryingSink):
    """Keeps a feed motion and forgets everything else."""

    def straight_traverse(self, end: Point) -> None:
        """Keep nothing: a traverse makes no corner."""


def tried_motion(ip: Interpreter, run: Callable[[], None], compensation: int | None = None) -> _Motion | None:
    """Return the feed motion that would be made, under a compensation of its own, or None; a fault is reported when it is made."""
    trying = _Trying(ip.sink)
    try:
        with ip.on_trial(trying, compensation=compensation):
            run()
    except BlockError:
        return None
    return trying.motion


class _Later(PassingSink):
    """Keeps the calls of blocks that stand between the motions of a corner."""

    #: Its own: the sink behind is told later.
    block = Block({})

    def __init__(self, inner: Sink) -> None:
        super().__init__(inner)
        self._calls: list[tuple[Block, str, tuple[Any, ...], dict[str, Any]]] = []
        self.block = inner.block

    def __getattr__(self, name: str) -> Any:
        value = getattr(self.inner, name)
        if not callable(value):
            return value
        return lambda *arguments, **named: self._calls.append((self.block, name, arguments, named))

    def tell(self) -> None:
        """Tell the sink behind what was kept."""
        for block, name, arguments, named in self._calls:
            self.inner.block = block
            getattr(self.inner, name)(*arguments, **named)


class _Passed:
    """Stands as the guard in the block after a corner: `end` is where the chamfer or arc ended."""

    def __init__(self, end: Point) -> None:
        self.end = end

    def __call__(self, ip: Interpreter, block: Block) -> None:
        """Remove this sink: the block after the next one is independent of the corner."""
        ip.guard = None


class _Corner:
    """A motion with ``,C`` or ``,R`` that waits for the next one, as whose guard it stands.

    Attributes:
        name, size: ``,C`` or ``,R`` and its value.
        feed: That of the chamfer or arc alone, 0 where it has none of its own.
        start: Where the motion begins: behind the corner before it, where there is one.
        sink: The stand-in for the sink of the run while the motion's block is executed.
    """

    def __init__(self, ip: Interpreter, block: Block, name: str, size: float) -> None:
        self.name, self.size, self.feed = name, size, block.words.get("corner_f", 0.0)
        self._feed_beside = 0.0
        self.names = _NAMES.get(ip.dialect, {})
        #: Whether a corner that cannot be is made smaller or left out, and a few blocks may stand before the next motion.
        self.bends = ip.dialect == "sinumerik"
        self.between: set[int] = set()
        self.slack = _DIGITS
        self.later: _Later | None = None
        self.block = block
        self.plane = ip.state.plane
        self.start = ip.guard.end if isinstance(ip.guard, _Passed) else list(ip.state.position)
        self.sink = _Holding(ip.sink)

    def __call__(self, ip: Interpreter, block: Block) -> None:
        """Pass the motion on, and its corner with the motion of the block that comes next."""
        if not (block.words or block.g or block.m) or self._waits(ip, block):
            return
        motion, later = self._taken(ip)
        if motion is None:
            return
        corner = self._found(ip, motion, block)
        if corner is None:
            motion.tell(ip.sink, motion.end)
        else:
            first, second, _ = PLANE_AXES[self.plane]
            ends = [list(motion.end), list(motion.end)]
            for end, point in zip(ends, (corner.start, corner.end), strict=True):
                end[first], end[second] = point.real, point.imag
            motion.tell(ip.sink, ends[0])
            if self.feed > 0.0:
                ip.sink.set_feed_rate(self.feed)
            _Motion(ends[1], corner.centre, corner.spin, self.plane).tell(ip.sink, ends[1])
            if self.feed > 0.0:
                ip.sink.set_feed_rate(self._feed_beside)
            ip.guard = _Passed(ends[1])
        if later is not None:
            later.tell()

    def leave_out(self, ip: Interpreter) -> None:
        """Pass the motion on without a corner, for what comes next is no motion."""
        motion, later = self._taken(ip)
        if motion is not None:
            self._tell_fault(
                ip,
                self._fault("corner-next", "is not followed by a feed motion (G1, G2, G3) in the next block"),
            )
            motion.tell(ip.sink, motion.end)
        if later is not None:
            later.tell()

    def _waits(self, ip: Interpreter, block: Block) -> bool:
        """Tell whether a block without a motion may stand before the next one, and keep its calls."""
        if not self.bends or block.g or block.words.keys() & _WORDS or _TOOL_CHANGE in block.m:
            return False
        self.between |= {block.line}
        if len(self.between) > _MOST_BETWEEN:
            return False
        if self.later is None and self.sink.motion is not None:
            ip.sink = self.later = _Later(ip.sink)
        return True

    def _taken(self, ip: Interpreter) -> tuple[_Motion | None, _Later | None]:
        """Return the motion that waits, and the calls behind it; both wait no longer."""
        ip.guard, motion, later = None, self.sink.motion, self.later
        if motion is None:
            # The block failed, and was left before its end.
            ip.sink = self.sink.inner
        elif later is not None:
            ip.sink = later.inner
        ip.sink.block = self.block
        return motion, later

    def _found(self, ip: Interpreter, motion: _Motion, block: Block) -> Segment | None:
        """Return the corner, or None where there is none; SINUMERIK makes it smaller, or leaves it out, where it does not fit."""
        try:
            following = self._tried(ip, block)
            try:
                return self._between(motion, following)
            except BlockError as error:
                if error.code != "corner-size" or not self.bends:
                    raise
                return self._smaller(ip, motion, following, error)
        except BlockError as error:
            self._tell_fault(ip, error)
            return None

    def _tell_fault(self, ip: Interpreter, error: BlockError) -> None:
        """Report why there is no corner: on SINUMERIK it is left out, and of RNDM this is the rule."""
        if not self.bends:
            ip.remark(error, Severity.ERROR)
        elif self.name != ",M":
            message = f"{error.message}: the corner is left out, as the control does"
            ip.warn(error.code, message, error.word, error.hint)

    def _smaller(
        self, ip: Interpreter, motion: _Motion, following: _Motion, error: BlockError
    ) -> Segment | None:
        """Return the corner of the largest size that fits (840D sl, Fundamentals, "Chamfer, rounding")."""
        wanted, low, high, found, self.slack = self.size, 0.0, self.size, None, 0.0
        # Of two lines the size is known, but for rounding; else halving finds it.
        known = self._of_lines(motion, following)
        tries = [part * known for part in (1.0, 1.0 - _NEARLY) if 0.0 < known < wanted]
        while high - low > _NEARLY * wanted:
            ip.budget.spend(CORNER)
            at_once = bool(tries)
            self.size = tries.pop(0) if tries else (low + high) / 2.0
            try:
                found, low = self._between(motion, following), self.size
            except BlockError:
                high = self.size
            else:
                if at_once:
                    break
        self.size = wanted
        if found is not None:
            message = f"{error.message}; it is made smaller, {low:.4g}, as the control does"
            ip.warn(error.code, message, error.word, "the control does not say how much smaller")
            return found
        raise error

    def _of_lines(self, motion: _Motion, following: _Motion) -> float:
        """Return the size of the corner that reaches the far end of the shorter of two lines, or 0 where one is an arc."""
        one, two = motion.segment(self.start, self.plane), following.segment(motion.end, self.plane)
        if one.centre is not None or two.centre is not None or one.start == one.end or two.start == two.end:
            return 0.0
        half = abs(cmath.phase(two.heading(two.start) / one.heading(one.end))) / 2.0
        least = min(abs(one.end - one.start), abs(two.end - two.start))
        if self.name in (",R", ",M"):
            return least / math.tan(half) if half else 0.0
        return 2.0 * least * math.cos(half) if self.name == ",H" else least

    def release(self, ip: Interpreter) -> None:
        """Let the block end: its motion waits; raise where it had none."""
        self._feed_beside = ip.state.feed
        ip.sink = self.sink.inner
        if self.sink.motion is None:
            ip.guard = None
            raise self._fault("corner-motion", "stands in a block without a feed motion (G1, G2, G3)")

    def _tried(self, ip: Interpreter, block: Block) -> _Motion:
        """Return the motion of the next block; raise where it has none in the plane."""
        words = block.only(_WORDS)
        rows = {number: ip.codes.row("G", number) for number in block.g}
        codes = tuple(number for number, row in rows.items() if row is not None and row.group in _GROUPS)
        run = partial(ip.execute, block.beside(words, codes))
        motion = tried_motion(ip, run) if words else None
        ip.sink.block = self.block
        if motion is None:
            raise self._fault(
                "corner-next", "is not followed by a feed motion (G1, G2, G3) in the next block"
            )
        return motion

    def _between(self, motion: _Motion, following: _Motion) -> Segment | None:
        """Return the chamfer or arc between two motions, or None where they go on straight; raise where a motion leaves the plane, or is too short."""
        for start, move in ((self.start, motion), (motion.end, following)):
            self._check_plane(start, move)
        one, two = motion.segment(self.start, self.plane), following.segment(motion.end, self.plane)
        if any(segment.centre is None and segment.start == segment.end for segment in (one, two)):
            raise self._fault("corner-size", "has a motion of no length beside it")
        if abs(cmath.phase(two.heading(two.start) / one.heading(one.end))) < _STRAIGHT_RAD:
            return None
        corner = self._arc(one, two) if self.name in (",R", ",M") else self._chamfer(one, two)
        for segment, point, which in (
            (one, corner.start, "the motion"),
            (two, corner.end, "the next motion"),
        ):
            if not segment.reaches(point, self.slack):
                raise self._fault("corner-size", f"does not fit: {which} is too short for it")
        return corner

    def _check_plane(self, start: Point, move: _Motion) -> None:
        """Raise where a motion moves an axis outside the corner's plane."""
        inside = PLANE_AXES[self.plane][:2]
        outside = [
            k for k, (a, b) in enumerate(zip(start, move.end, strict=True)) if k not in inside and a != b
        ]
        if outside or (move.centre is not None and move.plane != self.plane):
            what = f"moves {AXES[outside[0]].upper()}" if outside else f"is an arc in G{move.plane}"
            raise self._fault(
                "corner-plane", f"makes a corner in G{self.plane}, and a motion beside it {what}"
            )

    def _arc(self, one: Segment, two: Segment) -> Segment:
        try:
            return Segment(*fillet(one, two, self.size))
        except BlockError:
            raise self._fault("corner-size", "does not fit between the two motions") from None

    def _chamfer(self, one: Segment, two: Segment) -> Segment:
        size = self.size
        if self.name == ",H":
            # The length of the chamfer itself, of equal legs: 2 leg sin(inner angle / 2).
            size /= 2.0 * math.cos(cmath.phase(two.heading(two.start) / one.heading(one.end)) / 2.0)
        points = [
            segment.at_distance(size, from_end=from_end) for segment, from_end in ((one, True), (two, False))
        ]
        if points[0] is None or points[1] is None:
            raise self._fault("corner-size", "does not fit between the two motions")
        return Segment(points[0], points[1])

    def _fault(self, code: str, what: str) -> BlockError:
        name = self.names.get(self.name, self.name)
        message = f"{name}{self.size:g} {what}"
        return BlockError(code, message, name.rstrip("= "), hint=_HINTS[code], values={"size": self.size})


def taps(ip: Interpreter, block: Block) -> bool:
    """Tell whether a block is of a tapping cycle, of which ,R1 or ,R0 says on Mazak's and Mitsubishi's controls whether the spindle follows
    the feed (M700V programming manual, G84)."""
    codes = (ip.codes.get(("G", number)) for number in (*block.g, ip.state.motion))
    return any(code is not None and code.pitched and bool(code.summons) for code in codes)


def _corner(ip: Interpreter, block: Block, name: str) -> None:
    size = block.words[name.lower()]
    if name == ",R" and size in (0.0, 1.0) and taps(ip, block):
        return
    if size < 0.0:
        shown = _NAMES.get(ip.dialect, {}).get(name, name)
        message = f"{shown}{size:g} is negative"
        raise BlockError("corner-size", message, shown.rstrip("= "), hint="a size is positive")
    if size:
        corner = _Corner(ip, block, name, size)
        ip.sink, ip.guard = corner.sink, corner


def _end(ip: Interpreter, block: Block) -> None:
    """Let the block end whose motion waits."""
    if isinstance(ip.guard, _Corner):
        ip.guard.release(ip)


def leave_out(ip: Interpreter) -> None:
    """Pass on a motion that waits for its corner, before a change that is no block of codes."""
    if isinstance(ip.guard, _Corner):
        ip.guard.leave_out(ip)


CODES = tuple(
    Code(name, 0, "corner", Stage.REFERENCE, partial(_corner, name=name), text, dialects=dialects, named=(name.lower(), "corner_f"),
        after=_end, title=_NAMES["sinumerik"][name] if dialects == ("sinumerik",) else "")
    for name, text, dialects in (
        (",C", "chamfer to the next motion", ("fanuc", "sinumerik", "heidenhain")),
        (",R", "rounding to the next motion", ("fanuc", "sinumerik", "heidenhain")),
        (",M", "rounding to the next motion, as to all", ("sinumerik",)),
        (",H", "chamfer of that length to the next motion", ("sinumerik",)),
    )
)  # fmt: skip

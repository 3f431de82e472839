"""Profiles of turned parts: read from a subroutine, and moved aside by the allowance for a later cut.

A profile is a chain of lines and arcs in the complex plane: real along the travel of the cut, imaginary the depth,
turned so that the travel goes to the right and the tool comes from above.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise

from cncgen.gcode.block import Block
from cncgen.gcode.codes.tool_centre import CentreMove, CompensationError, OffsetCurve, ToolCentre, meeting
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Point
from cncgen.gcode.state.modal import PLAIN_MOTIONS, in_plane
from cncgen.gcode.text.labels import Cursor
from cncgen.records import dataclass, replace

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

#: Groups of the codes of a profile beside its motions: all others are ignored.
_GROUPS = ("distance", "arc distance")
_LINE = 10
MAX_MOVES = 10_000
#: Cuts and passes of a cycle beyond which a step counts as a mistake.
MAX_CUTS = 100_000
TINY = 1e-9
#: How far an arc that ends where it turns back may lead past its end, since programs round their places (program units; FANUC has parameter 5145).
ROUNDED = 1e-3
#: A profile that turns by less than this (rad) goes on smoothly; any larger turn has its corner, as LinuxCNC's turning cycles have it.
_SMOOTH = 1e-9
#: How far along the travel an arc around an outside corner leads at least (program units; measured on LinuxCNC's
#: interpreter); shorter ones are left out.
_LEAST_ROLL = 0.01


def backwards(path: Sequence[Segment]) -> list[Segment]:
    """Return a path from its end to its start."""
    return [Segment(s.end, s.start, s.centre, -s.spin) for s in reversed(path)]


@dataclass(frozen=True, slots=True)
class Segment:
    """A line, or an arc about `centre`; `spin` 1 is counter-clockwise, `turns` as canonical calls count them."""

    start: complex
    end: complex
    centre: complex | None = None
    spin: int = 0

    def heading(self, at: complex) -> complex:
        """Return the direction at a point."""
        if self.centre is None:
            return (self.end - self.start) / abs(self.end - self.start)
        return 1j * self.spin * (at - self.centre) / abs(at - self.centre)

    def dives(self) -> bool:
        """Tell whether the segment begins by going down."""
        slope = self.heading(self.start).imag
        if abs(slope) > TINY or self.centre is None:
            return slope < -TINY
        return self.centre.imag < self.start.imag

    def radius(self) -> float:
        """Return the radius of an arc: that of its start, as LinuxCNC's turning cycles have it (seen on its interpreter).

        That of its end may be another by the tolerance of arcs, and then no point of the circle is the end.
        """
        assert self.centre is not None
        return abs(self.start - self.centre)

    def sweep(self) -> float:
        """Return the angle of an arc, positive."""
        assert self.centre is not None
        angle = self.spin * cmath.phase((self.end - self.centre) / (self.start - self.centre))
        return angle if angle > 0.0 else angle + 2.0 * math.pi

    def holds(self, point: complex) -> bool:
        """Tell whether a point of the arc's circle lies on the arc."""
        assert self.centre is not None
        angle = self.spin * cmath.phase((point - self.centre) / (self.start - self.centre))
        angle = angle if angle > -TINY else angle + 2.0 * math.pi
        return angle <= self.sweep() + TINY

    def crossings(self, level: float) -> list[complex]:
        """Return where the segment meets a depth, in its order."""
        if self.centre is None:
            low, high = self.start.imag, self.end.imag
            if low == high or not min(low, high) <= level <= max(low, high):
                return []
            part = (level - low) / (high - low)
            return [complex(self.start.real + part * (self.end.real - self.start.real), level)]
        half = self.radius() ** 2 - (level - self.centre.imag) ** 2
        if half < 0.0:
            return []
        points = [complex(self.centre.real + s * math.sqrt(half), level) for s in (-1, 1)]
        inside = [p for p in points if self.holds(p)]
        return sorted(inside, key=lambda p: p.real)

    def reaches(self, point: complex, tolerance: float) -> bool:
        """Tell whether the segment, cut at a point of its line or circle, keeps its way: the point lies on it."""
        if self.centre is None:
            part = ((point - self.start) * self.heading(self.start).conjugate()).real
            return -tolerance <= part <= abs(self.end - self.start) + tolerance
        slack = tolerance / abs(self.end - self.centre)
        angle = self.spin * cmath.phase((point - self.centre) / (self.start - self.centre)) % math.tau
        return angle <= self.sweep() + slack or angle >= math.tau - slack

    def at_distance(self, distance: float, *, from_end: bool) -> complex | None:
        """Return the point at a straight distance from an end of the segment, or None where the segment does not reach so far."""
        origin, way = (self.end, -1.0) if from_end else (self.start, 1.0)
        if self.centre is None:
            return origin + way * distance * self.heading(origin)
        spoke = origin - self.centre
        half = distance / (2.0 * abs(spoke))
        return (
            self.centre + spoke * cmath.rect(1.0, way * self.spin * 2.0 * math.asin(half))
            if half <= 1.0
            else None
        )

    def extremes(self) -> list[complex]:
        """Return the ends, and the points of an arc where it turns back along either axis."""
        points = [self.start, self.end]
        if self.centre is not None:
            points += [p for k in range(4) if self.holds(p := self.centre + self.radius() * 1j**k)]
        return points

    def advances(self, slack: float = TINY) -> bool:
        """Tell whether the segment never goes back along the travel, but for `slack`."""
        places = [p.real for p in self.extremes()]
        return min(places) >= self.start.real - slack and max(places) <= self.end.real + slack

    def rises(self, slack: float = TINY) -> bool:
        """Tell whether the segment never goes down, but for `slack`."""
        depths = [p.imag for p in self.extremes()]
        return min(depths) >= self.start.imag - slack and max(depths) <= self.end.imag + slack

    def shifted(self, by: complex) -> Segment:
        """Return the segment shifted."""
        centre = None if self.centre is None else self.centre + by
        return replace(self, start=self.start + by, end=self.end + by, centre=centre)

    def halves(self) -> list[Segment]:
        """Return the segment, an arc cut where it turns from rising to falling or back."""
        if self.centre is None:
            return [self]
        centre, spoke = self.centre, self.start - self.centre
        tops = [centre + sign * 1j * self.radius() for sign in (1, -1)]
        # By angles: where the radii differ a little, a top in the end's own direction is not the end.
        places = sorted((self.spin * cmath.phase((p - centre) / spoke) % math.tau, p) for p in tops)
        cuts = [p for angle, p in places if TINY < angle < self.sweep() - TINY]
        return [replace(self, start=a, end=b) for a, b in pairwise([self.start, *cuts, self.end])]

    def seen(self, across: complex, swap: bool) -> Segment:
        """Return the segment with axes swapped and turned round (`across`: signs of travel and depth)."""
        mirror = (across.real * across.imag < 0) != swap

        def turn(p: complex) -> complex:
            p = complex(p.imag, p.real) if swap else p
            return complex(p.real * across.real, p.imag * across.imag)

        centre = None if self.centre is None else turn(self.centre)
        return Segment(turn(self.start), turn(self.end), centre, -self.spin if mirror else self.spin)


def check_cuts(high: float, low: float, step: float, name: str, word: str = "") -> None:
    """Raise where levels `step` apart from `high` down to `low` are more than `MAX_CUTS`."""
    if high - low > MAX_CUTS * step:
        message = f"{name} makes more than {MAX_CUTS} cuts, each {step:g} deep"
        raise BlockError("profile-step", message, word or name)


class Recorder:
    """A sink that keeps motions in a plane, ZX if not said, and forgets everything else."""

    wants_comments = False
    frame = None

    def __init__(self, start: Point, plane: int = 18) -> None:
        self.block = Block({})
        self.plane, self.at = plane, in_plane(start, plane)
        self.segments: list[Segment] = []

    def straight_feed(self, end: Point) -> None:
        self._keep(Segment(self.at, in_plane(end, self.plane)))

    straight_traverse = straight_feed

    def arc_feed(self, end: Point, first: float, second: float, turns: int, plane: int) -> None:
        self._keep(
            Segment(self.at, in_plane(end, self.plane), complex(first, second), 1 if turns > 0 else -1)
        )

    def _keep(self, segment: Segment) -> None:
        self.at = segment.end
        if segment.centre is not None or abs(segment.end - segment.start) > TINY or not self.segments:
            self.segments.append(segment)

    def __getattr__(self, name: str) -> Any:
        """Ignore any other call."""
        return lambda *arguments, **named: None


@contextmanager
def recording(ip: Interpreter, plane: int = 18) -> Iterator[Recorder]:
    """Let motions in a plane be made on a recorder, without compensation, in a state that is put back behind them."""
    recorder: Any = Recorder(ip.state.position, plane)
    with ip.on_trial(recorder, compensation=40):
        yield recorder


def read_profile(ip: Interpreter, block: Block, number: float) -> list[Segment]:
    """Run the profile in subroutine `number`: its moves in Z (real) and X (imaginary), fillets and chamfers made.

    The first move leads to the profile and is its first segment.

    Raises:
        BlockError: The subroutine is missing, or a line of it is wrong.
    """
    mark = ip.flow_control().subroutines.find(number, Cursor(block.source, block.offset, block.line))
    corners: list[tuple[float, bool]] = []
    with recording(ip) as recorder:
        # A profile goes on with the motion in force; where none is, its first line is a traverse.
        ip.state.motion = ip.state.motion if ip.state.motion in PLAIN_MOTIONS else 0

        def take(made: Block) -> None:
            ip.check(made)
            corners.extend(_execute(ip, recorder, made))
            if len(corners) > MAX_MOVES:
                raise BlockError("profile-length", f"it has more than {MAX_MOVES} moves")

        ip.flow_control().run_profile(take, mark.after, number, "Q")
    profile = _rounded(recorder.segments, corners) if recorder.segments else []
    if len(profile) < 2:
        raise BlockError("profile-length", f"o{number:g} has fewer than two moves: no profile", "Q")
    return profile


def _execute(ip: Interpreter, recorder: Recorder, whole: Block) -> list[tuple[float, bool]]:
    """Execute the motion of a block; return its corner: radius of the fillet or chamfer (0: none), whether a fillet."""
    words = whole.only("xzikr")
    scale = 2.0 if ip.state.diameter else 1.0
    for letter, axis, column, unit in (("u", "x", 0, scale), ("w", "z", 2, 1.0)):
        if letter in whole.words:
            words[axis] = ip.state.position[column] * unit + whole.words[letter]
    modes = [row.number for row in ip.codes.of(whole) if row.letter == "G" and row.group in _GROUPS]
    # Traverses are lines of a profile.
    codes = tuple(dict.fromkeys([number or _LINE for number in whole.g if number in PLAIN_MOTIONS] + modes))
    before = len(recorder.segments)
    if codes or words:
        if not words:
            codes = tuple(modes)
        ip.execute(Block(words, codes))
    made = len(recorder.segments) - before
    corner = (whole.words["a"], True) if "a" in whole.words else (whole.words.get("c", 0.0), False)
    return [corner] * made


def _rounded(segments: list[Segment], corners: list[tuple[float, bool]]) -> list[Segment]:
    out = [segments[0]]
    for segment, (size, rounded) in zip(segments[1:], corners, strict=False):
        last = out[-1]
        if size <= 0.0 or len(out) < 2:
            out.append(segment)
            continue
        begin, finish, centre, spin = fillet(last, segment, size)
        out[-1] = replace(last, end=begin)
        out.append(Segment(begin, finish, centre, spin) if rounded else Segment(begin, finish))
        out.append(replace(segment, start=finish))
    return out[:1] + [segment for segment in out[1:] if abs(segment.end - segment.start) > TINY]


def fillet(one: Segment, two: Segment, radius: float) -> tuple[complex, complex, complex, int]:
    """Return start, end, centre and spin of the arc of a radius that touches two segments at their corner.

    Its centre is where the segments meet when they are moved by the radius to the inside of the corner.
    """
    into, out_of = one.heading(one.end), two.heading(two.start)
    turn = (into.conjugate() * out_of).imag
    if abs(turn) < TINY:
        message = f"a fillet or chamfer of {radius:g} where the profile does not turn"
        raise BlockError("profile-corner", message, "Q")
    side = 1 if turn > 0.0 else -1
    centre = meeting(_beside(one, radius, side), _beside(two, radius, side), side)
    if centre is None:
        raise BlockError("profile-corner", f"a corner of size {radius:g} does not fit", "Q")
    return _touch(one, centre), _touch(two, centre), centre, side


def _beside(segment: Segment, radius: float, side: int) -> OffsetCurve:
    """Return the curve that a segment becomes when moved to a side."""
    into, out_of = segment.heading(segment.start), segment.heading(segment.end)
    point = segment.end + 1j * out_of * radius * side
    if segment.centre is None:
        return OffsetCurve(point, None, math.inf, 0, into, out_of)
    own = abs(segment.end - segment.centre) - radius * side * segment.spin
    return OffsetCurve(point, segment.centre, max(own, 0.0), segment.spin, into, out_of)


def _touch(segment: Segment, centre: complex) -> complex:
    """Return the point of a segment nearest to the centre of its fillet."""
    if segment.centre is None:
        along = segment.heading(segment.start)
        return segment.start + ((centre - segment.start) * along.conjugate()).real * along
    spoke = centre - segment.centre
    return segment.centre + spoke / abs(spoke) * abs(segment.end - segment.centre)


def _send(tool: ToolCentre, segment: Segment) -> list[Any]:
    if segment.centre is None:
        return tool.line(segment.end, None)
    return tool.arc(segment.end, segment.centre, segment.spin, None)


def moved_aside(profile: list[Segment], distance: float, left: bool) -> list[Segment]:
    """Return a profile moved by a distance to its left or right: rolled around outer corners, cut short at inner ones."""
    if distance <= TINY:
        return profile
    first = profile[0]
    into = first.heading(first.start)
    tool = ToolCentre(
        distance, left, first.start - into * (2.0 * distance), smooth=_SMOOTH, least_roll=_LEAST_ROLL
    )
    try:
        pieces = tool.line(first.start, None)
        for segment in profile:
            pieces += _send(tool, segment)
        pieces += tool.finish()
        for gouge in tool.take_remarks():
            if gouge.refused:
                raise gouge
    except CompensationError as error:
        message = f"the profile cannot be moved aside by {distance:g}: {error}"
        raise BlockError("profile-corner", message, "D") from None
    moves = [piece for piece in pieces if isinstance(piece, CentreMove)]
    ends = [move.end for move in moves]
    return [
        Segment(a, b, move.centre, move.turns)
        for a, b, move in zip(ends, ends[1:], moves[1:], strict=False)
        if abs(b - a) > TINY
    ]

"""The path of the tool's centre beside the programmed path: the geometry of cutter radius compensation.

The plane is the complex plane: its first axis is real, its second imaginary, seen from the positive end of the
third (XY for G17, ZX for G18, YZ for G19). A move is offset by the radius to its left or right. The joint with the previous move
depends on the turn of the path at their common point:

* away from the tool by more than `SMOOTH_TURN`: an arc of the tool's radius about the corner, so that the tool rolls
  around it (a straight line where the new move is a rapid);
* towards the tool by more than that: both offset curves end where they meet, so the earlier one is cut short;
* less: they are joined without change.

As the end of a move depends on the next one, moves wait in a queue; blocks that do not move in the plane wait
behind them. The rules are those that LinuxCNC documents ("Cutter Compensation", "G41, G42", "G41.1, G42.1"); the
geometry is derived in the functions below.
"""

from __future__ import annotations

import cmath
import math

from cncgen.records import dataclass

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

#: Turns of the path up to this angle (rad) count as smooth.
SMOOTH_TURN = 0.05
#: Move of the plane coordinates below which a block counts as not moving in the plane.
STILL = 1e-12
#: Blocks without a move in the plane that may wait for the next one.
MAX_WAITING = 100_000
#: Moves that wait at most where states are compared: where more do, they grow in number.
FEW = 8

#: Where the centre of the nose lies from the controlled point, in radii (Z, X), by lathe tool orientation (Q of the
#: tool table): the figure "Tool Orientations" of the lathe manual.
NOSE = {1: -1 + 1j, 2: 1 + 1j, 3: 1 - 1j, 4: -1 - 1j, 5: -1 + 0j, 6: 1j, 7: 1 + 0j, 8: -1j}


class CompensationError(ValueError):
    """The tool cannot follow: `code` is the diagnostic's, `values` are the numbers of the message.

    `refused` says whether LinuxCNC refuses it too.
    """

    def __init__(
        self, code: str, message: str, hint: str = "", *, refused: bool = True, **values: float
    ) -> None:
        super().__init__(message)
        self.code, self.hint, self.values, self.refused = code, hint, values, refused


@dataclass(slots=True)
class CentreMove:
    """A move of the tool's centre in the plane.

    Attributes:
        end: Where it ends.
        centre: Of its arc, or None for a straight line.
        turns: Of its arc: ±1 up to a full turn, ±2 for one more; positive is counter-clockwise.
        block: The caller's own record of the move: its feed, its line, where its other axes end.
        rapid: Whether it is a rapid.
        corner: True for what rolls around a corner before `block`: the other axes stand still.
    """

    end: complex
    centre: complex | None
    turns: int
    block: Any
    rapid: bool = False
    corner: bool = False


@dataclass(slots=True)
class OffsetCurve:
    """The offset curve that a move lies on.

    Attributes:
        point: Where the offset move ends.
        centre, radius, turns: Of an arc (None, infinite, 0 of a line).
        heading_in, heading_out: Programmed direction at the start and the end, unit vectors.
        slip: From an arc's start to the circle through its end.
        corner: Where the programmed move ends.
        start: Where the offset move starts.
        entry: Whether it is the first move.
    """

    point: complex
    centre: complex | None
    radius: float
    turns: int
    heading_in: complex
    heading_out: complex
    slip: complex = 0j
    corner: complex = 0j
    start: complex = 0j
    entry: bool = False


class ToolCentre:
    """Turns programmed moves into those of the tool's centre; one object from G41 to G40.

    `line`, `arc` and `defer` return the settled part: pieces, and deferred blocks in their place between
    them. `finish` returns the rest.

    Args:
        radius: Of the tool; a negative one compensates on the other side.
        left: Whether the tool is left of the path (G41).
        start: Where the tool stands, programmed.
        orientation: Lathe tool orientation 0 to 9 (0 and 9: the controlled point is the centre of the nose).
        unit: Name of the unit of all lengths, for messages.
        smooth: Turns of the path up to this angle (rad) count as smooth.
        growth: How much farther than programmed (rad) an arc may sweep before it counts as cut to less than nothing;
            None: as far as a smooth turn at its start can bring it.
        least_roll: Outside corners around which the tool would roll by less than this along the real axis are cut
            straight on instead, to where the offset paths cross.
        least_entry: The first move must be longer than this; None: than the radius.
        square_entry: Whether a straight first move leads beside the beginning of the second one, square to it (FANUC, start-up of type A,
            B-64484EN, "Tool Movement in Start-up"; NORM of SINUMERIK, 840D, Programming Guide Fundamentals, 8.2; RL and RR of Heidenhain,
            iTNC 530, user's manual, 5.3); else beside its own end.
    """

    def __init__(
        self,
        radius: float,
        left: bool,
        start: complex,
        orientation: int = 0,
        unit: str = "mm",
        smooth: float = SMOOTH_TURN,
        growth: float | None = None,
        least_roll: float = 0.0,
        least_entry: float | None = None,
        square_entry: bool = False,
    ) -> None:
        self.radius = abs(radius)
        self._least_entry = self.radius if least_entry is None else least_entry
        self._square_entry = square_entry
        #: Whether a move that stands still in the plane may come before the entry, as the controls with a square entry have it.
        self._waits_for_entry = square_entry
        self._stands = False
        self._renewed: tuple[float, int] | None = None
        self.unit = unit
        self._smooth = smooth
        self._growth = growth
        self._least_roll = least_roll
        self.side = 1 if left == (radius >= 0.0) else -1
        self._shift = -self.radius * NOSE.get(orientation, 0j)
        self._programmed = start
        self._actual = start
        self._curve: OffsetCurve | None = None
        self._queue: list[CentreMove | Any] = []
        self._remarks: list[CompensationError] = []

    def take_remarks(self) -> list[CompensationError]:
        """Return the faults found since the last call in moves that were made nevertheless."""
        remarks, self._remarks = self._remarks, []
        return remarks

    @property
    def position(self) -> complex:
        """Where the tool's controlled point is, as far as the moves are known."""
        return self._actual + self._shift if self._curve else self._actual

    def line(self, end: complex, block: Any, rapid: bool = False) -> list[CentreMove | Any]:
        """Take a straight move to `end` (programmed).

        Raises:
            CompensationError: ``comp-entry`` (the first move is not longer than the radius), ``comp-gouge`` (the offset
                paths do not meet).
        """
        step = end - self._programmed
        length = abs(step)
        if length < STILL and (self._curve or self._waits_for_entry):
            self._wait(CentreMove(self._actual, None, 0, block, rapid))
            return []
        self._check_entry(length)
        heading = step / length
        if self._renewed is not None:
            return self._line_renewed(end, heading, block, rapid)
        offset = 1j * heading * self.radius * self.side
        curve = OffsetCurve(end + offset, None, math.inf, 0, heading, heading)
        return self._append(curve, end, self._programmed + offset, block, rapid)

    def cut_outside(self, on: bool) -> None:
        """Take, or no longer take, the place where the offset paths cross at outside corners too (G451 of SINUMERIK)."""
        self._least_roll = math.inf if on else 0.0

    def stand(self, programmed: complex) -> None:
        """Take a programmed point that the tool stands beside already: its first move begins there, and is no entry."""
        self._programmed, self._stands, self._square_entry = programmed, True, False

    def renew(self, radius: float, left: bool) -> None:
        """Take another radius or side from the next move on, which must be straight.

        A new radius holds at the end of that move, which begins where the old one leads; on the other side, the tool crosses the
        path at the corner, square to the new move (B-64484EN, "Overview of Cutter Compensation": change of the offset direction,
        change of the cutter compensation value).
        """
        self._renewed = abs(radius), 1 if left == (radius >= 0.0) else -1

    def _line_renewed(
        self, end: complex, heading: complex, block: Any, rapid: bool
    ) -> list[CentreMove | Any]:
        assert self._renewed is not None
        (radius, side), self._renewed = self._renewed, None
        crossed = side != self.side
        corner = self._programmed
        done: list[CentreMove | Any] = []
        if crossed and self._curve is not None:
            # The move before ends square to itself; the tool then crosses to the other side.
            done += self._settle()
            self._curve, self._square_entry = None, False
        if crossed or self._curve is None:
            self.radius, self.side = radius, side
            start = corner + 1j * heading * radius * side
            done.append(self._shifted(CentreMove(start, None, 0, block, rapid, corner=True)))
            self._actual = start
        offset = 1j * heading * self.radius * self.side
        curve = OffsetCurve(end + offset, None, math.inf, 0, heading, heading)
        done += self._append(curve, end, corner + offset, block, rapid)
        if radius != self.radius:
            self.radius = radius
            curve.point = self._actual = end + 1j * heading * radius * side
            self._queue[-1].end = curve.point
        return done

    def arc(self, end: complex, centre: complex, turns: int, block: Any) -> list[CentreMove | Any]:
        """Take an arc (or, where other axes move along, a helix) to `end` about `centre`, `turns` as in `CentreMove`.

        Raises:
            CompensationError: As `line`; ``comp-radius`` (the tool does not fit in the arc).
        """
        spin = 1 if turns > 0 else -1
        spoke_in, spoke_out = self._programmed - centre, end - centre
        radius = abs(spoke_out)
        offset_radius = radius - self.radius * self.side * spin
        if self._renewed is not None:
            message = (
                "the move after another radius or side of cutter compensation is an arc; it must be straight"
            )
            raise CompensationError("comp-refused", message, "change D, or the side, before a straight move")
        if self._curve is None and not self._stands:
            return self._entry_arc(end, centre, turns, block)
        if offset_radius <= 0.0:
            message = f"the tool's radius, {self.radius:.4f} {self.unit}, does not fit in an arc of radius {radius:.4f} {self.unit}"
            hint = "use a smaller tool or a larger arc"
            raise CompensationError("comp-radius", message, hint, tool_radius=self.radius, arc_radius=radius)
        heading_in, heading_out = (1j * spin * s / abs(s) for s in (spoke_in, spoke_out))
        point, slip = centre + spoke_out * (offset_radius / radius), spoke_in * (radius / abs(spoke_in) - 1.0)
        curve = OffsetCurve(point, centre, offset_radius, turns, heading_in, heading_out, slip)
        return self._append(
            curve, end, self._programmed + 1j * heading_in * self.radius * self.side, block, False
        )

    def defer(self, block: Any) -> list[CentreMove | Any]:
        """Take a block that does not move: it waits behind the moves that wait.

        Raises:
            CompensationError: ``comp-waiting`` (more blocks wait than in any program that ends).
        """
        if not self._queue:
            return [block]
        self._wait(block)
        return []

    def _wait(self, item: CentreMove | Any) -> None:
        """Put blocks without motion in the plane behind the waiting moves."""
        if len(self._queue) >= MAX_WAITING:
            message = f"{MAX_WAITING} blocks wait for the next move in the plane of cutter compensation"
            hint = "is there a loop that does not move there? G40 ends compensation"
            raise CompensationError("comp-waiting", message, hint)
        self._queue.append(item)

    def rescale(self, factor: float, unit: str) -> None:
        """Take all lengths times `factor` from now on: the program changed its units."""
        self.unit = unit
        self.radius *= factor
        self._least_entry *= factor
        self._shift *= factor
        self._programmed *= factor
        self._actual *= factor
        for item in self._queue:
            if isinstance(item, CentreMove):
                item.end *= factor
                item.centre = None if item.centre is None else item.centre * factor
        curve = self._curve
        if curve is not None:
            curve.point = curve.point * factor
            curve.start = curve.start * factor
            curve.slip = curve.slip * factor
            curve.centre = None if curve.centre is None else curve.centre * factor
            curve.radius *= factor

    @property
    def moved(self) -> bool:
        """Whether a move was offset already."""
        return self._curve is not None

    def waiting(self) -> list[CentreMove]:
        """Return the moves that wait."""
        return [item for item in self._queue if isinstance(item, CentreMove)]

    def snapshot(self) -> tuple[Any, ...] | None:
        """Return the state that later output depends on, or None if waiting blocks cannot be compared or are many."""
        if len(self._queue) > FEW or not all(isinstance(item, CentreMove) for item in self._queue):
            return None
        place = self._programmed, self._actual, self._shift
        return self.radius, self.side, self._renewed, self.unit, place, self._curve, list(self._queue)

    def last_waiting(self) -> CentreMove | None:
        """Return the last of the moves that wait."""
        return next((item for item in reversed(self._queue) if isinstance(item, CentreMove)), None)

    @property
    def begins(self) -> bool:
        """Tell whether no move has been taken yet: the next one is the entry."""
        return self._curve is None

    def finish(self) -> list[CentreMove | Any]:
        """Return the waiting moves (G40, or the end of the program)."""
        return self._settle()

    def leave_towards(self, way: complex) -> list[CentreMove | Any]:
        """Return the waiting moves; the last one ends where its offset path crosses that of a line in a direction from its end.

        FANUC's controls take where they cross at inside and outside corners alike, and where they do not, the place square to the
        move (B-63014EN, "Cutter Compensation Cancel in the Offset Mode": G40 with I J K; Okuma's OSP-P200L, 5238-E, p. 84, and
        Mitsubishi's M700V, 12.4, have the same).
        """
        last = self._curve
        if last is not None and self.radius and self._renewed is None:
            heading = way / abs(way)
            beside = self._programmed + 1j * heading * self.radius * self.side
            towards = OffsetCurve(beside, None, math.inf, 0, heading, heading)
            turn = cmath.phase(heading / last.heading_out)
            crossing = meeting(last, towards, 1 if turn > 0.0 else -1) if abs(turn) > self._smooth else None
            if crossing is not None:
                self._meet(last, towards, crossing)
        return self.finish()

    def _check_entry(self, length: float) -> None:
        """Demand that the first move leads farther than the tool's radius, where the control does."""
        if self._curve is None and length <= self._least_entry:
            message = f"the entry move leads {length:.4f} {self.unit} away and must lead farther than the tool's radius, {self.radius:.4f} {self.unit}"
            hint = "start farther away"
            raise CompensationError("comp-entry", message, hint, length=length, radius=self.radius)

    def _entry_arc(self, end: complex, centre: complex, turns: int, block: Any) -> list[CentreMove | Any]:
        """Enter on an arc: from where the tool stands, tangent at its end to the offset of the programmed arc.

        The new centre lies on the line from the offset end e through the programmed centre, at the distance k from e
        (unit vector d) that it also has from the start s: |s − e − k d| = k gives k = |s − e|² / (2 (s − e)·d).
        """
        spin = 1 if turns > 0 else -1
        self._check_entry(abs(end - self._programmed))
        inwards = (centre - end) / abs(centre - end)
        tip = end + inwards * (self.radius * self.side * spin)
        back = self._actual - tip
        along = (back * inwards.conjugate()).real
        reach = abs(back) ** 2 / (2.0 * along) if along else math.inf
        if not 0.0 < reach < math.inf:
            message = "the entry arc begins on the wrong side of its end: the tool turns back on itself there"
            hint = "enter on an arc of less than half a turn, or on a straight line"
            self._remarks.append(CompensationError("comp-entry", message, hint, refused=False))
        heading = -1j * spin * inwards
        curve = OffsetCurve(tip, tip + inwards * reach, abs(reach), turns, heading, heading)
        return self._append(curve, end, self._actual, block, False)

    def _append(
        self, curve: OffsetCurve, end: complex, start: complex, block: Any, rapid: bool
    ) -> list[CentreMove | Any]:
        """Join a move to the one before, settle that one, and queue the new one."""
        old, self._programmed = self._curve, end
        done: list[CentreMove | Any] = []
        if old is None:
            curve.start, curve.entry = self._actual, not self._stands
            done += self._settle()
        else:
            done += self._join(old, curve, start, block, rapid)
        curve.corner = end
        self._curve = curve
        self._actual = curve.point
        self._queue.append(CentreMove(curve.point, curve.centre, curve.turns, block, rapid))
        return done

    def _join(
        self, old: OffsetCurve, new: OffsetCurve, start: complex, block: Any, rapid: bool
    ) -> list[CentreMove | Any]:
        """Settle the previous move, and return it with the arc around the corner (without a radius there is none)."""
        if self.radius == 0.0:
            new.start = start
            return self._settle(strict=False)
        if self._square_entry:
            self._square_entry = False
            if old.centre is None:
                self._meet(old, new, start)
                return self._settle()
        turn = self.side * cmath.phase(new.heading_in / old.heading_out)
        rolls = self._rolls(old, new, turn)
        blunt = rolls and abs((start - old.point).real) < self._least_roll
        if rolls and not blunt:
            done = self._settle(strict=new.centre is None)
            centre, turns = (None, 0) if rapid else (old.corner, -self.side)
            new.start = start
            return [*done, self._shifted(CentreMove(start, centre, turns, block, rapid, corner=True))]
        shared = (
            old.point if abs(turn) <= self._smooth else meeting(old, new, -self.side if blunt else self.side)
        )
        if shared is None:
            raise self._gouge("the offset paths do not meet in this inside corner")
        self._meet(old, new, shared)
        return self._settle(strict=abs(turn) > self._smooth)

    def _meet(self, old: OffsetCurve, new: OffsetCurve, point: complex) -> None:
        """Let the move that waits end, and the new one begin, at a point."""
        old.point = new.start = point
        for piece in self._queue:
            if isinstance(piece, CentreMove):
                piece.end = point

    def _rolls(self, old: OffsetCurve, new: OffsetCurve, turn: float) -> bool:
        """Tell whether a corner is an outside one.

        A path that turns back on itself (within `SMOOTH_TURN`) is rolled around, but where the tool is outside of an
        arc it takes the place where the offset paths cross, as LinuxCNC does.
        """
        if abs(turn) > math.pi - SMOOTH_TURN:
            arc = new if new.centre is not None else old
            return arc.centre is None or (arc.turns > 0) == (self.side > 0)
        return turn < -self._smooth

    def _check(self, curve: OffsetCurve | None, strict: bool) -> CompensationError | None:
        """Return the fault of a move that goes backward after it was shortened at its ends; the entry move may do so.

        Of an arc that does, the sweep is more than programmed: nearly a full turn. Where it starts a little off the
        tangent of the move before, it is more as well, by a little.
        """
        if curve is None or curve.entry:
            return None
        if curve.centre is None:
            if ((curve.point - curve.start) * curve.heading_out.conjugate()).real < 0.0:
                return self._gouge("a straight move at an inside corner is too short for the tool")
            return None
        spin = 1 if curve.turns > 0 else -1
        sweep = _sweep(curve.start - curve.centre, curve.point - curve.centre, spin)
        programmed = _sweep(curve.heading_in, curve.heading_out, spin)
        growth = SMOOTH_TURN * max(1.0, self.radius / curve.radius)
        if strict and self._growth is not None:
            growth = self._growth
        if sweep <= programmed + growth:
            return None
        if sweep - programmed > math.pi:
            return self._gouge("an arc at an inside corner is too short for the tool")
        return CompensationError(
            "comp-gouge",
            f"the tool would sweep {math.degrees(sweep - programmed):.3f}° more than the {math.degrees(programmed):.3f}°"
            f" of this arc: more than {math.degrees(growth):.3f}° count as a gouge",
            "let the arc begin tangent to the move before it: more decimals in its end and centre",
            sweep_deg=math.degrees(sweep),
            programmed_deg=math.degrees(programmed),
        )

    def _gouge(self, what: str) -> CompensationError:
        message = f"{what}: a tool of radius {self.radius:.4f} {self.unit} would gouge"
        hint = "use a smaller tool, or widen the corner"
        return CompensationError("comp-gouge", message, hint, tool_radius=self.radius)

    def _settle(self, strict: bool = True) -> list[CentreMove | Any]:
        """Check the waiting move and return it with the blocks behind it; `strict` where LinuxCNC looks for gouges."""
        gouge = self._check(self._curve, strict)
        if gouge is not None:
            gouge.refused = strict
            self._remarks.append(gouge)
        done = [self._shifted(item) if isinstance(item, CentreMove) else item for item in self._queue]
        self._queue = []
        return done

    def _shifted(self, piece: CentreMove) -> CentreMove:
        piece.end += self._shift
        if piece.centre is not None:
            piece.centre += self._shift
        return piece


def _sweep(start: complex, end: complex, spin: int) -> float:
    """Return the angle in (0, 2π] from one direction to another, turning `spin` (1: counter-clockwise)."""
    angle = spin * cmath.phase(end / start)
    return angle if angle > 0.0 else angle + 2.0 * math.pi


def meeting(old: OffsetCurve, new: OffsetCurve, side: int) -> complex | None:
    """Return where two offset curves cross so that the path turns towards the tool (`side`: 1 left), or None."""
    if old.centre is None and new.centre is None:
        points = _line_line(old, new)
    elif old.centre is None and new.centre is not None:
        # An arc given by its centre may start a little off the circle through its end; that circle counts.
        points = _line_circle(old, new.centre, new.radius, new.slip)
    elif new.centre is None and old.centre is not None:
        points = _line_circle(new, old.centre, old.radius)
    elif old.centre is not None and new.centre is not None:
        points = _circle_circle(old.centre, old.radius, new.centre, new.radius)
    turns = [side * (_heading(old, p).conjugate() * _heading(new, p)).imag for p in points]
    return points[turns.index(max(turns))] if points else None


def _heading(curve: OffsetCurve, point: complex) -> complex:
    if curve.centre is None:
        return curve.heading_in
    return (1j if curve.turns > 0 else -1j) * (point - curve.centre)


def _line_line(a: OffsetCurve, b: OffsetCurve) -> list[complex]:
    across = (a.heading_in.conjugate() * b.heading_in).imag
    if across == 0.0:
        return []  # the second line goes back over the first one
    along = ((b.point - a.point).conjugate() * b.heading_in).imag / across
    return [a.point + along * a.heading_in]


def _line_circle(line: OffsetCurve, centre: complex, radius: float, slip: complex = 0j) -> list[complex]:
    point = line.point + slip
    foot = point + ((centre - point) * line.heading_in.conjugate()).real * line.heading_in
    half = radius * radius - abs(foot - centre) ** 2
    if half < 0.0:
        return []
    return [foot + s * math.sqrt(half) * line.heading_in for s in (-1, 1)]


def _circle_circle(a: complex, radius_a: float, b: complex, radius_b: float) -> list[complex]:
    distance = abs(b - a)
    if distance == 0.0:
        return []
    along = (distance * distance + radius_a * radius_a - radius_b * radius_b) / (2.0 * distance)
    half = radius_a * radius_a - along * along
    if half < 0.0:
        return []
    axis = (b - a) / distance
    return [a + axis * complex(along, s * math.sqrt(half)) for s in (-1, 1)]

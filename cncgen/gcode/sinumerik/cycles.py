"""Drilling cycles of SINUMERIK, CYCLE81 to CYCLE89 and CYCLE840, and patterns HOLES1 and HOLES2.

Parameters stand in the order of the manual (840D sl, "Programming cycles externally"): RTP retraction plane, RFP reference plane, SDIS
safety clearance (added to RFP, without sign), DP depth or DPR depth from RFP (without sign), then those of each cycle. Empty ones are 0.
Motions are along the axis beside the plane, where the tool stands.
"""

from __future__ import annotations

import cmath
import math
import operator
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, SupportsIndex

from cncgen.gcode.block import AXES
from cncgen.gcode.codes.places import in_rows, on_circle
from cncgen.gcode.codes.steps import MOST, steps_of
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.sinumerik.expressions import Scalar

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions

Values = list[Scalar | None]
#: The distance that CYCLE83 keeps from the last depth, mm: that part of the way down to it, within bounds; how far it goes back to
#: break chips, mm.
_AHEAD, _LEAST_AHEAD, _MOST_AHEAD, _BREAK = 1.0 / 50.0, 0.6, 7.0, 1.0
#: GMODE of drilling, whose depth is that of the shank.
_SHANK = 10


class CycleParameters(list[Scalar | None]):
    """The parameters of a cycle, which keep how many of them have been looked at."""

    looked = 0

    def __getitem__(self, place: SupportsIndex | slice) -> Any:
        """Return one or some."""
        last = place.indices(len(self))[1] if isinstance(place, slice) else int(place) + 1
        self.looked = max(self.looked, last)
        return super().__getitem__(place)

    def __iter__(self) -> Iterator[Scalar | None]:
        self.looked = len(self)
        return super().__iter__()

    def tell_beyond(self, motions: Motions, name: str) -> None:
        """Warn of parameters behind the last one that the cycle has looked at."""
        looked = self.looked
        beyond = [k + 1 for k, value in enumerate(self) if k >= looked and value not in (None, 0.0, "")]
        if beyond:
            one = f" {beyond[0]} of {name} is"
            several = f"s {beyond[0]} to {beyond[-1]} of {name} are" if len(beyond) > 1 else one
            message = f"parameter{several} not read; the cycle is made as without"
            hint = f"docs/sinumerik.md says what is read; {name} has it in the first {beyond[0] - 1}"
            motions.ip.warn_once("cycle-parameters", message, name, hint)


def given(values: Values, index: int) -> float | None:
    """Return a parameter, None where it is left out."""
    value = values[index] if index < len(values) else None
    if isinstance(value, str):
        message = f"parameter {index + 1} of the cycle is a text, and a number is needed"
        raise BlockError("cycle-words", message, hint="see docs/sinumerik.md")
    return value


def filled(values: Values, index: int, usual: float = 0.0) -> float:
    """Return a parameter, or its default where it is left out."""
    value = given(values, index)
    return usual if value is None else value


def check_plane(motions: Motions, name: str) -> None:
    """Refuse a cycle that works in G17 in another plane."""
    plane = motions.ip.state.plane
    refuse(name, (plane != 17, "cycle-plane", f"{name} works in plane G17, not in G{plane}", "use G17"))


def doubt_order(motions: Motions, name: str, hint: str) -> None:
    """Warn of a cycle whose list of parameters is that of programs."""
    message = f"the order of the parameters of {name} has not been compared with a printed manual"
    motions.ip.warn_once("cycle-parameters", message, name, hint)


def milling_feed(motions: Motions, name: str, value: float) -> float:
    """Return the feed of a milling cycle: its own, or F of the program where it gives none."""
    feed, message = value or motions.ip.state.feed, f"{name} has no feed: FFP1 and F are not given"
    refuse(name, (feed <= 0.0, "feed-missing", message, "FFP1 mills, FFD plunges"))
    return feed


@dataclass(slots=True)
class Hole:
    """Levels along the axis beside the plane: retraction, start and depth."""

    motions: Motions
    back: float
    start: float
    depth: float
    reference: float

    @classmethod
    def of(cls, motions: Motions, name: str, values: Values) -> Hole:
        """Return the levels of RTP, RFP, SDIS, DP, DPR.

        Raises:
            BlockError: The depth is missing or above the reference plane, or the retraction below the start.
        """
        if motions.plane_assumed:
            message = f"{name} goes along Y in G18, in which most lathes begin, and the program says no plane"
            motions.ip.warn_once("plane-doubtful", message, name, "G17 before it drills along Z, G19 along X")
        back, reference, clearance = (filled(values, k) for k in range(3))
        absolute, relative = given(values, 3), given(values, 4)
        missing = absolute is None and relative is None
        depth = _depth(motions, name, reference, absolute, relative)
        start = reference + abs(clearance)
        refuse(
            name,
            (missing, "cycle-depth", f"{name} has no depth: neither DP nor DPR",
             "the fourth parameter is the depth, the fifth its distance from RFP"),
            (depth >= reference, "cycle-depth", f"the depth of {name}, {depth:g}, is not below its reference plane, {reference:g}",
             "DP is a coordinate below RFP"),
            (back < start, "cycle-depth", f"the retraction plane of {name}, {back:g}, is below where it begins, {start:g} (RFP + SDIS)",
             "RTP is RFP + SDIS or above"),
        )  # fmt: skip
        return cls(motions, back, start, depth, reference)

    def go(self, level: float, *, rapid: bool) -> None:
        """Go along the axis."""
        axis = AXES[self.motions.plane()[2]]
        self.motions.move({axis: level}, rapid=rapid)

    def drill(self, wait: float = 0.0, feed: float | None = None) -> None:
        """Traverse to the start, go down at a feed, that in force where it is None, and wait."""
        self.go(self.start, rapid=True)
        self.feed(feed)
        self.go(self.depth, rapid=False)
        self.motions.dwell(wait)

    def mm(self, length: float) -> float:
        """Return a length in the unit of the program."""
        return length / self.motions.ip.state.unit_mm

    def ahead_of(self, depth: float) -> float:
        """Return how far above a depth traverse ends, as the control works it out (840D, Programming Guide, Cycles, CYCLE83, DIS1)."""
        return max(self.mm(_LEAST_AHEAD), min((self.start - depth) * _AHEAD, self.mm(_MOST_AHEAD)))

    def feed(self, feed: float | None) -> None:
        if feed:
            self.motions.emit({"f": feed})


def _depth(
    motions: Motions, name: str, reference: float, absolute: float | None, relative: float | None
) -> float:
    """Return a depth that is given as a coordinate or as a distance: of both the distance counts, and the control shows a message (ibid.)."""
    if absolute is not None and not relative:
        return absolute
    depth = reference - abs(relative or 0.0)
    if absolute is not None and not math.isclose(depth, absolute, abs_tol=1e-9):
        message = f"{name} has the depth {absolute:g} and the distance {relative:g}, which leads to {depth:g}: the distance counts, as on the control"
        motions.ip.warn_once("cycle-depths", message, name, "leave one of them out")
    return depth


def _hole(motions: Motions, name: str, values: Values, modes: int) -> tuple[Hole, float]:
    """Return a hole, and its dwell DTB: the ones of AMODE, two behind GMODE at `modes`, choose DP or DPR (of CYCLE81 DP, a depth or a
    diameter), the tens the unit of DTB."""
    end, each = _modes(motions, name, values, modes, (2, 2))
    hole = Hole.of(motions, name, [*values[:3], *of_two(name, values, 3, end)])
    return hole, _waits(filled(values, 5), each)


def _drill(motions: Motions, name: str, values: Values) -> None:
    """CYCLE81, CYCLE82: DTB GMODE DMODE AMODE."""
    hole, wait = _hole(motions, name, values, 6)
    hole.drill(wait)
    hole.go(hole.back, rapid=True)


def depth_of(name: str, values: Values) -> float:
    """Return the depth DP of a cycle, its fourth parameter; raise where it is left out."""
    depth = given(values, 3)
    missing = depth is None
    refuse(name, (missing, "cycle-depth", f"{name} has no depth DP", "the fourth parameter is the depth"))
    return depth or 0.0


def _depths(hole: Hole, first: float, degression: float, least: float, name: str) -> list[float]:
    """Return the depths of CYCLE83: the first step, and each next one less by DAM, but at least MDEP (DAM without it); below 0 DAM is
    the factor of each step to the one before.

    The last two are alike where less than half of DAM would be left."""
    depths, step = [max(first, hole.depth)], hole.reference - first
    message = f"the first depth of {name}, {first:g}, is not below its reference plane"
    refuse(name, (step <= 0.0, "cycle-infeed", message, "FDEP is a coordinate, FDPR a distance from RFP"))
    many, hint = f"{name} makes more than {MOST} steps", "is FDPR too small?"
    while depths[-1] > hole.depth:
        refuse(name, (len(depths) >= MOST, "cycle-infeed", many, hint))
        smaller = step * -degression if degression < 0.0 else step - degression
        floor = least if degression < 0.0 else least or degression or step
        step = max(smaller, floor) if step > floor else step
        left = depths[-1] - hole.depth
        if left <= step:
            depths.append(hole.depth)
        elif left - step < degression / 2.0:
            depths += [depths[-1] - left / 2.0, hole.depth]
        else:
            depths.append(depths[-1] - step)
    return depths


def check_mode_plane(motions: Motions, name: str, plane: int) -> None:
    """Refuse DMODE whose ones choose another plane than that in force: 1 to 3, 0 for none."""
    if plane % 10 not in (0, motions.ip.state.plane - 16):
        message = f"DMODE = {plane} of {name} chooses another plane than G{motions.ip.state.plane}, which is in force"
        hint = "its ones are 1 for G17, 2 for G18, 3 for G19, 0 for the plane in force"
        raise BlockError("cycle-plane", message, name, hint=hint)


def _modes(motions: Motions, name: str, values: Values, index: int, most: Sequence[int]) -> list[int]:
    """Return the digits of AMODE, ones first and none above its `most`: they choose what other parameters mean. It is the last one of a cycle.

    GMODE, at `index`, and DMODE, whose ones are the plane (1 to 3; 0 the one in force), stand before it.
    """
    shape, plane, mode = (round(filled(values, index + k)) for k in range(3))
    check_mode_plane(motions, name, plane)
    digits = [mode // 10**place % 10 for place in range(len(most))]
    beyond = next((k for k in range(index + 3, len(values)) if filled(values, k)), None)
    hint = "0 is the usual value of each"
    if shape == _SHANK:
        message = f"GMODE = {shape} of {name}: the depth is that of the full diameter on the control, here of the tip"
        motions.ip.warn_once("tool-assumed", message, name, "the angle of the tip is not in the tool table")
    elif shape:
        message, hint = f"GMODE = {shape} of {name} is not read", "GMODE = 0 is the depth of the tip"
        raise BlockError("not-read", message, name, hint=hint)
    if not 0 <= mode < 10 ** len(most) or any(map(operator.gt, digits, most)):
        message = f"AMODE = {mode} of {name} is not read"
    elif beyond is not None:
        message = f"parameter {beyond + 1} of {name} is not read"
    else:
        return digits
    raise BlockError("not-read", message, name, hint=hint)


def _check_axis(name: str, values: Values) -> None:
    """Refuse AXN, the thirteenth parameter, where it chooses another axis than the one beside the plane."""
    axis = filled(values, 12)
    message = f"AXN = {axis:g} of {name} (a hole along an axis of the plane) is not read"
    hint = "AXN = 3, or none, is the axis beside the plane"
    refuse(name, (axis not in (0.0, 3.0), "not-read", message, hint))


def of_two(name: str, values: Values, index: int, digit: int) -> tuple[float | None, float | None]:
    """Return a depth as a coordinate and as a distance, of which a digit of AMODE chooses: 0 the one that is given, 1 the distance, 2 the coordinate."""
    absolute, relative = given(values, index), given(values, index + 1)
    missing = digit > 0 and (relative, absolute)[digit - 1] is None
    message = f"AMODE of {name} chooses a depth that is not given"
    refuse(name, (missing, "cycle-depth", message, "the digit 1 chooses the distance, 2 the coordinate"))
    return (None, relative) if digit == 1 else (absolute, None if digit else relative)


def _waits(time: float, digit: int) -> float:
    """Return a time of dwell whose unit a digit of AMODE tells: 0 its sign, 1 seconds, 2 revolutions (negative here)."""
    return (time, abs(time), -abs(time))[digit]


def _deep(motions: Motions, name: str, values: Values) -> None:
    """CYCLE83: FDEP FDPR DAM DTB DTS FRF VARI (0 breaks chips, 1 clears them) AXN MDEP VRT DTD DIS1 GMODE DMODE AMODE.

    Digits of AMODE, ones first: DP or DPR, units of DTB, DTS and DTD, FDEP or FDPR, DAM as amount (1) or percent (2), the distance ahead as
    usual (1) or DIS1 (2), FRF in percent (1).
    """
    end, each, out, last, begin, less, near, percent = _modes(
        motions, name, values, 17, (2, 2, 2, 2, 2, 2, 2, 1)
    )
    _check_axis(name, values)
    hole = Hole.of(motions, name, [*values[:3], *of_two(name, values, 3, end)])
    absolute, relative = of_two(name, values, 5, begin)
    missing = absolute is None and relative is None
    hint = "the sixth parameter is the first depth, the seventh its distance from RFP"
    refuse(name, (missing, "cycle-infeed", f"{name} has no first depth: neither FDEP nor FDPR", hint))
    first = _depth(motions, name, hole.reference, absolute, relative)
    degression = filled(values, 7)
    degression = (degression, abs(degression), -abs(degression) / 100.0)[less]
    depths = _depths(hole, first, degression, abs(filled(values, 13)), name)
    if degression > hole.reference - first and len(depths) > 2:
        message = f"the first step of {name}, {hole.reference - first:g}, is less than DAM, {degression:g}: all steps are like the first"
        motions.ip.warn_once(
            "cycle-parameters",
            message,
            name,
            "the control may go on in steps of DAM; write DAM = 0 for steps that are alike",
        )
    back, ahead = abs(filled(values, 14)) or hole.mm(_BREAK), abs(filled(values, 16))
    usual = near == 1 or (near == 0 and not ahead)
    feed, factor = motions.ip.state.feed, (filled(values, 10) / (100.0 if percent else 1.0)) or 1.0
    hole.go(hole.start, rapid=True)
    for k, depth in enumerate(depths):
        hole.feed(feed * factor if k == 0 and factor != 1.0 else None)
        hole.go(depth, rapid=False)
        if k == 0 and factor != 1.0:
            hole.feed(feed)
        at_end = _waits(filled(values, 15), last) if depth == depths[-1] else 0.0
        hole.motions.dwell(at_end or _waits(filled(values, 8), each))
        if depth == depths[-1]:
            break
        if filled(values, 11):
            hole.go(hole.start, rapid=True)
            hole.motions.dwell(_waits(filled(values, 9), out))
            hole.go(depth + (hole.ahead_of(depth) if usual else ahead), rapid=True)
        else:
            hole.go(depth + back, rapid=False)
    hole.go(hole.back, rapid=True)


def pitch_of(name: str, size: float | None, pitch: float | None) -> float:
    """Return the lead of MPIT (3 for M3 to 48 for M48) or PIT."""
    if pitch:
        return abs(pitch)
    coarse = {1: .25, 2: .4, 3: .5, 4: .7, 5: .8, 6: 1.0, 8: 1.25, 10: 1.5, 12: 1.75, 14: 2.0, 16: 2.0, 18: 2.5, 20: 2.5, 22: 2.5, 24: 3.0,
              27: 3.0, 30: 3.5, 33: 3.5, 36: 4.0, 39: 4.0, 42: 4.5, 45: 4.5, 48: 5.0}  # fmt: skip
    found = coarse.get(round(abs(size or 0.0)), 0.0)
    hint = "PIT is the lead, MPIT the size of a metric thread"
    refuse(name, (not found, "pitch-missing", f"{name} has no lead: neither MPIT nor PIT", hint))
    return found


def _tap(motions: Motions, name: str, values: Values) -> None:
    """CYCLE84, rigid: DTB SDAC MPIT PIT POSS SST SST1 AXN PITA TECHNO VARI (1 breaks chips, 2 clears them) DAM VRT PITM PTAB PTABA GMODE
    DMODE AMODE.

    Digits of AMODE, ones first: DP or DPR, units of DTB, none, a thread to the right (1) or left (2), and three that move nothing.
    """
    end, each, _, hand, *_ = _modes(motions, name, values, 21, (2, 2, 0, 2, 0, 0, 1))
    _check_axis(name, values)
    hole = Hole.of(motions, name, [*values[:3], *of_two(name, values, 3, end)])
    wait = _waits(filled(values, 5), each)
    unit = filled(values, 13)
    message = f"PITA = {unit:g} of {name} (a lead in inches or threads an inch) is not read"
    refuse(name, (unit not in (0.0, 1.0), "not-read", message, "PITA = 1 is a lead in mm"))
    left = hand == 2 or (hand == 0 and (given(values, 7) or given(values, 8) or 0.0) < 0.0)
    lead, speed = pitch_of(name, given(values, 7), given(values, 8)), filled(values, 10)
    steps, infeed = [hole.depth], abs(filled(values, 16))
    how = round(filled(values, 15)) % 10
    if how and infeed:
        count = steps_of(
            hole.reference - hole.depth, infeed, name, f"DAM = {infeed:g} of {name} makes {{}} steps"
        )
        steps = [*(hole.reference - infeed * k for k in range(1, count)), hole.depth]
    back = (abs(filled(values, 17)) or hole.mm(_BREAK)) if how == 1 else None
    speeds = (speed, filled(values, 11) or speed)
    _tapped(hole, name, [*values[:5], wait, *values[6:]], lead, speeds, left, 6, steps, back)


def _tap_floating(motions: Motions, name: str, values: Values) -> None:
    """CYCLE840, with a compensating chuck: DTB SDR SDAC ENC MPIT PIT; with ENC = 1 the feed in force is speed times lead."""
    hole = Hole.of(motions, name, values)
    state = motions.ip.state
    speed = state.speed
    if filled(values, 8) == 1.0 and state.feed and state.feed_mode in (94, 95):
        lead = state.feed / (speed if state.feed_mode == 94 and speed > 0.0 else 1.0)
    else:
        lead = pitch_of(name, given(values, 9), given(values, 10))
    _tapped(hole, name, values, lead, (speed, speed), motions.ip.state.direction < 0, 7)


def _tapped(
    hole: Hole,
    name: str,
    values: Values,
    lead: float,
    speeds: tuple[float, float],
    left: bool,
    after: int,
    steps: list[float] | None = None,
    back: float | None = None,
) -> None:
    """Tap in and out at lead times speed, the spindle turning back on the way out; between steps back by `back`, or out of the hole."""
    motions = hole.motions
    stopped = min(speeds) <= 0.0
    refuse(name, (stopped, "spindle-stopped", f"{name} has no speed", "SST of CYCLE84, or S before CYCLE840"))
    feed, feed_mode = motions.ip.state.feed, motions.ip.state.feed_mode
    hole.go(hole.start, rapid=True)
    if feed_mode != 94:
        motions.emit({}, (940,))
    for level in steps or [hole.depth]:
        last = level == hole.depth
        for k, place in enumerate((level, hole.start if last or back is None else level + back)):
            motions.emit({"s": speeds[k], "f": lead * speeds[k]}, (), (30 if (k == 0) != left else 40,))
            hole.go(place, rapid=False)
            if k == 0 and last:
                hole.motions.dwell(filled(values, 5))
    if feed_mode != 94:
        motions.emit({}, (feed_mode * 10,))
    if feed:
        motions.emit({"f": feed})
    direction = filled(values, after)
    motions.emit({}, (), ({3.0: 30, 4.0: 40}.get(direction, 50),))
    hole.go(hole.back, rapid=True)


def _ream(motions: Motions, name: str, values: Values) -> None:
    """CYCLE85: DTB, FFR in, RFF out, GMODE DMODE AMODE."""
    hole, wait = _hole(motions, name, values, 8)
    feed = motions.ip.state.feed
    hole.drill(wait, given(values, 6))
    hole.feed(given(values, 7))
    hole.go(hole.start, rapid=False)
    hole.feed(feed)
    hole.go(hole.back, rapid=True)


def _turn(name: str, direction: float) -> int:
    """Return the M function of SDIR, which turns the spindle."""
    message = f"SDIR = {direction:g} of {name} is neither 3 nor 4"
    refuse(name, (direction not in (3.0, 4.0), "cycle-spindle", message, "3 turns as M3, 4 as M4"))
    return round(10.0 * direction)


def _bore(motions: Motions, name: str, values: Values) -> None:
    """CYCLE86: DTB, SDIR, the way off the wall RPA RPO RPAP, POSS (where the spindle stands, which moves no axis), and modes as of CYCLE85."""
    filled(values, 10)
    hole, wait = _hole(motions, name, values, 11)
    first, second, normal = motions.plane()
    motions.emit({}, (), (_turn(name, filled(values, 6)),))
    hole.drill(wait)
    motions.emit({}, (), (50,))
    place = motions.ip.state.position
    steps = {AXES[k]: place[k] + filled(values, 7 + j) for j, k in enumerate((first, second, normal))}
    if any(filled(values, k) for k in (7, 8, 9)):
        motions.move(steps, rapid=True)
    hole.go(hole.back, rapid=True)
    if filled(values, 7) or filled(values, 8):
        motions.move({AXES[k]: place[k] for k in (first, second)}, rapid=True)


def _bore_stop(motions: Motions, name: str, values: Values) -> None:
    """CYCLE87 (SDIR) and CYCLE88 (DTB SDIR): in, stop spindle and program at the bottom, traverse out."""
    hole, waits = Hole.of(motions, name, values), name == "CYCLE88"
    turn = _turn(name, filled(values, 6 if waits else 5))
    motions.emit({}, (), (turn,))
    hole.drill(filled(values, 5) if waits else 0.0)
    motions.emit({}, (), (50,))
    motions.emit({}, (), (0,))
    hole.go(hole.back, rapid=True)
    motions.emit({}, (), (turn,))


def _bore_feed(motions: Motions, name: str, values: Values) -> None:
    """CYCLE89: in, wait DTB, out at the same feed."""
    hole = Hole.of(motions, name, values)
    hole.drill(filled(values, 5))
    hole.go(hole.start, rapid=False)
    hole.go(hole.back, rapid=True)


def _modal(motions: Motions, name: str) -> None:
    missing, hint = motions.modal is None, "MCALL CYCLE81(...) stands before"
    refuse(name, (missing, "cycle-missing", f"{name} has no cycle that it calls", hint))


def _visit(motions: Motions, places: list[complex]) -> None:
    """Run the modal cycle at places of the plane."""
    assert motions.modal is not None
    first, second, _ = motions.plane()
    for place in places:
        motions.move({AXES[first]: place.real, AXES[second]: place.imag}, rapid=True)
        motions.run_call(motions.modal[0], motions.modal[1], 1)


def _count(name: str, values: Values, index: int) -> int:
    return count_of(name, filled(values, index), "holes")


def count_of(name: str, number: float, what: str) -> int:
    """Return how many holes or slots NUM counts."""
    count = round(number)
    message = f"NUM = {count} of {name} is not within 1 to {MOST}"
    refuse(name, (not 1 <= count <= MOST, "cycle-repeats", message, f"NUM counts the {what}"))
    return count


def _row(motions: Motions, name: str, values: Values) -> None:
    """HOLES1(SPCA, SPCO, STA1, FDIS, DBH, NUM): holes in a line; the end that is nearer comes first."""
    _modal(motions, name)
    way = cmath.rect(1.0, math.radians(filled(values, 2)))
    origin = complex(filled(values, 0), filled(values, 1))
    begin, step = filled(values, 3), filled(values, 4)
    places = [origin + way * (begin + k * step) for k in range(_count(name, values, 5))]
    here = motions.here_in_plane()
    if abs(places[-1] - here) < abs(places[0] - here):
        places.reverse()
    _visit(motions, places)


def _circle(motions: Motions, name: str, values: Values) -> None:
    """HOLES2(CPA, CPO, RAD, STA1, INDA, NUM): holes on a circle; INDA 0 shares it evenly."""
    _modal(motions, name)
    count = _count(name, values, 5)
    step = filled(values, 4) or 360.0 / count
    centre, radius = complex(filled(values, 0), filled(values, 1)), filled(values, 2)
    _visit(motions, on_circle(centre, radius, filled(values, 3), step, count))


def _grid(motions: Motions, name: str, values: Values) -> None:
    """CYCLE801(SPCA, SPCO, STA, DIS1, DIS2, NUM1, NUM2, VARI): holes in a grid, or (VARI 1) on its frame.

    Rows along the smaller distance are visited to and fro, from the corner that is nearest to the tool, as the cycle of
    the 840D has it (software 6.2).
    """
    _modal(motions, name)
    slants = any(filled(values, k) for k in (9, 10)) or bool(len(values) > 11 and values[11])
    message = f"{name} with slanting sides or holes left out is not read"
    refuse(name, (slants, "not-read", message, "ANG1, ANG2 and HIDE are empty"))
    way = cmath.rect(1.0, math.radians(filled(values, 2)))
    origin, steps = complex(filled(values, 0), filled(values, 1)), [filled(values, 3), filled(values, 4)]
    counts = [_count(name, values, 5), _count(name, values, 6)]
    here = (motions.here_in_plane() - origin) / way
    ways = []
    for unit, place, step, count in zip((way, way * 1j), (here.real, here.imag), steps, counts, strict=True):
        near = abs(place) <= abs(place - (count - 1) * step)
        ways.append(unit * step * (1.0 if near else -1.0))
        origin += 0.0 if near else unit * step * (count - 1)
    # Rows lie along the smaller distance.
    row = 0 if abs(steps[0]) <= abs(steps[1]) else 1
    frame = round(filled(values, 7)) == 1
    places = in_rows(origin, ways[row], ways[1 - row], counts[row], counts[1 - row], frame=frame)
    _visit(motions, places)


_MOST_PLACES = 9


def _places(motions: Motions, name: str, values: Values) -> None:
    """CYCLE802(XA, YA, X0, Y0, X1, Y1, …): holes at up to nine places; digits of XA and YA, the last for X0: 1 a place, 2 a step."""
    _modal(motions, name)
    kinds = [f"{round(filled(values, k)):0{_MOST_PLACES}d}"[::-1] for k in (0, 1)]
    places: list[complex] = []
    at = [0.0, 0.0]
    for k in range(_MOST_PLACES):
        given = values[2 + 2 * k : 4 + 2 * k]
        if len(given) < 2 or all(value is None for value in given):
            break
        for axis in (0, 1):
            value = filled(values, 2 + 2 * k + axis)
            at[axis] = at[axis] + value if kinds[axis][k] == "2" and places else value
        places.append(complex(*at))
    hint = "X0 and Y0 are its third and fourth argument"
    refuse(name, (not places, "cycle-words", f"{name} has no place", hint))
    _visit(motions, places)


CYCLES: dict[str, Callable[[Motions, str, Values], None]] = {
    "CYCLE81": _drill, "CYCLE82": _drill, "CYCLE83": _deep, "CYCLE84": _tap,
    "CYCLE840": _tap_floating, "CYCLE85": _ream, "CYCLE86": _bore, "CYCLE87": _bore_stop, "CYCLE88": _bore_stop, "CYCLE89": _bore_feed,
    "HOLES1": _row, "HOLES2": _circle, "CYCLE801": _grid, "CYCLE802": _places,
}  # fmt: skip

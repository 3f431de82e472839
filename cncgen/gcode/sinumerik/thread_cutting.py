"""Threads that are turned: CYCLE97, CYCLE98, and CYCLE99 of SINUMERIK 840D sl, 828D and 808D, which has the parameters of CYCLE97 in another order."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from cncgen.gcode.codes.steps import MOST
from cncgen.gcode.errors import refuse
from cncgen.gcode.sinumerik.cycles import Values, check_mode_plane, doubt_order, filled, given, pitch_of

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions

#: How far the tool leaves a thread where no SDIS says it, mm.
_OFF = 1.0


@dataclass(frozen=True, slots=True)
class _Job:
    """The parts of a thread that CYCLE99 makes, and how far the tool leaves it, 0 for the usual distance."""

    roughs: bool = True
    finishes: bool = True
    off: float = 0.0


_ALL = _Job()
#: By the hundred thousands of VARI of CYCLE99: all where it says nothing.
_JOBS = {0: (True, True), 1: (True, False), 2: (False, True), 3: (True, True)}


def turned(motions: Motions, name: str, values: Values) -> None:
    """CYCLE97: PIT MPIT SPL FPL DM1 DM2 APP ROP TDEP FAL IANG NSP NRC NID VARI NUMT."""
    ends = [(filled(values, 2), filled(values, 4) / 2.0), (filled(values, 3), filled(values, 5) / 2.0)]
    pitches = [pitch_of(name, given(values, 1), given(values, 0))]
    _cut(motions, name, ends, pitches, values[6:14], filled(values, 14), filled(values, 15))


def chain(motions: Motions, name: str, values: Values) -> None:
    """CYCLE98: PO1 DM1 PO2 DM2 PO3 DM3 PO4 DM4 APP ROP TDEP FAL IANG NSP NRC NID PP1 PP2 PP3 VARI NUMTH; points that coincide leave a section out."""
    ends = [(filled(values, k), filled(values, k + 1) / 2.0) for k in range(0, 8, 2)]
    sections = [k for k in (1, 2, 3) if ends[k] != ends[k - 1]]
    pitches = [pitch_of(name, None, given(values, 15 + k)) for k in sections]
    kept = [ends[0], *(ends[k] for k in sections)]
    _cut(motions, name, kept, pitches, values[8:16], filled(values, 19), filled(values, 20))


def _cut(
    motions: Motions,
    name: str,
    ends: list[tuple[float, float]],
    pitches: list[float],
    how: Values,
    kind: float,
    starts: float,
    job: _Job = _ALL,
) -> None:
    """Cut threads of a lead each from end to end (Z, radius), in one go: APP ROP TDEP FAL IANG NSP NRC NID, VARI and NUMT.

    NRC cuts of equal depth (VARI 1 outside, 2 inside) or equal section (3, 4) at IANG along a flank, or both in turn below 0; then the
    allowance FAL, and NID passes more, unless `job` leaves one of both out. The tool leaves the thread by 1 mm. The angle of the spindle at the start (NSP, NUMT) moves no axis.
    (840D, Programming Guide, Cycles, 4.7 and 4.8; 808D turning, 01/2017, p. 205)
    """
    depth, allowance, angle = (filled(how, k) for k in (2, 3, 4))
    cuts, idle, kind, starts = round(filled(how, 6)), round(filled(how, 7)), round(kind), round(starts) or 1
    (start, _), (finish, _) = ends[0], ends[-1]
    way, side = math.copysign(1.0, finish - start), 1.0 if kind in (1, 3) else -1.0
    parts = list(pairwise(ends))
    faults = (
        (motions.ip.state.plane != 18, "works in the plane G18", "G18 stands before it"),
        (start == finish, "has no length: it ends where it begins", "its points are where it begins and ends"),
        (min(radius for _, radius in ends) <= 0.0, "has no diameter", "DM1, DM2 … are the diameters at its points"),
        (not 0.0 <= allowance < depth, f"has the depth {depth:g} and the allowance {allowance:g}", "TDEP is above FAL"),
        (not 1 <= cuts <= MOST, f"has {cuts} cuts", "NRC counts them"),
        (not 0 <= idle <= MOST or not 1 <= starts <= 100, "has a wrong number of passes or starts", "NID, NUMT"),
        (kind not in (1, 2, 3, 4), f"has VARI = {kind}", "VARI is 1 to 4"),
        (abs(angle) >= 60.0, f"has the infeed angle {angle:g}", "IANG is half the angle of the flanks at most"),
        (any((b[0] - a[0]) * way <= 0.0 for a, b in parts), "turns back along Z", "its points follow each other along Z"),
        (any(abs(b[1] - a[1]) > abs(b[0] - a[0]) for a, b in parts), "is steeper than 45 degrees", "such a thread has its lead along X"),
    )  # fmt: skip
    refuse(name, *((wrong, "thread-words", f"{name} {what}", hint) for wrong, what, hint in faults))
    slopes = [(b[1] - a[1]) / (b[0] - a[0]) for a, b in parts]
    first, last = start - way * abs(filled(how, 0)), finish + way * abs(filled(how, 1))
    path = [*ends[1:-1], (last, ends[-1][1] + slopes[-1] * (last - finish))]
    rough = depth - allowance
    depths = [rough * (math.sqrt(k / cuts) if kind > 2 else k / cuts) for k in range(1, cuts + 1)]
    finishing = [depth] * ((1 if allowance or not job.roughs else 0) + idle)
    depths = [*(depths if job.roughs else ()), *(finishing if job.finishes else ())]
    off = job.off or _OFF / motions.ip.state.unit_mm
    entry = ends[0][1] + slopes[0] * (first - start)
    out = (max if side > 0.0 else min)(entry, *(radius for _, radius in (*ends, path[-1]))) + side * off
    motions.move({"X": out, "Z": first}, rapid=True)
    for k, cut in [(k, cut) for _ in range(starts) for k, cut in enumerate(depths)]:
        flank = way * cut * math.tan(math.radians(abs(angle))) * (-1.0 if angle < 0.0 and k % 2 else 1.0)
        begin = first + flank
        motions.move({"Z": begin}, rapid=True)
        motions.move({"X": ends[0][1] + slopes[0] * (begin - start) - side * cut}, rapid=True)
        for (z, radius), slope, pitch in zip(path, slopes, pitches, strict=True):
            motions.emit({"x": radius - side * cut, "z": z, "k": pitch * math.hypot(1.0, slope)}, (330,))
        motions.move({"X": out}, rapid=True)
        motions.move({"Z": first}, rapid=True)


def of_control(motions: Motions, name: str, values: Values) -> None:
    """CYCLE99: SPL SPD FPL FPD APP ROP TDEP FAL IANG NSP NRC NID PIT VARI NUMTH SDIS MID GDEP PIT1 FDEP GST GUD IFLANK PITA PITM PTAB PTABA DMODE AMODE.

    Digits of VARI, ones first: that of CYCLE97; none; 1 feeds in along one flank, 2 along both in turn; none; whether NRC or MID counts the
    cuts; 1 roughs, 2 finishes, 3 does both; the order of starts, which moves no axis. IFLANK is how far the tool comes in aside over the whole
    depth, where IANG gives no angle. Without FPD the thread has one diameter.
    """
    vari, depth, angle = round(filled(values, 13)), filled(values, 6), filled(values, 8)
    kind, tens, flanks, thousands, counts, job, order = (vari // 10**k % 10 for k in range(7))
    start, mode, unit = filled(values, 0), round(filled(values, 28)), round(filled(values, 23))
    wrong = tens or thousands or flanks > 2 or counts > 2 or job not in _JOBS or order > 1 or vari >= 10**7
    cuts, first = round(filled(values, 10)), filled(values, 16)
    unsure = "FPL is a coordinate or a distance, which AMODE says, and is read where SPL is 0 or AMODE is 0"
    refuse(
        name,
        (bool(wrong), "not-read", f"VARI = {vari} of {name} is not read", "300101 is an outside thread, roughed and finished, 300103 in cuts of equal section"),
        (unit > 1, "not-read", f"PITA = {unit} of {name} (a lead in inches or threads an inch) is not read", "PIT in mm with PITA = 1"),
        (filled(values, 18) != 0.0, "not-read", f"{name} with PIT1, a lead that changes, is not read", "PIT1 is the nineteenth parameter"),
        (mode != 0 and start != 0.0, "not-read", f"AMODE = {mode} of {name} with SPL = {start:g} is not read", unsure),
        (cuts <= 0 and first <= 0.0, "thread-words", f"{name} has no cuts", "NRC counts them, or MID is the first one"),
    )  # fmt: skip
    check_mode_plane(motions, name, round(filled(values, 27)))
    doubt_order(
        motions,
        name,
        "SPL SPD FPL FPD APP ROP TDEP FAL IANG NSP NRC NID PIT VARI NUMTH SDIS MID: are the values these?",
    )
    others = [k + 1 for k in (17, 19, 20, 21) if filled(values, k)]
    if others:
        message = (
            f"parameters {', '.join(map(str, others))} of {name} are not read; the cycle is made as without"
        )
        motions.ip.warn_once("cycle-parameters", message, name, "GDEP, FDEP, GST and GUD are 0")
    rough = depth - filled(values, 7)
    if cuts <= 0:
        parts = max(rough, 0.0) / first
        cuts = math.ceil((parts**2 if kind > 2 else parts) - 1e-9)
    if not angle and depth > 0.0:
        angle = math.degrees(math.atan(filled(values, 22) / depth))
    angle = -abs(angle) if flanks == 2 else abs(angle) if flanks == 1 else angle
    diameter = filled(values, 1)
    ends = [(start, diameter / 2.0), (filled(values, 2), (given(values, 3) or diameter) / 2.0)]
    how: Values = [
        *(filled(values, k) for k in range(4, 8)),
        angle,
        filled(values, 9),
        float(cuts),
        filled(values, 11),
    ]
    job_of = _Job(*_JOBS[job], abs(filled(values, 15)))
    _cut(
        motions, name, ends, [pitch_of(name, None, given(values, 12))], how, kind, filled(values, 14), job_of
    )


CYCLES: dict[str, Callable[[Motions, str, Values], None]] = {
    "CYCLE97": turned,
    "CYCLE98": chain,
    "CYCLE99": of_control,
}

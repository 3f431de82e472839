"""The rules of controls: their speeds on blocks and at corners."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.machine.record import Machine
from cncgen.planner.controls.control_blocks import Blocks
from cncgen.planner.limits.axis_limits import AxisLimits, along_path

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

#: Cosine of the turn beyond which a way is straight, and below which it is reversed.
_STRAIGHT = 0.999999
#: Junction deviation and arc tolerance of grbl's own settings $11 and $12, mm, and the blocks of its buffer
#: (https://github.com/gnea/grbl/wiki/Grbl-v1.1-Configuration).
JUNCTION_DEVIATION_MM = 0.01
ARC_TOLERANCE_MM = 0.002
GRBL_DEPTH = 15
#: Segments that LinuxCNC's arc blends look ahead, by default (its manual, [TRAJ]ARC_BLEND_OPTIMIZATION_DEPTH).
LINUXCNC_DEPTH = 50
#: Share of an axis's acceleration that LinuxCNC gives to the bend of an arc, measured: 22.59 mm/s on a corner of 90°
#: with P0.1 and 2450 mm/s², 65.13 mm/s on an arc of 2 mm; and the rest along the way: √(1 - 3/4).
NORMAL_SHARE = np.sqrt(0.75)
TANGENTIAL_SHARE = 0.5
#: Share of its acceleration that LinuxCNC gives to the last block before a stop under G64, measured: it keeps the rest for a
#: blend that does not come.
LAST_SHARE = 0.5
#: Servo periods that LinuxCNC takes longer than the trapezoids, measured: one for each deceleration, as it decides for
#: the period to come, and two more for each stop (4 stops of a square last 12.4 ms longer).
LINUXCNC_STOP_PERIODS = 2
LINUXCNC_SLOWING_PERIODS = 1
#: Sagitta of the parts that curves are cut into where a control follows them as they are, mm.
_FINE_MM = 0.001


@dataclass(frozen=True, slots=True)
class Control:
    """A control's rules.

    Attributes:
        title: Its name for people.
        depth: Blocks that it looks ahead.
        chord_mm: Distance of a curve from the chords that it is cut into.
        stop_periods: Servo periods that a stop takes beside the trapezoids.
        slowing_periods: Servo periods that a deceleration takes longer.
        rules: Returns the blocks with the speeds and accelerations allowed on them. Where the control rounds corners, blocks are cut further.
    """

    title: str
    depth: int
    chord_mm: float
    stop_periods: int
    slowing_periods: int
    rules: Callable[[Blocks, str, Machine], Blocks]


def exact_stop(blocks: Blocks, axes: str, machine: Machine) -> Blocks:
    """A rest after each block of the program; arcs as fast as their acceleration allows."""
    top = np.minimum(blocks.feed, np.sqrt(blocks.acceleration * blocks.radius))
    return replace(blocks, top=top, entry=np.where(blocks.inner, _met(top), 0.0))


def grbl(blocks: Blocks, axes: str, machine: Machine) -> Blocks:
    """Corners by junction deviation; arcs as chords; a buffer of 16 blocks.

    A circle that touches both ways at a corner and is δ from it at its middle has the radius
    R = δ sin(θ/2) / (1 − sin(θ/2)), θ the angle between the ways; the speed is √(a R), with the acceleration that the
    axes can give towards the circle's middle (S. Jeon, Improving Grbl: Cornering Algorithm, 2011).
    """
    cosine = _turn(blocks)
    half = np.sqrt(0.5 * (1.0 + cosine))
    towards = np.zeros_like(blocks.way_in)
    towards[1:] = blocks.way_in[1:] - blocks.way_out[:-1]
    towards /= np.maximum(np.linalg.norm(towards, axis=1), 1e-300)[:, None]
    limit = AxisLimits.of(machine, axes).acceleration
    with np.errstate(divide="ignore"):
        corner = np.sqrt(along_path(limit, towards) * JUNCTION_DEVIATION_MM * half / (1.0 - half))
    corner = np.where(cosine > _STRAIGHT, np.inf, np.where(cosine < -_STRAIGHT, 0.0, corner))
    corner[blocks.stopped] = 0.0
    strength = along_path(limit, blocks.way_in, blocks.way_out)
    return replace(blocks, entry=np.minimum(corner, _met(blocks.feed)), acceleration=strength)


def linuxcnc(blocks: Blocks, axes: str, machine: Machine) -> Blocks:
    """G61: a rest at corners. G64 P: arcs that touch both ways of a corner and are P from it, no longer than half of a way.

    Before that, lines that are within P of one line become this line (the naive cam detector).
    """
    if not len(blocks):
        return exact_stop(blocks, axes, machine)
    blocks = _straightened(blocks)
    cosine = _turn(blocks)
    tangent = (cosine > _STRAIGHT) | blocks.inner
    same = np.append(False, blocks.rapid[1:] == blocks.rapid[:-1])
    rounded = ~tangent & same & ~blocks.stopped & (cosine > -_STRAIGHT)
    rounded[1:] &= ~(blocks.exact[1:] | blocks.exact[:-1])
    rounded &= np.isinf(blocks.radius) & np.append(False, np.isinf(blocks.radius[:-1]))
    passed = tangent & same & ~blocks.stopped
    passed[1:] &= ~blocks.exact_stop[:-1]
    acceleration = np.where(
        np.isinf(blocks.radius), blocks.acceleration, TANGENTIAL_SHARE * blocks.acceleration
    )
    top = np.minimum(blocks.feed, np.sqrt(NORMAL_SHARE * blocks.acceleration * blocks.radius))
    stops = np.append(blocks.stopped[1:], True) & ~blocks.exact
    # All parts of a row, or of rows that became one line.
    part = np.cumsum(~blocks.inner) - 1
    last = np.isin(part, part[stops])
    acceleration = np.where(last, LAST_SHARE * acceleration, acceleration)
    entry = np.where(passed, _met(top), 0.0)
    allowed = replace(blocks, top=top, entry=entry, acceleration=acceleration)
    return _with_arcs(allowed, blocks.acceleration, rounded, cosine)


def _straightened(blocks: Blocks) -> Blocks:
    """Make one block of blocks that are within their tolerance of one line."""
    free = np.isinf(blocks.radius) & ~blocks.exact & ~blocks.rapid & (blocks.tolerance > 0.0)
    joins = np.append(False, free[1:] & free[:-1] & (blocks.feed[1:] == blocks.feed[:-1]))
    joins &= ~(blocks.stopped | blocks.leads)
    if not joins.any():
        return blocks
    corner = np.concatenate(
        [np.zeros((1, blocks.way_in.shape[1])), np.cumsum(blocks.way_in * blocks.length[:, None], axis=0)]
    )
    firsts, first, n = [0], 0, len(blocks)
    for last in range(1, n):
        if not (joins[last] and _near_chord(corner[first : last + 2], blocks.tolerance[first])):
            first = last
            firsts.append(last)
    at, end = np.array(firsts), np.array([*firsts[1:], n])
    chord = corner[end] - corner[at]
    straight = np.linalg.norm(chord, axis=1)
    single = end == at + 1
    way = np.where(single[:, None], blocks.way_in[at], chord / np.maximum(straight, 1e-300)[:, None])
    way_out = np.where(single[:, None], blocks.way_out[at], way)
    return replace(
        blocks.part(at),
        end=blocks.end[end - 1],
        length=np.where(single, blocks.length[at], straight),
        acceleration=np.minimum.reduceat(blocks.acceleration, at),
        way_in=way,
        way_out=way_out,
    )


def _near_chord(points: Floats, tolerance: float) -> bool:
    """Tell whether all points are within a tolerance of the line from the first to the last, and between these."""
    chord = points[-1] - points[0]
    length = float(np.linalg.norm(chord))
    if length == 0.0:
        return False
    along = (points[1:-1] - points[0]) @ (chord / length)
    off = points[1:-1] - points[0] - along[:, None] * (chord / length)
    between = np.all((along >= 0.0) & (along <= length))
    return bool(between and np.all(np.einsum("ij,ij->i", off, off) <= (tolerance * (1.0 + 1e-9)) ** 2))


def _with_arcs(blocks: Blocks, strongest: Floats, rounded: Bools, cosine: Floats) -> Blocks:
    """Cut the arcs of rounded corners out of the ways on both sides, half an arc on each; blocks had the acceleration `strongest`."""
    at = np.flatnonzero(rounded)
    if not len(at):
        return blocks
    half = 0.5 * elementary.arccos(np.clip(cosine[at], -1.0, 1.0))
    tolerance = np.minimum(blocks.tolerance[at], blocks.tolerance[at - 1])
    cut = tolerance * np.sin(half) / (1.0 - np.cos(half))
    cut = np.minimum(cut, 0.5 * np.minimum(blocks.length[at], blocks.length[at - 1]))
    radius = cut / np.tan(half)
    strength = np.minimum(strongest[at], strongest[at - 1])
    met = np.minimum(blocks.top[at], blocks.top[at - 1])
    speed = np.minimum(met, np.sqrt(NORMAL_SHARE * strength * radius))
    before, after = np.zeros(len(blocks)), np.zeros(len(blocks))
    before[at], after[at - 1] = cut, cut
    arc, arc_speed, arc_strength = (np.zeros(len(blocks)) for _ in range(3))
    arc[at], arc_speed[at], arc_strength[at] = radius * half, speed, TANGENTIAL_SHARE * strength
    following = np.append(rounded[1:], False)
    # In order: the second half of the arc behind, the way, the first half of the arc before.
    number = np.concatenate([np.flatnonzero(rounded), np.arange(len(blocks)), np.flatnonzero(following)])
    place = np.repeat([0, 1, 2], [len(at), len(blocks), len(at)])
    order = np.lexsort((place, number))
    number, place = number[order], place[order]
    corner = np.where(place == 2, np.minimum(number + 1, len(blocks) - 1), number)
    of_arc = place != 1
    start = np.where(
        place == 0, blocks.start[number],
        np.where(place == 1, blocks.start[number] + before[number], blocks.end[number] - after[number]),
    )  # fmt: skip
    end = np.where(
        place == 0, blocks.start[number] + before[number],
        np.where(place == 1, blocks.end[number] - after[number], blocks.end[number]),
    )  # fmt: skip
    length = np.where(of_arc, arc[corner], np.maximum(end - start, 0.0))
    top = np.where(of_arc, arc_speed[corner], blocks.top[number])
    acceleration = np.where(of_arc, arc_strength[corner], blocks.acceleration[number])
    met = np.minimum(top, np.append(0.0, top[:-1]))
    begins_block = (place == 0) | ((place == 1) & ~rounded[number])
    entry = np.where(begins_block & ~rounded[number], blocks.entry[number], met)
    columns = {
        "start": start,
        "end": end,
        "length": length,
        "top": top,
        "entry": entry,
        "acceleration": acceleration,
    }
    kept = (length > 0.0) | (end > start)
    return replace(blocks.part(number), **columns).part(np.flatnonzero(kept))


def _turn(blocks: Blocks) -> Floats:
    """Return the cosine of the turn where each block begins, 1 at the first, shape (n,)."""
    return np.append(1.0, np.einsum("ij,ij->i", blocks.way_in[1:], blocks.way_out[:-1]))[: len(blocks)]


def _met(top: Floats) -> Floats:
    """Return the lower one of the speeds of each block and the block before, shape (n,)."""
    return np.minimum(top, np.append(top[:1], top[:-1]))


#: By the name that ``--as`` takes.
CONTROLS = {
    "linuxcnc": Control(
        "LinuxCNC", LINUXCNC_DEPTH, _FINE_MM, LINUXCNC_STOP_PERIODS, LINUXCNC_SLOWING_PERIODS, linuxcnc
    ),
    "grbl": Control("grbl", GRBL_DEPTH, ARC_TOLERANCE_MM, 0, 0, grbl),
    "exact-stop": Control("a control with exact stop", 1_000, _FINE_MM, 0, 0, exact_stop),
}

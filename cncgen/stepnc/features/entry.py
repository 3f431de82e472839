"""Ways down into the material: helix, ramp along a path, zigzag, plunge."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cncgen.stepnc.features.job import Floats, Job, Moves
from cncgen.stepnc.features.offsets import OffsetError, clearance
from cncgen.stepnc.geometry.chords import polyline_of
from cncgen.stepnc.geometry.pieces import Piece
from cncgen.stepnc.model import STEEPEST

if TYPE_CHECKING:
    from shapely import Polygon

#: Angle of helices and ramps where none is given (NIST's interpreter).
DEFAULT_ANGLE = math.radians(10.0)
#: Radius of a helix in diameters of the tool (the same).
HELIX_RADIUS = 0.4
#: The smallest helix worth it, and the shortest line to ramp along, in diameters.
SMALLEST_HELIX = 0.1
SHORTEST_RAMP = 0.1
#: Ways to and fro that a line shorter than that is good for.
MAX_WAYS = 100
#: Angle of the ramps of tools whose edges do not reach their middle.
FLAT_ANGLE = math.radians(2.0)
_RAMPS = ("plunge ramp", "plunge zigzag", "plunge zig zag")
#: Turns of a helix, and lines of a ramp, on one level.
MAX_TURNS = 10_000
MAX_RAMP_LINES = 1_000_000


@dataclass(frozen=True, slots=True)
class Entry:
    """A way down at a place: where it begins for a height, and the moves from there to the place.

    Attributes:
        start: Called with heights from and to (mm); returns the point, shape (3,), above which the tool comes down.
        descend: Called with the moves and the height to reach; ends at the place.
    """

    start: Callable[[float, float], Floats]
    descend: Callable[[Moves, float], None]


def choose(job: Job, place: Floats, direction: Floats, path: list[Piece], region: Polygon) -> Entry:
    """Return the entry that the operation's approach asks for, else a helix, or a ramp where no helix fits.

    PLUNGE_TOOLAXIS, PLUNGE_RAMP, PLUNGE_HELIX and PLUNGE_ZIGZAG of ISO 14649-11.

    Args:
        job: The operation.
        place: Shape (3,), where the cut begins.
        direction: Shape (3,), unit vector in which it begins.
        path: First cut, from `place`: a ramp goes along it.
        region: shapely polygon of where the tool's centre may go.
    """
    approach = job.operation.approach
    kind = approach.kind if approach else ""
    values = approach.values if approach else {}
    angle = _angle(job, values.get("angle"))
    if kind == "plunge toolaxis":
        return _straight(job, place)
    if kind in _RAMPS:
        return ramp(job, place, path, angle, _width(job, values))
    if kind not in ("", "plunge helix", "plunge helical"):
        job.warn(
            "stepnc-approach",
            f"approach {kind!r} is for the sides of a contour; the tool goes down in a helix",
        )
    wanted = float(values.get("radius", HELIX_RADIUS * 2 * job.radius))
    if not wanted > 0:
        raise job.fault("stepnc-geometry", f"the radius of the helix is {wanted:g} mm; it must be above 0")
    fits = min(wanted, clearance(region, place))
    if fits < wanted - 1e-6:
        if fits < SMALLEST_HELIX * 2 * job.radius:
            return ramp(job, place, path, angle)
        if "radius" in values:
            job.warn("stepnc-approach", f"a helix of {wanted:g} mm does not fit; it has {fits:g} mm")
    return helix(place, direction, fits, angle, clockwise=not job.climb)


def along_cut(job: Job, place: Floats, path: list[Piece]) -> Entry:
    """Return the way down where the tool has no room beside the cut, a slot or a line across a face: a ramp along it.

    A PLUNGE_TOOLAXIS goes straight down; a helix that is asked for finds no room, with a warning.

    Args:
        job: The operation.
        place: Shape (3,), where the cut begins.
        path: The cut, from `place`.
    """
    approach = job.operation.approach
    kind, values = (approach.kind, approach.values) if approach else ("", {})
    if kind == "plunge toolaxis":
        return _straight(job, place)
    if kind and kind not in _RAMPS:
        text = f"approach {kind!r} has no room where the cut is as wide as the tool; the tool goes down in a ramp along it"
        job.warn("stepnc-approach", text)
        values = {}
    return ramp(job, place, path, _angle(job, values.get("angle")), _width(job, values))


def _straight(job: Job, place: Floats) -> Entry:
    """Return the straight way down, with a warning for a tool whose edges do not reach its middle."""
    if not job.tool.centre_cutting:
        text = f"a {job.tool.kind} does not cut at its centre, and goes straight down"
        job.warn("stepnc-plunge", f"{text}; PLUNGE_RAMP or PLUNGE_HELIX would spare it")
    return plunge(place)


def _width(job: Job, values: Mapping[str, Any]) -> float:
    """Return how long the ways to and fro of a zigzag are at most, mm."""
    width = values.get("width")
    if not isinstance(width, int | float):
        return math.inf
    if not width > 0:
        raise job.fault("stepnc-geometry", f"the width of a zigzag is {width:g} mm; it must be above 0")
    return float(width)


def _angle(job: Job, given: float | None) -> float:
    """Return the angle of a way down, rad: that given, else 10 degrees, or 2 for tools that do not cut at their centre."""
    flat = not job.tool.centre_cutting
    if not isinstance(given, int | float):
        return FLAT_ANGLE if flat else DEFAULT_ANGLE
    angle = float(given)
    if not 0 < angle < math.pi / 2:
        text = f"the angle of the approach is {math.degrees(angle):g} degrees; it must lie between 0 and 90"
        raise job.fault("stepnc-geometry", text)
    if flat and angle > STEEPEST:
        text = (
            f"a {job.tool.kind} does not cut at its centre, and goes down at {math.degrees(angle):g} degrees"
        )
        job.warn("stepnc-plunge", f"{text}; {math.degrees(STEEPEST):g} are usual at most")
    return angle


def plunge(place: Floats) -> Entry:
    """Return the straight way down."""
    return Entry(lambda top, bottom: place, lambda moves, z: moves.height(z))


def helix(place: Floats, direction: Floats, radius: float, angle: float, clockwise: bool) -> Entry:
    """Return a helix about the place, and half a circle that leads into the first cut without a corner."""
    pitch = 2 * math.pi * radius * math.tan(angle)
    turn = -1.0 if clockwise else 1.0
    side = turn * np.array([-direction[1], direction[0], 0.0])
    last = place + radius * side  # where the helix ends

    def start(top: float, bottom: float) -> Floats:
        back = -turn * 2 * math.pi * (top - bottom) / pitch
        c, s = math.cos(back), math.sin(back)
        return np.array(
            [
                place[0] + radius * (side[0] * c - side[1] * s),
                place[1] + radius * (side[0] * s + side[1] * c),
                0.0,
            ]
        )

    def descend(moves: Moves, z: float) -> None:
        sweep = 2 * math.pi * (moves.position[2] - z) / pitch
        if sweep > 2 * math.pi * MAX_TURNS:
            text = f"at {math.degrees(angle):g} degrees the helix needs {sweep / (2 * math.pi):.0f} turns, more than {MAX_TURNS}"
            raise OffsetError(text)
        moves.arc(np.array([last[0], last[1], z]), place, clockwise, sweep)
        middle = place + radius / 2 * side
        moves.arc(np.array([place[0], place[1], z]), middle, clockwise, math.pi)

    return Entry(start, descend)


def ramp(
    job: Job, place: Floats, path: list[Piece], angle: float = DEFAULT_ANGLE, longest: float = math.inf
) -> Entry:
    """Return a ramp to and fro along the way to the first cut and the cut, so steep as the angle, that ends at the place.

    Its ways are no longer than `longest`, mm.

    Where the cut is so short that the tool would do little but turn round, it goes straight down, with a warning.
    """
    line = np.concatenate([place[None, :], *(polyline_of(p, 1e-3).points for p in path)])[:, :2]
    line = line[np.concatenate([[True], np.abs(np.diff(line, axis=0)).max(axis=1) > 1e-9])]
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    total = min(float(lengths[-1]), longest)

    def descend(moves: Moves, z: float) -> None:
        drop = moves.position[2] - z
        if drop <= 0 or total < 1e-6:
            moves.height(z)
            return
        # There and back as often as needed, so that the last way back ends at the place.
        pairs = max(1, math.ceil(drop / math.tan(angle) / (2 * total)))
        if total < SHORTEST_RAMP * 2 * job.radius and 2 * pairs > MAX_WAYS:
            job.warn(
                "stepnc-approach",
                f"the first cut of {total:.3g} mm is too short for a ramp; the tool plunges",
            )
            moves.height(z)
            return
        if 2 * pairs * len(line) > MAX_RAMP_LINES:
            text = f"at {math.degrees(angle):g} degrees the ramp goes to and fro {pairs} times: more than {MAX_RAMP_LINES} lines"
            raise OffsetError(text)
        reach = min(total, drop / math.tan(angle) / (2 * pairs))
        s = np.concatenate([lengths[lengths < reach], [reach]])
        out = np.column_stack([np.interp(s, lengths, line[:, k]) for k in (0, 1)])
        each = drop / (2 * pairs)
        top = float(moves.position[2])
        for k in range(2 * pairs):
            way, share = (out, s / reach) if k % 2 == 0 else (out[::-1], 1 - s[::-1] / reach)
            moves.feed(
                *(np.array([x, y, top - each * (k + f)]) for (x, y), f in zip(way, share, strict=True))
            )

    return Entry(lambda top, bottom: place, descend)

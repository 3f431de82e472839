"""Turned features as profiles in the plane of X, the radius, and Z, the axis of the work.

ISO 14649-12 and ISO 10303-238 have the same features. Where they are silent, the features are read as in their origin, AP224 (ISO
10303-224): an outer diameter goes from its placement along Z; `radius` is the distance of the profile's origin from the axis; a
profile in the plane of its X and Y has X along the radius and Y against Z. The diameters of the standards' own example (ISO 14649-12,
annex D; ISO 10303-238, annex J) go against Z, as milled features do. If only this direction makes one part of them, or lies within the
raw piece, it is taken.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.geometry.frames import Matrix, apply, identity, translation
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline, reverse
from cncgen.stepnc.geometry.solids import Solid
from cncgen.stepnc.model import Feature, Operation, Shape, Vector, Workingstep

#: Farther out than any bar, mm: where the walls of a groove end.
OUTSIDE = 1e4
#: How far a profile may lie beside its plane, mm.
FLAT = 1e-6
#: The kind of features whose side of the placement may have to be found.
_DIAMETER = "outer diameter"


def diameter(owner: Entity, diameters: tuple[float, float], length: float) -> list[Piece]:
    """Return an outer diameter from its placement along Z, with its diameters where it begins and ends, mm.

    Raises:
        Skip: where its taper goes beyond the axis.
    """
    first, last = diameters[0] / 2, diameters[1] / 2
    if not last >= 0:
        raise owner.fault("stepnc-geometry", f"the taper ends {-last:g} mm beyond the axis")
    return [Polyline(np.array([[first, 0.0, 0.0], [last, 0.0, length]]))]


def groove(profile: Entity, section: dict[str, Any], place: Matrix | None, radius: float) -> Shape:
    """Return a groove round the work: its section open outwards, the width along Z, the bottom at a radius.

    Args:
        profile: The section's entity.
        section: The values of `Shape` that it gives a slot.
        place: Of the section within the feature, or None.
        radius: mm.

    Raises:
        Skip: where no tool can turn it.
    """
    x, z = (0.0, 0.0) if place is None else (float(place[0, 3]), float(place[2, 3]))
    x += radius
    if section.get("section", "") not in ("", "vee"):
        raise profile.fault("stepnc-unsupported", "a groove of this section cannot be turned")
    if section.get("section") == "vee":
        if section["section_radius"]:
            raise profile.fault("stepnc-unsupported", "a vee with a rounded bottom cannot be turned")
        lean = math.tan(section["section_angle"] / 2) * OUTSIDE
        bottom: list[Piece] = []
        low = high = np.array([x, 0.0, z])
    else:
        lean, half = 0.0, section["width"] / 2
        bottom, low, high = _floor(profile, x, z, half, section["floor_radius"] or 0.0)
    first = Polyline(np.array([[x + OUTSIDE, 0.0, high[2] + lean], high]))
    last = Polyline(np.array([low, [x + OUTSIDE, 0.0, low[2] - lean]]))
    return Shape(contour=[first, *bottom, last], width=2 * abs(high[2] - z))


def _floor(
    profile: Entity, x: float, z: float, half: float, radius: float
) -> tuple[list[Piece], np.ndarray, np.ndarray]:
    """Return the floor of a groove with rounded corners, from high Z to low, and where its low and high wall begin."""
    if not 0 <= radius <= half + 1e-9 or not half > 0:
        text = f"a groove {2 * half:g} mm wide has no corners of {radius:g} mm"
        raise profile.fault("stepnc-geometry", text)
    low, high = np.array([x + radius, 0.0, z - half]), np.array([x + radius, 0.0, z + half])
    if radius == 0:
        return [Polyline(np.stack([high, low]))], low, high
    # About Y: from Z to X the angle grows, and on the way down and along the floor it falls from 0 (at +Z).
    normal = np.array([0.0, -1.0, 0.0])
    right, left = (
        np.array([x + radius, 0.0, z + half - radius]),
        np.array([x + radius, 0.0, z - half + radius]),
    )
    deep = np.array([-radius, 0.0, 0.0])
    out: list[Piece] = [Arc(high, right + deep, right, normal, math.pi / 2)]
    if half - radius > 1e-9:
        out.append(Polyline(np.stack([right + deep, left + deep])))
    return [*out, Arc(left + deep, low, left, normal, math.pi / 2)], low, high


def in_plane(profile: Entity, pieces: list[Piece], radius: float) -> list[Piece]:
    """Return a profile in the plane of X and Z, its origin `radius` mm from the axis.

    Raises:
        Skip: where it lies in another plane.
    """
    ends = np.stack([p for piece in pieces for p in (piece.start, piece.end, _bulge(piece))])
    if np.abs(ends[:, 1]).max() > FLAT:
        if np.abs(ends[:, 2] - ends[0, 2]).max() > FLAT:
            raise profile.fault("stepnc-geometry", "a turned profile must lie in a plane through the axis")
        turned = np.eye(4)
        turned[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
        pieces = [p.moved(turned) for p in pieces]
    return [p.moved(translation(radius, 0.0, 0.0)) for p in pieces]


def standing(entities: Entities, features: list[Feature], raw: Solid | None) -> Feature:
    """Return the feature of a workingstep; of several turned ones their profiles end to end, in the workpiece's frame.

    Args:
        entities: Of the file; they take the faults.
        features: One or more.
        raw: The raw piece in the workpiece's frame, or None.

    Raises:
        Skip: from its shape, where one has a fault, is not turned, or they are not joined.
    """
    if len(features) == 1:
        one = features[0]
        return replace(one, shape=lambda: _within(entities, one, raw)) if one.kind == _DIAMETER else one
    owner = entities.get(features[0].ident)

    def shape() -> Shape:
        shapes = [f.shape() for f in features]
        if any(s.contour is None for s in shapes):
            text = "features that are not turned stand in one workingstep"
            raise owner.fault("stepnc-unsupported", text)
        material = next((s.material for s in shapes if s.inside), None)
        ways = [_placed(f, s) for f, s in zip(features, shapes, strict=True)]
        gap = _joined(ways)
        if isinstance(gap, str):
            other = _joined(
                [
                    _placed(f, _turned_back(s) if f.kind == _DIAMETER else s)
                    for f, s in zip(features, shapes, strict=True)
                ]
            )
            if isinstance(other, str):
                raise owner.fault("stepnc-geometry", gap)
            owner.warn(
                "stepnc-placement", f"{gap}; its diameters are taken against the Z of their placements"
            )
            gap = other
        return Shape(contour=gap, material=material)

    return Feature(features[0].ident, features[0].label, "turned profile", identity(), shape)


def _placed(feature: Feature, shape: Shape) -> list[Piece]:
    return [p.moved(feature.placement) for p in shape.contour or ()]


def _turned_back(shape: Shape) -> Shape:
    """Return an outer diameter that goes against Z."""
    mirrored = [Polyline(p.points * [1.0, 1.0, -1.0]) for p in shape.contour or () if isinstance(p, Polyline)]
    return replace(shape, contour=list(mirrored))


def _within(entities: Entities, feature: Feature, raw: Solid | None) -> Shape:
    """Return an outer diameter on the side of its placement where the raw piece is."""
    shape = feature.shape()
    if raw is None:
        return shape
    low, high = raw.reach(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    back = _turned_back(shape)
    if _beside(_placed(feature, shape), low, high) and not _beside(_placed(feature, back), low, high):
        text = "it lies outside of the raw piece along the Z of its placement, and within it against that, which is taken"
        entities.get(feature.ident).warn("stepnc-placement", text)
        return back
    return shape


def _beside(pieces: list[Piece], low: float, high: float) -> bool:
    """Tell whether half of a profile or more lies beyond heights."""
    ends = sorted([float(pieces[0].start[2]), float(pieces[-1].end[2])])
    inside = min(ends[1], high) - max(ends[0], low)
    return inside < (ends[1] - ends[0]) / 2


def _joined(profiles: list[list[Piece]]) -> list[Piece] | str:
    """Return turned profiles as one, from the highest Z down; a shoulder between two of them is joined by a line.

    If one does not begin at the Z where another ends, a text reports it.
    """
    down = [p if p[0].start[2] >= p[-1].end[2] else reverse(p) for p in profiles]
    down.sort(key=lambda p: -(p[0].start[2] + p[-1].end[2]))
    out = list(down[0])
    for profile in down[1:]:
        end, begin = out[-1].end, profile[0].start
        if abs(profile[-1].end[2] - end[2]) < 1e-3 and abs(begin[2] - end[2]) < 1e-3:
            # A face has two ends at one Z; it begins at that beside the profile before it.
            if abs(profile[-1].end[0] - end[0]) < abs(begin[0] - end[0]):
                profile = reverse(profile)
                begin = profile[0].start
        elif abs(begin[2] - end[2]) > 1e-3:
            apart = "apart" if begin[2] < end[2] else "one over the other"
            return f"its features are {abs(begin[2] - end[2]):g} mm {apart} along the axis, at Z {end[2]:g}"
        if np.abs(begin - end).max() > 1e-6:
            out.append(Polyline(np.stack([end, begin])))
        out += profile
    return out


def feed_direction(operation: Operation, frame: Matrix) -> Vector | None:
    """Return the direction of the feed that a strategy gives, seen from the machine, or None."""
    given = operation.strategy.values.get("feed_direction") if operation.strategy else None
    return elementary.product(frame[:3, :3], given) if isinstance(given, np.ndarray) else None


def feed_sense(step: Workingstep, shape: Shape) -> float:
    """Return 1 where a turning tool feeds against Z of the machine, −1 where it feeds along it, or faces the rear end of the bar.

    A face is cut from where no material is: that the direction into the material says, else the raw piece. Elsewhere the strategy
    says it, else the hand of the tool: a left-handed one feeds along Z, but not down a profile that only rises against Z, where its
    trailing edge would cut.
    """
    frame, tool, contour = step.frame, step.operation.tool, shape.contour or []
    ends = apply(frame, np.array([p for piece in contour for p in (piece.start, piece.end)]).reshape(-1, 3))
    if step.operation.kind.startswith("facing") and contour:
        behind = (
            0.0 if shape.material is None else float(elementary.product(frame[:3, :3], shape.material)[2])
        )
        if abs(behind) > 0.5:
            return 1.0 if behind < 0 else -1.0
        if step.raw is not None:
            low, high = step.raw.reach(np.zeros(3), np.array([0.0, 0.0, 1.0]))
            return 1.0 if high - ends[0, 2] <= ends[0, 2] - low else -1.0
    given = feed_direction(step.operation, frame)
    if given is not None and abs(given[2]) > abs(given[0]):
        return -1.0 if given[2] > 0 else 1.0
    if tool is None or not tool.left_handed:
        return 1.0
    rise = np.diff(ends[np.argsort(-ends[:, 2], kind="stable"), 0])
    return 1.0 if len(rise) and rise.min() >= -FLAT and rise.max() > FLAT else -1.0


def _bulge(piece: Piece) -> np.ndarray:
    """Return a point of a piece that does not lie on the line between its ends, if it is curved."""
    if isinstance(piece, Arc):
        return np.asarray(piece.points(np.array([0.5]))[0])
    points = piece.points if isinstance(piece, Polyline) else piece.control
    return np.asarray(points[len(points) // 2])

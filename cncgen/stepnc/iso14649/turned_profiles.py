"""The turned features of ISO 14649-12 as profiles in the plane of X, the radius, and Z, the axis of the work.

Where the first edition is silent, features are read as AP224 (ISO 10303-224) has them, from which they come: an outer diameter
goes from its placement along Z; `radius` is the distance of the profile's origin from the axis; a profile in the plane of its X
and Y has X along the radius and Y against Z.
"""

from __future__ import annotations

import math

import numpy as np

from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.geometry import profile_shapes
from cncgen.stepnc.geometry.frames import translation
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline, reverse
from cncgen.stepnc.iso14649.profiles import Profiles
from cncgen.stepnc.model import Shape

#: Farther out than any bar, mm: where the walls of a groove end.
OUTSIDE = 1e4
#: How far a profile may lie beside its plane, mm.
FLAT = 1e-6


class TurnedProfiles:
    """Reads turned features."""

    def __init__(self, entities: Entities, profiles: Profiles) -> None:
        self.entities = entities
        self.profiles = profiles
        self.shapes = {
            "OUTER_DIAMETER": self._outer_diameter,
            "REVOLVED_FLAT": lambda e: self._revolved(e, "flat_edge_shape"),
            "REVOLVED_ROUND": lambda e: self._revolved(e, "rounded_edge_shape"),
            "GENERAL_REVOLUTION": lambda e: self._revolved(e, "outer_edge_profile"),
            "GROOVE": self._groove,
        }

    def _outer_diameter(self, entity: Entity) -> Shape:
        radius = self.profiles.size(entity, "diameter_at_placement") / 2
        length = self.profiles.size(entity, "feature_length")
        end, ident = radius, entity.ref("reduced_size")
        if ident is not None:
            taper = self.entities.get(ident, "DIAMETER_TAPER", "ANGLE_TAPER", owner=entity.id)
            if taper.keyword == "DIAMETER_TAPER":
                end = self.profiles.length(taper, "final_diameter") / 2
            else:
                end = radius - length * math.tan(taper.number("angle") * self.profiles.curves.angle)
        if not end >= 0:
            raise entity.fault("stepnc-geometry", f"the taper ends {-end:g} mm beyond the axis")
        return Shape(contour=[Polyline(np.array([[radius, 0.0, 0.0], [end, 0.0, length]]))])

    def _revolved(self, entity: Entity, name: str) -> Shape:
        profile = entity.entity(name)
        kind = profile.keyword
        if kind == "LINEAR_PROFILE":
            reach = np.array([self.profiles.length(profile, "profile_length"), 0.0, 0.0])
            pieces: list[Piece] = [profile_shapes.linear_path(reach)]
        elif kind == "PARTIAL_CIRCULAR_PROFILE":
            sweep = profile.number("sweep_angle") * self.profiles.curves.angle
            pieces = [profile_shapes.arc_path(profile, self.profiles.length(profile, "radius"), sweep)]
        elif kind == "GENERAL_PROFILE":
            pieces = self.profiles.curves.read(profile.entity("its_profile").id, profile.id)
        else:
            raise profile.fault("stepnc-unsupported", "nothing can be turned by this profile")
        pieces = self.profiles.placed(profile, pieces)
        radius = self.profiles.optional_length(entity, "radius") or 0.0
        return Shape(contour=_in_plane(profile, pieces, radius), inside=self._inside(entity))

    def _inside(self, entity: Entity) -> bool:
        """Tell whether the material lies outside of the profile."""
        side = entity.ref("material_side")
        return side is not None and self.profiles.curves.placements.direction(side, entity.id)[0] > 0.5

    def _groove(self, entity: Entity) -> Shape:
        """Return a groove round the work: its section open outwards, the width along Z, the bottom at `radius`."""
        profile = entity.entity("sweep")
        kind = profile.keyword
        if kind == "GENERAL_PROFILE":
            return self._revolved(entity, "sweep")
        place = self.profiles.curves.placements.optional(profile, "placement")
        x, z = (0.0, 0.0) if place is None else (float(place[0, 3]), float(place[2, 3]))
        x += self.profiles.optional_length(entity, "radius") or 0.0
        if kind not in ("SQUARE_U_PROFILE", "ROUNDED_U_PROFILE", "VEE_PROFILE"):
            raise profile.fault("stepnc-unsupported", "a groove of this section cannot be turned")
        section = self.profiles.slot_profile(profile)
        if kind == "VEE_PROFILE":
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
        return Shape(contour=[first, *bottom, last], width=2 * abs(high[2] - z), inside=self._inside(entity))


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


def _in_plane(profile: Entity, pieces: list[Piece], radius: float) -> list[Piece]:
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


def end_to_end(owner: Entity, profiles: list[list[Piece]]) -> list[Piece]:
    """Return turned profiles as one, from the highest Z down; a shoulder between two of them is joined by a line.

    Raises:
        Skip: where one does not begin at the Z where another ends.
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
            text = f"its features are {abs(begin[2] - end[2]):g} mm apart along the axis, at Z {end[2]:g}"
            raise owner.fault("stepnc-geometry", text)
        if np.abs(begin - end).max() > 1e-6:
            out.append(Polyline(np.stack([end, begin])))
        out += profile
    return out


def _bulge(piece: Piece) -> np.ndarray:
    """Return a point of a piece that does not lie on the line between its ends, if it is curved."""
    if isinstance(piece, Arc):
        return np.asarray(piece.points(np.array([0.5]))[0])
    points = piece.points if isinstance(piece, Polyline) else piece.control
    return np.asarray(points[len(points) // 2])

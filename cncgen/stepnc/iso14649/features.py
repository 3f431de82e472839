"""The manufacturing features of ISO 14649-10 as records."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.geometry.curves import CurveReader
from cncgen.stepnc.geometry.frames import Matrix, identity
from cncgen.stepnc.geometry.pieces import Piece
from cncgen.stepnc.iso14649.patterns import Patterns
from cncgen.stepnc.iso14649.profiles import Profiles
from cncgen.stepnc.iso14649.stock import RawPieces
from cncgen.stepnc.iso14649.technology import LEAST_RADIANS
from cncgen.stepnc.iso14649.turned_profiles import TurnedProfiles
from cncgen.stepnc.model import Boss, Feature, Shape
from cncgen.stepnc.schema.tables import positions
from cncgen.units import DEGREE

_BOTTOMS = {
    "THROUGH_BOTTOM_CONDITION": "through",
    "THROUGH_POCKET_BOTTOM_CONDITION": "through",
    "FLAT_HOLE_BOTTOM": "flat",
    "PLANAR_POCKET_BOTTOM_CONDITION": "flat",
    "CONICAL_HOLE_BOTTOM": "conical",
    "SPHERICAL_HOLE_BOTTOM": "spherical",
    "FLAT_WITH_RADIUS_HOLE_BOTTOM": "flat with radius",
    "RADIUSED_POCKET_BOTTOM_CONDITION": "radiused",
}
#: No bottom of a hole is sharper, degrees: such an angle is that of the edge from the plane.
SHARPEST = 45.0
#: Entities that are machined as another feature is.
_KINDS = {
    "GENERAL_OUTSIDE_PROFILE": "general outside profile",
    "CIRCULAR_CLOSED_SHAPE_PROFILE": "general outside profile",
    "RECTANGULAR_CLOSED_SHAPE_PROFILE": "general outside profile",
    "GENERAL_SHAPE_PROFILE": "general outside profile",
    "CATALOGUE_THREAD": "thread",
    "DEFINED_THREAD": "thread",
}


#: Features with toolpaths that depend on where the raw piece ends.
_WITH_STOCK = ("STEP", "BOSS", "SLOT", "PLANAR_FACE", "general outside profile")


class Features:
    """Reads features; their shapes when they are asked for."""

    def __init__(self, entities: Entities, curves: CurveReader) -> None:
        self.entities = entities
        self.curves = curves
        self.placements = curves.placements
        self.profiles = Profiles(entities, curves)
        self.patterns = Patterns(entities, self)
        self.stock = RawPieces(entities, curves.placements)
        self._shapes: dict[str, Callable[[Entity], Shape]] = {
            "PLANAR_FACE": self._planar_face,
            "ROUND_HOLE": self._round_hole,
            "CLOSED_POCKET": self._closed_pocket,
            "OPEN_POCKET": self._open_pocket,
            "SLOT": self._slot,
            "STEP": self._step,
            "GENERAL_OUTSIDE_PROFILE": self._outside_profile,
            "CIRCULAR_CLOSED_SHAPE_PROFILE": self._outside_profile,
            "RECTANGULAR_CLOSED_SHAPE_PROFILE": self._outside_profile,
            "GENERAL_SHAPE_PROFILE": self._outside_profile,
            "CATALOGUE_THREAD": self._thread,
            "DEFINED_THREAD": self._thread,
            "THREAD": self._thread,
            "BOSS": self._boss,
            "COUNTERBORE_HOLE": self._compound,
            "COUNTERSUNK_HOLE": self._compound,
            "COMPOUND_FEATURE": self._compound,
            "CIRCULAR_PATTERN": self.patterns.circular,
            "RECTANGULAR_PATTERN": self.patterns.rectangular,
            "GENERAL_PATTERN": self.patterns.general,
        } | TurnedProfiles(entities, self.profiles).shapes
        self.kinds = (*self._shapes, "TOOLPATH_FEATURE", "REGION_PROJECTION")

    def read(self, ident: int) -> Feature:
        """Return a feature.

        Raises:
            Skip: where it has a fault.
        """
        entity = self.entities.get(ident)
        placement = self.placements.optional(entity, "feature_placement")
        kind = _KINDS.get(entity.keyword, entity.keyword.lower().replace("_", " "))
        place = identity() if placement is None else placement
        return Feature(ident, entity.text("its_id"), kind, place, lambda: self._shape(entity, place))

    def _shape(self, entity: Entity, placement: Matrix) -> Shape:
        if entity.keyword not in self._shapes:
            text = "no toolpath can be made for this feature; give explicit toolpaths"
            raise entity.fault("stepnc-unsupported", text)
        self.profiles.feature_placement = placement
        shape = self._shapes[entity.keyword](entity)
        if _KINDS.get(entity.keyword, entity.keyword) in _WITH_STOCK:
            return replace(shape, stock=self.stock.outline(entity, placement))
        return shape

    def depth(self, entity: Entity) -> float | None:
        """Return how far the depth plane lies below the feature's origin, mm.

        Raises:
            Skip: It is not across the feature's axis.
        """
        plane = self.placements.plane(entity.ref("depth"), entity.id)
        if plane is None:
            return None
        if abs(abs(plane[2, 2]) - 1.0) > 1e-9:
            raise entity.fault("stepnc-unsupported", "the depth plane is not across the feature's axis")
        return float(-plane[2, 3])

    def _bottom(self, entity: Entity) -> tuple[str, Entity | None]:
        """Return the kind of a hole's or pocket's bottom, and its entity."""
        ident = entity.ref("bottom_condition")
        if ident is None:
            return "", None
        bottom = self.entities.get(ident, owner=entity.id)
        if bottom.keyword not in _BOTTOMS:
            raise bottom.fault("stepnc-unsupported", "this kind of bottom cannot be made")
        return _BOTTOMS[bottom.keyword], bottom

    def _planar_face(self, entity: Entity) -> Shape:
        boundary = entity.ref("face_boundary")
        course, outline = self.profiles.face_sweep(entity)
        if boundary is not None:
            outline = self.profiles.closed(boundary, entity)
        return Shape(self.depth(entity), outline=outline, course=course, bosses=self._bosses(entity))

    def _bosses(self, entity: Entity) -> tuple[Boss, ...]:
        out = []
        for ident in entity.refs("its_boss"):
            boss = self.entities.get(ident, "BOSS", owner=entity.id)
            outline = self.profiles.closed(boss.entity("its_boundary").id, boss)
            place = self.placements.optional(boss, "feature_placement")
            slope = boss.number("slope", 0.0) * self.curves.angle
            if place is None:
                out.append(Boss(outline, slope))
                continue
            if abs(place[2, 2] - 1.0) > 1e-9:
                raise boss.fault("stepnc-unsupported", "the boss does not stand along the feature's axis")
            flat = place.copy()
            flat[2, 3] = 0.0
            out.append(Boss([p.moved(flat) for p in outline], slope, min(float(place[2, 3]), 0.0)))
        return tuple(out)

    def _round_hole(self, entity: Entity) -> Shape:
        bottom, end = self._bottom(entity)
        diameter, depth = self.profiles.length(entity, "diameter"), self.depth(entity)
        angle = end.optional("tip_angle") if end is not None else None
        if end is not None and angle is not None and LEAST_RADIANS <= angle < math.pi:
            meant = angle / DEGREE
            if meant < SHARPEST:
                meant = 180.0 - 2 * meant
            text = f"a hole's bottom of {angle:g}° is a needle; it is taken as {meant:.4g}°"
            text += (
                ", in radians"
                if meant == angle / DEGREE
                else ", in radians from the plane, as of a drill's edge"
            )
            end.warn("stepnc-angle", text)
            angle = meant
        return Shape(
            depth,
            diameter=diameter,
            bottom=bottom,
            bottom_angle=None if angle is None else angle * self.curves.angle,
            bottom_radius=self.profiles.optional_length(end, "radius") if end is not None else None,
            floor_radius=self.profiles.optional_length(end, "corner_radius") if end is not None else None,
            slope=self._taper(entity, diameter, depth),
        )

    def _taper(self, entity: Entity, diameter: float, depth: float | None) -> float:
        """Return the angle between a hole's wall and its axis, rad."""
        ident = entity.ref("change_in_diameter")
        if ident is None:
            return 0.0
        taper = self.entities.get(ident, "DIAMETER_TAPER", "ANGLE_TAPER", owner=entity.id)
        if taper.keyword == "ANGLE_TAPER":
            return taper.number("angle") * self.curves.angle
        if not depth:
            raise entity.fault("stepnc-missing", "a tapered hole needs a depth")
        return math.atan((diameter - self.profiles.length(taper, "final_diameter")) / 2 / depth)

    def _thread(self, entity: Entity) -> Shape:
        """Return the hole that a thread is cut into, as deep as the thread."""
        holes = entity.refs("applied_shape")
        outer = entity.flag("inner_or_outer_thread") is False
        if len(holes) != 1:
            raise entity.fault("stepnc-unsupported", "a thread is made on one hole or diameter")
        if outer:
            return self._outer_thread(entity, holes[0])
        hole = self._round_hole(self.entities.get(holes[0], "ROUND_HOLE", owner=entity.id))
        major = entity.optional("major_diameter")
        return replace(
            hole,
            depth=self.depth(entity) or hole.depth,
            thread=None if major is None else major * self.placements.scale,
            pitch=self._pitch(entity),
        )

    def _outer_thread(self, entity: Entity, ident: int) -> Shape:
        """Return the profile of the diameter that a thread is cut into, in the thread's frame."""
        base = self.read(self.entities.get(ident, "OUTER_DIAMETER", owner=entity.id).id)
        own = self.placements.optional(entity, "feature_placement")
        outside = np.asarray(np.linalg.inv(identity() if own is None else own), np.float64)
        place = elementary.product(outside, base.placement)
        major, minor = entity.optional("major_diameter"), entity.optional("minor_diameter")
        area = self.entities.optional(entity.ref("partial_profile"))
        return Shape(
            contour=[p.moved(place) for p in base.shape().contour or ()],
            thread=None if major is None else major * self.placements.scale,
            diameter=None if minor is None else minor * self.placements.scale,
            pitch=self._pitch(entity),
            width=None if area is None else area.optional("effective_length"),
        )

    def _pitch(self, thread: Entity) -> float | None:
        """Return the pitch of a thread by the number of its threads a mm (an inch), negative if left-handed; None without one."""
        given = self.entities.optional(thread.ref("number_of_threads"))
        if given is None:
            return None
        count, unit = given.number("its_parameter_value"), given.text("its_parameter_unit").strip().lower()
        if not count > 0:
            raise given.fault("stepnc-geometry", f"{count:g} threads")
        pitch = (25.4 if "in" in unit or "tpi" in unit or '"' in unit else 1.0) / count
        hand = self.entities.optional(thread.ref("thread_hand"))
        words = [v.lower() for v in hand.parameters if isinstance(v, str)] if hand is not None else []
        return -pitch if any("left" in w for w in words) else pitch

    def _pocket(self, entity: Entity, outline: list[Piece], open_sides: tuple[int, ...] = ()) -> Shape:
        slope = entity.number("slope", 0.0) * self.curves.angle
        bottom, _ = self._bottom(entity)
        return Shape(
            self.depth(entity),
            bottom=bottom,
            outline=outline,
            open_sides=open_sides,
            bosses=self._bosses(entity),
            slope=slope,
            corner_radius=self.profiles.optional_length(entity, "orthogonal_radius"),
            floor_radius=self.profiles.optional_length(entity, "planar_radius"),
        )

    def _closed_pocket(self, entity: Entity) -> Shape:
        return self._pocket(entity, self.profiles.closed(entity.entity("feature_boundary").id, entity))

    def _open_pocket(self, entity: Entity) -> Shape:
        """Return an open pocket: the wall, and the straight line from its end back to its start, which is open."""
        boundary = entity.entity("open_boundary")
        outline, open_sides = self.profiles.open_outline(boundary, entity.ref("wall_boundary"), entity)
        return self._pocket(entity, outline, open_sides)

    def _slot(self, entity: Entity) -> Shape:
        course = self.profiles.path(entity.entity("course_of_travel"))
        profile = self.profiles.slot_profile(entity.entity("swept_shape"))
        ends = tuple(
            self.entities.keyword(i).lower().removesuffix("_slot_end_type")
            for i in entity.refs("end_conditions")
        )
        return Shape(self.depth(entity), course=course, ends=ends, **profile)

    def _step(self, entity: Entity) -> Shape:
        course = self.profiles.path(entity.entity("open_boundary"))
        wall = entity.ref("wall_boundary")
        profile = None if wall is None else self.entities.get(wall, "VEE_PROFILE", owner=entity.id)
        course, slope = self.profiles.step_wall(course, profile)
        return Shape(self.depth(entity), course=course, slope=slope, bosses=self._bosses(entity))

    def _outside_profile(self, entity: Entity) -> Shape:
        names = ("feature_boundary", "closed_boundary", "profile_boundary")
        boundary = next(n for n in names if n in positions(entity.keyword, True))
        outline = self.profiles.closed(entity.entity(boundary).id, entity)
        depth = self.depth(entity)
        if depth is None and entity.ref("profile_swept_shape") is not None:
            sweep = self.profiles.path(entity.entity("profile_swept_shape"))
            depth = abs(float((sweep[-1].end - sweep[0].start)[2]))
        return Shape(depth, outline=outline)

    def _boss(self, entity: Entity) -> Shape:
        outline = self.profiles.closed(entity.entity("its_boundary").id, entity)
        return Shape(
            self.depth(entity), outline=outline, slope=entity.number("slope", 0.0) * self.curves.angle
        )

    def _compound(self, entity: Entity) -> Shape:
        return Shape(elements=tuple(self.read(i) for i in entity.refs("elements")))

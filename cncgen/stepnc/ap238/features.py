"""Features of the AIM: placement, depth and profiles, in the convention of ISO 14649 (top of the feature, Z out).

ISO 10303 places a feature where its sweep begins: holes, pockets and outside profiles at the bottom with Z out of the
material (at the top with Z into it where the bottom is at the path's end); slots and steps at the bottom with Z along the
path and Y out of the material (ISO 10303-238, 5.2.2.3).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc import turned_shapes
from cncgen.stepnc.ap238.graph import Graph
from cncgen.stepnc.ap238.groups import Groups
from cncgen.stepnc.ap238.profiles import CLOSED, OPEN, Profiles, component_of, find, path_of, profile_of
from cncgen.stepnc.ap238.shapes import Component, Shapes, flipped
from cncgen.stepnc.ap238.turned_profiles import ENTITIES as TURNED
from cncgen.stepnc.ap238.turned_profiles import TurnedProfiles
from cncgen.stepnc.ap238.units import Units
from cncgen.stepnc.entities import Entity
from cncgen.stepnc.geometry import profile_shapes
from cncgen.stepnc.geometry.frames import Matrix, identity, translation
from cncgen.stepnc.geometry.pieces import Piece
from cncgen.stepnc.geometry.solids import Solid
from cncgen.stepnc.model import Boss, Feature, Shape

_KINDS = {
    "ROUND_HOLE": "round hole",
    "POCKET": "closed pocket",
    "FLAT_FACE": "planar face",
    "SLOT": "slot",
    "STEP": "step",
    "OUTSIDE_PROFILE": "general outside profile",
    "BOSS": "boss",
    "CIRCULAR_PATTERN": "circular pattern",
    "RECTANGULAR_PATTERN": "rectangular pattern",
    "FEATURE_PATTERN": "general pattern",
    "COMPOSITE_HOLE": "compound feature",
    "COMPOUND_FEATURE": "compound feature",
}
_GROUPS = (
    "CIRCULAR_PATTERN",
    "RECTANGULAR_PATTERN",
    "FEATURE_PATTERN",
    "COMPOSITE_HOLE",
    "COMPOUND_FEATURE",
)
#: Features within a feature that are looked at for one that leans.
MAX_ASKED = 500
_DEPTHS = ("hole depth", "pocket depth", "depth", "profile swept shape", "boss height", "course of travel")
_BOUNDARIES = ("closed boundary", "feature boundary", "boundary", "enclosed boundary")
_Y = np.array([0.0, 1.0, 0.0])


class Features:
    """Reads the features of workingsteps."""

    def __init__(self, graph: Graph, units: Units) -> None:
        self.graph = graph
        self.entities = graph.entities
        self.shapes = Shapes(graph, units)
        self.profiles = Profiles(self.shapes)
        self.groups = Groups(self.shapes, self.read)
        self.turned = TurnedProfiles(self.shapes, self.profiles)

    def of_workingstep(self, step: int, raw: Solid | None = None) -> Feature | None:
        """Return the feature that a workingstep machines, None where it names none; of several turned ones all as one.

        Args:
            step: The workingstep.
            raw: The raw piece in the workpiece's frame, or None.

        Raises:
            Skip: where it has a fault.
        """
        found = self._of_step(step)
        return turned_shapes.standing(self.entities, [self.read(i) for i in found], raw) if found else None

    def _of_step(self, step: int) -> list[int]:
        return list(
            dict.fromkeys(
                ident
                for relation in ("MACHINING_FEATURE_RELATIONSHIP", "MACHINING_FEATURE_SEQUENCE_RELATIONSHIP")
                for process in self.graph.related(step, relation)
                for action in self.graph.index("PROPERTY_PROCESS", 0).of(process.id)
                for link in self.graph.index("PROCESS_PROPERTY_ASSOCIATION", 0).of(action)
                if (ident := self.entities.get(link).ref("property_or_shape")) is not None
            )
        )

    def workpiece(self, step: int) -> int | None:
        """Return the workpiece whose shape the features of a workingstep are of; None where that is not said.

        Raises:
            Skip: where one has a fault.
        """
        for ident in self._of_step(step):
            aspect = self.entities.get(ident).ref("of_shape")
            shape = None if aspect is None else self.entities.get(aspect, owner=ident)
            if shape is not None and shape.keyword == "PRODUCT_DEFINITION_SHAPE":
                return shape.ref("definition")
        return None

    def read(self, ident: int) -> Feature:
        """Return a feature.

        Raises:
            Skip: where it has a fault.
        """
        entity = self.entities.get(ident)
        kind = next((k for k in (*_KINDS, *TURNED) if entity.instance.part(k)), "")
        place = self.shapes.frame(ident, "orientation")
        placement = identity() if place is None else place
        label = self._label(entity)
        depth, move = None, identity()
        if kind in ("SLOT", "STEP"):
            depth, move = self._swept(ident, entity, kind)
        elif kind in _KINDS and kind not in _GROUPS:
            depth, move = self._depth(ident, kind, placement)
        inside = np.asarray(np.linalg.inv(move), np.float64)
        name = self.turned.kind(entity, kind) if kind in TURNED else _KINDS.get(kind, kind)
        if kind == "POCKET" and self._is_open(ident):
            name = "open pocket"
        if kind == "COMPOSITE_HOLE":
            name = self.groups.hole_kind(entity)

        def shape() -> Shape:
            if kind in TURNED:
                return self._turned(entity, name, placement)
            self.profiles.feature_placement = placement
            return self._shape(entity, kind, depth, inside)

        return Feature(ident, label, name, elementary.product(placement, move), shape)

    def _turned(self, entity: Entity, kind: str, placement: Matrix) -> Shape:
        ident = self.turned.base_of(entity) if kind == "thread" else None
        base = None if ident is None else self.read(ident)
        shape = None if base is None else base.shape()
        self.profiles.feature_placement = placement
        place = placement if base is None else base.placement
        return self.turned.shape(entity, kind, placement, shape, place)

    def _label(self, entity: Entity) -> str:
        """Return the name of a feature: as a characterized object, or as a shape aspect."""
        for keyword in ("CHARACTERIZED_OBJECT", "SHAPE_ASPECT", entity.instance.parts[0].keyword):
            part = entity.instance.part(keyword)
            if part is not None and part.parameters and part.parameters[0]:
                return str(part.parameters[0])
        return ""

    def _is_open(self, ident: int) -> bool:
        kinds = {c.entity.keyword for c in self.shapes.components(ident)}
        return not kinds & set(CLOSED) and bool(kinds & set(OPEN))

    # Where a feature stands, and how deep it is

    def _depth(self, ident: int, kind: str, placement: Matrix) -> tuple[float | None, Matrix]:
        """Return the depth, and the way from the placement to that of ISO 14649.

        A plane 'maximum feature limit' with Z below the placement means that it is there already; not so where the
        bottom is at the path's end and the placement's Z goes down: files have both the plane of ISO 14649 and the placement
        of ISO 10303.
        """
        limit = self.shapes.limit(ident)
        components = self.shapes.components(ident)
        if limit is not None and limit < 0:
            into = self._bottom_at_end(components) and placement[2, 2] < 1e-9
            return -limit, flipped() if into else identity()
        depth = abs(limit) if limit is not None else self._sweep(ident, kind, components)
        if depth is None:
            return None, identity()
        if self._bottom_at_end(components):
            return depth, flipped()
        return depth, translation(0.0, 0.0, depth)

    def _sweep(self, ident: int, kind: str, components: list[Component]) -> float | None:
        """Return how far a feature's profile is swept, mm, None where the file does not say."""
        if kind == "FLAT_FACE":
            return self.shapes.measures(ident).get("removal depth")
        path = find(components, *_DEPTHS)
        return self.profiles.length(path)

    def _bottom_at_end(self, components: list[Component]) -> bool:
        """Tell whether the bottom is at the end of the path: the placement is at the top, Z into the material."""
        for component in components:
            if "BOTTOM" in component.entity.keyword:
                words = (component.role, *self.shapes.words(component.entity.id))
                return any(w.endswith("depth end") for w in words)
        return False

    def _swept(self, ident: int, entity: Entity, kind: str) -> tuple[float | None, Matrix]:
        """Return the depth of a slot or step, and the way from its placement to that of ISO 14649.

        ISO 14649 has it at the top, the path along Y: Z becomes -Y and Y becomes Z, and the way goes to the other end
        of the path. A plane 'maximum feature limit' below the placement means that it is there already.
        """
        limit = self.shapes.limit(ident)
        if limit is not None and limit < 0:
            return -limit, identity()
        components = self.shapes.components(ident)
        profile, length = profile_of(components, OPEN), self.profiles.length(path_of(components))
        size = self.shapes.measures(profile.id) if profile is not None else {}
        depth = size.get("depth", size.get("profile depth"))
        if kind == "STEP" and "second side length" in size:
            depth = size["second side length"] * math.sin(size.get("profile angle", math.pi / 2))
        if length is None or depth is None:
            raise entity.fault(
                "stepnc-missing", f"the {kind.lower()} has no length of its path or no depth of its profile"
            )
        return depth, np.array([[1, 0, 0, 0], [0, 0, 1, depth], [0, -1, 0, length], [0, 0, 0, 1.0]])

    # Shapes

    def _shape(self, entity: Entity, kind: str, depth: float | None, inside: Matrix) -> Shape:
        """Return the shape of a feature; `inside` leads from its own placement to that of ISO 14649."""
        if kind not in _KINDS:
            text = "no toolpath can be made for this feature; give explicit toolpaths"
            raise entity.fault("stepnc-unsupported", text)
        components = self.shapes.components(entity.id)
        if kind in _GROUPS:
            return self.groups.shape(entity, kind)
        if kind == "ROUND_HOLE":
            return self._hole(entity, depth, components)
        if kind == "FLAT_FACE":
            return replace(self._face(entity, depth, components), bosses=self._bosses(entity, inside))
        if kind == "SLOT":
            return self._slot(entity, depth, components)
        if kind == "STEP":
            return self._step(entity, depth, components)
        turned = inside.copy()
        turned[:3, 3] = 0.0  # outlines are those of the top, whichever end of the path they are given at
        if kind == "POCKET":
            shape = replace(self._pocket(entity, depth, components), bosses=self._bosses(entity, inside))
        else:
            taper = self._taper(components, None, depth)
            shape = Shape(depth, outline=self._boundary(entity, components), slope=abs(taper))
        return replace(shape, outline=[p.moved(turned) for p in shape.outline or []])

    def _boundary(self, entity: Entity, components: list[Component]) -> list[Piece]:
        """Return the closed boundary of a feature."""
        profile = profile_of(components, CLOSED) or find(components, *_BOUNDARIES)
        if profile is None:
            raise entity.fault("stepnc-missing", "the feature has no closed boundary")
        return self.profiles.closed(profile)

    def _bottom(self, components: list[Component]) -> tuple[str, dict[str, float]]:
        """Return the kind of a hole's or pocket's bottom, and its measures."""
        bottom = component_of(components, "bottom", ("HOLE_BOTTOM", "POCKET_BOTTOM"))
        if bottom is None:
            return "", {}
        kind = bottom.text("description").strip().lower()
        return {"planar": "flat"}.get(kind, kind), self.shapes.measures(bottom.id)

    def _taper(self, components: list[Component], diameter: float | None, depth: float | None) -> float:
        """Return the angle between the wall and the axis, rad."""
        taper = component_of(components, "taper", ("TAPER",))
        sizes = {} if taper is None else self.shapes.measures(taper.id)
        if "taper angle" in sizes:
            return sizes["taper angle"]
        if "final diameter" in sizes and diameter is not None and depth:
            return math.atan((diameter - sizes["final diameter"]) / 2 / depth)
        return 0.0

    def _hole(self, entity: Entity, depth: float | None, components: list[Component]) -> Shape:
        profile = find(components, "diameter") or profile_of(components, ("CIRCULAR_CLOSED_PROFILE",))
        diameter = self.shapes.measures(profile.id).get("diameter") if profile else None
        bottom, sizes = self._bottom(components)
        return Shape(
            depth,
            diameter=diameter,
            bottom=bottom,
            bottom_angle=sizes.get("tip angle"),
            bottom_radius=sizes.get("radius"),
            floor_radius=sizes.get("corner radius"),
            slope=self._taper(components, diameter, depth),
        )

    def _pocket(self, entity: Entity, depth: float | None, components: list[Component]) -> Shape:
        own = self.shapes.measures(entity.id)
        bottom, sizes = self._bottom(components)
        open_sides: tuple[int, ...] = ()
        if self._is_open(entity.id):
            outline, open_sides = self._open_outline(entity, components)
        else:
            outline = self._boundary(entity, components)
        return Shape(
            depth,
            bottom=bottom,
            outline=outline,
            open_sides=open_sides,
            slope=own.get("slope", own.get("draft angle", abs(self._taper(components, None, depth)))),
            corner_radius=own.get("orthogonal fillet radius", own.get("orthogonal radius")),
            floor_radius=own.get("planar radius", sizes.get("radius")),
        )

    def _open_outline(
        self, entity: Entity, components: list[Component]
    ) -> tuple[list[Piece], tuple[int, ...]]:
        wall = find(components, "wall boundary", "wall boundary usage")
        others = [c for c in components if wall is None or c.entity.id != wall.id]
        boundary = component_of(others, "boundary", OPEN) or wall
        if boundary is None:
            raise entity.fault("stepnc-missing", "the pocket has no boundary")
        if wall is None or wall.id == boundary.id:
            return profile_shapes.closed_outline(boundary, self.profiles.open(boundary))
        return profile_shapes.closed_outline(boundary, self.profiles.open(wall), self.profiles.open(boundary))

    def _bosses(self, entity: Entity, inside: Matrix) -> tuple[Boss, ...]:
        """Return the bosses within a pocket or face, placed within its own placement."""
        out = []
        for _, usage, ident in self.shapes.members(entity.id):
            if usage != "uncut volume" or self.entities.get(ident).instance.part("BOSS") is None:
                continue
            feature = self.read(ident)
            shape, place = feature.shape(), elementary.product(inside, feature.placement)
            if abs(place[2, 2] - 1.0) > 1e-9:
                text = "the boss does not stand along the feature's axis"
                raise self.entities.get(ident).fault("stepnc-unsupported", text)
            flat = place.copy()
            flat[2, 3] = 0.0
            outline = [p.moved(flat) for p in shape.outline or []]
            out.append(Boss(outline, shape.slope, min(float(place[2, 3]), 0.0)))
        return tuple(out)

    def _step(self, entity: Entity, depth: float | None, components: list[Component]) -> Shape:
        """Return a step whose path goes along Y from the origin."""
        profile, length = profile_of(components, OPEN), self.profiles.length(path_of(components))
        if length is None or profile is None:
            text = "the step has no straight path with a distance, or no profile"
            raise entity.fault("stepnc-unsupported", text)
        size = self.shapes.measures(profile.id)
        if abs(size.get("tilt angle", 0.0)) > 1e-9 or "first side length" not in size:
            text = "the step needs a profile with a level first side and its length"
            raise profile.fault("stepnc-unsupported", text)
        slope = size.get("profile angle", math.pi / 2) - math.pi / 2
        slope = slope if abs(slope) > 1e-9 else 0.0
        course: list[Piece] = [profile_shapes.linear_path(length * _Y)]
        return Shape(depth, course=course, width=size["first side length"], slope=slope)

    def _slot(self, entity: Entity, depth: float | None, components: list[Component]) -> Shape:
        """Return a slot along its path, which goes along Y where it is straight and says no direction."""
        profile, path = profile_of(components, OPEN), path_of(components)
        if path is None or profile is None:
            raise entity.fault("stepnc-missing", "the slot has no path or no profile")
        placed_at_top = (self.shapes.limit(entity.id) or 0.0) < 0
        if not placed_at_top and self.profiles.length(path) is None:
            raise path.fault("stepnc-unsupported", "a slot placed at its bottom needs a straight path")
        length = self.profiles.length(path)
        course = (
            self.profiles.path(path, _Y)
            if placed_at_top
            else [profile_shapes.linear_path((length or 0) * _Y)]
        )
        ends = self._slot_ends(components, reverse=not placed_at_top)
        return Shape(depth, course=list(course), ends=ends, **self.profiles.across(profile))

    def _slot_ends(self, components: list[Component], reverse: bool) -> tuple[str, ...]:
        """Return the ends of a slot, at the begin and at the end of its path.

        Args:
            components: Of the slot.
            reverse: Whether the course made here goes against the slot's own path.
        """
        ends = {c.role: c.entity for c in components if "SLOT_END" in c.entity.keyword}
        first, last = ends.get("course of travel start"), ends.get("course of travel end")
        given = [first, last] if first is not None and last is not None else list(ends.values())
        if reverse and first is not None and last is not None:
            given = given[::-1]
        return tuple(e.text("description").strip().lower() for e in given if e is not None)

    def _face(self, entity: Entity, depth: float | None, components: list[Component]) -> Shape:
        """Return a face: the area that its profile sweeps along the course of travel, or its closed boundary."""
        course, boundary = find(components, "course of travel"), find(components, "removal boundary")
        if course is None or boundary is None:
            raise entity.fault("stepnc-missing", "the face has no course of travel or no removal boundary")
        size = self.shapes.measures(boundary.id)
        width = size.get("profile length", size.get("length"))
        distance = self.profiles.length(course)
        if width is None or distance is None:
            raise entity.fault("stepnc-missing", "the face has no length or no width")
        path = self.profiles.path(course, _Y)
        enclosed = profile_of(components, CLOSED)
        profile = profile_shapes.linear_path(np.array([width, 0.0, 0.0]))
        outline: list[Piece] = [profile_shapes.swept(entity, profile, path)]
        if enclosed is not None:
            outline = self.profiles.closed(enclosed)
        return Shape(depth, outline=outline, course=path)

    def tilted(self, feature: Feature) -> bool:
        """Tell whether the Z of a feature, or of one that belongs to it, leaves that of the part.

        Of features within features no more are asked than toolpaths are made of.

        Raises:
            Skip: where one has a fault.
        """
        waiting, asked = [feature], 0
        while waiting and asked < MAX_ASKED:
            one, asked = waiting.pop(), asked + 1
            if abs(one.placement[2, 2] - 1.0) > 1e-12:
                return True
            if one.kind in ("circular pattern", "rectangular pattern"):
                waiting += one.shape().elements[:1]  # the others lean as it does
            elif one.kind in ("general pattern", "compound feature") or one.kind.startswith("counter"):
                waiting += one.shape().elements
        return False

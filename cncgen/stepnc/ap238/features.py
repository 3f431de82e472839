"""Features of the AIM: placement, depth and profiles, in the convention of ISO 14649 (top of the feature, Z out).

ISO 10303 places a feature where its sweep begins: holes, pockets and outside profiles at the bottom with Z out of the
material; slots and steps at the bottom with Z along the path and Y out of the material (ISO 10303-238, 5.2.2.3).
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cncgen.stepnc.ap238.graph import Graph, Item
from cncgen.stepnc.ap238.technology import described
from cncgen.stepnc.ap238.units import Units
from cncgen.stepnc.entities import Entity, Skip
from cncgen.stepnc.geometry.curves import Curves
from cncgen.stepnc.geometry.frames import Matrix, Placements, identity, translation
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline
from cncgen.stepnc.model import Feature, Shape

_KINDS = {
    "ROUND_HOLE": "round hole",
    "POCKET": "closed pocket",
    "FLAT_FACE": "planar face",
    "SLOT": "slot",
    "STEP": "step",
    "OUTSIDE_PROFILE": "general outside profile",
    "BOSS": "boss",
}
_DEPTHS = ("hole depth", "pocket depth", "depth", "course of travel", "removal depth")


class Features:
    """Reads the features of workingsteps."""

    def __init__(self, graph: Graph, units: Units) -> None:
        self.graph = graph
        self.entities = graph.entities
        self.units = units

    def of_workingstep(self, step: int) -> Feature | None:
        """Return the feature that a workingstep machines, None where it names none.

        Raises:
            Skip: where it has a fault.
        """
        for process in self.graph.related(step, "MACHINING_FEATURE_RELATIONSHIP"):
            for action in self.graph.index("PROPERTY_PROCESS", 0).of(process.id):
                for link in self.graph.index("PROCESS_PROPERTY_ASSOCIATION", 0).of(action):
                    ident = self.entities.get(link).ref("property_or_shape")
                    if ident is not None:
                        return self._feature(ident)
        return None

    def _feature(self, ident: int) -> Feature:
        entity = self.entities.get(ident)
        kind = next((k for k in _KINDS if entity.instance.part(k)), "")
        items = self._shape_items(ident)
        placement = identity()
        for item in items:
            if item.name == "orientation" and item.entity.keyword == "AXIS2_PLACEMENT_3D":
                placement = self._placements(item).placement(item.entity.id)
        name = entity.instance.part("CHARACTERIZED_OBJECT") or entity.instance.parts[0]
        label = str(name.parameters[0]) if name.parameters else ""
        if kind in ("SLOT", "STEP"):
            depth, move = self._swept(ident, entity, kind)
            placement = placement @ move
        else:
            depth, at_top = self._depth(ident, entity)
            if not at_top and depth is not None:
                placement = placement @ translation(0.0, 0.0, depth)
        return Feature(
            ident, label, _KINDS.get(kind, kind), placement, lambda: self._shape(entity, kind, depth)
        )

    def _placements(self, item: Item) -> Placements:
        return Placements(self.entities, self.units.context(item.context)[0])

    # The graph from a feature or profile to its values

    def _shape_items(self, ident: int, name: str | None = None) -> list[Item]:
        """Return the items of the shape representations of a feature or shape aspect."""
        out: list[Item] = []
        owners = [ident]
        for keyword in ("PRODUCT_DEFINITION_SHAPE", "PROPERTY_DEFINITION"):
            owners += self.graph.index(keyword, 0).of(ident)
        for owner in owners:
            for keyword in ("SHAPE_DEFINITION_REPRESENTATION", "PROPERTY_DEFINITION_REPRESENTATION"):
                for link in self.graph.index(keyword, 0).of(owner):
                    representation = self.entities.get(link).ref("used_representation")
                    if representation is not None:
                        items = self.graph.items(representation)
                        out += [i for i in items if name is None or i.representation.strip().lower() == name]
        return out

    def _aspects(self, feature: int) -> list[Entity]:
        """Return the shape aspects of a feature's shape (its '… occurrence's)."""
        out = []
        for shape in self.graph.index("PRODUCT_DEFINITION_SHAPE", 0).of(feature):
            for aspect in self.graph.index("SHAPE_ASPECT", 0).of(shape):
                out.append(self.entities.get(aspect))
        return out

    def _components(self, feature: int) -> Iterator[tuple[str, Entity]]:
        """Yield the profiles and paths of a feature under the names of their relationships."""
        for aspect in self._aspects(feature):
            for keyword in ("SHAPE_DEFINING_RELATIONSHIP", "FEATURE_COMPONENT_RELATIONSHIP"):
                for relation in self.graph.index(keyword, 1).of(aspect.id):
                    entity = self.entities.get(relation, keyword)
                    yield entity.text("name").strip().lower(), entity.entity("relating_shape_aspect")

    def _measures(self, ident: int) -> dict[str, float]:
        out = {}
        for item in self._shape_items(ident):
            if described(item) or item.entity.keyword in ("AXIS2_PLACEMENT_3D", "PLANE", "DIRECTION"):
                continue
            try:
                measure = self.units.measure(item.entity)
            except Skip:
                continue
            if measure is not None:
                out[item.name or measure.name] = measure.value
        return out

    def _limit(self, ident: int) -> float | None:
        """Return the height of the plane 'maximum feature limit' in the feature's frame, None where there is none."""
        for item in self._shape_items(ident):
            if (
                item.representation.strip().lower() == "maximum feature limit"
                and item.entity.keyword == "PLANE"
            ):
                plane = self._placements(item).plane(item.entity.id)
                if plane is not None:
                    return float(plane[2, 3])
        return None

    def _depth(self, ident: int, entity: Entity) -> tuple[float | None, bool]:
        """Return the depth, and whether the placement is at the top (ISO 14649) or the bottom (ISO 10303).

        A plane 'maximum feature limit' with Z below the placement means the convention of ISO 14649.
        """
        limit = self._limit(ident)
        if limit is not None:
            return abs(limit), limit < 0
        for name, component in self._components(ident):
            if name in _DEPTHS:
                depth = self._length(component)
                if depth is not None and not (
                    name == "course of travel" and entity.instance.part("FLAT_FACE")
                ):
                    return depth, False
        return None, True

    def _length(self, path: Entity) -> float | None:
        measures = self._measures(path.id)
        return measures.get("distance", measures.get("length"))

    def _swept(self, ident: int, entity: Entity, kind: str) -> tuple[float | None, Matrix]:
        """Return the depth of a slot or step, and the way from its placement to that of ISO 14649.

        ISO 14649 has it at the top, the path along Y: Z becomes -Y and Y becomes Z, and the way goes to the other end
        of the path. A plane 'maximum feature limit' below the placement means that it is there already.
        """
        limit = self._limit(ident)
        if limit is not None and limit < 0:
            return -limit, identity()
        path, profile = self._path_and_profile(ident)
        length = self._length(path) if path is not None else None
        size = self._measures(profile.id) if profile is not None else {}
        depth = size.get("depth", size.get("profile depth"))
        if kind == "STEP" and "second side length" in size:
            depth = size["second side length"] * math.sin(size.get("profile angle", math.pi / 2))
        if length is None or depth is None:
            raise entity.fault(
                "stepnc-missing", f"the {kind.lower()} has no length of its path or no depth of its profile"
            )
        return depth, np.array([[1, 0, 0, 0], [0, 0, 1, depth], [0, -1, 0, length], [0, 0, 0, 1.0]])

    def _path_and_profile(self, ident: int) -> tuple[Entity | None, Entity | None]:
        """Return the path that a feature is swept along and the profile that is swept."""
        path = profile = None
        for name, component in self._components(ident):
            if name == "course of travel" or "PATH" in component.keyword:
                path = component
            elif "PROFILE" in component.keyword:
                profile = component
        return path, profile

    # Shapes

    def _shape(self, entity: Entity, kind: str, depth: float | None) -> Shape:
        if kind not in _KINDS:
            text = "no toolpath can be made for this feature; give explicit toolpaths"
            raise entity.fault("stepnc-unsupported", text)
        components = dict(self._components(entity.id))
        if kind == "ROUND_HOLE":
            profile = components.get("diameter")
            return Shape(depth, diameter=self._measures(profile.id).get("diameter") if profile else None)
        if kind == "FLAT_FACE":
            return self._face(entity, depth, components)
        if kind in ("SLOT", "STEP"):
            return self._along_path(entity, kind, depth)
        names = ("closed boundary", "feature boundary", "removal boundary", "boundary", "enclosed boundary")
        profile = next((components[n] for n in names if n in components), None)
        profile = profile or self._path_and_profile(entity.id)[1]
        if profile is None:
            raise entity.fault("stepnc-missing", f"the {_KINDS[kind]} has no boundary")
        own = self._measures(entity.id)
        return Shape(
            depth,
            outline=self._profile(profile),
            slope=own.get("slope", own.get("draft angle", 0.0)),
            corner_radius=own.get("orthogonal radius"),
            floor_radius=own.get("planar radius"),
        )

    def _along_path(self, entity: Entity, kind: str, depth: float | None) -> Shape:
        """Return a slot or step whose path goes along Y from the origin."""
        path, profile = self._path_and_profile(entity.id)
        length = self._length(path) if path is not None else None
        if length is None or profile is None:
            text = f"the {kind.lower()} has no straight path with a distance, or no profile"
            raise entity.fault("stepnc-unsupported", text)
        course: list[Piece] = [Polyline(np.array([[0.0, 0.0, 0.0], [0.0, length, 0.0]]))]
        size = self._measures(profile.id)
        if kind == "STEP":
            if abs(size.get("tilt angle", 0.0)) > 1e-9 or "first side length" not in size:
                text = "the step needs a profile with a level first side and its length"
                raise profile.fault("stepnc-unsupported", text)
            slope = size.get("profile angle", math.pi / 2) - math.pi / 2
            slope = slope if abs(slope) > 1e-9 else 0.0
            return Shape(depth, course=course, width=size["first side length"], slope=slope)
        width = size.get("width", size.get("profile width"))
        if profile.keyword not in ("SQUARE_U_PROFILE", "ROUNDED_U_PROFILE") or width is None:
            raise profile.fault("stepnc-unsupported", "a slot of this profile cannot be made")
        for name in ("first angle", "second angle"):
            angle = size.get(name, 0.0)
            if min(abs(angle), abs(angle - math.pi / 2)) > 1e-6:
                raise profile.fault(
                    "stepnc-unsupported", "walls of a slot that are not upright cannot be made"
                )
        floor = width / 2 if profile.keyword == "ROUNDED_U_PROFILE" else size.get("first radius")
        return Shape(depth, course=course, width=width, floor_radius=floor, ends=self._slot_ends(entity.id))

    def _slot_ends(self, ident: int) -> tuple[str, ...]:
        """Return what the ends of a slot are, from the descriptions of its SLOT_ENDs."""
        ends = [e for _, e in self._components(ident) if "SLOT_END" in e.keyword]
        return tuple(e.text("description").strip().lower() for e in ends)

    def _face(self, entity: Entity, depth: float | None, components: dict[str, Entity]) -> Shape:
        course, boundary = components.get("course of travel"), components.get("removal boundary")
        if course is None or boundary is None:
            raise entity.fault("stepnc-missing", "the face has no course of travel or no removal boundary")
        length = self._measures(course.id)
        width = self._measures(boundary.id).get("profile length", self._measures(boundary.id).get("length"))
        distance = length.get("distance", length.get("length"))
        if width is None or distance is None:
            raise entity.fault("stepnc-missing", "the face has no length or no width")
        path: list[Piece] = [Polyline(np.array([[0.0, 0.0, 0.0], [0.0, distance, 0.0]]))]
        corners = np.array(
            [[0, 0, 0], [width, 0, 0], [width, distance, 0], [0, distance, 0], [0, 0, 0]], float
        )
        return Shape(depth, outline=[Polyline(corners)], course=path, width=width)

    def _profile(self, entity: Entity) -> list[Piece]:
        values = self._measures(entity.id)
        if entity.keyword == "CIRCULAR_CLOSED_PROFILE" and "diameter" in values:
            start = np.array([values["diameter"] / 2, 0.0, 0.0])
            return [Arc(start, start, np.zeros(3), np.array([0.0, 0.0, 1.0]), 2 * math.pi)]
        if entity.keyword == "RECTANGULAR_CLOSED_PROFILE" and {"profile width", "profile length"} <= set(
            values
        ):
            half = np.array([values["profile length"], values["profile width"]]) / 2
            signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
            return [Polyline(np.column_stack([signs * half, np.zeros(5)]))]
        for item in self._shape_items(entity.id):
            if "CURVE" in item.entity.keyword or item.entity.keyword == "POLYLINE":
                return Curves(self.entities, *self.units.context(item.context)).read(
                    item.entity.id, entity.id
                )
        raise entity.fault("stepnc-unsupported", "this is no closed profile that can be made")

    # Setups and tilts

    def setup_origins(self, process: int) -> Iterator[Matrix]:
        """Yield the placements named 'orientation' of the setup that a process associates."""
        for link in self.graph.index("PROCESS_PRODUCT_ASSOCIATION", 1).of(process):
            product = self.entities.get(link).ref("defined_product")
            for item in self._shape_items(product) if product is not None else ():
                if item.entity.keyword == "AXIS2_PLACEMENT_3D" and item.name == "orientation":
                    yield self._placements(item).placement(item.entity.id)

    def tilted(self) -> Iterator[bool]:
        """Yield for each feature whether its placement's Z leaves the machine's."""
        for row in self.entities.exchange.complex_rows().tolist():
            instance = self.entities.exchange.at_row(row)
            if instance is None or instance.part("INSTANCED_FEATURE") is None:
                continue
            try:
                frame = self._feature(instance.id).placement
            except Skip:
                continue
            yield abs(frame[2, 2] - 1.0) > 1e-12

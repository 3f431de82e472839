"""The setup of a workplan: the place of the workpiece in it, its security plane, and its own place on the machine."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc.ap238.graph import Graph, Item
from cncgen.stepnc.ap238.shapes import Shapes
from cncgen.stepnc.entities import Entity, only
from cncgen.stepnc.geometry.breps import SOLIDS
from cncgen.stepnc.geometry.frames import Matrix, Placements, identity
from cncgen.stepnc.geometry.solids import Solid, solid_of

#: Workpieces, each made of the next.
_MOST_MADE = 50


class Setups:
    """Reads the setups of workplans (ISO 10303-238, 5.1.6: SETUP, WORKPIECE_SETUP, WORKPLAN)."""

    def __init__(self, graph: Graph, shapes: Shapes) -> None:
        self.graph = graph
        self.entities = graph.entities
        self.shapes = shapes
        self._pieces: dict[tuple[int, bool], tuple[int, Solid] | None] = {}
        self._open: set[int] = set()

    def of_plan(self, plan: int) -> list[int]:
        """Return the product definitions that are the setups of a workplan."""
        out = []
        for process in self.graph.index("PRODUCT_DEFINITION_PROCESS", 0).of(plan):
            if self.entities.get(process).text("name").strip().lower() == "setup":
                for link in self.graph.index("PROCESS_PRODUCT_ASSOCIATION", 1).of(process):
                    product = self.entities.get(link).ref("defined_product")
                    out += [] if product is None else [product]
        return out

    def origin(self, setup: int) -> Matrix | None:
        """Return where a setup stands on the machine, a work offset, or None.

        Raises:
            Skip: where a placement has a fault.
        """
        return self.shapes.frame(setup, "orientation")

    def security(self, setup: int) -> Matrix | None:
        """Return the frame of a setup's security plane, None where it has none.

        Raises:
            Skip: where it has a fault.
        """
        items: list[Item] = []
        for link in self.graph.index("PROPERTY_DEFINITION", 0).of(setup):
            if self.entities.get(link).text("name").strip().lower() != "security plane":
                continue
            items += [
                i for i in self.shapes.items(link) if i.entity.keyword in ("PLANE", "ELEMENTARY_SURFACE")
            ]
        item = only("security plane of a setup", items)
        return None if item is None else self.shapes.placements(item).plane(item.entity.id)

    def workpieces(self, owner: int) -> dict[int | None, Matrix | None]:
        """Return the workpieces of a setup or project, and where each stands in it: None where that is not said.

        Raises:
            Skip: where a placement has a fault.
        """
        out: dict[int | None, Matrix | None] = {}
        for kind in ("MACHINING_PROJECT_WORKPIECE_RELATIONSHIP", "MACHINING_SETUP_WORKPIECE_RELATIONSHIP"):
            for relation in self.graph.index(kind, 0).of(owner):
                piece = self.entities.get(relation).ref("related_product_definition")
                frame = self._place(relation)
                known = out.get(piece)
                if known is not None and frame is not None and not np.allclose(known, frame, atol=1e-9):
                    text = "the standard has one place of a workpiece in a setup, and the file gives two"
                    raise self.entities.get(relation).fault("stepnc-several", text)
                out[piece] = known if frame is None else frame
        return out

    def _place(self, relation: int) -> Matrix | None:
        found: dict[int, tuple[Entity, Entity]] = {}
        for shape in self.graph.index("PRODUCT_DEFINITION_SHAPE", 0).of(relation):
            for link in self.graph.index("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION", 1).of(shape):
                related = self.entities.get(link).entity("representation_relation")
                found.update((t.id, (t, related)) for t in self._transformations(related))
        ident = self.entities.only("place of the workpiece in a setup", found)
        return None if ident is None else self._frame(*found[ident])

    def piece(self, product: int | None, raw: bool = False) -> tuple[int, Solid] | None:
        """Return the raw piece of a workpiece, and its shape in the workpiece's frame; None where none has a shape.

        The raw piece is what the workpiece is made from (MAKE_FROM_USAGE_OPTION, a relationship 'rawpiece'), and so on; else the
        workpiece itself. Its shape has
        a length, width and height from the corner at its *orientation* (BLOCK_SHAPE_REPRESENTATION), a diameter and
        a length along its Z (CYLINDRICAL_SHAPE_REPRESENTATION), or is a BLOCK or a RIGHT_CIRCULAR_CYLINDER; of the raw
        piece also a B-rep.

        Args:
            product: A workpiece.
            raw: Whether it is the raw piece of another.

        Raises:
            Skip: where the geometry has a fault, or there are several raw pieces.
        """
        if product is None:
            return None
        key = product, raw
        if key in self._pieces:
            return self._pieces[key]
        if product in self._open:
            raise self.entities.get(product).fault("part21-cycle", "the workpiece is its own raw piece")
        if len(self._open) > _MOST_MADE:
            text = f"more than {_MOST_MADE} workpieces are made of one another"
            raise self.entities.get(product).fault("stepnc-nesting", text)
        self._open.add(product)
        try:
            # The raw piece of a workpiece may be its material alone, without a shape.
            made_of = [self.piece(p, True) for p in dict.fromkeys(self._raw_products(product))]
            shaped = dict(piece for piece in made_of if piece is not None)
            ident = self.entities.only("raw piece of a workpiece", shaped)
            found = None if ident is None else (ident, shaped[ident])
            solid = self._solid(product, raw) if found is None else None
        finally:
            self._open.discard(product)
        self._pieces[key] = found if solid is None else (product, solid)
        return self._pieces[key]

    def parts(self) -> list[Solid]:
        """Return what bounds the finished parts whose shape the file has as a B-rep."""
        kind = "MACHINING_PROJECT_WORKPIECE_RELATIONSHIP"
        pieces = {
            self.entities.get(i.id).ref("related_product_definition")
            for i in self.entities.exchange.instances(kind)
        }
        found = [self._solid(p, True) for p in pieces if p is not None]
        return [solid for solid in found if solid is not None]

    def _solid(self, product: int, breps: bool) -> Solid | None:
        """Return the shape of a product; a B-rep's where they count: the raw piece is larger than the finished part."""
        for item in self.shapes.items(product):
            if item.entity.keyword in SOLIDS and not breps:
                continue
            found = solid_of(item.entity, self.shapes.placements(item))
            if found is not None:
                return found
        sizes = self.shapes.measures(product)
        place = self.shapes.frame(product, "orientation")
        frame = identity() if place is None else place
        if sizes.keys() >= {"length", "width", "height"}:
            return Solid("block", frame, (sizes["length"], sizes["width"], sizes["height"]))
        if sizes.keys() >= {"diameter", "length"}:
            radius = sizes["diameter"] / 2
            return Solid("cylinder", frame, (radius, radius, sizes["length"]))
        return None

    def _raw_products(self, piece: int) -> list[int | None]:
        links = [self.entities.get(i) for i in self.graph.index("MAKE_FROM_USAGE_OPTION", 0).of(piece)]
        named = [
            self.entities.get(i) for i in self.graph.index("PRODUCT_DEFINITION_RELATIONSHIP", 0).of(piece)
        ]
        links += [e for e in named if e.text("name").strip().lower() == "rawpiece"]  # the fourth edition
        return [link.ref("related_product_definition") for link in links]

    def _transformations(self, relation: Entity) -> Iterator[Entity]:
        for part in relation.instance.parts:
            for value in part.parameters:
                if isinstance(value, int) and self.entities.keyword(value) == "ITEM_DEFINED_TRANSFORMATION":
                    yield self.entities.get(value)

    def _frame(self, transformation: Entity, relation: Entity) -> Matrix:
        """Return the frame that takes a placement in the workpiece to one in the setup."""
        rows = relation.instance.part("REPRESENTATION_RELATIONSHIP") or relation.instance.parts[0]
        spaces = [v for v in rows.parameters if isinstance(v, int)][:2]
        frames = []
        for name, space in zip(("transform_item_1", "transform_item_2"), [*spaces, None, None], strict=False):
            if transformation.ref(name) is None:
                transformation.warn(
                    "stepnc-placement", f"{name} is not set; it is taken as the origin, not turned"
                )
                frames.append(identity())
                continue
            item = transformation.entity(name, "AXIS2_PLACEMENT_3D")
            context = None if space is None else self.graph.context(int(space))
            placements = Placements(self.entities, self.shapes.units.context(context)[0])
            frames.append(placements.placement(item.id))
        return elementary.product(frames[1], np.asarray(np.linalg.inv(frames[0]), np.float64))

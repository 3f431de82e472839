"""Putting AIM instances into a file one after another, with the entities that every such file needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from cncgen.stepnc.part21 import DERIVED, Enumeration, Instance, Record, Ref, Typed, Value, format_instance
from cncgen.stepnc.part21.writer import format_real

Floats = NDArray[np.float64]
#: The kind, frame and size of a raw piece, as events have them.
Stock = Mapping[str, Any]
E = Enumeration


class AimFile:
    """Writes instances with running numbers.

    Attributes:
        context: The representation context of everything (mm, s, degrees, or inches).
        unit: Its unit of length, mm.
    """

    def __init__(self, stream: TextIO, inches: bool = False) -> None:
        self._stream = stream
        self._next = 1
        self.unit = 25.4 if inches else 1.0
        self._units(inches)

    def add(self, keyword: str, *parameters: Value) -> Ref:
        """Write a simple instance and return its name."""
        return self.add_complex((keyword, parameters))

    def add_complex(self, *parts: tuple[str, Sequence[Value]]) -> Ref:
        """Write an instance of several types, given in alphabetical order, and return its name."""
        ident = self._next
        self._next += 1
        records = tuple(Record(k, tuple(p)) for k, p in parts)
        self._stream.write(format_instance(Instance(ident, records)) + "\n")
        return Ref(ident)

    def points(self, points: Floats) -> list[Ref]:
        """Write CARTESIAN_POINTs of an array, shape (n, 3), mm, and return their names."""
        first = self._next
        real = format_real
        lines = [
            f"#{first + k}=CARTESIAN_POINT('',({real(x)},{real(y)},{real(z)}));\n"
            for k, (x, y, z) in enumerate((points / self.unit).tolist())
        ]
        self._stream.writelines(lines)
        self._next += len(lines)
        return [Ref(first + k) for k in range(len(lines))]

    def direction(self, vector: Floats) -> Ref:
        """Write a DIRECTION, shape (3,)."""
        return self.add("DIRECTION", "", tuple(float(v) for v in vector))

    def placement(self, origin: Floats, axis: Floats, reference: Floats, name: str = "") -> Ref:
        """Write an AXIS2_PLACEMENT_3D, mm."""
        point = self.points(origin[None, :])[0]
        return self.add("AXIS2_PLACEMENT_3D", name, point, self.direction(axis), self.direction(reference))

    def _units(self, inches: bool) -> None:
        self.mm = self.add_complex(
            ("LENGTH_UNIT", ()), ("NAMED_UNIT", (DERIVED,)), ("SI_UNIT", (E("MILLI"), E("METRE")))
        )
        self.second = self.add_complex(
            ("NAMED_UNIT", (DERIVED,)), ("SI_UNIT", (None, E("SECOND"))), ("TIME_UNIT", ())
        )
        radian = self.add_complex(
            ("NAMED_UNIT", (DERIVED,)), ("PLANE_ANGLE_UNIT", ()), ("SI_UNIT", (None, E("RADIAN")))
        )
        no_length = self.add("DIMENSIONAL_EXPONENTS", *[0.0] * 7)
        factor = self.add("PLANE_ANGLE_MEASURE_WITH_UNIT", Typed("PLANE_ANGLE_MEASURE", np.pi / 180), radian)
        degree = self.add_complex(
            ("CONVERSION_BASED_UNIT", ("DEGREE", factor)),
            ("NAMED_UNIT", (no_length,)),
            ("PLANE_ANGLE_UNIT", ()),
        )
        length = self.mm
        if inches:
            exponents = self.add("DIMENSIONAL_EXPONENTS", 1.0, *[0.0] * 6)
            measure = self.add("LENGTH_MEASURE_WITH_UNIT", Typed("LENGTH_MEASURE", 25.4), self.mm)
            length = self.add_complex(
                ("CONVERSION_BASED_UNIT", ("INCH", measure)),
                ("LENGTH_UNIT", ()),
                ("NAMED_UNIT", (exponents,)),
            )
        revolution = self.add("CONTEXT_DEPENDENT_UNIT", no_length, "revolution")
        self.length, self.degree = length, degree
        self.tooth = self.add("CONTEXT_DEPENDENT_UNIT", no_length, "tooth")
        self.feed_unit = self._product((length, 1.0), (self.second, -1.0))
        self.feed_per_turn = self._product((length, 1.0), (revolution, -1.0))
        self.spindle_unit = self._product((revolution, 1.0), (self.second, -1.0))
        self.context = self.add_complex(
            ("GEOMETRIC_REPRESENTATION_CONTEXT", (3,)),
            ("GLOBAL_UNIT_ASSIGNED_CONTEXT", ((length, degree, self.second),)),
            ("REPRESENTATION_CONTEXT", ("", "3D")),
        )

    def _product(self, *powers: tuple[Ref, float]) -> Ref:
        elements = tuple(self.add("DERIVED_UNIT_ELEMENT", unit, exponent) for unit, exponent in powers)
        return self.add("DERIVED_UNIT", elements)

    # Methods, their properties and relationships

    def method(self, keyword: str, name: str = "", description: str = "") -> Ref:
        """Write an action method: ``KEYWORD(name, description, '', '')``."""
        return self.add(keyword, name, description, "", "")

    def relate(self, keyword: str, relating: Ref, related: Ref, position: int | None = None) -> None:
        """Write a relationship, with its sequence position where one is given."""
        place = () if position is None else (float(position),)
        self.add(keyword, "", "", relating, related, *place)

    def property(self, owner: Ref, name: str, keyword: str, label: str, *items: Ref) -> None:
        """Write a property of a method with one representation of some items."""
        representation = self.add(keyword, label, tuple(items), self.context)
        prop = self.add("ACTION_PROPERTY", name, "", owner)
        self.add("ACTION_PROPERTY_REPRESENTATION", "", "", prop, representation)

    def words(self, owner: Ref, name: str, text: str, keyword: str = "REPRESENTATION") -> None:
        """Write a property whose value is a text."""
        item = self.add("DESCRIPTIVE_REPRESENTATION_ITEM", "", text)
        self.property(owner, name, keyword, name, item)

    def measure(self, name: str, value: float, unit: Ref) -> Ref:
        """Write a MEASURE_REPRESENTATION_ITEM."""
        return self.add("MEASURE_REPRESENTATION_ITEM", name, Typed("NUMERIC_MEASURE", float(value)), unit)

    def size(self, name: str, value: float) -> Ref:
        """Write a length as an item, mm."""
        given = Typed("LENGTH_MEASURE", float(value) / self.unit)
        return self.add("MEASURE_REPRESENTATION_ITEM", name, given, self.length)

    def angle(self, name: str, degrees: float) -> Ref:
        """Write an angle as an item."""
        given = Typed("PLANE_ANGLE_MEASURE", float(degrees))
        return self.add("MEASURE_REPRESENTATION_ITEM", name, given, self.degree)

    def teeth(self, name: str, number: int) -> Ref:
        """Write a number of teeth as an item."""
        given = Typed("COUNT_MEASURE", float(number))
        return self.add("MEASURE_REPRESENTATION_ITEM", name, given, self.tooth)

    def project(
        self,
        workplan: Ref,
        name: str,
        stock: Stock | None = None,
        setups: Sequence[tuple[Ref, Stock]] = (),
    ) -> None:
        """Write the project that the workplan is the process of, with its workpiece where the raw piece is known.

        Args:
            workplan: The main workplan.
            name: Of the project.
            stock: ``kind`` (``block`` or ``cylinder``), ``frame`` (4 x 4, mm) and ``size`` (mm) of the raw piece, as
                `cncgen.stepnc.geometry.solids.Solid` has them.
            setups: Workplans within it, and the raw piece in each. One of the same size as one before is of the same workpiece, which
                stands elsewhere.
        """
        application = self.add("APPLICATION_CONTEXT", "application protocol for the control of CNC machines")
        context = self.add("PRODUCT_CONTEXT", "CNC machining", application, "manufacturing")
        product = self.add("MACHINING_PROJECT", name, name, "", (context,))
        formation = self.add("PRODUCT_DEFINITION_FORMATION", "", "", product)
        stage = self.add("PRODUCT_DEFINITION_CONTEXT", "CNC machining", application, "manufacturing")
        definition = self.add("PRODUCT_DEFINITION", "", "", formation, stage)
        process = self.add("PRODUCT_DEFINITION_PROCESS", "machining", "", workplan, "")
        self.add("PROCESS_PRODUCT_ASSOCIATION", "", "", definition, process)
        pieces: list[tuple[Stock, Ref]] = []
        if stock is not None:
            pieces.append((stock, self._workpiece(stock, context, stage)))
            self.add("MACHINING_PROJECT_WORKPIECE_RELATIONSHIP", "", "", "", definition, pieces[0][1])
            setups = [(workplan, stock), *setups] if setups else ()
        for plan, standing in setups:
            setup = self._definition("setup", context, stage)
            process = self.add("PRODUCT_DEFINITION_PROCESS", "setup", "", plan, "")
            self.add("PROCESS_PRODUCT_ASSOCIATION", "", "", setup, process)
            alike = [p for p in pieces if _alike(p[0], standing)] or [
                (standing, self._workpiece(standing, context, stage))
            ]
            pieces += [] if alike[0] in pieces else alike
            relation = self.add("MACHINING_SETUP_WORKPIECE_RELATIONSHIP", "", "", "", setup, alike[0][1])
            self._place(relation, np.asarray(alike[0][0]["frame"]), np.asarray(standing["frame"]))

    def _workpiece(self, stock: Stock, context: Ref, stage: Ref) -> Ref:
        """Write a workpiece and what it is made of."""
        piece, raw = (self._definition(n, context, stage) for n in ("workpiece", "raw piece"))
        one = self.add("MEASURE_WITH_UNIT", Typed("COUNT_MEASURE", 1.0), self.tooth)
        self.add("MAKE_FROM_USAGE_OPTION", "", "", "", piece, raw, 1, "", one)
        shape = self.add("PRODUCT_DEFINITION_SHAPE", "", "", raw)
        self.add("SHAPE_DEFINITION_REPRESENTATION", shape, self._solid(stock))
        return piece

    def _place(self, relation: Ref, own: Floats, standing: Floats) -> None:
        """Write that what a workpiece has at one frame stands at another one in a setup."""
        shape = self.add("PRODUCT_DEFINITION_SHAPE", "", "", relation)
        places = [self.placement(f[:3, 3], f[:3, 2], f[:3, 0], "orientation") for f in (own, standing)]
        change = self.add("ITEM_DEFINED_TRANSFORMATION", "", "", *places)
        link = self.add_complex(
            ("REPRESENTATION_RELATIONSHIP", ("", "", None, None)),
            ("REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION", (change,)),
            ("SHAPE_REPRESENTATION_RELATIONSHIP", ()),
        )
        self.add("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION", link, shape)

    def _definition(self, name: str, context: Ref, stage: Ref) -> Ref:
        product = self.add("PRODUCT", name, name, "", (context,))
        formation = self.add("PRODUCT_DEFINITION_FORMATION", "", "", product)
        return self.add("PRODUCT_DEFINITION", "", "", formation, stage)

    def _solid(self, stock: Stock) -> Ref:
        """Write the shape of a raw piece as ISO 10303-238 has that of ITS_RAWPIECE."""
        frame, size = np.asarray(stock["frame"], float), stock["size"]
        place = self.placement(frame[:3, 3], frame[:3, 2], frame[:3, 0], "orientation")
        if stock["kind"] == "block":
            names, keyword = ["length", "width", "height"], "BLOCK_SHAPE_REPRESENTATION"
        else:
            names, keyword = ["diameter", "length"], "CYLINDRICAL_SHAPE_REPRESENTATION"
            size = (2 * size[0], size[2])
        items = [self.size(name, float(value)) for name, value in zip(names, size, strict=True)]
        return self.add(keyword, "raw piece", (*items, place), self.context)


def _alike(one: Stock, other: Stock) -> bool:
    """Tell whether two raw pieces have the same shape, to a nanometre."""
    return one["kind"] == other["kind"] and np.allclose(one["size"], other["size"], rtol=0.0, atol=1e-6)

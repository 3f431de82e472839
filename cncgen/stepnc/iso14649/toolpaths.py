"""The toolpath kinds of ISO 14649-10 as records."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from cncgen.stepnc.entities import Entities, Entity
from cncgen.stepnc.geometry.approach import angled, tangential
from cncgen.stepnc.geometry.chords import couple
from cncgen.stepnc.geometry.contact import Floats, Lean, leaning, locations
from cncgen.stepnc.geometry.curves import CurveReader
from cncgen.stepnc.geometry.pieces import Piece, Polyline, reverse
from cncgen.stepnc.iso14649.technology import Resources, speed_of
from cncgen.stepnc.model import CutterPath, CuttingTool, Paths


class Toolpaths:
    """Reads TOOLPATH_LISTs."""

    def __init__(self, entities: Entities, curves: CurveReader, resources: Resources) -> None:
        self.entities = entities
        self.curves = curves
        self.resources = resources

    def read(self, ident: int, tool: CuttingTool | None = None, tilt: Floats | Lean | None = None) -> Paths:
        """Return the toolpaths of a list, in their order.

        Args:
            ident: The list.
            tool: Of the operation: its shape counts where paths are those of the contact point.
            tilt: Its direction, shape (3,), where it is not Z, or how it leans.

        Raises:
            Skip: where the entity is of another type, or at fault.
        """
        members = self.entities.get(ident, "TOOLPATH_LIST").refs("its_list")

        def member(k: int) -> CutterPath:
            neighbours = (members[k - 1] if k else None, members[k + 1] if k + 1 < len(members) else None)
            return self._path(self.entities.get(members[k], owner=ident), neighbours, tool, tilt)

        return Paths(members, member)

    def _path(
        self,
        entity: Entity,
        neighbours: tuple[int | None, int | None],
        tool: CuttingTool | None,
        tilt: Floats | Lean | None,
    ) -> CutterPath:
        rapid, ratio = speed_of(entity)
        technology = self.resources.technology(entity.ref("its_technology"))
        functions = self.resources.functions(entity.ref("its_machine_functions"))
        rapid = rapid or entity.enum("its_type") == "CONNECT"

        def path(kind: str, pieces=list, seconds: float = 0.0) -> CutterPath:  # type: ignore[no-untyped-def]
            return CutterPath(entity.id, kind, pieces, rapid, ratio, technology, functions, seconds)

        kind = entity.keyword
        if kind == "CUTTER_LOCATION_TRAJECTORY":
            return path("trajectory", lambda: self._trajectory(entity, tilt))
        if kind == "FEEDSTOP":
            return path("dwell", seconds=entity.number("dwell"))
        if kind == "CONNECT_DIRECT":
            return path("connect direct")
        if kind == "CONNECT_SECPLANE":
            return path("connect security plane")
        if kind in ("AP_LIFT_PATH_ANGLE", "AP_LIFT_PATH_TANGENT"):
            return path("trajectory", lambda: self._approach(entity, neighbours))
        if kind == "AXIS_TRAJECTORY":
            return path("trajectory", lambda: self._axis_trajectory(entity))
        if kind == "CUTTER_CONTACT_TRAJECTORY":
            return path("trajectory", lambda: self._contact(entity, tool, tilt))
        raise entity.fault("stepnc-unsupported", "this kind of toolpath cannot be executed")

    def _trajectory(self, entity: Entity, tilt: Floats | Lean | None = None) -> list[Piece]:
        pieces = self.curves.read(entity.entity("basiccurve").id, entity.id)
        axis, normals = entity.ref("its_toolaxis"), entity.ref("surface_normal")
        plain = CurveReader(self.entities, 1.0, self.curves.angle)  # directions have no unit
        backwards = entity.flag("its_direction") is False
        if axis is not None:
            pieces = list[Piece](couple(pieces, plain.read(axis, entity.id)))
        elif isinstance(tilt, Lean) and normals is not None:
            lean = replace(tilt, forward=not backwards)
            pieces = self._made(entity, leaning, pieces, plain.read(normals, entity.id), lean)
        elif isinstance(tilt, Lean) and abs(tilt.tilt) > 1e-12:
            raise entity.fault(
                "stepnc-missing", "a constant tilt needs the surface's normal (surface_normal)"
            )
        return reverse(pieces) if backwards else pieces

    def _made(self, entity: Entity, make: Callable[..., list[Piece]], *arguments: Any) -> list[Piece]:
        """Return the pieces made of a path and its normals; a `ValueError` becomes a fault of the toolpath."""
        try:
            return make(*arguments)
        except ValueError as error:
            raise entity.fault("stepnc-geometry", str(error)) from None

    def _contact(self, entity: Entity, tool: CuttingTool | None, tilt: Floats | Lean | None) -> list[Piece]:
        """Return the path of the tip where that of the contact point is given with the surface's normal."""
        basic = entity.entity("basiccurve")
        if basic.keyword != "CURVE_WITH_NORMAL_VECTOR":
            text = "a path of the contact point needs the surface's normal: a CURVE_WITH_NORMAL_VECTOR"
            raise entity.fault("stepnc-unsupported", text)
        if tool is None or tool.diameter is None:
            raise entity.fault("stepnc-missing", "a path of the contact point needs a tool with a diameter")
        plain = CurveReader(self.entities, 1.0, self.curves.angle)  # directions have no unit
        contact = self.curves.read(basic.entity("basiccurve").id, basic.id)
        normals = plain.read(basic.entity("surface_normal").id, basic.id)
        axis = entity.ref("its_toolaxis")
        axes = None if axis is None else plain.read(axis, entity.id)
        backwards = entity.flag("its_direction") is False
        upright = np.array([0.0, 0.0, 1.0]) if tilt is None else tilt
        if isinstance(upright, Lean):
            upright = replace(upright, forward=not backwards)
        pieces = self._made(entity, locations, contact, normals, axes, upright, tool.diameter / 2, tool.edge)
        return reverse(pieces) if backwards else pieces

    def _approach(self, entity: Entity, neighbours: tuple[int | None, int | None]) -> list[Piece]:
        """Return an approach to the path after it, or the lift from the path before it."""
        lift = entity.enum("its_type") == "LIFT"
        other = neighbours[0] if lift else neighbours[1]
        contact = self.entities.get(other, "CUTTER_LOCATION_TRAJECTORY", owner=entity.id) if other else None
        if contact is None:
            raise entity.fault("stepnc-missing", "an approach or lift path stands beside no trajectory")
        pieces = self._trajectory(contact)
        pieces = reverse(pieces) if lift else pieces
        point, direction = entity.ref("fix_point"), entity.ref("fix_point_dir")
        if point is None:
            raise entity.fault("stepnc-missing", "fix_point must be given")
        fix = self.curves.placements.point(point, entity.id)
        toward = self.curves.placements.direction(direction, entity.id) if direction is not None else None
        if entity.keyword == "AP_LIFT_PATH_ANGLE":
            angle, bend = entity.number("angle") * self.curves.angle, entity.number("benddist")
            made = angled(entity, fix, toward, pieces[0], angle, bend)
        else:
            made = tangential(entity, fix, toward, pieces[0], entity.number("radius"))
        return reverse(made) if lift else made

    def _axis_trajectory(self, entity: Entity) -> list[Piece]:
        """Return the motion of X, Y and Z given as one curve an axis, all with the same number of points."""
        names, commands = entity.get("axis_list"), entity.refs("commands")
        if not isinstance(names, tuple) or len(names) != len(commands):
            raise entity.fault("stepnc-missing", "axis_list and commands must be lists of the same length")
        letters = [str(n).strip().upper()[:1] for n in names]
        if sorted(letters) != ["X", "Y", "Z"]:
            raise entity.fault(
                "stepnc-unsupported", f"axes {', '.join(map(str, names))}: X, Y and Z together can be moved"
            )
        columns = {}
        for letter, ident in zip(letters, commands, strict=True):
            curve = self.entities.get(ident, "POLYLINE", owner=entity.id)
            points = [self.curves.placements.point(i, ident)[0] for i in curve.refs("points")]
            columns[letter] = points
        if len({len(c) for c in columns.values()}) != 1 or len(columns["X"]) < 2:
            raise entity.fault("stepnc-geometry", "the commands of the axes have different numbers of points")
        return [Polyline(np.column_stack([columns[a] for a in "XYZ"]))]

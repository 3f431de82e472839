"""The executables of an AIM file: workplans, workingsteps, rapid movements, functions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from cncgen.diagnostics import Severity
from cncgen.geometry import elementary
from cncgen.stepnc.ap238.features import Features
from cncgen.stepnc.ap238.graph import Graph
from cncgen.stepnc.ap238.operations import Operations
from cncgen.stepnc.ap238.setups import Setups
from cncgen.stepnc.ap238.statements import ControlStatements
from cncgen.stepnc.ap238.technology import Resources, described, text_of
from cncgen.stepnc.ap238.toolpaths import Properties, Toolpaths
from cncgen.stepnc.ap238.units import Units
from cncgen.stepnc.entities import Entities, Entity, Skip
from cncgen.stepnc.geometry.frames import Matrix, identity
from cncgen.stepnc.geometry.solids import Solid
from cncgen.stepnc.model import (
    Assignment,
    Branching,
    Executable,
    NcFunction,
    Operation,
    ProgramStructure,
    RawPiece,
    Workingstep,
    WorkSetup,
)
from cncgen.stepnc.part21 import Exchange


class Setting(NamedTuple):
    """The settings that hold within a workplan.

    Attributes:
        frame: Of its toolpaths.
        workpieces: Where each workpiece stands, seen from the machine; one that the file does not name is None.
        pieces: The raw pieces.
        security: The setup's security plane, or None.
        clamping: The setup, where the program has several.
    """

    frame: Matrix
    workpieces: Mapping[int | None, Matrix]
    pieces: tuple[RawPiece, ...] = ()
    security: Matrix | None = None
    clamping: WorkSetup | None = None


class Ap238Reader:
    """Reads executables when the executor asks for them."""

    def __init__(self, exchange: Exchange) -> None:
        self.exchange = exchange
        self.entities = Entities(exchange, iso=False)
        self.graph = Graph(self.entities)
        self.units = Units(self.entities)
        self.resources = Resources(self.graph, self.units)
        self.features = Features(self.graph, self.units)
        self.setups = Setups(self.graph, self.features.shapes)
        self.statements = ControlStatements(self.graph)
        self.toolpaths = Toolpaths(self.graph, self.units, self.resources)
        self.operations = Operations(self.graph, self.units, self.resources, self.toolpaths)

    def variables(self) -> dict[str, float]:
        """Return the NC variables with their initial values."""
        return self.statements.variables()

    def _root_ids(self) -> list[int]:
        """Return the workplans that a project's process chooses, else those that no other holds."""
        chosen = []
        for instance in self.exchange.instances("PRODUCT_DEFINITION_PROCESS"):
            try:
                entity = self.entities.get(instance.id)
            except Skip:
                continue
            method = entity.get("chosen_method")
            if entity.text("name").strip().lower() == "machining" and isinstance(method, int):
                chosen.append(int(method))
        plans = [i.id for i in self.exchange.instances("MACHINING_WORKPLAN")]
        held = set()
        for relation in self.exchange.rows_of_type("MACHINING_PROCESS_SEQUENCE_RELATIONSHIP").tolist():
            held.update(self.exchange.links_of(relation)[1:2].tolist())
        return [p for p in dict.fromkeys(chosen) if p in set(plans)] or [p for p in plans if p not in held]

    def roots(self) -> list[Executable]:
        """Return the main workplans (`_root_ids`)."""
        roots = self._root_ids()
        if not roots:
            text = "every MACHINING_WORKPLAN of the file is held by another, or the file has none: nothing is executed"
            self.exchange.reporter.report("stepnc-no-project", text, 0)
        out = []
        for root in roots:
            try:
                out.append(self.executable(root, self._whole()))
            except Skip:
                continue
        return out

    def _whole(self) -> Setting:
        """Return the setting of a project: its workpieces stand at the origin where no setup places them."""
        places: dict[int | None, Matrix] = {}
        for link in self.exchange.instances("MACHINING_PROJECT_WORKPIECE_RELATIONSHIP"):
            with suppress(Skip):
                places[self.entities.get(link.id).ref("related_product_definition")] = identity()
        return Setting(identity(), places, self._pieces(places))

    def _pieces(self, places: Mapping[int | None, Matrix]) -> tuple[RawPiece, ...]:
        """Return the raw pieces of workpieces that stand at places."""
        found: dict[int, RawPiece] = {}
        for product, frame in places.items():
            with suppress(Skip):  # reported
                piece = self.setups.piece(product)
                if piece is not None:
                    found.setdefault(piece[0], RawPiece(*piece, frame))
        return tuple(found.values())

    def parts(self) -> list[Solid]:
        """Return what bounds the finished parts, in the workpieces' frames."""
        return self.setups.parts()

    def orphans(self) -> list[int]:
        """Return workplans and workingsteps that no sequence leads to from the main workplan."""
        leads: dict[int, list[int]] = {}
        for kind in (
            "MACHINING_PROCESS_SEQUENCE_RELATIONSHIP",
            "MACHINING_PROCESS_CONCURRENT_RELATIONSHIP",
            "MACHINING_PROCESS_BRANCH_RELATIONSHIP",
            "MACHINING_PROCESS_BODY_RELATIONSHIP",
        ):
            for row in self.exchange.rows_of_type(kind).tolist():
                links = self.exchange.links_of(row).tolist()
                leads.setdefault(links[0], []).extend(links[1:2]) if links else None
        waiting, seen = self._root_ids(), set[int]()
        while waiting:
            ident = waiting.pop()
            if ident not in seen:
                seen.add(ident)
                waiting += leads.get(ident, [])
        rows = self.exchange.rows_of_type("MACHINING_WORKPLAN", "MACHINING_WORKINGSTEP").tolist()
        return sorted(i for i in (int(self.exchange.rows.ids[r]) for r in rows) if i not in seen)

    def executable(self, ident: int, context: Any) -> Executable:
        """Return an executable within a block whose `Setting` is given.

        Raises:
            Skip: where it has a fault.
        """
        entity = self.entities.get(ident)
        kind, label, properties = entity.keyword, entity.text("name"), self.graph.properties(ident)
        if any(described(i) == "disabled" for i in properties.get("enabled", [])):
            text = f"#{ident} {kind} {label!r} is disabled; it is not executed"
            self.exchange.report(ident, "stepnc-disabled", text, severity=Severity.NOTE)
            return ProgramStructure(ident, label, "disabled", ())
        if kind == "MACHINING_WORKPLAN":
            return self._workplan(entity, properties, context)
        if kind == "MACHINING_WORKINGSTEP":
            return self._workingstep(entity, properties, context)
        if kind == "MACHINING_RAPID_MOVEMENT":
            return self._rapid(entity, properties, context)
        if kind == "MACHINING_TOUCH_PROBING":
            return self._probing(entity, properties, context)
        if kind == "MACHINING_NC_FUNCTION":
            return self._function(entity, properties)
        return self._process(entity, properties, context)

    def _function(self, entity: Entity, properties: Properties) -> NcFunction:
        name = entity.text("description").strip().lower()
        texts = [text_of(i) for items in properties.values() for i in items]
        label = entity.text("name")
        text = next((t for t in texts if t), label)
        values: dict[str, Any] = {"text": text, "value": text if texts else label}
        if name in ("load tool", "unload tool"):
            values = {"tool": self.resources.tool(entity.id)}
        return NcFunction(entity.id, label, name, values)

    def _workplan(self, entity: Entity, properties: Properties, outer: Setting) -> ProgramStructure:
        children = self.graph.related(entity.id, "MACHINING_PROCESS_SEQUENCE_RELATIONSHIP")
        inner = outer._replace(frame=self.toolpaths.frame(properties, outer.frame))
        for setup in self.setups.of_plan(entity.id):
            # A fault of the setup is reported; the plan's workingsteps are still read.
            with suppress(Skip):
                self._note_origin(entity, setup)
            with suppress(Skip):
                inner = self._placed(inner, setup)
            with suppress(Skip):
                inner = inner._replace(clamping=self._clamping(setup))
            with suppress(Skip):
                plane = self.setups.security(setup)
                inner = (
                    inner
                    if plane is None
                    else inner._replace(security=elementary.product(inner.frame, plane))
                )
        return ProgramStructure(
            entity.id, entity.text("name"), "workplan", tuple(c.id for c in children), inner
        )

    def _placed(self, outer: Setting, setup: int) -> Setting:
        """Return a setting with the workpieces of a setup; where none of them has a raw piece, the only one of the project stands there.

        Raises:
            Skip: where a placement has a fault.
        """
        told = self.setups.workpieces(setup)
        if not told:
            return outer
        places = {
            p: outer.workpieces.get(p, identity()) if frame is None else frame for p, frame in told.items()
        }
        pieces = self._pieces(places)
        if not pieces and len(places) == len(outer.pieces) == 1:
            (frame,) = places.values()
            pieces = (replace(outer.pieces[0], frame=frame),)
        return outer._replace(workpieces=places, pieces=pieces)

    def _clamping(self, setup: int) -> WorkSetup | None:
        """Return a setup with its number among those of all workplans, None where it is the only one."""
        plans = [i.id for i in self.exchange.instances("MACHINING_WORKPLAN")]
        used = sorted({s for plan in plans for s in self.setups.of_plan(plan)})
        if len(used) < 2:
            return None
        origin = self.setups.origin(setup)
        return WorkSetup(used.index(setup) + 1, f"#{setup}", origin)

    def _note_origin(self, plan: Entity, setup: int) -> None:
        origin = self.setups.origin(setup)
        if origin is not None and not np.allclose(origin, np.eye(4), atol=1e-9):
            x, y, z = origin[:3, 3]
            text = f"#{plan.id}: the setup stands at ({x:g}, {y:g}, {z:g}) mm: a work offset, not applied"
            self.exchange.report(plan.id, "stepnc-work-offset", text, severity=Severity.NOTE)

    def _process(self, entity: Entity, properties: Properties, context: Any) -> Executable:
        """Return a statement, or an executable of several branches (MACHINING_PROCESS_EXECUTABLE)."""
        ident, label = entity.id, entity.text("name")
        kind = entity.text("description").strip().lower().replace("-", " ")
        if kind == "assignment":
            target = self.statements.target(self.statements.property(entity, properties, "lvalue"))
            value = self.statements.number(self.statements.property(entity, properties, "rvalue"))
            return Assignment(ident, label, target, value)
        if kind in ("if statement", "while statement"):
            return self._choice(entity, properties, context)
        if kind == "setup instructions":
            told = self.graph.related(ident, "MACHINING_OPERATOR_INSTRUCTION_RELATIONSHIP")
            texts = [i.text("description") or i.text("name") for i in told]
            return NcFunction(
                ident, label, "display message", {"text": "; ".join(filter(None, texts)) or label}
            )
        members = self.graph.related(ident, "MACHINING_PROCESS_CONCURRENT_RELATIONSHIP")
        if members:
            return ProgramStructure(ident, label, "parallel", tuple(m.id for m in members), context)
        for word in ("SEQUENCE", "BODY", "BRANCH"):
            members += self.graph.related(ident, f"MACHINING_PROCESS_{word}_RELATIONSHIP")
        if kind in ("non sequential", "selective") and members:
            return ProgramStructure(ident, label, kind, tuple(m.id for m in members), context)
        raise entity.fault(
            "stepnc-unsupported", f"this executable ({kind or 'of no kind'}) cannot be executed"
        )

    def _choice(self, entity: Entity, properties: Properties, context: Any) -> Branching:
        """Return an IF or WHILE: the branches of an IF are told by the names of their relationships."""
        loop = entity.text("description").strip().lower().startswith("while")
        condition = self.statements.condition(self.statements.property(entity, properties, "condition"))
        word = "BODY" if loop else "BRANCH"
        found = self.graph.relation_names(entity.id, f"MACHINING_PROCESS_{word}_RELATIONSHIP")
        ways: dict[str, list[int]] = {}
        for name, executable in found:
            ways.setdefault("body" if loop else name.strip().lower(), []).append(executable.id)
        then, otherwise = (
            self.entities.only(f"{n} of a statement", ways.pop(n, []))
            for n in ("body" if loop else "true branch", "false branch")
        )
        if ways or then is None:
            wanted = "one MACHINING_PROCESS_BODY_RELATIONSHIP" if loop else "'true branch' and 'false branch'"
            raise entity.fault("stepnc-missing", f"its branches must be given by {wanted}")
        return Branching(entity.id, entity.text("name"), loop, condition, then, otherwise, context)

    def _security(self, properties: Properties, frame: Matrix, outer: Matrix | None) -> Matrix | None:
        """Return the frame of the security plane: that of a property, else the one that holds outside."""
        found = self.toolpaths.placed(properties, "security plane", "PLANE", "ELEMENTARY_SURFACE")
        if found is not None:
            plane = found[1].plane(found[0].id)
            return outer if plane is None else elementary.product(frame, plane)
        bare = self.toolpaths.placed(properties, "security plane", "AXIS2_PLACEMENT_3D")
        return outer if bare is None else elementary.product(frame, bare[1].placement(bare[0].id))

    def _rapid(self, entity: Entity, properties: Properties, setting: Setting) -> Workingstep:
        frame = self.toolpaths.frame(properties, setting.frame)
        tilt = self.operations.tilt(entity, properties)
        operation = Operation(
            entity.id, entity.text("name"), "rapid", self.toolpaths.read(entity.id, tilt), tilt=tilt
        )
        security = self._security(properties, frame, setting.security)
        where = setting.clamping
        return Workingstep(entity.id, operation.label, operation, None, frame, security, True, setup=where)

    def _probing(self, entity: Entity, properties: Properties, setting: Setting) -> Workingstep:
        """Return a probing that stands in a workplan without a workingstep."""
        frame = self.toolpaths.frame(properties, setting.frame)
        operation = self._probed(self.operations.read(entity), entity)
        security = self._security(properties, frame, setting.security)
        return Workingstep(entity.id, operation.label, operation, None, frame, security)

    def _probed(self, operation: Operation, entity: Entity) -> Operation:
        """Return a probing with a note: it goes all of its toolpath; there is nothing to touch."""
        if operation.paths is None:
            text = "without toolpaths neither the way nor the feed of the probe is known"
            raise entity.fault("stepnc-unsupported", text)
        text = f"#{entity.id} {entity.keyword}: planned to the end of its toolpath; nothing is measured"
        self.exchange.report(entity.id, "probe-not-run", text, severity=Severity.NOTE)
        return operation

    def _workingstep(self, entity: Entity, properties: Properties, setting: Setting) -> Workingstep:
        frame = self.toolpaths.frame(properties, setting.frame)
        operations = self.graph.related(entity.id, "MACHINING_OPERATION_RELATIONSHIP")
        if not operations:
            raise entity.fault("stepnc-missing", "the workingstep has no operation")
        if len(operations) > 1:
            raise entity.fault(
                "stepnc-unsupported", f"the workingstep has {len(operations)} operations, not one"
            )
        operation = self.operations.read(operations[0])
        if operation.kind == "probing" or operations[0].keyword == "MACHINING_TOUCH_PROBING":
            operation = self._probed(operation, operations[0])
        security = self._security(properties, frame, setting.security)
        feature = None
        workpiece, piece = self._machined(entity, setting, operation.paths is None)
        if operation.paths is None:
            feature = self.features.of_workingstep(entity.id, None if piece is None else piece.solid)
            # A toolpath orientation places toolpaths, and not the workpiece (ISO 10303-238, 4.3.345.3).
            frame = frame if feature is None else elementary.product(workpiece, feature.placement)
        return Workingstep(
            entity.id,
            entity.text("name"),
            operation,
            feature,
            frame,
            security,
            raw=None if piece is None else piece.placed,
            setup=setting.clamping,
            pieces=setting.pieces,
        )

    def _machined(self, step: Entity, setting: Setting, wanted: bool) -> tuple[Matrix, RawPiece | None]:
        """Return where the workpiece of a workingstep stands, and its raw piece; `wanted`: they matter.

        Raises:
            Skip: where there are several workpieces at different places, and the feature is of none of them.
        """
        try:
            product = self.features.workpiece(step.id)
            made = self.setups.piece(product)
        except Skip:  # reported; explicit toolpaths do not need them
            if wanted:
                raise
            product = made = None
        own = [p for p in setting.pieces if made is not None and p.ident == made[0]]
        pieces = own or list(setting.pieces)
        frames = [setting.workpieces[product]] if product in setting.workpieces else [p.frame for p in own]
        frames = frames or list(setting.workpieces.values()) or [identity()]
        if all(np.allclose(f, frames[0], atol=1e-9) for f in frames):
            if wanted and len(pieces) > 1 and not own:
                text = f"there are {len(pieces)} raw pieces, and the feature is of none of their workpieces: none counts"
                step.warn("stepnc-workpiece", text)
            return frames[0], pieces[0] if len(pieces) == 1 else None
        if wanted:
            text = f"the setup has {len(frames)} workpieces, and the feature is of none of them: where it is cut is not known"
            raise step.fault(
                "stepnc-workpiece", text, hint="of_shape of the feature, the shape of its workpiece"
            )
        return frames[0], None

    def needs_rotary(self) -> bool:
        """Tell whether a tool axis may leave the machine's Z: by tool axes, tool directions or the frames of toolpaths."""
        for instance in self.exchange.instances("ACTION_PROPERTY"):
            name = str(instance.parameters[0] if instance.parameters else "").strip().lower()
            if name in ("tool axis", "tool direction") and self.toolpaths.leans(instance.id):
                return True
            if name == "toolpath orientation" and self.toolpaths.turns_frame(instance.id):
                return True
        return False

    def may_lean(self) -> bool:
        """Tell whether a workpiece leans in its setup, or a feature that is machined without toolpaths."""
        for plan in self.exchange.instances("MACHINING_WORKPLAN"):
            with suppress(Skip):
                for setup in self.setups.of_plan(plan.id):
                    frames = self.setups.workpieces(setup).values()
                    if any(f is not None and abs(f[2, 2] - 1.0) > 1e-12 for f in frames):
                        return True
        return any(self._tilted_features())

    def _tilted_features(self) -> Iterator[bool]:
        """Yield for each workingstep that is made of its feature whether that is tilted."""
        for row in self.exchange.rows_of_type("MACHINING_WORKINGSTEP").tolist():
            step = int(self.exchange.rows.ids[row])
            try:
                operations = self.graph.related_ids(step, "MACHINING_OPERATION_RELATIONSHIP")
                paths = "MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP"
                if any(self.graph.related_ids(o, paths) for o in operations):
                    continue
                feature = self.features.of_workingstep(step)
                yield feature is not None and self.features.tilted(feature)
            except Skip:
                continue

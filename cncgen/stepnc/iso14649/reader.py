"""The executables of ISO 14649-10: project, workplans, workingsteps, functions, statements."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from cncgen.diagnostics import Severity
from cncgen.geometry import elementary
from cncgen.stepnc import turned_shapes
from cncgen.stepnc.entities import Entities, Entity, Skip
from cncgen.stepnc.geometry.curves import CurveReader
from cncgen.stepnc.geometry.frames import Matrix, identity, is_identity
from cncgen.stepnc.geometry.solids import Solid
from cncgen.stepnc.iso14649.features import Features
from cncgen.stepnc.iso14649.operations import Operations
from cncgen.stepnc.iso14649.statements import ControlStatements
from cncgen.stepnc.iso14649.technology import Resources
from cncgen.stepnc.iso14649.toolpaths import Toolpaths
from cncgen.stepnc.model import (
    Assignment,
    Branching,
    Executable,
    Feature,
    NcFunction,
    Operation,
    ProgramStructure,
    RawPiece,
    Workingstep,
    WorkSetup,
)
from cncgen.stepnc.part21 import Exchange, Ref, Value

_FUNCTIONS = {
    "DISPLAY_MESSAGE": "its_text",
    "OPTIONAL_STOP": "",
    "PROGRAM_STOP": "",
    "EXCHANGE_PALLET": "",
    "INDEX_PALLET": "its_index",
    "INDEX_TABLE": "its_index",
    "WAIT_FOR_MARK": "its_channel",
    "SET_MARK": "",
}
#: Entities that may hold executables.
_LEADING = ("WORKPLAN", "PARALLEL", "NON_SEQUENTIAL", "SELECTIVE", "IF_STATEMENT", "WHILE_STATEMENT")
_BLOCKS = {"PARALLEL": "branches", "NON_SEQUENTIAL": "its_elements", "SELECTIVE": "its_elements"}


@dataclass(frozen=True, slots=True)
class Setting:
    """The settings that hold within a workplan.

    Attributes:
        setup: Frame of the setup, seen from the machine: its_origin is a work offset, set at the machine.
        workpieces: Frame of each workpiece by its id, seen from the machine.
        security: The setup's security plane, seen from the machine, or None.
        clamping: The setup, where the program has several.
    """

    setup: Matrix
    workpieces: dict[int, Matrix]
    security: Matrix | None
    clamping: WorkSetup | None = None


class Iso14649Reader:
    """Reads executables when the executor asks for them."""

    def __init__(self, exchange: Exchange) -> None:
        self.exchange = exchange
        self.entities = Entities(exchange, iso=True)
        self.curves = CurveReader(self.entities, 1.0, math.pi / 180.0)
        self.placements = self.curves.placements
        self.resources = Resources(self.entities)
        self.statements = ControlStatements(self.entities)
        self.features = Features(self.entities, self.curves)
        toolpaths = Toolpaths(self.entities, self.curves, self.resources)
        #: The raw pieces of workpieces.
        self._raws: dict[int, tuple[int, Solid] | None] = {}
        #: The first workplan of each channel.
        self._channels: dict[int, int] = {}
        self.operations = Operations(self.entities, self.placements, self.resources, toolpaths)

    def variables(self) -> dict[str, float]:
        """Return the NC variables with their initial values."""
        return self.statements.variables()

    def roots(self) -> list[Executable]:
        """Return the main workplan of the project; without one, the workplans that no other holds."""
        nowhere = Setting(identity(), {}, None)
        projects = list(self.exchange.instances("PROJECT"))
        roots = []
        for project in projects:
            try:
                plan = self.entities.get(project.id).entity("main_workplan", "WORKPLAN")
                roots.append(self.executable(plan.id, nowhere))
            except Skip:
                continue
        if not projects:
            held = {int(i) for w in self.exchange.instances("WORKPLAN") for i in self._elements(w.id)}
            free = [w.id for w in self.exchange.instances("WORKPLAN") if w.id not in held]
            for plan_id in free:
                try:
                    roots.append(self.executable(plan_id, nowhere))
                except Skip:
                    continue
            if not free:
                text = "there is no PROJECT and no WORKPLAN: nothing is executed"
                hint = "a STEP file of a part (AP203, AP214, AP242) has its shape alone, and no work on it"
                if self.exchange.data:  # else the whole file is reported
                    self.exchange.reporter.report("stepnc-no-project", text, 0, hint=hint)
        return roots

    def parts(self) -> list[Solid]:
        """Return what bounds the finished parts, in the workpieces' frames."""
        return self.features.stock.parts()

    def orphans(self) -> list[int]:
        """Return workplans and workingsteps that nothing leads to from the main workplan."""
        waiting = [
            int(v) for i in self.exchange.instances("PROJECT") for v in i.parameters if isinstance(v, Ref)
        ]
        if not waiting:
            return []
        seen: set[int] = set()
        held = dict.fromkeys(waiting)
        while held:
            ident, _ = held.popitem()
            if ident in seen:
                continue
            seen.add(ident)
            instance = self.exchange.instance(ident)
            if instance is not None and instance.keyword in _LEADING:
                held.update(dict.fromkeys(refs_of(instance.parameters)))
        kinds = ("WORKPLAN", "MACHINING_WORKINGSTEP", "TURNING_WORKINGSTEP")
        return sorted(i.id for i in self.exchange.instances(*kinds) if i.id not in seen)

    def _elements(self, ident: int) -> list[int]:
        try:
            return self.entities.get(ident).refs("its_elements")
        except Skip:
            return []

    def executable(self, ident: int, context: Any) -> Executable:
        """Return an executable of a block whose `Setting` is given.

        Raises:
            Skip: where it has a fault.
        """
        entity = self.entities.get(ident)
        kind, label = entity.keyword, entity.text("its_id")
        if kind == "WORKPLAN":
            self._check_channel(entity)
            try:
                setting = self._setting(entity, context)
            except Skip:  # reported; the plan's workingsteps are still read
                setting = context
            return ProgramStructure(ident, label, "workplan", tuple(entity.refs("its_elements")), setting)
        if kind in _BLOCKS:
            name = kind.lower().replace("_", " ")
            return ProgramStructure(ident, label, name, tuple(entity.refs(_BLOCKS[kind])), context)
        if kind in ("MACHINING_WORKINGSTEP", "TURNING_WORKINGSTEP"):
            return self._workingstep(entity, context)
        if kind in ("RAPID_MOVEMENT", "RETURN_HOME"):
            return self._rapid(entity, context)
        if "PROBING" in kind:
            return self._probing(entity, context)
        if kind in ("IF_STATEMENT", "WHILE_STATEMENT"):
            return self._choice(entity, context)
        if kind == "ASSIGNMENT":
            target = entity.entity("its_lvalue", "NC_VARIABLE")
            value = self.statements.value(entity, entity.get("its_rvalue"))
            return Assignment(ident, label, self.statements.name(target), value)
        return self._function(entity)

    def _check_channel(self, plan: Entity) -> None:
        """Warn of a workplan of another channel than one before: of two turrets or spindles each works on its own."""
        channel = plan.ref("its_channel")
        if channel is None:
            return
        self._channels.setdefault(channel, plan.id)
        first, other = next(iter(self._channels)), channel
        if first != other:
            text = f"its channel #{other} is another than #{first} of #{self._channels[first]}; there is one machine here, which"
            plan.warn("stepnc-channel", f"{text} does one workplan after the other")

    def _choice(self, entity: Entity, context: Any) -> Branching:
        loop = entity.keyword == "WHILE_STATEMENT"
        condition = self.statements.condition(entity, entity.get("condition"))
        then = entity.ref("body" if loop else "true_branch")
        otherwise = None if loop else entity.ref("false_branch")
        return Branching(entity.id, entity.text("its_id"), loop, condition, then, otherwise, context)

    def _function(self, entity: Entity) -> NcFunction:
        kind, label = entity.keyword, entity.text("its_id")
        name = kind.lower().replace("_", " ")
        if kind in ("LOAD_TOOL", "UNLOAD_TOOL"):
            tool = self.resources.tool(entity.ref("its_tool"))
            return NcFunction(entity.id, label, name, {"tool": tool})
        if kind not in _FUNCTIONS:
            raise entity.fault("stepnc-unsupported", "this executable cannot be executed")
        attribute = _FUNCTIONS[kind]
        value = entity.get(attribute) if attribute else None
        return NcFunction(
            entity.id, label, name, {"text": value, "value": None if value is None else str(value)}
        )

    # Frames

    def _setting(self, plan: Entity, outer: Setting) -> Setting:
        ident = plan.ref("its_setup")
        if ident is None:
            return outer
        setup = self.entities.get(ident, "SETUP", owner=plan.id)
        origin = self.placements.optional(setup, "its_origin")
        if origin is not None and not is_identity(origin):
            x, y, z = origin[:3, 3]
            text = f"#{ident} SETUP: its_origin at ({x:g}, {y:g}, {z:g}) mm is a work offset, not applied to motions"
            self.exchange.report(ident, "stepnc-work-offset", text, severity=Severity.NOTE)
        frame = identity()
        workpieces = {}
        for member in setup.refs("its_workpiece_setup"):
            entity = self.entities.get(member, "WORKPIECE_SETUP", owner=ident)
            if entity.get("its_offset") is not None:
                entity.warn("stepnc-offset", "a measured offset of the workpiece is not applied")
            place = self.placements.optional(entity, "its_origin")
            workpiece = entity.ref("its_workpiece")
            if workpiece is not None:
                workpieces[workpiece] = frame if place is None else elementary.product(frame, place)
        plane = self.placements.plane(setup.ref("its_secplane"), ident)
        security = None if plane is None else elementary.product(frame, plane)
        return Setting(frame, workpieces, security, self._clamping(setup, origin))

    def _clamping(self, setup: Entity, origin: Matrix | None) -> WorkSetup | None:
        """Return a setup with its number among those of all workplans, None where it is the only one."""
        plans = (self.entities.get(w.id) for w in self.exchange.instances("WORKPLAN"))
        used = {int(v) for v in (p.get("its_setup") for p in plans) if isinstance(v, Ref)}
        if len(used) < 2:
            return None
        return WorkSetup(sorted(used).index(setup.id) + 1, setup.text("its_id") or f"#{setup.id}", origin)

    def _workpiece_frame(self, setting: Setting, workpiece: int | None, owner: Entity) -> Matrix:
        if workpiece in setting.workpieces:
            return setting.workpieces[workpiece]
        if len(setting.workpieces) == 1 and workpiece is None:
            return next(iter(setting.workpieces.values()))
        if setting.workpieces and workpiece is not None:
            owner.warn(
                "stepnc-workpiece",
                f"the setup does not place workpiece #{workpiece}; the setup's frame holds",
            )
        return setting.setup

    def _workingstep(self, entity: Entity, setting: Setting) -> Workingstep:
        features = self._features(entity)
        feature: Feature | None = None
        workpiece = None
        if features:
            owner = self.entities.get(features[0], owner=entity.id)
            workpiece = owner.ref("its_workpiece")
        frame = self._workpiece_frame(setting, workpiece, entity)
        raw = self.features.stock.solid(workpiece)
        pieces = self._pieces(setting, workpiece)
        if features:
            feature = turned_shapes.standing(self.entities, [self.features.read(f) for f in features], raw)
        raw = None if raw is None else raw.moved(frame)
        if workpiece is None and len(pieces) == 1:
            raw = pieces[0].placed
        if feature is not None:
            frame = elementary.product(frame, feature.placement)
        plane = self.placements.plane(entity.ref("its_secplane"), entity.id)
        security = setting.security if plane is None else elementary.product(frame, plane)
        operation = self.operations.read(entity.entity("its_operation"))
        label = entity.text("its_id")
        where = setting.clamping
        return Workingstep(
            entity.id, label, operation, feature, frame, security, raw=raw, setup=where, pieces=pieces
        )

    def _pieces(self, setting: Setting, workpiece: int | None) -> tuple[RawPiece, ...]:
        """Return the raw pieces in a setup: of the workpieces that it holds and of that of a feature, else of all of the project."""
        idents = list(dict.fromkeys([*setting.workpieces, *([] if workpiece is None else [workpiece])]))
        found: dict[int, RawPiece] = {}
        for ident in idents or self._workpieces:
            if ident not in self._raws:
                self._raws[ident] = None
                with suppress(Skip):  # reported
                    self._raws[ident] = self.features.stock.piece(ident)
            piece = self._raws[ident]
            if piece is not None:
                found.setdefault(piece[0], RawPiece(*piece, setting.workpieces.get(ident, setting.setup)))
        return tuple(found.values())

    @cached_property
    def _workpieces(self) -> list[int]:
        """The workpieces of the projects."""
        out: list[int] = []
        for project in self.exchange.instances("PROJECT"):
            with suppress(Skip):
                out += self.entities.get(project.id).refs("its_workpieces")
        return out

    def _features(self, step: Entity) -> list[int]:
        """Return the features of a workingstep; turning may have several."""
        value = step.get("its_feature")
        if isinstance(value, tuple):
            return step.refs("its_feature")
        ident = step.ref("its_feature")
        return [] if ident is None else [ident]

    def _probing(self, entity: Entity, setting: Setting) -> Workingstep:
        """Return a probing that goes all of its toolpath: there is nothing to touch, and nothing is measured."""
        if entity.ref("its_toolpath") is None:
            text = "without its_toolpath neither the way nor the feed of the probe is known"
            raise entity.fault("stepnc-unsupported", text)
        step = self._rapid(entity, setting)
        text = f"#{entity.id} {entity.keyword}: planned to the end of its toolpath; nothing is measured"
        self.exchange.report(entity.id, "probe-not-run", text, severity=Severity.NOTE)
        return replace(step, rapid=False, operation=replace(step.operation, kind="probing"))

    def _rapid(self, entity: Entity, setting: Setting) -> Workingstep:
        """Return a rapid movement; its toolpath is in the setup's frame (as in NIST's ex1E)."""
        toolpath = entity.ref("its_toolpath")
        if toolpath is None:
            raise entity.fault(
                "stepnc-missing", "its_toolpath must be given: where the tool goes is not known"
            )
        paths = self.operations.toolpaths.read(toolpath)
        operation = Operation(entity.id, entity.text("its_id"), "rapid", paths)
        plane = self.placements.plane(entity.ref("its_secplane"), entity.id)
        security = setting.security if plane is None else elementary.product(setting.setup, plane)
        step = Workingstep(
            entity.id, operation.label, operation, None, setting.setup, security, True, setup=setting.clamping
        )
        tilt = self.operations.tilt(entity)
        return step if tilt is None else replace(step, operation=replace(operation, tilt=tilt))

    def needs_rotary(self) -> bool:
        """Tell whether a tool axis may leave the machine's Z: tool axes and tilted tools."""
        return self._tools_lean() or self._paths_lean()

    def _tools_lean(self) -> bool:
        leaning = self.exchange.instances("FIVE_AXES_CONST_TILT_YAW")
        return len(self.exchange.rows_of_type("THREE_AXES_TILTED_TOOL")) > 0 or any(
            any(instance.parameters) for instance in leaning
        )

    def _paths_lean(self) -> bool:
        for instance in self.exchange.instances("CUTTER_LOCATION_TRAJECTORY", "CUTTER_CONTACT_TRAJECTORY"):
            axis = instance.parameters[7] if len(instance.parameters) > 7 else None
            if isinstance(axis, int) and self.curves.leans(int(axis)):
                return True
        return False

    def may_lean(self) -> bool:
        """Tell whether a setup, workpiece or feature leans; `leans` tells of their workingsteps."""
        for instance in self.exchange.instances("AXIS2_PLACEMENT_3D"):
            axis = instance.parameters[2] if len(instance.parameters) > 2 else None
            direction = self.exchange.instance(int(axis)) if isinstance(axis, int) else None
            if (
                direction
                and len(direction.parameters) > 1
                and self._tilts(direction.parameters[1])
                and self._places(instance.id)
            ):
                return True
        return False

    def _tilts(self, ratios: Value) -> bool:
        """Tell whether the numbers of a direction leave Z; False where they do not make a direction in space."""
        if not isinstance(ratios, tuple) or len(ratios) != 3:
            return False
        if not all(isinstance(r, int | float) for r in ratios):
            return False
        length = math.hypot(*map(float, ratios))
        return length > 0 and float(ratios[2]) / length < 1.0 - 1e-12

    def _places(self, ident: int) -> bool:
        """Tell whether a placement places a setup, a workpiece or a feature, not a curve or plane."""
        if not hasattr(self, "_placing"):
            self._placing: set[int] = set()
            self._note_places("WORKPIECE_SETUP", "its_origin")
            for kind in self.features.kinds:
                self._note_places(kind, "feature_placement")
        return ident in self._placing

    def _note_places(self, kind: str, attribute: str) -> None:
        for instance in self.exchange.instances(kind):
            if instance.part(kind) is None:  # defined twice; the first is another entity
                continue
            value = Entity(self.entities, instance, kind).get(attribute)
            if isinstance(value, int):
                self._placing.add(int(value))


def refs_of(values: tuple[Value, ...]) -> list[int]:
    """Return all references among parameters, in aggregates too."""
    out: list[int] = []
    for value in values:
        if isinstance(value, Ref):
            out.append(int(value))
        elif isinstance(value, tuple):
            out += refs_of(value)
    return out

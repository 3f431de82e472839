"""Walking a program: workplans, statements, functions, workingsteps; motion by motion to a listener."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Severity
from cncgen.geometry import elementary
from cncgen.stepnc.entities import Skip
from cncgen.stepnc.execution.canon import Canon
from cncgen.stepnc.execution.cutting_speed import at_diameter, radius, spindle_at, stretches
from cncgen.stepnc.execution.machine_state import MachineState
from cncgen.stepnc.execution.rotary_axes import RotaryAxes
from cncgen.stepnc.execution.technology import SpeedRules, Speeds, check_cutting_speed, completed, speeds
from cncgen.stepnc.geometry.pieces import Arc, Piece, Polyline
from cncgen.stepnc.model import (
    TURNING,
    Assignment,
    Branching,
    CutterPath,
    CuttingTool,
    Executable,
    NcFunction,
    Operation,
    ProgramStructure,
    Reader,
    Technology,
    Workingstep,
)
from cncgen.stepnc.part21 import Exchange

Floats = NDArray[np.float64]
#: Called with a workingstep whose operation has no toolpaths; returns those of its feature; raises `Skip`.
MakePaths = Callable[[Workingstep], tuple[CutterPath, ...]]

#: Blocks and statements within each other.
MAX_DEPTH = 60
#: Executables that one run executes, whatever the options allow: it takes seconds to find that a loop has no end.
MAX_STEPS = 2_000_000
#: Largest coordinate of a position, mm.
MAX_COORDINATE = 1e7
#: Largest feed (mm/s) and spindle speed (rev/min).
MAX_SPEED = 1e7
#: Longest dwell, s: eleven days.
MAX_DWELL = 1e6
#: A turn of the turning axis that is worth a warning where the tool hardly leans, rad.
MAX_SWING = math.pi / 4
#: ISO 14649-12 gives const_cutting_speed no sense; its max_speed is a rot_speed_measure, below 0 with the clock.
NO_SENSE = (
    "a constant cutting speed above 0 does not tell which way the work turns; it is with the clock (M3)"
)


class ProgramExecutor:
    """Executes a program once.

    Args:
        reader: Gives the program's records.
        exchange: The file, for diagnostics.
        canon: Listens to the execution.
        start: Where the tool stands, shape (3,), mm.
        kinematics: Of the rotary axes, None where the program has none.
        make_paths: Makes toolpaths of features.
        max_steps: Executables after which the program counts as endless; never more than `MAX_STEPS`, which None stands for.
        rules: Meaning of the file's speeds.
        lengths: Of a tool table, mm, by name (`cncgen.machine.tool_table.ToolTable.lengths`); None: those of the file.
    """

    def __init__(
        self,
        reader: Reader,
        exchange: Exchange,
        canon: Canon,
        start: Floats,
        kinematics: RotaryAxes | None,
        make_paths: MakePaths,
        max_steps: int | None,
        rules: SpeedRules,
        lengths: Mapping[str, float] | None = None,
    ) -> None:
        self._reader = reader
        self._exchange = exchange
        self._canon = canon
        self._machine = MachineState(canon, start, kinematics)
        self._home = start
        self._make_paths = make_paths
        self._rules = rules
        self._lengths = lengths
        self._steps_left = min(max_steps or MAX_STEPS, MAX_STEPS)
        self._variables: dict[str, float] = {}
        self._open: list[int] = []
        #: Operations that were reported: for a feed with a standing spindle, and for the feed of another operation.
        self._standing: set[int] = set()
        self._carried: set[int] = set()
        self._moved = self._done = False
        self._connect: str | None = None
        self._setup: int | None = None

    def run(self) -> Iterator[None]:
        """Execute; yields after every toolpath, so that what listens can hand on."""
        try:
            with suppress(Skip):
                self._variables = self._reader.variables()
            roots = self._reader.roots()
            if len(roots) > 1:
                names = ", ".join(f"#{root.ident} {root.label!r}" for root in roots)
                text = f"several workplans are main ones: {names}; they are executed one after the other"
                self._warn(roots[1].ident, "stepnc-several", text)
            for root in roots:
                with suppress(Skip):
                    yield from self._execute(root)
            self._check_motions()
        except _Endless:
            pass
        self._canon.end()

    def _check_motions(self) -> None:
        """Warn of a program that does nothing, and of executables that no workplan holds."""
        for ident in self._reader.orphans():
            text = "no workplan that is executed holds it, so it is left out"
            self._warn(ident, "stepnc-orphan", text)
        if not self._done and not self._exchange.reporter.diagnostics.has_errors:
            text = "the program does nothing: no workplan that is executed holds a workingstep or a function"
            self._exchange.reporter.report("stepnc-no-motion", text, 0, severity=Severity.WARNING)

    def _warn(self, ident: int, code: str, message: str, severity: Severity = Severity.WARNING) -> None:
        name = self._exchange.instance(ident)
        text = f"#{ident} {name.keyword if name else ''}: {message}"
        self._exchange.report(ident, code, text, severity=severity)

    def _fail(self, ident: int, code: str, message: str) -> Skip:
        self._warn(ident, code, message, Severity.ERROR)
        return Skip()

    # Structure

    def _execute(self, item: Executable) -> Iterator[None]:
        self._steps_left -= 1
        if self._steps_left < 0:
            self._fail(
                item.ident, "stepnc-endless", "the program has executed too many steps; it does not end"
            )
            raise _Endless
        if isinstance(item, ProgramStructure | Branching):
            if item.ident in self._open:
                cycle = " → ".join(f"#{i}" for i in [*self._open[self._open.index(item.ident) :], item.ident])
                raise self._fail(item.ident, "part21-cycle", f"it executes itself: {cycle}")
            if len(self._open) >= MAX_DEPTH:
                raise self._fail(item.ident, "stepnc-nesting", f"nested more than {MAX_DEPTH} deep")
            self._open.append(item.ident)
            try:
                yield from self._block(item) if isinstance(item, ProgramStructure) else self._choice(item)
            finally:
                self._open.pop()
            return
        self._done = True
        if isinstance(item, Workingstep):
            yield from self._workingstep(item)
        elif isinstance(item, Assignment):
            self._variables[item.variable] = item.value(self._variables)
        else:
            self._function(item)
            yield

    def _child(self, ident: int | None, context: object) -> Iterator[None]:
        """Execute a child; a fault in it leaves the others."""
        if ident is None:
            return
        try:
            yield from self._execute(self._reader.executable(ident, context))
        except Skip:
            return

    def _block(self, block: ProgramStructure) -> Iterator[None]:
        children = block.children
        if block.kind == "parallel" and len(children) > 1:
            text = f"{len(children)} branches at once cannot be honoured by one machine with one spindle"
            raise self._fail(block.ident, "stepnc-parallel", text)
        if block.kind == "selective" and len(children) > 1:
            self._warn(
                block.ident, "stepnc-selective", f"the first of {len(children)} alternatives is executed"
            )
            children = children[:1]
        for child in children:
            yield from self._child(child, block.context)

    def _choice(self, choice: Branching) -> Iterator[None]:
        if not choice.loop:
            branch = choice.then if choice.condition(self._variables) else choice.otherwise
            yield from self._child(branch, choice.context)
            return
        seen = set()
        while choice.condition(self._variables):
            # Nothing but the variables tells the next turn from one before.
            self._steps_left -= 1
            now = tuple(self._variables.values())
            if now in seen or self._steps_left < 0:
                why = (
                    "its variables are those of an earlier turn" if now in seen else "no step allowed is left"
                )
                self._fail(choice.ident, "stepnc-endless", f"the loop does not end: {why}")
                raise _Endless
            seen.add(now)
            yield from self._child(choice.then, choice.context)

    def _function(self, function: NcFunction) -> None:
        self._canon.source(function.ident)
        kind, values = function.kind, function.values
        if kind in ("program stop", "optional stop"):
            self._canon.stop(kind == "optional stop")
        elif kind == "display message":
            self._canon.message(str(values.get("text", "")))
        elif kind == "load tool":
            if values.get("tool") is None:
                raise self._fail(function.ident, "stepnc-missing", "its_tool must be given")
            self._machine.change_tool(self._measured(values["tool"]))
        elif kind == "unload tool":
            tool = self._machine.tool
            self._machine.unload_tool()
            self._canon.function(kind, tool.name if tool is not None else None)
        else:
            if kind in ("wait for mark", "set mark"):
                self._warn(
                    function.ident,
                    "stepnc-channel",
                    "there is one channel: nobody else waits or is waited for",
                )
            self._canon.function(kind, values.get("value"))

    # Workingsteps

    def _workingstep(self, step: Workingstep) -> Iterator[None]:
        if step.operation.technology is not None:
            told = self._rules.applied(step.operation.technology, step.operation.tool)
            step = replace(step, operation=replace(step.operation, technology=told))
        operation = step.operation
        self._canon.workingstep(step)
        self._canon.source(operation.ident)
        if step.setup is not None and step.setup.number != self._setup:
            self._setup = step.setup.number
            self._canon.setup(step.setup)
        paths = operation.paths
        if paths is None:
            paths = self._make_paths(step)
        elif not paths:
            self._warn(operation.ident, "stepnc-empty", "the operation has no toolpath")
        if not step.rapid:
            self._prepare(step, operation)
        self._connect = None
        begun = False
        for k in range(len(paths)):
            try:
                begun = self._path(step, paths[k], begun) or begun
            except Skip:
                continue
            yield

    def _prepare(self, step: Workingstep, operation: Operation) -> None:
        if operation.tool is not None:
            self._machine.change_tool(self._measured(operation.tool))
        elif self._machine.tool is None and operation.technology is not None:
            self._warn(
                operation.ident, "stepnc-no-tool", "the operation names no tool, and none is in the spindle"
            )
        if operation.functions is not None:
            self._machine.switch(operation.functions)
            if operation.functions.others:
                names = ", ".join(operation.functions.others)
                self._warn(operation.functions.ident, "stepnc-function", f"nothing does this here: {names}")

    def _measured(self, tool: CuttingTool) -> CuttingTool:
        """Return a tool with the length that the tool table gives it."""
        if self._lengths is None:
            return tool
        length = self._lengths.get(tool.name.strip().upper())
        if length is None:
            self._warn(tool.ident, "stepnc-tool-table", f"tool {tool.name!r} is not in the tool table")
            return tool
        return replace(tool, offset_length=length)

    def _path(self, step: Workingstep, path: CutterPath, begun: bool) -> bool:
        """Do one toolpath; tell whether it moved."""
        machine = self._machine
        self._canon.source(path.ident)
        if path.functions is not None:
            machine.switch(path.functions)
        if path.kind == "dwell":
            self._wait(path)
            return False
        if path.kind.startswith("connect"):
            self._connect = path.kind
            return False
        pieces = [p.moved(step.frame) for p in path.pieces()]
        if not all(_within(p) for p in pieces):
            raise self._fail(path.ident, "stepnc-range", f"the path leaves ±{MAX_COORDINATE:g} mm")
        rapid = path.rapid or step.rapid
        technology, around = self._technology(step, path, pieces, rapid)
        self._set_speeds(step, path, technology, rapid)
        if not pieces:
            return False
        self._canon.deviation(path.deviation)
        self._go_to(step, path, pieces[0].start, pieces, begun)
        if not rapid:
            self._check_spindle(step, path)
        self._follow(step, path, pieces, (technology, around), rapid)
        self._moved = True
        self._check_swing(path)
        return True

    def _technology(
        self, step: Workingstep, path: CutterPath, pieces: list[Piece], rapid: bool
    ) -> tuple[Technology | None, Technology | None]:
        """Return the technology that a toolpath begins with, and that of a constant cutting speed, which changes along it."""
        technology = path.technology or (None if step.rapid else step.operation.technology)
        if path.technology is not None and step.operation.paths is not None:
            technology = self._rules.applied(path.technology, step.operation.tool or self._machine.tool)
            technology = completed(technology, step.operation.technology)
        if technology is None or not step.operation.kind.startswith(TURNING):
            return technology, None
        check_cutting_speed(technology, self._warn)
        if technology.spindle is None and (technology.cutting_speed or 0.0) > 0 and not rapid:
            self._warn(technology.ident, "stepnc-spindle-sign", NO_SENSE, Severity.NOTE)
        return at_diameter(technology, pieces)

    def _follow(
        self,
        step: Workingstep,
        path: CutterPath,
        pieces: list[Piece],
        told: tuple[Technology | None, Technology | None],
        rapid: bool,
    ) -> None:
        """Follow pieces as their kind demands; `told` is what `_technology` returns."""
        machine, (technology, around) = self._machine, told
        if path.kind == "tap":
            machine.tap(pieces[-1].end, path.pitch)
        elif path.kind == "thread":
            self._canon.synchronise(path.pitch)
            machine.follow(pieces, False)
            self._canon.synchronise(None)
        elif rapid:
            machine.follow(pieces, True)
        elif step.operation.paths is not None and technology and technology.synchronised:
            self._in_step(path, technology, pieces)
        elif around is not None and technology is not None and technology.feed is None:
            self._turned(pieces, around, technology)
        elif step.operation.kind == "probing":
            self._canon.probing(True)
            machine.follow(pieces, False)
            self._canon.probing(False)
        else:
            machine.follow(pieces, False)

    def _wait(self, path: CutterPath) -> None:
        """Turn the spindle as a feedstop says, and wait; one of no time that switches something is that switch alone."""
        if path.technology is not None:
            self._machine.set_speeds(
                speeds(path.technology, self._machine.tool, path.ratio, self._warn)._replace(feed=None)
            )
        seconds = self._seconds(path)
        if seconds > 0.0 or (path.technology is None and path.functions is None):
            self._canon.dwell(seconds)

    def _turned(self, pieces: list[Piece], around: Technology, told: Technology) -> None:
        """Follow pieces at a constant cutting speed: the feed a turn becomes that in time, piece by piece."""
        for piece in (p for whole in pieces for p in stretches(whole)):
            rate = abs(spindle_at(around, radius(piece)))
            self._machine.set_speeds(Speeds((told.feed_per_rev or 0.0) * rate, 0, None))
            self._machine.follow([piece], False)

    def _in_step(self, path: CutterPath, technology: Technology, pieces: list[Piece]) -> None:
        """Follow pieces in step with the spindle; a straight way there and back is a tap's."""
        machine = self._machine
        pitch = technology.feed_per_rev
        if pitch is None and machine.rpm and machine.feed:
            pitch = machine.feed * 60.0 / machine.rpm
        if not pitch:
            text = "feed and spindle are to be in step, and no spindle speed or feed per revolution says how far a turn is"
            raise self._fail(path.ident, "stepnc-no-spindle", text)
        turning = _turning_point(pieces)
        if turning is not None:
            machine.tap(turning, pitch)
            return
        self._canon.synchronise(pitch)
        machine.follow(pieces, False)
        self._canon.synchronise(None)

    def _check_spindle(self, step: Workingstep, path: CutterPath) -> None:
        """Warn of a cut with a standing spindle, once an operation; a tool that is stopped to be drawn out cuts nothing."""
        operation = step.operation
        if self._machine.rpm or operation.kind == "probing" or operation.ident in self._standing:
            return
        stopped = path.technology is not None and path.technology.spindle == 0.0
        if operation.paths is None and stopped:
            return
        self._standing.add(operation.ident)
        asked = operation.technology is not None and operation.technology.spindle == 0.0
        why = "its speed is 0" if asked or stopped else "no technology gives a speed"
        text = f"{_called(operation)} feeds with the spindle standing: {why}"
        self._warn(operation.ident, "stepnc-no-spindle", text)

    def _check_swing(self, path: CutterPath) -> None:
        """Warn where the turning axis had to swing round since the tool passed close by it."""
        (swept, near), self._machine.swing = self._machine.swing, (0.0, 0.0)
        if swept > MAX_SWING and self._machine.kinematics is not None:
            text = f"the tool passes {math.degrees(near):.3g} degrees beside {self._machine.kinematics.turn}, which"
            text += f" swings round by {math.degrees(swept):.0f} degrees there"
            self._warn(path.ident, "stepnc-singular", text)

    def _seconds(self, path: CutterPath) -> float:
        """Return how long a dwell lasts, s; raises `Skip` for an impossible time, and for turns of a spindle that stands."""
        seconds = path.seconds
        if path.turns:
            if not self._machine.rpm:
                raise self._fail(
                    path.ident, "stepnc-no-spindle", "a dwell in turns needs a spindle that turns"
                )
            seconds = path.turns * 60.0 / self._machine.rpm
        if not 0.0 <= seconds <= MAX_DWELL:
            text = f"a dwell of {seconds:g} s; it must be 0 to {MAX_DWELL:g}"
            raise self._fail(path.ident, "stepnc-range", text)
        return seconds

    def _set_speeds(
        self, step: Workingstep, path: CutterPath, technology: Technology | None, rapid: bool
    ) -> None:
        """Set spindle and feed; warn once per operation if a toolpath has the feed of an earlier one."""
        feed = None
        if technology is not None and (not rapid or path.technology is not None):
            tool = step.operation.tool or self._machine.tool
            told = speeds(technology, tool, path.ratio, self._warn)
            for what, value in (("feed (mm/s)", told.feed), ("spindle speed (rev/min)", told.rpm)):
                if value is not None and not value <= MAX_SPEED:
                    text = f"the {what} is {value:g}, more than {MAX_SPEED:g}"
                    raise self._fail(technology.ident, "stepnc-speed", text)
            self._machine.set_speeds(told)
            feed = told.feed
        owner = path.ident if technology is None else technology.ident
        if not rapid and feed is not None and not feed > 0:
            raise self._fail(
                owner, "stepnc-speed", f"the feed is {feed * 60:g} mm/min: the tool never arrives"
            )
        if rapid or feed is not None:
            return
        if not self._machine.feed:
            raise self._fail(owner, "stepnc-no-feed", "no technology gives a feed for this toolpath")
        if path.kind not in ("tap", "thread") and step.operation.ident not in self._carried:
            self._carried.add(step.operation.ident)
            text = f"no technology gives {_called(step.operation)} a feed; the {self._machine.feed * 60:g} mm/min before it hold"
            self._warn(owner, "stepnc-no-feed", text)

    def _go_to(
        self, step: Workingstep, path: CutterPath, start: Floats, pieces: list[Piece], begun: bool
    ) -> None:
        """Bring the tool to where a path begins, by way of the security plane where it is elsewhere."""
        machine, tool_axes = self._machine, self._tool_axes(step, pieces)
        if machine.is_at(start) and machine.points_along(tool_axes):
            return
        if self._connect == "connect direct":
            self._connect = None
            machine.turn(tool_axes)
            machine.traverse(start)
            return
        if begun and self._connect is None and step.operation.paths is not None:
            gap = float(elementary.length(start - machine.position))
            if gap > 0:
                text = f"the toolpath begins {gap:.4f} mm from where the one before it ended; it is reached in rapid"
                self._warn(path.ident, "path-gap", text)
        self._connect = None
        if step.security is not None:
            axis, height = (
                step.security[:3, 2],
                float(elementary.product(step.security[:3, 2], step.security[:3, 3])),
            )
        else:
            axis = np.array([0.0, 0.0, 1.0])
            height = float(elementary.product(self._home, axis))
            if self._moved:
                text = f"no security plane is given; the way to the next toolpath is taken at Z {height:g} mm"
                self._warn(step.ident, "stepnc-no-security-plane", text)
        machine.link(start, axis, tool_axes, height)

    def _tool_axes(self, step: Workingstep, pieces: list[Piece]) -> Floats:
        """Return the directions of the tool along the first piece, shape (n, 3)."""
        axes = getattr(pieces[0], "axes", None)
        if axes is not None:
            return np.asarray(axes)
        tilt = step.operation.tilt
        local = np.array([0.0, 0.0, 1.0]) if tilt is None else tilt
        return np.asarray(elementary.product(step.frame[:3, :3], local))[None, :]


def _turning_point(pieces: list[Piece]) -> Floats | None:
    """Return where a way turns back that goes straight to a point and straight back to its start, None of any other way."""
    if not all(isinstance(p, Polyline) for p in pieces):
        return None
    points = np.concatenate([p.points for p in pieces if isinstance(p, Polyline)])
    way = np.linalg.norm(points - points[0], axis=1)
    far = int(np.argmax(way))
    if not way[far] > 0 or way[-1] > 1e-6:
        return None
    axis = (points[far] - points[0]) / way[far]
    along = elementary.product(points - points[0], axis)
    beside = float(np.abs(points - points[0] - along[:, None] * axis).max())
    straight = (np.diff(along[: far + 1]) >= 0).all() and (np.diff(along[far:]) <= 0).all()
    return points[far] if beside < 1e-6 and straight else None


def _called(operation: Operation) -> str:
    """Return the name of an operation for a message; the place of the message shows one without a name."""
    return repr(operation.label) if operation.label else "the operation"


def _within(piece: Piece) -> bool:
    """Tell whether a piece has coordinates that a machine may have."""
    if isinstance(piece, Polyline):
        points = piece.points
    elif isinstance(piece, Arc):
        points = np.stack([piece.start, piece.end])
        if not np.abs(piece.centre).max() <= 1e3 * MAX_COORDINATE:
            return False
    else:
        points = piece.control
    return bool(np.abs(points).max() <= MAX_COORDINATE)


class _Endless(Exception):
    """The program has used up its steps."""

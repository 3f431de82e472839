"""The workplan as a tree, of text or of plain values: workingsteps with features, tools, speeds, feeds, lengths and times."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.stepnc.entities import Skip
from cncgen.stepnc.execution.canon import Canon
from cncgen.stepnc.geometry.chords import polyline_of
from cncgen.stepnc.geometry.pieces import Arc, Nurbs
from cncgen.stepnc.model import (
    Assignment,
    Branching,
    CuttingTool,
    Executable,
    NcFunction,
    ProgramStructure,
    Workingstep,
)
from cncgen.stepnc.reading import StepFile
from cncgen.toolpath.reading import ReadOptions

Floats = NDArray[np.float64]

_MAX_DEPTH = 40
#: Lines of a tree.
MAX_LINES = 100_000
#: A thousand years, s.
ENDLESS = 3.2e10
#: Feeds and speeds that a line names.
_NAMED = 4


@dataclass(slots=True)
class Work:
    """The work of a workingstep, or of several.

    Attributes:
        motions: Lines, arcs and splines.
        cut, rapid: Length of way at the feed and in rapid, mm.
        seconds: Time at the programmed feeds, without acceleration, and of dwells.
        feeds: mm/min.
        speeds: Spindle speeds, rev/min.
    """

    motions: int = 0
    cut: float = 0.0
    rapid: float = 0.0
    seconds: float = 0.0
    feeds: set[float] = field(default_factory=set)
    speeds: set[float] = field(default_factory=set)

    def text(self) -> str:
        """Return it in words: ``12 motions, 80.0 mm cut, 30.0 mm rapid, 2.1 s``."""
        parts = [f"{self.motions} motion{'' if self.motions == 1 else 's'}"]
        parts += [f"{self.cut:.1f} mm cut"] if self.cut else []
        parts += [f"{self.rapid:.1f} mm rapid"] if self.rapid else []
        parts += [duration(self.seconds)] if self.seconds else []
        return ", ".join(parts)

    def as_json(self) -> dict[str, Any]:
        """Return it as plain values; `time_s` is null where it is endless."""
        found: dict[str, Any] = {
            "motions": self.motions,
            "cut_mm": self.cut,
            "rapid_mm": self.rapid,
            "time_s": self.seconds if self.seconds < ENDLESS else None,
        }
        for key, values in (("feeds_mm_min", self.feeds), ("speeds_rev_min", self.speeds)):
            if values:
                found[key] = sorted(values)
        return found


def duration(seconds: float) -> str:
    """Return a time as ``48.3 s``, ``4:30 min`` or ``2:05:10 h``; over a thousand years as ``endless``."""
    if not seconds < ENDLESS:
        return "endless"
    if seconds < 120:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02d} min"
    return f"{whole // 3600}:{whole % 3600 // 60:02d}:{whole % 60:02d} h"


class Meter(Canon):
    """Listens to an execution and adds up what is done in each workingstep.

    Attributes:
        steps: By the number of the workingstep's entity.
    """

    def __init__(self) -> None:
        self.steps: dict[int, Work] = {}
        self._now = Work()
        self._feed = 0.0
        self._rpm: float | None = None
        self._position: Floats = np.zeros(3)

    def workingstep(self, step: Workingstep) -> None:
        """Add what follows to a workingstep."""
        self._now = self.steps.setdefault(step.ident, Work())

    def begin(self, position: Floats) -> None:
        """Begin there."""
        self._position = position[:3]

    def feed(self, speed: float) -> None:
        """Move at this speed, mm/s, from now on."""
        self._feed = speed

    def spindle(self, direction: int, rpm: float | None) -> None:
        """Note the speed of later cuts."""
        self._rpm = self._rpm if rpm is None else rpm
        if direction == 0:
            self._rpm = None

    def _add(self, length: float, count: int, rapid: bool) -> None:
        now = self._now
        now.motions += count
        if rapid:
            now.rapid += length
            return
        now.cut += length
        if self._feed > 0:
            now.feeds.add(round(self._feed * 60, 6))
            now.seconds += length / self._feed
        if self._rpm is not None:
            now.speeds.add(round(self._rpm, 3))

    def _straight(self, points: Floats, rapid: bool) -> None:
        rows = np.concatenate([self._position[None, :], points[:, :3]])
        self._add(float(np.linalg.norm(np.diff(rows, axis=0), axis=1).sum()), len(points), rapid)
        self._position = points[-1, :3]

    def traverse(self, points: Floats) -> None:
        """Add rapid lines."""
        self._straight(points, True)

    def lines(self, points: Floats) -> None:
        """Add lines at the feed."""
        self._straight(points, False)

    def arc(self, arc: Arc, end: Floats, rapid: bool) -> None:
        """Add an arc or a helix."""
        rise = float(elementary.product(arc.end - arc.start, arc.normal))
        length = float(np.hypot(elementary.length(arc.start - arc.centre) * arc.sweep, rise))
        self._add(length, 1, rapid)
        self._position = end[:3]

    def nurbs(self, curve: Nurbs, control: Floats, rapid: bool) -> None:
        """Add a spline, measured by chords of 1e-3 mm."""
        points = polyline_of(curve, 1e-3).points
        self._add(float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()), 1, rapid)
        self._position = curve.end

    def rigid_tap(self, end: Floats, pitch: float) -> None:
        """Add the way of a tap there and back."""
        self._add(2 * float(elementary.length(end[:3] - self._position)), 2, False)

    def dwell(self, seconds: float) -> None:
        """Add a dwell's time."""
        self._now.seconds += seconds


@dataclass(slots=True)
class WorkplanEntry:
    """An executable of a workplan.

    Attributes:
        kind: ``workplan``, ``workingstep``, ``if``, ``while``, ``assignment`` or the name of a function; "" of one that has errors.
        label: Its name in the file; of an assignment the variable.
        ident: Number of its entity.
        work: The work below it; None where that is not counted.
        step: Of a workingstep.
        children: The executables within it.
        deeper: It holds others that are nested deeper than is listed.
    """

    kind: str
    label: str
    ident: int
    work: Work | None = None
    step: Workingstep | None = None
    children: list[WorkplanEntry] = field(default_factory=list)
    deeper: bool = False

    def lines(self, depth: int = 0) -> Iterator[str]:
        """Yield it and those that it holds as text, indented by depth."""
        indent = "  " * depth
        if not self.kind:
            yield f"{indent}#{self.ident}: has errors"
        elif self.step is not None:
            yield f"{indent}workingstep {self.label!r} (#{self.ident}): {_step_text(self.step, self.work or Work())}"
        elif self.kind == "assignment":
            yield f"{indent}assignment to {self.label} (#{self.ident})"
        else:
            work = f": {self.work.text()}" if self.work is not None else ""
            yield f"{indent}{self.kind} {self.label!r} (#{self.ident}){work}"
        for child in self.children:
            yield from child.lines(depth + 1)
        if self.deeper:
            yield f"{indent}  …"

    def as_json(self) -> dict[str, Any]:
        """Return it and those that it holds as plain values; keys that say nothing are left out."""
        found: dict[str, Any] = {"kind": self.kind or "faulty", "name": self.label, "entity": self.ident}
        if self.step is not None:
            found |= _step_values(self.step)
        if self.work is not None:
            found |= self.work.as_json()
        if self.children:
            found["children"] = [child.as_json() for child in self.children]
        return found


def tree(
    source: str | os.PathLike[str] | BinaryIO | bytes, name: str = "-", options: ReadOptions | None = None
) -> Iterator[str]:
    """Yield the workplan of a program, a line an executable: indented, with feature, tool, feed, length and time.

    Times are those of the programmed feeds, without acceleration and rapids (`cncgen plan` has those). A workplan's are
    those of all that it holds.

    Raises:
        UsageError: where the file cannot be read.
    """
    yield from islice((line for entry in entries(source, name, options) for line in entry.lines()), MAX_LINES)


def entries(
    source: str | os.PathLike[str] | BinaryIO | bytes, name: str = "-", options: ReadOptions | None = None
) -> list[WorkplanEntry]:
    """Return the workplans of a program as records, at most `MAX_LINES` of them; otherwise as `tree`."""
    file = StepFile(source, name, options or ReadOptions())
    meter = Meter()
    for _ in file.execute(meter):
        pass
    listing = _Listing(file, meter)
    return [entry for root in file.reader.roots() if (entry := listing.entry(root, 0)) is not None]


class _Listing:
    """Makes the records of executables."""

    def __init__(self, file: StepFile, meter: Meter) -> None:
        self._file = file
        self._meter = meter
        self._room = MAX_LINES

    def entry(self, item: Executable, depth: int) -> WorkplanEntry | None:
        """Return the record of an executable and of those that it holds; None beyond `MAX_LINES`."""
        if self._room <= 0:
            return None
        self._room -= 1
        if isinstance(item, ProgramStructure):
            sums = self._all(item, 0) if item.kind == "workplan" else None
            made = WorkplanEntry(item.kind, item.label, item.ident, sums)
            self._fill(made, item.children, item.context, depth)
            return made
        if isinstance(item, Branching):
            made = WorkplanEntry("while" if item.loop else "if", item.label, item.ident)
            branches = tuple(branch for branch in (item.then, item.otherwise) if branch is not None)
            self._fill(made, branches, item.context, depth)
            return made
        if isinstance(item, Workingstep):
            work = self._meter.steps.get(item.ident, Work())
            return WorkplanEntry("workingstep", item.label, item.ident, work, item)
        if isinstance(item, Assignment):
            return WorkplanEntry("assignment", item.variable, item.ident)
        return WorkplanEntry(item.kind, item.label, item.ident) if isinstance(item, NcFunction) else None

    def _fill(self, entry: WorkplanEntry, children: tuple[int, ...], context: Any, depth: int) -> None:
        """Add the records of the executables that one holds."""
        if depth >= _MAX_DEPTH:
            entry.deeper = bool(children)
            return
        for ident in children:
            try:
                child = self.entry(self._file.reader.executable(ident, context), depth + 1)
            except Skip:
                child = WorkplanEntry("", "", ident)
            if child is not None:
                entry.children.append(child)

    def _all(self, block: ProgramStructure, depth: int) -> Work:
        """Return the sum of the workingsteps below a block."""
        total = Work()
        for ident in self._steps_below(block.children, block.context, depth, {}):
            done = self._meter.steps[ident]
            total.motions += done.motions
            total.cut += done.cut
            total.rapid += done.rapid
            total.seconds += done.seconds
        return total

    def _steps_below(
        self, children: tuple[int, ...], context: Any, depth: int, seen: dict[int, None]
    ) -> dict[int, None]:
        """Return the workingsteps that were executed below, each once."""
        for ident in children if depth <= _MAX_DEPTH else ():
            if ident in seen:
                continue
            try:
                item = self._file.reader.executable(ident, context)
            except Skip:
                continue
            if ident in self._meter.steps:
                seen[ident] = None
            elif isinstance(item, ProgramStructure):
                self._steps_below(item.children, item.context, depth + 1, seen)
            elif isinstance(item, Branching):
                branches = tuple(b for b in (item.then, item.otherwise) if b is not None)
                self._steps_below(branches, item.context, depth + 1, seen)
        return seen


def _step_text(step: Workingstep, work: Work) -> str:
    """Return operation, feature, tool, speeds, feeds and work of a workingstep in words."""
    what = "rapid" if step.rapid else step.operation.kind
    if step.feature is not None:
        what += f" of {step.feature.kind} {step.feature.label!r}"
    parts = [what]
    if step.operation.tool is not None:
        parts.append(_tool(step.operation.tool))
    for values, format_ in ((work.speeds, "{} rev/min"), (work.feeds, "feed {} mm/min")):
        if values:
            parts.append(format_.format(_some(values)))
    parts.append(work.text())
    return ", ".join(parts)


def _step_values(step: Workingstep) -> dict[str, Any]:
    """Return operation, feature and tool of a workingstep as plain values."""
    found: dict[str, Any] = {"operation": "rapid" if step.rapid else step.operation.kind}
    if step.feature is not None:
        found["feature"] = {"kind": step.feature.kind, "name": step.feature.label}
    tool = step.operation.tool
    if tool is not None:
        found["tool"] = {"name": tool.name, "kind": tool.kind, "diameter_mm": tool.diameter}
    return found


def _tool(tool: CuttingTool) -> str:
    details = [tool.kind] if tool.kind else []
    details += [f"{tool.diameter:g} mm"] if tool.diameter is not None else []
    return f"tool {tool.name!r}" + (f" ({' '.join(details)})" if details else "")


def _some(values: set[float]) -> str:
    shown = sorted(values)
    return ", ".join(f"{v:g}" for v in shown[:_NAMED]) + (" …" if len(shown) > _NAMED else "")

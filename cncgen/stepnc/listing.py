"""The workplan as a tree of text: workingsteps with tool, feeds, motions and times."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from cncgen.stepnc.entities import Skip
from cncgen.stepnc.execution.linearize import polyline_of
from cncgen.stepnc.geometry.pieces import Arc, Nurbs
from cncgen.stepnc.model import (
    Assignment,
    Block,
    Choice,
    Executable,
    NcFunction,
    Paths,
    Tool,
    Workingstep,
)
from cncgen.stepnc.reading import Source
from cncgen.toolpath.reading import ReadOptions

Floats = NDArray[np.float64]
_MAX_DEPTH = 40
#: Lines of a tree.
MAX_LINES = 100_000


@dataclass(slots=True)
class _Meter:
    """Listens to an execution and adds up, for each entity, feeds, lengths and times."""

    owner: int = 0
    feed_now: float = 0.0
    position: Floats = field(default_factory=lambda: np.zeros(3))
    feeds: dict[int, set[float]] = field(default_factory=dict)
    seconds: dict[int, float] = field(default_factory=dict)
    lengths: dict[int, float] = field(default_factory=dict)
    motions: dict[int, int] = field(default_factory=dict)

    def _add(self, length: float, count: int, rapid: bool) -> None:
        self.motions[self.owner] = self.motions.get(self.owner, 0) + count
        self.lengths[self.owner] = self.lengths.get(self.owner, 0.0) + length
        if not rapid and self.feed_now > 0:
            self.feeds.setdefault(self.owner, set()).add(self.feed_now)
            self.seconds[self.owner] = self.seconds.get(self.owner, 0.0) + length / self.feed_now

    def source(self, ident: int) -> None:
        self.owner = ident

    def begin(self, position: Floats) -> None:
        self.position = position[:3]

    def feed(self, speed: float) -> None:
        self.feed_now = speed

    def _straight(self, points: Floats, rapid: bool) -> None:
        rows = np.concatenate([self.position[None, :], points[:, :3]])
        self._add(float(np.linalg.norm(np.diff(rows, axis=0), axis=1).sum()), len(points), rapid)
        self.position = points[-1, :3]

    def traverse(self, points: Floats) -> None:
        self._straight(points, True)

    def lines(self, points: Floats) -> None:
        self._straight(points, False)

    def arc(self, arc: Arc, end: Floats, rapid: bool) -> None:
        rise = float((arc.end - arc.start) @ arc.normal)
        length = float(np.hypot(np.linalg.norm(arc.start - arc.centre) * arc.sweep, rise))
        self._add(length, 1, rapid)
        self.position = end[:3]

    def nurbs(self, curve: Nurbs, control: Floats, rapid: bool) -> None:
        points = polyline_of(curve, 1e-3).points
        self._add(float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()), 1, rapid)
        self.position = curve.end

    def dwell(self, seconds: float) -> None:
        self.seconds[self.owner] = self.seconds.get(self.owner, 0.0) + seconds

    def change_tool(self, tool: Tool) -> None:
        """Take no notice."""

    def spindle(self, direction: int, rpm: float | None) -> None:
        """Take no notice."""

    def coolant(self, flood: bool, mist: bool, through: bool) -> None:
        """Take no notice."""

    def stop(self, optional: bool) -> None:
        """Take no notice."""

    def message(self, text: str) -> None:
        """Take no notice."""

    def function(self, name: str, value: object) -> None:
        """Take no notice."""

    def end(self) -> None:
        """Take no notice."""


def tree(
    source: Path | BinaryIO | bytes, name: str = "-", options: ReadOptions | None = None
) -> Iterator[str]:
    """Yield the workplan of a program, a line an executable: indented, with tool, feeds, length and cutting time.

    Times are those of the programmed feeds, without acceleration and rapids (`cncgen plan` has those). An operation that
    several workingsteps do shows the sum of all.

    Raises:
        UsageError: where the file cannot be read.
    """
    file = Source(source, name, options or ReadOptions())
    meter = _Meter()
    for _ in file.execute(meter):
        pass
    lines = (line for root in file.reader.roots() for line in _lines(file, root, meter, 0))
    yield from islice(lines, MAX_LINES)


def _lines(file: Source, item: Executable, meter: _Meter, depth: int) -> Iterator[str]:
    indent = "  " * depth
    if depth > _MAX_DEPTH:
        yield f"{indent}…"
    elif isinstance(item, Block):
        yield f"{indent}{item.kind} {item.label!r} (#{item.ident})"
        for child in item.children:
            yield from _child(file, child, item.context, meter, depth + 1)
    elif isinstance(item, Choice):
        yield f"{indent}{'while' if item.loop else 'if'} {item.label!r} (#{item.ident})"
        for branch in (item.then, item.otherwise):
            if branch is not None:
                yield from _child(file, branch, item.context, meter, depth + 1)
    elif isinstance(item, Workingstep):
        yield indent + _step(item, meter)
    elif isinstance(item, Assignment):
        yield f"{indent}assignment to {item.variable} (#{item.ident})"
    elif isinstance(item, NcFunction):
        yield f"{indent}{item.kind} {item.label!r} (#{item.ident})"


def _child(file: Source, ident: int, context: Any, meter: _Meter, depth: int) -> Iterator[str]:
    try:
        yield from _lines(file, file.reader.executable(ident, context), meter, depth)
    except Skip:
        yield f"{'  ' * depth}#{ident}: has errors"


def _step(step: Workingstep, meter: _Meter) -> str:
    operation = step.operation
    paths = operation.paths or ()
    owners = {operation.ident, *(paths.idents if isinstance(paths, Paths) else [p.ident for p in paths])}
    feeds = sorted({round(f * 60, 6) for o in owners for f in meter.feeds.get(o, ())})
    parts = ["rapid" if step.rapid else operation.kind]
    if operation.tool is not None:
        parts.append(f"tool {operation.tool.name!r}")
    if feeds:
        shown = ", ".join(f"{f:g}" for f in feeds[:4]) + (" …" if len(feeds) > 4 else "")
        parts.append(f"feed {shown} mm/min")
    motions = sum(meter.motions.get(o, 0) for o in owners)
    length = sum(meter.lengths.get(o, 0.0) for o in owners)
    parts.append(f"{motions} motions, {length:.1f} mm")
    seconds = sum(meter.seconds.get(o, 0.0) for o in owners)
    if seconds:
        parts.append(f"{seconds:.1f} s")
    return f"workingstep {step.label!r} (#{step.ident}): " + ", ".join(parts)

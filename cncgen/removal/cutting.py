"""Cutting a stock along a program: events set tool and spindle, stretches between them go to the kernel."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import removal as kernel
from cncgen.removal.cutters import cutter_of_event
from cncgen.removal.findings import Findings
from cncgen.removal.record import Cutter, Field, OperationCut, Removal, Target
from cncgen.removal.sweeps import Lines, lines_of
from cncgen.toolpath.lines import lines_alone
from cncgen.toolpath.record import Event, Kind, Toolpath

Floats = NDArray[np.float64]

#: Distance of chords from arcs and splines, in cells, and at most, mm.
CHORD_CELLS, CHORD = 0.02, 0.005
#: Touches less deep than this do not count, mm.
LEVEL = 0.02
#: Material left in a column that does not count where all is to go, mm, beside the cell.
LEFT = 0.02


@dataclass(slots=True)
class _State:
    """The state of the machine between two motions."""

    cutter: Cutter | None = None
    tool: str = ""
    direction: int = 0
    tapping: bool = False


@dataclass(slots=True)
class Cutting:
    """Cuts a field along toolpaths, in order.

    Attributes:
        stock: Cut in place.
        name: Of the program, for findings.
        target: The material that is to stay, None where it is not known.
        cutters: Tools by name that count before those of the program.
    """

    stock: Field
    name: str
    target: Target | None = None
    cutters: Mapping[str, Cutter] = field(default_factory=dict)
    _state: _State = field(default_factory=_State)
    _operations: list[OperationCut] = field(default_factory=list)
    _pending: str = ""
    _times: list[Floats] = field(default_factory=list)
    _rates: list[Floats] = field(default_factory=list)
    _now: float = 0.0

    def run(self, toolpaths: Iterable[Toolpath]) -> Removal:
        """Cut along toolpaths and return what is left and what is wrong."""
        stock = self.stock
        part = np.full(stock.top.shape, -np.inf)
        if self.target is not None:
            x, y = np.broadcast_arrays(stock.x[None, :], stock.y[:, None])
            part = np.ascontiguousarray(np.minimum(self.target.floor(x, y), stock.top))
        grid = np.array([*stock.origin, stock.cell])
        findings = Findings(self.name, stock)
        for path in lines_alone(toolpaths, min(CHORD_CELLS * stock.cell, CHORD)):
            events = np.flatnonzero(path.kind == Kind.EVENT).tolist()
            for begin, end in zip([-1, *events], [*events, len(path)], strict=True):
                if begin >= 0:
                    self._event(path.events[int(path.curve[begin])], int(path.line[begin]))
                if end > begin + 1:
                    self._stretch(lines_of(path, begin + 1, end), part, grid, findings)
        if self.target is not None:
            findings.left(self.target, LEFT)
        findings.close()
        times = np.concatenate([np.zeros(0), *self._times])
        rates = np.concatenate([np.zeros(0), *self._rates])
        return Removal(stock, tuple(self._operations), tuple(findings.found), times, rates)

    def _event(self, event: Event, line: int) -> None:
        state, values = self._state, event.values
        if event.name == "tool":
            state.tool = str(values.get("tool", ""))
            state.cutter = self.cutters.get(state.tool) or cutter_of_event(values)
            state.direction = 0 if event.rest else state.direction
            if not self._pending:
                self._operations.append(OperationCut(f"tool {state.tool}", line, state.tool))
        elif event.name == "workingstep":
            self._pending = str(values.get("label", ""))
            self._operations.append(OperationCut(self._pending, line, state.tool))
        elif event.name == "spindle" and "direction" in values:
            state.direction = int(values["direction"])
        elif event.name == "synchronise":
            state.tapping = bool(values.get("tap"))

    def _stretch(self, lines: Lines, part: Floats, grid: Floats, findings: Findings) -> None:
        """Cut along lines with the tool that is in the spindle."""
        state, stock = self._state, self.stock
        if not self._operations:
            self._operations.append(OperationCut("program", int(lines.line[0]), state.tool))
        operation = self._operations[-1]
        operation.tool = state.tool
        cutter = state.cutter or self.cutters.get("*")
        if cutter is None:
            findings.no_tool(state.tool, lines)
            return
        out = np.empty((len(lines.ends), kernel.COLUMNS))
        if cutter.holder is not None:
            findings.holder(lines, self._beside(lines, grid, *cutter.holder), operation, "holder")
        if cutter.shank is not None and cutter.shank > cutter.radius and math.isfinite(cutter.cutting_length):
            reached = self._beside(lines, grid, cutter.shank, cutter.cutting_length)
            findings.holder(lines, reached, operation, "shank")
        limits = np.array([min(0.6 * stock.cell, 0.5 * cutter.radius), LEVEL])
        arrays = (stock.heights, stock.mean, stock.top, stock.bottom, part, grid)
        kernel.cut_lines(*arrays, lines.ends, cutter.values, limits, out)
        findings.judge(lines, out, operation, cutter, 0 if state.tapping else state.direction, state.tapping)
        cutting = (out[:, 0] > 0) & ~lines.rapid
        operation.volume_mm3 += float(out[:, 0].sum())
        operation.cutting_s += float(lines.seconds[cutting].sum())
        operation.deepest_mm = max(operation.deepest_mm, float(out[:, 1].max(initial=0.0)))
        with np.errstate(divide="ignore", invalid="ignore"):
            rate = np.where(lines.seconds > 0, out[:, 0] / lines.seconds, 0.0)
        self._times.append(self._now + np.cumsum(lines.seconds))
        self._rates.append(rate)
        self._now += float(lines.seconds.sum())

    def _beside(self, lines: Lines, grid: Floats, radius: float, above: float) -> Floats:
        out = np.empty((len(lines.ends), 3))
        kernel.highest_beside(self.stock.heights, grid, lines.ends, radius, above, out)
        return out

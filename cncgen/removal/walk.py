"""The loop over a program: events set tool and spindle, and each stretch between them is cut."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cncgen.removal.cutters import cutter_of_event, insert_of_event
from cncgen.removal.findings import Findings
from cncgen.removal.record import Cutter, Dexels, Field, Insert, Met, OperationCut, Removal, Turned
from cncgen.removal.sweeps import Lines, lines_of
from cncgen.toolpath.lines import lines_alone
from cncgen.toolpath.record import Event, Kind, Toolpath

Floats = NDArray[np.float64]


@dataclass(slots=True)
class _State:
    """The state of the machine between two motions."""

    cutter: Cutter | Insert | None = None
    tool: str = ""
    direction: int = 0
    tapping: bool = False
    threading: bool = False
    left_handed: bool | None = None


class CutWalk(ABC):
    """Walks over toolpaths, in order, and cuts.

    Args:
        name: Of the program, for findings.
        cutters: Tools by name that count before those of the program.
    """

    #: What is said of a tool that is not known, and of one that cannot cut here; and how to name those that can.
    UNKNOWN = "the diameter of tool {} is not known"
    UNFIT = "tool {} is for lathes, and the program does not turn its work"
    #: The same of a tool that may pass between the middles of all cells.
    NARROW = "tool {} of {:g} mm is narrower than a cell of {:g} mm, which cannot show what it cuts"
    FINER = "a smaller --cell shows its cuts; is the size of the tool in mm?"
    TOOLS = "--tool '{0}=flat:D' names it (on a lathe {0}=turn:NOSE,TRAILING), or a tool table with diameters"

    def __init__(self, name: str, cutters: Mapping[str, Cutter | Insert] | None) -> None:
        self.name = name
        self.cutters = cutters or {}
        self.findings = Findings(name)
        self._state = _State()
        self._operations: list[OperationCut] = []
        self._pending = ""
        self._times: list[Floats] = []
        self._rates: list[Floats] = []
        self._now = self._narrowest = 0.0

    def walk(self, toolpaths: Iterable[Toolpath], chord: float, narrowest: float = 0.0) -> None:
        """Cut along toolpaths, arcs and splines as lines within a chord, mm; cuts of milling tools below a diameter are left out."""
        self._narrowest = narrowest
        for path in lines_alone(toolpaths, chord):
            events = np.flatnonzero(path.kind == Kind.EVENT).tolist()
            for begin, end in zip([-1, *events], [*events, len(path)], strict=True):
                if begin >= 0:
                    self._event(path.events[int(path.curve[begin])], int(path.line[begin]))
                if end > begin + 1:
                    self._stretch(self._lines(path, begin + 1, end))

    def result(self, stock: Field | Turned | Dexels, raw_mm3: float) -> Removal:
        """Return the part of a raw volume that was cut, mm³."""
        self.findings.close()
        times = np.concatenate([np.zeros(0), *self._times])
        rates = np.concatenate([np.zeros(0), *self._rates])
        return Removal(stock, tuple(self._operations), tuple(self.findings.found), times, rates, raw_mm3)

    def _event(self, event: Event, line: int) -> None:
        state, values = self._state, event.values
        if event.name == "tool":
            state.tool = str(values.get("tool", ""))
            made = insert_of_event(values) or cutter_of_event(values)
            state.cutter = self.cutters.get(state.tool) or made
            state.direction = 0 if event.rest else state.direction
            if not self._pending:
                self._operations.append(OperationCut(f"tool {state.tool}", line, state.tool))
        elif event.name == "workingstep":
            self._pending = str(values.get("label", ""))
            state.left_handed = values.get("left_handed")
            self._operations.append(OperationCut(self._pending, line, state.tool))
        elif event.name == "setup":
            self._setup(int(values["number"]))
        elif event.name == "spindle" and "direction" in values:
            state.direction = int(values["direction"])
        elif event.name == "synchronise":
            state.tapping = bool(values.get("tap"))
            state.threading = values.get("pitch_mm") is not None and not state.tapping

    def _lines(self, path: Toolpath, begin: int, end: int) -> Lines:
        """Return the motions among the rows `begin` to `end` of a toolpath."""
        return lines_of(path, begin, end)

    def _cutter(self) -> Cutter | Insert | None:
        """Return the tool in the spindle, None if unknown; a turning tool as it stands in the workingstep."""
        cutter, left = self._state.cutter or self.cutters.get("*"), self._state.left_handed
        if isinstance(cutter, Insert) and left is not None and not cutter.width:
            return replace(cutter, left=left)
        return cutter

    @abstractmethod
    def _setup(self, number: int) -> None:
        """Go on in another clamping."""

    @abstractmethod
    def _cut(self, lines: Lines, cutter: Cutter | Insert, operation: OperationCut) -> Met | None:
        """Cut along lines; return the findings of each, or None if the tool cannot cut."""

    def _stretch(self, lines: Lines) -> None:
        """Cut along lines with the tool that is in the spindle."""
        state = self._state
        if not self._operations:
            self._operations.append(OperationCut("program", int(lines.line[0]), state.tool))
        operation = self._operations[-1]
        operation.tool = state.tool
        cutter = self._cutter()
        if isinstance(cutter, Cutter) and 2.0 * cutter.radius < self._narrowest:
            why = self.NARROW.format("{}", 2.0 * cutter.radius, self._narrowest)
            self.findings.no_tool("cut-narrow", state.tool or "*", lines, why, self.FINER)
            return
        met = None if cutter is None else self._cut(lines, cutter, operation)
        if cutter is None or met is None:
            why = self.UNKNOWN if cutter is None else self.UNFIT
            self.findings.no_tool("cut-tool", state.tool or "*", lines, why, self.TOOLS)
            return
        self.findings.judge(
            lines, met, operation, cutter, 0 if state.tapping else state.direction, state.tapping
        )
        cutting = (met.volume > 0) & ~lines.rapid
        operation.volume_mm3 += float(met.volume.sum())
        operation.cutting_s += float(lines.seconds[cutting].sum())
        operation.deepest_mm = max(operation.deepest_mm, float(met.depth.max(initial=0.0)))
        with np.errstate(divide="ignore", invalid="ignore"):
            rate = np.where(lines.seconds > 0, met.volume / lines.seconds, 0.0)
        self._times.append(self._now + np.cumsum(lines.seconds))
        self._rates.append(rate)
        self._now += float(lines.seconds.sum())

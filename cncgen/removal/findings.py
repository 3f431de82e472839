"""The faults of a cut as diagnostics: one for each fault of a source line, with place, depth and volume."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Severity, Span
from cncgen.removal.record import Cutter, Field, Insert, Met, OperationCut, Target
from cncgen.removal.sweeps import Lines

Floats = NDArray[np.float64]

#: Touches less deep than this do not count, mm.
LEVEL = 0.02
#: Findings of one kind that are listed; the rest is counted.
MAX_TOLD = 50
#: Places where material is left that are listed, the largest first, and the least columns of a place.
MAX_PLACES = 10
LEAST_COLUMNS = 3

_TEXTS = {
    "cut-rapid": "a rapid motion enters the stock",
    "cut-gouge": "the tool cuts into the finished part",
    "cut-spindle": "the tool cuts with the spindle standing",
    "cut-spindle-direction": "the tool cuts with the spindle turning the wrong way",
    "cut-plunge": "a tool whose edges do not reach its middle goes down too steeply",
    "cut-shank": "material stands above the cutting edge",
    "cut-holder": "the holder enters the stock",
}


@dataclass(slots=True)
class _CutFault:
    """A fault of one source line, or of one operation: from its first line to its last."""

    line: int
    operation: str
    tool: str
    depth: float = 0.0
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    volume: float = 0.0
    motions: int = 0
    last: int = 0


@dataclass(slots=True)
class _LeftOut:
    """Motions with a tool that does not cut: the code of the finding, their first line, what helps, and their way at the feed."""

    code: str
    line: int
    hint: str
    feed_mm: float = 0.0


@dataclass(slots=True)
class Findings:
    """Collects the faults of a program.

    Attributes:
        name: Of the program.
        found: Diagnostics, complete after `close`.
    """

    name: str
    found: list[Diagnostic] = field(default_factory=list)
    _faults: dict[tuple[str, int, str], _CutFault] = field(default_factory=dict)
    _unknown: dict[tuple[str, str], _LeftOut] = field(default_factory=dict)

    def no_tool(self, code: str, name: str, lines: Lines, why: str, hint: str) -> None:
        """Note motions that are left out, as their tool does not cut, and why."""
        left = self._unknown.setdefault((name, why), _LeftOut(code, int(lines.line[0]), hint))
        at_feed = lines.ends[~lines.rapid]
        left.feed_mm += float(np.linalg.norm(at_feed[:, 3:] - at_feed[:, :3], axis=1).sum())

    def judge(
        self,
        lines: Lines,
        met: Met,
        operation: OperationCut,
        cutter: Cutter | Insert,
        direction: int,
        tapping: bool,
    ) -> None:
        """Note the faults of motions by their findings."""
        bites, line = met.depth > LEVEL, lines.line.tolist()
        for k in np.flatnonzero(bites & lines.rapid).tolist():
            self._note("cut-rapid", line[k], operation, met.depth[k], met.at[k], met.volume[k])
        for k in np.flatnonzero(met.gouge > LEVEL).tolist():
            self._note("cut-gouge", line[k], operation, met.gouge[k], met.gouge_at[k], met.gouged[k])
        for k in np.flatnonzero(met.above > LEVEL).tolist():
            self._note("cut-shank", line[k], operation, met.above[k], met.at[k])
        if tapping:
            return
        if isinstance(cutter, Cutter) and cutter.steepest < np.pi / 2:
            for k in np.flatnonzero(
                bites & ~lines.rapid & (_ways_down(lines) > cutter.steepest + 1e-6)
            ).tolist():
                self._note("cut-plunge", line[k], operation, met.depth[k], met.at[k], met.volume[k])
        code = "cut-spindle" if direction == 0 else "cut-spindle-direction"
        # A tool that stands cuts with the work turning either way.
        turning = isinstance(cutter, Cutter) and (direction > 0) == cutter.left_handed
        if direction == 0 or turning:
            wrong = np.flatnonzero(bites & ~lines.rapid)
            if len(wrong):
                k = int(wrong[met.depth[wrong].argmax()])
                volume, first, last = float(met.volume[wrong].sum()), line[wrong[0]], line[wrong[-1]]
                found = self._note(code, first, operation, met.depth[k], met.at[k], volume, operation.line)
                found.motions += len(wrong) - 1
                found.last = last

    def beside(
        self, lines: Lines, heights: Floats, places: Floats, operation: OperationCut, what: str
    ) -> None:
        """Note where material stands beside a shank or holder, and how high, shapes (n, 3) and (n,)."""
        for k in np.flatnonzero(heights > LEVEL).tolist():
            self._note(f"cut-{what}", int(lines.line[k]), operation, heights[k], places[k])

    def _note(
        self,
        code: str,
        line: int,
        operation: OperationCut,
        depth: float,
        place: Floats,
        volume: float = 0.0,
        owner: int | None = None,
    ) -> _CutFault:
        """Add a motion to the fault of its line, or of the operation whose line is the owner; return the fault."""
        fault = self._faults.setdefault(
            (code, line if owner is None else owner, operation.name),
            _CutFault(line, operation.name, operation.tool),
        )
        fault.motions += 1
        fault.volume += float(volume)
        if depth > fault.depth:
            fault.depth = float(depth)
            fault.place = (float(place[0]), float(place[1]), float(place[2]))
        return fault

    def left(self, stock: Field, target: Target, allowed: float) -> None:
        """Note where more is left than a target demands, place by place."""
        x, y = np.broadcast_arrays(stock.x[None, :], stock.y[:, None])
        over = stock.heights - np.maximum(target.demanded(x, y), stock.bottom)
        self.places_left(stock, target, over, np.maximum(over, 0.0) * stock.cell**2, allowed)

    def places_left(
        self, stock: Field, target: Target, over: Floats, volumes: Floats, allowed: float
    ) -> None:
        """Note places where material is thicker than demanded by more than the allowance.

        Args:
            stock: Columns that hold it.
            target: Names the feature that demands it.
            over: Thickness over each, mm.
            volumes: In each, mm³.
            allowed: mm.
        """
        from scipy.ndimage import find_objects, label

        places, count = label(over > allowed)
        told: list[tuple[float, Diagnostic]] = []
        for k, box in enumerate(find_objects(places), start=1):
            inside = places[box] == k
            if int(inside.sum()) < LEAST_COLUMNS:
                continue
            heights = np.where(inside, over[box], 0.0)
            volume = float(np.where(inside, volumes[box], 0.0).sum())
            j, i = np.unravel_index(int(heights.argmax()), heights.shape)
            j, i = int(j) + box[0].start, int(i) + box[1].start
            place = (float(stock.x[i]), float(stock.y[j]), float(stock.heights[j, i]))
            size = float(heights.max()), f"{float(heights.max()):.3f} mm high, {volume:.3g} mm³"
            told.append((volume, self.left_at(*size, volume, place, target.owner(*place[:2]))))
        told.sort(key=lambda item: -item[0])
        self.found += [d for _, d in told[:MAX_PLACES]]
        if count and len(told) > MAX_PLACES:
            text = f"material is left at {len(told) - MAX_PLACES} more places"
            self.found.append(Diagnostic("cut-left", text, Severity.WARNING, Span(self.name, 1)))

    def left_at(
        self,
        depth: float,
        size: str,
        volume: float,
        place: tuple[float, float, float],
        owner: tuple[str, int],
    ) -> Diagnostic:
        """Return the finding of a place where more is left than its owner demands, mm and mm³."""
        name, line = owner
        text = f"material is left where a feature demands none: {size}, at {_at(place)}"
        text += f" ({name!r})" if name else ""
        values = {"depth_mm": depth, "volume_mm3": volume, "place_mm": place, "operation": name}
        return Diagnostic("cut-left", text, Severity.WARNING, Span(self.name, line), values=values)

    def close(self) -> None:
        """Make diagnostics of the faults, those of a line together."""
        told: dict[str, int] = {}
        first = []
        for (code, *_), fault in sorted(self._faults.items(), key=lambda item: (item[0][0], item[1].line)):
            told[code] = told.get(code, 0) + 1
            if told[code] <= MAX_TOLD:
                first.append(self._diagnostic(code, fault))
        for code, count in told.items():
            if count > MAX_TOLD:
                text = f"{_TEXTS[code]} in {count - MAX_TOLD} more lines"
                first.append(Diagnostic(code, text, _severity(code), Span(self.name, 1)))
        for (name, why), left in self._unknown.items():
            # A tool may rapid to where it is changed without a size; a cut that is left out is not judged, and misleads what follows.
            severity = Severity.ERROR if left.feed_mm else Severity.WARNING
            text = f"{why.format(repr(name))}; its motions are left out, {left.feed_mm:.6g} mm of them at the feed"
            values = {"tool": name, "left_out_feed_mm": left.feed_mm}
            span, hint = Span(self.name, left.line), left.hint.format(name)
            first.append(Diagnostic(left.code, text, severity, span, hint=hint, values=values))
        self.found[:0] = first

    def _diagnostic(self, code: str, fault: _CutFault) -> Diagnostic:
        text = f"{_TEXTS[code]}, {fault.depth:.3f} mm deep at {_at(fault.place)}"
        text += f", {fault.volume:.3g} mm³" if fault.volume > 0 else ""
        text += f" ({fault.operation!r}, tool {fault.tool!r}"
        text += f", {fault.motions} motions" if fault.motions > 1 else ""
        text += f" to line {fault.last})" if fault.last > fault.line else ")"
        values = {
            "depth_mm": fault.depth,
            "volume_mm3": fault.volume,
            "place_mm": fault.place,
            "operation": fault.operation,
            "tool": fault.tool,
            "motions": fault.motions,
        }
        return Diagnostic(code, text, _severity(code), Span(self.name, max(fault.line, 1)), values=values)


def _severity(code: str) -> Severity:
    return Severity.WARNING if code in ("cut-shank", "cut-plunge") else Severity.ERROR


def _ways_down(lines: Lines) -> Floats:
    """Return the angles at which motions go along the tool's axis, from the plane across it, rad, shape (n,)."""
    way = lines.ends[:, 3:] - lines.ends[:, :3]
    axes = np.array([[0.0, 0.0, 1.0]]) if lines.axes is None else lines.axes
    down = -(way * axes).sum(axis=1)
    across = np.sqrt(np.maximum((way**2).sum(axis=1) - down**2, 0.0))
    return np.arctan2(down, across)


def _at(place: tuple[float, float, float]) -> str:
    return f"X{place[0]:.2f} Y{place[1]:.2f} Z{place[2]:.2f}"

"""Cutting a bar that turns: rings along Z, each with a radius, along the way of a standing tool's edge."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.removal.record import Cutter, Insert, Met, OperationCut, Removal, Turned, TurnedTarget
from cncgen.removal.stock import Stock, checked_cell
from cncgen.removal.sweeps import Lines
from cncgen.removal.walk import CutWalk
from cncgen.toolpath.record import Toolpath

Floats = NDArray[np.float64]

#: Rings of a bar where no length is given, and at most.
RINGS = 5000
MAX_RINGS = 5_000_000
#: Distance of chords from arcs, mm.
CHORD = 0.001
#: Rings so near to a side of the tool, mm, are cut but not judged.
SIDE = 0.02
#: Material left on a radius that does not count, mm.
LEFT = 0.02
#: A piece that is cut off at the axis falls away if it is at most this share of the bar; a larger one counts as the part.
CHIP = 0.05
#: Way beside the axis of the work that counts as none, mm.
ON_AXIS = 1e-6


def bar_of(stock: Stock, cell: float | None = None) -> Turned:
    """Return a stock as rings about X 0 Y 0: of a box those of the bar round it.

    Raises:
        UsageError: It does not stand about the axis, or there would be too many rings.
    """
    middle, size = (stock.low + stock.high) / 2, stock.high - stock.low
    if np.abs(middle[:2]).max() > 1e-3 or stock.kind == "mesh":
        text = f"the stock of a lathe is a cylinder or box about X0 Y0, and stands about X{middle[0]:g} Y{middle[1]:g}"
        raise UsageError(Diagnostic("cut-stock", text, hint="--stock cylinder:0,0,DIAMETER,Z0,Z1"))
    radius = size[0] / 2 if stock.kind == "cylinder" else math.hypot(size[0], size[1]) / 2
    width = checked_cell(float(size[2]) / RINGS if cell is None else cell)
    count = max(round(float(size[2]) / width), 1)
    if count > MAX_RINGS:
        text = f"rings of {width:g} mm are {count}, more than {MAX_RINGS}"
        raise UsageError(Diagnostic("cut-grid", text, hint="a larger --cell"))
    width = float(size[2]) / count
    raw = np.full(count, float(radius))
    return Turned(float(stock.low[2]) + width / 2, width, raw, raw.copy(), np.zeros(count))


class TurnedCutting(CutWalk):
    """Cuts a bar, in place, with tools that stand and drills on its axis.

    Args:
        stock: The bar.
        name: Of the program, for findings.
        target: The profile that is to stay, None if unknown.
        cutters: Tools by name that count before those of the program.
    """

    UNKNOWN = "the shape of tool {} is not known"
    UNFIT = "tool {} is one of mills or a drill, and moves beside the axis of the bar"
    TOOLS = "--tool '{0}=turn:NOSE,TRAILING' names a turning tool, {0}=groove:WIDTH one for grooves, {0}=drill:D a drill on the axis"

    def __init__(
        self,
        stock: Turned,
        name: str,
        target: TurnedTarget | None = None,
        cutters: Mapping[str, Cutter | Insert] | None = None,
    ) -> None:
        super().__init__(name, cutters)
        self._stock, self._target = stock, target
        self._part = np.full(len(stock.raw), -np.inf)
        if target is not None:
            self._part = np.minimum(target.floor(stock.z), stock.raw)
        self._top = float(stock.raw.max()) + 1.0

    def _setup(self, number: int) -> None:
        """Go on: a bar stands in one clamping, and `cncgen.pipeline.removing` refuses more."""

    def run(self, toolpaths: Iterable[Toolpath]) -> Removal:
        """Cut along toolpaths and return the remaining stock and the faults."""
        self.walk(toolpaths, CHORD)
        if self._target is not None:
            self._left(self._target)
        return self.result(self._stock, self._stock.raw_volume)

    def _cut(self, lines: Lines, cutter: Cutter | Insert, operation: OperationCut) -> Met | None:
        """Cut along lines; places are at Y 0.

        A thread is left out, since its ridges are helices and a bar has rings alone. So is a tool that turns beside the axis.
        """
        # Volume; depth, radius and Z of the deepest bite; the same of a gouge, and its volume.
        out = np.zeros((len(lines.ends), 8))
        if self._state.threading or self._state.tapping:
            return Met.nothing(len(out))
        if isinstance(cutter, Cutter):
            beside = np.hypot(lines.ends[:, [0, 3]], lines.ends[:, [1, 4]]).max(axis=1) > ON_AXIS
            reached = np.minimum(lines.ends[:, 2], lines.ends[:, 5]) < self._stock.z[-1] + self._stock.cell
            if (beside & reached & ~lines.rapid).any():
                return None
            for k in np.flatnonzero(~beside).tolist():
                self._drill(cutter, float(min(lines.ends[k, 2], lines.ends[k, 5])), out[k])
            return _met(out)
        edge = cutter.edge(self._top)
        slopes = _slopes(edge)
        for k in range(len(lines.ends)):
            self._turn(edge, slopes, lines.ends[k], out[k])
        return _met(out)

    def _turn(self, edge: Floats, slopes: Floats, ends: Floats, out: Floats) -> None:
        """Cut along one line. The edge sweeps itself, drawn apart where it is parallel to the line."""
        a, b = ends[[2, 0]], ends[[5, 3]]
        if b[0] < a[0]:
            a, b = b, a
        if b[0] - a[0] < 1e-12:
            chain = edge + np.minimum(a, b)
        else:
            k = int(np.searchsorted(slopes, (b[1] - a[1]) / (b[0] - a[0])))
            chain = np.concatenate([edge[: k + 1] + a, edge[k:] + b])
        stock = self._stock
        first = max(math.ceil((chain[0, 0] - stock.first) / stock.cell - 1e-9), 0)
        last = min(math.floor((chain[-1, 0] - stock.first) / stock.cell + 1e-9), len(stock.raw) - 1)
        if last < first:
            return
        rings = slice(first, last + 1)
        z = stock.first + stock.cell * np.arange(first, last + 1)
        reach = np.maximum(np.interp(z, chain[:, 0], chain[:, 1]), 0.0)
        before = stock.radius[rings]
        after = np.maximum(np.minimum(before, reach), stock.bore[rings])
        if not (after < before).any():
            return
        self._note(
            z, before, after, self._part[rings], (z > chain[0, 0] + SIDE) & (z < chain[-1, 0] - SIDE), out
        )
        stock.radius[rings] = after
        if float(after.min()) <= 2 * stock.cell:
            out[0] += self._fallen(first + int(after.argmin()))

    def _fallen(self, k: int) -> float:
        """Take away what a cut through the axis has parted from the bar, if it is little; return its volume, mm³."""
        stock = self._stock
        each = np.maximum(stock.radius**2 - stock.bore**2, 0.0) * math.pi * stock.cell
        ends = [slice(0, k), slice(k + 1, None)]
        small = min(ends, key=lambda end: float(each[end].sum()))
        volume = float(each[small].sum())
        if volume > CHIP * float(each.sum()):
            return 0.0
        stock.radius[small] = stock.bore[small]
        return volume

    def _note(
        self, z: Floats, before: Floats, after: Floats, part: Floats, judged: NDArray[np.bool_], out: Floats
    ) -> None:
        """Note volume, depth and gouge of a cut of rings."""
        ring = math.pi * self._stock.cell
        out[0] = float((before**2 - after**2).sum()) * ring
        if not judged.any():
            return
        depth = np.where(judged, before - after, 0.0)
        k = int(depth.argmax())
        out[1:4] = depth[k], after[k], z[k]
        kept = np.minimum(before, part)
        gouge = np.where(judged & np.isfinite(part), kept - after, 0.0)
        k = int(gouge.argmax())
        if gouge[k] > 0:
            volume = float(np.maximum(kept**2 - after**2, 0.0)[gouge > 0].sum()) * ring
            out[4:8] = gouge[k], after[k], z[k], volume

    def _drill(self, cutter: Cutter, tip: float, out: Floats) -> None:
        """Cut the core of the bar as deep as a tip."""
        stock = self._stock
        z = stock.z
        rho = np.linspace(0.0, cutter.radius, 257)
        wide = np.where(z >= tip, np.interp(z - tip, cutter.height(rho), rho), 0.0)
        after = np.minimum(np.maximum(stock.bore, wide), stock.radius)
        grown = after**2 - stock.bore**2
        out[0] = float(grown.sum()) * math.pi * stock.cell
        deep = after - stock.bore
        k = int(deep.argmax())
        out[1:4] = deep[k], after[k], z[k]
        stock.bore[:] = after

    def _left(self, target: TurnedTarget) -> None:
        """Note where more is left than the target demands, place by place."""
        stock = self._stock
        over = stock.radius - np.maximum(target.demanded(stock.z), stock.bore)
        high = np.concatenate([[False], (over > LEFT) & (stock.radius > stock.bore), [False]])
        begins, ends = np.flatnonzero(high[1:] & ~high[:-1]), np.flatnonzero(high[:-1] & ~high[1:])
        for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
            if (end - begin) * stock.cell < SIDE:
                continue
            k = begin + int(over[begin:end].argmax())
            demanded = np.maximum(stock.radius[begin:end] - over[begin:end], 0.0)
            volume = float((stock.radius[begin:end] ** 2 - demanded**2).sum()) * math.pi * stock.cell
            place = (float(stock.radius[k]), 0.0, float(stock.z[k]))
            size = f"{over[k]:.3f} mm on the radius, {volume:.3g} mm³"
            owner = target.owner(place[2])
            self.findings.found.append(self.findings.left_at(float(over[k]), size, volume, place, owner))


def _met(out: Floats) -> Met:
    """Return the findings of motions, from the columns that cutting fills."""
    bite, gouge = (np.insert(out[:, k : k + 2], 1, 0.0, axis=1) for k in (2, 5))
    return Met(out[:, 0], out[:, 1], bite, out[:, 4], gouge, out[:, 7], np.full(len(out), -np.inf))


def _slopes(edge: Floats) -> Floats:
    """Return the slope from each corner of an edge to the next, rising, shape (n - 1,)."""
    along, up = np.diff(edge, axis=0).T
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = np.where(along > 1e-12, up / along, np.where(up < 0, -np.inf, np.inf))
    return np.maximum.accumulate(slopes)

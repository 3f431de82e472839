"""Cutting a height field along a program, by the kernel `cncgen.kernels.removal`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import removal as kernel
from cncgen.removal.record import Cutter, Field, Insert, Met, OperationCut, Removal, Target
from cncgen.removal.sweeps import Lines
from cncgen.removal.walk import CutWalk
from cncgen.toolpath.record import Toolpath

Floats = NDArray[np.float64]

#: Distance of chords from arcs and splines, in cells, and at most, mm.
CHORD_CELLS, CHORD = 0.02, 0.005
#: Touches less deep than this do not count, mm.
LEVEL = 0.02
#: Touches nearer to the tool's side than this do not count, in cells.
SIDE_CELLS = 0.6
#: Material left in a column that does not count where all is to go, mm, beside the cell.
LEFT = 0.02


class Cutting(CutWalk):
    """Cuts a field, in place, with upright tools.

    Args:
        stock: The field.
        name: Of the program, for findings.
        target: The material that is to stay, None if unknown.
        cutters: Tools by name that count before those of the program.
    """

    def __init__(
        self,
        stock: Field,
        name: str,
        target: Target | None = None,
        cutters: Mapping[str, Cutter | Insert] | None = None,
    ) -> None:
        super().__init__(name, cutters)
        self._stock, self._target = stock, target
        self._part = np.full(stock.top.shape, -np.inf)
        if target is not None:
            x, y = np.broadcast_arrays(stock.x[None, :], stock.y[:, None])
            self._part = np.ascontiguousarray(np.minimum(target.floor(x, y), stock.top))
        self._grid = np.array([*stock.origin, stock.cell])
        self._squares = np.empty([-(-count // kernel.SQUARE) for count in stock.heights.shape])
        kernel.bound_squares(stock.heights, stock.mean, stock.bottom, self._squares)

    def _setup(self, number: int) -> None:
        """Go on: of several setups `cncgen.removal.leaning` knows how the stock stands."""

    def run(self, toolpaths: Iterable[Toolpath]) -> Removal:
        """Cut along toolpaths and return the remaining stock and the faults."""
        raw = self._stock.raw_volume
        self.walk(toolpaths, min(CHORD_CELLS * self._stock.cell, CHORD), self._stock.cell)
        if self._target is not None:
            self.findings.left(self._stock, self._target, LEFT)
        return self.result(self._stock, raw)

    def _cut(self, lines: Lines, cutter: Cutter | Insert, operation: OperationCut) -> Met | None:
        """Cut along lines with an upright tool; not with one that stands."""
        if isinstance(cutter, Insert):
            return None
        stock = self._stock
        out = np.empty((len(lines.ends), kernel.COLUMNS))
        arrays: tuple[Floats, ...] = (stock.heights, stock.bottom)
        for what, radius, above in cutter.beside():
            reached = np.empty((len(lines.ends), 3))
            kernel.highest_beside(*arrays, self._squares, self._grid, lines.ends, radius, above, reached)
            self.findings.beside(lines, reached[:, 0], self._places(lines, reached[:, 1:3]), operation, what)
        limits = np.array([min(SIDE_CELLS * stock.cell, 0.5 * cutter.radius), LEVEL])
        arrays = (stock.heights, stock.mean, stock.top, stock.bottom, self._part)
        kernel.cut_lines(*arrays, self._squares, self._grid, lines.ends, cutter.values, limits, out)
        bite, gouge = self._places(lines, out[:, 2:4]), self._places(lines, out[:, 5:7])
        known = math.isfinite(cutter.cutting_length)
        over = out[:, 8] if known else np.full(len(out), -np.inf)
        return Met(out[:, 0], out[:, 1], bite, out[:, 4], gouge, out[:, 7], over)

    def _places(self, lines: Lines, columns: Floats) -> Floats:
        """Return where columns and rows of the grid are, at the lower end of each line, shape (n, 3)."""
        low = np.minimum(lines.ends[:, 2], lines.ends[:, 5])
        return np.column_stack([np.array(self._stock.origin) + self._stock.cell * columns, low])

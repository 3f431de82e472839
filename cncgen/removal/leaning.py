"""Cutting dexels along a program whose tools lean, or whose work stands differently in several setups."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.kernels import dexel_sweeps as kernel
from cncgen.removal.cutting import CHORD, CHORD_CELLS, LEFT, LEVEL, SIDE_CELLS
from cncgen.removal.dexels import below, grid_of, mesh_field, moved, order, thickness_beyond, turns_of
from cncgen.removal.record import (
    Clamping,
    Cutter,
    DexelField,
    Dexels,
    Insert,
    Met,
    OperationCut,
    Removal,
    Target,
)
from cncgen.removal.sweeps import Lines, Poses, leaning_lines_of
from cncgen.removal.targets import MeshTarget
from cncgen.removal.walk import CutWalk
from cncgen.room import pool
from cncgen.toolpath.record import Event, Toolpath

Floats = NDArray[np.float64]

#: A turning tool's touches less deep than this do not count, in cells, because pieces of one direction replace the turn.
TURN_CELLS = 0.5
#: Of a gap that is not known (`cncgen.kernels.dexel_sweeps.cut_lines`).
UNKNOWN = 1e300


class LeaningCutting(CutWalk):
    """Cuts dexels, in place.

    Args:
        stock: As it stands in the first setup.
        name: Of the program, for findings.
        poses: Tells where tools are.
        target: The material that is to stay, as it stands in the first setup, None if unknown.
        cutters: Tools by name that count before those of the program.
        clampings: Setups by their numbers, if there are several; `target` counts before theirs.
    """

    def __init__(
        self,
        stock: Dexels,
        name: str,
        poses: Poses,
        target: Target | None = None,
        cutters: Mapping[str, Cutter | Insert] | None = None,
        clampings: Mapping[int, Clamping] | None = None,
    ) -> None:
        super().__init__(name, cutters)
        self._poses = poses
        self._clampings = dict(clampings or {})
        self._given = target is not None
        self._number = 0
        self._take(stock, target)

    def _take(self, stock: Dexels, target: Target | None) -> None:
        """Cut these dexels from now on."""
        self._stock, self._target = stock, target
        self._grids = [grid_of(stock, axis) for axis in range(3)]
        self._gaps = [
            np.full((*(-(-n // kernel.SQUARE) for n in f.counts.shape), kernel.GAP), UNKNOWN)
            for f in stock.fields
        ]
        self._parts: tuple[DexelField | None, ...] = (None, None, None)
        if isinstance(target, MeshTarget):
            self._parts = tuple(mesh_field(stock, target.triangles, axis) for axis in range(3))
        elif target is not None:
            x, y = np.broadcast_arrays(stock.nodes(0)[None, :], stock.nodes(1)[:, None])
            self._parts = (None, None, below(stock, target.floor(x, y)))

    def _event(self, event: Event, line: int) -> None:
        super()._event(event, line)
        if event.name == "tool offset":
            self._poses.offset(float(event.values["length_mm"]))

    def _lines(self, path: Toolpath, begin: int, end: int) -> Lines:
        """Return the motions among rows, those that turn the tool in pieces."""
        cutter = self._cutter()
        wide = (
            max([cutter.radius, *(r for _, r, _ in cutter.beside())]) if isinstance(cutter, Cutter) else 0.0
        )
        return leaning_lines_of(
            path, begin, end, self._poses, lambda tips, axes: turns_of(self._stock, tips, axes, wide)
        )

    def _setup(self, number: int) -> None:
        """Place the rest of the stock as in another clamping."""
        if number == self._number or number not in self._clampings:
            return
        after = self._clampings[number]
        before, self._number = self._clampings.get(self._number), number
        if before is None:
            self._take(self._stock, self._target if self._given else after.target)
            return
        move = elementary.product(after.frame, np.asarray(np.linalg.inv(before.frame)))
        target = after.target
        if self._given:
            target = self._target.moved(move) if isinstance(self._target, MeshTarget) else None
        else:
            self._left()
        self._take(moved(self._stock, move), target)

    def run(self, toolpaths: Iterable[Toolpath]) -> Removal:
        """Cut along toolpaths and return the remaining stock and the faults."""
        raw = self._stock.volume
        self.walk(toolpaths, min(CHORD_CELLS * self._stock.cell, CHORD), self._stock.cell)
        self._left()
        return self.result(self._stock, raw)

    def _left(self) -> None:
        """Note where more is left than the target demands."""
        stock, parts = self._stock, tuple(p for p in self._parts if p is not None)
        if self._target is None:
            return
        if len(parts) == 3:
            over, volumes = thickness_beyond(stock, parts)
            allowed = LEFT + SIDE_CELLS * stock.cell
            self.findings.places_left(stock.seen(), self._target, over, volumes, allowed)
        else:
            self.findings.left(stock.seen(), self._target, LEFT)

    def _cut(self, lines: Lines, cutter: Cutter | Insert, operation: OperationCut) -> Met | None:
        """Cut along lines; not with a tool that stands."""
        if isinstance(cutter, Insert):
            return None
        for what, radius, above in cutter.beside():
            values = np.array([radius, radius, 0.0, 0.0, 0.0])
            out = self._swept(_raised(lines, above), values, True)
            self.findings.beside(lines, out[:, 10], out[:, 2:5], operation, what)
        out = self._swept(lines, cutter.values, False)
        known = math.isfinite(cutter.cutting_length)
        over = out[:, 10] if known else np.full(len(out), -np.inf)
        return Met(out[:, 0], out[:, 1], out[:, 2:5], out[:, 5], out[:, 6:9], out[:, 9], over)

    def _swept(self, lines: Lines, tool: Floats, dry: bool) -> Floats:
        """Cut along lines, or (dry) tell what is met: columns as of `cut_lines`, places in X Y Z.

        Volumes are the mean of the three directions; depths are those along the dexels that are nearest to the tool's axis.
        """
        assert lines.axes is not None
        assert lines.turning is not None
        stock, count = self._stock, len(lines.ends)
        nearest = np.abs(lines.axes).argmax(axis=1)
        if self._parts[2] is not None and self._parts[0] is None:
            nearest = np.where(np.abs(lines.axes[:, 2]) > 1e-3, 2, nearest)
        margins = np.empty((count, 2))
        margins[:, 0] = min(SIDE_CELLS * stock.cell, 0.5 * float(tool[0]))
        margins[:, 1] = LEVEL + np.where(lines.turning, TURN_CELLS * stock.cell, 0.0)
        out = np.zeros((count, kernel.COLUMNS))
        out[:, 10] = -np.inf
        with pool(3) as threads:
            fields = list(
                threads.map(
                    lambda axis: self._field_swept(axis, lines, nearest, tool, margins, dry), range(3)
                )
            )
        for axis, made in enumerate(fields):
            told = nearest == axis
            out[:, 0] += made[:, 0] / 3
            out[told, 1:] = made[told, 1:]
        return out

    def _field_swept(
        self, axis: int, lines: Lines, nearest: NDArray[np.int64], tool: Floats, margins: Floats, dry: bool
    ) -> Floats:
        """Cut the dexels along an axis, or (dry) tell what is met: columns as of `cut_lines`, places in X Y Z."""
        assert lines.axes is not None
        stock, field, turned = self._stock, self._stock.fields[axis], order(axis)
        made = np.zeros((len(lines.ends), kernel.COLUMNS))
        made[:, 10] = -np.inf
        judged = (nearest == axis).astype(np.uint8)
        if dry and not judged.any():
            return made
        part = self._parts[axis] or DexelField(np.zeros((0, 0, 0)), np.zeros((0, 0), np.int32))
        first = 0
        while True:
            first = kernel.cut_lines(
                field.ends,
                field.counts,
                part.ends,
                part.counts,
                self._gaps[axis],
                np.zeros((kernel.SQUARE, 2), np.int64),
                self._grids[axis],
                np.array([stock.low[axis], stock.high[axis]]),
                np.ascontiguousarray(lines.ends[:, [*turned, *(3 + k for k in turned)]]),
                np.ascontiguousarray(lines.axes[:, turned]),
                judged,
                tool,
                margins,
                dry,
                first,
                made,
            )
            if first >= len(made):
                break
            field.grow()
        for begin in (2, 6):
            made[:, [begin + k for k in turned]] = made[:, begin : begin + 3].copy()
        return made


def _raised(lines: Lines, above: float) -> Lines:
    """Return the motions of a place above the tip."""
    assert lines.axes is not None
    return lines._replace(ends=np.ascontiguousarray(lines.ends + above * np.tile(lines.axes, 2)))

"""Raw pieces: boxes, upright cylinders and meshes, as columns on a grid."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import read_bytes
from cncgen.kernels import removal as kernel
from cncgen.ranges import CELL_MM, POSITION
from cncgen.removal.record import Field
from cncgen.room import MIB, room

Floats = NDArray[np.float64]

#: Columns of a grid, at most, and bytes that cutting takes for each.
MAX_COLUMNS, COLUMN_BYTES = 100_000_000, 56
#: Sides of a cylinder as a mesh.
SIDES = 720
#: Columns along the longer side where no cell is given, and along the shorter one at least.
USUAL_COLUMNS, FEWEST_COLUMNS = 500, 10


@dataclass(frozen=True, slots=True)
class Stock:
    """A raw piece in machine coordinates.

    Attributes:
        kind: ``box``, ``cylinder`` (along Z) or ``mesh``.
        low, high: Shape (3,): its bounds, mm.
        triangles: Shape (n, 3, 3) of a mesh, else None.
    """

    kind: str
    low: Floats
    high: Floats
    triangles: Floats | None = None

    def solid_values(self) -> dict[str, Any]:
        """Return ``kind`` (``block`` or ``cylinder``), ``frame`` (4 x 4) and ``size`` (mm), as STEP-NC has raw pieces.

        A mesh becomes the box round it.
        """
        frame, size = np.eye(4), self.high - self.low
        frame[:3, 3] = self.low
        if self.kind != "cylinder":
            return {"kind": "block", "frame": frame.tolist(), "size": size.tolist()}
        frame[:2, 3] += size[:2] / 2
        sizes = [size[0] / 2, size[0] / 2, size[2]]
        return {"kind": "cylinder", "frame": frame.tolist(), "size": [float(v) for v in sizes]}

    def field(self, cell: float | None = None) -> Field:
        """Return it as columns.

        Args:
            cell: Width of a column, mm; None: so that the longer side has `USUAL_COLUMNS`.

        Raises:
            UsageError: There would be too many columns, or one is wider than the stock.
        """
        size = self.high[:2] - self.low[:2]
        width = checked_cell(_fitting_width(size) if cell is None else cell)
        if width > size.min():
            text = f"a column of {width:g} mm is wider than the stock of {size[0]:g} x {size[1]:g} mm"
            raise UsageError(Diagnostic("cut-grid", text, hint="a smaller --cell"))
        # As many as come nearest to the stock's sides: over all columns its volume is neither more nor less.
        covered = np.round(size / width) * width
        counts = counts_of(covered, width, "columns", MAX_COLUMNS, lambda x, y: COLUMN_BYTES * x * y)
        # The grid is centred on the stock, so that both of its sides are cut alike.
        origin = (self.low[:2] + self.high[:2]) / 2 - width * (counts - 1) / 2
        shape = (int(counts[1]), int(counts[0]))
        x, y = (origin[k] + width * np.arange(counts[k]) for k in (0, 1))
        top, bottom = self._columns(x, y, shape)
        return Field((float(origin[0]), float(origin[1])), width, top, bottom, top.copy(), top.copy())

    def _columns(self, x: Floats, y: Floats, shape: tuple[int, int]) -> tuple[Floats, Floats]:
        if self.triangles is not None:
            return columns_of(self.triangles, x, y)
        top, bottom = np.full(shape, self.high[2]), np.full(shape, self.low[2])
        if self.kind == "cylinder":
            middle, radius = (self.low[:2] + self.high[:2]) / 2, (self.high[0] - self.low[0]) / 2
            outside = (x[None, :] - middle[0]) ** 2 + (y[:, None] - middle[1]) ** 2 > radius**2
            top[outside] = bottom[outside]
        return top, bottom


def _fitting_width(size: Floats) -> float:
    """Return a width of columns, of which some `USUAL_COLUMNS` fill the longer side, shape (2,), and the shorter one with little left."""
    longer, shorter = float(size.max()), float(size.min())
    counts = np.arange(USUAL_COLUMNS, USUAL_COLUMNS * 21 // 20) * max(
        1, math.ceil(FEWEST_COLUMNS * longer / shorter / USUAL_COLUMNS)
    )
    other = shorter * counts / longer
    return longer / int(counts[np.abs(other - np.round(other)).round(6).argmin()])


def checked_cell(cell: float) -> float:
    """Return the width of a cell, mm.

    Raises:
        UsageError: It is not within `cncgen.ranges.CELL_MM`.
    """
    low, high = CELL_MM
    if not low <= cell <= high:
        raise UsageError(
            Diagnostic("cut-grid", f"a cell of {cell:g} mm is not within {low:g} to {high:g} mm")
        )
    return cell


def counts_of(
    size: Floats, cell: float, name: str, most: float, bytes_of: Callable[..., float]
) -> NDArray[np.int64]:
    """Return how many places a grid has along each side.

    Args:
        size: Of the covered range, mm.
        cell: Distance of its places, mm.
        name: Their name in messages.
        most: Places at most.
        bytes_of: Memory of a grid with so many places along each side.

    Raises:
        UsageError: They are more than that, or take more memory than there is room for.
    """
    counts = np.maximum(np.ceil(size / cell - 1e-9), 1.0)
    needed, there = bytes_of(*counts), room()
    grid = f"a grid of {cell:g} mm has {' x '.join(f'{n:.0f}' for n in counts)} {name}"
    if counts.prod() > most:
        raise UsageError(Diagnostic("cut-grid", f"{grid}, more than {most:,.0f}", hint="a larger --cell"))
    if needed > there:
        text = f"{grid}, which take {needed / MIB:,.0f} MiB, and there is room for {there / MIB:,.0f} MiB"
        raise UsageError(Diagnostic("cut-grid", text, hint="a larger --cell, or a larger --max-memory"))
    return np.asarray(counts, np.int64)


def box(low: Sequence[float], high: Sequence[float]) -> Stock:
    """Return a box between two corners, mm.

    Raises:
        UsageError: It has no volume, or a place beyond `cncgen.ranges.POSITION`.
    """
    if not (np.abs([low, high]) <= POSITION).all():  # nor where it is not a number
        raise UsageError(Diagnostic("cut-stock", f"the stock reaches beyond ±{POSITION:g} mm"))
    a, b = np.minimum(low, high).astype(float), np.maximum(low, high).astype(float)
    if not (b - a > 0).all():
        size = ", ".join(f"{v:g}" for v in b - a)
        raise UsageError(
            Diagnostic("cut-stock", f"a box of {size} mm has no volume; all three sides must be above 0")
        )
    return Stock("box", a, b)


def prism(frame: Floats, size: tuple[float, float, float], round_: bool) -> Stock:
    """Return a block, or a cylinder of `SIDES` sides, as a mesh.

    Args:
        frame: Shape (4, 4): of a block at its corner, of a cylinder in the middle of its base, Z its axis.
        size: Lengths along X, Y and Z of a block, radius, radius and height of a cylinder, mm.
        round_: Whether it is a cylinder.
    """
    ring = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    if round_:
        turn = 2 * np.pi * np.arange(SIDES) / SIDES
        # The polygon has the area of the circle.
        ring = np.column_stack([np.cos(turn), np.sin(turn)]) * math.sqrt(
            2 * np.pi / SIDES / math.sin(2 * np.pi / SIDES)
        )
    low = np.column_stack([ring, np.zeros(len(ring))]) * size
    high = low + np.array([0.0, 0.0, size[2]])
    after = np.roll(np.arange(len(ring)), -1)
    fan = np.arange(1, len(ring) - 1)
    local = np.concatenate(
        [
            np.stack([low, low[after], high[after]], axis=1),
            np.stack([low, high[after], high], axis=1),
            np.stack([np.broadcast_to(low[0], (len(fan), 3)), low[fan + 1], low[fan]], axis=1),
            np.stack([np.broadcast_to(high[0], (len(fan), 3)), high[fan], high[fan + 1]], axis=1),
        ]
    )
    triangles = local @ frame[:3, :3].T + frame[:3, 3]
    return Stock("mesh", triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1)), triangles)


def together(stocks: Sequence[Stock]) -> Stock:
    """Return several stocks as one; each stands beside the others.

    Raises:
        UsageError: The boxes round two of them overlap.
    """
    if len(stocks) == 1:
        return stocks[0]
    for k, one in enumerate(stocks):
        for other in stocks[:k]:
            if (np.minimum(one.high, other.high) - np.maximum(one.low, other.low) > 1e-6).all():
                text = f"of {len(stocks)} raw pieces one stands in another, or their boxes overlap"
                raise UsageError(Diagnostic("cut-stock", text, hint="--stock with the one that is cut"))
    meshes = []
    for stock in stocks:
        values = stock.solid_values()
        made = prism(np.array(values["frame"]), tuple(values["size"]), stock.kind == "cylinder")
        meshes.append(made.triangles if stock.triangles is None else stock.triangles)
    triangles = np.concatenate([m for m in meshes if m is not None])
    return Stock("mesh", triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1)), triangles)


def stock_of_option(text: str) -> Stock:
    """Return the stock of ``box:X0,Y0,Z0,X1,Y1,Z1``, ``cylinder:X,Y,DIAMETER,Z0,Z1`` or the name of an STL file.

    Raises:
        UsageError: The text does not describe a stock, or the file cannot be read.
    """
    kind, _, rest = text.partition(":")
    try:
        numbers = [float(v) for v in rest.split(",")] if rest else []
    except ValueError:
        numbers = []
    if kind == "box" and len(numbers) == 6:
        return box(numbers[:3], numbers[3:])
    if kind == "cylinder" and len(numbers) == 5:
        x, y, diameter, low, high = numbers
        if diameter < 0.0:
            raise UsageError(Diagnostic("cut-stock", f"the diameter of the cylinder is {diameter:g} mm"))
        made = box((x - diameter / 2, y - diameter / 2, low), (x + diameter / 2, y + diameter / 2, high))
        return Stock("cylinder", made.low, made.high)
    if kind in ("box", "cylinder") and not Path(text).exists():
        hint = "box:X0,Y0,Z0,X1,Y1,Z1 or cylinder:X,Y,DIAMETER,Z0,Z1, mm, or the name of an STL file"
        raise UsageError(Diagnostic("cut-stock", f"{text!r} does not describe a stock", hint=hint))
    triangles = read_stl(text)
    return Stock("mesh", triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1)), triangles)


def read_stl(name: str) -> Floats:
    """Return the triangles of an STL file, binary or text, shape (n, 3, 3), mm.

    Raises:
        UsageError: The file cannot be read, or holds none.
    """
    data = read_bytes(name)
    count = struct.unpack_from("<I", data, 80)[0] if len(data) >= 84 else -1
    if len(data) == 84 + 50 * count and count > 0:
        kind = np.dtype([("normal", "<f4", 3), ("points", "<f4", (3, 3)), ("flags", "<u2")])
        triangles = np.frombuffer(data, kind, count, 84)["points"].astype(float)
    else:
        lines = [line.split() for line in data.decode("latin-1").splitlines()]
        words = [line[1:4] for line in lines if line[:1] == ["vertex"]]
        if words and ["endsolid"] not in [line[:1] for line in lines]:
            raise UsageError(Diagnostic("cut-stl", f"{name} is cut off: it has no line endsolid"))
        try:
            numbers = np.array(words, float)
        except ValueError:
            numbers = np.zeros((0, 3))
        triangles = (
            numbers.reshape(-1, 3, 3) if numbers.size and len(numbers) % 3 == 0 else np.zeros((0, 3, 3))
        )
    if not len(triangles):
        raise UsageError(Diagnostic("cut-stl", f"{name} is not an STL file: it holds no triangles"))
    if not (np.abs(triangles) <= POSITION).all():
        raise UsageError(Diagnostic("cut-stl", f"{name} has places beyond ±{POSITION:g} mm"))
    return triangles


def columns_of(triangles: Floats, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return the highest and the lowest point of a mesh over the middles of columns, shape (len(y), len(x)) each.

    Over places beside the mesh the top is below the bottom. Hollows that open to a side are filled.
    """
    top = np.full((len(y), len(x)), -np.inf)
    bottom = np.full((len(y), len(x)), np.inf)
    cell = float(x[1] - x[0]) if len(x) > 1 else (float(y[1] - y[0]) if len(y) > 1 else 1.0)
    grid = np.array([x[0], y[0], cell])
    kernel.mesh_columns(np.ascontiguousarray(triangles), grid, top, bottom)
    lowest = float(triangles[:, :, 2].min())
    empty = ~np.isfinite(top)
    top[empty], bottom[empty] = lowest, lowest
    return top, bottom

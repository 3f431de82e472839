"""The remaining stock as a mesh: for STL files, pictures and 3-D views."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cncgen.removal.dexels import dexel_mesh
from cncgen.removal.record import Dexels, Field, Turned

Floats = NDArray[np.float64]

_HEAD = b"stock left by cncgen cut".ljust(80, b" ")


#: Corners of a turned stock in a mesh, round it and along it; round it where they are few.
ROUND, ALONG, ROUND_FEW = 180, 2000, 90
#: Triangles that a mesh of a stock of dexels has at the most where they are few.
FEW = 80_000


def turned_mesh(stock: Turned, joined: bool = False) -> tuple[Floats, NDArray[np.int64]]:
    """Return the surface of a turned stock: rings round the axis, outside and bore; where nothing is left they meet.

    Args:
        stock: The bar.
        joined: Whether rings that half a cell needs not are left out, and the rings have fewer corners.
    """
    z, radius, bore = stock.z, stock.radius, np.minimum(stock.bore, stock.radius)
    around = ROUND_FEW if joined else ROUND
    if joined:
        keep = _needed(z, np.stack([radius, bore]), stock.cell / 2)
    else:
        turns = np.flatnonzero((np.diff(radius) != 0) | (np.diff(bore) != 0))
        keep = np.unique(np.concatenate([[0, len(z) - 1], turns, turns + 1]))
    if len(keep) > ALONG:
        keep = np.unique(np.linspace(0, len(z) - 1, ALONG).astype(np.int64))
    low, high = stock.first - stock.cell / 2, float(z[-1]) + stock.cell / 2
    heights = z[keep].copy()
    heights[0], heights[-1] = low, high
    out, inner = radius[keep], bore[keep]
    # Outside upwards, then the bore downwards: one closed strip.
    r, h = np.concatenate([out, inner[::-1]]), np.concatenate([heights, heights[::-1]])
    angle = 2 * np.pi * np.arange(around) / around
    vertices = np.stack(
        [
            r[:, None] * np.cos(angle),
            r[:, None] * np.sin(angle),
            np.broadcast_to(h[:, None], (len(h), around)),
        ],
        axis=2,
    ).reshape(-1, 3)
    k = np.arange(len(vertices)).reshape(len(r), around)
    a, b = k, np.roll(k, -1, axis=1)
    c, d = np.roll(a, -1, axis=0), np.roll(b, -1, axis=0)
    quads = [np.stack([a, b, d], 2), np.stack([a, d, c], 2)]
    return vertices, np.concatenate([q.reshape(-1, 3) for q in quads])


def _needed(x: Floats, curves: Floats, tolerance: float) -> NDArray[np.int64]:
    """Return the places of x, both ends among them, between which straight lines keep within a tolerance of curves, shape (n, len(x)).

    Stretches are parted where they are farthest off (Douglas and Peucker (1973)).
    """
    at = np.array([0, len(x) - 1])
    while True:
        off = np.max([np.abs(curve - np.interp(x, x[at], curve[at])) for curve in curves], axis=0)
        parts = [(a, b) for a, b in pairwise(at.tolist()) if off[a:b].max(initial=0.0) > tolerance]
        if not parts:
            return at
        at = np.union1d(at, [a + int(np.argmax(off[a:b])) for a, b in parts])


def _clustered(
    vertices: Floats, triangles: NDArray[np.int64], most: int, size: float
) -> tuple[Floats, NDArray[np.int64]]:
    """Return a mesh of at most so many triangles: vertices in a cube of `size` mm or more become their middle."""
    while len(triangles) > most:
        places, cube, count = np.unique(
            np.floor(vertices / size), axis=0, return_inverse=True, return_counts=True
        )
        cube = cube.reshape(-1)
        middle = (
            np.stack([np.bincount(cube, column, len(places)) for column in vertices.T], axis=1)
            / count[:, None]
        )
        found = cube[triangles]
        whole = (found[:, 0] != found[:, 1]) & (found[:, 1] != found[:, 2]) & (found[:, 2] != found[:, 0])
        if np.count_nonzero(whole) <= most:
            return middle, found[whole]
        size *= 1.5
    return vertices, triangles


def mesh_of(
    field: Field | Turned | Dexels, columns: int | None = None, joined: bool = False
) -> tuple[Floats, NDArray[np.int64]]:
    """Return the surface of a stock as a closed mesh of columns' middles, the outermost ones as far as their sides.

    Columns that are cut through belong to the hollow: the surface goes down to the underside there.

    Args:
        field: The stock.
        columns: Columns along the longer side at the most, None for all.
        joined: Whether there are few triangles, which look the same, but are no closed mesh: level neighbours are one rectangle,
            rings of a turned stock keep within half a cell, and those of dexels are joined to `FEW`.

    Returns:
        Vertices, shape (v, 3), mm, and triangles, shape (t, 3): the top, the underside, and walls round both.
    """
    if isinstance(field, Turned):
        return turned_mesh(field, joined)
    if isinstance(field, Dexels):
        found = dexel_mesh(field)
        return _clustered(*found, FEW, 2 * field.cell) if joined else found
    step = 1 if columns is None else max(1, -(-max(field.top.shape) // columns))
    heights, low = field.heights[::step, ::step], field.bottom[::step, ::step]
    x, y = field.x[::step], field.y[::step]
    for row, whole in ((x, field.x), (y, field.y)):
        row[0], row[-1] = whole[0] - field.cell / 2, whole[-1] + field.cell / 2
    ny, nx = heights.shape
    grid_x, grid_y = np.meshgrid(x, y)
    upper = np.stack([grid_x, grid_y, np.maximum(heights, low)], axis=-1).reshape(-1, 3)
    lower = np.stack([grid_x, grid_y, low], axis=-1).reshape(-1, 3)
    k = np.arange(ny * nx).reshape(ny, nx)
    # Where the part is cut through it has neither top nor underside.
    thick = heights - low > 0
    solid = np.logical_or.reduce([thick[s] for s in _CORNERS])
    n = ny * nx
    a, b, c, d = _rectangles(np.maximum(heights, low), solid, joined)
    top = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
    a, b, c, d = _rectangles(low, solid, joined)
    under = np.concatenate([np.stack([a, d, b], 1), np.stack([a, c, d], 1)]) + n
    rim = np.concatenate([k[0, :], k[1:, -1], k[-1, -2::-1], k[-2:0:-1, 0]])
    after = np.roll(rim, -1)
    walls = np.concatenate([np.stack([rim, rim + n, after + n], 1), np.stack([rim, after + n, after], 1)])
    return np.concatenate([upper, lower]), np.concatenate([top, under, walls])


_CORNERS = (
    np.s_[:-1, :-1],
    np.s_[:-1, 1:],
    np.s_[1:, :-1],
    np.s_[1:, 1:],
)


def _rectangles(level: Floats, solid: NDArray[np.bool_], joined: bool) -> tuple[NDArray[np.int64], ...]:
    """Return the corners of the cells of a grid that are solid, as places of nodes; level neighbours are one if `joined`.

    Args:
        level: Heights of the nodes, shape (rows, columns).
        solid: Of the cells between them, shape (rows - 1, columns - 1).
        joined: See `mesh_of`.

    Returns:
        The corners at low X and low Y, high X and low Y, low X and high Y, high X and high Y, each of shape (n,).
    """
    wide = level.shape[1]
    if not joined:
        y, x = np.nonzero(solid)
        return _corners(wide, y, y, x, x)
    corners = np.stack([level[s] for s in _CORNERS])
    flat = solid & (corners.max(axis=0) == corners.min(axis=0))
    # Two level cells beside each other have two nodes in common, hence one height.
    follows = np.zeros_like(flat)
    follows[:, 1:] = flat[:, 1:] & flat[:, :-1]
    y, first = np.nonzero(solid & ~follows)
    last = np.nonzero(solid & ~np.roll(follows, -1, axis=1))[1]
    # The same stretch of columns in row after row is one rectangle.
    order = np.lexsort((y, last, first))
    y, first, last = y[order], first[order], last[order]
    goes_on = np.zeros(len(y), np.bool_)
    goes_on[1:] = (
        (np.diff(y) == 1)
        & (np.diff(first) == 0)
        & (np.diff(last) == 0)
        & (flat[y, first][1:] & flat[y, first][:-1])
    )
    starts = np.flatnonzero(~goes_on)
    ends = np.append(starts[1:], len(y)) - 1
    return _corners(wide, y[starts], y[ends], first[starts], last[starts])


def _corners(
    wide: int,
    low: NDArray[np.int64],
    high: NDArray[np.int64],
    first: NDArray[np.int64],
    last: NDArray[np.int64],
) -> tuple[NDArray[np.int64], ...]:
    """Return the places of the nodes round cells from row `low` and column `first` to row `high` and column `last`."""
    below, above = wide * low, wide * (high + 1)
    return below + first, below + last + 1, above + first, above + last + 1


def stl_bytes(vertices: Floats, triangles: NDArray[np.int64]) -> bytes:
    """Return a mesh as a binary STL file; triangles of no area are left out."""
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(normals, axis=1)
    corners, normals, size = corners[size > 0], normals[size > 0], size[size > 0]
    out = np.zeros(
        len(corners), np.dtype([("normal", "<f4", 3), ("points", "<f4", (3, 3)), ("flags", "<u2")])
    )
    out["normal"], out["points"] = normals / size[:, None], corners
    return _HEAD + np.uint32(len(corners)).tobytes() + out.tobytes()

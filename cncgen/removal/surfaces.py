"""The remaining stock as a mesh: for STL files, pictures and 3-D views."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cncgen.removal.dexels import dexel_mesh
from cncgen.removal.record import Dexels, Field, Turned

Floats = NDArray[np.float64]

_HEAD = b"stock left by cncgen cut".ljust(80, b" ")
#: Bytes of a binary STL file without triangles.
EMPTY_BYTES = len(_HEAD) + 4


#: Corners of a turned stock in a mesh, round it and along it; round it where they are few.
ROUND, ALONG, ROUND_FEW = 180, 2000, 90
#: Triangles that a mesh of a stock of dexels has at the most where they are few.
FEW = 80_000
#: Part of a cell by which rings that are left out may be off where the surface is to stay as it is.
_EXACT = 1e-6


def turned_mesh(stock: Turned, joined: bool = False) -> tuple[Floats, NDArray[np.int64]]:
    """Return the surface of a turned stock: rings round the axis, outside and bore; where nothing is left they meet.

    Args:
        stock: The bar.
        joined: Whether rings that half a cell needs not are left out, and the rings have fewer corners. Rings on the line between
            others always are.
    """
    z, radius, bore = stock.z, stock.radius, np.minimum(stock.bore, stock.radius)
    around = ROUND_FEW if joined else ROUND
    keep = _needed(z, np.stack([radius, bore]), stock.cell * (0.5 if joined else _EXACT))
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
        joined: Whether there are few triangles, which look the same: rings of a turned stock keep within half a cell, and those of
            dexels are joined to `FEW`. Those amid a plane, and rings of a cylinder or cone, are joined always, and nothing is lost.

    Returns:
        Vertices, shape (v, 3), mm, and triangles, shape (t, 3): the top, the underside, and walls round both.
    """
    if isinstance(field, Turned):
        return turned_mesh(field, joined)
    if isinstance(field, Dexels):
        found = _joined(*dexel_mesh(field), field.cell)
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
    both = [_rectangles(level, solid) for level in (np.maximum(heights, low), low)]
    # A node is kept in both where it is a corner in one: so edges that meet have the same nodes, and the mesh is closed.
    kept = np.zeros((ny, nx), np.bool_)
    kept[[0, 0, -1, -1], [0, -1, 0, -1]] = True
    for y0, y1, x0, x1 in both:
        for corner in ((y0, x0), (y0, x1), (y1, x0), (y1, x1)):
            kept[corner] = True
    vertices, triangles = [upper, lower], []
    for side, rectangles in enumerate(both):
        numbers, middles = _covered(kept, rectangles)
        n, y0, x0 = ny * nx, rectangles[0][middles], rectangles[2][middles]
        place = (x[x0] + x[rectangles[3][middles]]) / 2, (y[y0] + y[rectangles[1][middles]]) / 2
        level = vertices[side][y0 * nx + x0, 2]
        # Nodes of the underside come behind those of the top, and middles behind them all.
        numbers = np.where(numbers < n, numbers + side * n, numbers + n + sum(map(len, vertices[2:])))
        vertices.append(np.stack([*place, level], axis=1))
        triangles.append(numbers[:, ::-1] if side else numbers)
    rim = np.concatenate([k[0, :], k[1:, -1], k[-1, -2::-1], k[-2:0:-1, 0]])
    rim = rim[kept.ravel()[rim]]
    after, n = np.roll(rim, -1), ny * nx
    triangles += [np.stack([rim, rim + n, after + n], 1), np.stack([rim, after + n, after], 1)]
    return np.concatenate(vertices), np.concatenate(triangles)


_CORNERS = (
    np.s_[:-1, :-1],
    np.s_[:-1, 1:],
    np.s_[1:, :-1],
    np.s_[1:, 1:],
)


def _rectangles(level: Floats, solid: NDArray[np.bool_]) -> tuple[NDArray[np.int64], ...]:
    """Return the cells of a grid that are solid as rectangles, of which level neighbours are one.

    Args:
        level: Heights of the nodes, shape (rows, columns).
        solid: Of the cells between them, shape (rows - 1, columns - 1).

    Returns:
        First and last row, first and last column of nodes, each of shape (n,).
    """
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
    ends = np.append(starts, len(y))[1:] - 1
    return y[starts], y[ends] + 1, first[starts], last[starts] + 1


def _covered(
    kept: NDArray[np.bool_], rectangles: tuple[NDArray[np.int64], ...]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cover rectangles with triangles that have every kept node on their edges as a corner.

    Args:
        kept: Whether a node is kept, shape (rows, columns); corners of rectangles are.
        rectangles: See `_rectangles`.

    Returns:
        Triangles, shape (t, 3), counterclockwise; numbers beyond the nodes are middles of rectangles. And the rectangles that have one.
    """
    y0, y1, x0, x1 = rectangles
    tall, wide = kept.shape
    number = np.arange(kept.size).reshape(kept.shape)
    pieces = []
    # Edges along rows, at low and at high Y, then along columns; round the rectangle the second and the last run downwards.
    for nodes, length, (fixed, begin, end), down in (
        (number, wide, (y0, x0, x1), False),
        (number, wide, (y1, x0, x1), True),
        (number.T, tall, (x1, y0, y1), False),
        (number.T, tall, (x0, y0, y1), True),
    ):
        places = np.flatnonzero(kept if nodes is number else kept.T)
        low, high = (np.searchsorted(places, fixed * length + k) for k in (begin, end))
        owner = np.repeat(np.arange(len(y0)), high - low)
        step = np.arange(len(owner)) - np.repeat(np.cumsum(high - low) - high, high - low)
        along = nodes.ravel()[places]
        ends = along[step], along[step + 1]
        pieces.append(np.stack([owner, *(ends[::-1] if down else ends)], axis=1))
    edges = np.concatenate(pieces)
    many = np.bincount(edges[:, 0], minlength=len(y0)) > 4
    middles = np.flatnonzero(many)
    middle = np.zeros(len(y0), np.int64)
    middle[middles] = kept.size + np.arange(len(middles))
    round_it = edges[many[edges[:, 0]]]
    a, b, c, d = (number[k][~many] for k in ((y0, x0), (y0, x1), (y1, x0), (y1, x1)))
    fans = np.column_stack([round_it[:, 1:], middle[round_it[:, 0]]])
    return np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1), fans]), middles


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


#: Widths of the squares in which `_joined` lets corners become one, in cells, one after the other.
_SQUARES = (2, 4, 8, 16, 32)
#: 1 less the cosine between normals that count as the same, which rounding of corners leaves.
_LEVEL = 1e-11


def _joined(vertices: Floats, triangles: NDArray[np.int64], cell: float) -> tuple[Floats, NDArray[np.int64]]:
    """Return the same closed surface with fewer triangles: corners amid a plane become one in each square of it, their middle.

    The borders of plane regions stay as they are. So a region is covered once, as before, where every triangle keeps its
    orientation; squares about which one does not are left.
    """
    for square in _SQUARES:
        vertices, triangles = _joined_once(vertices, triangles, cell * square, cell)
    return vertices, triangles


def _joined_once(
    vertices: Floats, triangles: NDArray[np.int64], size: float, cell: float
) -> tuple[Floats, NDArray[np.int64]]:
    normals = _normals(vertices, triangles)
    length = np.linalg.norm(normals, axis=1)
    units = normals / np.where(length > 0, length, 1.0)[:, None]
    corners = triangles.ravel()
    count = np.bincount(corners, minlength=len(vertices))
    sums = [np.bincount(corners, np.repeat(u, 3), len(vertices)) for u in units.T]
    mean = np.stack(sums, axis=1) / np.maximum(count, 1)[:, None]
    amid = np.flatnonzero(np.linalg.norm(mean, axis=1) > 1.0 - _LEVEL)
    normal, place = mean[amid], vertices[amid]
    plane = np.rint((normal * place).sum(axis=1) / (1e-3 * cell))
    keys = np.column_stack([np.rint(1e4 * normal), plane, np.floor(place / size)])
    _, group, sizes = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    group = group.reshape(-1)
    wanted = sizes > 1
    while True:
        number, at = np.arange(len(vertices)), wanted[group]
        if not at.any():
            return vertices, triangles
        order = np.cumsum(wanted) - 1
        number[amid[at]] = len(vertices) + order[group[at]]
        middle = np.stack(
            [np.bincount(group[at], c, len(sizes))[wanted] / sizes[wanted] for c in place[at].T], axis=1
        )
        found = number[triangles]
        whole = (found[:, 0] != found[:, 1]) & (found[:, 1] != found[:, 2]) & (found[:, 2] != found[:, 0])
        points = np.concatenate([vertices, middle])
        turned = (_normals(points, found[whole]) * units[whole]).sum(axis=1) <= 0.0
        turned &= (found[whole] >= len(vertices)).any(axis=1)
        if not turned.any():
            kept, corner = np.unique(found[whole], return_inverse=True)
            return points[kept], corner.reshape(-1, 3)
        bad = np.unique(found[whole][turned])
        wanted[np.flatnonzero(wanted)[bad[bad >= len(vertices)] - len(vertices)]] = False


def _normals(vertices: Floats, triangles: NDArray[np.int64]) -> Floats:
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.asarray(np.cross(b - a, c - a))

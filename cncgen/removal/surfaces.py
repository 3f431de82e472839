"""The stock that is left as a mesh: STL files, and what a picture or a 3-D view takes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.removal.dexels import dexel_mesh
from cncgen.removal.record import Dexels, Field, Turned

Floats = NDArray[np.float64]

_HEAD = b"stock left by cncgen cut".ljust(80, b" ")


#: Corners of a turned stock in a mesh, round it and along it.
ROUND, ALONG = 180, 2000


def turned_mesh(stock: Turned) -> tuple[Floats, NDArray[np.int64]]:
    """Return the surface of a turned stock: rings round the axis, outside and bore; where nothing is left they meet."""
    z, radius, bore = stock.z, stock.radius, np.minimum(stock.bore, stock.radius)
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
    angle = 2 * np.pi * np.arange(ROUND) / ROUND
    vertices = np.stack(
        [
            r[:, None] * np.cos(angle),
            r[:, None] * np.sin(angle),
            np.broadcast_to(h[:, None], (len(h), ROUND)),
        ],
        axis=2,
    ).reshape(-1, 3)
    k = np.arange(len(vertices)).reshape(len(r), ROUND)
    a, b = k, np.roll(k, -1, axis=1)
    c, d = np.roll(a, -1, axis=0), np.roll(b, -1, axis=0)
    quads = [np.stack([a, b, d], 2), np.stack([a, d, c], 2)]
    return vertices, np.concatenate([q.reshape(-1, 3) for q in quads])


def mesh_of(field: Field | Turned | Dexels, columns: int | None = None) -> tuple[Floats, NDArray[np.int64]]:
    """Return the surface of a stock as a closed mesh of columns' middles, the outermost ones as far as their sides.

    Columns that are cut through belong to the hollow: the surface goes down to the underside there.

    Args:
        field: The stock.
        columns: Columns along the longer side at the most, None for all.

    Returns:
        Vertices, shape (v, 3), mm, and triangles, shape (t, 3): the top, the underside, and walls round both.
    """
    if isinstance(field, Turned):
        return turned_mesh(field)
    if isinstance(field, Dexels):
        return dexel_mesh(field)
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
    a, b, c, d = (k[s].ravel() for s in _CORNERS)
    # Where the part is cut through it has neither top nor underside.
    thick = (heights - low).reshape(-1) > 0
    solid = thick[a] | thick[b] | thick[c] | thick[d]
    a, b, c, d = a[solid], b[solid], c[solid], d[solid]
    top = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
    n = ny * nx
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

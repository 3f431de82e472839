"""Stocks as dexels: lines of material along X, Y and Z through the nodes of one grid; from raw pieces, and as a mesh."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.kernels.dexel_meshes import mesh_crossings
from cncgen.removal.record import DexelField, Dexels
from cncgen.removal.stock import Stock, checked_cell, counts_of

Floats = NDArray[np.float64]
Stretches = tuple[NDArray[np.int64], Floats, Floats]

#: Nodes along the longest side where no cell is given, nodes at most, and those of a mesh, which takes 2 bytes for each.
USUAL_NODES = 250
MAX_NODES = 1_000_000_000
MESH_NODES = 200_000_000
#: Bytes that cutting takes for a dexel.
DEXEL_BYTES = 72
#: Stretches that a dexel has places for at first.
PLACES = 2
#: Dexels pass beside corners of meshes by this part of a cell, so that they go through no edge.
ASIDE = (1.3e-6, 0.7e-6)


def order(axis: int) -> list[int]:
    """Return the axes u, v, w of the dexels along an axis."""
    return [(axis + 1) % 3, (axis + 2) % 3, axis]


def dexels_of(stock: Stock, cell: float | None = None) -> Dexels:
    """Return a stock as dexels.

    Args:
        stock: A raw piece.
        cell: Distance of nodes, mm; None: so that the longest side has `USUAL_NODES`.

    Raises:
        UsageError: There would be too many nodes.
    """
    size = stock.high - stock.low
    width = checked_cell(float(size.max()) / USUAL_NODES if cell is None else cell)
    counts = counts_of(size, width, "nodes", MAX_NODES, lambda x, y, z: DEXEL_BYTES * (x * y + y * z + z * x))
    origin = (stock.low + stock.high) / 2 - width * (counts - 1) / 2
    out = Dexels(
        origin,
        width,
        (int(counts[0]), int(counts[1]), int(counts[2])),
        stock.low,
        stock.high,
        (_empty(counts, 0), _empty(counts, 1), _empty(counts, 2)),
    )
    for axis in range(3):
        u, v, w = order(axis)
        shape = (int(counts[v]), int(counts[u]))
        if stock.triangles is not None:
            taken = mesh_field(out, stock.triangles, axis)
            out.fields[axis].ends, out.fields[axis].counts = taken.ends, taken.counts
            continue
        low, high = np.full(shape, stock.low[w]), np.full(shape, stock.high[w])
        there = np.ones(shape, bool)
        if stock.kind == "cylinder":
            middle, radius = (stock.low + stock.high) / 2, (stock.high[0] - stock.low[0]) / 2
            along_u, along_v = out.nodes(u)[None, :], out.nodes(v)[:, None]
            if axis == 2:
                there = (along_u - middle[0]) ** 2 + (along_v - middle[1]) ** 2 < radius**2
            else:
                # One of u and v is Z; the other one is across.
                across = along_u - middle[u] if v == 2 else along_v - middle[v]
                half = np.broadcast_to(np.sqrt(np.maximum(radius**2 - across**2, 0.0)), shape)
                low, high, there = middle[w] - half, middle[w] + half, half > 0
        field = out.fields[axis]
        field.ends[..., 0], field.ends[..., 1] = low, high
        field.counts[...] = there
    return out


def _empty(counts: NDArray[np.int64], axis: int) -> DexelField:
    u, v, _ = order(axis)
    shape = (int(counts[v]), int(counts[u]))
    return DexelField(np.zeros((*shape, 2 * PLACES)), np.zeros(shape, np.int32))


def below(stock: Dexels, heights: Floats) -> DexelField:
    """Return dexels along Z that are material below heights, shape (rows, columns), mm."""
    low = float(stock.low[2]) - 1.0
    ends = np.zeros((*heights.shape, 2))
    ends[..., 0], ends[..., 1] = low, heights
    return DexelField(ends, (heights > low).astype(np.int32))


def grid_of(stock: Dexels, axis: int) -> Floats:
    """Return u and v of the first dexel along an axis, and the distance of dexels."""
    u, v, _ = order(axis)
    return np.array([stock.origin[u], stock.origin[v], stock.cell])


def mesh_field(stock: Dexels, triangles: Floats, axis: int) -> DexelField:
    """Return where the dexels of a stock along an axis are within a mesh, shape (n, 3, 3)."""
    u, v, _ = order(axis)
    rows, columns = stock.counts[v], stock.counts[u]
    turned = np.ascontiguousarray(triangles[:, :, order(axis)])
    grid = grid_of(stock, axis)
    grid[:2] += np.array(ASIDE) * stock.cell
    none = np.zeros(0, np.int64), np.zeros(0), np.zeros(0, np.int8)
    count = mesh_crossings(turned, grid, rows, columns, *none)
    line, place, sense = np.zeros(count, np.int64), np.zeros(count), np.zeros(count, np.int8)
    mesh_crossings(turned, grid, rows, columns, line, place, sense)
    return field_of(_inside(line, place, sense), (rows, columns))


def _inside(line: NDArray[np.int64], place: Floats, sense: NDArray[np.int8]) -> Stretches:
    """Return the stretches within surfaces that lines cross at places, by how often they have gone in and out."""
    by = np.lexsort((place, line))
    line, place, sense = line[by], place[by], sense[by]
    first = np.append(True, line[1:] != line[:-1])[: len(line)]
    depth = np.cumsum(sense.astype(np.int64))
    before = depth - sense
    start = np.maximum.accumulate(np.where(first, np.arange(len(line)), 0)) if len(line) else np.zeros(0, int)
    depth, before = depth - before[start], before - before[start]
    into, out = (before == 0) & (depth != 0), (before != 0) & (depth == 0)
    # A line that a mesh with holes leaves nowhere ends where it is crossed last.
    last = np.append(first[1:], True)[: len(line)]
    out |= last & (depth != 0) & (before != 0)
    into &= ~(last & (depth != 0))
    return line[into], place[into], place[out]


def field_of(stretches: Stretches, shape: tuple[int, int]) -> DexelField:
    """Return stretches, sorted by line and place, as a field."""
    line, low, high = stretches
    counts = np.bincount(line, minlength=shape[0] * shape[1]).astype(np.int32)
    ends = np.zeros((shape[0] * shape[1], 2 * max(int(counts.max(initial=0)), PLACES)))
    number = np.arange(len(line)) - (np.cumsum(counts) - counts)[line]
    ends[line, 2 * number], ends[line, 2 * number + 1] = low, high
    return DexelField(ends.reshape(*shape, -1), counts.reshape(shape))


def beyond(field: DexelField, part: DexelField) -> Stretches:
    """Return the stretches of a field that are outside of a part."""
    line, low, high = field.stretches()
    line_p, low_p, high_p = part.stretches()
    lines = np.concatenate([line, line, line_p, line_p])
    places = np.concatenate([low, high, low_p, high_p])
    material = np.concatenate([np.ones(len(low)), -np.ones(len(low)), np.zeros(2 * len(low_p))])
    other = np.concatenate([np.zeros(2 * len(low)), np.ones(len(low_p)), -np.ones(len(low_p))])
    by = np.lexsort((places, lines))
    lines, places = lines[by], places[by]
    free = (np.cumsum(material[by]) > 0.5) & (np.cumsum(other[by]) < 0.5)
    k = np.flatnonzero(free[:-1] & (lines[1:] == lines[:-1]) & (places[1:] > places[:-1]))
    return lines[k], places[k], places[k + 1]


def thickness_beyond(stock: Dexels, parts: tuple[DexelField, ...]) -> tuple[Floats, Floats]:
    """Return how thick the material outside of a part is over each column, and its volume there; shapes (rows, columns).

    The thickness at a place is the least of those along X, Y and Z as far as dexels there are within it.
    """
    found = [beyond(f, p) for f, p in zip(stock.fields, parts, strict=True)]
    shape = (stock.counts[1], stock.counts[0])
    thick, volume = np.zeros(shape), np.zeros(shape)
    for axis, (line, low, high) in enumerate(found):
        u, v, w = order(axis)
        index = np.empty((len(line), 3), np.int64)
        index[:, v], index[:, u] = np.divmod(line, stock.counts[u])
        middle = ((low + high) / 2 - stock.origin[w]) / stock.cell
        index[:, w] = np.clip(np.rint(middle), 0, stock.counts[w] - 1)
        places = np.array(stock.origin) + stock.cell * index
        places[:, w] = (low + high) / 2
        least = high - low
        for other in range(3):
            if other != axis and len(line):
                least = np.minimum(least, _length_at(stock, found[other], other, index, places))
        np.maximum.at(thick, (index[:, 1], index[:, 0]), least)
        np.add.at(volume, (index[:, 1], index[:, 0]), (high - low) * stock.cell**2 / 3)
    return thick, volume


def _length_at(
    stock: Dexels, stretches: Stretches, axis: int, index: NDArray[np.int64], places: Floats
) -> Floats:
    """Return the length of the stretch along an axis that holds each place, on the dexel next to it; infinite where none does."""
    line, low, high = stretches
    if not len(line):
        return np.full(len(index), np.inf)
    u, v, w = order(axis)
    wanted = index[:, v] * stock.counts[u] + index[:, u]
    # Line and place as one rising number.
    span = 4.0 * float(np.abs([stock.low[w], stock.high[w]]).max()) + 4.0
    k = np.searchsorted(line * span + low, wanted * span + places[:, w], side="right") - 1
    kept = np.maximum(k, 0)
    holds = (k >= 0) & (line[kept] == wanted) & (high[kept] >= places[:, w])
    return np.asarray(np.where(holds, high[kept] - low[kept], np.inf))


def dexel_mesh(stock: Dexels) -> tuple[Floats, NDArray[np.int64]]:
    """Return the surface of a stock: a corner in each cube of nodes that it goes through, amid the places where dexels cross it.

    (Surface nets: S. F. F. Gibson, Constrained elastic surface nets, MICCAI 1998.) Of more than `MESH_NODES` nodes it is that of every
    second one, or fewer.

    Returns:
        Vertices, shape (v, 3), mm, and triangles, shape (t, 3), against the clock seen from outside.
    """
    while math.prod(stock.counts) > MESH_NODES:
        stock = _thinned(stock)
    counts = np.array(stock.counts)
    inside = np.zeros(tuple(counts + 2), bool)
    inside[1:-1, 1:-1, 1:-1] = _nodes_within(stock)
    cubes = counts + 1
    edges, crossings, ups = [], [], []
    for axis in range(3):
        before = [slice(None)] * 3
        after = list(before)
        before[axis], after[axis] = slice(None, -1), slice(1, None)
        differs = inside[tuple(before)] != inside[tuple(after)]
        index = np.argwhere(differs)
        edges.append(index)
        ups.append(~inside[tuple(before)][differs])
        crossings.append(_crossings(stock, axis, index))
    # Every edge between nodes that differ belongs to four cubes.
    members, where, corners = [], [], []
    for axis in range(3):
        u, v, _ = order(axis)
        of = np.repeat(edges[axis][:, None, :], 4, axis=1)
        of[:, 1, u] -= 1
        of[:, 2, [u, v]] -= 1
        of[:, 3, v] -= 1
        number = np.asarray((of[..., 0] * cubes[1] + of[..., 1]) * cubes[2] + of[..., 2])
        corners.append(number)
        members.append(number.ravel())
        where.append(np.repeat(crossings[axis], 4, axis=0))
    cube, member = np.unique(np.concatenate(members), return_inverse=True)
    points = np.concatenate(where)
    share = np.bincount(member, minlength=len(cube))
    vertices = np.stack(
        [np.bincount(member, points[:, k], minlength=len(cube)) / share for k in range(3)], axis=1
    )
    triangles = []
    for axis in range(3):
        quad = np.searchsorted(cube, corners[axis])
        quad[ups[axis]] = quad[ups[axis]][:, ::-1]
        triangles += [quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]]
    return vertices, np.concatenate(triangles)


def _thinned(stock: Dexels) -> Dexels:
    """Return a stock with the dexels through every second node."""
    x, y, z = (DexelField(f.ends[::2, ::2], f.counts[::2, ::2]) for f in stock.fields)
    nx, ny, nz = ((count + 1) // 2 for count in stock.counts)
    return replace(stock, cell=2 * stock.cell, counts=(nx, ny, nz), fields=(x, y, z))


def _nodes_within(stock: Dexels) -> NDArray[np.bool_]:
    """Tell which nodes are within the material by the dexels along Z, shape `counts`."""
    line, low, high = stock.fields[2].stretches()
    nx, ny, nz = stock.counts
    first = np.clip(np.ceil((low - stock.origin[2]) / stock.cell), 0, nz).astype(np.int64)
    last = np.clip(np.ceil((high - stock.origin[2]) / stock.cell), 0, nz).astype(np.int64)
    change = np.zeros((nx * ny, nz + 1), np.int8)
    np.add.at(change, (line, first), 1)
    np.add.at(change, (line, last), -1)
    within = np.cumsum(change, axis=1, dtype=np.int8)[:, :nz] > 0
    return within.reshape(ny, nx, nz).transpose(1, 0, 2)


def _crossings(stock: Dexels, axis: int, index: NDArray[np.int64]) -> Floats:
    """Return where dexels along an axis cross the surface between nodes and the ones after them, shape (n, 3).

    `index`, shape (n, 3), counts nodes from the one before the first.
    """
    u, v, w = order(axis)
    line, low, high = stock.fields[axis].stretches()
    places = stock.origin + stock.cell * (index - 1.0)
    first = places[:, w].copy()
    places[:, w] += stock.cell / 2
    if not len(line):
        return np.asarray(places)
    # Line and place as one rising number; of the ends on a line the nearest to the middle, as far as it is between the nodes.
    span = 4.0 * float(np.abs([stock.low[w], stock.high[w]]).max() + stock.cell) + 4.0
    key = np.column_stack([line * span + low, line * span + high]).ravel()
    wanted = (index[:, v] - 1) * stock.counts[u] + index[:, u] - 1
    middle = wanted * span + places[:, w]
    k = np.searchsorted(key, middle)
    both = np.stack([key[np.maximum(k - 1, 0)], key[np.minimum(k, len(key) - 1)]])
    nearest = np.where(np.abs(both[0] - middle) <= np.abs(both[1] - middle), both[0], both[1]) - wanted * span
    there = np.abs(nearest - places[:, w]) < 2 * stock.cell
    places[:, w] = np.where(there, np.clip(nearest, first, first + stock.cell), places[:, w])
    return np.asarray(places)


def moved(stock: Dexels, move: Floats) -> Dexels:
    """Return what is left of a stock as it stands after a motion, shape (4, 4), on a grid of the same cell."""
    vertices, triangles = dexel_mesh(stock)
    corners = (elementary.product(vertices, move[:3, :3].T) + move[:3, 3])[triangles]
    if not len(corners):
        corners = np.zeros((1, 3, 3))
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    return dexels_of(Stock("mesh", low, np.maximum(high, low + stock.cell), corners), stock.cell)


def turns_of(stock: Dexels, tips: Floats, axes: Floats, radius: float) -> Floats:
    """Return the angles, rad, by which tools at tips may lean otherwise meanwhile, shape (n,): a quarter of a cell where stock is.

    Args:
        stock: The stock.
        tips, axes: Shape (n, 3): where the tools are, and the directions of their axes, away from the tip.
        radius: Of their widest part, mm.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        leaves = (np.where(axes > 0, stock.high + radius, stock.low - radius) - tips) / axes
    far = np.where(np.abs(axes) > 1e-9, leaves, np.inf).min(axis=1)
    lever = np.hypot(np.clip(far, 0.0, float(np.linalg.norm(stock.high - stock.low))), radius)
    return np.asarray(np.minimum(stock.cell / 2 / np.maximum(lever, stock.cell), math.radians(2.0)))

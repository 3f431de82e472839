"""What a flat-ended tool leaves of a block: heights on a grid, lowered along the path. Slow and obvious."""

import itertools

import numpy as np

from cncgen.toolpath.record import FeedMode, Kind, Toolpath


def points_along(path: Toolpath, row: int, spacing: float) -> np.ndarray:
    """Return points, shape (n, 3), no farther apart than `spacing`, of a line or arc."""
    start, end = path.starts[row, :3], path.end[row, :3]
    if path.kind[row] == Kind.LINE:
        n = int(np.ceil(np.linalg.norm(end - start) / spacing)) + 1
        return start + np.linspace(0, 1, n + 1)[:, None] * (end - start)
    k = path.curve[row]
    centre, normal, sweep = path.arcs.centre[k], path.arcs.normal[k], path.arcs.sweep[k]
    u = start - centre
    t = np.linspace(0, 1, int(np.ceil(np.linalg.norm(u) * sweep / spacing)) + 2)[:, None]
    rise = (end - start) @ normal
    return centre + np.cos(t * sweep) * u + np.sin(t * sweep) * np.cross(normal, u) + t * rise * normal


def removed(chunks, size, top, spacing, radii) -> tuple[float, np.ndarray]:
    """Return the volume that is gone, mm³, and the heights left.

    Args:
        chunks: Toolpaths with tool events.
        size: Of the block in X and Y from the origin, mm.
        top: Its height, mm.
        spacing: Of the grid, mm.
        radii: Radius of each tool by name, mm.
    """
    x = np.arange(spacing / 2, size[0], spacing)
    y = np.arange(spacing / 2, size[1], spacing)
    heights = np.full((len(x), len(y)), float(top))
    radius = 0.0
    for path in chunks:
        for row in range(len(path)):
            if path.kind[row] == Kind.EVENT:
                event = path.events[path.curve[row]]
                radius = radii[event.values["tool"]] if event.name == "tool" else radius
                continue
            for p in points_along(path, row, spacing):
                if p[2] >= top:
                    continue
                i = slice(*np.searchsorted(x, [p[0] - radius, p[0] + radius]))
                j = slice(*np.searchsorted(y, [p[1] - radius, p[1] + radius]))
                disc = (x[i, None] - p[0]) ** 2 + (y[None, j] - p[1]) ** 2 <= radius**2
                heights[i, j] = np.where(disc, np.minimum(heights[i, j], p[2]), heights[i, j])
    return float((top - heights).sum() * spacing**2), heights


def swept(path: Toolpath, size, spacing, radius) -> tuple[np.ndarray, list[int]]:
    """Return the heights that a flat-ended tool leaves of a block with its top at 0, and the rapids that cut.

    Each stretch takes away the capsule about it, so nothing between two points is missed.

    Args:
        path: One tool's motions.
        size: Of the block in X and Y, mm.
        spacing: Of the grid, mm.
        radius: Of the tool, mm.
    """
    x = np.arange(spacing / 2, size[0], spacing)
    y = np.arange(spacing / 2, size[1], spacing)
    heights = np.zeros((len(x), len(y)))
    crashes = []
    for row in np.flatnonzero(path.kind != Kind.EVENT):
        points = points_along(path, row, 1e9 if path.kind[row] == Kind.LINE else 0.25)
        if path.kind[row] == Kind.LINE and points[0, 2] != points[-1, 2]:
            points = points_along(path, row, 1.0)
        for p, q in itertools.pairwise(points):
            level = min(p[2], q[2])
            if level >= 0.0:
                continue
            low, high = np.minimum(p, q) - radius, np.maximum(p, q) + radius
            i, j = (
                slice(*np.searchsorted(x, [low[0], high[0]])),
                slice(*np.searchsorted(y, [low[1], high[1]])),
            )
            dx, dy = (q - p)[:2]
            along = ((x[i, None] - p[0]) * dx + (y[None, j] - p[1]) * dy) / max(dx * dx + dy * dy, 1e-18)
            t = np.clip(along, 0.0, 1.0)
            near = (x[i, None] - p[0] - t * dx) ** 2 + (y[None, j] - p[1] - t * dy) ** 2 <= radius**2
            if path.feed_mode[row] == FeedMode.RAPID and (near & (heights[i, j] > level + 0.05)).any():
                crashes.append(int(row))
            heights[i, j] = np.where(near, np.minimum(heights[i, j], level), heights[i, j])
    return heights, crashes

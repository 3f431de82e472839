"""What a flat-ended tool leaves of a block: heights on a grid, lowered along the path. Slow and obvious."""

import numpy as np

from cncgen.toolpath.record import Kind, Toolpath


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

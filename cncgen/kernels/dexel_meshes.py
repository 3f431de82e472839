# cython: infer_types=True
"""Where a mesh crosses a field of dexels (`cncgen.kernels.dexel_sweeps`)."""

import cython
from cython.cimports.cncgen.kernels.removal import first_node, last_node, least


def mesh_crossings(
    triangles: cython.double[:, :, ::1],
    grid: cython.double[::1],
    rows: cython.Py_ssize_t,
    columns: cython.Py_ssize_t,
    dexel: cython.longlong[::1],
    place: cython.double[::1],
    sense: cython.schar[::1],
) -> cython.Py_ssize_t:
    """Find where a mesh crosses dexels.

    Args:
        triangles: Shape (n, 3, 3), corners (u, v, w), mm.
        grid: As of `cut_lines`; no dexel may go through an edge of a triangle.
        rows, columns: Of the field.
        dexel, place, sense: Shape (m,), filled: number of the dexel, row by row; w, mm; 1 where the line goes into the mesh, -1 where
            it leaves it, by the sense of the triangle's corners.

    Returns:
        How many crossings there are; no more than m are filled in.
    """
    found: cython.Py_ssize_t = 0
    cell: cython.double = grid[2]
    with cython.nogil:
        for k in range(triangles.shape[0]):
            ax, ay = triangles[k, 0, 0] - grid[0], triangles[k, 0, 1] - grid[1]
            bx, by = triangles[k, 1, 0] - grid[0], triangles[k, 1, 1] - grid[1]
            cx, cy = triangles[k, 2, 0] - grid[0], triangles[k, 2, 1] - grid[1]
            area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
            if area == 0.0:
                continue
            for j in range(
                first_node(least(ay, by, cy), cell), last_node(-least(-ay, -by, -cy), cell, rows) + 1
            ):
                v = j * cell
                for i in range(
                    first_node(least(ax, bx, cx), cell), last_node(-least(-ax, -bx, -cx), cell, columns) + 1
                ):
                    u = i * cell
                    # Shares of the corners b and c.
                    p = ((u - ax) * (cy - ay) - (cx - ax) * (v - ay)) / area
                    q = ((bx - ax) * (v - ay) - (u - ax) * (by - ay)) / area
                    if p < 0.0 or q < 0.0 or p + q > 1.0:
                        continue
                    if found < place.shape[0]:
                        dexel[found] = j * columns + i
                        place[found] = triangles[k, 0, 2] + p * (triangles[k, 1, 2] - triangles[k, 0, 2])
                        place[found] += q * (triangles[k, 2, 2] - triangles[k, 0, 2])
                        # Seen from above, the corners of an upper side go against the clock.
                        sense[found] = -1 if area > 0.0 else 1
                    found += 1
    return found

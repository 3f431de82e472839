"""Material removal on a height field: the swept volume of a tool that moves in straight lines, its axis along Z.

A tool is a convex profile: its surface stands h(ρ) above its tip at the distance ρ ≤ R from its axis,

    h(ρ) = 0                                for ρ ≤ f,
    h(ρ) = e - sqrt(e² - (ρ - f)²)          beyond, for a rounded edge (ball: f = 0, e = R),
    h(ρ) = (ρ - f) tan a                    beyond, for a cone (drill, chamfer).

Over a point at the distance d from the line, u before the foot of its perpendicular, the tool that rises by m a mm stands at
z + m s + h(sqrt(d² + u²)), which is convex in s. Its least value (the envelope) is taken in closed form, for a rounded edge
with a flat bottom by bisection.

Two numbers a cell: the height at its middle, and the mean height in it, which counts the part of the cell that the tool covers.
The first tells depths, the second volumes.
"""

import cython
from cython.cimports.libc.math import ceil, fabs, floor, sqrt

#: Columns of the result of `cut_lines`.
COLUMNS = 9


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def lift(rho: cython.double, flat: cython.double, edge: cython.double, slope: cython.double) -> cython.double:
    """Return h(ρ)."""
    over: cython.double = rho - flat
    if over <= 0.0:
        return 0.0
    if edge > 0.0:
        if over >= edge:
            return edge
        return edge - sqrt(edge * edge - over * over)
    return over * slope


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def lead(
    m: cython.double,
    d: cython.double,
    half: cython.double,
    flat: cython.double,
    edge: cython.double,
    slope: cython.double,
) -> cython.double:
    """Return how far from the foot the tool is lowest over a point, to the side where the line is lower (0 to `half`), mm."""
    steep: cython.double = fabs(m)
    low: cython.double
    high: cython.double
    u: cython.double
    rho: cython.double
    over: cython.double
    k: cython.int
    if edge <= 0.0:
        if steep < slope:
            u = steep * d / sqrt(slope * slope - steep * steep)
            rho = sqrt(d * d + u * u)
            if rho < flat and d < flat:
                u = sqrt(flat * flat - d * d)
        elif slope > 0.0:
            return half
        else:
            u = sqrt(flat * flat - d * d) if d < flat else 0.0
        return u if u < half else half
    if flat <= 0.0:
        u = steep * sqrt(edge * edge - d * d) / sqrt(1.0 + m * m) if d < edge else 0.0
        return u if u < half else half
    if d < 0.9 * flat:
        # u = sqrt(ρ² - d²) and the slope of the edge at ρ determine each other; a few rounds do.
        rho = flat
        for k in range(12):
            u = sqrt(rho * rho - d * d)
            low = steep * rho / u
            high = flat + edge * low / sqrt(1.0 + low * low)
            over = high - rho
            rho = high
            if fabs(over) < 1e-6:
                break
        u = sqrt(rho * rho - d * d)
        return u if u < half else half
    low, high = 0.0, half
    for k in range(26):
        u = 0.5 * (low + high)
        rho = sqrt(d * d + u * u)
        over = rho - flat
        if over <= 0.0:
            low = u
        elif over >= edge or over * u > steep * rho * sqrt(edge * edge - over * over):
            high = u
        else:
            low = u
    return 0.5 * (low + high)


def cut_lines(
    heights: cython.double[:, ::1],
    mean: cython.double[:, ::1],
    top: cython.double[:, ::1],
    bottom: cython.double[:, ::1],
    part: cython.double[:, ::1],
    grid: cython.double[::1],
    lines: cython.double[:, ::1],
    tool: cython.double[::1],
    limits: cython.double[::1],
    out: cython.double[:, ::1],
) -> None:
    """Cut a height field along straight lines, one after the other.

    Args:
        heights, mean: Shape (rows, columns): height at the middle of each cell and mean height in it, mm; lowered in place.
        top, bottom: Shape alike: the stock's top and underside.
        part: Shape alike: the finished part's top, -inf where nothing is to stay.
        grid: x and y of the first cell's middle, and the width of a cell, mm.
        lines: Shape (n, 6): start and end of the tip, mm.
        tool: Radius, flat radius, radius of the edge, slope of the cone, length of the cutting edge, mm.
        limits: Margin at the tool's side and at its tip within which a touch does not count, mm.
        out: Shape (n, COLUMNS), filled: volume removed; the deepest bite, with its column and row; the deepest gouge of the
            part, with column and row, and the volume gouged; how far material stands above the cutting edge. mm, mm³.
    """
    n: cython.Py_ssize_t = lines.shape[0]
    k: cython.Py_ssize_t
    with cython.nogil:
        for k in range(n):
            _cut(heights, mean, top, bottom, part, grid, lines, k, tool, limits, out)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _cut(
    heights: cython.double[:, ::1],
    mean: cython.double[:, ::1],
    top: cython.double[:, ::1],
    bottom: cython.double[:, ::1],
    part: cython.double[:, ::1],
    grid: cython.double[::1],
    lines: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    tool: cython.double[::1],
    limits: cython.double[::1],
    out: cython.double[:, ::1],
) -> cython.void:
    """Cut along one line."""
    radius: cython.double = tool[0]
    flat: cython.double = tool[1]
    edge: cython.double = tool[2]
    slope: cython.double = tool[3]
    length_cut: cython.double = tool[4]
    cell: cython.double = grid[2]
    px: cython.double = lines[k, 0] - grid[0]
    py: cython.double = lines[k, 1] - grid[1]
    pz: cython.double = lines[k, 2]
    qx: cython.double = lines[k, 3] - grid[0]
    qy: cython.double = lines[k, 4] - grid[1]
    qz: cython.double = lines[k, 5]
    reach: cython.double = radius + 0.75 * cell
    inner: cython.double = radius - 0.5 * cell
    sure: cython.double = radius - limits[0]
    level: cython.double = limits[1]
    length: cython.double = sqrt((qx - px) * (qx - px) + (qy - py) * (qy - py))
    tx: cython.double = 1.0
    ty: cython.double = 0.0
    m: cython.double = 0.0
    base: cython.double = pz
    lowest: cython.double = pz if pz < qz else qz
    nx: cython.Py_ssize_t = heights.shape[1]
    ny: cython.Py_ssize_t = heights.shape[0]
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    i0: cython.Py_ssize_t
    i1: cython.Py_ssize_t
    j0: cython.Py_ssize_t
    j1: cython.Py_ssize_t
    x: cython.double
    y: cython.double
    s: cython.double
    foot: cython.double
    d: cython.double
    d2: cython.double
    half: cython.double
    env: cython.double
    tip: cython.double
    rho: cython.double
    cover: cython.double
    lo: cython.double
    hi: cython.double
    middle: cython.double
    wide: cython.double
    value: cython.double
    old: cython.double
    volume: cython.double = 0.0
    gouged: cython.double = 0.0
    floor_of: cython.double
    out[k, 0] = out[k, 1] = out[k, 4] = out[k, 7] = 0.0
    out[k, 2] = out[k, 3] = out[k, 5] = out[k, 6] = -1.0
    out[k, 8] = -1e300
    if length > 1e-9:
        tx, ty = (qx - px) / length, (qy - py) / length
        m = (qz - pz) / length
    else:
        length = 0.0
        base = lowest
    lo = (py if py < qy else qy) - reach
    hi = (py if py > qy else qy) + reach
    j0 = cython.cast(cython.Py_ssize_t, ceil(lo / cell)) if lo > 0.0 else 0
    j1 = cython.cast(cython.Py_ssize_t, floor(hi / cell)) if hi < (ny - 1) * cell else ny - 1
    if hi < 0.0 or lo > (ny - 1) * cell:
        return
    for j in range(j0, j1 + 1):
        y = j * cell - py
        lo = (px if px < qx else qx) - reach
        hi = (px if px > qx else qx) + reach
        if fabs(ty) > 1e-9:
            # The strip beside the line: |y tx - (x - px) ty| <= reach.
            middle, wide = px + y * tx / ty, reach / fabs(ty)
            lo = middle - wide if middle - wide > lo else lo
            hi = middle + wide if middle + wide < hi else hi
        if hi < 0.0 or lo > (nx - 1) * cell:
            continue
        i0 = cython.cast(cython.Py_ssize_t, ceil(lo / cell)) if lo > 0.0 else 0
        i1 = cython.cast(cython.Py_ssize_t, floor(hi / cell)) if hi < (nx - 1) * cell else nx - 1
        for i in range(i0, i1 + 1):
            # A cell that a deep cut covers in part has a mean height below that of its middle.
            old = mean[j, i] if mean[j, i] > heights[j, i] else heights[j, i]
            floor_of = bottom[j, i]
            if old <= lowest or old <= floor_of:
                continue
            x = i * cell - px
            foot = x * tx + y * ty
            d = fabs(y * tx - x * ty)
            s = 0.0 if foot < 0.0 else (length if foot > length else foot)
            d2 = d * d + (foot - s) * (foot - s)
            if d2 >= reach * reach:
                continue
            rho = sqrt(d2)
            cover = 1.0 if rho <= inner else 0.5 + (radius - rho) / cell
            if cover <= 0.0:
                continue
            # The tool is nowhere lower over the cell than its least height with the tip at the line's lower end.
            if lowest + lift(rho if rho < radius else radius, flat, edge, slope) >= old:
                continue
            if m != 0.0:
                if d < radius:
                    half = sqrt(radius * radius - d * d)
                    wide = lead(m, d, half, flat, edge, slope)
                    s = foot - wide if m > 0.0 else foot + wide
                    lo = foot - half
                    hi = foot + half
                    lo = 0.0 if lo < 0.0 else lo
                    hi = length if hi > length else hi
                    if hi < lo:  # beyond an end of the line, by less than a cell
                        lo = hi = 0.0 if foot < 0.0 else length
                    s = lo if s < lo else (hi if s > hi else s)
                value = sqrt(d * d + (foot - s) * (foot - s))
            else:
                value = rho
            if value > radius:
                value = radius
            tip = base + m * s
            env = tip + lift(value, flat, edge, slope)
            if env < floor_of:
                env = floor_of
            if cover < 1.0:
                value = top[j, i] - cover * (top[j, i] - env)
            else:
                value = env
            if value < mean[j, i]:
                volume += mean[j, i] - value
                mean[j, i] = value
            old = heights[j, i]
            if rho > radius or env >= old:
                continue
            heights[j, i] = env
            value = part[j, i]
            if env < value - level:
                gouged += (old if old < value else value) - env
            if rho > sure:
                continue
            if old - env > out[k, 1]:
                out[k, 1] = old - env
                out[k, 2] = i
                out[k, 3] = j
            if old - tip - length_cut > out[k, 8] and old - env > level:
                out[k, 8] = old - tip - length_cut
            if env < value - level and value - env > out[k, 4]:
                out[k, 4] = value - env
                out[k, 5] = i
                out[k, 6] = j
    out[k, 0] = volume * cell * cell
    out[k, 7] = gouged * cell * cell


def highest_beside(
    heights: cython.double[:, ::1],
    grid: cython.double[::1],
    lines: cython.double[:, ::1],
    radius: cython.double,
    above: cython.double,
    out: cython.double[:, ::1],
) -> None:
    """Tell how far material stands above the end of a cylinder that moves along lines: a shank, a holder.

    Args:
        heights, grid, lines: As of `cut_lines`; nothing is changed.
        radius: Of the cylinder, mm.
        above: Where it begins above the tip, mm.
        out: Shape (n, 3), filled: the largest height above the end, negative where it is free; column and row.
    """
    n: cython.Py_ssize_t = lines.shape[0]
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    cell: cython.double = grid[2]
    nx: cython.Py_ssize_t = heights.shape[1]
    ny: cython.Py_ssize_t = heights.shape[0]
    lo: cython.double
    hi: cython.double
    px: cython.double
    py: cython.double
    dx: cython.double
    dy: cython.double
    l2: cython.double
    t: cython.double
    x: cython.double
    y: cython.double
    over: cython.double
    i0: cython.Py_ssize_t
    i1: cython.Py_ssize_t
    j0: cython.Py_ssize_t
    j1: cython.Py_ssize_t
    with cython.nogil:
        for k in range(n):
            out[k, 0] = -1e300
            out[k, 1] = out[k, 2] = -1.0
            px, py = lines[k, 0] - grid[0], lines[k, 1] - grid[1]
            dx, dy = lines[k, 3] - lines[k, 0], lines[k, 4] - lines[k, 1]
            l2 = dx * dx + dy * dy
            lo = (py if dy > 0.0 else py + dy) - radius
            hi = (py if dy < 0.0 else py + dy) + radius
            if hi < 0.0 or lo > (ny - 1) * cell:
                continue
            j0 = cython.cast(cython.Py_ssize_t, ceil(lo / cell)) if lo > 0.0 else 0
            j1 = cython.cast(cython.Py_ssize_t, floor(hi / cell)) if hi < (ny - 1) * cell else ny - 1
            lo = (px if dx > 0.0 else px + dx) - radius
            hi = (px if dx < 0.0 else px + dx) + radius
            if hi < 0.0 or lo > (nx - 1) * cell:
                continue
            i0 = cython.cast(cython.Py_ssize_t, ceil(lo / cell)) if lo > 0.0 else 0
            i1 = cython.cast(cython.Py_ssize_t, floor(hi / cell)) if hi < (nx - 1) * cell else nx - 1
            for j in range(j0, j1 + 1):
                for i in range(i0, i1 + 1):
                    x, y = i * cell - px, j * cell - py
                    t = (x * dx + y * dy) / l2 if l2 > 1e-18 else 0.0
                    t = 0.0 if t < 0.0 else (1.0 if t > 1.0 else t)
                    if (x - t * dx) * (x - t * dx) + (y - t * dy) * (y - t * dy) > radius * radius:
                        continue
                    if l2 <= 1e-18:
                        over = lines[k, 2] if lines[k, 2] < lines[k, 5] else lines[k, 5]
                    else:
                        over = lines[k, 2] + t * (lines[k, 5] - lines[k, 2])
                    over = heights[j, i] - over - above
                    if over > out[k, 0]:
                        out[k, 0] = over
                        out[k, 1] = i
                        out[k, 2] = j


def mesh_columns(
    triangles: cython.double[:, :, ::1],
    grid: cython.double[::1],
    top: cython.double[:, ::1],
    bottom: cython.double[:, ::1],
) -> None:
    """Raise `top` and lower `bottom` to a mesh over the middles of columns.

    Args:
        triangles: Shape (n, 3, 3), mm.
        grid: As of `cut_lines`.
        top, bottom: Shape (rows, columns), changed in place.
    """
    n: cython.Py_ssize_t = triangles.shape[0]
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    nx: cython.Py_ssize_t = top.shape[1]
    ny: cython.Py_ssize_t = top.shape[0]
    cell: cython.double = grid[2]
    ax: cython.double
    ay: cython.double
    bx: cython.double
    by: cython.double
    cx: cython.double
    cy: cython.double
    area: cython.double
    v: cython.double
    w: cython.double
    z: cython.double
    lo: cython.double
    hi: cython.double
    i0: cython.Py_ssize_t
    i1: cython.Py_ssize_t
    j0: cython.Py_ssize_t
    j1: cython.Py_ssize_t
    with cython.nogil:
        for k in range(n):
            ax, ay = triangles[k, 0, 0] - grid[0], triangles[k, 0, 1] - grid[1]
            bx, by = triangles[k, 1, 0] - grid[0] - ax, triangles[k, 1, 1] - grid[1] - ay
            cx, cy = triangles[k, 2, 0] - grid[0] - ax, triangles[k, 2, 1] - grid[1] - ay
            area = bx * cy - cx * by
            if fabs(area) < 1e-12:
                continue
            lo = (bx if bx < cx else cx) if (bx < 0.0 or cx < 0.0) else 0.0
            hi = (bx if bx > cx else cx) if (bx > 0.0 or cx > 0.0) else 0.0
            lo, hi = ax + lo - 1e-4 * cell, ax + hi + 1e-4 * cell
            if hi < 0.0 or lo > (nx - 1) * cell:
                continue
            i0 = cython.cast(cython.Py_ssize_t, ceil(lo / cell)) if lo > 0.0 else 0
            i1 = cython.cast(cython.Py_ssize_t, floor(hi / cell)) if hi < (nx - 1) * cell else nx - 1
            lo = (by if by < cy else cy) if (by < 0.0 or cy < 0.0) else 0.0
            hi = (by if by > cy else cy) if (by > 0.0 or cy > 0.0) else 0.0
            lo, hi = ay + lo - 1e-4 * cell, ay + hi + 1e-4 * cell
            if hi < 0.0 or lo > (ny - 1) * cell:
                continue
            j0 = cython.cast(cython.Py_ssize_t, ceil(lo / cell)) if lo > 0.0 else 0
            j1 = cython.cast(cython.Py_ssize_t, floor(hi / cell)) if hi < (ny - 1) * cell else ny - 1
            for j in range(j0, j1 + 1):
                for i in range(i0, i1 + 1):
                    v = ((i * cell - ax) * cy - cx * (j * cell - ay)) / area
                    w = (bx * (j * cell - ay) - (i * cell - ax) * by) / area
                    if v < -1e-4 or w < -1e-4 or v + w > 1.0 + 1e-4:
                        continue
                    z = triangles[k, 0, 2] + v * (triangles[k, 1, 2] - triangles[k, 0, 2])
                    z += w * (triangles[k, 2, 2] - triangles[k, 0, 2])
                    top[j, i] = z if z > top[j, i] else top[j, i]
                    bottom[j, i] = z if z < bottom[j, i] else bottom[j, i]

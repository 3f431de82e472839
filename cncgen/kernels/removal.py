# cython: infer_types=True
"""Material removal on a height field: the swept volume of a tool that moves in straight lines, its axis along Z.

A tool is a convex profile: its surface stands h(ρ) above its tip at the distance ρ ≤ R from its axis,

    h(ρ) = 0                                for ρ ≤ f,
    h(ρ) = e - sqrt(e² - (ρ - f)²)          beyond, for a rounded edge (ball: f = 0, e = R),
    h(ρ) = (ρ - f) tan a                    beyond, for a cone (drill, chamfer).

Over a point at the distance d from the line, u before the foot of its perpendicular, the tool that rises by m a mm stands at
z + m s + h(sqrt(d² + u²)), which is convex in s. Its least value (the envelope) is taken in closed form, for a rounded edge
with a flat bottom by Newton's method.

Two numbers a cell: the height at its middle, and the mean height in it, which counts the part of the cell that the tool covers.
The first tells depths, the second volumes.
"""

import cython
from cython.cimports.libc.math import ceil, fabs, floor, sqrt

#: Columns of the result of `cut_lines`.
COLUMNS = 9
#: Rows and columns of a square of cells, whose greatest height is known: as many as a line of the processor's cache holds.
SQUARE = 8
_SQUARE = cython.declare(cython.Py_ssize_t, SQUARE)
#: The height of nothing.
_NOTHING = cython.declare(cython.double, -1e300)


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


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _lead(
    m: cython.double,
    d: cython.double,
    half: cython.double,
    flat: cython.double,
    edge: cython.double,
    slope: cython.double,
) -> cython.double:
    """Return how far from the foot a tool that rises by m ≥ 0 is lowest, to the side where the line is lower (0 to `half`), mm."""
    k: cython.int
    if edge <= 0.0:
        if m < slope:
            u = m * d / sqrt(slope * slope - m * m)
            rho = sqrt(d * d + u * u)
            if rho < flat and d < flat:
                u = sqrt(flat * flat - d * d)
        elif slope > 0.0:
            return half
        else:
            u = sqrt(flat * flat - d * d) if d < flat else 0.0
        return u if u < half else half
    if flat <= 0.0:
        u = m * sqrt(edge * edge - d * d) / sqrt(1.0 + m * m) if d < edge else 0.0
        return u if u < half else half
    # Where the edge touches, at the sine x of its angle from below, its normal is across the way:
    # (f + e x)² (x² - c) = d² x² / (1 + m²), with c = m² / (1 + m²). The difference rises and is convex from its root on.
    share = 1.0 / (1.0 + m * m)
    c = m * m * share
    x = d / (flat + edge * sqrt(c))
    x = 1.0 - x * x * share
    x = sqrt(c / x) if x > c else 1.0
    for k in range(60):
        rho = flat + edge * x
        step = rho * rho * (x * x - c) - share * d * d * x * x
        step /= 2.0 * (edge * rho * (x * x - c) + x * rho * rho - share * d * d * x)
        x -= step
        if step < 1e-7:
            break
    rho = flat + edge * x
    u = sqrt(rho * rho - d * d) if rho > d else 0.0
    return u if u < half else half


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _lowers(
    m: cython.double,
    u: cython.double,
    d: cython.double,
    flat: cython.double,
    edge: cython.double,
    slope: cython.double,
) -> cython.bint:
    """Tell whether a tool u past a point, at the distance d beside it, stands lower over it the farther back it was, rising by m."""
    rho: cython.double = sqrt(d * d + u * u)
    over: cython.double = rho - flat
    if over <= 0.0:
        return True
    if edge > 0.0:
        return over < edge and m * rho * sqrt(edge * edge - over * over) >= over * u
    return m * rho >= slope * u


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def lowest_at(
    x: cython.double,
    d: cython.double,
    length: cython.double,
    m: cython.double,
    radius: cython.double,
    flat: cython.double,
    edge: cython.double,
    slope: cython.double,
) -> cython.double:
    """Return where on its way (0 to `length`) a tool that rises by m a mm is lowest over a point x along it and d beside it, mm.

    That is the nearer end where the tool does not reach the point.
    """
    rise: cython.double = fabs(m)
    # Seen from the lower end.
    from_low: cython.double = x if m >= 0.0 else length - x
    beyond: cython.double = from_low - length
    reach2: cython.double = radius * radius - d * d
    if from_low <= 0.0:
        s = 0.0
    elif rise == 0.0 or reach2 <= 0.0:
        s = from_low if beyond < 0.0 else length
    elif from_low * from_low <= reach2 and _lowers(rise, from_low, d, flat, edge, slope):
        s = 0.0
    elif beyond > 0.0 and (beyond * beyond >= reach2 or not _lowers(rise, beyond, d, flat, edge, slope)):
        s = length
    else:
        s = from_low - _lead(rise, d, sqrt(reach2), flat, edge, slope)
        s = 0.0 if s < 0.0 else (length if s > length else s)
    return s if m >= 0.0 else length - s


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def first_node(low: cython.double, cell: cython.double) -> cython.Py_ssize_t:
    """Return the first node of a row (or column) at a place or after it."""
    return cython.cast(cython.Py_ssize_t, ceil(low / cell)) if low > 0.0 else 0


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def last_node(high: cython.double, cell: cython.double, count: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Return the last of `count` nodes of a row (or column) at a place or before it, -1 if missing."""
    if high < 0.0:
        return -1
    return cython.cast(cython.Py_ssize_t, floor(high / cell)) if high < (count - 1) * cell else count - 1


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def least(a: cython.double, b: cython.double, c: cython.double) -> cython.double:
    """Return the least of three numbers."""
    a = a if a < b else b
    return a if a < c else c


@cython.final
@cython.cclass
class _Way:
    """The straight way of an upright tool over the grid, from its first cell's middle."""

    px: cython.double
    py: cython.double
    # Its direction and length across the axis, how far it rises a mm of that, and where it starts and is lowest.
    tx: cython.double
    ty: cython.double
    length: cython.double
    rise: cython.double
    base: cython.double
    lowest: cython.double
    # The rows that it reaches; and the columns, of a few rows.
    first_row: cython.Py_ssize_t
    last_row: cython.Py_ssize_t
    first: cython.Py_ssize_t
    last: cython.Py_ssize_t

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _take(
        self,
        lines: cython.double[:, ::1],
        k: cython.Py_ssize_t,
        grid: cython.double[::1],
        rows: cython.Py_ssize_t,
        reach: cython.double,
    ) -> cython.void:
        """Take a line of a tool that reaches so far from its axis."""
        dx: cython.double = lines[k, 3] - lines[k, 0]
        dy: cython.double = lines[k, 4] - lines[k, 1]
        dz: cython.double = lines[k, 5] - lines[k, 2]
        self.px, self.py = lines[k, 0] - grid[0], lines[k, 1] - grid[1]
        self.length = sqrt(dx * dx + dy * dy)
        self.lowest = lines[k, 2] + (dz if dz < 0.0 else 0.0)
        if self.length > 1e-9:
            self.tx, self.ty, self.rise = dx / self.length, dy / self.length, dz / self.length
            self.base = lines[k, 2]
        else:
            self.tx, self.ty, self.rise, self.length = 1.0, 0.0, 0.0, 0.0
            self.base = self.lowest
        self.first_row = first_node(self.py + (dy if dy < 0.0 else 0.0) - reach, grid[2])
        self.last_row = last_node(self.py + (dy if dy > 0.0 else 0.0) + reach, grid[2], rows)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _columns(
        self,
        low: cython.double,
        high: cython.double,
        reach: cython.double,
        cell: cython.double,
        columns: cython.Py_ssize_t,
    ) -> cython.void:
        """Find the columns that the tool reaches where y is between two places."""
        qx: cython.double = self.px + self.length * self.tx
        lo: cython.double = (self.px if self.px < qx else qx) - reach
        hi: cython.double = (self.px if self.px > qx else qx) + reach
        if fabs(self.ty) > 1e-9:
            # The strip beside the line: |y tx - (x - px) ty| <= reach.
            a, b = (low - self.py) * self.tx / self.ty, (high - self.py) * self.tx / self.ty
            if a > b:
                a, b = b, a
            wide = reach / fabs(self.ty)
            lo = self.px + a - wide if self.px + a - wide > lo else lo
            hi = self.px + b + wide if self.px + b + wide < hi else hi
        self.first, self.last = first_node(lo, cell), last_node(hi, cell, columns)

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _nearest(self, foot: cython.double) -> cython.double:
        """Return the place of the way that is nearest to one on the line through it, mm from its start."""
        return 0.0 if foot < 0.0 else (self.length if foot > self.length else foot)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _square_beside(
        self, j: cython.Py_ssize_t, i: cython.Py_ssize_t, cell: cython.double
    ) -> cython.double:
        """Return a distance from the way within which no cell of a square of the grid has its middle."""
        half: cython.double = 0.5 * (_SQUARE - 1) * cell
        x: cython.double = i * _SQUARE * cell + half - self.px
        y: cython.double = j * _SQUARE * cell + half - self.py
        foot: cython.double = x * self.tx + y * self.ty
        s: cython.double = self._nearest(foot)
        d: cython.double = y * self.tx - x * self.ty
        return sqrt(d * d + (foot - s) * (foot - s)) - 1.4143 * half


def bound_squares(
    heights: cython.double[:, ::1],
    mean: cython.double[:, ::1],
    bottom: cython.double[:, ::1],
    squares: cython.double[:, ::1],
) -> None:
    """Find how high each square of SQUARE by SQUARE cells is at most.

    Args:
        heights, mean, bottom: As of `cut_lines`.
        squares: Shape (rows / SQUARE, columns / SQUARE), rounded up; filled, -1e300 where nothing is.
    """
    with cython.nogil:
        for j in range(squares.shape[0]):
            for i in range(squares.shape[1]):
                squares[j, i] = _NOTHING
        for j in range(heights.shape[0]):
            for i in range(heights.shape[1]):
                value = mean[j, i] if mean[j, i] > heights[j, i] else heights[j, i]
                if value > bottom[j, i] and value > squares[j // _SQUARE, i // _SQUARE]:
                    squares[j // _SQUARE, i // _SQUARE] = value


@cython.final
@cython.cclass
class _Cut:
    """The cut along a line."""

    heights: cython.double[:, ::1]
    mean: cython.double[:, ::1]
    top: cython.double[:, ::1]
    bottom: cython.double[:, ::1]
    part: cython.double[:, ::1]
    radius: cython.double
    flat: cython.double
    edge: cython.double
    slope: cython.double
    edge_length: cython.double
    cell: cython.double
    # Within `sure` of the axis, and deeper than `level`, a touch counts.
    sure: cython.double
    level: cython.double
    volume: cython.double
    bite: cython.double
    bite_x: cython.double
    bite_y: cython.double
    gouge: cython.double
    gouge_x: cython.double
    gouge_y: cython.double
    gouged: cython.double
    above: cython.double

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _square(
        self,
        way: _Way,
        first_row: cython.Py_ssize_t,
        last_row: cython.Py_ssize_t,
        first: cython.Py_ssize_t,
        last: cython.Py_ssize_t,
    ) -> cython.double:
        """Cut some cells; return how high they are at most afterwards, -1e300 if there is nothing left."""
        highest: cython.double = _NOTHING
        for j in range(first_row, last_row + 1):
            for i in range(first, last + 1):
                most = self._most(j, i)
                if most > way.lowest:
                    most = self._lower(way, j, i, most)
                if most > highest and most > self.bottom[j, i]:
                    highest = most
        return highest

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _most(self, j: cython.Py_ssize_t, i: cython.Py_ssize_t) -> cython.double:
        """Return the greater of a cell's two heights: one that a deep cut covers in part has a mean below that of its middle."""
        height: cython.double = self.heights[j, i]
        mean: cython.double = self.mean[j, i]
        return mean if mean > height else height

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _lift(self, rho: cython.double) -> cython.double:
        """Return h(ρ), beyond the tool's radius as at its rim."""
        return lift(rho if rho < self.radius else self.radius, self.flat, self.edge, self.slope)

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _lower(
        self, way: _Way, j: cython.Py_ssize_t, i: cython.Py_ssize_t, most: cython.double
    ) -> cython.double:
        """Cut a cell whose heights are so much at most; return how much they are at most afterwards."""
        cell: cython.double = self.cell
        radius: cython.double = self.radius
        reach: cython.double = radius + 0.75 * cell
        x: cython.double = i * cell - way.px
        y: cython.double = j * cell - way.py
        foot: cython.double = x * way.tx + y * way.ty
        d: cython.double = fabs(y * way.tx - x * way.ty)
        s: cython.double = way._nearest(foot)
        rho: cython.double = d * d + (foot - s) * (foot - s)
        if rho >= reach * reach:
            return most
        rho = sqrt(rho)
        cover: cython.double = 1.0 if rho <= radius - 0.5 * cell else 0.5 + (radius - rho) / cell
        # The tool is nowhere lower over the cell than its least height with the tip at the line's lower end.
        bottom: cython.double = self.bottom[j, i]
        if cover <= 0.0 or way.lowest + self._lift(rho) >= most or most <= bottom:
            return most
        at: cython.double = rho
        if way.rise != 0.0:
            s = lowest_at(foot, d, way.length, way.rise, radius, self.flat, self.edge, self.slope)
            at = sqrt(d * d + (foot - s) * (foot - s))
        tip: cython.double = way.base + way.rise * s
        env: cython.double = tip + self._lift(at)
        env = env if env > bottom else bottom
        mean: cython.double = env if cover >= 1.0 else self.top[j, i] - cover * (self.top[j, i] - env)
        if mean < self.mean[j, i]:
            self.volume += self.mean[j, i] - mean
            self.mean[j, i] = mean
        height: cython.double = self.heights[j, i]
        if rho <= radius and env < height:
            self.heights[j, i] = env
            self._touch(j, i, height, env, tip, rho <= self.sure)
        return self._most(j, i)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _touch(
        self,
        j: cython.Py_ssize_t,
        i: cython.Py_ssize_t,
        old: cython.double,
        env: cython.double,
        tip: cython.double,
        sure: cython.bint,
    ) -> cython.void:
        """Judge a cell that the tool, its tip so low, lowers at its middle from one height to another."""
        part: cython.double = self.part[j, i]
        into: cython.double = part - env
        if into > self.level:
            self.gouged += (old if old < part else part) - env
        if not sure:
            return
        if old - env > self.bite:
            self.bite, self.bite_x, self.bite_y = old - env, i, j
        if old - tip - self.edge_length > self.above and old - env > self.level:
            self.above = old - tip - self.edge_length
        if into > self.level and into > self.gouge:
            self.gouge, self.gouge_x, self.gouge_y = into, i, j


def cut_lines(
    heights: cython.double[:, ::1],
    mean: cython.double[:, ::1],
    top: cython.double[:, ::1],
    bottom: cython.double[:, ::1],
    part: cython.double[:, ::1],
    squares: cython.double[:, ::1],
    grid: cython.double[::1],
    lines: cython.double[:, ::1],
    tool: cython.double[::1],
    limits: cython.double[::1],
    out: cython.double[:, ::1],
) -> None:
    """Cut a height field along straight lines, one after the other.

    A square of cells that is lower than the tool on its way is passed over.

    Args:
        heights, mean: Shape (rows, columns): height at the middle of each cell and mean height in it, mm; lowered in place.
        top, bottom: Shape alike: the stock's top and underside.
        part: Shape alike: the finished part's top, -inf where nothing is to stay.
        squares: As of `bound_squares`; lowered in place.
        grid: x and y of the first cell's middle, and the width of a cell, mm.
        lines: Shape (n, 6): start and end of the tip, mm.
        tool: Radius, flat radius, radius of the edge, slope of the cone, length of the cutting edge, mm.
        limits: Margin at the tool's side and at its tip within which a touch does not count, mm.
        out: Shape (n, COLUMNS), filled: volume removed; the deepest bite, with its column and row; the deepest gouge of the
            part, with column and row, and the volume gouged; how far material stands above the cutting edge. mm, mm³.
    """
    cell: cython.double = grid[2]
    reach: cython.double = tool[0] + 0.75 * cell
    rows: cython.Py_ssize_t = heights.shape[0]
    columns: cython.Py_ssize_t = heights.shape[1]
    way: _Way = _Way()
    cut: _Cut = _Cut()
    cut.heights, cut.mean, cut.top, cut.bottom, cut.part = heights, mean, top, bottom, part
    cut.radius, cut.flat, cut.edge, cut.slope, cut.edge_length = tool[0], tool[1], tool[2], tool[3], tool[4]
    cut.cell, cut.sure, cut.level = cell, tool[0] - limits[0], limits[1]
    with cython.nogil:
        for k in range(lines.shape[0]):
            cut.volume = cut.bite = cut.gouge = cut.gouged = 0.0
            cut.bite_x = cut.bite_y = cut.gouge_x = cut.gouge_y = -1.0
            cut.above = _NOTHING
            way._take(lines, k, grid, rows, reach)
            for j in range(way.first_row // _SQUARE, (way.last_row + _SQUARE) // _SQUARE):
                end_row = (j + 1) * _SQUARE - 1 if (j + 1) * _SQUARE < rows else rows - 1
                way._columns(j * _SQUARE * cell, end_row * cell, reach, cell, columns)
                for i in range(way.first // _SQUARE, (way.last + _SQUARE) // _SQUARE):
                    if squares[j, i] <= way.lowest:
                        continue
                    beside = way._square_beside(j, i, cell)
                    if beside > reach or (beside > 0.0 and way.lowest + cut._lift(beside) >= squares[j, i]):
                        continue
                    end = (i + 1) * _SQUARE - 1 if (i + 1) * _SQUARE < columns else columns - 1
                    squares[j, i] = cut._square(way, j * _SQUARE, end_row, i * _SQUARE, end)
            out[k, 0] = cut.volume * cell * cell
            out[k, 1], out[k, 2], out[k, 3] = cut.bite, cut.bite_x, cut.bite_y
            out[k, 4], out[k, 5], out[k, 6] = cut.gouge, cut.gouge_x, cut.gouge_y
            out[k, 7], out[k, 8] = cut.gouged * cell * cell, cut.above


def highest_beside(
    heights: cython.double[:, ::1],
    bottom: cython.double[:, ::1],
    squares: cython.double[:, ::1],
    grid: cython.double[::1],
    lines: cython.double[:, ::1],
    radius: cython.double,
    above: cython.double,
    out: cython.double[:, ::1],
) -> None:
    """Tell how far material stands above the end of a cylinder that moves along lines: a shank, a holder.

    Args:
        heights, bottom, squares, grid, lines: As of `cut_lines`; nothing is changed.
        radius: Of the cylinder, mm.
        above: Where it begins above the tip, mm.
        out: Shape (n, 3), filled: the largest height above the end, 0 where it is free; column and row.
    """
    cell: cython.double = grid[2]
    rows: cython.Py_ssize_t = heights.shape[0]
    columns: cython.Py_ssize_t = heights.shape[1]
    way: _Way = _Way()
    with cython.nogil:
        for k in range(lines.shape[0]):
            most = 0.0
            out[k, 1] = out[k, 2] = -1.0
            way._take(lines, k, grid, rows, radius)
            for j in range(way.first_row // _SQUARE, (way.last_row + _SQUARE) // _SQUARE):
                end_row = (j + 1) * _SQUARE if (j + 1) * _SQUARE < rows else rows
                way._columns(j * _SQUARE * cell, (end_row - 1) * cell, radius, cell, columns)
                for i in range(way.first // _SQUARE, (way.last + _SQUARE) // _SQUARE):
                    if squares[j, i] - way.lowest - above <= most or way._square_beside(j, i, cell) > radius:
                        continue
                    for b in range(j * _SQUARE, end_row):
                        for a in range(
                            i * _SQUARE, (i + 1) * _SQUARE if (i + 1) * _SQUARE < columns else columns
                        ):
                            x, y = a * cell - way.px, b * cell - way.py
                            foot, d = x * way.tx + y * way.ty, y * way.tx - x * way.ty
                            s = way._nearest(foot)
                            over = heights[b, a] - (way.base + way.rise * s) - above
                            if over <= most or heights[b, a] <= bottom[b, a]:
                                continue
                            if (foot - s) * (foot - s) + d * d <= radius * radius:
                                most = over
                                out[k, 1], out[k, 2] = a, b
            out[k, 0] = most


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
    cell: cython.double = grid[2]
    # Edges are a hair wide, so that a column on one meets a triangle beside it whatever the rounding.
    hair: cython.double = 1e-4 * cell
    with cython.nogil:
        for k in range(triangles.shape[0]):
            # Corner a, and b and c from it.
            ax, ay, az = triangles[k, 0, 0] - grid[0], triangles[k, 0, 1] - grid[1], triangles[k, 0, 2]
            bx, by = triangles[k, 1, 0] - grid[0] - ax, triangles[k, 1, 1] - grid[1] - ay
            cx, cy = triangles[k, 2, 0] - grid[0] - ax, triangles[k, 2, 1] - grid[1] - ay
            area = bx * cy - cx * by
            if fabs(area) < 1e-12:
                continue
            first = first_node(ax + least(0.0, bx, cx) - hair, cell)
            last = last_node(ax - least(0.0, -bx, -cx) + hair, cell, top.shape[1])
            first_row = first_node(ay + least(0.0, by, cy) - hair, cell)
            last_row = last_node(ay - least(0.0, -by, -cy) + hair, cell, top.shape[0])
            for j in range(first_row, last_row + 1):
                for i in range(first, last + 1):
                    # Shares of the corners b and c.
                    v = ((i * cell - ax) * cy - cx * (j * cell - ay)) / area
                    w = (bx * (j * cell - ay) - (i * cell - ax) * by) / area
                    if v < -1e-4 or w < -1e-4 or v + w > 1.0 + 1e-4:
                        continue
                    z = az + v * (triangles[k, 1, 2] - az) + w * (triangles[k, 2, 2] - az)
                    top[j, i] = z if z > top[j, i] else top[j, i]
                    bottom[j, i] = z if z < bottom[j, i] else bottom[j, i]

# cython: cpow=True, infer_types=True
"""The spacing of the nodes of a mesh at places of a path, and nodes spread by it, place by place.

Called by `cncgen.planner.least_time.mesh_spacing`, which says what the numbers mean.
"""

import cython
from cython.cimports.libc.math import ceil, expm1, fabs, log1p, pow

#: Ratios of spacings that differ by less than this part are taken to be equal.
_ALIKE = cython.declare(cython.double, 1e-6)
#: Where the spacings at neighbouring places differ by more than this factor, they are not interpolated linearly (`graded`).
_STEEP = cython.declare(cython.double, 1.5)
_INFINITE = cython.declare(cython.double, float("inf"))


def lowered(
    values: cython.const[cython.double][::1], way: cython.const[cython.double][::1], out: cython.double[::1]
) -> None:
    """Fill `out` with the largest values, none above `values`, that differ between two places by the way between them at most.

    A value that no other one lowers is the same to the last digit, however large the way is beside it.
    """
    least: cython.double = _INFINITE
    with cython.nogil:
        for n in range(out.shape[0]):
            up = values[n] - way[n]
            out[n] = values[n]
            if up <= least:
                least = up
            else:
                out[n] = min(least + way[n], values[n])
        least = _INFINITE
        for n in range(out.shape[0] - 1, -1, -1):
            up = values[n] + way[n]
            if up <= least:
                least = up
            else:
                out[n] = min(out[n], least - way[n])


def graded(
    s: cython.const[cython.double][::1],
    spacing: cython.const[cython.double][::1],
    low: cython.const[cython.double][::1],
    growth: cython.double,
    fine: cython.double[::1],
    out: cython.double[::1],
) -> int:
    """Insert places where the lowered spacing `low` grows less than it may; return how many there are in `fine`, with `out` there.

    Args:
        s, spacing, low: Shape (n,), places, ascending, the spacing there and the lowered one.
        growth: Largest growth of the spacing by the way.
        fine, out: Room for 3 n.
    """
    count: cython.Py_ssize_t = 0
    with cython.nogil:
        for n in range(s.shape[0]):
            if n > 0 and not s[n] > s[n - 1]:
                continue
            fine[count] = s[n]
            out[count] = low[n]
            count += 1
            if n == s.shape[0] - 1:
                break
            top = max(spacing[n], spacing[n + 1])
            # Beside rounding: next to a rest spacings at quarters of a panel are as 1 to 2 to 3.
            if top <= (1.0 + _ALIKE) * _STEEP * min(low[n], low[n + 1]):
                continue
            # Where growth from both ends meets, if it does so below the top.
            met = 0.5 * (s[n] + s[n + 1] + (low[n + 1] - low[n]) / growth)
            up = min(s[n] + (top - low[n]) / growth, met)
            down = max(s[n + 1] - (top - low[n + 1]) / growth, met)
            height = min(top, low[n] + growth * (met - s[n]))
            if s[n] < up < s[n + 1]:
                fine[count] = up
                out[count] = height
                count += 1
            if s[n] < down < s[n + 1] and down != up:
                fine[count] = down
                out[count] = height
                count += 1
    return count


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def slope_log(slope: cython.double, x: cython.double) -> cython.double:
    """Return log(1 + slope x) / slope, x where the slope is 0."""
    return x if fabs(slope * x) < 1e-9 else log1p(slope * x) / slope


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def slope_exp(slope: cython.double, x: cython.double) -> cython.double:
    """Return (exp(slope x) - 1) / slope, x where the slope is 0: the inverse of `slope_log`."""
    return x if fabs(slope * x) < 1e-9 else expm1(slope * x) / slope


def measure(
    s: cython.const[cython.double][::1],
    spacing: cython.const[cython.double][::1],
    borders: cython.const[cython.double][::1],
    whole: cython.const[cython.char][::1],
    up_to: cython.double[::1],
    at: cython.double[::1],
    count: cython.double[::1],
) -> None:
    """Fill how many intervals each stretch between borders has in the measure ds / spacing, `whole` stretches one.

    From a place where the spacing is h and its slope g, the measure over a distance x is log(1 + g x/h) / g.

    Args:
        s, spacing: Shape (n,), places, ascending, and the spacing there, linear between.
        borders: Shape (m,), ascending.
        whole: Shape (m - 1,).
        up_to: Shape (n,), becomes the measure up to each place.
        at: Shape (m,), becomes that up to each border.
        count: Shape (m - 1,).
    """
    k: cython.Py_ssize_t = 0
    with cython.nogil:
        up_to[0] = 0.0
        for n in range(s.shape[0] - 1):
            slope = (spacing[n + 1] - spacing[n]) / (s[n + 1] - s[n])
            up_to[n + 1] = up_to[n] + slope_log(slope, (s[n + 1] - s[n]) / spacing[n])
        for n in range(borders.shape[0]):
            while k < s.shape[0] - 2 and s[k + 1] <= borders[n]:
                k += 1
            slope = (spacing[k + 1] - spacing[k]) / (s[k + 1] - s[k])
            at[n] = up_to[k] + slope_log(slope, (borders[n] - s[k]) / spacing[k])
            if n > 0:
                count[n - 1] = 1.0 if whole[n - 1] else max(ceil(at[n] - at[n - 1] - 1e-9), 1.0)


def spread(
    s: cython.const[cython.double][::1],
    spacing: cython.const[cython.double][::1],
    borders: cython.const[cython.double][::1],
    up_to: cython.const[cython.double][::1],
    at: cython.const[cython.double][::1],
    count: cython.const[cython.double][::1],
    out: cython.double[::1],
) -> int:
    """Fill `out` with the borders and the nodes between them, as `measure` has counted them; return how many differ."""
    k: cython.Py_ssize_t = 0
    filled: cython.Py_ssize_t = 0
    with cython.nogil:
        for n in range(count.shape[0] + 1):
            for step in range(cython.cast(cython.Py_ssize_t, count[n]) if n < count.shape[0] else 1):
                node = borders[n]
                if step > 0:
                    place = at[n] + (at[n + 1] - at[n]) * step / count[n]
                    while k < s.shape[0] - 2 and up_to[k + 1] <= place:
                        k += 1
                    slope = (spacing[k + 1] - spacing[k]) / (s[k + 1] - s[k])
                    node = s[k] + spacing[k] * slope_exp(slope, place - up_to[k])
                # Beside a rest they may be as near to each other as coordinates are round.
                if filled == 0 or node > out[filled - 1]:
                    out[filled] = node
                    filled += 1
    return filled


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _largest(x: cython.double[:, :, :, ::1], order: cython.Py_ssize_t, n: cython.Py_ssize_t) -> cython.double:
    """Return the largest size of a derivative at three places of an interval; NaN where one of them is NaN."""
    most: cython.double = 0.0
    for e in range(3):
        for d in range(x.shape[3]):
            if not fabs(x[order, n, e, d]) <= most:
                most = fabs(x[order, n, e, d])
                if most != most:
                    return most
    return most


def calm(
    x: cython.double[:, :, :, ::1],
    h: cython.const[cython.double][::1],
    spline: cython.const[cython.char][::1],
    sharp: cython.double,
    digits: cython.double,
) -> None:
    """Bound the derivatives on intervals that bend more than nodes are placed for, in place; see `cncgen.planner.least_time.mesh`.

    Args:
        x: Shape (4, n, 3, axes), position and derivatives at three places of each interval.
        h: Shape (n,), lengths.
        spline: Shape (n,), where bounded derivatives are made linear.
        sharp: Largest turn of the direction over an interval.
        digits: A change of the direction by this part of it is rounding.
    """
    change: cython.double
    with cython.nogil:
        for n in range(h.shape[0]):
            size = _largest(x, 1, n)
            bent = False
            for order in range(2, 4):
                bound = sharp * size / (h[n] if order == 2 else pow(h[n], 2.0))
                if _largest(x, order, n) > bound:
                    bent = True
                    for e in range(3):
                        for d in range(x.shape[3]):
                            x[order, n, e, d] = min(max(x[order, n, e, d], -bound), bound)
            # Where the direction does not change in any digit, x'' and x''' are rounding, as at a cusp that lies on a line.
            change = 0.0
            for d in range(x.shape[3]):
                change = max(
                    change,
                    max(x[1, n, 0, d], max(x[1, n, 1, d], x[1, n, 2, d]))
                    - min(x[1, n, 0, d], min(x[1, n, 1, d], x[1, n, 2, d])),
                )
            for order in range(2, 4):
                if change <= digits * size:
                    for e in range(3):
                        for d in range(x.shape[3]):
                            x[order, n, e, d] = 0.0
            if bent and spline[n]:
                for order in range(1, 4):
                    for d in range(x.shape[3]):
                        x[order, n, 1, d] = 0.5 * (x[order, n, 0, d] + x[order, n, 2, d])


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _differs(
    x: cython.const[cython.double][:, :, :, ::1],
    order: cython.Py_ssize_t,
    n: cython.Py_ssize_t,
    d: cython.Py_ssize_t,
    first: cython.double,
    second: cython.double,
) -> cython.double:
    """How far values at the quarter points are from the parabola through the three of axis d of interval n; 0 where that is infinite."""
    one = fabs(first - (0.375 * x[order, n, 0, d] + 0.75 * x[order, n, 1, d] - 0.125 * x[order, n, 2, d]))
    other = fabs(second - (-0.125 * x[order, n, 0, d] + 0.75 * x[order, n, 1, d] + 0.375 * x[order, n, 2, d]))
    return max(one, other) if one < _INFINITE and other < _INFINITE else 0.0


def concealed(
    s: cython.const[cython.double][::1],
    spline: cython.const[cython.schar][::1],
    x: cython.const[cython.double][:, :, :, ::1],
    seen: cython.const[cython.double][:, :, :, ::1],
    top: cython.const[cython.double][:, ::1],
    acceleration: cython.const[cython.double][::1],
    believed: cython.double,
    excess: cython.double,
    out: cython.double[:, ::1],
    lost: cython.double[::1],
) -> None:
    """Fill `out` with what x''' differs at the quarter points from the parabola through its three values, times `excess`,
    and `lost` with the part of the acceleration of an axis that what x'' differs by may take.

    At a cusp there is nothing to compare: 0. No more than the acceleration of an axis is used for its curvature, which
    bounds the speed besides `top`.

    Args:
        s: Shape (n + 1,), nodes.
        spline: Shape (n,), which intervals are looked at, if x''' is not 0 on them; 0 for the others.
        x: Shape (4, n, 3, axes), derivatives at the start, middle and end of each interval.
        seen: Shape (4, n, 4, axes), those of the path at its start and quarters.
        top: Shape (n, 3), the largest q at the start, middle and end.
        acceleration: Shape (axes,).
        believed: Largest x''' at the quarters that is believed, times the square of the length.
        excess: The factor.
        out: Shape (n, axes).
        lost: Shape (n,).
    """
    q: cython.double
    bent: cython.bint
    with cython.nogil:
        for n in range(out.shape[0]):
            lost[n] = 0.0
            most = believed / ((s[n + 1] - s[n]) * (s[n + 1] - s[n]))
            q = max(top[n, 0], top[n, 1], top[n, 2])
            bent = False
            for d in range(out.shape[1]):
                out[n, d] = 0.0
                bent = bent or x[3, n, 0, d] != 0.0 or x[3, n, 1, d] != 0.0 or x[3, n, 2, d] != 0.0
            if not (bent and spline[n]):
                continue
            for d in range(out.shape[1]):
                one = min(max(seen[3, n, 1, d], -most), most)
                other = min(max(seen[3, n, 3, d], -most), most)
                out[n, d] = excess * _differs(x, 3, n, d, one, other)
                used = max(fabs(x[2, n, 0, d]), fabs(x[2, n, 1, d]), fabs(x[2, n, 2, d]))
                if used > 0.0:
                    q = min(q, acceleration[d] / used)
            for d in range(out.shape[1]):
                bulge = _differs(x, 2, n, d, seen[2, n, 1, d], seen[2, n, 3, d])
                if bulge > 0.0:
                    lost[n] = max(lost[n], bulge * q / acceleration[d])

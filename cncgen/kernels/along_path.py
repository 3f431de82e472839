# cython: cpow=True, infer_types=True
"""The speeds that a path allows at given places: by limits of axes, by chords between setpoints, by how fast its direction turns.

Called by `cncgen.planner.limits` and `cncgen.planner.least_time.mesh_spacing`. Symbols: T period, d chord tolerance, k curvature
(bend), x1, x2, x3 the first three derivatives of the path by its coordinate, shape (n, axes).
"""

import cython
import numpy as np
from cython.cimports.libc.math import sqrt

#: The largest number, which stands for what is infinite where a finite one is wanted.
_LARGEST = cython.declare(cython.double, float(np.finfo(float).max))
_INFINITE = cython.declare(cython.double, float("inf"))


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _over(a: cython.double, b: cython.double) -> cython.double:
    """a / b for b >= 0 and a > 0; infinite where b is 0."""
    return a / b if b > 0.0 else _INFINITE


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _weakest(
    limit: cython.const[cython.double][::1], x1: cython.const[cython.double][:, ::1], n: cython.Py_ssize_t
) -> cython.double:
    """Return the limit along the path at place n: the least of limit[d] / |x1[n, d]| over the axes."""
    found: cython.double = _INFINITE
    for d in range(limit.shape[0]):
        found = min(found, _over(limit[d], abs(x1[n, d])))
    return found


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _chord_speed(bend: cython.double, tolerance: cython.double, period: cython.double) -> cython.double:
    """Return (2/T) sqrt(2 d/k - d^2), or (2/T) sqrt(d/k) where that is more (Yeh and Hsu (2002)); see `chord_speed`."""
    square: cython.double = _INFINITE
    if bend > 0.0:
        square = tolerance * max(2.0 / bend - tolerance, 1.0 / bend)
    return 2.0 / period * sqrt(square)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _across(
    x1: cython.const[cython.double][:, ::1],
    x2: cython.const[cython.double][:, ::1],
    scale: cython.const[cython.double][::1],
    n: cython.Py_ssize_t,
) -> cython.double:
    """Return the size of the part of x'' across x' at place n, columns multiplied by `scale`."""
    along: cython.double = 0.0
    size: cython.double = 0.0
    total: cython.double = 0.0
    for d in range(x1.shape[1]):
        along += x1[n, d] * scale[d] * (x2[n, d] * scale[d])
        size += x1[n, d] * scale[d] * (x1[n, d] * scale[d])
    if size > 0.0:
        along /= size
    for d in range(x1.shape[1]):
        beside = x2[n, d] * scale[d] - along * (x1[n, d] * scale[d])
        total += beside * beside
    return sqrt(total)


def weakest(
    limit: cython.const[cython.double][::1],
    x1: cython.const[cython.double][:, ::1],
    out: cython.double[::1],
):
    """Fill `out` with the least of ``limit[d] / |x1[n, d]|``, infinite where no axis moves."""
    with cython.nogil:
        for n in range(out.shape[0]):
            out[n] = _weakest(limit, x1, n)


def top(
    feed: cython.const[cython.double][::1],
    feed_kind: cython.const[cython.char][::1],
    velocity: cython.const[cython.double][::1],
    tolerance: cython.double,
    period: cython.double,
    centripetal: cython.double,
    scale: cython.const[cython.double][::1],
    kinds: cython.const[cython.char][::1],
    x1: cython.const[cython.double][:, ::1],
    x2: cython.const[cython.double][:, ::1],
    q: cython.double[::1],
    kind: cython.char[::1],
):
    """Fill `q` with the largest v^2 at places by feed, axis velocities, the chord of a period, and `centripetal` v^2 times
    the curvature; `kind` with what holds it: ``feed_kind[n]``, or of `kinds` the one for velocity, chord, or curvature.

    Chords are those of all axes, multiplied by `scale`; the curvature is that of X Y Z, the first three. Beside a bend whose
    radius is below the tolerance d, a way of 2 d in a period keeps to it whatever the bend is.
    """
    axes: cython.Py_ssize_t = x1.shape[1]
    other: cython.double
    curvature: cython.double
    bend: cython.double
    size: cython.double
    with cython.nogil:
        for n in range(q.shape[0]):
            curvature = 0.0
            for d in range(3):
                curvature += x2[n, d] * x2[n, d]
            curvature = sqrt(curvature)
            bend = curvature
            if axes > 3:
                bend = _across(x1, x2, scale, n)
            v = feed[n]
            kind[n] = feed_kind[n]
            other = _weakest(velocity, x1, n)
            if other < v:
                v = other
                kind[n] = kinds[0]
            other = _chord_speed(bend, tolerance, period)
            if other < v and bend * tolerance > 1.0:
                # Sharper than the tolerance: no point of a period's way is further than half of it from its nearer end.
                size = 0.0
                for d in range(axes):
                    size += x1[n, d] * scale[d] * (x1[n, d] * scale[d])
                other = max(other, _over(2.0 / period * tolerance, sqrt(size)))
            if other < v:
                v = other
                kind[n] = kinds[1]
            other = sqrt(_over(centripetal, curvature))
            if other < v:
                v = other
                kind[n] = kinds[2]
            q[n] = v * v


def turning(
    acceleration: cython.const[cython.double][::1],
    jerk: cython.const[cython.double][::1],
    x1: cython.const[cython.double][:, ::1],
    x2: cython.const[cython.double][:, ::1],
    x3: cython.const[cython.double][:, ::1],
    out: cython.double[:, ::1],
):
    """Fill ``out[0 .. 4]`` with acceleration and jerk along the path by the weakest axis, the curvature that the
    acceleration meets, that of the path, and its change, in the axes' own limits: max |x''| / A over max |x'| / A, likewise
    with J and by x''' (the larger one counts). Infinite values of the last three become the largest number.
    """
    steep: cython.double
    bend: cython.double
    twist: cython.double
    steep_j: cython.double
    bend_j: cython.double
    twist_j: cython.double
    with cython.nogil:
        for n in range(x1.shape[0]):
            steep = bend = twist = steep_j = bend_j = twist_j = 0.0
            for d in range(acceleration.shape[0]):
                steep = max(steep, abs(x1[n, d]) / acceleration[d])
                bend = max(bend, abs(x2[n, d]) / acceleration[d])
                twist = max(twist, abs(x3[n, d]) / acceleration[d])
                steep_j = max(steep_j, abs(x1[n, d]) / jerk[d])
                bend_j = max(bend_j, abs(x2[n, d]) / jerk[d])
                twist_j = max(twist_j, abs(x3[n, d]) / jerk[d])
            out[0, n] = _over(1.0, steep)
            out[1, n] = _over(1.0, steep_j)
            # Where nothing moves, nothing turns.
            out[2, n] = min(_over(bend, steep), _LARGEST) if bend > 0.0 else 0.0
            out[3, n] = max(out[2, n], min(_over(bend_j, steep_j), _LARGEST) if bend_j > 0.0 else 0.0)
            out[4, n] = min(_over(twist, steep), _LARGEST) if twist > 0.0 else 0.0
            out[4, n] = max(out[4, n], min(_over(twist_j, steep_j), _LARGEST) if twist_j > 0.0 else 0.0)


def chord_speed(
    bend: cython.const[cython.double][::1],
    tolerance: cython.const[cython.double][::1],
    period: cython.double,
    out: cython.double[::1],
):
    """Fill `out` with the speed whose chord over a period stays within ``tolerance[n]`` of a path that bends by ``bend[n]``:
    (2/T) sqrt(2 d/k - d^2) (S.-S. Yeh and P.-L. Hsu (2002); Tsai (2010), eq. 24, with T for Ts, d for delta, k for kappa),
    or (2/T) sqrt(d/k) where that is more: where the tolerance d is above the radius 1/k.
    """
    with cython.nogil:
        for n in range(out.shape[0]):
            out[n] = _chord_speed(bend[n], tolerance[n], period)


def chords_of_rows(
    x1: cython.const[cython.double][:, ::1],
    x2: cython.const[cython.double][:, ::1],
    scale: cython.const[cython.double][::1],
    tolerance: cython.const[cython.double][::1],
    before: cython.const[cython.longlong][::1],
    after: cython.const[cython.longlong][::1],
    period: cython.double,
    out: cython.double[::1],
):
    """Fill `out` with the speed whose chord stays within the ``tolerance[row]`` of the rows before and after each place.

    As `chord_speed` says, by the part of x'' across x' with columns multiplied by `scale`; infinite where the tolerance is.
    """
    with cython.nogil:
        for n in range(out.shape[0]):
            d = min(tolerance[before[n]], tolerance[after[n]])
            out[n] = _INFINITE
            if d < _INFINITE:
                out[n] = _chord_speed(_across(x1, x2, scale, n), d, period)

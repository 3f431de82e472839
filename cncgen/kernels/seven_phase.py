# cython: infer_types=True
"""Speed profiles of segments with given end speeds, and the look-ahead over their joints.

A segment of length L runs from speed v1 to v2 under a top speed F, an acceleration A and a jerk J along the path:

    v │      ┌─────── vp ≤ F ───┐
      │    ／                     ＼ v2      accelerate, cruise, decelerate; acceleration is 0 at both ends
      │ v1
      └──────────────────────────────── t

Ramp distances d(v, v + Δ), Δ ≥ 0 (Tsai 2010, section 5.3; bell: Biagiotti and Melchiorri 2008, section 3.4; the profiles of
Chen and Hsu, section 2):

    0 bell          (2v + Δ) √(Δ/J)                     where Δ ≤ A²/J, else (2v + Δ)/2 · (Δ/A + A/J)
    1 linear        (2v + Δ)/2 · Δ/A
    2 exponential   T (v + gΔ) upwards, T (v + (1 − g)Δ) downwards;
                    T = 4KΔ/A, K = 1/(1 − e⁻⁴), g = K − 1/4, speed v + KΔ(1 − exp(−4t/T))

Every one has a closed inverse (the speed that a length allows), which is what the look-ahead needs.
"""

import cython
from cython.cimports.libc.math import asinh, cbrt, cosh, exp, sinh, sqrt


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _gain() -> cython.double:
    """Return K = 1/(1 − e⁻⁴) of the exponential ramp."""
    return 1.0 / (1.0 - exp(-4.0))


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _ramp(
    kind: cython.int,
    low: cython.double,
    delta: cython.double,
    acc: cython.double,
    jerk: cython.double,
    up: cython.int,
) -> cython.double:
    """Distance of a ramp between the speeds `low` and `low` + `delta`."""
    if kind == 0:
        if delta * jerk <= acc * acc:
            return (2.0 * low + delta) * sqrt(delta / jerk)
        return 0.5 * (2.0 * low + delta) * (delta / acc + acc / jerk)
    if kind == 1:
        return 0.5 * (2.0 * low + delta) * delta / acc
    g = _gain() - 0.25
    if not up:
        g = 1.0 - g
    return 4.0 * _gain() * delta / acc * (low + g * delta)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _reach(
    kind: cython.int,
    low: cython.double,
    length: cython.double,
    acc: cython.double,
    jerk: cython.double,
    up: cython.int,
) -> cython.double:
    """Highest speed that a ramp of that length reaches from `low` (up), or can come down from to `low`."""
    if length <= 0.0:
        return low
    if kind == 0:
        x = acc * acc / jerk
        if length <= (2.0 * low + x) * acc / jerk:
            # x³ + p x = q with x = √Δ, p = 2 low, q = L √J: one real root.
            p = 2.0 * low
            q = length * sqrt(jerk)
            if p < 1e-9 * cbrt(q * q):
                x = cbrt(q) - p / (3.0 * cbrt(q))
            else:
                x = 2.0 * sqrt(p / 3.0) * sinh(asinh(1.5 * q / p * sqrt(3.0 / p)) / 3.0)
            return low + x * x
        # Δ²/(2A) + Δ (low/A + A/(2J)) = L − low A/J
        b = low + 0.5 * x
        q = 2.0 * acc * (length - low * acc / jerk)
        return low + q / (b + sqrt(b * b + q))
    if kind == 1:
        return sqrt(low * low + 2.0 * acc * length)
    g = _gain() - 0.25
    if not up:
        g = 1.0 - g
    # g Δ² + low Δ = L A / (4K)
    q = length * acc / (4.0 * _gain())
    return low + 2.0 * q / (low + sqrt(low * low + 4.0 * g * q))


def look_ahead(
    kind: cython.int,
    length: cython.double[::1],
    acc: cython.double[::1],
    jerk: cython.double[::1],
    cap: cython.double[::1],
    v: cython.double[::1],
) -> cython.void:
    """Lower joint speeds until every segment is long enough to go from one to the next.

    `length`, `acc`, `jerk` have n entries, `cap` and `v` n + 1. ``v[0]`` is the speed at the start, as given (it must
    not exceed what the path allows, or ``v[0]`` comes back lower); the other speeds come back as the largest with
    v ≤ cap and d(v[i], v[i+1]) ≤ length[i] both ways: a backward and then a forward pass.
    """
    n: cython.Py_ssize_t = length.shape[0]
    start: cython.double = v[0]
    with cython.nogil:
        v[n] = cap[n]
        for i in range(n - 1, -1, -1):
            reached = _reach(kind, v[i + 1], length[i], acc[i], jerk[i], 0)
            v[i] = reached if reached < cap[i] else cap[i]
        if start < v[0]:
            v[0] = start
        for i in range(n):
            reached = _reach(kind, v[i], length[i], acc[i], jerk[i], 1)
            if reached < v[i + 1]:
                v[i + 1] = reached


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _peak(
    kind: cython.int,
    length: cython.double,
    v1: cython.double,
    v2: cython.double,
    top: cython.double,
    acc: cython.double,
    jerk: cython.double,
) -> cython.double:
    """Highest speed of a segment: `top` in a long one, else that at which both ramps just fill the length.

    Ramps that are alike take half of it each; others are found by bisection.
    """
    low: cython.double = v1 if v1 > v2 else v2
    high: cython.double = top
    if high <= low:
        return low
    if v1 == v2 and kind != 2:
        return min(high, _reach(kind, v1, 0.5 * length, acc, jerk, 1))
    if _ramp(kind, v1, high - v1, acc, jerk, 1) + _ramp(kind, v2, high - v2, acc, jerk, 0) <= length:
        return high
    for _round in range(60):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        if _ramp(kind, v1, middle - v1, acc, jerk, 1) + _ramp(kind, v2, middle - v2, acc, jerk, 0) <= length:
            low = middle
        else:
            high = middle
    return low


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _put(
    out: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    tau: cython.double,
    v: cython.double,
    a: cython.double,
    j: cython.double,
    c: cython.double,
    phase: cython.double,
) -> cython.Py_ssize_t:
    """Append a piece (duration, v, a, j, c, phase, length) unless it takes no time; return how many there are."""
    if tau <= 0.0:
        return k
    if c > 0.0:
        r = sqrt(c)
        out[k, 6] = v * tau + a * (cosh(r * tau) - 1.0) / c + (j + c * v) * (sinh(r * tau) / r - tau) / c
    else:
        out[k, 6] = tau * (v + tau * (0.5 * a + tau * j / 6.0))
    out[k, 0] = tau
    out[k, 1] = v
    out[k, 2] = a
    out[k, 3] = j
    out[k, 4] = c
    out[k, 5] = phase
    return k + 1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _put_ramp(
    out: cython.double[:, ::1],
    k: cython.Py_ssize_t,
    kind: cython.int,
    v1: cython.double,
    v2: cython.double,
    acc: cython.double,
    jerk: cython.double,
) -> cython.Py_ssize_t:
    """Append the pieces of the ramp from v1 to v2."""
    delta: cython.double = v2 - v1
    size: cython.double = delta if delta > 0.0 else -delta
    sign: cython.double = 1.0 if delta > 0.0 else -1.0
    t2: cython.double = 0.0
    top: cython.double = acc
    if size == 0.0:
        return k
    if kind == 1:
        return _put(out, k, size / acc, v1, sign * acc, 0.0, 0.0, 1.0)
    if kind == 2:
        # v = v1 + Δ K (1 − e^(−λt)):  v'' = λ² v − λ² (v1 + Δ K)
        rate = acc / (_gain() * size)
        return _put(
            out, k, 4.0 / rate, v1, sign * acc, -rate * rate * (v1 + delta * _gain()), rate * rate, 1.0
        )
    if size * jerk <= acc * acc:
        t1 = sqrt(size / jerk)
        top = jerk * t1
    else:
        t1 = acc / jerk
        t2 = size / acc - t1
    k = _put(out, k, t1, v1, 0.0, sign * jerk, 0.0, 2.0)
    k = _put(out, k, t2, v1 + sign * 0.5 * top * t1, sign * top, 0.0, 0.0, 1.0)
    return _put(out, k, t1, v2 - sign * 0.5 * top * t1, sign * top, -sign * jerk, 0.0, 2.0)


def build(
    kind: cython.int,
    length: cython.double[::1],
    acc: cython.double[::1],
    jerk: cython.double[::1],
    top: cython.double[::1],
    v: cython.double[::1],
    out: cython.double[:, ::1],
    offset: cython.longlong[::1],
) -> cython.Py_ssize_t:
    """Lay out the pieces of every segment between joint speeds that `look_ahead` made feasible.

    `out` has room for 7 n rows of duration, speed, acceleration, jerk, c, phase (0 cruise, 1 constant acceleration
    or exponential ramp, 2 jerk) and length; ``offset[i]`` becomes the first piece of segment i, ``offset[n]`` the
    number of all. The rest that the ramps leave of a length by rounding is travelled at the peak speed. Returns that number.
    """
    n: cython.Py_ssize_t = length.shape[0]
    k: cython.Py_ssize_t = 0
    with cython.nogil:
        for i in range(n):
            offset[i] = k
            if length[i] <= 0.0:
                continue
            peak = _peak(kind, length[i], v[i], v[i + 1], top[i], acc[i], jerk[i])
            left = (
                length[i]
                - _ramp(kind, v[i], peak - v[i], acc[i], jerk[i], 1)
                - _ramp(kind, v[i + 1], peak - v[i + 1], acc[i], jerk[i], 0)
            )
            if left < -1e-9 * length[i]:
                # The joints differ by the last digits alone, which make a ramp longer than this tiny segment.
                mean = 0.5 * (v[i] + v[i + 1])
                k = _put(out, k, length[i] / mean, mean, 0.0, 0.0, 0.0, 0.0)
                continue
            k = _put_ramp(out, k, kind, v[i], peak, acc[i], jerk[i])
            if peak > 0.0:
                k = _put(out, k, left / peak, peak, 0.0, 0.0, 0.0, 0.0)
            k = _put_ramp(out, k, kind, peak, v[i + 1], acc[i], jerk[i])
        offset[n] = k
    return k

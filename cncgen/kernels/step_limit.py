# cython: infer_types=True
"""Steps along a path limited so that PD+ drives stay out of saturation (Yeh and Sun 2008, section 3), tick by tick.

The path stands as a table over the planned time, `parts` entries a period: place s, positions x and directions dx/ds.
Between two entries s is linear in time and x is the cubic Hermite polynomial in s.

Numbers of an axis (columns of `axis`): 0 S, 1 kp, 2 kd, 3 ka, 4 U, 5 counts a unit of travel, 6 counts a radian,
7 and 8: a and b of w⁺ = a w + b u, 9 and 10: c and d of θ⁺ = θ + c w + d u.
State of an axis (columns of `state`): 0 θ measured now, 1 θ measured a period ago, 2 speed w of the motor,
3 θ commanded last, 4 speed commanded last.
"""

import cython
from cython.cimports.libc.math import fabs


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _place(s: cython.double[::1], g: cython.double) -> cython.double:
    """Place at the real-valued index g of the table; its end beyond it."""
    last: cython.Py_ssize_t = s.shape[0] - 1
    if g >= last:
        return s[last]
    i = cython.cast(cython.Py_ssize_t, g)
    return s[i] + (g - i) * (s[i + 1] - s[i])


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _index(s: cython.double[::1], g: cython.double, place: cython.double) -> cython.double:
    """Real-valued index, g or later, at which the table reaches a place."""
    last: cython.Py_ssize_t = s.shape[0] - 1
    i: cython.Py_ssize_t = cython.cast(cython.Py_ssize_t, g)
    while i < last and s[i + 1] < place:
        i += 1
    if i >= last:
        return last
    if s[i + 1] <= s[i]:
        return g if g > i else i
    found = i + (place - s[i]) / (s[i + 1] - s[i])
    return found if found > g else g


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _position(
    s: cython.double[::1],
    x: cython.double[:, ::1],
    direction: cython.double[:, ::1],
    g: cython.double,
    place: cython.double,
    axis: cython.Py_ssize_t,
) -> cython.double:
    """Position of an axis at a place, g being its index or one before it."""
    last: cython.Py_ssize_t = s.shape[0] - 1
    i: cython.Py_ssize_t = cython.cast(cython.Py_ssize_t, g)
    while i < last - 1 and s[i + 1] < place:
        i += 1
    if i >= last:
        return x[last, axis]
    h = s[i + 1] - s[i]
    if h <= 0.0:
        return x[i + 1, axis]
    r = (place - s[i]) / h
    return (
        x[i, axis] * (1.0 + 2.0 * r) * (1.0 - r) * (1.0 - r)
        + x[i + 1, axis] * r * r * (3.0 - 2.0 * r)
        + h * r * (1.0 - r) * ((1.0 - r) * direction[i, axis] - r * direction[i + 1, axis])
    )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _within(
    s: cython.double[::1],
    x: cython.double[:, ::1],
    direction: cython.double[:, ::1],
    g: cython.double,
    place: cython.double,
    period: cython.double,
    axis: cython.double[:, ::1],
    state: cython.double[:, ::1],
    bound: cython.double[:, ::1],
) -> cython.bint:
    """Tell whether the step to a place keeps every axis's commanded speed within its bounds (eq. 3.6)."""
    for i in range(axis.shape[0]):
        speed = (_position(s, x, direction, g, place, i) * axis[i, 5] - state[i, 3]) / (period * axis[i, 6])
        if speed < bound[i, 0] - 1e-9 or speed > bound[i, 1] + 1e-9:
            return False
    return True


#: Speeds V that every axis can follow, or none: then the nearest of those that are asked.
_Range = cython.struct(low=cython.double, high=cython.double, empty=cython.bint)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _range(
    direction: cython.double[:, ::1],
    g: cython.double,
    nominal: cython.double,
    period: cython.double,
    axis: cython.double[:, ::1],
    state: cython.double[:, ::1],
    bound: cython.double[:, ::1],
) -> _Range:
    """Intersect [0, nominal] with what each axis's bounds leave (eqs 3.6 and 3.10); fills `bound`."""
    low: cython.double = 0.0
    high: cython.double = nominal
    empty: cython.bint = False
    last: cython.double = direction.shape[0] - 1
    here: cython.Py_ssize_t = cython.cast(cython.Py_ssize_t, min(g, last))
    for i in range(axis.shape[0]):
        v = (
            axis[i, 1] * (state[i, 3] - state[i, 0])
            - axis[i, 2] * (state[i, 0] - state[i, 1]) / (period * axis[i, 6])
            - axis[i, 3] * state[i, 4]
        )
        bound[i, 0] = (-axis[i, 4] - v) / axis[i, 0]
        bound[i, 1] = (axis[i, 4] - v) / axis[i, 0]
        rate = direction[here, i] * axis[i, 5] / axis[i, 6]
        if fabs(rate) < 1e-12:
            empty = empty or bound[i, 0] > 0.0 or bound[i, 1] < 0.0
            continue
        one = bound[i, 0] / rate
        other = bound[i, 1] / rate
        low = max(low, min(one, other))
        high = min(high, max(one, other))
    if low > high:
        # Nothing is feasible: the nearest speed of [0, nominal].
        empty = True
        high = max(nominal if low > nominal else high, 0.0)
    return _Range(low=low, high=high, empty=empty)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _shortened(
    s: cython.double[::1],
    x: cython.double[:, ::1],
    direction: cython.double[:, ::1],
    g: cython.double,
    here: cython.double,
    one: cython.double,
    other: cython.double,
    period: cython.double,
    axis: cython.double[:, ::1],
    state: cython.double[:, ::1],
    bound: cython.double[:, ::1],
) -> cython.double:
    """Return the highest speed of [one, other] whose chord keeps the bounds, by bisection; negative where none does."""
    for _round in range(50):
        v = 0.5 * (one + other)
        if _within(s, x, direction, g, here + v * period, period, axis, state, bound):
            one = v
        else:
            other = v
    return one if _within(s, x, direction, g, here + one * period, period, axis, state, bound) else -1.0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _drive(
    i: cython.Py_ssize_t,
    theta: cython.double,
    period: cython.double,
    axis: cython.double[:, ::1],
    state: cython.double[:, ::1],
    out: cython.double[::1],
) -> cython.void:
    """Move axis `i` on by a period with the command `theta`, counts; ``out[2]`` and ``out[3]`` become w_d and u."""
    speed: cython.double = (theta - state[i, 3]) / (period * axis[i, 6])
    force: cython.double = (
        axis[i, 0] * speed
        + axis[i, 1] * (state[i, 3] - state[i, 0])
        - axis[i, 2] * (state[i, 0] - state[i, 1]) / (period * axis[i, 6])
        - axis[i, 3] * state[i, 4]
    )
    out[2] = speed
    out[3] = force
    force = min(max(force, -axis[i, 4]), axis[i, 4])
    state[i, 1] = state[i, 0]
    state[i, 0] += axis[i, 9] * state[i, 2] + axis[i, 10] * force
    state[i, 2] = axis[i, 7] * state[i, 2] + axis[i, 8] * force
    state[i, 3] = theta
    state[i, 4] = speed


def limit_steps(
    s: cython.double[::1],
    x: cython.double[:, ::1],
    direction: cython.double[:, ::1],
    parts: cython.double,
    start: cython.double,
    end: cython.double,
    period: cython.double,
    axis: cython.double[:, ::1],
    state: cython.double[:, ::1],
    bound: cython.double[:, ::1],
    steps: cython.double[:, ::1],
    forces: cython.double[:, :, ::1],
) -> cython.Py_ssize_t:
    """Step from index `start` of the table until `end` is reached or `steps` is full; return the number of steps.

    Row k of `steps` becomes the index and the place reached by step k, and 1 where no step was feasible (else 0);
    ``forces[k, i]`` the lower and upper bound of axis i's commanded speed, the speed, and the force u before the
    drive's bound. `state` moves on; `bound` (axes, 2) is room to work in.

    A step takes the highest V of [0, nominal] for which every axis's D_j V lies within its bounds: the intersection
    of the intervals sorted(min_j/D_j, max_j/D_j), which is eq. 3.10 put right (docs/saturation.md). As the command is
    a chord and not a tangent, the step is then shortened by bisection until the chord keeps the bounds too.
    """
    n: cython.Py_ssize_t = steps.shape[0]
    k: cython.Py_ssize_t = 0
    g: cython.double = start
    can: _Range
    with cython.nogil:
        while k < n and g < end:
            here = _place(s, g)
            aim = _place(s, g + parts)
            nominal = (aim - here) / period
            can = _range(direction, g, nominal, period, axis, state, bound)
            place = aim if can.high >= nominal else here + can.high * period
            if not can.empty and not _within(s, x, direction, g, place, period, axis, state, bound):
                speed = _shortened(s, x, direction, g, here, can.low, can.high, period, axis, state, bound)
                can.empty = speed < 0.0
                if speed >= 0.0:
                    place = here + speed * period
            for i in range(axis.shape[0]):
                forces[k, i, 0] = bound[i, 0]
                forces[k, i, 1] = bound[i, 1]
                _drive(
                    i,
                    _position(s, x, direction, g, place, i) * axis[i, 5],
                    period,
                    axis,
                    state,
                    forces[k, i],
                )
            g = g + parts if place >= aim else _index(s, g, place)
            steps[k, 0] = g
            steps[k, 1] = place
            steps[k, 2] = 1.0 if can.empty else 0.0
            k += 1
    return k

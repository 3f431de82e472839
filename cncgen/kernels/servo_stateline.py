# cython: infer_types=True
"""Axes under a stateline: every control period each axis checks its error criterion, and all advance or all hold.

Source: Jung and Choi, eqs 6 and 7 and Rule 2; `cncgen.servo.controllers.stateline` states the choices beyond it.
"""

import cython


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _agrees(
    rule: cython.Py_ssize_t,
    error: cython.double,
    current: cython.double,
    following: cython.double,
    after: cython.double,
    before: cython.double,
    gains: cython.double[::1],
) -> cython.bint:
    """Tell whether an axis lets the line go high; see `run` for the arguments."""
    if rule == 0:
        return True
    if -gains[3] <= error <= gains[3]:
        return True
    if rule == 1:
        bound = gains[0] * following
        change = 0.0
    else:
        bound = gains[0] * following
        change = (gains[0] + gains[1] / gains[4]) * (following - current)
        if rule == 3:
            change += gains[2] / gains[4] * ((after - following) - (current - before))
    if bound < 0.0:
        bound = -bound
    return -bound - gains[3] <= error + change <= bound + gains[3]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _line_goes_high(
    rule: cython.Py_ssize_t,
    reference: cython.double[:, ::1],
    at: cython.Py_ssize_t,
    moving: cython.double,
    previous: cython.double,
    period: cython.double,
    state: cython.double[:, ::1],
    gains: cython.double[:, ::1],
) -> cython.bint:
    """Tell whether every axis lets the reference go on from row `at`, the line's AND; see `run` for the arguments.

    I V of Rule 2 is the commanded speed of a period, 0 where the line was low (`moving`, and `previous` before that).
    """
    n: cython.Py_ssize_t = reference.shape[0]
    for i in range(reference.shape[1]):
        if not _agrees(
            rule,
            reference[at, i] - state[i, 0],
            moving * (reference[at, i] - reference[at - 1, i]) / period if at > 0 else 0.0,
            (reference[at + 1, i] - reference[at, i]) / period,
            (reference[at + 2, i] - reference[at + 1, i]) / period if at < n - 2 else 0.0,
            previous * (reference[at - 1, i] - reference[at - 2, i]) / period if at > 1 else 0.0,
            gains[i],
        ):
            return False
    return True


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _has_settled(
    end: cython.double[::1], state: cython.double[:, ::1], gains: cython.double[:, ::1]
) -> cython.bint:
    """Tell whether every axis is within its δ of the reference's end, and within 1e-6 where δ is 0."""
    for i in range(end.shape[0]):
        error = end[i] - state[i, 0]
        if not (-gains[i, 3] - 1e-6 <= error <= gains[i, 3] + 1e-6):
            return False
    return True


def run(
    reference: cython.double[:, ::1],
    flow: cython.double[:, :, ::1],
    drive: cython.double[:, ::1],
    stiffness: cython.double[::1],
    gains: cython.double[:, ::1],
    rule: cython.Py_ssize_t,
    period: cython.double,
    patience: cython.Py_ssize_t,
    state: cython.double[:, ::1],
    position: cython.double[:, ::1],
    place: cython.longlong[::1],
    counts: cython.longlong[::1],
) -> cython.Py_ssize_t:
    """Run P-controlled axes along a reference under a stateline; return how many control periods it took.

    Args:
        reference: Shape (n, axes): positions for each control period if nothing ever holds.
        flow: Shape (axes, 2, 2), drive: (axes, 2): exact step of (position, velocity) under a held velocity command.
        stiffness: Shape (axes,): Kv of the position loop, 1/s.
        gains: Shape (axes, 5): Kve (s), Kac (s²), Kje (s³ or 0), the static bound δ, and Nf Ts (s).
        rule: 0 no stateline, 1 eq. 7, 2 Rule 2, 3 Rule 2 with jerk.
        period: Control period, s.
        patience: Control periods that the line may stay low before one step is forced.
        state: Shape (axes, 2): position and velocity.
        position: Shape (m, axes): receives positions.
        place: Shape (m,): receives the index of the reference in force.
        counts: Shape (2,): receives periods held, and forced steps.

    The run ends when the reference is at its end and every axis is within δ (or within 1e-6 where δ is 0), or when
    `position` is full; in the latter case −1 is returned.
    """
    n: cython.Py_ssize_t = reference.shape[0]
    axes: cython.Py_ssize_t = reference.shape[1]
    room: cython.Py_ssize_t = position.shape[0]
    at: cython.Py_ssize_t = 0
    waited: cython.Py_ssize_t = 0
    moving: cython.double = 0.0
    previous: cython.double = 0.0
    taken: cython.Py_ssize_t = -1
    high: cython.bint
    with cython.nogil:
        for k in range(room):
            if at == n - 1 and _has_settled(reference[at], state, gains):
                taken = k
                break
            high = at == n - 1 or _line_goes_high(rule, reference, at, moving, previous, period, state, gains)
            if not high:
                waited += 1
                counts[0] += 1
                if waited > patience:
                    high = True
                    counts[1] += 1
            previous = moving
            moving = 1.0 if high and at < n - 1 else 0.0
            if high and at < n - 1:
                at += 1
                waited = 0
            place[k] = at
            for i in range(axes):
                command = stiffness[i] * (reference[at, i] - state[i, 0])
                x = state[i, 0]
                state[i, 0] = flow[i, 0, 0] * x + flow[i, 0, 1] * state[i, 1] + drive[i, 0] * command
                state[i, 1] = flow[i, 1, 0] * x + flow[i, 1, 1] * state[i, 1] + drive[i, 1] * command
                position[k, i] = state[i, 0]
    return taken

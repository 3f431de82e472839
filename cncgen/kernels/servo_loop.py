"""Closed loops of servo axes, step by step.

An axis is a vector of states z that *flows* over a control period by exact transition matrices and *jumps* at each
control instant, when a sampled controller reads its encoder. What breaks linearity stands between the two: encoder
steps and noise, the bound of the drive, Coulomb friction, backlash. `cncgen.servo.loop` makes the tables.

Tables, for `axes` axes of at most `order` states (rows beyond an axis's own order are zero):

    phi (axes, 4, levels, order, order), inputs (axes, 4, levels, 5, order)
        flow over 1/2**level of a control period in mode 0 free, 1 held, 2 free and sticking, 3 held and sticking;
        inputs are: setpoint at the start, setpoint at the end, what is held at the drive, friction, encoder error
    output, encoder (axes, order)   position y = output . z; what the encoder sees = encoder . z
    jump (axes, order, order), jump_inputs (axes, 3, order)
        inputs are: setpoint, encoder error, what the bound took off the drive's input
    law (axes, order), law_inputs (axes, 2)
        drive input u = law . z + law_inputs . (setpoint, encoder error)
    stick_law (axes, 2, order), stick_inputs (axes, 2, 2)
        force on the standing axis, free and held; inputs are: setpoint, what is held
    numbers (axes, 6)               bound, Coulomb force, dead band, backlash, encoder step, noise
    switches (axes, 5)              order, index of the velocity state (-1: none), control periods a setpoint,
                                    1 for a sampled controller, 1 where the encoder is beyond the backlash
    state (axes, order), memory (axes, 3)   z; and: position beyond the backlash, 1 while sticking, friction's sign

Setpoints stand as (axes, n + 1), the last one being the first of what follows. Results (axes, n) hold at the setpoint's
own instant: position, drive input (bounded), and 1 where the bound was met in the period that begins there.
"""

import cython


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _transit(
    phi: cython.double[:, :, :, :, ::1],
    inputs: cython.double[:, :, :, :, ::1],
    axis: cython.Py_ssize_t,
    mode: cython.Py_ssize_t,
    level: cython.Py_ssize_t,
    order: cython.Py_ssize_t,
    z: cython.double[:, ::1],
    u: cython.double[::1],
    result: cython.double[::1],
) -> cython.void:
    """Write phi z + inputs u of one mode and level to `result`."""
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    total: cython.double
    for i in range(order):
        total = 0.0
        for j in range(order):
            total += phi[axis, mode, level, i, j] * z[axis, j]
        for j in range(5):
            total += inputs[axis, mode, level, j, i] * u[j]
        result[i] = total


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _standing_force(
    stick_law: cython.double[:, :, ::1],
    stick_inputs: cython.double[:, :, ::1],
    axis: cython.Py_ssize_t,
    held: cython.Py_ssize_t,
    order: cython.Py_ssize_t,
    z: cython.double[::1],
    setpoint: cython.double,
    drive: cython.double,
) -> cython.double:
    """Return the force that friction has to balance where the axis stands."""
    total: cython.double = stick_inputs[axis, held, 0] * setpoint + stick_inputs[axis, held, 1] * drive
    i: cython.Py_ssize_t
    for i in range(order):
        total += stick_law[axis, held, i] * z[i]
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _flow_with_friction(
    phi: cython.double[:, :, :, :, ::1],
    inputs: cython.double[:, :, :, :, ::1],
    stick_law: cython.double[:, :, ::1],
    stick_inputs: cython.double[:, :, ::1],
    axis: cython.Py_ssize_t,
    held: cython.Py_ssize_t,
    order: cython.Py_ssize_t,
    velocity: cython.Py_ssize_t,
    coulomb: cython.double,
    z: cython.double[:, ::1],
    memory: cython.double[:, ::1],
    u: cython.double[::1],
    result: cython.double[::1],
) -> cython.void:
    """Flow over a period in which the axis may stop, stick, break away and turn; `memory` keeps which it does.

    The longest part 1/2**level whose end still agrees with the regime is taken; where even the shortest one does
    not agree, the regime changes there.
    """
    first: cython.double = u[0]
    last: cython.double = u[1]
    deepest: cython.Py_ssize_t = phi.shape[2] - 1
    whole: cython.longlong = 1 << deepest
    done: cython.longlong = 0
    level: cython.Py_ssize_t = 0
    i: cython.Py_ssize_t
    force: cython.double
    agrees: cython.bint
    changes: cython.Py_ssize_t = 0
    trembling: cython.Py_ssize_t = 64
    while done < whole:
        while (whole >> level) > whole - done or (done & ((whole >> level) - 1)) != 0:
            level += 1
        u[0] = first + (last - first) * done / whole
        u[1] = first + (last - first) * (done + (whole >> level)) / whole
        if z[axis, velocity] == 0.0:
            for i in range(order):
                result[i] = z[axis, i]
            force = _standing_force(stick_law, stick_inputs, axis, held, order, result, u[0], u[2])
            memory[axis, 1] = 1.0 if -coulomb <= force <= coulomb or changes >= trembling else 0.0
            memory[axis, 2] = 1.0 if force > 0.0 else -1.0
        elif memory[axis, 1] == 0.0:
            memory[axis, 2] = 1.0 if z[axis, velocity] > 0.0 else -1.0
        if memory[axis, 1] == 1.0:
            u[3] = 0.0
            _transit(phi, inputs, axis, held + 2, level, order, z, u, result)
            force = _standing_force(stick_law, stick_inputs, axis, held, order, result, u[1], u[2])
            agrees = -coulomb <= force <= coulomb or changes >= trembling
        else:
            u[3] = -coulomb * memory[axis, 2]
            _transit(phi, inputs, axis, held, level, order, z, u, result)
            agrees = result[velocity] * memory[axis, 2] > 0.0
        if not agrees and level < deepest:
            level += 1
            continue
        for i in range(order):
            z[axis, i] = result[i]
        if not agrees:
            changes += 1
            if memory[axis, 1] == 0.0:
                z[axis, velocity] = 0.0
            memory[axis, 1] = 0.0
        done += whole >> level
        while (
            level > 0
            and (done & ((whole >> (level - 1)) - 1)) == 0
            and (whole >> (level - 1)) <= whole - done
        ):
            level -= 1


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _rounded(value: cython.double, step: cython.double) -> cython.double:
    """Return the nearest multiple of an encoder's step."""
    count: cython.double = value / step
    whole: cython.longlong = cython.cast(cython.longlong, count + 0.5 if count >= 0 else count - 0.5)
    return whole * step


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _dot(
    table: cython.double[:, ::1], z: cython.double[:, ::1], axis: cython.Py_ssize_t, order: cython.Py_ssize_t
) -> cython.double:
    total: cython.double = 0.0
    i: cython.Py_ssize_t
    for i in range(order):
        total += table[axis, i] * z[axis, i]
    return total


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _read(
    axis: cython.Py_ssize_t,
    output: cython.double[:, ::1],
    encoder: cython.double[:, ::1],
    numbers: cython.double[:, ::1],
    switches: cython.longlong[:, ::1],
    state: cython.double[:, ::1],
    memory: cython.double[:, ::1],
    noise: cython.double,
    found: cython.double[::1],
) -> cython.void:
    """Write the position (beyond the backlash) and what the encoder says of it to `found`; the same when repeated."""
    order: cython.Py_ssize_t = switches[axis, 0]
    play: cython.double = numbers[axis, 3]
    found[0] = _dot(output, state, axis, order)
    if play > 0.0:
        if found[0] - memory[axis, 0] > 0.5 * play:
            memory[axis, 0] = found[0] - 0.5 * play
        elif memory[axis, 0] - found[0] > 0.5 * play:
            memory[axis, 0] = found[0] + 0.5 * play
        found[0] = memory[axis, 0]
    found[1] = found[0] if switches[axis, 4] == 1 else _dot(encoder, state, axis, order)
    found[1] += noise * numbers[axis, 5]
    if numbers[axis, 4] > 0.0:
        found[1] = _rounded(found[1], numbers[axis, 4])


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _step(
    axis: cython.Py_ssize_t,
    phi: cython.double[:, :, :, :, ::1],
    inputs: cython.double[:, :, :, :, ::1],
    output: cython.double[:, ::1],
    encoder: cython.double[:, ::1],
    jump: cython.double[:, :, ::1],
    jump_inputs: cython.double[:, :, ::1],
    law: cython.double[:, ::1],
    law_inputs: cython.double[:, ::1],
    stick_law: cython.double[:, :, ::1],
    stick_inputs: cython.double[:, :, ::1],
    numbers: cython.double[:, ::1],
    switches: cython.longlong[:, ::1],
    state: cython.double[:, ::1],
    memory: cython.double[:, ::1],
    setpoint: cython.double,
    following: cython.double,
    beside: cython.double,
    noise: cython.double,
    work: cython.double[:, ::1],
    found: cython.double[::1],
) -> cython.void:
    """Carry one axis over one control period; `found` receives position, drive input and whether it is bounded."""
    order: cython.Py_ssize_t = switches[axis, 0]
    velocity: cython.Py_ssize_t = switches[axis, 1]
    sampled: cython.bint = switches[axis, 3] == 1
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    _read(axis, output, encoder, numbers, switches, state, memory, noise, found)
    wrong: cython.double = found[1] - _dot(encoder, state, axis, order)
    wanted: cython.double = _dot(law, state, axis, order) + beside
    wanted += law_inputs[axis, 0] * setpoint + law_inputs[axis, 1] * wrong
    drive: cython.double = wanted
    if drive > numbers[axis, 0]:
        drive = numbers[axis, 0]
    elif drive < -numbers[axis, 0]:
        drive = -numbers[axis, 0]
    found[1] = drive
    found[2] = 1.0 if drive != wanted else 0.0
    if sampled:
        for i in range(order):
            work[0, i] = (
                jump_inputs[axis, 0, i] * setpoint
                + jump_inputs[axis, 1, i] * wrong
                + jump_inputs[axis, 2, i] * (drive - wanted)
            )
            for j in range(order):
                work[0, i] += jump[axis, i, j] * state[axis, j]
        for i in range(order):
            state[axis, i] = work[0, i]
    held: cython.Py_ssize_t = 1 if sampled or drive != wanted else 0
    effect: cython.double = drive if held == 1 else beside
    if numbers[axis, 2] > 0.0:
        if effect > numbers[axis, 2]:
            effect -= numbers[axis, 2]
        elif effect < -numbers[axis, 2]:
            effect += numbers[axis, 2]
        else:
            effect = 0.0
    work[1, 0] = setpoint
    work[1, 1] = following
    work[1, 2] = effect
    work[1, 3] = 0.0
    work[1, 4] = wrong
    if numbers[axis, 1] > 0.0:
        _flow_with_friction(
            phi, inputs, stick_law, stick_inputs, axis, held, order, velocity, numbers[axis, 1], state, memory,
            work[1], work[0],
        )  # fmt: skip
    else:
        _transit(phi, inputs, axis, held, 0, order, state, work[1], work[0])
        for i in range(order):
            state[axis, i] = work[0, i]


def run_axes(
    phi: cython.double[:, :, :, :, ::1],
    inputs: cython.double[:, :, :, :, ::1],
    output: cython.double[:, ::1],
    encoder: cython.double[:, ::1],
    jump: cython.double[:, :, ::1],
    jump_inputs: cython.double[:, :, ::1],
    law: cython.double[:, ::1],
    law_inputs: cython.double[:, ::1],
    stick_law: cython.double[:, :, ::1],
    stick_inputs: cython.double[:, :, ::1],
    numbers: cython.double[:, ::1],
    switches: cython.longlong[:, ::1],
    state: cython.double[:, ::1],
    memory: cython.double[:, ::1],
    setpoints: cython.double[:, ::1],
    noise: cython.double[:, ::1],
    position: cython.double[:, ::1],
    force: cython.double[:, ::1],
    bounded: cython.uchar[:, ::1],
    work: cython.double[:, ::1],
) -> None:
    """Run axes that know nothing of each other. `work` is (3, max(order, 5)); `noise` (axes, n control periods)."""
    axes: cython.Py_ssize_t = setpoints.shape[0]
    count: cython.Py_ssize_t = setpoints.shape[1] - 1
    axis: cython.Py_ssize_t
    k: cython.Py_ssize_t
    m: cython.Py_ssize_t
    parts: cython.Py_ssize_t
    rise: cython.double
    with cython.nogil:
        for axis in range(axes):
            parts = switches[axis, 2]
            for k in range(count):
                rise = (setpoints[axis, k + 1] - setpoints[axis, k]) / parts
                for m in range(parts):
                    _step(
                        axis, phi, inputs, output, encoder, jump, jump_inputs, law, law_inputs, stick_law, stick_inputs, numbers,
                        switches, state, memory, setpoints[axis, k] + m * rise, setpoints[axis, k] + (m + 1) * rise, 0.0,
                        noise[axis, k * parts + m] if numbers[axis, 5] > 0.0 else 0.0, work, work[2],
                    )  # fmt: skip
                    if m == 0:
                        position[axis, k] = work[2, 0]
                        force[axis, k] = work[2, 1]
                        bounded[axis, k] = 0
                    if work[2, 2] != 0.0:
                        bounded[axis, k] = 1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _cross_couple(
    axes: cython.Py_ssize_t,
    k: cython.Py_ssize_t,
    tangent: cython.double[:, ::1],
    curvature: cython.double[:, ::1],
    gains: cython.double[::1],
    integral: cython.double[::1],
    errors: cython.double[:, ::1],
) -> cython.void:
    """Write the coupling (row 2 of `errors`) for the position errors (row 0): Koren and Lo's variable gain.

    The contour error is ε = e − (e·t)t + κ|e|²/2, to second order in e; in two dimensions that is −Ex Cx + Ey Cy of
    Koren and Lo with Cx = sin ψ − Ex/(2ρ), Cy = cos ψ + Ey/(2ρ).
    """
    along: cython.double = 0.0
    square: cython.double = 0.0
    signed: cython.double
    weighted: cython.double
    i: cython.Py_ssize_t
    for i in range(axes):
        along += errors[0, i] * tangent[k, i]
        square += errors[0, i] * errors[0, i]
    if axes == 2:
        bend: cython.double = tangent[k, 0] * curvature[k, 1] - tangent[k, 1] * curvature[k, 0]
        gain_x: cython.double = -tangent[k, 1] + 0.5 * bend * errors[0, 0]
        gain_y: cython.double = tangent[k, 0] + 0.5 * bend * errors[0, 1]
        signed = gain_x * errors[0, 0] + gain_y * errors[0, 1]
        integral[0] += gains[1] * signed
        weighted = gains[0] * signed + integral[0]
        errors[2, 0] = gain_x * weighted
        errors[2, 1] = gain_y * weighted
        return
    for i in range(axes):
        signed = errors[0, i] - along * tangent[k, i] + 0.5 * square * curvature[k, i]
        integral[i] += gains[1] * signed
        errors[2, i] = gains[0] * signed + integral[i]
    along = 0.0
    for i in range(axes):
        along += integral[i] * tangent[k, i]
    for i in range(axes):
        integral[i] -= along * tangent[k, i]


def run_coupled(
    phi: cython.double[:, :, :, :, ::1],
    inputs: cython.double[:, :, :, :, ::1],
    output: cython.double[:, ::1],
    encoder: cython.double[:, ::1],
    jump: cython.double[:, :, ::1],
    jump_inputs: cython.double[:, :, ::1],
    law: cython.double[:, ::1],
    law_inputs: cython.double[:, ::1],
    stick_law: cython.double[:, :, ::1],
    stick_inputs: cython.double[:, :, ::1],
    numbers: cython.double[:, ::1],
    switches: cython.longlong[:, ::1],
    state: cython.double[:, ::1],
    memory: cython.double[:, ::1],
    setpoints: cython.double[:, ::1],
    noise: cython.double[:, ::1],
    position: cython.double[:, ::1],
    force: cython.double[:, ::1],
    bounded: cython.uchar[:, ::1],
    work: cython.double[:, ::1],
    desired: cython.double[:, ::1],
    gains: cython.double[::1],
    tangent: cython.double[:, ::1],
    curvature: cython.double[:, ::1],
    feedforward: cython.double[:, :, ::1],
    feedback: cython.double[:, :, :, ::1],
    integral: cython.double[::1],
    errors: cython.double[:, ::1],
) -> None:
    """Run axes that a controller couples; all have the same number of control periods a setpoint.

    `desired` (axes, n + 1) is what errors are measured against (`setpoints` may be shaped). With ``gains`` of length 2
    (proportional, integral a control period) it is cross coupling along `tangent` and `curvature` (n, axes). With
    gains empty it is state feedback: the drives receive feedforward[k, 0] + feedback[k, 0] e + feedback[k, 1] ė, with the
    desired velocity in feedforward[k, 1]; arrays (n, 2, axes) and (n, 2, axes, axes). `integral` (axes) is kept
    between calls; `errors` is scratch (3, axes).
    """
    axes: cython.Py_ssize_t = setpoints.shape[0]
    count: cython.Py_ssize_t = setpoints.shape[1] - 1
    parts: cython.Py_ssize_t = switches[0, 2]
    cross: cython.bint = gains.shape[0] == 2
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    k: cython.Py_ssize_t
    m: cython.Py_ssize_t
    start: cython.double
    rise: cython.double
    with cython.nogil:
        for k in range(count):
            for m in range(parts):
                for i in range(axes):
                    start = desired[i, k] + (desired[i, k + 1] - desired[i, k]) * m / parts
                    _read(
                        i, output, encoder, numbers, switches, state, memory,
                        noise[i, k * parts + m] if numbers[i, 5] > 0.0 else 0.0, work[2],
                    )  # fmt: skip
                    errors[0, i] = start - work[2, 1]
                    if not cross:
                        errors[1, i] = feedforward[k, 1, i] - state[i, switches[i, 1]]
                if cross:
                    _cross_couple(axes, k, tangent, curvature, gains, integral, errors)
                else:
                    for i in range(axes):
                        errors[2, i] = feedforward[k, 0, i]
                        for j in range(axes):
                            errors[2, i] += (
                                feedback[k, 0, i, j] * errors[0, j] + feedback[k, 1, i, j] * errors[1, j]
                            )
                for i in range(axes):
                    rise = (setpoints[i, k + 1] - setpoints[i, k]) / parts
                    start = setpoints[i, k] + m * rise
                    _step(
                        i, phi, inputs, output, encoder, jump, jump_inputs, law, law_inputs, stick_law, stick_inputs, numbers,
                        switches, state, memory, start, start + rise, errors[2, i],
                        noise[i, k * parts + m] if numbers[i, 5] > 0.0 else 0.0, work, work[2],
                    )  # fmt: skip
                    if m == 0:
                        position[i, k] = work[2, 0]
                        force[i, k] = work[2, 1]
                        bounded[i, k] = 0
                    if work[2, 2] != 0.0:
                        bounded[i, k] = 1

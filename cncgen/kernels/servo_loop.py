# cython: infer_types=True
"""Closed loops of servo axes, step by step.

An axis is a hybrid system (Goebel, Sanfelice and Teel 2009): a vector of states z that *flows* over a control period by
exact transition matrices and *jumps* at each control instant, when a sampled controller reads its encoder. The parts that break
linearity stand between the two: encoder steps and noise, the bound of the drive, Coulomb friction, backlash.
`cncgen.servo.loop` makes the tables.

    setpoint ──► law ──► bound ──► dead band ──► flow with friction ──► backlash ──► encoder ─┐
                  ▲                                                                          │
                  └──────────────── jump of a sampled controller ◄───────────────────────────┘
"""

import cython
from cython.cimports.libc.math import sqrt

#: Columns of `numbers`, of `switches`, of `memory`, and rows of what flows in (see `Axes`).
_BOUND = cython.declare(cython.Py_ssize_t, 0)
_COULOMB = cython.declare(cython.Py_ssize_t, 1)
_DEAD_BAND = cython.declare(cython.Py_ssize_t, 2)
_BACKLASH = cython.declare(cython.Py_ssize_t, 3)
_RESOLUTION = cython.declare(cython.Py_ssize_t, 4)
_NOISE = cython.declare(cython.Py_ssize_t, 5)

_ORDER = cython.declare(cython.Py_ssize_t, 0)
_VELOCITY = cython.declare(cython.Py_ssize_t, 1)
_PARTS = cython.declare(cython.Py_ssize_t, 2)
_SAMPLED = cython.declare(cython.Py_ssize_t, 3)
_LOAD_SIDE = cython.declare(cython.Py_ssize_t, 4)

_LOAD = cython.declare(cython.Py_ssize_t, 0)
_STICKING = cython.declare(cython.Py_ssize_t, 1)
_SENSE = cython.declare(cython.Py_ssize_t, 2)

_START = cython.declare(cython.Py_ssize_t, 0)
_END = cython.declare(cython.Py_ssize_t, 1)
_DRIVE = cython.declare(cython.Py_ssize_t, 2)
_FRICTION = cython.declare(cython.Py_ssize_t, 3)
_ENCODER_ERROR = cython.declare(cython.Py_ssize_t, 4)

#: Changes of regime in one control period from which on an axis that trembles about standstill stays there.
_TREMBLING = cython.declare(cython.Py_ssize_t, 64)

#: Where an axis is (beyond the backlash), and where its encoder sees it.
_Reading = cython.struct(position=cython.double, seen=cython.double)

#: Record of a control period: position at its start, drive input, whether the bound was met.
_Step = cython.struct(position=cython.double, drive=cython.double, bounded=cython.bint)


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
def _bounded(value: cython.double, bound: cython.double) -> cython.double:
    """Return the value between −bound and bound."""
    if value > bound:
        return bound
    return -bound if value < -bound else value


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _beyond_dead_band(value: cython.double, width: cython.double) -> cython.double:
    """Return a drive's input after a dead band of ± width."""
    if value > width:
        return value - width
    return value + width if value < -width else 0.0


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def _level(done: cython.longlong, whole: cython.longlong, level: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Return the level of the longest part of a period that may begin at `done`, near that of the part before.

    Parts of level l are ``whole >> l`` long, begin at a multiple of their length and end within the period.
    """
    while (whole >> level) > whole - done or (done & ((whole >> level) - 1)) != 0:
        level += 1
    while level > 0 and (done & ((whole >> (level - 1)) - 1)) == 0 and (whole >> (level - 1)) <= whole - done:
        level -= 1
    return level


@cython.final
@cython.cclass
class Axes:
    """Axes with their tables and states; `run` and `run_coupled` carry them over setpoints.

    Tables, for `axes` axes of at most `order` states (rows beyond an axis's own order are zero):

    Args:
        phi, inputs: Shape (axes, 4, levels, order, order) and (axes, 4, levels, 5, order):
            flow over 1/2**level of a control period in mode 0 free, 1 held, 2 free and sticking, 3 held and sticking;
            inputs are: setpoint at the start, setpoint at the end, what is held at the drive, friction, encoder error.
        output, encoder: Shape (axes, order): position y = output . z; reading of the encoder = encoder . z.
        jump, jump_inputs: Shape (axes, order, order) and (axes, 3, order);
            inputs are: setpoint, encoder error, what the bound took off the drive's input.
        law, law_inputs: Shape (axes, order) and (axes, 2):
            drive input u = law . z + law_inputs . (setpoint, encoder error).
        stick_law, stick_inputs: Shape (axes, 2, order) and (axes, 2, 2):
            force on the standing axis, free and held; inputs are: setpoint, what is held.
        numbers: Shape (axes, 6): bound, Coulomb force, dead band, backlash, encoder step, noise.
        switches: Shape (axes, 5): order, index of the velocity state (-1: none), control periods a setpoint,
            1 for a sampled controller, 1 where the encoder is beyond the backlash.
        state: Shape (axes, order): z; changed.
        memory: Shape (axes, 3): position beyond the backlash, 1 while sticking, friction's sign; changed.
        work: Shape (2, max(order, 5)), scratch.
    """

    phi: cython.double[:, :, :, :, ::1]
    inputs: cython.double[:, :, :, :, ::1]
    output: cython.double[:, ::1]
    encoder: cython.double[:, ::1]
    jump: cython.double[:, :, ::1]
    jump_inputs: cython.double[:, :, ::1]
    law: cython.double[:, ::1]
    law_inputs: cython.double[:, ::1]
    stick_law: cython.double[:, :, ::1]
    stick_inputs: cython.double[:, :, ::1]
    numbers: cython.double[:, ::1]
    switches: cython.longlong[:, ::1]
    state: cython.double[:, ::1]
    memory: cython.double[:, ::1]
    entering: cython.double[::1]
    result: cython.double[::1]

    def __init__(
        self,
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
        work: cython.double[:, ::1],
    ):
        self.phi = phi
        self.inputs = inputs
        self.output = output
        self.encoder = encoder
        self.jump = jump
        self.jump_inputs = jump_inputs
        self.law = law
        self.law_inputs = law_inputs
        self.stick_law = stick_law
        self.stick_inputs = stick_inputs
        self.numbers = numbers
        self.switches = switches
        self.state = state
        self.memory = memory
        self.entering = work[0]
        self.result = work[1]

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _transit(
        self, axis: cython.Py_ssize_t, mode: cython.Py_ssize_t, level: cython.Py_ssize_t
    ) -> cython.void:
        """Write phi z + inputs u of one mode and level to `result`."""
        order: cython.Py_ssize_t = self.switches[axis, _ORDER]
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        total: cython.double
        for i in range(order):
            total = 0.0
            for j in range(order):
                total += self.phi[axis, mode, level, i, j] * self.state[axis, j]
            for j in range(5):
                total += self.inputs[axis, mode, level, j, i] * self.entering[j]
            self.result[i] = total

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _arrive(self, axis: cython.Py_ssize_t) -> cython.void:
        """Take `result` over as the state."""
        i: cython.Py_ssize_t
        for i in range(self.switches[axis, _ORDER]):
            self.state[axis, i] = self.result[i]

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _dot(self, table: cython.double[:, ::1], axis: cython.Py_ssize_t) -> cython.double:
        """Return a row of a table times the state."""
        total: cython.double = 0.0
        i: cython.Py_ssize_t
        for i in range(self.switches[axis, _ORDER]):
            total += table[axis, i] * self.state[axis, i]
        return total

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _standing_force(
        self, axis: cython.Py_ssize_t, held: cython.Py_ssize_t, z: cython.double[::1], setpoint: cython.double
    ) -> cython.double:
        """Return the force that friction has to balance where the axis stands with the states z."""
        total: cython.double = (
            self.stick_inputs[axis, held, 0] * setpoint
            + self.stick_inputs[axis, held, 1] * self.entering[_DRIVE]
        )
        i: cython.Py_ssize_t
        for i in range(self.switches[axis, _ORDER]):
            total += self.stick_law[axis, held, i] * z[i]
        return total

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _choose_regime(
        self, axis: cython.Py_ssize_t, held: cython.Py_ssize_t, trembles: cython.bint
    ) -> cython.void:
        """Say whether the axis sticks or slides, and which way, from its velocity or the force on it at rest."""
        velocity: cython.double = self.state[axis, self.switches[axis, _VELOCITY]]
        coulomb: cython.double = self.numbers[axis, _COULOMB]
        if velocity == 0.0:
            force = self._standing_force(axis, held, self.state[axis], self.entering[_START])
            self.memory[axis, _STICKING] = 1.0 if trembles or -coulomb <= force <= coulomb else 0.0
            self.memory[axis, _SENSE] = 1.0 if force > 0.0 else -1.0
        elif self.memory[axis, _STICKING] == 0.0:
            self.memory[axis, _SENSE] = 1.0 if velocity > 0.0 else -1.0

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _try_part(
        self,
        axis: cython.Py_ssize_t,
        held: cython.Py_ssize_t,
        level: cython.Py_ssize_t,
        trembles: cython.bint,
    ) -> cython.bint:
        """Write where a part of the period leads to `result`; tell whether its end agrees with the regime."""
        coulomb: cython.double = self.numbers[axis, _COULOMB]
        if self.memory[axis, _STICKING] == 1.0:
            self.entering[_FRICTION] = 0.0
            self._transit(axis, held + 2, level)
            force = self._standing_force(axis, held, self.result, self.entering[_END])
            return trembles or -coulomb <= force <= coulomb
        self.entering[_FRICTION] = -coulomb * self.memory[axis, _SENSE]
        self._transit(axis, held, level)
        return self.result[self.switches[axis, _VELOCITY]] * self.memory[axis, _SENSE] > 0.0

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _flow_with_friction(self, axis: cython.Py_ssize_t, held: cython.Py_ssize_t) -> cython.void:
        """Flow over a period in which the axis may stop, stick, break away and turn; `memory` keeps which it does.

        The longest part 1/2**level whose end still agrees with the regime is taken; where even the shortest one does
        not agree, the regime changes there.
        """
        first: cython.double = self.entering[_START]
        rise: cython.double = self.entering[_END] - first
        deepest: cython.Py_ssize_t = self.phi.shape[2] - 1
        whole: cython.longlong = 1 << deepest
        done: cython.longlong = 0
        level: cython.Py_ssize_t = 0
        changes: cython.Py_ssize_t = 0
        while done < whole:
            self.entering[_START] = first + rise * done / whole
            self.entering[_END] = first + rise * (done + (whole >> level)) / whole
            self._choose_regime(axis, held, changes >= _TREMBLING)
            agrees = self._try_part(axis, held, level, changes >= _TREMBLING)
            if not agrees and level < deepest:
                level += 1
                continue
            self._arrive(axis)
            if not agrees:
                changes += 1
                if self.memory[axis, _STICKING] == 0.0:
                    self.state[axis, self.switches[axis, _VELOCITY]] = 0.0
                self.memory[axis, _STICKING] = 0.0
            done += whole >> level
            if done < whole:
                level = _level(done, whole, level)

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _read(self, axis: cython.Py_ssize_t, noise: cython.double) -> _Reading:
        """Return the position (beyond the backlash) and its encoder reading; the same when repeated."""
        position: cython.double = self._dot(self.output, axis)
        half: cython.double = 0.5 * self.numbers[axis, _BACKLASH]
        step: cython.double = self.numbers[axis, _RESOLUTION]
        if half > 0.0:
            if position - self.memory[axis, _LOAD] > half:
                self.memory[axis, _LOAD] = position - half
            elif self.memory[axis, _LOAD] - position > half:
                self.memory[axis, _LOAD] = position + half
            position = self.memory[axis, _LOAD]
        seen = position if self.switches[axis, _LOAD_SIDE] == 1 else self._dot(self.encoder, axis)
        seen += noise * self.numbers[axis, _NOISE]
        return _Reading(position=position, seen=_rounded(seen, step) if step > 0.0 else seen)

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _jump(
        self,
        axis: cython.Py_ssize_t,
        setpoint: cython.double,
        wrong: cython.double,
        taken_off: cython.double,
    ) -> cython.void:
        """Let the sampled controller take its step."""
        i: cython.Py_ssize_t
        j: cython.Py_ssize_t
        for i in range(self.switches[axis, _ORDER]):
            self.result[i] = (
                self.jump_inputs[axis, 0, i] * setpoint
                + self.jump_inputs[axis, 1, i] * wrong
                + self.jump_inputs[axis, 2, i] * taken_off
            )
            for j in range(self.switches[axis, _ORDER]):
                self.result[i] += self.jump[axis, i, j] * self.state[axis, j]
        self._arrive(axis)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def _step(
        self,
        axis: cython.Py_ssize_t,
        setpoint: cython.double,
        following: cython.double,
        beside: cython.double,
        noise: cython.double,
    ) -> _Step:
        """Carry one axis over one control period, from a setpoint to the following; `beside` is what a coupling adds."""
        reading: _Reading = self._read(axis, noise)
        wrong: cython.double = reading.seen - self._dot(self.encoder, axis)
        wanted: cython.double = self._dot(self.law, axis) + beside
        wanted += self.law_inputs[axis, 0] * setpoint + self.law_inputs[axis, 1] * wrong
        drive: cython.double = _bounded(wanted, self.numbers[axis, _BOUND])
        sampled: cython.bint = self.switches[axis, _SAMPLED] == 1
        held: cython.Py_ssize_t = 1 if sampled or drive != wanted else 0
        effect: cython.double = drive if held == 1 else beside
        if sampled:
            self._jump(axis, setpoint, wrong, drive - wanted)
        if self.numbers[axis, _DEAD_BAND] > 0.0:
            effect = _beyond_dead_band(effect, self.numbers[axis, _DEAD_BAND])
        self.entering[_START] = setpoint
        self.entering[_END] = following
        self.entering[_DRIVE] = effect
        self.entering[_FRICTION] = 0.0
        self.entering[_ENCODER_ERROR] = wrong
        if self.numbers[axis, _COULOMB] > 0.0:
            self._flow_with_friction(axis, held)
        else:
            self._transit(axis, held, 0)
            self._arrive(axis)
        return _Step(position=reading.position, drive=drive, bounded=drive != wanted)

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _drawn(
        self, noise: cython.double[:, ::1], axis: cython.Py_ssize_t, m: cython.Py_ssize_t
    ) -> cython.double:
        """Return the noise of control period m, 0 where the axis has none."""
        return noise[axis, m] if self.numbers[axis, _NOISE] > 0.0 else 0.0

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _follow(
        self,
        axis: cython.Py_ssize_t,
        k: cython.Py_ssize_t,
        m: cython.Py_ssize_t,
        setpoints: cython.double[:, ::1],
        beside: cython.double,
        noise: cython.double[:, ::1],
        position: cython.double[:, ::1],
        force: cython.double[:, ::1],
        bounded: cython.uchar[:, ::1],
    ) -> cython.void:
        """Carry an axis over control period m of setpoint k, and record it."""
        parts: cython.Py_ssize_t = self.switches[axis, _PARTS]
        rise: cython.double = (setpoints[axis, k + 1] - setpoints[axis, k]) / parts
        start: cython.double = setpoints[axis, k] + m * rise
        step: _Step = self._step(
            axis,
            start,
            setpoints[axis, k] + (m + 1) * rise,
            beside,
            self._drawn(noise, axis, k * parts + m),
        )
        if m == 0:
            position[axis, k] = step.position
            force[axis, k] = step.drive
            bounded[axis, k] = 0
        if step.bounded:
            bounded[axis, k] = 1

    def run(
        self,
        setpoints: cython.double[:, ::1],
        noise: cython.double[:, ::1],
        position: cython.double[:, ::1],
        force: cython.double[:, ::1],
        bounded: cython.uchar[:, ::1],
    ) -> None:
        """Run axes that know nothing of each other.

        Args:
            setpoints: Shape (axes, n + 1), the last one being the first of what follows.
            noise: Shape (axes, n control periods), standard normal; not read where no axis has noise.
            position, force, bounded: Shape (axes, n), filled, at the setpoint's own instant: position, drive input
                (bounded), and 1 where the bound was met in the period that begins there.
        """
        m: cython.Py_ssize_t
        with cython.nogil:
            for axis in range(setpoints.shape[0]):
                for k in range(setpoints.shape[1] - 1):
                    for m in range(self.switches[axis, _PARTS]):
                        self._follow(axis, k, m, setpoints, 0.0, noise, position, force, bounded)

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _measure(
        self,
        k: cython.Py_ssize_t,
        m: cython.Py_ssize_t,
        desired: cython.double[:, ::1],
        noise: cython.double[:, ::1],
        errors: cython.double[:, ::1],
    ) -> cython.void:
        """Write the errors that the encoders see in control period m of setpoint k to row 0 of `errors`."""
        parts: cython.Py_ssize_t = self.switches[0, _PARTS]
        reading: _Reading
        for axis in range(desired.shape[0]):
            reading = self._read(axis, self._drawn(noise, axis, k * parts + m))
            errors[0, axis] = (
                desired[axis, k] + (desired[axis, k + 1] - desired[axis, k]) * m / parts - reading.seen
            )

    @cython.cfunc
    @cython.inline
    @cython.nogil
    @cython.exceptval(check=False)
    def _feed_back(
        self,
        k: cython.Py_ssize_t,
        feedforward: cython.double[:, :, ::1],
        feedback: cython.double[:, :, :, ::1],
        errors: cython.double[:, ::1],
    ) -> cython.void:
        """Write feedforward + feedback of position and velocity errors (rows 0 and 1 of `errors`) to row 2."""
        axes: cython.Py_ssize_t = errors.shape[1]
        for i in range(axes):
            errors[1, i] = feedforward[k, 1, i] - self.state[i, self.switches[i, _VELOCITY]]
        for i in range(axes):
            errors[2, i] = feedforward[k, 0, i]
            for j in range(axes):
                errors[2, i] += feedback[k, 0, i, j] * errors[0, j] + feedback[k, 1, i, j] * errors[1, j]

    def run_coupled(
        self,
        setpoints: cython.double[:, ::1],
        noise: cython.double[:, ::1],
        position: cython.double[:, ::1],
        force: cython.double[:, ::1],
        bounded: cython.uchar[:, ::1],
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

        Args:
            setpoints, noise, position, force, bounded: As in `run`.
            desired: Shape (axes, n + 1): reference of the errors (`setpoints` may be shaped).
            gains: Of cross coupling, (proportional, integral a control period), or empty for state feedback.
            tangent, curvature: Shape (n, axes), of cross coupling.
            feedforward, feedback: Shape (n, 2, axes) and (n, 2, axes, axes), of state feedback: the drives receive
                feedforward[k, 0] + feedback[k, 0] e + feedback[k, 1] ė, with the desired velocity in feedforward[k, 1].
            integral: Shape (axes,), kept between calls.
            errors: Shape (3, axes), scratch.
        """
        cross: cython.bint = gains.shape[0] == 2
        m: cython.Py_ssize_t
        with cython.nogil:
            for k in range(setpoints.shape[1] - 1):
                for m in range(self.switches[0, _PARTS]):
                    self._measure(k, m, desired, noise, errors)
                    if cross:
                        _cross_couple(k, tangent, curvature, gains, integral, errors)
                    else:
                        self._feed_back(k, feedforward, feedback, errors)
                    for i in range(setpoints.shape[0]):
                        self._follow(i, k, m, setpoints, errors[2, i], noise, position, force, bounded)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _cross_couple(
    k: cython.Py_ssize_t,
    tangent: cython.double[:, ::1],
    curvature: cython.double[:, ::1],
    gains: cython.double[::1],
    integral: cython.double[::1],
    errors: cython.double[:, ::1],
) -> cython.void:
    """Write the coupling (row 2 of `errors`) for the position errors (row 0): Koren and Lo's variable gain.

    The contour error is ε = e − (e·t)t + κ|e|²/2, to second order in e; in two dimensions that is −Ex Cx + Ey Cy of
    Koren and Lo with Cx = sin ψ − Ex/(2ρ), Cy = cos ψ + Ey/(2ρ). The expansion holds for |e| < ρ; in a corner rounder than
    the error its gain would grow without bound, so that ρ counts as |e| at least.
    """
    axes: cython.Py_ssize_t = errors.shape[1]
    along: cython.double = 0.0
    square: cython.double = 0.0
    turn: cython.double = 0.0
    share: cython.double = 1.0
    for i in range(axes):
        along += errors[0, i] * tangent[k, i]
        square += errors[0, i] * errors[0, i]
        turn += curvature[k, i] * curvature[k, i]
    if turn * square > 1.0:
        share = 1.0 / sqrt(turn * square)
    if axes == 2:
        bend: cython.double = tangent[k, 0] * curvature[k, 1] - tangent[k, 1] * curvature[k, 0]
        gain_x: cython.double = -tangent[k, 1] + 0.5 * share * bend * errors[0, 0]
        gain_y: cython.double = tangent[k, 0] + 0.5 * share * bend * errors[0, 1]
        signed = gain_x * errors[0, 0] + gain_y * errors[0, 1]
        integral[0] += gains[1] * signed
        weighted = gains[0] * signed + integral[0]
        errors[2, 0] = gain_x * weighted
        errors[2, 1] = gain_y * weighted
        return
    for i in range(axes):
        signed = errors[0, i] - along * tangent[k, i] + 0.5 * share * square * curvature[k, i]
        integral[i] += gains[1] * signed
        errors[2, i] = gains[0] * signed + integral[i]
    along = 0.0
    for i in range(axes):
        along += integral[i] * tangent[k, i]
    for i in range(axes):
        integral[i] -= along * tangent[k, i]

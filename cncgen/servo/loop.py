"""A closed loop of one axis: plant and controller joined, in continuous pieces and as tables for the kernel `servo_loop`.

An axis is a hybrid system (Goebel, Sanfelice and Teel (2009)): its states z flow over a control period by exact transition matrices
(matrix exponentials, `discretise`) and jump at control instants, where a sampled controller reads the encoder. `models` makes
plants and controllers from servo data; `bank` runs the loops of several axes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cncgen.servo.controller import Controller
from cncgen.servo.discretise import exponential, held, ramped
from cncgen.servo.plants import Imperfections, Plant, companion

Floats = NDArray[np.float64]

#: How often a control period is halved to find where an axis with friction stops or reverses: to 2⁻²⁰ of it.
FRICTION_LEVELS = 21
#: Longest dead time, in control periods: each of them is a state.
MAX_DELAY = 250
#: Columns of the flow's inputs: setpoint (start, end), drive, friction, encoder error.
_INPUTS = 5


@dataclass(frozen=True, slots=True)
class AxisLoop:
    """One axis over one control period, its n states z. The names are those of `cncgen.kernels.servo_loop.Axes`.

    Attributes:
        phi: Shape (4, levels, n, n): transition matrices over 1/2**level of a control period. The first index is the mode: 0 free,
            1 with the drive's input held, 2 free and sticking, 3 held and sticking.
        inputs: Shape (4, levels, 5, n): additions to z for each unit of: setpoint at the start, setpoint at the end, held drive
            input, friction, encoder error.
        output, encoder: Shape (n,): position of the axis, and measured position, as output · z and encoder · z.
        jump, jump_inputs: Shape (n, n) and (3, n): the jump at a control instant; inputs are setpoint, encoder error, and what the
            bound has taken off the drive's input.
        law, law_inputs: Shape (n,) and (2,): drive input law · z + law_inputs · (setpoint, encoder error).
        stick_law, stick_inputs: Shape (2, n) and (2, 2): force on the standing axis, free and held; inputs are setpoint and held
            drive input.
        velocity: Index of the velocity state, or −1.
        sampled: True where the controller is sampled.
        period: Control period, s.
        dead_band: Drive input that friction swallows on a plant without a velocity state.
        feedthrough: Of a closed loop given as a ratio: position = output · z + feedthrough · setpoint.
        force_unit: Unit of the drive input.
        imperfections: Friction, backlash and encoder.
    """

    phi: Floats
    inputs: Floats
    output: Floats
    encoder: Floats
    jump: Floats
    jump_inputs: Floats
    law: Floats
    law_inputs: Floats
    stick_law: Floats
    stick_inputs: Floats
    velocity: int
    sampled: bool
    period: float
    dead_band: float = 0.0
    feedthrough: float = 0.0
    force_unit: str = ""
    imperfections: Imperfections = field(default_factory=Imperfections)

    def transition(self) -> tuple[Floats, Floats, Floats]:
        """Return (A, B0, B1) of the linear loop over one control period: z⁺ = A z + B0 r[k] + B1 r[k+1]."""
        if not self.sampled:
            return self.phi[0, 0], self.inputs[0, 0, 0], self.inputs[0, 0, 1]
        flow, drive = self.phi[1, 0], self.inputs[1, 0, 2]
        matrix = flow @ self.jump + np.outer(drive, self.law)
        return matrix, flow @ self.jump_inputs[0] + drive * self.law_inputs[0], np.zeros(len(drive))

    def poles(self) -> NDArray[np.complex128]:
        """Return the eigenvalues of the linear loop over one control period (poles in z)."""
        return np.linalg.eigvals(self.transition()[0]).astype(complex)


def close_loop(plant: Plant, controller: Controller, period: float) -> AxisLoop:
    """Join a plant and a controller.

    Args:
        plant: The plant.
        controller: The controller; a sampled one holds its output over `period`.
        period: Control period, s.

    Raises:
        ValueError: The controller needs a velocity that the plant has not, a plant in z has another period, or a dead
            time stands with a continuous controller, or with friction and is no whole number of control periods.
    """
    reads_velocity = controller.d_velocity != 0.0 or len(controller.b_velocity) > 0
    if reads_velocity and plant.velocity is None:
        raise ValueError("the controller reads a velocity, and the plant has no velocity state")
    if plant.sample_time_s is not None and abs(plant.sample_time_s - period) > 1e-9 * period:
        raise ValueError(
            f"a plant in z at {plant.sample_time_s:g} s goes with that control period, not {period:g} s"
        )
    _check_delay(plant.delay_s, period)
    if plant.delay_s > 0.0 or plant.sample_time_s is not None:
        if controller.continuous:
            raise ValueError("a dead time or a plant in z goes with a sampled controller")
        if plant.imperfections.coulomb > 0.0 and plant.velocity is not None:
            return _close(plant, _queued(controller, _whole_periods(plant.delay_s, period)), period)
        return _close_delayed(plant, controller, period)
    return _close(plant, controller, period)


def _check_delay(delay_s: float, period: float) -> None:
    if delay_s > MAX_DELAY * period:
        raise ValueError(
            f"a dead time of {delay_s:g} s is more than {MAX_DELAY} control periods of {period:g} s"
        )


def _whole_periods(delay_s: float, period: float) -> int:
    count = round(delay_s / period)
    if abs(delay_s - count * period) > 1e-9 * period:
        raise ValueError(
            f"with Coulomb friction the dead time {delay_s:g} s must be a whole number of control periods of {period:g} s"
        )
    return count


def _queued(controller: Controller, count: int) -> Controller:
    """Return a sampled controller whose output comes that many control periods late: a queue in its memory."""
    if count == 0:
        return controller
    if controller.d_velocity != 0.0:
        raise ValueError("a dead time with friction goes with a controller that reads the position alone")
    m = len(controller.a)
    a = np.zeros((m + count, m + count))
    a[:m, :m], a[m, :m] = controller.a, controller.c
    a[range(m + 1, m + count), range(m, m + count - 1)] = 1.0

    def joined(name: str, direct: float) -> Floats:
        return np.concatenate([controller.column(name), [direct], np.zeros(count - 1)])

    return Controller(
        a=a,
        b_setpoint=joined("b_setpoint", controller.d_setpoint),
        b_position=joined("b_position", controller.d_position),
        b_bound=joined("b_bound", 0.0),
        c=np.concatenate([np.zeros(m + count - 1), [1.0]]),
    )


def _close(plant: Plant, controller: Controller, period: float) -> AxisLoop:
    law, speed = _law(plant, controller)
    levels = FRICTION_LEVELS if plant.imperfections.coulomb > 0.0 and plant.velocity is not None else 1
    phi = np.zeros((4, levels, len(law), len(law)))
    inputs = np.zeros((4, levels, _INPUTS, len(law)))
    stick_law, stick_inputs = np.zeros((2, len(law))), np.zeros((2, 2))
    for mode in (0, 1):
        if mode == 1 and not controller.continuous:
            # A sampled controller has no say between its instants: free and held are one flow.
            phi[1::2], inputs[1::2] = phi[0::2], inputs[0::2]
            stick_law[1], stick_inputs[1] = stick_law[0], stick_inputs[0]
            break
        a, b = _continuous(plant, controller, mode == 0, law, speed)
        _fill(phi[mode], inputs[mode], a, b, period)
        if levels > 1 and plant.velocity is not None:
            strength = plant.b[plant.velocity]
            stick_law[mode] = a[plant.velocity] / strength
            stick_inputs[mode] = b[plant.velocity, 0] / strength, 1.0
            a[plant.velocity], b[plant.velocity] = 0.0, 0.0
            _fill(phi[mode + 2], inputs[mode + 2], a, b, period)
    return _tables(plant, controller, period, law, phi, inputs, (stick_law, stick_inputs))


def _law(plant: Plant, controller: Controller) -> tuple[Floats, Floats]:
    """Return the controller's law over the states of plant and controller, and the row that picks the velocity."""
    speed = np.zeros(len(plant.a))
    if plant.velocity is not None:
        speed[plant.velocity] = 1.0
    seen = controller.d_position * plant.encoder + controller.d_velocity * speed
    return np.concatenate([seen, controller.c]), speed


def _tables(
    plant: Plant,
    controller: Controller,
    period: float,
    law: Floats,
    phi: Floats,
    inputs: Floats,
    sticking: tuple[Floats, Floats],
) -> AxisLoop:
    n, m, order = len(plant.a), len(controller.a), phi.shape[-1]
    jump = np.eye(order)
    jump_inputs = np.zeros((3, order))
    if not controller.continuous:
        jump[n : n + m, : n + m] = np.hstack(
            [np.outer(controller.column("b_position"), plant.encoder), controller.a]
        )
        for row, name in enumerate(("b_setpoint", "b_position", "b_bound")):
            jump_inputs[row, n : n + m] = controller.column(name)
    return AxisLoop(
        phi=phi,
        inputs=inputs,
        output=_padded(plant.c, order),
        encoder=_padded(plant.encoder, order),
        jump=jump,
        jump_inputs=jump_inputs,
        law=_padded(law, order),
        law_inputs=np.array([controller.d_setpoint, controller.d_position]),
        stick_law=sticking[0],
        stick_inputs=sticking[1],
        velocity=-1 if plant.velocity is None else plant.velocity,
        sampled=not controller.continuous,
        period=period,
        dead_band=plant.imperfections.coulomb if plant.velocity is None else 0.0,
        force_unit=plant.force_unit,
        imperfections=plant.imperfections,
    )


def _padded(values: Floats, length: int) -> Floats:
    return np.concatenate([values, np.zeros(length - len(values))])


def _continuous(
    plant: Plant, controller: Controller, free: bool, law: Floats, speed: Floats
) -> tuple[Floats, Floats]:
    """Return (A, B) of the flow; B's columns are setpoint, drive, friction and encoder error.

    Free: the controller's law acts all the time. Else the drive's input is given, and a continuous controller goes on
    with its integrators frozen.
    """
    n, m = len(plant.a), len(controller.a)
    a, b = np.zeros((n + m, n + m)), np.zeros((n + m, 4))
    a[:n, :n] = plant.a
    b[:n, 1] = b[:n, 2] = plant.b
    if not controller.continuous:
        return a, b
    if free:
        a[:n] += np.outer(plant.b, law)
        b[:n, 0] = plant.b * controller.d_setpoint
        b[:n, 3] = plant.b * controller.d_position
    position, velocity = controller.column("b_position"), controller.column("b_velocity")
    a[n:, :n] = np.outer(position, plant.encoder) + np.outer(velocity, speed)
    a[n:, n:] = controller.a
    b[n:, 0], b[n:, 3] = controller.column("b_setpoint"), position
    if not free:
        stopped = [n + i for i in controller.frozen]
        a[stopped], b[stopped] = 0.0, 0.0
    return a, b


def _fill(phi: Floats, inputs: Floats, a: Floats, b: Floats, period: float) -> None:
    """Write the flow over the period and over its halves: phi (levels, n, n), inputs (levels, 5, n)."""
    _read_flow(phi[0], inputs[0], exponential(_ramp_block(a * period, b * period)), b.shape[1], 1.0)
    if len(phi) > 1:
        _fill_halves(phi, inputs, a, b, period)


def _ramp_block(a: Floats, b: Floats) -> Floats:
    """Return the generator of ẋ = A x + B u with all inputs held but the first, which rises: (n + m + 1) square."""
    n, m = b.shape
    block = np.zeros((n + m + 1, n + m + 1))
    block[:n, :n], block[:n, n : n + m], block[n, n + m] = a, b, 1.0
    return block


def _read_flow(phi: Floats, inputs: Floats, flow: Floats, m: int, part: float) -> None:
    """Write Φ (n, n) and inputs (5, n) from the exponential of `_ramp_block` over a time `part` of its own unit."""
    n = len(phi)
    ramp = flow[:n, n + m] / part
    phi[:] = flow[:n, :n]
    inputs[0], inputs[1] = flow[:n, n] - ramp, ramp
    inputs[2:] = flow[:n, n + 1 : n + m].T


def _fill_halves(phi: Floats, inputs: Floats, a: Floats, b: Floats, period: float) -> None:
    """Write levels 1 and up by squaring from the shortest part: its rounding grows to 1e-10 on the way, no more."""
    part = period / 2.0 ** (len(phi) - 1)
    flow = exponential(_ramp_block(a, b) * part)
    for level in range(len(phi) - 1, 0, -1):
        _read_flow(phi[level], inputs[level], flow, b.shape[1], part)
        flow, part = flow @ flow, 2.0 * part


def _close_delayed(plant: Plant, controller: Controller, period: float) -> AxisLoop:
    """Join with a dead time: drive inputs wait in a queue of states, the newest first.

    The input over [0, f T] of a period is the one d + 1 periods old, over the rest the one d periods old, with
    d + f the dead time in periods (Åström and Wittenmark, Computer-Controlled Systems, section 2.3).
    """
    n, m = len(plant.a), len(controller.a)
    whole, fraction = divmod(plant.delay_s / period, 1.0)
    if fraction > 1.0 - 1e-9:
        whole, fraction = whole + 1.0, 0.0
    queue = np.arange(int(whole) + 1) + n + m
    if plant.sample_time_s is None:
        flow, total = held(plant.a, plant.b[:, None], period)
        _, late = held(plant.a, plant.b[:, None], period * (1.0 - fraction))
    else:
        flow, total = plant.a, plant.b[:, None]
        late = total
    order = n + m + len(queue)
    phi = np.zeros((4, 1, order, order))
    inputs = np.zeros((4, 1, _INPUTS, order))
    phi[:, 0, :n, :n] = flow
    phi[:, 0, n : n + m, n : n + m] = np.eye(m)
    phi[:, 0, queue[1:], queue[:-1]] = 1.0
    inputs[:, 0, 2, queue[0]] = 1.0
    phi[:, 0, :n, queue[-1]] += (total - late)[:, 0]
    if len(queue) > 1:
        phi[:, 0, :n, queue[-2]] += late[:, 0]
    else:
        inputs[:, 0, 2, :n] = late[:, 0]
    law, _ = _law(plant, controller)
    return _tables(plant, controller, period, law, phi, inputs, (np.zeros((2, order)), np.zeros((2, 2))))


def follow_transfer_function(
    numerator: Floats,
    denominator: Floats,
    period: float,
    delay_s: float = 0.0,
    discrete: bool = False,
    imperfections: Imperfections | None = None,
) -> AxisLoop:
    """Return a closed loop given as a ratio of polynomials from setpoint to position, without a drive inside.

    Args:
        numerator, denominator: Highest power first, in s, or in z (then `period` is their sample time).
        period: s.
        delay_s: Dead time; the setpoint goes straight from sample to sample also when it is delayed.
        discrete: True for polynomials in z.
        imperfections: Only backlash has a meaning here.

    Raises:
        ValueError: The ratio is not proper, the dead time is too long, or backlash stands with a direct feedthrough.
    """
    imperfections = imperfections or Imperfections()
    _check_delay(delay_s, period)
    a, b, c, feedthrough = companion(numerator, denominator)
    if feedthrough != 0.0 and imperfections.backlash > 0.0:
        raise ValueError("backlash needs a closed loop without direct feedthrough")
    whole, fraction = divmod(delay_s / period, 1.0)
    if discrete and min(fraction, 1.0 - fraction) > 1e-9:
        raise ValueError("the dead time of a ratio in z must be a whole number of its sample times")
    if discrete:
        whole, fraction = round(delay_s / period), 0.0
        flow, weights = a, {int(whole): b}
    else:
        flow, weights = _delayed_ramps(a, b, period, int(whole), fraction)
    n = len(a)
    order = n + (int(whole) + 1 if delay_s > 0.0 else 0)
    phi, inputs, output = np.zeros((4, 1, order, order)), np.zeros((4, 1, _INPUTS, order)), _padded(c, order)
    phi[0, 0, :n, :n] = flow
    if order > n:
        phi[0, 0, range(n + 1, order), range(n, order - 1)] = 1.0
        inputs[0, 0, 0, n] = 1.0
    for age, weight in weights.items():
        if age > 0:
            phi[0, 0, :n, n + age - 1] += weight
        else:
            inputs[0, 0, -age, :n] += weight
    direct = 0.0
    for age, share in ((int(whole), 1.0 - fraction), (int(whole) + 1, fraction)):
        if age > 0 and share > 0.0:
            output[n + age - 1] += feedthrough * share
        elif age == 0:
            direct = feedthrough * share
    return AxisLoop(
        phi=phi,
        inputs=inputs,
        output=output,
        encoder=output,
        jump=np.eye(order),
        jump_inputs=np.zeros((3, order)),
        law=np.zeros(order),
        law_inputs=np.array([1.0, 0.0]),
        stick_law=np.zeros((2, order)),
        stick_inputs=np.zeros((2, 2)),
        velocity=-1,
        sampled=False,
        period=period,
        feedthrough=direct,
        force_unit="mm",
        imperfections=imperfections,
    )


def _delayed_ramps(
    a: Floats, b: Floats, period: float, whole: int, fraction: float
) -> tuple[Floats, dict[int, Floats]]:
    """Return the flow over a period under a delayed ramp: Φ, and the weight of each setpoint by its age in periods.

    The delayed setpoint has its kink f T into the period: it comes from age d + 1 and goes towards age d − 1.
    """
    if whole == 0 and fraction == 0.0:
        flow, start, end = ramped(a, b[:, None], period)
        return flow, {0: start[:, 0], -1: end[:, 0]}
    flow_1, start_1, end_1 = ramped(a, b[:, None], period * fraction)
    flow_2, start_2, end_2 = ramped(a, b[:, None], period * (1.0 - fraction))
    at_start = flow_2 @ start_1[:, 0]
    weights = {
        whole + 1: at_start * fraction,
        whole: at_start * (1.0 - fraction) + flow_2 @ end_1[:, 0] + start_2[:, 0] + end_2[:, 0] * fraction,
        whole - 1: end_2[:, 0] * (1.0 - fraction),
    }
    return flow_2 @ flow_1, weights

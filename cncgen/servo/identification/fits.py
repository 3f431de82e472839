"""Output-error fits: the parameters whose simulation is nearest to the logged position, with their uncertainty.

Minimising Σ (y − ŷ(θ))² over a simulated ŷ is the maximum-likelihood estimate under white measurement noise, in closed
loop too, since the drive's input is known; its covariance is s² (JᵀJ)⁻¹ (Ljung, System Identification, 2nd ed., eqs 9.29,
9.42). Positive parameters are fitted by their logarithms.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.arguments import is_number
from cncgen.machine import servo_schema
from cncgen.machine.record import Servo
from cncgen.servo import plants
from cncgen.servo.bank import LoopBank
from cncgen.servo.controller import Controller
from cncgen.servo.identification.log import LEAST_ROWS
from cncgen.servo.loop import AxisLoop, close_loop, follow_transfer_function
from cncgen.servo.models import axis_loop

Floats = NDArray[np.float64]

#: Step of numerical derivatives, in logarithms and shares.
STEP = 1e-5
#: Rounding of a simulated position after n steps, in √n units of rounding of the largest position. Roundings of steps add up
#: like a random walk (Higham and Mary 2019, A new approach to probabilistic rounding error analysis, theorem 2.4 with λ = 4).
ROUNDINGS = 4.0
#: Given the drive's input, the plant alone is simulated.
_OPEN = Controller(d_setpoint=1.0)


@dataclass(frozen=True, slots=True)
class FitCovariance:
    """The covariance of fitted parameters, of those of a model alone (not of zeros that differ).

    Attributes:
        parameters: Shape (k,): names.
        logarithm: Shape (k,): whether the logarithm of the parameter is meant.
        matrix: Shape (k, k); infinite where the log does not determine a parameter.
    """

    parameters: tuple[str, ...]
    logarithm: tuple[bool, ...]
    matrix: Floats

    def as_json(self) -> dict[str, object]:
        """Return plain values."""
        return {
            "parameters": list(self.parameters),
            "logarithm": list(self.logarithm),
            "matrix": self.matrix.tolist(),
        }


#: The columns of a log that a fit takes.
_COLUMNS = ("what the axis is given", "the position")


@dataclass(frozen=True, slots=True)
class Fit:
    """A fitted model.

    Attributes:
        model: Name of the model.
        parameters: By name, in the units that the name says.
        uncertainty: Standard deviation of each; infinite where the log does not determine it.
        covariance: Of all together.
        fit_percent: 100 (1 − |y − ŷ|/|y − mean y|), the usual measure.
        residual_rms: mm or rad.
        residual: Shape (n,).
    """

    model: str
    parameters: Mapping[str, float]
    uncertainty: Mapping[str, float]
    covariance: FitCovariance
    fit_percent: float
    residual_rms: float
    residual: Floats


def checked_log(given: Floats, position: Floats, period_s: float) -> tuple[Floats, Floats]:
    """Return two columns of a log as doubles, shape (n,).

    Raises:
        ValueError: The columns differ in length, hold numbers that are not finite, have fewer rows than a fit has unknowns, or one of
            them does not change; or the period is not positive.
    """
    columns = np.asarray(given, np.float64), np.asarray(position, np.float64)
    if any(column.ndim != 1 for column in columns) or len(columns[0]) != len(columns[1]):
        shapes = " and ".join(str(column.shape) for column in columns)
        raise ValueError(f"drive input and position have shapes {shapes}; both must be of one shape (n,)")
    if len(columns[0]) < LEAST_ROWS:
        raise ValueError(f"the log has {len(columns[0])} rows; {LEAST_ROWS} are needed")
    for column, what in zip(columns, _COLUMNS, strict=True):
        if not np.isfinite(column).all():
            raise ValueError(f"{what} is not finite in row {int(np.argmin(np.isfinite(column)))}")
    if not (is_number(period_s) and period_s > 0.0):
        raise ValueError(f"the period is {period_s!r}; it is to be a number of seconds above 0")
    for column, what in zip(columns, _COLUMNS, strict=True):
        if not np.ptp(column) > 0.0:
            raise ValueError(f"{what} does not change")
    return columns


def fit_velocity_loop(drive: Floats, position: Floats, period_s: float, *, friction: bool = True) -> Fit:
    """Fit gain/(s(τs + 1)) with Coulomb friction from drive input to position.

    That is the torque-mode motor of Yeh and Sun 2008 (u in V, gain = Kc Ke/counts_per_mm) and the velocity loop of Hsu 1999
    (u in mm/s, gain 1). Viscous friction is in τ and gain. An offset of the drive's input and of the position are
    fitted beside. The axis is at rest when the log begins.

    Args:
        drive, position: Shape (n,).
        period_s: s; the drive's input is held between samples.
        friction: Whether Coulomb friction is fitted.

    Raises:
        ValueError: `checked_log` refuses them, or no fit is found.
    """
    drive, position = checked_log(drive, position, period_s)

    def simulated(gain: float, lag: float, coulomb: float, bias: float) -> Floats:
        plant = plants.velocity_loop(gain, lag).with_imperfections(coulomb=coulomb)
        return _open_response(close_loop(plant, _OPEN, period_s), drive + bias)

    def unit(given: Floats, lag: float) -> Floats:
        return _open_response(close_loop(plants.velocity_loop(1.0, lag), _OPEN, period_s), given)

    gain, lag, bias, offset = _start(unit, drive, position, period_s)
    typical = float(np.abs(drive).mean())

    def residual(theta: Floats) -> Floats:
        coulomb = abs(theta[4]) * typical if len(theta) > 4 else 0.0
        gain, lag = _exponential(theta[:2])
        values = simulated(gain, lag, coulomb, theta[2] * typical)
        return values + theta[3] - position

    scale = {"bias": typical, "coulomb": typical}
    names = ["gain", "time_constant_s", "bias", "offset"]
    found = _solved(residual, np.array([np.log(gain), np.log(lag), bias / typical, offset]), position)
    if friction:
        # From the smooth problem's solution, and from more friction than that can show: the better end counts.
        names.append("coulomb")
        starts = [np.append(found[0], 0.01), np.append(found[0], 0.3)]
        found = min((_solved(residual, start, position) for start in starts), key=lambda one: _square(one[2]))
    values, errors, together = _unfold(names, found[0], found[1], scale)
    if friction:
        values["coulomb"] = abs(values["coulomb"])
    return _fit("velocity-loop", values, errors, together, found[2], position)


def fit_first_order(command: Floats, position: Floats, period_s: float, *, friction: bool = True) -> Fit:
    """Fit P control (Kv) round a velocity loop (τ), with the lag that friction costs, from command to position.

    The control period is the log's. An offset of the position (zeros that differ) is fitted beside. The axis is at rest
    when the log begins.

    Args:
        command, position: Shape (n,), mm or rad.
        period_s: Between rows.
        friction: Whether ``coulomb_lag_mm`` is fitted (rad of a rotary axis).

    Raises:
        ValueError: `checked_log` refuses them.
    """
    command, position = checked_log(command, position, period_s)
    size = _typical(command - command[0])

    def simulated(theta: Floats) -> Floats:
        gain, lag = _exponential(theta[:2])
        values = {"position_gain_1_s": gain, "time_constant_s": lag}
        if len(theta) > 3:
            values["coulomb_lag_mm"] = abs(theta[3])
        return _follow(axis_loop(Servo("first-order", values), "X", period_s), command) + theta[2] * size

    start = float(position[0] - command[0]) / size
    grid = [
        np.array([np.log(k), np.log(share / k), start])
        for k in (10.0, 30.0, 90.0, 270.0)
        for share in (0.03, 0.2)
    ]
    theta, spread, rest = _best(simulated, grid, position)
    names = ["position_gain_1_s", "time_constant_s", "offset"]
    if friction:
        names.append("coulomb_lag_mm")
        lag = float(np.abs(command + theta[2] * size - position).mean())
        theta, spread, rest = _best(
            simulated, [np.append(theta, 0.02 * lag), np.append(theta, 0.3 * lag)], position
        )
    values, errors, together = _unfold(names, theta, spread, {"offset": size})
    if friction:
        values["coulomb_lag_mm"] = abs(values["coulomb_lag_mm"])
    return _fit("first-order", values, errors, together, rest, position)


#: Coefficients of the fourth-order loop (Tsai 2010, eq. 9, with b0 = a0), in the order they are fitted.
COEFFICIENTS = ("a3", "a2", "a1", "a0", "b2", "b1")


def fit_fourth_order(command: Floats, position: Floats, period_s: float) -> Fit:
    """Fit (b2 s² + b1 s + a0)/(s⁴ + a3 s³ + a2 s² + a1 s + a0) from command to position: Tsai 2010, eq. 9.

    An offset of the position is fitted beside. The six coefficients are what a log of the closed loop determines;
    several sets of gains of appendix A-1 give the same ones.

    Args:
        command, position: Shape (n,), mm or rad.
        period_s: Between rows; between them the command goes straight.

    Raises:
        ValueError: `checked_log` refuses them.
    """
    command, position = checked_log(command, position, period_s)
    size = _typical(command - command[0])
    start = float(position[0] - command[0]) / size

    def simulated(theta: Floats) -> Floats:
        a3, a2, a1, a0, b2, b1 = _exponential(theta[:6])
        loop = follow_transfer_function(np.array([b2, b1, a0]), np.array([1.0, a3, a2, a1, a0]), period_s)
        return _follow(loop, command) + theta[6] * size

    theta, spread, rest = _best(simulated, [np.append(one, start) for one in _cascades()], position)
    values, errors, together = _unfold([*COEFFICIENTS, "offset"], theta, spread, {"offset": size}, logs=6)
    return _fit("fourth-order", values, errors, together, rest, position)


def _cascades() -> Iterator[Floats]:
    """Yield logarithms of the coefficients of typical loops, slow to fast."""
    for size in (50.0, 150.0, 400.0, 1000.0):
        for forward in (0.5, 0.95):
            values = {
                "velocity_pole_1_s": 0.1 * size,
                "velocity_gain_1_s": size,
                "integral_rate_1_s": 0.4 * size,
                "position_gain_1_s": 0.35 * size,
                "feedforward_filter_rad_s": 0.9 * size,
                "feedforward_gain": forward,
            }
            loop = servo_schema.closed_loop(Servo("pi-p-feedforward", values))
            yield np.log([*loop.denominator[1:], *loop.numerator[:2]])


def _best(
    simulated: Callable[[Floats], Floats], grid: list[Floats], position: Floats
) -> tuple[Floats, Floats, Floats]:
    """Solve from the two best starts of a grid, and take the better end."""

    def residual(theta: Floats) -> Floats:
        return simulated(theta) - position

    ranked = sorted(grid, key=lambda theta: _square(residual(theta)))
    return min(
        (_solved(residual, start, position) for start in ranked[:2]), key=lambda found: _square(found[2])
    )


def _exponential(logarithms: Floats) -> Floats:
    """Return e to the logarithms of parameters, within what a model can hold: a search may ask for anything."""
    return np.exp(np.clip(logarithms, -100.0, 100.0))


def _typical(values: Floats) -> float:
    """Return the size of a signal."""
    return float(np.abs(values).mean())


def _square(values: Floats) -> float:
    total = float(values @ values)
    return total if np.isfinite(total) else np.inf


def _start(
    unit: Callable[[Floats, float], Floats], drive: Floats, position: Floats, period_s: float
) -> Floats:
    """Return (gain, τ, bias, offset) of the smooth problem: for a given τ the other three are linear least squares.

    `unit` gives the position, shape (n,), under a drive input, shape (n,), of a motor of gain 1 and a lag, s.
    """
    from scipy.optimize import minimize_scalar

    def projected(log_lag: float) -> tuple[float, Floats]:
        lag = float(np.exp(log_lag))
        basis = np.column_stack([unit(drive, lag), unit(np.ones_like(drive), lag), np.ones_like(drive)])
        solution, *_ = np.linalg.lstsq(basis / (norms := np.linalg.norm(basis, axis=0)), position, rcond=None)
        solution /= norms
        return (_square(basis @ solution - position) if solution[0] > 0.0 else np.inf), solution

    grid = np.log(period_s) + np.log(2.0) * np.arange(-1.0, 13.0)
    squares = [projected(log_lag)[0] for log_lag in grid]
    best = int(np.argmin(squares))
    if not np.isfinite(squares[best]):
        raise ValueError("the position does not follow the drive's input: no gain is positive")
    bounds = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
    # The search subtracts values from each other: a lag of no positive gain counts as the worst that has one.
    worst = max(square for square in squares if np.isfinite(square))
    log_lag = float(minimize_scalar(lambda x: min(projected(x)[0], worst), bounds=bounds, method="bounded").x)
    if not np.isfinite(projected(log_lag)[0]):
        log_lag = float(grid[best])
    gain, push, offset = projected(log_lag)[1]
    return np.array([gain, np.exp(log_lag), push / gain, offset])


def _solved(
    residual: Callable[[Floats], Floats], start: Floats, position: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return θ, shape (k,), its covariance, (k, k), and the residual, (n,), of the least-squares solution from a start.

    The covariance is that of the linearised problem, σ² (Jᵀ J)⁻¹ with σ² = |r|²/(n − k); see `_inverse`. The residual is
    the simulated position less the logged one, `position`, shape (n,).
    """
    from scipy.optimize import least_squares

    def bounded(theta: Floats) -> Floats:
        with np.errstate(over="ignore", invalid="ignore"):
            return np.clip(np.nan_to_num(residual(theta), nan=1e9), -1e9, 1e9)

    def jacobian(theta: Floats, least: float = -np.inf) -> Floats:
        # Absolute steps: logarithms and shares of typical values are all of size one, and some of them are zero.
        columns = []
        for i in range(len(theta)):
            step, back = np.zeros(len(theta)), np.zeros(len(theta))
            # Friction enters by its size: about 0 the central difference of it vanishes, that away from 0 does not.
            step[i] = -STEP if -least <= theta[i] < 0.0 else STEP
            back[i] = 0.0 if abs(theta[i]) <= least else STEP
            columns.append((bounded(theta + step) - bounded(theta - back)) / (step[i] + back[i]))
        return np.column_stack(columns)

    found = least_squares(bounded, start, jac=jacobian, x_scale="jac", method="lm", max_nfev=100)
    rest = found.fun
    variance = float(rest @ rest) / max(1, len(rest) - len(start))
    rounding = ROUNDINGS * np.sqrt(len(rest)) * np.finfo(float).eps * np.abs(position).max(initial=0.0) / STEP
    return found.x, _inverse(jacobian(found.x, STEP), float(rounding)) * variance, rest


def _inverse(jacobian: Floats, rounding: float) -> Floats:
    """Return (Jᵀ J)⁻¹, shape (k, k), of J, (n, k), with an infinite variance for each θ that the log does not determine.

    That is a θ with a part in a direction along which nothing changes but by rounding: of the pseudoinverse, which leaves
    such directions out, it would have a small one. docs/identification.md derives both limits.

    Args:
        jacobian: Shape (n, k).
        rounding: Of each of its elements, in its unit.
    """
    size = np.linalg.norm(jacobian, axis=0)
    size[size == 0.0] = 1.0
    _, values, rows = np.linalg.svd(jacobian / size, full_matrices=False)
    moved = rounding * np.sqrt(len(jacobian)) * np.linalg.norm(1.0 / size)
    lost = values <= moved
    kept = rows[~lost] / values[~lost, None]
    inverse: Floats = kept.T @ kept / np.outer(size, size)
    vague = (np.abs(rows[lost]) > np.sqrt(moved)).any(axis=0)
    inverse[vague, vague] = np.inf
    return inverse


#: Fitted beside a model: offsets of the drive's input and of the position.
_ZEROS = ("bias", "offset")


def _unfold(
    names: list[str], theta: Floats, covariance: Floats, scale: Mapping[str, float], logs: int = 2
) -> tuple[dict[str, float], dict[str, float], FitCovariance]:
    """Return values and standard deviations by name, and the covariance; the first `logs` entries of θ are logarithms."""
    spread = np.sqrt(np.diag(covariance))
    values, errors = {}, {}
    for i, name in enumerate(names):
        size = scale.get(name, 1.0)
        values[name] = float(_exponential(theta[i : i + 1])[0] if i < logs else theta[i] * size)
        errors[name] = float(values[name] * spread[i] if i < logs else spread[i] * size)
    kept = [i for i, name in enumerate(names) if name not in _ZEROS]
    sizes = np.array([1.0 if i < logs else scale.get(names[i], 1.0) for i in kept])
    matrix = covariance[np.ix_(kept, kept)] * np.outer(sizes, sizes)
    together = FitCovariance(tuple(names[i] for i in kept), tuple(i < logs for i in kept), matrix)
    return values, errors, together


def _fit(
    model: str,
    values: dict[str, float],
    errors: dict[str, float],
    together: FitCovariance,
    residual: Floats,
    position: Floats,
) -> Fit:
    if not np.isfinite([*values.values(), *residual]).all():
        raise ValueError("no fit is found: the search ends at numbers that are not finite")
    around = position - position.mean()
    share = np.sqrt(_square(residual) / max(_square(around), 1e-300))
    return Fit(
        model,
        values,
        errors,
        together,
        100.0 * (1.0 - float(share)),
        float(np.sqrt(np.mean(residual**2))),
        residual,
    )


def _open_response(loop: AxisLoop, drive: Floats) -> Floats:
    rows = np.append(drive, drive[-1])[:, None]
    return LoopBank([loop], loop.period).run(rows)[0][:, 0]


def _follow(loop: AxisLoop, command: Floats) -> Floats:
    rows = np.append(command, command[-1])[:, None] - command[0]
    return LoopBank([loop], loop.period).run(rows)[0][:, 0] + command[0]

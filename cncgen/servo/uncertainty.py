"""Servo axes whose parameters are not known exactly: draws of them, and quantiles of their results.

Draws are quasi-random (Sobol's sequence, scrambled: A. B. Owen, Journal of Complexity 14 (1998) 466), so that few of them show
the spread. Each number of a servo table is drawn evenly within a share of its value; periods, encoder counts and the
weights of a design stay. The parameters of an axis that was identified are drawn as its log leaves them open, normal with the
covariance of the fit, and the rest of that axis stays. A controller that was designed on a model keeps the model (`Servo.knows`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.interrupts import held
from cncgen.machine.record import Servo
from cncgen.machine.servo_parameters import MODELS, Parameter
from cncgen.servo.identified_spread import SERVO_MODELS, IdentifiedSpread

Floats = NDArray[np.float64]

#: Machines that are drawn for intervals. Of others 90 ± 3 % are in an interval of 90 % (`share_error`, `trials/interval_coverage`).
DRAWS = 512
#: Machines that are drawn to find a worst one, or to say in short how robust something is.
FEW_DRAWS = 64

#: Keys that are known exactly: periods, the encoder's resolution, and the weights of a design.
EXACT = frozenset(
    [
        "control_period_s",
        "sample_time_s",
        "noise_seed",
        "encoder_resolution_{l}",
        "counts_per_rad",
        "counts_per_{l}",
        "sensitivity_bandwidth_rad_s",
        "sensitivity_peak",
        "sensitivity_offset",
        "robustness_crossover_rad_s",
        "control_weight",
        "roll_off_rad_s",
        "frequency_uncertainty",
        "gain_uncertainty",
        "complementary_peak",
    ]
)
#: Keys of the plant that the controller of a model was designed with.
_DESIGNED_ON = {"pd-plus": ("time_constant_s", "velocity_gain_rad_s_volt")}


@dataclass(frozen=True, slots=True)
class Perturbation:
    """How uncertain parameters are.

    Attributes:
        share: Each is within this share of its value, evenly distributed.
        draws: How many machines are drawn; powers of 2 are spread best.
        seed: Of the draws.
        identified: Distributions of axes' parameters from identifications, instead of the share.
    """

    share: float = 0.1
    draws: int = DRAWS
    seed: int = 0
    identified: tuple[IdentifiedSpread, ...] = ()

    def __str__(self) -> str:
        found = ", ".join(spread.letter for spread in self.identified)
        parts = [f"every parameter within {100 * self.share:g} %"] if self.share or not found else []
        parts += [f"parameters of {found} within the covariance of their fit"] if found else []
        return " and ".join(parts)


def perturbed(
    servos: Mapping[str, Servo], axes: str, perturbation: Perturbation
) -> Iterator[dict[str, Servo]]:
    """Yield servos of the axes with drawn parameters, as many as the perturbation asks for.

    Args:
        servos: Nominal servo data by axis.
        axes: Which of them.
        perturbation: How uncertain they are.

    Raises:
        UsageError: An axis was identified by another model than that of its servo data (``perturb-model``).
    """
    found = {spread.letter: spread for spread in perturbation.identified}
    for letter in axes:
        _check_model(servos[letter], found.get(letter))
    sizes = [
        len(found[letter].names) if letter in found else len(_entries(servos[letter])) for letter in axes
    ]
    points = sobol(sum(sizes), perturbation.draws, perturbation.seed)
    for point in points:
        parts = zip(axes, np.split(point, np.cumsum(sizes)[:-1]), strict=True)
        yield {
            letter: _possible(servos[letter], found[letter], part)
            if letter in found
            else _drawn(servos[letter], 1.0 + perturbation.share * (2.0 * part - 1.0))
            for letter, part in parts
        }


def _check_model(servo: Servo, spread: IdentifiedSpread | None) -> None:
    if spread is None or SERVO_MODELS[spread.model] == servo.model:
        return
    message = (
        f"axis {spread.letter} was identified as {spread.model}, which is the servo model "
        f"{SERVO_MODELS[spread.model]}; the machine has {servo.model}"
    )
    hint = (
        "put the table that cncgen identify wrote into the machine file, or leave the axis out of --perturb"
    )
    raise UsageError(Diagnostic("perturb-model", message, hint=hint))


def _possible(servo: Servo, spread: IdentifiedSpread, point: Floats) -> Servo:
    """Return a servo with parameters that the log of an identification leaves possible."""
    table = spread.table(spread.values(point.tolist()), {"model": servo.model, **servo.parameters})
    model = table.pop("model")
    return _with(servo, model, table)


def sobol(dimensions: int, draws: int, seed: int) -> Floats:
    """Return the first points of a scrambled Sobol sequence, shape (draws, dimensions), in the unit cube."""
    from scipy.stats import qmc

    if not dimensions:
        return np.zeros((draws, 0))
    with held():  # scipy reads a table where an exception would be printed and dropped
        sampler = qmc.Sobol(dimensions, scramble=True, seed=seed)
    points = sampler.random_base2(max(int(draws - 1).bit_length(), 0))
    return np.asarray(points[:draws], np.float64)


def _entries(servo: Servo) -> list[tuple[str, int | None]]:
    """Return key, and index within a list, of each number that is drawn."""
    found: list[tuple[str, int | None]] = []
    sampled = servo.parameters.get("sample_time_s") is not None
    for parameter in MODELS[servo.model].parameters:
        key = _key(parameter, servo)
        if key is None or parameter.name in EXACT:
            continue
        value = servo.parameters[key]
        if parameter.kind == "number" and value:
            found.append((key, None))
        elif parameter.kind == "numbers":
            if not sampled:
                found += [(key, i) for i, entry in enumerate(value) if entry]
            elif parameter.name == "numerator" and servo.model == "plant":
                found.append((key, None))
    return found


def _key(parameter: Parameter, servo: Servo) -> str | None:
    """Return the key under which a servo has a parameter, in mm or degrees, or None."""
    return next((k for k in (parameter.key("X"), parameter.key("A")) if k in servo.parameters), None)


def _drawn(servo: Servo, factors: Floats) -> Servo:
    values: dict[str, Any] = dict(servo.parameters)
    for (key, index), factor in zip(_entries(servo), factors.tolist(), strict=True):
        if index is None:
            value = values[key]
            values[key] = [v * factor for v in value] if isinstance(value, (list, tuple)) else value * factor
        else:
            values[key] = [v * factor if i == index else v for i, v in enumerate(values[key])]
    if servo.model == "transfer-function":
        values["numerator"] = _same_at_rest(values, servo)
    return _with(servo, servo.model, values)


def _with(servo: Servo, model: str, values: Mapping[str, Any]) -> Servo:
    """Return a servo with other parameters, whose controller keeps its design data."""
    known = {key: servo.parameters[key] for key in _DESIGNED_ON.get(model, ())}
    knows = Servo(model, {**values, **known}) if known else None
    if values.get("controller") == "h-infinity":
        knows = servo
    return replace(servo, parameters=values, knows=knows)


def _same_at_rest(values: Mapping[str, Any], servo: Servo) -> list[float]:
    """Return the numerator of a closed loop in s scaled so that it comes to rest where the nominal one does."""
    above, below = values["numerator"][-1], values["denominator"][-1]
    if not (above and below) or values.get("sample_time_s") is not None:
        return list(values["numerator"])
    nominal = servo.parameters["numerator"][-1] / servo.parameters["denominator"][-1]
    return [v * nominal * below / above for v in values["numerator"]]


def quantile(values: Floats | Sequence[float], share: float) -> float:
    """Return a quantile of draws, at (k − 1/2)/n for the k-th smallest (Hazen), so that intervals are not too narrow.

    Values may be infinite, of unstable machines; a quantile between two of them is not a number, which numpy would warn of.
    """
    with np.errstate(invalid="ignore"):
        return float(np.quantile(np.asarray(values, float), share, method="hazen"))


def share_error(share: float, draws: int) -> float:
    """Return how far the share of all machines within quantiles of draws may be off, two standard deviations.

    That of independent draws: their share is distributed as Beta(share · (n + 1), (1 − share) · (n + 1)) (H. A. David and
    H. N. Nagaraja, Order statistics, 2003, section 7.2), which has the variance share (1 − share)/(n + 2). Quasi-random draws
    are spread better.
    """
    return 2.0 * float(np.sqrt(share * (1.0 - share) / (draws + 2)))

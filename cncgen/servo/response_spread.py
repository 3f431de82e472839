"""Figures of a simulation on machines whose parameters are not quite the model's."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import UsageError
from cncgen.machine.kinematics import Kinematics
from cncgen.machine.record import Servo
from cncgen.servo.named_schemes import Settings, scheme_maker
from cncgen.servo.record import Response
from cncgen.servo.scheme import Scheme
from cncgen.servo.simulate import simulate_scheme
from cncgen.servo.summary import summarize
from cncgen.servo.uncertainty import Perturbation, perturbed, quantile, share_error
from cncgen.setpoints.record import Setpoints

Floats = NDArray[np.float64]
Figures = Mapping[str, float]

#: The interval that is shown holds this share of the machines.
INTERVAL = 0.9


def drawn_figures(
    setpoints: Sequence[Setpoints],
    servos: Mapping[str, Servo],
    perturbation: Perturbation,
    *,
    controller: str = "p",
    settings: Settings | None = None,
    settle_s: float = 0.0,
    judge: Callable[[Sequence[Response]], Figures] | None = None,
    kinematics: Kinematics | None = None,
) -> dict[str, Floats]:
    """Return figures of drawn machines by name, shape (draws,) each; inf where the machine is unstable.

    Shapers of the setpoints and couplings of the axes are designed on the nominal machine.

    Args:
        setpoints: The motion.
        servos: Nominal servo data by axis.
        perturbation: How uncertain they are.
        controller, settings, settle_s, kinematics: As of `cncgen.simulate`.
        judge: From a response to figures; None: `figures_of_response`.

    Raises:
        UsageError: The nominal machine cannot be simulated.
    """
    head = setpoints[0]
    nominal = scheme_maker(controller, servos, settings)(head.axes, head.period_s)
    found: list[Figures | None] = []
    for drawn in perturbed(servos, head.axes, perturbation):
        try:
            scheme = _with_loops(nominal, scheme_maker(controller, drawn, settings)(head.axes, head.period_s))
            responses = list(
                simulate_scheme(iter(setpoints), scheme, settle_s=settle_s, kinematics=kinematics)
            )
            found.append((judge or figures_of_response)(responses))
        except UsageError:
            found.append(None)
    names = next((list(one) for one in found if one is not None), [])
    return {name: np.array([np.inf if one is None else one[name] for one in found]) for name in names}


def _with_loops(nominal: Scheme, drawn: Scheme) -> Scheme:
    return replace(nominal, loops=drawn.loops)


def figures_of_response(responses: Iterable[Response]) -> dict[str, float]:
    """Return the errors of a response by the names of its summary, with ``_x`` and so on for those of an axis."""
    summary = summarize(responses)
    found = {
        key: summary[key]
        for key in ("contour_error_rms_mm", "contour_error_max_mm")
        if summary[key] is not None
    }
    for letter, axis in summary["axes"].items():
        found |= {
            f"{key}_{letter}": value
            for key, value in axis.items()
            if key.startswith("tracking_") and "_t_s" not in key
        }
    return found


def spread_values(found: Mapping[str, Floats], perturbation: Perturbation) -> dict[str, Any]:
    """Return interval, median and worst of each figure as plain values; None where that machine is unstable."""
    unstable = max((int(np.isinf(values).sum()) for values in found.values()), default=perturbation.draws)
    result: dict[str, Any] = {
        "share": perturbation.share,
        "identified": [spread.letter for spread in perturbation.identified],
        "of": str(perturbation),
        "draws": perturbation.draws,
        "interval_share": INTERVAL,
        "interval_share_error": share_error(INTERVAL, perturbation.draws),
        "unstable": unstable,
    }
    for name, values in found.items():
        low, high = interval(values)
        figures = {"low": low, "median": quantile(values, 0.5), "high": high, "worst": float(values.max())}
        result[name] = {key: value if np.isfinite(value) else None for key, value in figures.items()}
    return result


def interval(values: Floats) -> tuple[float, float]:
    """Return the interval that holds 90 % of the machines, as much left out on either side."""
    beyond = 0.5 * (1.0 - INTERVAL)
    return quantile(values, beyond), quantile(values, 1.0 - beyond)

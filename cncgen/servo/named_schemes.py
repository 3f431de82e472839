"""Control schemes by name, for the axes of a machine; ``compare --controllers`` compares them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.machine.record import Servo
from cncgen.machine.settings_schema import check
from cncgen.servo.controller import Controller
from cncgen.servo.controllers.ccc import CrossCoupling, coupling_of, fitted
from cncgen.servo.controllers.feedforward import Feedforward, velocity_error
from cncgen.servo.controllers.mirror_filter import MirrorFilter
from cncgen.servo.controllers.tcf import task_frame
from cncgen.servo.controllers.zpetc import Zpetc, design
from cncgen.servo.loop import AxisLoop, close_loop
from cncgen.servo.models import control_period, plant_and_controller
from cncgen.servo.scheme import PathCoupling, Prefilter, Scheme, SchemeMaker
from cncgen.servo.simulate import own_scheme
from cncgen.units import is_rotary

#: The names: each axis's own controller (``p``), that without its feedforward, with full velocity feedforward round it, the
#: schemes of Hsu 1999, Table 1, reference shaping by the loop's mirror, and H-infinity designed from a table's weights.
NAMES = ("p", "plain", "feedforward", "zpetc", "ccc", "zpetc+ccc", "tcf", "mirror", "h-infinity")


@dataclass(frozen=True, slots=True)
class Settings:
    """Gains of the schemes; `settings_of` reads them from the ``[coupling]`` table of a machine file.

    Attributes:
        ccc_proportional, ccc_integral_1_s: Multiples of the axes' own gain, the second in 1/s. None: 8 and 100, lowered
            together where the contour loop would come too near to instability (`ccc.fitted`).
        tcf_tangential_rad_s, tcf_tangential_damping: Natural frequency and damping of the error along the path.
        tcf_normal_rad_s, tcf_normal_damping: The same across it. The defaults are poles at 250 and 350 rad/s.
        models: Servo data that ZPETC and the mirror are designed on, where they are not the axes' own (what a model error does).
    """

    ccc_proportional: float | None = None
    ccc_integral_1_s: float | None = None
    tcf_tangential_rad_s: float = math.sqrt(250.0 * 350.0)
    tcf_tangential_damping: float = 300.0 / math.sqrt(250.0 * 350.0)
    tcf_normal_rad_s: float = math.sqrt(250.0 * 350.0)
    tcf_normal_damping: float = 300.0 / math.sqrt(250.0 * 350.0)
    models: Mapping[str, Servo] | None = None

    def as_table(self, controller: str) -> dict[str, float]:
        """Return the keys of ``[coupling]`` that a scheme uses."""
        group = "tcf" if controller == "tcf" else "ccc" if "ccc" in controller else "none"
        return {
            k: getattr(self, k) for k in COUPLING_KEYS if k.startswith(group) and getattr(self, k) is not None
        }


#: Keys of the ``[coupling]`` table.
COUPLING_KEYS = tuple(f.name for f in fields(Settings) if f.name != "models")


def settings_of(table: Mapping[str, Any]) -> Settings:
    """Return the settings of a ``[coupling]`` table.

    Raises:
        UsageError: With a diagnostic for each key that is unknown (``machine-key``) or no positive number
            (``machine-value``; an integral gain may be 0).
    """
    check("coupling", table)
    return replace(Settings(), **dict[str, Any]({key: float(value) for key, value in table.items()}))


def scheme_maker(name: str, servos: Mapping[str, Servo], settings: Settings | None = None) -> SchemeMaker:
    """Return the constructor of a named scheme for axes and a setpoint period.

    Raises:
        UsageError: The name is unknown (``controller-unknown``); later, where the scheme cannot be had for the axes
            (``controller-unfit``).
    """
    if name not in NAMES:
        raise UsageError(
            Diagnostic(
                "controller-unknown", f"no controller is called {name!r}; there are {', '.join(NAMES)}"
            )
        )
    chosen = settings or Settings()

    def make(axes: str, period_s: float) -> Scheme:
        try:
            if name == "h-infinity":
                return own_scheme(
                    h_infinity_servos({k: servos[k] for k in axes if k in servos}), axes, period_s
                )
            if name == "plain":
                return own_scheme(plain_servos(servos), axes, period_s)
            if name == "tcf":
                return _task_frame(servos, axes, period_s, chosen)
            return _coupled(name, servos, axes, period_s, chosen)
        except ValueError as error:
            raise UsageError(Diagnostic("controller-unfit", f"{name}: {error}")) from error

    return make


def plain_servos(servos: Mapping[str, Servo]) -> dict[str, Servo]:
    """Return servos without the feedforward of their controllers, where they have one: PD instead of PD+, say."""
    without: dict[str, dict[str, Any]] = {
        "pi-p-feedforward": {"feedforward_gain": 0.0},
        "pd-plus": {"feedforward": False},
    }
    return {k: Servo(s.model, {**s.parameters, **without.get(s.model, {})}) for k, s in servos.items()}


def h_infinity_servos(servos: Mapping[str, Servo]) -> dict[str, Servo]:
    """Return servos with the H-infinity controller of their weights in the place of their own.

    Raises:
        ValueError: A servo is not of the model ``plant``, or its table has no weights.
    """
    for letter, servo in servos.items():
        if servo.model != "plant":
            raise ValueError(f"axis {letter}: it is designed for the model plant, not {servo.model}")
        if "sensitivity_bandwidth_rad_s" not in servo.parameters:
            raise ValueError(
                f"axis {letter}: its table has no weights (sensitivity_bandwidth_rad_s and the rest)"
            )
    return {k: Servo(s.model, {**s.parameters, "controller": "h-infinity"}) for k, s in servos.items()}


def _coupled(name: str, servos: Mapping[str, Servo], axes: str, period_s: float, chosen: Settings) -> Scheme:
    own = own_scheme(servos, axes, period_s)
    prefilter: Prefilter | None = None
    coupling: PathCoupling | None = None
    if name == "feedforward":
        prefilter = Feedforward([velocity_error(loop, round(period_s / loop.period)) for loop in own.loops])
    if name == "mirror":
        prefilter = MirrorFilter(own_scheme({**servos, **(chosen.models or {})}, axes, period_s).loops)
    if "zpetc" in name:
        modelled = own_scheme({**servos, **(chosen.models or {})}, axes, period_s)
        prefilter = Zpetc([design(loop, round(period_s / loop.period)) for loop in modelled.loops])
    if "ccc" in name:
        coupling = cross_coupling(own.loops, axes, chosen)
    return Scheme(own.loops, prefilter, coupling)


def cross_coupling(loops: Sequence[AxisLoop], axes: str, chosen: Settings) -> CrossCoupling:
    """Return the coupling of a scheme: as the settings say, or fitted to the axes where they leave it open.

    Raises:
        ValueError: The axes cannot be coupled.
    """
    _check_coupled(axes, {loop.period for loop in loops})
    if any(not loop.inputs[:, 0, 2].any() for loop in loops):
        raise ValueError("it acts on the drives, and a closed loop given as a whole has none")
    if chosen.ccc_proportional is None or chosen.ccc_integral_1_s is None:
        return fitted(loops)
    return coupling_of(loops, chosen.ccc_proportional, chosen.ccc_integral_1_s)


def _check_coupled(axes: str, periods: set[float]) -> None:
    if len(periods) > 1:
        said = " and ".join(f"{period:g} s" for period in sorted(periods))
        raise ValueError(f"it couples axes of one control period, and theirs are {said} (control_period_s)")
    if len(axes) not in (2, 3) or any(is_rotary(letter) for letter in axes):
        raise ValueError(f"it couples two or three linear axes, not {', '.join(axes)}")


def _task_frame(servos: Mapping[str, Servo], axes: str, period_s: float, chosen: Settings) -> Scheme:
    own_scheme(servos, axes, period_s)
    periods = {control_period(servos[letter], letter, period_s) for letter in axes}
    _check_coupled(axes, periods)
    period = periods.pop()
    plants = [plant_and_controller(servos[letter], letter, period)[0] for letter in axes]
    frame = task_frame(
        plants,
        (chosen.tcf_tangential_rad_s, chosen.tcf_tangential_damping),
        (chosen.tcf_normal_rad_s, chosen.tcf_normal_damping),
    )
    return Scheme(tuple(close_loop(plant, Controller(), period) for plant in plants), None, frame)

"""Control schemes by name, for the axes of a machine: what ``compare --controllers`` sets side by side."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.machine.record import Servo
from cncgen.servo.controllers.base import Controller
from cncgen.servo.controllers.ccc import fitted
from cncgen.servo.controllers.tcf import task_frame
from cncgen.servo.controllers.zpetc import Zpetc, design
from cncgen.servo.loop import close_loop
from cncgen.servo.models import control_period, plant_and_controller
from cncgen.servo.scheme import Scheme, SchemeMaker
from cncgen.servo.simulate import own_scheme

#: The names, in the order of Hsu 1999, Table 1. ``p`` stands for the axis's own controller, whatever it is.
NAMES = ("p", "zpetc", "ccc", "zpetc+ccc", "tcf")


@dataclass(frozen=True, slots=True)
class Settings:
    """Gains of the schemes.

    Attributes:
        ccc_proportional, ccc_integral: Multiples of the axes' own gain (the second in 1/s); see `ccc.fitted`.
        tcf_poles: rad/s, of the tangential and the normal error.
        models: Servo data that ZPETC is designed on, where they are not the axes' own (what a model error does).
    """

    ccc_proportional: float = 8.0
    ccc_integral: float = 100.0
    tcf_poles: tuple[float, float] = (250.0, 350.0)
    models: Mapping[str, Servo] | None = None


def scheme_maker(name: str, servos: Mapping[str, Servo], settings: Settings | None = None) -> SchemeMaker:
    """Return what makes the scheme of a name for axes and a setpoint period.

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
            if name == "tcf":
                return _task_frame(servos, axes, period_s, chosen)
            return _coupled(name, servos, axes, period_s, chosen)
        except ValueError as error:
            raise UsageError(Diagnostic("controller-unfit", f"{name}: {error}")) from error

    return make


def _coupled(name: str, servos: Mapping[str, Servo], axes: str, period_s: float, chosen: Settings) -> Scheme:
    own = own_scheme(servos, axes, period_s)
    prefilter = coupling = None
    if "zpetc" in name:
        modelled = own_scheme({**servos, **(chosen.models or {})}, axes, period_s)
        if any(abs(loop.period - period_s) > 1e-12 for loop in modelled.loops if loop.sampled):
            raise ValueError("it is designed at the setpoints' period; set control_period_s to that")
        prefilter = Zpetc([design(loop) for loop in modelled.loops])
    if "ccc" in name:
        if len({loop.period for loop in own.loops}) > 1 or len(axes) not in (2, 3):
            raise ValueError("it couples two or three axes of one control period")
        coupling = fitted(own.loops, chosen.ccc_proportional, chosen.ccc_integral)
    return Scheme(own.loops, prefilter, coupling)


def _task_frame(servos: Mapping[str, Servo], axes: str, period_s: float, chosen: Settings) -> Scheme:
    own_scheme(servos, axes, period_s)
    periods = {control_period(servos[letter], letter, period_s) for letter in axes}
    if len(periods) > 1:
        raise ValueError("it couples axes of one control period")
    period = periods.pop()
    plants = [plant_and_controller(servos[letter], letter, period)[0] for letter in axes]
    loops = tuple(close_loop(plant, Controller(), period) for plant in plants)
    return Scheme(loops, None, task_frame(plants, chosen.tcf_poles))

"""Runs of paper 004 (Hsu): circles of 10 mm, straight from an angle or through NURBS interpolators, under its controllers."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from cncgen.machine import load_servos
from cncgen.machine.record import Servo
from cncgen.papers.planned import planned_text, program_text
from cncgen.planner import PlanOptions
from cncgen.servo.named_schemes import Settings, scheme_maker
from cncgen.servo.simulate import simulate_scheme
from cncgen.servo.summary import path_speed
from cncgen.setpoints.record import Setpoints

Floats = NDArray[np.float64]

MACHINE = "dyna-1007"
PERIOD = 0.001
RADIUS = 10.0
#: Standard deviation of the measured speed that comes from measuring it, µm/s; added in quadrature.
SPEED_FLOOR = 213.0
#: ZPETC is designed on a model whose gain is this share of the axis's.
MODEL_SHARE = 0.97

#: The circle as a NURBS: the quadratic of seven points, which ships, and one of nine points, whose parameter runs more evenly.
SEVEN_POINTS = "circle.nc"
_NINE_POINTS = b"""(START, X10 Y0)
G21 G17 G90 G94 G61
G6.2 P3 K0 X10 Y0 R1 F5000
K0 X10 Y10 R0.70710678118654757
K0 X0 Y10 R1
K0.25 X-10 Y10 R0.70710678118654757
K0.25 X-10 Y0 R1
K0.5 X-10 Y-10 R0.70710678118654757
K0.5 X0 Y-10 R1
K0.75 X10 Y-10 R0.70710678118654757
K0.75 X10 Y0 R1
K1
K1
K1
M30
"""


@dataclass(frozen=True, slots=True)
class Choices:
    """Values that the paper leaves out, inferred from its tables.

    Attributes:
        model_share: Gain of ZPETC's model over the axis's.
        floor_um_s: The part of the speed's standard deviation that measuring adds, µm/s.
        tcf_share: Natural frequency of the task frame over that of the settings.
        ccc_share: Gains of the cross coupling over 8 and 100/s.
        friction: Whether the axes have their Coulomb friction.
        gain_1_s: Position gain of both axes; None: the profile's.
    """

    model_share: float = MODEL_SHARE
    floor_um_s: float = SPEED_FLOOR
    tcf_share: float = 1.0
    ccc_share: float = 1.0
    friction: bool = True
    gain_1_s: float | None = None


def circle(speed_m_min: float, turns: float = 3.0) -> Floats:
    """Return a circle at constant speed after 0.2 s of even acceleration, shape (n, 2), mm."""
    speed, ramp = speed_m_min * 1000.0 / 60.0, 0.2
    t = np.arange(0.0, 2 * math.pi * turns * RADIUS / speed + ramp, PERIOD)
    s = np.where(t < ramp, speed * t**2 / (2 * ramp), speed * (t - ramp / 2))
    return RADIUS * np.column_stack([np.cos(s / RADIUS), np.sin(s / RADIUS)])


@lru_cache(maxsize=16)
def nurbs_circle(
    interpolator: str,
    speed_m_min: float,
    programs: str | None = None,
    turns: int = 3,
    nine_points: bool = False,
) -> Floats:
    """Return the setpoints of turns of the NURBS circle at constant feed, shape (n, 2), mm; they start and end with a step.

    Args:
        interpolator: One of `cncgen.planner.options.INTERPOLATORS`.
        speed_m_min: Feed; for ``uniform``, whose speed is not constant, the mean.
        programs: Folder of the example programs; None: looked for.
        turns: How often round.
        nine_points: The circle of nine control points instead of seven.
    """
    text = _NINE_POINTS if nine_points else program_text(SEVEN_POINTS, programs)
    lines = text.split(b"\n")
    first = next(i for i, line in enumerate(lines) if line.startswith(b"G6.2"))
    last = next(i for i, line in enumerate(lines) if line.startswith(b"M30"))
    text = b"\n".join([*lines[:first], *(turns * lines[first:last]), *lines[last:]])
    text = text.replace(b"F5000", f"F{1000.0 * speed_m_min:.12g}".encode())
    options = PlanOptions(feedrate="constant", interpolator=interpolator)
    return planned_text(text, SEVEN_POINTS, MACHINE, options).signal("position")


def uniform_circle(step: float, programs: str | None = None, nine_points: bool = False) -> Floats:
    """Return the setpoints of the NURBS circle at equal parameter steps a period, shape (n, 2), mm."""
    mean_m_min = 2.0 * math.pi * RADIUS * step / PERIOD * 60.0 / 1000.0
    return nurbs_circle("uniform", mean_m_min, programs, 4, nine_points)


def errors_of(rows: Floats, name: str, choices: Choices | None = None) -> tuple[float, float, float]:
    """Return tracking error, contour error (rms, µm) and standard deviation of the speed (µm/s), from the second turn on."""
    chosen = choices or Choices()
    servos = {k: _changed(servo, chosen) for k, servo in load_servos(MACHINE).items()}
    parts = list(
        simulate_scheme(
            [Setpoints("XY", PERIOD, 0, rows)], scheme_maker(name, servos, _settings(servos, chosen))
        )
    )
    command, position = (np.concatenate([getattr(p, k) for p in parts]) for k in ("command", "position"))
    contour = np.concatenate([p.contour_error_mm for p in parts])
    steady = slice(len(rows) // 3, -50)
    tracking = np.sqrt(((command - position)[steady] ** 2).sum(axis=1).mean())
    speed = path_speed(position[steady], PERIOD).std() * 1e3
    measured = math.hypot(float(speed), chosen.floor_um_s)
    return 1e3 * float(tracking), 1e3 * float(np.sqrt((contour[steady] ** 2).mean())), measured


def _changed(servo: Servo, chosen: Choices) -> Servo:
    """Return an axis with the gain and the friction of the choices."""
    values = dict(servo.parameters)
    if chosen.gain_1_s is not None:
        values["position_gain_1_s"] = chosen.gain_1_s
    if not chosen.friction:
        values["coulomb_lag_mm"] = 0.0
    return Servo(servo.model, values)


def _settings(servos: dict[str, Servo], chosen: Choices) -> Settings:
    """Return the settings of the schemes under the choices."""
    models = {
        k: Servo(
            s.model,
            {**s.parameters, "position_gain_1_s": s.parameters["position_gain_1_s"] * chosen.model_share},
        )
        for k, s in servos.items()
    }
    usual = Settings(models=models)
    settings = replace(
        usual,
        tcf_tangential_rad_s=usual.tcf_tangential_rad_s * chosen.tcf_share,
        tcf_normal_rad_s=usual.tcf_normal_rad_s * chosen.tcf_share,
    )
    if chosen.ccc_share == 1.0:
        return settings
    return replace(
        settings, ccc_proportional=8.0 * chosen.ccc_share, ccc_integral_1_s=100.0 * chosen.ccc_share
    )

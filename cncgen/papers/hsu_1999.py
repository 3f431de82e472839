"""Paper 004 (Hsu): controllers on circles of 10 mm, and NURBS interpolation under them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cncgen.machine import load_servos
from cncgen.papers.hsu_runs import (
    MACHINE,
    PERIOD,
    RADIUS,
    SPEED_FLOOR,
    Choices,
    circle,
    errors_of,
    nurbs_circle,
    uniform_circle,
)
from cncgen.papers.printed import ARITHMETIC, WITHIN, Basis, Row, RowKind, Table, absent, drawing, given
from cncgen.report.drawing import (
    BLUE,
    ORANGE,
    legend,
    line,
    new_figure,
    ticks,
)
from cncgen.servo.named_schemes import scheme_maker
from cncgen.servo.simulate import simulate_scheme
from cncgen.servo.summary import path_speed
from cncgen.setpoints.record import Setpoints

if TYPE_CHECKING:
    from cncgen.report.drawing import Figures

Floats = NDArray[np.float64]
#: Tracking error (µm), contour error (µm) and standard deviation of the speed (µm/s).
Triple = tuple[float, float, float]

#: m/min, as printed.
SPEEDS = ("1.25", "2.5", "5")
LABELS = {"p": "P", "zpetc": "ZPETC+P", "ccc": "CCC+P", "zpetc+ccc": "Integrated", "tcf": "TCF"}
#: Tables 1 and 2: tracking error, contour error (µm) and speed variation (µm/s) at each speed.
PRINTED = {
    "p": (("305.18", "40.54", "225.66"), ("556.46", "70.61", "410.38"), ("1030.44", "132.00", "1103.80")),
    "zpetc": (("40.58", "19.58", "202.56"), ("34.51", "18.39", "271.44"), ("30.97", "22.21", "283.72")),
    "ccc": (("298.26", "2.09", "267.11"), ("543.58", "4.39", "656.50"), ("1006.06", "12.69", "2203.10")),
    "zpetc+ccc": (("35.84", "1.65", "203.01"), ("29.60", "2.45", "300.06"), ("21.08", "3.64", "364.14")),
    "tcf": (("11.56", "6.93", "105.2952"), ("7.99", "6.40", "143.8484"), ("30.14", "10.18", "258.3305")),
}
#: The machine's own control in the same tables: contour error and speed variation.
DYNA = (("7.93", "427.40"), ("11.54", "436.78"), ("21.08", "536.56"))
#: Table 3: equal parameter steps, and constant speed at 5, 2.5 and 1.25 m/min.
UNIFORM = {
    "zpetc+ccc": ("67.64", "4.08", "18583"),
    "tcf": ("91.40", "15.39", "18305"),
    "p": ("1141.06", "152.86", "18688"),
}
CONSTANT = {
    "5": {
        "zpetc+ccc": ("22.66", "3.55", "360.95"),
        "tcf": ("25.64", "12.37", "258.33"),
        "p": ("1018.00", "132.88", "1103.8"),
    },
    "2.5": {
        "zpetc+ccc": ("32.63", "2.38", "270.19"),
        "tcf": ("8.93", "7.56", "143.85"),
        "p": ("552.40", "71.00", "410.38"),
    },
    "1.25": {
        "zpetc+ccc": ("39.37", "1.66", "169.35"),
        "tcf": ("9.97", "6.90", "105.30"),
        "p": ("303.43", "40.78", "225.66"),
    },
}
#: Printed parameter step of uniform interpolation.
STEP = "0.0015"
_QUANTITIES = (("tracking error", "µm"), ("contour error", "µm"), ("speed variation", "µm/s"))
#: Choices that differ in the column of sensitivity, for each controller.
_OTHERS = {
    "p": ("no friction", Choices(friction=False)),
    "zpetc": ("exact model", Choices(model_share=1.0)),
    "ccc": ("half the gains", Choices(ccc_share=0.5)),
    "zpetc+ccc": ("exact model", Choices(model_share=1.0)),
    "tcf": ("half the poles", Choices(tcf_share=0.5)),
}


def tables(programs: str | None = None) -> list[Table]:
    """Return Tables 1 to 3, the numbers of the text, and the figures."""
    ours = {name: [errors_of(circle(float(speed)), name) for speed in SPEEDS] for name in PRINTED}
    others = {
        name: [errors_of(circle(float(speed)), name, _OTHERS[name][1]) for speed in SPEEDS] for name in PRINTED
    }  # fmt: skip
    uniform = {name: errors_of(uniform_circle(float(STEP), programs), name) for name in UNIFORM}
    return [
        _given(),
        _table_1(ours, others),
        _table_2(ours),
        _uniform(uniform, programs),
        _constant(programs),
        _conclusions(ours, uniform, programs),
        _schemes(),
    ]


def _given() -> Table:
    """The numbers of section 6 that are taken over, what follows from them, and the bandwidth, which cannot be."""
    rows = [
        given("sampling period", "1msec", 1e3 * PERIOD, "ms"),
        given("radius", "10mm", RADIUS, "mm"),
        given("parameter step of uniform interpolation", STEP, float(STEP)),
    ]
    for speed, rate, frequency in zip(
        SPEEDS, ("2.083 rad/sec", "4.167 rad/sec", "8.333 rad/sec"), ("1/3Hz", "2/3 Hz", "4/3Hz"), strict=True
    ):
        omega = float(speed) * 1000.0 / 60.0 / RADIUS
        rows.append(Row(f"{speed} m/min: rate", omega, rate, "rad/s", within=ARITHMETIC, basis=Basis.PRINTED))
        hertz = omega / (2.0 * math.pi)
        rows.append(
            Row(f"{speed} m/min: frequency", hertz, frequency, "Hz", within=ARITHMETIC, basis=Basis.PRINTED)
        )
    rows.append(
        Row(
            "position loop: bandwidth in Hz",
            9.0 / (2.0 * math.pi),
            "1.5Hz",
            "Hz",
            within=WITHIN,
            basis=Basis.PRINTED,
        )
    )
    slow = errors_of(circle(1.25), "p", Choices(gain_1_s=9.0))[0]
    for letter, servo in load_servos(MACHINE).items():
        gain = float(servo.parameters["position_gain_1_s"])
        rows.append(
            Row(f"position loop of {letter}: bandwidth", gain, "9 rad/sec", "rad/s", within=WITHIN, basis=Basis.CALIBRATED,
                reason=f"with 9 rad/s P's tracking error at 1.25 m/min is {slow:.0f} µm where Table 1 has 305.18; a slip of a factor"
                " of ten is likely")
        )  # fmt: skip
    return Table("Paper 004, section 6: what is given", tuple(rows))


def _table_1(ours: dict[str, list[Triple]], others: dict[str, list[Triple]]) -> Table:
    rows = []
    for name, printed in PRINTED.items():
        for i, speed in enumerate(SPEEDS):
            for k in range(2):
                what, unit = _QUANTITIES[k]
                rows.append(
                    Row(f"{LABELS[name]}, {speed} m/min: {what}", ours[name][i][k], printed[i][k], unit, within=WITHIN,
                        basis=Basis.CALIBRATED, sensitivity=((_OTHERS[name][0], others[name][i][k]),), reason=_REASONS[name])
                )  # fmt: skip
    for speed, (contour, _) in zip(SPEEDS, DYNA, strict=True):
        rows.append(absent(f"DYNA, {speed} m/min: contour error", contour, _OWN_CONTROL, "µm"))
    return Table("Paper 004, Table 1: errors on a circle of 10 mm", tuple(rows), _CALIBRATION)


def _table_2(ours: dict[str, list[Triple]]) -> Table:
    rows = []
    for name, printed in PRINTED.items():
        for i, speed in enumerate(SPEEDS):
            found = ours[name][i][2]
            bare = _without_floor(found)
            rows.append(
                Row(f"{LABELS[name]}, {speed} m/min: speed variation", found, printed[i][2], "µm/s", within=WITHIN,
                    basis=Basis.CALIBRATED, sensitivity=(("no floor", bare),), reason=_NOISE)
            )  # fmt: skip
    for speed, (_, variation) in zip(SPEEDS, DYNA, strict=True):
        rows.append(absent(f"DYNA, {speed} m/min: speed variation", variation, _OWN_CONTROL, "µm/s"))
    return Table("Paper 004, Table 2: standard deviation of the speed", tuple(rows), (_FLOOR, *_CALIBRATION))


def _without_floor(variation: float) -> float:
    """Return a speed variation without the contribution of the measurement, µm/s."""
    return math.sqrt(max(variation**2 - SPEED_FLOOR**2, 0.0))


def _uniform(uniform: dict[str, Triple], programs: str | None) -> Table:
    """Table 3, equal parameter steps."""
    rows = []
    for name, printed in UNIFORM.items():
        nine = errors_of(uniform_circle(float(STEP), programs, nine_points=True), name)
        for k, (what, unit) in enumerate(_QUANTITIES):
            basis = Basis.SCANNED if k == 2 else Basis.PREDICTED
            rows.append(
                Row(f"uniform, {LABELS[name]}: {what}", uniform[name][k], printed[k], unit, within=WITHIN, basis=basis,
                    sensitivity=(("nine control points", nine[k]),), reason=_VARYING)
            )  # fmt: skip
    return Table("Paper 004, Table 3: NURBS circle at equal parameter steps", tuple(rows), _UNIFORM)


def _constant(programs: str | None) -> Table:
    """Table 3, constant speed: all 27 numbers."""
    rows = []
    for speed, columns in CONSTANT.items():
        second, first = (nurbs_circle(kind, float(speed), programs) for kind in ("taylor2", "taylor1"))
        for name, printed in columns.items():
            ours, other = errors_of(second, name), errors_of(first, name)
            for k, (what, unit) in enumerate(_QUANTITIES):
                reason = _NOISE if k == 2 else _REASONS[name]
                rows.append(
                    Row(f"constant speed, {speed} m/min, {LABELS[name]}: {what}", ours[k], printed[k], unit, within=WITHIN,
                        basis=Basis.CALIBRATED, sensitivity=(("first order", other[k]),), reason=reason)
                )  # fmt: skip
    return Table("Paper 004, Table 3: NURBS circle at constant speed", tuple(rows), _CONSTANT)


def _conclusions(ours: dict[str, list[Triple]], uniform: dict[str, Triple], programs: str | None) -> Table:
    """The numbers of the conclusions."""
    p, both = uniform["p"], uniform["zpetc+ccc"]
    rows = [
        Row("uniform: contour error, integrated over P", 100 * both[1] / p[1], "2.67%", "%", within=WITHIN, reason=_VARYING),
        Row("uniform: tracking error, integrated over P", 100 * both[0] / p[0], "5.93%", "%", within=WITHIN, reason=_VARYING),
    ]  # fmt: skip
    at_5 = nurbs_circle("taylor2", 5.0, programs)
    constant = {name: errors_of(at_5, name)[2] for name in UNIFORM}
    cut = {name: constant[name] / uniform[name][2] for name in UNIFORM}
    bare = {
        name: (("no floor", _without_floor(constant[name]) / _without_floor(uniform[name][2])),)
        for name in UNIFORM
    }
    rows.append(
        Row("P: speed variation at constant speed over uniform", cut["p"], "1/10", "", within=WITHIN,
            basis=Basis.CALIBRATED, sensitivity=bare["p"], reason="the paper's own Table 3 has 1103.8/18688, 1/17")
    )  # fmt: skip
    rows += [
        Row(f"{LABELS[name]}: speed variation at constant speed over uniform", cut[name], "1/60 以下", "", at_most=1 / 60,
            basis=Basis.CALIBRATED, sensitivity=bare[name])
        for name in ("zpetc+ccc", "tcf")
    ]  # fmt: skip
    for name, contour, variation in (("zpetc+ccc", "80%", "30%"), ("tcf", "60%", "50%")):
        for k, printed, what in ((1, contour, "contour error"), (2, variation, "speed variation")):
            values = [found[k] for found in ours[name]]
            share = _mean_below(values, k)
            other = (("no floor", _mean_below([_without_floor(v) for v in values], k)),) if k == 2 else ()
            rows.append(
                Row(f"{LABELS[name]}: {what} below DYNA's printed one, mean of the speeds", share,
                    printed, "%", within=WITHIN, basis=Basis.CALIBRATED, sensitivity=other,
                    reason=_NOISE if k == 2 else _REASONS[name])
            )  # fmt: skip
    rows += _orders(ours)
    return Table("Paper 004, conclusions", tuple(rows))


def _mean_below(values: Sequence[float], quantity: int) -> float:
    """Return by how much values at the three speeds are below DYNA's printed ones in the mean, %; 1: contour error, 2: speed."""
    shares = [1.0 - value / float(own[quantity - 1]) for value, own in zip(values, DYNA, strict=True)]
    return 100.0 * float(np.mean(shares))


def _orders(ours: dict[str, list[Triple]]) -> list[Row]:
    """Return how many pairs of controllers stand in another order of contour error than printed, at each speed."""
    rows = []
    for i, speed in enumerate(SPEEDS):
        swapped = sum(
            (float(PRINTED[a][i][1]) < float(PRINTED[b][i][1])) != (ours[a][i][1] < ours[b][i][1])
            for a in PRINTED
            for b in PRINTED
            if a < b
        )
        rows.append(
            Row(f"pairs of controllers in another order by contour error, {speed} m/min", swapped,
                at_most=0.0, basis=Basis.CALIBRATED, kind=RowKind.OURS)
        )  # fmt: skip
    return rows


def _schemes() -> Table:
    """Figs 1 to 4, and the designs that the text names without giving them."""
    rows = (
        *(drawing(f"Fig. {k}: block diagram") for k in (1, 2, 3, 4)),
        absent("optimal ZPETC", "", "the text names it and cites it; the filter in front is not given"),
        absent("robust CCC", "", "the text names it and cites it; the design is not given"),
    )
    return Table("Paper 004, figures and designs", rows)


_REASONS = {
    "p": "five values of the axes are fitted to P's six figures of Table 1",
    "zpetc": "the error of ZPETC is that of its model, which is not given; ours has 0.97 of the gain, set by hand",
    "ccc": "the gains of the cross coupling are not given; ours are 8 and 100/s times the axes' own, set by hand",
    "zpetc+ccc": "neither the error of ZPETC's model nor the gains of the cross coupling are given; ours are set by hand",
    "tcf": "neither the poles nor the model of the task frame are given; with the exact model ours hardly depends on the speed",
}
_OWN_CONTROL = "the machine's own control is not described"
_NOISE = f"how the speed is measured is not given; a floor of {SPEED_FLOOR:g} µm/s is fitted to P at 1.25 m/min, more than some rows print"
_VARYING = "under a speed that varies by ±32 % the errors follow from the drives' dynamics and the model's error, which are not given"
_FLOOR = (
    f"a floor of {SPEED_FLOOR:g} µm/s, what measuring the speed adds, is calibrated and added in quadrature"
)
_CALIBRATION = (
    "calibrated on P's six figures: gains 105.9 and 71.8/s, lag 4.7 ms, friction 45.1 and 42.1 µm (profile dyna-1007)",
    "calibrated by hand towards the table: ZPETC's model has 0.97 of the gain; CCC is 8 + 100/s times the gain; TCF's poles are 250"
    " and 350 rad/s; errors are rms",
)
_UNIFORM = (
    "the paper's NURBS is not printed; of five representations of the circle three give its speed variation, the quadratic of seven"
    " points among them, that of nine points does not",
    _FLOOR,
)
_CONSTANT = (
    "interpolator `taylor2` at constant feed on the circle of seven points; the paper does not say of which order its interpolator is",
    "calibrated: the model was fitted to Table 1, whose circles these repeat, and the floor to P's speed variation, which stands here again",
    _FLOOR,
)


def figures(programs: str | None = None) -> Figures:
    """Contour errors of the controllers on the circle (Table 1), and the speed of both interpolations (Table 3)."""
    servos = load_servos(MACHINE)
    rows = circle(5.0)
    figure, grid = new_figure(
        "Paper 004, Table 1: contour error on a circle of 10 mm at 5 m/min, second turn", 5, height=1.5
    )
    turn = slice(*(int(1000 * t) for t in (0.2 + 0.754, 0.2 + 2 * 0.754)))
    for part, (name, label) in zip(grid[:, 0], LABELS.items(), strict=True):
        run = list(simulate_scheme([Setpoints("XY", 0.001, 0, rows)], scheme_maker(name, servos)))
        error = 1e3 * np.concatenate([r.contour_error_mm for r in run])[turn]
        line(part, ticks(len(error), first=turn.start), error,
             label=f"{label}: rms {np.sqrt((error**2).mean()):.3g} µm")  # fmt: skip
        part.set_ylim(0.0, 1.45 * error.max())
        part.set_ylabel("error (µm)")
        legend(part, "upper right")
    grid[-1, 0].set_xlabel("time (s)")
    yield "table1_contour", figure
    figure, ((part,),) = new_figure("Paper 004, Table 3: commanded speed on the NURBS circle")
    for label, path, color in (
        ("uniform parameter steps", uniform_circle(float(STEP), programs), ORANGE),
        ("constant speed (5 m/min, second order)", nurbs_circle("taylor2", 5.0, programs), BLUE),
    ):
        speed = path_speed(path, PERIOD)
        line(part, ticks(len(speed)), speed, label=label, color=color)
    part.set_ylabel("speed (mm/s)")
    part.set_xlabel("time (s)")
    part.set_ylim(bottom=0.0)
    legend(part, "lower right")
    yield "table3_speed", figure

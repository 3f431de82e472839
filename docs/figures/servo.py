"""Draw the figures of the servo pages from our own data: python docs/figures/servo.py."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cncgen.machine import load_machine, load_servos
from cncgen.machine.record import Axis, Servo
from cncgen.papers import chen_hsu_2007, hsu_1999
from cncgen.pipeline import plan, read, sample
from cncgen.servo.compensation import compensate
from cncgen.servo.identification.etfe import etfe
from cncgen.servo.identification.excitation import swept_sine
from cncgen.servo.identification.fits import fit_first_order
from cncgen.servo.learning import follow
from cncgen.servo.simulate import own_scheme, simulate
from cncgen.setpoints.record import Setpoints
from trials.compensation import made_servos

HERE = Path(__file__).parent
PERIOD_S = 0.001
NOISE_MM = 0.001


def main() -> None:
    """Write controllers.png, inversion.png, compensation.png and identification.png beside this file."""
    for name, wanted, paper in (
        ("controllers", "table1_contour", hsu_1999),
        ("inversion", "inversion", chen_hsu_2007),
    ):
        for title, figure in paper.figures():
            if title == wanted:
                figure.savefig(HERE / f"{name}.png", dpi=90)
    compensation().savefig(HERE / "compensation.png", dpi=90)
    identification().savefig(HERE / "identification.png", dpi=90)


def compensation() -> Figure:
    """Return a reversal with friction and backlash, pre-actuation, and a drive at its bound."""
    figure = Figure(figsize=(9.0, 6.4), layout="constrained")
    reversal, early, forces, errors = figure.subplots(2, 2).ravel()
    _reversal(reversal, made_servos("two masses, friction, backlash 2 µm, encoder 1 µm"))
    _early(early, made_servos("first order, zero at 200/s on the right, delay of 2 samples"))
    weak = {
        k: Servo(s.model, {**s.parameters, "saturation_volt": 0.8})
        for k, s in load_servos("die-bonder").items()
    }
    _bound(forces, errors, weak)
    return figure


def _learnt(
    program: str, machine: str, servos: Mapping[str, Servo], whole: bool = False
) -> tuple[np.ndarray, ...]:
    """Return time, wanted motion, command, and the axes' position and drive input under both, of X; s from the motion's begin.

    `whole`: the motion alone, without the rests before and after.
    """
    where = load_machine(machine)
    rows = list(sample(plan(read(str(HERE.parents[1] / "programs" / f"{program}.nc")), where)).chunks)
    found = compensate(rows, servos, limits=where.axes).learnt
    loops = own_scheme(servos, rows[0].axes, PERIOD_S).loops
    before, after = (follow(loops, PERIOD_S, part)[:2] for part in (found.wanted, found.command))
    t = (np.arange(len(found.wanted)) - found.lead) * PERIOD_S
    columns = (found.wanted, found.command, before[0], after[0], before[1], after[1])
    inside = slice(found.lead, len(t) - found.tail) if whole else slice(None)
    return t[inside], *(column[inside, 0] for column in columns)


def _reversal(part: Axes, servos: Mapping[str, Servo]) -> None:
    smooth = {
        k: Servo(s.model, {**s.parameters, "coulomb_n_m": 0.0, "backlash_mm": 0.0}) for k, s in servos.items()
    }
    _, _, without, *_ = _learnt("circle", "xy-table", smooth, whole=True)
    t, wanted, command, *_ = _learnt("circle", "xy-table", servos, whole=True)
    velocity = np.gradient(wanted, t)
    inside = np.flatnonzero((t > 0.2) & (t < t[-1] - 0.3))
    k = int(inside[np.flatnonzero(np.diff(np.sign(velocity[inside])))[0]])
    near = slice(k - 60, k + 90)
    part.plot(t[near] - t[k], 1e3 * (command - without)[near], color="C0")
    part.axvline(0.0, color="0.7", linewidth=0.8)
    part.set(title="reversal with friction and backlash", xlabel="time from the reversal, s",
             ylabel="command less that without them, X, µm")  # fmt: skip


def _early(part: Axes, servos: Mapping[str, Servo]) -> None:
    t, wanted, command, _, after, *_ = _learnt("circle", "xy-table", servos)
    near = (t > -0.03) & (t < 0.03)
    for label, rows in (("motion", wanted), ("command", command), ("axis", after)):
        part.plot(
            t[near],
            1e3 * (rows - wanted[0])[near],
            label=label,
            linewidth=1.2,
            linestyle="--" if label == "axis" else "-",
        )
    part.set(title="zero on the right: pre-actuation", xlabel="time, s", ylabel="X, µm", ylim=(-3, 3))
    part.legend(frameon=False)


def _bound(forces: Axes, errors: Axes, servos: Mapping[str, Servo]) -> None:
    t, wanted, _, before, after, force_before, force_after = _learnt("star", "die-bonder", servos)
    for label, force, position in (("as it is", force_before, before), ("compensated", force_after, after)):
        forces.plot(t, force, label=label, linewidth=0.9)
        errors.plot(t, 1e3 * np.abs(wanted - position), label=label, linewidth=0.9)
    for sign in (-1.0, 1.0):
        forces.axhline(0.8 * sign, color="0.5", linestyle="--", linewidth=0.8)
    forces.set(title="a drive's bound of 0.8 V", xlabel="time, s", ylabel="drive input, X, V")
    forces.legend(frameon=False)
    errors.set(
        title="the same, error",
        xlabel="time, s",
        ylabel="tracking error, X, µm",
        yscale="log",
        ylim=(1e-3, None),
    )


def identification() -> Figure:
    """Return a logged excitation, the frequency response, and the fits of many logs with their ellipse."""
    servo = Servo("first-order", {"position_gain_1_s": 80.0, "time_constant_s": 0.004})
    rows = swept_sine(Axis("X", 250.0, 2450.0, 50000.0), PERIOD_S, duration_s=4.0, low_hz=1.0)
    [run] = simulate([Setpoints("X", PERIOD_S, 0, rows[:, None])], {"X": servo})
    position = run.position[:, 0]
    noisy = [position + NOISE_MM * np.random.default_rng(k).standard_normal(len(position)) for k in range(60)]
    fits = [fit_first_order(rows, y, PERIOD_S, friction=False) for y in noisy]
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    sweep, gain, ellipse = figure.subplots(1, 3)
    t = np.arange(len(rows)) * PERIOD_S
    sweep.plot(t, rows, label="command", linewidth=0.8)
    sweep.plot(t, position, label="axis", linewidth=0.8)
    sweep.set(xlabel="time, s", ylabel="X, mm")
    sweep.legend(frameon=False)
    found = etfe(rows, noisy[0], PERIOD_S)
    seen = found.coherence > 0.9
    gain.loglog(found.frequency_hz[seen], np.abs(found.response[seen]), ".", markersize=3, label="ETFE")
    s = 2j * np.pi * found.frequency_hz[seen]
    kv, lag = (fits[0].parameters[key] for key in ("position_gain_1_s", "time_constant_s"))
    gain.loglog(found.frequency_hz[seen], np.abs(kv / (lag * s**2 + s + kv)), label="fit, without its hold")
    gain.set(xlabel="frequency, Hz", ylabel="gain")
    gain.legend(frameon=False)
    values = np.array(
        [[f.parameters["position_gain_1_s"], 1e3 * f.parameters["time_constant_s"]] for f in fits]
    )
    ellipse.plot(*values.T, ".", markersize=4, label="60 logs")
    ellipse.plot(80.0, 4.0, "+", color="0.2", markersize=9, label="true")
    root = np.linalg.cholesky(fits[0].covariance.matrix)
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    around = (80.0, 4.0) * np.exp((2.0 * root @ np.array([np.cos(angle), np.sin(angle)])).T)
    ellipse.plot(*around.T, color="C1", linewidth=0.9, label="two sigma, from one log")
    ellipse.set(
        xlabel="position gain, 1/s",
        ylabel="time constant, ms",
        xticks=(79.99, 80.0, 80.01),
        xlim=(79.985, 80.015),
    )
    ellipse.ticklabel_format(useOffset=False)
    ellipse.legend(frameon=False, fontsize=8)
    return figure


if __name__ == "__main__":
    main()

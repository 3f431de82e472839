"""The paper appended to 003 (Tsai, Pan and You): H-infinity and QFT control of a flexure stage, one axis and both coupled.

The paper's plants are in its figures only. Ours are those of the profile ``flexure-stage``. Their axes are coupled as the paper's
are, by an error of installation: the actuators stand at an angle φ to the sensors, so y = R(φ) (Gx ux, Gy uy). φ is ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cncgen.machine import load_servos
from cncgen.machine.servo_schema import resolve
from cncgen.papers.printed import WITHIN, Basis, Row, RowKind, Table, absent, drawing
from cncgen.report.drawing import BLUE, GREEN, GREY, ORANGE, RED, legend, line, new_figure, ticks
from cncgen.servo.controller import Controller
from cncgen.servo.controllers.hinf_servo import check, controller_of, family
from cncgen.servo.discretise import held
from cncgen.servo.frequency import open_loop
from cncgen.servo.loop import close_loop
from cncgen.servo.models import control_period
from cncgen.servo.plants import companion, transfer_function

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from cncgen.report.drawing import Figures

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

STAGE = "flexure-stage"
LETTERS = "XY"
#: Angle between actuators and sensors, degrees.
ANGLE_DEG = 5.0
#: A step, µm.
STEP = 20.0
_AXIS_COLORS = (("X", BLUE), ("Y", ORANGE))


def stage_period() -> float:
    """Return the control period of the stage, s."""
    return control_period(load_servos(STAGE)["X"], "X", 0.001)


def stage_controller(letter: str, reshaped: bool = True) -> Controller:
    """Return an axis's sampled controller, after or before the reshaping at high frequencies (the paper's second stage)."""
    values = resolve(load_servos(STAGE)[letter], letter)
    return controller_of(
        values if reshaped else {**values, "roll_off_rad_s": None}, control_period(load_servos(STAGE)[letter], letter, 0.001)
    )  # fmt: skip


def stage_steps(letter: str, seconds: float = 0.8) -> list[Floats]:
    """Return the response of one axis to a step of 20 µm for every payload, µm, one row a control period."""
    values, period, controller = (
        resolve(load_servos(STAGE)[letter], letter),
        stage_period(),
        stage_controller(letter),
    )
    found = []
    for above, below in family(values):
        loop = close_loop(transfer_function(np.array(above), np.array(below)), controller, period)
        a, b, _ = loop.transition()
        states = np.zeros((round(seconds / period), len(a)))
        for k in range(1, len(states)):
            states[k] = a @ states[k - 1] + b
        found.append(STEP * states @ loop.output)
    return found


@dataclass(frozen=True, slots=True)
class CoupledStage:
    """The closed loop of both axes: z[k+1] = A z[k] + B (r − n)[k], y = C z, u = F z + D (r − n); r, n, y, u of both axes.

    Attributes:
        a, b, c, f, d: Shapes (n, n), (n, 2), (2, n), (2, n), (2, 2); lengths in mm, drives in V.
        period: Control period, s.
    """

    a: Floats
    b: Floats
    c: Floats
    f: Floats
    d: Floats
    period: float

    def step(self, axis: int, seconds: float = 0.8) -> tuple[Floats, Floats]:
        """Return positions (µm) and drives (V) of both axes after a step of 20 µm of one, each of shape (n, 2)."""
        r = np.zeros(2)
        r[axis] = 1e-3 * STEP
        z = np.zeros(len(self.a))
        rows = np.empty((round(seconds / self.period), 4))
        for k in range(len(rows)):
            rows[k] = *(1e3 * self.c @ z), *(self.f @ z + self.d @ r)
            z = self.a @ z + self.b @ r
        return rows[:, :2], rows[:, 2:]

    def noise(self) -> tuple[Floats, Floats]:
        """Return the rms of position (µm) and drive (V) of both axes under white noise of 1 µm rms of the sensors.

        In closed form: the covariance P of the states solves P = A P Aᵀ + B Bᵀ.
        """
        n = len(self.a)
        spread = 1e-6 * self.b @ self.b.T
        p = np.linalg.solve(np.eye(n * n) - np.kron(self.a, self.a), spread.ravel()).reshape(n, n)
        position = 1e3 * np.sqrt(np.diag(self.c @ p @ self.c.T))
        drive = np.sqrt(np.diag(self.f @ p @ self.f.T) + 1e-6 * np.diag(self.d @ self.d.T))
        return position, drive


def coupled_stage(reshaped: bool = True, angle_deg: float = ANGLE_DEG) -> CoupledStage:
    """Return both axes of the stage under their own controllers, the actuators turned by an angle against the sensors."""
    period, angle = stage_period(), math.radians(angle_deg)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    plants, controllers = [], []
    for letter in LETTERS:
        values = resolve(load_servos(STAGE)[letter], letter)
        a, b, c, _ = companion(np.array(values["numerator"]), np.array(values["denominator"]))
        phi, gamma = held(a, b[:, None], period)
        plants.append((phi, gamma[:, 0], c))
        controllers.append(stage_controller(letter, reshaped))
    ap, bp = (_blocks([part[i] for part in plants]) for i in range(2))
    ac = _blocks([k.a for k in controllers])
    bc = _blocks([k.b_setpoint for k in controllers])
    cc = _blocks([k.c for k in controllers], rows=True)
    direct = np.diag([k.d_setpoint for k in controllers])
    out = turn @ _blocks([part[2] for part in plants], rows=True)
    f = np.hstack([-direct @ out, cc])
    a = np.block([[ap - bp @ direct @ out, bp @ cc], [-bc @ out, ac]])
    return CoupledStage(
        a, np.vstack([bp @ direct, bc]), np.hstack([out, np.zeros((2, len(ac)))]), f, direct, period
    )


def _blocks(parts: list[Floats], rows: bool = False) -> Floats:
    """Return matrices, columns, or (where `rows` says so) rows along a diagonal."""
    shaped = [part if part.ndim == 2 else part[None] if rows else part[:, None] for part in parts]
    whole = np.zeros((sum(len(p) for p in shaped), sum(p.shape[1] for p in shaped)))
    i = j = 0
    for part in shaped:
        whole[i : i + len(part), j : j + part.shape[1]] = part
        i, j = i + len(part), j + part.shape[1]
    return whole


def controller_response(letter: str, reshaped: bool, frequency: Floats) -> Complexes:
    """Return the response of a sampled controller from error to drive at rad/s, V/mm."""
    k = stage_controller(letter, reshaped)
    z = np.exp(1j * frequency * stage_period())
    systems = z[:, None, None] * np.eye(len(k.a)) - k.a
    states = np.linalg.solve(systems, np.broadcast_to(k.b_setpoint[:, None], (len(z), len(k.a), 1)))
    return np.asarray(states[:, :, 0] @ k.c + k.d_setpoint, np.complex128)


def stage_tables() -> list[Table]:
    """Return the claims of the appended paper, its bounds on our loops, and its figures."""
    return [_claims(), _bounds(), _figures()]


def _claims() -> Table:
    rows = []
    for letter in LETTERS:
        steps = stage_steps(letter)
        rises = [
            (np.argmax(step > 0.9 * STEP) - np.argmax(step > 0.1 * STEP)) * stage_period() for step in steps
        ]
        ends = max(abs(float(step[-1]) - STEP) for step in steps)
        rows.append(
            Row(f"{letter}: rise time of 20 µm, slowest of {len(steps)} plants", float(max(rises)), "about 0.1 sec", "s",
                within=WITHIN, basis=Basis.CALIBRATED, sensitivity=(("the quickest", float(min(rises))),))
        )  # fmt: skip
        rows.append(
            Row(
                f"{letter}: error after 0.8 s, largest",
                ends,
                "within 1um",
                "µm",
                at_most=1.0,
                basis=Basis.CALIBRATED,
            )
        )
    return Table("Appended to paper 003: claims", (*rows, *_reshaping(), *_coupling()), _FLEXURE)


def _reshaping() -> list[Row]:
    """Noise and effort after the reshaping by QFT, over those before it."""
    before, after = coupled_stage(reshaped=False), coupled_stage()
    (seen, drive), (seen_after, drive_after) = before.noise(), after.noise()
    peaks = [float(np.abs(stage.step(0)[1]).max()) for stage in (before, after)]
    said = "noise effects and control efforts can be reduced significantly"
    rows = [
        Row(f"{letter}: drive under noise of the sensors, after QFT over before", float(drive_after[i] / drive[i]), said,
            at_most=0.7, basis=Basis.CALIBRATED, reason=_ROLL)
        for i, letter in enumerate(LETTERS)
    ]  # fmt: skip
    rows.append(
        Row("X: position under noise of the sensors, after QFT over before", float(seen_after[0] / seen[0]), said, at_most=0.7,
            basis=Basis.CALIBRATED, reason=_ROLL)
    )  # fmt: skip
    rows.append(
        Row("X: largest drive of a step, after QFT over before", peaks[1] / peaks[0], said, at_most=0.7, basis=Basis.CALIBRATED,
            reason=_ROLL)
    )  # fmt: skip
    w = np.array([100.0, 1000.0, 6000.0])
    gain = np.abs(controller_response("X", False, w))
    rows.append(
        Row("Fig. 10: gain of the H-infinity controller above 1000 rad/s over that at 100 rad/s", float(gain[1:].max() / gain[0]),
            "controller gain is high as the frequency is higher than 1000 rad/sec", at_least=1.0, reason=_ROLL)
    )  # fmt: skip
    return rows


def _coupling() -> list[Row]:
    """The rest of the coupling of X and Y."""
    rows = []
    for i, letter in enumerate(LETTERS):
        found = {angle: coupled_stage(angle_deg=angle).step(i)[0][:, 1 - i] for angle in (ANGLE_DEG, 10.0)}
        other = LETTERS[1 - i]
        rows.append(
            Row(f"{other} 0.8 s after a step of 20 µm of {letter}", float(abs(found[ANGLE_DEG][-1])), "The coupling of the X and Y axes is also eliminated",
                "µm", at_most=0.02 * STEP * math.tan(math.radians(ANGLE_DEG)),
                sensitivity=(("10°", float(abs(found[10.0][-1]))), ("its peak", float(np.abs(found[ANGLE_DEG]).max()))))
        )  # fmt: skip
    return rows


def _bounds() -> Table:
    rows = []
    for letter in LETTERS:
        values = resolve(load_servos(STAGE)[letter], letter)
        found = check(values, stage_controller(letter), stage_period())
        share = float((found.sensitivity / found.allowed).max())
        rows.append(Row(f"{letter}: largest S over its bound (eq. 4)", share, at_most=1.0, kind=RowKind.OURS))
        largest = float(found.complementary.max())
        rows.append(Row(f"{letter}: largest T (eq. 5)", largest, at_most=found.peak, kind=RowKind.OURS))
    return Table(
        "Appended to paper 003: its bounds on our loops (α and M_L are not printed)", tuple(rows), _FLEXURE
    )


def _figures() -> Table:
    curves = "our copy names no number of it, and the plant is in figures only"
    rows = [
        *(drawing(f"Fig. {k}") for k in ("1: one drop filling", "2: the stage", "6: block diagram", "7: the LFT form")),
        *(absent(f"Fig. {k}", "", "our copy has every second page") for k in ("3", "8")),
        *(absent(f"Fig. {k}", "", curves) for k in (
            "4: response to X", "5: response to Y", "9: Nichols chart of the plant", "10: H-infinity controller",
            "11: Nichols chart after QFT", "12: step response")),
        absent("rotation of the third axis", "X, Y, θ", "no dynamics of θ are in our copy"),
    ]  # fmt: skip
    return Table(
        "Appended to paper 003: figures", tuple(rows), ("`--plots` draws Figs 4, 5 and 9 to 12 of our stage",)
    )


_FLEXURE = (
    "the paper's plants are in its figures only: ours has one resonance of 25 or 27.5 Hz and payloads within 10 % (profile"
    " flexure-stage), with weights chosen for a rise time of 0.1 s",
    f"both axes together: actuators at {ANGLE_DEG:g}° to the sensors, our angle; sampled at 0.5 ms, white noise of the sensors,"
    " quantisation and saturation left out",
)
_ROLL = "the weights of the paper's design are not printed; ours leave less to reduce"


def figures() -> Figures:
    """Figs 4, 5 and 9 to 12 of our stage, and the bounds on it."""
    yield "stage_responses", _responses()
    yield "stage_nichols", _nichols()
    yield "stage_controller", _controllers()
    yield "stage_bounds", _stage_bounds()
    yield "stage_step", _stage_step()


def _responses() -> Figure:
    """Figs 4 and 5: both sensors while one actuator is shaken."""
    figure, grid = new_figure(
        "Appended to paper 003, Figs 4 and 5: response of the coupled stage", 1, 2, height=3.4, width=11.0
    )
    w = np.geomspace(1.0, 2000.0, 600)
    angle = math.radians(ANGLE_DEG)
    for part, letter in zip(grid[0], LETTERS, strict=True):
        values = resolve(load_servos(STAGE)[letter], letter)
        plant = np.abs(np.polyval(values["numerator"], 1j * w) / np.polyval(values["denominator"], 1j * w))
        for seen, color in _AXIS_COLORS:
            share = math.cos(angle) if seen == letter else math.sin(angle)
            line(part, w, 20.0 * np.log10(1e3 * share * plant), color=color, label=f"{seen} sensor")
        part.set_xscale("log")
        part.set_title(f"{letter} actuator", fontsize=9)
        part.set_xlabel("frequency (rad/s)")
        part.set_ylabel("dB of 1 µm/V")
        legend(part, "lower left")
    return figure


def _nichols() -> Figure:
    """Figs 9 and 11: the Nichols chart of the X loop, plant alone, under H-infinity, and after QFT, all payloads."""
    figure, ((part,),) = new_figure(
        "Appended to paper 003, Figs 9 and 11: Nichols chart of X, nine payloads", height=5.4
    )
    period, w = stage_period(), np.geomspace(1.0, 5000.0, 1500)
    values = resolve(load_servos(STAGE)["X"], "X")
    looks = (("H-infinity alone", False, ORANGE), ("after QFT", True, BLUE))
    for label, reshaped, color in looks:
        controller = stage_controller("X", reshaped)
        for k, (above, below) in enumerate(family(values)):
            loop = close_loop(transfer_function(np.array(above), np.array(below)), controller, period)
            _on_nichols(part, open_loop(loop, w), color, label if k == 0 else None)
    for k, (above, below) in enumerate(family(values)):
        plant = (
            np.polyval(above, 1j * w)
            / np.polyval(below, 1j * w)
            / abs(np.polyval(above, 0) / np.polyval(below, 0))
        )
        _on_nichols(part, plant, GREEN, "plant over its gain at rest" if k == 0 else None)
    m = values["complementary_peak"]
    turn = np.exp(1j * np.linspace(0.0, 2.0 * math.pi, 400))
    _on_nichols(part, m * turn / (1.0 - m * turn), RED, f"|T| = {m:g}")
    part.plot([-180.0], [0.0], "k+", markersize=9)
    part.set_xlim(-540.0, 0.0)
    part.set_ylim(-80.0, 50.0)
    part.set_xlabel("phase (°)")
    part.set_ylabel("gain (dB)")
    legend(part, "lower left")
    return figure


def _on_nichols(part: Axes, response: Complexes, color: str, label: str | None) -> None:
    """Draw a response as gain over phase."""
    phase = np.degrees(np.unwrap(np.angle(response)))
    phase -= 360.0 * math.ceil(float(phase[0]) / 360.0 - 0.01)
    line(part, phase, 20.0 * np.log10(np.abs(response)), color=color, linewidth=0.8, label=label)


def _controllers() -> Figure:
    """Fig. 10: gain of the controller of X before and after QFT."""
    figure, ((part,),) = new_figure("Appended to paper 003, Fig. 10: controllers of X", height=3.4)
    w = np.geomspace(1.0, 6000.0, 600)
    for label, reshaped, color in (("H-infinity alone", False, ORANGE), ("after QFT", True, BLUE)):
        line(
            part, w, 20.0 * np.log10(np.abs(controller_response("X", reshaped, w))), color=color, label=label
        )
    part.set_xscale("log")
    part.set_xlabel("frequency (rad/s)")
    part.set_ylabel("gain (dB of 1 V/mm)")
    legend(part, "lower left")
    return figure


def _stage_bounds() -> Figure:
    """The appended paper's bounds on the sampled loops of its stage, the worst of all payloads."""
    figure, grid = new_figure("Appended to paper 003: bounds on the flexure stage under H-infinity control", 1, 2,
                              height=3.6, width=11.0)  # fmt: skip
    for letter, color in _AXIS_COLORS:
        values = resolve(load_servos(STAGE)[letter], letter)
        found = check(values, stage_controller(letter), stage_period())
        hertz = found.frequency / (2.0 * math.pi)
        for part, worst, allowed, name in (
            (grid[0, 0], found.sensitivity, found.allowed, "S"),
            (grid[0, 1], found.complementary, np.full(len(hertz), found.peak), "T"),
        ):
            line(
                part,
                hertz,
                20 * np.log10(np.maximum(worst, 1e-6)),
                color=color,
                label=f"{letter}, worst of {found.plants} plants",
            )
            if letter == "X":
                line(part, hertz, 20 * np.log10(allowed), color=RED, linestyle="--", label="bound")
            part.set_xscale("log")
            part.set_ylim(-60, 12)
            part.set_xlabel("frequency (Hz)")
            part.set_ylabel(f"|{name}| (dB)")
    legend(grid[0, 0], "lower right")
    legend(grid[0, 1], "lower left")
    return figure


def _stage_step() -> Figure:
    """Fig. 12: the step of 20 µm, for every payload."""
    figure, grid = new_figure("Appended to paper 003, Fig. 12: step of 20 µm, nine payloads", 2, height=2.4)
    for part, letter in zip(grid[:, 0], "XY", strict=True):
        for rows in stage_steps(letter):
            line(part, ticks(len(rows), stage_period())[:600], rows[:600], linewidth=0.6)
        part.axhline(20.0, color=GREY, linewidth=0.8, linestyle="--")
        part.set_ylabel(f"{letter} (µm)")
    grid[-1, 0].set_xlabel("time (s)")
    return figure

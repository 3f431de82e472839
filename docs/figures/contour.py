"""Draw the figure of contour-error.md from our own simulation: python docs/figures/contour.py."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from cncgen.machine.record import Servo
from cncgen.servo.simulate import simulate
from cncgen.setpoints.record import Setpoints

HERE = Path(__file__).parent
PERIOD_S, SPEED_MM_S, RADIUS_MM = 0.001, 50.0, 2.0


def commanded() -> np.ndarray:
    """Setpoints of a line, a quarter circle and a line, at constant speed: shape (n, 2), mm."""
    bend = RADIUS_MM * np.pi / 2
    s = np.arange(0.0, 10.0 + bend, SPEED_MM_S * PERIOD_S)
    angle = np.clip((s - 5.0) / RADIUS_MM, 0.0, np.pi / 2)
    before, after = np.minimum(s, 5.0) - 5.0, np.maximum(s - 5.0 - bend, 0.0)
    return np.column_stack([before + RADIUS_MM * np.sin(angle), RADIUS_MM * (1.0 - np.cos(angle)) + after])


def main() -> None:
    """Write contour_error.png beside this file."""
    rows = commanded()
    servos = {letter: Servo("first-order", {"position_gain_1_s": 60.0}) for letter in "XY"}
    [response] = simulate(iter([Setpoints("XY", PERIOD_S, 0, rows)]), servos)
    position, error = response.position, response.contour_error_mm
    figure = Figure(figsize=(8.0, 3.6), layout="constrained")
    path, course = figure.subplots(1, 2)
    path.plot(*rows.T, color="0.6", linewidth=3, label="commanded")
    path.plot(*position.T, color="C0", label="axes")
    k = int(np.argmax(error))
    path.plot(*rows[k], "o", color="0.3")
    path.plot(*position[k], "o", color="C0")
    path.plot(*np.transpose([position[k], rows[k]]), color="C1", label="tracking error")
    foot = rows[np.argmin(np.hypot(*(rows - position[k]).T))]
    path.plot(*np.transpose([position[k], foot]), color="C3", linewidth=2.5, label="contour error")
    path.set(xlabel="x, mm", ylabel="y, mm", aspect="equal", xlim=(-2.5, 3.0), ylim=(-0.7, 4.3))
    path.legend(frameon=False, fontsize=8)
    t = np.arange(len(rows)) * PERIOD_S
    course.plot(t, np.hypot(*(rows - position).T), color="C1", label="tracking error")
    course.plot(t, error, color="C3", label="contour error")
    course.set(xlabel="t, s", ylabel="mm")
    course.legend(frameon=False, fontsize=8)
    figure.savefig(HERE / "contour_error.png", dpi=90)


if __name__ == "__main__":
    main()

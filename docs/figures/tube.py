"""Draw the figure of tube.md, from our own plans: python docs/figures/tube.py."""

from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import cncgen

HERE = Path(__file__).parent
TOLERANCE_MM = 0.05


def planned(text: str, effort: str) -> np.ndarray:
    """Setpoints of a program, shape (n, 2), mm."""
    chunk = cncgen.sample(cncgen.plan(cncgen.read_text(text), "generic-mill", effort=effort)).collect()
    return np.asarray(chunk.position[:, :2])


def main() -> None:
    """Write tube.png beside this file."""
    points = np.array([(2.0 * i, 1.5 * (i % 2)) for i in range(9)])
    rows = "\n".join(f"G1 X{x:g} Y{y:g}" for x, y in points[1:])
    text = f"G21 G90 G94 G17 G64 P{TOLERANCE_MM} F6000\n{rows}\nM30\n"
    both = [
        (planned(text, effort), label)
        for effort, label in (("fast", "speed alone"), ("best", "path and speed"))
    ]
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    path, course = figure.subplots(1, 2)
    for a, b in pairwise(points):
        normal = TOLERANCE_MM * np.array([-(b - a)[1], (b - a)[0]]) / np.hypot(*(b - a))
        path.fill(*np.array([a + normal, b + normal, b - normal, a - normal]).T, color="0.9")
    for corner in points:
        path.fill(
            *(corner[:, None] + TOLERANCE_MM * np.array([np.cos(u := np.linspace(0, 7, 90)), np.sin(u)])),
            color="0.9",
        )
    path.plot(*points.T, color="0.6", linewidth=0.8, label="programmed")
    for x, label in both:
        path.plot(*x.T, ".-", markersize=2, linewidth=1, label=label)
        course.plot(np.arange(len(x) - 1), np.hypot(*np.diff(x, axis=0).T) * 1e3, label=label)
    path.set(
        xlim=(3.5, 6.5),
        ylim=(1.1, 1.65),
        xlabel="X, mm",
        ylabel="Y, mm",
        title="two corners of the zigzag, P0.05",
    )
    course.set(xlabel="time, ms", ylabel="speed, mm/s", title="speed along the path")
    path.legend(fontsize=8, loc="lower center")
    course.legend(fontsize=8)
    figure.savefig(HERE / "tube.png", dpi=110)


if __name__ == "__main__":
    main()

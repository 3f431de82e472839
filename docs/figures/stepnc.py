"""Figure of docs/stepnc.md: NIST's example, and the path that cncgen makes of it.

Run from the top of a checkout: ``python docs/figures/stepnc.py``.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from cncgen.stepnc import read
from cncgen.toolpath.record import FeedMode, Kind, Toolpath

HERE = Path(__file__).parent
PROGRAM = HERE.parents[1] / "programs" / "stepnc" / "nist_ex1.stp"
COLOURS = {"MILL 18MM": "tab:blue", "SPIRAL_DRILL_20MM": "tab:red", "REAMER_22MM": "tab:green"}


def points(path: Toolpath, row: int) -> np.ndarray:
    """Return points, shape (n, 3), of a line or arc."""
    start, end = path.starts[row, :3], path.end[row, :3]
    if path.kind[row] == Kind.LINE:
        return np.stack([start, end])
    k = path.curve[row]
    centre, normal, sweep = path.arcs.centre[k], path.arcs.normal[k], path.arcs.sweep[k]
    t = np.linspace(0.0, 1.0, 60)[:, None]
    u = start - centre
    rise = (end - start) @ normal
    return centre + np.cos(t * sweep) * u + np.sin(t * sweep) * np.cross(normal, u) + t * rise * normal


def main() -> None:
    """Draw the whole path in space, and one depth of the finished pocket from above."""
    (path,) = read(PROGRAM, PROGRAM.name).chunks()
    figure = plt.figure(figsize=(10, 4.5))
    space, above = figure.add_subplot(1, 2, 1, projection="3d"), figure.add_subplot(1, 2, 2)
    tool = ""
    for row in range(len(path)):
        if path.kind[row] == Kind.EVENT:
            event = path.events[path.curve[row]]
            tool = event.values["tool"] if event.name == "tool" else tool
            continue
        p = points(path, row)
        rapid = path.feed_mode[row] == FeedMode.RAPID
        if p[:, 2].max() < 60:
            space.plot(*p.T, ":" if rapid else "-", color="0.6" if rapid else COLOURS[tool], linewidth=0.6)
        if -2.01 < p[:, 2].min() < -1.99 and not rapid:
            above.plot(p[:, 0], p[:, 1], color=COLOURS[tool], linewidth=1.0)
    space.set(xlabel="X mm", ylabel="Y mm", zlabel="Z mm", title="face, hole and pocket from features alone")
    above.add_patch(plt.Rectangle((45, 30), 50, 80, fill=False, color="0.5", linestyle="--"))
    above.set(
        xlabel="X mm", ylabel="Y mm", title="finish pocket, first depth: helix, middle, rings", aspect="equal"
    )
    figure.tight_layout()
    figure.savefig(HERE / "stepnc.png", dpi=90)


if __name__ == "__main__":
    main()

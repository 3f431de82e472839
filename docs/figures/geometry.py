"""Figures of docs/nurbs.md, docs/arc-length.md and docs/smoothing.md, from our own programs.

Run from the top of a checkout: ``python docs/figures/geometry.py``.
"""

from __future__ import annotations

import sys
from pathlib import Path as File

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from cncgen import pipeline
from cncgen.geometry.curvature import curvature_extrema
from cncgen.planner.smoothing import smooth
from cncgen.toolpath.record import Toolpath
from cncgen.toolpath.slicing import join

HERE = File(__file__).parent
PROGRAMS = HERE.parents[1] / "programs"


def toolpath(name: str) -> Toolpath:
    return join(list(pipeline.read(PROGRAMS / f"{name}.nc").chunks()))


def nurbs() -> None:
    """The butterfly and its curvature, extrema marked."""
    path = toolpath("butterfly").path
    found = curvature_extrema(path)
    s = np.unique(np.concatenate([np.linspace(0, path.length, 20001), found.s]))
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), width_ratios=(1, 1.5))
    x = path.evaluate(s)[0]
    left.plot(x[:, 0], x[:, 1], lw=1)
    top = path.evaluate(found.s[found.is_maximum])[0]
    left.plot(top[:, 0], top[:, 1], ".", ms=4, color="C3")
    left.set(aspect="equal", xlabel="X, mm", ylabel="Y, mm", title="37 maxima of curvature")
    right.semilogy(s, path.curvature(s).clip(1e-4), lw=0.8)
    right.semilogy(found.s[found.is_maximum], found.curvature[found.is_maximum], ".", ms=4, color="C3")
    right.semilogy(
        found.s[~found.is_maximum], found.curvature[~found.is_maximum].clip(1e-4), ".", ms=4, color="C2"
    )
    right.set(xlabel="s, mm", ylabel="curvature, 1/mm", title="73 extrema in all")
    save(figure, "nurbs")


def arc_length() -> None:
    """Cells of the arc-length table, and how far u(s) is from the truth."""
    path = toolpath("butterfly").path
    measured = path._nurbs
    cells = measured.cells
    s = np.linspace(0, path.length, 40001)
    curve = np.zeros(len(s), np.int64)
    miss = np.abs(measured.at(curve, measured.parameter(curve, s)) - s)
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(8, 5), sharex=True)
    top.step(cells[:, 1], cells[:, 2], where="post", lw=0.8)
    top.set(yscale="log", ylabel="cell length, mm", title=f"{len(cells)} cells of the butterfly")
    bottom.semilogy(s, miss.clip(1e-16), ".", ms=1)
    bottom.set(xlabel="s, mm", ylabel="|s(u(s)) − s|, mm")
    save(figure, "arc_length")


def smoothing() -> None:
    """A sharp corner, the curvature of R5 corners, and short segments of the butterfly."""
    figure, (corner, ramp, facets) = plt.subplots(1, 3, figsize=(12, 3.8))
    sharp = toolpath("square_sharp")
    x = join(list(smooth([sharp]))).path.evaluate(np.linspace(49.8, 50.1, 4001))[0]
    corner.plot([49.9, 50, 50], [0, 0, 0.1], "k:", lw=1)
    corner.plot(x[:, 0], x[:, 1])
    corner.set(
        aspect="equal",
        xlim=(49.9, 50.02),
        ylim=(-0.02, 0.1),
        xlabel="X, mm",
        ylabel="Y, mm",
        title="sharp, P 0.01",
    )
    rounded = toolpath("square_r5")
    for rows, style, name in (
        (rounded, "k:", "programmed"),
        (join(list(smooth([rounded]))), "-", "smoothed"),
    ):
        path = rows.path
        s = np.linspace(38, 50, 6001)
        ramp.plot(s, path.curvature(s), style, label=name)
    ramp.set(xlabel="s, mm", ylabel="curvature, 1/mm", title="line to R5, P 0.01")
    ramp.legend()
    path = join(list(smooth([toolpath("butterfly_g1")]))).path
    s = np.linspace(100, 130, 6001)
    facets.plot(s, np.abs(path.evaluate(s, 3)[3][:, :2]).max(axis=1), lw=0.8)
    facets.set(
        yscale="log",
        xlabel="s, mm",
        ylabel="max |x'''| of the axes, 1/mm²",
        title="2000 short segments, fitted",
    )
    save(figure, "smoothing")


def save(figure: plt.Figure, name: str) -> None:
    figure.tight_layout()
    figure.savefig(HERE / f"{name}.png", dpi=90)
    plt.close(figure)


if __name__ == "__main__":
    for draw in (nurbs, arc_length, smoothing):
        if len(sys.argv) < 2 or draw.__name__ in sys.argv[1:]:
            draw()

"""Classes of rows that may be smoothed together: runs between rows and places that must be met exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.columns import max_over_axes, norm
from cncgen.geometry.path import STANDSTILL, Path
from cncgen.planner.smoothing.tolerance_split import Chords
from cncgen.toolpath.record import FeedMode, Kind, PathMode, Toolpath

Floats = NDArray[np.float64]

#: mm: a tolerance below it means the path exactly.
LEAST_TOLERANCE = 1e-6
#: cos of the turn (166°) beyond which a corner is met exactly, here and by `cncgen.planner.tube`. From 150° on, 61 random programs took
#: 1.0 % longer with `--effort fast` and 0.3 % with `best`. With no such bound 175 others take 0.6 % less with `fast`, but three of them
#: up to 2.8 % longer, and with `best` one of 49 3.7 %.
SHARPEST = -0.97
#: Where tangents differ by less (as mm per mm), a joint with a row that is met exactly is smooth, and is kept so.
TANGENT = 0.01


@dataclass(frozen=True, slots=True)
class Classes:
    """How the rows of a toolpath are to be treated.

    Attributes:
        fits: Shape (n,): rows that move and may be smoothed.
        idle: Shape (n,): rows within a run that neither move nor stop it: events without rest, moves of no length.
        parts: Shape (n,): True where a row cannot be in one run with the row before it.
        entry, leave: Shape (n, axes): dx/ds at start and end of each row, scaled; 0 for rows without direction.
    """

    fits: NDArray[np.bool_]
    idle: NDArray[np.bool_]
    parts: NDArray[np.bool_]
    entry: Floats
    leave: Floats


def rests(toolpath: Toolpath) -> NDArray[np.bool_]:
    """Tell at which rows the axes rest: events that need it."""
    event = toolpath.kind == Kind.EVENT
    out = np.zeros(len(toolpath), bool)
    out[event] = [e.stands for e in (toolpath.events[k] for k in toolpath.curve[event])]
    return out


def rapid(toolpath: Toolpath) -> NDArray[np.bool_]:
    """Tell which rows are rapids. Where they meet others the path is met exactly: cuts begin and end where they are programmed to."""
    out: NDArray[np.bool_] = toolpath.feed_mode == FeedMode.RAPID
    return out


def loose(toolpath: Toolpath) -> NDArray[np.bool_]:
    """Tell which rows have a tolerance within which the motion may leave them."""
    out: NDArray[np.bool_] = (toolpath.path_mode == PathMode.CONTINUOUS) & (
        toolpath.tolerance >= LEAST_TOLERANCE
    )
    return out


def classify(
    toolpath: Toolpath,
    path: Path,
    scale: Floats,
    free: NDArray[np.bool_] | None = None,
    chords: Chords | None = None,
) -> Classes:
    """Sort the rows of a toolpath; see `Classes`.

    Args:
        toolpath, path: The rows and their geometry.
        scale: Shape (axes,): factors from the columns to mm.
        free: Shape (n,): NURBS rows that may be smoothed (`cncgen.planner.smoothing.ends`); None for none.
        chords: Those of a machine, which meets some corners exactly; None for none.
    """
    length = np.diff(path.row_s)
    count = len(toolpath)
    entry, leave = _tangents(path, scale)
    event = toolpath.kind == Kind.EVENT
    resting = rests(toolpath)
    away = max_over_axes(np.abs(toolpath.end - toolpath.starts)) if count else np.zeros(0)
    idle = (event & ~resting) | ((toolpath.kind == Kind.LINE) & (away <= STANDSTILL))
    within = (toolpath.kind == Kind.LINE) | (toolpath.kind == Kind.ARC)
    if free is not None:
        within |= free
    fits = within & loose(toolpath) & (length > STANDSTILL) & ~idle & path.moves_xyz
    parts = np.ones(count, bool)
    member = fits | idle
    parts[1:] = member[1:] != member[:-1]
    moving, swift = np.flatnonzero(fits), rapid(toolpath)
    one, two = moving[:-1], moving[1:]
    met = np.einsum("ij,ij->i", leave[one, :3], entry[two, :3]) < SHARPEST
    met |= swift[one] != swift[two]
    if chords is not None:
        # Over all axes: beside X Y Z that hardly move, a small turn of the others is a large one.
        size = norm(entry)
        narrow, near = (np.minimum(each[one], each[two]) for each in (toolpath.tolerance, length * size))
        before, behind = leave[one] / norm(leave[one])[:, None], entry[two] / size[two][:, None]
        met |= chords.unseen(narrow, norm(behind - before), near)
    parts[two[met]] = True
    return Classes(fits, idle, parts, entry, leave)


def _tangents(path: Path, scale: Floats) -> tuple[Floats, Floats]:
    """Return dx/ds at the start and at the end of each row that moves X Y Z."""
    rows = np.arange(len(path))
    out = []
    for at, side in ((path.row_s[:-1], 1), (path.row_s[1:], -1)):
        u = path.parameter(rows, at, side)
        x1 = path.evaluate_parameter(rows, u, 1, side)[1]
        speed = norm(x1[:, :3])[:, None]
        out.append(np.divide(x1 * scale, speed, out=np.zeros_like(x1), where=speed > 0))
    return out[0], out[1]

"""Toolpaths of lines only, for readers without curves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from cncgen.geometry.linearize import linearize
from cncgen.geometry.path import Path
from cncgen.geometry.tables import empty_arcs, empty_nurbs
from cncgen.toolpath.record import FeedMode, Kind, Toolpath


def lines_alone(toolpaths: Iterable[Toolpath], tolerance_mm: float) -> Iterator[Toolpath]:
    """Yield toolpaths with arcs and NURBS cut into lines, events and all else as they are.

    Args:
        toolpaths: Consecutive stretches of a program.
        tolerance_mm: Largest distance of a line from its curve, over all axes (mm and rad).
    """
    for toolpath in toolpaths:
        if len(toolpath.arcs) or len(toolpath.nurbs):
            yield _cut(toolpath, tolerance_mm)
        else:
            yield toolpath


def _cut(t: Toolpath, tolerance_mm: float) -> Toolpath:
    points, rows = linearize(Path(t.axes, t.start, t.kind, t.end, t.curve, t.arcs, t.nurbs), tolerance_mm)
    # Events, and rows that go nowhere, have no place of their own on the path.
    still = np.setdiff1d(np.arange(len(t)), rows)
    of = np.concatenate([rows, still])
    order = np.argsort(of, kind="stable")
    of, end = of[order], np.concatenate([points, t.end[still]])[order]
    event = t.kind[of] == Kind.EVENT
    # A motion of 1/F seconds gives each of its lines as much of them as it has of the way.
    step = np.linalg.norm(np.diff(end, axis=0, prepend=t.start[None, :])[:, :3], axis=1)
    whole = np.bincount(of, step, minlength=len(t))[of]
    count = np.bincount(of, minlength=len(t))[of]
    share = np.where(whole > 0.0, step / np.where(whole > 0.0, whole, 1.0), 1.0 / count)
    timed = (t.feed_mode[of] == FeedMode.INVERSE_TIME) & (share > 0.0)
    columns = t.columns(of) | {
        "kind": np.where(event, Kind.EVENT, Kind.LINE).astype(np.int8),
        "end": end,
        "feed": np.where(timed, t.feed[of] / np.where(share > 0.0, share, 1.0), t.feed[of]),
        "curve": np.where(event, t.curve[of], -1),
    }
    return replace(
        t,
        **columns,
        arcs=empty_arcs(),
        nurbs=empty_nurbs(len(t.axes)),
    )

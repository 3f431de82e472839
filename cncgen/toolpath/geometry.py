"""The path that a toolpath describes."""

from __future__ import annotations

from cncgen.geometry.path import Path
from cncgen.toolpath.record import Toolpath


def path_of(toolpath: Toolpath, s_start: float = 0.0) -> Path:
    """Return the rows of a toolpath as functions of the path coordinate, which is `s_start` at its start."""
    return Path(
        toolpath.axes,
        toolpath.start,
        toolpath.kind,
        toolpath.end,
        toolpath.curve,
        toolpath.arcs,
        toolpath.nurbs,
        s_start,
    )

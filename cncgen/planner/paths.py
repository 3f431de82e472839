"""The geometry of a toolpath, made once for the stages that ask for it in turn."""

from __future__ import annotations

from collections import deque

from cncgen.geometry.path import Path
from cncgen.toolpath.record import Toolpath

#: The last toolpaths with their paths: planner, blending and sampling ask for the same ones one after the other, the
#: planner in another thread and some blocks ahead.
_recent: deque[tuple[Toolpath, Path]] = deque(maxlen=12)


def path_of(toolpath: Toolpath) -> Path:
    """Return the path of a toolpath, its coordinate from 0 at the start; the same object when asked again soon."""
    for known, path in tuple(_recent):
        if known is toolpath:
            return path
    t = toolpath
    path = Path(t.axes, t.start, t.kind, t.end, t.curve, t.arcs, t.nurbs)
    _recent.append((toolpath, path))
    return path

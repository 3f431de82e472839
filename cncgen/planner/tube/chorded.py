"""Curves as chords, for the plan that the search starts from.

Smoothing rounds the corners of lines, and meets a curve exactly. So the plan of a NURBS slows down where it bends within a few
tolerances, and the search went on from there to a motion that took up to 22 % longer than that of the curve's own chords.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from cncgen.geometry.linearize import chords
from cncgen.machine.record import Machine
from cncgen.planner.limits.axis_limits import axis_scale, chord_reserve
from cncgen.planner.smoothing.ends import regular
from cncgen.planner.smoothing.runs import loose
from cncgen.toolpath.record import Kind, Toolpath
from cncgen.toolpath.slicing import between

#: Part of the tolerance that chords take; smoothing has the rest.
_SHARE = 0.3
#: Least tolerance as a multiple of the chords between setpoints, which smoothing shares it with (`smoothing.tolerance_split`). At one, a
#: curve that it meets exactly takes less time.
_WIDE = 4.0


def chorded(chunks: Iterable[Toolpath], machine: Machine) -> Iterator[Toolpath]:
    """Hand on chunks, with lines in place of NURBS whose tolerance is much wider than the chords between setpoints."""
    for chunk in chunks:
        yield _chorded(chunk, _WIDE * chord_reserve(machine, chunk.axes))


def _chorded(toolpath: Toolpath, least_mm: float) -> Toolpath:
    curves = (toolpath.kind == Kind.NURBS) & loose(toolpath) & (toolpath.tolerance >= least_mm)
    if not curves.any():
        return toolpath
    path = toolpath.path
    # A chord would not meet the place where a curve turns back.
    curves &= path.moves_xyz & regular(toolpath, path)
    rows = np.flatnonzero(curves)
    of, part, x = chords(path, rows, _SHARE * toolpath.tolerance[rows], axis_scale(toolpath.axes))
    inner = part > 0.0
    # A chord that begins inside of a row ends the one before it.
    row = np.concatenate([np.arange(len(toolpath)), rows[of[inner]]])
    order = np.lexsort((np.concatenate([np.ones(len(toolpath)), part[inner]]), row))
    row = row[order]
    columns = toolpath.columns(row)
    cut = curves[row]
    columns["end"] = np.concatenate([toolpath.end, x[inner]])[order]
    columns["kind"] = np.where(cut, np.int8(Kind.LINE), columns["kind"])
    columns["curve"] = np.where(cut, -1, columns["curve"])
    columns["tolerance"] = columns["tolerance"] * np.where(cut, 1.0 - _SHARE, 1.0)
    lines = replace(toolpath, **columns)
    return between(lines, 0, len(lines))

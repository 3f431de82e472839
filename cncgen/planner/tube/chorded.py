"""Curves as lines: their sharp bends for the search, and all of them for the plan that it starts from (docs/tube.md, First guess)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry.columns import norm
from cncgen.geometry.linearize import chords
from cncgen.geometry.path import Path
from cncgen.geometry.splitting import split
from cncgen.machine.record import Machine
from cncgen.planner.limits.axis_limits import axis_scale, chord_reserve
from cncgen.planner.smoothing.ends import regular
from cncgen.planner.smoothing.runs import loose
from cncgen.toolpath.record import Kind, Toolpath
from cncgen.toolpath.slicing import between, join

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Part of the tolerance that chords of the plan take; smoothing has the rest.
_SHARE = 0.3
#: Part of it that chords of a bend take, and their turn from which on it is one, rad. Such chords are √(8 · part · P R) long, so they turn
#: by as much in a bend whose radius R is two and a half tolerances.
_FINE, _TURN = 0.003, 0.1
#: Least tolerance as a multiple of the chords between setpoints, which smoothing shares it with (`smoothing.tolerance_split`). At one, a
#: curve that it meets exactly takes less time.
_WIDE = 4.0


def cornered(chunks: Iterable[Toolpath]) -> Iterator[Toolpath]:
    """Hand on chunks, with lines in place of arcs and those parts of NURBS that bend more sharply than a few tolerances, or in a corner."""
    for chunk in chunks:
        yield _cornered(chunk)


def chorded(chunks: Iterable[Toolpath], machine: Machine) -> Iterator[Toolpath]:
    """Hand on chunks, with lines in place of NURBS whose tolerance is much wider than the chords between setpoints."""
    for chunk in chunks:
        yield _chorded(chunk, machine)


def _cornered(toolpath: Toolpath) -> Toolpath:
    """Return a toolpath whose sharp arcs are lines, and whose NURBS are cut beside their sharp bends, which are."""
    toolpath = _as_chords(toolpath, toolpath.path, _tight(toolpath), _FINE)
    path, rows = _curves(toolpath)
    if not len(rows):
        return toolpath
    of, part, x = chords(
        path, rows, _FINE * toolpath.tolerance[rows], axis_scale(toolpath.axes, toolpath.degree_mm)
    )
    sharp = _sharp(of, x, toolpath.end[rows], axis_scale(toolpath.axes, toolpath.degree_mm))
    cut: list[Toolpath] = []
    done = 0
    for k in np.unique(of[sharp]).tolist():
        own, row = slice(*np.searchsorted(of, [k, k + 1])), int(rows[k])
        cut += [between(toolpath, done, row), _cut(toolpath, path, row, sharp[own], part[own], x[own])]
        done = row + 1
    return join([*cut, between(toolpath, done, len(toolpath))]) if cut else toolpath


def _sharp(of: Ints, x: Floats, end: Floats, scale: Floats) -> NDArray[np.bool_]:
    """Tell which chords meet another one of the same curve in a sharp turn.

    Args:
        of: Shape (n,), which curve each is of, ascending.
        x: Shape (n, axes), where they begin.
        end: Shape (curves, axes), where each curve ends.
        scale: Shape (axes,).
    """
    if not len(of):
        # Curves of one place have no chords.
        return np.zeros(0, bool)
    last = np.append(of[1:] != of[:-1], True)
    stop = np.concatenate([x[1:], x[:1]])
    stop[last] = end[of[last]]
    way = (stop - x) * scale
    way /= np.maximum(np.sqrt((way**2).sum(axis=1)), 1e-300)[:, None]
    turn = ~last[:-1] & (np.sqrt((np.diff(way, axis=0) ** 2).sum(axis=1)) > _TURN)
    return np.append(turn, False) | np.append(False, turn)


def _cut(
    toolpath: Toolpath, path: Path, row: int, sharp: NDArray[np.bool_], part: Floats, x: Floats
) -> Toolpath:
    """Return a NURBS row as the curves between its sharp chords, and these; as it is where these are at one parameter.

    Args:
        toolpath, path: It and its geometry.
        row: Which row.
        sharp: Shape (chords,), which of its chords are.
        part: Shape (chords,), the part of its parameter at which each begins.
        x: Shape (chords, axes), where each begins.
    """
    one = between(toolpath, row, row + 1)
    # A row for each sharp chord, and for each run of others, which are a curve.
    runs = np.flatnonzero(np.append(True, sharp[1:] != sharp[:-1]))
    begin = np.flatnonzero(np.append(True, sharp[1:] | sharp[:-1]))
    first, last = (
        path.parameter_after(np.array([row]), at, side)
        for at, side in ((np.zeros(1), 1), (path.row_length[[row]], -1))
    )
    lines = sharp[begin]
    columns = one.columns(np.zeros(len(begin), np.int64))
    columns["end"] = np.concatenate([x[begin[1:]], one.end])
    columns["kind"] = np.where(lines, np.int8(Kind.LINE), np.int8(Kind.NURBS))
    columns["curve"] = np.where(lines, -1, np.searchsorted(runs, begin))
    columns["tolerance"] = columns["tolerance"] * np.where(lines, 1.0 - _FINE, 1.0)
    at = first + part[runs[1:]] * (last - first)
    if not (np.diff(np.concatenate([first, at, last])) > 0.0).all():
        # Sharp chords at one parameter, by rounding: the curve cannot come apart there.
        return one
    pieces = split(one.nurbs, 0, at)
    cut = replace(one, nurbs=pieces, **columns)
    return between(cut, 0, len(cut))


def _chorded(toolpath: Toolpath, machine: Machine) -> Toolpath:
    """Return a toolpath whose NURBS are chords."""
    path, rows = _curves(toolpath)
    if len(rows):
        wide = toolpath.tolerance >= _WIDE * chord_reserve(machine, toolpath.axes)
        # The plan would round the corner where a curve turns back, and lose its tip.
        rows = rows[(wide & regular(toolpath, path))[rows]]
    return _as_chords(toolpath, path, rows, _SHARE)


def _as_chords(toolpath: Toolpath, path: Path, rows: Ints, share: float) -> Toolpath:
    """Return a toolpath with chords in place of some of its rows, that take a part of their tolerance."""
    if not len(rows):
        return toolpath
    of, part, x = chords(
        path, rows, share * toolpath.tolerance[rows], axis_scale(toolpath.axes, toolpath.degree_mm)
    )
    inner = part > 0.0
    # A chord that begins inside of a row ends the one before it.
    row = np.concatenate([np.arange(len(toolpath)), rows[of[inner]]])
    order = np.lexsort((np.concatenate([np.ones(len(toolpath)), part[inner]]), row))
    row = row[order]
    columns = toolpath.columns(row)
    cut = np.isin(row, rows)
    columns["end"] = np.concatenate([toolpath.end, x[inner]])[order]
    columns["kind"] = np.where(cut, np.int8(Kind.LINE), columns["kind"])
    columns["curve"] = np.where(cut, -1, columns["curve"])
    columns["tolerance"] = columns["tolerance"] * np.where(cut, 1.0 - share, 1.0)
    lines = replace(toolpath, **columns)
    return between(lines, 0, len(lines))


def _tight(toolpath: Toolpath) -> Ints:
    """Return which rows are arcs that bend as sharply all along."""
    path = toolpath.path
    arcs = np.flatnonzero((toolpath.kind == Kind.ARC) & loose(toolpath) & path.moves_xyz)
    bend = norm(path.evaluate(path.row_s[arcs], 2, 1)[2] * axis_scale(toolpath.axes, toolpath.degree_mm))
    # A chord is √(8 · part · P R) long.
    return arcs[8.0 * _FINE * toolpath.tolerance[arcs] * bend > _TURN**2]


def _curves(toolpath: Toolpath) -> tuple[Path, Ints]:
    """Return the path of a toolpath, and which of its rows are NURBS that lines may stand for."""
    path = toolpath.path
    curves = (toolpath.kind == Kind.NURBS) & loose(toolpath)
    return path, np.flatnonzero(curves & path.moves_xyz if curves.any() else curves)

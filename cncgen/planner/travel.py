"""Travel of the axes: where a program's motions leave it, at their ends or along curves.

Motions beyond the travel, from the one that leaves it to the one that comes back, are one excursion: a work offset that was forgotten is
one fault, not one of each line that follows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import MAX_KEPT, Diagnostic, Diagnostics, Severity, Span
from cncgen.geometry.arcs import spirals
from cncgen.geometry.extents import arc_extents, hulls, nurbs_extents
from cncgen.geometry.tables import ArcTable
from cncgen.machine.record import Machine
from cncgen.toolpath.record import Kind, Toolpath
from cncgen.units import file_unit, to_file

Floats = NDArray[np.float64]

#: A place is beyond the travel by more than this, mm or rad: the ninth decimal of a setpoint.
_ROUNDING = 1e-9


@dataclass(slots=True)
class _Excursion:
    """Motions of one axis beyond its travel, one after another.

    Attributes:
        begin: The line of the first one.
        furthest: The line that goes furthest.
        position: How far, mm or rad.
        ends: Whether its motion ends there.
        beyond: How far that is beyond the travel.
        count: Number of motions.
    """

    begin: Span
    furthest: Span
    position: float
    ends: bool
    beyond: float
    count: int

    def joined(self, other: _Excursion) -> None:
        """Take in one that goes on from this, or is another run of the same line."""
        self.count += other.count
        if other.beyond > self.beyond:
            self.furthest, self.position, self.ends = other.furthest, other.position, other.ends
            self.beyond = other.beyond


class Travel:
    """The excursions of a program, found in one chunk after another.

    Excursions that begin on the same line are one: a loop runs it many times.
    """

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._found: dict[tuple[str, Span], _Excursion] = {}
        self._open: dict[str, _Excursion] = {}
        self._more = 0
        self._start: list[Diagnostic] = []
        self._begun = False

    @property
    def is_left(self) -> bool:
        """Tell whether a motion has left the travel so far."""
        return bool(self._found or self._start)

    def add(self, chunk: Toolpath) -> None:
        """Look at the next chunk."""
        axes = [self._machine.axes.get(letter) for letter in chunk.axes]
        low, high = np.array([axis.travel if axis and axis.travel else (-np.inf, np.inf) for axis in axes]).T
        low, high = low - _ROUNDING, high + _ROUNDING
        if not self._begun:
            self._begun = True
            moves = (chunk.end != chunk.start).any(axis=0)
            for column in np.flatnonzero(moves & ((chunk.start < low) | (chunk.start > high))).tolist():
                self._start.append(self._starts_beyond(chunk, column))
        if not np.isfinite([low, high]).any():
            return
        rows = np.flatnonzero(chunk.kind != Kind.EVENT)
        lowest, highest = (each[rows] for each in _reach(chunk, low, high))
        beyond = np.maximum(low - lowest, highest - high)
        place = np.where(low - lowest > highest - high, lowest, highest)
        for column, letter in enumerate(chunk.axes):
            outside = np.concatenate([[False], beyond[:, column] > 0.0, [False]])
            goes_on = self._open.pop(letter, None)
            for first, last in np.flatnonzero(np.diff(outside)).reshape(-1, 2).tolist():
                worst = first + int(beyond[first:last, column].argmax())
                position = float(place[worst, column])
                found = _Excursion(
                    begin=chunk.span(rows[first]),
                    furthest=chunk.span(rows[worst]),
                    position=position,
                    ends=position == chunk.end[rows[worst], column],
                    beyond=float(beyond[worst, column]),
                    count=last - first,
                )
                kept = self._kept(letter, found, goes_on if first == 0 else None)
                if kept is not None and last == len(rows):
                    self._open[letter] = kept
            if goes_on is not None and not len(rows):
                self._open[letter] = goes_on

    def _kept(self, letter: str, found: _Excursion, before: _Excursion | None) -> _Excursion | None:
        """Keep an excursion, as a part of the one before it or of one that began on the same line; return that, None if it is only counted."""
        known = before or self._found.get((letter, found.begin))
        if known is not None:
            known.joined(found)
        elif len(self._found) < MAX_KEPT:
            known = self._found[letter, found.begin] = found
        else:
            self._more += 1
        return known

    def tell(self, found: Diagnostics) -> None:
        """Add the faults to `found`."""
        found.extend(self._start)
        for (letter, _), each in self._found.items():
            found.add(self._beyond(letter, each))
        found.counts[Severity.ERROR] += self._more

    def _beyond(self, letter: str, found: _Excursion) -> Diagnostic:
        """Name an excursion."""
        scale, unit = to_file(letter), file_unit(letter)
        where = ""
        if found.furthest != found.begin:
            file = "" if found.furthest.file == found.begin.file else f" of {found.furthest.file}"
            where = f" (line {found.furthest.line}{file})"
        more = f"; {found.count} motions from here on are beyond it" if found.count > 1 else ""
        return self._fault(
            letter,
            f"{'is sent to' if found.ends else 'reaches'} {found.position * scale:.4f} {unit}{where}",
            more,
            found.begin,
            found.position,
        )

    def _starts_beyond(self, chunk: Toolpath, column: int) -> Diagnostic:
        """Name an axis that stands beyond its travel before the first motion."""
        letter, start = chunk.axes[column], float(chunk.start[column])
        verb = f"starts at {start * to_file(letter):.4f} {file_unit(letter)}"
        hint = "say where the machine stands in a comment before the first motion: (START, X... Y...)"
        return self._fault(letter, verb, "", chunk.span(0), start, hint)

    def _fault(
        self, letter: str, verb: str, more: str, span: Span, position: float, hint: str = ""
    ) -> Diagnostic:
        scale, unit = to_file(letter), file_unit(letter)
        low, high = (end * scale for end in self._machine.axes[letter].travel or (-np.inf, np.inf))
        return Diagnostic(
            "travel-exceeded",
            f"axis {letter} {verb}, beyond its travel of {low:g} to {high:g} {unit}{more}",
            span=span,
            hint=hint,
            values={"axis": letter, "value": position * scale, "low": low, "high": high},
        )


def _reach(chunk: Toolpath, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Return the lowest and highest coordinates of each row, each of shape (n, axes).

    Of lines the end alone (their start is the end before), of NURBS too where their hull stays between low and high.
    """
    lowest, highest = chunk.end.copy(), chunk.end.copy()
    rows = np.flatnonzero(chunk.kind == Kind.ARC)
    if len(rows):
        lowest[rows], highest[rows] = _arcs_reach(chunk, rows)
    rows = np.flatnonzero(chunk.kind == Kind.NURBS)
    if len(rows):
        bottom, top = hulls(chunk.nurbs)
        leaves = np.any((bottom < low) | (top > high), axis=1)
        for row in rows[np.take(leaves, chunk.curve[rows])]:
            lowest[row], highest[row] = nurbs_extents(chunk.nurbs, int(chunk.curve[row]))
    return lowest, highest


def _arcs_reach(chunk: Toolpath, rows: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Return the lowest and highest coordinates of rows that are arcs, each of shape (rows, axes)."""
    table, index = chunk.arcs, chunk.curve[rows]
    arcs = ArcTable(table.centre[index], table.normal[index], table.sweep[index])
    return arc_extents(spirals(arcs, chunk.starts[rows], chunk.end[rows]))


def moved(chunk: Toolpath) -> NDArray[np.bool_]:
    """Tell which axes each row moves, shape (n, axes): along a curve too, which may come back to where it began."""
    moves = chunk.end != chunk.starts
    rows = np.flatnonzero(chunk.kind == Kind.ARC)
    if len(rows):
        low, high = _arcs_reach(chunk, rows)
        moves[rows] |= high - low > _ROUNDING
    rows = np.flatnonzero(chunk.kind == Kind.NURBS)
    if len(rows):
        bottom, top = hulls(chunk.nurbs)
        moves[rows] |= (top - bottom > _ROUNDING)[chunk.curve[rows]]
    return moves

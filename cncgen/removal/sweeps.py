"""Rows of a toolpath as straight lines of the tool's tip."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, ProgramError
from cncgen.toolpath.record import FeedMode, Kind, Toolpath

Floats = NDArray[np.float64]

#: Pieces of one motion that turns the tool's axis; each takes some 20 µs and 1 kB.
MOST_PIECES = 100_000


class Poses(Protocol):
    """Tells where tools are: seen from the workpiece, of the axes of a machine."""

    def __call__(self, letters: str, positions: Floats) -> tuple[Floats, Floats]:
        """Return tips and tool axes (of length 1, away from the tip), shapes (n, 3), of positions, shape (n, letters), mm and rad."""

    def offset(self, length_mm: float) -> None:
        """Take the length of the tool, as G43 has it, from now on."""


class Lines(NamedTuple):
    """Straight lines in the order of the motion.

    Attributes:
        ends: Shape (n, 6): start and end, mm.
        line: Shape (n,): source line of each.
        rapid: Shape (n,), bool.
        seconds: Shape (n,): at the programmed feed, 0 for rapids.
        axes: Shape (n, 3): the tool's axis during each, away from the tip; None of upright tools.
        turning: Shape (n,), bool: the axis turned meanwhile, which pieces of one direction stand for; None of upright tools.
    """

    ends: Floats
    line: NDArray[np.int64]
    rapid: NDArray[np.bool_]
    seconds: Floats
    axes: Floats | None = None
    turning: NDArray[np.bool_] | None = None


def lines_of(path: Toolpath, begin: int, end: int) -> Lines:
    """Return the motions among the rows `begin` to `end` of a toolpath that has lines alone."""
    rows = _motions(path, begin, end)
    ends = np.ascontiguousarray(np.concatenate([path.starts[rows, :3], path.end[rows, :3]], axis=1))
    return Lines(ends, path.line[rows], *_times(path, rows))


def leaning_lines_of(
    path: Toolpath, begin: int, end: int, poses: Poses, turns_at: Callable[[Floats, Floats], Floats]
) -> Lines:
    """Return the same of tools that lean: pieces during which the tool's axis turns by no more than angles of tips and axes, rad.

    Each piece has the axis of its middle.

    Raises:
        ProgramError: A motion turns the axis so far that it would be more pieces than `MOST_PIECES`.
    """
    rows = _motions(path, begin, end)
    rapid, seconds = _times(path, rows)
    starts, stops = path.starts[rows], path.end[rows]
    rotary = [k for k, letter in enumerate(path.axes) if letter in "ABC"]
    turns = np.abs(stops[:, rotary] - starts[:, rotary]).sum(axis=1)
    least = np.minimum(turns_at(*poses(path.axes, starts)), turns_at(*poses(path.axes, stops)))
    count = np.maximum(np.ceil(turns / least - 1e-9), 1.0)
    if count.max(initial=0.0) > MOST_PIECES:
        raise ProgramError(_far_turned(path, int(rows[count.argmax()]), float(count.max())))
    pieces = count.astype(np.int64)
    of = np.repeat(np.arange(len(rows)), pieces)
    number = np.arange(len(of)) - np.repeat(np.cumsum(pieces) - pieces, pieces)

    def at(share: Floats) -> tuple[Floats, Floats]:
        where = starts[of] + ((number + share) / pieces[of])[:, None] * (stops - starts)[of]
        return poses(path.axes, where)

    zero, half, one = (np.full(len(of), share) for share in (0.0, 0.5, 1.0))
    ends = np.ascontiguousarray(np.concatenate([at(zero)[0], at(one)[0]], axis=1))
    axes = np.ascontiguousarray(at(half)[1])
    return Lines(ends, path.line[rows][of], rapid[of], (seconds / pieces)[of], axes, (turns > 0)[of])


def _far_turned(path: Toolpath, row: int, pieces: float) -> Diagnostic:
    return Diagnostic(
        "cut-turns",
        f"the motion turns the tool's axis so far that it is cut in {pieces:.6g} pieces, more than {MOST_PIECES}",
        span=path.span(row),
        hint="was a decimal point lost? a larger --cell makes fewer pieces",
    )


def _motions(path: Toolpath, begin: int, end: int) -> NDArray[np.int64]:
    return np.arange(begin, end)[path.kind[begin:end] != Kind.EVENT]


def _times(path: Toolpath, rows: NDArray[np.int64]) -> tuple[NDArray[np.bool_], Floats]:
    """Return which rows are rapids, and how long each takes at the programmed feed."""
    rapid = path.feed_mode[rows] == FeedMode.RAPID
    inverse = path.feed_mode[rows] == FeedMode.INVERSE_TIME
    way = np.linalg.norm(path.end[rows, :3] - path.starts[rows, :3], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        seconds = np.where(inverse, 1.0, way) / path.feed[rows]
    return rapid, np.where(rapid | ~np.isfinite(seconds), 0.0, seconds)

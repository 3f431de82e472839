"""A program's text for the page: its numbers apart from the words between them.

Most of a long program is coordinates, and a coordinate differs little from the previous one with the same letter.
So the text is kept as a *skeleton*, with one byte for each number, and as columns of integers, differenced and deflated. The text is
restored byte by byte; docs/page.md describes the format.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.report.page.streams import Blob

Integers = NDArray[np.int64]
Bytes = NDArray[np.uint8]

#: Bytes that UTF-8 never has stand for numbers: a whole one; one with as few decimals as show it; one with 0 to 6 decimals.
WHOLE, FEWEST, FIXED = 0xC0, 0xC1, 0xF5
MOST_DECIMALS = 6
_MOST_DIGITS = 9
#: Numbers of one place in a line that count apart; a column with fewer numbers joins the last column.
PLACES, LEAST = 16, 64
#: Bytes that are taken at once; with a longer line than the second number the text is deflated directly.
_PIECE, _LONGEST_LINE = 1 << 20, 1 << 20
_DIGIT_0, _POINT, _MINUS, _NEWLINE = b"0.-\n"
_TENS = 10 ** np.arange(_MOST_DIGITS + MOST_DECIMALS + 1, dtype=np.int64)


@dataclass(frozen=True, slots=True)
class _Style:
    """How a text writes its numbers: with as few decimals as show them, and 0.5 as .5."""

    fewest: bool
    bare: bool


def put_text(text: bytes, blob: Blob) -> list[int] | dict[str, Any]:
    """Put a text into a blob; return the data for a reader.

    Args:
        text: In UTF-8.
        blob: Where it goes.

    Returns: Its place, if it is deflated directly; else ``{length, bare, skeleton, columns}``.
    """
    if any(len(piece) > _PIECE + _LONGEST_LINE for piece in _pieces(text)):
        return blob.put(zlib.compress(text, 6))
    style = _style(np.frombuffer(next(_pieces(text), b""), np.uint8))
    squeezed = zlib.compressobj(6)
    skeleton: list[bytes] = []
    found: list[tuple[Integers, NDArray[np.int8], NDArray[np.int16]]] = []
    for piece in _pieces(text):
        words, values, decimals, keys = _taken(np.frombuffer(piece, np.uint8), style)
        skeleton.append(squeezed.compress(words.tobytes()))
        found.append((values, decimals, keys))
    skeleton.append(squeezed.flush())
    values, decimals, keys = (
        (np.concatenate(parts) for parts in zip(*found, strict=True)) if found else _NOTHING
    )
    return {
        "length": len(text),
        "bare": style.bare,
        "skeleton": blob.put(b"".join(skeleton)),
        "columns": _columns(values, decimals, keys, blob),
    }


_NOTHING = (np.zeros(0, np.int64), np.zeros(0, np.int8), np.zeros(0, np.int16))


def _pieces(text: bytes) -> Iterator[bytes]:
    """Yield a text in pieces that end with a line."""
    start = 0
    while start < len(text):
        end = text.find(b"\n", start + _PIECE) + 1 or len(text)
        yield text[start:end]
        start = end


def _runs(text: Bytes) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Return first byte, end, number of points and place of the last point of each run of digits and points."""
    point = text == _POINT
    among = ((text - np.uint8(_DIGIT_0)) < 10) | point
    edges = np.flatnonzero(np.diff(np.concatenate([[False], among, [False]])))
    first, end = edges[0::2], edges[1::2]
    points = np.concatenate([[0], np.flatnonzero(point) + 1])
    upto = np.searchsorted(points, end, side="right")
    count = upto - np.searchsorted(points, first, side="right")
    return first, end, count, points[upto - 1] - 1


def _style(text: Bytes) -> _Style:
    """Return how a text writes numbers: whether few of those with a point end in 0, and whether more begin with a point than with 0."""
    first, end, count, _ = _runs(text)
    first, end = first[count == 1], end[count == 1]
    if not len(first):
        return _Style(False, False)
    bare = np.count_nonzero(text[first] == _POINT)
    nought = np.count_nonzero(
        (text[first] == _DIGIT_0) & (text[np.minimum(first + 1, len(text) - 1)] == _POINT)
    )
    return _Style(bool(np.mean(text[end - 1] == _DIGIT_0) < 0.02), bool(bare > nought))


def _taken(text: Bytes, style: _Style) -> tuple[Bytes, Integers, NDArray[np.int8], NDArray[np.int16]]:
    """Return the skeleton of some lines, and values (as whole numbers), decimals and columns' keys of their numbers."""
    first, end, count, point = _runs(text)
    before = np.where(count == 1, point, end) - first
    decimals = np.where(count == 1, end - point - 1, 0)
    nought = text[first] == _DIGIT_0
    fine = (
        (count <= 1)
        & (end - first - count <= _MOST_DIGITS)
        & (decimals <= MOST_DECIMALS)
        & (end - first > count)
    )
    fine &= (before > 0) | style.bare
    fine &= ~nought | ((before == 1) & ((count == 0) | (not style.bare)))
    first, end, count, point, decimals = (part[fine] for part in (first, end, count, point, decimals))

    values = _values(text, first, end, np.where(count == 1, point, len(text)))
    negative = (first > 0) & (text[first - 1] == _MINUS) & (values != 0)
    begin = first - negative
    last = text[end - 1]
    code = np.where(count == 0, WHOLE, FIXED + decimals)
    code[(count == 1) & (last != _DIGIT_0) & style.fewest] = FEWEST

    # The skeleton has a byte for each number, and the text between them.
    gone = np.zeros(len(text) + 1, np.int8)
    gone[begin] += 1
    gone[end] -= 1
    kept = np.cumsum(gone[:-1], dtype=np.int8) == 0
    kept[begin] = True
    marked = text.copy()
    marked[begin] = code
    where = np.cumsum(kept)[begin] - 1
    words = marked[kept]
    before_number = np.where(where > 0, words[where - 1], _NEWLINE)
    lines = np.cumsum(words == _NEWLINE)[where]
    keys = before_number.astype(np.int32) * PLACES + np.minimum(_ranks(lines, before_number), PLACES - 1)
    return words, np.where(negative, -values, values), decimals.astype(np.int8), keys.astype(np.int16)


def _values(text: Bytes, first: NDArray[np.intp], end: NDArray[np.intp], point: NDArray[np.intp]) -> Integers:
    """Return numbers without their points."""
    found = np.zeros(len(first), np.int64)
    width = int((end - first).max(initial=0))
    for k in range(width):
        at = first + k
        digit = text[np.minimum(at, len(text) - 1)]
        counts = (at < end) & (at != point)
        found = np.where(counts, 10 * found + (digit - np.uint8(_DIGIT_0)), found)
    return found


def _ranks(lines: Integers, signs: Bytes) -> Integers:
    """Return how many numbers of the same line stand before each one behind the same sign."""
    group = lines * 256 + signs
    order = np.argsort(group, kind="stable")
    ordered = group[order]
    fresh = np.concatenate([[True], ordered[1:] != ordered[:-1]]) if len(group) else np.zeros(0, bool)
    start = np.maximum.accumulate(np.where(fresh, np.arange(len(group)), 0))
    found = np.empty(len(group), np.int64)
    found[order] = np.arange(len(group)) - start
    return found


def _columns(
    values: Integers, decimals: NDArray[np.int8], keys: NDArray[np.int16], blob: Blob
) -> list[dict[str, Any]]:
    """Put the numbers into a blob, column by column; the last column has all that are few."""
    counts = np.bincount(keys, minlength=1)
    many = np.flatnonzero(counts >= LEAST)
    found = [{"key": k} | _column(values[keys == k], decimals[keys == k], blob) for k in many.tolist()]
    few = (counts < LEAST)[keys]
    return [*found, {"key": -1} | _column(values[few], decimals[few], blob)]


def _column(values: Integers, decimals: NDArray[np.int8], blob: Blob) -> dict[str, Any]:
    """Put numbers of one column into a blob: differenced as often as makes them smallest, folded, and byte by byte deflated."""
    most = int(decimals.max(initial=0))
    scaled = values * _TENS[most - decimals.astype(np.int64)]
    rests = [scaled]
    for _ in range(2):
        rests.append(np.diff(rests[-1], prepend=0))
    order = int(np.argmin([np.log2(1.0 + np.abs(rest)).sum() for rest in rests]))
    folded = np.where(rests[order] < 0, -2 * rests[order] - 1, 2 * rests[order])
    planes: list[list[int]] = []
    while not planes or folded.any():
        planes.append(blob.put(zlib.compress((folded & 255).astype(np.uint8).tobytes(), 9)))
        folded = folded >> 8
    return {"decimals": most, "order": order, "count": len(values), "planes": planes}

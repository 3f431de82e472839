"""A picture as SVG text, drawn from arrays with nothing but numpy: a path coloured by speed."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from cncgen.units import file_unit

Floats = NDArray[np.float64]

#: Width of the picture, in the units of its view box.
PICTURE = 900
#: Room round the picture of a path, and below it.
_MARGIN, _FOOT = 40, 50
#: Points of the picture of a path at most: a page stays some hundred kilobytes however long the program is.
MOST_POINTS = 20_000

#: Part of the time in motion that the colours of a path tell apart.
_USUAL = 0.95

#: Speed from slow to fast: slow places stand out (samples of the inferno map, without its ends that white paper hides).
SPEEDS = ("#fca50a", "#f8850f", "#ec6824", "#d94d3d", "#bf3952", "#a12a62", "#7f1e6c", "#5c126e", "#390963")


def path_picture(points: Floats, axes: Sequence[str], speed: Floats, marks: Floats) -> str:
    """Draw a path in the plane of its two longest extents, coloured by speed, with marks at some places.

    Linear axes go before rotary ones. Colours run up to the speed that `_USUAL` of the time in motion keeps below, so
    that rapids do not make all cutting look alike.

    Args:
        points: Shape (n, axes), mm and degrees.
        axes: Their letters.
        speed: Shape (n,), mm/s.
        marks: Shape (m, axes).
    """
    columns = _plane(points, axes)
    low, high = points.min(axis=0)[columns], points.max(axis=0)[columns]
    units = [file_unit(axes[c]) for c in columns]
    scale, height = _scale(high - low, alike=units[0] == units[1])

    def place(p: Floats) -> tuple[Floats, Floats]:
        x, y = ((p[:, columns] - low) * scale).T
        return _MARGIN + x, height - _FOOT - y

    x, y = place(points)
    keep = _visible(x, y)
    usual = _usual_speed(speed)
    x, y, colour = x[keep], y[keep], _speed_class(speed[keep], usual)
    parts = []
    for begin, end in _runs(colour[:-1] if len(colour) > 1 else colour):
        path = _path(x[begin : end + 1], y[begin : end + 1])
        parts.append(f'<path d="{path}" stroke="{SPEEDS[colour[begin]]}" class="path"/>')
    parts += [
        f'<circle cx="{a:.1f}" cy="{b:.1f}" r="4" class="mark"/>' for a, b in zip(*place(marks), strict=True)
    ]
    extents = [
        f"{escape(axes[c])} {round(a, 3) + 0.0:.9g} to {round(b, 3) + 0.0:.9g} {unit}"
        for c, a, b, unit in zip(columns, low, high, units, strict=True)
    ]
    parts.append(f'<text x="{_MARGIN}" y="{height - 14:.0f}">across {extents[0]}, up {extents[1]}</text>')
    parts += _speed_scale(height - 14, usual, float(speed.max(initial=0.0)))
    return _svg(PICTURE, height, parts)


def _plane(points: Floats, axes: Sequence[str]) -> list[int]:
    """Return the columns of the two longest extents in their order, of linear axes where two of them move."""
    extent = np.ptp(points, axis=0)
    linear = [c for c, axis in enumerate(axes) if file_unit(axis) == "mm" and extent[c] > 0.0]
    choice = linear if len(linear) > 1 else list(range(len(axes)))
    longest = sorted(sorted(choice, key=lambda c: -extent[c])[:2])
    return longest if len(longest) > 1 else [0, 0]


def _scale(extent: Floats, alike: bool) -> tuple[Floats, float]:
    """Return the scale of both directions and the height of a picture: one scale for all where units are alike."""
    room = PICTURE - 2 * _MARGIN
    if alike:
        scale = np.full(2, room / max(float(extent.max()), 1e-9))
        return scale, float(extent[1] * scale[1]) + _MARGIN + _FOOT
    return np.array([room, room / 2]) / np.maximum(extent, 1e-9), room / 2 + _MARGIN + _FOOT


def _usual_speed(speed: Floats) -> float:
    """Return the speed that `_USUAL` of the samples in motion keep below, 0 where nothing moves."""
    moving = speed[speed > 1e-6 * speed.max(initial=0.0)]
    return float(np.quantile(moving, _USUAL, method="higher")) if len(moving) else 0.0


def _speed_class(speed: Floats, usual: float) -> NDArray[np.int64]:
    return np.minimum((speed / max(usual, 1e-12) * len(SPEEDS)).astype(np.int64), len(SPEEDS) - 1)


def _speed_scale(y: float, usual: float, top: float) -> list[str]:
    """Return a legend of the colours, a strip of them with its ends named, in the lower right corner."""
    right, width = PICTURE - _MARGIN, 14
    name = f"{usual:.4g} mm/s" + (f" (up to {top:.4g})" if top > 1.01 * usual else "")
    left = right - 170 - width * len(SPEEDS)
    strip = [
        f'<rect x="{left + width * k}" y="{y - 9:.0f}" width="{width}" height="10" fill="{colour}"/>'
        for k, colour in enumerate(SPEEDS)
    ]
    end = left + width * len(SPEEDS)
    return [
        f'<text x="{left - 6}" y="{y:.0f}" text-anchor="end">0</text>',
        *strip,
        f'<text x="{end + 6}" y="{y:.0f}">{name}</text>',
    ]


def _visible(x: Floats, y: Floats) -> NDArray[np.int64]:
    """Return indices of points no nearer to each other along the path than a part of a pixel, `MOST_POINTS` at most."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    least = max(0.4, float(length[-1]) / MOST_POINTS)
    _, index = np.unique(np.floor(length / least), return_index=True)
    return np.unique(np.append(index, len(x) - 1))


def _runs(values: NDArray[np.int64]) -> list[tuple[int, int]]:
    """Return begin and end (exclusive) of runs of equal values."""
    cuts = np.flatnonzero(np.diff(values)) + 1
    edges = [0, *cuts.tolist(), len(values)]
    return [(a, b) for a, b in itertools.pairwise(edges) if b > a]


def _path(x: Floats, y: Floats) -> str:
    return "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))


def _svg(width: float, height: float, parts: Sequence[str]) -> str:
    return f'<svg viewBox="0 0 {width:.0f} {height:.0f}" role="img">{"".join(parts)}</svg>'

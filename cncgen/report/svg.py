"""Pictures as SVG text, drawn from arrays with nothing but numpy: curves over time, and a path coloured by speed."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Size of a chart and of the picture of a path, in the units of their view boxes.
WIDTH, HEIGHT, PICTURE = 900, 220, 900
_LEFT, _RIGHT, _TOP, _BOTTOM = 64, 12, 22, 26
#: Points of the picture of a path at most: a page stays some hundred kilobytes however long the program is.
MOST_POINTS = 20_000

#: Colours of curves that can be told apart with any colour vision (Okabe and Ito 2008).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", "#000000", "#b8a800")
#: Speed from slow to fast (samples of the viridis map).
SPEEDS = ("#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725")


def envelope(x: Floats, y: Floats, columns: int) -> tuple[Floats, Floats]:
    """Thin a curve to its lowest and highest value in each of some columns of x; short curves stay as they are."""
    if len(x) <= 4 * columns:
        return x, y
    size = math.ceil(len(x) / columns)
    whole = len(x) // size * size
    parts = y[:whole].reshape(-1, size)
    first = np.arange(len(parts)) * size
    picks = np.sort(
        np.stack([first + parts.argmin(axis=1), first + parts.argmax(axis=1)], axis=1), axis=1
    ).ravel()
    tail = y[whole:]
    rest = sorted({whole + int(tail.argmin()), whole + int(tail.argmax())}) if len(tail) else []
    keep = np.concatenate([[0], picks, rest, [len(x) - 1]]).astype(np.int64)
    return x[keep], y[keep]


def ticks(low: float, high: float, count: int = 5) -> list[float]:
    """Return round numbers (1, 2 or 5 times a power of ten apart) between two values."""
    if not high > low:
        return [low]
    rough = (high - low) / count
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(factor * power for factor in (1, 2, 5, 10) if factor * power >= rough)
    return [k * step for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def chart(title: str, time_s: Floats, curves: Mapping[str, Floats], limits: Sequence[float] = ()) -> str:
    """Draw curves over time, with dashed lines at plus and minus each limit.

    Args:
        title: With the unit.
        time_s: Shape (n,).
        curves: Shape (n,) each, by name.
        limits: Magnitudes, one a curve or none; those far above the curves are left out.
    """
    top = max((float(np.abs(curve).max(initial=0.0)) for curve in curves.values()), default=0.0)
    shown = sorted({limit for limit in limits if limit <= 3 * top})
    high = max([top, *shown, 1e-12]) * 1.05
    low = -high if any(curve.min(initial=0.0) < 0 for curve in curves.values()) else 0.0
    end = max(float(time_s[-1]) if len(time_s) else 0.0, 1e-9)

    def across(t: Floats) -> Floats:
        return _LEFT + (WIDTH - _LEFT - _RIGHT) * t / end

    def down(v: Floats | float) -> Floats:
        return np.asarray(_TOP + (HEIGHT - _TOP - _BOTTOM) * (high - v) / (high - low))

    parts = [f'<text x="{_LEFT}" y="14" class="title">{escape(title)}</text>']
    for value in ticks(low, high, 4):
        y = float(down(value))
        parts.append(f'<line x1="{_LEFT}" x2="{WIDTH - _RIGHT}" y1="{y:.1f}" y2="{y:.1f}" class="grid"/>')
        parts.append(f'<text x="{_LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{value:g}</text>')
    for value in ticks(0.0, end, 8):
        x = float(across(np.asarray(value)))
        parts.append(f'<text x="{x:.1f}" y="{HEIGHT - 8}" text-anchor="middle">{value:g}</text>')
    for limit in shown:
        for signed in (limit, -limit) if low < 0 else (limit,):
            y = float(down(signed))
            parts.append(
                f'<line x1="{_LEFT}" x2="{WIDTH - _RIGHT}" y1="{y:.1f}" y2="{y:.1f}" class="limit"/>'
            )
    for k, (name, curve) in enumerate(curves.items()):
        t, v = envelope(time_s, curve, WIDTH - _LEFT - _RIGHT)
        colour = COLOURS[k % len(COLOURS)]
        parts.append(f'<path d="{_path(across(t), down(v))}" stroke="{colour}" class="curve"/>')
        parts.append(
            f'<text x="{WIDTH - _RIGHT - 40 * (len(curves) - k)}" y="14" fill="{colour}">{escape(name)}</text>'
        )
    return _svg(WIDTH, HEIGHT, parts)


def path_picture(points: Floats, names: Sequence[str], speed: Floats, marks: Floats) -> str:
    """Draw a path in the plane of its two longest extents, coloured by speed, with marks at some places.

    Args:
        points: Shape (n, axes).
        names: Of the axes.
        speed: Shape (n,), mm/s.
        marks: Shape (m, axes).
    """
    first, second = _plane(points)
    low, high = points.min(axis=0), points.max(axis=0)
    scale = (PICTURE - 80) / max(float((high - low).max()), 1e-9)
    height = float(high[second] - low[second]) * scale + 80

    def place(p: Floats) -> tuple[Floats, Floats]:
        return 40 + (p[:, first] - low[first]) * scale, height - 40 - (p[:, second] - low[second]) * scale

    x, y = place(points)
    keep = _visible(x, y)
    x, y, colour = x[keep], y[keep], _speed_class(speed[keep])
    parts = []
    for begin, end in _runs(colour[:-1] if len(colour) > 1 else colour):
        path = _path(x[begin : end + 1], y[begin : end + 1])
        parts.append(f'<path d="{path}" stroke="{SPEEDS[colour[begin]]}" class="path"/>')
    parts += [
        f'<circle cx="{a:.1f}" cy="{b:.1f}" r="4" class="mark"/>' for a, b in zip(*place(marks), strict=True)
    ]
    parts.append(
        f'<text x="40" y="{height - 12:.0f}">{escape(names[first])} across, {escape(names[second])} up</text>'
    )
    parts.append(
        f'<text x="{PICTURE - 40}" y="{height - 12:.0f}" text-anchor="end">dark: slow; bright: {speed.max(initial=0.0):.1f} mm/s</text>'
    )
    return _svg(PICTURE, height, parts)


def _plane(points: Floats) -> tuple[int, int]:
    """Return the columns of the two longest extents, in their order."""
    longest = np.argsort(-np.ptp(points, axis=0), kind="stable")[:2]
    first, second = sorted(int(k) for k in longest) if len(longest) > 1 else (0, 0)
    return first, second


def _speed_class(speed: Floats) -> NDArray[np.int64]:
    top = max(float(speed.max(initial=0.0)), 1e-12)
    return np.minimum((speed / top * len(SPEEDS)).astype(np.int64), len(SPEEDS) - 1)


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

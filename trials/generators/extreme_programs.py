"""Random small programs and machines at the ends of what planning takes: sizes from 1e-4 to 1e7 mm, places of 1e8 mm, ratios of
limits and of weights of a million, periods from 1e-7 to 1000 s, tolerances from a nanometre to a hundred times the size of the path.

A case is one text: words of `cncgen plan`, the machine file and the program, separated by `MARK`. Most machines are made so that
a motion takes from three to some hundred periods, and their limits are then drawn apart.
"""

from __future__ import annotations

import math
import random

#: Stands alone on a line between the parts of a case.
MARK = b"%%%%\n"
_FORMATS = ("csv", "npz", "f64", "npy", "jsonl", "arrow", "hal", "parquet")


def _ten(rng: random.Random, low: float, high: float) -> float:
    """Return a number with an exponent between two, of nine digits."""
    return float(f"{10.0 ** rng.uniform(low, high):.9g}")


def case(rng: random.Random) -> bytes:
    """Return a case."""
    axes = rng.choice(["XY", "XY", "XYZ", "XYZ", "X", "XYZA", "XYC", "XYZUVW"])
    wild = rng.random() < 0.15
    size = _ten(rng, -4, 7) if wild else _ten(rng, -2, 3)
    period = _ten(rng, -7, 3) if wild else rng.choice([1e-3, 1e-3, 5e-4, 4e-3, 2.5e-4, _ten(rng, -4, -1)])
    took = period * _ten(rng, 0.5, 2.3)
    machine = _machine(rng, axes, size, period, took)
    program = _program(rng, axes, size, took)
    words = [
        *("--effort", rng.choice(["best", "fast"])),
        *("--format", rng.choice(_FORMATS)),
        *(["--path-tolerance", f"{size * _ten(rng, -6, 0):.6g}"] if rng.random() < 0.2 else []),
    ]
    return MARK.join(["\n".join([*words, ""]).encode(), machine.encode(), program.encode()])


def _machine(rng: random.Random, axes: str, size: float, period: float, took: float) -> str:
    """Return a machine file on which `size` takes about `took` seconds."""
    apart = rng.choice([0.3, 1.0, 3.0])
    lines = [
        'name = "extreme"',
        f"period_s = {period!r}",
        f"chord_tolerance_mm = {size * _ten(rng, -7, 0):.6g}",
        f"path_tolerance_mm = {size * _ten(rng, -6, 2):.6g}",
    ]
    for letter in axes:
        unit = "deg" if letter in "ABC" else "mm"
        velocity = (360.0 if unit == "deg" else size) / took * _ten(rng, -apart, apart)
        acceleration = velocity / took * _ten(rng, -0.3, 0.5 + apart)
        jerk = acceleration / took * _ten(rng, -0.3, 0.5 + apart)
        limits = (
            ("velocity_", velocity, "", 1e-3),
            ("acceleration_", acceleration, "2", 1e-6),
            ("jerk_", jerk, "3", 1e-6),
        )
        lines.append(f"[axes.{letter.lower()}]")
        for name, value, power, least in limits:
            lines.append(f"max_{name}{unit}_s{power} = {min(max(value, least), 1e9):.6g}")
    return "\n".join([*lines, ""])


def _program(rng: random.Random, axes: str, size: float, took: float) -> str:
    """Return a program of one to eight motions."""
    place = [0.0 if rng.random() < 0.7 else _far(rng, size) for _ in axes]
    at = list(place)
    feed = _feed(rng, size / took, 1.0)
    tolerance = f"P{_fixed(size * _ten(rng, -6, 1))}"
    lines = [
        f"(START, {_words(axes, at)})",
        "G21 G90 G17 G94",
        rng.choice(["G61", "G61.1", "G64", f"G64 {tolerance}", f"G64 {tolerance}"]),
        feed,
    ]
    for _ in range(rng.randint(1, 8)):
        kind = rng.choice(
            [
                "line",
                "line",
                "line",
                "rapid",
                "arc",
                "nurbs",
                "nurbs",
                "back",
                "tiny",
                "dwell",
                "mode",
                "feed",
            ]
        )
        if kind == "mode":
            lines.append(rng.choice(["G61", "G64", f"G64 P{_fixed(size * _ten(rng, -7, 1))}"]))
        elif kind == "feed":
            lines.append(_feed(rng, size / took, 2.0))
        elif kind == "dwell":
            lines.append(f"G4 P{_fixed(took * rng.choice([0.0, 0.01, 1.0]))}")
        elif kind == "arc" and axes.startswith("XY"):
            lines.append(_arc(rng, axes, at, size))
        elif kind == "nurbs" and axes.startswith("XY"):
            lines += _nurbs(rng, at, size)
        else:
            step = size * (_ten(rng, -9, -3) if kind == "tiny" else _ten(rng, -2, 0))
            moved = [k for k in range(len(axes)) if rng.random() < 0.6] or [0]
            old = list(at)
            for k in moved:
                at[k] += step * rng.uniform(-1.0, 1.0) * (57.0 / size if axes[k] in "ABC" else 1.0)
            lines.append(f"{'G0' if kind == 'rapid' else 'G1'} {_words(axes, at)}")
            if kind == "back":
                at[:] = old
                lines.append(f"G1 {_words(axes, at)}")
    return "\n".join([*lines, "M2", ""])


def _far(rng: random.Random, size: float) -> float:
    """Return a place far away for its size, up to 1e8 mm."""
    return rng.choice([-1.0, 1.0]) * min(size * _ten(rng, 0, 5), 9e7)


def _feed(rng: random.Random, speed: float, apart: float) -> str:
    """Return a feed around a speed, mm/s."""
    return f"F{_fixed(max(min(60.0 * speed * _ten(rng, -apart, apart), 1e9), 1.0))}"


def _fixed(value: float) -> str:
    """Return a number without an exponent."""
    return f"{value:.12f}".rstrip("0").rstrip(".")


def _words(axes: str, at: list[float]) -> str:
    return " ".join(f"{axis}{_fixed(value)}" for axis, value in zip(axes, at, strict=False))


def _arc(rng: random.Random, axes: str, at: list[float], size: float) -> str:
    """Return an arc or a helix in the plane of X and Y, with up to three turns."""
    radius, begin = max(size * _ten(rng, -3, 0.5), 0.02), rng.uniform(0.0, 2.0 * math.pi)
    centre = [at[0] - radius * math.cos(begin), at[1] - radius * math.sin(begin)]
    end = rng.choice([begin, begin + 10.0 ** rng.uniform(-4, 0.7)])
    i, j = centre[0] - at[0], centre[1] - at[1]
    at[0], at[1] = centre[0] + radius * math.cos(end), centre[1] + radius * math.sin(end)
    words = ""
    if "Z" in axes and rng.random() < 0.5:
        at[2] += size * rng.uniform(-1.0, 1.0)
        words = f" Z{at[2]:.12f}"
    turns = f" P{rng.randint(2, 3)}" if rng.random() < 0.2 else ""
    return f"{rng.choice(['G2', 'G3'])} {_words('XY', at)} I{i:.12f} J{j:.12f}{words}{turns}"


def _nurbs(rng: random.Random, at: list[float], size: float) -> list[str]:
    """Return a curve in X and Y with weights in a ratio of up to a million."""
    order, more = rng.choice([2, 3, 3, 4]), rng.choice([0, 0, 1, 3])
    count = order + more
    wide = rng.choice([0.0, 0.5, 2.0, 3.0, 3.2])
    inside = sorted(rng.choice([rng.random(), rng.random(), 0.5, 1e-9]) for _ in range(more))
    knots = [0.0] * order + inside + [1.0] * order
    step, way = size * _ten(rng, -3, 0), rng.uniform(0.0, 2.0 * math.pi)
    lines = []
    for k in range(count):
        if k and rng.random() < 0.9:
            way += rng.gauss(0.0, 0.8)
            at[0] += step * rng.random() * math.cos(way)
            at[1] += step * rng.random() * math.sin(way)
        head = f"G6.2 P{order} " if not k else ""
        weight = 10.0 ** rng.uniform(-wide, wide)
        lines.append(f"{head}K{_fixed(knots[k])} {_words('XY', at)} R{_fixed(weight)}")
    return lines + [f"K{_fixed(knot)}" for knot in knots[count:]]

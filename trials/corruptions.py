"""`verify` against setpoints that were made wrong, and against honest ones of low resolution.

    python -m trials.corruptions [--count 10000] [--honest 1000] [--seed N] [--seconds S]

Parts of lines and half circles are drawn at random, their path written down here, and planned; the programs of ``programs/`` for
two axes are there too. Their setpoints are corrupted in twenty kinds. What a corruption is judged to be does not depend on cncgen:
finite differences say whether it breaks a limit of an axis, the distances of vertices from segments whether it leaves the path,
and the reachability of pairs on two dense polylines (the discrete
Frechet distance: T. Eiter, H. Mannila (1994)) whether it keeps its order within the tolerance. What is so near
to a bound that this judge cannot tell counts for neither side. A miss is a wrong file that `verify` lets pass, or
does not refuse; a false alarm is an honest one that it does not.

Feeds, lines and events are not what `verify` judges (docs/verify.md).
"""

from __future__ import annotations

import argparse
import math
import random
import secrets
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import cncgen
from cncgen.diagnostics import CncgenError
from trials.judge import nearest

Floats = NDArray[np.float64]

#: The machine of the trial: limits of both axes (xy-table), mm/s, mm/s^2, mm/s^3; period, s; travel, mm; chord tolerance, mm.
MACHINE, LIMITS, PERIOD_S, TRAVEL_MM, CHORD_MM = "xy-table", (250.0, 2450.0, 50000.0), 1e-3, 500.0, 1e-3
#: Allowance on a limit, as a part of it, and the resolution of files, mm.
MARGIN, RESOLUTION = 1e-3, 1e-9
#: Distance between vertices of dense polylines, mm, and vertices beyond which the path is not judged.
STEP_MM, MOST = 0.02, 6000
#: Corruptions between two tables of counts.
ROUND = 230
PROGRAMS = ("square_r5", "square_sharp", "circle", "bonder")
ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True, slots=True)
class Part:
    """A program with its path, the tolerance of all of it, what its setpoints are, and neighbours that are no plans of it.

    Attributes:
        text: The program.
        path: Vertices of the path, shape (n, 2); of a program of ``programs/`` its own setpoints.
        tolerance: In force, mm.
        slack: How far `path` may be from the programmed one, mm.
        rows: The setpoints, shape (m, 2), mm.
        others: Setpoints of changed programs by what was changed.
    """

    text: str
    path: Floats
    tolerance: float
    slack: float
    rows: Floats
    others: dict[str, Floats]


@dataclass(slots=True)
class Corrupted:
    """What is handed to `verify`: rows, or a file, that of a reader's fault must be refused."""

    rows: Floats | None
    period_s: float = PERIOD_S
    file: str = ""


def planned(text: str) -> Floats:
    """Return the setpoints of a program, mm."""
    chunks = cncgen.sample(cncgen.plan(cncgen.read_text(text, "part.nc"), MACHINE))
    return np.round(np.concatenate([chunk.position for chunk in chunks]), 9)


def _written(pieces: list[tuple[Floats, bool]], mode: str) -> str:
    lines = ["G21 G17 G90 " + mode]
    for k, (point, arc) in enumerate(pieces):
        x, y = point
        if arc:
            centre = 0.5 * (point - pieces[k - 1][0])
            lines.append(f"G3 X{x:.4f} Y{y:.4f} I{centre[0]:.6f} J{centre[1]:.6f}")
        else:
            lines.append(f"G1 X{x:.4f} Y{y:.4f} F3000")
    return "\n".join([*lines, "M2", ""])


def _path_of(pieces: list[tuple[Floats, bool]]) -> Floats:
    """Return the path of pieces from machine zero on as a dense polyline: half circles counterclockwise, and lines."""
    points = [np.zeros(2)]
    for end, arc in pieces:
        start = points[-1]
        if arc:
            centre, half = 0.5 * (start + end), 0.5 * (start - end)
            angle = np.linspace(0.0, math.pi, max(int(math.pi * np.linalg.norm(half) / 1e-3), 8))
            turned = np.column_stack([-half[1], half[0]])[0]
            points += list(centre + np.outer(np.cos(angle), half) + np.outer(np.sin(angle), turned))
            points[-1] = end
        else:
            points.append(end)
    return np.array(points)


def drawn_part(rng: random.Random) -> Part:
    """Draw a part of three to six pieces in a square of 6 mm, with neighbours: a vertex moved, one left out, one more, one cut off."""
    count = rng.randint(3, 6)
    pieces = [
        (np.round([rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0)], 4), k > 0 and rng.random() < 0.25)
        for k in range(count)
    ]
    tolerance = rng.choice([0.005, 0.01, 0.02, 0.05])
    exact = rng.random() < 0.3
    mode = "G61" if exact else f"G64 P{tolerance}"
    text = _written(pieces, mode)
    moved, at = list(pieces), rng.randrange(count)
    moved[at] = np.round(moved[at][0] + rng.uniform(0.1, 0.5), 4), moved[at][1]
    left_out = rng.randrange(1, count)
    less = [piece for k, piece in enumerate(pieces) if k != left_out]
    more = [*pieces, (np.round(pieces[-1][0] + rng.uniform(0.1, 1.0), 4), False)]
    others = {
        "vertex": planned(_written(moved, mode)),
        "missing": planned(_written(less, mode)),
        "more": planned(_written(more, mode)),
        "again": planned(_written([*pieces, *pieces[:-1][::-1], *pieces[1:]], mode)),
        "corner": planned(_written(pieces, "G64 P0.5")),
    }
    return Part(
        text, _path_of(pieces), CHORD_MM if exact else max(tolerance, CHORD_MM), 1e-4, planned(text), others
    )


def shipped_parts() -> Iterator[Part]:
    """Yield the programs of ``programs/`` that move X and Y alone."""
    for name in PROGRAMS:
        text = (ROOT / "programs" / f"{name}.nc").read_text()
        rows = planned(text)
        yield Part(text, rows, 0.01, 0.02, rows, {})


# Kinds of corruption: each takes a part and returns what is handed over.


def _shift(part: Part, rng: random.Random) -> Corrupted:
    """Move a sample until a limit is broken by one to ten percent."""
    rows, at, axis = part.rows.copy(), rng.randrange(len(part.rows)), rng.randrange(2)
    step = 1e-7
    while not _over(rows, PERIOD_S, MARGIN + 0.01):
        rows[at, axis] = part.rows[at, axis] + step
        step *= 1.1
    return Corrupted(rows)


def _at(part: Part, rng: random.Random) -> int:
    return rng.randrange(1, len(part.rows) - 1)


def _dropped(part: Part, rng: random.Random) -> Corrupted:
    return Corrupted(np.delete(part.rows, _at(part, rng), axis=0))


def _doubled(part: Part, rng: random.Random) -> Corrupted:
    return Corrupted(np.insert(part.rows, at := _at(part, rng), part.rows[at], axis=0))


def _swapped_rows(part: Part, rng: random.Random) -> Corrupted:
    rows, at = part.rows.copy(), _at(part, rng)
    rows[[at, at - 1]] = rows[[at - 1, at]]
    return Corrupted(rows)


def _as_csv(rows: Floats, times: Floats | None = None, head: str = "t_s,x_mm,y_mm") -> str:
    t = np.arange(len(rows), dtype=np.float64) * PERIOD_S if times is None else times
    lines = [f"{a:.9f}," + ",".join(f"{value:.9f}" for value in row) for a, row in zip(t, rows, strict=True)]
    return "\n".join([head, *lines, ""])


def _jitter(part: Part, rng: random.Random) -> Corrupted:
    times = np.arange(len(part.rows), dtype=np.float64) * PERIOD_S
    times[_at(part, rng)] += rng.choice([-1, 1]) * rng.uniform(0.03, 0.9) * PERIOD_S
    return Corrupted(None, file=_as_csv(part.rows, times))


def _scaled(part: Part, rng: random.Random) -> Corrupted:
    factor = np.ones(2)
    factor[rng.randrange(2)] = 1.0 + rng.choice([-1, 1]) * 10.0 ** rng.uniform(-3.5, -0.5)
    return Corrupted(part.rows * factor)


def _swapped_axes(part: Part, rng: random.Random) -> Corrupted:
    return Corrupted(part.rows[:, ::-1].copy())


def _sign(part: Part, rng: random.Random) -> Corrupted:
    factor = np.ones(2)
    factor[rng.randrange(2)] = -1.0
    return Corrupted(part.rows * factor)


def _drift(part: Part, rng: random.Random) -> Corrupted:
    """Add a drift of an axis that itself breaks nothing."""
    u = np.linspace(0.0, 1.0, len(part.rows))
    size = part.tolerance * 10.0 ** rng.uniform(-0.5, 1.5)
    rows = part.rows.copy()
    rows[:, rng.randrange(2)] += size * u**4 * (35.0 - 84.0 * u + 70.0 * u**2 - 20.0 * u**3)
    return Corrupted(rows)


def _offset(part: Part, rng: random.Random) -> Corrupted:
    rows = part.rows.copy()
    rows[:, rng.randrange(2)] += rng.choice([-1, 1]) * part.tolerance * 10.0 ** rng.uniform(-0.5, 2.0)
    return Corrupted(rows)


def _cut_off(part: Part, rng: random.Random) -> Corrupted:
    at = _at(part, rng)
    return Corrupted(part.rows[:at] if rng.random() < 0.5 else part.rows[at:])


def _reversed(part: Part, rng: random.Random) -> Corrupted:
    return Corrupted(part.rows[::-1].copy())


def _coarse(part: Part, rng: random.Random) -> Corrupted:
    unit = 10.0 ** rng.uniform(-6.0, -1.0)
    return Corrupted(np.round(part.rows / unit) * unit)


def _not_finite(part: Part, rng: random.Random) -> Corrupted:
    text = _as_csv(part.rows).split("\n")
    at = rng.randrange(1, len(text) - 1)
    text[at] = text[at].rpartition(",")[0] + "," + rng.choice(["nan", "inf", "-inf", "1e400", "", "x"])
    return Corrupted(None, file="\n".join(text))


def _period(part: Part, rng: random.Random) -> Corrupted:
    return Corrupted(part.rows, period_s=PERIOD_S * rng.choice([0.25, 0.5, 0.8, 0.95, 1.25, 2.0]))


def _columns(part: Part, rng: random.Random) -> Corrupted:
    """Leave an axis out, or name it otherwise."""
    if rng.random() < 0.5:
        return Corrupted(None, file=_as_csv(part.rows[:, :1], head="t_s,x_mm"))
    return Corrupted(None, file=_as_csv(part.rows, head=rng.choice(["t_s,x_mm,z_mm", "t_s,y_mm,a_deg"])))


def _lost_rows(part: Part, rng: random.Random) -> Corrupted:
    at = _at(part, rng)
    return Corrupted(np.delete(part.rows, slice(at, at + rng.randint(2, 200)), axis=0))


def _inch(part: Part, rng: random.Random) -> Corrupted:
    return Corrupted(part.rows * rng.choice([25.4, 1.0 / 25.4]))


def _other(name: str) -> Callable[[Part, random.Random], Corrupted]:
    def corrupt(part: Part, rng: random.Random) -> Corrupted:
        return Corrupted(part.others.get(name, part.rows))

    return corrupt


KINDS: dict[str, Callable[[Part, random.Random], Corrupted]] = {
    "a sample moved": _shift,
    "a row dropped": _dropped,
    "a row doubled": _doubled,
    "two rows swapped": _swapped_rows,
    "jitter of times": _jitter,
    "an axis scaled": _scaled,
    "axes swapped": _swapped_axes,
    "a sign": _sign,
    "drift": _drift,
    "offset": _offset,
    "cut off": _cut_off,
    "reversed": _reversed,
    "rounded coarsely": _coarse,
    "not a number": _not_finite,
    "another period": _period,
    "columns": _columns,
    "rows lost": _lost_rows,
    "inch for mm": _inch,
    "corners cut": _other("corner"),
    "a vertex moved": _other("vertex"),
    "a piece left out": _other("missing"),
    "a piece more": _other("more"),
    "gone along again": _other("again"),
}

# The judge.


def _over(rows: Floats, period_s: float, margin: float) -> bool:
    """Tell whether finite differences, at rest before and after, are over a limit by more than a part of it and rounding."""
    padded = np.concatenate([np.repeat(rows[:1], 3, axis=0), rows, np.repeat(rows[-1:], 3, axis=0)])
    for order, limit in enumerate(LIMITS, 1):
        peak = np.abs(np.diff(padded, order, axis=0)).max() / period_s**order
        if peak > limit * (1.0 + margin) + (2**order * 0.5 * RESOLUTION / period_s**order if margin else 0.0):
            return True
    return bool((np.abs(rows) > TRAVEL_MM + RESOLUTION).any())


def _dense(points: Floats, step: float) -> Floats:
    """Return a polyline with vertices no further apart than `step`, standing still left out."""
    keep = np.concatenate([[True], (np.diff(points, axis=0) != 0.0).any(axis=1)])
    points = points[keep]
    if len(points) < 2:
        return points
    parts = np.maximum(np.ceil(np.linalg.norm(np.diff(points, axis=0), axis=1) / step).astype(int), 1)
    which = np.repeat(np.arange(len(parts)), parts)
    u = (np.arange(len(which)) - np.repeat(np.cumsum(parts) - parts, parts) + 1.0) / parts[which]
    inside = points[which] + u[:, None] * np.diff(points, axis=0)[which]
    return np.concatenate([points[:1], inside])


def within(one: Floats, other: Floats, distance: float) -> bool:
    """Tell whether the discrete Frechet distance of two sequences of points is at most `distance`."""
    index = np.arange(len(other))
    reached = np.zeros(len(other), bool)
    for k, point in enumerate(one):
        free = ((other - point) ** 2).sum(axis=1) <= distance**2
        seeds = free & (reached | np.concatenate([[k == 0], reached[:-1]]))
        last_seed = np.maximum.accumulate(np.where(seeds, index, -1))
        last_wall = np.maximum.accumulate(np.where(free, -1, index))
        reached = free & (last_seed > last_wall)
        if not reached.any():
            return False
    return bool(reached[-1])


def wrong(part: Part, found: Corrupted) -> bool | None:
    """Tell whether what was made of a part is wrong; None where it is too near to a bound to tell."""
    if found.rows is None:
        return True
    rows = found.rows
    if len(rows) < 2:  # cut off to a point
        return True
    if _over(rows, found.period_s, MARGIN * 1.01):
        return True
    near = _over(rows, found.period_s, 0.0)
    most = part.tolerance * (1.0 + 2.0 * MARGIN) + part.slack
    if any(nearest(a, b[:-1], b[1:])[0].max() > most for a, b in ((rows, part.path), (part.path, rows))):
        return True
    length = float(np.linalg.norm(np.diff(part.path, axis=0), axis=1).sum())
    step = max(STEP_MM, length / MOST)
    one, other = _dense(rows, step), _dense(part.path, step)
    if len(one) > 4 * MOST:
        return None
    if not within(one, other, most + 2.0 * step):
        return True
    if near:
        return None
    if not part.slack > 1e-3 and within(one, other, part.tolerance - part.slack):
        return False
    moved = rows - part.rows if len(rows) == len(part.rows) else np.full(1, math.inf)
    return False if not moved.any() else None


@dataclass(slots=True)
class Score:
    """Counts by kind: corruptions, those that are wrong, honest and untold; misses and false alarms as texts."""

    wrong: Counter[str] = field(default_factory=Counter)
    honest: Counter[str] = field(default_factory=Counter)
    untold: Counter[str] = field(default_factory=Counter)
    misses: list[str] = field(default_factory=list)
    alarms: list[str] = field(default_factory=list)


def verdict(part: Part, found: Corrupted, resolution: float = RESOLUTION) -> tuple[bool, str]:
    """Return whether `verify` lets setpoints pass, and what it says."""
    program = cncgen.read_text(part.text, "part.nc")
    try:
        if found.rows is not None:
            points = cncgen.Setpoints("XY", found.period_s, 0, found.rows)
            said = cncgen.judge(points, program, MACHINE, resolution=resolution)
        else:
            with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
                file.write(found.file)
                file.flush()
                said = cncgen.judge(cncgen.read_setpoints(file.name), program, MACHINE, resolution=resolution)
    except CncgenError as error:
        return False, str(error)
    return said.holds, "; ".join(each.render() for each in said.breaches)


def parts_of(rng: random.Random, count: int, *, shipped: bool) -> list[Part]:
    """Return drawn parts, behind the programs of ``programs/`` if these are asked for."""
    found = list(shipped_parts()) if shipped else []
    while len(found) < count:
        try:
            found.append(drawn_part(rng))
        except CncgenError:  # a half circle of no length, or corners that leave nothing of a piece
            continue
    return found


def corruptions(rng: random.Random, parts: list[Part], numbers: Iterable[int], score: Score) -> None:
    """Corrupt parts in all kinds in turn and compare the verdicts."""
    names = list(KINDS)
    for number in numbers:
        name, part = names[number % len(names)], rng.choice(parts)
        found = KINDS[name](part, rng)
        state = wrong(part, found)
        counter = score.untold if state is None else score.wrong if state else score.honest
        counter[name] += 1
        holds, said = verdict(part, found)
        text = f"{name}: {part.text!r}: {said}"
        if state and holds:
            score.misses.append(text)
        elif state is False and not holds:
            score.alarms.append(text)


def honest(rng: random.Random, parts: list[Part], count: int, score: Score) -> None:
    """Round setpoints to 1e-3 to 1e-6 mm, and judge them by that resolution."""
    for _ in range(count):
        part, unit = rng.choice(parts), rng.choice([1.0, 2.0, 5.0]) * 10.0 ** -rng.randint(3, 6)
        unit = min(unit, 1e-3)
        score.honest["low resolution"] += 1
        holds, said = verdict(part, Corrupted(np.round(part.rows / unit) * unit), unit)
        if not holds:
            score.alarms.append(f"{unit:g} mm: {part.text!r}: {said}")


def table(score: Score) -> str:
    """Return the counts by kind, and in all."""
    lines = [
        f"{score.wrong[name]:6d} wrong {score.honest[name]:6d} honest {score.untold[name]:6d} untold  {name}"
        for name in (*KINDS, "low resolution")
    ]
    return "\n".join([*lines, f"{len(score.misses)} misses, {len(score.alarms)} false alarms"])


def main() -> int:
    """Run the trial and print the counts."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--honest", type=int, default=1000)
    parser.add_argument("--parts", type=int, default=100)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--seconds", type=float, default=math.inf)
    given = parser.parse_args()
    seed = secrets.randbelow(2**31) if given.seed is None else given.seed
    print(f"seed {seed}", flush=True)
    rng, score = random.Random(seed), Score()
    end, told, rounds = time.monotonic() + given.seconds, 0, max(-(-given.count // ROUND), 1)
    for k in range(rounds):
        # Fresh parts for each round; the counts are printed as they grow, so that a trial that is stopped has shown something.
        parts = parts_of(rng, max(given.parts // rounds, 5), shipped=k == 0 and given.parts > 20)
        corruptions(rng, parts, range(k * ROUND, min((k + 1) * ROUND, given.count)), score)
        honest(rng, parts, given.honest * (k + 1) // rounds - given.honest * k // rounds, score)
        print(f"after round {k + 1} of {rounds}\n{table(score)}", flush=True)
        texts = [f"missed: {each}" for each in score.misses] + [
            f"false alarm: {each}" for each in score.alarms
        ]
        for text in texts[told:][:20]:
            print(f"--- {text}", flush=True)
        told = len(texts)
        if time.monotonic() > end:
            break
    return 1 if score.misses or score.alarms else 0


if __name__ == "__main__":
    raise SystemExit(main())

"""A limit raised step by step, and segments split: how the time of simple paths answers, on random machines.

    python -m trials.planner_ladders relaxing 100              # a hundred paths, each with five limits in twenty steps
    python -m trials.planner_ladders relaxing 100 --seed 3 --mode "G64 P0.01"
    python -m trials.planner_ladders splitting 300

Random programs (`planner_properties.py`) raise a limit once. Here it climbs from a thirtieth to hundreds of times, by
factors of 1.01 to 10, and each time is set beside the least one of all that are stricter: no more than a thousandth
longer. Paths are those where corners, rests and setpoints meet: zigzags, polygons, stars, polylines that turn at random,
lines with arcs, a NURBS, a cusp; periods of 0.25 to 4 ms. Printed is what fails, and a line for all.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from trials.generators.simple_paths import Arc, Case, Curve, Floats, Line, Move, drawn, end_of, train
from trials.seeds import first_for_tuning

#: Part by which a time may be longer, s that it may be besides.
LONGER, ROUNDING_S = 1e-3, 1e-6
#: Parts that segments are split into.
PARTS = (
    (0.37, 0.63),
    (0.5, 0.2, 0.3),
    (0.02, 0.18, 0.1, 0.05, 0.15, 0.1, 0.2, 0.08, 0.02, 0.1),
)
#: Factors of a step.
FACTORS = (1.01, 1.1, 1.5, 2.0, 10.0)


# --- properties -----------------------------------------------------------------------------------------------------


def _with(case: Case, what: str, axes: slice, factor: float) -> Case:
    """Return a case with a limit (of some axes) times a factor."""
    if what in ("feed", "chord"):
        return replace(case, **{what: factor * getattr(case, what)})
    limits = np.array(case.limits)
    limits[("velocity", "acceleration", "jerk").index(what), axes] *= factor
    return replace(case, limits=tuple(map(tuple, limits.tolist())))


def relaxing(case: Case, draw: np.random.Generator) -> Iterator[str]:
    """Yield the worst step of each limit that takes longer than a stricter one."""
    for what in ("velocity", "acceleration", "jerk", "feed", "chord"):
        axes = slice(*[(0, 2), (0, 1), (1, 2)][int(draw.integers(3))])
        factor, least, stricter, worst = 1.0 / 30.0, math.inf, 0.0, (0.0, 0.0, 0.0)
        while factor < 300.0:
            seconds = _with(case, what, axes, factor).time
            if seconds < least:
                least, stricter = seconds, factor
            elif seconds > least + ROUNDING_S:
                worst = max(worst, (seconds / least - 1.0, stricter, factor))
            factor *= float(draw.choice(FACTORS))
        if worst[0] > LONGER:
            of = "" if what in ("feed", "chord") else f" of {'XY'[axes]}"
            yield f"{what}{of} times {worst[2]:.5g} takes {worst[0]:.3%} more than times {worst[1]:.5g}"


def splitting(case: Case, draw: np.random.Generator) -> Iterator[str]:
    """Yield where every segment in two, three or ten parts takes another time than whole."""
    whole = case.time
    for parts in PARTS:
        moves: list[Move] = []
        at = np.zeros(2)
        for move in case.moves:
            moves += _parted(at, move, parts)
            at = end_of(at, move)
        seconds = replace(case, moves=tuple(moves)).time
        if abs(seconds - whole) > LONGER * whole + ROUNDING_S:
            yield f"in {len(parts)} parts {seconds:.6f} s, whole {whole:.6f} s ({seconds / whole - 1.0:+.3%})"


def _parted(at: Floats, move: Move, parts: tuple[float, ...]) -> list[Move]:
    """Split a move; a NURBS at these parts of its parameter."""
    if isinstance(move, Line):
        way = np.array(move.end) - at
        ends = [at + part * way for part in np.cumsum(parts)[:-1]]
        return [*(Line((float(x), float(y))) for x, y in ends), move]
    if isinstance(move, Arc):
        return [Arc(move.centre, part * move.sweep) for part in parts]
    out: list[Move] = []
    rest = move
    for u in np.cumsum(parts)[:-1]:
        first, rest = _cut(rest, float(u))
        out.append(first)
    return [*out, rest]


def _cut(curve: Curve, u: float) -> tuple[Curve, Curve]:
    """Split a NURBS at a parameter by inserting it as a knot three times (Boehm 1980)."""
    points = np.array(curve.points)
    points[:, :2] *= points[:, 2:]
    knots = np.array(curve.knots)
    for _ in range(3):
        k = int(np.searchsorted(knots, u, side="right")) - 1
        new = np.concatenate([points[: k - 2], points[k - 3 :]])
        for i in range(k - 2, k + 1):
            # A point that stays: where the knot is there already, beyond its span.
            part = (u - knots[i]) / (knots[i + 3] - knots[i]) if knots[i + 3] > knots[i] else 0.0
            new[i] = part * points[i] + (1.0 - part) * points[i - 1] if i < len(points) else points[i - 1]
        points, knots = new, np.insert(knots, k + 1, u)
    points[:, :2] /= points[:, 2:]
    k = int(np.searchsorted(knots, u))
    rows = [tuple(map(float, row)) for row in points]
    before, after = (*knots[: k + 3], u), (u, *knots[k:])
    return (
        Curve(tuple(rows[:k]), tuple(map(float, before))),  # type: ignore[arg-type]
        Curve(tuple(rows[k - 1 :]), tuple(map(float, after))),  # type: ignore[arg-type]
    )


PROPERTIES = {"relaxing": relaxing, "splitting": splitting}


def main() -> None:
    """Try a property on so many paths; exit 1 if it fails on one."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("name", choices=list(PROPERTIES))
    parser.add_argument("count", nargs="?", type=int, default=100)
    parser.add_argument("--seed", type=int, default=first_for_tuning("planner_ladders"))
    parser.add_argument("--mode", default="G61", help="G61, G61.1 or G64 P…")
    parser.add_argument("--trains", action="store_true", help="of short lines, beside coarse periods")
    asked = parser.parse_args()
    begin = time.process_time()
    failed = 0
    for number in range(asked.count):
        draw = np.random.default_rng([asked.seed, number])
        case = (train if asked.trains else drawn)(draw, asked.mode)
        found = list(PROPERTIES[asked.name](case, draw))
        failed += bool(found)
        for each in found:
            print(f"FAILED #{number} {each}", flush=True)
        if found:
            print(case, flush=True)
    seconds = time.process_time() - begin
    print(f"{asked.name} {asked.mode}: {asked.count} paths, {failed} failed, {seconds:.0f} s of CPU")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()

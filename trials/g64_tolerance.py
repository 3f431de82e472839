"""Random G64 programs: does the motion stay within P of the path, both ways, and within the limits?

    python -m trials.g64_tolerance 300 --seed 7
    python -m trials.g64_tolerance --only 7:41

Lines, arcs, helices, NURBS and rotary axes; cusps, reversals, retraced paths, plunges, moves of no length, waits; P from
1e-5 to ten times the moves, changed within the program, left out, with Q. The path is known here from what wrote the
program, and distances come from scipy: nothing of `cncgen.verify`, and of the planner's geometry, is used.
"""

from __future__ import annotations

import argparse
import signal
import sys
import time

import numpy as np
from scipy.spatial import cKDTree

from cncgen.diagnostics import CncgenError
from cncgen.machine.record import Machine
from cncgen.pipeline import plan, read_text, sample
from cncgen.setpoints.columns import file_units
from cncgen.units import DEGREE
from trials.generators.g64_parts import AXES, Floats, Part, random_machine, random_part
from trials.seeds import first_for_tuning

#: A tolerance, or a limit, is broken beyond this part of it.
MARGIN = 1.001
#: Seconds of a plan.
PATIENCE_S = 120


def to_segments(points: Floats, starts: Floats, ends: Floats, spacing: float) -> Floats:
    """Return the distance of points from segments: the segments' places at most `spacing` apart find the nearest ones."""
    parts = np.maximum(np.ceil(np.linalg.norm(ends - starts, axis=1) / spacing), 1).astype(int)
    owner = np.repeat(np.arange(len(parts)), parts)
    f = (np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts) + 0.5) / parts[owner]
    tree = cKDTree(starts[owner] + f[:, None] * (ends - starts)[owner])
    _, near = tree.query(points, k=min(4, len(owner)), workers=1)
    best = np.full(len(points), np.inf)
    for k in np.atleast_2d(near.T):
        best = np.minimum(best, to_each(points, starts[owner[k]], ends[owner[k]]))
    return best


def to_each(points: Floats, a: Floats, b: Floats) -> Floats:
    """Return the distance of each point from its segment."""
    d = b - a
    f = np.clip(((points - a) * d).sum(1) / np.maximum((d**2).sum(1), 1e-300), 0, 1)
    return np.linalg.norm(points - a - f[:, None] * d, axis=1)


def dense(points: Floats, spacing: float) -> Floats:
    """Return places on a polyline at most `spacing` apart (a million at most)."""
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    spacing = max(spacing, length.sum() / 3e5)
    parts = np.maximum(np.ceil(length / spacing), 1).astype(int)
    owner = np.repeat(np.arange(len(parts)), parts)
    f = (np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[owner]
    return np.concatenate([points[owner] + f[:, None] * np.diff(points, axis=0)[owner], points[-1:]])


def exactly(points: Floats, starts: Floats, ends: Floats) -> Floats:
    """Return the distance of a few points from all segments."""
    return np.array([to_each(np.repeat(p[None], len(starts), 0), starts, ends).min() for p in points])


def over(points: Floats, starts: Floats, ends: Floats, allowed: float) -> float:
    """Return by what factor of `allowed` the worst of the points is away from the segments, 0 where none is over it."""
    spacing = max(allowed, np.linalg.norm(ends - starts, axis=1).sum() / 3e5)
    far = np.flatnonzero(to_segments(points, starts, ends, spacing) > allowed)
    if not len(far):
        return 0.0
    some = far[:: max(len(far) // 300, 1)]
    return float((exactly(points[some], starts, ends) / allowed).max())


def distances(part: Part, setpoints: Floats) -> tuple[float, float]:
    """Return by what factor the motion leaves the path, and the path the motion; up to 1 where neither is over.

    A place of the motion has to be within the tolerance of some piece.
    """
    worst_out, worst_back = 0.0, 0.0
    tolerance = np.array(part.tolerance)
    left = dense(setpoints, tolerance.min())
    for value in np.unique(tolerance)[::-1]:
        mine = [p for p, t in zip(part.pieces, part.tolerance, strict=True) if t == value]
        starts, ends = np.concatenate([p[:-1] for p in mine]), np.concatenate([p[1:] for p in mine])
        allowed = value * MARGIN + 2e-3 * value + 1e-8
        # At its ends a piece may be as far away as its neighbour allows.
        inner = np.concatenate(
            [_inner(p, tolerance, k) for k, p in enumerate(part.pieces) if tolerance[k] == value]
        )
        if len(inner):
            worst_back = max(worst_back, over(inner, setpoints[:-1], setpoints[1:], allowed))
        if len(left):
            spacing = max(value, np.linalg.norm(ends - starts, axis=1).sum() / 3e5)
            gap = to_segments(left, starts, ends, spacing)
            far = gap > allowed
            if len(np.unique(tolerance)) == 1 and far.any():
                worst_out = over(left[far], starts, ends, allowed)
            left = left[far]
    if len(np.unique(tolerance)) > 1 and len(left):
        some = left[:: max(len(left) // 300, 1)]
        factor = np.full(len(some), np.inf)
        for value in np.unique(tolerance):
            mine = [p for p, t in zip(part.pieces, part.tolerance, strict=True) if t == value]
            starts, ends = np.concatenate([p[:-1] for p in mine]), np.concatenate([p[1:] for p in mine])
            factor = np.minimum(factor, exactly(some, starts, ends) / (value * (MARGIN + 2e-3) + 1e-8))
        worst_out = float(factor.max())
    return worst_out, worst_back


def _inner(points: Floats, tolerance: Floats, k: int) -> Floats:
    """Return dense places of a piece, without an end at which a neighbour of wider tolerance begins."""
    places = dense(points, tolerance[k])
    first = k > 0 and tolerance[k - 1] > tolerance[k]
    last = k + 1 < len(tolerance) and tolerance[k + 1] > tolerance[k]
    return places[int(first) : len(places) - int(last)]


def limits(setpoints: Floats, machine: Machine) -> float:
    """Return the largest finite difference as a part of its limit, rest before and after."""
    padded = np.concatenate([np.repeat(setpoints[:1], 3, 0), setpoints, np.repeat(setpoints[-1:], 3, 0)])
    worst = 0.0
    for column, letter in enumerate(machine.axes):
        axis = machine.axes[letter]
        unit = DEGREE if letter in "AC" else 1.0
        for k, limit in enumerate((axis.max_velocity, axis.max_acceleration, axis.max_jerk), start=1):
            size = np.abs(np.diff(padded[:, column], k)).max() / machine.period_s**k * unit
            worst = max(worst, (size - 2.0**k * 1e-12 / machine.period_s**k) / limit)
    return worst


def judge(seed: int, index: int) -> str:
    """Plan one program; return what is wrong with it, or nothing."""
    part = random_part(seed, index)
    machine = random_machine(part.rng)
    text = "\n".join(part.lines) + "\n"
    try:
        signal.alarm(PATIENCE_S)
        stream = sample(plan(read_text(text), machine))
        chunk = stream.collect()
    except CncgenError as error:
        return f"refused: {error}"
    except TimeoutError:
        return f"not done in {PATIENCE_S} s"
    finally:
        signal.alarm(0)
    position = np.zeros((len(chunk), len(AXES)))
    given = file_units(chunk.position, chunk.axes)
    for column, letter in enumerate(chunk.axes):
        position[:, AXES.index(letter)] = given[:, column]
    found = []
    if (ratio := limits(position, machine)) > MARGIN:
        found.append(f"limit x {ratio:.4f}")
    out, back = distances(part, position)
    if out > 1.0:
        found.append(f"motion leaves the path by {out:.3f} of the tolerance")
    if back > 1.0:
        found.append(f"path is missed by {back:.3f} of the tolerance")
    return "; ".join(found)


def _too_long(*_: object) -> None:
    raise TimeoutError


def main() -> int:
    """Run the programs; exit 1 where something is wrong."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("count", type=int, nargs="?", default=100)
    parser.add_argument("--seed", type=int, default=first_for_tuning("g64_tolerance"))
    parser.add_argument("--only", metavar="SEED:INDEX", help="print this program, and judge it")
    options = parser.parse_args()
    signal.signal(signal.SIGALRM, _too_long)
    if options.only:
        seed, index = map(int, options.only.split(":"))
        print("\n".join(random_part(seed, index).lines))
        print(judge(seed, index) or "holds", file=sys.stderr)
        return 0
    wrong, begun = 0, time.process_time()
    for index in range(options.count):
        start = time.process_time()
        fault = judge(options.seed, index)
        spent = time.process_time() - start
        if fault or spent > 30:
            wrong += bool(fault)
            print(f"{options.seed}:{index}: {fault or 'slow'} ({spent:.1f} s)", flush=True)
    print(f"{options.count} programs, {wrong} wrong, {time.process_time() - begun:.0f} s")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

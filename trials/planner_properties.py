"""Properties of every plan, tried on random paths over all kinds of motion: thousands of them, shrunk where one fails.

    python -m trials.planner_properties                      # every property, 300 paths each
    python -m trials.planner_properties limits 5000 --seed 3
    python -m trials.planner_properties limits 5000 --seed 3 --shrink

The properties, one function each, say in their docstrings what they ask. A failure is printed as a program and the
machine's limits; with --shrink the first one is made smaller. `tests/planner/test_properties.py` runs a small fixed set of the same.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import signal
import sys
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from cncgen.planner import PlanOptions, plan
from cncgen.planner.limits.axis_limits import axis_scale
from cncgen.planner.motion import motion_at
from cncgen.planner.record import Limit, Trajectory
from cncgen.toolpath.record import FeedMode, Kind, Toolpath
from trials.generators.paths import LETTERS, PERIOD, Arc, Case, Floats, Line, Move, cases, chains, outlines
from trials.seeds import first_for_tuning

#: Setpoints may pass a limit by a thousandth (rounding of the setpoints themselves is far below).
HELD = 1.001
#: Setpoints (five minutes) beyond which `limits` does not sample a plan, and so says nothing of it: it takes too long.
LONGEST = 300_000
#: Cases that take longer, s of CPU, are printed.
SLOW_S = 10.0


# --- plans ----------------------------------------------------------------------------------------------------------


def _duration(trajectories: list[Trajectory]) -> float:
    """Return how long a motion takes, s: a stand before its start does not count, since its reverse lacks it."""
    if not trajectories:
        return 0.0
    first = trajectories[0].profile
    stood = first.t[1] if len(first) and first.waits[0] and first.limit[0] != Limit.STOP else 0.0
    return float(trajectories[-1].profile.t[-1] - stood)


@dataclass(frozen=True)
class Planned:
    """All trajectories of a case."""

    trajectories: list[Trajectory]
    axes: str

    @property
    def time(self) -> float:
        """Duration, s."""
        return _duration(self.trajectories)

    @property
    def rounded(self) -> Floats:
        """Path coordinate times the largest dx/ds, shape (axes,): the move of each axis by one rounding of s."""
        out = np.zeros(len(self.axes))
        for each in self.trajectories:
            path = each.toolpath.path
            moving = np.flatnonzero(np.diff(path.row_s) > 0.0)
            if len(moving):
                middle = 0.5 * (path.row_s[moving] + path.row_s[moving + 1])
                x1 = np.abs(path.evaluate(middle, 1)[1]).max(axis=0)
                out = np.maximum(out, x1 * abs(path.row_s[-1]))
        return out

    def states(self, t: Floats) -> tuple[Floats, Floats]:
        """Return positions, shape (n, axes), and derivatives in time by the pieces' formula, shape (3, n, axes)."""
        ends = np.array([each.profile.t[-1] for each in self.trajectories])
        which = np.minimum(np.searchsorted(ends, t), len(ends) - 1)
        position, derivatives = np.zeros((len(t), len(self.axes))), np.zeros((3, len(t), len(self.axes)))
        for i, trajectory in enumerate(self.trajectories):
            mine = which == i
            if not mine.any():
                continue
            if trajectory.cubics is not None:
                found = trajectory.cubics.at(t[mine], 3)
                position[mine], derivatives[:, mine] = found[0], found[1:]
                continue
            at = motion_at(trajectory.profile, t[mine])
            x = trajectory.toolpath.path.evaluate(at.s, 3)
            v, a, j = at.v[:, None], at.a[:, None], at.j[:, None]
            position[mine] = x[0]
            derivatives[:, mine] = (
                x[1] * v,
                x[2] * v**2 + x[1] * a,
                x[3] * v**3 + 3.0 * x[2] * v * a + x[1] * j,
            )
        return position, derivatives


def planned(case: Case, **options: object) -> Planned:
    """Plan a case with `optimal`."""
    toolpaths = case.toolpaths
    done = list(plan(toolpaths, case.machine, PlanOptions(feedrate="optimal", **options)))  # type: ignore[arg-type]
    return Planned(done, toolpaths[0].axes if toolpaths else "XYZ")


def limits_of(case: Case, axes: str) -> Floats:
    """Return velocity, acceleration and jerk of the axes, shape (3, axes); those that the machine lacks do not move."""
    machine = case.machine
    rows = [
        (a.max_velocity, a.max_acceleration, a.max_jerk)
        if (a := machine.axes.get(letter))
        else (1.0, 1.0, 1.0)
        for letter in axes
    ]
    return np.array(rows).T


# --- properties -----------------------------------------------------------------------------------------------------


def limits(case: Case) -> None:
    """First, second and third differences a period apart are within 1.001 limits, wherever the period starts."""
    done = planned(case)
    allowed = limits_of(case, done.axes)
    count = int(np.ceil(done.time / PERIOD)) + 4
    if count > LONGEST:
        return  # minutes of setpoints of a slow feed
    for phase in (0.0, 0.2, 0.43, 0.71, 0.9):
        t = (np.arange(-3, count) + phase) * PERIOD
        x = done.states(np.clip(t, 0.0, done.time))[0]
        for order in (1, 2, 3):
            found = np.abs(np.diff(x, order, axis=0)).max(axis=0, initial=0.0) / PERIOD**order
            # Positions carry rounding of a few 1e-16 of their size, and that of the path coordinate by dx/ds.
            noise = 2.0**order * 4e-16 * (np.abs(x).max(initial=1.0) + done.rounded) / PERIOD**order
            worst = (found - noise) / allowed[order - 1]
            assert worst.max() <= HELD, (
                f"order {order}, axis {done.axes[int(worst.argmax())]}: {worst.max():.5f} of the limit, phase {phase}"
            )


def continuous(case: Case) -> None:
    """Velocity and acceleration of every axis are within 1.001 limits at every instant, not at setpoints alone."""
    done = planned(case)
    allowed = limits_of(case, done.axes)
    t = np.linspace(0.0, done.time, min(200_000, 20 * int(done.time / PERIOD) + 200))
    _, derivatives = done.states(t)
    for order in (0, 1):
        worst = np.abs(derivatives[order]).max(axis=0) / allowed[order]
        assert worst.max() <= HELD, (
            f"order {order + 1}, axis {done.axes[int(worst.argmax())]}: {worst.max():.5f}"
        )


def units(case: Case) -> None:
    """Lengths, limits and tolerances in another unit leave the time as it is, to 1e-9."""
    if any(isinstance(move, Line) and move.by[3] for move in case.moves):
        return  # beside angles, which have no such unit, lengths cannot be scaled
    one, other = planned(case).time, planned(replace(case, scale=25.4)).time
    assert abs(one - other) <= 1e-9 * one, f"{one:.12g} s, scaled {other:.12g} s"


def splitting(case: Case) -> None:
    """Straight moves and arcs cut in three: the time changes by less than a thousandth."""
    if case.inverse:
        return  # the time of each part would have to be said anew
    cut: list[Move] = []
    for move in case.moves:
        if isinstance(move, Line) and max(map(abs, move.by)) > 1e-3:
            cut += [Line(tuple(part * x for x in move.by)) for part in (0.5, 0.2, 0.3)]  # type: ignore[arg-type]
        elif isinstance(move, Arc):
            for begin, part in ((0.0, 0.4), (0.4, 0.35), (0.75, 0.25)):
                cut.append(
                    replace(
                        move,
                        start=move.start + begin * move.sweep,
                        sweep=part * move.sweep,
                        rise=part * move.rise,
                    )
                )
        else:
            cut.append(move)
    one, other = planned(case).time, planned(replace(case, moves=tuple(cut))).time
    assert abs(one - other) <= 1e-3 * one + 1e-6, (
        f"{one:.9g} s, split {other:.9g} s ({(other / one - 1.0) * 100:+.3f} %)"
    )


def relaxing(case: Case) -> None:
    """Any one limit half as large again: the time is longer by a thousandth at most."""
    one = planned(case).time
    wider = [replace(case, feed=1.5 * case.feed)]
    for i in range(len(LETTERS)):
        for k in range(3):
            rows = [list(row) for row in case.limits]
            rows[i][k] *= 1.5
            wider.append(replace(case, limits=tuple(map(tuple, rows))))  # type: ignore[arg-type]
    moving = {0, 1, 2} | ({3} if any(isinstance(m, Line) and m.by[3] for m in case.moves) else set())
    for number, other in enumerate(wider):
        if number and (number - 1) // 3 not in moving:
            continue
        time = planned(other).time
        name = (
            "feed"
            if not number
            else f"{LETTERS[(number - 1) // 3]} {('velocity', 'acceleration', 'jerk')[(number - 1) % 3]}"
        )
        assert time <= one * 1.001 + 1e-6, (
            f"{one:.9g} s; with more {name} {time:.9g} s ({(time / one - 1.0) * 100:+.3f} %)"
        )


def reversing(case: Case) -> None:
    """The program from its end to its start takes as long, within 0.5 %."""
    one = planned(case).time
    back = plan(_reversed(case.toolpaths), case.machine, PlanOptions(feedrate="optimal"))
    other = _duration(list(back))
    assert abs(one - other) <= 0.005 * one + 1e-6, (
        f"{one:.9g} s, reversed {other:.9g} s ({(other / one - 1.0) * 100:+.3f} %)"
    )


def pace(case: Case) -> None:
    """Rows that turn rotary axes beside X Y Z take together no less than their feeds ask: 0.1 %, and two periods where they meet others.

    Rows that turn alone have their feed as those of X Y Z have, and are cut at corners as these are.
    """
    asked, taken = 0.0, 0.0
    turning: set[int] = set()
    for tp in case.toolpaths:
        turns = (tp.kind != Kind.EVENT) & (tp.feed_mode != FeedMode.RAPID)
        turns &= (tp.end != tp.starts)[:, 3:].any(axis=1) & np.isin(tp.path.measured_by, (0, 3))
        timed = tp.feed_mode == FeedMode.INVERSE_TIME
        asked += (np.where(timed, 1.0, tp.path.feed_length) / tp.feed)[turns].sum()
        turning.update(tp.line[turns].tolist())
    for each in planned(case).trajectories:
        time = np.diff(np.interp(each.row_s, each.profile.s, each.profile.t))
        taken += time[np.isin(each.toolpath.line, list(turning))].sum()
    assert taken >= 0.999 * asked - 2.0 * case.machine.period_s, f"{taken:.6g} s of {asked:.6g} s"


def bounds(case: Case) -> None:
    """No longer than with a stop at every junction, no shorter than by velocity and acceleration alone, within the tolerance."""
    one = planned(case).time
    stopped = planned(replace(case, mode="G61.1")).time
    assert one <= stopped * 1.001 + 1e-6, f"{one:.9g} s, with stops everywhere {stopped:.9g} s"
    if case.mode.startswith("G64"):
        least = least_within(case)
    else:
        least = acceleration_only(case)
        if one < least * 0.998 - 1e-6:
            # Where a curve bends sharply, a few nodes are slow for more of it than is.
            least = acceleration_only(case, 48_000)
    assert one >= least * 0.998 - 1e-6, f"{one:.9g} s, acceleration alone needs {least:.9g} s"


def tolerances(case: Case) -> None:
    """Without stops no longer than with them, and no tolerance takes longer than one that is less: 0.1 %."""
    stopped = planned(replace(case, mode="G61.1")).time
    least = stopped
    for mode in ("G61", "G64 P0.001", "G64 P0.003", "G64 P0.01", "G64 P0.03", "G64 P0.1"):
        time = planned(replace(case, mode=mode)).time
        assert time <= least * 1.001 + 1e-6, (
            f"{mode} {time:.9g} s, with less {least:.9g} s ({(time / least - 1.0) * 100:+.3f} %), with stops {stopped:.9g} s"
        )
        # Corners of G61 are passed where setpoints do not see them, which a tolerance does not promise.
        least = least if mode == "G61" else min(least, time)


def chords(case: Case) -> None:
    """A wider chord tolerance takes no longer, 0.1 %: with setpoints 2 ms apart at least, where chords count."""
    coarse = replace(case, period=max(case.period or PERIOD, 2e-3))
    for mode in ("G64 P0.003", "G64 P0.01"):
        least = math.inf
        for chord in (1e-4, 3e-4, 1e-3, 3e-3, 1e-2):
            time = planned(replace(coarse, mode=mode, chord=chord)).time
            assert time <= least * 1.001 + 1e-6, (
                f"{mode}, chord {chord:g} {time:.9g} s, with less {least:.9g} s ({(time / least - 1.0) * 100:+.3f} %)"
            )
            least = min(least, time)


def _reversed(toolpaths: list[Toolpath]) -> list[Toolpath]:
    """Return the motions from the end to the start, events at their places."""
    out = []
    for tp in toolpaths[::-1]:
        n = len(tp)
        order = np.arange(n)[::-1]
        ends = np.concatenate([tp.start[None], tp.end])
        arcs, splines = tp.arcs, tp.nurbs
        turns = np.flatnonzero(tp.kind == Kind.ARC)
        which = tp.curve[turns]
        # The centre stands at the height of the start point, which is now the other end.
        rise = np.einsum("ij,ij->i", (ends[turns + 1] - ends[turns])[:, :3], arcs.normal[which])
        centre = arcs.centre.copy()
        centre[which] += rise[:, None] * arcs.normal[which]
        flat = []
        weights, knots = [], []
        for i in range(len(splines)):
            p = slice(splines.point_offset[i], splines.point_offset[i + 1])
            k = slice(splines.knot_offset[i], splines.knot_offset[i + 1])
            flat.append(splines.control_points[p][::-1])
            weights.append(splines.weights[p][::-1])
            u = splines.knots[k]
            knots.append((u[0] + u[-1] - u)[::-1])
        if len(splines):
            splines = replace(
                splines,
                control_points=np.concatenate(flat),
                weights=np.concatenate(weights),
                knots=np.concatenate(knots),
            )
        out.append(
            replace(
                tp,
                start=ends[-1],
                end=ends[:-1][order],
                arcs=replace(arcs, centre=centre, normal=-arcs.normal),
                nurbs=splines,
                **{
                    name: getattr(tp, name)[order]
                    for name in (
                        "kind",
                        "feed",
                        "feed_mode",
                        "path_mode",
                        "tolerance",
                        "curve",
                        "line",
                        "source",
                    )
                },
            )
        )
    return out


def acceleration_only(case: Case, nodes: int = 3000) -> float:
    """Return the least time by feed, velocity and acceleration alone, corners passed at any speed: a lower bound.

    On nodes along each row, q = v² is bounded, and every axis bounds q'/2 = a by |x'' q + x' a| <= A; a backward and a
    forward pass take the largest q that can still brake and that can be reached.
    """
    total = 0.0
    toolpaths = case.toolpaths
    hs: list[Floats] = []
    cap: list[Floats] = []
    shape: list[tuple[Floats, Floats]] = []
    allowed = limits_of(case, toolpaths[0].axes) if toolpaths else np.ones((3, 3))
    for tp in toolpaths:
        for row in np.flatnonzero(tp.kind == Kind.EVENT):
            total += tp.events[tp.curve[row]].dwell_s
        path = tp.path
        if not path.length > 0.0:
            continue
        inverse = tp.feed_mode == FeedMode.INVERSE_TIME
        speed = tp.feed * np.where(inverse, np.diff(path.row_s), path.per_feed)
        for row in np.flatnonzero(np.diff(path.row_s) > 0.0):
            count = max(100, int(nodes * np.diff(path.row_s)[row] / path.length))
            s = np.linspace(path.row_s[row], path.row_s[row + 1], count + 1)
            x = path.evaluate(0.5 * (s[1:] + s[:-1]), 2)
            with np.errstate(divide="ignore", invalid="ignore"):
                top = np.minimum(speed[row], (allowed[0] / np.abs(x[1])).min(axis=1)) ** 2
                # An axis that all but stands on the whole of an interval, which one that turns back does nowhere.
                stands = np.abs(x[1]) + 0.5 * np.diff(s)[:, None] * np.abs(x[2]) < 1e-9
                bend = np.where(stands, allowed[1] / np.abs(x[2]), np.inf).min(axis=1)
            cap.append(np.minimum(top, bend))
            shape.append((x[1], x[2]))
            hs.append(np.diff(s))
    if not hs:
        return total
    h, top = np.concatenate(hs), np.concatenate(cap)
    x1, x2 = (np.concatenate([each[i] for each in shape]) for i in (0, 1))
    return total + _two_passes(h, top, x1, x2, allowed[1])


def _two_passes(h: Floats, top: Floats, x1: Floats, x2: Floats, acceleration: Floats) -> float:
    """Run the passes on intervals; q is bounded on each, and so is the change over it."""
    n = len(h)

    def after(q: float, k: int) -> float:
        """Return the largest q at the other end of interval k, with a from the largest that all axes allow at q."""
        with np.errstate(divide="ignore", invalid="ignore"):
            free = (acceleration - np.sign(x1[k]) * x2[k] * q) / np.abs(x1[k])
        a = float(np.where(np.abs(x1[k]) > 1e-9, free, np.inf).min())
        return q + 2.0 * max(a, 0.0) * h[k] if math.isfinite(a) else math.inf

    back = np.zeros(n + 1)
    for k in range(n - 1, -1, -1):
        with np.errstate(divide="ignore", invalid="ignore"):
            free = (acceleration + np.sign(x1[k]) * x2[k] * back[k + 1]) / np.abs(x1[k])
        a = float(np.where(np.abs(x1[k]) > 1e-9, free, np.inf).min())
        back[k] = min(top[k] if k == 0 else max(top[k], top[k - 1]), back[k + 1] + 2.0 * max(a, 0.0) * h[k])
    q = np.zeros(n + 1)
    for k in range(n):
        q[k + 1] = min(after(q[k], k), back[k + 1], max(top[k], top[min(k + 1, n - 1)]))
    v = np.sqrt(q)
    return float((2.0 * h / np.maximum(v[:-1] + v[1:], 1e-12)).sum())


def least_within(case: Case) -> float:
    """Return a bound of the time of any motion within the tolerance P, by feed, velocity and acceleration alone.

    Of places in the order of the path, ends exact and the others met within P, each axis for itself goes at least from each turn
    to the next, less P at either, and rests at turns: L/V + V/A, or 2 √(L/A) where that is too short for V. The way over X Y Z
    is at least that between any choice of the places, less P at either, and none of it is faster than the feed.
    """
    tolerance = float(case.mode[5:]) * case.scale
    toolpaths = case.toolpaths
    dwell, places, feed = 0.0, [tp.start[None] for tp in toolpaths[:1]], 0.0
    for tp in toolpaths:
        dwell += sum(tp.events[tp.curve[row]].dwell_s for row in np.flatnonzero(tp.kind == Kind.EVENT))
        ends = tp.path.row_s
        moves = np.flatnonzero(np.diff(ends) > 0.0)
        for row in moves:
            parts = np.linspace(0.0, 1.0, 2 if tp.kind[row] == Kind.LINE else 25)[1:]
            places.append(tp.path.evaluate(ends[row] + parts * (ends[row + 1] - ends[row]))[0])
        inverse = tp.feed_mode[moves] == FeedMode.INVERSE_TIME
        speed = tp.feed[moves] * np.where(inverse, np.diff(ends)[moves], tp.path.per_feed[moves])
        feed = max(feed, float(speed.max(initial=0.0)))
    if len(places) < 2:
        return dwell
    x = np.concatenate(places)
    least = _way(x[:, :3], tolerance) / feed
    scale = axis_scale(toolpaths[0].axes, 1.0)
    for column, of, velocity, acceleration in zip(
        x.T, scale, *limits_of(case, toolpaths[0].axes)[:2], strict=True
    ):
        way = _turns(column, tolerance / of)
        peak = np.minimum(velocity, np.sqrt(way * acceleration))
        times = np.divide(way, peak, out=np.zeros_like(way), where=peak > 0.0) + peak / acceleration
        least = max(least, float(times.sum()))
    return dwell + least


def _turns(x: Floats, tolerance: float) -> Floats:
    """Return the ways at least from turn to turn of what passes values in order, within a tolerance but for both ends, shape (k,)."""
    pivots, far = [x[0]], x[0]
    for value in x[1:]:
        way = far - pivots[-1]
        if abs(value - far) > 2.0 * tolerance and way * (value - far) < 0.0:
            pivots.append(far)
            far = value
        elif way == 0.0 or (value - far) * way > 0.0:
            far = value
    if abs(x[-1] - far) > 0.0:
        pivots.append(far)
    ways = np.abs(np.diff([*pivots, x[-1]]))
    loose = np.full(len(ways), 2.0)
    loose[0] -= 1.0
    loose[-1] -= 1.0
    return np.maximum(ways - tolerance * loose, 0.0)


def _way(x: Floats, tolerance: float) -> float:
    """Return the most, over choices of places in order, of the lengths between them less the tolerance at either end."""
    most = np.zeros(len(x))
    for k in range(1, len(x)):
        away = np.sqrt(((x[k] - x[:k]) ** 2).sum(axis=1)) - tolerance * (np.arange(k) > 0)
        most[k] = (most[:k] + away).max() - tolerance * (k < len(x) - 1)
        most[k] = max(most[k], 0.0)
    return float(most[-1])


PROPERTIES: dict[str, tuple[Callable[[Case], None], st.SearchStrategy[Case]]] = {
    "limits": (limits, cases()),
    "continuous": (continuous, cases()),
    "units": (units, cases()),
    "splitting": (splitting, st.one_of(cases(modes=("G61", "G64")), chains())),
    "relaxing": (relaxing, cases()),
    "reversing": (reversing, cases()),
    "pace": (pace, cases(modes=("G64",))),
    "bounds": (bounds, cases()),
    "tolerances": (tolerances, outlines()),
    "chords": (chords, outlines()),
}


class TooSlow(Exception):
    """A case took longer than it may."""


def _alarm(*_: object) -> None:
    raise TooSlow("stopped")


def run(name: str, count: int, number: int, most_s: int = 60, shrink: bool = False) -> int:
    """Try a property on so many paths, print what happens as it happens, and return how many failed.

    Args:
        name: Of the property.
        count: Paths.
        number: Seed.
        most_s: Seconds of CPU that a case may take; one that takes longer counts as a failure.
        shrink: Stop at the first failure and look for a smaller one, which is printed last.
    """
    check, drawn = PROPERTIES[name]
    seconds: list[float] = []
    failed: list[int] = []
    start = time.monotonic()

    @settings(
        max_examples=count,
        deadline=None,
        database=None,
        print_blob=False,
        phases=[Phase.generate, Phase.shrink] if shrink else [Phase.generate],
        suppress_health_check=list(HealthCheck),
        report_multiple_bugs=False,
    )
    @seed(number)
    @given(drawn)
    def tried(case: Case) -> None:
        begin = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, most_s)
        try:
            check(case)
        except Exception as fault:
            failed.append(len(seconds))
            print(_described(name, len(seconds), fault, case), flush=True)
            if shrink:
                raise
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            seconds.append(time.process_time() - begin)
            if seconds[-1] > SLOW_S:
                print(f"{name} #{len(seconds) - 1}: slow, {seconds[-1]:.1f} s\n{case!r}", flush=True)
            if len(seconds) % 50 == 0:
                print(_progress(name, seconds, failed, start), flush=True)

    signal.signal(signal.SIGPROF, _alarm)
    with contextlib.suppress(AssertionError, TooSlow) if shrink else contextlib.nullcontext():
        tried()
    print("end of", _progress(name, seconds, failed, start), flush=True)
    return len(failed)


def _progress(name: str, seconds: list[float], failed: list[int], start: float) -> str:
    return (
        f"{name}: {len(seconds)} paths, {len(failed)} failed, {sum(seconds):.0f} s of CPU, "
        f"{time.monotonic() - start:.0f} s, median {np.median(seconds):.3f} s, slowest {max(seconds):.1f} s"
    )


def _described(name: str, number: int, fault: Exception, case: Case) -> str:
    where = "" if isinstance(fault, AssertionError) else "".join(traceback.format_tb(fault.__traceback__, -3))
    return f"FAILED {name} #{number}: {type(fault).__name__}: {fault}\n{where}{case!r}"


def main() -> None:
    """Run the properties that are asked for; exit 1 if one fails."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("name", nargs="?", default="all", choices=["all", *PROPERTIES])
    parser.add_argument("count", nargs="?", type=int, default=300)
    parser.add_argument("--seed", type=int, default=first_for_tuning("planner_properties"))
    parser.add_argument("--most", type=int, default=60, help="seconds of CPU that a case may take")
    parser.add_argument("--shrink", action="store_true", help="stop at the first failure and make it smaller")
    asked = parser.parse_args()
    names = list(PROPERTIES) if asked.name == "all" else [asked.name]
    sys.exit(
        1 if sum([run(name, asked.count, asked.seed, asked.most, asked.shrink) for name in names]) else 0
    )


if __name__ == "__main__":
    main()

"""The summary of a plan: gathered while the plan is computed, then as plain values and as a page of text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Diagnostics, Severity, UsageError, one_line
from cncgen.machine.record import Axis, Machine
from cncgen.planner.record import MAX_CORNERS, Limit, Profile, SharpCorner, Trajectory
from cncgen.report.feed_curve import FeedCurve, sparkline
from cncgen.report.slow_places import LISTED, SlowPlace, SlowPlaces
from cncgen.report.tables import counted, duration
from cncgen.report.thread_speeds import ThreadSpeeds
from cncgen.report.time_split import TimeSplit, split_text, untimed_text
from cncgen.setpoints.columns import position_column
from cncgen.setpoints.differences import DifferencePeaks
from cncgen.setpoints.record import Setpoints
from cncgen.toolpath.record import Kind, Program, Toolpath
from cncgen.units import ORDER_NAMES, ORDERS, file_unit, is_rotary, to_file

if TYPE_CHECKING:
    from cncgen.report.line_times import LineTimes

Floats = NDArray[np.float64]

SCHEMA_VERSION = 1

#: A peak is over its limit beyond this part of it, as `cncgen verify` has it.
_OVER = 1.001


class Summary:
    """Observes the stages of one plan while they run, and gives its summary."""

    def __init__(
        self,
        program: Program,
        machine: Machine,
        feedrate: str | None,
        line_times: LineTimes | None = None,
        *,
        interpolator: str = "arclength",
        estimate: bool = False,
    ) -> None:
        self._program, self._machine = program, machine
        self._feedrate, self._interpolator = feedrate, interpolator
        #: Whether the times are those of another control, whose setpoints nobody knows.
        self._estimate = estimate
        self.line_times = line_times
        self._axes = program.moving_axes or program.axes
        speeds = [axis.max_velocity for axis in machine.axes.values()]
        self._slow = SlowPlaces(max(speeds), machine.axes)
        self._differences = DifferencePeaks(len(self._axes), machine.period_s)
        fed = [group for group in ("XYZ", "UVW") if set(group) & set(self._axes)] or [self._axes]
        self._feeds = FeedCurve(
            [k for k, letter in enumerate(self._axes) if letter in fed[0]], machine.period_s
        )
        #: Of the axes that move: their place among those of the program, and name and unit in files.
        self._columns = [
            (k, position_column(letter), to_file(letter))
            for k, letter in enumerate(program.axes)
            if letter in self._axes
        ]
        self._lines: int | None = None
        self._line: int | None = 0
        #: Length of the planned path, and of the whole one, in the path's coordinate.
        self._gone = 0.0
        self._way: float | None = None
        self._corners: list[SharpCorner] = []
        self._corners_seen = self._corners_said = self._motions = 0
        #: Whether rotary axes turn along with linear ones: the feed of these is then not that of the tool on the workpiece.
        self._turns_along = False
        self._split = TimeSplit()
        self._threads = ThreadSpeeds()
        self._end_s = self._waited_s = self._stood_s = self._turned_s = self._length_mm = self._max_feed = 0.0
        self._values: dict[str, Any] = {}
        self._complete = False
        self.remarks = Diagnostics()

    def over_toolpaths(self, chunks: Iterable[Toolpath]) -> Iterator[Toolpath]:
        """Hand on the program's toolpaths, counting their motions."""
        for chunk in chunks:
            self._motions += int((chunk.kind != Kind.EVENT).sum())
            self._turns_along = self._turns_along or _turns_along(chunk)
            yield chunk

    def over_trajectories(self, trajectories: Iterable[Trajectory]) -> Iterator[Trajectory]:
        """Hand on trajectories, taking their times, lengths, corners and slow places."""
        for trajectory in trajectories:
            self._add(trajectory)
            yield trajectory

    def over_setpoints(self, chunks: Iterable[Setpoints]) -> Iterator[Setpoints]:
        """Hand on setpoints, taking their finite differences."""
        for chunk in chunks:
            self._differences.add(chunk.position)
            self._feeds.add(chunk.position)
            yield chunk
        self._differences.finish()
        if not self._estimate:
            self._remark_on_limits()
        self._complete = True

    def _remark_on_limits(self) -> None:
        """Say which limits the setpoints break; a strategy of the papers knows no jerk of an axis."""
        over: list[str] = []
        rounded: list[str] = []
        for column, letter in enumerate(self._axes):
            peak = self._peak(column, letter)
            for order, name in enumerate(ORDER_NAMES, start=1):
                share = peak[f"{name}_of_limit"] or 0.0
                # The plan is not to blame for what rounding to the ninth decimal adds to a difference.
                rounding = 0.5e-9 * (2.0 / self._machine.period_s) ** order
                if share > _OVER:
                    explained = peak[name] * (1.0 - 1.0 / share) <= rounding
                    (rounded if explained else over).append(f"{letter} {name} {100 * share:.4g} %")
        if rounded:
            message = (
                f"{', '.join(rounded)} of the limit: no more than rounding positions to the ninth decimal can make of it "
                f"at a period of {self._machine.period_s:g} s"
            )
            self.remarks.add(Diagnostic("plan-rounding", message, severity=Severity.NOTE))
        if over:
            exact = self._interpolator == "arclength"
            who = self._feedrate if exact else f"{self._feedrate} with {self._interpolator} interpolation"
            keeps = "--feedrate optimal" + ("" if exact else " with --interpolator arclength")
            self.remarks.add(
                Diagnostic(
                    "plan-over-limits",
                    f"{who} asks more than the machine's limits: {', '.join(over)} of the limit",
                    severity=Severity.WARNING,
                    hint=f"{keeps} keeps every limit of the axes; cncgen verify says where they are broken",
                )
            )

    def places(self) -> list[SlowPlace]:
        """Return the places that cost the most time, the worst first: up to `cncgen.report.slow_places.KEPT`."""
        return self._slow.worst()

    def done(self) -> float | None:
        """Return the part of the program that is planned, 0 to 1; None before the first motion.

        It is that of the lines. Where these come in another order or are not counted, it is that of the path, for whose length the
        program is read once more.
        """
        if self._line is not None and self._lines:
            return self._line / self._lines
        if not self._gone:
            return None
        if self._way is None:
            self._way = sum(chunk.path.length for chunk in self._program.chunks())
        return min(self._gone / self._way, 1.0) if self._way else None

    def _follow(self, trajectory: Trajectory) -> None:
        """Take how far the lines have come, as long as they come one after the other."""
        if self._lines is None:
            self._lines = self._program.count_lines()
        rows, s = trajectory.toolpath, trajectory.profile.s
        if self._line is None or not len(rows) or not len(s):
            return
        ends = np.searchsorted(trajectory.row_s[1:], s[[0, -1]], side="left")
        first, last = np.minimum(ends, len(rows) - 1).tolist()
        # A piece may begin in a row before the one in which the last piece ended, where the way is rounded.
        back = np.any(np.diff(rows.line[first : last + 1]) < 0)
        ahead = not back and self._line <= int(rows.line[last]) and not rows.source[last]
        self._line = int(rows.line[last]) if ahead else None

    def _add(self, trajectory: Trajectory) -> None:
        self._follow(trajectory)
        profile = trajectory.profile
        top = _top_speeds(profile)
        self.remarks.extend(self._threads.add(trajectory, top))
        if len(profile):
            time, length = np.diff(profile.t), np.diff(profile.s)
            turns = _turning(trajectory)
            if turns.any():
                self._turned_s += float(time[turns].sum())
                length, top = length[~turns], top[~turns]
            self._waited_s += float(time[profile.waits & (profile.limit == Limit.STOP)].sum())
            if profile.t[0] == 0.0 and profile.waits[0] and profile.limit[0] != Limit.STOP:
                # Until the first motion a plan may wait for a setpoint that meets it well.
                self._stood_s = float(time[0])
            self._length_mm += float(length.sum())
            self._gone += float(np.ptp(profile.s))
            self._max_feed = max(self._max_feed, float(top.max(initial=0.0)))
        if len(profile.t):
            self._end_s = float(profile.t[-1])
        self._corners.extend(trajectory.corners[: MAX_CORNERS - len(self._corners)])
        self._slow.add(trajectory)
        self._split.add(trajectory)
        if self.line_times is not None:
            self.line_times.add(trajectory)
        values = dict(trajectory.values)
        # A plan hands on so many corners at most, and counts the others; its number may be of corners that are still to come.
        self._corners_seen += len(trajectory.corners)
        self._corners_said = values.pop("corners_total", self._corners_said)
        self.remarks.extend(values.pop("diagnostics", ()))
        self._values.update(values)

    def __repr__(self) -> str:
        rest = duration(self.as_json()["cycle_time_s"]) if self._complete else "not drawn to its end"
        return f"Summary({self._program.name!r} on {self._machine.name!r}, {rest})"

    def __str__(self) -> str:
        """Return what ``cncgen plan`` prints; of setpoints that have not been drawn to their end, what `repr` says."""
        return as_text(self.as_json()) if self._complete else repr(self)

    def as_json(self) -> dict[str, Any]:
        """Return the output of ``cncgen plan --summary`` as plain values.

        Raises:
            UsageError: The setpoints have not been drawn to their end: half a plan has no time.
        """
        if not self._complete:
            hint = "draw the stream first: stream.collect(), cncgen.write(stream, …) or cncgen.simulate(stream, …)"
            raise UsageError(
                Diagnostic(
                    "summary-early",
                    "the setpoints of this summary have not been drawn to their end",
                    hint=hint,
                )
            )
        moving = self._end_s - self._waited_s - self._stood_s
        feeding = moving - self._turned_s
        diagnostics = [*self._program.diagnostics, *self.remarks]
        return {
            "schema_version": SCHEMA_VERSION,
            "program": self._program.name,
            "machine": self._machine.name,
            "feedrate": self._feedrate,
            **self._split.as_json(),
            "untimed_events": {} if self._machine.settings.get("times") else self._split.instant,
            "motion_time_s": moving,
            "dwell_time_s": self._split.dwell_s,
            "path_length_mm": self._length_mm,
            "motions": self._motions,
            "samples": self._differences.samples,
            "period_s": self._machine.period_s,
            "peak": {}
            if self._estimate
            else {letter.lower(): self._peak(k, letter) for k, letter in enumerate(self._axes)},
            "feed_mm_s": {"mean": self._length_mm / feeding if feeding > 0 else 0.0, "max": self._max_feed},
            "feed_of": "slides" if self._turns_along else "path",
            "feed_over_time_mm_s": self._feeds.feeds_mm_s(),
            "sharp_corners": [self._corner(corner) for corner in self._corners],
            "sharp_corner_count": max(self._corners_seen, self._corners_said),
            "slowest": [
                {
                    "lost_s": place.lost_s,
                    "line": place.line,
                    "source": place.source,
                    "position": self._position(place.position),
                    "t_s": place.t_s,
                    "s_mm": place.s_mm,
                    "feed_mm_s": place.feed_mm_s,
                    "limit": place.limit.name.lower(),
                    "axis": place.axis,
                }
                for place in self.places()[:LISTED]
            ],
            **{k: v for k, v in self._values.items() if isinstance(v, str | int | float | bool | None)},
            "diagnostics": [item.as_json() for item in diagnostics],
        }

    def _corner(self, corner: SharpCorner) -> dict[str, Any]:
        return {
            "line": corner.line,
            "position": self._position(corner.position),
            "feed_mm_s": corner.feed_mm_s,
            "limit": corner.limit.name.lower(),
            "t_s": corner.t_s,
        }

    def _position(self, position: Sequence[float]) -> dict[str, float]:
        """Return a position of all axes by column, in the units of files, of the axes that move."""
        return {name: position[k] * factor for k, name, factor in self._columns if k < len(position)}

    def _peak(self, column: int, letter: str) -> dict[str, Any]:
        """Return the peaks of an axis in the units of files, and each as a fraction of its limit."""
        axis: Axis | None = self._machine.axes.get(letter)
        found: dict[str, Any] = {"unit": file_unit(letter)}
        for order, name in enumerate(ORDER_NAMES):
            value = float(self._differences.peak[order, column])
            limit = getattr(axis, f"max_{name}") if axis else None
            found[name] = value * to_file(letter)
            found[f"{name}_of_limit"] = value / limit if limit else None
        return found


def _turns_along(toolpath: Toolpath) -> bool:
    """Tell whether a row of a toolpath moves rotary axes and linear ones together."""
    rotary = np.array([is_rotary(letter) for letter in toolpath.axes])
    if not rotary.any():
        return False
    moves = toolpath.end != toolpath.starts
    moves[:, ~rotary] |= (toolpath.kind == Kind.ARC)[:, None]
    return bool((moves[:, rotary].any(axis=1) & moves[:, ~rotary].any(axis=1)).any())


def _turning(trajectory: Trajectory) -> NDArray[np.bool_]:
    """Tell the pieces of a profile whose path is the angle of rotary axes and not a length, shape (pieces,)."""
    profile, rows = trajectory.profile, trajectory.toolpath
    # Without rotary axes the rows need not be measured.
    turns = rows.path.turns if any(map(is_rotary, rows.axes)) else np.zeros(1, np.bool_)
    if not turns.any():
        return np.zeros(len(profile), np.bool_)
    middle = 0.5 * (profile.s[:-1] + profile.s[1:])
    row = np.minimum(np.searchsorted(trajectory.row_s[1:], middle, side="left"), len(rows) - 1)
    moves: NDArray[np.bool_] = np.diff(profile.s) > 0.0
    return turns[row] & moves


def _top_speeds(profile: Profile) -> Floats:
    """Return the largest speed of each piece of a profile: at its start, or where its acceleration ends."""
    v, a, j = profile.v, profile.a, profile.j
    falling = (a > 0) & (j < 0)
    turn = np.where(falling, -a / np.where(falling, j, 1.0), np.inf)
    inside = turn < np.diff(profile.t)
    return np.where(inside, v + 0.5 * a * np.where(inside, turn, 0.0), v)


def as_text(summary: dict[str, Any]) -> str:
    """Return the summary as the lines that a person reads."""
    feed = summary["feed_mm_s"]
    lines = [
        one_line(f"{summary['program']} on {summary['machine']}")
        + f": {duration(summary['cycle_time_s'])} ({split_text(summary)})"
        + f", {summary['path_length_mm']:.4f} mm, {counted(summary['motions'], 'motion')}, {counted(summary['samples'], 'setpoint')}",
        f"feed{_feed_of(summary)}: mean {_short(feed['mean'])}, max {_short(feed['max'])} mm/s; {counted(summary['sharp_corner_count'], 'sharp corner')}",
    ]
    untimed = untimed_text(summary)
    if untimed:
        lines.append(f"  {untimed}")
    curve = sparkline(summary["feed_over_time_mm_s"])
    if curve:
        lines.append(f"  {curve}")
    for letter, peak in summary["peak"].items():
        parts = []
        for name, power in ORDERS:
            share = peak[f"{name}_of_limit"]
            of_limit = f" ({100 * share:.2f} %)" if share is not None else ""
            parts.append(f"{name} {peak[name]:.6g} {peak['unit']}/s{power}{of_limit}")
        lines.append(f"  {letter.upper()}: " + ", ".join(parts))
    kept = summary.get("tolerance_windows_kept")
    if kept:
        windows = counted(summary["tolerance_windows"], "window")
        lines.append(
            f"  the search found no motion in {kept} of {windows}: the plan along the path stands there"
        )
    places = 3 if summary["path_length_mm"] > 1.0 else 6
    lines.extend(_loss_text(place, summary["program"], places) for place in summary["slowest"][:3])
    return "\n".join(lines)


def _feed_of(summary: dict[str, Any]) -> str:
    """Return whose feed it is, where it is not that of the tool on the workpiece."""
    if summary.get("feed_of", "path") == "path":
        return ""
    slides = [letter for letter in summary["peak"] if not is_rotary(letter.upper())]
    return f" of the slides {' '.join(slides).upper()} (the tool's on the workpiece is another while rotary axes turn along)"


def _short(value: float) -> str:
    """Return a number with two decimals, a small one with three digits."""
    return f"{value:.2f}" if value >= 1.0 or value == 0.0 else f"{value:.3g}"


def _loss_text(place: dict[str, Any], program: str, places: int) -> str:
    """Return a place where time is lost: how much, line (with its file, if it is not the program), position, time, limit."""
    file = "" if place["source"] == program else f" of {place['source']}"
    # Rounded first, and 0 added: no axis stands at -0.000.
    at = " ".join(
        f"{k.split('_')[0].upper()}{round(v, places) + 0.0:.{places}f}" for k, v in place["position"].items()
    )
    limit = f"{place['axis']} {place['limit'].replace('_', ' ')}".strip()
    lost = 1000 * place["lost_s"]
    return f"  {lost:.{0 if lost >= 9.5 else 1}f} ms lost at line {place['line']}{file}, {at}, {place['t_s']:.3f} s: {limit}"

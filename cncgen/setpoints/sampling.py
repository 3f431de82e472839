"""Sampling: a trajectory becomes positions of the axes, one row a period, without an error that adds up.

Every sample is computed from its own time, t = k · period, in the closed form of its piece of the profile
(`cncgen.kernels.profile`) and by the exact geometry of its row; nothing is carried from sample to sample.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, NoPlanError, Span, UsageError
from cncgen.geometry.path import Path
from cncgen.machine.record import Machine
from cncgen.planner.limits.speeds import programmed_speed
from cncgen.planner.motion import Motion, by_time, motion_at
from cncgen.planner.record import MOST_ROWS, Limit, Profile, Trajectory
from cncgen.setpoints.record import Setpoints
from cncgen.toolpath.record import Event

Floats = NDArray[np.float64]

#: Names that ``--signals`` may give.
SIGNALS = ("vel", "acc", "jerk", "feed", "line", "limit", "programmed", "source", "tool_length")

#: Those of them that are derivatives of the axes, in order.
_DERIVATIVES = ("vel", "acc", "jerk")

#: Rows of one chunk of setpoints.
CHUNK_ROWS = 65_536


#: Part of a period by which the end of the motion may miss a sample through rounding alone.
_ROUNDING = 1e-6


def sample(
    trajectories: Iterable[Trajectory],
    machine: Machine,
    *,
    axes: str | None = None,
    signals: Sequence[str] = (),
) -> Iterator[Setpoints]:
    """Sample trajectories once a period of the machine, from t = 0 to the first tick at or after the end.

    Args:
        trajectories: Consecutive stretches of planned motion.
        machine: Gives the period.
        axes: Letters of the columns, some of the toolpath's axes; None: all of them.
        signals: Names out of `SIGNALS`.

    Yields:
        Chunks of at most `CHUNK_ROWS` rows. The last row is the end position, at rest. No trajectory, no rows.

    Raises:
        UsageError: A signal has an unknown name.
        NoPlanError: The motion takes more than `MOST_ROWS` periods (a feed or limit of next to nothing, a dwell in the
            wrong unit); raised as the setpoints are drawn.
    """
    unknown = [name for name in signals if name not in SIGNALS]
    if unknown:
        raise UsageError(
            Diagnostic("option-value", f"signals {', '.join(unknown)}: not one of {', '.join(SIGNALS)}")
        )
    derived = tuple(name for name in dict.fromkeys(signals) if name != "tool_length")
    chunks = _sample(trajectories, machine.period_s, axes, derived)
    return chunks if len(derived) == len(set(signals)) else _with_tool_length(chunks)


def _with_tool_length(chunks: Iterable[Setpoints]) -> Iterator[Setpoints]:
    """Yield chunks with the tool offset along the spindle, mm, that holds at each row, as the events of the program tell it."""
    length = 0.0
    for chunk in chunks:
        told = [
            (t_s, event.values["length_mm"]) for t_s, _, event in chunk.events if "length_mm" in event.values
        ]
        lengths = np.array([length, *(value for _, value in told)])
        rows = lengths[np.searchsorted([t_s for t_s, _ in told], chunk.time_s, "right")]
        length = float(lengths[-1])
        yield replace(chunk, signals={**chunk.signals, "tool_length": rows})


def _sample(
    trajectories: Iterable[Trajectory], period_s: float, axes: str | None, signals: tuple[str, ...]
) -> Iterator[Setpoints]:
    first = 0
    path: Path | None = None
    current: Trajectory | None = None
    waiting: list[tuple[float, int, Event]] = []
    lasting: list[tuple[float, int, Event]] = []
    for trajectory in trajectories:
        if path is None or current is None or trajectory.toolpath is not current.toolpath:
            path = trajectory.toolpath.path
        # An event may last beyond the stretch that hands it on.
        lasting = [each for each in lasting if each[0] + each[2].wait_s > first * period_s]
        current = replace(trajectory, events=(*lasting, *trajectory.events))
        lasting += [each for each in trajectory.events if each[2].wait_s]
        waiting += trajectory.events
        # The last tick is left to the next stretch: a stretch that ends on a tick hands that tick on.
        periods = float(np.ceil(trajectory.profile.t[-1] / period_s - _ROUNDING))
        if not periods <= MOST_ROWS:
            raise NoPlanError(_too_long(trajectory, period_s))
        # Even if the first motion takes almost no time, the first tick is at its start.
        ticks = max(int(periods), int(trajectory.profile.t[-1] > 0.0))
        while first < ticks:
            stop = min(ticks, first + CHUNK_ROWS)
            chunk, waiting = _chunk(current, path, first, stop, period_s, axes, signals, waiting)
            yield chunk
            first = stop
    if current is not None and path is not None:
        rest = _at_rest(current)
        chunk, waiting = _chunk(rest, path, first, first + 1, period_s, axes, signals, waiting, last=True)
        yield chunk


def _too_long(trajectory: Trajectory, period_s: float) -> Diagnostic:
    """Say that a motion takes too long, and on which line most of it."""
    profile, toolpath = trajectory.profile, trajectory.toolpath
    longest = int(np.argmax(np.diff(profile.t)))
    middle = 0.5 * (profile.s[longest] + profile.s[longest + 1])
    row = int(np.clip(np.searchsorted(trajectory.row_s, middle, "right") - 1, 0, len(toolpath) - 1))
    dwell = max(trajectory.events, key=lambda event: event[2].wait_s, default=None)
    waits = dwell is not None and dwell[2].wait_s >= profile.t[longest + 1] - profile.t[longest]
    line = dwell[1] if dwell is not None and waits else int(toolpath.line[row])
    end = float(profile.t[-1])
    return Diagnostic(
        "motion-endless",
        f"the motion takes {end:.4g} s, which is more than {MOST_ROWS:.0e} setpoints every {1e3 * period_s:g} ms",
        span=Span(toolpath.sources[int(toolpath.source[row])], line),
        hint="look at feed and dwell there (G4 P is in seconds or milliseconds), and at the machine's limits",
        values={"time_s": end},
    )


def _at_rest(trajectory: Trajectory) -> Trajectory:
    """Replace the profile of a trajectory by a wait at its end."""
    p = trajectory.profile
    wait = Profile.standing(p.s[-1], p.t[-1], p.t[-1], Limit.NONE)
    return Trajectory(trajectory.toolpath, trajectory.row_s, wait, cubics=trajectory.cubics)


def _chunk(
    trajectory: Trajectory,
    path: Path,
    first: int,
    stop: int,
    period_s: float,
    axes: str | None,
    signals: tuple[str, ...],
    waiting: list[tuple[float, int, Event]],
    last: bool = False,
) -> tuple[Setpoints, list[tuple[float, int, Event]]]:
    """Sample ticks `first` to `stop` of one trajectory; return them and the events that come later."""
    ticks = np.arange(first, stop, dtype=np.float64) * period_s
    at = motion_at(trajectory.profile, ticks)
    letters = trajectory.toolpath.axes
    columns = [letters.index(letter) for letter in (axes or letters)]
    orders = max(
        (_DERIVATIVES.index(n) + 1 for n in signals if n in _DERIVATIVES), default=int("feed" in signals)
    )
    x = path.evaluate(at.s, orders) if trajectory.cubics is None else trajectory.cubics.at(ticks, orders)
    if trajectory.cubics is not None and orders:
        # The length of its path by time is exact where pieces begin; so is the speed everywhere else.
        along = [i for i, letter in enumerate(letters) if letter in "XYZ"]
        at = replace(at, v=np.sqrt((x[1][:, along] ** 2).sum(axis=1)))
    if columns != list(range(len(letters))):
        x = x[:, :, columns]
    until = np.inf if last else (stop - 0.5) * period_s
    due = tuple(event for event in waiting if event[0] <= until)
    setpoints = Setpoints(
        axes="".join(letters[c] for c in columns),
        period_s=period_s,
        first=first,
        position=np.ascontiguousarray(x[0]),
        signals={name: _signal(name, ticks, x, at, trajectory) for name in signals},
        events=due,
    )
    return setpoints, [event for event in waiting if event[0] > until]


def _signal(name: str, ticks: Floats, x: Floats, at: Motion, trajectory: Trajectory) -> NDArray:
    """Return one signal: axis derivatives by the chain rule from ``x[k]`` = dᵏx/dsᵏ, or what the profile says."""
    if trajectory.cubics is not None and name in _DERIVATIVES:
        return x[_DERIVATIVES.index(name) + 1]
    if name in _DERIVATIVES:
        return by_time(x, at, _DERIVATIVES.index(name) + 1)
    if name == "feed":
        return at.v
    if name == "limit":
        return trajectory.profile.limit[at.piece]
    rows = np.searchsorted(trajectory.row_s[1:], at.s, side="left")
    rows = np.minimum(rows, len(trajectory.toolpath) - 1)
    if name == "programmed":
        return programmed_speed(trajectory.toolpath)[rows]
    found = trajectory.toolpath.source[rows] if name == "source" else trajectory.toolpath.line[rows]
    # While an event lasts the line is its own; lines of events count in the program itself.
    for t_s, line, event in trajectory.events:
        if event.wait_s:
            first, last = np.searchsorted(ticks, [t_s, t_s + event.wait_s])
            found[first:last] = 0 if name == "source" else line
    return found

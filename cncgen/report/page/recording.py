"""The record of a plan for the page, gathered while the plan is computed: signals as streams of bytes, and events.

Positions, lines, feeds and limits are kept row by row. Velocity, acceleration, jerk, forces and errors are kept row by row of a
short plan; of a long one the page has their lowest and highest value in blocks of rows (`streams.Bands`).
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import json_values
from cncgen.machine.record import Machine
from cncgen.planner.record import Trajectory
from cncgen.report.page.packed_rows import PackedStream
from cncgen.report.page.streams import Bands, Blob, RunStream
from cncgen.room import pool
from cncgen.setpoints.columns import Layout, file_units, position_column
from cncgen.setpoints.record import AXIS_SIGNALS, Setpoints
from cncgen.units import ORDER_NAMES, file_unit, is_rotary, to_file

_T = TypeVar("_T")

if TYPE_CHECKING:
    from cncgen.servo.record import Response

Floats = NDArray[np.float64]

#: Signals that the page is made of.
SIGNALS = ("vel", "acc", "jerk", "feed", "line", "limit", "programmed", "source")

#: Steps in which signals are written: mm or degrees, mm/s, and parts of the limits of acceleration and jerk.
POSITION_STEP, SPEED_STEP, CONTOUR_STEP, FORCE_STEP = 1e-4, 1e-2, 1e-5, 1e-2
_DIGITS_OF_LIMIT = {"vel": None, "acc": 3, "jerk": 2}

#: Values of all bands together while each row keeps its own, and where blocks are joined.
MOST_ROWWISE, MOST_JOINED = 800_000, 400_000
#: Bytes a row that positions and feed may take together; beyond it a long plan leaves out the feed of each row.
BYTES_A_ROW = 0.5
#: Events that are kept; the first ones of more.
MOST_EVENTS = 20_000
#: Chunks that may wait for the thread that writes them.
_AHEAD = 4

_RUNS = ("line", "limit", "source")


class Recording:
    """The streams of one plan, or of setpoints from elsewhere."""

    def __init__(self, machine: Machine, axes: str, period_s: float) -> None:
        self._machine, self._axes, self.period_s = machine, axes, period_s
        self._positions = [PackedStream() for _ in axes]
        self._feed = PackedStream()
        self._programmed = RunStream()
        self._runs: dict[str, RunStream] = {}
        self._motion: Bands | None = None
        self._servo: Bands | None = None
        self._reference: Bands | None = None
        self._force_unit: dict[str, str] = {}
        self._saturated = RunStream()
        self._has_feed = False
        self._events: list[dict[str, Any]] = []
        self.sources: tuple[str, ...] = ()
        self.rows = 0
        self._writer = pool(1)
        self._waiting: deque[Future[None]] = deque()

    def over_trajectories(self, trajectories: Iterable[Trajectory]) -> Iterator[Trajectory]:
        """Hand on trajectories, taking the names of the files that their lines are in."""
        for trajectory in trajectories:
            if len(trajectory.toolpath.sources) > len(self.sources):
                self.sources = trajectory.toolpath.sources
            yield trajectory

    def over_setpoints(self, chunks: Iterable[Setpoints]) -> Iterator[Setpoints]:
        """Hand on setpoints; another thread writes them."""
        for chunk in chunks:
            self._later(self._take, chunk)
            yield chunk

    def over_responses(self, responses: Iterable[Response]) -> Iterator[Response]:
        """Hand on the response of the servo axes to the setpoints."""
        for response in responses:
            self._later(self._take_response, response)
            yield response

    def _later(self, work: Callable[[_T], None], item: _T) -> None:
        self._waiting.append(self._writer.submit(work, item))
        while len(self._waiting) > _AHEAD:
            self._waiting.popleft().result()

    def _take(self, chunk: Setpoints) -> None:
        self.rows += len(chunk)
        position = file_units(chunk.position, chunk.axes)
        for stream, column in zip(self._positions, position.T, strict=True):
            stream.add(_scaled(column, POSITION_STEP))
        signals = chunk.signals
        if "feed" in signals:
            self._has_feed = True
            self._feed.add(_scaled(signals["feed"], SPEED_STEP))
        if "programmed" in signals:
            self._programmed.add(_scaled(signals["programmed"], SPEED_STEP))
        for name in _RUNS:
            if name in signals:
                self._runs.setdefault(name, RunStream()).add(signals[name])
        self._take_motion(chunk)
        for t_s, line, event in chunk.events:
            if len(self._events) < MOST_EVENTS:
                values = {"dwell_s": event.dwell_s} if event.dwell_s else {}
                values |= {"takes_s": event.takes_s} if event.takes_s else {}
                record = {"t_s": round(t_s, 6), "line": line, "event": event.name, **values, **event.values}
                self._events.append(json_values(record))

    def _take_motion(self, chunk: Setpoints) -> None:
        """Take velocity, acceleration, jerk and feed."""
        present = [name for name in AXIS_SIGNALS if name in chunk.signals]
        if not present:
            return
        if self._motion is None:
            names = Layout(chunk.axes, chunk.period_s, tuple(present)).names[1 + len(chunk.axes) :]
            steps = dict(zip(names, self._motion_steps(present), strict=True))
            self._motion = Bands({**steps, "feed_mm_s": SPEED_STEP}, MOST_ROWWISE, MOST_JOINED)
        columns = [file_units(chunk.signals[name], chunk.axes) for name in present]
        self._motion.add(np.column_stack([*columns, chunk.signals["feed"]]))

    def _motion_steps(self, signals: list[str]) -> list[float]:
        steps = []
        for signal in signals:
            for letter in self._axes:
                digits = _DIGITS_OF_LIMIT[signal]
                axis = self._machine.axes.get(letter)
                order = ORDER_NAMES[list(AXIS_SIGNALS).index(signal)]
                limit = getattr(axis, f"max_{order}") * to_file(letter) if axis else 1000.0
                steps.append(_step(limit, digits) if digits else SPEED_STEP)
        return steps

    def _take_response(self, response: Response) -> None:
        errors = file_units(response.position - response.command, response.axes)
        if self._servo is None:
            self._force_unit = dict(zip(response.axes, response.force_unit, strict=True))
            names = [f"{letter.lower()}_error_{file_unit(letter)}" for letter in response.axes]
            steps = dict.fromkeys(names, POSITION_STEP)
            steps |= {f"{letter.lower()}_force": FORCE_STEP for letter in response.axes}
            self._servo = Bands({**steps, "contour_error_mm": CONTOUR_STEP}, MOST_ROWWISE, MOST_JOINED // 4)
        contour = np.nan_to_num(response.contour_error_mm)
        self._servo.add(np.column_stack([errors, response.force, contour]))
        self._saturated.add(np.asarray(response.saturated.any(axis=1), np.int64))

    def take_reference(self, contour_mm: Floats) -> None:
        """Take the contour error against a wanted motion, shape (rows,), mm, beside that against the command."""
        self._reference = Bands({"reference_contour_mm": CONTOUR_STEP}, MOST_ROWWISE, MOST_JOINED // 4)
        self._reference.add(contour_mm[:, None])

    def finish(self, blob: Blob) -> dict[str, Any]:
        """Put all streams into a blob; return their descriptions, the axes and the events."""
        while self._waiting:
            self._waiting.popleft().result()
        self._writer.shutdown()
        streams: dict[str, Any] = {}
        for letter, stream in zip(self._axes, self._positions, strict=True):
            streams[position_column(letter)] = {"step": POSITION_STEP, "rows": stream.finish(blob)}
        for name, run in self._runs.items():
            streams[name] = {"runs": run.finish(blob)}
        if self._has_feed:
            streams["programmed_feed_mm_s"] = {"step": SPEED_STEP, "runs": self._programmed.finish(blob)}
        rowwise = self._motion is not None and self._motion.block == 1
        small = blob.size + self._feed.size <= BYTES_A_ROW * self.rows
        keep_feed = self._has_feed and (rowwise or small)
        if keep_feed:
            streams["feed_mm_s"] = {"step": SPEED_STEP, "rows": self._feed.finish(blob)}
        if self._motion is not None:
            streams |= self._motion.finish(blob, ["feed_mm_s"] if keep_feed else [])
        if self._servo is not None:
            streams |= self._servo.finish(blob)
            streams["saturated"] = {"runs": self._saturated.finish(blob)}
        if self._reference is not None:
            streams |= self._reference.finish(blob)
        return {
            "axes": [self._axis(letter) for letter in self._axes],
            "period_s": self.period_s,
            "rows": self.rows,
            "streams": streams,
            "events": self._events,
        }

    def _axis(self, letter: str) -> dict[str, Any]:
        axis, factor = self._machine.axes.get(letter), to_file(letter)
        limits = {name: getattr(axis, f"max_{name}") * factor for name in ORDER_NAMES} if axis else {}
        return {
            "letter": letter,
            "unit": file_unit(letter),
            "rotary": is_rotary(letter),
            "limits": limits,
            "force_unit": self._force_unit.get(letter, ""),
        }


def _scaled(values: Floats, step: float) -> NDArray[np.int64]:
    """Return values in whole steps. Multiplying by the inverse, a whole number, rounds as the printed decimals do."""
    return np.rint(values * round(1.0 / step)).astype(np.int64)


def _step(limit: float, digits: int) -> float:
    """Return the power of ten that shows so many digits of a limit after its first."""
    return float(10.0 ** (math.floor(math.log10(limit)) - digits))

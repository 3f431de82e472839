"""The stream record: positions of the axes, one row a period."""

from __future__ import annotations

import numbers
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.arguments import expect, expect_axes, expect_number, wrong
from cncgen.ranges import PERIOD_S, POSITION
from cncgen.shown import html_of
from cncgen.toolpath.record import Event

Floats = NDArray[np.float64]

#: Signals of one column an axis, with the power of the second in their unit.
AXIS_SIGNALS = {"vel": "_s", "acc": "_s2", "jerk": "_s3"}
#: Signals of one column, with its name and its unit; "" for whole numbers.
PATH_SIGNALS = {
    "feed": ("feed_mm_s", "mm/s"),
    "line": ("line", ""),
    "limit": ("limit", ""),
    "programmed": ("programmed_feed_mm_s", "mm/s"),
    "source": ("source", ""),
    "tool_length": ("tool_length_mm", "mm"),
}
#: Whole numbers up to this one are doubles.
_MOST_ROWS = 2.0**53


@dataclass(frozen=True, slots=True, eq=False)
class Setpoints:
    """A chunk of the setpoint stream: row `i` holds at ``(first + i) * period_s``.

    Attributes:
        axes: Letters of the columns.
        period_s: Time between rows.
        first: Index of the first row in the whole stream.
        position: Shape (n, axes), mm or rad.
        signals: Further columns by name, where they were asked for. ``vel``, ``acc`` and ``jerk`` have the shape (n, axes).
            The others have the shape (n,): ``feed`` (mm/s along the path), ``programmed`` (the feed that the program asks
            for, 0 in a rapid), ``line``, ``source`` (the file of the line, 0 for the program), ``limit`` (a
            `cncgen.planner.record.Limit`) and ``tool_length`` (mm, the tool offset along the spindle).
        events: Pairs of time and `Event` with the source line, that fall into this chunk.

    Raises:
        UsageError: A field is wrong, as it is made. Lists become arrays. Whether positions are finite is looked at where they are used.
    """

    axes: str
    period_s: float
    first: int
    position: Floats
    signals: Mapping[str, NDArray] = field(default_factory=dict)
    events: tuple[tuple[float, int, Event], ...] = ()

    def __post_init__(self) -> None:
        expect_axes(self.axes, "axes of setpoints")
        period_s = expect_number(self.period_s, "period_s of setpoints", *PERIOD_S)
        object.__setattr__(self, "period_s", period_s)  # of numpy, a file of JSON could not hold it
        expect(self.first, numbers.Integral, "first of setpoints", "the index of the first row")
        expect_number(self.first, "first of setpoints", -_MOST_ROWS, _MOST_ROWS)
        position = _doubles(self.position)
        if position.ndim != 2 or position.shape[1] != len(self.axes):
            raise wrong(
                f"setpoints of axes {self.axes} have an array of shape {position.shape}, not (rows, axes)"
            )
        object.__setattr__(self, "position", position)
        object.__setattr__(self, "signals", _signals(self.signals, position.shape))
        _check_events(self.events)

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        more = f", signals {', '.join(self.signals)}" if self.signals else ""
        rows = f"{len(self)} rows from {self.first}"
        return f"Setpoints({rows}, axes {self.axes}, every {1e3 * self.period_s:g} ms{more})"

    def _repr_html_(self) -> str | None:
        sound = np.abs(self.position).max(initial=0.0) <= POSITION  # not where one is no number
        return html_of(self) if sound else None

    @property
    def time_s(self) -> Floats:
        """Shape (n,): time of each row."""
        rows = np.arange(self.first, self.first + len(self), dtype=np.float64)
        return rows * self.period_s


def _doubles(values: Any) -> NDArray[np.float64]:
    """Return an array of doubles in C order, the same where it is one."""
    try:
        if np.iscomplexobj(values):
            raise wrong(
                "positions of setpoints are complex numbers; they must be real (numpy.real gives the real part)"
            )
        if np.ma.is_masked(values):
            raise wrong("positions of setpoints are masked: every setpoint needs a position")
        return np.asarray(values, np.float64, order="C")
    except (TypeError, ValueError, OverflowError) as error:
        raise wrong(f"positions of setpoints are not an array of numbers: {error}") from None


def _signals(signals: Any, shape: tuple[int, ...]) -> dict[str, NDArray]:
    """Return signals as arrays; refuse those of another name or shape than writers know, for positions of a `shape`."""
    found = {}
    for name, values in expect(
        signals, Mapping, "signals of setpoints", "a mapping of names to arrays"
    ).items():
        if name not in AXIS_SIGNALS and name not in PATH_SIGNALS:
            raise wrong(f"signals {name}: not one of {', '.join((*AXIS_SIGNALS, *PATH_SIGNALS))}")
        array, wanted = np.asarray(values), shape if name in AXIS_SIGNALS else shape[:1]
        if array.shape != wanted or array.dtype.kind not in "iuf":
            raise wrong(
                f"the signal {name} is to be an array of numbers of shape {wanted}; it has {array.shape}"
            )
        found[name] = array
    return found


def _check_events(events: Any) -> None:
    """Refuse what are no triples of time, line and event."""
    for each in expect(events, Iterable, "events of setpoints", "triples of time, line and Event"):
        if not (isinstance(each, tuple) and len(each) == 3 and isinstance(each[2], Event)):
            raise wrong(f"events of setpoints hold {each!r}; they are to be triples of time, line and Event")

"""The intermediate representation: a program as columns, a row a motion or an event between motions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType

from cncgen.diagnostics import Diagnostics, Span
from cncgen.records import IntEnum, dataclass, field

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, ClassVar

    import numpy as np
    from numpy.typing import NDArray

    from cncgen.geometry.path import Path
    from cncgen.geometry.tables import ArcTable, NurbsTable
    from cncgen.toolpath.reading import ReadOptions

    Floats = NDArray[np.float64]


class Kind(IntEnum):
    """Kind of a row."""

    LINE = 0
    ARC = 1
    NURBS = 2
    EVENT = 3


class FeedMode(IntEnum):
    """Meaning of the `feed` of a row.

    SPEED: mm/s along X Y Z (or U V W; rad/s where only rotary axes move). G94, and G95 already multiplied out.
    INVERSE_TIME: 1/s; the motion takes ``1 / feed`` seconds. G93.
    RAPID: the machine's own speed; `feed` is NaN, or, once planned under G64, what the axes allow along the row.
    """

    SPEED = 0
    INVERSE_TIME = 1
    RAPID = 2


class PathMode(IntEnum):
    """How close the motion stays to the programmed path: G64 (within `tolerance`), G61, G61.1."""

    CONTINUOUS = 0
    EXACT_PATH = 1
    EXACT_STOP = 2


@dataclass(frozen=True, slots=True)
class Event:
    """An event between two motions.

    Attributes:
        name: ``dwell``, ``spindle``, ``coolant``, ``tool``, ``stop``, ``end``, ``message``, ``user`` …
        rest: True where the axes must stand still for it.
        dwell_s: Seconds that the program asks the axes to wait.
        values: Values that ``--events`` writes beside the name (JSON).
        takes_s: Seconds that the machine takes for the event itself (a tool change), while the axes stand.
    """

    name: str
    rest: bool = False
    dwell_s: float = 0.0
    values: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    takes_s: float = 0.0

    @property
    def wait_s(self) -> float:
        """Seconds that the axes stand for the event in all."""
        return self.dwell_s + self.takes_s

    @property
    def stands(self) -> bool:
        """Whether the axes come to rest for the event."""
        return self.rest or self.wait_s > 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Toolpath:
    """A stretch of a program, `n` rows, in machine coordinates. Frozen: a stage makes a new one.

    A row starts where the row before it ends, the first one at `start`. EVENT rows do not move: their `end` repeats
    the position. Arc and NURBS rows point into the side tables by `curve` (−1 elsewhere); EVENT rows point into
    `events` by `curve`.

    Attributes:
        axes: Letters of the columns, a subsequence of ``XYZABCUVW``; X, Y and Z are always there first.
        start: Shape (axes,), mm or rad.
        kind: Shape (n,), int8, a `Kind`.
        end: Shape (n, axes), mm or rad.
        feed: Shape (n,), see `FeedMode`; NaN for events.
        feed_mode: Shape (n,), int8.
        path_mode: Shape (n,), int8.
        tolerance: Shape (n,), mm, of CONTINUOUS; NaN where the program gives none (then the machine's holds).
        curve: Shape (n,), int64.
        line: Shape (n,), int64, the source line (from 1) that the row came from.
        source: Shape (n,), int16, index into `sources`.
        arcs, nurbs: The curves.
        events: The events.
        sources: Names of the files that lines refer to, the program itself first.
        chord_room: Shape (n,), mm: the part of its tolerance that a smoothed row leaves to the chords between setpoints; None where
            nothing is smoothed.
        lever: Shape (n,), mm/rad: how far the tip of the tool goes as the rotary axes turn, where the program tells the tip's path and they
            carry it (the root of the sum of the squares over the axes); else 0. None where all are.
        degree_mm: What a degree of a rotary axis counts as where distances of all axes are measured, mm (`Machine.degree_mm`).
        path: The geometry of the rows, measured when it is first asked for.
    """

    #: The columns that have one entry a row, `chord_room` and `lever` apart.
    COLUMNS: ClassVar = (
        "kind",
        "end",
        "feed",
        "feed_mode",
        "path_mode",
        "tolerance",
        "curve",
        "line",
        "source",
    )

    axes: str
    start: Floats
    kind: NDArray[np.int8]
    end: Floats
    feed: Floats
    feed_mode: NDArray[np.int8]
    path_mode: NDArray[np.int8]
    tolerance: Floats
    curve: NDArray[np.int64]
    line: NDArray[np.int64]
    source: NDArray[np.int16]
    arcs: ArcTable
    nurbs: NurbsTable
    events: tuple[Event, ...]
    sources: tuple[str, ...]
    chord_room: Floats | None = None
    lever: Floats | None = None
    degree_mm: float = 1.0
    _path: list[Path] = field(default_factory=list, init=False, repr=False)

    def __len__(self) -> int:
        return len(self.kind)

    def __reduce__(self) -> tuple[type[Toolpath], tuple[Any, ...]]:
        """Return what a pickle holds: the columns, from which the path is measured anew."""
        from dataclasses import fields

        return Toolpath, tuple(getattr(self, each.name) for each in fields(self) if each.init)

    def __repr__(self) -> str:
        lines = f", lines {self.line[0]} to {self.line[-1]}" if len(self) else ""
        return f"Toolpath({len(self)} rows, axes {self.axes}{lines} of {self.sources[0] if self.sources else '?'})"

    @property
    def starts(self) -> Floats:
        """Shape (n, axes): the start point of each row."""
        import numpy as np

        return np.concatenate([self.start[None, :], self.end[:-1]]) if len(self) else self.end

    @property
    def event_rows(self) -> list[tuple[int, int, Event]]:
        """Number, source line and event of each row that is one, in order."""
        import numpy as np

        rows = np.flatnonzero(self.kind == Kind.EVENT).tolist()
        return [(row, int(self.line[row]), self.events[int(self.curve[row])]) for row in rows]

    @property
    def chord_tolerance(self) -> Floats:
        """Shape (n,), mm: how far chords may be from each row under CONTINUOUS, all of its tolerance where it is not smoothed."""
        return self.tolerance if self.chord_room is None else self.chord_room

    def columns(self, rows: slice | NDArray[np.int64]) -> dict[str, Any]:
        """Return the columns of some rows by name, `chord_room` and `lever` among them where there are any."""
        optional = [name for name in ("chord_room", "lever") if getattr(self, name) is not None]
        return {name: getattr(self, name)[rows] for name in (*self.COLUMNS, *optional)}

    def span(self, row: int) -> Span:
        """Return the line of the program that a row comes from."""
        return Span(self.sources[int(self.source[row])], int(self.line[row]))

    @property
    def path(self) -> Path:
        """The geometry of the rows, its coordinate from 0 at the start: measured once, by the stage that asks first."""
        if not self._path:
            from cncgen.geometry.path import Path

            self._path.append(
                Path(self.axes, self.start, self.kind, self.end, self.curve, self.arcs, self.nurbs)
            )
        return self._path[0]


@dataclass(frozen=True, slots=True)
class Program:
    """A program that is read on demand: `chunks()` yields its toolpath piece by piece.

    The diagnostics grow while the chunks are drawn; they are complete when the iterator ends. After an error the
    reader goes on to find the other errors of the file, but what it yields then is not to be moved on.

    Attributes:
        name: File name, or ``-``.
        language: ``gcode`` or ``stepnc``.
        axes: Letters of the axes that the program names, in the order of ``XYZABCUVW``, with X Y Z always there.
        moving_axes: Those of them that the output shows (the program's own).
        chunks: Yields `Toolpath` of bounded size, at each call from the start of the program on. G-code takes a factor of the spindle's
            largest speed (`ReadOptions.fastest_spindle`).
        diagnostics: Filled while reading; of several readings each fault stands there once.
        count_lines: Returns how many lines the text has; 0 where they are not counted.
        options: How it is read.
        reread: Returns the same text as a program that is read with other options; its diagnostics are added to these too.
        for_lathe: Whether it is written in a dialect of lathes.
    """

    name: str
    language: str
    axes: str
    moving_axes: str
    chunks: Callable[..., Iterator[Toolpath]]
    diagnostics: Diagnostics
    options: ReadOptions
    reread: Callable[[ReadOptions], Program]
    count_lines: Callable[[], int] = int
    for_lathe: bool = False

    def __reduce__(self) -> tuple[Any, ...]:
        """Refuse to be pickled: the program reads its file as it is drawn."""
        raise TypeError(
            f"{self!r} reads its file on demand and cannot be pickled; hand on the name of the file"
        )

    def __repr__(self) -> str:
        return f"Program({self.name!r}, {self.language}, axes {self.moving_axes or 'none'}, {self.diagnostics!r})"

"""Warnings about rotary axes, with the numbers of the run: ways that roll-over makes shorter, and feeds that other controls count otherwise."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cncgen.diagnostics import Severity
from cncgen.gcode.errors import BlockError, Reporter
from cncgen.gcode.sinks.counting import HALF_TURN
from cncgen.gcode.source import Source
from cncgen.gcode.text import signs
from cncgen.gcode.text.built_patterns import compiled
from cncgen.units import DEGREE, ROTARY_LETTERS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.toolpath.record import Toolpath

#: Degrees that the way of an axis may differ by rounding.
_ROUNDING = 1e-6
_TURN = 360.0
#: How many times as long a line may take on other controls without a remark.
_TIMES = 2.0
#: Blocks that are looked at: where so many are distances, the program is written in them.
_LOOKS = 100


class SharedFeeds:
    """Looks at the feed of lines in which rotary axes turn while X Y Z move, in a program whose control no sign tells, and remarks once."""

    def __init__(self) -> None:
        self._said = False

    def add(self, chunk: Toolpath, sources: Sequence[Source], reporter: Reporter, unit_mm: float) -> None:
        """Look at the rows of a chunk, in whose unit of length other controls count a degree."""
        import numpy as np

        from cncgen.toolpath.record import FeedMode, Kind

        axes = [k for k, letter in enumerate(chunk.axes) if letter in ROTARY_LETTERS]
        if not axes or self._said or not len(chunk):
            return
        way = chunk.end - chunk.starts
        length = np.linalg.norm(way[:, :3], axis=1)
        whole = np.hypot(length, np.linalg.norm(way[:, axes], axis=1) / DEGREE * unit_mm)
        lines = (chunk.kind == Kind.LINE) & (chunk.feed_mode == FeedMode.SPEED) & (chunk.feed > 0.0)
        rows = np.flatnonzero(lines & (length > _ROUNDING) & (whole > _TIMES * length))
        if len(rows):
            self._said, row = True, rows[0]
            here, others = length[row] / chunk.feed[row], whole[row] / chunk.feed[row]
            message = (
                f"F is along X Y Z here, as LinuxCNC has it, and the line takes {here:.3g} s; controls that count a degree"
                f" as a unit of length (FANUC, grbl) take {others:.3g} s"
            )
            hint = "--dialect linuxcnc or --dialect fanuc says which; G93 is beyond doubt"
            line, source = int(chunk.line[row]), sources[int(chunk.source[row])]
            fault = BlockError("feed-rotary", message, "F", hint=hint)
            reporter.report(source, line, _offset(source, line), fault, Severity.WARNING)


def _offset(source: Source, line: int, near: int = 1, offset: int = 0) -> int:
    """Return where a line begins; `near` is one before it, at an offset."""
    for _ in range(line - near):
        offset = source.line_end(offset) + 1
    return offset


class Turns:
    """Looks at the ways of rotary axes while a program of FANUC's mills is read, and remarks once on one of more than half a turn.

    A control with roll-over goes to a place the shorter way round (B-63534EN, 20.2.1: from A210 to A540 it moves -30 degrees), and the
    whole way of a distance (G91).
    """

    def __init__(self) -> None:
        self._looks = _LOOKS
        #: Source, line and offset of the last block that was looked at: most follow one another.
        self._last = 0, 1, 0

    def add(self, chunk: Toolpath, sources: Sequence[Source], reporter: Reporter) -> None:
        """Look at the rows of a chunk."""
        import numpy as np

        axes = [k for k, letter in enumerate(chunk.axes) if letter in ROTARY_LETTERS]
        if not axes or self._looks <= 0 or not len(chunk):
            return
        starts, ends = chunk.starts[:, axes] / DEGREE, chunk.end[:, axes] / DEGREE
        for row, column in np.argwhere(np.abs(ends - starts) > HALF_TURN):
            self._looks -= 1
            line, number = int(chunk.line[row]), int(chunk.source[row])
            source = sources[number]
            near = self._last[1:] if self._last[0] == number and self._last[1] <= line else (1, 0)
            offset = _offset(source, line, *near)
            self._last = number, line, offset
            axis, start, end = chunk.axes[axes[column]], float(starts[row, column]), float(ends[row, column])
            if _is_place(source, offset, axis, start, end):
                self._looks = 0
                reporter.report(source, line, offset, _remark(axis, start, end), Severity.WARNING)
            if self._looks <= 0:
                return


def _is_place(source: Source, offset: int, axis: str, start: float, end: float) -> bool:
    """Tell whether the block of a motion names the place where an axis goes, and not a distance or another point.

    A number that is not the way is a place. Where it may be both, the axis stands at 0, and for a value that is worked out, the last G90 or
    G91 of the text counts.
    """
    stop = source.line_end(offset)
    block = compiled(signs.OUT_OF_CODE).sub(b"", source.data[offset:stop]).upper()
    if compiled(signs.NO_PLACE).search(block):
        return False
    for word in compiled(signs.ROTARY).finditer(block):
        if word["axis"] == axis.encode():
            written = float(word["angle"].replace(b" ", b""))
            if not math.isclose(written, end - start, abs_tol=_ROUNDING):
                return True
    if not any(word[:1] == axis.encode() for word in compiled(signs.ANGLE).findall(block)):
        return False
    said = {n: max(source.data.rfind(b"%c%d" % (g, n), 0, stop) for g in b"Gg") for n in (90, 91)}
    return said[90] >= said[91]


def _remark(axis: str, start: float, end: float) -> BlockError:
    shorter = (end - start + _TURN / 2.0) % _TURN - _TURN / 2.0
    start, end, way, shorter = (round(number, 4) + 0.0 for number in (start, end, end - start, shorter))
    message = (
        f"{axis} goes from {start:g} to {end:g}, by {way:g} degrees; with roll-over of rotary axes"
        f" (parameter 1008 bits 0 and 1 of FANUC) a control goes by {shorter:g}"
    )
    hint = "angles that are no more than half a turn apart, or G91, leave no choice"
    return BlockError("roll-over", message, axis, hint=hint)

"""Endless programs: a program is endless if it comes back to a place in the same state.

Interpreting a block depends only on the state, so a state that recurs once recurs for ever. The search follows Brent (1980, section
2): one state is kept, replaced after 1, 2, 4, … looks, and each later look is compared with it.
"""

from __future__ import annotations

import io

# `pickle` itself imports `re` and `enum`, which take as long as some 20,000 lines of a loop.
from _pickle import Pickler, PicklingError, dumps
from collections.abc import Callable

from cncgen.gcode.errors import Astray, BlockError
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import empty_block

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.flow.faults import Faults
    from cncgen.gcode.interpreter import Interpreter

#: Blocks that loops may execute after a fault: the faulty line might have ended the loop.
_MOST_AFTER_A_FAULT = 1_000_000


class _StateWriter(Pickler):
    """Writes a state; things that a run never changes, or that are seen otherwise, by their identity."""

    def __init__(self, file: io.BytesIO, fixed: tuple[type, ...]) -> None:
        super().__init__(file)
        self._fixed = fixed

    def persistent_id(self, thing: object) -> int | None:
        """Return what stands for a thing, None where its contents do."""
        return id(thing) if isinstance(thing, self._fixed) else None


class Recurrence:
    """Looks at a run now and then, at lines that it jumps back to; no block may wait then.

    Args:
        ip: The interpreter.
        faults: Those of the run so far.
        flow: Gives the state of what leads through the program.
        fixed: Classes of what that state names and is no part of it.
    """

    def __init__(
        self, ip: Interpreter, faults: Faults, flow: Callable[[], object], fixed: tuple[type, ...] = ()
    ) -> None:
        self._ip, self._faults, self._flow, self._fixed = ip, faults, flow, fixed
        self._looks = 0
        self._replaced_after = 1
        self._kept: tuple[Cursor, bytes, bytes] | None = None

    def look(self, here: Cursor, back: Cursor, begun: int, counters: object = None) -> None:
        """Raise where a jump back finds everything as it was at an earlier look: the loop is endless.

        Args:
            here: The line that leads back.
            back: The line that comes next.
            begun: Blocks that were executed before a line was last reached for the first time.
            counters: The values that differ in nearly every round.

        Raises:
            Astray: The program can never go on, or a fault keeps it from going on.
        """
        faulty = self._faults.found
        if faulty and self._ip.budget.steps - begun > _MOST_AFTER_A_FAULT:
            raise Astray
        if self._found(back, counters):
            if faulty:
                # An earlier faulty line might have ended it.
                raise Astray
            self._ip.base.block = empty_block(here)
            message = (
                f"back to line {back.line} with everything as it was there before: this goes on for ever"
            )
            hint = "does anything in the loop change what ends it? for one round, leave the jump back out"
            raise Astray(BlockError("too-many-steps", message, hint=hint))

    def _found(self, back: Cursor, counters: object) -> bool:
        """Tell whether the run is at this line with everything as it was at an earlier look."""
        numbers = self._ip.parameters.numbers.tobytes() + dumps(counters)
        # Counters nearly always tell.
        if self._kept is not None and self._kept[:2] == (back, numbers) and self._kept[2] == self._others():
            return bool(self._kept[2])
        self._looks += 1
        if self._looks >= self._replaced_after:
            self._replaced_after *= 2
            self._kept = back, numbers, self._others()
        return False

    def _others(self) -> bytes:
        """Return all state but the counters; nothing where some of it cannot be seen from here."""
        ip = self._ip
        sinks = self._sinks()
        if sinks is None or ip.guard is not None:
            return b""
        parameters = ip.parameters
        state = (
            ip.state,
            sinks,
            ip.base.where(ip.state.position),
            parameters.local,
            parameters.named,
            ip.tools,
            ip.modal_macros,
            ip.skipping,
            ip.rewrite,
            ip.plain_language,
            ip.last_spline_end,
            self._flow(),
        )
        written = io.BytesIO()
        try:
            _StateWriter(written, self._fixed).dump(state)
        except (TypeError, AttributeError, PicklingError):
            return b""
        return written.getvalue()

    def _sinks(self) -> list[object] | None:
        """Return the states of the sinks before the sink of the run, or None if the state of one is unknown."""
        ip = self._ip
        sink, states = ip.sink, list[object]()
        while sink is not ip.base:
            from cncgen.gcode.codes.affine import FramedSink
            from cncgen.gcode.codes.compensated_sink import CompensatedSink

            if not isinstance(sink, CompensatedSink | FramedSink):
                return None
            states.append(sink.snapshot())
            if states[-1] is None:
                return None
            sink = sink.inner
        return states

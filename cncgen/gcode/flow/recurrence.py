"""Endless programs: a program is endless if it comes back to a place in the same state.

Interpreting a block depends only on the state, so a state that recurs once recurs for ever. The search follows Brent (1980, section
2): one state is kept, replaced after 1, 2, 4, … looks, and each later look is compared with it.
"""

from __future__ import annotations

from cncgen.gcode.text.labels import Cursor

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.flow.calls import Calls
    from cncgen.gcode.interpreter import Interpreter


class Recurrence:
    """Looks at a run now and then, at lines that it jumps back to; no block may wait then."""

    def __init__(self, ip: Interpreter, calls: Calls) -> None:
        self._ip = ip
        self._calls = calls
        self._looks = 0
        self._replaced_after = 1
        self._line: Cursor | None = None
        self._numbers = b""
        self._rest = b""

    def found(self, line: Cursor) -> bool:
        """Tell whether the run is at this line with everything as it was at an earlier look."""
        numbers = self._ip.parameters.numbers.tobytes()
        # Counters stand in the numbered parameters: nearly always they tell.
        if line == self._line and numbers == self._numbers and self._rest and self._rest == self._others():
            return True
        self._looks += 1
        if self._looks >= self._replaced_after:
            self._replaced_after *= 2
            self._line, self._numbers, self._rest = line, numbers, self._others()
        return False

    def _others(self) -> bytes:
        """Return all state but the numbered parameters; nothing where some of it cannot be seen from here."""
        ip = self._ip
        sinks = self._sinks()
        if sinks is None or ip.guard is not None or ip.plain_language is not None:
            return b""
        import pickle

        parameters = ip.parameters
        return pickle.dumps(
            (
                ip.state,
                sinks,
                ip.base.where(ip.state.position),
                parameters.local,
                parameters.named,
                ip.tools,
                ip.modal_macros,
                ip.skipping,
                self._calls.records,
            )
        )

    def _sinks(self) -> list[object] | None:
        """Return the states of the sinks before the sink of the run, or None if the state of one is unknown."""
        ip = self._ip
        sink, states = ip.sink, list[object]()
        while sink is not ip.base:
            from cncgen.gcode.codes.compensated_sink import CompensatedSink
            from cncgen.gcode.codes.frames import FramedSink

            if not isinstance(sink, CompensatedSink | FramedSink):
                return None
            states.append(sink.snapshot())
            if states[-1] is None:
                return None
            sink = sink.inner
        return states

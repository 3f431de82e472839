"""Lines that are computed while they are read, by the kernel `gcode_values`: values and settings, no functions of them.

Blocks go to the columns of plain blocks and wait there: motions change no parameter, so that reading may go on, over loops
and calls too, until something needs to know where the machine is (`flow.pending` then has them run).
"""

from __future__ import annotations

from cncgen.gcode.block import Flow
from cncgen.gcode.source import Source
from cncgen.gcode.state.parameters import Parameters
from cncgen.gcode.state.predefined import NAMED
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import PlainBlocks
from cncgen.kernels import gcode_values

_BRANCHES = "if", "elseif", "else", "endif"
_LOOPS = "while", "endwhile", "do", "repeat", "endrepeat"
#: O-words of which all values are computed whenever they run.
_WORDS = frozenset(("sub", "endsub", "call", "return", "break", "continue", *_BRANCHES, *_LOOPS))
_RESERVED = frozenset(NAMED)


class Computing:
    """The sources' texts under the kernel, all on the columns `plain`."""

    def __init__(self, parameters: Parameters, sources: list[Source], plain: PlainBlocks) -> None:
        self._parameters = parameters
        self._sources = sources
        self._plain = plain
        self._computers: dict[int, gcode_values.Computer] = {}

    def _computer(self, source: int) -> gcode_values.Computer:
        computer = self._computers.get(source)
        if computer is None:
            text, plain, parameters = self._sources[source], self._plain, self._parameters
            computer = self._computers[source] = gcode_values.Computer(
                text.data, text.bytes, parameters.numbers, parameters.named, _RESERVED, plain.columns()
            )
        return computer

    def read(self, here: Cursor) -> Cursor:
        """Read on from a line, its source that of the blocks that wait, if any; return the first line not read."""
        computer, plain = self._computer(here.source), self._plain
        computer.blocks = plain.count
        offset = computer.run(here.offset, here.line, self._parameters.local)
        plain.count, plain.source = computer.blocks, here.source
        return here if offset == here.offset else Cursor(here.source, offset, computer.line)

    def flow(self, here: Cursor) -> tuple[Flow, Cursor] | None:
        """Return the O-word of a line with its values, and the next line; None where there is none for certain."""
        found = self._computer(here.source).o_word(here.offset, self._parameters.local)
        if found is None or found[1] not in _WORDS:
            return None
        label, keyword, arguments, end = found
        return Flow(keyword, label, tuple(arguments)), Cursor(here.source, end + 1, here.line + 1)

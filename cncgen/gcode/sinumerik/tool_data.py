"""Tools by system variables of SINUMERIK: $TC_DPn[t,d], the data of edge d of tool t (840D sl, Tools, "Tool edge data").

The tool table has one edge of each tool: the one that D takes, if the program describes it, and what TOFFL and TOFFR add to that.
"""

from __future__ import annotations

import re

from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinumerik.expressions import Scalar, whole
from cncgen.machine.tool_table import TIPS, Tool
from cncgen.records import replace

_DATA = re.compile(r"\$TC_DP(\d{1,4})\Z")
#: Position of the edge (numbered as on FANUC's lathes: 3 turns outside; from memory), length 1, length 2, radius; and the wear of
#: lengths and radius.
_ORIENTATION, _LENGTH_1, _LENGTH_2, _RADIUS = 2, 3, 4, 6
_WEAR = {12: _LENGTH_1, 13: _LENGTH_2, 15: _RADIUS}
#: Types of tools of lathes, whose length 1 is along X and length 2 along Z.
_LATHE_TYPES = range(500, 600)
_TYPE = 1


def names(name: str) -> bool:
    """Tell whether a name is of a tool's data."""
    return name.startswith("$TC_")


def _unknown(name: str) -> BlockError:
    message = f"the system variable {name} is not read"
    return BlockError("variable-unknown", message, name, hint="$TC_DP3[1,1] is length 1 of tool 1")


def _index(name: str, at: list[Scalar]) -> tuple[int, int, int]:
    """Return the number of a tool's datum, the tool and its edge."""
    found = _DATA.match(name)
    if found is None or not 1 <= len(at) <= 2:
        raise _unknown(name)
    return int(found[1]), whole(at[0]), whole(at[1]) if len(at) == 2 else 1


class ToolData:
    """Types of the tools that a program describes, and the data that it sets."""

    def __init__(self, ip: Interpreter) -> None:
        self.ip = ip
        self._types: dict[int, int] = {}
        #: Tools without a type: of a lathe where the plane is G18 as the first of their data is set or read.
        self._lathes: dict[int, bool] = {}
        #: Teeth of tools, by which FZ is multiplied.
        self.teeth: dict[int, float] = {}
        #: Edges of tools that have several, or one to which something is added, by tool and D.
        self._edges: dict[tuple[int, int], Tool] = {}
        self.edge = 1
        #: What TOFFL adds to the length of the tool in the spindle and TOFFR to its radius, in program units.
        self.added = (0.0, 0.0)

    def take(self, tool: int, edge: int) -> bool:
        """Have an edge in the tool table, with what is added to it; tell whether the program or the table describes it."""
        record, self.edge = self._edges.get((tool, edge)), edge
        if record is None and edge > 1:
            self.take(tool, 1)
            return False
        if any(self.added):
            record = self._edge(tool, edge)
            length, radius = (value / self.ip.table_scale() for value in self.added)
            column = self._column(tool, _LENGTH_1)
            offset = [size + length * (k == column) for k, size in enumerate(record.offset)]
            record = replace(record, offset=offset, diameter=record.diameter + 2.0 * radius)
        if record is not None:
            self.ip.tools.tools[tool] = record
        return True

    def _edge(self, tool: int, edge: int) -> Tool:
        """Return an edge to be changed; the first one is that of the tool table."""
        first = self._edges.get((tool, 1)) or self.ip.tools.made(tool)
        if edge == 1 and not any(self.added):
            return first
        self._edges[tool, 1] = first
        made = Tool(tool, first.pocket, remark=first.remark)
        return self._edges.setdefault((tool, edge), made)

    def _column(self, tool: int, datum: int) -> int:
        """Return the axis of a length, the same one whatever plane is chosen later."""
        if tool in self._types:
            lathe = self._types[tool] in _LATHE_TYPES
        else:
            lathe = self._lathes.setdefault(tool, self.ip.state.plane == 18)
        return (0 if lathe else 2) if datum == _LENGTH_1 else (2 if lathe else 1)

    def set(self, name: str, at: list[Scalar], value: float) -> None:
        """Set a datum; data without effect on motion are ignored, with a remark."""
        if name == "$TC_DPNT" and at:
            self.teeth[whole(at[0])] = value
            return
        if not _DATA.match(name):
            self._pass_over(name)
            return
        datum, number_, edge = _index(name, at)
        if datum == _TYPE:
            self._types[number_] = round(value)
            return
        if datum not in (_ORIENTATION, _LENGTH_1, _LENGTH_2, _RADIUS, *_WEAR):
            if value:
                self._pass_over(name)
            return
        tool = self._edge(number_, edge)
        if datum == _ORIENTATION:
            if not 0 <= round(value) < len(TIPS):
                message = f"{name} = {value:g}: the position of an edge is 0 to 9"
                raise BlockError("tool-orientation", message, name)
            tool.orientation = TIPS[round(value)]
            return
        base = _WEAR.get(datum, datum)
        worn = datum in _WEAR
        scale = self.ip.table_scale()
        place = {_LENGTH_1: 0, _LENGTH_2: 2, _RADIUS: 1}[base]
        wear = tool.wear[place]
        size = self._size(tool, number_, base) - wear
        if worn:
            wear = value / scale
        else:
            size = value / scale
        tool.wear[place] = wear
        if base == _RADIUS:
            tool.diameter = 2.0 * (size + wear)
        else:
            tool.offset[self._column(number_, base)] = size + wear

    def _size(self, tool: Tool, number_: int, datum: int) -> float:
        return tool.diameter / 2.0 if datum == _RADIUS else tool.offset[self._column(number_, datum)]

    def _pass_over(self, name: str) -> None:
        message = f"{name} and other data of tools change nothing here: lengths, radius and position of an edge are kept"
        self.ip.note_once("tool-edge", message, name, "$TC_DP2, 3, 4, 6 and their wear are read")

    def value(self, name: str, at: list[Scalar]) -> float:
        """Return a datum of a tool."""
        datum, number_, edge = _index(name, at)
        first = self.ip.tools.find(number_) if edge == 1 else None
        tool = self._edges.get((number_, edge)) or first
        if datum == _TYPE:
            return float(self._types.get(number_, 0))
        if datum not in (_ORIENTATION, _LENGTH_1, _LENGTH_2, _RADIUS, *_WEAR) or tool is None:
            raise _unknown(name)
        if datum == _ORIENTATION:
            return float(TIPS[tool.orientation])
        place = {_LENGTH_1: 0, _LENGTH_2: 2, _RADIUS: 1}[_WEAR.get(datum, datum)]
        if datum in _WEAR:
            return tool.wear[place] * self.ip.table_scale()
        return (self._size(tool, number_, datum) - tool.wear[place]) * self.ip.table_scale()

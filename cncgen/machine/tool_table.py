"""The tool table in LinuxCNC's format: a tool a line, ``T1 P1 X0 Y0 Z-12.5 D6 I0 J0 Q0 ; remark``.

Programs in G-code name a tool by its number, those in STEP-NC by a name that is searched in the remarks, then in the numbers.
"""

from __future__ import annotations

from cncgen.diagnostics import Diagnostic, Span, UsageError
from cncgen.files import read_utf8
from cncgen.ranges import POSITION
from cncgen.records import dataclass, field
from cncgen.units import AXIS_LETTERS, INCH

TYPE_CHECKING = False
if TYPE_CHECKING:
    from pathlib import Path

_WORD = r"([A-Za-z])\s*([+-]?(?:\d++\.?+\d*+|\.\d+))"
#: Bytes that are read of a tool table: some 100 000 tools.
MAX_FILE_BYTES = 16_000_000
#: LinuxCNC's number of the direction of a lathe tool's tip by that of other controls, and theirs by LinuxCNC's: X counts the other way.
#: Theirs by Haas's Lathe Operator's Manual, "Imaginary Tool Tip and Direction": 1 is X+ Z+, 2 X+ Z-, 3 X- Z-, 4 X- Z+, 5 Z+, 6 X+, 7 Z-, 8 X-.
TIPS = (0, 4, 3, 2, 1, 5, 8, 7, 6, 9)


@dataclass(slots=True)
class Tool:
    """One tool; lengths in the table's units, angles in degrees.

    Attributes:
        number, pocket: T and P.
        offset: X Y Z A B C U V W.
        diameter: D.
        front, back, orientation: I, J, Q, of lathe tools.
        wear: The wear that `offset` Z, the radius and `offset` X include (FANUC keeps geometry and wear apart).
        remark: The text behind the semicolon.
    """

    number: int
    pocket: int
    offset: list[float] = field(default_factory=lambda: [0.0] * len(AXIS_LETTERS))
    diameter: float = 0.0
    front: float = 0.0
    back: float = 0.0
    orientation: int = 0
    wear: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    remark: str = ""


class ToolTable:
    """Tools by number. Without a table every tool exists, of no length."""

    def __init__(self, tools: dict[int, Tool] | None = None) -> None:
        self.given = tools is not None
        self.tools: dict[int, Tool] = dict(tools or {})
        #: Whether the note on a tool of unknown size was given.
        self.told = False

    def find(self, number: int) -> Tool | None:
        """Return a tool, or None for a tool that the table lacks."""
        if number in self.tools:
            return self.tools[number]
        if number == 0 or not self.given:
            return Tool(number, number)
        return None

    def invents(self, number: int) -> bool:
        """Tell whether nothing gives the sizes of a tool, which was not said yet."""
        return not (self.given or self.told or number in self.tools)

    def entry(self, number: int) -> Tool | None:
        """Return a tool to be changed, which then stays in the table; None for an unknown tool."""
        tool = self.find(number)
        if tool is not None:
            self.tools[number] = tool
        return tool

    def made(self, number: int) -> Tool:
        """Return a tool to be changed, which a program may describe that no table has."""
        return self.tools.setdefault(number, self.find(number) or Tool(number, number))

    def named(self, name: str) -> int | None:
        """Return the number of the tool whose remark is a name, whatever its capitals; None where no tool or several have it."""
        wanted = name.strip().upper()
        found = [
            number for number, tool in self.tools.items() if wanted and tool.remark.strip().upper() == wanted
        ]
        return found[0] if len(found) == 1 else None

    def place_of(self, number: int) -> int:
        """Return which entry of the table a tool is, from 1, as canonical calls name it; 0 for no tool."""
        if number == 0 or number not in self.tools:
            return number
        return list(self.tools).index(number) + 1

    def pocket_of(self, number: int) -> int:
        """Return the pocket of a tool, 0 for none."""
        tool = self.find(number)
        return tool.pocket if tool else 0

    def lengths(self, inches: bool) -> dict[str, float]:
        """Return length offsets (Z), mm, by the names of tools: the remark in capitals, and the number.

        Args:
            inches: Whether lengths of the table are inches.
        """
        found: dict[str, float] = {}
        for number, tool in self.tools.items():
            length = tool.offset[2] * (INCH if inches else 1.0)
            found.setdefault(str(number), length)
            if tool.remark:
                found[tool.remark.upper()] = length
        return found


#: The tools of LinuxCNC's stand-alone interpreter: number, length, diameter, in inches (manual page rs274.1).
_STAND_ALONE = ((1, 0.511, 0.125), (2, 0.1, 0.0625), (3, 1.273, 0.201))


def tools_of(table: Path | None, stand_alone: bool) -> ToolTable:
    """Return the tools of a run: those of its table; without one any tool, or those that the stand-alone machine has.

    Args:
        table: The file, or None.
        stand_alone: Whether the machine is the imaginary one of LinuxCNC's stand-alone interpreter.

    Raises:
        UsageError: See `read_tool_table`.
    """
    if table:
        return read_tool_table(table)
    if stand_alone:
        return ToolTable(
            {n: Tool(n, n, [0.0, 0.0, z, *[0.0] * 6], diameter) for n, z, diameter in _STAND_ALONE}
        )
    return ToolTable()


def read_tool_table(path: Path) -> ToolTable:
    """Read a tool table.

    Raises:
        UsageError: Where it cannot be read or a line is wrong; all of them are named.
    """
    lines = read_utf8(path, at_most=MAX_FILE_BYTES).decode("utf-8", "replace").splitlines()
    tools: dict[int, Tool] = {}
    faults = []
    for count, line in enumerate(lines, 1):
        text, _, remark = line.partition(";")
        if not text.strip():
            continue
        fault = _read_line(text.strip(), remark.strip(), tools)
        if fault:
            faults.append(
                Diagnostic("tool-table", fault, span=Span(str(path), count), hint=_HINT, excerpt=line[:200])
            )
    if faults:
        raise UsageError(faults)
    return ToolTable(tools)


_HINT = "a line is T, a whole number and words like P1 Z12.5 D6, then a remark after a semicolon"


def _read_line(text: str, remark: str, tools: dict[int, Tool]) -> str:
    """Take a line into the table; return its fault, or ""."""
    import re

    pairs = [(letter.upper(), float(number)) for letter, number in re.findall(_WORD, text)]
    words = dict(pairs)
    if re.sub(_WORD, "", text).strip():
        return f"{re.sub(_WORD, '', text).strip()[:40]!r} is not a word of a tool table"
    if len(words) < len(pairs):
        twice = next(letter for letter in words if [each for each, _ in pairs].count(letter) > 1)
        return f"{twice} stands in the line twice"
    if "T" not in words:
        return "the line has no tool number T"
    for letter, number in words.items():
        if abs(number) > POSITION:
            return f"{letter}{number:g} is not within ±{POSITION:g}"
        if letter in "TPQ" and (number < 0.0 or number % 1.0):
            return f"{letter}{number:g} must be a whole number from 0 on"
    if words.get("Q", 0.0) >= len(TIPS):
        return f"Q{words['Q']:g}: the orientation of a tool is 0 to 9"
    tool = int(words["T"])
    if tool in tools:
        return f"tool {tool} stands in the table twice"
    unknown = set(words) - set("TPDIJQ" + AXIS_LETTERS)
    if unknown:
        return f"{sorted(unknown)[0]} is not a word of a tool table"
    tools[tool] = Tool(
        tool,
        int(words.get("P", tool)),
        [words.get(letter, 0.0) for letter in AXIS_LETTERS],
        words.get("D", 0.0),
        words.get("I", 0.0),
        words.get("J", 0.0),
        int(words.get("Q", 0)),
        remark=remark,
    )
    return ""

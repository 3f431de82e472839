"""Tools: T, M6, M61, and the tool's length G43 G43.1 G43.2 G49."""

from __future__ import annotations

from array import array
from functools import partial

from cncgen.gcode.block import AXES, AXIS_INDEX, LARGEST, NEXT_TOOL, Block, repeated
from cncgen.gcode.codes.table import (
    CHANGES_TOOL,
    CHANGES_TOOL_OFFSET,
    COMPENSATION,
    ROTARY_PATH,
    TOOL_POINT,
    Code,
)
from cncgen.gcode.errors import BlockError
from cncgen.gcode.state.modal import Stage, zeros
from cncgen.gcode.state.parameters import TOOL
from cncgen.machine.tool_table import Tool
from cncgen.toolpath.record import Event

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

_M61 = 610


def whole(block: Block, letter: str, name: str) -> int:
    """Return a word that must be a whole number, not negative."""
    return whole_of(block.words[letter], letter, name)


def whole_of(value: float, letter: str, name: str) -> int:
    """Return the value of a word of a code ("" without one); raise where it is negative or not whole."""
    word, of = letter.upper(), f" of {name}" if name else ""
    if not abs(value) <= LARGEST:
        raise BlockError("number-range", f"{word}{of} is not within ±{LARGEST:g}", word)
    if abs(value - round(value)) > 1e-4:
        raise BlockError("not-whole", f"{word}{value:g}{of} is not a whole number", word)
    if value < 0:
        raise BlockError("negative-number", f"{word}{value:g}{of} is negative", word)
    return round(value)


def known(tool: Tool | None, named: str, letter: str, hint: str = "") -> Tool:
    """Return an entry of the tool table; raise where it has none."""
    if tool is None:
        raise BlockError("unknown-tool", f"{named} is not in the tool table", letter, hint=hint)
    return tool


def tell_unknown(ip: Interpreter, number: int, letter: str) -> None:
    """Say, once in a program, that the sizes of a tool are not known where no table gives them."""
    if number and ip.tools.invents(number):
        ip.tools.told = True
        message = f"without a tool table, tool {number} has no length and no radius"
        ip.note("no-tool-table", message, letter, "--tool-table names a table in LinuxCNC's format")


def load_tool_parameters(ip: Interpreter) -> None:
    """Write #5400 to #5413: number, offsets, diameter, angles and orientation of the tool in the spindle."""
    tool = ip.tools.find(ip.state.tool) or Tool(0, 0)
    values = [float(tool.number), *tool.offset, tool.diameter, tool.front, tool.back, float(tool.orientation)]
    ip.parameters.numbers[TOOL : TOOL + len(values)] = array("d", values)


def select(ip: Interpreter, block: Block) -> None:
    """T."""
    number = whole(block, "t", "")
    known(ip.tools.find(number), f"tool {number}", "T")
    ip.state.selected = number
    ip.sink.call(f"SELECT_TOOL({number})")


def change(ip: Interpreter, block: Block) -> None:
    """M6; the tool that a second T names is made ready on FANUC's kin alone; LinuxCNC's blocks have one T."""
    if NEXT_TOOL in block.words and ip.dialect != "fanuc":
        raise repeated("t")
    state = ip.state
    ip.sink.call("START_CHANGE()")
    # The tool of a lathe does not stand in the spindle, and LinuxCNC stops it all the same.
    turns = ip.system != "linuxcnc" and (ip.lathe or state.constant_surface is not None)
    if not turns:
        state.direction, state.driven = 0, False
        ip.sink.set_spindle(state.speed, 0)
        ip.sink.call("STOP_SPINDLE_TURNING(0)")
    number = state.selected
    put_in(ip, number)
    ip.sink.call(f"CHANGE_TOOL({ip.tools.place_of(number)})", Event("tool", True, values=_sizes(ip, number)))


def _change_fanuc(ip: Interpreter, block: Block) -> None:
    """M6, which a control may have call a macro of the machine's builder (parameters 6071 and 6080): K P Q R go to that."""
    others = [row.words for row in ip.codes.of(block) if (row.letter, row.number) != ("M", 60)]
    given = [
        letter for letter in _ARGUMENTS if letter in block.words and not any(letter in row for row in others)
    ]
    if given:
        message = f"{', '.join(given).upper()} of M6 goes to the macro of the machine's builder that changes tools: passed over"
        ip.warn_once("builders-code", message, given[0].upper(), "check that the macro moves nothing with it")
    change(ip, block)


def put_in(ip: Interpreter, number: int) -> None:
    """Have a tool in the spindle, and its sizes in the parameters."""
    ip.state.fetched = number
    if number or not ip.options.stand_alone:
        ip.state.tool = number
        load_tool_parameters(ip)


def take_position(ip: Interpreter, block: Block) -> None:
    """Take the position anew from the machine: LinuxCNC alone asks, and its numbers know no frames."""
    if ip.dialect == "linuxcnc":
        ip.state.position = ip.base.where(ip.state.position)


def name_tool(ip: Interpreter, block: Block) -> None:
    """M61 Q: the tool in the spindle is Q."""
    if "q" not in block.words:
        raise BlockError("tool-missing", "M61 has no tool number Q", "M61")
    number = whole(block, "q", "M61")
    known(ip.tools.find(number), f"tool {number}", "Q")
    ip.state.fetched = number
    # LinuxCNC's stand-alone interpreter keeps the tool that it had.
    if not ip.options.stand_alone or ip.dialect != "linuxcnc":
        ip.state.tool = ip.state.selected = number
        load_tool_parameters(ip)
    ip.sink.call(f"CHANGE_TOOL_NUMBER({ip.tools.place_of(number)})", Event("tool", values=_sizes(ip, number)))


def _sizes(ip: Interpreter, number: int) -> dict[str, float]:
    """Return a tool's number, and its diameter where the table has one, as values of its event."""
    tool = ip.tools.find(number)
    values: dict[str, float] = {"tool": number}
    if tool is not None and tool.diameter > 0:
        values["diameter_mm"] = tool.diameter * (25.4 if ip.options.inch_tables else 1.0)
    return values


def use_offset(ip: Interpreter, offset: list[float], word: str = "G43") -> None:
    """Take a tool offset; the machine stays where it is; raise where cutter compensation is on, and the control does not change the offset under it."""
    if ip.state.compensation != 40 and ip.dialect == "linuxcnc":
        message = "the tool offset cannot change while cutter compensation is on"
        raise BlockError("comp-refused", message, word, hint="use G40")
    machine = ip.machine_position()
    ip.state.tool_offset = offset
    ip.rebase(machine)
    ip.sink.use_tool_length_offset(offset)


def table_offset(ip: Interpreter, number: int, letter: str = "H") -> list[float]:
    """Return the offset of a tool, which that word names, in program units."""
    tell_unknown(ip, number, letter)
    tool = known(ip.tools.find(number), f"tool {number}", letter)
    return [value * ip.scale_of(index) for index, value in enumerate(tool.offset)]


def length(ip: Interpreter, block: Block) -> None:
    """G43 H: the offset of tool H, or of the tool in the spindle."""
    number = whole(block, "h", "G43") if "h" in block.words else 0
    # M61 of the block has named the tool, also on the machine that leaves it in the spindle (`stand_alone`).
    in_spindle = whole(block, "q", "M61") if _M61 in block.m else ip.state.tool
    use_offset(ip, table_offset(ip, number or in_spindle))


def length_number(ip: Interpreter, block: Block) -> None:
    """H of FANUC by itself: the offset that G43 or G44 goes on with, at once where one of them is in force.

    Raises:
        BlockError: H stands beside the call of a program, where other controls mean a line of it.
    """
    if any(row.calls and row.letter == "M" for row in ip.codes.of(block)):
        number = block.words["h"]
        message = f"H{number:g} beside M98: Mazak's and Mitsubishi's controls begin at line N{number:g} there, FANUC's change the tool offset"
        hint = "write H in a block of its own where it is the tool offset"
        raise BlockError("other-control", message, "H", hint=hint)
    if "d" not in block.words and any(
        row.group == "cutter compensation" and row.takes for row in ip.codes.of(block)
    ):
        # G41 and G42 take it as the number of the radius.
        return
    code = ip.state.length_code
    if code == 49:
        ip.state.length_number = whole(block, "h", "")
    elif code in (43, 44):
        _length_fanuc(ip, block, int(code))
    else:
        message = f"H changes the tool offset: not under G{code:g}"
        raise BlockError("tcp-refused", message, "H", hint="use G49")


def number_in_force(ip: Interpreter, block: Block, name: str) -> int:
    """Return the H of a block of FANUC, which stays in force: else the last one, or the tool in the spindle."""
    if "h" in block.words:
        ip.state.length_number = whole(block, "h", name)
    number = ip.state.length_number
    return of_the_spindle(ip, name, "H") if number is None else number


def of_the_spindle(ip: Interpreter, name: str, letter: str) -> int:
    """Return the tool in the spindle, whose offset a FANUC program means that has named none; a note says so."""
    if ip.state.tool and not ip.lathe:
        message = f"{name} has no {letter}, and none stood before it: the offset of tool {ip.state.tool}, which is in the spindle, is taken"
        hint = f"a control goes on with the {letter} of the program before, or with {letter}0"
        ip.note_once("offset-number", message, name, hint)
    return ip.state.tool


def _length_fanuc(ip: Interpreter, block: Block, code: int) -> None:
    """G43 H of FANUC: the offset H, G44 H: the other way; H0 removes it."""
    number = number_in_force(ip, block, f"G{code}")
    ip.state.length_code = code
    sign = 1.0 if code == 43 else -1.0
    take_length(ip, block, [sign * value for value in table_offset(ip, number)] if number else zeros())


def take_length(ip: Interpreter, block: Block, offset: list[float]) -> None:
    """Take a tool offset of FANUC's controls, which add it to programmed coordinates: under G91 a line goes its distance and the change.

    So does the manual's example of tool length offset A (G91, H1 = -4: ``N2 G43 Z-32.0 H1`` goes 36 down). Where parameter TOS (5006 bit 6)
    shifts the coordinates instead (B-63943EN-1, 12.5.2), the line goes its distance alone.
    """
    before, programmed = ip.state.tool_offset, ip.state.position
    use_offset(ip, offset)
    changed = [letter for letter in AXIS_INDEX if offset[AXIS_INDEX[letter]] != before[AXIS_INDEX[letter]]]
    codes = ip.codes.of(block)
    if not changed or any(row.axes == "own" for row in codes):
        return
    by = " ".join(
        f"{letter.upper()}{offset[AXIS_INDEX[letter]] - before[AXIS_INDEX[letter]]:g}" for letter in changed
    )
    hint = "G90 and a coordinate in the block of the offset leave no choice"
    given = [letter for letter in changed if letter in block.words]
    if not given:
        message = f"the tool offset changes by {by}, and no axis moves; with parameter TOS (5006 bit 6) = 0 FANUC's controls move by it at once"
        ip.note_once("length-moves", message, "", hint)
        return
    absolute = ip.state.absolute if {900, 910}.isdisjoint(block.g) else 900 in block.g
    motion = next((row.number for row in codes if row.axes == "motion"), ip.state.motion)
    if absolute or motion not in (0, 10):
        return
    message = f"under G91 the line goes its distance and the change of the tool offset, {by}; with parameter TOS (5006 bit 6) = 1 its distance alone"
    ip.warn_once("length-moves", message, "", hint)
    for letter in given:
        ip.state.position[AXIS_INDEX[letter]] = programmed[AXIS_INDEX[letter]]


def length_given(ip: Interpreter, block: Block) -> None:
    """G43.1: the offset that the axis words give."""
    offset = ip.state.tool_offset.copy()
    for index, value in block.axes():
        offset[index] = value
    use_offset(ip, offset)


def length_added(ip: Interpreter, block: Block) -> None:
    """G43.2: add the offset of tool H, or the axis words, to the one in force."""
    if "h" in block.words:
        more = table_offset(ip, whole(block, "h", "G43.2"))
        if any(letter in AXIS_INDEX for letter in block.words):
            raise BlockError("tool-length-words", "G43.2 takes a tool H or axis words, not both", "H")
    else:
        more = [block.words.get(letter, 0.0) for letter in AXES]
        if not any(letter in AXIS_INDEX for letter in block.words):
            raise BlockError("tool-length-words", "G43.2 has neither a tool H nor an axis word", "G43.2")
    use_offset(ip, [a + b for a, b in zip(ip.state.tool_offset, more, strict=True)])


def length_off(ip: Interpreter, block: Block) -> None:
    """G49."""
    ip.state.length_code = 49
    use_offset(ip, zeros())


#: Words beside M6 that nothing else has use for there.
_ARGUMENTS = "kpqr"
_BY_NUMBER = ("changes the tool's offset", TOOL_POINT)
_GIVEN = ("changes the tool's offset", COMPENSATION | TOOL_POINT)
CODES = (
    Code("T", 0, "T", Stage.TOOL, select, "tool to be changed in next", "t", refused=("changes the tool", ROTARY_PATH),
        without="lathes"),
    Code("H", 0, "H", Stage.TOOL_LENGTH, length_number, "number of the tool offset", "h", dialects=("fanuc",), without="lathes"),
    Code("M", 60, "tool change", Stage.CHANGE, change, "change to the tool of T", dialects=("linuxcnc",), named=(NEXT_TOOL,),
        after=take_position, refused=CHANGES_TOOL, without="lathes"),
    Code("M", 60, "tool change", Stage.CHANGE, _change_fanuc, "change to the tool of T (K P Q R: arguments of the builder's macro)", _ARGUMENTS,
        dialects=("fanuc",), named=(NEXT_TOOL,), after=take_position, refused=CHANGES_TOOL, without="lathes"),
    Code("M", _M61, "tool change", Stage.CHANGE, name_tool, "the tool in the spindle is Q", "q", dialects=("linuxcnc",)),
    Code("G", 430, "tool length", Stage.TOOL_LENGTH, length, "tool offset of tool H", "h", dialects=("linuxcnc",),
        refused=CHANGES_TOOL_OFFSET, restores=("tool_length", True)),
    Code("G", 430, "tool length", Stage.TOOL_LENGTH, partial(_length_fanuc, code=43), "tool offset H", "h", dialects=("fanuc",),
        takes="h", refused=_BY_NUMBER, without="lathes"),
    Code("G", 440, "tool length", Stage.TOOL_LENGTH, partial(_length_fanuc, code=44), "tool offset H, negative", "h",
        dialects=("fanuc",), takes="h", refused=_BY_NUMBER, without="lathes"),
    Code("G", 431, "tool length", Stage.TOOL_LENGTH, length_given, "tool offset in axis words", AXES, "own", refused=_GIVEN,
        without="lathes"),
    Code("G", 432, "tool length", Stage.TOOL_LENGTH, length_added, "add to the tool offset", AXES + "h", "own", takes="h",
        refused=_GIVEN, without="lathes"),
    Code("G", 490, "tool length", Stage.TOOL_LENGTH, length_off, "no tool offset", dialects=("linuxcnc",),
        refused=CHANGES_TOOL_OFFSET, restores=("tool_length", False)),
)  # fmt: skip

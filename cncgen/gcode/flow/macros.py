"""FANUC's macros (custom macro B): IF GOTO, IF THEN, WHILE DO END, G65 G66 G67, M98 M99 with program numbers.

Arguments follow argument specification I, and II where I J K repeat (B-63324EN, 15.7.1). A parameter without a value
is vacant: NaN inside, which counts as 0 in arithmetic and as no word where a word has it.
"""

from __future__ import annotations

import math

from cncgen.gcode.block import PROGRAM, Block, Flow, Jump, evaluate, named_program, nearest
from cncgen.gcode.codes.subprograms import of_builder
from cncgen.gcode.codes.table import LEADS_ELSEWHERE, OF_FANUC, Code
from cncgen.gcode.codes.tools import whole, whole_of
from cncgen.gcode.errors import BlockError, Stop
from cncgen.gcode.flow import repeats
from cncgen.gcode.flow.calls import MACRO_LOCALS
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.gcode.text import macro_loops
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.search import parted
from cncgen.grammars.terminals import FANUC
from cncgen.kernels.gcode_codes import LITERALS, MACRO_PARAMETERS
from cncgen.toolpath.record import Event

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.flow.o_words import FlowControl
    from cncgen.gcode.text.marked_lines import Marked

VACANT = math.nan
_INPUTS = 1000
#: How far a computed line number may be from a whole one.
_WHOLE = 1e-4


def by_m_code(ip: Interpreter, pairs: list[tuple[str, float]]) -> list[tuple[str, float]]:
    """Return the words of a block as those of G65, with a remark: the parameters 6080 to 6089 of the control name such M codes."""
    name, number = (next(f"{value:g}" for letter, value in pairs if letter == wanted) for wanted in "mp")
    message = f"M{name} P{number} is read as the call of a probe's macro, G65 P{number}: the other words are its arguments"
    ip.warn_once("builders-code", message, f"M{name}", "write G65 for it")
    return [pair for pair in pairs if pair[0] != "m"]


def apart(
    pairs: list[tuple[str, float]], code: float
) -> tuple[list[tuple[str, float]], list[tuple[str, float]]]:
    """Return the G codes of a block before G65 or G66, `code`, which the macro begins with, and the words behind it.

    Raises:
        BlockError: Another word stands before it: G65 stands before its arguments (B-63324EN, 15.7.1).
    """
    at = pairs.index(("g", code))
    for letter, value in pairs[:at]:
        if letter != "g":
            message = f"{letter.upper()} stands before G{code:g}, whose arguments stand behind it"
            hint = "give it a block of its own"
            raise BlockError("macro-arguments", message, f"{letter.upper()}{value:g}", hint=hint)
    return pairs[:at], pairs[at + 1 :]


def arguments(ip: Interpreter, pairs: list[tuple[str, float]]) -> tuple[int, int, list[float]]:
    """Return program number (below 0 that of a name), repeats and local parameters of a G65 or G66 block."""
    number, times = None, 1
    values = [VACANT] * MACRO_LOCALS
    sets = {"i": 0, "j": 0, "k": 0}
    last = 0
    for letter, value in pairs:
        if letter == "p":
            number = whole_of(value, letter, "a macro call")
        elif letter == PROGRAM:
            number = -1 - int(value)
        elif letter == "l":
            times = whole_of(value, letter, "a macro call")
        elif letter in sets:
            # I J K may repeat: the n-th set goes to #(3n+1), #(3n+2), #(3n+3).
            index = 3 * sets[letter] + MACRO_PARAMETERS[letter]
            sets[letter] += 1
            if index > MACRO_LOCALS:
                message = f"{letter.upper()} stands more than ten times"
                raise BlockError("macro-arguments", message, letter.upper())
            values[index - 1] = value
            if index < last:
                message = f"{letter.upper()} stands behind a later one of I J K: it sets #{index} here, and on some controls one of the next set"
                hint = "I, J and K stand in the order of the alphabet (FANUC), each set by itself"
                ip.warn_once("other-control", message, letter.upper(), hint)
            last = index
        elif letter in MACRO_PARAMETERS:
            values[MACRO_PARAMETERS[letter] - 1] = value
        else:
            message = f"{letter.upper()} is not an argument of a macro"
            raise BlockError("macro-arguments", message, f"{letter.upper()}{value:g}")
    # H stands first, and P is a variable or the line that a condition leads to: `G65 H81 P100 Q#10 R1`.
    sums = any(letter == "h" for letter, _ in pairs) if number is None else pairs[0][0] == "h"
    if sums and (number is None or not _has_program(ip, ip.base.block, number)):
        message = "G65 H is of custom macro A of older controls, which is not read"
        hint = "write it in macro B: #100=#101+#102, IF[#100EQ1]GOTO100; G65 P calls a program"
        raise BlockError("not-read", message, "H", hint=hint)
    if number is None:
        raise BlockError("sub-missing", "a macro call has no program number P", "G65")
    return number, times, values


def call(ip: Interpreter, block: Block) -> None:
    """G65: call a macro (its words are read before, `LineRunner.call_macro`)."""


def modal_call(ip: Interpreter, block: Block) -> None:
    """G66: call a macro after each motion from now on."""


def end_modal_call(ip: Interpreter, block: Block) -> None:
    """G67: end the G66 that came last."""
    if ip.modal_macros:
        ip.modal_macros.pop()


def call_program(ip: Interpreter, block: Block) -> None:
    """M98 P L, M98 <NAME> L, M98 (FILE) L of Haas: run a program L times; P of more than four digits begins with the number of times. Q is the N word of the
    line at which it begins (Mazak: "Q: sequence number in subprogram to be called"), without P of a line of this program."""
    times = _times(ip, block, "M98")
    line = whole(block, "q", "M98") if "q" in block.words else -1
    if PROGRAM in block.words:
        ip.jump = Jump("call", -1 - int(block.words[PROGRAM]), times, line)
        return
    if "p" not in block.words:
        file = _file_of(ip, block) if line < 0 else ""
        if file:
            ip.jump = Jump("call", -1 - named_program(file), times)
            return
        if line < 0:
            raise BlockError("sub-missing", "M98 has no program number P", "M98", hint="M98 P1000 runs O1000")
        ip.jump = Jump("lines", line, times)
        return
    number = whole(block, "p", "M98")
    if number > 9999 and "l" not in block.words and not _has_program(ip, block, number):
        times, number = divmod(number, 10_000)
    ip.jump = Jump("call", number, times, line)


def _file_of(ip: Interpreter, block: Block) -> str:
    """Return the name of the file that stands in parentheses behind M98 (Haas), "" without one; its folder is one of the control's disk."""
    import re

    text = ip.flow_control().subroutines.sources[block.source].text_at(block.offset)
    found = re.search(rf"(?i)M[ \t]*98[ \t]*({FANUC['COMMENT']})", text)
    folder, file = parted(found[1]) if found else ("", "")
    if file and folder:
        message = (
            f"the folder {folder} of M98 is one of the control's: {file} is looked for beside the program"
        )
        ip.warn_once("other-control", message, "M98", "--include adds a folder to the search path")
    return file


def _times(ip: Interpreter, block: Block, code: str) -> int:
    """Return how often a block calls, L of its code."""
    times = whole(block, "l", code) if "l" in block.words else 1
    tell_idle(ip, times)
    return times


def tell_idle(ip: Interpreter, times: int) -> None:
    """Say that a call of no times runs nothing."""
    if times == 0:
        ip.warn_once("call-idle", "a call with L0 runs nothing", "L", "without L it runs once")


def _has_program(ip: Interpreter, block: Block, number: int) -> bool:
    """Tell whether a program has a number: one of more than four digits is an option of FANUC's controls."""
    assert ip.flow is not None
    try:
        ip.flow.subroutines.find(
            float(number), Cursor(block.source, block.offset, block.line), ("program", "sub")
        )
    except BlockError:
        return False
    return True


def call_lines(ip: Interpreter, block: Block) -> None:
    """M97 P L of Haas: run the lines of this program from N P to M99, L times."""
    if "p" not in block.words:
        message = "M97 has no line number P"
        raise BlockError("sub-missing", message, "M97", hint="M97 P100 runs from N100 to M99")
    times = _times(ip, block, "M97")
    ip.jump = Jump("lines", whole(block, "p", "M97"), times)


def unless_input(ip: Interpreter, block: Block) -> None:
    """M96 P Q of Haas: to line N P if input Q is 0, which #1000 and the next variables tell (96-8000, "M96 Jump If No Input"); without Q
    the builder's, which FANUC's controls may have for an interruption by a macro."""
    if "q" not in block.words:
        of_builder(960, "p").run(ip, block)
        return
    line, parameters = whole(block, "p", "M96") if "p" in block.words else 0, ip.parameters
    if not line:
        raise BlockError("sub-missing", "M96 has no line number P", "M96", hint="M96 P10 Q8 leads to N10")
    parameters.untold = 0
    if not parameters.number(_INPUTS + whole(block, "q", "M96")):
        ip.jump = Jump("line", line)


def back(ip: Interpreter, block: Block) -> None:
    """M99 P: back to where the program was called from, or to its line N; in the main program, to its own."""
    ip.jump = Jump("return", whole(block, "p", "M99") if "p" in block.words else -1)


def run(control: FlowControl, word: Flow, here: Cursor) -> Cursor | None:
    """Execute a jump or loop of a macro; return where to go on, or None for the next line."""
    parameters = control.ip.parameters
    parameters.untold = 0
    if word.keyword == "goto" and word.arguments and not control.condition(word):
        return None
    untold = parameters.untold
    assert word.label is not None
    assert not isinstance(word.label, str)
    target = target_of(control, LITERALS[word.keyword], evaluate(word.label, parameters), here)
    if word.keyword == "goto" and target.offset <= here.offset:
        if word.arguments:
            if repeats.waits(control, here, target, untold, "GOTO"):
                return None
        elif repeats.repeats_for_ever(control, here, target):
            repeats.end_main(control, here, target, "GOTO")
            return None
    if word.keyword == "goto" and (loop := entered(control, here, target)) is not None:
        message = f"GOTO leads into the loop DO {loop.label:g} of line {loop.cursor.line} from outside: controls do not take that, or differ"
        hint = "lead to the line of WHILE or DO, or before it"
        control.ip.warn_once("other-control", message, "GOTO", hint)
    stays = word.keyword == "while-do" and (not word.arguments or control.condition(word))
    if stays and parameters.untold and _waited(control, here, target, parameters.untold):
        return target
    return None if stays else target


def _waited(control: FlowControl, here: Cursor, behind: Cursor, untold: int) -> bool:
    """Tell whether a loop that asks for a signal has had its pass: the wait for the signal ends."""
    if here not in control.waiting:
        control.waiting.add(here)
        return False
    control.waiting.remove(here)
    last = Cursor(behind.source, behind.offset - 1, behind.line - 1)
    return repeats.waits(control, last, here, untold, "WHILE")


def target_of(control: FlowControl, keyword: int, value: float, here: Cursor) -> Cursor:
    """Return the line that GOTO, DO or END, by its literal in the grammar, leads to: `value` is its number."""
    if keyword == LITERALS["goto"]:
        return line_numbered(control, here, line_of(value))
    return (macro_loops.end_of if keyword == LITERALS["while-do"] else macro_loops.begin_of)(
        control, value, here
    )


def entered(control: FlowControl, here: Cursor, target: Cursor) -> Marked | None:
    """Return the DO of a loop that GOTO enters from outside, which FANUC's manual forbids (B-63324EN, 15.6); None without one."""
    return control.subroutines.labels(here.source).loops.entered(here.offset, target.offset)


def tells(control: FlowControl, here: Cursor, target: Cursor) -> bool:
    """Tell whether a GOTO, with a condition or without, may have more to do than to lead to its line."""
    return entered(control, here, target) is not None or repeats.repeats_for_ever(control, here, target)


def line_of(value: float) -> int:
    """Return the line number after GOTO; raise if it is not whole."""
    number = nearest(value, "the line of GOTO")
    if abs(number - value) > _WHOLE:
        hint = "round it, or compute it from whole numbers"
        raise BlockError("not-whole", f"GOTO {value:g} is not a whole number", "GOTO", hint=hint)
    return number


def line_numbered(control: FlowControl, here: Cursor, number: int, word: str = "GOTO") -> Cursor:
    """Return the line with that N word in the same program: after this line, else from the program's beginning."""
    labels = control.subroutines.labels(here.source)
    begin, end = labels.program_range(here.offset)
    found = [c for c in labels.numbered.get(number, []) if begin <= c.offset < end]
    later = [c for c in found if c.offset > here.offset]
    if not found:
        message = f"there is no line N{number} to go to in this program"
        hint = "GOTO and M99 P name the N word of a line of their own program"
        raise BlockError("goto-target", message, word, hint=hint)
    return (later or found)[0]


def alarm(ip: Interpreter, value: float, text: str) -> None:
    """#3000 = n (text): end the program with an alarm."""
    raise Stop(BlockError("macro-alarm", f"the program raises alarm {value:g}: {text or 'no text'}", "#"))


def message(ip: Interpreter, value: float, text: str) -> None:
    """#3006 = n (text): stop with a message."""
    ip.sink.call("PROGRAM_STOP()", Event("stop", True, values={"kind": "message", "text": text}))


CODES = (
    Code("G", 650, "macro", Stage.STOP, call, "call macro P, L times, with arguments", dialects=OF_FANUC, calls="p"),
    Code("G", 660, "macro", Stage.STOP, modal_call, "call macro P after each motion", dialects=OF_FANUC, calls="p"),
    Code("G", 670, "macro", Stage.STOP, end_modal_call, "end of G66", dialects=OF_FANUC),
    *(
        Code("M", number, "subprogram", Stage.STOP, run_it, text, words, dialects=OF_FANUC, named=named, calls=calls, refused=LEADS_ELSEWHERE,
            ends="subprogram" if run_it is back else "")
        for number, run_it, text, words, named, calls in (
            (960, unless_input, "to line N P if input Q is 0 (Haas)", "pq", (), ""),
            (970, call_lines, "run the lines from N P to M99, L times (Haas)", "pl", (), ""),
            (980, call_program, "run program P, L times", "plq", (PROGRAM,), "p"),
            (990, back, "end of a subprogram", "p", (), ""),
            (1980, call_program, "run program P of a file, L times", "pl", (PROGRAM,), "p"),
        )
    ),
)  # fmt: skip

"""Comments, also those with an effect: MSG, DEBUG, PRINT, LOG, and START, the first position of the machine."""

from __future__ import annotations

import re
from collections.abc import Callable

from cncgen.gcode.block import AXIS_INDEX, OUTPUT, Block
from cncgen.gcode.errors import BlockError, Stop
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.parameters import DEBUGGING
from cncgen.grammars.terminals import LINUXCNC
from cncgen.toolpath.record import Event

CODES = ()

_ACTIVE = r"(?s)\s*([A-Za-z]+),(.*)"
_START_WORD = rf"\s*([A-Za-z])\s*([+-]?(?:{LINUXCNC['NUMBER']}))"
#: Parts that a message does not show literally: parameters, an unfinished one at the end, formats, the % of an unknown format.
_SHOWN = r"#(?P<number>\d+)|#<(?P<name>[^>]*)>|#<[^>]*$|#$|(?P<form>%d|%f|%\.\df)|%(?=\.)"
#: Values nearer to 0 are shown as 0 (measured on LinuxCNC's interpreter).
_LEAST = 1e-4
#: A variable of DPRNT and its digits.
_DIGITS = r"#\[?(?P<number>\d+)\]?\s*\[(?P<whole>\d)(?P<decimals>\d)\]"
_STYLES = {"%d": ".0f", "%f": ".4f"}


def comment(ip: Interpreter, block: Block, text: str) -> None:
    """Execute a comment, or pass it on."""
    if text[:1] == OUTPUT:
        output(ip, text[1:])
        return
    match = re.match(_ACTIVE, text)
    keyword = match.group(1).upper() if match else ""
    act = _ACTS.get(keyword)
    ip.sink.block = block
    if match and act:
        act(ip, match.group(2))
    elif text.strip().upper() == "LOGCLOSE":
        ip.sink.call("LOGCLOSE()", Event("log", values={"action": "logclose", "text": ""}))
    else:
        if match and keyword == "START":
            start(ip, match.group(2))
        if text.count("(") > text.count(")"):
            message = "a comment ends at its first ), whatever ( stands within it: what follows is read"
            ip.warn_once("other-control", message, "(", "close each ( of a comment, or leave it out")
        if text:
            ip.sink.call(f'COMMENT("{text.lstrip()}")')


def _message(ip: Interpreter, rest: str) -> None:
    ip.sink.call(f'MESSAGE("{rest}")', Event("message", values={"text": rest.strip()}))


def _debug(ip: Interpreter, rest: str) -> None:
    if ip.parameters.numbers[DEBUGGING]:
        _message(ip, expand(ip, rest))


def _print(ip: Interpreter, rest: str) -> None:
    shown = expand(ip, rest)
    ip.sink.call(shown, Event("message", values={"text": shown.strip(), "print": True}))


def _log(ip: Interpreter, rest: str) -> None:
    shown = expand(ip, rest)
    ip.sink.call(f'LOG("{shown}")', Event("log", values={"action": "log", "text": shown.strip()}))


def _log_file(action: str) -> Callable[[Interpreter, str], None]:
    def run(ip: Interpreter, rest: str) -> None:
        event = Event("log", values={"action": action, "text": rest.strip()})
        ip.sink.call(f'{action.upper()}("{rest}")', event)

    return run


def _abort(ip: Interpreter, rest: str) -> None:
    raise Stop(BlockError("program-abort", f"the program aborts itself: {expand(ip, rest).strip()}"))


def output(ip: Interpreter, text: str) -> None:
    """Execute an output command of FANUC's macros: POPEN, PCLOS, or DPRNT[X#1[53]] with its text.

    Of DPRNT, a value has as many digits before and after the point as its bracket says, and * is a blank. SETVN#500[SIZE] gives variables
    names for the control's screen.
    """
    keyword, _, inner = text.partition("[")
    if not inner or keyword.startswith("SETVN"):
        ip.sink.call(f'COMMENT("{keyword.strip()}")')
        return

    def shown(match: re.Match[str]) -> str:
        try:
            value = ip.parameters.shown(int(match["number"][:99]))
        except BlockError:
            return "######"
        whole, decimals = int(match["whole"]), int(match["decimals"])
        width = whole + decimals + (1 if decimals else 0)
        sign = "-" if value < 0.0 else " "
        return sign + (f"{abs(value):{width}.{decimals}f}" if value == value else " " * width)

    text = re.sub(_DIGITS, shown, inner.rstrip().removesuffix("]")).replace("*", " ")
    ip.sink.call(f'COMMENT("{text}")', Event("message", values={"text": text, "print": True}))


_ACTS: dict[str, Callable[[Interpreter, str], None]] = {
    "MSG": _message,
    "DEBUG": _debug,
    "PRINT": _print,
    "LOG": _log,
    "LOGOPEN": _log_file("logopen"),
    "LOGAPPEND": _log_file("logappend"),
    "ABORT": _abort,
}


def expand(ip: Interpreter, text: str) -> str:
    """Replace ``#5`` and ``#<name>`` by their values, as messages show them.

    ``%d`` shows the values after it as whole numbers, ``%.2f`` with two decimals, ``%f`` with four; ``######`` stands
    for a missing value (LinuxCNC manual, "Formatting"; the rest as its interpreter does).
    """
    style = "f"

    def shown(match: re.Match[str]) -> str:
        nonlocal style
        number, name, form = match.group("number"), match.group("name"), match.group("form")
        if number is None and name is None:
            style = _STYLES.get(form, form[1:]) if form else style
            return ""
        # The interpreter knows names without blanks, in lower case.
        folded = re.sub(r"\s", "", name or "").lower()
        try:
            value = ip.parameters.shown(int(number[:99])) if number else ip.parameters.name(folded)
        except BlockError:
            return "######"
        return f"{0.0 if abs(value) < _LEAST else value:{style}}"

    return re.sub(_SHOWN, shown, text)


def start(ip: Interpreter, text: str) -> None:
    """Set where the machine stands, in machine coordinates: ``(START, X10 Y5)`` before the first motion."""
    if ip.state.moved:
        raise BlockError("start-late", "(START, …) stands after the first motion", "")
    machine = ip.machine_position()
    place = 0
    for match in re.finditer(_START_WORD, text):
        letter = match.group(1).lower()
        if text[place : match.start()].strip() or letter not in AXIS_INDEX:
            break
        machine[AXIS_INDEX[letter]] = float(match.group(2))
        place = match.end()
    if text[place:].strip():
        message = f"(START, …) takes axis letters with numbers, not {text[place:].strip()!r}"
        raise BlockError("start-words", message)
    ip.rebase(machine)
    ip.sink.place(ip.state.position)

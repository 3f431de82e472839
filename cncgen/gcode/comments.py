"""Comments, and those that do something: MSG, DEBUG, PRINT, LOG, and START, where the machine stands."""

from __future__ import annotations

import re

from cncgen.gcode.block import AXIS_INDEX, Block
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.toolpath.record import Event

CODES = ()

_ACTIVE = re.compile(r"\s*([A-Za-z]+)\s*,(.*)", re.DOTALL)
_START_WORD = re.compile(r"\s*([A-Za-z])\s*([+-]?(?:\d+\.?\d*|\.\d+))")
_PARAMETER = re.compile(r"#(\d+|<[^>]*>)")


def comment(ip: Interpreter, block: Block, text: str) -> None:
    """Do what a comment says, or pass it on."""
    match = _ACTIVE.match(text)
    keyword = match.group(1).upper() if match else ""
    rest = match.group(2) if match else ""
    sink = ip.sink
    sink.block = block
    if keyword == "MSG":
        sink.call(f'MESSAGE("{rest}")', Event("message", values={"text": rest.strip()}))
    elif keyword == "DEBUG":
        shown = expand(ip, rest)
        sink.call(f'MESSAGE("{shown}")', Event("message", values={"text": shown.strip()}))
    elif keyword == "PRINT":
        sink.call("", Event("message", values={"text": expand(ip, rest).strip()}))
    elif keyword in ("LOG", "LOGOPEN", "LOGAPPEND", "LOGCLOSE", "PROBEOPEN", "PROBECLOSE"):
        sink.call("", Event("log", values={"action": keyword.lower(), "text": expand(ip, rest).strip()}))
    else:
        if keyword == "START":
            start(ip, rest)
        if text.strip():
            sink.call(f'COMMENT("{text.lstrip()}")')


def expand(ip: Interpreter, text: str) -> str:
    """Replace ``#5`` and ``#<name>`` by their values, as messages show them."""

    def value(match: re.Match[str]) -> str:
        name = match.group(1)
        parameters = ip.parameters
        found = parameters.number(int(name)) if name.isdigit() else parameters.name(name[1:-1].lower())
        return f"{found:f}"

    return _PARAMETER.sub(value, text)


def start(ip: Interpreter, text: str) -> None:
    """Set where the machine stands, in machine coordinates: ``(START, X10 Y5)`` before the first motion."""
    if ip.state.moved:
        raise BlockError("start-late", "(START, …) stands after the first motion", "")
    machine = ip.machine_position()
    place = 0
    for match in _START_WORD.finditer(text):
        letter = match.group(1).lower()
        if text[place : match.start()].strip() or letter not in AXIS_INDEX:
            break
        machine[AXIS_INDEX[letter]] = float(match.group(2))
        place = match.end()
    if text[place:].strip():
        raise BlockError(
            "start-words", f"(START, …) takes axis letters with numbers, not {text[place:].strip()!r}"
        )
    ip.rebase(machine)
    ip.sink.place(ip.state.position)

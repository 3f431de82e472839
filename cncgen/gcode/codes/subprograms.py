"""M98 and M99, and the M codes of the user: M100 to M199."""

from __future__ import annotations

from functools import cache

from cncgen.gcode.block import Block, Jump
from cncgen.gcode.codes.table import BOTH, Code
from cncgen.gcode.codes.tools import whole
from cncgen.gcode.errors import BlockError
from cncgen.gcode.state.modal import Stage
from cncgen.toolpath.record import Event

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

USER_CODES = range(1000, 2000, 10)
#: M198 of FANUC runs a program.
_OF_A_FILE = 1980


def call(ip: Interpreter, block: Block) -> None:
    """M98 P L: run program P, L times."""
    if "p" not in block.words:
        raise BlockError("sub-missing", "M98 has no program number P", "M98")
    times = whole(block, "l", "M98") if "l" in block.words else 1
    ip.jump = Jump("call", whole(block, "p", "M98"), times)


def back(ip: Interpreter, block: Block) -> None:
    """M99: end of a subprogram; in the main program, the end of it."""
    if ip.call_level() and ip.frame().again is None:
        message = "M99 cannot end a SUB that was called by CALL"
        raise BlockError("sub-kind", message, "M99", hint="use ENDSUB or RETURN")
    ip.jump = Jump("return")


def user(ip: Interpreter, block: Block) -> None:
    """M100 to M199: an event with its number, P and Q."""
    values = {letter: block.words[letter] for letter in "pq" if letter in block.words}
    number = block.m[0] // 10 if block.m else 0
    number = next((m // 10 for m in block.m if m in USER_CODES), number)
    _start_driven(ip, block, f"M{number}")
    p, q = block.words.get("p", -1.0), block.words.get("q", -1.0)
    ip.sink.call(
        f"USER_DEFINED_FUNCTION_{number}({p:f}, {q:f})", Event("user", True, values={"m": number, **values})
    )


#: M codes of Haas's controls that move no axis (96-8000 and 96-8900, "M-Codes"): brakes and chucks, conveyor and spigot, gears, doors, air
#: and coolant through the spindle, and the mist condenser.
_OF_HAAS = frozenset(
    (10, 11, 12, 13, 14, 15, 31, 33, 34, 35, 41, 42, 73, 74, 80, 81, 83, 84, 88, 89, 158, 159)
)


@cache
def of_builder(number: int, words: str) -> Code:
    """Return the handler of an M code, in tenths, that FANUC leaves to the machine's builder: an event, and a remark.

    `words` are those that it may take.
    """
    name = f"M{number // 10}"

    def run(ip: Interpreter, block: Block) -> None:
        if not (number // 10 in _OF_HAAS and ip.flow is not None and ip.flow.of_haas):
            tell_builders(ip, name)
        _start_driven(ip, block, name)
        ip.sink.call(
            f"USER_DEFINED_FUNCTION_{number // 10}(-1.000000, -1.000000)",
            Event("user", True, values={"m": number // 10}),
        )

    return Code("M", number, name, Stage.USER, run, "the machine builder's: an event", words)


def _start_driven(ip: Interpreter, block: Block, name: str) -> None:
    """Have feeds per revolution count on S where it stands beside a code of the machine's builder while the spindle rests: of a driven tool."""
    state = ip.state
    if ip.dialect == "fanuc" and "s" in block.words and state.direction == 0 and state.speed > 0.0:
        state.driven = True
        ip.sink.set_spindle(state.speed, 1)
        message = f"{name} beside S while the spindle rests is taken to start a driven tool: feeds per revolution count on its S{state.speed:g}"
        ip.note_once("driven-tool", message, name, "M3 or M4 before it starts the spindle")


def tell_builders(ip: Interpreter, name: str) -> None:
    """Say that an M code is the machine builder's."""
    message = f"{name} does not belong to the control's own codes: taken as the machine builder's, an event"
    ip.warn_once("builders-code", message, name, f"check that {name} moves nothing")


CODES = (
    Code("M", 980, "subprogram", Stage.STOP, call, "run program P, L times", "pl", dialects=("linuxcnc",), calls="p"),
    Code("M", 990, "subprogram", Stage.STOP, back, "end of a subprogram", dialects=("linuxcnc",)),
    *(
        Code("M", number, "user", Stage.USER, user, "the user's own: an event", "pq",
            dialects=BOTH if number != _OF_A_FILE else ("linuxcnc",))
        for number in USER_CODES
    ),
)  # fmt: skip

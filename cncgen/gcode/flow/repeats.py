"""Jumps back that a program itself never stops making: it repeats until its operator or the machine ends it.

A jump without a condition, as programs for bar feeders have it, ends the main program where nothing between its target and itself leads
elsewhere: one pass is planned, as of M99. A jump whose condition asks a signal of the machine, which is not known here, is made once where
nothing between sets a variable: the control waits for the signal, or repeats until it comes.
"""

from __future__ import annotations

import re

from cncgen.gcode.text.labels import Cursor
from cncgen.grammars.terminals import FANUC

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.flow.o_words import FlowControl

_COMMENTS, _BLANKS = re.compile(FANUC["COMMENT"].encode()), b" \t\r"
_LEFT_OUT = re.compile(f"(?im)^(?:{FANUC['LINE_NUMBER']})?{FANUC['DELETE']}.*$".encode())
_GO = f"(?:{FANUC['GOTO']}|{FANUC['GO']})"
_COMPUTED, _WHOLE = f"(?:{FANUC['HASH']}|{FANUC['LSQB']})", "([0-9]+)"


def _code(letter: str, *numbers: int) -> str:
    """Return the pattern of codes, whose numbers may have zeros before them and a point behind: M2, M02, M2."""
    return rf"{letter}0*(?:{'|'.join(map(str, numbers))})(?:\.0*)?(?![0-9.])"


def _any(*patterns: str) -> re.Pattern[bytes]:
    return re.compile("|".join(patterns).encode())


_ALARM = f"{FANUC['HASH']}3000{FANUC['EQUAL']}"
_CALLED = _code("m", 97, 98), _code("m", 198), _code("g", 65, 66)
#: Words that end a run of lines or lead out of it, apart from jumps by number: the ends of a program and of a subprogram, an alarm, a computed jump.
_ENDS = _any(_code("m", 2, 30, 99), _ALARM, "%", _GO + _COMPUTED, _code("m", 96) + "p" + _COMPUTED)
_BACK = _code("m", 99) + "p" + _WHOLE
_JUMPS = _any(_GO + _WHOLE, _code("m", 96) + "p" + _WHOLE, _BACK)
#: A condition before a jump.
_CONDITION = _any(FANUC["IF"], FANUC["RSQB"] + FANUC["RETURN"])
_CALLS = _any(*_CALLED)
#: Words by which a called program may end the run, or return to another line of its caller.
_ENDS_ELSEWHERE = _any(_code("m", 2, 30), _ALARM, _code("m", 99) + "p", _GO + FANUC["LSQB"])
#: Words that set a variable, or may do so elsewhere.
_SETS = _any(FANUC["EQUAL"], *_CALLED)


def repeats_for_ever(control: FlowControl, here: Cursor, target: Cursor) -> bool:
    """Tell whether a jump of the main program from one line back to another repeats what stands between for ever."""
    if here.source != 0 or control.calls.frames or target.offset > here.offset:
        return False
    known = control.repeating
    if here.offset not in known:
        known[here.offset] = _never_left(control, here, target)
    return known[here.offset]


def end_main(control: FlowControl, here: Cursor, target: Cursor, word: str) -> None:
    """End the main program at a jump that repeats it, with a note."""
    from cncgen.gcode.text.lanes import empty_block

    control.calls.flush()
    control.ip.base.block = empty_block(here)
    message = f"{word} leads back to line {target.line} without end, as nothing between leads elsewhere; one pass is planned"
    control.ip.note("program-repeats", message, word, "M30 ends it")
    control.ip.end_program()


def waits(control: FlowControl, here: Cursor, target: Cursor, untold: int, word: str) -> bool:
    """Tell whether a jump back asks for a signal (variable `untold`, 0 for none) that nothing here brings; a warning says that it counts
    as having come."""
    if not untold or here.source != target.source or target.offset > here.offset:
        return False
    if _SETS.search(_between(control, here, target)):
        return False
    message = (
        f"{word} leads back to line {target.line} until #{untold} tells of a signal of the machine: it counts as "
        "having come after one pass, and the wait takes no time"
    )
    control.ip.warn_once("wait-assumed", message, word, f"--parameters gives #{untold} the value that it has")
    return True


def _bare(text: bytes) -> bytes:
    """Return a text in small letters, as the grammar has them, without comments and blanks."""
    return _COMMENTS.sub(b"", text).translate(None, _BLANKS).lower()


def _between(control: FlowControl, here: Cursor, target: Cursor) -> bytes:
    """Return the lines from the target of a jump back to the jump itself, without comments, blanks and blocks that are left out."""
    source = control.subroutines.sources[here.source]
    lines = _bare(source.data[target.offset : source.line_end(here.offset)])
    return _LEFT_OUT.sub(b"", lines) if control.ip.options.block_delete else lines


def _never_left(control: FlowControl, here: Cursor, target: Cursor) -> bool:
    """Tell whether nothing from the target to the jump leads elsewhere or ends the program."""
    lines = _between(control, here, target)
    # The jump itself may be M99 P.
    *before, last = lines.rsplit(b"\n", 1)
    if _CONDITION.search(last):
        return False
    if any(_ENDS.search(part) for part in before) or _ENDS.search(re.sub(_BACK.encode(), b"", last)):
        return False
    labels = control.subroutines.labels(here.source)
    for jump in _JUMPS.finditer(lines):
        places = labels.numbered.get(int(next(filter(None, jump.groups()))), [])
        if not places or any(not target.offset <= place.offset <= here.offset for place in places):
            return False
    if not _CALLS.search(lines):
        return True
    source = control.subroutines.sources[here.source]
    behind = source.data[labels.program_range(here.offset)[1] :]
    return not _ENDS_ELSEWHERE.search(_bare(behind))

"""Recovery from an error: the modes that a faulty line sets, and the place that it leads to, still take effect.

Otherwise later lines would be reported for words of the faulty line: coordinates without a motion code, arcs that begin at the wrong
place. This has no effect on a plan, since a program with errors is not planned.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress

from cncgen.gcode.block import AXIS_INDEX, LARGEST, Block, Parsed, Value, evaluate, tenths
from cncgen.gcode.codes.lathe_words import turned
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import PLAIN_MOTIONS
from cncgen.gcode.text.normal_text import normalise
from cncgen.grammars.terminals import LINUXCNC

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.flow.faults import Faults
    from cncgen.gcode.flow.o_words import FlowControl
    from cncgen.gcode.text.labels import Cursor
    from cncgen.gcode.text.marked_lines import Marked

#: O-words that begin branches or a loop with a value, and their ends.
_ENDS = {"if": "endif", "while": "endwhile", "repeat": "endrepeat"}
#: Lines of a comment that are looked at for its end.
_MOST_REMARKS = 100
_FEED = re.compile(r"(?<![a-z])f[#\[]")
#: Modal groups of what a line sets by a code alone.
_MODES = frozenset(("plane", "units", "distance", "arc distance", "feed mode"))


def recover(ip: Interpreter, parse: Callable[[str], Parsed], text: str) -> None:
    """Put the modes and the feed rate of a faulty line in force, and take the end point of its axis words for the position.

    Lines with another use of axis words do not change the position. So do lines under G91: an arc whose centre is given from its
    start is then correct in itself. `parse` has the block of a line that was read before.
    """
    if ip.guard is not None:
        return
    words, codes = _said(ip, parse, text)
    rows = {number: ip.codes.get(("G", number)) for number in codes}
    modes = [number for number, row in rows.items() if row is not None and row.group in _MODES]
    motions = [number for number in codes if number in PLAIN_MOTIONS]
    if motions:
        ip.state.motion = motions[-1]
    if ip.state.compensation != 40:
        # Cutter compensation holds moves back, and knows by itself where it is.
        return
    feed = {"f": words["f"]} if words.get("f", 0.0) > 0.0 else {}
    if not feed and not ip.state.feed and _FEED.search(normalise(text)):
        # The line has a feed, but its value was not computed.
        feed = {"f": 1.0}
    for block in (*(Block({}, (number,)) for number in modes), Block(feed)):
        attempt(ip, block)
    # Beside G0, G90 of a lathe (system A) is the mode of a mill, and no cycle.
    cycles = [number for number, row in rows.items() if motions and row is not None and row.group == "motion"]
    plain = ip.state.motion in PLAIN_MOTIONS and rows.keys() <= {*modes, *PLAIN_MOTIONS, *cycles}
    if plain and ip.state.absolute:
        stand(ip, Block({letter: v for letter, v in words.items() if letter in AXIS_INDEX}))


def behind_branch(control: FlowControl, faults: Faults, here: Cursor) -> Cursor | None:
    """Return the line behind the branches or the loop that begin in a faulty line; None of another line.

    Nobody knows whether they run: of their lines, the modes, feeds and named parameters count for what follows, and faults of spelling are
    reported.
    """
    labels, frame = control.subroutines.labels(here.source), control.calls.frame
    mark = labels.by_offset.get(here.offset)
    if mark is None or not isinstance(mark.label, float | str):
        return None
    end: Marked | None = None
    if mark.keyword == "while-do":
        end = labels.loops.partner.get(here.offset)
    elif mark.keyword in _ENDS and not (
        mark.keyword == "while" and frame.doing is not None and mark.label in frame.doing
    ):
        resolve = control.subroutines.resolved
        end = labels.next(here.offset, mark.label, (_ENDS[mark.keyword],), resolve, over_borders=False)
    if end is None:
        return None
    inner = control.lines.after(here)
    while inner.offset < end.cursor.offset:
        _take_modes(control, faults, inner)
        inner = control.lines.after(inner)
    return end.after


def behind_comment(control: FlowControl, here: Cursor, error: BlockError) -> Cursor | None:
    """Return the line behind a comment that goes on over several lines, and let its fault say where it ends; None of another one."""
    below = control.lines.after(here)
    for _ in range(_MOST_REMARKS):
        try:
            text = control.lines.text(below)
        except BlockError:
            # A line that is too long has a fault of its own.
            return None
        opens, closes = text.find("("), text.find(")")
        below = control.lines.after(below)
        if closes >= 0 and (opens < 0 or closes < opens):
            error.message += f" on its line; that stands in line {below.line - 1}"
            error.hint = "each line of a comment has its own ( and )"
            return below
        if opens >= 0:
            return None
    return None


def _take_modes(control: FlowControl, faults: Faults, here: Cursor) -> None:
    """Put in force what a line sets that is passed by."""
    ip = control.ip
    try:
        text = control.lines.text(here)
        parsed = control.lines.parse(text)
    except BlockError as error:
        faults.fail(here, error)
        return
    if parsed.flow is not None:
        return
    for target, value in parsed.settings:
        if isinstance(target, str):
            with suppress(BlockError):
                ip.parameters.set_name(target, evaluate(value, ip.parameters))
    faults.recover(text)


def _said(ip: Interpreter, parse: Callable[[str], Parsed], text: str) -> tuple[dict[str, float], list[int]]:
    """Return the words of a line that have values, and its G codes; none of a line that jumps or loops."""
    pairs: list[tuple[str, Value]]
    try:
        parsed = parse(text)
    except BlockError:
        found = re.finditer(LINUXCNC["WORD"], normalise(text))
        pairs = [(word[0][0], float(word[0][1:])) for word in found]
    else:
        pairs = [] if parsed.flow is not None else parsed.words
    words: dict[str, float] = {}
    codes: list[int] = []
    for letter, value in pairs:
        try:
            number = evaluate(value, ip.parameters)
            if letter == "g":
                codes.append(tenths("G", number))
            elif abs(number) <= LARGEST:
                words[letter] = number
        except BlockError:
            continue
    return words, codes


def attempt(ip: Interpreter, block: Block) -> None:
    """Execute a block with the remaining modes of the failed line."""
    if not block.words and not block.g:
        return
    here, doubted = ip.base.block, ip.feed_doubted
    # F may be a word of the code that failed: nothing is said of it.
    ip.feed_doubted = True
    with suppress(BlockError):
        ip.execute(block)
    ip.base.block, ip.feed_doubted = here, doubted


def stand(ip: Interpreter, block: Block) -> None:
    """Take the target of axis words as the place of the tool."""
    if not block.words:
        return
    if ip.state.diameter and not ip.lathe and "x" in block.words:
        block.words["x"] *= 0.5
    with suppress(BlockError):
        block = ip.rewrite(ip, block) if ip.rewrite is not None else block
        ip.state.position = ip.end_point(turned(ip, block) if ip.lathe else block)

"""O-words of branches and loops: IF ELSEIF ELSE ENDIF, WHILE ENDWHILE, DO WHILE, REPEAT ENDREPEAT, BREAK, CONTINUE.

Each takes the flow control, the O-word, its line and the line behind it, and returns where to go on, None for the next line.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from cncgen.gcode.block import Flow, nearest
from cncgen.gcode.text.labels import LOOP_END, Cursor, Label

if TYPE_CHECKING:
    from cncgen.gcode.flow.o_words import FlowControl

#: Where BREAK and CONTINUE lead.
_ENDS = ("endwhile", "endrepeat", "while")


def begin_if(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Handle IF: into its branch, or that of the first ELSEIF whose condition holds, or of ELSE, or behind ENDIF."""
    from cncgen.gcode.text import grammar

    label = control.label_of(flow)
    control.claim(flow, label, here)
    if control.condition(flow):
        return None
    place = here
    while True:
        mark = control.next_mark(place, label, ("elseif", "else", "endif"), "endif")
        if mark.keyword != "elseif":
            return mark.after
        parsed = grammar.parse(control.text_of(mark), control.ip.dialect)
        assert parsed.flow is not None
        if parsed.flow.asks_state:
            control.flush()
        if control.condition(parsed.flow):
            return mark.after
        place = mark.cursor


def leave_if(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Handle ELSE or ELSEIF at the end of the branch that was taken: go behind ENDIF."""
    label = control.label_of(flow)
    control.previous_mark(here, label, ("if",), flow.keyword)
    if flow.keyword == "elseif":
        control.condition(flow)  # not asked for, but it must have a value: LinuxCNC computes it on the way
    return control.next_mark(here, label, ("endif",), "endif").after


def end_if(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Handle ENDIF."""
    control.previous_mark(here, control.label_of(flow), ("if",), "endif")
    return None


def begin_or_close_while(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Handle WHILE: the head of a loop, or the foot of one that DO began."""
    label = control.label_of(flow)
    control.claim(flow, label, here)
    holds = control.condition(flow)
    doing = control.calls.frame.doing
    if label in doing:
        if holds:
            return control.previous_mark(here, label, ("do",), "while").after
        doing.discard(label)
        return None
    return None if holds else control.next_mark(here, label, ("endwhile",), "endwhile").after


def end_while(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Handle ENDWHILE: back to WHILE."""
    return control.previous_mark(here, control.label_of(flow), ("while",), "endwhile").cursor


def begin_do(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Handle DO."""
    label = control.label_of(flow)
    control.claim(flow, label, here)
    control.calls.frame.doing.add(label)
    return None


def begin_repeat(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Handle REPEAT: keep how often."""
    label = control.label_of(flow)
    control.claim(flow, label, here)
    if goes_round(control.calls.frame.left, label, lambda: control.value_of(flow)):
        return None
    return control.next_mark(here, label, ("endrepeat",), "endrepeat").after


def goes_round(rounds: dict[Label, int], label: Label, times: Callable[[], float]) -> bool:
    """Tell whether REPEAT or ENDREPEAT begins another round; keep how many are left after it.

    A REPEAT that is met while it goes round, as CONTINUE of a loop around had left it, counts as the end of that round (seen on
    LinuxCNC's interpreter).
    """
    left = rounds[label] - 1 if label in rounds else nearest(times(), "the count of REPEAT")
    if left > 0:
        rounds[label] = left
        return True
    rounds.pop(label, None)
    return False


def end_repeat(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Handle ENDREPEAT: back behind REPEAT while rounds are left."""
    label = control.label_of(flow)
    start = control.previous_mark(here, label, ("repeat",), "endrepeat")
    return start.after if goes_round(control.calls.frame.left, label, lambda: 0.0) else None


def break_off(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Handle BREAK: behind the loop's end."""
    label = control.label_of(flow)
    mark = control.next_mark(here, label, _ENDS, LOOP_END)
    control.calls.frame.doing.discard(label)
    control.calls.frame.left.pop(label, None)
    return mark.after


def go_round(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Handle CONTINUE: to the loop's end."""
    return control.next_mark(here, control.label_of(flow), _ENDS, LOOP_END).cursor

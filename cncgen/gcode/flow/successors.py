"""The lines that O-words lead to, found once: for lines that run often, what cannot change is not looked up again.

`FlowControl.run` defines what an O-word does. A `Successor` is a function that gives the same result with the labels already
resolved. It exists for labels that are written (not computed) in texts where all labels are. Otherwise, and where a label has
no match, the successor calls `run` itself, so that a fault is reported when the line runs, not when it is read.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeGuard

from cncgen.gcode.block import Computed, Flow, Value
from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow import macros
from cncgen.gcode.flow.branches import goes_round
from cncgen.gcode.flow.calls import LOCALS
from cncgen.gcode.text import macro_loops
from cncgen.gcode.text.labels import LOOP_END

if TYPE_CHECKING:
    from cncgen.gcode.flow.o_words import FlowControl
    from cncgen.gcode.state.parameters import Parameters
    from cncgen.gcode.text.labels import Cursor, Label

Successor = Callable[[], "Cursor | None"]
#: O-words that a branch or loop begins with.
_OPENERS = ("if", "while", "do", "repeat")


def successor_of(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Successor:
    """Return what a line with an O-word does each time: it gives where to go on, or None for the next line."""
    make = _MAKERS.get(control.ip.dialect, {}).get(flow.keyword)
    if make is not None and _is_written(flow.label):
        try:
            if control.has_written_labels(here.source):
                if flow.keyword in _OPENERS:
                    control.claim(flow, flow.label, here)
                successor = make(control, flow, flow.label, here, after)
                if successor is not None:
                    return successor
        except BlockError:
            pass
    return lambda: control.run(flow, here, after)


def _is_written(label: Value | str | None) -> TypeGuard[Label]:
    """Tell whether a label is a name or a whole number."""
    return isinstance(label, str) or (isinstance(label, float) and label.is_integer())


def _computed(value: Value) -> Computed:
    """Return a value as a function, known or not."""
    return value if callable(value) else lambda p: value


def _settled(control: FlowControl, flow: Flow) -> Computed:
    """Return the condition of another line, which sees to it that the machine is where it says."""
    condition = _computed(flow.arguments[0])
    if not flow.asks_state:
        return condition

    def run(parameters: Parameters) -> float:
        control.flush()
        return condition(parameters)

    return run


def _to(target: Cursor | None) -> Successor:
    return lambda: target


def _if(control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor) -> Successor | None:
    """IF: the conditions of its ELSEIF lines are asked in turn."""
    from cncgen.gcode.text import grammar

    branches: list[tuple[Computed, Cursor]] = []
    mark = control.next_mark(here, label, ("elseif", "else", "endif"), "endif")
    while mark.keyword == "elseif":
        other = grammar.parse(control.text_of(mark), control.ip.dialect).flow
        if other is None or len(other.arguments) != 1:
            return None
        branches.append((_settled(control, other), mark.after))
        mark = control.next_mark(mark.cursor, label, ("elseif", "else", "endif"), "endif")
    if len(flow.arguments) != 1:
        return None
    parameters, condition, otherwise = control.ip.parameters, _computed(flow.arguments[0]), mark.after
    if not branches:
        return lambda: None if condition(parameters) else otherwise

    def successor() -> Cursor | None:
        if condition(parameters):
            return None
        for holds, target in branches:
            if holds(parameters):
                return target
        return otherwise

    return successor


def _leave_if(
    control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor
) -> Successor | None:
    """ELSE or ELSEIF at the end of the branch that was taken; the condition of the latter must have a value."""
    control.previous_mark(here, label, ("if",), flow.keyword)
    target = control.next_mark(here, label, ("endif",), "endif").after
    if flow.keyword == "else":
        return _to(target)
    if len(flow.arguments) != 1:
        return None
    parameters, condition = control.ip.parameters, _computed(flow.arguments[0])

    def successor() -> Cursor:
        condition(parameters)
        return target

    return successor


def _endif(control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor) -> Successor:
    control.previous_mark(here, label, ("if",), "endif")
    return _to(None)


def _while(control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor) -> Successor | None:
    """WHILE: the head of a loop with ENDWHILE, or the foot of one that DO begins."""
    if len(flow.arguments) != 1:
        return None
    parameters, condition = control.ip.parameters, _computed(flow.arguments[0])
    begin = control.find_previous(here, label, ("do",))
    if begin is None:
        end = control.next_mark(here, label, ("endwhile",), "endwhile").after
        return lambda: None if condition(parameters) else end
    start = begin.after

    def successor() -> Cursor | None:
        if label not in control.calls.frame.doing:
            return control.run(flow, here, after)
        if condition(parameters):
            return start
        control.calls.frame.doing.discard(label)
        return None

    return successor


def _endwhile(control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor) -> Successor:
    return _to(control.previous_mark(here, label, ("while",), "endwhile").cursor)


def _do(control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor) -> Successor:
    return lambda: control.calls.frame.doing.add(label)


def _repeat(control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor) -> Successor | None:
    if len(flow.arguments) != 1:
        return None
    end = control.next_mark(here, label, ("endrepeat",), "endrepeat").after
    parameters, times = control.ip.parameters, _computed(flow.arguments[0])

    def successor() -> Cursor | None:
        return None if goes_round(control.calls.frame.left, label, lambda: times(parameters)) else end

    return successor


def _endrepeat(control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor) -> Successor:
    start = control.previous_mark(here, label, ("repeat",), "endrepeat").after

    def successor() -> Cursor | None:
        left = control.calls.frame.left
        count = left.get(label, 0) - 1
        if count > 0:
            left[label] = count
            return start
        left.pop(label, None)
        return None

    return successor


def _break(control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor) -> Successor:
    end = control.next_mark(here, label, ("endwhile", "endrepeat", "while"), LOOP_END).after

    def successor() -> Cursor | None:
        control.calls.frame.doing.discard(label)
        control.calls.frame.left.pop(label, None)
        return end

    return successor


def _continue(control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor) -> Successor:
    return _to(control.next_mark(here, label, ("endwhile", "endrepeat", "while"), LOOP_END).cursor)


def _call(control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor) -> Successor | None:
    """CALL: the subroutine stays where it is; its arguments are computed each time."""
    arguments = [_computed(value) for value in flow.arguments]
    vacant = [0.0] * (LOCALS - len(arguments))
    if len(arguments) > LOCALS:
        return None
    target = control.subroutines.find(label, here).after
    parameters = control.ip.parameters

    def successor() -> Cursor | None:
        control.calls.enter(label, after, [value(parameters) for value in arguments] + vacant)
        return target

    return successor


def _leave(control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor) -> Successor | None:
    """ENDSUB and RETURN: back to the caller, where the call in progress is of this subroutine."""
    if len(flow.arguments) > 1:
        return None
    anywhere, arguments = flow.keyword == "return", flow.arguments

    def successor() -> Cursor | None:
        frames = control.calls.frames
        if frames and (anywhere or frames[-1].label == label):
            return control.calls.leave(arguments)
        return control.run(flow, here, after)

    return successor


def _goto(control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor) -> Successor | None:
    """GOTO of a macro, and IF … GOTO."""
    if isinstance(label, str):
        return None
    target = macros.line_numbered(control, here, macros.line_of(label))
    if not flow.arguments:
        return _to(target)
    parameters, condition = control.ip.parameters, _computed(flow.arguments[0])
    return lambda: target if condition(parameters) else None


def _while_do(control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor) -> Successor:
    end = macro_loops.end_of(control, flow, here)
    if not flow.arguments:
        return _to(None)
    parameters, condition = control.ip.parameters, _computed(flow.arguments[0])
    return lambda: None if condition(parameters) else end


def _end_do(control: FlowControl, flow: Flow, label: Label, here: Cursor, after: Cursor) -> Successor:
    return _to(macro_loops.begin_of(control, flow, here))


Maker = Callable[["FlowControl", Flow, "Label", "Cursor", "Cursor"], Successor | None]
_MAKERS: dict[str, dict[str, Maker]] = {
    "linuxcnc": {
        "if": _if,
        "elseif": _leave_if,
        "else": _leave_if,
        "endif": _endif,
        "while": _while,
        "endwhile": _endwhile,
        "do": _do,
        "repeat": _repeat,
        "endrepeat": _endrepeat,
        "break": _break,
        "continue": _continue,
        "call": _call,
        "endsub": _leave,
        "return": _leave,
    },
    "fanuc": {"goto": _goto, "while-do": _while_do, "end-do": _end_do},
}

"""O-words of subroutines: SUB ENDSUB, CALL, RETURN, and program numbers; M98, M99 and macro calls, which lead as they do.

Each O-word takes the flow control, the O-word, its line and the line behind it, and returns the place where to go on, None for the
next line.
"""

from __future__ import annotations

from cncgen.gcode.block import Flow, evaluate, program_names
from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow import macros, repeats
from cncgen.gcode.flow.calls import LOCALS
from cncgen.gcode.text.labels import Cursor, Label, shown
from cncgen.gcode.text.lanes import empty_block

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.block import Jump
    from cncgen.gcode.flow.o_words import FlowControl


def define(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Handle SUB: skip a definition."""
    label = control.label_of(flow)
    subroutines = control.subroutines
    labels = subroutines.labels(here.source)
    end = labels.next(here.offset, label, ("endsub",), subroutines.resolved, over_borders=True)
    if end is None:
        return _unclosed(control, label, here)
    first = labels.first(label, ("sub",), subroutines.resolved)
    if first is not None and first.cursor != here:
        message = f"subroutine o{shown(label)} is defined in line {first.cursor.line} already"
        control.ip.fault("oword-duplicate", message, "O", "give it another name")
        return end.after
    if labels.has_sub_between(here.offset, end.cursor.offset):
        hint = "close the outer one first; it may call the inner one all the same"
        control.ip.fault("oword-nested-sub", "a subroutine is defined within a subroutine", "O", hint)
    return end.after


def _unclosed(control: FlowControl, label: Label, here: Cursor) -> Cursor | None:
    """Report a definition without its end, and skip what another label's ENDSUB closes."""
    control.subroutines.unclosed.add(label)
    border = control.subroutines.labels(here.source).border(here.offset)
    end = border if border is not None and border.keyword == "endsub" else None
    hint = f"it must stand below, with the label o{shown(label)}"
    if end is not None:
        hint += f"; line {end.cursor.line} has the ENDSUB of another label"
    control.ip.fault("oword-unmatched", f"o{shown(label)} has no ENDSUB", "O", hint)
    return end.after if end is not None else None


def end_sub(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Handle ENDSUB: back to the caller."""
    label = control.label_of(flow)
    calls = control.calls
    # A computed label may have changed by the parameters that the subroutine has of its own.
    if not calls.frames or (calls.frame.label != label and not callable(flow.label)):
        message = f"o{shown(label)} ENDSUB with no SUB that was called"
        raise BlockError("oword-unmatched", message, "O", hint="SUB and ENDSUB have the same label")
    return calls.leave(flow.arguments)


def give_back(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Handle RETURN: back to the caller."""
    if not control.calls.frames:
        message = "RETURN stands outside a subroutine"
        raise BlockError("oword-unmatched", message, "O", hint="M2 or M30 end the main program")
    return control.calls.leave(flow.arguments)


def call(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Handle CALL: into the subroutine."""
    label = control.label_of(flow)
    if len(flow.arguments) > LOCALS:
        message = f"{len(flow.arguments)} arguments; a call takes {LOCALS}"
        hint = "pass more in global parameters: #<_name>, or #31 and above"
        raise BlockError("oword-arguments", message, "O", hint=hint)
    parameters = control.ip.parameters
    values = [value if isinstance(value, float) else evaluate(value, parameters) for value in flow.arguments]
    target = control.subroutines.find(label, here).after
    control.calls.enter(label, after, values + [0.0] * (LOCALS - len(values)))
    return target


def pass_program_number(control: FlowControl, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
    """Pass the number of a program; the next program of a file of several ends the main one."""
    if control.ip.dialect == "fanuc" and not control.calls.frames:
        if control.begun:
            control.ip.end_program()
        control.begun = True
    return None


def follow_jump(control: FlowControl, here: Cursor, after: Cursor) -> Cursor | None:
    """Execute the jump of a block with M97, M98, M99, G65, G66 or a cycle of lathes (`Interpreter.jump`)."""
    ip, calls = control.ip, control.calls
    assert ip.jump is not None
    jump, ip.jump = ip.jump, None
    if jump.kind == "past":
        last = macros.line_numbered(control, here, jump.number, "Q")
        return control.lines.after(last)
    if jump.kind == "line":
        target = macros.line_numbered(control, here, jump.number, "P")
        return None if repeats.waits(control, here, target, ip.parameters.untold, "M96") else target
    if jump.kind == "return":
        back = calls.leave() if calls.frames else None
        if jump.number > 0:
            target = macros.line_numbered(control, back or here, jump.number, "P")
            if back is None and repeats.repeats_for_ever(control, here, target):
                repeats.end_main(control, here, target, "M99")
                return None
            return target
        if back is not None:
            return back
        message = "M99 in the main program repeats it without end on a control; one pass is planned"
        ip.note("program-repeats", message, "M99", "M30 ends it")
        ip.end_program()
        return None
    values, ip.macro_values = ip.macro_values, None
    if jump.times < 1:
        return after
    if jump.kind == "lines":
        line = macros.line_numbered(control, here, jump.number, "P")
        calls.enter(float(jump.number), after, None).again = (line, jump.times - 1)
        return line
    try:
        target = _call_number(control, jump, here, after, values if jump.kind != "call" else None)
    except BlockError as error:
        if error.code != "sub-missing" or values is None:
            raise
        from cncgen.gcode.codes.probing import measures

        if not measures(ip, empty_block(here), jump.number, values):
            raise
        return after
    calls.frame.modal = jump.kind == "modal"
    return target


def _call_number(
    control: FlowControl, jump: Jump, here: Cursor, after: Cursor, values: list[float] | None
) -> Cursor:
    """Run the program of a jump with these local parameters (M98: those of the caller)."""
    number = jump.number
    label = float(number) if number >= 0 else program_names[-1 - number]
    try:
        target = control.subroutines.find(label, here, ("program", "sub"))
    except BlockError as error:
        error.word = "P"
        raise
    if target.keyword == "sub" and control.ip.dialect == "linuxcnc":
        hint = f"use o{number} CALL"
        raise BlockError("sub-kind", f"o{number} is a SUB, which M98 cannot run", "P", hint=hint)
    # Words may stand behind the number of a program.
    begin = target.cursor if target.keyword == "program" else target.after
    if jump.line >= 0:
        begin = macros.line_numbered(control, begin, jump.line, "Q")
    control.calls.enter(label, after, values).again = (begin, jump.times - 1)
    return begin

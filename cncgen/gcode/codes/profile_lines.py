"""The lines of a profile's subroutine in the order of their execution: branches and loops within it, and settings.

LinuxCNC's turning cycles run the subroutine of a profile as a call (seen with its interpreter); here its motions alone
matter, so that what decides on their order is done in this small executor.
"""

from __future__ import annotations

from collections.abc import Iterator

from cncgen.gcode.block import Flow, Parsed, nearest
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.text import grammar
from cncgen.gcode.text.expressions import evaluate
from cncgen.gcode.text.labels import Cursor, Label

#: Lines executed beyond which a profile counts as endless.
_MAX_STEPS = 20_000
#: Lines read for the end of a subroutine.
_MAX_LINES = 20_000
#: Local numbered parameters, #1 to #30.
_LOCALS = 30
_ENDS = ("endsub", "return")
_ALTERNATIVES = ("elseif", "else", "endif")
_LOOP_ENDS = ("endwhile", "while", "endrepeat")


def profile_lines(
    ip: Interpreter,
    after: Cursor,
    arguments: tuple[float, ...] = (),
    budget: Iterator[int] | None = None,
) -> Iterator[list[tuple[str, float]]]:
    """Yield the words of each line that a profile's subroutine executes, values computed; its locals are its own.

    Args:
        ip: The interpreter, whose parameters the lines read and set.
        after: The line behind the beginning of the subroutine.
        arguments: The arguments of the call.
        budget: As many lines are executed as it yields, those of subroutines called included.

    Raises:
        BlockError: A line is wrong, or an O-word leads nowhere.
        Astray: Calls nest too deep.
    """
    assert ip.flow is not None
    calls = ip.flow.calls
    calls.enter("", after, [*arguments, *[0.0] * (_LOCALS - len(arguments))][:_LOCALS])
    try:
        yield from _Body(ip, _read(ip, after), after, budget or iter(range(_MAX_STEPS))).run()
    finally:
        calls.leave()


def _read(ip: Interpreter, after: Cursor) -> list[Parsed]:
    """Return the lines up to ENDSUB."""
    assert ip.flow is not None
    text, offset = ip.flow.subroutines.sources[after.source], after.offset
    found: list[Parsed] = []
    while offset < len(text) and len(found) < _MAX_LINES:
        parsed = grammar.parse(text.text_at(offset), ip.dialect)
        if parsed.flow is not None and parsed.flow.keyword == "endsub":
            break
        found.append(parsed)
        offset = text.line_end(offset) + 1
    return found


class _Body:
    """The lines of a subroutine, and where loops under way began."""

    def __init__(self, ip: Interpreter, body: list[Parsed], here: Cursor, budget: Iterator[int]) -> None:
        self._ip = ip
        self._here = here
        self._budget = budget
        self._body = body
        #: Line where a DO, WHILE or REPEAT under way began, by label; rounds left of a REPEAT.
        self._began: dict[Label, int] = {}
        self._left: dict[Label, int] = {}

    def run(self) -> Iterator[list[tuple[str, float]]]:
        """Yield the words of the lines that are executed."""
        at = 0
        for _ in self._budget:
            if at >= len(self._body):
                return
            parsed = self._body[at]
            if parsed.flow is not None:
                if parsed.flow.keyword in _ENDS:
                    return
                if parsed.flow.keyword == "call":
                    yield from self._called(parsed.flow)
                    at += 1
                    continue
                at = self._follow(at, parsed.flow)
                continue
            words = [(letter, evaluate(value, self._ip.parameters)) for letter, value in parsed.words]
            self._set(parsed)
            yield words
            at += 1
        raise BlockError("profile-length", f"the profile executes more than {_MAX_STEPS} lines", "Q")

    def _set(self, parsed: Parsed) -> None:
        """Set the parameters of a line; all values are read before."""
        parameters = self._ip.parameters
        found = [
            (x if isinstance(x, str) else evaluate(x, parameters), evaluate(value, parameters))
            for x, value in parsed.settings
        ]
        for target, number in found:
            if isinstance(target, str):
                parameters.set_name(target, number)
            else:
                parameters.set_number(target, number)

    def _called(self, flow: Flow) -> Iterator[list[tuple[str, float]]]:
        """Yield the words of the lines of another subroutine."""
        ip = self._ip
        assert ip.flow is not None
        label = self._label(flow)
        mark = ip.flow.subroutines.find(label, self._here)
        values = tuple(evaluate(value, ip.parameters) for value in flow.arguments)
        yield from profile_lines(ip, mark.after, values, self._budget)

    def _label(self, flow: Flow) -> Label:
        label = flow.label
        if isinstance(label, str):
            return label
        return 0.0 if label is None else evaluate(label, self._ip.parameters)

    def _holds(self, flow: Flow) -> bool:
        """Tell whether a condition is true."""
        return bool(flow.arguments) and evaluate(flow.arguments[0], self._ip.parameters) != 0.0

    def _find(self, at: int, label: Label, keywords: tuple[str, ...]) -> int:
        """Return the next line of a label with one of some keywords."""
        for index in range(at + 1, len(self._body)):
            flow = self._body[index].flow
            if flow is not None and flow.keyword in keywords and self._label(flow) == label:
                return index
        name = f"o{label:g}" if isinstance(label, float) else f"o<{label}>"
        raise BlockError("profile-flow", f"{name} has no {' or '.join(k.upper() for k in keywords)}", "Q")

    def _follow(self, at: int, flow: Flow) -> int:
        """Return the line that follows an O-word."""
        label = self._label(flow)
        match flow.keyword:
            case "if":
                return self._branch(at, label)
            case "elseif" | "else":
                return self._find(at, label, ("endif",)) + 1
            case "endif":
                return at + 1
            case "do":
                self._began[label] = at
                return at + 1
            case "while":
                return self._while(at, flow, label)
            case "repeat":
                return self._repeat(at, flow, label)
            case "endwhile" | "endrepeat" if label in self._began:
                # Its beginning decides whether it goes on.
                return self._began[label]
            case "break" if label in self._began:
                self._began.pop(label)
                return self._find(at, label, _LOOP_ENDS) + 1
            case "continue" if label in self._began:
                return self._find(at, label, _LOOP_ENDS)
        message = f"{flow.keyword.upper()} in the subroutine of a profile leads nowhere"
        raise BlockError("profile-flow", message, "Q")

    def _branch(self, at: int, label: Label) -> int:
        """Return where IF leads: behind the first branch whose condition holds."""
        flow = self._body[at].flow
        while flow is not None and flow.keyword in ("if", "elseif") and not self._holds(flow):
            at = self._find(at, label, _ALTERNATIVES)
            flow = self._body[at].flow
        return at + 1

    def _while(self, at: int, flow: Flow, label: Label) -> int:
        """Return where WHILE leads, which begins a loop, or ends that of a DO."""
        began = self._began.get(label)
        first = self._body[began].flow if began is not None else None
        if began is not None and first is not None and first.keyword == "do":
            if self._holds(flow):
                return began + 1
            self._began.pop(label)
            return at + 1
        if self._holds(flow):
            self._began[label] = at
            return at + 1
        self._began.pop(label, None)
        return self._find(at, label, ("endwhile",)) + 1

    def _repeat(self, at: int, flow: Flow, label: Label) -> int:
        """Return where REPEAT leads, which counts down when its end leads back to it."""
        if label in self._began:
            self._left[label] -= 1
        else:
            times = evaluate(flow.arguments[0], self._ip.parameters) if flow.arguments else 0.0
            self._began[label], self._left[label] = at, nearest(times, "the count of REPEAT")
        if self._left[label] > 0:
            return at + 1
        self._began.pop(label)
        return self._find(at, label, ("endrepeat",)) + 1

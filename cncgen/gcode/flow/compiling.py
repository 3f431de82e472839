"""Parsed blocks as functions: what lines do that the kernel `gcode_run` leaves to the interpreter."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cncgen.gcode.block import Block, Flow, Parsed, Value, evaluate, gather
from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow.o_words import FlowControl
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.parameters import Parameters
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import empty_block

Action = Callable[[], None]
#: Codes of macro calls, the first M code that a builder may give a macro, and the first number of the macros of builders.
_CALLS, _OF_BUILDERS, _BUILT = (65.0, 66.0), 100.0, 9000.0


class Compiler:
    """Makes actions of parsed blocks; `execute` runs a block whose values are known."""

    def __init__(self, ip: Interpreter, flow: FlowControl, execute: Callable[[Block], None]) -> None:
        self.ip = ip
        self.flow = flow
        self.execute = execute
        self.fanuc = ip.dialect == "fanuc"

    def action(self, parsed: Parsed, cursor: Cursor) -> Action:
        """Return the function of a block without flow: compute its values, set its parameters, execute it.

        All values are read before any parameter changes.
        """
        if self.fanuc:
            macro = self._macro(parsed, cursor)
            if macro is not None:
                return macro
        comment = parsed.comments[-1] if parsed.comments else None
        parameters = self.ip.parameters

        def run() -> None:
            pairs = [(letter, evaluated(letter, value, parameters)) for letter, value in parsed.words]
            settings = [
                (
                    target if isinstance(target, str) else evaluate(target, parameters),
                    evaluated("#", value, parameters),
                )
                for target, value in parsed.settings
            ]
            if self.fanuc:
                # A word with a vacant value counts as not written.
                pairs = [(letter, value) for letter, value in pairs if value == value]
            block = gather(pairs)
            block.source, block.offset, block.line = cursor
            block.comment = comment
            for target, number in settings:
                if isinstance(target, str):
                    parameters.set_name(target, number)
                else:
                    parameters.set_number(target, number)
            self.execute(block)

        return run

    def then(self, flow: Flow, cursor: Cursor) -> Action:
        """Return what IF [...] THEN ... does."""
        assert flow.then is not None
        run = self.action(flow.then, cursor)
        return lambda: run() if self.flow.condition(flow) else None

    # Macros of FANUC.

    def _macro(self, parsed: Parsed, cursor: Cursor) -> Action | None:
        """Return what a macro call (G65, G66) or a setting of #3000 or #3006 does; None for other blocks."""
        ip, parameters = self.ip, self.ip.parameters
        if _called(parsed.words):

            def call() -> None:
                pairs = [(x, evaluated(x, value, parameters)) for x, value in parsed.words]
                self.call_macro(pairs, cursor)

            return call
        if len(parsed.settings) == 1 and parsed.settings[0][0] in (3000.0, 3006.0):
            from cncgen.gcode.flow import macros

            target, value = parsed.settings[0]
            effect = macros.alarm if target == 3000.0 else macros.message

            def raise_it() -> None:
                ip.sink.block = empty_block(cursor)
                effect(ip, evaluate(value, parameters), (parsed.comments or [""])[-1])

            return raise_it
        return None

    def call_macro(self, pairs: list[tuple[str, float]], cursor: Cursor) -> bool:
        """Ask for the macro that G65 or G66 names; tell whether the block is such a call."""
        code = _called(pairs)
        if not code:
            return False
        from cncgen.gcode.flow import macros

        self.ip.base.block = empty_block(cursor)
        if code == "m":
            pairs = macros.by_m_code(self.ip, pairs)
        number, times, values = macros.arguments([pair for pair in pairs if pair[1] == pair[1]])
        if code == "g66":
            self.ip.modal_macros.append((number, times, values))
        else:
            self.ip.jump, self.ip.macro_values = ("macro", number, times), values
        return True


def _called(pairs: Sequence[tuple[str, Value]]) -> str:
    """Return by which code a block calls a macro: ``g65``, ``g66``, ``m`` (an M code of the builder, to a probe's program), or ""."""
    by_m = False
    for letter, value in pairs:
        if letter == "g" and value in _CALLS:
            return f"g{value:g}"
        by_m = by_m or (letter == "m" and isinstance(value, float) and value >= _OF_BUILDERS)
    if not by_m or not any(
        letter == "p" and isinstance(value, float) and value >= _BUILT for letter, value in pairs
    ):
        return ""
    from cncgen.gcode.codes.probing import MEASURING

    return "m" if any(letter == "p" and value in MEASURING for letter, value in pairs) else ""


def evaluated(letter: str, value: Value, parameters: Parameters) -> float:
    """Return the number of a word; its faults point at the word."""
    try:
        return evaluate(value, parameters)
    except BlockError as error:
        error.word = error.word or letter.upper()
        raise

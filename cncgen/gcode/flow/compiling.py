"""Parsed blocks as functions, for lines that run more than once, so that facts known when the line is read are computed only once."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cncgen.gcode.block import LARGEST, Block, Computed, Flow, Parsed, Value, evaluate, gather
from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow.o_words import FlowControl
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.parameters import Parameters
from cncgen.gcode.state.predefined import NAMED
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import empty_block
from cncgen.records import replace

Action = Callable[[], None]
#: Codes of macro calls, the first M code that a builder may give a macro, and the first number of the macros of builders.
_CALLS, _OF_BUILDERS, _BUILT = (65.0, 66.0), 100.0, 9000.0
#: Numbered parameters below this are plain storage.
_STORED = 1000


class Compiler:
    """Makes actions of parsed blocks; `execute` runs a block whose values are known."""

    def __init__(self, ip: Interpreter, flow: FlowControl, execute: Callable[[Block], None]) -> None:
        self.ip = ip
        self.flow = flow
        self.execute = execute
        self.fanuc = ip.dialect == "fanuc"

    def action(self, parsed: Parsed, cursor: Cursor) -> Action:
        """Return the function of a block without flow: compute its values, set its parameters, execute it."""
        if self.fanuc:
            macro = self._macro(parsed, cursor)
            if macro is not None:
                return macro
        comment = parsed.comments[-1] if parsed.comments else None
        if not parsed.words and comment is None and len(parsed.settings) == 1:
            return self._setting(*parsed.settings[0])
        if parsed.settings or self.fanuc or _has_computed_code(parsed):
            return self._general(parsed, cursor, comment)
        fixed = gather(
            [(letter, value if isinstance(value, float) else 0.0) for letter, value in parsed.words]
        )
        fixed.source, fixed.offset, fixed.line = cursor
        fixed.comment = comment
        computed = [(letter, value) for letter, value in parsed.words if not isinstance(value, float)]
        if not computed:
            return self._known(fixed)
        return self._words(fixed, computed)

    def _known(self, block: Block) -> Action:
        """Return an action of a block whose values are all known."""
        execute = self.execute
        if any(row.group == "diameter" for row in self.ip.codes.of(block)):
            # These change the block's own X.
            return lambda: execute(replace(block, words=block.words.copy()))
        return lambda: execute(block)

    def _words(self, fixed: Block, computed: list[tuple[str, Callable[[Parameters], float]]]) -> Action:
        """Return an action of a block of which some words are computed (`fixed` holds the others)."""
        parameters, execute = self.ip.parameters, self.execute
        others = fixed.g, fixed.m, fixed.comment, fixed.source, fixed.line, fixed.offset

        def run() -> None:
            words = fixed.words.copy()
            letter = ""
            try:
                for letter, value in computed:
                    number = words[letter] = value(parameters)
                    if not -LARGEST <= number <= LARGEST:
                        # The check that `gather` makes of known values, with its message.
                        gather([(letter, number)])
            except BlockError as error:
                raise _at(error, letter.upper()) from None
            execute(Block(words, *others))

        return run

    def _general(self, parsed: Parsed, cursor: Cursor, comment: str | None) -> Action:
        """Return an action of any block: all values are read before any parameter changes."""
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

    def _setting(self, target: Value | str, value: Value) -> Action:
        """Return an action that sets one parameter."""
        parameters = self.ip.parameters
        computed = value if callable(value) else _constant(value)
        if isinstance(target, str):
            if target in NAMED:
                return lambda: parameters.set_name(target, evaluated("#", value, parameters))
            everywhere = target.startswith("_")

            def name() -> None:
                try:
                    number = computed(parameters)
                except BlockError as error:
                    raise _at(error, "#") from None
                (parameters.named if everywhere else parameters.local)[target] = number

            return name
        if isinstance(target, float) and target.is_integer() and 0 < target < _STORED:
            index = int(target)

            def store() -> None:
                try:
                    parameters.numbers[index] = computed(parameters)
                except BlockError as error:
                    raise _at(error, "#") from None

            return store
        return lambda: parameters.set_number(evaluate(target, parameters), evaluated("#", value, parameters))

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

        if code == "m":
            self.ip.base.block = empty_block(cursor)
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


def _has_computed_code(parsed: Parsed) -> bool:
    """Tell whether a G or M number is computed."""
    return any(letter in "gm" and not isinstance(value, float) for letter, value in parsed.words)


def _constant(value: float) -> Computed:
    return lambda parameters: value


def _at(error: BlockError, word: str) -> BlockError:
    """Return the fault of a value that belongs to a word of the block."""
    error.word = error.word or word
    return error


def evaluated(letter: str, value: Value, parameters: Parameters) -> float:
    """Return the number of a word; its faults point at the word."""
    try:
        return evaluate(value, parameters)
    except BlockError as error:
        raise _at(error, letter.upper()) from None

"""Parsed lines, run one by one through the interpreter: those that kernels leave to it, and those of profiles."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cncgen.gcode.block import Block, Flow, Jump, Parsed, Value, evaluate, gather
from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow.o_words import FlowControl
from cncgen.gcode.state.parameters import Parameters
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import empty_block

#: Codes of macro calls, the first M code that a builder may give a macro, and the first number of the macros of builders.
_CALLS, _OF_BUILDERS, _BUILT = (65.0, 66.0), 100.0, 9000.0
#: Variables of FANUC that stop the program with an alarm or a message.
_ALARM, _MESSAGE = 3000.0, 3006.0
#: Variables without a value that are told.
_MAX_TOLD = 10


class LineRunner:
    """Runs lines; `execute` takes the blocks, whose values are known."""

    def __init__(self, control: FlowControl, execute: Callable[[Block], None]) -> None:
        self.control, self.ip = control, control.ip
        self.execute = execute
        self.fanuc = control.ip.dialect == "fanuc"

    def run(self, parsed: Parsed, here: Cursor, after: Cursor) -> Cursor | None:
        """Run a line, `after` which another stands; return where it leads, None for the next line."""
        control, flow = self.control, parsed.flow
        if parsed.deletable and control.ip.options.block_delete:
            return None
        if parsed.is_o_word:
            return self._o_word(flow, here, after)
        if flow is not None and flow.then is not None and flow.keyword == "while-do":
            past = self._o_word(flow, here, after)
            return self.run(flow.then, here, after) if past is None else past
        # Settings before a jump, or words behind the number of a program (FANUC).
        jumps = flow is not None and flow.keyword == "goto"
        if jumps and parsed.words:
            message = "GOTO stands beside words"
            raise BlockError("unsupported-flow", message, "GOTO", hint="give it a line of its own")
        if flow is not None and flow.then is None and not jumps:
            self._o_word(flow, here, after)
        control.calls.flush()
        # Remarks on what a line reads are of that line.
        control.ip.base.block = empty_block(here)
        if flow is None or parsed.words or parsed.settings or parsed.comments:
            self._act(parsed, here)
        if flow is not None and flow.then is not None and control.condition(flow):
            self._act(flow.then, here)
        if jumps:
            return self._o_word(flow, here, after)
        return control.follow_jump(here, after) if control.ip.jump is not None else None

    def _o_word(self, flow: Flow | None, here: Cursor, after: Cursor) -> Cursor | None:
        """Execute an O-word, behind the blocks that wait: its values may depend on where the machine is."""
        assert flow is not None
        self.control.calls.flush()
        self.ip.base.block = empty_block(here)
        return self.control.run(flow, here, after)

    def _act(self, parsed: Parsed, here: Cursor) -> None:
        """Compute the values of a block, set its parameters, execute it: all values are read before any parameter changes."""
        parameters = self.ip.parameters
        parameters.unset = 0
        pairs = [(letter, evaluated(letter, value, parameters)) for letter, value in parsed.words]
        unset = parameters.unset
        settings = [
            (
                target if isinstance(target, str) else evaluate(target, parameters),
                evaluated("#", value, parameters),
            )
            for target, value in parsed.settings
        ]
        comment = parsed.comments[-1] if parsed.comments else None
        for target, number in settings:
            if isinstance(target, str):
                parameters.set_name(target, number)
            elif self.fanuc and target in (_ALARM, _MESSAGE):
                self._stop(target, number, comment, here)
                comment = None
            else:
                parameters.set_number(target, number)
        if self.fanuc:
            if self.call_macro(pairs, here):
                return
            if unset:
                self._tell_unset(f"#{unset}", here)
            # A word with a vacant value counts as not written.
            pairs = [(letter, value) for letter, value in pairs if value == value]
        if pairs or comment is not None:
            twice: list[str] | None = [] if self.fanuc else None
            block = gather(pairs, twice)
            block.source, block.offset, block.line = here
            block.comment = comment
            if twice:
                self.tell_twice(block, twice)
            self.execute(block)

    # Words and macros of FANUC.

    def tell_twice(self, block: Block, letters: list[str]) -> None:
        """Warn of letters that stand twice in a block: the last counts where parameter 3403#6 is 0."""
        self.ip.base.block = block
        for letter in dict.fromkeys(letters):
            name = letter.upper()
            message = f"{name} stands twice in one block: the last counts, {name}{block.words[letter]:g}"
            self.ip.warn(
                "repeated-word",
                message,
                name,
                "write it once: where parameter 3403#6 is 1, a control refuses it",
            )

    def _tell_unset(self, name: str, here: Cursor) -> None:
        """Remark that a word reads a common variable that nothing has set, once of each: on a control it may have a value of before."""
        told = self.ip.parameters.unset_told
        if name in told or len(told) >= _MAX_TOLD:
            return
        told.add(name)
        self.ip.sink.block = empty_block(here)
        message = f"nothing has set {name} when this block runs: a word that takes it alone is left out, and a formula counts it as 0"
        hint = "--parameters gives it the value that it has on the machine"
        self.ip.note("variable-assumed", message, name, hint)

    def _stop(self, target: float, value: float, text: str | None, here: Cursor) -> None:
        """Do what a setting of #3000 or #3006 does."""
        from cncgen.gcode.flow import macros

        self.ip.sink.block = empty_block(here)
        (macros.alarm if target == _ALARM else macros.message)(self.ip, value, text or "")

    def call_macro(self, pairs: list[tuple[str, float]], here: Cursor) -> bool:
        """Ask for the macro that G65 or G66 names; tell whether the block is such a call."""
        code = _called(pairs)
        if not code:
            return False
        from cncgen.gcode.flow import macros

        self.ip.base.block = empty_block(here)
        if code == "m":
            pairs = macros.by_m_code(self.ip, pairs)
        else:
            ahead, pairs = macros.apart(pairs, float(code[1:]))
            if ahead:
                block = gather(ahead)
                block.source, block.offset, block.line = here
                self.execute(block)
        number, times, values = macros.arguments(self.ip, [pair for pair in pairs if pair[1] == pair[1]])
        macros.tell_idle(self.ip, times)
        if code == "g66":
            self.ip.modal_macros.append((number, times, values))
        else:
            self.ip.jump, self.ip.macro_values = Jump("macro", number, times), values
        return True


def _called(pairs: Sequence[tuple[str, float]]) -> str:
    """Return by which code a block calls a macro: ``g65``, ``g66``, ``m`` (an M code of the builder, to a probe's program), or ""."""
    by_m = False
    for letter, value in pairs:
        if letter == "g" and value in _CALLS:
            return f"g{value:g}"
        by_m = by_m or (letter == "m" and value >= _OF_BUILDERS)
    if not by_m or not any(letter == "p" and value >= _BUILT for letter, value in pairs):
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

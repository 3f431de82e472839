"""The lane of recursive descent: one block of text to `Parsed`, as the grammar reads it, ten times faster and at once.

The grammar (`grammars/gcode.lark`) is the language, and names what is wrong with a block; building its parser takes
longer than reading a thousand lines. This reader knows the same rules, function by function under their names there,
and judges nothing: at the first character that it does not expect it declines, and the grammar reads the block.
"""

from __future__ import annotations

import re

from cncgen.gcode.block import Flow, Parsed, Value
from cncgen.gcode.errors import BlockError
from cncgen.gcode.state.predefined import asks_state
from cncgen.gcode.text import expressions, grammar

_LINE_NUMBER = re.compile(r"n([0-9]+(?:\.[0-9]*)?)")
_NUMBER = re.compile(r"[0-9]+\.?[0-9]*|\.[0-9]+")
_WORD = re.compile(r"([a-mp-z@^$])([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))")
_COMMENT = re.compile(r"\(([^()\n]*)\)|;([^\n]*)")
_NAME = re.compile(r"<([^>\n]*)>")
_LABEL = re.compile(r"<[^>\n]*>|[0-9]+")
_FUNCTION = re.compile(r"(abs|acos|asin|cos|exp|fix|fup|ln|round|sin|sqrt|tan|bin|bcd|sqr|rnd)\[")
_ARC_TANGENT = re.compile(r"atan\[|atn\[")
_OPERATOR = re.compile(r"and|xor|or|eq|ne|gt|ge|lt|le|mod|\*\*|[*/+-]")
_KEYWORD = re.compile(
    "endsub|sub|call|return|elseif|else|endif|if|endwhile|while|do|endrepeat|repeat|break|continue"
)
_MACRO = re.compile("if|goto|while|do|end")
_NAMED = re.compile("bspline|(?:pw|pl|sd)=")
_LETTERS = frozenset("abcdefghijklmpqrstuvwxyz@^$")
#: How tight operators bind.
_LEVELS = {
    **dict.fromkeys(("and", "or", "xor"), 1),
    **dict.fromkeys(("eq", "ne", "gt", "ge", "lt", "le"), 2),
    **dict.fromkeys("+-", 3),
    **dict.fromkeys(("*", "/", "mod"), 4),
    "**": 5,
}


class _Declined(Exception):
    """The block is not for this reader."""


def parse(text: str, dialect: str = "linuxcnc", increments: bool = False) -> Parsed:
    """Read one block; see `grammar.parse`, which reads it where this lane declines.

    Raises:
        BlockError: Where it is no block; the column is that of `text`.
    """
    output = grammar.output_command(text) if dialect == "fanuc" else None
    if output is not None:
        return output
    bare = grammar.normalise(text)
    grammar.check_nesting(text, bare)
    try:
        return _Reader(bare, dialect == "fanuc", increments).start()
    except (_Declined, BlockError):
        return grammar.parse(text, dialect, increments)


class _Reader:
    """A place in a normalised block; each method reads one rule of the grammar from there on."""

    __slots__ = ("arithmetic", "asks_state", "at", "end", "fanuc", "increments", "text")

    def __init__(self, bare: str, fanuc: bool, increments: bool) -> None:
        # No block holds a newline: it stands for the end.
        self.text = bare + "\n"
        self.end = len(bare)
        self.at = 0
        self.fanuc = fanuc
        self.increments = increments
        self.arithmetic = expressions.FANUC if fanuc else expressions.LINUXCNC
        #: Whether a value that was read may tell the machine's state.
        self.asks_state = False

    def start(self) -> Parsed:
        parsed = Parsed(deletable=self._is_deleted())
        number = _LINE_NUMBER.match(self.text, self.at)
        if number:
            parsed.number = number[1]
            self.at = number.end()
            if self.fanuc and self._is_deleted():
                parsed.deletable = True
        if self.text[self.at] == "o" or (self.fanuc and self.text[self.at] in ":<"):
            self._o_word(parsed)
        elif _MACRO.match(self.text, self.at):
            parsed.flow = self._macro()
        if parsed.flow is None:
            self._items(parsed)
        else:
            while self.at < self.end:
                parsed.comments += self._comment()
        return parsed

    def _is_deleted(self) -> bool:
        """Tell whether a / comes here, and go by it (FANUC: and by its number)."""
        if self.text[self.at] != "/":
            return False
        self.at += 2 if self.fanuc and self.text[self.at + 1] in "123456789" else 1
        return True

    def _items(self, parsed: Parsed) -> None:
        text, end = self.text, self.end
        while self.at < end:
            word = _WORD.match(text, self.at)
            if word:
                letter = word[1]
                parsed.words.append((letter, grammar.word_value(letter, word[2], self.increments)))
                self.at = word.end()
                continue
            character = text[self.at]
            if character == "#":
                self.at += 1
                target = self._target()
                self._expect("=")
                parsed.settings.append((target, self._expression() if self.fanuc else self._signed()))
            elif character in "(;":
                parsed.comments += self._comment()
            elif self.fanuc and text.startswith((",c", ",r"), self.at):
                self.at += 2
                parsed.words.append((text[self.at - 2 : self.at], self._signed()))
            elif character in _LETTERS and not _NAMED.match(text, self.at):
                self.at += 1
                parsed.words.append((character, self._signed()))
            else:
                raise _Declined

    def _comment(self) -> list[str]:
        """Read a comment; one behind a semicolon is never passed on."""
        comment = _COMMENT.match(self.text, self.at)
        if not comment:
            raise _Declined
        self.at = comment.end()
        return [comment[1]] if comment[2] is None else []

    def _expect(self, character: str) -> None:
        if not self.text.startswith(character, self.at):
            raise _Declined
        self.at += len(character)

    # Values.

    def _signed(self) -> Value:
        negative = False
        while self.text[self.at] in "+-":
            negative ^= self.text[self.at] == "-"
            self.at += 1
        value = self._value()
        return expressions.negative(value) if negative else value

    def _value(self) -> Value:
        character = self.text[self.at]
        if character == "#":
            self.at += 1
            target = self._target()
            self.asks_state = self.asks_state or asks_state(target)
            return expressions.parameter(target)
        if character == "[":
            return self._bracket()
        number = _NUMBER.match(self.text, self.at)
        if number:
            self.at = number.end()
            return float(number[0])
        function = _FUNCTION.match(self.text, self.at)
        if function:
            self.at = function.end() - 1
            return expressions.unary(function[1], self._bracket(), self.arithmetic)
        arc_tangent = _ARC_TANGENT.match(self.text, self.at)
        if arc_tangent:
            return self._arc_tangent(arc_tangent[0])
        if self.fanuc and self.text.startswith("pow[", self.at):
            return self._power()
        return self._exists()

    def _target(self) -> Value | str:
        name = _NAME.match(self.text, self.at)
        if name:
            self.at = name.end()
            return name[1]
        if self.text[self.at] not in "#[.0123456789":
            raise _Declined
        return self._value()

    def _bracket(self) -> Value:
        self._expect("[")
        value = self._expression()
        self._expect("]")
        return value

    def _power(self) -> Value:
        self._expect("pow[")
        base = self._expression()
        self._expect(",")
        exponent = self._expression()
        self._expect("]")
        return expressions.binary("**", base, exponent, self.arithmetic)

    def _arc_tangent(self, name: str) -> Value:
        if name == "atn[" and not self.fanuc:
            raise _Declined
        self._expect(name)
        y = self._expression()
        x: Value | None
        if self.text[self.at] == ",":
            self.at += 1
            x = self._expression()
            self._expect("]")
        else:
            self._expect("]")
            x = None
            if self.text.startswith("/[", self.at):
                self.at += 1
                x = self._bracket()
        return expressions.arc_tangent(y, x, self.arithmetic)

    def _exists(self) -> Value:
        self._expect("exists[#")
        value = expressions.exists(self._target())
        self._expect("]")
        return value

    def _expression(self) -> Value:
        """Read operands and operators up to what is neither; all levels of binding in one pass with two stacks."""
        values = [self._signed()]
        waiting: list[str] = []
        operator = _OPERATOR.match(self.text, self.at)
        while operator:
            name = operator[0]
            level = _LEVELS[name]
            while waiting and _LEVELS[waiting[-1]] >= level:
                self._join(values, waiting.pop())
            waiting.append(name)
            self.at = operator.end()
            values.append(self._signed())
            operator = _OPERATOR.match(self.text, self.at)
        while waiting:
            self._join(values, waiting.pop())
        return values[0]

    def _join(self, values: list[Value], name: str) -> None:
        right = values.pop()
        values[-1] = expressions.binary(name, values[-1], right, self.arithmetic)

    # Order of execution.

    def _o_word(self, parsed: Parsed) -> None:
        # Newer controls write the name of a program without the O.
        self.at += self.text[self.at] != "<"
        label: Value | str
        written = _LABEL.match(self.text, self.at)
        if written:
            label = grammar.o_label(written[0])
            self.at = written.end()
        else:
            label = self._value()
        keyword = _KEYWORD.match(self.text, self.at)
        if not keyword:
            parsed.flow = Flow("program", label)
            return
        self.at = keyword.end()
        arguments = []
        while self.at < self.end:
            if self.text[self.at] == "[":
                arguments.append(self._bracket())
            else:
                parsed.comments += self._comment()
        parsed.flow = Flow(keyword[0], label, tuple(arguments), asks_state=self.asks_state)

    def _macro(self) -> Flow:
        keyword = _MACRO.match(self.text, self.at)
        assert keyword
        self.at = keyword.end()
        name = keyword[0]
        if name == "goto":
            return Flow("goto", self._signed())
        if name in ("do", "end"):
            return Flow("while-do" if name == "do" else "end-do", self._loop_number())
        condition = self._bracket()
        if name == "while":
            self._expect("do")
            return Flow("while-do", self._loop_number(), (condition,))
        if self.text.startswith("goto", self.at):
            self.at += len("goto")
            return Flow("goto", self._signed(), (condition,))
        self._expect("then")
        then = Parsed()
        self._items(then)
        return Flow("then", None, (condition,), then)

    def _loop_number(self) -> float:
        number = _NUMBER.match(self.text, self.at)
        if not number:
            raise _Declined
        self.at = number.end()
        return float(number[0])

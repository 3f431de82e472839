"""One line of SINUMERIK to a statement, by the tables of its grammar (``grammars/sinumerik.lark``)."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache, partial
from importlib import import_module
from typing import Any

from cncgen.gcode.errors import BlockError
from cncgen.gcode.sinumerik import expressions
from cncgen.gcode.sinumerik.expressions import Chain, Function, RParameter, Value
from cncgen.gcode.text.syntax_errors import Language, refusal
from cncgen.kernels.grammar_values import Reader

#: ("word", letter, number), ("assign", index of R, value), ("set", name, indices, value), ("poly", target, values),
#: ("call", name, values), ("name", name), ("text", string).
Item = tuple[Any, ...]

_OPERATOR = ("TIMES", "SIGN", "__ANON_0", "COLON", "OR", "XOR", "AND", "B_OR", "B_XOR", "B_AND")
_COMMANDS = (
    "IF", "ELSE", "ENDIF", "LOOP", "ENDLOOP", "FOR", "ENDFOR", "WHILE", "ENDWHILE", "REPEAT", "UNTIL", "REPEATB", "_CALL_BLOCK", "_SCC",
    "CASE", "DEF", "PROC", "EXTERN", "SYNCHRONOUS",
)  # fmt: skip
_LANGUAGE = Language(
    names={
        "PLAIN": "a word", "ADDRESS": "a word", "NAME": "a name", "PLAIN_NUMBER": "a number", "EXPONENT": "a number",
        "STRING": "a text", "RELATION": "a comparison", "GOTO": "a jump", "GOTOS": "a jump", "TYPE": "a type", "LABEL": "a label",
        "BLOCK_NUMBER": "a block number", "HEADER": "a program's head", "DELETE": "/", "NOT": "an operator", "B_NOT": "an operator",
        **dict.fromkeys(_OPERATOR, "an operator"), **dict.fromkeys(_COMMANDS, "a command"),
    },
    hint="a block of SINUMERIK is words (G1 X10), settings (X=R1*2, CR=5) and calls (CYCLE81(...))",
)  # fmt: skip
_COMPARISONS = ("==", "<", ">")
#: M functions beyond 10 that end programs, turn the spindle to a place or make it an axis.
_NO_OUTPUTS = (17, 19, 30, 70)


@dataclass(slots=True)
class Statement:
    """A line: its kind (``block``, ``if``, ``for`` …), its data, and the parts before its block.

    Attributes:
        items: Of a block.
        number: Text of its block number (``N10``), or "".
        label: Name before a colon, or "".
        deletable: Whether it begins with ``/``.
    """

    kind: str = "block"
    items: list[Item] = field(default_factory=list)
    data: tuple[Any, ...] = ()
    number: str = ""
    label: str = ""
    deletable: bool = False


def parse(text: str) -> Statement:
    """Read one line; raise where it does not belong to the language; the column counts in `text`."""
    reader = _reader()
    statement: Statement | None = reader.parse(text)
    if statement is None:
        relation = text.startswith(_COMPARISONS, reader.error)
        hint = "AND and OR bind before comparisons: IF (R1==1) AND (R2==2)" if relation else ""
        raise refusal(text, reader.error, reader.expected(), _LANGUAGE, hint)
    if statement.kind == "synchronous" and not _outputs_alone(statement.data[0]):
        message = "a synchronous action, which acts while other blocks move, is not read"
        hint = "leave it out, or write what it does as blocks"
        raise BlockError("not-read", message, column=text.index(statement.data[0]) + 1, hint=hint)
    return statement


def _outputs_alone(action: str) -> bool:
    """Tell whether a synchronous action does no more than to send outputs and M functions that start no spindle and change no tool."""
    import re

    output = r"\$A_OUTA?\[[^\]]*\][ \t]*=[ \t]*\S+|H[ \t]*=?[ \t]*\d+|M[ \t]*=?[ \t]*(\d+)(?![\d=])"
    done = re.split(r"\bDO\b", action.split(";")[0].upper())[-1]
    functions = [int(one[1]) for one in re.finditer(output, done) if one[1]]
    quiet = all(7 <= m <= 9 or (m > 10 and m not in _NO_OUTPUTS) for m in functions)
    return quiet and bool(done.strip()) and not re.sub(output, "", done).strip()


def _line(delete: str | None, number: str | None, label: str | None, found: Item | None) -> Statement:
    kind, *data = found or ("block", [])
    items = data.pop() if kind in ("block", "assign") else []
    name = label.rstrip(": \t").upper() if label else ""
    return Statement(
        kind, items, tuple(data), _name(number).replace(":", "N") if number else "", name, delete is not None
    )


def _name(text: str) -> str:
    """Return a name in capitals; blanks may stand before its number (840D, Fundamentals, 2.2, "Variable identifiers")."""
    return "".join(text.upper().split())


def _header(text: str) -> Statement:
    """Return the statement of ``%_N_NAME_MPF`` or ``%NAME_MPF``, whose data is the name."""
    name = text.upper().removeprefix("%").removeprefix("_N_")
    ends = [at for suffix in ("_MPF", "_SPF") if (at := name.find(suffix)) > 0]
    return Statement("header", data=(name[: min(ends)],) if ends else ("",))


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float(text.upper().replace("EX", "E"))
    return expressions.number(value, "a number")


def _text(text: str) -> str:
    return text[1:-1]


def _constant(text: str) -> Value:
    """Return a text, or the number of a hexadecimal or binary constant: 'HFF', 'B101'."""
    inner = _text(text).upper()
    if text[0] == "'":
        for letter, base in (("H", 16), ("B", 2)):
            if inner[:1] == letter and len(inner) > 1:
                with suppress(ValueError):
                    whole = int(inner[1:], base)
                    # A double has 1024 bits before its point at most.
                    value = float(whole) if whole.bit_length() < 1024 else math.inf
                    return expressions.number(value, "a constant")
    return expressions.Quoted(_text(text))


def _block(*items: Item) -> Item:
    """Return a block; one of R parameters alone has a kind of its own."""
    return ("assign" if all(item[0] == "assign" for item in items) else "block", list(items))


def _word(word: str) -> Item:
    """Return a word; L with leading zeros is the name of a subprogram: "L123, L0123 and L00123 are three" (840D sl, Job planning,
    "Subprogram call without parameter transfer")."""
    letter, digits = word[0].upper(), word[1:].strip()
    if letter == "L" and digits[:1] == "0" and digits.isdigit() and len(digits) > 1:
        return ("name", letter + digits)
    return ("word", letter, float(digits))


def _setting(target: tuple[str, tuple[Value, ...]], value: Value) -> Item:
    """Return a setting, of a known R parameter or of a name that the run looks up."""
    where = expressions.variable(*target)
    if isinstance(where, RParameter) and not isinstance(value, Function | Chain):
        return ("assign", where.index, value)
    return ("set", *target, value)


def _given(children: tuple[Any, ...]) -> tuple[Any, ...]:
    return tuple(child for child in children if child is not None)


def _jump(goto: str, target: str) -> Item:
    """Return a jump; the number of a block may stand without its N ("e.g.: 200, N300", 840D sl, Fundamentals, "Jumps to jump markers")."""
    number = "N" if target[0].isdigit() else ""
    return ("jump", goto.upper(), number + _name(target.strip("\"'")))


def _computed_jump(goto: str, first: str, *parts: Value) -> Item:
    label: Value = expressions.Quoted(_text(first))
    for part in parts:
        label = expressions.binary("<<", label, part)
    return ("jump", goto.upper(), label)


def _repeat_part(*children: Any) -> Item:
    *labels, times = children
    return ("repeat-part", tuple(label.upper() for label in labels if label), 1.0 if times is None else times)


#: Rules that are one word.
_ALONE = ("else_", "endif", "loop", "endloop", "endfor", "endwhile", "repeat")
_OPERATORS = {"join": "<<", "both": "AND", "or_": "OR", "xor": "XOR", "bit_and": "B_AND", "bit_or": "B_OR", "bit_xor": "B_XOR"}  # fmt: skip
#: The value of each rule of the grammar, of those of its parts.
VALUES: dict[str, Callable[..., Any]] = {
    "line": _line,
    "header": _header,
    "block": _block,
    "synchronous": lambda text: ("synchronous", text),
    "word": _word,
    "setting": _setting,
    "polynomial": lambda target, *values: ("poly", target, values),
    "call": lambda name, arguments: ("call", name.upper(), arguments),
    "surface_axis": lambda name: ("call", "SCC", (expressions.variable(_name(name), ()),)),
    "command": lambda name: ("name", name.upper()),
    "text": lambda text: ("text", _text(text)),
    "target": lambda name, *indices: (_name(name), _given(indices)),
    "arguments": lambda *c: () if c == (None,) else c,
    "number": _number,
    "string": _constant,
    "parameter": lambda name: expressions.variable(_name(name), ()),
    "variable": lambda name, *indices: expressions.variable(name.upper(), _given(indices)),
    "function": lambda name, arguments: expressions.function(name.upper(), arguments),
    "negative": lambda a: -a,
    "signed": expressions.unary,
    **{rule: partial(expressions.unary, name) for rule, name in (("negation", "NOT"), ("bit_not", "B_NOT"))},
    **{rule: partial(expressions.binary, name) for rule, name in _OPERATORS.items()},
    "binary": lambda a, operator, b: expressions.binary(operator.upper(), a, b),
    "compare": lambda a, operator, b: expressions.binary(operator, a, b),
    "text_of": lambda a: expressions.binary("<<", expressions.Quoted(""), a),
    "chain": expressions.Chain,
    "jump": _jump,
    "computed_jump": _computed_jump,
    "jump_to_text": lambda goto, label: ("jump", goto.upper(), label),
    "begin": lambda goto: ("jump", goto.upper(), ""),
    "if_jump": lambda *c: ("if-jump", tuple(zip(c[::2], c[1::2], strict=True))),
    **{rule: partial(lambda kind, condition: (kind, condition), rule.rstrip("_")) for rule in ("if_", "while_", "until")},
    "for_": lambda target, first, last: ("for", target, first, last),
    "case": lambda value, *branches: ("case", value, branches),
    "branch": lambda value, jump: (value, jump),
    "default": lambda jump: (None, jump),
    "times": lambda value: value,
    "repeat_part": _repeat_part,
    "call_block": lambda first, last: _repeat_part(first, last, None),
    "repeat_block": lambda label, times: ("repeat-block", label.upper(), 1.0 if times is None else times),
    "length": lambda number: ("length", float(number)),
    **dict.fromkeys(("bounds", "several"), lambda *c: c),
    "defined": lambda name, bounds, value: (name.upper(), bounds or (), value),
    "def_": lambda kind, _, *names: ("def", kind.upper(), names),
    "formal": lambda var, kind, _, name, extent, usual: ("formal", kind.upper(), name.upper(), var is not None, usual, extent),
    "formals": lambda *c: _given(c),
    "extent": lambda *bounds: ("extent", *bounds),
    "declared": lambda *_: None,
    "proc": lambda name, formals, *attributes: (
        "proc", name.upper(), formals or (), tuple(attribute.upper() for attribute in attributes)
    ),
    "extern": lambda name, *_: ("extern", name.upper()),
    **{rule: partial(tuple, (rule.rstrip("_"),)) for rule in _ALONE},
}  # fmt: skip


@cache
def _reader() -> Reader:
    return Reader(import_module("cncgen.grammars.tables_sinumerik"), VALUES)

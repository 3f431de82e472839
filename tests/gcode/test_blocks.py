"""Values of blocks: rows of operators, signs, least increments; and blocks for other tests, as hypothesis strategies."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import strategies as st

from cncgen.gcode.errors import BlockError
from cncgen.gcode.text import grammar

ROOT = Path(__file__).resolve().parent.parent.parent


class Values:
    """Parameters whose values tell them apart."""

    def __init__(self) -> None:
        self.numbers = [0.37 * k - 2.0 for k in range(6000)]
        self.interpreter = self
        self.local: dict[str, float] = {}
        self.named: dict[str, float] = {}

    def number(self, index: float) -> float:
        return self.numbers[int(index) % 6000]

    def name(self, name: str) -> float:
        return float(len(name))

    def has(self, name: str) -> bool:
        return len(name) % 2 == 1

    def has_number(self, index: float) -> bool:
        return 0 < index < 5000

    def increment(self) -> float:
        return 0.001


def value_of(value: Any) -> Any:
    """Return a value as what can be compared: its number now, or its fault."""
    if not callable(value):
        return value
    try:
        number = value(Values())
    except BlockError as error:
        return error.code, error.message
    except (ValueError, OverflowError) as error:
        return type(error)
    return "vacant" if math.isnan(number) else number


NUMBERS = st.sampled_from(["0", "1", "2.5", ".5", "3.", "12", "0.125", "007"])
SIGNS = st.sampled_from(["", "", "", "-", "+", "--", "- "])
LEAVES = st.one_of(
    NUMBERS,
    st.sampled_from(["#1", "#<a>", "#<_long name>", "##2", "#[1 + 2]", "EXISTS[#<b>]", "#5420", "#31.0"]),
)
OPERATORS = st.sampled_from(
    ["+", "-", "*", "/", "**", "MOD", "AND", "or", "XOR", "EQ", "ne", "GT", "GE", "LT", "le"]
)
FUNCTIONS = st.sampled_from(
    ["ABS", "acos", "ASIN", "COS", "EXP", "FIX", "FUP", "LN", "Round", "SIN", "SQRT", "TAN", "BIN"]
)


@st.composite
def rows(draw: st.DrawFn, inner: st.SearchStrategy[str]) -> str:
    """Operands with operators between, blanks here and there."""
    out = draw(SIGNS) + draw(inner)
    for _ in range(draw(st.integers(0, 4))):
        out += draw(st.sampled_from([" ", ""])) + draw(OPERATORS) + draw(SIGNS) + draw(inner)
    return out


VALUES = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        rows(inner).map("[{}]".format),
        st.builds("{}[{}]".format, FUNCTIONS, rows(inner)),
        st.builds("ATAN[{}]/[{}]".format, rows(inner), rows(inner)),
        st.builds("ATAN[{},{}]".format, rows(inner), rows(inner)),
    ),
    max_leaves=12,
)
BRACKETS = rows(VALUES).map("[{}]".format)
ITEMS = st.one_of(
    st.builds("{} {}{}".format, st.sampled_from("XyZgMf@^$"), SIGNS, VALUES),
    st.builds("#{} = {}{}".format, st.sampled_from(["1", "<a>", "#2", "[1+1]"]), SIGNS, VALUES),
    st.sampled_from(["(note)", "(MSG, Hi)", "()"]),
)
BLOCKS = st.builds(
    "{}{}{}{}".format,
    st.sampled_from(["", "", "/"]),
    st.sampled_from(["", "N10 ", "n7.5"]),
    st.lists(ITEMS, max_size=4).map(" ".join),
    st.sampled_from(["", "; tail"]),
)
FLOWS = st.one_of(
    st.builds(
        "o{} {} {}".format,
        st.sampled_from(["100", "<a b>", "[#1]", "#2"]),
        st.sampled_from(
            ["sub", "call", "while", "IF", "elseif", "endwhile", "return", "do", "repeat", "break"]
        ),
        st.lists(BRACKETS, max_size=3).map(" ".join),
    ),
    st.builds("IF {} GOTO {}".format, BRACKETS, st.one_of(NUMBERS, BRACKETS)),
    st.builds("IF {} THEN {}".format, BRACKETS, BLOCKS.filter(lambda text: text[:1] not in "/Nn")),
    st.builds("WHILE {} DO {}".format, BRACKETS, st.sampled_from("123")),
    st.sampled_from(["DO1", "END 2", "GOTO 30", "O1234", "o5 (name)", "GOTO #1"]),
)


def test_lengths_in_least_increments() -> None:
    """``X10`` counts them, ``X10.`` and a code do not."""
    text = "G1 X10 Y10. F5 I-3"
    found = [(letter, value_of(value)) for letter, value in grammar.parse(text, "fanuc", True).words]
    assert found == [("g", 1.0), ("x", 0.01), ("y", 10.0), ("f", 5.0), ("i", -0.003)]


@pytest.mark.parametrize("count", [1, 5, 7, 8, 9, 5000])
def test_long_rows_of_operators_are_computed(count: int) -> None:
    """Sums and differences of any length, against Python's own; #1 is -1.63."""
    text = "X[#1" + "".join(f" {'+-'[k % 2]} {'#1' if k % 3 else k}" for k in range(count)) + "]"
    expected = -1.63
    for k in range(count):
        term = -1.63 if k % 3 else k
        expected = expected - term if k % 2 else expected + term
    assert value_of(grammar.parse(text).words[0][1]) == expected


def test_rows_in_rows_keep_their_levels() -> None:
    """A row in brackets, or of a tighter operator, is computed before the row around it goes on."""
    inner = "+".join(["#1"] * 9)
    product = "*".join(["#3"] * 9)
    text = f"X[[{inner}]*2 + {product} - {inner} LT 3]"
    a, c = Values().numbers[1], Values().numbers[3]
    total = 0.0
    for _ in range(9):
        total += a
    row = total * 2
    power = c
    for _ in range(8):
        power *= c
    row = row + power - a
    for _ in range(8):
        row += a
    assert value_of(grammar.parse(text).words[0][1]) == float(row < 3)


def test_signs_in_a_row_do_not_nest() -> None:
    assert value_of(grammar.parse("X" + "-" * 5000 + "#1").words[0][1]) == pytest.approx(-1.63)
    assert value_of(grammar.parse("X" + "-" * 5001 + "#1").words[0][1]) == pytest.approx(1.63)

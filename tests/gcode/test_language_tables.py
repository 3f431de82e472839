"""The tables of languages whose rules make values, and their kernel, read what Lark's own parser reads: random lines, fresh in every run."""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from importlib import import_module
from typing import Any

import pytest
from cncgen.grammars import lalr
from lark import Lark, Tree
from lark.exceptions import UnexpectedInput

from cncgen.gcode.klartext import din_iso
from cncgen.gcode.sinumerik import reading as sinumerik
from cncgen.gcode.text import plain_language
from cncgen.kernels import grammar_values
from tests.kernels.plain import uncompiled


class _Shapes(dict[str, Callable[..., Any]]):
    """Functions that make tuples of the names of rules and their parts."""

    def __missing__(self, name: str) -> Callable[..., Any]:
        return lambda *parts: (name, *parts)


def _shape(tree: Any) -> Any:
    if isinstance(tree, Tree):
        return (lalr._bare(str(tree.data)), *map(_shape, tree.children))
    return None if tree is None else str(tree)


NUMBERS = ("1", "2.5", ".5", "1EX3", "1.5EX-3", "10.")
NAMES = ("R1", "R23", "AA", "X", "$AA_IM[X]", "VAR1", "_N", "R[2]", "PI", "X1_A")
OPERATORS = (
    *("+", "-", "*", "/", " DIV ", " MOD ", "==", "<>", "<", ">", "<=", ">=", "<<", ":"),
    *(" AND ", " OR ", " XOR ", " B_AND ", " B_OR ", " B_XOR "),
)


def _expression(dice: random.Random, depth: int = 3) -> str:
    kind = dice.randrange(14 if depth else 4)
    if kind < 4:
        return dice.choice(NUMBERS if kind < 2 else NAMES)
    if kind < 6:
        return dice.choice(("-", "+", "NOT ", "B_NOT ")) + _expression(dice, 0)
    if kind < 8:
        return f"ATAN2({_expression(dice, depth - 1)},{_expression(dice, depth - 1)})"
    if kind < 10:
        return f"({_expression(dice, depth - 1)})"
    return _expression(dice, depth - 1) + dice.choice(OPERATORS) + _expression(dice, depth - 1)


def _item(dice: random.Random) -> str:
    kind = dice.randrange(12)
    if kind < 5:
        return (
            dice.choice("GXYZFSMTDIJKL")
            + dice.choice(("", "-", "+"))
            + dice.choice(("1", "10", "2.5", ".5", "3."))
        )
    if kind < 7:
        target = dice.choice(("X", "Y1", "CR", "AP", "R1", "R[3]", "F", "S2", "AA[1,2]", "X1"))
        return target + dice.choice(("=", " = ", "= ")) + _expression(dice)
    if kind < 9:
        return dice.choice((f"Z=IC({_expression(dice, 1)})", "TRANS", "M30", "SUPA", "CIP", "TRAORI", "CHR"))
    if kind < 10:
        return (
            f"CYCLE81({','.join(dice.choice(('', _expression(dice, 1))) for _ in range(dice.randint(1, 4)))})"
        )
    return dice.choice(('MSG("TEXT; 1")', "PO[X]=(1,2,3)", "L10(1)", "SUB1", " L5", "P=3", "'TEXT'"))


FLOW = (
    *("IF E", "IF E GOTOF LAB", "FOR R1=E TO E", "FOR AA=E TO E", "ENDFOR", "ELSE", "ENDIF", "WHILE E", "ENDWHILE", "LOOP"),
    *("ENDLOOP", "REPEAT", "UNTIL E", "REPEAT LAB", "REPEAT LAB LAB_2 P=3", "REPEATB N10 P=2", "GOTOB N100", "GOTOC LAB"),
    *('GOTO "LAB"', "GOTOS", "CASE E OF 1 GOTOF LAB 2 GOTOB N10 DEFAULT GOTOF LAB", "CASE R1 OF -1 GOTOF LAB", "DEF REAL AA"),
    *("DEF INT AA=3,BB[2]=SET(1,2)", "DEF STRING[20] NAME", "DEF REAL AA[3]=(1,E,3)", "PROC UP", "EXTERN UP(REAL, VAR INT)"),
    *("PROC UP(REAL AA, VAR INT BB, STRING[3] CC, REAL DD[3]=E) SAVE", "CALL BLOCK LAB TO LAB_2", "WHEN $AA_IM[X]>5 DO M5"),
    *("ID=1 EVERY R1 DO X=3", "%_N_ABC_MPF", "%ABC_SPF", "%"),
    *("X 1 Y -2.5 F 100", "R 1=E", "GOTOF N 10", "N 10 G 1 X E", "IF R 1==E GOTOB LAB", "R 1_A=E"),
)  # fmt: skip


def sinumerik_line(dice: random.Random) -> str:
    """Return a line of SINUMERIK, of four one with a fault."""
    head = (
        dice.choice(("", "", "", "/", "/1"))
        + dice.choice(("", "", "N10 ", "N5", "N10", " :5 "))
        + dice.choice(("", "", "", "LAB: ", "A1: ", "LAB_1 :"))
    )
    if dice.random() < 0.55:
        body = dice.choice((" ", "")).join(_item(dice) for _ in range(dice.randrange(5)))
    else:
        body = " ".join(_expression(dice) if word == "E" else word for word in dice.choice(FLOW).split(" "))
    text = head + body + dice.choice(("", " ", "; NOTE"))
    if dice.random() < 0.25 and text:
        at = dice.randrange(len(text))
        wrong = dice.choice(("", "=", "(", ")", "R", "1", "N ", "[", ",", ".", "-", '"', "AND"))
        text = text[:at] + wrong + text[at + dice.randrange(2) :]
    return text


VALUES_OF_Q = ("5", "+5", "-2.5", "-2,5", ".5", "+ 7", "Q5", "+Q12", "-QL3", "- QR4", "1.5E2", "10.")
WORDS_OF_L = ("X", "IY", "Z", "A", "C", "PR", "IPA", "F", "S", "R", "FU", "K1X", "M")
OTHER_WORDS = (
    "FMAX",
    "F AUTO",
    "RL",
    "RR",
    "DR+",
    "M140 MB MAX",
    "M128 F MAX",
    "M120 LA5",
    "M103",
    "M138 A C",
    "M124 T0.1",
    "F",
    "M",
)
STATEMENTS = (
    *("CALL LBL 5 REP 3/3", 'CALL LBL "A B"', "LBL 0", "CALL PGM A\\B.H", "SEL PGM X", "CALL SELECTED PGM", "FSELECT 2", "STOP M8"),
    *("CYCL DEF 200 DRILLING", "CYCL DEF 7 .1 X+10", "CYCL CALL POS X+10 FMAX", "CYCL CALL PAT F200", "TCH PROBE 0.0", "BLK FORM 0.1 Z"),
    *("PLANE SPATIAL SPA+0 SPB-Q1 SPC+0 TURN FMAX SEQ-", "TRANS DATUM AXIS X+10", "PATTERN DEF POS1 (X+1 Y+Q2) ROW2 (X+0 D5)"),
    *("FUNCTION TCPM F TCP", "GLOBAL DEF 100", "QS1 = \"A\"", "Q5 = F MAX", "Q200 = PREDEF", "FN 18: SYSREAD Q1 = ID50 NR2 IDX Q3"),
    *("FN 9: IF E EQU E GOTO LBL 5", "FN 10: IF E NEQ E GOTO LBL \"X\"", "FN 1: Q1 = E + E", "FN 4: Q1 = E DIV E", "FN6:Q2=SIN E"),
    *("FN 13: Q1 = E ANG E", "FN 14: ERROR = 5", "FN 16: F-PRINT A", "FN 26: TABOPEN A", 'FN 27: TABWRITE E/"L" = E', "FN 0: Q1 = E", "FN 42: X", "FCT DR- R10 CCX+20 RX 5 CLSD+ PAR 3"),
    *("APPR PLCT PR+5 PA+3 R5 RL F200", "DEP LN LEN5", "RND R5 F AUTO", "CHF 2", 'TOOL CALL "A" Z S500 DL+0.1 DR-Q2', "TOOL DEF 5 L+0 R+5"),
    *("BEGIN PGM A MM", "END PGM A MM", "LN X+1 NX0 NY0 NZ1"),
)  # fmt: skip


def _formula(dice: random.Random, depth: int = 3) -> str:
    kind = dice.randrange(12 if depth else 3)
    if kind < 3:
        return dice.choice(("5", "2.5", "2,5", ".5", "Q5", "QL2", "PI"))
    if kind < 5:
        return dice.choice(("-", "+", "SIN ", "SQRT ", "SQ ", "LN ", "ACOS")) + _formula(dice, depth - 1)
    if kind < 7:
        return f"( {_formula(dice, depth - 1)} )"
    return (
        _formula(dice, depth - 1)
        + dice.choice((" + ", "-", " * ", "/", "%", " ^ "))
        + _formula(dice, depth - 1)
    )


def heidenhain_line(dice: random.Random) -> str:
    """Return a block of Heidenhain's plain language, of four one with a fault."""
    kind = dice.random()
    if kind < 0.5:
        words = [
            dice.choice(WORDS_OF_L) + dice.choice(VALUES_OF_Q)
            if dice.random() < 0.7
            else dice.choice(OTHER_WORDS)
            for _ in range(dice.randrange(6))
        ]
        head = dice.choice(
            ("L", "LP", "CC", "C", "CR", "CP", "CT", "CTP", "SPL", "LN", "TOOL CALL 5 Z", "CYCL CALL", "")
        )
        text = f"{head} {' '.join(words)}"
    elif kind < 0.7:
        text = f"Q1 = {_formula(dice)}"
    else:
        text = dice.choice(STATEMENTS)
        while " E" in text:
            text = text.replace(" E", f" {dice.choice(('', '+', '-'))}{dice.choice(('5', 'Q2', '.5'))}", 1)
    if dice.random() < 0.25 and text:
        at = dice.randrange(len(text))
        text = (
            text[:at]
            + dice.choice(("", "=", "(", ")", "R", "1", "X ", ".", "-", "+", '"'))
            + text[at + (text[at] != " " and dice.randrange(2)) :]
        )
    return text


ISO_WORDS = (
    *("G01", "G1", "G 03", "G17", "G41", "G91", "X", "Y", "Z", "I", "J", "H", "R", "F", "S", "M", "FU", "FMAX", "F AUTO", "M120 LA5", "M128"),
    *("M118 X1 Y+Q2", "M140 MB MAX", "M103 F20", "IX"),
)  # fmt: skip
ISO_BLOCKS = (
    *("%PART G71", "%PARTG70", "%PART", "G98 L1", 'G98L"AB"', "L1,3", "L 12", 'L"AB"', "L1.2", "G24 R2", "G25R+Q1 F100", "D00 Q1 P01 +5"),
    *("D01Q2P01+Q1P02 2", "D12 P01 +Q1 P02 +1 P03 7", 'D9 P01 Q1 P02 -2 P03 "A"', "D14 P01 5", "D18: SYSREAD", "D00 P01 5", "G200 DRILLING"),
    *("G247", "G125 X", "G83 P01 2 P02 -8 P03+Q3", "G37 P01 1 P02 2", "G39 P01 PART.I", "G39 PART", "G17 T1 S500", "T1 G17 S500 F2 DL+0.1 DR-Q2"),
    *('T"AB"', "T Q5 G17", "G99 T2 L+0 R+5", "G51 T3", "G04 F0.5", "G4 2", "G62 T0.05 P01 1", "G62", "G28 X Y", "G28", "G38 M5", "G36 S0", "G30 G17 X0"),
    *("G55 P01", "G412 X", "G75 P01 2", "G17 M3", "G54 X1 Y2", "G73 H+20", "Q5 = 2 * Q1", "FN 0: Q1 = 5", "RND R2", "APPR LT X1 R5"),
    *("TOOL CALL 5 Z S200", "FL X5 DR+", "CYCL DEF 7.1 X+5", "PLANE RESET STAY", "LBL 5", "CALL LBL 5 REP 2"),
)  # fmt: skip


def iso_line(dice: random.Random) -> str:
    """Return a block of DIN/ISO, of four one with a fault."""
    if dice.random() < 0.5:
        words = [dice.choice(ISO_WORDS) for _ in range(dice.randrange(6))]
        said = [
            word + dice.choice(VALUES_OF_Q) if len(word) == 1 or word in ("FU", "IX") else word
            for word in words
        ]
        text = dice.choice((" ", "")).join(said)
    else:
        text = dice.choice(ISO_BLOCKS)
    if dice.random() < 0.25 and text:
        at = dice.randrange(len(text))
        wrong = dice.choice(("", "=", "(", "R", "1", "X ", ".", "-", "+", '"', "G", "T"))
        text = text[:at] + wrong + text[at + dice.randrange(2) :]
    return text


LINES = {"din_iso": iso_line, "heidenhain": heidenhain_line, "sinumerik": sinumerik_line}


def _compare(name: str, count: int) -> None:
    lark = Lark.open(
        str(lalr.HERE / lalr.VALUES[name][0]), parser="lalr", lexer="contextual", maybe_placeholders=True
    )
    reader = grammar_values.Reader(import_module(f"cncgen.grammars.tables_{name}"), _Shapes())
    seed = random.SystemRandom().randrange(1 << 32)
    print(f"seed {seed} of {name}")
    dice = random.Random(seed)
    refused = 0
    for _ in range(count):
        text = LINES[name](dice)
        try:
            expected = _shape(lark.parse(text))
        except UnexpectedInput:
            expected = None
            refused += 1
        assert reader.parse(text) == expected, f"seed {seed}: {text!r}"
        assert (reader.error >= 0) == (expected is None)
    assert 0.02 * count < refused < 0.5 * count


@pytest.mark.parametrize("name", sorted(LINES))
def test_random_lines(name: str) -> None:
    _compare(name, 2000)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(LINES))
def test_many_random_lines(name: str) -> None:
    _compare(name, 100_000)


def test_letters_are_capital_or_small() -> None:
    dice = random.Random(1)
    reader = grammar_values.Reader(import_module("cncgen.grammars.tables_sinumerik"), _Shapes())
    for _ in range(300):
        text = sinumerik_line(dice)
        capital, small = reader.parse(text), reader.parse(text.lower())
        assert repr(small).lower() == repr(capital).lower(), text


@pytest.mark.parametrize(
    ("name", "functions"), [("heidenhain", plain_language.RULES), ("sinumerik", sinumerik.VALUES)]
)
def test_each_rule_has_a_value(name: str, functions: dict[str, Callable[..., Any]]) -> None:
    """A rule that is renamed has no function, and a function without a rule would never run."""
    assert _rules(name) == functions.keys()


def _rules(name: str) -> set[str]:
    return {name for name, _, _ in import_module(f"cncgen.grammars.tables_{name}").RULES if name}


def test_rules_of_din_iso_are_those_of_the_plain_language_and_its_own() -> None:
    assert _rules("din_iso") - plain_language.RULES.keys() == din_iso.RULES.keys()


@pytest.mark.parametrize("name", sorted(lalr.VALUES))
def test_tables_are_those_of_the_grammar(name: str) -> None:
    text = (lalr.HERE / f"tables_{name}.py").read_text("utf-8")
    assert f'DIGEST = "{lalr.digest(name)}"' in text, (
        "run `make kernels`: a grammar changed since the last build"
    )


def test_the_kernel_runs_uncompiled() -> None:
    tables = import_module("cncgen.grammars.tables_sinumerik")
    slow = uncompiled("grammar_values", "grammar_tables").Reader(tables, _Shapes())
    fast = grammar_values.Reader(tables, _Shapes())
    for text in ("N10 LAB: G1 X=IC(2*R1) ; note", "FOR R1=1 TO 5", "X=(1+2", "G1 X= ; nothing", "", "G1 !"):
        assert slow.parse(text) == fast.parse(text)
        assert slow.error == fast.error
        assert fast.error < 0 or slow.expected() == fast.expected()


def test_what_was_expected() -> None:
    """The states of the tables say what may follow."""
    reader = grammar_values.Reader(import_module("cncgen.grammars.tables_sinumerik"), _Shapes())
    assert reader.parse("GOTOF ; where?") is None
    assert (reader.error, set(reader.expected())) == (
        5,
        {"NAME", "ADDRESS", "STRING", "PLAIN_NUMBER", "LPAR"},
    )


def test_a_formula_takes_time_as_its_length() -> None:
    """A scan ends where no token that the state allows goes on: behind each number some other terminal takes the rest of the line."""

    def least_time(terms: int) -> float:
        taken = []
        for _ in range(3):
            begin = time.process_time()
            plain_language.parse("Q1 = 1" + " + 1" * terms)
            taken.append(time.process_time() - begin)
        return min(taken)

    # As the length: 8; as its square: 64.
    assert least_time(16_000) < 20.0 * least_time(2_000)

"""The tables and their kernel read what Lark's own parser reads: random blocks of each grammar, fresh in every run."""

from __future__ import annotations

import io
import random
from array import array
from importlib import import_module
from pathlib import Path

import pytest
from cncgen.grammars import lalr

from cncgen.gcode import read
from cncgen.gcode.codes.table import LATHE, language_of
from cncgen.gcode.source import MAX_LINE, open_source
from cncgen.gcode.text.dialects import choose
from cncgen.gcode.text.parsers import STORED, new_parser, parser
from cncgen.kernels import gcode_codes, gcode_lines, gcode_names, gcode_parse
from cncgen.kernels.gcode_codes import ROW
from tests.kernels.plain import uncompiled
from trials.peer_cases import peer_cases

from .reference import by_lark, by_shapes, by_tables, random_block, renumbered, spread

ROOT = Path(__file__).resolve().parent.parent.parent


def _compare(dialect: str, count: int) -> None:
    seed = random.SystemRandom().randrange(1 << 32)
    print(f"seed {seed} of {dialect}")
    dice = random.Random(seed)
    refused = 0
    for _ in range(count):
        text = random_block(dialect, dice)
        expected = by_lark(text, dialect)
        refused += isinstance(expected, int)
        found = by_tables(text, dialect)
        if isinstance(found, int):
            # Places are bytes.
            found = len(text.encode()[:found].decode())
        assert found == expected, f"seed {seed}: {text!r}"
        if not isinstance(expected, int):
            loose = spread(text, dice)
            assert loose == text or by_tables(loose, dialect) == expected, f"seed {seed}: {loose!r}"
    assert 0.02 * count < refused < 0.5 * count


@pytest.mark.parametrize("dialect", sorted(lalr.GRAMMARS))
def test_random_blocks(dialect: str) -> None:
    _compare(dialect, 2500)


@pytest.mark.slow
@pytest.mark.parametrize("dialect", sorted(lalr.GRAMMARS))
def test_many_random_blocks(dialect: str) -> None:
    _compare(dialect, 50_000)


@pytest.mark.parametrize(("count", "plain"), [(1500, False), (100, True)])
def test_lines_of_one_shape(count: int, plain: bool) -> None:
    """Lines that are read by the shape of another one have the instructions that the tables give."""
    kernel, kept = gcode_parse, gcode_lines
    if plain:
        kernel, kept = (
            uncompiled("gcode_parse", "decimals", "grammar_tables", "gcode_lines"),
            uncompiled("gcode_lines", "decimals", "grammar_tables"),
        )
    parser = kernel.Parser(import_module("cncgen.grammars.tables_linuxcnc"), STORED["linuxcnc"])
    seed = random.SystemRandom().randrange(1 << 32)
    dice = random.Random(seed)
    texts = [*SHAPES]
    while len(texts) < count:
        block = random_block("linuxcnc", dice).replace("\n", "")
        # Blanks belong to the shape: the last lines mostly have one of their own.
        texts += [block, *(renumbered(block, dice) for _ in range(dice.randint(1, 3)))]
        texts += [*(spread(renumbered(block, dice), dice) for _ in range(dice.randint(1, 2)))]
    for text, shaped in zip(texts, by_shapes(texts, parser, kept), strict=True):
        expected = by_tables(text, "linuxcnc")
        assert shaped == (-1 if isinstance(expected, int) else expected), f"seed {seed}: {text!r}"
    # The tables read the first one alone.
    before = parser.lines
    many = "\n".join(f"g1 x[{k} + 2 * sin[{k}.5]] y-.{k}" for k in range(200)).encode()
    rows = memoryview(bytearray(8 * ROW * 201)).cast("q", [201, ROW])
    kept.Lines(parser, memoryview(many), rows).compile(0, 1, 0, 200, len(many) + 1)
    assert parser.lines == before + 1


#: Lines of which two look alike, and are not of one shape or have other instructions.
SHAPES = (
    *("#1 = 2", "#3 = 2", "#[5] = 1", "#[7] = 1", "x#[5]", "x#[6.5]", "x#[5000]", "#5=[#[5]]", "##1=2", "##2=2"),
    *("o<5> call [#[5]]", "o<5> call [#[7]]", "o<7> call [#[7]]", "o5 call [1]", "o6 call [2]", "bspline x1", "bspline x2"),
    *("n1 x1", "n2.5 x1", "n.5 x1", "n3. x2", "n4 .5", "x1.", "x1", "x.1", "x1.2.3", "x..1", "x.", "x-.0", "x- - 0", "x-0", "x0"),
    *("g1 x1 2 y3", "g1 x1 . 2 y3", "g1 x1 . 2 . y3", "#<a1>=1", "#<a2>=1", "#<a 1>=2", "o1.5 sub", "o1 sub", "o 2 sub"),
    *("x12345678901234567890", "x1234567890123456789", "x123456789012345678", "x9007199254740993", "x9007199254740992", "(x1) y1", "(x2) y1"),
    *("x1 2", "x3 4", "n1 0 x5", "n2 1 x6", "n 3 x7", "n 4 x8", "x# 1", "x# 2", "# 1=2", "# 1=3", "x1\t", "x2 ", "x 1\r", "x 2 "),
    *("/x1", "/ x2", "x1/2", "x[1/2]", "x[3/4]", "x1 (a) y2", "x" + "1" * 239, "x" + "1" * 240, "x[1]" * 60, "x[2]" * 60, ""),
)  # fmt: skip


@pytest.mark.parametrize("dialect", sorted(lalr.GRAMMARS))
def test_tables_are_those_of_the_grammar(dialect: str) -> None:
    text = (lalr.HERE / f"tables_{dialect}.py").read_text("utf-8")
    assert f'DIGEST = "{lalr.digest(dialect)}"' in text, (
        "run `make kernels`: a grammar changed since the last build"
    )


def test_a_rule_that_is_renamed_breaks_the_build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for path in lalr.HERE.glob("*.lark"):
        text = path.read_text("utf-8").replace("-> plain_word ", "-> simple_word")
        (tmp_path / path.name).write_text(text, "utf-8")
    monkeypatch.setattr(lalr, "HERE", tmp_path)
    with pytest.raises(lalr.GrammarError, match="simple_word has no action"):
        lalr.write_all()


def test_a_literal_without_a_number_breaks_the_build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for path in lalr.HERE.glob("*.lark"):
        text = path.read_text("utf-8").replace("|sqrt|", "|sqrt|cosh|")
        (tmp_path / path.name).write_text(text, "utf-8")
    monkeypatch.setattr(lalr, "HERE", tmp_path)
    with pytest.raises(lalr.GrammarError, match="'cosh' of FUNCTION has no number"):
        lalr.tables("linuxcnc")


@pytest.mark.parametrize(
    ("name", "spelt", "instead", "fault"),
    [
        # R1=10-4 was read as two items once: the string won over the pattern in silence.
        (
            "sinumerik",
            "sum SIGN product",
            '(sum SIGN product | sum "-" product)',
            "MINUS and SIGN .* match '-'",
        ),
        ("sinumerik", '"NOT" unary', '("NOT" | "10") unary', "and PLAIN_NUMBER .* match '10'"),
        ("heidenhain", "IDENTIFIER: /[A-Z_]", "IDENTIFIER: /[0-9A-Z_]", "NUMBER and IDENTIFIER .* match '0'"),
    ],
)
def test_terminals_that_match_the_same_text_break_the_build(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, spelt: str, instead: str, fault: str
) -> None:
    for path in lalr.HERE.glob("*.lark"):
        (tmp_path / path.name).write_text(path.read_text("utf-8").replace(spelt, instead), "utf-8")
    monkeypatch.setattr(lalr, "HERE", tmp_path)
    with pytest.raises(lalr.GrammarError, match=fault):
        lalr.tables(name)


def test_a_terminal_that_the_scanner_reads_otherwise_breaks_the_build(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for path in lalr.HERE.glob("*.lark"):
        text = path.read_text("utf-8").replace("WORD: /[a-mp-z@^$]", "WORD: /[a-mp-z@^$&]")
        (tmp_path / path.name).write_text(text, "utf-8")
    monkeypatch.setattr(lalr, "HERE", tmp_path)
    with pytest.raises(lalr.GrammarError, match=r"gcode_scan\.py reads WORD as"):
        lalr.tables("linuxcnc")


def texts(folder: str) -> list[str]:
    """Return the programs of a folder."""
    if folder == "tests/peer/cases":
        return [case.program for case in peer_cases()]
    paths = (path for path in (ROOT / folder).iterdir() if path.suffix in (".ngc", ".nc"))
    return [path.read_text(errors="replace") for path in paths]


@pytest.mark.parametrize("folder", ["programs", "programs/bad", "tests/peer/cases"])
def test_reading_runs_the_tables_for_every_block(folder: str) -> None:
    count = 0
    for text in texts(folder):
        source = open_source(io.BytesIO(text.encode()), "t.ngc")
        dialect = choose(source).dialect
        if dialect not in (*lalr.GRAMMARS, LATHE) or source.is_binary():
            continue
        reader = parser(language_of(dialect), False)
        before = reader.lines
        read(io.BytesIO(text.encode()), "t.ngc")
        assert reader.lines - before >= len(text.splitlines()), text
        count += 1
    assert count > 10


@pytest.mark.parametrize("folder", ["programs", "programs/bad", "tests/peer/cases"])
def test_lines_of_programs(folder: str) -> None:
    lines = {
        "".join(line.split()).lower()
        for text in texts(folder)
        for line in text.splitlines()[:200]
        if not line.isascii() or line.strip()[:1] != "%"
    }
    for line in random.SystemRandom().sample(sorted(lines), min(len(lines), 400)):
        for dialect in lalr.GRAMMARS:
            found = by_tables(line, dialect)
            expected = by_lark(line, dialect)
            if isinstance(found, int):
                found = len(line.encode()[:found].decode())
            assert found == expected, line


def test_the_kernel_runs_uncompiled() -> None:
    slow = uncompiled("gcode_parse", "decimals", "grammar_tables", "gcode_lines")
    tables = import_module("cncgen.grammars.tables_linuxcnc")
    for text in ("N10 G1 X-1.5 Y[#1+2*SIN[30]] (note)", "o<a b> call [1] [2]", "#<x>=-#5 ; tail", "X1..2"):
        found = []
        for module in (gcode_parse, slow):
            parser = module.Parser(tables, 5000)
            end = parser.parse(memoryview(text.encode()), 0)
            numbers = parser.constants[: parser.numbers]
            found.append(
                (
                    end,
                    parser.error,
                    parser.flags,
                    list(parser.code[: parser.used]),
                    list(numbers),
                    parser.names,
                )
            )
        assert found[0] == found[1]
    text = memoryview(b"G18 G1 X-1.5 Y[2]\nM98 P7 G#1 @3\no<a> call (Z1)\no9 call [1]\n)X1\nC1/B2\n")
    named = []
    for module, names in (
        (gcode_parse, gcode_names),
        (slow, uncompiled("gcode_names", "decimals", "grammar_tables", "gcode_lines")),
    ):
        parser = module.Parser(tables, 5000)
        first = array("i", bytes(16 * gcode_codes.CODE_NUMBERS))
        calls = bytearray(len(first) // 2)
        calls[gcode_codes.CODE_NUMBERS + 980] = ord("p")
        named.append(
            (
                *names.named(parser, text, first, calls, True),
                {k: line for k, line in enumerate(first) if line},
            )
        )
    letters = sum(1 << (ord(letter) - 65) for letter in "CPXY")
    n = gcode_codes.CODE_NUMBERS
    codes = {180: 1, 10: 1, n + 980: 2}
    assert named[0] == named[1] == (letters | gcode_codes.COMPUTED, 2, {7.0, "a", 9.0}, codes)


@pytest.mark.parametrize("line", ["G1 X" + "[" * 300_000, "X1" * 300_000, "(" + "a" * 300_000 + ")"])
@pytest.mark.parametrize("dialect", sorted(lalr.GRAMMARS))
def test_lines_that_are_longer_than_any_are_refused(dialect: str, line: str) -> None:
    """The parser has room for one of `MAX_LINE` bytes: the process ended at such a line."""
    reader = new_parser(dialect)
    text = memoryview(f"{line}\nG1 X2\n".encode())
    assert reader.parse(text, 0) == len(line)
    assert 0 <= reader.error <= MAX_LINE
    reader.parse(text, len(line) + 1)
    assert reader.error < 0


def test_constants_of_kernels_have_names_of_their_own() -> None:
    """Of two with one name the kernels would have one number for both."""
    codes = gcode_codes
    groups = (
        *(
            codes.NUMBERS,
            codes.OPERATIONS,
            codes.OF_LANGUAGES,
            codes.JUMPS,
            codes.WORKS,
            codes.WORDS_OF_CYCLES,
            codes.ASIDES,
            codes.SETS_OF_WORDS,
            codes.SLOTS,
        ),
        *(codes.LINE_COLUMNS, codes.SHAPE_BYTES, codes.SHAPE_COLUMNS, codes.MARK_COLUMNS, codes.WAYS),
        *(codes.MODE_PLACES, codes.LEVEL_PLACES),
        [name for name, number in codes.ACTIONS.items() if number],
        [name for name, number in codes.LITERALS.items() if number < 128 and "[" not in name],
    )
    assert len(codes.CONSTANTS) == sum(len(group) for group in groups)
    assert all(getattr(codes, name) == number for name, number in codes.CONSTANTS.items())

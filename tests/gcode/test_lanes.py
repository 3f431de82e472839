"""Both lanes read a plain block alike: the scanner's columns against the grammar, on generated blocks and programs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.gcode.codes import comments
from cncgen.gcode.errors import BlockError
from cncgen.gcode.source import Source
from cncgen.gcode.text import grammar
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import PlainBlocks, comment_of
from cncgen.kernels import gcode_scan
from tests.kernels.plain import uncompiled
from trials.peer_cases import peer_cases

ROOT = Path(__file__).resolve().parent.parent.parent


def scanned(text: str) -> list[tuple[int, list[tuple[str, float]], int]]:
    """Return line, words and flags of the plain blocks of a text, up to the first line that is not plain."""
    blocks = PlainBlocks()
    blocks.scan(Source(text.encode(), "t"), Cursor(0, 0, 1))
    return [(int(blocks.line[i]), blocks.pairs(i), int(blocks.flags[i])) for i in range(blocks.count)]


BLANKS = st.sampled_from(["", " ", "  ", "\t"])


@st.composite
def numbers(draw: st.DrawFn) -> str:
    """A number as programs write them: signs, blanks inside, no digit before or after the point, many digits."""
    digits = draw(st.text("0123456789", min_size=0, max_size=7))
    fraction = draw(st.text("0123456789", min_size=0, max_size=8))
    if not digits and not fraction:
        digits = "7"
    point = "." if fraction or draw(st.booleans()) else ""
    sign = draw(st.sampled_from(["", "-", "+", "- "]))
    return sign + draw(BLANKS).join([*digits, *point, *fraction])


@st.composite
def blocks(draw: st.DrawFn) -> str:
    """A plain block: slash, line number, words, comments."""
    parts = [draw(st.sampled_from(["", "/", " /"])), draw(st.sampled_from(["", "N10", "n 5 0", "N7.1"]))]
    for _ in range(draw(st.integers(0, 6))):
        letter = draw(st.sampled_from("abcdefghijklmpqrstuvwxyzABCDEFGHIJKLMPQRSTUVWXYZ"))
        parts.append(letter + draw(BLANKS) + draw(numbers()))
        if draw(st.integers(0, 5)) == 0:
            parts.append(
                draw(
                    st.sampled_from(
                        [
                            "(note)",
                            "(MSG, x)",
                            "( G1 X[ )",
                            "()",
                            "(a, b)",
                            "( log ,)",
                            "(logclose)",
                            "(\u00fc, x)",
                        ]
                    )
                )
            )
    parts.append(draw(st.sampled_from(["", "; tail (", ";"])))
    return draw(BLANKS).join(parts)


@given(st.lists(blocks(), min_size=1, max_size=8), st.sampled_from(["\n", "\r\n"]))
def test_the_scanner_reads_what_the_grammar_reads(lines: list[str], end: str) -> None:
    found = {line: (pairs, flags) for line, pairs, flags in scanned(end.join(lines))}
    for number, text in enumerate(lines, 1):
        parsed = grammar.parse(text)
        if number not in found:
            assert not parsed.words
            assert not parsed.comments
            continue
        pairs, flags = found[number]
        assert pairs == parsed.words
        assert bool(flags & gcode_scan.SLASH) == parsed.deletable
        # What follows a semicolon says nothing, in either lane.
        assert flags & gcode_scan.COMMENT or not parsed.comments
        assert comment_of(text) == (parsed.comments[-1] if parsed.comments else None)
        assert bool(flags & gcode_scan.NUMBERED) == (parsed.number is not None)


@pytest.mark.parametrize("path", sorted((ROOT / "programs").glob("*.nc")), ids=lambda p: p.stem)
def test_the_lanes_agree_on_every_program(path: Path) -> None:
    text = path.read_text()
    found = {line: pairs for line, pairs, _ in scanned(text.replace("%\n", "\n"))}
    lines = text.splitlines()
    assert found
    # Programs of thousands of alike lines prove nothing more after the first ones.
    for number, line in enumerate(lines[:300], 1):
        if line.startswith("%"):
            continue
        assert found.get(number, []) == grammar.parse(line).words


def test_the_lanes_agree_on_the_peers_cases() -> None:
    lines = {line for case in peer_cases() for line in case.program.splitlines()}
    taken = 0
    for line in sorted(lines):
        found = scanned(line)
        taken += len(found)
        for _, pairs, _ in found:
            assert pairs == grammar.parse(line).words, line
    assert taken > 1000


@pytest.mark.parametrize(
    "line",
    ["X[1]", "#1=2", "o1 sub", "%", "G1 X#2", "(open", "(a (b) c)", "X1..2", "X-", "G0 N5", "X1 /", "GX1"],
)
def test_what_is_not_plain_is_left_to_the_grammar(line: str) -> None:
    assert scanned(f"G0 X1\n{line}\nG0 X2") == [(1, [("g", 0.0), ("x", 1.0)], 0)]


def test_numbers_of_more_digits_than_a_double_holds_go_to_the_grammar() -> None:
    text = "X0.12345678901234567890"
    assert scanned(text) == []
    assert grammar.parse(text).words == [("x", 0.12345678901234567890)]


@given(numbers())
def test_numbers_are_the_nearest_doubles(text: str) -> None:
    """Against Python's float, which rounds correctly."""
    ((_, pairs, _),) = scanned(f"X{text}")
    assert pairs == [("x", float(text.replace(" ", "").replace("\t", "")))]


@pytest.mark.parametrize("blank", ["", " ", "\t", "\x0b", "\u00a0"])
def test_comments_that_do_something_are_told_from_others(blank: str) -> None:
    """All that `comments` acts on; a comma in a remark makes nothing of it."""
    acts = [f"{keyword}, x" for keyword in (*comments._ACTS, "START", "Msg", "print")] + [
        "LOGCLOSE",
        "logclose ",
    ]
    for text in acts:
        ((_, _, flags),) = scanned(f"G1 X1 ({blank}{text})")
        assert flags & gcode_scan.ACTIVE, text
    for text in (
        "pass 2, roughing",
        "outer contour, pass 2",
        "x,y",
        ", a",
        "",
        "MSG",
        "feed, speed",
        "logclose it",
    ):
        ((_, _, flags),) = scanned(f"G1 X1 ({blank}{text})")
        assert not flags & gcode_scan.ACTIVE, text
        assert flags & gcode_scan.COMMENT


@given(st.lists(blocks(), min_size=1, max_size=5))
def test_the_scanner_runs_uncompiled(lines: list[str]) -> None:
    text = np.frombuffer("\n".join(lines).encode(), np.uint8)
    slow = uncompiled("gcode_scan", "decimals")
    results = []
    for module in (gcode_scan, slow):
        blocks = PlainBlocks()
        columns = (blocks.line, blocks.offset, blocks.flags, blocks.word_end, blocks.letters, blocks.values)
        returned = module.scan(text, 0, 1, *columns)
        results.append((tuple(map(int, returned)), *(column[:64].tolist() for column in columns)))
    assert results[0] == results[1]


def test_columns_of_any_size_give_the_same_blocks() -> None:
    """A scan that fills its columns goes on where it stopped."""
    text = "".join(f"N{i} G1 X{i} Y{-i}\n" for i in range(50)).encode()
    source = Source(text, "t")
    whole = PlainBlocks()
    whole.scan(source, Cursor(0, 0, 1))
    small = PlainBlocks(
        np.zeros(7, np.int64),
        np.zeros(7, np.int64),
        np.zeros(7, np.uint8),
        np.zeros(7, np.int64),
        np.zeros(16, np.uint8),
        np.zeros(16),
    )
    place, why = Cursor(0, 0, 1), gcode_scan.FULL
    found = []
    while why == gcode_scan.FULL:
        place, why = small.scan(source, place)
        found += [small.pairs(i) for i in range(small.count)]
    assert why == gcode_scan.END
    assert found == [whole.pairs(i) for i in range(whole.count)]


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("G1 X", 5, "X has no number"),
        ("G1  ?", 5, "'?' where"),
        ("G1 X[1 + ", 9, "the end of the block where"),
        ("G1 (a) ( b", 8, "a comment ( without its )"),
        ("X1 (a (b) c)", 4, "a comment begins within a comment"),
        ("#1 = [2 * ]", 11, "']' where"),
        ("G0 N5", 4, "'n' where"),
    ],
)
def test_syntax_errors_name_place_and_expectation(text: str, column: int, message: str) -> None:
    with pytest.raises(BlockError) as caught:
        grammar.parse(text)
    assert (caught.value.column, caught.value.message[: len(message)]) == (column, message)

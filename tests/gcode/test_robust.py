"""Whatever bytes come: diagnostics, never an exception, in bounded time and memory."""

from __future__ import annotations

import io
import resource
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cncgen.diagnostics import Diagnostics, UsageError
from cncgen.gcode import canon, read
from cncgen.toolpath.reading import ReadOptions

BOUNDS = {"max_steps": 2_000, "max_call_depth": 8}


def consume(data: bytes, **options: Any) -> list[str]:
    """Read bytes to the end both ways; return the codes of what was said."""
    program = read(io.BytesIO(data), "t", ReadOptions(**BOUNDS, **options))
    for _ in program.chunks():
        pass
    printed = Diagnostics()
    for _ in canon(io.BytesIO(data), "t", ReadOptions(**BOUNDS, **options), printed):
        pass
    codes = [d.code for d in program.diagnostics]
    assert codes == [d.code for d in printed]
    return codes


WORDS = st.sampled_from(
    [
        "G0",
        "G1",
        "G2",
        "G3",
        "G4",
        "G5",
        "G5.1",
        "G5.2",
        "G5.3",
        "G6.2",
        "G10",
        "G17",
        "G18",
        "G19",
        "G20",
        "G21",
        "G28",
        "G33",
        "G38.2",
        "G40",
        "G41.1",
        "G43",
        "G52",
        "G53",
        "G54",
        "G59.3",
        "G61",
        "G64",
        "G68",
        "G73",
        "G76",
        "G81",
        "G83",
        "G90",
        "G91",
        "G92",
        "G93",
        "G94",
        "G95",
        "G98",
        "M0",
        "M2",
        "M3",
        "M5",
        "M6",
        "M62",
        "M70",
        "M72",
        "M98",
        "M99",
        "X1",
        "Y-2",
        "Z.5",
        "A9",
        "U1",
        "I1",
        "J",
        "K0",
        "K1",
        "L2",
        "P1",
        "Q2",
        "R1",
        "S9",
        "F100",
        "T1",
        "H1",
        "D1",
        "E1",
        "@1",
        "^30",
        "$1",
        "N10",
        "/",
        "%",
        "(",
        ")",
        ";",
        "[",
        "]",
        "#1",
        "#<a>",
        "=",
        "+",
        "-",
        "*",
        "**",
        "MOD",
        "EQ",
        "SIN[30]",
        "ATAN[1]/[2]",
        "O1",
        "O<a>",
        "sub",
        "endsub",
        "call",
        "if",
        "endif",
        "else",
        "while",
        "endwhile",
        "do",
        "repeat",
        "endrepeat",
        "return",
        "IF",
        "GOTO",
        "10",
        "WHILE",
        "DO1",
        "END1",
        "THEN",
        "G65",
        "G66",
        "1e9",
    ]
)


@settings(max_examples=300)
@given(st.lists(st.lists(WORDS, max_size=6), max_size=8), st.sampled_from(["linuxcnc", "fanuc"]))
def test_words_in_any_order(lines: list[list[str]], dialect: str) -> None:
    consume("\n".join(" ".join(line) for line in lines).encode(), dialect=dialect)


@settings(max_examples=200)
@given(st.binary(max_size=200))
def test_any_bytes(data: bytes) -> None:
    assert consume(data) or data.strip()


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"", "empty-program"),
        (b"\n\r\n \t\n", "empty-program"),
        (b"(nothing)\n", "empty-program"),
        (b"\x7fELF\0\0\0\x01", "binary-file"),
        (b"G0 X1 \xff\xfe\nM2", "syntax"),
        (b"G0 XNaN\nM2", "syntax"),
        (b"F1\nG1 X1e400\nM2", "unused-word"),
        (b"G0 X" + b"9" * 400 + b"\nM2", "number-range"),
        (b"G0 X1" + b" " * 70_000 + b"Y1 [\nM2", "line-too-long"),
        (b"G0 X1 (open\nM2", "open-comment"),
    ],
)
def test_what_is_no_program(data: bytes, code: str) -> None:
    assert consume(data)[0] == code


def test_a_hundred_megabytes_in_one_line(tmp_path: Path) -> None:
    """The line is never held as text: the file is mapped, and the line ends in one diagnostic."""
    big = tmp_path / "big.nc"
    with big.open("wb") as file:
        for _ in range(100):
            file.write(b"G1 X1 [" * 142_857)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    program = read(big, "big.nc")
    for _ in program.chunks():
        pass
    (error, *_) = program.diagnostics
    assert error.code == "line-too-long"
    assert len(error.excerpt) <= 200
    # The mapped pages themselves may count, nothing more.
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200 * 1024


def test_a_million_faults_stay_bounded() -> None:
    program = read(io.BytesIO(b"G1 X\n" * 20_000), "t")
    for _ in program.chunks():
        pass
    assert program.diagnostics.counts["error"] == 20_000
    assert len(program.diagnostics) == 1000


def test_unreadable_files_are_usage_errors(tmp_path: Path) -> None:
    for path in (tmp_path / "none.nc", tmp_path):
        with pytest.raises(UsageError):
            read(path, path.name)


def test_a_stream_is_read_like_a_file(tmp_path: Path) -> None:
    text = b"G0 X1\nG1 Y2 F100\nM2\n"
    (tmp_path / "p.nc").write_bytes(text)
    chunks = [next(iter(read(source, "p").chunks())) for source in (tmp_path / "p.nc", io.BytesIO(text))]
    assert chunks[0].end.tolist() == chunks[1].end.tolist()

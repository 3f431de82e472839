"""Whatever bytes come: diagnostics, never an exception, in bounded time and memory."""

from __future__ import annotations

import io
import resource
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cncgen.diagnostics import Diagnostics, UsageError
from cncgen.gcode import canon, check, read, source
from cncgen.toolpath.reading import ReadOptions

BOUNDS = {"max_steps": 2_000, "max_call_depth": 8}


def consume(data: bytes, **options: Any) -> list[str]:
    """Read bytes to the end both ways; return the codes of what was said, but that no unit is.

    Where no sign tells the control, reading takes codes that LinuxCNC refuses, and canonical calls do not, as `rs274`.
    """
    if "dialect" not in options:
        for _ in read(io.BytesIO(data), "t", ReadOptions(**BOUNDS, **options)).chunks():
            pass
        options["dialect"] = "linuxcnc"
    program = read(io.BytesIO(data), "t", ReadOptions(**BOUNDS, **options))
    for _ in program.chunks():
        pass
    printed = Diagnostics()
    for _ in canon(io.BytesIO(data), "t", ReadOptions(**BOUNDS, **options), printed):
        pass
    codes = [d.code for d in program.diagnostics]
    assert codes == [d.code for d in printed]
    return [code for code in codes if code not in ("units-assumed", "units-doubtful")]


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


@pytest.mark.parametrize(
    ("leader", "trailer"),
    [(b"\x11\x12", b"\x13\x14"), (b"", b"\0" * 20), (b"\0" * 20, b"\x14"), (b"", b"\x1a" * 9)],
    ids=["codes", "blank behind", "blank before", "Control-Z"],
)
@pytest.mark.parametrize("stream", [True, False])
def test_what_leads_and_trails_a_tape_is_no_text(
    tmp_path: Path, leader: bytes, trailer: bytes, stream: bool
) -> None:
    """What a serial line brings: DC2 before and DC4 behind, blanks, Control-Z. Of a stream that began with blanks only 4096 bytes were read."""
    blocks = b"".join(b"G1 X%d. F100.\n" % k for k in range(1000))
    data = leader + b"%\nO1\nG21\n" + blocks + trailer
    (tmp_path / "t.nc").write_bytes(data)
    program = read(io.BytesIO(data) if stream else tmp_path / "t.nc", "t.nc", ReadOptions())
    ends = [end[0] for chunk in program.chunks() for end in chunk.end.tolist()]
    assert [d.code for d in program.diagnostics if d.severity == "error"] == []
    assert ends[-1] == 999.0


@settings(max_examples=300)
@given(st.lists(st.lists(WORDS, max_size=6), max_size=8), st.sampled_from(["linuxcnc", "fanuc"]))
def test_words_in_any_order(lines: list[list[str]], dialect: str) -> None:
    consume("\n".join(" ".join(line) for line in lines).encode(), dialect=dialect)


@settings(max_examples=200)
@given(st.binary(max_size=200))
@example(b"M10")
@example(b"G70")
def test_any_bytes(data: bytes) -> None:
    """In LinuxCNC's dialect: without a sign of any, `read` leaves M10 to the machine's builder, which `canon` refuses as the peer does."""
    assert consume(data, dialect="linuxcnc") or data.strip()


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


def diagnostics_of(stream: Any) -> Diagnostics:
    found = Diagnostics()
    check(stream, "-", ReadOptions(), found)
    return found


class Endless(io.RawIOBase):
    """A stream that gives the same bytes again and again, and counts them."""

    def __init__(self, line: bytes) -> None:
        self.line, self.given = line, 0

    def read(self, size: int = -1) -> bytes:
        self.given += size
        return self.line * (size // len(self.line))


def test_a_stream_without_end_is_not_read_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of zeros the head is enough; text is spooled up to a limit."""
    zeros, text = Endless(b"\0"), Endless(b"G1 X1 F1")
    (fault,) = list(diagnostics_of(zeros))
    assert (fault.code, zeros.given) == ("binary-file", 2**20)
    monkeypatch.setattr(source, "MAX_STREAM", 3 * 2**20)
    with pytest.raises(UsageError, match="- is larger than 3145728 bytes"):
        diagnostics_of(text)
    assert text.given == 4 * 2**20


LINES = [
    b"%",
    b"N1 G0 X1",
    b"#1=1",
    b"o1 while [#1 LT 3]",
    b"G1 F5 Y#1",
    b"#1=[#1+1]",
    b"o1 endwhile",
    b"M2",
    b"%",
]


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r", b"\r\r\n"])
@pytest.mark.parametrize("begin", [b"", b"\xef\xbb\xbf"])
@pytest.mark.parametrize("last", [b"", b"end"])
def test_lines_end_as_any_system_ends_them(begin: bytes, end: bytes, last: bytes, run: Any) -> None:
    """With or without the mark of UTF-8, and whether the last line ends or not."""
    out = run(begin + end.join(LINES) + last.replace(b"end", end))
    assert [d.code for d in out.diagnostics] == ["dialect"]
    assert out.path.end[:, :2].tolist()[:3] == [[1, 0], [1, 1], [1, 2]]
    assert out.path.line.tolist()[:3] == [2, 5, 5]


@pytest.mark.parametrize(
    ("before", "after"), [("\n", "\r\0\0\n"), ("10", "1\x7f0"), ("\n%\n", "\x7f\x7f\n%\n\0\0\0")]
)
def test_fillers_of_a_tape_are_passed_over(before: str, after: str, tmp_path: Path, run: Any) -> None:
    """NUL is a place without a hole, DEL one that was punched out: the text means what it does without them, as file and stream.

    Amid a line they may stand in place of a digit that was lost, which is told.
    """
    told = ["tape-fillers"] if before == "10" else []
    written = "%\nO1\nG21 G0 X10 Y5\nX20\nM30\n%\n".replace(before, after).encode()
    out = run(written)
    assert [d.code for d in out.diagnostics] == ["dialect", *told]
    assert [(d.span.line, d.span.column) for d in out.diagnostics if d.code in told] == [(3, 10)] * len(told)
    assert out.path.end[:2, :2].tolist() == [[10, 5], [20, 5]]
    (tmp_path / "tape.nc").write_bytes(written)
    found = Diagnostics()
    check(tmp_path / "tape.nc", "tape.nc", ReadOptions(), found)
    assert [d.code for d in found] == ["dialect", *told]


@pytest.mark.parametrize("dialect", ["auto", "linuxcnc", "sinumerik", "heidenhain"])
def test_wide_text_without_its_mark_is_named(dialect: str) -> None:
    for coding, named in (("utf-16-le", True), ("utf-16-be", True), ("utf-32", True), ("ascii", False)):
        found = Diagnostics()
        check(
            io.BytesIO(("G0 X1" + "\0\1" * (not named) + "\nM2\n").encode(coding)),
            "a",
            ReadOptions(dialect=dialect),
            found,
        )
        (fault,) = [d for d in found if d.code != "dialect"]
        assert fault.code == "binary-file"
        assert ("UTF-16" in fault.hint) == named


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("coding", ["utf-16-le", "utf-16-be"])
def test_wide_text_is_the_same_text(coding: str, end: str, tmp_path: Path) -> None:
    """Places of faults count characters, as they do in UTF-8, which Python's own codecs make here."""
    text = end.join(
        ["%", "O1 (Gr\u00f6\u00dfe \u4e2d)", "G21 G90 G54", "(\u00e9) G1 X5. Q! F100", "M30", "%", ""]
    )
    wide, narrow = tmp_path / "wide.nc", tmp_path / "narrow.nc"
    wide.write_bytes(("\ufeff" + text).encode(coding))
    narrow.write_bytes(text.encode())
    said = []
    for path in (wide, narrow):
        for given_as in (path, io.BytesIO(path.read_bytes())):
            found = Diagnostics()
            check(given_as, "a", ReadOptions(), found)
            said.append(
                [(d.code, d.message, d.span and (d.span.line, d.span.column, d.excerpt)) for d in found]
            )
    assert said[0] == said[1] == said[2] == said[3]
    (fault,) = [place for code, _, place in said[0] if code == "syntax"]
    assert fault == (4, 13, "(\u00e9) G1 X5. Q! F100")


#: An infinite number, and one that is none.
_INFINITE = "#2=[10**308*10**308]\n#1=[#2-#2]\n"


@pytest.mark.parametrize("operand", ["#1", "#2"])
@pytest.mark.parametrize(
    "line",
    [
        *(
            f"#3={f}[{{}}]"
            for f in ("ABS", "ACOS", "ASIN", "COS", "EXP", "FIX", "FUP", "LN", "ROUND", "SIN", "SQRT", "TAN")
        ),
        *(f"#3=[{{}} {o} 2]" for o in ("+", "/", "MOD", "**", "AND", "EQ", "LT")),
        *(f"#3=[-2 {o} {{}}]" for o in ("-", "*", "/", "MOD", "**", "XOR", "GE")),
        "#3=ATAN[{}]/[{}]",
        "#3=#[{}]",
        "#[{}]=1",
        "X{}",
        "G1 F{} X1",
        "G2 X1 I{}",
        "G2 X1 Y1 R{}",
        "G3 I1 P{}",
        "G4 P{}",
        "G{} X1",
        "M{}",
        "T{} M6",
        "S{} M3",
        "G10 L2 P{} X1",
        "G10 L2 P1 X{} R{}",
        "G43.1 Z{}",
        "G43 H{}",
        "G92 X{}",
        "G81 X1 Z-1 R{} L{}",
        "G83 X1 Z-1 R1 Q{}",
        "G76 P{} Z1 I1 J1 K{}",
        "G5 X1 Y1 I{} J1 P1 Q1",
        "G5.2 P{} X1 Y1",
        "G33 Z1 K{}",
        "M66 P{}",
        "M68 E{} Q{}",
        "M98 P{} L{}",
        "o1 if [{}]\no1 endif",
        "o1 repeat [{}]\no1 endrepeat",
        "o1 while [{} LT 0]\no1 endwhile",
        "o[{}] call",
        "o1 sub\no1 endsub [{}]\no1 call [{}]\nX#1",
        "G7\nX{}",
        "G41.1 D{}\nG1 F1 X9",
        "G96 D{} S{}",
        "G64 P{} Q{}",
        "G68 X0 Y0 R{}",
        "G51 X1 P{}",
        "@{} ^{}",
        "(debug, #1 #2 {})",
    ],
)
def test_numbers_that_are_none_end_in_diagnostics(line: str, operand: str) -> None:
    """Everywhere a number may stand; whatever is said of it, in both dialects."""
    for dialect in ("linuxcnc", "fanuc"):
        text = "F10 G0 X0 Y0 Z5\n" + _INFINITE + line.replace("{}", operand) + "\nG0 X1\nM2\n"
        consume(text.encode(), dialect=dialect)


def test_many_labels_are_found_in_time(run: Any) -> None:
    """Nested branches, loops and subroutines by the thousand; a search through all of them for each took minutes."""
    count = 4000
    opened = "".join(f"o{k} if [1]\n" for k in range(count))
    closed = "".join(f"o{k} endif\n" for k in reversed(range(count)))
    subs = "".join(f"o{k + count} sub\nG0 X{k + 1}\no{k + count} endsub\n" for k in range(count))
    calls = "".join(f"o{k + count} call\n" for k in range(0, count, 4))
    out = run(opened + closed + subs + calls + "M2\n")
    assert out.errors == []
    assert out.path.end[:1000, 0].tolist() == [k + 1 for k in range(0, count, 4)]


def test_names_that_no_file_can_have(run: Any) -> None:
    assert run(f"o<{'b' * 300}> call\nM2\n").errors[0][0] == "sub-missing"


def test_a_hundred_megabytes_in_one_line(tmp_path: Path) -> None:
    """The line is never held as text: the file is mapped, and the line ends in one diagnostic."""
    big = tmp_path / "big.nc"
    with big.open("wb") as file:
        for _ in range(100):
            file.write(b"G1 X1 [" * 142_857)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    program = read(big, "big.nc", ReadOptions(units="mm"))
    for _ in program.chunks():
        pass
    (error, *_) = program.diagnostics
    assert error.code == "line-too-long"
    assert len(error.excerpt) <= 200
    # The mapped pages themselves may count, nothing more.
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200 * 1024


def test_a_million_faults_stay_bounded() -> None:
    program = read(
        io.BytesIO(b"".join(b"M%d\n" % k for k in range(300, 20_300))), "t", ReadOptions(dialect="linuxcnc")
    )
    for _ in program.chunks():
        pass
    assert program.diagnostics.counts["error"] == 20_000
    assert len(program.diagnostics) == 1000


def test_the_same_fault_in_every_line_is_shown_some_times() -> None:
    program = read(io.BytesIO(b"G1 X\n" * 20_000 + b"M2\nG4\n"), "t")
    for _ in program.chunks():
        pass
    assert program.diagnostics.counts["error"] == 20_000
    assert [d.code for d in program.diagnostics] == ["syntax"] * 10


def test_unreadable_files_are_usage_errors(tmp_path: Path) -> None:
    for path in (tmp_path / "none.nc", tmp_path):
        with pytest.raises(UsageError):
            read(path, path.name)


def test_a_stream_is_read_like_a_file(tmp_path: Path) -> None:
    text = b"G0 X1\nG1 Y2 F100\nM2\n"
    (tmp_path / "p.nc").write_bytes(text)
    chunks = [next(iter(read(source, "p").chunks())) for source in (tmp_path / "p.nc", io.BytesIO(text))]
    assert chunks[0].end.tolist() == chunks[1].end.tolist()


def test_a_parameter_of_infinite_number(run: Any) -> None:
    """Digits enough for a number that is none."""
    nines = "9" * 400
    for text in (f"G0 X#{nines}", f"#{nines}=1", f"G0 X[#{nines}+1]"):
        for dialect in ("linuxcnc", "fanuc"):
            assert [code for code, _, _ in run(f"{text}\nM2", dialect=dialect).errors] == ["number-range"]


@pytest.mark.parametrize("aside", ["", "(LINE BY LINE)", "#1=0"])
@pytest.mark.parametrize("way", ["X.00000000000001 A10.", "A10. B-.0000156783 Z1e-14"])
def test_check_finds_the_feed_that_planning_refuses(tmp_path: Path, aside: str, way: str) -> None:
    """F500 along all axes (FANUC B-63174EN, 4.2) leaves a way of 1e-14 mm beside 10 degrees 500/60 * 1e-15 mm/s: no feed of `ranges.FEEDS`."""
    way = way.replace("1e-14", ".00000000000001")
    path = tmp_path / "p.nc"
    path.write_text(f"O1\nG21 G90 F500\nG1 X0 Y0\n{aside}\nG1 {way}\nM30\n")
    found = Diagnostics()
    check(path, "p", ReadOptions(dialect="fanuc"), found)
    errors = [d for d in found if d.severity == "error"]
    assert [(d.code, d.span and d.span.line) for d in errors] == [("number-range", 5)]
    assert float(errors[0].values["value"]) == pytest.approx(500 / 60 * 1e-15, rel=1e-6)
    path.write_text(
        f"O1\nG21 G90 F500\nG1 X0 Y0\n{aside}\nG1 {way.replace('.00000000000001', '.001')}\nM30\n"
    )
    assert check(path, "p", ReadOptions(dialect="fanuc")) > 0


@pytest.mark.parametrize("text", ["{blanks}G0 X1", "{blanks}/{blanks}N5{blanks}X1", "GOTO 5\n{blanks}x"])
def test_many_blanks_take_no_time(run: Any, text: str) -> None:
    """Patterns that look for words of macros must not try each way to share the blanks out (20,000 of them)."""
    assert run(text.format(blanks=" " * 20_000) + "\nN5 M30", dialect="fanuc").errors == []


def test_a_line_that_is_not_utf_8_is_shown_as_western_windows_writes_it(run: Any) -> None:
    out = run("G0 X1 (Ø 12 – groß) §\nM2\n".encode("cp1252"))
    (error,) = out.diagnostics
    assert error.excerpt == "G0 X1 (Ø 12 – groß) §"
    assert error.span is not None
    assert error.span.column == 21
    assert "'§' U+00A7 (section sign)" in error.message


@pytest.mark.parametrize("head", ["O0001;", "O<PART 1>(NAME)", "O<A>;", ":0001 (X) ;"])
def test_a_program_number_or_name_alone_is_of_fanuc(run: Any, head: str) -> None:
    """P of G4 is in milliseconds there."""
    out = run(f"{head}\nG4 P500\nM30\n")
    assert [d.code for d in out.diagnostics] == ["dialect"]
    assert [event.dwell_s for event in out.path.events if event.name == "dwell"] == [0.5]


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc", "sinumerik", "heidenhain"])
def test_a_link_out_of_the_search_path_is_not_followed(tmp_path: Path, dialect: str) -> None:
    """The file that it leads to holds the subprogram; a link within the folder is followed."""
    texts = {
        "linuxcnc": ("part.ngc", "o<part> sub\nG0 X1\no<part> endsub\n", "o<part> call\nM2\n"),
        "fanuc": ("O0012.nc", "O12\nG0 X1\nM99\n", "M98 P12\nM30\n"),
        "sinumerik": ("PART.SPF", "G0 X1\nM17\n", "PART\nM30\n"),
        "heidenhain": ("PART.H", "L X+1 FMAX\n", "CALL PGM PART\nM30\n"),
    }
    name, subprogram, program = texts[dialect]
    inside, outside = tmp_path / "inside", tmp_path / "outside"
    for folder in (inside / "below", outside):
        folder.mkdir(parents=True)
        (folder / "kept").write_text(subprogram)
    main = inside / "main.nc"
    main.write_text(program)
    for target, codes in ((outside / "kept", ["sub-missing"]), (inside / "below" / "kept", [])):
        (inside / name).unlink(missing_ok=True)
        (inside / name).symlink_to(target)
        found = Diagnostics()
        check(main, "main.nc", ReadOptions(dialect=dialect), found)
        assert [each.code for each in found if each.severity == "error"] == codes


@pytest.mark.parametrize(
    ("dialect", "line"),
    [
        ("heidenhain", "CYCL DEF {}.1 X+1"),
        ("heidenhain", "CYCL DEF 7.{} X+1"),
        ("heidenhain", "TOOL CALL {} Z S1"),
        ("heidenhain", "CALL LBL 1 REP {}"),
        ("heidenhain", "%A G71 *\nN10 G{} X+1 *\nN20 %A G71 *"),
        ("heidenhain", "%A G71 *\nN10 G98 L1 *\nN20 L1,{} *\nN30 %A G71 *"),
        ("sinumerik", "$TC_DP{}[1,1]=2"),
        ("sinumerik", "R1='H{}'"),
        ("sinumerik", f"R1='B{'1' * 5000}'"),
        ("sinumerik", "DEF REAL A[{}]"),
        ("fanuc", "M98 P1 L{}"),
        ("linuxcnc", "o{} call"),
    ],
)
def test_a_number_of_5000_digits_is_a_fault(dialect: str, line: str) -> None:
    """Python turns no text of more than 4300 digits into a whole number, and no whole number beyond 2^1024 into a float."""
    assert consume(line.replace("{}", "9" * 5000).encode(), dialect=dialect)

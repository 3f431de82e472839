"""Where in a line a diagnostic points: the word that is meant, or the first character."""

from __future__ import annotations

import pytest

from cncgen.gcode.errors import locate


@pytest.mark.parametrize(
    ("text", "word", "marked"),
    [
        ("G1 X10 Y20", "X", "X10"),
        ("G1 X10 Y20", "y", "Y20"),
        ("g1x10y20", "Y", "y20"),
        ("(X5) G1 X10", "X", "X10"),
        ("G1 ; X5\n", "X", "G"),
        ("G1 #<X>=5 X7", "X", "X7"),
        ("G90 G5.1 X1", "G5.1", "G5.1"),
        ("G05.10 X1", "G5.1", "G05.10"),
        ("G1 G2", "G2", "G2"),
        ("G1 G2", "G3", "G1"),
        ("  G1", "Q", "G"),
        ("X1 #5 = 3", "#", "#"),
        ("o1 while [1]", "WHILE", "while"),
        ("G1 X5 ,R 2.5 Y3", ",R", ",R 2.5"),
        ("", "X", ""),
    ],
)
def test_the_word_that_is_meant_is_marked(text: str, word: str, marked: str) -> None:
    """Comments and names of parameters hold no words; numbers are compared by their value, not by their digits."""
    column, length = locate(text, word)
    assert text[column - 1 : column - 1 + length] == marked


@pytest.mark.parametrize(
    ("dialect", "text", "column"),
    [
        ("sinumerik", "G90 G54\u00a0G710 X5\nM30", 8),
        ("heidenhain", "BEGIN PGM A MM\nL X+5\u00a0R0 FMAX\nEND PGM A MM", 6),
    ],
)
def test_a_blank_that_is_none_is_what_is_named(dialect: str, text: str, column: int) -> None:
    """A no-break space, as texts copied from web pages have: the word behind it was named as what is wrong."""
    from cncgen import read_text

    program = read_text(text, dialect=dialect)
    list(program.chunks())
    fault = next(d for d in program.diagnostics if d.severity.value == "error")
    assert "U+00A0 (no-break space)" in fault.message
    assert fault.span is not None
    assert fault.span.column == column


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc"])
def test_a_comment_over_several_lines_is_one_fault(dialect: str) -> None:
    """Its lines were read as blocks, with an error each and its numbers as motions; a comment without an end hides nothing."""
    from cncgen import read_text

    def faults(text: str) -> list[tuple[int, str]]:
        program = read_text(text, dialect=dialect)
        list(program.chunks())
        errors = [one for one in program.diagnostics if one.severity.value != "note" and one.span]
        return [(one.span.line, one.code) for one in errors if one.span]

    assert faults("G21 G0 X1.\n(BLANK OF\nX10. Y20.\nLONG)\nG99999\nM2\n") == [
        (2, "open-comment"),
        (5, "unknown-code"),
    ]
    assert (3, "unknown-code") in faults("G21 G0 X1.\n(BLANK OF\nG99999\n(LONG)\nM2\n")
    assert [code for _, code in faults(f"G21 G0 X1.\n(BLANK OF\n{'X' * 70_000}\nM2\n")] == [
        "open-comment",
        "line-too-long",
    ]

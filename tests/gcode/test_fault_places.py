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

"""Letters as strokes, for cycles that engrave: our own, since controls do not publish theirs.

A glyph is strokes of points XY on a grid: capitals are 6 high and up to 4 wide, small letters 4 high; 9 and 8 as Y are 1 and 2 below the line.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache

from cncgen.gcode.codes.flat_cutter import FlatCutter

Stroke = tuple[complex, ...]
_CAPITAL, _GAP, _BLANK = 6.0, 2.0, 4.0
_GLYPHS = {
    "A": "002640 1333", "B": "00063645443303 3342413000", "C": "4536160501103041", "D": "00062645412000", "E": "46060040 0333",
    "F": "460600 0333", "G": "45361605011030414323", "H": "0006 4046 0343", "I": "0006", "J": "4641301001", "K": "0006 460340", "L": "060040",
    "M": "0006234640", "N": "00064046", "O": "100105163645413010", "P": "00063645443303", "Q": "100105163645413010 2240",
    "R": "00063645443303 2340", "S": "453616050413334241301001", "T": "0646 2620", "U": "060110304146", "V": "062046", "W": "0610233046",
    "X": "0046 0640", "Y": "062346 2320", "Z": "06460040",
    "a": "40441403011040", "b": "06003041433404", "c": "441403011040", "d": "46401001031444", "e": "024243341403011040", "f": "36261510 0424",
    "g": "441403011040 44493808", "h": "0600 0314344340", "i": "0004 06", "j": "141908 16", "k": "0600 340230", "l": "0600",
    "m": "0004 03142320 23344340", "n": "0004 0314344340", "o": "100103143443413010", "p": "0804 043443413000", "q": "4844 441403011040",
    "r": "0004 031434", "s": "440402424000", "t": "16112030 0424", "u": "040110304044", "v": "042044", "w": "0410223044", "x": "0044 0440",
    "y": "0421 4408", "z": "04440040",
    "0": "100105163645413010 0145", "1": "051610", "2": "05163645440040", "3": "051636454433424130" "1001 1333", "4": "30360242",
    "5": "460603334241301001", "6": "4536160501103041423303", "7": "064610", "8": "13040516364544331302011030414233", "9": "0110304145361605041343",
    ".": "00", ",": "1100", "-": "0333", "+": "0343 2125", "/": "0046", ":": "01 04", ";": "1100 14", "=": "0242 0444", "_": "0040",
    "(": "16050110", ")": "06151100", "*": "0343 1135 1531", "!": "00 0206", "?": "0516364544332322 20", "'": "0506", "<": "450341", ">": "054301",
}  # fmt: skip
_UNKNOWN = "0006464000"
#: What lies between two letters, as a part of the height of capitals.
GAP = _GAP / _CAPITAL


@cache
def _strokes(letter: str) -> tuple[float, tuple[Stroke, ...]]:
    """Return the width of a letter and its strokes, in units of the grid; a box where none is known."""
    if letter == " ":
        return _BLANK, ()
    strokes = tuple(
        tuple(complex(int(part[k]), (int(part[k + 1]) + 2) % 10 - 2) for k in range(0, len(part), 2))
        for part in _GLYPHS.get(letter, _UNKNOWN).split()
    )
    return max(point.real for stroke in strokes for point in stroke), strokes


def strokes(text: str, height: float, gap: float = 1.0) -> list[Stroke]:
    """Return the strokes of a line of text from 0 on along X, for capitals of a height; `gap` scales what lies between letters."""
    found: list[Stroke] = []
    scale, at = height / _CAPITAL, 0.0
    for letter in text:
        width, glyph = _strokes(letter)
        found += [tuple((point + at) * scale for point in stroke) for stroke in glyph]
        at += width + _GAP * gap
    return found


def engraved(
    cutter: FlatCutter, letters: Iterable[Stroke], levels: tuple[float, float], feeds: tuple[float, float]
) -> None:
    """Cut strokes, from a height above the part down to a depth, at the feeds downwards and along; the tool ends above."""
    above, depth = levels
    for stroke in letters:
        cutter.to(z=above, rapid=True)
        cutter.to(stroke[0], rapid=True)
        cutter.plunge(depth, *feeds)
        for point in stroke[1:]:
            cutter.to(point)
    cutter.to(z=above, rapid=True)

"""What is usually meant where the grammar finds something else: one line of help for a syntax error."""

from __future__ import annotations

import re

#: What stands before the place (its end is matched), what stands there, and the help.
_HINTS = tuple(
    (re.compile(before + r"\Z"), re.compile(there), text)
    for before, there, text in (
        (r"[0-9.]", r",[0-9]", "the decimal sign is a point"),
        (
            r"",
            r",[rc]",
            "chamfers ,C and roundings ,R are not read: write the line or arc as a block of its own",
        ),
        (r"c", r"r=", "CR= is a radius on Siemens' controls; here it is R"),
        (r"[0-9]\.[0-9]*", r"\.", "a number has one decimal point"),
        (r"[0-9.]", r"o", "is the letter O meant as a zero?"),
        (r"[0-9]", r"[il]", "is the letter meant as a one?"),
        (r"o[0-9]+", r"[a-z]", "a program number stands alone on its line"),
        (r"[a-mp-z]", r"=", "a word is a letter and its number (X5); = sets parameters (#5=3)"),
        (r"#", r"[a-z]", "the name of a parameter stands in < >: #<depth>"),
        (r"[0-9.\]>]", r"[+*-]", "a sum stands in brackets: X[10-5]"),
        (r"", r"/", "/ stands first in a block (block delete), or divides within brackets"),
    )
)
_STARTS_WITH_NUMBER = re.compile(r"\A[0-9]")
_WORDLESS = re.compile(r"(?:\A|[^a-z])([a-mp-z])[+-]?\Z")
_VALUE = re.compile(r"\Z|[a-z(;]")
_FUNCTION = re.compile(r"(abs|acos|asin|cos|exp|fix|fup|ln|round|sin|sqrt|tan|atan)\Z")


def hint_for(before: str, there: str) -> str:
    """Return a line of help for a place in a normalised block: what stands before it and from it on."""
    if not before and _STARTS_WITH_NUMBER.match(there):
        return "a block begins with a letter: is N missing before the number?"
    if _FUNCTION.search(before) and not there.startswith("["):
        return "the argument of a function stands in brackets: SIN[30]"
    if before.count("[") > before.count("]") and not there.startswith("]"):
        return "is a ] missing?" if not there or there[0].isalpha() else ""
    for left, right, text in _HINTS:
        if left.search(before) and right.match(there):
            return text
    return ""


def missing_number(before: str, there: str) -> str:
    """Return the letter that stands without its number before a place, or ""."""
    match = _WORDLESS.search(before)
    return match[1].upper() if match and _VALUE.match(there) else ""

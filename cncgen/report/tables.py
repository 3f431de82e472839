"""Tables of text: columns in line, numbers to the right, as Markdown writes them too."""

from __future__ import annotations

from collections.abc import Sequence


def text_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table with a rule under its header; the first column stands to the left, the others to the right."""
    return _table(header, rows, [True, *[False] * (len(header) - 1)])


def left_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table of words: every column stands to the left."""
    return _table(header, rows, [True] * len(header))


def _table(header: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[bool]) -> str:
    widths = [max(len(row[k]) for row in (header, *rows)) for k in range(len(header))]
    rule = [
        "-" * width if stays else "-" * (width - 1) + ":" for width, stays in zip(widths, left, strict=True)
    ]
    lines = []
    for row in (header, rule, *rows):
        cells = [
            cell.ljust(width) if stays else cell.rjust(width)
            for cell, width, stays in zip(row, widths, left, strict=True)
        ]
        lines.append(f"| {' | '.join(cells)} |\n")
    return "".join(lines)


def number(value: float | None, scale: float = 1.0, digits: int = 4) -> str:
    """Return a number with that many significant digits, a dash for None."""
    return "-" if value is None else f"{value * scale:.{digits}g}"

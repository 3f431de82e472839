"""Tables of text, columns in line as Markdown writes them too; numbers, counts and times for people."""

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


def counted(number: int, noun: str) -> str:
    """Return a number with its noun: ``1 motion``, ``2 motions``."""
    return f"{number} {noun}" + ("" if number == 1 else "s")


def duration(seconds: float) -> str:
    """Return a time: ``59.1234 s``, ``1:02.345 min``, ``1:02:03.456 h``."""
    if seconds < 59.99995:
        return f"{seconds:.4f} s"
    minutes, thousandths = divmod(round(1000.0 * seconds), 60_000)
    hours, minutes = divmod(minutes, 60)
    rest = f"{thousandths / 1000.0:06.3f}"
    return f"{hours}:{minutes:02d}:{rest} h" if hours else f"{minutes}:{rest} min"

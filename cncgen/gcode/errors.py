"""Faults of blocks as diagnostics: they are raised where they are found, and get their place in the text here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from cncgen.diagnostics import Diagnostic, Diagnostics, Severity, Span, excerpt_of
from cncgen.gcode.source import Source
from cncgen.grammars.terminals import FANUC

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from cncgen.gcode.text.labels import Cursor


class BlockError(Exception):
    """A fault of one block; the interpreter leaves the block there and goes on to the next.

    Attributes:
        code: Name of the diagnostic.
        message: One sentence with the numbers.
        word: The word to point at: a letter (``"X"``) or a letter with its number (``"G5.1"``), or "".
        column: 1-based column to point at where it is known, else 0.
        at: Index of the line that it is of, where that is not the one that is executed.
        place: That line itself, in runs whose lines have no index.
    """

    at: int | None = None
    place: Cursor | None = None

    def __init__(
        self,
        code: str,
        message: str,
        word: str = "",
        *,
        column: int = 0,
        length: int = 1,
        hint: str = "",
        values: Mapping[str, Any] = MappingProxyType({}),
    ) -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.word = word
        self.column = column
        self.length = length
        self.hint = hint
        self.values = values

    def within(self, place: str, word: str = "") -> BlockError:
        """Return the fault as that of a line which another one runs."""
        return BlockError(self.code, f"{place}: {self.message}", word, hint=self.hint, values=self.values)


def refuse(word: str, *faults: tuple[bool, str, str, str]) -> None:
    """Raise the first fault that holds: of each whether it does, its code, its message, and what helps ("": the cure of its code)."""
    for holds, code, message, hint in faults:
        if holds:
            raise BlockError(code, message, word, hint=hint)


class Stop(Exception):
    """The run ends here: a bound is reached, or the program aborts itself; carries the diagnostic's fault."""

    def __init__(self, error: BlockError) -> None:
        super().__init__(error.message)
        self.error = error


class Astray(Exception):
    """The calls and loops in progress lead nowhere; reading goes on at the first line that was not reached yet.

    Carries the diagnostic's fault, or None where it was reported before.
    """

    def __init__(self, error: BlockError | None = None) -> None:
        super().__init__(error.message if error else "")
        self.error = error


#: A comment, the name of a parameter, or a letter with all that may be its value (names of parameters are parts of values).
_TOKEN = rf"(?:{FANUC['COMMENT']})|\(.*|#\s*{FANUC['NAME']}|(?P<letter>[A-Za-z@^$])\s*(?P<value>(?:#\s*{FANUC['NAME']}|[^A-Za-z@^$(;])*)"


def locate(text: str, word: str) -> tuple[int, int]:
    """Return 1-based column and length of a word (``X`` or ``G5.1``) in a line's text, or of its first character."""
    blank = len(text) - len(text.lstrip())
    if not word:
        return blank + 1, 1
    found = _sign(text, word)
    if found is not None:
        return found
    import re

    letter, number = word[:1].upper(), word[1:]
    fallback: tuple[int, int] | None = None
    for match in re.finditer(_TOKEN, text):
        if match["letter"] is None or match["letter"].upper() != letter:
            continue
        place = match.start() + 1, max(1, len(match.group().rstrip()))
        if not number or _same(match["value"], number):
            return place
        fallback = fallback or place
    if fallback:
        return fallback
    return blank + 1, 1


def _sign(text: str, word: str) -> tuple[int, int] | None:
    """Return column and length of ``#``, ``#518``, ``<``, a keyword or ``,R``; None for other words."""
    if word in ("#", "<"):
        return text.find(word) + 1 or 1, 1
    if word[:1] == "#":
        return (text.find(word) + 1, len(word)) if word in text else _sign(text, "#")
    if len(word) > 1 and word.isalpha():
        import re

        keyword = re.search(rf"(?<![A-Za-z]){word}", text, re.IGNORECASE) or re.search(
            word, text, re.IGNORECASE
        )
        return (keyword.start() + 1, len(word)) if keyword else None
    if word[:1] == ",":
        import re

        corner = re.search(rf",\s*{word[1:]}[^A-Za-z@^$(;,]*", text, re.IGNORECASE)
        return (corner.start() + 1, len(corner.group().rstrip())) if corner else (1, 1)
    return None


def _same(written: str, number: str) -> bool:
    """Tell whether the text of a word's value is that number (``05.10`` is 5.1)."""
    try:
        return abs(float("".join(written.split())) - float(number)) < 1e-9
    except ValueError:
        return False


def _cure(code: str) -> str:
    """Return the hint for a fault without one of its own."""
    from cncgen.explanations import cure_of

    return cure_of("gcode", code)


class Reporter:
    """Places faults in their source and adds them to the run's diagnostics."""

    def __init__(self, diagnostics: Diagnostics) -> None:
        self.diagnostics = diagnostics
        self.on_error: Callable[[], None] = lambda: None

    def report(
        self, source: Source, line: int, offset: int, error: BlockError, severity: Severity = Severity.ERROR
    ) -> None:
        """Add the diagnostic of a fault found in the line that begins at byte `offset` of `source`."""
        if severity is Severity.ERROR:
            self.on_error()
        text = source.text_at(offset)
        column, length = error.column, error.length
        if not column:
            column, length = locate(text, error.word)
        text, line, column = source.written(offset, line, column)
        excerpt, cut = excerpt_of(text, column)
        self.diagnostics.add(
            Diagnostic(
                error.code,
                error.message,
                severity,
                Span(source.name, line, column, length),
                excerpt,
                cut,
                error.hint or _cure(error.code),
                error.values,
            )
        )

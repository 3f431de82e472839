"""A fault, its place, its numbers and a remedy: records that stages gather and the CLI renders once.

A user's mistake is a `Diagnostic`, collected in a `Diagnostics` list so that one run names every fault. Exceptions end the work:
`ProgramError` (exit 1), `UsageError` (exit 2), `NoPlanError` (exit 3).
"""

from __future__ import annotations

import copyreg
import math
from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType

from cncgen.records import StrEnum, dataclass, field

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def _read_only(values: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    """Return a read-only mapping: the form in which one is pickled."""
    return MappingProxyType(values)


# Records hold read-only mappings, which pickle does not know by itself.
copyreg.pickle(MappingProxyType, lambda mapping: (_read_only, (dict(mapping),)))

#: Diagnostics kept of one run; later ones are counted only, so that a million bad lines stay bounded.
MAX_KEPT = 1000

#: Diagnostics with the same message that are kept: more would only repeat the same fault for every line of a program.
MAX_ALIKE = 10

#: Diagnostics that the text of an exception holds, which a notebook prints whole; all are in its `diagnostics`.
MAX_TOLD = 20

#: Characters of a source line that a diagnostic keeps (a line may be 100 MB long).
MAX_EXCERPT = 200

#: Control characters are replaced by pictures, so that the text of a program cannot control the terminal. Those of the direction of
#: writing would show words in another order than they are read (Unicode Standard Annex #9, table 4).
_DIRECTIONS = (0x061C, 0x200E, 0x200F, *range(0x202A, 0x202F), *range(0x2066, 0x206A))
CONTROLS = {code: 0x2400 + code for code in range(0x20)} | dict.fromkeys(
    (*range(0x7F, 0xA0), *_DIRECTIONS), 0xFFFD
)


def one_line(text: str) -> str:
    """Return a text that names a file, in one line: names may hold line feeds, and whatever follows one would look like a message."""
    return text.translate(CONTROLS)


class Severity(StrEnum):
    """How bad: an error ends in exit 1, a warning and a note do not."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True, slots=True)
class Span:
    """A place in a source text: `line` and `column` count from 1; `length` characters are meant (0: a point)."""

    file: str
    line: int
    column: int = 1
    length: int = 1


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One fault or remark.

    Attributes:
        code: Stable kebab-case name (``arc-radius``) for tests and scripts.
        message: One sentence with the numbers and their units.
        severity: Error, warning or note.
        span: The place, or None without a place in a text.
        excerpt: The source line (cut around the column to `MAX_EXCERPT`), or "".
        excerpt_offset: Characters cut off on the left of `excerpt`.
        hint: A remedy, or "".
        values: The numbers of the message by name, for ``--json``.
    """

    code: str
    message: str
    severity: Severity = Severity.ERROR
    span: Span | None = None
    excerpt: str = ""
    excerpt_offset: int = 0
    hint: str = ""
    values: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def render(self) -> str:
        """Return the text for a person: ``file:line:col: severity[code]: message``, the line, a caret, the hint."""
        place = f"{self.span.file}:{self.span.line}:{self.span.column}: " if self.span else ""
        text = one_line(f"{place}{self.severity}[{self.code}]: {self.message}")
        if self.span and self.excerpt:
            caret = max(self.span.column - 1 - self.excerpt_offset, 0)
            marks = "^" * max(1, min(self.span.length, len(self.excerpt) - caret))
            text += f"\n{self.span.line:5d} | {self.excerpt}\n      | {' ' * caret}{marks}"
        if self.hint:
            text += f"\n  help: {self.hint}"
        return text

    def as_json(self) -> dict[str, Any]:
        """Return the record as plain values for one JSON line."""
        place = self.span
        return {
            "code": self.code,
            "severity": str(self.severity),
            "message": self.message,
            "file": place.file if place else None,
            "line": place.line if place else None,
            "column": place.column if place else None,
            "hint": self.hint or None,
            "explain": f"cncgen explain {self.code}",
            "values": json_values(self.values),
        }


def json_values(value: Any) -> Any:
    """Return values as JSON has them: numpy's as Python's, and null for what is not finite (JSON has no NaN)."""
    if isinstance(value, Mapping):
        return {str(key): json_values(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [json_values(item) for item in value]
    if hasattr(value, "tolist"):
        return json_values(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if isinstance(value, str | int | None) else str(value)


def excerpt_of(line: str, column: int) -> tuple[str, int]:
    """Cut a source line to `MAX_EXCERPT` characters around a 1-based column; return the text and what was cut left."""
    line = line.rstrip("\r\n").replace("\t", " ").translate(CONTROLS)
    if len(line) <= MAX_EXCERPT:
        return line, 0
    start = max(0, min(column - 1 - MAX_EXCERPT // 2, len(line) - MAX_EXCERPT))
    return line[start : start + MAX_EXCERPT], start


class Diagnostics:
    """A growing list of diagnostics that keeps the first `MAX_KEPT`, `MAX_ALIKE` of one message, and counts all."""

    def __init__(self, items: Iterable[Diagnostic] = ()) -> None:
        self._kept: list[Diagnostic] = []
        self._alike: dict[tuple[Severity, str, str], int] = {}
        self.counts = dict.fromkeys(Severity, 0)
        self.extend(items)

    def add(self, item: Diagnostic) -> None:
        """Count a diagnostic, and keep it while there is room for it and for more that say the same."""
        self.counts[item.severity] += 1
        key = item.severity, item.code, item.message
        alike = self._alike.get(key, 0)
        if len(self._kept) < MAX_KEPT and alike < MAX_ALIKE:
            self._alike[key] = alike + 1
            self._kept.append(item)

    def extend(self, items: Iterable[Diagnostic]) -> None:
        """Add each of several diagnostics."""
        for item in items:
            self.add(item)
        if isinstance(items, Diagnostics):  # those beyond the kept ones stay counted
            for severity, count in items.counts.items():
                self.counts[severity] += count - sum(item.severity == severity for item in items)

    @property
    def has_errors(self) -> bool:
        """Tell whether an error was counted."""
        return self.counts[Severity.ERROR] > 0

    @property
    def total(self) -> int:
        """Return how many were counted."""
        return sum(self.counts.values())

    @property
    def suppressed(self) -> int:
        """Return how many were counted and not kept."""
        return self.total - len(self._kept)

    def __iter__(self) -> Iterator[Diagnostic]:
        return iter(self._kept)

    def __len__(self) -> int:
        return len(self._kept)

    def __repr__(self) -> str:
        counts = ", ".join(f"{n} {severity}{'s' * (n != 1)}" for severity, n in self.counts.items() if n)
        return f"Diagnostics({counts or 'none'})"


class RunDiagnostics(Diagnostics):
    """Findings of one run over a source, added to those of all runs over it (`whole`).

    Every run finds the same in the same order, so diagnostics of an earlier run are ignored: a program that is
    planned and then judged has each of its faults once.
    """

    def __init__(self, whole: Diagnostics) -> None:
        super().__init__()
        self._whole = whole

    def add(self, item: Diagnostic) -> None:
        """Count a diagnostic, and add it to the whole where no run has come so far yet."""
        super().add(item)
        if self.total > self._whole.total:
            self._whole.add(item)


def more(suppressed: int) -> str:
    """Return the text about diagnostics that were counted and not kept."""
    return f"{suppressed} more {'was' if suppressed == 1 else 'were'} counted and {'is' if suppressed == 1 else 'are'} not shown"


class RemarkWarning(UserWarning):
    """A remark of a stage that collects none, as a Python warning; the CLI shows its `diagnostic`."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        self.diagnostic = diagnostic
        super().__init__(diagnostic)

    def __str__(self) -> str:
        return self.diagnostic.render()


class CncgenError(Exception):
    """Base of the exceptions that end the work.

    Attributes:
        exit_code: Exit code of the command line.
        diagnostics: The faults.
        suppressed: How many more were counted and not kept.
    """

    exit_code = 1

    def __init__(self, diagnostics: Iterable[Diagnostic] | Diagnostic) -> None:
        items = [diagnostics] if isinstance(diagnostics, Diagnostic) else list(diagnostics)
        self.diagnostics = items
        self.suppressed = diagnostics.suppressed if isinstance(diagnostics, Diagnostics) else 0
        said = [d.render() for d in items[:MAX_TOLD]]
        left = len(items) - len(said) + self.suppressed
        super().__init__("\n".join([*said, more(left)] if left else said))

    def __reduce__(self) -> tuple[type[CncgenError], tuple[list[Diagnostic]], dict[str, Any]]:
        """Pickle by the diagnostics, of which the text is made: errors come back from other processes whole."""
        return type(self), (self.diagnostics,), {"suppressed": self.suppressed, "args": self.args}


class ProgramError(CncgenError):
    """The program has errors."""


class UsageError(CncgenError):
    """Wrong usage, an unreadable file, a bad machine file."""

    exit_code = 2


class NoPlanError(CncgenError):
    """No plan exists within the limits."""

    exit_code = 3

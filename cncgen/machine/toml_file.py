"""TOML files that people write: their text with the places of keys, so that every fault is named by its line."""

from __future__ import annotations

import re
import tomllib
from datetime import date, datetime, time
from typing import Any

from cncgen.diagnostics import Diagnostic, Diagnostics, Span, UsageError, excerpt_of


class TomlFile:
    """The text of a TOML file and the faults found in it."""

    def __init__(self, name: str, text: str) -> None:
        self.name = name
        self.lines = text.splitlines()
        self.places = key_places(self.lines)
        self.faults = Diagnostics()

    def fault(self, code: str, path: str, message: str, hint: str = "", **values: Any) -> None:
        """Note a fault at a key path; see `placed`."""
        self.faults.add(self.placed(code, path, message, hint, **values))

    def placed(self, code: str, path: str, message: str, hint: str = "", **values: Any) -> Diagnostic:
        """Return a fault at a key path, with the line of the key or of the nearest table above it."""
        # A table that stands only in the headers of those below it is shown at the first of them.
        near = next((place for place in self.places if place == path or place.startswith(f"{path}.")), path)
        while near and near not in self.places:
            near = near.rpartition(".")[0]
        span, excerpt, cut = None, "", 0
        if near:
            line, column, length = self.places[near]
            excerpt, cut = excerpt_of(self.lines[line - 1], column)
            span = Span(self.name, line, column, length)
        elif self.name:
            message = f"{self.name}: {message}"
        return Diagnostic(
            code,
            message,
            span=span,
            excerpt=excerpt,
            excerpt_offset=cut,
            hint=hint,
            values={"key": path, **values},
        )

    def raise_faults(self) -> None:
        """Raise the faults, in the order of the file."""
        if self.faults.has_errors:
            raise UsageError(sorted(self.faults, key=lambda fault: fault.span.line if fault.span else 0))


#: A name of a key, bare or in quotes.
_KEY = r"(?:[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*')"


def key_places(lines: list[str]) -> dict[str, tuple[int, int, int]]:
    """Find where keys stand in a TOML text: key path to line and column (from 1) and length.

    It knows ``[table]`` headers and ``key = value`` lines, as in machine files; a key that it misses is only shown without its line.
    """
    places: dict[str, tuple[int, int, int]] = {}
    table = ""
    for number, line in enumerate(lines, start=1):
        header = re.match(r"\s*\[\s*([^\[\]]+?)\s*\]", line)
        key = re.match(rf"\s*({_KEY}(?:\s*\.\s*{_KEY})*)\s*=", line)
        if header:
            table = re.sub(r"[\s\"]", "", header[1])
            places.setdefault(table, (number, header.start(1) + 1, len(header[1])))
        elif key:
            name = "".join(part.strip("\"'") for part in re.findall(rf"{_KEY}|\.", key[1]))
            path = f"{table}.{name}" if table else name
            places.setdefault(path, (number, key.start(1) + 1, len(key[1])))
    return places


def parse_toml(content: bytes, name: str, kind: str = "machine") -> tuple[dict[str, Any], str]:
    """Return the tables of a TOML file, and its text.

    Args:
        content: UTF-8 text.
        name: Name of the file in messages.
        kind: Name of the thing that the file describes; codes of diagnostics begin with it.

    Raises:
        UsageError: It is not UTF-8, not TOML, or nested beyond reason.
    """
    code = f"{kind}-syntax"
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise UsageError(_encoding_fault(content, name, error.start, code)) from error
    try:
        return tomllib.loads(text), text
    except tomllib.TOMLDecodeError as error:
        raise UsageError(_syntax_fault(text, name, str(error), kind)) from error
    except ValueError as error:  # an integer of more digits than Python converts
        digits = re.search(r"[0-9_]{4300,}", text)
        message = f"an integer has too many digits{f': {len(digits[0])}' if digits else ''}"
        raise UsageError(_fault_at(digits.start() if digits else 0, text, name, code, message)) from error
    except RecursionError as error:
        message = f"{name}: tables or arrays are nested too deeply"
        raise UsageError(Diagnostic(code, message)) from error


def _encoding_fault(content: bytes, name: str, at: int, code: str) -> Diagnostic:
    """Return the diagnostic of a file whose byte `at` is the first that is not UTF-8."""
    before = content[:at].decode("utf-8-sig")
    text = before + content[at:].decode("cp1252", "replace")
    message = f"byte 0x{content[at]:02x} is not UTF-8, which TOML files are"
    return _fault_at(len(before), text, name, code, message, "save the file as UTF-8")


def _fault_at(at: int, text: str, name: str, code: str, message: str, hint: str = "") -> Diagnostic:
    """Return a diagnostic of the place of the character `at` in a text."""
    begin = text.rfind("\n", 0, at) + 1
    line, column = text.count("\n", 0, at) + 1, at - begin + 1
    excerpt, cut = excerpt_of(text[begin:].partition("\n")[0], column)
    return Diagnostic(
        code, message, span=Span(name, line, column), excerpt=excerpt, excerpt_offset=cut, hint=hint
    )


def _syntax_fault(text: str, name: str, message: str, kind: str) -> Diagnostic:
    """Turn tomllib's message, which ends in ``(at line 3, column 5)``, into a diagnostic with its place."""
    place = re.search(r"\s*\(at (?:line (\d+), column (\d+)|end of document)\)$", message)
    if not place:
        return Diagnostic(f"{kind}-syntax", f"{name}: {message}")
    lines = text.split("\n")
    last = text.rstrip().split("\n")
    line, column = (int(place[1]), int(place[2])) if place[1] else (len(last), len(last[-1]) + 1)
    row = lines[line - 1] if line <= len(lines) else ""
    excerpt, cut = excerpt_of(row, column)
    said = message[: place.start()]
    twice = re.fullmatch(r"Cannot declare \((.*?),?\) twice", said)
    if twice:
        path = ".".join(re.findall("'([^']*)'", twice[1]))
        said = f"the table [{path}] stands twice"
    elif said == "Cannot overwrite a value":
        said = f"the key {row.partition('=')[0].strip()} stands twice in its table"
    before, there = row[: column - 1], row[column - 1 :]
    return Diagnostic(
        f"{kind}-syntax",
        said,
        span=Span(name, line, column),
        excerpt=excerpt,
        excerpt_offset=cut,
        hint=next((help for a, b, help in _SYNTAX_HINTS if re.search(a, before) and re.match(b, there)), ""),
    )


#: Text before the place of a fault of syntax, text at the place, and the text that is meant.
_SYNTAX_HINTS = (
    (r"", r"\0", "is it UTF-16 without its mark? save it as UTF-8"),
    (r"[0-9]$", r",\s*[0-9]", "the decimal sign is a point: 250.0"),
    (r"=\s*$", r"[“”„‘’«]", 'texts stand in straight quotes: name = "mine"'),
    (r"=\s*$", r"[A-Za-z_./\\]", 'texts stand in quotes: name = "mine"; the file is to be TOML, not INI'),
    (r"^[\w.-]+\s*$", r":", 'this is YAML; the file is to be TOML: name = "mine", tables as [axes.x]'),
    (r"^\s*$", r"[{<]", 'this is JSON or XML; the file is to be TOML: name = "mine", tables as [axes.x]'),
)


def is_toml_number(value: Any) -> bool:
    """Tell a number from everything else, truth values included."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def toml_value_shown(value: Any) -> str:
    """Return a value as text for a message: short."""
    kinds: dict[type, str] = {
        bool: "a truth value",
        str: "a text",
        dict: "a table",
        list: "an array",
        date: "a date",
        datetime: "a date",
        time: "a time of day",
    }
    text = value.isoformat() if isinstance(value, date | time) else repr(value)
    text = text if len(text) <= 40 else text[:37] + "..."
    return f"{kinds[type(value)]} ({text})" if type(value) in kinds else text

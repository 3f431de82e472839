"""Diagnostics of an exchange structure: from an offset in the file to line, column, excerpt."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cncgen.diagnostics import Diagnostic, Diagnostics, Severity, Span, excerpt_of

#: Places of one code that are reported; the rest is counted in one more diagnostic by `Reporter.close`.
MAX_OF_A_CODE = 50


class Reporter:
    """Makes diagnostics of offsets of a file and collects them, each place of a code once."""

    def __init__(self, name: str, data: bytes, diagnostics: Diagnostics) -> None:
        self.name = name
        self.diagnostics = diagnostics
        self._data = data
        self._ends: np.ndarray | None = None
        self._seen: dict[str, set[int | str]] = {}
        self._dropped: dict[str, tuple[int, Severity]] = {}
        #: Codes whose count is reported: a program that is executed again adds no more of them.
        self._counted: set[str] = set()

    def line_of(self, offset: int) -> int:
        """Return the line, from 1, of an offset."""
        return int(np.searchsorted(self._line_ends(), offset)) + 1

    def lines_of(self, offsets: np.ndarray) -> np.ndarray:
        """Return the lines, from 1, of offsets, shape as given."""
        return np.searchsorted(self._line_ends(), offsets) + 1

    def _line_ends(self) -> np.ndarray:
        if self._ends is None:
            self._ends = np.flatnonzero(np.frombuffer(self._data, np.uint8) == 10)
        return self._ends

    def report(
        self,
        code: str,
        message: str,
        offset: int | None = None,
        *,
        severity: Severity = Severity.ERROR,
        length: int = 1,
        hint: str = "",
        values: Mapping[str, Any] | None = None,
    ) -> None:
        """Add a diagnostic at an offset (None: of the file); one of that code that was there already is dropped.

        It was there where it had the same offset, or of the file the same message.
        """
        seen = self._seen.setdefault(f"{severity} {code}", set())
        key = message if offset is None else offset
        if key in seen:
            return
        if len(seen) >= MAX_OF_A_CODE:
            if code not in self._counted:
                self._dropped[code] = (self._dropped.get(code, (0, severity))[0] + 1, severity)
            return
        seen.add(key)
        span, excerpt, cut = None, "", 0
        if offset is not None:
            span, excerpt, cut = self._place(offset, length)
        self.diagnostics.add(
            Diagnostic(code, message, severity, span, excerpt, cut, hint, dict(values) if values else {})
        )

    def _place(self, offset: int, length: int) -> tuple[Span, str, int]:
        ends = self._line_ends()
        index = int(np.searchsorted(ends, offset))
        start = int(ends[index - 1]) + 1 if index else 0
        stop = int(ends[index]) if index < len(ends) else len(self._data)
        first = max(start, offset - 2000)
        left = self._data[first:offset].decode("utf-8", "replace")
        text = left + self._data[offset : min(stop, offset + 2000)].decode("utf-8", "replace")
        before = first - start
        excerpt, cut = excerpt_of(text, len(left) + 1)
        return Span(self.name, index + 1, before + len(left) + 1, length), excerpt, before + cut

    def close(self) -> None:
        """Say of each code how many more places were not reported."""
        for code, (count, severity) in self._dropped.items():
            text = f"{count} more of these in the file"
            self.diagnostics.add(Diagnostic(code, text, severity, Span(self.name, 1)))
        self._counted.update(self._dropped)
        self._dropped = {}

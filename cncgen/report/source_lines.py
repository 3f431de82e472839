"""The text of lines of a program, for tables that name them."""

from __future__ import annotations

import io
import os
from collections import defaultdict
from collections.abc import Iterable
from contextlib import suppress
from itertools import islice

from cncgen.diagnostics import excerpt_of
from cncgen.files import WIDE_MARK, as_utf8, is_wide

#: Characters of a line that are shown.
MOST_CHARACTERS = 60


def source_lines(places: Iterable[tuple[str, int]]) -> dict[tuple[str, int], str]:
    """Return the text of lines of files, cut to `MOST_CHARACTERS`.

    Args:
        places: Files with numbers of lines, from 1. Places outside regular files, in files that cannot be read and
            beyond their ends are left out.
    """
    wanted: dict[str, set[int]] = defaultdict(set)
    for name, line in places:
        wanted[name].add(line)
    found: dict[tuple[str, int], str] = {}
    for name, lines in wanted.items():
        with suppress(OSError, ValueError):
            if os.path.isfile(name):
                found |= {(name, line): text for line, text in _lines(name, lines)}
    return found


def _lines(name: str, wanted: set[int]) -> Iterable[tuple[int, str]]:
    with open(name, "rb") as file:
        lines = io.BytesIO(as_utf8(file.read())) if is_wide(file.peek(WIDE_MARK)) else file
        for number, raw in enumerate(islice(lines, max(wanted)), start=1):
            if number in wanted:
                text, _ = excerpt_of(raw[: 4 * MOST_CHARACTERS + 4].decode("utf-8", "replace").strip(), 1)
                yield number, text if len(text) <= MOST_CHARACTERS else text[: MOST_CHARACTERS - 1] + "…"

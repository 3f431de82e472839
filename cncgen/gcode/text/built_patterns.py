"""Patterns that were compiled when the package was built: a check of a plain program need not import `re`."""

from __future__ import annotations

import _sre  # type: ignore[import-not-found]
from importlib import import_module

TYPE_CHECKING = False
if TYPE_CHECKING:
    import re

_known: dict[bytes, re.Pattern[bytes]] = {}
_codes: dict[bytes, tuple[int, tuple[str | None, ...], bytes]] | None = None


def compiled(pattern: bytes) -> re.Pattern[bytes]:
    """Return a pattern, compiled; those of `signs.patterns` are compiled already (``grammars/patterns.py``)."""
    found = _known.get(pattern)
    if found is None:
        found = _known[pattern] = _built(pattern)
    return found


def _built(pattern: bytes) -> re.Pattern[bytes]:
    """Return a pattern by its code; by `re` where it has none that this engine takes."""
    global _codes
    if _codes is None:
        try:
            made = import_module("cncgen.grammars.pattern_codes")
        except ImportError:  # a source tree that was not built
            _codes = {}
        else:
            _codes = made.CODES if made.MAGIC == _sre.MAGIC else {}
    if pattern not in _codes:
        import re

        return re.compile(pattern)
    flags, names, code = _codes[pattern]
    groups = {name: k for k, name in enumerate(names) if name is not None}
    return _sre.compile(pattern, flags, memoryview(code).cast("I").tolist(), len(names) - 1, groups, names)

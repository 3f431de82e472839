"""How records show themselves in a notebook: rooms above say it, records ask here.

Records are independent of pages. `cncgen.pipeline`, which is there wherever a result is, registers a function for each kind.
"""

from __future__ import annotations

from collections.abc import Callable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_KINDS: dict[str, Callable[[Any], str]] = {}


def shown_by(kind: str, function: Callable[[Any], str]) -> None:
    """Let a function give the HTML of all records of a class, by the name of the class."""
    _KINDS[kind] = function


def html_of(record: object) -> str | None:
    """Return the HTML of a record, or None where nothing is registered: its `repr` is shown then."""
    function = _KINDS.get(type(record).__name__)
    return function(record) if function is not None else None

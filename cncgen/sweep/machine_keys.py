"""Keys of machine files by their paths: the keys that a pattern matches, and a machine's tables with other values for them."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any

from cncgen.arguments import is_number
from cncgen.machine import Machine, to_toml
from cncgen.sweep.quantities import Value

Tables = dict[str, Any]


def tables_of(machine: Machine) -> Tables:
    """Return the tables of a machine's file."""
    return tomllib.loads(to_toml(machine))


def paths_of(tables: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    """Yield the path of each key of nested tables."""
    for key, value in tables.items():
        if isinstance(value, dict):
            yield from paths_of(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"


def matched(pattern: str, tables: Mapping[str, Any]) -> list[str]:
    """Return the paths that a pattern means: itself without ``*``, else those of the machine where ``*`` stands for one name."""
    if "*" not in pattern:
        return [pattern]
    wanted = pattern.split(".")
    return [
        path
        for path in paths_of(tables)
        if len(parts := path.split(".")) == len(wanted)
        and all(w in ("*", p) for w, p in zip(wanted, parts, strict=True))
    ]


def near_path(pattern: str, tables: Mapping[str, Any]) -> str:
    """Return a hint for a pattern that means no key: the nearest one, else where they are listed."""
    near = difflib.get_close_matches(pattern, list(paths_of(tables)), 1, 0.5)
    return f"did you mean {near[0]}?" if near else "cncgen machines keys lists the keys of machine files"


def value_at(tables: Mapping[str, Any], path: str) -> Any:
    """Return the value at a path, or None."""
    found: Any = tables
    for name in path.split("."):
        found = found.get(name) if isinstance(found, Mapping) else None
    return found


def with_value(tables: Tables, pattern: str, value: Value, relative: bool) -> Tables:
    """Return tables with another value at every path that a pattern means.

    Args:
        tables: Of a machine.
        pattern: As `matched` takes it.
        value: New value of the keys.
        relative: Whether it is a factor of their old values.
    """
    for path in matched(pattern, tables):
        before = value_at(tables, path)
        if relative and is_number(before) and is_number(value):
            tables = _with(tables, path.split("."), before * value)
        elif not relative:
            tables = _with(tables, path.split("."), value)
    return tables


def _with(tables: Tables, path: list[str], value: Any) -> Tables:
    """Return a copy of tables with a value at a path; tables off the path are shared with the original."""
    changed = dict(tables)
    inner = changed.get(path[0])
    if len(path) == 1:
        changed[path[0]] = value
    else:
        changed[path[0]] = _with(inner if isinstance(inner, dict) else {}, path[1:], value)
    return changed


def with_table(tables: Tables, path: str, table: Tables) -> Tables:
    """Return tables with another table at a path."""
    return _with(tables, path.split("."), table)

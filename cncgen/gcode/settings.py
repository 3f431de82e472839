"""What a machine's table ``[interpreter]`` says about how its control reads a program."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.toolpath.reading import ReadOptions

_DIALECTS = ("linuxcnc", "fanuc")
_KEYS = ("dialect", "least_increment_mm")


def interpreter_settings(table: Mapping[str, Any], options: ReadOptions) -> ReadOptions:
    """Return options with the settings of a machine: ``dialect``, and ``least_increment_mm`` for its decimal-point rule.

    Raises:
        UsageError: All that is wrong with the table, by key.
    """
    faults = [
        _fault(f"{key}: unknown key", f"known keys: {', '.join(_KEYS)}") for key in table if key not in _KEYS
    ]
    dialect, increment = table.get("dialect"), table.get("least_increment_mm")
    if dialect is not None and dialect not in _DIALECTS:
        faults.append(_fault(f"dialect: must be one of {', '.join(_DIALECTS)}"))
    if increment is not None and not (
        isinstance(increment, int | float)
        and not isinstance(increment, bool)
        and 0.0 < increment <= 1.0
        and math.isfinite(increment)
    ):
        faults.append(_fault("least_increment_mm: must be a number above 0, at most 1"))
    if faults:
        raise UsageError(faults)
    if dialect is not None and options.dialect == "auto":
        options = replace(options, dialect=str(dialect))
    if increment is not None and options.least_increment is None:
        options = replace(options, least_increment=float(increment))
    return options


def _fault(message: str, hint: str = "") -> Diagnostic:
    return Diagnostic("machine-interpreter", f"interpreter.{message}", hint=hint)

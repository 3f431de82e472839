"""A machine's table ``[interpreter]``: how its control reads a program."""

from __future__ import annotations

from collections.abc import Mapping

from cncgen.machine.settings_schema import check
from cncgen.records import replace
from cncgen.toolpath.reading import ReadOptions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def interpreter_settings(table: Mapping[str, Any], options: ReadOptions) -> ReadOptions:
    """Return options with the settings of a machine: ``dialect``, ``units``, and ``least_increment_mm`` for its decimal-point rule.

    Raises:
        UsageError: All that is wrong with the table, by key.
    """
    check("interpreter", table)
    dialect, increment = table.get("dialect"), table.get("least_increment_mm")
    if dialect is not None and options.dialect == "auto":
        options = replace(options, dialect=str(dialect))
    if "units" in table and options.units == "auto":
        options = replace(options, units=str(table["units"]))
    if increment is not None and options.least_increment is None:
        options = replace(options, least_increment=float(increment))
    return options

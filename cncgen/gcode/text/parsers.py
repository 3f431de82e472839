"""The kernel that parses blocks, with the tables of a dialect's grammar: one of each for all texts of a run."""

from __future__ import annotations

from functools import cache
from importlib import import_module

from cncgen.kernels.gcode_parse import Parser

#: Parameters below these numbers are plain storage.
STORED = {"linuxcnc": 5000, "fanuc": 1000}


def new_parser(dialect: str, increments: bool = False) -> Parser:
    """Return a parser of a dialect's grammar; lengths without a decimal point may count in least increments."""
    return Parser(import_module(f"cncgen.grammars.tables_{dialect}"), STORED[dialect], increments)


@cache
def parser(dialect: str, increments: bool) -> Parser:
    """Return the parser of all lines that are read one by one."""
    return new_parser(dialect, increments)

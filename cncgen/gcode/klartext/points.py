"""Patterns of Heidenhain's plain language: PATTERN DEF with points, rows, grids and circles, which CYCL CALL PAT visits (TNC 640)."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator, Sequence

from cncgen.gcode.block import Value
from cncgen.gcode.errors import BlockError
from cncgen.gcode.klartext import tables

_MOST = 10_000
_NAMES = ("NUMX", "NUMY", "NUM", "ROTX", "ROTY", "ROT", "START", "STEP", "DX", "DY", "D", "X", "Y", "Z")
#: Words that each kind must have.
_NEEDS = {"POS": "X Y", "ROW": "X Y D NUM", "PAT": "X Y DX DY NUMX NUMY", "FRAME": "X Y DX DY NUMX NUMY", "CIRC": "X Y D NUM", "PITCHCIRC": "X Y D STEP NUM"}  # fmt: skip
#: A place in X and Y, and how far above the surface of the cycle its own lies.
Place = tuple[complex, float]


def places(parts: Sequence[tuple[str, dict[str, Value]]], now: Callable[[Value], float]) -> list[Place]:
    """Return the places of PATTERN DEF, in the order of visits.

    Args:
        parts: The kind of each part, and its words.
        now: Gives the present value of a word.

    Raises:
        BlockError: A part misses a word or has one too many, or counts too many places.
    """
    found = list[Place]()
    for kind, given in parts:
        strange = next((name for name in given if name not in _NAMES), None)
        if strange:
            message, hint = f"{strange} of PATTERN DEF is not read", f"{' '.join(_NAMES)} are"
            raise BlockError("unsupported-block", message, "PATTERN", hint=hint)
        words = {name: now(value) for name, value in given.items()}
        missing = [name for name in _NEEDS[kind].split() if name not in words]
        if missing:
            message = f"{kind} of PATTERN DEF has no {missing[0]}"
            raise BlockError("cycle-words", message, "PATTERN", hint=f"{kind} has {_NEEDS[kind]}")
        found += [(place, words.get("Z", 0.0)) for place in _of_kind(kind, words)]
        if len(found) > _MOST:
            message = f"PATTERN DEF has more than {_MOST} places"
            raise BlockError("cycle-repeats", message, "PATTERN", hint="NUM counts them")
    return found


def of_table(text: str, name: str) -> list[Place]:
    """Return the places of a table of points (.PNT).

    Raises:
        BlockError: It has no column X and Y, or a row is not of numbers.
    """
    rows = tables.rows(text, name, "table of points")
    return [(complex(row.get("X", 0.0), row.get("Y", 0.0)), row.get("Z", 0.0)) for row in rows]


def _of_kind(kind: str, words: dict[str, float]) -> Iterator[complex]:
    first = complex(words["X"], words["Y"])
    across, down = words.get("NUMX", words.get("NUM", 1.0)), words.get("NUMY", 1.0)
    if not (across >= 1.0 and down >= 1.0 and across * down <= _MOST):
        message = f"{kind} of PATTERN DEF has {across:g} by {down:g} places"
        raise BlockError("cycle-repeats", message, "PATTERN", hint="NUM, or NUMX and NUMY, count them")
    if kind in ("CIRC", "PITCHCIRC"):
        step = words["STEP"] if kind == "PITCHCIRC" else 360.0 / round(across)
        for k in range(round(across)):
            yield first + cmath.rect(words["D"] / 2.0, math.radians(words.get("START", 0.0) + k * step))
        return
    turn = words.get("ROT", 0.0)
    along = words.get("DX", words.get("D", 0.0)) * cmath.rect(
        1.0, math.radians(turn + words.get("ROTX", 0.0))
    )
    aside = words.get("DY", 0.0) * cmath.rect(1.0, math.radians(90.0 + turn + words.get("ROTY", 0.0)))
    columns, rows = round(across), round(down)
    for row in range(rows):
        # Rows are visited to and fro.
        for column in range(columns) if row % 2 == 0 else range(columns - 1, -1, -1):
            if kind != "FRAME" or row in (0, rows - 1) or column in (0, columns - 1):
                yield first + column * along + row * aside

"""Patterns of Heidenhain's plain language: PATTERN DEF with points, rows, grids and circles, which CYCL CALL PAT visits (TNC 640)."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence

from cncgen.gcode.block import Value
from cncgen.gcode.codes.places import in_rows, on_circle
from cncgen.gcode.codes.steps import MOST
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.klartext import tables

_NAMES = ("NUMX", "NUMY", "NUM", "ROTX", "ROTY", "ROT", "START", "STEP", "DX", "DY", "D", "X", "Y", "Z")
#: Steps from the point before to another one.
_STEPS = ("IX", "IY")
#: Words that each kind must have.
_NEEDS = {"POS": "X Y", "ROW": "X Y D NUM", "PAT": "X Y DX DY NUMX NUMY", "FRAME": "X Y DX DY NUMX NUMY", "CIRC": "X Y D NUM", "PITCHCIRC": "X Y D STEP NUM"}  # fmt: skip
#: A place in X and Y, and how far above the surface of the cycle its own lies.
Place = tuple[complex, float]


def places(parts: Sequence[tuple[str, dict[str, Value]]], now: Callable[[Value], float]) -> list[Place]:
    """Return the places of PATTERN DEF, in the order of visits; raise where a part misses a word or has one too many, or counts too many places.

    Args:
        parts: The kind of each part, and its words.
        now: Gives the present value of a word.
    """
    found, before = list[Place](), dict[str, float]()
    for kind, given in parts:
        steps = _STEPS if kind == "POS" and before else ()
        strange = next((name for name in given if name not in (*_NAMES, *steps)), None)
        if strange:
            message, hint = f"{strange} of PATTERN DEF is not read", f"{' '.join(_NAMES)} are"
            raise BlockError("unsupported-block", message, "PATTERN", hint=hint)
        words = {name: now(value) for name, value in given.items()}
        words |= {name[1:]: words[name] + before[name[1:]] for name in steps if name in words}
        before = words if kind == "POS" else before
        missing = [name for name in _NEEDS[kind].split() if name not in words]
        if missing:
            message = f"{kind} of PATTERN DEF has no {missing[0]}"
            raise BlockError("cycle-words", message, "PATTERN", hint=f"{kind} has {_NEEDS[kind]}")
        found += [(place, words.get("Z", 0.0)) for place in _of_kind(kind, words)]
        many = f"PATTERN DEF has more than {MOST} places"
        refuse("PATTERN", (len(found) > MOST, "cycle-repeats", many, "NUM counts them"))
    return found


def of_table(text: str, name: str) -> list[Place]:
    """Return the places of a table of points (.PNT); raise where it has no column X and Y, or a row is not of numbers."""
    rows = tables.rows(text, name, "table of points")
    return [(complex(row.get("X", 0.0), row.get("Y", 0.0)), row.get("Z", 0.0)) for row in rows]


def _of_kind(kind: str, words: dict[str, float]) -> list[complex]:
    first = complex(words["X"], words["Y"])
    across, down = words.get("NUMX", words.get("NUM", 1.0)), words.get("NUMY", 1.0)
    counted = across >= 1.0 and down >= 1.0 and across * down <= MOST
    message = f"{kind} of PATTERN DEF has {across:g} by {down:g} places"
    refuse("PATTERN", (not counted, "cycle-repeats", message, "NUM, or NUMX and NUMY, count them"))
    if kind in ("CIRC", "PITCHCIRC"):
        step = words["STEP"] if kind == "PITCHCIRC" else 360.0 / round(across)
        return on_circle(first, words["D"] / 2.0, words.get("START", 0.0), step, round(across))
    turn, length = words.get("ROT", 0.0), words.get("DX", words.get("D", 0.0))
    along = cmath.rect(1.0, math.radians(turn + words.get("ROTX", 0.0))) * length
    aside = words.get("DY", 0.0) * cmath.rect(1.0, math.radians(90.0 + turn + words.get("ROTY", 0.0)))
    return in_rows(first, along, aside, round(across), round(down), frame=kind == "FRAME")

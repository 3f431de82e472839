"""Places of patterns of holes, in the languages of all controls: on a circle, and in rows that are visited to and fro."""

from __future__ import annotations

import cmath
import math


def on_circle(centre: complex, radius: float, start: float, step: float, count: int) -> list[complex]:
    """Return places on a circle about a centre, from an angle on, a step apart (degrees)."""
    return [centre + cmath.rect(radius, math.radians(start + k * step)) for k in range(count)]


def in_rows(
    origin: complex, along: complex, aside: complex, columns: int, rows: int, *, frame: bool = False
) -> list[complex]:
    """Return the places of a grid, or those on its frame alone: rows of `columns` places, one forth and the next back.

    Args:
        origin: The first place.
        along: From place to place of a row.
        aside: From row to row.
        columns: Places of a row.
        rows: How many there are.
        frame: Whether those within are left out.
    """
    return [
        origin + k * along + row * aside
        for row in range(rows)
        for k in (range(columns) if row % 2 == 0 else range(columns - 1, -1, -1))
        if not frame or row in (0, rows - 1) or k in (0, columns - 1)
    ]

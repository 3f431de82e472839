"""Steps of cycles of all languages: how many a way takes, and the levels that they lead to."""

from __future__ import annotations

import math

from cncgen.gcode.errors import BlockError

#: Steps of one cycle beyond which what makes them counts as a mistake.
MOST = 10_000
_TINY = 1e-9


def steps_of(way: float, step: float, word: str, makes: str, hint: str = "", least: int = 1) -> int:
    """Return how many steps a way takes, the least number where a step is not above 0; raise where they are more than `MOST`.

    Args:
        way: Their sum.
        step: The longest that one may be.
        word: The word to point at.
        makes: The message for too many steps; ``{}`` is replaced by their number.
        hint: Its help; if left out, the help names `MOST`.
        least: The fewest.
    """
    count = max(least, math.ceil(way / step - _TINY)) if step > 0.0 else least
    if count > MOST:
        raise BlockError("cycle-infeed", makes.format(count), word, hint=hint or f"at most {MOST} are made")
    return count


def levels_of(surface: float, depth: float, infeed: float, name: str) -> tuple[float, ...]:
    """Return the levels from a surface down to a depth, equal steps not deeper than an infeed; one where it is not above 0.

    Raises:
        BlockError: They are too many.
    """
    way = surface - depth
    count = steps_of(way, infeed, name, f"an infeed of {infeed:g} makes {{}} levels of {name}")
    return tuple(surface - way * (k + 1) / count for k in range(count))

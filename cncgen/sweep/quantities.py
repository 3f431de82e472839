"""The quantities of a sweep: a key of machine files or an option each, and the values that it takes.

A design gives numbers u between 0 and 1; a quantity turns them into values. A uniform u gives values of the quantity's own
law, by the inverse of its distribution function.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from cncgen.servo.identified_spread import IdentifiedSpread, normal_quantile

#: A value of a machine's key or of an option.
Value = float | int | bool | str

#: Laws of a range or of a distribution, with the names of their two numbers.
LAWS = {
    "linear": ("low", "high"),
    "uniform": ("low", "high"),
    "log": ("low", "high"),
    "normal": ("mean", "standard deviation"),
}


class Varied(Protocol):
    """The interface of everything that is varied.

    Attributes:
        key: As ``[vary]`` has it.
        columns: Names of the values in the results.
        relative: Whether values are factors on those of the machine.
        discrete: Whether only the levels of a list exist.
    """

    @property
    def key(self) -> str: ...
    @property
    def columns(self) -> tuple[str, ...]: ...
    @property
    def relative(self) -> bool: ...
    @property
    def discrete(self) -> bool: ...

    def values(self, u: Sequence[float]) -> tuple[Value, ...]:
        """Return a value a column, for a number u in [0, 1] a column."""

    def shares(self) -> tuple[float, ...]:
        """Return the numbers u that each column takes on a grid; none where the quantity does not say how many."""

    def extremes(self) -> tuple[Value, ...]:
        """Return values that show whether the machine can have them: ends of ranges, all levels."""


@dataclass(frozen=True, slots=True)
class Levels:
    """A list of values, each as often as the others."""

    key: str
    levels: tuple[Value, ...]
    relative: bool = False

    @property
    def columns(self) -> tuple[str, ...]:
        """The key itself."""
        return (self.key,)

    @property
    def discrete(self) -> bool:
        """True."""
        return True

    def values(self, u: Sequence[float]) -> tuple[Value, ...]:
        """Return the level whose part of [0, 1) holds u."""
        return (self.levels[min(int(u[0] * len(self.levels)), len(self.levels) - 1)],)

    def shares(self) -> tuple[float, ...]:
        """Return the middle of each level's part of [0, 1]."""
        return _middles(len(self.levels))

    def extremes(self) -> tuple[Value, ...]:
        """Return all levels."""
        return self.levels


@dataclass(frozen=True, slots=True)
class Range:
    """A range or a distribution.

    Attributes:
        law: One of `LAWS`.
        first, second: Its two numbers.
    """

    key: str
    law: str
    first: float
    second: float
    count: int | None = None
    relative: bool = False

    @property
    def columns(self) -> tuple[str, ...]:
        """The key itself."""
        return (self.key,)

    @property
    def discrete(self) -> bool:
        """False."""
        return False

    def values(self, u: Sequence[float]) -> tuple[Value, ...]:
        """Return the value below which the law has the share u."""
        share = u[0]
        if self.law == "normal":
            return (self.first + self.second * normal_quantile(share),)
        if self.law == "log":
            return (self.first * math.exp(share * math.log(self.second / self.first)),)
        return (self.first + share * (self.second - self.first),)

    def shares(self) -> tuple[float, ...]:
        """Return equal steps from end to end of a range, and the middles of equally probable parts of a distribution."""
        if self.count is None:
            return ()
        if self.law in ("uniform", "normal"):
            return _middles(self.count)
        return tuple(k / (self.count - 1) if self.count > 1 else 0.5 for k in range(self.count))

    def extremes(self) -> tuple[Value, ...]:
        """Return the ends; of a normal law, which has none, the mean."""
        return (self.first,) if self.law == "normal" else (self.first, self.second)


@dataclass(frozen=True, slots=True)
class UncertainServo:
    """The servo parameters that an identification found of an axis, drawn together.

    Attributes:
        key: ``axes.x.servo``.
        spread: What was found.
    """

    key: str
    spread: IdentifiedSpread
    count: int | None = None
    relative: bool = False

    @property
    def columns(self) -> tuple[str, ...]:
        """A column a parameter."""
        return tuple(f"{self.key}.{name}" for name in self.spread.names)

    @property
    def discrete(self) -> bool:
        """False."""
        return False

    def values(self, u: Sequence[float]) -> tuple[Value, ...]:
        """Return drawn parameters."""
        return self.spread.values(u)

    def shares(self) -> tuple[float, ...]:
        """Return the middles of equally probable parts."""
        return () if self.count is None else _middles(self.count)

    def extremes(self) -> tuple[Value, ...]:
        """Return the means."""
        return self.values([0.5] * len(self.spread.names))


def _middles(count: int) -> tuple[float, ...]:
    return tuple((k + 0.5) / count for k in range(count))

"""Printed values of the papers beside ours: rows with a tolerance stated in the paper's module, and tables of them.

A row of the paper is *reproduced* if ours meets its tolerance, *not reproduced* if it misses it (with the reason), and *not
reproducible* if the paper lacks the necessary data. Numbers that are taken from the paper are *inputs*, pictures without a quantity
are *drawings*, and values that a paper does not print are *checks of ours*. These do not count as reproduced.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

#: Share that a number may differ by from the printed one, where a module states no other: the papers measure, or print three digits.
WITHIN = 0.05
#: Share for values that follow from other printed numbers by arithmetic alone.
ARITHMETIC = 0.01


class RowKind(StrEnum):
    """Relation of a row to its paper."""

    PAPER = "paper"
    INPUT = "input"
    DRAWING = "drawing"
    OURS = "check of ours"


class RowOutcome(StrEnum):
    """Result of a row."""

    REPRODUCED = "reproduced"
    NOT_REPRODUCED = "not reproduced"
    NOT_REPRODUCIBLE = "not reproducible"
    INPUT = "input"
    DRAWING = "drawing"
    HOLDS = "ours holds"
    MISSED = "ours missed"


class Basis(StrEnum):
    """How our number came about.

    PREDICTED: nothing was chosen after looking at the printed number. CALIBRATED: something was fitted to this number or to others
    of its table. SCANNED: an unprinted choice was made by trying several and keeping the best fit. PRINTED: it follows from other
    printed numbers by arithmetic alone.
    """

    PREDICTED = "predicted"
    CALIBRATED = "calibrated"
    SCANNED = "chosen by scan"
    PRINTED = "from printed numbers"


#: The outcomes that count for a paper, in the order of every summary.
COUNTED = (
    RowOutcome.REPRODUCED,
    RowOutcome.NOT_REPRODUCED,
    RowOutcome.NOT_REPRODUCIBLE,
    RowOutcome.INPUT,
    RowOutcome.DRAWING,
)

_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:/(?P<below>\d+))?(?:×10(?P<sign>⁻?)(?P<power>[⁰¹²³⁴⁵⁶⁷⁸⁹]+))?")
_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789")


def number_in(text: str) -> float | None:
    """Return the first number of printed characters, ``3.25×10⁻⁶ m`` or ``1/3 sec`` say; None without a number."""
    found = _NUMBER.search(re.sub(r"(?<=\d),(?=\d{3})", "", text))
    if found is None:
        return None
    mantissa = found.group().partition("×")[0].partition("/")[0]
    power = int((found["power"] or "0").translate(_RAISED))
    return float(f"{mantissa}e{-power if found['sign'] else power}") / float(found["below"] or 1)


@dataclass(frozen=True, slots=True)
class Row:
    """A number, figure or claim of a paper, or a check of ours.

    Attributes:
        what: Its description.
        ours: Our value, or None.
        printed: The paper's own characters; empty where it prints nothing.
        unit: Unit of both values.
        within: Largest share that ours may differ by from the printed (or expected) value, or None.
        at_most, at_least: Bounds on ours, or None.
        basis: How ours came about; None for inputs and drawings.
        sensitivity: Our values under other choices of something that the paper leaves open: the choice, and the value.
        reason: Why it is not reproduced, or not reproducible.
        kind: Relation of the row to its paper.
        scale: Unit of the printed characters over `unit`.
        expected: Value that a check of ours is held against.
    """

    what: str
    ours: float | None = None
    printed: str = ""
    unit: str = ""
    within: float | None = None
    at_most: float | None = None
    at_least: float | None = None
    basis: Basis | None = Basis.PREDICTED
    sensitivity: tuple[tuple[str, float], ...] = ()
    reason: str = ""
    kind: RowKind = RowKind.PAPER
    scale: float = 1.0
    expected: float | None = None

    def __post_init__(self) -> None:
        """Refuse a row that no referee could judge: ours without a tolerance, or none of ours without a reason.

        Raises:
            ValueError: It is one.
        """
        asked = not (self.within is None and self.at_most is None and self.at_least is None)
        if self.kind is RowKind.DRAWING:
            return
        if self.ours is None and not self.reason:
            raise ValueError(f"{self.what}: no value of ours, and no reason")
        if self.ours is not None and not asked:
            raise ValueError(f"{self.what}: a value of ours without a tolerance")
        if self.kind is RowKind.PAPER and self.ours is not None and not self.printed:
            raise ValueError(f"{self.what}: nothing is printed, so it is a check of ours")

    @property
    def value(self) -> float | None:
        """Return the printed number in the row's unit, or the expected one of a check of ours, or None."""
        if self.expected is not None:
            return self.expected
        found = number_in(self.printed)
        return None if found is None else found * self.scale

    @property
    def holds(self) -> bool:
        """Tell whether ours meets its tolerance."""
        if self.ours is None:
            return False
        value = self.value
        near = self.within is None or (
            value is not None and abs(self.ours - value) <= self.within * abs(value) * (1.0 + 1e-12)
        )
        low = self.at_least is None or self.ours >= self.at_least
        high = self.at_most is None or self.ours <= self.at_most
        return near and low and high

    @property
    def outcome(self) -> RowOutcome:
        """Return the result of the row; an input that is not as printed counts as not reproduced."""
        if self.kind is RowKind.DRAWING:
            return RowOutcome.DRAWING
        if self.kind is RowKind.OURS:
            return RowOutcome.HOLDS if self.holds else RowOutcome.MISSED
        if self.ours is None:
            return RowOutcome.NOT_REPRODUCIBLE
        if not self.holds:
            return RowOutcome.NOT_REPRODUCED
        return RowOutcome.INPUT if self.kind is RowKind.INPUT else RowOutcome.REPRODUCED

    @property
    def explained(self) -> bool:
        """Tell whether the row stands as it should: it holds, or it says why it does not."""
        return self.outcome not in (RowOutcome.NOT_REPRODUCED, RowOutcome.MISSED) or bool(self.reason)

    @property
    def difference(self) -> float | None:
        """Return ours over the printed value, less one; None where no share of it is asked."""
        return (
            None
            if self.ours is None or self.within is None or not self.value
            else self.ours / self.value - 1.0
        )

    @property
    def asked(self) -> str:
        """Return the tolerance in words."""
        parts = []
        if self.within is not None:
            parts.append(f"±{100 * self.within:g} %" if self.within else "equal")
        if self.at_most is not None:
            parts.append(f"≤ {self.at_most:g}")
        if self.at_least is not None:
            parts.append(f"≥ {self.at_least:g}")
        return ", ".join(parts)


def given(what: str, printed: str, ours: float, unit: str = "", scale: float = 1.0) -> Row:
    """Return the row of a number that is taken over from the paper."""
    return Row(what, ours, printed, unit, within=1e-9, basis=None, kind=RowKind.INPUT, scale=scale)


def absent(what: str, printed: str, reason: str, unit: str = "") -> Row:
    """Return the row of an item that cannot be computed from the paper."""
    return Row(what, None, printed, unit, basis=None, reason=reason)


def drawing(what: str) -> Row:
    """Return the row of a diagram or a photograph, which holds no quantity."""
    return Row(what, basis=None, kind=RowKind.DRAWING)


@dataclass(frozen=True, slots=True)
class Table:
    """A table of a paper, or a group of its figures and numbers.

    Attributes:
        title: Paper and table.
        rows: The rows.
        assumptions: Assumptions that hold for all of them.
    """

    title: str
    rows: tuple[Row, ...]
    assumptions: tuple[str, ...] = ()

    @property
    def explained(self) -> bool:
        """Tell whether every row holds or says why it does not."""
        return all(row.explained for row in self.rows)


def counts(tables: Iterable[Table]) -> dict[RowOutcome, int]:
    """Return how many rows have each outcome, every outcome named."""
    found = dict.fromkeys(RowOutcome, 0)
    for table in tables:
        for row in table.rows:
            found[row.outcome] += 1
    return found

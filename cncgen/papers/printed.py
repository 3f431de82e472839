"""Printed values beside ours: figures with their tolerances, and tables of them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Row:
    """One figure.

    Attributes:
        what: What it is.
        ours: Our value.
        printed: The paper's value, or None where the tolerance is a bound of our own.
        unit: Unit of both.
        within: Largest share that ours may differ by from the printed one, or None.
        at_most, at_least: Bounds on ours, or None.
    """

    what: str
    ours: float
    printed: float | None = None
    unit: str = ""
    within: float | None = None
    at_most: float | None = None
    at_least: float | None = None

    @property
    def checked(self) -> bool:
        """Tell whether anything is asked of the figure."""
        return not (self.within is None and self.at_most is None and self.at_least is None)

    @property
    def holds(self) -> bool:
        """Tell whether what is asked of it holds; a figure that is only shown holds."""
        near = self.within is None or (
            self.printed is not None and abs(self.ours - self.printed) <= self.within * abs(self.printed)
        )
        low = self.at_least is None or self.ours >= self.at_least
        high = self.at_most is None or self.ours <= self.at_most
        return near and low and high

    @property
    def asked(self) -> str:
        """Return what is asked, in words."""
        parts = []
        if self.within is not None:
            parts.append(f"±{100 * self.within:g} %")
        if self.at_most is not None:
            parts.append(f"≤ {self.at_most:g}")
        if self.at_least is not None:
            parts.append(f"≥ {self.at_least:g}")
        return ", ".join(parts)


@dataclass(frozen=True, slots=True)
class Table:
    """A table of a paper.

    Attributes:
        title: Paper and table.
        rows: The figures.
        assumptions: Assumptions, and which figures are calibrated and which predicted.
    """

    title: str
    rows: tuple[Row, ...]
    assumptions: tuple[str, ...] = ()

    @property
    def holds(self) -> bool:
        """Tell whether every row holds."""
        return all(row.holds for row in self.rows)

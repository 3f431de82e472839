"""Types of values that click lacks; the types of files tell a shell which names to complete."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import click

from cncgen.extensions import FORMAT_GROUP, FORMATS, foreign_names
from cncgen.ranges import OPTION
from cncgen.units import AXIS_LETTERS

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem


class FiniteRange(click.FloatRange):
    """A number within bounds and `cncgen.ranges.OPTION`: ``nan`` passes every comparison of `click.FloatRange`, ``inf`` an open end."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number, or fail as click does."""
        try:
            value = float(value)
        except ValueError:
            within = "" if self.min is self.max is None else f" in the range {self._describe_range()}"
            self.fail(f"{value!r} is not a number{within}.", param, ctx)
        number = float(super().convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{value!r} is not a finite number.", param, ctx)
        low, high = OPTION
        if number and not low <= abs(number) <= high:
            self.fail(f"{value!r} is neither 0 nor within {low:g} and {high:g} but for its sign.", param, ctx)
        return number


class WholeRange(click.IntRange):
    """A whole number within bounds; a text that is none is refused with the bounds."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the number, or fail as click does."""
        try:
            number = int(value)
        except ValueError:
            self.fail(f"{value!r} is not a whole number in the range {self._describe_range()}.", param, ctx)
        return int(super().convert(number, param, ctx))


class Share(click.ParamType):
    """A share of something: ``10%``, or ``0.1``."""

    name = "share"

    def __init__(self, low: float, high: float) -> None:
        self._low, self._high = low, high

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the share as a number, or fail as click does."""
        text = str(value).strip()
        try:
            number = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
        except ValueError:
            self.fail(f"{value!r} is not a share, such as 10% or 0.1.", param, ctx)
        if not self._low <= number <= self._high:
            self.fail(f"{value!r} is not within {100 * self._low:g}% and {100 * self._high:g}%.", param, ctx)
        return number


class Uncertain(click.ParamType):
    """A share, summaries of ``cncgen identify``, or both by commas: ``10%``, ``x.json``, ``5%,x.json``."""

    name = "uncertain"

    def __init__(self, low: float, high: float) -> None:
        self._share = Share(low, high)

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, tuple[str, ...]]:
        """Return the share (0 without one) and the names of the files, or fail as click does."""
        if isinstance(value, tuple):
            return value
        parts = [part.strip() for part in str(value).split(",")]
        files = tuple(part for part in parts if part.endswith(".json"))
        shares = [self._share.convert(part, param, ctx) for part in parts if part not in files]
        if len(shares) > 1:
            self.fail(f"{value!r} has {len(shares)} shares; one is for all parameters.", param, ctx)
        return (shares[0] if shares else 0.0), files


class ModeList(click.ParamType):
    """Vibrations by commas, each a frequency in Hz and a damping: ``38:0.05,71:0.03``."""

    name = "modes"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[tuple[float, float], ...]:
        """Return pairs of frequency and damping, or fail as click does."""
        if isinstance(value, tuple):
            return value
        found = []
        for part in str(value).split(","):
            try:
                frequency, damping = (float(number) for number in part.split(":"))
            except ValueError:
                self.fail(f"{part!r} is not FREQUENCY:DAMPING, such as 38:0.05.", param, ctx)
            found.append((frequency, damping))
        return tuple(found)


class AxisLetters(click.ParamType):
    """Letters of axes, each once, as a word or by commas or blanks: ``XYZ``, ``x,y``; in the order given."""

    name = "letters"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the letters as a word of capitals, or fail as click does."""
        letters = "".join(str(value).replace(",", " ").split()).upper()
        if not letters or set(letters) - set(AXIS_LETTERS) or len(set(letters)) < len(letters):
            self.fail(f"{value!r} does not name axes, of {' '.join(AXIS_LETTERS)}, once each.", param, ctx)
        return letters


class FileName(click.ParamType):
    """The given name of a file or folder: faults are reported when it is opened."""

    name = "file"

    def __init__(self, kind: str = "file") -> None:
        self._kind = kind

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Let the shell complete names of files (or, of the kind ``dir``, folders)."""
        from click.shell_completion import CompletionItem

        return [CompletionItem(incomplete, type=self._kind)]


class MachineName(FileName):
    """A machine: one of the profiles that ship, or a file."""

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return the profiles that begin so; let the shell complete names of files beside them."""
        from click.shell_completion import CompletionItem

        from cncgen.machine import profile_names

        names = [CompletionItem(name) for name in profile_names() if name.startswith(incomplete)]
        # bash forgets the entries before one that asks it for files.
        return super().shell_complete(ctx, param, incomplete) + names


class NamedChoice(click.Choice[str]):
    """One of some words, or the name of an entry point of another package in a group."""

    def __init__(self, choices: tuple[str, ...], group: str) -> None:
        super().__init__(choices)
        self._group = group

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the word, or fail as click does; entry points are searched if it is not one of ours."""
        known = self.choices if value in self.choices else (*self.choices, *foreign_names(self._group))
        return str(click.Choice(known).convert(value, param, ctx))


AXES = AxisLetters()
MODES = ModeList()
FILE = FileName()
FOLDER = FileName("dir")
MACHINE = MachineName()
SETPOINT_FORMAT = NamedChoice(FORMATS, FORMAT_GROUP)

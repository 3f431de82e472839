"""The output of `cncgen sweep show`: tables of a folder of results."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cncgen.arguments import wrong
from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import open_output
from cncgen.report.swept import Cell, Share, rows_text, shares_text, swept_figure
from cncgen.report.tables import counted
from cncgen.sweep.ranking import (
    column_of,
    excess_over,
    pareto_front,
    ranked,
    rows_by_program,
    sensitivities_of,
)
from cncgen.sweep.results import FIRST, LAST, ResultsFolder, needed_pyarrow
from cncgen.sweep.sensitivities import Sensitivities

if TYPE_CHECKING:
    import pyarrow
    from matplotlib.figure import Figure

Indices = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class ShownResults:
    """The findings in a folder of results.

    Attributes:
        name: Of the folder.
        table: All rows.
        by: The figure that ranks.
        order: The rows by it, the best first; those that break a bound of a search stand behind those that keep all.
        pair: The figures of the front; None where there is one figure alone.
        fronts: Its rows by program: the rows that no other row of the program beats.
        sensitivities: Of each figure, by program and machine.
        text: All that, for a person.
    """

    name: str
    table: pyarrow.Table
    by: str
    order: Indices
    pair: tuple[str, str] | None
    fronts: dict[str, Indices]
    sensitivities: dict[tuple[str, str], list[Sensitivities]]
    text: str

    def as_json(self) -> dict[str, Any]:
        """Return plain values."""
        keys = self.table.column("key").to_pylist()
        return {
            "schema_version": 1,
            "rows": len(self.table),
            "failed": len(self.table) - self.table.column("code").null_count,
            "by": self.by,
            "ranking": [keys[row] for row in self.order],
            "pareto": {
                "figures": self.pair,
                "rows": [keys[row] for front in self.fronts.values() for row in front],
            },
            "sensitivities": [
                {"program": group[0], "machine": group[1], **asdict(one)}
                for group, found in self.sensitivities.items()
                for one in found
            ],
        }

    def picture(self) -> Figure:
        """Draw the front and the sensitivities of the first program and machine.

        Raises:
            UsageError: There is one figure alone, or matplotlib is missing.
        """
        if self.pair is None:
            raise wrong("a picture needs two figures", "keep two, or name them with --pareto")
        x, y = (column_of(self.table, name) for name in self.pair)
        first = next(iter(self.sensitivities.values()), [])
        shares = [(one.figure, _shares(one)) for one in first]
        return swept_figure(self.name, (self.pair[0], x, self.pair[1], y), list(self.fronts.values()), shares)


def shown_results(
    path: str | os.PathLike[str],
    *,
    by: str | None = None,
    largest: bool = False,
    top: int = 10,
    pareto: str | None = None,
) -> ShownResults:
    """Rank the results in a folder, and find their Pareto fronts and sensitivities, of each program for itself.

    Rows of a search that break its bounds stand behind all that keep them.

    Args:
        path: The folder.
        by: Figure that ranks; None: the first figure, or that of a search.
        largest: Whether the largest value is the best.
        top: Rows of each program that the text names.
        pareto: Two figures, by a comma; None: the first two.

    Raises:
        UsageError: The folder holds no results, or a figure is unknown.
    """
    folder = ResultsFolder(path)
    drawn = folder.design()
    table = folder.table()
    numeric = [
        name
        for name in table.column_names
        if name not in (*FIRST, *LAST) and str(table.schema.field(name).type) == "double"
    ]
    sought, bounds = folder.sought()
    figures = list(drawn.figures) if drawn else [sought, *bounds] if sought else numeric[-1:]
    chosen = _known(by or figures[0], numeric)
    excess = excess_over(table, {_known(name, numeric): bound for name, bound in bounds.items()})
    order = ranked(column_of(table, chosen), largest=largest, excess=excess)
    pair = _pair(pareto, figures, numeric)
    rows = rows_by_program(table)
    fronts = _fronts(table, pair, rows) if pair else {}
    found = sensitivities_of(drawn, table) if drawn else {}
    best = {program: order[np.isin(order, own)][:top] for program, own in rows.items()}
    least = {program: front[:top] for program, front in fronts.items()}
    ranking = f"by {chosen}{_kept(bounds, int((excess <= 0.0).sum()), len(table))}"
    text = _text(table, ranking, best, pair, least, found)
    return ShownResults(os.fspath(path), table, chosen, order, pair, fronts, found, text)


def _kept(bounds: Mapping[str, float], keeping: int, rows: int) -> str:
    """Tell how many rows keep the bounds of a search; "" without bounds."""
    if not bounds:
        return ""
    named = ", ".join(f"{name} up to {bound:g}" for name, bound in bounds.items())
    many = f"{keeping} of {counted(rows, 'row')} with {named}"
    return f"; {many} first" if keeping else f"; {many}, the nearest to it first"


def _fronts(table: pyarrow.Table, pair: tuple[str, str], rows: Mapping[str, Indices]) -> dict[str, Indices]:
    """Return the rows of each program's Pareto front."""
    first, second = (column_of(table, name) for name in pair)
    return {program: own[pareto_front(first[own], second[own])] for program, own in rows.items()}


def _known(name: str, numeric: Sequence[str]) -> str:
    if name not in numeric:
        raise wrong(f"the results have no figure {name!r}", f"there are {', '.join(numeric)}")
    return name


def _pair(asked: str | None, figures: Sequence[str], numeric: Sequence[str]) -> tuple[str, str] | None:
    if asked is None:
        return (figures[0], figures[1]) if len(figures) > 1 else None
    names = [name.strip() for name in asked.split(",")]
    if len(names) != 2:
        raise wrong(f"--pareto {asked}: two figures are to stand there, by a comma")
    return _known(names[0], numeric), _known(names[1], numeric)


def _shares(one: Sensitivities) -> list[Share]:
    return [Share(share.column, share.first, share.total) for share in one.shares]


def _text(
    table: pyarrow.Table,
    ranking: str,
    best: Mapping[str, Indices],
    pair: tuple[str, str] | None,
    fronts: Mapping[str, Indices],
    found: dict[tuple[str, str], list[Sensitivities]],
) -> str:
    columns = {name: table.column(name).to_pylist() for name in table.column_names}
    shown = [name for name in table.column_names if name not in ("key", *LAST)]
    failed = len(table) - table.column("code").null_count
    parts = [f"{counted(len(table), 'row')}; {counted(failed, 'job') if failed else 'no job'} failed\n"]
    for program, rows in best.items():
        of = f"{program}, " if len(best) > 1 else ""
        if len(rows):
            parts.append(f"{of}{ranking}:\n" + rows_text(columns, rows, shown))
        if pair and len(fronts[program]):
            head = f"{of}Pareto front of {pair[0]} and {pair[1]}:\n"
            parts.append(head + rows_text(columns, fronts[program], shown))
    for (program, machine), group in found.items():
        parts.append(f"{program} on {machine}\n")
        known = [one for one in group if any(np.isfinite(share.total) for share in one.shares)]
        parts += [shares_text(one.figure, one.method, one.rows, one.explained, _shares(one)) for one in known]
        parts += _without_shares([one.figure for one in group if one not in known], columns, program, machine)
    if failed:
        parts.append(_failures(columns))
    return "\n".join(parts)


def _without_shares(
    figures: Sequence[str], columns: Mapping[str, Sequence[Cell]], program: str, machine: str
) -> list[str]:
    """Return a line for all figures of one value, and one for those of too few rows."""
    own = [
        k
        for k, of in enumerate(zip(columns["program"], columns["machine"], strict=True))
        if of == (program, machine)
    ]
    alike = [name for name in figures if len({columns[name][k] for k in own} - {None}) < 2]
    few = [name for name in figures if name not in alike]
    lines = (("the same in all rows", alike), ("too few rows for sensitivities", few))
    return [f"{told}: {', '.join(names)}\n" for told, names in lines if names]


def _failures(columns: dict[str, list[Any]]) -> str:
    """Return each diagnostic of failed jobs with how many jobs it ended, and the first of its texts."""
    texts: dict[str, list[str]] = {}
    for code, error in zip(columns["code"], columns["error"], strict=True):
        if code is not None:
            texts.setdefault(code, []).append(error)
    lines = [f"{counted(len(found), 'job')} failed: {found[0]}" for found in texts.values()]
    return "\n".join(lines) + "\n"


def write_table(shown: ShownResults, path: str) -> None:
    """Write all rows to one file, by its suffix CSV or Parquet.

    Raises:
        UsageError: Another suffix, a place in the folder of results, whose files are its rows, or the file cannot be written.
    """
    pyarrow = needed_pyarrow()
    table = shown.table
    suffix, sink = Path(path).suffix.lower(), io.BytesIO()
    if Path(path).resolve().parent == Path(shown.name).resolve():
        text = f"{path} would stand among the rows of {shown.name}, and be read with them"
        raise UsageError(Diagnostic("sweep-table", text, hint="name a file outside of the folder"))
    if suffix == ".csv":
        pyarrow.csv.write_csv(table, sink)
    elif suffix == ".parquet":
        pyarrow.parquet.write_table(table, sink)
    else:
        text = f"{path}: a table of results is written as .csv or .parquet"
        raise UsageError(Diagnostic("sweep-table", text))
    with open_output(path) as file:
        file.write(sink.getvalue())

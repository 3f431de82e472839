"""The papers item by item: printed value, ours, tolerance and result of each, as text, Markdown and values."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.papers.printed import COUNTED, Row, RowKind, RowOutcome, Table, counts
from cncgen.report.drawing import folder, save
from cncgen.report.tables import left_table, text_table

#: The module of each paper, which has ``tables(programs)`` and ``figures(programs)``, by the name that commands take.
MODULES = {
    "000": "cncgen.papers.yeh_sun_2008",
    "001": "cncgen.papers.chen_hsu_2007",
    "002": "cncgen.papers.jung_choi_2001",
    "003": "cncgen.papers.tsai_2010",
    "004": "cncgen.papers.hsu_1999",
}
NAMES = tuple(MODULES)

#: The tables of papers by name.
Found = Mapping[str, Sequence[Table]]


def reproduce(name: str | None = None, programs: str | None = None) -> dict[str, list[Table]]:
    """Compute the items of one paper, or of all.

    Args:
        name: One of `NAMES`, or None.
        programs: Folder of the example programs; None: looked for.

    Returns:
        The tables of each paper, by name.

    Raises:
        UsageError: The paper is unknown (``reproduce-name``), or the programs are not found.
    """
    return {one: importlib.import_module(MODULES[one]).tables(programs) for one in _wanted(name)}


def _wanted(name: str | None) -> Sequence[str]:
    """Return the names of the papers that are asked for."""
    if name is not None and name not in NAMES:
        papers = ", ".join(f"{one} ({module.rpartition('.')[2]})" for one, module in MODULES.items())
        raise UsageError(Diagnostic("reproduce-name", f"no paper is called {name!r}; there are {papers}"))
    return [name] if name else NAMES


def draw_papers(output: str, name: str | None = None, programs: str | None = None) -> list[str]:
    """Draw the figures of one paper, or of all, as PNG into a folder; return the files.

    Args:
        output: The folder, which is made where it is missing.
        name: One of `NAMES`, or None.
        programs: Folder of the example programs; None: looked for.

    Raises:
        UsageError: The paper is unknown, matplotlib is missing, or the programs are not found.
    """
    wanted = _wanted(name)
    target = folder(output)
    files = []
    for paper in wanted:
        for title, figure in importlib.import_module(MODULES[paper]).figures(programs):
            file = target / f"paper_{paper}_{title}.png"
            save(figure, file)
            files.append(str(file))
    return files


def explained(found: Found) -> bool:
    """Tell whether each row holds or says why it does not, and each check of ours holds."""
    return all(table.explained for tables in found.values() for table in tables)


def as_text(found: Found) -> str:
    """Return the tables as text, with reasons and assumptions, and the counts at the end."""
    parts = []
    for tables in found.values():
        for table in tables:
            parts.append(f"{table.title}\n\n{text_table(_HEADER, [_cells(row) for row in table.rows])}")
            parts += [f"  {line}" for line in (*_reasons(table.rows), *table.assumptions)]
            parts.append("")
    parts.append(_count_table(found))
    parts += [f"  {line}" for line in _remarks(found)]
    return "\n".join(parts) + "\n"


def as_markdown(found: Found) -> str:
    """Return the page that docs/papers.md is: the counts, and each table with its reasons and assumptions."""
    parts = [_INTRODUCTION, _count_table(found)]
    parts += [f"{line}\n" for line in _remarks(found)]
    for tables in found.values():
        for table in tables:
            parts.append(f"## {table.title}\n")
            parts.append(left_table(_HEADER, [_cells(row) for row in table.rows]))
            parts += [f"- {line}" for line in (*_reasons(table.rows), *table.assumptions)]
            parts.append("")
    return "\n".join(parts).rstrip("\n") + "\n"


def as_values(found: Found) -> dict[str, Any]:
    """Return the tables as plain values; ``holds`` is None for an item that cncgen does not compute."""
    return {
        "schema_version": 2,
        "holds": explained(found),
        "counts": {name: _counted(tables) for name, tables in found.items()},
        "tables": [
            {
                "paper": name,
                "title": table.title,
                "assumptions": list(table.assumptions),
                "rows": [_values(row) for row in table.rows],
            }
            for name, tables in found.items()
            for table in tables
        ],
    }


def _counted(tables: Iterable[Table]) -> dict[str, int]:
    return {outcome.value: number for outcome, number in counts(tables).items()}


def _values(row: Row) -> dict[str, Any]:
    return {
        "figure": row.what,
        "printed": row.value if row.kind is not RowKind.OURS else None,
        "printed_text": row.printed or None,
        "expected": row.expected,
        "ours": row.ours,
        "unit": row.unit,
        "asked": row.asked or None,
        "holds": None if row.ours is None else row.holds,
        "outcome": row.outcome.value,
        "basis": row.basis.value if row.basis else None,
        "sensitivity": [{"with": choice, "ours": value} for choice, value in row.sensitivity],
        "reason": row.reason or None,
    }


_HEADER = (
    "item",
    "printed",
    "ours",
    "unit",
    "difference",
    "tolerance",
    "basis",
    "ours with another choice",
    "outcome",
)


def _cells(row: Row) -> Sequence[str]:
    difference = row.difference
    printed = row.printed or ("" if row.expected is None else f"({row.expected:g})")
    return (
        row.what,
        printed,
        "" if row.ours is None else f"{row.ours:.8g}" if row.kind is RowKind.INPUT else f"{row.ours:.4g}",
        row.unit,
        "" if difference is None or row.kind is RowKind.INPUT else f"{100 * difference:+.1f} %",
        "" if row.kind is RowKind.INPUT else row.asked,
        row.basis.value if row.basis else "",
        "; ".join(f"{choice}: {value:.4g}" for choice, value in row.sensitivity),
        row.outcome.value,
    )


def _reasons(rows: Iterable[Row]) -> list[str]:
    """Return each reason once, with the rows that it stands for."""
    found: dict[tuple[RowOutcome, str], list[str]] = {}
    for row in rows:
        if row.reason and row.outcome in _EXPLAINED:
            found.setdefault((row.outcome, row.reason), []).append(row.what)
    return [
        f"{outcome.value}: {which[0] if len(which) == 1 else f'{len(which)} items'}: {reason}"
        for (outcome, reason), which in found.items()
    ]


#: The outcomes whose reasons are shown.
_EXPLAINED = (RowOutcome.NOT_REPRODUCED, RowOutcome.NOT_REPRODUCIBLE, RowOutcome.MISSED)


def _count_table(found: Found) -> str:
    """Return how many items of each paper have each outcome, and how many checks of ours hold."""
    rows, total = [], dict.fromkeys(RowOutcome, 0)
    for name, tables in found.items():
        numbers = counts(tables)
        rows.append(_count_cells(name, numbers))
        for outcome, number in numbers.items():
            total[outcome] += number
    if len(found) > 1:
        rows.append(_count_cells("all", total))
    return text_table(("paper", *(outcome.value for outcome in COUNTED), "checks of ours that hold"), rows)


def _count_cells(name: str, numbers: Mapping[RowOutcome, int]) -> Sequence[str]:
    checks = numbers[RowOutcome.HOLDS] + numbers[RowOutcome.MISSED]
    return (name, *(str(numbers[outcome]) for outcome in COUNTED), f"{numbers[RowOutcome.HOLDS]} of {checks}")


def _remarks(found: Found) -> list[str]:
    """Return rows that miss without a reason, and our checks that fail."""
    return [
        f"{row.outcome.value} and not explained: {table.title}: {row.what}"
        for tables in found.values()
        for table in tables
        for row in table.rows
        if not row.explained
    ]


_INTRODUCTION = """# The papers, item by item

`cncgen reproduce -o docs/papers.md` makes this page. It has a row for each table, figure and printed number of the five papers
([references](references.md)), experiments included, and for what their texts claim in numbers.

An item is *reproduced* where ours is within the tolerance, which stands in the paper's module of `cncgen.papers` beside the
printed number. It is *not reproduced* where ours misses it, and *not reproducible* where the paper (or our copy of it) does not
give what it takes. *Inputs* are printed numbers that are taken over. *Drawings* are diagrams and photographs.

*Basis* says how our number came about. *Predicted*: nothing was chosen with the printed number in view. *Calibrated*: something
was fitted to this number or to others of the same table. *Chosen by scan*: the paper leaves something open, and several choices
were tried. *From printed numbers*: it follows from other numbers of the paper by arithmetic. The column beside it shows what ours
becomes with another choice.

*Checks of ours* are not of the papers. Each has a bound or, in brackets, the value of a closed form.
"""

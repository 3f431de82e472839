"""The papers' tables: printed value, ours, the difference, and whether a stated tolerance is held."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Sequence
from typing import Any

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.papers.printed import Row, Table
from cncgen.report.drawing import folder, save
from cncgen.report.tables import text_table

#: The module of each paper, which has ``tables(programs)`` and ``figures(programs)``, by the name that commands take.
MODULES = {
    "000": "cncgen.papers.yeh_sun_2008",
    "001": "cncgen.papers.chen_hsu_2007",
    "002": "cncgen.papers.jung_choi_2001",
    "003": "cncgen.papers.tsai_2010",
    "004": "cncgen.papers.hsu_1999",
}
NAMES = tuple(MODULES)


def reproduce(name: str | None = None, programs: str | None = None) -> list[Table]:
    """Compute the tables of one paper, or of all.

    Args:
        name: One of `NAMES`, or None.
        programs: Folder of the example programs; None: looked for.

    Raises:
        UsageError: The paper is unknown (``reproduce-name``), or the programs are not found.
    """
    found: list[Table] = []
    for one in _wanted(name):
        found += importlib.import_module(MODULES[one]).tables(programs)
    return found


def _wanted(name: str | None) -> Sequence[str]:
    """Return the names of the papers that are asked for."""
    if name is not None and name not in NAMES:
        raise UsageError(
            Diagnostic("reproduce-name", f"no paper is called {name!r}; there are {', '.join(NAMES)}")
        )
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


def as_text(tables: Iterable[Table]) -> str:
    """Return tables as text, with their assumptions, and at the end what does not hold."""
    parts, missed = [], []
    for table in tables:
        parts.append(f"{table.title}\n\n{text_table(_HEADER, [_cells(row) for row in table.rows])}")
        parts += [f"  {line}" for line in table.assumptions]
        parts.append("")
        missed += [f"{table.title}: {row.what}" for row in table.rows if not row.holds]
    parts.append("all stated tolerances hold" if not missed else "missed:\n  " + "\n  ".join(missed))
    return "\n".join(parts) + "\n"


def as_values(tables: Sequence[Table]) -> dict[str, Any]:
    """Return tables as plain values; ``asked`` and ``holds`` are None for figures that are only shown."""
    return {
        "schema_version": 1,
        "holds": all(table.holds for table in tables),
        "tables": [
            {
                "title": table.title,
                "assumptions": list(table.assumptions),
                "rows": [_values(row) for row in table.rows],
            }
            for table in tables
        ],
    }


def _values(row: Row) -> dict[str, Any]:
    return {
        "figure": row.what,
        "printed": row.printed,
        "ours": row.ours,
        "unit": row.unit,
        "asked": row.asked or None,
        "holds": row.holds if row.checked else None,
    }


_HEADER = ("figure", "printed", "ours", "unit", "difference", "asked", "")


def _cells(row: Row) -> Sequence[str]:
    difference = ""
    if row.printed:
        difference = f"{100 * (row.ours / row.printed - 1):+.2f} %"
    printed = "" if row.printed is None else f"{row.printed:g}"
    verdict = ("ok" if row.holds else "MISSED") if row.checked else ""
    return row.what, printed, f"{row.ours:.5g}", row.unit, difference, row.asked, verdict

"""Parts of the page about a plan beside its signals: figures, places, corners, verdict, and the text of the program."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from cncgen import __version__
from cncgen.diagnostics import json_values
from cncgen.files import as_utf8
from cncgen.machine.record import Machine
from cncgen.planner.record import Limit
from cncgen.removal.cutters import turns_work
from cncgen.removal.record import Removal, Turned
from cncgen.removal.surfaces import mesh_of
from cncgen.report.page.assembling import assemble
from cncgen.report.page.numbered_text import put_text
from cncgen.report.page.packed_rows import predictors
from cncgen.report.page.recording import Recording
from cncgen.report.page.streams import Blob, integers
from cncgen.report.slow_places import SlowPlace
from cncgen.verify.verdict import Verdict

#: Of the format that docs/page.md describes.
FORMAT = 2
#: Columns of the mesh of a part along its longer side, and the step of its corners, mm.
MESH_COLUMNS, MESH_STEP = 250, 1e-3
#: Bytes of a program's text that the page holds at most.
MOST_SOURCE = 64_000_000


@dataclass(frozen=True, slots=True)
class Contents:
    """One plan, or setpoints from elsewhere, as the page shows it.

    Attributes:
        label: Its name where several stand on one page.
        machine: On which it runs.
        recording: Its signals.
        summary: As `cncgen.report.summary.Summary.as_json` gives it; {} of setpoints from elsewhere.
        places: Where the most time is lost, the worst first.
        verdict: The verdict of `verify`, or None.
        texts: Programs' texts by the names in `Recording.sources`; a file that is not there is read.
        why: Rows of ``cncgen why``, or None.
        removal: The part that the program cuts, or None.
        for_lathe: Whether the program is written in a dialect of lathes.
    """

    label: str
    machine: Machine
    recording: Recording
    summary: Mapping[str, Any]
    places: Sequence[SlowPlace] = ()
    verdict: Verdict | None = None
    texts: Mapping[str, bytes] | None = None
    why: Sequence[Mapping[str, Any]] | None = None
    removal: Removal | None = None
    for_lathe: bool = False


def html(title: str, parts: Sequence[Contents]) -> str:
    """Return the page on one plan, or on several over each other.

    Args:
        title: Of the page.
        parts: The plan, then those that it is compared with.
    """
    blob = Blob()
    header: dict[str, Any] = {
        "format": FORMAT,
        "version": __version__,
        "title": title,
        "limits": [_limit(limit) for limit in Limit],
        "predictors": predictors(),
        "parts": [contents(part, blob, with_source=k == 0) for k, part in enumerate(parts)],
    }
    return assemble(title, header, blob.text())


def contents(part: Contents, blob: Blob, with_source: bool = True) -> dict[str, Any]:
    """Return the page's header of one plan; its streams go into the blob."""
    summary = {k: v for k, v in part.summary.items() if k not in ("sharp_corners", "slowest")}
    corners = [round(item["t_s"] / part.recording.period_s) for item in part.summary.get("sharp_corners", ())]
    found = part.recording.finish(blob)
    found |= {
        "label": part.label,
        "machine": part.machine.name,
        "summary": json_values(summary),
        "corners": integers(sorted(corners), 1, blob),
        "places": [_place(place, part.recording.sources) for place in part.places],
        "verdict": _verdict(part.verdict),
        "sources": [_source(name, part.texts or {}, blob, with_source) for name in part.recording.sources],
    }
    found["turned"] = _turned(part, {axis["letter"] for axis in found["axes"]}, found["events"])
    if part.why is not None:
        found["why"] = [json_values(dict(row)) for row in part.why]
    if part.removal is not None:
        found["removal"] = _removal(part.removal, blob)
    return found


def _turned(part: Contents, axes: set[str], events: Sequence[Mapping[str, Any]]) -> bool:
    """Tell whether a part is turned: its stock is, or the program turns its work."""
    if part.removal is not None:
        return isinstance(part.removal.stock, Turned)
    return turns_work(events, axes, part.for_lathe or part.machine.is_lathe)


def _removal(removal: Removal, blob: Blob) -> dict[str, Any]:
    """Return the part that is cut as a mesh, how much is removed, and what is wrong."""
    vertices, triangles = mesh_of(removal.stock, MESH_COLUMNS, joined=True)
    used, corners = np.unique(triangles, return_inverse=True)
    steps = np.rint(vertices[used] / MESH_STEP).astype(np.int64)
    findings = [
        {"code": item.code, "severity": item.severity.name.lower(), "message": item.message}
        | ({"line": item.span.line} if item.span else {})
        for item in removal.findings
    ]
    return {
        "step": MESH_STEP,
        "vertices": [integers(column, 1, blob) for column in steps.T],
        "corners": [integers(column, 1, blob) for column in corners.reshape(-1, 3).T],
        "removed_mm3": sum(operation.volume_mm3 for operation in removal.operations),
        "raw_volume_mm3": removal.raw_volume_mm3,
        "cell_mm": removal.stock.cell,
        "findings": json_values(findings),
    }


def _limit(limit: Limit) -> str:
    return "nothing" if limit is Limit.NONE else limit.name.lower().replace("_", " ")


def _place(place: SlowPlace, sources: Sequence[str]) -> dict[str, Any]:
    return {
        "lost_s": round(place.lost_s, 6),
        "source": sources.index(place.source) if place.source in sources else 0,
        "line": place.line,
        "t_s": round(place.t_s, 6),
        "feed_mm_s": round(place.feed_mm_s, 4),
        "limit": f"{place.axis} {_limit(place.limit)}".strip(),
    }


def _verdict(verdict: Verdict | None) -> dict[str, Any] | None:
    if verdict is None:
        return None
    result = verdict.as_json()
    breaches = [
        {"code": item.code, "severity": item.severity.name.lower(), "message": item.message}
        | {key: item.values[key] for key in ("t_s", "line") if key in item.values}
        for item in verdict.breaches
    ]
    found: dict[str, Any] = json_values({**result, "breaches": breaches})
    return found


def _source(name: str, texts: Mapping[str, bytes], blob: Blob, wanted: bool) -> dict[str, Any]:
    """Return a file's name, and its text if it can be had."""
    found: dict[str, Any] = {"name": name}
    text = texts.get(name)
    if text is None and wanted and os.path.isfile(name):
        with suppress(OSError), open(name, "rb") as file:
            text = file.read(MOST_SOURCE)
    if wanted and text is not None:
        found["text"] = put_text(as_utf8(text).decode("utf-8", "replace").encode(), blob)
    return found

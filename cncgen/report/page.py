"""One self-contained HTML page on a plan: figures, the path coloured by speed, curves with limits, slow places.

Nothing is fetched when the page is opened: pictures are SVG in its text, and there are no scripts.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from cncgen.machine.record import Machine
from cncgen.report.line_times import LineTimes
from cncgen.report.source_lines import source_lines
from cncgen.report.svg import chart, path_picture
from cncgen.report.tables import duration
from cncgen.setpoints.columns import file_units, position_column
from cncgen.setpoints.record import Setpoints
from cncgen.units import ORDER_NAMES, ORDERS, file_unit, to_file
from cncgen.verify.verdict import Verdict

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 960px; margin: 2em auto; padding: 0 1em; color: #222;
       background: #fff }
h1 { font-size: 1.5em } h2 { font-size: 1.15em; margin-top: 2em }
table { border-collapse: collapse } td, th { padding: .2em .8em; border-bottom: 1px solid #ddd; text-align: right }
td:first-child, th:first-child { text-align: left }
svg { width: 100%; height: auto } svg text { font: 11px system-ui, sans-serif; fill: #444 }
svg .title { font-weight: 600 } svg .grid { stroke: #e4e4e4 } svg .limit { stroke: #b00; stroke-dasharray: 5 4 }
svg .curve { fill: none; stroke-width: 1.2 } svg .path { fill: none; stroke-width: 2; stroke-linejoin: round }
svg .mark { fill: none; stroke: #b00; stroke-width: 1.5 }
.lines td:last-child, .lines th:last-child { text-align: left; font-family: monospace; white-space: pre }
.broken { color: #b00; font-weight: 600 } .good { color: #060; font-weight: 600 }
"""

#: Lines that the page lists with their times.
MOST_LINES = 100


def page(
    setpoints: Setpoints,
    machine: Machine,
    summary: dict[str, Any],
    verdict: Verdict | None,
    times: LineTimes | None = None,
) -> str:
    """Return the page as HTML.

    Args:
        setpoints: The whole plan.
        machine: Its limits are drawn.
        summary: From `cncgen.report.summary.Summary.as_json`.
        verdict: What `verify` found, or None.
        times: What each line takes, or None.
    """
    title = f"{summary['program']} on {machine.name}"
    sections = [
        f"<h1>{escape(title)}</h1>",
        _figures(summary),
        _verdict(verdict),
        "<h2>Path</h2>",
        _picture(setpoints, summary),
        "<h2>Axes</h2>",
        *_charts(setpoints, machine),
        _slow_places(summary),
        _line_times(times, summary["program"]) if times else "",
        _diagnostics(summary),
    ]
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head>\n<body>\n"
        + "\n".join(section for section in sections if section)
        + "\n</body></html>\n"
    )


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{escape(cell)}</th>" for cell in header)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"


def _figures(summary: dict[str, Any]) -> str:
    rows = [
        ("feedrate strategy", str(summary["feedrate"])),
        ("cycle time", duration(summary["motion_time_s"] + summary["dwell_time_s"])),
        ("motion time", duration(summary["motion_time_s"])),
        ("dwell time", duration(summary["dwell_time_s"])),
        ("path length", f"{summary['path_length_mm']:.4f} mm"),
        ("motions", str(summary["motions"])),
        ("setpoints", f"{summary['samples']} every {1000 * summary['period_s']:g} ms"),
        (
            "feed, mean and largest",
            f"{summary['feed_mm_s']['mean']:.2f}, {summary['feed_mm_s']['max']:.2f} mm/s",
        ),
        ("sharp corners", str(summary["sharp_corner_count"])),
    ]
    peaks = [
        [
            letter.upper(),
            *(f"{peak[name]:.6g} {peak['unit']}/s{power}{_share(peak, name)}" for name, power in ORDERS),
        ]
        for letter, peak in summary["peak"].items()
    ]
    return _table(("figure", ""), rows) + "<h2>Peaks</h2>" + _table(("axis", *ORDER_NAMES), peaks)


def _share(peak: dict[str, Any], name: str) -> str:
    share = peak[f"{name}_of_limit"]
    return "" if share is None else f" ({100 * share:.1f} %)"


def _verdict(verdict: Verdict | None) -> str:
    if verdict is None:
        return ""
    distances = (
        f"setpoints to path {1000 * verdict.setpoints_to_path_mm:.3f} µm, "
        f"path to setpoints {1000 * verdict.path_to_setpoints_mm:.3f} µm"
    )
    if verdict.holds:
        return f'<h2>Verified</h2><p><span class="good">Every limit holds.</span> Distance: {distances}.</p>'
    items = "".join(f"<li>{escape(item.message)}</li>" for item in verdict.breaches)
    return f'<h2>Verified</h2><p><span class="broken">Limits are broken.</span> Distance: {distances}.</p><ul>{items}</ul>'


def _picture(setpoints: Setpoints, summary: dict[str, Any]) -> str:
    points = file_units(setpoints.position, setpoints.axes)
    linear = [k for k, axis in enumerate(setpoints.axes) if file_unit(axis) == "mm"]
    steps = np.linalg.norm(np.diff(setpoints.position[:, linear], axis=0), axis=1) / setpoints.period_s
    speed = np.append(steps, steps[-1:]) if len(steps) else np.zeros(len(points))
    columns = [position_column(axis) for axis in setpoints.axes]
    corners = [
        [corner["position"].get(name, 0.0) for name in columns] for corner in summary["sharp_corners"][:500]
    ]
    marks = np.array(corners, np.float64).reshape(-1, len(columns))
    return path_picture(points, list(setpoints.axes), speed, marks)


def _charts(setpoints: Setpoints, machine: Machine) -> list[str]:
    """Draw velocity, acceleration and jerk: linear axes in one chart each, rotary axes in another."""
    charts = []
    padded = np.concatenate([np.repeat(setpoints.position[:1], 3, axis=0), setpoints.position])
    difference = file_units(padded, setpoints.axes)
    for k, (name, power) in enumerate(ORDERS, start=1):
        difference = np.diff(difference, axis=0)
        values = difference[3 - k :] / setpoints.period_s**k
        for unit in ("mm", "deg"):
            columns = [c for c, axis in enumerate(setpoints.axes) if file_unit(axis) == unit]
            if columns:
                letters = [setpoints.axes[c] for c in columns]
                limits = [
                    getattr(machine.axes[axis], f"max_{name}") * to_file(axis)
                    for axis in letters
                    if axis in machine.axes
                ]
                curves = {axis: values[:, c] for axis, c in zip(letters, columns, strict=True)}
                charts.append(chart(f"{name}, {unit}/s{power}", setpoints.time_s, curves, limits))
    return charts


def _slow_places(summary: dict[str, Any]) -> str:
    if not summary["slowest"]:
        return ""
    rows = [
        [
            str(place["line"]),
            f"{1000 * place['lost_s']:.1f}",
            place["limit"].replace("_", " "),
            f"{place['feed_mm_s']:.2f}",
            f"{place['t_s']:.4f}",
        ]
        for place in summary["slowest"]
    ]
    header = ("line", "time lost, ms", "what binds", "slowest, mm/s", "at, s")
    return "<h2>Where time is lost</h2>" + _table(header, rows)


def _line_times(times: LineTimes, program: str) -> str:
    """Return the lines that take the most time, and what all others take together."""
    longest, total = times.longest(MOST_LINES), times.total_s
    if not longest or not total > 0:
        return ""
    texts = source_lines((item.source, item.line) for item in longest)
    rows = [
        [
            str(item.line) if item.source == program else f"{item.source}:{item.line}",
            f"{item.time_s:.4f}",
            f"{100 * item.time_s / total:.2f}",
            f"{item.length_mm:.4f}",
            f"{item.length_mm / item.time_s:.2f}" if item.time_s > 0 else "",
            texts.get((item.source, item.line), ""),
        ]
        for item in longest
    ]
    others = times.lines - len(longest)
    if others > 0:
        rest = total - sum(item.time_s for item in longest)
        rows.append([f"{others} others", f"{rest:.4f}", f"{100 * rest / total:.2f}", "", "", ""])
    header = ("line", "time, s", "share, %", "path, mm", "mean, mm/s", "block")
    return '<div class="lines"><h2>Time by line</h2>' + _table(header, rows) + "</div>"


def _diagnostics(summary: dict[str, Any]) -> str:
    if not summary["diagnostics"]:
        return ""
    rows = [[str(d["line"] or ""), d["severity"], d["code"], d["message"]] for d in summary["diagnostics"]]
    return "<h2>Diagnostics</h2>" + _table(("line", "severity", "code", "message"), rows)

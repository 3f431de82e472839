"""Results in a notebook: figures, a picture, and the page in a frame."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from html import escape

import numpy as np

from cncgen.machine.record import Machine
from cncgen.report.page import Contents, Recording, html
from cncgen.report.svg import path_picture
from cncgen.servo.record import Response
from cncgen.setpoints.columns import file_units
from cncgen.setpoints.differencing import differenced
from cncgen.setpoints.record import Setpoints
from cncgen.units import file_unit
from cncgen.verify.verdict import Verdict

#: Height of the frame, in pixels.
HEIGHT = 720


def framed(page: str, height: int = HEIGHT) -> str:
    """Return a whole HTML document in a frame, as a notebook shows it; nothing in it reaches the notebook."""
    style = f"width:100%;height:{height}px;border:1px solid #8884;border-radius:8px"
    return f'<iframe srcdoc="{escape(page)}" sandbox="allow-scripts" title="cncgen" style="{style}"></iframe>'


def setpoints_page(setpoints: Setpoints, machine: Machine | None = None) -> str:
    """Return the page on setpoints; without signals of their own these are differences, beside the limits of a machine."""
    machine = machine or Machine("setpoints", {}, period_s=setpoints.period_s)
    recording = Recording(machine, setpoints.axes, setpoints.period_s)
    for _ in recording.over_setpoints(differenced([setpoints])):
        pass
    return html("Setpoints", [Contents("setpoints", machine, recording, {})])


def of_setpoints(setpoints: Setpoints) -> str:
    """Return figures, a picture and the viewer of setpoints."""
    figures = _figures(repr(setpoints), _extents(setpoints))
    return _together(figures, _picture(setpoints), setpoints_page(setpoints))


def response_page(response: Response, machine: Machine | None = None) -> str:
    """Return the page on the response of the servo axes to setpoints, with forces and errors, beside the limits of a machine."""
    machine = machine or Machine("response", {}, period_s=response.period_s)
    recording = Recording(machine, response.axes, response.period_s)
    for _ in recording.over_setpoints(differenced([_commands(response)])):
        pass
    for _ in recording.over_responses([response]):
        pass
    return html("Response", [Contents("response", machine, recording, {})])


def of_response(response: Response) -> str:
    """Return figures, a picture and the viewer of a response."""
    errors = file_units(np.abs(response.position - response.command), response.axes)
    rows = [
        (f"{letter}: largest tracking error", f"{1e3 * value:.3f} {_thousandth(letter)}")
        for letter, value in zip(response.axes, errors.max(axis=0, initial=0.0), strict=True)
    ]
    contour = np.nan_to_num(response.contour_error_mm)
    rows.append(("largest contour error", f"{1e3 * contour.max(initial=0.0):.3f} µm"))
    rows.append(("saturated setpoints", str(int(response.saturated.any(axis=1).sum()))))
    return _together(_figures(repr(response), rows), _picture(_commands(response)), response_page(response))


def _commands(response: Response) -> Setpoints:
    return Setpoints(response.axes, response.period_s, response.first, response.command)


def of_verdict(verdict: Verdict) -> str:
    """Return the result of a verification: whether every limit holds, the peaks beside their limits, and broken limits."""
    rows = [
        (f"{peak.axis} {peak.order}", f"{peak.value:.6g} of {peak.limit:g} ({100 * peak.of_limit:.1f} %)")
        for peak in verdict.peaks
    ]
    rows.append(("setpoints to path", f"{1e3 * verdict.setpoints_to_path_mm:.3f} µm"))
    rows.append(("path to setpoints", f"{1e3 * verdict.path_to_setpoints_mm:.3f} µm"))
    broken = "".join(f"<li>{escape(item.message)}</li>" for item in verdict.breaches)
    outcome = "Every limit holds" if verdict.holds else "Limits are broken"
    return _figures(f"{outcome}: {verdict.samples} setpoints", rows) + (
        f"<ul>{broken}</ul>" if broken else ""
    )


def _together(figures: str, picture: str, page: str) -> str:
    return f"{figures}<details><summary>Picture without the viewer</summary>{picture}</details>{framed(page)}"


def _figures(title: str, rows: Iterable[tuple[str, str]]) -> str:
    body = "".join(f"<tr><td>{escape(name)}</td><td>{escape(value)}</td></tr>" for name, value in rows)
    return f"<p><strong>{escape(title)}</strong></p><table>{body}</table>"


def _extents(setpoints: Setpoints) -> Iterable[tuple[str, str]]:
    """Return the time, and from where to where each axis goes."""
    points = file_units(setpoints.position, setpoints.axes)
    rows = [("time", f"{max(0, len(points) - 1) * setpoints.period_s:.3f} s")]
    if len(points):
        for letter, low, high in zip(setpoints.axes, points.min(axis=0), points.max(axis=0), strict=True):
            rows.append((letter, f"{low:.4f} to {high:.4f} {file_unit(letter)}"))
    return rows


def _thousandth(letter: str) -> str:
    return "µm" if file_unit(letter) == "mm" else "m°"


def _picture(setpoints: Setpoints) -> str:
    """Return the path as SVG, coloured by speed."""
    if not len(setpoints):
        return ""
    (chunk,) = differenced([replace(setpoints, signals={})])
    points = file_units(setpoints.position, setpoints.axes)
    return path_picture(points, list(setpoints.axes), chunk.signals["feed"], points[:0])

"""Tuned gains for users: margins, Bode tables, and tables for a machine file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from cncgen.machine.record import Servo
from cncgen.machine.writing import table_text
from cncgen.report.tables import text_table
from cncgen.servo.controllers.hinf_servo import BoundCheck
from cncgen.servo.named_schemes import Settings
from cncgen.servo.tuning.analysis import (
    OpenLoop,
    WorstMargins,
    closed_bandwidth_hz,
    linear_loop,
    open_loops,
)
from cncgen.servo.tuning.search import BestGains
from cncgen.servo.uncertainty import Perturbation


def margin_text(loop: OpenLoop, bode: bool = True) -> str:
    """Return the margins of a loop, and its Bode table where asked."""
    found = loop.margins()
    head = (
        f"{loop.name}: UNSTABLE, a pole at |z| = {loop.largest_pole:.3f}, sampled every {1e3 * loop.period:g} ms"
        if not loop.stable
        else f"{loop.name}: gain margin {_decibels(found.gain)}, phase margin {found.phase_deg:.1f}°, modulus margin"
        f" {found.modulus:.3f}, crossover {found.crossover_rad_s / (2.0 * math.pi):.3g} Hz, sampled every {1e3 * loop.period:g} ms"
    )
    return f"{head}\n{loop.bode_table()}" if bode else head


def _decibels(gain: float) -> str:
    """Return a gain margin in dB, with its factor."""
    return f"{20.0 * math.log10(gain):.1f} dB (a factor of {gain:.3g})" if math.isfinite(gain) else "infinite"


def loop_texts(
    controller: str,
    servos: Mapping[str, Servo],
    axes: str,
    period_s: float,
    settings: Settings | None,
    bode: bool,
) -> Iterator[str]:
    """Yield the margins of each loop of a scheme, and of its own controllers the bandwidth of each closed axis."""
    try:
        loops = open_loops(controller, servos, axes, period_s, settings)
    except ValueError as error:
        yield str(error)
        return
    yield from (margin_text(loop, bode) for loop in loops)
    if controller != "tcf":
        for letter in axes:
            bandwidth = closed_bandwidth_hz(linear_loop(servos[letter], letter, period_s))
            yield f"{letter}: closed loop, setpoint to position: {bandwidth:.3g} Hz (-3 dB), feedforward included"


def worst_texts(found: Iterable[WorstMargins], perturbation: Perturbation) -> Iterator[str]:
    """Yield the least margins of each loop over drawn machines."""
    for loop in found:
        unstable = f", {loop.unstable} of them UNSTABLE" if loop.unstable else ""
        yield (
            f"{loop.name}: worst of {loop.draws} draws of {perturbation}{unstable}: gain margin"
            f" {_decibels(loop.gain)}, phase margin {loop.phase_deg:.1f}°, modulus margin {loop.modulus:.3f}"
        )


def bounds_text(letter: str, gamma: float, found: BoundCheck, rows: int = 16) -> str:
    """Return the H-infinity norm of an axis's design and a table of its bounds over all plants."""
    picks = np.unique(np.linspace(0, len(found.frequency) - 1, rows).round().astype(int))
    table = []
    for k in picks:
        within = found.sensitivity[k] <= found.allowed[k] and found.complementary[k] <= found.peak
        values = (found.sensitivity[k], found.allowed[k], found.complementary[k], found.peak)
        cells = [f"{20.0 * math.log10(max(float(v), 1e-300)):.1f}" for v in values]
        table.append([f"{found.frequency[k] / (2.0 * math.pi):.3g}", *cells, "ok" if within else "MISSED"])
    header = ("frequency Hz", "worst |S| dB", "allowed", "worst |T| dB", "allowed", "")
    verdict = "hold" if found.holds else "DO NOT HOLD"
    stable = "all of them stable" if found.stable else "NOT ALL STABLE"
    head = f"{letter}: norm {gamma:.4g}; the bounds {verdict} for {found.plants} plants, {stable}"
    return f"{head}\n{text_table(header, table)}"


def search_text(found: BestGains) -> str:
    """Return the result of a search in one line."""
    before = f"{1e3 * found.start_rms_mm:.3f}" if math.isfinite(found.start_rms_mm) else "refused"
    return (
        f"{found.tried} gain sets, {found.refused} refused: contour error rms {before} ->"
        f" {1e3 * found.contour_rms_mm:.3f} µm"
    )


def gain_tables(servos: Mapping[str, Servo], coupling: Mapping[str, float]) -> str:
    """Return ``[axes.x.servo]`` tables and the ``[coupling]`` table as TOML, for ``--axis-params``."""
    parts = [
        table_text(f"axes.{letter.lower()}.servo", {"model": servo.model, **servo.parameters})
        for letter, servo in servos.items()
    ]
    if coupling:
        parts.append(table_text("coupling", coupling))
    return "\n".join(parts)


def summary_of(
    controller: str,
    servos: Mapping[str, Servo],
    coupling: Mapping[str, float],
    loops: Iterable[OpenLoop],
    found: BestGains | None,
    worst: Iterable[WorstMargins] = (),
) -> dict[str, Any]:
    """Return gains, margins and the search as plain values."""
    result: dict[str, Any] = {
        "schema_version": 1,
        "controller": controller,
        "axes": {k.lower(): {"model": s.model, **s.parameters} for k, s in servos.items()},
        "coupling": dict(coupling),
        "loops": [_margins(loop) for loop in loops],
    }
    drawn = [{k: _finite(v) for k, v in asdict(each).items()} for each in worst]
    if drawn:
        result["worst_of_draws"] = drawn
    if found is not None:
        start = found.start_rms_mm if math.isfinite(found.start_rms_mm) else None
        result["search"] = {
            "sets": found.tried,
            "refused": found.refused,
            "contour_rms_mm": found.contour_rms_mm,
            "start_contour_rms_mm": start,
        }
    return result


def _finite(value: str | float) -> str | float | None:
    return value if isinstance(value, str) or math.isfinite(value) else None


def _margins(loop: OpenLoop) -> dict[str, Any]:
    found = loop.margins()
    values = {
        "gain_margin": found.gain,
        "gain_margin_db": 20.0 * math.log10(found.gain),
        "phase_margin_deg": found.phase_deg,
        "modulus_margin": found.modulus,
        "crossover_hz": found.crossover_rad_s / (2.0 * math.pi),
    }
    known = {k: v if math.isfinite(v) and loop.stable else None for k, v in values.items()}
    return {"loop": loop.name, "stable": loop.stable, **known}

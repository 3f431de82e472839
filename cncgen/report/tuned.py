"""Tuned gains as a user sees them: margins, Bode tables, and servo tables for a machine file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cncgen.machine.record import Servo
from cncgen.servo.tuning import bode_table, loop_margins


def margin_text(servo: Servo, letter: str, period_s: float, bode: bool = True) -> str:
    """Return the margins of an axis's loop, and its Bode table where asked."""
    try:
        found = loop_margins(servo, letter, period_s)
    except ValueError as error:
        return f"{letter}: {error}"
    head = (
        f"{letter}: gain margin {found.gain:.3g}, phase margin {found.phase_deg:.1f}°, modulus margin {found.modulus:.3f},"
        f" crossover {found.crossover_rad_s / 6.283185307179586:.3g} Hz"
    )
    return f"{head}\n{bode_table(servo, letter, period_s)}" if bode else head


def servo_tables(servos: Mapping[str, Servo]) -> str:
    """Return ``[axes.x.servo]`` tables as TOML, for ``--axis-params``."""
    parts = []
    for letter, servo in servos.items():
        lines = [f"[axes.{letter.lower()}.servo]", f'model = "{servo.model}"']
        lines += [f"{key} = {_toml(value)}" for key, value in servo.parameters.items()]
        parts.append("\n".join(lines))
    return "\n\n".join(parts) + "\n"


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(repr(float(v)) for v in value) + "]"
    return repr(float(value)) if isinstance(value, float) else repr(value)

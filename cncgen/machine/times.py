"""The table ``[times]`` of a machine: the times for changing a tool, ramping the spindle, switching coolant and the like."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from types import MappingProxyType
from typing import Any

import numpy as np

from cncgen.machine.record import Machine


@dataclass(frozen=True, slots=True)
class Times:
    """Seconds that a machine takes beside moving its axes; all 0 where the machine says nothing.

    Attributes:
        tool_change_s: Time of a tool change without the way of the magazine.
        pocket_s: Time that the magazine takes from one pocket to the next.
        pockets: Pockets of a magazine that turns both ways; 0: it goes through all pockets between.
        spindle_acceleration_rpm_s: Rate of speeding up; infinite: no time.
        spindle_braking_rpm_s: Rate of slowing down; None: that of speeding up.
        spindle_ramp: Rising pairs (rpm, s from standstill) instead of a rate; speeds beyond the last are extrapolated.
        spindle_orient_s: Time to turn to an angle from standstill.
        coolant_s: Time of switching coolant on or off.
        pallet_s: Time of a pallet change.
        operator_stop_s: Time that an operator takes at M0, M1 and M60.
        block_s: Least time between the ends of two blocks with a feed.
        m_codes: Time by name of an M code (``M8``), before the other entries.
    """

    tool_change_s: float = 0.0
    pocket_s: float = 0.0
    pockets: int = 0
    spindle_acceleration_rpm_s: float = np.inf
    spindle_braking_rpm_s: float | None = None
    spindle_ramp: tuple[tuple[float, float], ...] = ()
    spindle_orient_s: float = 0.0
    coolant_s: float = 0.0
    pallet_s: float = 0.0
    operator_stop_s: float = 0.0
    block_s: float = 0.0
    m_codes: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))

    def __bool__(self) -> bool:
        """Return whether anything takes time."""
        return self != Times()

    def spindle_s(self, before_rpm: float, after_rpm: float) -> float:
        """Return the time from one speed to another; a reversal goes through standstill. Signs say the direction."""
        if before_rpm * after_rpm < 0.0:
            return self.spindle_s(before_rpm, 0.0) + self.spindle_s(0.0, after_rpm)
        low, high = sorted((abs(before_rpm), abs(after_rpm)))
        if self.spindle_ramp:
            return self._ramp(high) - self._ramp(low)
        braking = abs(after_rpm) < abs(before_rpm) and self.spindle_braking_rpm_s is not None
        rate = self.spindle_braking_rpm_s if braking else self.spindle_acceleration_rpm_s
        return (high - low) / (rate or np.inf)

    def _ramp(self, rpm: float) -> float:
        """Return the time from standstill to a speed."""
        speeds, times = (np.array([0.0, *column]) for column in zip(*self.spindle_ramp, strict=True))
        if rpm <= speeds[-1]:
            return float(np.interp(rpm, speeds, times))
        slope = (times[-1] - times[-2]) / (speeds[-1] - speeds[-2])
        return float(times[-1] + slope * (rpm - speeds[-1]))

    def tool_s(self, before: int | None, after: int | None) -> float:
        """Return the time of a tool change from one pocket to another; pockets that are not known add no way."""
        way = abs(after - before) if before is not None and after is not None else 0
        if self.pockets:
            way = min(way % self.pockets, -way % self.pockets)
        return self.tool_change_s + way * self.pocket_s


def times_of(machine: Machine) -> Times:
    """Return the times of a machine."""
    table = dict(machine.settings.get("times", {}))
    known = {field.name for field in fields(Times)}
    values: dict[str, Any] = {key: value for key, value in table.items() if key in known}
    if "spindle_ramp" in values:
        values["spindle_ramp"] = tuple((float(rpm), float(s)) for rpm, s in values["spindle_ramp"])
    if "m_codes" in values:
        values["m_codes"] = MappingProxyType(
            {
                f"M{key.upper().lstrip('M').lstrip('0') or '0'}": float(s)
                for key, s in values["m_codes"].items()
            }
        )
    return Times(**values)

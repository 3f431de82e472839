"""Parameters with the state of the machine: ``#<_x>`` and kin, ``#5420`` to ``#5428`` (LinuxCNC manual, "Predefined Named
Parameters", "Numbered Parameters")."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from cncgen.gcode.block import AXES

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

#: Current position in program coordinates and units.
POSITION = range(5420, 5429)
#: Where a probe touched, by axis, and whether it did.
PROBE, PROBE_HIT = 5061, 5070
#: Faults of the tool changer, which never happen here.
TOOL_CHANGER = (5600, 5601)


def position_parameter(ip: Interpreter, number: int) -> float:
    """Return #5420 (X) to #5428 (W)."""
    return ip.reported_position()[number - POSITION.start]


def _absolute(ip: Interpreter, index: int) -> float:
    return ip.machine_position()[index]


def _pocket(ip: Interpreter, number: int) -> float:
    """Return the pocket of a tool; 0 stands for the tool in the spindle, and -1 is returned where it holds none."""
    number = number or ip.state.tool
    return float(ip.tools.pocket_of(number)) if number else -1.0


NAMED: dict[str, Callable[[Interpreter], float]] = {
    **{
        f"_{letter}": partial(position_parameter, number=POSITION.start + index)
        for index, letter in enumerate(AXES)
    },
    **{f"_abs_{letter}": partial(_absolute, index=index) for index, letter in enumerate(AXES)},
    "_vmajor": lambda ip: 2.9,
    "_vminor": lambda ip: 0.0,
    "_line": lambda ip: ip.sink.block.line,
    "_motion_mode": lambda ip: float(ip.state.motion),
    "_plane": lambda ip: ip.state.plane * 10 if ip.state.plane < 100 else ip.state.plane,
    "_ccomp": lambda ip: ip.state.compensation * 10,
    "_metric": lambda ip: not ip.state.inches,
    "_imperial": lambda ip: ip.state.inches,
    "_absolute": lambda ip: ip.state.absolute,
    "_incremental": lambda ip: not ip.state.absolute,
    "_inverse_time": lambda ip: ip.state.feed_mode == 93,
    "_units_per_minute": lambda ip: ip.state.feed_mode == 94,
    "_units_per_rev": lambda ip: ip.state.feed_mode == 95,
    "_coord_system": lambda ip: 530 + 10 * ip.state.system if ip.state.system <= 6 else 584 + ip.state.system,
    "_tool_offset": lambda ip: any(ip.state.tool_offset),
    "_retract_r_plane": lambda ip: not ip.state.retract_old,
    "_retract_old_z": lambda ip: ip.state.retract_old,
    "_spindle_rpm_mode": lambda ip: ip.state.constant_surface is None,
    "_spindle_css_mode": lambda ip: ip.state.constant_surface is not None,
    "_ijk_absolute_mode": lambda ip: ip.state.arc_absolute,
    "_lathe_diameter_mode": lambda ip: ip.state.diameter,
    "_lathe_radius_mode": lambda ip: not ip.state.diameter,
    "_spindle_on": lambda ip: ip.state.direction != 0,
    "_spindle_cw": lambda ip: ip.state.direction == 1,
    "_mist": lambda ip: ip.state.mist,
    "_flood": lambda ip: ip.state.flood,
    "_speed_override": lambda ip: ip.state.speed_override,
    "_feed_override": lambda ip: ip.state.feed_override,
    "_adaptive_feed": lambda ip: ip.state.adaptive_feed,
    "_feed_hold": lambda ip: ip.state.feed_hold,
    "_feed": lambda ip: ip.state.feed,
    "_rpm": lambda ip: ip.state.speed,
    "_current_tool": lambda ip: ip.state.tool,
    "_current_pocket": lambda ip: _pocket(ip, ip.state.fetched),
    "_selected_tool": lambda ip: ip.state.selected,
    "_selected_pocket": lambda ip: _pocket(ip, ip.state.selected),
    "_call_level": lambda ip: ip.call_level(),
    "_task": lambda ip: 0.0,
    "_remap_level": lambda ip: 0.0,
    "_value": lambda ip: 0.0,
    "_value_returned": lambda ip: 0.0,
}

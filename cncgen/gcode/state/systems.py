"""Coordinate systems in the parameters: their first numbers, and the change to another system."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

#: The parameter that holds the system in force, the first one of G54, from system to system, and how many they are.
SYSTEM, SYSTEMS, SYSTEM_STEP, SYSTEM_COUNT = 5220, 5221, 20, 9
#: FANUC's additional systems, G54.1 P1 to P300; they count from `SYSTEM_COUNT` + 1. The first 48 have parameters from #7001 on, all of a
#: control with more of them from #14001 on (B-64484EN, 15.2).
MORE_SYSTEMS, MORE_COUNT, _FIRST_COUNT, _ALL_SYSTEMS = 7001, 300, 48, 14_001
ROTATION = 9
#: Where FANUC's shift of all work coordinate systems begins.
EXTERNAL = 5201


def first_parameter(system: int) -> int:
    """Return the number of the first parameter of a system."""
    if system > SYSTEM_COUNT:
        first = MORE_SYSTEMS if system <= SYSTEM_COUNT + _FIRST_COUNT else _ALL_SYSTEMS
        return first + SYSTEM_STEP * (system - SYSTEM_COUNT - 1)
    return SYSTEMS + SYSTEM_STEP * (system - 1)


def load_system(ip: Interpreter, system: int) -> None:
    """Take origin and rotation of a system from its parameters; the machine stays where it is."""
    machine = ip.machine_position()
    state, parameters = ip.state, ip.parameters
    state.system = system
    parameters.numbers[SYSTEM] = float(system)
    state.origin = parameters.offset(first_parameter(system), ip.table_scale())
    if ip.dialect == "fanuc":
        shift = parameters.offset(EXTERNAL, ip.table_scale())
        state.origin = [o + s for o, s in zip(state.origin, shift, strict=True)]
    state.rotation = parameters.numbers[first_parameter(system) + ROTATION]
    ip.rebase(machine)

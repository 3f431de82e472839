"""The machine description: TOML → `Machine`, with the profiles that ship.

`record` has `Machine`, `Axis` and `Servo`; `reading` makes them from TOML and names every fault, `checking` does so for machines
that a script makes, `writing` writes TOML. Keys of servo data are in `servo_parameters` and `servo_schema`, those of drives in
`drives`, those of further tables in `settings_schema`; `keys` lists all of them for people. `kinematics` and `tool_table` are
what programs of every language need of a machine.

Names are imported when they are asked for, as `cncgen check` needs the tool table alone.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.machine.record import Axis, Drive, Machine, Servo
    from cncgen.machine.shipped import load, load_coupling, load_servos, profile_names
    from cncgen.machine.shipped import load as load_machine
    from cncgen.machine.writing import to_toml

#: Public names: the module and the name in it. `load_machine` is the public name of `load`.
_PUBLIC = {
    "Axis": ("cncgen.machine.record", "Axis"),
    "Drive": ("cncgen.machine.record", "Drive"),
    "Machine": ("cncgen.machine.record", "Machine"),
    "Servo": ("cncgen.machine.record", "Servo"),
    "load": ("cncgen.machine.shipped", "load"),
    "load_coupling": ("cncgen.machine.shipped", "load_coupling"),
    "load_machine": ("cncgen.machine.shipped", "load"),
    "load_servos": ("cncgen.machine.shipped", "load_servos"),
    "profile_names": ("cncgen.machine.shipped", "profile_names"),
    "to_toml": ("cncgen.machine.writing", "to_toml"),
}

__all__ = [
    "Axis",
    "Drive",
    "Machine",
    "Servo",
    "load",
    "load_coupling",
    "load_machine",
    "load_servos",
    "profile_names",
    "to_toml",
]


def __getattr__(name: str) -> object:
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    module, attribute = _PUBLIC[name]
    value = globals()[name] = getattr(importlib.import_module(module), attribute)
    return value

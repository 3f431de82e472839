"""The machine description: TOML → `Machine`, with the profiles that ship.

`record` has `Machine`, `Axis` and `Servo`; `reading` makes them from TOML and names every fault, `checking` does so for machines
that a script makes, `writing` writes TOML. Keys of servo data are in `servo_parameters` and `servo_schema`, those of drives in
`drives`, those of further tables in `settings_schema`; `keys` lists all of them for people.
"""

from cncgen.machine.profiles import load, load_coupling, load_servos, profile_names
from cncgen.machine.record import Axis, Drive, Machine, Servo
from cncgen.machine.writing import to_toml

#: What `cncgen.load_machine` is called inside.
load_machine = load

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

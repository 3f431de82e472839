"""The machine description: TOML → `Machine`, with the profiles that ship."""

from cncgen.machine.profiles import load, load_coupling, load_servos, profile_names
from cncgen.machine.record import Axis, Machine, Servo
from cncgen.machine.writing import to_toml

#: What `cncgen.load_machine` is called inside.
load_machine = load

__all__ = [
    "Axis",
    "Machine",
    "Servo",
    "load",
    "load_coupling",
    "load_machine",
    "load_servos",
    "profile_names",
    "to_toml",
]

"""Every option of every command, as click's own tables list them, with values that nobody means.

A case is the words of a command, separated by NUL bytes: words that the command takes, then one option or two with such a value.
"""

from __future__ import annotations

import importlib
import random
import tomllib
from collections.abc import Iterator
from functools import cache

import click

from cncgen.cli import commands
from trials.generators import door_commands, door_inputs

#: Words that each command takes, with the files of `FILES`; what plans, plans soon.
_PLANNED = "-m m.toml --feedrate ild"
BASES = {
    "check": "p.nc",
    "canon": "p.nc",
    "plan": f"p.nc {_PLANNED} -o o.csv",
    "simulate": "s.csv --axis-params m.toml -o o.csv",
    "verify": "s.csv --program p.nc --machine m.toml",
    "cut": "p.nc --stock box:0,0,-10,30,20,0 --tool *=flat:6 --cell 1 -o o.stl",
    "convert": "p.nc -o o.nc",
    "compare": f"p.nc {_PLANNED}",
    "sweep run": "s.toml --dry-run -o o",
    "sweep show": "o",
    "why": "p.nc -m m.toml --effort fast",
    "compensate": f"p.nc {_PLANNED} -o o.csv",
    "identify": "log.csv --model velocity-loop -o o.toml",
    "excite": "--axis X --duration 0.1 --low 20 --high 50 -m m.toml -o o.csv",
    "tune": "-m m.toml --bandwidth 20 -o o.toml",
    "plot": "s.csv -m m.toml --kinds path -o o.svg",
    "report": f"p.nc {_PLANNED} -o o.html",
    "view": f"p.nc {_PLANNED}",
    "codes": "",
    "explain": "too-many-steps",
    "machines show": "m.toml",
    "machines keys": "",
}
VALUES = (
    "", " ", "0", "-0", "1", "-1", "3", "0.5", "nan", "-nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "1e9", "1e-9", "99999999999999999999", "9" * 400,
    "9" * 5000, "2147483648", "-2147483649", "1_000", "0x10", "\u0661", "true", "none", "auto", ",", "1,2,3", "1,2,", "1:2", "1:nan", "a=b", "=", "x=nan",
    "1=flat:nan", "1=ball:1e-300", "box:0,0,0,1,1,nan", "box:0,0,0,1e9,1e9,1e9", "cylinder:0,0,1e-9,0,1", "x" * 300, "x" * 5000, ".", "..", "/", "/dev/null",
    "/dev/full", "/proc/self/status", "no/such/o", "p.nc", "m.toml", "s.csv", "log.csv", "t.tbl", "o.csv", "o.npy", "o.hdf5", "o.unknown", "-", "--", "%s", "{0}", "\x1b[31m",
    "\x07", "\n", "\udcff", "\u202e", "*", "[", "]", "'", '"', "$(x)", "X", "XYZ", "XYZABCUVW", "XX", "Q", "x,y", "path", "linuxcnc", "fanuc", "G64", "p", "0.001", "1000",
)  # fmt: skip


@cache
def options() -> tuple[tuple[str, str, bool], ...]:
    """Return the options of all commands: words of the command, a name, and whether a value follows."""
    found = []
    for name in BASES:
        group, _, inner = name.partition(" ")
        command = importlib.import_module(f"cncgen.cli.{group}").command
        if inner:
            command = command.commands[inner]
        for option in command.params:
            if isinstance(option, click.Option):
                found += [(name, word, not option.is_flag) for word in (*option.opts, *option.secondary_opts)]
    return tuple(found)


@cache
def files() -> dict[str, bytes]:
    """Return the files of the folder that commands run in."""
    named = {tomllib.loads(file.decode())["name"]: file for file in door_inputs.machines()}
    return {
        "p.nc": b"G21 G64 P0.01\nT1 M6\nG1 X1 Y1 F1000\nG2 X2 Y0 I0.5 J-0.5\nG1 X0\nM2\n",
        "m.toml": named["xy-table"],
        "s.csv": door_inputs.setpoints("csv")[0],
        "log.csv": door_inputs.logs()[3],
        "s.toml": door_commands.SWEEP.encode(),
        "t.tbl": door_inputs.TOOLS[0],
        "t.stl": door_commands.STL.encode(),
    }


def seeds() -> list[bytes]:
    """Return the commands without hostile options."""
    return [
        b"\0".join(word.encode() for word in (*name.split(), *words.split())) for name, words in BASES.items()
    ]


def every_command() -> Iterator[str]:
    """Yield the words of each command."""
    for name in commands.COMMANDS:
        command = importlib.import_module(f"cncgen.cli.{name}").command
        yield from (
            [f"{name} {each}" for each in command.commands] if isinstance(command, click.Group) else [name]
        )


def change(rng: random.Random, data: bytes, sources: list[bytes]) -> bytes:
    """Return a case: a command with one hostile option or two, in place of a word of it or behind all; one of five changed anyhow."""
    if rng.random() < 0.2:
        return door_inputs.change(rng, data, sources)
    name, option, valued = rng.choice(options())
    words = [*name.split(), *BASES[name].split()]
    if rng.random() < 0.1 and BASES[name]:  # an argument, or the value of an option that the command has
        words[rng.randrange(len(name.split()), len(words))] = rng.choice(VALUES)
    _set(rng, words, option, valued)
    if rng.random() < 0.3:
        own = [each for each in options() if each[0] == name]
        _set(rng, words, *rng.choice(own)[1:])
    return b"\0".join(word.encode("utf-8", "surrogateescape") for word in words)


def _set(rng: random.Random, words: list[str], option: str, valued: bool) -> None:
    """Give an option a value, in place of the one that it has."""
    value = [rng.choice(VALUES)] if valued else []
    if option in words:
        at = words.index(option)
        words[at + 1 : at + 1 + len(value)] = value
    else:
        words += [option, *value]

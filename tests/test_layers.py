"""Modules that are loaded by name keep to the layers of pyproject.toml too, and every module has a place in them."""

from __future__ import annotations

import ast
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "cncgen"
#: Packages whose `__init__` only passes public names on: what they name stands above or below as the packages do.
FACADES = frozenset({"cncgen", "cncgen.machine", "cncgen.stepnc", "cncgen.servo", "cncgen.setpoints"})
#: Modules that no name stands for: what runs the commands is none.
ENTRIES = frozenset({"cncgen.cli.app"})
#: Rooms in which modules name each other for reasons that their own docstrings give.
UNORDERED = {
    "cncgen.gcode": "codes and the interpreter are mutually recursive: a code runs blocks, a block runs codes",
    "cncgen.setpoints.readers": "`isolated` runs the reader that asks for it in a process of its own",
}


def name_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {name_of(path): path for path in sorted(PACKAGE.rglob("*.py"))}


def named_in(path: Path) -> Iterator[str]:
    """Yield the modules that strings of a file name: whole names, and all below ``f"cncgen.room.{name}"``."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    documentation = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        and node.body
        and isinstance(node.body[0], ast.Expr)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr) and isinstance(node.values[0], ast.Constant):
            room = str(node.values[0].value)
            if room.startswith("cncgen.") and room.endswith("."):
                yield from (name for name in MODULES if name.startswith(room) and name not in ENTRIES)
        elif (
            isinstance(node, ast.Constant)
            and id(node) not in documentation
            and isinstance(node.value, str)
            and node.value != "cncgen"
            and node.value in MODULES
        ):
            yield node.value


def contracts() -> dict[str, list[set[str]]]:
    """Return the layers of each room, the highest first."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        found = tomllib.load(file)["tool"]["importlinter"]["contracts"]
    rooms: dict[str, list[set[str]]] = {}
    for contract in found:
        layers = [
            {part.strip(" ()") for part in layer.replace(":", "|").split("|")} for layer in contract["layers"]
        ]
        for room in contract["containers"]:
            rooms[room] = layers
    return rooms


def fault(user: str, used: str, rooms: dict[str, list[set[str]]]) -> str:
    """Return what is wrong with one module that names another, or ""."""
    one, other = user.split("."), used.split(".")
    common = 0
    while common < min(len(one), len(other)) and one[common] == other[common]:
        common += 1
    room = ".".join(one[:common])
    if room in UNORDERED or common == len(one) or common == len(other) or room not in rooms:
        return ""
    level = {name: k for k, layer in enumerate(rooms[room]) for name in layer}
    high, low = level[one[common]], level[other[common]]
    return "" if high < low else f"{user} names {used}, which stands no lower in {room}"


def test_modules_that_strings_name_stand_below_those_that_name_them() -> None:
    rooms = contracts()
    pairs = [
        (user, used)
        for user, path in MODULES.items()
        if user not in FACADES
        for used in named_in(path)
        if used != user
    ]
    # Commands, formats, strategies, languages, papers and codes are loaded so: were none found, this test were blind.
    for user in (
        "cncgen.cli.commands",
        "cncgen.setpoints.writers",
        "cncgen.planner.strategies",
        "cncgen.pipeline.reading",
        "cncgen.papers.reproduction",
        "cncgen.gcode.codes.table",
    ):
        assert any(one == user for one, _ in pairs), f"{user} loads nothing by name"
    assert [said for user, used in pairs if (said := fault(user, used, rooms))] == []


def test_a_name_upwards_is_seen() -> None:
    rooms = contracts()
    assert fault("cncgen.planner.record", "cncgen.report.page", rooms)
    assert fault("cncgen.setpoints.record", "cncgen.setpoints.writers.csv", rooms)
    assert not fault("cncgen.report.page", "cncgen.planner.record", rooms)


@pytest.mark.parametrize("room", sorted({name.rpartition(".")[0] for name in MODULES} - {""}))
def test_every_module_has_a_place(room: str) -> None:
    """Each module of a room stands in exactly one layer of its contract."""
    rooms = contracts()
    if room.startswith("cncgen.gcode.") and room not in rooms:
        return  # the contract of cncgen.gcode holds its rooms, each of which is one executor or one table in parts
    assert room in rooms, f"no contract holds the modules of {room}"
    named = [name for layer in rooms[room] for name in layer]
    inside = {name.rpartition(".")[2] for name in MODULES if name.rpartition(".")[0] == room}
    assert len(named) == len(set(named))
    assert inside <= set(named), f"{sorted(inside - set(named))} of {room} have no place"

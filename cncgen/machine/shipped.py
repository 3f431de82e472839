"""Machines by name (the profiles that ship) or by file."""

from __future__ import annotations

import difflib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cncgen.arguments import expect_path
from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import read_utf8
from cncgen.machine.reading import (
    MAX_BYTES,
    coupling_from_toml,
    machine_from_toml,
    parse_toml,
    servos_from_toml,
)
from cncgen.machine.record import Machine, Servo

_DIRECTORY = Path(__file__).parent / "profiles"


def profile_names() -> list[str]:
    """Return the names of the profiles that ship, sorted."""
    return sorted(path.stem for path in _DIRECTORY.glob("*.toml"))


def profile_text(name: str) -> str:
    """Return the TOML text of a profile that ships.

    Raises:
        UsageError: No profile or file has that name.
    """
    if name not in profile_names():
        raise _unknown(name)
    return (_DIRECTORY / f"{name}.toml").read_text(encoding="utf-8")


def load(name_or_path: str | os.PathLike[str]) -> Machine:
    """Return a machine: a profile by its name, or a TOML file.

    A text that names a profile is that profile; a name that ends in ``.toml``, holds a path separator or exists is a file.

    Raises:
        UsageError: There is neither, or the file has faults (all of them are named).
    """
    content, name = _content(name_or_path)
    return machine_from_toml(content, name)


def load_servos(name_or_path: str | os.PathLike[str]) -> dict[str, Servo]:
    """Return the servo data of each axis that has any: from a profile, a machine file, or a file of servos alone.

    Raises:
        UsageError: As `load`; also where no axis has servo data.
    """
    content, name = _content(name_or_path)
    return servos_from_toml(content, name)


def load_coupling(name_or_path: str | os.PathLike[str]) -> Mapping[str, Any]:
    """Return the ``[coupling]`` table (gains of controllers that couple axes) from the source of `load_servos`; {} if missing.

    Its keys are checked by `cncgen.servo.named_schemes.settings_of`.
    """
    return coupling_from_toml(*_content(name_or_path))


def has_limits(name_or_path: str | os.PathLike[str]) -> bool:
    """Tell whether the source of `load_servos` has the limits of an axis too, so that a plan can be made for it.

    Raises:
        UsageError: It cannot be read, or is not TOML.
    """
    axes = parse_toml(*_content(name_or_path))[0].get("axes")
    tables = axes.values() if isinstance(axes, dict) else ()
    return any(key.startswith("max_") for table in tables if isinstance(table, dict) for key in table)


def _content(name_or_path: str | os.PathLike[str]) -> tuple[bytes, str]:
    text = expect_path(name_or_path, "the machine", "a profile's name or a TOML file")
    if text in profile_names():
        return (_DIRECTORY / f"{text}.toml").read_bytes(), text
    if not (text.endswith(".toml") or os.sep in text or os.path.exists(text)):
        raise _unknown(text)
    return read_utf8(text, at_most=MAX_BYTES), text


def _unknown(name: str) -> UsageError:
    names = profile_names()
    near = difflib.get_close_matches(name.lower(), names, 1)
    hint = f"did you mean {near[0]}? " if near else ""
    return UsageError(
        Diagnostic(
            "machine-unknown",
            f"there is no machine profile {name!r}, and no such file",
            hint=f"{hint}profiles: {', '.join(names)}; or give a TOML file",
        )
    )

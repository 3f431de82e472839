"""The search path of subprograms: the program's own folder, and those that the user adds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

#: Suffixes of files with subprograms; FANUC's have often none.
_SUFFIXES = (".ngc", ".nc", ".tap", ".cnc", "")


def search_path(program: Path | None, include: Sequence[Path]) -> list[Path]:
    """Return the folders in which subprograms are looked for, in order."""
    return ([program.parent] if program else []) + list(include)


def candidates(folder: Path, name: str) -> list[Path]:
    """Return the files of a folder that hold a subprogram of that name (names are case-insensitive)."""
    exact = folder / f"{name}.ngc"
    try:
        if exact.is_file():
            return [exact]
        if not folder.is_dir():
            return []
        wanted = {f"{name}{suffix}".lower() for suffix in _SUFFIXES}
        return sorted(path for path in folder.iterdir() if path.name.lower() in wanted and path.is_file())
    except (OSError, ValueError):  # no name of a file: too long, or with a NUL
        return []


def leaves_path(name: str) -> bool:
    """Tell whether a name of a subprogram leads out of the folder that it is looked for in."""
    return "/" in name or "\\" in name or name.startswith(".")

"""The search path of subprograms: the program's own folder, and those that the user adds."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import lru_cache

from cncgen.diagnostics import UsageError
from cncgen.gcode.source import Source, open_source
from cncgen.grammars.terminals import FANUC

TYPE_CHECKING = False
if TYPE_CHECKING:
    from pathlib import Path

#: Suffixes of files with subprograms; FANUC's have often none.
SUFFIXES = (".ngc", ".nc", ".gcode", ".tap", ".cnc", ".txt", "")


def search_path(program: str | os.PathLike[str] | None, include: Sequence[Path]) -> list[Path]:
    """Return the folders in which subprograms are looked for, in order, as they are when a run begins."""
    from pathlib import Path

    _listed.cache_clear()
    return ([Path(program).parent] if program else []) + list(include)


def parted(comment: str) -> tuple[str, str]:
    """Return folder and name of the file that a comment names, as behind M98 of Haas: ``(USB0/JOBS/PART.NC)``."""
    folder, _, name = (
        comment.strip().removeprefix("(").removesuffix(")").strip().replace("\\", "/").rpartition("/")
    )
    return folder, name


def places(folders: Sequence[Path]) -> str:
    """Return how a message names the folders."""
    return ", ".join(str(folder) for folder in folders) or "the search path, which is empty"


def opened(folders: Sequence[Path], name: str, suffixes: Sequence[str] = SUFFIXES) -> Source | None:
    """Return the first file that may hold a subprogram and can be read, None where no folder has one."""
    if not leaves_path(name):
        for folder in folders:
            for path in candidates(folder, name, suffixes):
                with suppress(UsageError):
                    return open_source(path, str(path))
    return None


def candidates(folder: Path, name: str, suffixes: Sequence[str] = SUFFIXES) -> list[Path]:
    """Return the files of a folder that may hold a subprogram, the best first (names are case-insensitive).

    A symbolic link that leads out of the folder is passed over: a program opens no file beyond the search path.
    """
    exact = folder / f"{name}{suffixes[0]}"
    try:
        if _holds(folder, exact):
            return [exact]
        listed = _listed(folder)
        wanted = [f"{spelling}{suffix}".lower() for spelling in _spellings(name) for suffix in suffixes]
        found = [folder / file for lower in dict.fromkeys(wanted) for file in listed.get(lower, ())]
        return [path for path in found if _holds(folder, path)]
    except (OSError, ValueError):  # no name of a file: too long, or with a NUL
        return []


@lru_cache(maxsize=16)
def _listed(folder: Path) -> dict[str, list[str]]:
    """Return the names in a folder by their lower case: listed once a run, since calls of missing files may be many."""
    names: dict[str, list[str]] = {}
    for name in sorted(os.listdir(folder)) if folder.is_dir() else ():
        names.setdefault(name.lower(), []).append(name)
    return names


def _holds(folder: Path, path: Path) -> bool:
    """Tell whether a path is a file that lies in a folder or below it, links followed.

    One that begins with a point has a suffix, as ``.m6.ngc`` that a list of programs is not to show: others hold settings of systems.
    """
    inside = path.is_file() and (not path.is_symlink() or path.resolve().is_relative_to(folder.resolve()))
    return inside and (path.suffix != "" or not path.name.startswith("."))


def _spellings(name: str) -> Iterator[str]:
    """Yield how the file of a subprogram may be called, without its suffix: that of FANUC may leave out the O and leading zeros."""
    yield name
    if re.fullmatch(FANUC["O_NUMBER"], name.lower()):
        number = name[1:].lstrip("0") or "0"
        yield from (f"O{number}", number.zfill(4), number)


def leaves_path(name: str) -> bool:
    """Tell whether a name of a subprogram leads out of the folder that it is looked for in."""
    return "/" in name or "\\" in name or not name.strip(".")

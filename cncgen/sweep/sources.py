"""The programs and machines that a sweep names: read once, so that jobs carry them by hash and need no file."""

from __future__ import annotations

import glob
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cncgen.diagnostics import CncgenError
from cncgen.files import read_bytes
from cncgen.machine import load, profile_names
from cncgen.machine.toml_file import toml_value_shown
from cncgen.sweep.figures import FILES
from cncgen.sweep.jobs import Bundle, bundle_of
from cncgen.sweep.machine_keys import Tables, tables_of

if TYPE_CHECKING:
    from cncgen.sweep.definition import SweepReader

#: Bytes of the files beside a program, all together: every worker keeps them in memory.
_MOST_BYTES = 1_000_000_000


def programs_of(reader: SweepReader, table: Mapping[str, Any], options: dict[str, Any]) -> dict[str, Bundle]:
    """Return the programs that ``programs`` names, each with the files of ``include`` and of the options that name files.

    The options' names become those of the files in the bundle.
    """
    patterns = reader.texts(table, "programs")
    if not patterns and not reader.file.faults.has_errors:
        reader.fault("sweep-missing", "programs", "programs: a sweep needs at least one program")
    beside = _included(reader, table)
    for key in FILES:
        if isinstance(options.get(key), str):
            content = _content(reader, f"options.{key}", reader.folder / options[key])
            options[key] = f"options/{key}/{os.path.basename(options[key])}"
            beside[options[key]] = content
    found: dict[str, Bundle] = {}
    for pattern in patterns:
        named = os.path.join(glob.escape(str(reader.folder)), pattern)
        paths = [path for path in sorted(glob.glob(named, recursive=True)) if os.path.isfile(path)]
        if os.path.isfile(reader.folder / pattern):  # part[1].nc names a file, too
            paths = [str(reader.folder / pattern)]
        if not paths:
            reader.fault("sweep-value", "programs", f"programs: no file is named {pattern}")
        names = [os.path.relpath(path, reader.folder).replace(os.sep, "/") for path in paths]
        if names and found.keys() >= set(names):
            reader.fault(
                "sweep-value", "programs", f"programs: {pattern} names what stands before it already"
            )
        for name, path in zip(names, paths, strict=True):
            base = os.path.basename(path)
            found[name] = bundle_of(base, {**beside, base: _content(reader, "programs", Path(path))})
    return found


def _included(reader: SweepReader, table: Mapping[str, Any]) -> dict[str, bytes]:
    """Return the files of the folders of ``include`` by their names there: subprograms, which programs call by name.

    Of files with one name that of the first folder counts, as of the folders of ``--include``.
    """
    files: dict[str, bytes] = {}
    for name in reader.texts(table, "include"):
        folder = reader.folder / name
        if not folder.is_dir():
            reader.fault("sweep-value", "include", f"include: {name} is not a folder")
            continue
        for path in sorted(item for item in folder.iterdir() if item.is_file()):
            if path.name not in files:
                files[path.name] = _content(reader, "include", path)
    if sum(map(len, files.values())) > _MOST_BYTES:
        reader.fault("sweep-value", "include", f"include: the files are larger than {_MOST_BYTES} bytes")
    return files


def _content(reader: SweepReader, key: str, path: Path) -> bytes:
    try:
        return read_bytes(path, at_most=_MOST_BYTES)
    except CncgenError as error:
        reader.fault("sweep-value", key, f"{key}: {error.diagnostics[0].message}")
        return b""


def machines_of(reader: SweepReader, table: Mapping[str, Any]) -> dict[str, Tables]:
    """Return the tables of the machines that ``machine`` or ``machines`` names: profiles, or files."""
    if "machine" in table and "machines" in table:
        reader.fault("sweep-key", "machines", "machines: machine stands there too; one of them is enough")
    if "machine" in table and not isinstance(table["machine"], str):
        shown = toml_value_shown(table["machine"])
        reader.fault("sweep-type", "machine", f"machine: must be a text, is {shown}", "machines takes a list")
        return {}
    key = "machine" if "machine" in table else "machines"
    names = reader.texts(table, key)
    if not names and not reader.file.faults.has_errors:
        reader.fault("sweep-missing", "machine", "machine: a sweep needs a machine, a profile or a file")
    found: dict[str, Tables] = {}
    for name in names:
        if name in found:
            reader.fault("sweep-value", key, f"{key}: {name} stands twice")
        where = name if name in profile_names() or os.path.isabs(name) else str(reader.folder / name)
        if name not in profile_names() and not os.path.exists(where):
            where = name
        try:
            found[name] = tables_of(load(where))
        except CncgenError as error:
            for item in error.diagnostics:
                if item.span is None:  # the file or profile itself, and no place in it
                    reader.fault(item.code, key, f"{key}: {item.message}", item.hint)
                else:
                    reader.file.faults.add(item)
    return found

"""Names of the formats of setpoints and of the dialects of G-code, and formats and dialects that other packages bring as entry points.

A package adds a format of setpoints by an entry point of the group ``cncgen.setpoint_formats``. Its name is that of the format and its
suffix. It leads to a module with a class ``Writer(sink, layout)``, a function ``blocks(file, name, axes, period_s)``, or both, like
the modules of `cncgen.setpoints.writers` and `readers`. ``BINARY = False`` says that a terminal may show it. A dialect is an entry
point of the group ``cncgen.dialects`` with the name for ``--dialect``. It leads to a module with ``BASE``, a dialect of cncgen, and
``translated(text)``, which returns a text of that dialect line by line. docs/extensions.md has examples.

Entry points are searched only if a name is not one of ours, because reading them takes some 20 ms.
"""

from __future__ import annotations

from types import ModuleType

from cncgen.diagnostics import Diagnostic, UsageError

#: Formats of setpoints in the order that messages name them.
FORMATS = (
    "csv",
    "jsonl",
    "npy",
    "npz",
    "f64",
    "hal",
    "arrow",
    "parquet",
    "mat",
    "hdf5",
    "mcap",
    "mf4",
    "csp",
    "csp-raw",
)
#: Formats that a terminal is never sent.
BINARY = ("npy", "npz", "f64", "arrow", "parquet", "mat", "hdf5", "mcap", "mf4", "csp-raw")
#: Suffixes that differ from the format's name.
SUFFIXES = {"h5": "hdf5", "feather": "arrow", "ndjson": "jsonl", "cspraw": "csp-raw"}

#: Dialects of G-code.
DIALECTS = ("linuxcnc", "fanuc", "fanuc-lathe", "fanuc-lathe-b", "fanuc-lathe-c", "heidenhain", "sinumerik")

FORMAT_GROUP, DIALECT_GROUP = "cncgen.setpoint_formats", "cncgen.dialects"


def foreign_names(group: str) -> tuple[str, ...]:
    """Return the names of the entry points of a group, sorted."""
    from importlib.metadata import entry_points

    return tuple(sorted({point.name for point in entry_points(group=group)}))


def unknown_format(name: str) -> str:
    """Say that no format of setpoints has this name, and which there are."""
    return f"format {name!r} is not one of {', '.join((*FORMATS, *foreign_names(FORMAT_GROUP)))}"


def is_format(name: str) -> bool:
    """Tell whether a format of setpoints has this name."""
    return name in FORMATS or name in foreign_names(FORMAT_GROUP)


def is_binary(name: str) -> bool:
    """Tell whether a terminal is never sent a format."""
    if name in FORMATS:
        return name in BINARY
    return bool(getattr(foreign_module(FORMAT_GROUP, name), "BINARY", True))


def is_brought(group: str, name: str) -> bool:
    """Tell whether an installed package has an entry point of that name."""
    from importlib.metadata import entry_points

    return bool(tuple(entry_points(group=group, name=name)))


def foreign_module(group: str, name: str) -> ModuleType:
    """Load the target of an entry point.

    Raises:
        UsageError: The entry point is missing, or it cannot be loaded.
    """
    from importlib.metadata import entry_points

    found = tuple(entry_points(group=group, name=name))
    if not found:
        raise UsageError(Diagnostic("extension", f"no installed package brings {name!r} of {group}"))
    try:
        module: ModuleType = found[0].load()
    except Exception as error:  # code of others may raise anything
        text = f"{found[0].value}, which brings {name!r} of {group}, cannot be loaded: {error}"
        raise UsageError(Diagnostic("extension", text)) from error
    return module


def part_of(module: ModuleType, name: str, what: str) -> object:
    """Return a name of a module that an entry point names.

    Raises:
        UsageError: It has no such name.
    """
    found: object = getattr(module, name, None)
    if found is None:
        raise UsageError(Diagnostic("extension", f"{module.__name__} has no {name}: it cannot {what}"))
    return found

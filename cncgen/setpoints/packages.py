"""Packages that some formats of setpoints need, and the message where one is missing."""

from __future__ import annotations

import importlib.util
import os
from types import ModuleType

from cncgen.diagnostics import Diagnostic, UsageError

#: Module that a format needs, and the extra of cncgen that installs it.
NEEDED = {
    "arrow": ("pyarrow", "arrow"),
    "parquet": ("pyarrow", "arrow"),
    "hdf5": ("h5py", "hdf5"),
    "mcap": ("mcap", "mcap"),
    "mf4": ("asammdf", "mf4"),
}


def needed(kind: str, module: str = "") -> ModuleType:
    """Import the package that a format needs, or one of its modules.

    Raises:
        UsageError: It is missing.
    """
    package = NEEDED[kind][0]
    # Arrow's own allocators take a GiB of address space at once, which counts against `--max-memory`.
    os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")
    try:
        return importlib.import_module(module or package)
    except ImportError as error:
        raise _missing(kind) from error


def check_installed(kind: str) -> None:
    """Raise `UsageError` where the package that a format needs is missing; it is not imported."""
    if kind in NEEDED and importlib.util.find_spec(NEEDED[kind][0]) is None:
        raise _missing(kind)


def _missing(kind: str) -> UsageError:
    package, extra = NEEDED[kind]
    message = f"format {kind} needs {package}"
    return UsageError(Diagnostic("missing-package", message, hint=f"pip install 'cncgen[{extra}]'"))

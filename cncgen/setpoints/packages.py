"""Packages that some formats of setpoints need, and the message where one is missing."""

from __future__ import annotations

import importlib
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
    package, extra = NEEDED[kind]
    # Arrow's own allocators take a GiB of address space at once, which counts against `--max-memory`.
    os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")
    try:
        return importlib.import_module(module or package)
    except ImportError as error:
        hint = f"pip install 'cncgen[{extra}]'"
        message = f"format {kind} needs {package}"
        raise UsageError(Diagnostic("missing-package", message, hint=hint)) from error

"""cncgen: NC programs to servo setpoints within the machine's limits.

The library in a line a stage: `read` a program, `plan` it on a machine, `sample` the trajectory, `simulate` the
servo axes. Names are imported when they are first used, so that ``import cncgen`` costs nothing.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_PUBLIC = {
    "read": "cncgen.pipeline",
    "plan": "cncgen.pipeline",
    "sample": "cncgen.pipeline",
    "simulate": "cncgen.pipeline",
    "load_machine": "cncgen.machine",
    "Machine": "cncgen.machine",
    "Diagnostic": "cncgen.diagnostics",
    "CncgenError": "cncgen.diagnostics",
}

__all__ = [*_PUBLIC, "__version__"]


def __getattr__(name: str) -> Any:
    """Import a public name on first use (PEP 562)."""
    if name not in _PUBLIC:
        raise AttributeError(f"module 'cncgen' has no attribute {name!r}")
    return getattr(importlib.import_module(_PUBLIC[name]), name)


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)

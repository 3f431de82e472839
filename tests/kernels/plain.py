"""Kernels as plain Python, beside their compiled form."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

_KERNELS = Path(__file__).resolve().parents[2] / "cncgen" / "kernels"


def uncompiled(name: str) -> ModuleType:
    """Load a kernel's source under another name, so that it runs as plain Python."""
    spec = importlib.util.spec_from_file_location(f"plain_{name}", _KERNELS / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module

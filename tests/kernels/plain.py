"""Kernels as plain Python, beside their compiled form."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from unittest.mock import patch

import cython  # noqa: F401 - it puts its own functions of C in place when it is first imported

from cncgen.kernels.plain import math_of_c

_KERNELS = Path(__file__).resolve().parents[2] / "cncgen" / "kernels"


def uncompiled(name: str) -> ModuleType:
    """Load a kernel's source under another name, so that it runs as plain Python, with the functions of C that it has there."""
    spec = importlib.util.spec_from_file_location(f"plain_{name}", _KERNELS / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    with patch.dict(sys.modules, {"cython.cimports.libc.math": math_of_c()}):
        spec.loader.exec_module(module)
    return module

"""Kernels as plain Python, beside their compiled form."""

from __future__ import annotations

import importlib.util
import re
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from unittest.mock import patch

import cython  # noqa: F401 - it puts its own functions of C in place when it is first imported

from cncgen.kernels.plain import math_of_c

#: Where kernels find what they use of others as C.
_CIMPORTS = "cython.cimports.cncgen.kernels"
_KERNELS = Path(__file__).resolve().parents[2] / "cncgen" / "kernels"


def uncompiled(name: str, *beneath: str) -> ModuleType:
    """Load a kernel's source under another name, so that it runs as plain Python, with the functions of C that it has there.

    The kernels `beneath` it whose classes it uses as C run so too.
    """
    packages = {each: ModuleType(each) for each in (_CIMPORTS.rpartition(".")[0], _CIMPORTS)}
    with patch.dict(sys.modules, {"cython.cimports.libc.math": math_of_c(), **packages}):
        for each in (*beneath, name):
            path = _KERNELS / f"{each}.py"
            for used in re.findall(rf"{re.escape(_CIMPORTS)}\.(\w+)", path.read_text("utf-8")):
                sys.modules.setdefault(f"{_CIMPORTS}.{used}", import_module(f"cncgen.kernels.{used}"))
            spec = importlib.util.spec_from_file_location(f"plain_{each}", path)
            assert spec is not None
            assert spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
            sys.modules[f"{_CIMPORTS}.{each}"] = sys.modules[f"cncgen.kernels.{each}"] = module
    return module

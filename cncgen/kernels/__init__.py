"""The hot loops, in Cython's pure-Python mode: plain arrays in, plain arrays out, nothing imported from other rooms.

What one kernel calls of another as C stands in a ``.pxd`` beside it.

Each module runs compiled or not. `warn_if_uncompiled` says once, when a command starts work, that it is the slow way.
"""

import importlib.machinery
import warnings
from pathlib import Path


def uncompiled() -> list[str]:
    """Return the names of the kernel modules that have no compiled form beside their source."""
    here = Path(__file__).parent
    suffixes = tuple(importlib.machinery.EXTENSION_SUFFIXES)
    built = {p.name.split(".")[0] for p in here.iterdir() if p.name.endswith(suffixes)}
    return sorted(p.stem for p in here.glob("*.py") if p.stem != "__init__" and p.stem not in built)


def warn_if_uncompiled() -> None:
    """Warn once (a RuntimeWarning) where kernels run as plain Python."""
    slow = uncompiled()
    if slow:
        warnings.warn(
            f"kernels run uncompiled, some 50 times slower ({', '.join(slow)}): "
            "reinstall where a C compiler is present",
            RuntimeWarning,
            stacklevel=2,
        )

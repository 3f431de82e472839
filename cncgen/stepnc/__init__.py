"""STEP-NC: ISO 14649 and AP238 programs in ISO 10303-21 files.

`read` gives a `Program` of toolpaths, `canon` the canonical machining functions as text, `tree` the workplan with
times; `write_ap238` puts toolpaths into an AP238 file, `gcode_lines` into G-code. `Exchange` and `write` of
`cncgen.stepnc.part21` read and write any Part 21 file.
"""

from __future__ import annotations

import importlib
from typing import Any

_PUBLIC = {
    "read": "cncgen.stepnc.reading",
    "canon": "cncgen.stepnc.reading",
    "entities_by_line": "cncgen.stepnc.reading",
    "tree": "cncgen.stepnc.listing",
    "write_ap238": "cncgen.stepnc.ap238.writer",
    "gcode_lines": "cncgen.stepnc.gcode",
    "Exchange": "cncgen.stepnc.part21",
}

__all__ = list(_PUBLIC)


def __getattr__(name: str) -> Any:
    """Import a public name on first use (PEP 562)."""
    if name not in _PUBLIC:
        raise AttributeError(f"module 'cncgen.stepnc' has no attribute {name!r}")
    return getattr(importlib.import_module(_PUBLIC[name]), name)

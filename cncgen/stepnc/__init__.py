"""STEP-NC: ISO 14649 and AP238 programs in ISO 10303-21 files.

`read` gives a `Program` of toolpaths, `canon` the canonical machining functions as text, `tree` the workplan with
times (`entries` as records); `write_ap238` puts toolpaths into an AP238 file, `gcode_lines` into G-code. `Exchange` and `write` of
`cncgen.stepnc.part21` read and write any Part 21 file. Rooms in the order in which data passes them:

    part21              an exchange structure (ISO 10303-21) as instances
    schema              attributes of each entity by name, and checks against the schema
    iso14649, ap238     readers of the two schemas; both make the records of `model`
    geometry            placements, curves and profiles of ISO 10303-42 and ISO 14649-10
    features            toolpaths for features that come without
    execution           walks the records and calls the canonical machining functions; `columns` makes a `Toolpath` of them
"""

from __future__ import annotations

import importlib
from typing import Any

_PUBLIC = {
    "read": "cncgen.stepnc.reading",
    "canon": "cncgen.stepnc.reading",
    "entities_by_line": "cncgen.stepnc.reading",
    "tree": "cncgen.stepnc.listing",
    "entries": "cncgen.stepnc.listing",
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

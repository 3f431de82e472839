"""cncgen: NC programs to servo setpoints within the machine's limits.

The library in a line a stage: `read` a program (`read_text`: from memory), `plan` it on a machine, `sample` the
trajectory (`plan_with_summary`: both, with the figures of the plan), `write` the setpoints (`read_setpoints` reads
those of any origin), `simulate` the servo axes, `judge` them against program and machine. Lengths are mm, times s,
angles rad. What is wrong with a program, a machine file or a call raises `CncgenError` with all its diagnostics. Names
are imported when they are first used, so that ``import cncgen`` costs nothing: not even `typing` is imported.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from cncgen.diagnostics import CncgenError as CncgenError
    from cncgen.diagnostics import Diagnostic as Diagnostic
    from cncgen.machine import Machine as Machine
    from cncgen.machine import load_machine as load_machine
    from cncgen.pipeline import judge as judge
    from cncgen.pipeline import plan as plan
    from cncgen.pipeline import plan_with_summary as plan_with_summary
    from cncgen.pipeline import read as read
    from cncgen.pipeline import read_setpoints as read_setpoints
    from cncgen.pipeline import read_text as read_text
    from cncgen.pipeline import sample as sample
    from cncgen.pipeline import simulate as simulate
    from cncgen.pipeline import write as write
    from cncgen.planner import PlanOptions as PlanOptions
    from cncgen.setpoints.record import Setpoints as Setpoints
    from cncgen.toolpath.reading import ReadOptions as ReadOptions

__version__ = "0.1.0"

_PUBLIC = {
    "read": "cncgen.pipeline",
    "read_text": "cncgen.pipeline",
    "plan": "cncgen.pipeline",
    "plan_with_summary": "cncgen.pipeline",
    "sample": "cncgen.pipeline",
    "simulate": "cncgen.pipeline",
    "judge": "cncgen.pipeline",
    "write": "cncgen.pipeline",
    "read_setpoints": "cncgen.pipeline",
    "load_machine": "cncgen.machine",
    "Machine": "cncgen.machine",
    "PlanOptions": "cncgen.planner",
    "ReadOptions": "cncgen.toolpath.reading",
    "Setpoints": "cncgen.setpoints.record",
    "Diagnostic": "cncgen.diagnostics",
    "CncgenError": "cncgen.diagnostics",
}

__all__ = [*_PUBLIC, "__version__"]


def __getattr__(name: str) -> Any:
    """Import a public name on first use (PEP 562)."""
    if name not in _PUBLIC:
        raise AttributeError(f"module 'cncgen' has no attribute {name!r}")
    import importlib

    value = globals()[name] = getattr(importlib.import_module(_PUBLIC[name]), name)
    return value


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)

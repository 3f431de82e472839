"""cncgen: NC programs to servo setpoints, in the least time within the machine's limits.

One function per stage, in the order of the data::

    import cncgen

    program = cncgen.read("part.nc")  # read_text: from memory
    plan = cncgen.plan(program, "xy-table")  # when the motion is where on the path
    setpoints = cncgen.sample(plan)  # positions of the axes, one row a period
    cncgen.write(setpoints, "part.csv")  # read_setpoints reads files of any origin

`plan_with_summary` plans and samples at once, and gives the figures of the plan. `simulate` computes the response of the servo axes to
setpoints. `judge` compares setpoints with program and machine. All of them work on streams: nothing is computed before it is needed,
and a stream can be consumed once.

Lengths are mm, times s, angles rad. A fault in a program, a machine file or a call raises `CncgenError`, with all diagnostics that
were found. Examples: docs/library.md; how the code is built: docs/architecture.md.
"""

# Names are imported when they are first used, so that ``import cncgen`` takes no time: not even `typing` is imported here.

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
    from cncgen.pipeline import report_page as report_page
    from cncgen.pipeline import sample as sample
    from cncgen.pipeline import simulate as simulate
    from cncgen.pipeline import viewer as viewer
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
    "report_page": "cncgen.pipeline",
    "viewer": "cncgen.pipeline",
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

"""The stages in order: read, plan, sample, write, simulate, judge. The command line and the library both call this.

    import cncgen
    program = cncgen.read("programs/butterfly.nc")
    plan = cncgen.plan(program, "xy-table", feedrate="ild")
    setpoints = cncgen.sample(plan)
    response = cncgen.simulate(setpoints, "xy-table")

Each stage takes chunks from the previous stage on demand, so a program of any length is processed as a stream.
"""

# Names are imported when they are first used: a check needs no plan.

from __future__ import annotations

import importlib

from cncgen.shown import shown_by

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from cncgen.pipeline.file_kinds import SUFFIXES as SUFFIXES
    from cncgen.pipeline.file_kinds import language_of as language_of
    from cncgen.pipeline.planning import Plan as Plan
    from cncgen.pipeline.planning import driven_axes as driven_axes
    from cncgen.pipeline.planning import machine_of as machine_of
    from cncgen.pipeline.planning import options_on as options_on
    from cncgen.pipeline.planning import output_axes as output_axes
    from cncgen.pipeline.planning import plan as plan
    from cncgen.pipeline.planning import plan_with_summary as plan_with_summary
    from cncgen.pipeline.planning import sample as sample
    from cncgen.pipeline.reading import canon as canon
    from cncgen.pipeline.reading import check as check
    from cncgen.pipeline.reading import read as read
    from cncgen.pipeline.reading import read_text as read_text
    from cncgen.pipeline.reading import reader_of as reader_of
    from cncgen.pipeline.reading import sound as sound
    from cncgen.pipeline.reporting import Page as Page
    from cncgen.pipeline.reporting import ShownPart as ShownPart
    from cncgen.pipeline.reporting import Variant as Variant
    from cncgen.pipeline.reporting import report_page as report_page
    from cncgen.pipeline.reporting import variant_of as variant_of
    from cncgen.pipeline.reporting import viewer as viewer
    from cncgen.pipeline.using import coupling_of as coupling_of
    from cncgen.pipeline.using import fmu as fmu
    from cncgen.pipeline.using import judge as judge
    from cncgen.pipeline.using import read_setpoints as read_setpoints
    from cncgen.pipeline.using import servos_of as servos_of
    from cncgen.pipeline.using import simulate as simulate
    from cncgen.pipeline.using import why as why
    from cncgen.pipeline.using import write as write

_NAMES = {
    "file_kinds": "SUFFIXES language_of",
    "planning": "Plan driven_axes machine_of options_on output_axes plan plan_with_summary sample",
    "reading": "canon check read read_text reader_of sound",
    "reporting": "Page ShownPart Variant report_page variant_of viewer",
    "using": "coupling_of fmu judge read_setpoints servos_of simulate why write",
}
_PUBLIC = {name: module for module, names in _NAMES.items() for name in names.split()}

__all__ = [*_PUBLIC]


def __getattr__(name: str) -> Any:
    """Import a public name on first use (PEP 562)."""
    if name not in _PUBLIC:
        raise AttributeError(f"module 'cncgen.pipeline' has no attribute {name!r}")
    value = globals()[name] = getattr(importlib.import_module(f"cncgen.pipeline.{_PUBLIC[name]}"), name)
    return value


def _shown(record: Any) -> str:
    from cncgen.pipeline.reporting import shown_record

    return shown_record(record)


for _kind in ("Plan", "Setpoints", "Response", "Verdict"):
    shown_by(_kind, _shown)

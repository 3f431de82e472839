"""The stages in order: read, plan, sample, write, simulate, judge. The command line and the library both call this.

    import cncgen
    program = cncgen.read("programs/butterfly.nc")
    plan = cncgen.plan(program, "xy-table", feedrate="ild")
    setpoints = cncgen.sample(plan)
    response = cncgen.simulate(setpoints, "xy-table")

Each stage draws from the one before it as it is drawn itself, so that a program of any length streams through.
"""

from cncgen.pipeline.planning import (
    Plan,
    driven_axes,
    machine_of,
    options_on,
    output_axes,
    plan,
    plan_with_summary,
    sample,
)
from cncgen.pipeline.reading import SUFFIXES, canon, check, language_of, read, read_text, reader_of, sound
from cncgen.pipeline.reporting import (
    Page,
    Variant,
    report_page,
    shown_plan,
    shown_record,
    variant_of,
    viewer,
)
from cncgen.pipeline.using import (
    coupling_of,
    fmu,
    judge,
    read_setpoints,
    servos_of,
    simulate,
    why,
    write,
)
from cncgen.shown import shown_by

shown_by("Plan", shown_plan)
for _kind in ("Setpoints", "Response", "Verdict"):
    shown_by(_kind, shown_record)

__all__ = [
    "SUFFIXES",
    "Page",
    "Plan",
    "Variant",
    "canon",
    "check",
    "coupling_of",
    "driven_axes",
    "fmu",
    "judge",
    "language_of",
    "machine_of",
    "options_on",
    "output_axes",
    "plan",
    "plan_with_summary",
    "read",
    "read_setpoints",
    "read_text",
    "reader_of",
    "report_page",
    "sample",
    "servos_of",
    "simulate",
    "sound",
    "variant_of",
    "viewer",
    "why",
    "write",
]

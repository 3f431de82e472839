"""The figures of a job, by name: numbers that `plan`, `simulate`, `verify` and `cut` give for a program on a machine.

A name is the key of the command's summary, with dots for tables within it: ``cycle_time_s``, ``peak.x.jerk_of_limit``. Where
two commands have a figure of the same name, ``simulate.samples`` names the one of `simulate`.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cncgen.arguments import is_number

if TYPE_CHECKING:
    from cncgen.machine import Machine
    from cncgen.planner import PlanOptions
    from cncgen.toolpath.reading import ReadOptions
    from cncgen.toolpath.record import Program

_AXIS = "[a-cu-z]"
#: Names of the figures of each stage, as regular expressions; messages show them with an axis x.
FIGURES: Mapping[str, tuple[str, ...]] = {
    "plan": (
        "cycle_time_s",
        "motion_time_s",
        "dwell_time_s",
        "path_length_mm",
        "motions",
        "samples",
        "feed_mm_s.mean",
        "feed_mm_s.max",
        "sharp_corner_count",
        *(
            f"peak.{_AXIS}.{name}{share}"
            for name in ("velocity", "acceleration", "jerk")
            for share in ("", "_of_limit")
        ),
    ),
    "simulate": (
        "contour_error_rms_mm",
        "contour_error_max_mm",
        "contour_error_max_t_s",
        "speed_variation_mm_s",
        "saturated_samples",
        "samples",
        *(
            f"axes.{_AXIS}.{name}"
            for name in (
                "tracking_rms_mm",
                "tracking_max_mm",
                "tracking_rms_deg",
                "tracking_max_deg",
                "tracking_max_t_s",
                "force_max",
                "saturated_samples",
            )
        ),
    ),
    "verify": ("holds", "breaches", "setpoints_to_path_mm", "path_to_setpoints_mm", "samples"),
    "cut": (
        "holds",
        "findings",
        "removed_mm3",
        "volume_mm3",
        "raw_volume_mm3",
        "cutting_s",
        "deepest_mm",
        "largest_rate_mm3_s",
    ),
}
STAGES = tuple(FIGURES)

#: Options of a job beside those of planning: how the program is read, of the simulation, and of cutting.
READING = (
    "language",
    "dialect",
    "units",
    "block_delete",
    "inch_tables",
    "speed_unit",
    "spindle_sign",
    "max_steps",
    "tool_table",
    "parameters",
)
SIMULATING = ("controller", "settle_s")
CUTTING = ("stock", "tools", "target", "cell_mm")
#: Options that name files, which travel with the program.
FILES = ("tool_table", "parameters", "target")


def stage_of(name: str) -> tuple[str, str] | None:
    """Return the stage that gives a figure, and the figure's name in it; None where no stage does."""
    stage, _, rest = name.partition(".")
    if stage in STAGES and rest:
        return (stage, rest) if any(re.fullmatch(known, rest) for known in FIGURES[stage]) else None
    for stage, names in FIGURES.items():
        if any(re.fullmatch(known, name) for known in names):
            return stage, name
    return None


def near_figures(name: str) -> str:
    """Return a hint for a name that no stage gives: the nearest ones, else all."""
    shown = [known.replace(_AXIS, "x") for names in FIGURES.values() for known in names]
    near = difflib.get_close_matches(name, shown, 3)
    return f"did you mean {' or '.join(near)}?" if near else f"figures: {', '.join(dict.fromkeys(shown))}"


@cache
def planning_options() -> tuple[str, ...]:
    """Return the names of the options of planning that a sweep may set: fields of `PlanOptions` with plain values."""
    from cncgen.planner import PlanOptions

    return tuple(field.name for field in fields(PlanOptions) if field.name != "servos")


def computed(
    figures: Iterable[str],
    program: Path,
    machine: Machine,
    options: Mapping[str, Any],
    folder: Path,
) -> dict[str, float | None]:
    """Compute figures of a program on a machine.

    Args:
        figures: Names that `stage_of` knows.
        program: The program's file in `folder`.
        machine: Where it is planned.
        options: Names of `planning_options`, `READING`, `SIMULATING` and `CUTTING` with their values.
        folder: Holds what the program calls, and the files of `FILES`.

    Returns:
        Each figure by its name; None where it does not exist (contour error of a rotary axis alone, say).

    Raises:
        CncgenError: As the stages raise it.
    """
    wanted = {name: stage_of(name) for name in figures}
    stages = {found[0] for found in wanted.values() if found}
    job = _Evaluation(program, machine, options, folder)
    values = {stage: getattr(job, stage)() for stage in STAGES if stage in stages}
    return {
        name: _number_at(values[found[0]], found[1].split(".")) for name, found in wanted.items() if found
    }


def _number_at(values: Mapping[str, Any], path: list[str]) -> float | None:
    found: Any = values
    for name in path:
        found = found.get(name) if isinstance(found, Mapping) else None
    if isinstance(found, bool):
        return float(found)
    return float(found) if is_number(found) else None


class _Evaluation:
    """One program on one machine; each method is a stage and gives its summary. The plan is made once."""

    def __init__(self, program: Path, machine: Machine, options: Mapping[str, Any], folder: Path) -> None:
        self._program, self._machine, self._options, self._folder = program, machine, options, folder
        self._planned: tuple[Any, dict[str, Any]] | None = None

    def _reading(self) -> tuple[str | None, ReadOptions]:
        from cncgen.pipeline import options_on
        from cncgen.toolpath.reading import ReadOptions

        given = {name: self._options[name] for name in READING if name in self._options}
        language = given.pop("language", None)
        for name in FILES:
            if name in given:
                given[name] = self._folder / given[name]
        tolerance = self._options.get("path_tolerance_mm")
        options = ReadOptions(**given, include=(self._folder,), tolerance_mm=tolerance)
        return language, options_on(self._machine, options)

    def _read(self) -> Program:
        from cncgen.pipeline import read

        language, options = self._reading()
        return read(self._program, language=language, options=options)

    def _plan_options(self) -> PlanOptions:
        from cncgen.planner import PlanOptions

        known = planning_options()
        return PlanOptions(**{name: value for name, value in self._options.items() if name in known})

    def _setpoints(self) -> tuple[Any, dict[str, Any]]:
        """Return the setpoints of the plan, all in memory, and its summary."""
        if self._planned is None:
            from cncgen.pipeline import plan_with_summary

            how = self._plan_options()
            stream, summary = plan_with_summary(self._read(), self._machine, how, ["tool_length"])
            self._planned = stream.collect(), summary.as_json()
        return self._planned

    def plan(self) -> dict[str, Any]:
        """Return the summary of the plan."""
        return self._setpoints()[1]

    def simulate(self) -> dict[str, Any]:
        """Return the summary of the servo axes' response."""
        from cncgen.pipeline import simulate
        from cncgen.servo.summary import summarize

        given = {name: self._options[name] for name in SIMULATING if name in self._options}
        return summarize(simulate(self._setpoints()[0], self._machine, **given))

    def verify(self) -> dict[str, Any]:
        """Return the verdict on the setpoints."""
        from cncgen.pipeline import judge

        verdict = judge(self._setpoints()[0], self._read(), self._machine)
        return verdict.as_json() | {"breaches": verdict.breaches.total}

    def cut(self) -> dict[str, Any]:
        """Return the summary of material removal."""
        from cncgen.pipeline.removing import cut

        given = {name: self._options[name] for name in CUTTING if name in self._options}
        if "target" in given:
            given["target"] = str(self._folder / given["target"])
        language, options = self._reading()
        removal = cut(str(self._program), language=language, options=replace(options), **given)
        values = removal.as_json()
        rates = values["engagement"]["rate_mm3_s"]
        return values | {
            "holds": removal.holds,
            "findings": len(removal.findings),
            "cutting_s": sum(operation["cutting_s"] for operation in values["operations"]),
            "deepest_mm": max((operation["deepest_mm"] for operation in values["operations"]), default=0.0),
            "largest_rate_mm3_s": max(rates, default=0.0),
        }

"""SWEEP.toml: the record that it describes, read with every fault named in one run by its key and line."""

from __future__ import annotations

import difflib
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from cncgen.diagnostics import Diagnostic, Severity
from cncgen.files import read_utf8
from cncgen.machine.toml_file import TomlFile, is_toml_number, parse_toml, toml_value_shown
from cncgen.sweep.designs import DESIGNS, MOST_DIMENSIONS, design_size, is_power_of_two
from cncgen.sweep.figures import CUTTING, FILES, READING, SIMULATING, near_figures, planning_options, stage_of
from cncgen.sweep.jobs import Bundle
from cncgen.sweep.machine_keys import Tables
from cncgen.sweep.quantities import Varied
from cncgen.sweep.sources import machines_of, programs_of
from cncgen.sweep.varying import check_on_machines, quantities_of

MAX_BYTES = 1_000_000
#: More jobs than this are a slip of the pen: at a thousandth of a second each they take a day.
MOST_JOBS = 100_000_000
_TOP = ("programs", "machine", "machines", "include", "options", "vary", "draw", "keep", "search")
#: Trials of a search that are chosen at once.
_TOGETHER = 4
#: The largest seed of optuna's samplers, which are numpy's RandomState.
_LAST_SEED = 2**32 - 1
_USUAL_FIGURES = ("cycle_time_s",)


@dataclass(frozen=True, slots=True)
class SearchGoal:
    """``[search]``: a figure is made small while others stay under bounds.

    Attributes:
        minimise: The figure.
        under: Upper bounds by figure.
        trials: How many jobs are tried.
        together: How many are chosen at once, before any of them is done.
        seed: Of the sampler.
    """

    minimise: str
    under: Mapping[str, float]
    trials: int
    together: int
    seed: int


@dataclass(frozen=True, slots=True)
class SweepDefinition:
    """A sweep as its file describes it.

    Attributes:
        name: Of the file.
        text: The file.
        programs: Bundles by the names of the programs.
        machines: Tables by the names of the machines.
        options: Options with one value for all jobs.
        quantities: The varied keys and options.
        design: One of `DESIGNS`.
        points: Points of a drawn design.
        seed: Seed of a drawn design.
        figures: Names of the figures that are kept.
        search: The goal of a search, which takes the place of a design; or None.
        remarks: Notes on what is doubtful.
    """

    name: str
    text: str
    programs: Mapping[str, Bundle]
    machines: Mapping[str, Tables]
    options: Mapping[str, Any]
    quantities: tuple[Varied, ...]
    design: str
    points: int
    seed: int
    figures: tuple[str, ...]
    search: SearchGoal | None = None
    remarks: tuple[Diagnostic, ...] = ()

    @property
    def shares(self) -> list[tuple[float, ...]]:
        """The numbers of each dimension on a grid; see `designs.unit_points`."""
        return [quantity.shares() for quantity in self.quantities for _ in quantity.columns]

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of all varied values."""
        return tuple(column for quantity in self.quantities for column in quantity.columns)

    @property
    def size(self) -> int:
        """Jobs, before equal ones are counted once."""
        each = self.search.trials if self.search else design_size(self.design, self.points, self.shares)
        return each * len(self.programs) * len(self.machines)


def load_sweep(path: str | os.PathLike[str]) -> SweepDefinition:
    """Read a sweep; programs and machines are found beside the file.

    Raises:
        UsageError: With a diagnostic for each fault: ``sweep-syntax``, ``sweep-key`` (unknown), ``sweep-missing``,
            ``sweep-type``, ``sweep-value``, and those of machine files.
    """
    name = os.fspath(path)
    return sweep_from_toml(read_utf8(path, at_most=MAX_BYTES), name, Path(name).parent)


def sweep_from_toml(content: bytes, name: str, folder: Path) -> SweepDefinition:
    """Return the sweep that a TOML text describes; relative names of files count from `folder`. Raises as `load_sweep`."""
    table, text = parse_toml(content, name, "sweep")
    reader = SweepReader(TomlFile(name, text), folder)
    reader.unknown_keys(table, "", _TOP)
    machines = machines_of(reader, table)
    options = _options(reader, reader.table(table, "options"))
    programs = programs_of(reader, table, options)
    quantities = quantities_of(reader, reader.table(table, "vary"))
    design, points, seed = _draw(reader, reader.table(table, "draw"), quantities, "search" not in table)
    search = _search(reader, reader.table(table, "search"), quantities) if "search" in table else None
    figures = _figures(reader, reader.table(table, "keep"), search)
    if not reader.file.faults.has_errors:
        check_on_machines(reader, machines, quantities, options, _stages(figures))
    definition = SweepDefinition(
        name, text, programs, machines, options, quantities, design, points, seed, figures, search
    )
    if not reader.file.faults.has_errors and definition.size > MOST_JOBS:
        path = "search.trials" if search else "draw"
        reader.fault("sweep-value", path, f"{path}: these are {definition.size} jobs, more than {MOST_JOBS}")
    reader.file.raise_faults()
    return _with_remarks(definition, _unused(reader, options, _stages(figures)))


class SweepReader:
    """The text of a sweep, the folder from which its files are named, and the faults found in it."""

    def __init__(self, file: TomlFile, folder: Path) -> None:
        self.file, self.folder = file, folder

    def fault(self, code: str, path: str, message: str, hint: str = "") -> None:
        """Note a fault at a key path."""
        self.file.fault(code, path, message, hint)

    def unknown_keys(self, table: Mapping[str, Any], prefix: str, known: Sequence[str]) -> None:
        """Note each key of a table that is not one of those known."""
        for key in table:
            if key not in known:
                path = f"{prefix}.{key}" if prefix else key
                near = difflib.get_close_matches(key, known, 1)
                hint = f"did you mean {near[0]}?" if near else f"known keys: {', '.join(known)}"
                self.fault("sweep-key", path, f"{path}: unknown key", hint)

    def table(self, table: Mapping[str, Any], key: str) -> dict[str, Any]:
        """Return a table within a table, empty where it is missing or something else."""
        found = table.get(key, {})
        if isinstance(found, dict):
            return found
        self.fault("sweep-type", key, f"{key}: must be a table, is {toml_value_shown(found)}")
        return {}

    def texts(self, table: Mapping[str, Any], key: str, prefix: str = "") -> list[str]:
        """Return a list of texts; one text counts as a list of one."""
        path = f"{prefix}.{key}" if prefix else key
        found = table.get(key, [])
        found = [found] if isinstance(found, str) else found
        if isinstance(found, list) and all(isinstance(item, str) and item for item in found):
            return found
        text = f"{path}: must be a list of texts that are not empty, is {toml_value_shown(table[key])}"
        self.fault("sweep-type", path, text)
        return []

    def integer(
        self,
        table: Mapping[str, Any],
        prefix: str,
        key: str,
        low: int,
        usual: int | None = None,
        most: int | None = None,
    ) -> int:
        """Return an integer from `low` to `most`; its fault is noted, and `low` returned."""
        path = f"{prefix}.{key}"
        if key not in table and usual is not None:
            return usual
        value = table.get(key)
        if value is None:
            self.fault("sweep-missing", path, f"{path}: missing")
        elif not isinstance(value, int) or isinstance(value, bool):
            self.fault("sweep-type", path, f"{path}: must be an integer, is {toml_value_shown(value)}")
        elif value < low:
            self.fault("sweep-value", path, f"{path}: must not be below {low}, is {value}")
        elif most is not None and value > most:
            self.fault("sweep-value", path, f"{path}: must not be above {most}, is {value}")
        else:
            return value
        return low


def _options(reader: SweepReader, table: dict[str, Any]) -> dict[str, Any]:
    """Return ``[options]``; its values are checked with the machines, its files when programs are gathered."""
    known = tuple(dict.fromkeys((*planning_options(), *READING, *SIMULATING, *CUTTING)))
    reader.unknown_keys(table, "options", known)
    for key in FILES:
        if key in table and not isinstance(table[key], str):
            reader.fault("sweep-type", f"options.{key}", f"options.{key}: must be the name of a file")
    return {key: value for key, value in table.items() if key in known}


def _draw(
    reader: SweepReader, table: dict[str, Any], quantities: Sequence[Varied], needs_counts: bool
) -> tuple[str, int, int]:
    """Return design, points and seed; a search, which has no grid, needs no counts."""
    reader.unknown_keys(table, "draw", ("design", "points", "seed"))
    design = table.get("design", "grid")
    if design not in DESIGNS:
        text = f"draw.design: must be one of {', '.join(DESIGNS)}, is {toml_value_shown(design)}"
        reader.fault("sweep-value", "draw.design", text)
        return "grid", 1, 0
    if design == "grid":
        for key in ("points", "seed"):
            if key in table:
                hint = "a grid has every combination of the levels; latin_hypercube and sobol draw points"
                reader.fault(
                    "sweep-value",
                    f"draw.{key}",
                    f"draw.{key}: a grid takes none, since it draws nothing",
                    hint,
                )
        for quantity in quantities if needs_counts else ():
            if not quantity.shares():
                path = f"vary.{quantity.key}"
                reader.fault(
                    "sweep-missing", path, f"{path}: a grid needs a count of its levels", "count = 5"
                )
        return design, 1, 0
    dimensions = sum(len(quantity.columns) for quantity in quantities) * (1 + (design == "saltelli"))
    if dimensions > MOST_DIMENSIONS:
        text = f"vary: {dimensions} dimensions are more than the {MOST_DIMENSIONS} of a Sobol sequence"
        reader.fault("sweep-value", "vary", text)
    return design, reader.integer(table, "draw", "points", 1), reader.integer(table, "draw", "seed", 0, 0)


def _figures(reader: SweepReader, table: dict[str, Any], search: SearchGoal | None) -> tuple[str, ...]:
    """Return the figures that are kept, those of a search among them."""
    reader.unknown_keys(table, "keep", ("figures",))
    named = dict.fromkeys(reader.texts(table, "figures", "keep"), "keep.figures")
    if "figures" not in table:
        named = dict.fromkeys(_USUAL_FIGURES, "keep.figures")
    elif table["figures"] == []:
        reader.fault("sweep-value", "keep.figures", "keep.figures: must name one figure at least, is empty")
    if search:
        goal = {search.minimise: "search.minimise"}
        named |= {
            name: path
            for name, path in (goal | dict.fromkeys(search.under, "search.under")).items()
            if name not in named
        }
    for name, path in named.items():
        if stage_of(name) is None:
            reader.fault("sweep-value", path, f"{path}: {name!r} is not a figure", near_figures(name))
    return tuple(named)


def _stages(figures: Sequence[str]) -> set[str]:
    return {found[0] for name in figures if (found := stage_of(name))}


def _search(reader: SweepReader, table: dict[str, Any], quantities: Sequence[Varied]) -> SearchGoal | None:
    """Return the goal of ``[search]``."""
    reader.unknown_keys(table, "search", ("minimise", "under", "trials", "together", "seed"))
    minimise, under = table.get("minimise"), table.get("under", {})
    if not isinstance(minimise, str):
        code, what = ("sweep-missing", "missing") if minimise is None else ("sweep-type", "must be a text")
        reader.fault(code, "search.minimise", f"search.minimise: {what}")
    numbers = isinstance(under, dict) and all(map(is_toml_number, under.values()))
    if not numbers or not all(map(math.isfinite, under.values())):
        text = f"search.under: must be a table of finite upper bounds, is {toml_value_shown(under)}"
        reader.fault("sweep-type", "search.under", text, "under = { contour_error_max_mm = 0.01 }")
        under = {}
    for quantity in quantities:
        if len(quantity.columns) > 1 or getattr(quantity, "law", "") == "normal":
            path = f"vary.{quantity.key}"
            hint = "a search chooses within lists, linear, uniform and log ranges"
            reader.fault(
                "sweep-value", path, f"{path}: a search cannot choose a value that is uncertain", hint
            )
    if not quantities:
        reader.fault(
            "sweep-missing", "search", "search: [vary] must have one key at least to choose, has none"
        )
    bounds = MappingProxyType({name: float(bound) for name, bound in under.items()})
    trials = reader.integer(table, "search", "trials", 1)
    together = reader.integer(table, "search", "together", 1, _TOGETHER)
    seed = reader.integer(table, "search", "seed", 0, 0, _LAST_SEED)
    if not isinstance(minimise, str):
        return None
    return SearchGoal(minimise, bounds, trials, together, seed)


def _unused(reader: SweepReader, options: Mapping[str, Any], stages: set[str]) -> list[Diagnostic]:
    """Return a warning for each option of a stage that no figure asks for."""
    asked = dict.fromkeys(SIMULATING, "simulate") | dict.fromkeys(CUTTING, "cut")
    return [
        replace(reader.file.placed("option-unused", path, text), severity=Severity.WARNING)
        for key in options
        if (stage := asked.get(key)) and stage not in stages
        for path in [f"options.{key}"]
        for text in [f"{path} changes nothing here: keep.figures has no figure of {stage}"]
    ]


def _with_remarks(definition: SweepDefinition, remarks: list[Diagnostic]) -> SweepDefinition:
    """Return a definition with remarks, and with notes on what its author may not mean."""
    if definition.design in ("sobol", "saltelli") and not is_power_of_two(definition.points):
        text = f"{definition.name}: {definition.points} points of a Sobol sequence are not balanced"
        near = 1 << (definition.points - 1).bit_length()
        hint = f"a power of two is, {near} for one"
        remarks.append(Diagnostic("sweep-points", text, Severity.NOTE, hint=hint))
    if definition.search and definition.design != "grid":
        text = f"{definition.name}: [draw] has no effect beside [search]"
        remarks.append(Diagnostic("sweep-search", text, Severity.NOTE))
    return replace(definition, remarks=tuple(remarks))

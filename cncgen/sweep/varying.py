"""``[vary]``: reading its rows, checking them on the machines, and the job of each point."""

from __future__ import annotations

import difflib
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from cncgen.arguments import expect_number, wrong
from cncgen.diagnostics import CncgenError, RemarkWarning
from cncgen.machine.reading import TOP_NUMBERS, machine_from_tables
from cncgen.machine.settings_schema import TABLES
from cncgen.machine.toml_file import is_toml_number, toml_value_shown
from cncgen.ranges import CELL_MM
from cncgen.servo.identified_spread import read_summary, spread_of
from cncgen.sweep.designs import unit_points
from cncgen.sweep.figures import READING, SIMULATING, planning_options
from cncgen.sweep.jobs import Place, SweepJob, job_of
from cncgen.sweep.machine_keys import (
    Tables,
    matched,
    near_path,
    value_at,
    with_table,
    with_value,
)
from cncgen.sweep.quantities import LAWS, Levels, Range, UncertainServo, Value, Varied

if TYPE_CHECKING:
    from cncgen.sweep.definition import SweepDefinition, SweepReader

_RANGE_KEYS = (*LAWS, "count", "relative", "list", "identified")
#: Most levels of a list or a range.
_MOST_LEVELS = 1_000_000


def quantities_of(reader: SweepReader, table: dict[str, Any]) -> tuple[Varied, ...]:
    """Return what ``[vary]`` has; faults are noted."""
    found = []
    for key, value in _flat(table):
        path = f"vary.{key}"
        if not is_option(key) and key.partition(".")[0] not in ("axes", "machine", *TOP_NUMBERS, *TABLES):
            near = difflib.get_close_matches(key, _options(), 1)
            known = f"keys of machine files (cncgen machines keys), and options: {', '.join(_options())}"
            hint = f"did you mean {near[0]}?" if near else known
            reader.fault("sweep-key", path, f"{path}: neither a key of machine files nor an option", hint)
            continue
        quantity = _levels(reader, path, key, {"list": value}) if isinstance(value, list) else None
        if isinstance(value, dict):
            quantity = _quantity(reader, path, key, value)
        elif not isinstance(value, list):
            hint = "a single value stands in [options] or in the machine file"
            text = f"{path}: must be a list, or a table like {{ log = [1, 10], count = 5 }}"
            reader.fault("sweep-type", path, f"{text}; is {toml_value_shown(value)}", hint)
        if quantity is not None:
            found.append(quantity)
    return tuple(found)


def _flat(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield keys and values; ``axes.x.max_jerk_mm_s3`` without quotes is nested tables to TOML."""
    for key, value in table.items():
        if isinstance(value, dict) and value and not any(name in _RANGE_KEYS for name in value):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _options() -> tuple[str, ...]:
    return (*planning_options(), *SIMULATING)


def is_option(key: str) -> bool:
    """Tell whether a key of ``[vary]`` is an option; such a name comes before a machine's key of the same name."""
    return key in _options()


def machine_pattern(key: str) -> str:
    """Return the path in machine files that a key of ``[vary]`` means."""
    return key.removeprefix("machine.")


def _quantity(reader: SweepReader, path: str, key: str, table: dict[str, Any]) -> Varied | None:
    reader.unknown_keys(table, path, _RANGE_KEYS)
    kinds = [name for name in (*LAWS, "list", "identified") if name in table]
    if len(kinds) != 1:
        text = f"{path}: must have one of {', '.join((*LAWS, 'list', 'identified'))}, and one alone"
        reader.fault("sweep-value", path, f"{text}; has {', '.join(kinds) or 'no such key'}")
        return None
    if kinds[0] == "list":
        if "count" in table:
            text = f"{path}.count: a list takes none, since it has its own levels"
            reader.fault("sweep-value", f"{path}.count", text)
        return _levels(reader, path, key, table)
    if kinds[0] == "identified":
        return _identified(reader, path, key, table)
    return _range(reader, path, key, kinds[0], table)


def _relative(reader: SweepReader, path: str, key: str, table: Mapping[str, Any]) -> bool:
    relative = table.get("relative", False)
    if not isinstance(relative, bool):
        reader.fault("sweep-type", f"{path}.relative", f"{path}.relative: must be true or false")
        return False
    if relative and is_option(key):
        text = f"{path}.relative: an option has no value in the machine to be a factor of"
        reader.fault("sweep-value", f"{path}.relative", text)
    return relative


def _count(reader: SweepReader, path: str, table: Mapping[str, Any]) -> int | None:
    if "count" not in table:
        return None
    count = reader.integer(table, path, "count", 1)
    if count > _MOST_LEVELS:
        reader.fault(
            "sweep-value", f"{path}.count", f"{path}.count: must not be above {_MOST_LEVELS}, is {count}"
        )
    return min(count, _MOST_LEVELS)


def _levels(reader: SweepReader, path: str, key: str, table: dict[str, Any]) -> Varied | None:
    levels = table["list"]
    kinds = {
        float if is_toml_number(value) else type(value)
        for value in (levels if isinstance(levels, list) else ())
    }
    if len(kinds) != 1 or not kinds <= {float, str, bool} or len(levels) > _MOST_LEVELS:
        text = (
            f"{path}: must be a list of numbers, of texts or of truth values, is {toml_value_shown(levels)}"
        )
        reader.fault("sweep-type", path, text)
        return None
    if not all(math.isfinite(value) for value in levels if is_toml_number(value)):
        reader.fault("sweep-value", path, f"{path}: every number must be finite")
        return None
    if len(set(levels)) < len(levels):
        reader.fault("sweep-value", path, f"{path}: a value stands twice in {toml_value_shown(levels)}")
    return Levels(key, tuple(levels), _relative(reader, path, key, table))


def _range(reader: SweepReader, path: str, key: str, law: str, table: dict[str, Any]) -> Varied | None:
    given = table[law]
    pair = isinstance(given, list) and len(given) == 2 and all(map(is_toml_number, given))
    if not pair or not all(map(math.isfinite, given)):
        text = f"{path}.{law}: must be two finite numbers [{', '.join(LAWS[law])}]"
        reader.fault("sweep-type", path, f"{text}, is {toml_value_shown(given)}")
        return None
    first, second = map(float, given)
    if law == "normal" and second <= 0.0:
        reader.fault("sweep-value", path, f"{path}: the standard deviation {second:g} must be above 0")
    elif law != "normal" and first >= second:
        reader.fault("sweep-value", path, f"{path}: low {first:g} must be below high {second:g}")
    elif law == "log" and first <= 0.0:
        reader.fault("sweep-value", path, f"{path}: a logarithmic range begins above 0, not at {first:g}")
    return Range(key, law, first, second, _count(reader, path, table), _relative(reader, path, key, table))


def _identified(reader: SweepReader, path: str, key: str, table: dict[str, Any]) -> Varied | None:
    """Return the quantity that an identification's summary describes for the axis of ``axes.x.servo``."""
    parts = key.split(".")
    if len(parts) != 3 or parts[0] != "axes" or parts[2] != "servo":
        text = f"{path}: identified gives the servo data of an axis, so its key must be axes.NAME.servo"
        reader.fault("sweep-value", path, text, '"axes.x.servo" = { identified = "x.json" }')
        return None
    try:
        spread = spread_of(read_summary(str(reader.folder / str(table["identified"]))), parts[1].upper())
    except CncgenError as error:
        reader.fault("sweep-value", path, f"{path}: {error.diagnostics[0].message}")
        return None
    except ValueError as error:
        reader.fault("sweep-value", path, f"{path}: {table['identified']}: {error}")
        return None
    return UncertainServo(key, spread, _count(reader, path, table))


def check_on_machines(
    reader: SweepReader,
    machines: Mapping[str, Tables],
    quantities: Sequence[Varied],
    options: Mapping[str, Any],
    stages: set[str],
) -> None:
    """Note what the machines cannot have of the quantities' values, and wrong options."""
    refused = [
        key for key, value in options.items() if not _check_options(reader, f"options.{key}", {key: value})
    ]
    if not refused:
        _check_options(reader, "options", options)
    for quantity in quantities:
        path = f"vary.{quantity.key}"
        for value in () if len(quantity.columns) > 1 else quantity.extremes():
            if is_option(quantity.key):
                _check_options(reader, path, {quantity.key: value})
        if quantity.key in options:
            reader.fault("sweep-value", path, f"{path}: stands in [options] too")
        for name, tables in machines.items():
            if not is_option(quantity.key):
                _check_on(reader, quantity, name, tables)
    if "simulate" in stages:
        _check_servos(reader, machines)


def _check_on(reader: SweepReader, quantity: Varied, name: str, tables: Tables) -> None:
    path, pattern = f"vary.{quantity.key}", machine_pattern(quantity.key)
    if isinstance(quantity, UncertainServo):
        hint = f"give {name} the servo table that `cncgen identify` prints, with its gains: a sweep varies the rest of it"
        _check_tables(reader, path, name, with_values(tables, quantity, quantity.extremes()), hint)
        return
    paths = matched(pattern, tables)
    absent = not paths or (quantity.relative and value_at(tables, paths[0]) is None)
    if absent:
        text = f"{path}: the machine {name} has no such key"
        reader.fault("sweep-key", path, text, near_path(pattern, tables))
        return
    for value in quantity.extremes():
        if not _check_tables(reader, path, name, with_values(tables, quantity, (value,))):
            return


def _check_tables(reader: SweepReader, path: str, name: str, tables: Tables, hint: str = "") -> bool:
    """Note the first fault of a machine's tables, with a hint where it has none of its own; tell whether they have none."""
    try:
        with warnings.catch_warnings():
            # An end of a range need not be plausible: it is what was asked for.
            warnings.simplefilter("ignore", RemarkWarning)
            machine_from_tables(tables, "", name)
    except CncgenError as error:
        item = error.diagnostics[0]
        reader.fault("sweep-value", path, f"{path}: {item.message}", item.hint or hint)
        return False
    return True


def _check_options(reader: SweepReader, path: str, options: Mapping[str, Any]) -> bool:
    """Note options that the stages would refuse; tell whether there are none."""
    for check in (_check_words, _check_plan, _check_reading, _check_simulation, _check_cutting):
        try:
            check(options)
        except CncgenError as error:
            for item in error.diagnostics:
                reader.fault("sweep-value", path, f"{path}: {item.message}", item.hint)
            return False
    return True


def _check_words(options: Mapping[str, Any]) -> None:
    """Raise `UsageError` for a word that is not one of those of its option."""
    from cncgen.planner.strategies import FEEDRATES
    from cncgen.servo.named_schemes import NAMES

    words = {"feedrate": FEEDRATES, "controller": NAMES, "language": ("gcode", "stepnc")}
    for key, allowed in words.items():
        if key in options and options[key] not in allowed:
            raise wrong(f"{key} = {options[key]!r} is not one of {', '.join(allowed)}")


def _check_plan(options: Mapping[str, Any]) -> None:
    from cncgen.planner import PlanOptions

    PlanOptions(**{key: value for key, value in options.items() if key in planning_options()}).check()


def _check_reading(options: Mapping[str, Any]) -> None:
    from cncgen.toolpath.reading import ReadOptions

    ReadOptions(**{k: v for k, v in options.items() if k in READING and k != "language"}).check()


def _check_simulation(options: Mapping[str, Any]) -> None:
    from cncgen.pipeline.using import LONGEST_SETTLE_S

    if "settle_s" in options:
        expect_number(options["settle_s"], "settle_s", high=LONGEST_SETTLE_S)


def _check_cutting(options: Mapping[str, Any]) -> None:
    """Raise `UsageError` for what cutting refuses; a stock that is a file is looked at in the job."""
    if "cell_mm" in options:
        expect_number(options["cell_mm"], "cell_mm", *CELL_MM)
    stock, tools = options.get("stock", ""), options.get("tools", [])
    if not isinstance(stock, str):
        raise wrong(f"stock = {stock!r} must be a text, as of --stock of cncgen cut")
    if stock.partition(":")[0] in ("box", "cylinder"):
        from cncgen.removal.stock import stock_of_option

        stock_of_option(stock)
    if not isinstance(tools, list) or not all(isinstance(tool, str) for tool in tools):
        raise wrong(f"tools = {tools!r} must be a list of texts, as of --tool of cncgen cut")
    if tools:
        from cncgen.removal.cutters import cutter_of_option

        for tool in tools:
            cutter_of_option(tool)


def _check_servos(reader: SweepReader, machines: Mapping[str, Tables]) -> None:
    for name, tables in machines.items():
        if not any("servo" in axis for axis in tables["axes"].values()):
            text = f"keep.figures: the machine {name} has no servo data, which figures of simulate need"
            reader.fault("sweep-value", "keep.figures", text)


def with_values(tables: Tables, quantity: Varied, values: Sequence[Value]) -> Tables:
    """Return a machine's tables with the values of a quantity that is not an option."""
    if isinstance(quantity, UncertainServo):
        table = quantity.spread.table(
            [float(value) for value in values], value_at(tables, quantity.key) or {}
        )
        return with_table(tables, quantity.key, table)
    return with_value(tables, machine_pattern(quantity.key), values[0], quantity.relative)


def job_at(
    sweep: SweepDefinition, program: str, machine: str, point: int, shares: Sequence[float]
) -> tuple[Place, SweepJob]:
    """Return the job of a program on a machine at a point of the unit cube, and its place."""
    tables, options = sweep.machines[machine], dict(sweep.options)
    values: list[Value] = []
    at = 0
    for quantity in sweep.quantities:
        width = len(quantity.columns)
        found = quantity.values([float(share) for share in shares[at : at + width]])
        at += width
        values += found
        if is_option(quantity.key):
            options[quantity.key] = found[0]
        else:
            tables = with_values(tables, quantity, found)
    job = job_of(sweep.programs[program].hash, machine, tables, options, sweep.figures)
    return Place(program, machine, point, tuple(values)), job


@dataclass(frozen=True, slots=True)
class Laid:
    """The jobs of a sweep's design.

    Attributes:
        jobs: Place and job by key; equal jobs of several points stand once, at the first of them.
        groups: By program and machine, the key of each point's job, shape (points,).
    """

    jobs: dict[str, tuple[Place, SweepJob]]
    groups: dict[tuple[str, str], list[str]]


def jobs_of(sweep: SweepDefinition) -> Laid:
    """Return the jobs of a sweep's design."""
    points = unit_points(sweep.design, sweep.points, sweep.seed, sweep.shares)
    laid = Laid({}, {})
    for program in sweep.programs:
        for machine in sweep.machines:
            keys = laid.groups.setdefault((program, machine), [])
            for point, shares in enumerate(points):
                place, job = job_at(sweep, program, machine, point, shares)
                laid.jobs.setdefault(job.key, (place, job))
                keys.append(job.key)
    return laid

"""Attributes and arguments have the type of what they hold: `Any` and `object` only where a reason stands here."""

from __future__ import annotations

import ast
from fnmatch import fnmatchcase
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "cncgen"


def attributes() -> list[tuple[str, str, str]]:
    """Return module, attribute and annotation of every attribute that is typed ``Any`` or ``object``."""
    found = []
    for path in sorted(PACKAGE.rglob("*.py")):
        if path.parent.name == "kernels":
            continue
        for holder in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(holder, ast.ClassDef):
                continue
            for node in ast.walk(holder):
                if not isinstance(node, ast.AnnAssign):
                    continue
                target = ast.unparse(node.target)
                names = {one.id for one in ast.walk(node.annotation) if isinstance(one, ast.Name)}
                if (node in holder.body or target.startswith("self.")) and names & {"Any", "object"}:
                    where = (
                        f"{path.relative_to(PACKAGE).as_posix()}:{holder.name}.{target.removeprefix('self.')}"
                    )
                    found.append((where, target, ast.unparse(node.annotation)))
    return found


#: Attributes whose values have no one type: what files and programs say, and what optional packages give.
OPEN = {
    "gcode/block_plans.py:BlockPlans._plans": "keys of a cache, compared and nothing else",
    "gcode/codes/tool_centre.py:CentreMove.block": "what the caller gave with a move, handed back",
    "gcode/codes/tool_centre.py:ToolCentre._queue": "moves, and blocks that wait between them as the caller gave them",
    "gcode/sinumerik/programs.py:Program.formals": "values of SINUMERIK: numbers, words and arrays",
    "gcode/text/plain_language.py:Statement.data": "values of a rule of the grammar: numbers, names and words",
    "gcode/sinumerik/reading.py:Statement.data": "values of SINUMERIK: numbers, words and arrays",
    "gcode/text/macro_loops.py:Loops._left": "keys of a cache, compared and nothing else",
    "machine/servo_parameters.py:Parameter.default": "a number, a word or a list, as TOML has it",
    "machine/settings_schema.py:Key.holds": "tells whether any value of TOML is right",
    "setpoints/writers/arrow.py:BatchMaker.arrow": "pyarrow, which may be missing",
    "setpoints/writers/arrow.py:BatchMaker.schema": "of pyarrow, which may be missing",
    "sweep/cluster.py:ClusterWorkers._running": "futures of dask, which may be missing",
    "setpoints/writers/mf4.py:Writer._file": "of asammdf, which may be missing",
    "stepnc/iso14649/technology.py:Resources._kept": "entities of any kind by kind and number",
    "stepnc/model.py:ProgramStructure.context": "of the reader, which the executor hands back to it",
    "stepnc/model.py:Branching.context": "of the reader, which the executor hands back to it",
    "stepnc/part21/exchange.py:Exchange.references": "as the file has them",
}


def test_attributes_have_the_type_of_what_they_hold() -> None:
    """Values of files, by name (``Mapping[str, Any]``), are open; all else is typed or has its reason in `OPEN`."""
    bare = {
        where
        for where, _, annotation in attributes()
        if not any(f"{kind}[str, Any]" in annotation for kind in ("Mapping", "dict"))
    }
    assert sorted(bare - set(OPEN)) == []
    assert sorted(set(OPEN) - bare) == [], "these are typed now"


def arguments() -> set[str]:
    """Return ``module:function.argument`` of each argument that is typed ``Any`` or ``object``, mappings by name left out."""
    found = set()
    for path in sorted(PACKAGE.rglob("*.py")):
        if path.parent.name == "kernels":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                continue
            given = node.args
            for one in (*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg):
                if one is None or one.annotation is None:
                    continue
                names = {part.id for part in ast.walk(one.annotation) if isinstance(part, ast.Name)}
                annotation = ast.unparse(one.annotation)
                by_name = any(f"{kind}[str, Any]" in annotation for kind in ("Mapping", "dict"))
                if names & {"Any", "object"} and not by_name:
                    found.add(f"{path.relative_to(PACKAGE).as_posix()}:{node.name}.{one.arg}")
    return found


#: Arguments whose values have no one type, by patterns of ``module:function.argument``.
OPEN_ARGUMENTS = {
    "arguments.py:*": "whatever a caller of the library gave: it is checked here",
    "toolpath/reading.py:_*": "whatever a caller of the library gave: it is checked here",
    "setpoints/checking.py:*": "whatever a caller of the library gave: it is checked here",
    "setpoints/record.py:_*": "whatever a caller of the library gave: it is checked here",
    "cli/options.py:*": "what click passes on: values of all options",
    "cli/types.py:convert.value": "click: a text, or a default of the type",
    "cli/app.py:_show_warning.*": "what Python's warnings pass on, unused",
    "cli/__init__.py:_take_signals.before": "handlers as the signal module has them: a function, a number or None",
    "diagnostics.py:*": "values of any kind, made JSON's",
    "report/page/assembling.py:_json.value": "values of any kind, made JSON's",
    "files.py:is_terminal.stream": "whatever stands in the place of a stream",
    "files.py:readinto.buffer": "any buffer: Python 3.11 has no name for it",
    "files.py:_guard.action": "what the action returns is dropped",
    "shown.py:*": "records of any room, told apart by their class",
    "pipeline/__init__.py:_shown.record": "records of any room",
    "pipeline/reporting.py:shown_record.record": "records of any room, told apart by their class",
    "gcode/codes/tool_centre.py:*": "what the caller gave with a move, handed back",
    "gcode/sinks/counting.py:*": "the arguments of every call, counted and dropped",
    "gcode/flow/recurrence.py:*": "states of any kind, compared as bytes",
    "gcode/sinumerik/reading.py:*": "values of SINUMERIK: numbers, words and arrays",
    "gcode/sinumerik/running.py:*": "values of SINUMERIK: numbers, words and arrays",
    "gcode/sinumerik/motions.py:*": "values of SINUMERIK: numbers, words and arrays; modes handed back",
    "gcode/text/macro_loops.py:_number.label": "keys of a cache, compared and shown",
    "kernels/plain/__init__.py:*": "whatever a kernel gives to the names of Cython: this module stands in for them",
    "machine/*": "values of a machine file, as TOML has them: they are checked here",
    "report/drawing.py:*.style": "keywords of matplotlib",
    "report/drawing.py:*.more": "keywords of matplotlib",
    "setpoints/readers/*": "objects of pyarrow and mcap, which may be missing",
    "setpoints/writers/*": "objects of scipy.io, imported where they are used",
    "setpoints/readers/tables.py:stated_period.value": "a value of a file: it is checked here",
    "stepnc/*.context": "of the reader, which the executor hands back to it",
    "stepnc/*.value": "values of STEP-NC entities: they are checked or shown here",
    "stepnc/*.values": "values of STEP-NC entities",
    "stepnc/iso14649/toolpaths.py:_made.arguments": "arguments of the function that is called",
    "stepnc/model.py:__getitem__.k": "an index, as `Sequence` has it",
    "stepnc/part21/exchange.py:report.options": "options of the reporter, handed on",
    "stepnc/part21/parsing.py:*.children": "what lark hands on: nodes and tokens",
    "sweep/cluster.py:*": "objects of dask, which may be missing",
    "sweep/machine_keys.py:_with.value": "a value of a machine file, as TOML has it: it is checked when the machine is read",
    "sweep/optimisation.py:_told.trial": "a trial of optuna, which may be missing",
    "sweep/showing.py:_failures.columns": "columns of pyarrow, which may be missing",
    "kernels/plain/*": "what Cython's names take, any value: they do nothing without a compiler",
    "toolpath/building.py:*": "columns of any dtype",
    "verify/verdict.py:breach.values": "numbers and names of a diagnostic",
}


def test_arguments_have_the_type_of_what_they_take() -> None:
    open_ones = arguments()
    fitting = {pattern: {one for one in open_ones if fnmatchcase(one, pattern)} for pattern in OPEN_ARGUMENTS}
    assert sorted(open_ones - set().union(*fitting.values())) == []
    assert [pattern for pattern, found in fitting.items() if not found] == [], "these are typed now"


@pytest.mark.parametrize(
    ("module", "words", "record"),
    [("planner/options.py", "PlanWords", "PlanOptions"), ("toolpath/reading.py", "ReadWords", "ReadOptions")],
)
def test_keywords_are_the_fields_of_the_options(module: str, words: str, record: str) -> None:
    """Type checkers see them, since `plan(**asked)` and `read(**asked)` name no keyword themselves."""
    tree = ast.parse((PACKAGE / module).read_text(encoding="utf-8"))
    fields = {
        holder.name: {
            ast.unparse(each.target): ast.unparse(each.annotation)
            for each in holder.body
            if isinstance(each, ast.AnnAssign)
        }
        for holder in ast.walk(tree)
        if isinstance(holder, ast.ClassDef)
    }
    assert len(fields[record]) > 10
    assert fields[words] == fields[record]

"""One name, one meaning: no two classes of cncgen share a name, nor two modules, unless a reason stands here."""

from __future__ import annotations

import ast
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "cncgen"

#: Classes that are the same idea for another format, language or schema.
SAME_CLASSES = {
    "Features": "readers of AP238 and ISO 14649",
    "Frame": "a coordinate frame; a call of a subprogram, in each language",
    "Hole": "a hole of a drilling cycle, in each language",
    "OpenCurve": "a curve whose words are not all read, in each language",
    "Operations": "readers of AP238 and ISO 14649",
    "Profiles": "readers of AP238 and ISO 14649",
    "Program": "a program of SINUMERIK as text; a program as the library gives it",
    "Reporter": "faults of G-code and of STEP-NC to diagnostics",
    "Resources": "readers of AP238 and ISO 14649",
    "Setting": "readers of AP238 and ISO 14649",
    "Span": "of a source; of a spline, within its kernel",
    "Toolpaths": "readers of AP238 and ISO 14649",
    "Writer": "one a format of setpoints",
}
#: Folders whose modules are named by what they handle, and so share names with each other or with what they handle.
PARALLEL = (
    {"setpoints/readers", "setpoints/writers"},
    {
        "stepnc/ap238",
        "stepnc/iso14649",
        "stepnc/part21",
        "stepnc/geometry",
        "stepnc/execution",
        "stepnc/features",
    },
)
#: Folders whose modules bear the name of a code, a command or a kernel: the modules that compute for it may bear it too.
NAMED_AFTER = {"cli", "gcode/codes", "gcode/sinumerik", "kernels", "planner/baselines"}
#: Names of parts that every room may have.
PARTS = {
    "checking": "faults of what a caller made",
    "columns": "columns of the room's record",
    "cutting": "profiles of motion cut in time; a stock cut along a program; a STEP-NC program as that takes it",
    "options": "options of the room",
    "pieces": "pieces of a curve, of a path and of a toolpath",
    "reading": "from a file or a text to the room's record",
    "record": "the room's record",
    "reporting": "what a run reports",
    "search": "a search",
    "strategy": "the entry of a strategy of planning",
    "stock": "the stock that is cut, and as ISO 14649 describes it",
    "stream": "the room's records one after the other",
    "summary": "the room's results in short",
    "tables": "tables of the room",
    "technology": "feeds and speeds of STEP-NC",
    "units": "of the package, and of an AP238 file",
    "verdict": "the record, and its text",
    "writer": "writers of STEP-NC files",
    "writing": "from the room's record to a file",
}


def classes() -> dict[str, list[str]]:
    found: dict[str, list[str]] = defaultdict(list)
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef) and node.name[0] != "_":
                found[node.name].append(path.relative_to(PACKAGE).as_posix())
    return found


def modules() -> dict[str, list[str]]:
    found: dict[str, list[str]] = defaultdict(list)
    for path in sorted(PACKAGE.rglob("*.py")):
        if path.name != "__init__.py":
            found[path.stem].append(path.relative_to(PACKAGE).parent.as_posix())
    return found


def test_classes_of_one_name_are_one_idea() -> None:
    shared = {name: where for name, where in classes().items() if len(where) > 1}
    assert {name: where for name, where in shared.items() if name not in SAME_CLASSES} == {}
    assert sorted(set(SAME_CLASSES) - set(shared)) == [], "no two classes have these names any more"


def allowed(name: str, folders: list[str]) -> bool:
    if name in PARTS:
        return True
    rest = [folder for folder in folders if folder not in NAMED_AFTER]
    languages = all(folder.startswith("gcode/") for folder in rest)  # each has its own reading and running
    return len(rest) < 2 or languages or any(set(rest) <= group for group in PARALLEL)


def test_modules_of_one_name_are_one_idea() -> None:
    shared = {name: where for name, where in modules().items() if len(where) > 1}
    assert {name: where for name, where in shared.items() if not allowed(name, where)} == {}
    assert sorted(set(PARTS) - set(shared)) == [], "no two modules have these names any more"


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
    "gcode/sinumerik/reading.py:Statement.data": "values of SINUMERIK: numbers, words and arrays",
    "gcode/sinumerik/running.py:Frame.results": "values of SINUMERIK: numbers, words and arrays",
    "gcode/sinumerik/running.py:Frame.saved": "modes as the motions keep them, handed back",
    "gcode/text/macro_loops.py:Loops._left": "keys of a cache, compared and nothing else",
    "machine/servo_parameters.py:Parameter.default": "a number, a word or a list, as TOML has it",
    "machine/settings_schema.py:Key.holds": "tells whether any value of TOML is right",
    "setpoints/writers/arrow.py:BatchMaker.arrow": "pyarrow, which may be missing",
    "setpoints/writers/arrow.py:BatchMaker.schema": "of pyarrow, which may be missing",
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

"""Attributes have the type of what they hold: `Any` and `object` only where a reason stands here."""

from __future__ import annotations

import ast
from pathlib import Path

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

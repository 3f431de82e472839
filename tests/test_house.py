"""The house: layers, cycles, start-up, help, package data, and kernels that match their source."""

from __future__ import annotations

import ast
import importlib
import importlib.machinery
import os
import re
import shutil
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import click
import pytest

import cncgen
from cncgen.cli.commands import COMMANDS, cli

ROOT = Path(__file__).resolve().parent.parent
HEAVY = {"scipy", "matplotlib", "pandas", "shapely", "pyarrow", "IPython", "sympy"}


def modules(*arguments: str) -> set[str]:
    """Return the modules that a run of the command imports, by ``-X importtime``."""
    run = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "cncgen", *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert run.returncode == 0, run.stderr[-2000:]
    found = re.findall(r"import time:\s+\d+ \|\s+\d+ \|\s*(\S+)", run.stderr)
    assert "cncgen.cli.app" in found
    return set(found)


def imported(*arguments: str) -> set[str]:
    """Return their top-level packages."""
    return {name.partition(".")[0] for name in modules(*arguments)}


def test_help_imports_nothing_heavy() -> None:
    assert not imported("--help") & (HEAVY | {"numpy", "lark", "rich"})


@pytest.mark.parametrize("name", [name for name in COMMANDS if name != "machines"])
def test_help_of_each_command_imports_nothing_heavy(name: str) -> None:
    assert not imported(name, "--help") & (HEAVY | {"numpy", "lark", "rich"})


def test_plan_of_a_small_program_imports_no_scipy(tmp_path: Path) -> None:
    program = str(ROOT / "programs" / "butterfly.nc")
    assert not imported("plan", program, "-m", "xy-table", "-o", str(tmp_path / "o.csv")) & HEAVY


def test_plan_of_plain_lines_imports_nothing_that_it_does_not_need(tmp_path: Path) -> None:
    """Neither what reads other blocks than plain words, nor codes that it has not, nor planning of other kinds."""
    program = tmp_path / "lines.nc"
    program.write_text("G21 G17 G90 G94 G64 P0.01\nF3000\nG1 X10 Y1\nG1 X20 Y5\nM2\n")
    found = modules("plan", str(program), "-o", str(tmp_path / "o.f64"))
    assert "cncgen.planner.least_time.block_planning" in found
    assert not found & {
        "cncgen.gcode.text.grammar",
        "cncgen.gcode.codes.corners",
        "cncgen.gcode.codes.turning_profiles",
        "cncgen.gcode.codes.canned_cycles",
        "cncgen.planner.least_time.contour_bound",
        "cncgen.planner.interpolators",
        "cncgen.report.line_times",
        "cncgen.stepnc",
    }


def commands(group: click.Group, path: tuple[str, ...] = ()) -> list[tuple[str, click.Command]]:
    """Return every command with its full name."""
    context = click.Context(group)
    found: list[tuple[str, click.Command]] = []
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None, f"{name} is listed and not there"
        found.append((" ".join([*path, name]), command))
        if isinstance(command, click.Group):
            found += commands(command, (*path, name))
    return found


def test_every_command_and_option_has_help() -> None:
    for name, command in commands(cli):
        assert command.help, f"{name} has no help"
        for parameter in command.params:
            if isinstance(parameter, click.Option):
                assert parameter.help, f"{name} {parameter.opts[0]} has no help"
                named = parameter.is_flag or parameter.metavar or isinstance(parameter.type, click.Choice)
                assert named, f"{name} {parameter.opts[0]} does not say what its value is"


def test_what_docstrings_list_is_read_as_a_list() -> None:
    """A line that is not indented below its name is a name of its own for what makes pages and help of docstrings (Google's style)."""
    wrong = []
    for path in sorted((ROOT / "cncgen").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.FunctionDef | ast.ClassDef):
                continue
            within = False
            for line in (ast.get_docstring(node) or "").splitlines():
                if line and not line.startswith(" "):
                    within = line in ("Args:", "Attributes:", "Raises:")
                elif within and re.match(r" {4}\S", line) and not re.match(r" {4}[\w*.,()\[\] ]+?: ", line):
                    wrong.append(f"{path.relative_to(ROOT)}, {node.name}: {line.strip()}")
    assert wrong == []


def test_public_names_are_there() -> None:
    for name in cncgen.__all__:
        assert getattr(cncgen, name) is not None
    assert set(cncgen.__all__) <= set(dir(cncgen))
    with pytest.raises(AttributeError, match="nonsense"):
        _ = cncgen.nonsense


def test_grammars_and_profiles_are_in_the_package() -> None:
    from importlib import resources

    names = {item.name for item in resources.files("cncgen.grammars").iterdir()}
    assert {path.name for path in (ROOT / "grammars").glob("*.lark")} <= names
    profiles = {item.name for item in resources.files("cncgen.machine").joinpath("profiles").iterdir()}
    assert {path.name for path in (ROOT / "cncgen/machine/profiles").glob("*.toml")} <= profiles


def test_compiled_kernels_are_not_older_than_their_source() -> None:
    folder = ROOT / "cncgen" / "kernels"
    suffixes = tuple(importlib.machinery.EXTENSION_SUFFIXES)
    stale = []
    for built in folder.iterdir():
        for source in folder.glob(f"{built.name.split('.')[0]}.p*"):
            if built.name.endswith(suffixes) and source.stat().st_mtime > built.stat().st_mtime + 1:
                stale.append(source.name)
    assert not stale, f"run `make kernels`: {', '.join(stale)} changed since the last build"


def test_kernels_import_nothing_of_ours_but_kernels() -> None:
    for path in (ROOT / "cncgen" / "kernels").glob("*.py"):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"^\s*(from|import) cncgen(?!\.kernels\.)", text, re.M), path.name
        assert "from __future__ import annotations" not in text, path.name


def test_what_becomes_setpoints_uses_the_same_functions_on_every_processor() -> None:
    """NumPy's own differ in the last digit between processors; `cncgen.geometry.elementary` says which."""
    kernel = (ROOT / "cncgen" / "kernels" / "elementary.py").read_text(encoding="utf-8")
    names = re.findall(r'"(\w+)"', kernel.partition("OF_ONE = (")[2].partition(")")[0])
    assert "cbrt" in names
    theirs = re.compile(rf"\bnp\.({'|'.join([*names, 'arctan2', 'power', 'float_power'])})\(")
    for room in ("gcode", "stepnc", "toolpath", "geometry", "planner", "setpoints"):
        for path in (ROOT / "cncgen" / room).rglob("*.py"):
            found = theirs.search(path.read_text(encoding="utf-8"))
            assert found is None, f"{path.name} has {found and found[0]}"


#: Folders that hold one idea for several formats: names may come again within each line.
TWINS = [
    ("setpoints/readers", "setpoints/writers"),  # one module a format, with one `Writer` each
    ("stepnc/ap238", "stepnc/iso14649", "stepnc/schema", "stepnc/execution"),  # two standards of one language
    (
        "gcode/sinumerik",
        "gcode/klartext",
        "gcode/codes",
        "gcode/sinks",
        "gcode/text",
        "gcode/flow",
    ),  # a dialect of its own
    ("cli", ""),  # a command is named as the stage that it runs
    ("kernels", ""),  # a kernel is named as the module that it serves
]
#: Classes that share a name, and why. A private one may be named as one of another room is.
SHARED_CLASSES = {
    "Reporter": "what finds faults in a language, G-code and STEP-NC",
    "Program": "Sinumerik: the programs of one text; elsewhere what is read",
    "Frame": "of coordinates; a call of a subprogram",
    "Span": "of a source; of a spline, within its kernel",
}
#: Modules that share a name, and why.
SHARED_MODULES = {
    "record": "the records that a room hands on",
    **dict.fromkeys(("reading", "reporting", "checking"), "what it does, in each room"),
    **dict.fromkeys(("columns", "stream", "tables", "summary", "verdict"), "a form of data, in each room"),
    "units": "AP238: of its entities; elsewhere of the house",
    "strategy": "the entry that planner.strategies loads, one a room",
    "limits": "verify judges limits with code of its own",
    "search": "for a place in a text, and for parameters",
    **dict.fromkeys(
        ("arcs", "corners", "frames", "lines", "nurbs", "offsets", "splines"),
        "gcode.codes: a module a concern, named as what it commands",
    ),
    **dict.fromkeys(
        ("cutting", "curves", "features", "gcode", "geometry", "pieces", "statements", "stock", "writer"),
        "stepnc: as its standards name them",
    ),
}


def apart(places: list[str]) -> bool:
    """Tell whether places of one name are neither twins of each other nor in folders of one idea."""
    for line in TWINS:
        inside = [place for place in places if any(place.startswith(folder) for folder in line if folder)]
        if inside and (len(inside) == len(places) or ("" in line and len(places) - len(inside) == 1)):
            return False
    return True


def test_no_two_classes_or_modules_share_a_name() -> None:
    """One name, one meaning: what shares one stands in a list above with its reason."""
    classes, modules_ = defaultdict(list), defaultdict(list)
    house = ROOT / "cncgen"
    for path in sorted(house.rglob("*.py")):
        place = path.relative_to(house).as_posix()
        name = path.parent.name if path.stem == "__init__" else path.stem
        modules_[name].append(place)
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef):
                # A private name is for its own room.
                private = node.name.startswith("_")
                classes[f"{place.partition('/')[0]}.{node.name[1:]}" if private else node.name].append(place)
    for name in [name for name in classes if "." in name]:
        room, _, public = name.partition(".")
        classes[name] += [place for place in classes.get(public, []) if place.startswith(room)]
    for found, shared in ((classes, SHARED_CLASSES), (modules_, SHARED_MODULES)):
        wrong = {n: w for n, w in found.items() if len(w) > 1 and n not in shared and apart(w)}
        assert not wrong, f"named twice: {wrong}"


def loaded_by_name() -> list[tuple[str, str]]:
    """Return the modules that are loaded by a name in a table, each with the module that loads it.

    G-code's codes are left out: the table of codes gathers modules that know its record.
    """
    from cncgen.papers.reproduction import MODULES
    from cncgen.pipeline.reading import _READERS
    from cncgen.planner.strategies import _STRATEGIES

    found = [("cncgen.planner.strategies", module) for module, _ in _STRATEGIES.values()]
    found += [("cncgen.pipeline.reading", module) for module in _READERS.values()]
    found += [("cncgen.papers.reproduction", module) for module in MODULES.values()]
    return found + [("cncgen.cli.commands", f"cncgen.cli.{name}") for name in COMMANDS]


def test_no_import_cycles() -> None:
    """Strongly connected components of the graph of imports at run time, by name too: each a single module."""
    grimp = pytest.importorskip("grimp")
    graph = grimp.build_graph("cncgen", exclude_type_checking_imports=True)
    for importer, imported_ in loaded_by_name():
        graph.add_import(importer=importer, imported=imported_)
    order: list[str] = []
    seen: set[str] = set()

    def visit(start: str, neighbours: object, out: list[str]) -> None:
        stack = [(start, iter(sorted(neighbours(start))))]  # type: ignore[operator]
        seen.add(start)
        while stack:
            module, rest = stack[-1]
            following = next((m for m in rest if m not in seen), None)
            if following is None:
                out.append(module)
                stack.pop()
            else:
                seen.add(following)
                stack.append((following, iter(sorted(neighbours(following)))))  # type: ignore[operator]

    for module in sorted(graph.modules):
        if module not in seen:
            visit(module, graph.find_modules_directly_imported_by, order)
    seen.clear()
    cycles = []
    for module in reversed(order):
        if module not in seen:
            component: list[str] = []
            visit(module, graph.find_modules_that_directly_import, component)
            if len(component) > 1:
                cycles.append(sorted(component))
    assert cycles == []


@pytest.mark.slow
def test_layers_hold() -> None:
    linter = shutil.which("lint-imports", path=str(Path(sys.executable).parent))
    if linter is None:
        pytest.skip("import-linter is not installed")
    run = subprocess.run([linter], cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert run.returncode == 0, run.stdout[-3000:]


def test_readme_begins_with_two_commands() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert text.index("make demo") < text.index("make test") < 1500


def test_the_readmes_picture_shows_setpoints_and_response(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both examples one after the other, from the top of the checkout."""
    pytest.importorskip("matplotlib")
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.chdir(ROOT)
    code = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.S)
    assert len(code) == 2
    names: dict[str, object] = {}
    exec(compile("".join(code), "README.md", "exec"), names)
    lines = names["plt"].gca().lines  # type: ignore[attr-defined]
    assert [len(line.get_xdata()) for line in lines] == [len(names["setpoints"])] * 2  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "page", ["README.md", *sorted(f"docs/{p.name}" for p in (ROOT / "docs").glob("*.md"))]
)
def test_links_of_the_pages_lead_somewhere(page: str) -> None:
    path = ROOT / page
    for target in re.findall(r"\]\((?!https?:)([^)#]+)", path.read_text(encoding="utf-8")):
        assert (path.parent / target).exists(), f"{page} links to {target}"


def test_the_command_names_its_version() -> None:
    run = subprocess.run(
        [sys.executable, "-m", "cncgen", "--version"], capture_output=True, text=True, check=False
    )
    assert (run.returncode, run.stdout) == (0, f"cncgen, version {cncgen.__version__}\n")


@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("cncgen pl", ["plain,plan", "plain,plot"]),
        ("cncgen plan --feedrate a", ["plain,adaptive"]),
        ("cncgen plan -m xy", ["file,xy", "plain,xy-table"]),
        ("cncgen plan part", ["file,part"]),
        ("cncgen machines show die", ["file,die", "plain,die-bonder"]),
        ("cncgen check --include lib", ["dir,lib"]),
    ],
)
def test_the_shell_completes_words_machines_and_files(words: str, found: list[str]) -> None:
    """Files come first: bash forgets what precedes them, and offers them where nothing else begins so."""
    asked = {
        "COMP_WORDS": words,
        "COMP_CWORD": str(len(words.split()) - 1),
        "_CNCGEN_COMPLETE": "bash_complete",
    }
    run = subprocess.run(
        [sys.executable, "-m", "cncgen"], env=os.environ | asked, capture_output=True, text=True, check=False
    )
    assert run.stdout.split() == found

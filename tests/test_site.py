"""The site: its pages are in its tree, what is generated is up to date, and the code on its pages runs."""

from __future__ import annotations

import importlib.util
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest
from click.testing import CliRunner

from cncgen.cli import app
from cncgen.cli.commands import cli

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
PAGES = ["README.md", *sorted(f"docs/{path.name}" for path in DOCS.glob("*.md"))]
#: Blocks of code by page and language, and the test that runs them.
RUN = {
    ("README.md", "python"): "test_house.py",
    ("README.md", "toml"): "test_docs.py",
    ("docs/library.md", "python"): "test_docs.py",
    ("docs/controllers.md", "toml"): "test_docs.py",
    ("docs/tutorial.md", "gcode"): "here",
    ("docs/tutorial.md", "sh"): "here",
    ("docs/how-to.md", "sh"): "here",
    ("docs/how-to.md", "python"): "here",
    ("docs/formats.md", "toml"): "here",
    ("docs/times.md", "toml"): "here",
    ("docs/extensions.md", "python"): "test_extensions.py",
    ("docs/extensions.md", "toml"): "test_extensions.py",
    ("docs/removal.md", "sh"): "here",
    ("docs/stepnc.md", "sh"): "here",
    ("docs/sweep.md", "toml"): "here",
    ("docs/sweep.md", "sh"): "here",
    ("docs/sweep.md", "python"): "sweep/test_cluster.py",
}


@pytest.fixture(scope="module")
def generate() -> ModuleType:
    """`docs/generate.py` as a module."""
    spec = importlib.util.spec_from_file_location("docs_generate", DOCS / "generate.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def blocks(page: str, *languages: str) -> list[tuple[str, str]]:
    """Return the blocks of a page with their languages, in order."""
    text = (ROOT / page).read_text(encoding="utf-8")
    found = re.findall(r"^```(\S*)\n(.*?)^```$", text, re.M | re.S)
    return [(kind, code) for kind, code in found if (kind in languages if languages else kind[:1] != "{")]


def test_every_block_of_code_is_run() -> None:
    kinds = {(page, kind) for page in PAGES for kind, _ in blocks(page) if kind != "text"}
    assert kinds == set(RUN)
    assert all((ROOT / "tests" / name).exists() for name in RUN.values() if name != "here")


def test_the_tutorial_and_the_recipes_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In one shell, in one folder; the programs of the tutorial under the names that it gives them."""
    shell = shutil.which("bash")
    if shell is None:
        pytest.skip("bash is not installed")
    programs = [code for _, code in blocks("docs/tutorial.md", "gcode")]
    for name, program in zip(("part.nc", "flat.nc"), programs, strict=True):
        (tmp_path / name).write_text(program, encoding="utf-8")
    lines = [code for page in ("docs/tutorial.md", "docs/how-to.md") for _, code in blocks(page, "sh")]
    # The reader that goes away after three lines ends the writer quietly, which pipefail shows.
    script = f'set -eo pipefail\ncncgen() {{ "{sys.executable}" -m cncgen "$@"; }}\n' + "".join(lines)
    run = subprocess.run(
        [shell, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=280, check=False
    )
    assert run.returncode == 0, run.stderr[-2000:]
    shown = shape_of(shown_by_the_tutorial(tmp_path, run.stderr))
    for _, said in blocks("docs/tutorial.md", "text"):
        assert shape_of(said) in shown, said
    assert (tmp_path / "response.csv").stat().st_size > 10_000
    assert (tmp_path / "part.sarif").read_text().startswith("{")
    monkeypatch.chdir(tmp_path)
    for _, code in blocks("docs/how-to.md", "python"):
        exec(compile(code.replace("part.nc", "flat.nc"), "how-to.md", "exec"), {})


def shape_of(text: str) -> str:
    """Return a text whose numbers and bars may differ, since they change with every better plan."""
    return re.sub(r"[▁▂▃▄▅▆▇█]+", "▁", re.sub(r"\d+(\.\d+)?", "0", text))


def shown_by_the_tutorial(folder: Path, messages: str) -> str:
    """Return what a reader sees: the messages of the commands, the head of the setpoints, the mistake that the page makes."""
    wrong = (folder / "part.nc").read_text(encoding="utf-8").replace("G3 X40 Y5 J5", "G3 X41 Y4 J5")
    (folder / "wrong").mkdir()
    (folder / "wrong" / "part.nc").write_text(wrong, encoding="utf-8")
    words = [sys.executable, "-m", "cncgen", "check", "part.nc"]
    check = subprocess.run(
        words, cwd=folder / "wrong", capture_output=True, text=True, timeout=60, check=False
    )
    return messages + (folder / "part.csv").read_text(encoding="utf-8")[:1000] + check.stderr


@pytest.mark.slow
def test_the_examples_of_sweeps_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The sweep as it stands, and its results in the tools that the page names; the search is read."""
    from cncgen.sweep.definition import load_sweep

    shell = shutil.which("bash")
    if shell is None:
        pytest.skip("bash is not installed")
    pandas, polars, duckdb = (pytest.importorskip(name) for name in ("pandas", "polars", "duckdb"))
    shutil.copy(ROOT / "programs" / "butterfly.nc", tmp_path / "butterfly.nc")
    (sweep, search) = (code for _, code in blocks("docs/sweep.md", "toml"))
    (tmp_path / "jerk.toml").write_text(sweep, encoding="utf-8")
    (tmp_path / "search.toml").write_text(search, encoding="utf-8")
    (lines,) = (code for _, code in blocks("docs/sweep.md", "sh"))
    script = f'set -e\ncncgen() {{ "{sys.executable}" -m cncgen "$@"; }}\n{lines}'
    run = subprocess.run(
        [shell, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=280, check=False
    )
    assert run.returncode == 0, run.stderr[-2000:]
    assert run.stdout.startswith("16 jobs, 16 missing, 0 failed\n")
    assert (tmp_path / "jerk.png").read_bytes().startswith(b"\x89PNG")
    monkeypatch.chdir(tmp_path)
    frames = [pandas.read_parquet("jerk/"), polars.read_parquet("jerk/*.parquet")]
    frames.append(duckdb.sql("from 'jerk/*.parquet'").df())
    assert [len(frame) for frame in frames] == [16, 16, 16]
    goal = load_sweep("search.toml").search
    assert goal is not None
    assert goal.under == {"contour_error_max_mm": 0.06}


def files_of_the_examples(folder: Path, page: str) -> None:
    """Write the programs, tables and parts that the commands of the pages on STEP-NC and material removal name.

    Of the programs that ship the shaft is the smallest one with a raw piece, which `cut` wants.
    """
    from cncgen.removal.stock import box
    from cncgen.removal.surfaces import mesh_of, stl_bytes
    from tests.stepnc.building import Part

    part_of_page = "shaft" if page == "docs/removal.md" else "plate_ap238"
    for name, file in ((part_of_page, "part.stp"), ("shaft", "shaft.stp")):
        shutil.copy(ROOT / "programs" / "stepnc" / f"{name}.stp", folder / file)
    mill = (ROOT / "cncgen/machine/profiles/generic-mill.toml").read_text(encoding="utf-8")
    table = '\n[kinematics]\nmodel = "table-table"\naxes = ["a", "c"]\ncentre_mm = [20, 15, 0]\n'
    texts = {
        "part.nc": "G21 G90 G94 G17\nT3 M6\nS1000 M3\nG0 X0 Y0 Z5\nG1 Z-2 F300\nX20\nG0 Z5\nM2\n",
        "tool.tbl": "T3 P3 D10 Z50\n",
        "five.toml": mill + table,
        "five_axes.nc": "G21 G90 G94\nT1 M6\nS1000 M3\nG0 X29 Y15 Z5\nG1 Z-3 F300\nC90 F2000\nG0 Z5\nM2\n",
        "shaft.nc": "G21 G18 G90 G8\nT1 M6\nM4 S500 F200\nG0 X24 Z5\nG1 Z-60\nG0 X30\nZ5\nM2\n",
    }
    for file, text in texts.items():
        (folder / file).write_text(text, encoding="utf-8")
    stood = mesh_of(box((-25, -25, -30), (25, 25, -3)).field(1.0))
    (folder / "part.stl").write_bytes(stl_bytes(*stood))
    part = Part()
    axis = part.polyline((0, -0.5, 0.8), (0, -0.5, 0.8))
    slot = part.trajectory(part.polyline((-20, 15, -5), (60, 15, -5)), axis=axis)
    part.project(part.plan(part.step(part.freeform(slot, tool=part.tool("T1", 10.0)))))
    (folder / "five_axes.stp").write_text(part.text(), encoding="utf-8")


@pytest.mark.parametrize("page", ["docs/removal.md", "docs/stepnc.md"])
def test_the_commands_on_step_nc_and_material_run(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """None is refused; that a motion is wrong is what `cut` may find (exit code 1), and then it names it."""
    files_of_the_examples(tmp_path, page)
    monkeypatch.chdir(tmp_path)
    lines = [line for _, code in blocks(page, "sh") for line in code.splitlines()]
    assert len(lines) >= 6
    for line in lines:
        words = shlex.split(line, comments=True)
        code = app.run(words[1:])
        said = capfd.readouterr().err
        assert code == 0 or (code, words[1]) == (1, "cut"), f"{line}: {said}"
        assert (code == 1) == ("error[cut-" in said), line


@pytest.mark.parametrize("page", ["docs/formats.md", "docs/times.md"])
def test_tables_of_machine_files_are_read(page: str) -> None:
    """Beside a profile that has no such table."""
    from cncgen.machine.reading import machine_from_toml

    profile = (ROOT / "cncgen/machine/profiles/xy-table.toml").read_text(encoding="utf-8")
    for _, code in blocks(page, "toml"):
        assert tomllib.loads(code)
        assert machine_from_toml(f"{profile}\n{code}".encode(), page).axes["X"].max_velocity > 0.0


def test_every_page_is_in_the_tree_of_the_site() -> None:
    listed = re.findall(r"^([\w/-]+)$", (DOCS / "index.md").read_text(encoding="utf-8"), re.M)
    pages = {path.stem for path in DOCS.glob("*.md")} - {"index"}
    assert pages <= set(listed)
    assert {name for name in listed if "/" in name} == {"generated/commands", "generated/codes/index"}


def test_the_reference_is_what_help_prints(generate: ModuleType) -> None:
    """Word by word, without the marks of Markdown."""
    page = generate.command_page()
    assert len(generate.commands()) > 20
    for name, _ in generate.commands():
        said = CliRunner().invoke(cli, [*name.split()[1:], "--help"], prog_name="cncgen", terminal_width=200)
        assert said.exit_code == 0
        section = re.split(r"^#", page.partition(f"# {name}\n")[2], maxsplit=1, flags=re.M)[0]
        section = re.sub(r"^: ", "", re.sub(r"\\([\W_])", r"\1", section), flags=re.M)
        assert section.replace("`", "").split() == said.output.replace("`", "").split(), name


def test_options_keep_their_hyphens_on_the_site(tmp_path: Path) -> None:
    """A page built with the constants of `docs/conf.py`; Sphinx makes dashes of two hyphens unless it is told not to."""
    for package in ("sphinx", "myst_parser"):
        pytest.importorskip(package)
    lines = (DOCS / "conf.py").read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if re.match(r"(smartquotes|myst_\w+) = ", line)]
    (tmp_path / "conf.py").write_text("\n".join(['extensions = ["myst_parser"]', *kept]), encoding="utf-8")
    (tmp_path / "index.md").write_text("# A page\n\nWith --json, and `--tree`.\n", encoding="utf-8")
    words = [sys.executable, "-m", "sphinx", "-q", "-W", "-b", "html", str(tmp_path), str(tmp_path / "out")]
    run = subprocess.run(words, capture_output=True, text=True, timeout=280, check=False)
    assert run.returncode == 0, run.stderr
    assert "With --json, and " in (tmp_path / "out" / "index.html").read_text(encoding="utf-8")


def test_each_diagnostic_has_a_page(generate: ModuleType) -> None:
    pages = generate.code_pages()
    index = pages.pop("codes/index.md")
    for name, text in pages.items():
        code = Path(name).stem
        assert text.startswith(f"# {code}\n")
        assert f"\n{code}\n" in index


def test_manual_page_and_completions_are_up_to_date(generate: ModuleType) -> None:
    for name, text in generate.shell_files().items():
        assert (DOCS / "shell" / name).read_text(encoding="utf-8") == text, "python docs/generate.py"


#: What a shell does when a key is pressed behind words, the last of which is begun: it prints what completes that.
SHELLS = {
    "bash": """compopt() { :; }; source {file}; COMP_WORDS=({words}); COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
        _cncgen_completion cncgen; printf '%s\\n' "${COMPREPLY[@]}" """,
    "zsh": """compdef() { : }; _path_files() { : }; compadd() { print -l $completions }
        _describe() { print -l ${completions_with_descriptions%%:*} }
        source {file}; words=({words}); CURRENT=$#words; _cncgen_completion""",
    "fish": "source {file}; complete -C '{words}'",
}


@pytest.mark.parametrize("shell", SHELLS)
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("cncgen pl", ["plan", "plot"]),
        ("cncgen plan -m xy", ["xy-table"]),
        ("cncgen machines ge", ["generic-lathe", "generic-mill"]),
        ("cncgen explain no-tool", ["no-tool-table"]),
        ("cncgen plan --as g", ["grbl"]),
    ],
)
def test_the_completions_that_ship_complete(
    tmp_path: Path, shell: str, words: str, expected: list[str]
) -> None:
    """In the shell itself, where it is installed, with a command of that name on the path."""
    program = shutil.which(shell)
    if program is None:
        pytest.skip(f"{shell} is not installed")
    command = tmp_path / "cncgen"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m cncgen "$@"\n', encoding="utf-8")
    command.chmod(0o755)
    file = DOCS / "shell" / {"zsh": "_cncgen"}.get(shell, f"cncgen.{shell}")
    script = SHELLS[shell].replace("{file}", f"'{file}'").replace("{words}", words)
    about = os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}", "HOME": str(tmp_path)}
    run = subprocess.run(
        [program, "-c", script],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env=about,
        timeout=120,
        check=False,
    )
    assert [line.partition("\t")[0] for line in run.stdout.splitlines()] == expected, run.stderr


def test_the_manual_page_names_every_option(generate: ModuleType) -> None:
    page = generate.manual_page().replace("\\-", "-")
    for name, command in generate.commands():
        assert f".SS {name.removeprefix('cncgen ')}" in page
        for parameter in command.params:
            for flag in (flag for flag in parameter.opts if flag.startswith("--")):
                assert flag in page, f"{name} {flag}"


def test_man_reads_the_page_without_complaint() -> None:
    groff = shutil.which("groff")
    if groff is None:
        pytest.skip("groff is not installed")
    run = subprocess.run(
        [groff, "-man", "-Tutf8", "-ww", str(DOCS / "shell" / "cncgen.1")],
        capture_output=True,
        text=True,
        env=os.environ | {"LC_ALL": "C.UTF-8"},
        check=False,
    )
    assert run.returncode == 0
    assert "CNCGEN(1)" in run.stdout
    assert "fatal" not in run.stderr


def test_the_citation_has_the_version_of_the_package() -> None:
    import cncgen

    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {cncgen.__version__}\n" in text
    assert f"\n## {cncgen.__version__}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")

"""The site: its pages are in its tree, what is generated is up to date, and the code on its pages runs."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest
from click.testing import CliRunner

from cncgen.cli.app import cli

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
}
#: Blocks that no test runs, and why.
NOT_RUN = {
    (
        "docs/extensions.md",
        "python",
    ): "modules of a package that is another's",
    ("docs/extensions.md", "toml"): "the project file of that package",
    ("docs/sweep.md", "python"): "needs a cluster with Slurm",
    ("docs/sweep.md", "sh"): "sweeps take minutes; tests/sweep runs smaller ones",
    ("docs/sweep.md", "toml"): "sweeps take minutes; tests/sweep runs smaller ones",
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
    found = re.findall(r"^```(\w+)\n(.*?)^```", text, re.M | re.S)
    return [(kind, code) for kind, code in found if not languages or kind in languages]


def test_every_block_of_code_is_run_or_says_why_not() -> None:
    kinds = {(page, kind) for page in PAGES for kind, _ in blocks(page) if kind != "text"}
    assert kinds == set(RUN) | set(NOT_RUN)


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
    assert (tmp_path / "response.csv").stat().st_size > 10_000
    assert (tmp_path / "part.sarif").read_text().startswith("{")
    monkeypatch.chdir(tmp_path)
    for _, code in blocks("docs/how-to.md", "python"):
        exec(compile(code.replace("part.nc", "flat.nc"), "how-to.md", "exec"), {})


@pytest.mark.parametrize("page", ["docs/formats.md", "docs/times.md"])
def test_tables_of_machine_files_are_read(page: str) -> None:
    """Beside a profile that has no such table."""
    from cncgen.machine.reading import machine_from_toml

    profile = (ROOT / "cncgen/machine/profiles/generic-mill.toml").read_text(encoding="utf-8")
    for _, code in blocks(page, "toml"):
        assert tomllib.loads(code)
        assert machine_from_toml(f"{profile}\n{code}".encode(), page).axes["X"].max_velocity > 0.0


def test_every_page_is_in_the_tree_of_the_site() -> None:
    listed = re.findall(r"^([\w/-]+)$", (DOCS / "index.md").read_text(encoding="utf-8"), re.M)
    pages = {path.stem for path in DOCS.glob("*.md")} - {"index"}
    assert pages <= set(listed)
    assert {name for name in listed if "/" in name} == {"generated/commands", "generated/codes/index"}


def test_the_reference_is_what_help_prints(generate: ModuleType) -> None:
    page = generate.command_page()
    assert len(generate.commands()) > 20
    for name, _ in generate.commands():
        words = name.split()[1:]
        said = CliRunner().invoke(cli, [*words, "--help"], prog_name="cncgen", terminal_width=generate.WIDTH)
        assert said.exit_code == 0
        section = page.partition(f" {name}\n\n```text\n")[2].partition("\n```\n")[0]
        # Its last words differ where the name of the command is wrapped.
        assert " ".join(section.split()) == " ".join(said.output.split()), name


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

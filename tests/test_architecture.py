"""docs/architecture.md tells the whole house: every room is named, and everything named is there."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
TABLE = "\n".join(line for line in PAGE.splitlines() if line.startswith("| `"))


def folders() -> set[str]:
    """Return all folders that hold files of the project."""
    run = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    if run.returncode == 0 and run.stdout:
        files = [Path(line) for line in run.stdout.splitlines()]
    else:  # a checkout without git: all that is no build's
        skipped = {"build", "dist", "out", "__pycache__"}
        files = [
            path.relative_to(ROOT)
            for path in ROOT.rglob("*")
            if path.is_file()
            and not any(part in skipped or part[0] == "." for part in path.parts[len(ROOT.parts) :])
        ]
    return {parent.as_posix() for path in files for parent in path.parents if parent.parts}


def described() -> set[str]:
    """Return the folders that the table names: whole paths, and the rooms that their rows name below them."""
    found: set[str] = set()
    for row in TABLE.splitlines():
        rooms, about = row.removeprefix("| ").split(" | ")[:2]
        tops = [name.removesuffix("/*.py") for name in re.findall(r"`([\w./*]+)`", rooms)]
        found |= set(tops)
        for name in re.findall(r"`([\w/]+|\w+\.py)`", about):
            found.add(name if "/" in name else f"{tops[0]}/{name}")
    return found


def test_every_room_is_named() -> None:
    inside = {
        name for name in folders() if name.startswith("cncgen/") and (ROOT / name / "__init__.py").exists()
    }
    top = {name for name in folders() if "/" not in name and name[0] != "."} - {"cncgen"}
    assert len(inside) > 30
    assert sorted((inside | top) - described()) == []


def test_every_name_is_there() -> None:
    known = folders() | {path.relative_to(ROOT).as_posix() for path in (ROOT / "cncgen").glob("*.py")}
    assert (
        sorted(name for name in described() if name not in known and f"cncgen/{Path(name).name}" not in known)
        == []
    )


def test_modules_of_the_package_itself_are_named() -> None:
    for path in (ROOT / "cncgen").glob("*.py"):
        assert path.name.startswith("__") or f"`{path.name}`" in TABLE, path.name


def test_table_and_decisions_are_a_screen_each() -> None:
    decisions = PAGE[PAGE.index("## Decisions") : PAGE.index("## To add")]
    assert len(TABLE.splitlines()) <= 40
    assert len(decisions.splitlines()) <= 40
    assert max(map(len, decisions.splitlines())) <= 140


def test_every_page_is_listed() -> None:
    for path in (ROOT / "docs").glob("*.md"):
        assert path.name == "architecture.md" or f"]({path.name})" in PAGE, f"{path.name} is not linked"

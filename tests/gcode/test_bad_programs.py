"""Every program of programs/bad gives exactly the errors that its first line says: ``; expect line:column:code …``."""

from __future__ import annotations

from pathlib import Path

import pytest

from cncgen.gcode import read
from cncgen.toolpath.reading import ReadOptions

BAD = Path(__file__).resolve().parent.parent.parent / "programs" / "bad"
#: Low, so that endless programs end soon.
STEPS = 20_000


def expectation(path: Path) -> tuple[str, list[str]]:
    """Return dialect and errors that a program's first line names (``; expect fanuc 3:1:code``)."""
    words = path.read_text("utf-8").splitlines()[0].removeprefix("; expect").split()
    dialect = words.pop(0) if words[0] in ("fanuc", "linuxcnc") else "auto"
    return dialect, words


@pytest.mark.parametrize("path", sorted(BAD.glob("*.nc")), ids=lambda p: p.stem)
def test_a_bad_program_gives_its_errors(path: Path) -> None:
    dialect, expected = expectation(path)
    program = read(path, path.name, ReadOptions(max_steps=STEPS, dialect=dialect))
    for _ in program.chunks():
        pass
    errors = [d for d in program.diagnostics if d.severity == "error"]
    assert [f"{d.span.line}:{d.span.column}:{d.code}" for d in errors if d.span] == expected
    for error in errors:
        assert error.hint, error.render()
        # The caret stands within the line that is shown.
        text, caret = error.render().splitlines()[1:3]
        assert caret.index("^") <= len(text)


def test_there_are_bad_programs_of_every_kind() -> None:
    assert len(list(BAD.glob("*.nc"))) >= 120

"""Order of execution: O-words, subroutines, calls by number; bounds on what has no end."""

from __future__ import annotations

import random
import time
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.gcode.source import Source
from cncgen.gcode.text.marked_lines import Labels
from cncgen.kernels.gcode_codes import LITERALS
from trials.generators.gcode_bodies import body, ways

from ..kernels.plain import uncompiled


def xs(out: Any) -> list[float]:
    """Return the X of the motions, after asserting that all went well."""
    assert out.errors == []
    return [float(row[0]) for row, kind in zip(out.path.end, out.path.kind, strict=True) if kind != 3]


def test_nested_loops_run_as_often_as_they_say(run: Any) -> None:
    out = run(
        "#1=0\no1 while [#1 lt 3]\n#1=[#1+1]\n#2=0\no2 do\n#2=[#2+1]\nG0 X[#1*10+#2]\n"
        "o2 while [#2 lt 2]\no3 repeat [2]\n#4=[#4+1]\no3 endrepeat\no1 endwhile\nG0 X#4\nM2"
    )
    assert xs(out) == [11, 12, 21, 22, 31, 32, 6]


@pytest.mark.parametrize(("value", "expected"), [(1, 10), (2, 20), (3, 30), (4, 40)])
def test_one_branch_is_taken(run: Any, value: int, expected: float) -> None:
    out = run(
        f"#1={value}\no1 if [#1 eq 1]\nG0 X10\no1 elseif [#1 eq 2]\nG0 X20\no1 elseif [#1 eq 3]\nG0 X30\n"
        "o1 else\nG0 X40\no1 endif\nM2"
    )
    assert xs(out) == [expected]


@pytest.mark.parametrize(
    ("text", "word", "end"),
    [
        ("o1 while [#1 lt 5]\n#1=[#1+1]\nG0 X#1\nM2", "WHILE", "ENDWHILE"),
        ("o1 repeat [5]\n#1=[#1+1]\nG0 X#1\nM2", "REPEAT", "ENDREPEAT"),
        ("o1 if [#1 lt 5]\n#1=[#1+1]\nG0 X#1\nM2", "IF", "ENDIF"),
        ("o1 do\n#1=[#1+1]\nG0 X#1\nM2", "DO", "WHILE"),
        ("o9 sub\no1 do\nG0 X1\no9 endsub\no9 call [1]\no1 while [0]\nM2", "DO", "WHILE"),
        ("o9 sub\no1 while [#1 lt 5]\nG0 X1\no9 endsub\no9 call [1]\no1 endwhile\nM2", "WHILE", "ENDWHILE"),
    ],
)
def test_a_loop_or_branch_without_an_end_is_run_once_with_a_warning(
    run: Any, text: str, word: str, end: str
) -> None:
    """LinuxCNC's interpreter runs it so, and says nothing: the end is looked for by a jump alone."""
    out = run(text)
    found = [d for d in out.diagnostics if d.code == "oword-unclosed"]
    assert [(d.severity, d.message) for d in found] == [
        ("warning", f"o1 {word} has no {end}: what follows is run once")
    ]
    assert [float(row[0]) for row, kind in zip(out.path.end, out.path.kind, strict=True) if kind != 3] == [1]


def test_a_program_that_ends_within_a_branch_that_has_an_end(run: Any) -> None:
    out = run("o1 if [1]\nG0 X1\nM2\no1 endif\nG0 X2\nM2")
    assert [d.code for d in out.diagnostics if d.code.startswith("oword")] == []


def test_break_and_continue(run: Any) -> None:
    out = run(
        "o1 while [1]\n#1=[#1+1]\no2 if [#1 eq 2]\no1 continue\no2 endif\no3 if [#1 gt 4]\no1 break\no3 endif\n"
        "G0 X#1\no1 endwhile\nM2"
    )
    assert xs(out) == [1, 3, 4]


def test_arguments_are_local_and_values_come_back(run: Any) -> None:
    out = run(
        "#1=7\no<twice> sub\n#<inner>=[#1*2]\no<twice> endsub [#<inner>]\no<twice> call [4]\n"
        "G0 X#<_value>\nG0 X#1\nG0 X[EXISTS[#<inner>]]\nM2"
    )
    assert xs(out) == [8, 7, 0]


def test_recursion_with_an_end(run: Any) -> None:
    out = run(
        "o<fac> sub\no1 if [#1 le 1]\no<fac> return [1]\no1 endif\no<fac> call [#1-1]\n"
        "o<fac> endsub [#1*#<_value>]\no<fac> call [5]\nG0 X#<_value>\nM2"
    )
    assert xs(out) == [120]


def test_subroutines_in_files(run: Any, tmp_path: Any) -> None:
    (tmp_path / "Slot.ngc").write_text("o<slot> sub\nG0 X[#1+0.5]\no<slot> endsub\nM2\n")
    out = run("o<slot> call [3]\nG0 X1\nM2", include=(tmp_path,))
    assert xs(out) == [3.5, 1]
    assert out.path.sources == ("t.ngc", str(tmp_path / "Slot.ngc"))


def test_a_file_whose_name_begins_with_a_point_is_found_and_no_settings_are(run: Any, tmp_path: Any) -> None:
    """LinuxCNC's own `rs274` runs it: shops hide subroutines from the list of programs so, o<.m6> in ``.m6.ngc``."""
    (tmp_path / ".m6.ngc").write_text("o<.m6> sub\nG0 X[#1]\no<.m6> endsub\nM2\n")
    (tmp_path / ".netrc").write_text("o<.netrc> sub\no<.netrc> endsub\n")
    out = run("o<.m6> call [3]\nM2", include=(tmp_path,))
    assert (out.errors, out.path.end[0, 0]) == ([], 3.0)
    for name in (".netrc", ".", "..", "../x"):
        out = run(f"o<{name}> call\nM2", include=(tmp_path,))
        assert [code for code, *_ in out.errors] == ["sub-missing" if name == ".netrc" else "sub-path"]


def test_files_beside_the_program_are_found(tmp_path: Any) -> None:
    from cncgen.gcode import read

    (tmp_path / "part.ngc").write_text("o<hole> call [2]\nM2\n")
    (tmp_path / "hole.ngc").write_text("o<hole> sub\nG0 X#1\no<hole> endsub\n")
    program = read(tmp_path / "part.ngc", "part.ngc")
    (chunk,) = program.chunks()
    assert not program.diagnostics.has_errors
    assert chunk.end[0].tolist() == [2, 0, 0]
    assert chunk.source.tolist() == [1, 0]
    assert chunk.line.tolist() == [2, 2]
    assert chunk.sources == ("part.ngc", str(tmp_path / "hole.ngc"))


@pytest.mark.parametrize(
    "text",
    [
        "o1 while [1]\no1 endwhile\nM2",
        "o1 do\no1 while [1]\nM2",
        "o1 repeat [1e0]\no1 endrepeat\no2 repeat [999999999]\no2 endrepeat\nM2",
        "o1 sub\no1 call\no1 endsub\no1 call\nM2",
        "o1 while [1]\n#1=[1/0]\no1 endwhile\nM2",
        "o1 while [1]\nG1 X1\no1 endwhile\nM2",
    ],
)
def test_what_has_no_end_is_ended_soon(run: Any, text: str) -> None:
    begin = time.monotonic()
    out = run(text, max_steps=50_000)
    assert out.errors
    # Not a measurement: without the bound this would take for ever.
    assert time.monotonic() - begin < 60


def test_steps_and_depth_are_bounds_to_set(run: Any) -> None:
    assert run("o1 repeat [50]\n#1=1\no1 endrepeat\nM2", max_steps=60).errors[0][0] == "too-many-steps"
    assert run("o1 repeat [50]\n#1=1\no1 endrepeat\nM2", max_steps=500).errors == []
    deep = "o1 sub\no2 if [#1 gt 0]\no1 call [#1-1]\no2 endif\no1 endsub\no1 call [5]\nM2"
    assert run(deep, max_call_depth=4).errors[0][0] == "call-depth"
    assert run(deep, max_call_depth=6).errors == []


def test_plain_blocks_in_a_loop_are_read_once_and_run_often(run: Any) -> None:
    out = run("G91 F100\no1 repeat [1000]\nG1 X1\nG1 X-0.5\no1 endrepeat\nM2")
    assert xs(out)[-1] == 500


def test_m98_and_m99(run: Any) -> None:
    assert xs(run("G0 X1\nM98 P5 L2\nG0 X9\nM2\nO5\nG91 G0 X1\nG90\nM99")) == [1, 2, 3, 9]


def test_modal_state_is_saved_and_restored(run: Any) -> None:
    out = run("o1 sub\nM73\nG91 G20\nG0 X1\no1 endsub\nG0 X10\no1 call\nG0 X10\nM2")
    assert xs(out) == pytest.approx([10, 35.4, 10])
    assert run("M72\nM2").errors[0][0] == "nothing-saved"


def test_block_delete(run: Any) -> None:
    text = "/G0 X1\nG0 X2\n/#1=3\nG0 X#1\nM2"
    assert xs(run(text)) == [2, 0]
    assert xs(run(text, block_delete=False)) == [1, 2, 3]


def test_percent_signs_bound_the_program(run: Any) -> None:
    out = run("%\nG0 X1\n%\nG0 X2\n")
    assert xs(out) == [1]
    assert [said.code for said in out.diagnostics] == ["text-behind-end"]


@pytest.mark.parametrize(
    ("text", "dialect", "lines"),
    [
        # Two programs in one file, as users join them for senders to grbl: a control runs the first one alone (RS274/NGC, 3.6.1).
        ("G0 X1\nM30\nG0 X2\nG0 X3\nM30\n", "linuxcnc", [2]),
        ("G0 X1\nN5 G0 X4 M02 (the end)\n(next)\nX2\n", "linuxcnc", [2]),
        ("O1\nG0 X1.\nM30\nT2 M6\nG0 X2.\nM30\n%", "fanuc", [3]),
        ("%\nO1\nG0 X1.\nM30\n%\n", "fanuc", []),
        ("G0 X1\nM30\n\n(X5)\n;G0 X3\n%\n", "linuxcnc", []),
        ("G0 X1\no1 call\nM2\no1 sub\nG0 X2\no1 endsub\n", "linuxcnc", []),
        ("O1\nG0 X1.\nM30\nO2\nG0 X2.\nM99\n", "fanuc", []),
        # A program of its own, which ends as a main program does; as a subprogram it would be called.
        ("%\nO1\nG0 X1.\nM30\n%\nO2\nG0 X2.\nM30\n%\n", "fanuc", [4]),
        ("O1\nG0 X1.\nM30\nO3\nG0 X3.\nM99\nO2\nM98 P3\nG0 X2.\nM30\n", "fanuc", [3]),
        ("O1\nM98 P30002\nM30\nO2\nG0 X2.\nM30\n", "fanuc", []),
        ("O1\nM98 P[#1+2]\nM30\nO2\nG0 X2.\nM30\n", "fanuc", []),
        ("O1\nM97 P9\nM30\nN9 G0 X2.\nM99\n", "fanuc", []),
        ("O1\nIF [#1 GT 5.] GOTO 9\nM30\nN9 G0 X2.\nM30\n", "fanuc", []),
    ],
)
def test_blocks_behind_the_end_of_the_program_are_not_run_in_silence(
    run: Any, text: str, dialect: str, lines: list[int]
) -> None:
    said = [d for d in run(text, dialect=dialect).diagnostics if d.code == "text-behind-end"]
    assert [d.span.line for d in said if d.span] == lines


def test_a_program_without_an_end_is_warned_of(run: Any) -> None:
    out = run("G0 X1\n")
    assert [(d.code, d.severity) for d in out.diagnostics] == [("no-program-end", "warning")]


def test_looking_for_computed_labels_has_a_bound(run: Any) -> None:
    """The next line that has the label ends the search; each that is computed on the way counts as a block."""
    pairs = "".join(f"o[#1+{k}] if [0]\no[#1+{k}] endif\n" for k in range(300))
    assert run(pairs + "M2", dialect="linuxcnc", max_steps=2000).errors == []
    alone = "".join(f"o[#1+{k}] if [0]\no[#1-{k + 1}] endif\n" for k in range(100))
    codes = {code for code, _, _ in run(alone + "M2", dialect="linuxcnc", max_steps=2000).errors}
    assert codes == {"oword-unmatched", "too-many-steps"}


LINES = st.lists(
    st.tuples(
        st.sampled_from(["1", "2", "[#1]", "[#1+1]"]),
        st.sampled_from(["sub", "endsub", "if [1]", "else", "endif"]),
    ),
    max_size=12,
)


PLAIN = uncompiled("gcode_marks")


@given(LINES, st.integers(0, 11), st.sampled_from([1.0, 2.0]), st.booleans())
def test_marks_are_the_nearest_of_their_label(
    lines: list[tuple[str, str]], place: int, label: float, over: bool
) -> None:
    """A slow reference: from line to line, up to the next border of a subroutine (its line counts)."""
    text = "".join(f"o{name} {keyword}\n" for name, keyword in lines)
    labels = Labels(Source(text.encode(), "t"), 0, "linuxcnc")
    wanted = ("else", "endif", "endsub")
    value = {"1": 1.0, "2": 2.0, "[#1]": 1.0, "[#1+1]": 2.0}

    def reference(order: range, stop: bool) -> int | None:
        for k in order:
            name, keyword = lines[k]
            if value[name] == label and keyword in wanted:
                return k
            if stop and keyword in ("sub", "endsub"):
                return None
        return None

    place = min(place, len(lines) - 1)
    if place < 0:
        return
    offset = labels.marks[place].cursor.offset
    names = {id(mark.label): name for mark, (name, _) in zip(labels.marks, lines, strict=True)}

    def known(written: Any) -> Any:
        return value[names[id(written)]] if callable(written) else written

    # The kernel runs uncompiled.
    rows = [
        (m.cursor.offset, m.cursor.line, LITERALS[m.keyword], m.label, m.after.offset) for m in labels.marks
    ]
    slow = PLAIN.Marks(rows)
    bits = PLAIN.bits_of(wanted)
    for way in (1, -1):
        asked = (offset, way, label, bits, over, known)
        assert slow.nearest(*asked) == labels.lines.nearest(*asked)
    assert [slow.leads(m) for m in range(slow.count)] == [labels.lines.leads(m) for m in range(slow.count)]
    after = labels.next(offset, label, wanted, known, over_borders=over)
    before = labels.previous(offset, label, wanted, known)
    at = {mark.cursor.offset: k for k, mark in enumerate(labels.marks)}
    assert (at[after.cursor.offset] if after else None) == reference(range(place + 1, len(lines)), not over)
    assert (at[before.cursor.offset] if before else None) == reference(range(place - 1, -1, -1), True)


@pytest.mark.parametrize(
    ("wrong", "loop"),
    [
        ("#1=", "o1 while [#1 LT 3]\n#2=[#2+1]\no1 endwhile"),
        ("#1=", "o1 while [#1 LT 3]\nG1 X#2 F100\n#2=[#2+1]\no1 endwhile"),
        ("#1=[2+", "WHILE [#1 LT 3] DO1\nG1 X#2 F100\nEND1"),
    ],
)
def test_a_loop_that_a_fault_lets_run_on_is_left(
    run: Any, monkeypatch: pytest.MonkeyPatch, wrong: str, loop: str
) -> None:
    """What would have ended it may be what was wrong: reading goes on behind it, and finds the next fault."""
    from cncgen.gcode.flow import recurrence

    monkeypatch.setattr(recurrence, "_MOST_AFTER_A_FAULT", 5_000)
    out = run(f"{wrong}\n{loop}\nG1 X=\nM2\n", max_steps=1_000_000)
    assert [(code, line) for code, line, _ in out.errors] == [("syntax", 1), ("syntax", 3 + loop.count("\n"))]
    whole = run(f"#1=0\n{loop}\nM2\n", max_steps=20_000)
    assert [code for code, _, _ in whole.errors] == ["too-many-steps"]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("o1 while [#1 lt 3]\n#1=[#1+1]\no2 sub\no2 endsub\no1 endwhile\nM2", 5),
        ("#1=9\no1 while [#1 lt 3]\no2 sub\no2 endsub\no1 endwhile\nM2", 2),
        ("o1 repeat [2]\no2 sub\nG0 X1\no2 endsub\no1 endrepeat\nM2", 5),
        ("o1 if [1]\no2 sub\no2 endsub\no1 else\no1 endif\nM2", 4),
    ],
)
def test_a_subroutine_within_a_loop_or_branch_is_what_parts_it(run: Any, text: str, line: int) -> None:
    """That its end is missing was all that was said of it; LinuxCNC refuses the SUB."""
    found = next(d for d in run(text).diagnostics if d.code == "oword-unmatched")
    assert found.span.line == line
    sub = 1 + text.split("\n").index("o2 sub")
    assert f"the subroutine that begins in line {sub} parts it from the " in found.hint


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        (
            "o<a> sub [1]\no<a> endsub\nM2",
            "oword-arguments",
            ("SUB has 1 value in brackets", "the values of CALL are #1"),
        ),
        (
            "o1 if [1] [2]\no1 endif\nM2",
            "oword-arguments",
            ("IF has 2 values in brackets", "one value in brackets"),
        ),
        ("F9\nG5.2 X0 Y1 P1 L3\nX2 Y2\nG5.3\nM2", "nurbs-weight", ("has no weight P", "write P1 where")),
    ],
)
def test_help_of_values_and_weights(run: Any, text: str, code: str, words: tuple[str, str]) -> None:
    """SUB was told of IF; a missing weight, which is an error, that it were 1."""
    found = next(d for d in run(text).diagnostics if d.code == code)
    assert words[0] in found.message
    assert words[1] in found.hint


#: A REPEAT that CONTINUE of the loop around it leaves in the middle of a round.
LEFT = (
    "#1=0\no3 while [#1 LT 8]\n#1=[#1+1]\no1 repeat [3]\nG1 X#1 Z[0-#1]\no3 continue\no1 endrepeat\n"
    "G1 X[#1+0.5] Z[0-#1-0.5]\no3 endwhile\n"
)


@pytest.mark.parametrize(
    "text",
    [
        f"F9 G18 G8\n{LEFT}M2\n",
        f"o100 sub\n{LEFT}o100 endsub\nF9 G18 G8\no100 call\nM2\n",
        f"o100 sub\n{LEFT}o100 endsub\nF9 G18 G8\no5 repeat [1]\no100 call\no5 endrepeat\nM2\n",
        f"o100 sub\n{LEFT}o100 endsub\no2 sub\no100 call\no2 endsub\nF9 G18 G8\no2 call\nM2\n",
        f"o100 sub\n{LEFT}o100 endsub\nF9 G18 G8\nG70 Q100 X0 Z1\nM2\n",
    ],
)
def test_a_repeat_that_an_outer_continue_left_goes_on(run: Any, text: str) -> None:
    """LinuxCNC's interpreter makes these moves: each REPEAT met on the way counts as the end of a round, in every way of calling."""
    found = [x for x in xs(run(text)) if x > 0.0]
    assert found == [1, 2, 3, 4.5, 5, 6, 7, 8.5]


def test_a_line_number_begins_with_a_digit(run: Any) -> None:
    """N.5 is no line number in the grammar, nor to LinuxCNC; the scanner of plain lines took it."""
    for text in ("N.5 G1 X1 F1\n", "#1=1\nN.5 G1 X#1 F1\n", "o1 repeat [2]\nN.5 G1 X#1 F1\no1 endrepeat\n"):
        assert [error[0] for error in run(text + "M2\n").errors] == ["syntax"], text
    assert run("N0.5 G1 X1 F1\nN1. X2\nN 1 2 X3\nM2\n").errors == []


@pytest.mark.parametrize("does", [False, True])
def test_a_body_runs_the_same_in_every_way_of_calling_it(calls: Any, tmp_path: Path, does: bool) -> None:
    """Random O-words: the moves of each way are those of the others."""
    seed = random.SystemRandom().randrange(1 << 32)
    print(f"seed {seed}")
    dice = random.Random(seed)
    for _ in range(15):
        lines = body(dice, 0, does, True)
        moves = {}
        for name, text, called in ways([lines], "random_body", True):
            (tmp_path / "random_body.ngc").write_text(called)
            found = [
                x
                for x in calls(text, include=(tmp_path,), dialect="linuxcnc", block_delete=False)
                if "_FEED(" in x
            ]
            moves[name] = (
                found[: -len(found) // 2] if name in ("called in a loop", "called by a subroutine") else found
            )
        once = moves["called"]
        assert moves["called in a loop"] == once, f"seed {seed}: {lines}"
        for name in ("in the main program", "called with blanks and remarks", "called in a file"):
            # A body that RETURN may leave is not run in the main program.
            if name != "in the main program" or not any("return" in line for line in lines):
                assert moves[name] == once, f"seed {seed}, {name}: {lines}"
        # The first move of a profile leads to it.
        assert moves["as profiles"][: len(once) - 1] == once[1:], f"seed {seed}, as a profile: {lines}"

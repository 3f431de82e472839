"""The commands on STEP-NC files."""

import json
import math
import re
from pathlib import Path

import pytest

from cncgen.cli.app import run
from cncgen.stepnc import read, tree
from tests.stepnc import building
from tests.stepnc.building import E, Part, codes

PROGRAMS = Path(__file__).parents[2] / "programs"
NIST = PROGRAMS / "stepnc" / "nist_ex1.stp"


def test_tree_of_nists_example():
    lines = list(tree(NIST, "nist_ex1.stp"))
    assert lines[0].startswith("workplan 'MAIN WORKPLAN' (#2): 490 motions, ")
    assert lines[0].endswith(" mm rapid, 4:31 min")
    assert [line.split("'")[1] for line in lines[1:]] == [
        "WS FINISH PLANAR FACE1",
        "WS DRILL HOLE1",
        "WS REAM HOLE1",
        "WS ROUGH POCKET1",
        "WS FINISH POCKET1",
    ]
    expected = "drilling of round hole 'HOLE1 D=22MM', tool 'SPIRAL_DRILL_20MM' (twist drill 20 mm)"
    assert f"{expected}, 480, 720, 960 rev/min, feed 900, 1350, 1800 mm/min, 7 motions" in lines[2]


def test_tree_adds_up_length_and_time():
    """30 mm at 20 mm/s, and a dwell of 2 s; branches and functions are named."""
    part = Part()
    line = part.trajectory(part.polyline((0, 0, 0), (30, 0, 0)))
    wait = part.add("FEEDSTOP", E("T"), E("CONTACT"), None, None, None, 2.0)
    step = part.step(part.freeform(line, wait))
    choice = part.add("IF_STATEMENT", "choose", E("T"), part.add("PROGRAM_STOP", "halt"), None)
    alone = part.add("PARALLEL", "alone", (part.add("SET_MARK", "mark"),))
    part.project(part.plan(step, choice, alone))
    lines = list(tree(part.text().encode(), "t.stp"))
    assert lines[0].endswith(": 1 motion, 30.0 mm cut, 3.5 s")
    assert lines[1].endswith("3000 rev/min, feed 1200 mm/min, 1 motion, 30.0 mm cut, 3.5 s")
    assert [line.rpartition(" (#")[0] for line in lines[2:]] == [
        "  if 'choose'",
        "    program stop 'halt'",
        "  parallel 'alone'",
        "    set mark 'mark'",
    ]


def test_tree_measures_splines_and_names_assignments():
    """A quarter circle of 10 mm as a rational spline is 5 pi mm long, at 1 mm/s; 7300 mm take 2 h 1 min 40 s."""
    part = Part()
    refs = tuple(part.point(*p) for p in ((0, 0, 0), (10, 0, 0), (10, 10, 0)))
    quarter = part.complex(
        ("B_SPLINE_CURVE", (2, refs, E("CIRCULAR_ARC"), E("F"), E("F"))),
        ("B_SPLINE_CURVE_WITH_KNOTS", ((3, 3), (0.0, 1.0), E("UNSPECIFIED"))),
        ("RATIONAL_B_SPLINE_CURVE", ((1.0, math.sqrt(0.5), 1.0),)),
    )
    slow = part.technology(feed=0.001)
    curve = part.trajectory(quarter, technology=slow)
    line = part.trajectory(part.polyline((0, 0, 0), (7300, 0, 0)), technology=slow)
    count = part.add("NC_VARIABLE", "count", None)
    steps = [part.step(part.freeform(path)) for path in (curve, line)]
    part.project(part.plan(*steps, part.add("ASSIGNMENT", "", count, 2.0)))
    lines = list(tree(part.text().encode(), "t.stp"))
    assert lines[1].endswith(f"1 motion, {5 * math.pi:.1f} mm cut, {5 * math.pi:.1f} s")
    # Between the steps the tool goes back to the origin, 14.1 mm rapid.
    assert lines[2].endswith(", 7300.0 mm cut, 14.1 mm rapid, 2:01:40 h")
    assert lines[3].startswith("  assignment to count (#")


def test_a_feed_of_next_to_nothing_takes_endless():
    """Found by fuzzing: the time of the ways is infinite."""
    part = Part()
    line = part.trajectory(part.polyline((0, 0, 0), (1e6, 0, 0)), technology=part.technology(feed=1e-307))
    part.project(part.plan(part.step(part.freeform(line, line))))
    assert next(iter(tree(part.text().encode(), "t.stp"))).endswith(", endless")


def test_check_with_the_tree(capsys):
    assert run(["check", "--tree", str(NIST)]) == 0
    assert "workplan 'MAIN WORKPLAN'" in capsys.readouterr().out


def test_the_tree_as_json_says_what_the_text_says(capsys):
    """NIST's example: time and length of a workingstep are those of its line; a workplan's are the sums."""
    assert run(["check", "-q", "--json-tree", str(NIST)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["program"] == str(NIST)
    (plan,) = found["workplans"]
    assert (plan["kind"], plan["name"], plan["entity"], plan["motions"]) == (
        "workplan",
        "MAIN WORKPLAN",
        2,
        490,
    )
    drill = plan["children"][1]
    assert drill["tool"] == {"name": "SPIRAL_DRILL_20MM", "kind": "twist drill", "diameter_mm": 20.0}
    assert drill["feature"] == {"kind": "round hole", "name": "HOLE1 D=22MM"}
    assert drill["feeds_mm_min"] == [900.0, 1350.0, 1800.0]
    assert drill["speeds_rev_min"] == [480.0, 720.0, 960.0]
    for key in ("motions", "cut_mm", "rapid_mm", "time_s"):
        assert math.isclose(plan[key], sum(step[key] for step in plan["children"]), rel_tol=1e-12), key
    assert run(["check", "--tree", "--json-tree", str(NIST)]) == 2
    assert run(["check", "-q", "--json-tree", str(PROGRAMS / "circle.nc")]) == 0
    assert capsys.readouterr().out == ""


def test_faults_end_in_exit_code_1(tmp_path, capsys):
    broken = tmp_path / "broken.stp"
    content = NIST.read_bytes().replace(b"#95,#96,#97", b"#95,#999,#97")
    broken.write_bytes(content)
    line = content[: content.index(b"#999")].count(b"\n") + 1
    assert run(["check", str(broken)]) == 1
    said = capsys.readouterr().err
    assert f"broken.stp:{line}:38: error[part21-dangling]" in said
    # The executor comes to the same reference, and says nothing new.
    assert said.count("part21-dangling") == 1


def test_convert_there_and_back(tmp_path):
    gcode, stepnc = tmp_path / "part.ngc", tmp_path / "heart.stp"
    assert run(["convert", str(NIST), "-o", str(gcode)]) == 0
    text = gcode.read_text()
    assert "(#19 PLANE_FINISH_MILLING)" in text
    assert "(T1: MILL 18MM)" in text
    assert run(["convert", str(PROGRAMS / "heart.nc"), "-o", str(stepnc)]) == 0
    path = next(iter(read(stepnc, "heart.stp").chunks()))
    assert len(path.nurbs) > 0
    assert run(["convert", str(stepnc), "--linearize", "0.01", "-o", str(tmp_path / "lines.nc")]) == 0
    assert "G6.2" not in (tmp_path / "lines.nc").read_text()


def test_what_a_broken_program_leaves(tmp_path):
    """Nothing: the output is written whole or not at all."""
    broken = tmp_path / "broken.stp"
    broken.write_bytes(NIST.read_bytes()[:5000])
    assert run(["convert", str(broken), "-o", str(tmp_path / "out.ngc")]) == 1
    assert not (tmp_path / "out.ngc").exists()


def test_a_tool_table_gives_the_lengths_that_nists_interpreter_had(tmp_path, capsys):
    """With NIST's tools in LinuxCNC's format, in mm or inches, all 537 lines are the same."""
    table = tmp_path / "tools.tbl"
    for unit, options in ((1.0, ["--table-units", "mm"]), (25.4, [])):
        z = [f"{length / unit:.12f}" for length in (50, 70, 50)]
        table.write_text(
            f"; tools\nT3 P3 Z{z[0]} D18 ; MILL 18MM\nT4 P4 Z{z[1]} D20 ; spiral_drill_20mm\n"
            f"T6 P6 Z+{z[2]} D22;REAMER_22MM\n"
        )
        assert run(["canon", "--tool-table", str(table), *options, str(NIST)]) == 0
        assert capsys.readouterr().out == NIST.with_suffix(".can").read_text()


def test_a_tool_that_the_table_does_not_have_and_lines_that_are_wrong(tmp_path, capsys):
    table = tmp_path / "tools.tbl"
    table.write_text("T3 P3 Z50 D18 ; MILL 18MM\n")
    assert run(["check", "--tool-table", str(table), str(NIST)]) == 0
    assert capsys.readouterr().err.count("warning[stepnc-tool-table]") == 2
    table.write_text("T3 Z50\nnonsense\nZ1\n")
    assert run(["check", "--tool-table", str(table), str(NIST)]) == 2
    said = capsys.readouterr().err
    assert re.findall(r"tools\.tbl:(\d+):.*error\[tool-table\]", said) == ["2", "3"]
    assert run(["check", "--tool-table", str(tmp_path / "none.tbl"), str(NIST)]) == 2


@pytest.mark.parametrize(
    "command",
    [
        ("check",),
        ("check", "--tree"),
        ("canon",),
        ("convert",),
        ("plan", "--format", "csv"),
        ("cut", "--cell", "2"),
    ],
)
def test_programs_from_standard_input_are_those_of_the_file(command, cncgen, programs):
    path = programs / "stepnc" / "features.stp"
    from_file = cncgen(*command, path)
    from_input = cncgen(*command, "-", stdin=path.read_bytes())
    assert from_file.returncode == from_input.returncode == 0, from_input.stderr
    if command[0] == "convert":  # names of entities are those of a file, which can be read again
        lines = [
            [r for r in o.stdout.splitlines() if not r.startswith(b"(")] for o in (from_file, from_input)
        ]
        assert lines[0] == lines[1]
    elif command[0] in ("canon", "plan"):
        assert from_input.stdout == from_file.stdout != b""


def test_three_independent_faults_are_told_in_one_run():
    """A radius of 5 mm with an end 7 mm from its centre, a negative feed, and a toolpath without a feed, each in its own step."""
    part = Part()
    bad = part.add("MILLING_TECHNOLOGY", -0.02, E("TCP"), None, -50.0, None, E("F"), E("F"), E("F"), None)
    line = part.polyline((0, 0, 0), (10, 0, 0))
    arc = part.trimmed(part.circle(5.0), (5, 0, 0), (0, 7, 0))
    operations = [
        part.freeform(part.trajectory(line), technology=bad),
        part.freeform(part.trajectory(arc)),
        part.freeform(part.trajectory(line), technology=None),
    ]
    part.project(part.plan(*map(part.step, operations)))
    text = part.text().replace("DATA;", "DATA;\n#900=CARTESIAN_POINT('',(0.,0.,0.);\n", 1)
    found = building.run(text)[1]
    assert codes(found, "error") == ["part21-syntax", "stepnc-speed", "arc-radius", "stepnc-no-feed"]

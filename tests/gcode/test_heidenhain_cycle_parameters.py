"""What cycles of Heidenhain's plain language take: parameters that are read, that change nothing, and that are told.

The rows of `cycles.ROWS` are held against the parameters that each cycle looks at while it runs.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.gcode.klartext import contour_cycles, cycles

Run = Callable[..., Any]
#: Values with which each cycle runs, those of several steps and ends among them.
USUAL: dict[int, float] = {
    1: -4, 2: 1, 3: 0.5, 4: 0.2, 5: 0, 6: 2, 7: 50, 8: 1, 9: 1, 10: 2, 11: 100, 12: 400, 13: 1, 14: 0.1, 15: 0,
    200: 2, 201: -10, 202: 3, 203: 0, 204: 20, 205: 1, 206: 100, 207: 200, 208: 300, 209: 250, 210: 0.1, 211: 0.2, 212: 0.5, 213: 1, 214: 1, 215: 0,
    216: 50, 217: 60, 218: 60, 219: 24, 220: 9, 221: 1, 222: 40, 223: 30, 224: 10, 225: 1, 226: 2, 227: 0, 228: 60, 229: 3, 230: 1, 231: 61, 232: 40, 233: 2,
    234: 2, 235: 41, 236: 3, 237: 30, 238: 20, 239: 1.5, 240: 4, 241: 3, 242: 2, 243: 2, 244: 80, 245: 0, 246: 300, 247: 30, 248: 40, 249: 3, 250: 10,
    251: 2, 252: 3, 253: 500, 254: 150, 255: 0.1, 256: 0.2, 257: 2, 258: 1, 259: 0.5, 301: 1, 334: 2, 335: 30, 338: 4, 343: 1, 344: 4, 347: 0, 348: 0,
    349: 0, 350: 1, 351: 1, 355: 2, 356: -5, 357: 0.5, 358: -1, 359: 0.5, 360: 0, 365: 1, 367: 0, 368: 0.5, 369: 0.3, 370: 1, 374: 10, 375: 90, 376: 5,
    377: 2, 378: 90, 379: 3, 385: 150, 386: -2, 389: 0, 390: 1, 391: 1, 392: 5, 393: 90, 394: 5, 401: 80, 403: 2, 424: 70, 425: 40, 426: 3, 427: 100, 428: 500,
    435: 5, 436: 1, 437: 0, 512: 100, 513: 8, 514: 0.8, 516: 0, 571: 30, 572: 6, 573: 1, 574: 90,
}  # fmt: skip
#: Values beside those with which the rest is read.
OTHERS: dict[int, list[dict[int, float]]] = {
    208: [],
    200: [],
    240: [{343: 0}],
    251: [{220: 12}],
    270: [{390: 2}, {390: 0}],
}
SQUARE = "LBL 1\nL X+0 Y+0 RL\nL X+60\nL Y+60\nL X+0\nL Y+0\nLBL 0"
OPEN = "LBL 1\nL X+0 Y+0 RL\nL X+60\nLBL 0"


class Watched(array):  # type: ignore[type-arg]
    """Parameters that note which are looked at."""

    seen: set[int]

    def __getitem__(self, number: Any) -> Any:
        self.seen.add(number)
        return super().__getitem__(number)


def definition(number: int, values: dict[int, float]) -> str:
    """Return the CYCL DEF of a cycle with all that it reads, as USUAL has it but for some values."""
    numbers = [int(one) for one in cycles.ROWS[number].reads.split()]
    given = [f" Q{one}={values.get(one, USUAL[one]):g}" for one in numbers]
    text = ' QS500="AB" ~\n' if number == 225 else ""
    return f"CYCL DEF {number} C ~\n{text}" + " ~\n".join(given) + "\n"


def program(number: int, values: dict[int, float]) -> str:
    """Return a program that runs a cycle."""
    before = "TOOL CALL 1 Z S1000 F300\nL X+0 Y+0 Z+50 R0 FMAX M3\n"
    contour, call = "", "CYCL CALL\n"
    if number < 26 or number in (contour_cycles.WAYS, 275):
        contour = OPEN if number in (25, contour_cycles.WAYS, 275) else SQUARE
        before += "CYCL DEF 14.0 CONTOUR\nCYCL DEF 14.1 CONTOUR LABEL 1\n"
        if number != 20:
            before += definition(20, {})
    body = definition(number, values)
    if number == 20:
        body += "".join(f"{definition(own, values)}{call}" for own in (22, 24))
    elif number == contour_cycles.WAYS:
        body += definition(25, {})
    elif number in cycles.PATTERNS:
        # No CYCL CALL: they run at once.
        before, call = before + definition(201, {}), ""
    return f"0 BEGIN PGM A MM\n{before}{body}{call}M30\n{contour}\nEND PGM A MM\n"


@pytest.fixture
def seen(monkeypatch: pytest.MonkeyPatch) -> set[int]:
    """Return the numbers of the parameters that cycles look at."""
    found = set[int]()

    def watching(run: Callable[..., None]) -> Callable[..., None]:
        def watched(ip: Any, *given: Any) -> None:
            plain = ip.parameters.numbers
            ip.parameters.numbers = Watched("d", plain)
            ip.parameters.numbers.seen = found
            try:
                run(ip, *given)
            finally:
                ip.parameters.numbers = plain

        return watched

    monkeypatch.setattr(cycles, "call", watching(cycles.call))
    monkeypatch.setattr(cycles, "pattern", watching(cycles.pattern))
    return found


@pytest.fixture
def tools(tmp_path: Path) -> Path:
    table = tmp_path / "t.tbl"
    table.write_text("T1 P1 Z0 D8\n")
    return table


@pytest.mark.parametrize("number", cycles.ROWS)
def test_a_row_has_what_its_cycle_reads(run: Run, seen: set[int], tools: Path, number: int) -> None:
    for values in ({}, *OTHERS.get(number, [])):
        out = run(program(number, values), dialect="heidenhain", tool_table=tools)
        assert out.errors == []
        told = [d.message for d in out.diagnostics if d.code == "cycle-parameters"]
        assert [message for message in told if "printed manual" not in message] == []
    row = cycles.ROWS[number]
    reads = {int(one) for one in row.reads.split()}
    shared = {201} | row.told.keys() | row.lacking.keys()
    if number < 26 or number in (contour_cycles.WAYS, *cycles.PATTERNS):
        # Those of the data beside them, and of the cycle that a pattern runs.
        for other in (20, 22, 24, 25, 201):
            shared |= {int(one) for one in cycles.ROWS[other].reads.split()} | cycles.ROWS[other].told.keys()
    assert reads <= seen
    assert seen - reads <= shared


def told(run: Run, body: str, tools: Path, behind: str = "") -> list[tuple[str, str]]:
    """Return code and message of the warnings of some lines."""
    text = f"0 BEGIN PGM A MM\nTOOL CALL 1 Z S1000 F300\nL X+0 Y+0 Z+50 R0 FMAX M3\n{body}M30\n{behind}\nEND PGM A MM\n"
    out = run(text, dialect="heidenhain", tool_table=tools)
    assert out.errors == []
    return [(d.code, d.message) for d in out.diagnostics if d.severity == "warning"]


def test_a_parameter_that_a_cycle_has_not_is_told(run: Run, tools: Path) -> None:
    found = told(run, definition(201, {}).rstrip() + " ~\n Q777=+5\nCYCL CALL\n", tools)
    assert found == [("cycle-parameters", "cycle 201 has no Q777 = 5 here: it is made as without")]


def test_a_parameter_that_is_left_out_is_told(run: Run, tools: Path) -> None:
    """The control stops there: CYCL DEF is incomplete."""
    body = definition(201, {}).replace(" Q208=300 ~\n", "") + "CYCL CALL\n"
    message = "cycle 201 is given without Q208: the values in force are taken, Q208 = 0"
    assert told(run, body, tools) == [("cycle-parameters", message)]


@pytest.mark.parametrize(
    ("number", "given", "what"),
    [
        (251, "Q366=+1", "the tool plunges straight down at Q206"),
        (252, "Q439=+3", "F is the feed of the tool's centre"),
        (208, "Q370=+1.2", "one helix along the wall mills the hole"),
        (240, "Q342=+4", "the tool centres from the surface on"),
        (22, "Q19=+150", "the tool plunges straight down at Q11"),
        (22, "Q401=+80", "F stays Q12 where the tool cuts its whole width"),
    ],
)
def test_a_value_that_is_not_read_is_told(run: Run, tools: Path, number: int, given: str, what: str) -> None:
    """All were passed over without a word."""
    name, value = given.split("=+")
    text = program(number, {343: 0}).split("M3\n", 1)[1]
    body, behind = text.split("M30\n")
    neutral = {"Q401": "100"}.get(name, "0")
    body = (
        body.replace("CYCL CALL", f" {name}=+{{}}\nCYCL CALL", 1)
        .replace("\n Q", " ~\n Q")
        .replace(" ~ ~", " ~")
    )
    contour = behind.split("\nEND")[0]
    assert told(run, body.format(neutral), tools, contour) == []
    message = f"{name} = {float(value):g} of cycle {number} is not read: {what}"
    assert told(run, body.format(value), tools, contour) == [("cycle-parameters", message)]


@pytest.mark.parametrize(("given", "up"), [(9999.0, 9999.0), (0.0, 400.0), (99999.0, 0.0)])
def test_rough_out_rises_at_q208(run: Run, tools: Path, given: float, up: float) -> None:
    """ "Retraction feed rate": 0 is Q12; it was a traverse always."""
    out = run(program(22, {208: given}), dialect="heidenhain", tool_table=tools)
    assert out.errors == []
    moves = out.path.kind < 3
    z, feeds = out.path.end[moves, 2], out.path.feed[moves] * 60.0
    rises = [k for k in range(1, len(z)) if z[k] > z[k - 1] and z[k] == 2.0]
    # Feeds of traverses are NaN.
    assert {round(float(np.nan_to_num(feeds[k])), 3) for k in rises} == {up}


def _levels(run: Run, tools: Path, number: int, values: dict[int, float]) -> list[tuple[float, float]]:
    """Return the heights at which a cycle cuts in the plane, and the feeds there, each once."""
    out = run(program(number, values), dialect="heidenhain", tool_table=tools)
    assert out.errors == []
    moves = out.path.kind < 3
    end, feed = out.path.end[moves, :3], out.path.feed[moves] * 60.0
    cuts = [
        k
        for k in range(1, len(end))
        if feed[k] > 0.0 and (end[k, :2] != end[k - 1, :2]).any() and end[k, 2] <= 0.0
    ]
    return list(dict.fromkeys((round(float(end[k, 2]), 6), round(float(feed[k]), 6)) for k in cuts))


@pytest.mark.parametrize(
    ("kind", "levels"), [(0, [(-1.7, 200), (-2, 150)]), (1, [(-1.7, 200)]), (2, [(-2, 150)])]
)
def test_a_face_is_roughed_and_finished_as_q215_says(run: Run, tools: Path, kind: int, levels: Any) -> None:
    """233: Q386 = -2 with the allowance Q369 = 0.3; Q215 was passed over, and each face finished."""
    assert _levels(run, tools, 233, {215: kind, 389: 1}) == levels


def test_a_stud_is_finished_where_q215_says(run: Run, tools: Path) -> None:
    """256: roughed to 0.3 above -10 in infeeds of 3, the floor and then the wall, in infeeds of 4, at Q385; Q215 was passed over and Q368 left."""
    rough = [(-3, 200), (-6, 200), (-9, 200), (-9.7, 200)]
    finish = [(-10, 150), (-4, 150), (-8, 150)]
    assert _levels(run, tools, 256, {215: 1}) == rough
    assert _levels(run, tools, 256, {215: 2}) == finish
    assert _levels(run, tools, 256, {}) == [*rough, *finish]
    # The wall of a stud 60 long lies at 30, a tool of radius 4 beside it at 34, with the allowance of 0.5 at 34.5.
    for kind, reach in ((1, 34.5), (2, 34.0)):
        out = run(program(256, {215: kind, 224: 0}), dialect="heidenhain", tool_table=tools)
        deep = out.path.end[(out.path.kind == 1) & (out.path.end[:, 2] < -3.5)]
        assert abs(deep[:, 0]).min() <= deep[:, 0].max()
        assert round(float(-deep[:, 0].min()), 6) >= reach
        assert reach in {round(float(-x), 6) for x in deep[:, 0]}


def test_what_another_cycle_has_set_is_not_taken(run: Run, tools: Path) -> None:
    """265 has no Q512, the feed of the way to the wall; it took that of a 262 before it."""
    body = definition(262, {512: 77}) + "CYCL CALL\n" + definition(265, {}) + "CYCL CALL\n"
    text = f"0 BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+50 R0 FMAX M3\n{body}END PGM A MM\n"
    out = run(text, dialect="heidenhain", tool_table=tools)
    assert out.errors == []
    slow = out.path.line[(out.path.feed * 60.0).round(6) == 77.0]
    assert len(slow) > 0
    assert slow.max() < text[: text.index("CYCL DEF 265")].count("\n") + 1


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (
            "CYCL DEF 1.0 PECKING\nCYCL DEF 1.6 F200",
            "cycle 1 has the parts 1.1 to 1.5, and 1.6 is none of them",
        ),
        (
            "CYCL DEF 1.0 PECKING\nCYCL DEF 2.1 SETUP 2",
            "CYCL DEF 2.1 is no part of the cycle that was defined",
        ),
        ("CYCL DEF 1.0 PECKING\nCYCL DEF 1.1 SETUP 2 F50", "F 50 of CYCL DEF 1.1 SETUP is not read"),
        ("CYCL DEF 200.1 Q200=2", "CYCL DEF 200.1 is no part of the cycle that was defined"),
    ],
)
def test_parts_that_a_cycle_has_not_are_errors(run: Run, lines: str, message: str) -> None:
    """They were passed over without a word."""
    out = run(f"0 BEGIN PGM A MM\nTOOL CALL 1 Z S1000\n{lines}\nEND PGM A MM\n", dialect="heidenhain")
    assert [d.message for d in out.diagnostics if d.severity == "error"] == [message]


@pytest.mark.parametrize(
    ("lines", "what"),
    [
        ("CYCL DEF 8.0 MIRROR\nCYCL DEF 8.1 X A", "A of cycle 8 is not read"),
        ("CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 S+10", "S of cycle 7 is not read"),
        ("CYCL DEF 10.0 ROT\nCYCL DEF 10.1 ROT+30 X+2", "X of cycle 10 is not read"),
        ("CYCL DEF 26.0 AXIS\nCYCL DEF 26.1 A2 X2", "A of cycle 26 is not read"),
    ],
)
def test_frames_of_other_axes_are_errors(run: Run, lines: str, what: str) -> None:
    """They were passed over without a word, and the axes went where the program says without the shift."""
    out = run(
        f"0 BEGIN PGM A MM\nTOOL CALL 1 Z S1000\n{lines}\nL X+5 FMAX\nEND PGM A MM\n", dialect="heidenhain"
    )
    assert [(d.code, d.message) for d in out.diagnostics if d.severity == "error"] == [("not-read", what)]


def test_shifts_of_other_axes_by_nothing_are_read(run: Run) -> None:
    """Posts end a shift with 0 of all axes."""
    lines = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+0 Y+0\nCYCL DEF 7.2 A+0 C+0\nCYCL DEF 26.0 AXIS\nCYCL DEF 26.1 X1 B1"
    out = run(f"0 BEGIN PGM A MM\n{lines}\nL X+5 FMAX\nEND PGM A MM\n", dialect="heidenhain")
    assert out.errors == []


@pytest.mark.parametrize(
    ("code", "said"), [("M104", "error"), ("M142", "error"), ("M160", "warning"), ("M101", None)]
)
def test_functions_from_100_on(run: Run, code: str, said: str | None) -> None:
    """Of these M101 is the control's own and changes no motion, M160 the builder's; all were taken without a word."""
    out = run(f"0 BEGIN PGM A MM\nL X+5 FMAX {code}\nEND PGM A MM\n", dialect="heidenhain")
    assert [d.severity.value for d in out.diagnostics if d.severity != "note"] == ([said] if said else [])


def test_a_pattern_runs_a_cycle_of_parts(run: Run) -> None:
    """The parts of a cycle stay those of the calls of 220 behind it."""
    lines = (
        "CYCL DEF 2.0 TAPPING\nCYCL DEF 2.1 SETUP 1\nCYCL DEF 2.2 DEPTH -18\nCYCL DEF 2.3 DWELL 0\nCYCL DEF 2.4 F100\n"
        + definition(220, {})
    )
    out = run(
        f"0 BEGIN PGM A MM\nTOOL CALL 1 Z S100\nL Z+1 FMAX M3\n{lines}END PGM A MM\n", dialect="heidenhain"
    )
    assert out.errors == []
    assert out.path.end[out.path.kind < 3][:, 2].min() == -18


@pytest.mark.parametrize("line", ["TOOL CALL 1.2 Z S100", "TOOL DEF 1.2 L+30 R+3\nTOOL CALL 1 Z S100"])
def test_an_index_of_a_tool_is_told(run: Run, tmp_path: Path, line: str) -> None:
    """It was taken for the tool without a word, and its TOOL DEF gave the sizes of the tool."""
    table = tmp_path / "t.tbl"
    table.write_text("T1 P1 Z20 D8\n")
    out = run(f"0 BEGIN PGM A MM\n{line}\nL Z+1 FMAX\nEND PGM A MM\n", dialect="heidenhain", tool_table=table)
    assert out.errors == []
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == ["tool-index"]
    assert out.path.end[out.path.kind < 3][-1, 2] == 21


@pytest.mark.parametrize(
    "ends",
    ["CYCL DEF 7.0 DATUM\nCYCL DEF 7.1 A+0 W+0", "TRANS DATUM RESET", "CYCL DEF 247 DATUM ~\n Q339=+1"],
)
def test_rotary_axes_have_datums(run: Run, ends: str) -> None:
    """A shift of A was passed over without a word. A+5 from a datum at 10, and 2 further, is at 15 and 17, and X as it says."""
    lines = "CYCL DEF 7.0 DATUM\nCYCL DEF 7.1 A+10 W+3\nL X+5 A+5 W+1 FMAX\nCYCL DEF 7.0 DATUM\nCYCL DEF 7.1 IA+2\nL A+5 FMAX\n"
    out = run(f"0 BEGIN PGM A MM\n{lines}{ends}\nL A+5 W+1 FMAX\nEND PGM A MM\n", dialect="heidenhain")
    assert out.errors == []
    columns = [out.axes.index(axis) for axis in "XAW"]
    found = out.path.end[out.path.kind < 3][:, columns]
    found[:, 1] = np.degrees(found[:, 1])
    assert found.round(6).tolist() == [[5, 15, 4], [5, 17, 4], [5, 5, 1]]

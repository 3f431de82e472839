"""Lines that are computed while they are read give what the grammar and the compiler give, and wait for nobody who asks."""

from __future__ import annotations

import math
import random
from array import array
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.diagnostics import Diagnostics
from cncgen.gcode import canon
from cncgen.gcode.block import evaluate
from cncgen.gcode.budget import PAUSE
from cncgen.gcode.codes.table import table
from cncgen.gcode.errors import BlockError
from cncgen.gcode.flow.line_by_line import LineRunner
from cncgen.gcode.flow.running import Runner
from cncgen.gcode.sinks.counting import CountingSink
from cncgen.gcode.sinks.printing import PrintingSink
from cncgen.gcode.source import Source
from cncgen.gcode.state.parameters import Parameters
from cncgen.gcode.state.predefined import NAMED
from cncgen.gcode.text import grammar
from cncgen.gcode.text.lanes import PlainBlocks
from cncgen.gcode.text.parsers import STORED, new_parser
from cncgen.kernels import gcode_arithmetic, gcode_run, gcode_scan, gcode_store
from cncgen.toolpath.reading import ReadOptions
from trials.generators.gcode_bodies import body, ways
from trials.generators.macro_programs import MacroProgram
from trials.peer_cases import peer_cases

from ..kernels.plain import uncompiled
from .reference import OneByOne
from .test_blocks import ITEMS, SIGNS, VALUES

ROOT = Path(__file__).resolve().parent.parent.parent


def parameters() -> Parameters:
    """Return parameters with some values, and no machine."""
    made = Parameters(SimpleNamespace(dialect="linuxcnc"))  # type: ignore[arg-type]
    made.numbers[:40] = array("d", [0.37 * k - 2.0 for k in range(40)])
    made.numbers[9] = 12.0
    made.local, made.named = {"a": 2.5, "longname": -1.0}, {"_g": 4.0, "_value": 3.0}
    return made


def computed(
    text: str, kernel: Any = gcode_run, store: Any = gcode_store
) -> tuple[Parameters, list[Any], int]:
    """Run the kernel over lines; return the parameters, the words of each block, and where it stopped."""
    data, plain, made = text.encode(), PlainBlocks(), parameters()
    computer = kernel.Computer(
        memoryview(data),
        new_parser("linuxcnc"),
        store.Store(made.numbers, made.named, frozenset(NAMED), STORED["linuxcnc"]),
        plain.columns(),
        lambda letter, number: bool((row := table("linuxcnc").get((letter, 10 * number))) and row.waits),
        PAUSE,
    )
    end = computer.run(0, 1, made.local)
    blocks = [(plain.line[k], plain.flags[k], plain.pairs(k)) for k in range(computer.blocks)]
    return made, blocks, end


def described(line: str) -> tuple[Parameters, list[tuple[str, float]]]:
    """Return the parameters after a line, and its words, by the grammar: all values are read before any is set."""
    made = parameters()
    parsed = grammar.parse(line)
    assert parsed.flow is None
    words = [(letter, evaluate(value, made)) for letter, value in parsed.words]
    settings = [
        (target if isinstance(target, str) else evaluate(target, made), evaluate(value, made))
        for target, value in parsed.settings
    ]
    for target, value in settings:
        if isinstance(target, str):
            made.set_name(target, value)
        else:
            made.set_number(target, value)
    return made, words


def agree(line: str) -> bool:
    """Hold a line that the kernel takes against the grammar; tell whether it takes it."""
    found, blocks, end = computed(line)
    if end == 0:
        assert found.numbers == parameters().numbers
        assert not blocks
        return False
    wanted, words = described(line)
    assert [pairs for *_, pairs in blocks] == ([words] if words or blocks else [])
    assert (found.numbers, found.local, found.named) == (wanted.numbers, wanted.local, wanted.named)
    return True


@pytest.mark.parametrize(
    "line",
    [
        "G1 X[#1 + 2] Y-#2 F[100 * 3] (pass 1)",
        "n10 g1x[-2**2]y[2--3]z- - 3",
        "#1 = 5 #2 = [#1 * 2] #<b> = #<a> X#1",
        "##9 = 3",
        "#[1 + 1] = [7 MOD -4]",
        "#< Long Name > = [#<longname> / 3] ; tail",
        "X[SIN[30] + COS[60] * TAN[45]] Y[ATAN[1]/[-1]] Z[ASIN[0.5] + ACOS[0.5]]",
        "X[1 lt 2 and 3 ge 3 xor 1.00005 eq 1] Y[0 or 1 ne 2]",
        "X[FIX[-1.5] + FUP[1.2] + ROUND[2.5] + ABS[-3] + SQRT[2] + LN[3] + EXP[0.5]]",
        "#3 = #<_value> M3 G4 S100",
        "  (a remark)",
        "#31 = [2 ** 0.5 - 1 - 1 * 4 / 2]",
        "X[1 2] Y0.1234567890123456789",
        "X" + "[" * 80 + "1" + "]" * 80,
    ],
)
def test_lines_that_are_computed(line: str) -> None:
    assert agree(line)


@pytest.mark.parametrize(
    "line",
    [
        *("X[1 / 0]", "X#<none>", "X#<_x>", "X#5420", "#5221 = 1", "#<_x> = 1", "X[SQRT[-1]]", "X[LN[0]]", "X[0 ** -1]"),
        *("X1 X2", "X1e3", "G10 L2 P1 X#1", "M6", "T1", "o1 sub", "%", "/X1", "(MSG, hi)", "X1 (debug,#1)", "(logclose)"),
        *("X1 2.5.3", "X[1", "X[1]]", "#1 = ", "#1.5 = 2", "#0 = 1", "X@1", "X[EXP[1000]]", "X2000000000", "X[ASIN[2]]"),
        *("N#1 X1", "X[BIN[3]]", "X" + "[1+" * 120 + "1" + "]" * 120, "X12345678901234567890", "M2", "G28 X#1"),
    ],
)  # fmt: skip
def test_lines_that_are_left_to_others(line: str) -> None:
    found, blocks, end = computed(line)
    assert (end, blocks, found.numbers) == (0, [], parameters().numbers)


WORDS = st.builds("{}{}{}".format, st.sampled_from("XYZFIJKRSg"), SIGNS, VALUES)
SETTINGS = st.builds("#{} = {}{}".format, st.sampled_from(["1", "<a>", "#2", "[1+1]", "<_g>"]), SIGNS, VALUES)
LINES = st.lists(st.one_of(WORDS, SETTINGS, ITEMS), min_size=1, max_size=4).map(" ".join)


@given(LINES)
def test_generated_lines_agree_with_the_grammar(line: str) -> None:
    try:
        agree(line)
    except BlockError as error:
        raise AssertionError(f"the kernel takes a line that is wrong: {error.message}") from error


@given(st.lists(LINES, min_size=1, max_size=4).map("\n".join))
def test_the_kernel_runs_uncompiled(text: str) -> None:
    compiled, plain = computed(text), computed(text, PLAIN, PLAIN_STORE)
    assert compiled[1:] == plain[1:]
    assert (compiled[0].numbers, compiled[0].local) == (plain[0].numbers, plain[0].local)


PLAIN = uncompiled(
    "gcode_run",
    "gcode_frames",
    "gcode_rows",
    "gcode_store",
    "language_store",
    "gcode_instructions",
    "gcode_jumps",
)
PLAIN_STORE = uncompiled("gcode_store")


def test_lines_of_programs_agree_with_the_grammar() -> None:
    lines = {line for case in peer_cases() for line in case.program.split("\n")}
    taken = sum(agree(line) for line in lines if line.strip())
    assert taken > 500


@pytest.mark.parametrize(
    "degrees", [0, 30, 45, 60, 90, 120, 135, 150, 180, 210, 225, 270, 300, 315, 330, 360, -30]
)
def test_angles_of_known_values_are_exact(degrees: int) -> None:
    sine = {0: 0.0, 30: 0.5, 90: 1.0, 150: 0.5, 180: 0.0, 210: -0.5, 270: -1.0, 330: -0.5}.get(degrees % 360)
    cosine = {60: 0.5, 120: -0.5, 180: -1.0, 240: -0.5, 300: 0.5, 0: 1.0}.get(degrees % 360)
    if sine is not None:
        assert gcode_arithmetic.sine(degrees) == sine or (
            sine == 0.0 and abs(gcode_arithmetic.sine(degrees)) < 1e-30
        )
    if cosine is not None:
        assert gcode_arithmetic.cosine(degrees) == cosine
    if degrees % 180 == 45:
        assert gcode_arithmetic.tangent(degrees) == 1.0
    assert gcode_arithmetic.arc_sine(gcode_arithmetic.sine(30)) == 30.0
    assert gcode_arithmetic.arc_cosine(-0.5) == 120.0


@given(st.floats(-1e6, 1e6))
def test_angles_are_those_of_the_library_to_an_ulp_or_the_angle_s_rounding(a: float) -> None:
    """The library's functions of the rounded radians are off by the rounding, half an ulp of them."""
    slack = math.ulp(math.radians(a)) + 2.0 * math.ulp(1.0)
    assert abs(gcode_arithmetic.sine(a) - math.sin(math.radians(a))) <= slack
    assert abs(gcode_arithmetic.cosine(a) - math.cos(math.radians(a))) <= slack


def count_of(text: str, *, batches: bool, dialect: str = "linuxcnc") -> tuple[int, list[str]]:
    """Count the motions of a program and list what is said about it."""
    sink, found = CountingSink(), Diagnostics()
    runner = (Runner if batches else OneByOne)(
        Source(text.encode(), "t"), ReadOptions(dialect=dialect), sink, found
    )
    for _ in runner.run():
        pass
    return sink.count, [diagnostic.render() for diagnostic in found]


@pytest.mark.parametrize(
    "text",
    [
        # Where the machine is decides how often a loop runs.
        "F100\no1 while [#5420 lt 5]\nG91 G1 X[1 + 0]\no1 endwhile\nM2\n",
        "F100\no1 do\nG91 G1 X1\no2 if [0]\no2 elseif [#<_x> gt 3]\no1 break\no2 endif\no1 while [1]\nM2\n",
        # A subroutine that puts the modal state back.
        "F100\no1 sub\nM73\nG91\nG1 X#1\no1 endsub\no1 call [3]\no1 call [4]\nG1 X[1 + 1]\nM2\n",
        # A wrong block among those that wait.
        "F100\n#1 = 0\no1 while [#1 lt 3]\nG1 X[#1]\nG2 X[#1 + 1] R0.1\n#1 = [#1 + 1]\no1 endwhile\nM2\n",
        # A value that is not there.
        "F100\no1 repeat [3]\nG1 X[#1]\n#1 = [1 / [#1 - 1]]\no1 endrepeat\nG1 X#1\nM2\n",
        # Arguments, values that come back, other words on the way.
        "F100\no1 sub\nG1 X#1\nM8\no1 endsub [#1 * 2]\no1 call [1]\no1 call [#<_value> + 1]\nG1 Y#<_value>\nM2\n",
    ],
)
def test_blocks_that_wait_change_nothing(text: str) -> None:
    assert count_of(text, batches=True) == count_of(text, batches=False)


def test_calls_come_in_the_order_of_the_program(tmp_path: Path) -> None:
    """Of a loop with motions that wait, and blocks that let them go."""
    text = "F100\n#1 = 0\no1 while [#1 lt 2]\nG1 X#1\n#1 = [#1 + 1]\nG1 Y[#1]\nM8\no1 endwhile\nM2\n"
    program = tmp_path / "order.ngc"
    program.write_text(text)
    calls = [line.split(maxsplit=2)[-1] for line in canon(program, "order.ngc")]
    begin = calls.index("SET_FEED_RATE(100.0000)")
    assert calls[begin + 1 : begin + 7] == [
        "STRAIGHT_FEED(0.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)",
        "STRAIGHT_FEED(0.0000, 1.0000, 0.0000, 0.0000, 0.0000, 0.0000)",
        "FLOOD_ON()",
        "STRAIGHT_FEED(1.0000, 1.0000, 0.0000, 0.0000, 0.0000, 0.0000)",
        "STRAIGHT_FEED(1.0000, 2.0000, 0.0000, 0.0000, 0.0000, 0.0000)",
        "FLOOD_ON()",
    ]


def printed(text: str, *, batches: bool, dialect: str = "linuxcnc") -> list[str]:
    """Return the canonical calls of a program, with lines, and what is said about it."""
    source, found = Source(text.encode(), "t"), Diagnostics()
    sink = PrintingSink(lambda index, offset: source.text_at(offset))
    for _ in (Runner if batches else OneByOne)(source, ReadOptions(dialect=dialect), sink, found).run():
        pass
    return [*sink.take(), *(diagnostic.render() for diagnostic in found)]


#: O-words whose labels stand twice, cross, are missing, are computed, or whose keywords are wrong.
ODD = [
    "o1 if [#1]\nG1 X1\no1 endif\no1 if [1]\nG1 X2\no1 endif",
    "o1 if [0]\no2 if [1]\nG1 X1\no1 endif\nG1 X2\no2 endif",
    "o1 if [0]\nG1 X1\no1 elseif [1]\nG1 X2\no1 else\nG1 X3\nG1 X4",
    "o1 else\nG1 X1\no1 endif",
    "o1 sub\no1 if [#1]\nG1 X#1\no1 return [5]\no1 endif\nG1 Y1\no1 endsub\no1 call [2]\no1 call\nG1 Z#<_value>",
    "o1 sub\nG1 X1\no2 endsub\no1 call",
    "o1 call\no1 sub\nG1 X1\no1 endsub\no1 sub\nG1 X2\no1 endsub\no1 call",
    "o1 do\n#1=[#1+1]\no1 while [#1 lt 3]\no1 do\nG1 X1\no1 while [0]",
    "o1 do\nG1 X1\no1 endwhile\no1 while [0]",
    "o1 repeat [2.4]\nG1 X1\no2 repeat [-1]\nG1 X2\no2 endrepeat\no1 endrepeat",
    "o1 repeat [3]\nG1 X1\no2 repeat [2]\no1 continue\no2 endrepeat\no1 endrepeat",
    "o1 while [#1 lt 3]\n#1=[#1+1]\no2 if [#1 eq 2]\no1 break\no2 endif\nG1 X#1\no1 endwhile",
    "o1 break\nG1 X1",
    "o<a B> sub\nG1 X#1\no<ab> endsub\nO < a b > CALL [3] (x)\no<7> repeat [2]\nG1 Y1\no7 endrepeat",
    "#1=7\no[#1] if [1]\nG1 X1\no7 endif\no8 if [0]\nG1 X2\no8 endif",
    "#1=2\no2 sub\nG1 X1\no2 endsub\no[#1] call\no1 if [1]\no[#1] call\no1 endif",
    "o1 if [0]\nG1 X1\no1 endifx\nG1 X2\no1 endif",
    "o1 if [0]\nG1 X1\n/o1 else\nG1 X2\nN5 o1 endif (x)\no9 while\no9 endwhile",
    "o1 sub\nG1 X[#1]\no2 if [#1 gt 1]\no1 call [#1-1]\no2 endif\nG1 Y#1\no1 endsub\no1 call [5]",
    "o1 sub\no1 call\no1 endsub\no1 call\nG1 X1",
    "o1 if [1/0]\nG1 X1\no1 else [3]\nG1 X2\no1 endif [2]\no1 if\no1 endif",
    "#1=1\no1 while [#1]\no2 sub\no2 endsub\nG1 X1\n#1=0\no1 endwhile",
    # A definition without its end: labels behind it are those of the main program, as it is passed.
    "o1 if [0]\nG1 X1\no1 endif\no2 sub\nG1 X1\no1 while [#1 lt 3]\n#1=[#1+1]\no1 endwhile",
    "o1 sub\nG1 X1\no1 endsub\no1 call\no1 sub\nG1 X[#1]\no2 if [#1 gt 1]\no1 call [#1-1]\no2 endif\nG1 Y#1\no1 call [5]",
]


@pytest.mark.parametrize("text", ODD)
def test_o_words_that_are_followed_lead_where_the_labels_say(text: str) -> None:
    whole = f"F100\n{text}\nM2\n"
    assert printed(whole, batches=True) == printed(whole, batches=False)


def test_lines_are_compiled_again_where_there_is_no_room_for_all() -> None:
    """A loop and its subroutine are longer than the instructions that are kept."""
    long = "\n".join(
        f"G1 X[#1{'+1' * 20_000}]\no{k} if [#1 lt {k - 100}]\nY#1\no{k} endif" for k in range(100, 115)
    )
    text = f"F100\no1 sub\n{long}\no1 endsub\no2 while [#1 lt 3]\no1 call [#1]\n{long.replace('o1', 'o9')}\n#1=[#1+1]\no2 endwhile\nM2\n"
    assert printed(text, batches=True) == printed(text, batches=False)


@pytest.mark.parametrize("number", range(3))
def test_random_bodies_lead_where_the_labels_say(number: int) -> None:
    seed = random.randrange(1_000_000)
    print(f"seed {seed}")
    dice = random.Random(seed)
    bodies = [body(dice, k, number == 1, number == 2) for k in range(4)]
    for name, text, file in ways(bodies, "random_body", number == 2):
        if not file:
            assert printed(text, batches=True) == printed(text, batches=False), name


def test_random_macros_are_computed_as_they_are_compiled() -> None:
    """FANUC's settings, jumps and loops by the kernel, and line by line through the interpreter."""
    seed = random.randrange(1_000_000)
    print(f"seed {seed}")
    dice = random.Random(seed)
    for _ in range(60):
        text = MacroProgram(dice).text
        for told in (printed, count_of):
            slow = told(text, batches=False, dialect="fanuc")
            # A line by itself takes more units of work.
            assert told(text, batches=True, dialect="fanuc") == slow or "too-many-steps" in str(slow)


def test_a_loop_of_macros_may_run_as_often_as_one_of_o_words() -> None:
    """Line by line its 500,000 lines took ten units of work each, so that the loop counted as endless."""
    text = "O1\nF100\n#1=0\nWHILE[#1LT100000]DO1\n#1=#1+1\nIF[#1EQ0]GOTO9\nEND1\nN9 G1 X[#1/1000]\nM30\n"
    assert "STRAIGHT_FEED(100.0000, 0.0000" in "\n".join(printed(text, batches=True, dialect="fanuc"))


def test_codes_that_touch_parameters_or_lead_elsewhere_do_not_wait() -> None:
    """What may wait is said in the row of a code; these write parameters, read the machine or call (LinuxCNC's manual, "G Codes")."""
    codes = table("linuxcnc")
    never = ["G10", "G28", "G30", "G38.2", "G54", "G55", "G92", "G43", "G41", "G42", "G20", "G21", "G68.2"]
    never += ["G5.2", "G70", "G71", "G76", "M2", "M30", "M6", "M61", "M66", "M70", "M98", "M99", "M19"]
    assert [code.name for code in codes.values() if code.waits and code.name in never] == []
    assert {code.letter for code in codes.values() if code.waits} == {"G", "M"}
    assert all(not code.calls for code in codes.values() if code.waits)


@pytest.mark.parametrize("batches", [True, False])
@pytest.mark.parametrize(
    ("text", "dialect"),
    [
        ("o1 sub\nG1 X1\no1 endsub\no2 sub\nG1 X2\no2 endsub\nF100\no1 call\n#100=0\no2 call", "linuxcnc"),
        ("F100\no1 if [0]\nG1 X1\no1 endif", "linuxcnc"),
        ("F100\no1 while [0]\no2 repeat [2]\nG1 X1\no2 endrepeat\no1 endwhile", "linuxcnc"),
        ("O1\nF100\nWHILE [1 EQ 2] DO 1\nG1 X1\nEND 1", "fanuc"),
    ],
)
def test_a_jump_to_the_end_of_the_text_keeps_the_number_of_its_last_line(
    text: str, dialect: str, batches: bool
) -> None:
    """The number is the count of lines, whatever line led there: it was the one behind that."""
    said = printed(text + "\n", batches=batches, dialect=dialect)
    last = text.count("\n") + 1
    assert any(f":{last}:1: warning[no-program-end]" in each for each in said), said


def test_asin_and_round_of_macros_are_computed_while_they_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """ASIN gives 0 to 360 degrees; ROUND is to a whole number in a setting, and to the least increment, 0.001 mm, in a word of a length.

    B-63324EN, 15.3. Each line with either ran by itself, which takes a hundred times as long.
    """
    by_itself: list[int] = []
    act = LineRunner._act

    def noted(self: LineRunner, parsed: Any, here: Any) -> None:
        by_itself.append(here.line)
        act(self, parsed, here)

    monkeypatch.setattr(LineRunner, "_act", noted)
    text = (
        "O1\nF100\n#1=2.\n#1=ASIN[-#1/4.]\n#2=ROUND[#1/100.]+ASIN[1.]\nG1X#1Y#2\nZROUND[1.23456*#1/#1]\nM30\n"
    )
    moves = [line for line in printed(text, batches=True, dialect="fanuc") if "STRAIGHT_FEED" in line]
    assert [line.split("(")[1].split(", ")[:3] for line in moves] == [
        ["330.0000", "93.0000", "0.0000"],
        ["330.0000", "93.0000", "1.2350"],
    ]
    assert by_itself == [7]
    assert printed(text, batches=True, dialect="fanuc") == printed(text, batches=False, dialect="fanuc")


def _by_itself(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return the numbers of lines that run by themselves from now on, as they come."""
    found: list[int] = []
    run = LineRunner.run

    def noted(self: LineRunner, parsed: Any, here: Any, after: Any) -> Any:
        found.append(here.line)
        return run(self, parsed, here, after)

    monkeypatch.setattr(LineRunner, "run", noted)
    return found


def test_macros_and_programs_by_their_number_are_called_while_lines_are_read(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A to Z beside G65 set #1 to #26, the rest is vacant (B-63324EN, 15.7.1); M98 goes on with the caller's, L times.

    Each call and each return ran by itself: 50,000 calls took 15 seconds.
    """
    found = _by_itself(monkeypatch)
    text = (
        "O1\nF100\n#1=5.\n#7=1.\nG65P20A#7B[#1/2.]D3.H4.Z5.(ARGUMENTS)\nM98P30L2(PROGRAM)\nX#1\nM30\n"
        "O20\nG1X#1Y#2\nZ[#7+#11+#26]\nX#4\nM99\nO30 Z0\n#1=#1+1.\nY#1\nM99(BACK)\n"
    )
    whole = printed(text, batches=True, dialect="fanuc")
    moves = [line for line in whole if "STRAIGHT_FEED" in line]
    assert [[float(x) for x in line.split("(")[1].split(", ")[:3]] for line in moves] == [
        [1.0, 2.5, 0.0], [1.0, 2.5, 12.0],
        [1.0, 2.5, 0.0], [1.0, 6.0, 0.0], [1.0, 6.0, 0.0], [1.0, 7.0, 0.0], [7.0, 7.0, 0.0],
    ]  # fmt: skip
    # The number of the main program; a vacant word.
    assert found == [1, 12]
    assert printed(text, batches=False, dialect="fanuc") == whole


def test_programs_of_linuxcnc_are_called_while_lines_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """The motions are those that `rs274` of LinuxCNC 2.9 prints for this text."""
    found = _by_itself(monkeypatch)
    text = (
        "F100\n#1=0\no9 while [#1 lt 2]\n#1=[#1+1]\nM98 P20 L2\no9 endwhile\nM2\n"
        "O20\nG1 X#1\n#2=[#2+1]\nY#2\nM98 P30\nM99\nO30\nZ[#2/10]\nM99\n"
    )
    whole = printed(text, batches=True)
    moves = [line.split("(")[1].split(", ")[:3] for line in whole if "STRAIGHT_FEED" in line]
    ends = [(x, y) for x, y in ((1, 1), (1, 2), (2, 3), (2, 4))]
    expected = [
        step for x, y in ends for step in ([x, y - 1, (y - 1) / 10], [x, y, (y - 1) / 10], [x, y, y / 10])
    ]
    assert [[float(x) for x in move] for move in moves] == expected
    assert found == []
    assert printed(text, batches=False) == whole


@pytest.mark.parametrize("called", ["M98P100", "G65P100A1."])
def test_blocks_behind_a_call_are_not_scanned_again_and_again(
    called: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a lathe each call runs by itself: up to 4,096 blocks behind it were scanned, thrown away, and scanned behind the next one."""
    blocks = 0
    scan = gcode_scan.scan

    def noted(*given: Any) -> Any:
        nonlocal blocks
        found = scan(*given)
        blocks += found[0]
        return found

    monkeypatch.setattr(gcode_scan, "scan", noted)
    body = "".join(f"G1X{k}.\n{called}\n" for k in range(500))
    text = f"O1\nG97S500M3\nG99F0.2\n{body}M30\nO100\nG1Z1.\nM99\n"
    assert sum("STRAIGHT_FEED" in line for line in printed(text, batches=True, dialect="fanuc-lathe")) == 1000
    assert blocks < 20 * 1000


def test_lines_of_a_subprogram_are_parsed_once_where_they_name_no_code_of_its_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each line of the first program was parsed by itself, twice, to find out whether a main program stands behind it."""
    found: list[str] = []
    parse = grammar.parse

    def noted(text: str, *given: Any) -> Any:
        found.append(text)
        return parse(text, *given)

    monkeypatch.setattr(grammar, "parse", noted)
    body = "".join(f"G1X{k}.Y1.\n" for k in range(300))
    whole = printed(f"O1\n{body}M99\nO2\nF100\nG1Z1.\nM98P1\nM30\n", batches=True, dialect="fanuc")
    assert sum("STRAIGHT_FEED" in line for line in whole) == 301
    assert len(found) < 30

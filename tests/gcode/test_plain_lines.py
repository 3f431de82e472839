"""Plain lines of SINUMERIK and Heidenhain in arrays: the same as line by line, on random programs, and how many of them go that way."""

from __future__ import annotations

import random
import re

import numpy as np
import pytest

from cncgen.diagnostics import Diagnostics
from cncgen.gcode.errors import BlockError
from cncgen.gcode.klartext import lines
from cncgen.gcode.klartext.running import HeidenhainRunner
from cncgen.gcode.sinks.columns import ColumnsSink
from cncgen.gcode.sinks.counting import CountingSink
from cncgen.gcode.sinks.standalone import StandAloneSink
from cncgen.gcode.sinumerik.reading import parse
from cncgen.gcode.sinumerik.running import SinumerikRunner
from cncgen.gcode.source import Source
from cncgen.gcode.text import line_runs, plain_language
from cncgen.gcode.text.lanes import PlainBlocks
from cncgen.gcode.text.line_runs import code_of
from cncgen.kernels.gcode_codes import ROW
from cncgen.kernels.gcode_lines import Lines
from cncgen.kernels.gcode_run import Computer
from cncgen.kernels.language_code import TOOL_FEED
from cncgen.kernels.language_store import LanguageStore
from cncgen.records import replace
from cncgen.toolpath.building import ToolpathBuilder
from cncgen.toolpath.reading import ReadOptions
from tests.kernels.plain import uncompiled

from .test_motions import same

#: Random jumps may lead round and round.
MOST_STEPS = 2000
RUNNERS = {"sinumerik": SinumerikRunner, "heidenhain": HeidenhainRunner}


class SinumerikOneByOne(SinumerikRunner):
    """A run in which each line goes through its handler."""

    batches = False


class HeidenhainOneByOne(HeidenhainRunner):
    """The same of the plain language."""

    batches = False


ONE_BY_ONE = {"sinumerik": SinumerikOneByOne, "heidenhain": HeidenhainOneByOne}


def run(
    text: str,
    dialect: str,
    sink: object,
    *,
    batches: bool,
    alone: bool = False,
    most: int | None = MOST_STEPS,
) -> tuple[object, list[str]]:
    """Run a text on a sink; return the runner and what was reported."""
    found = Diagnostics()
    options = replace(ReadOptions(dialect=dialect), stand_alone=alone, max_steps=most)
    runner = (RUNNERS if batches else ONE_BY_ONE)[dialect](Source(text.encode(), "t"), options, sink, found)
    for _ in runner.run():
        pass
    return runner, [d.render() for d in found]


def printed(text: str, dialect: str, *, batches: bool) -> tuple[list[str], list[str]]:
    """Return the canonical calls of a text, and what was reported."""
    source = Source(text.encode(), "t")
    sink = StandAloneSink(lambda index, offset: source.text_at(offset))
    found = run(text, dialect, sink, batches=batches, alone=True)[1]
    return list(sink.take()), found


def assert_alike(text: str, dialect: str) -> int:
    """Assert that arrays give a text the same calls, rows, counts and faults; return how many lines went through them."""
    assert printed(text, dialect, batches=True) == printed(text, dialect, batches=False)
    rows, said, counts, taken = [], [], [], 0
    for batches in (True, False):
        builder = ToolpathBuilder("XYZABCUVW", np.zeros(9), ["t"])
        sink = ColumnsSink(builder)
        said.append(run(text, dialect, sink, batches=batches)[1])
        sink.flush()
        rows.append(builder.take())
        counting = CountingSink()
        runner, faults = run(text, dialect, counting, batches=batches)
        counts.append((counting.count, faults, runner.ip.budget.steps, runner.ip.state.position))  # type: ignore[attr-defined]
        if batches:
            taken = runner._lane.taken  # type: ignore[attr-defined]
    same(*rows)
    assert said[0] == said[1]
    assert counts[0] == counts[1]
    return taken


def number_of(rng: random.Random, size: float = 40.0) -> str:
    """Return a number as posts write it."""
    value = rng.choice((rng.uniform(-size, size), float(rng.randrange(-30, 30)), 0.0))
    return rng.choice((f"{value:.3f}", f"{value:.5f}", f"{value:.0f}", f"{value:.1f}", f"{value:.0f}."))


def plain_of_sinumerik(rng: random.Random) -> str:
    """Return a line that is a motion, of the words that go through arrays for the most part."""
    words = []
    code = rng.random()
    if code < 0.45:
        words.append(rng.choice(("G0", "G1", "G1", "G01", "g1")))
    for axis in rng.sample("XYZ", rng.randint(1, 3)) + (["A"] if rng.random() < 0.05 else []):
        sign = rng.choice(("", "", "="))
        words.append(f"{axis}{sign}{number_of(rng)}")
    if rng.random() < 0.3:
        words.append(rng.choice((f"F{rng.randrange(100, 4000)}", f"F={rng.uniform(50, 900):.1f}", "F0")))
    if 0.45 <= code < 0.6:
        x, y = rng.uniform(1, 9), rng.uniform(1, 9)
        words = [rng.choice(("G2", "G3", "G02"))]
        words += rng.choice(
            (
                ["X=IC(0)", f"I{x:.3f}", f"J{y:.3f}"],
                [f"I{x:.3f}", f"J{y:.3f}"],
                [f"I={x:.3f}", f"J{y:.3f}", f"Z{number_of(rng)}"],
                [f"X{x:.3f}", f"Y{y:.3f}", f"CR={rng.choice((-1, 1)) * rng.uniform(3, 60):.3f}"],
                [f"X{x:.3f}", f"Y{y:.3f}", f"I{x:.3f}"],
            )
        )
    rng.shuffle(words) if rng.random() < 0.2 else None
    number = f"N{rng.randrange(10, 9999)} " if rng.random() < 0.6 else ""
    return number + rng.choice((" ", " ", "")).join(words) + rng.choice(("", "", "", " ;note", "\t"))


OTHERS_OF_SINUMERIK = (
    "G91", "G90", "G17", "G18", "M8", "S3000 M3", "R1=R1+1", "X=R1", "X=IC(1)", "G4 F0.1", "G41 D1", "G40", "CT X5 Y7", "G64", "G60",
    "G1 X5 RND=1", "RNDM=0.5", "RNDM=0", "TRANS X5", "ATRANS Y2", "TRANS", "ROT Z30", "G54", "G55", "", "; remark", "G9 G1 X3", "G95 F0.2",
    "G94 F500", "G1 X1 X2", "G1 Q5", "X", "G1", "G0", "DIAMON", "DIAMOF", "OVR=50", "OVR=100", "MSG(\"a\")", "AR=20", "G2 X1 Y1",
    "G1 X5 I3", "F-5", "REPEAT A1 P=2", "GOTOF N77", "N77 G1 X5", "G70", "G71", "X1=5", "CIP X5 Y5 I1=2 J1=3", "MIRROR X0", "G1 FB=100 X5",
    "IF R1<3 GOTOB A1", "G33 Z-5 K1", "G500", "ASPLINE", "X5 Y5", "SUPA G0 Z0", "G0 G53 Z0", "/N5 G1 X3", "X-0", "T1 D1", "M17x",
)  # fmt: skip


def sinumerik_program(rng: random.Random) -> str:
    """Return a program of runs of plain lines, and other lines between them."""
    lines = ["G17 G90 G71 G94", "T1 M6", "S2000 M3", "G0 X0 Y0 Z5", "G1 F1000"]
    for k in range(rng.randint(1, 7)):
        if k == 1:
            lines.append("A1:")
        lines += [plain_of_sinumerik(rng) for _ in range(rng.choice((1, 3, 7, 8, 20)))]
        lines += rng.sample(OTHERS_OF_SINUMERIK, rng.randint(0, 3))
    return "\n".join([*lines, "M30"]) + "\n"


def plain_of_heidenhain(rng: random.Random) -> str:
    """Return a line of the plain language that is a motion."""
    axes = rng.sample("XYZ", rng.randint(1, 3)) + (["C"] if rng.random() < 0.05 else [])
    words = [f"{axis}{rng.choice('+-')}{number_of(rng).lstrip('-')}" for axis in axes]
    if rng.random() < 0.1:
        words[0] = words[0].replace(".", ",")
    if rng.random() < 0.3:
        words.append("R0")
    if rng.random() < 0.5:
        words.append(
            rng.choice(("FMAX", "F MAX", "F AUTO", "FAUTO", f"F{rng.randrange(50, 3000)}", "F500.5", "F"))
        )
    if rng.random() < 0.1:
        words.append(rng.choice(("M3", "M8", "M9", "M5")))
    return "L " + " ".join(words) + rng.choice(("", "", "", " ; note", "\t", " "))


OTHERS_OF_HEIDENHAIN = (
    "RND R1", "CHF 0.5", "CC X+5 Y+5", "C X+1 Y+9 DR+", "CT X+5 Y+9", "CR X+3 Y+4 R+20 DR-", "L IX+5", "L X+Q1", "Q1 = Q1 + 1", "LBL 1",
    "CALL LBL 1 REP 1", "LBL 0", "L M3", "L R0 F200", "L RL X+5 Y+5", "L R0 X+9", "TOOL CALL 2 Z S1000", "TOOL CALL 3 Z S900 F700",
    "CYCL DEF 7.0 DATUM SHIFT", "CYCL DEF 7.1 X+5", "CYCL DEF 10.0 ROTATION", "CYCL DEF 10.1 ROT+30", "", "; remark", "; goes on ~", "* - part",
    "M8", "STOP", "L X+5 X+6", "L X+1 M99", "L Z+5 M91", "L X+5 F-3", "L X", "FN 0: Q1 = +5", "FN 9: IF +Q1 EQU +2 GOTO LBL 1", "M103 F50", "M103",
    "LP PR+10 PA+30", "CYCL DEF 9.0 DWELL TIME", "CYCL DEF 9.1 DWELL 0.1", "X+10", "L  X+5 Y", "/ L X+9", "CC",
    "CP IPA+90 DR+", "L A+5 S500", "L X+1 R5", "    X+5 Y+3", "L X+3 (note)", "L Z-3 M13", "L X1E2 Y+3", "L X+ 5",
)  # fmt: skip


def heidenhain_program(rng: random.Random) -> str:
    """Return a program of runs of plain lines, and other lines between them."""
    tool = "TOOL CALL 1 Z S5000" + rng.choice(("", " F600"))
    lines = ["BEGIN PGM T MM", "BLK FORM 0.1 Z X-50 Y-50 Z-20", tool, "L X+0 Y+0 R0 FMAX M3", "L Z+5 R0 F500"]
    others = [*OTHERS_OF_HEIDENHAIN, *(("FPOL X+0 Y+0", "FL X+5 Y+5") if rng.random() < 0.2 else ())]
    for _ in range(rng.randint(1, 7)):
        lines += [plain_of_heidenhain(rng) for _ in range(rng.choice((1, 3, 8, 9, 20)))]
        lines += rng.sample(others, rng.randint(0, 3))
    numbered = rng.random() < 0.7
    lines = [f"{k} {line}" if numbered and rng.random() < 0.99 else line for k, line in enumerate(lines)]
    return "\n".join([*lines, "L Z+100 FMAX M30", "END PGM T MM"]) + "\n"


@pytest.mark.parametrize(
    ("dialect", "made"), [("sinumerik", sinumerik_program), ("heidenhain", heidenhain_program)]
)
def test_arrays_give_what_handlers_give(dialect: str, made: object) -> None:
    """On random programs, most with lines of other kinds and faults among the plain ones: each call, row, count and fault is the same."""
    taken = 0
    for seed in range(80):
        taken += assert_alike(made(random.Random(seed)), dialect)  # type: ignore[operator]
    assert taken > 900


def formula(rng: random.Random, dialect: str, depth: int = 0) -> str:
    """Return an expression of a language, at times one without a value."""
    names = {
        "sinumerik": ("R1", "R2", "R3", "R[R1+1]", "R99"),
        "heidenhain": ("Q1", "Q2", "Q3", "Q1600", "Q7"),
    }[dialect]
    if depth > 2 or rng.random() < 0.35:
        return rng.choice((*names, "2", "0.5", "7", f"{rng.uniform(0, 30):.3f}", "0", "90"))
    one, other = (formula(rng, dialect, depth + 1) for _ in range(2))
    if dialect == "sinumerik":
        called = rng.choice(
            ("SIN", "COS", "TAN", "SQRT", "ABS", "TRUNC", "ROUND", "ROUNDUP", "POT", "ASIN", "LN", "EXP")
        )
        return rng.choice(
            (
                f"{one}+{other}", f"{one} - {other}", f"{one}*{other}", f"{one}/{other}", f"({one}) DIV {other}", f"{one} MOD ({other})",
                f"{called}({one})", f"-({one})", f"ATAN2({one},{other})", f"MINVAL({one},{other})", f"MAXVAL({one}, {other})",
                f"(({one})=={other})", f"(({one})<>({other}))", f"(({one})>=({other}))", f"(({one})<({other}))", f"NOT ({one})",
                f"({one}) AND ({other})", f"({one}) XOR ({other})", f"BOUND(0,5,{one})", f"({one}) B_AND 3",
            )
        )  # fmt: skip
    called = rng.choice(
        ("SIN", "COS", "TAN", "SQRT", "ABS", "INT", "FRAC", "SQ", "ATAN", "NEG", "SGN", "LN", "LOG", "ACOS")
    )
    return rng.choice(
        (
            f"{one} + {other}", f"{one} - {other}", f"{one} * {other}", f"( {one} ) / {other}", f"( {one} ) % ( {other} )",
            f"( {one} ) ^ 2", f"{called} ( {one} )", f"- ( {one} )", f"{called} {rng.choice(names)}",
        )
    )  # fmt: skip


def computed_line(rng: random.Random, dialect: str) -> str:
    """Return a line with parameters: a setting, a motion, or both."""
    kind = rng.random()
    if dialect == "sinumerik":
        if kind < 0.5:
            target = rng.choice(("R1", "R2", "R3", "R4", "R[R1]", "R[3]"))
            return f"{target}={formula(rng, dialect)}" + (
                f" R2={formula(rng, dialect)}" if kind < 0.1 else ""
            )
        words = [f"{axis}={formula(rng, dialect)}" for axis in rng.sample("XYZ", rng.randint(1, 2))]
        given = f" F=200+ABS({formula(rng, dialect)})" if kind < 0.6 else " R1=R1+1" if kind < 0.65 else ""
        return rng.choice(("G1 ", "G0 ", "")) + " ".join(words) + given
    if kind < 0.4:
        return f"{rng.choice(('', 'FN 0: '))}Q{rng.randint(1, 4)} = {formula(rng, dialect)}"
    if kind < 0.5:
        operator = rng.choice(
            (
                "1: Q1 = +Q2 + +Q3",
                "2: Q2 = +Q1 - +5",
                "3: Q3 = +Q1 * +Q2",
                "4: Q1 = +Q2 DIV +Q3",
                "6: Q2 = SIN +Q1",
            )
        )
        return f"FN {operator}"
    words = [f"{axis}{rng.choice('+-')}Q{rng.randint(1, 4)}" for axis in rng.sample("XYZ", rng.randint(1, 2))]
    return f"L {' '.join(words)}{rng.choice(('', ' FMAX', ' F500', ' FQ1', ' R0'))}"


@pytest.mark.parametrize("dialect", ["sinumerik", "heidenhain"])
def test_lines_that_compute_give_in_arrays_what_handlers_give(dialect: str) -> None:
    """On random programs of fresh seeds: each call, row, count and fault is the same; so are those behind expressions without a value."""
    taken, first = 0, random.SystemRandom().randrange(1 << 32)
    for seed in range(first, first + 60):
        rng = random.Random(seed)
        plain = plain_of_sinumerik if dialect == "sinumerik" else plain_of_heidenhain
        lines = [
            computed_line(rng, dialect) if rng.random() < 0.7 else plain(rng)
            for _ in range(rng.choice((2, 9, 30)))
        ]
        others = OTHERS_OF_SINUMERIK if dialect == "sinumerik" else OTHERS_OF_HEIDENHAIN
        for other in rng.sample(others, rng.randint(0, 3)):
            lines.insert(rng.randrange(len(lines) + 1), other)
        if dialect == "sinumerik":
            head = ["G17 G90 G94 F1000", "R1=1 R2=2.5", "R3=-3", "A1:"]
            text = "\n".join([*head, *lines, "M30"])
        else:
            head = [
                "BEGIN PGM T MM",
                "TOOL CALL 1 Z S5000 F600",
                "Q1 = 1",
                "Q2 = 2.5",
                "Q3 = - 3",
                "L X+0 Y+0 R0 F500",
            ]
            text = "\n".join([*head, *lines, "END PGM T MM"])
        print("seed", seed)
        taken += assert_alike(text + "\n", dialect)
    assert taken > 100


def loop(rng: random.Random, dialect: str, depth: int, number: list[int]) -> list[str]:
    """Return a loop or branch with lines in it, and others of them."""
    number[0] += 1
    k = number[0]
    body = [
        line
        for _ in range(rng.randint(1, 4))
        for line in (
            loop(rng, dialect, depth + 1, number)
            if depth < 3 and rng.random() < 0.3
            else [computed_line(rng, dialect)]
        )
    ]
    others = OTHERS_OF_SINUMERIK if dialect == "sinumerik" else OTHERS_OF_HEIDENHAIN
    if rng.random() < 0.2:
        body.insert(rng.randrange(len(body) + 1), rng.choice(others))
    count, last = 20 + k, rng.randint(0, 9)
    if dialect == "heidenhain":
        head = [f"Q{count} = 0", f"LBL {k}", f"Q{count} = Q{count} + 1"]
        ways = (
            f"FN 12: IF Q{count} LT {last} GOTO LBL {k}", f"FN 10: IF +Q{count} NE +{last % 3} GOTO LBL {k}",
            f"FN 9: IF Q{count} EQU 1 GOTO LBL {k}", f"CALL LBL {k} REP {last}", f"CALL LBL {k} REP {last}/{last}", f"CALL LBL {k} REP Q{count}",
        )  # fmt: skip
        return [*head, *body, rng.choice(ways)]
    step = f"R{count}=R{count}+1"
    name = rng.choice(("NN", "XX", f"R{count}", "FLAG"))
    return rng.choice(
        (
            [f"FOR {name}={rng.choice(('0', 'R1', '1.6'))} TO {last}", *body, "ENDFOR"],
            [f"WHILE R{count}<{last}", step, *body, "ENDWHILE"],
            ["REPEAT", *body, step, f"UNTIL R{count}>={last}"],
            [f"IF {formula(rng, dialect)}>2", *body, "ELSE", computed_line(rng, dialect), "ENDIF"],
            [f"IF NN=={last} AND TRUE", *body, "ENDIF"],
            [f"AA{k}:", *body, step, f"N{k} IF R{count}<{last} {rng.choice(('GOTOB', 'GOTO'))} AA{k}"],
            [f"IF R{count}>1 GOTOF AA{k}", *body, f"AA{k}: {step}"],
            ["LOOP", step, f"IF R{count}>{last} GOTOF AA{k}", *body, "ENDLOOP", f"AA{k}:"],
            [f"XX=R1*{last} FLAG=XX>1", *body, "NN=XX+R2", "G1 X=XX Y=NN+FLAG"],
            [f"AA{k}:", step, *body, f"REPEAT AA{k} P={last % 3}"],
        )
    )


@pytest.mark.parametrize("dialect", ["sinumerik", "heidenhain"])
def test_loops_in_the_kernel_give_what_handlers_give(dialect: str) -> None:
    """On random programs of fresh seeds, with other lines and faults in loops: each call, row and fault is the same."""
    first = random.SystemRandom().randrange(1 << 32)
    for seed in range(first, first + 40):
        rng = random.Random(seed)
        number = [0]
        lines = [line for _ in range(rng.randint(1, 4)) for line in loop(rng, dialect, 0, number)]
        if dialect == "sinumerik":
            outer = ["DEF INT NN", "DEF REAL XX", "DEF BOOL FLAG", "FOR R10=1 TO 3"]
            text = "\n".join([*outer, "G17 G90 G94 F1000", *lines, "ENDFOR", "M30"])
        else:
            outer = ["BEGIN PGM T MM", "TOOL CALL 1 Z S5000 F600", "Q1 = 1", "Q2 = 2.5", "LBL 90"]
            text = "\n".join([*outer, *lines, "CALL LBL 90 REP 2", "END PGM T MM"])
        print("seed", seed)
        assert_alike(text + "\n", dialect)


def test_lines_of_variables_go_through_arrays() -> None:
    """Those of DEF with one number each, from their definition on."""
    lines = "".join(f"AA=BB+{k} NN=AA/2\nG1 X=AA Y=NN F100\n" for k in range(20))
    assert assert_alike(f"DEF REAL AA, BB\nDEF INT NN\nG90\n{lines}M30\n", "sinumerik") == 20


def test_a_code_alone_among_computed_lines_stays_in_force() -> None:
    """G0 in a line of its own is the motion of the lines behind it, of which the first is one that arrays do not take."""
    text = "G1 F100\nR1=1\nX=R1\nG0\nR2=2\nX=IC(1)\nM30\n"
    calls, faults = printed(text, "sinumerik", batches=True)
    assert any("STRAIGHT_TRAVERSE(2.0000" in call for call in calls), (calls, faults)


def test_arcs_by_their_radius_go_through_arrays() -> None:
    """Quarters of circles, and three of them where CR is below 0; one in front of a turn more, which handlers make."""
    body = "G2 X10 Y10 CR=10\nG3 X0 Y0 CR=-10\n"
    text = f"G17 G90 G94\nG1 X0 Y0 F500\n{20 * body}G2 X10 Y10 CR=10 TURN=1\n{20 * body}M30\n"
    assert assert_alike(text, "sinumerik") == 80


def words_by_grammar(text: str, dialect: str) -> list[tuple[str, float]] | None:
    """Return the words of a line as its grammar reads it, None where it is no plain line."""
    try:
        if dialect == "heidenhain":
            statement = plain_language.parse(lines.bare(text))
            words = [(letter, value) for letter, value in statement.words if isinstance(value, float)]
            plain = statement.kind == "block" and len(words) == len(statement.words)
            return words if plain else None
        items = parse(text).items
    except BlockError:
        return None
    names = {"CR": "r"}
    found = []
    for item in items:
        if item[0] == "word":
            found.append((item[1].lower(), item[2]))
        elif item[0] == "set" and not item[2] and isinstance(item[3], float):
            found.append((names.get(item[1], item[1].lower()), item[3]))
        else:
            return None
    return found


PARTS = {
    "sinumerik": "N10|:5|/|G1|G2|G01|g0|G4|X1|X-2.5|Y+.5|y3.|Z=5|Z = -5|X1=5|X=|=|-|+|--|5|5.5|.5|1.2.3|A=0|CR=5|CR|I1|J=2.5|K-1|F100|F=2.5"
    "|X=1EX3|X1_|XY|E5|;c|\"a\"|(|)|DIV|*|:|R1|R1=2|X=R1|X=IC(5)|M3|H5|L2|ü|\t|X=5Y=6|X=5*2|5-3|X123456789012345678901|B|AND",
    "heidenhain": "12|N5|L|CC|C|X+1|X-2,5|Y3.5|IX+1|z+.5|R0|R1|R+0|R|F100|F 5|F|FMAX|F MAX|F AUTO|FAUTO|M3|M|M99|;c|~|(c)|*|/|Q1|X+Q1|+|-|X"
    "|S500|1E3|X+1E2|X+ 5|DR+|RL|ü|\t|LX+1|X+1Y+2|A+90|12L|LBL|TOOL|5.5.5|X+1234567890123456789|B|RND|=",
}  # fmt: skip


class ToolFeed:
    """A variable of one number, 700."""

    kind, bounds, values = "REAL", (), (700.0,)


def words_taken(text: str, dialect: str) -> tuple[int, list[list[tuple[str, float]]]]:
    """Return how many lines of a text the kernel takes, and the words of their blocks."""
    blocks, numbers = PlainBlocks(), memoryview(bytearray(8 * 5000)).cast("d")
    numbers[1] = 2.5
    code, store = code_of(dialect), LanguageStore(numbers, 0, [{TOOL_FEED: ToolFeed}])
    columns = blocks.columns()
    computer = Computer(text.encode(), code, store, columns, lambda *_: True, 99)
    computer.run(0, 1, {})
    return computer.lines, [blocks.pairs(k) for k in range(computer.blocks)]


def another(text: str, rng: random.Random) -> str:
    """Return a line of the same shape: other digits in its numbers."""
    return "".join(rng.choice("0123456789") if c.isdigit() and rng.random() < 0.5 else c for c in text)


#: Settings of parameters, parameters, and operators behind a number: such lines are no plain ones.
COMPUTES = re.compile(r"[RQ] *\d|[\d.)] *([-+*/]|DIV|AND)", re.IGNORECASE)


@pytest.mark.parametrize("dialect", ["sinumerik", "heidenhain"])
def test_a_line_means_what_the_grammar_says(dialect: str) -> None:
    """On lines of random parts: what is taken has the words that the grammar's functions make of it, also behind lines of its shape."""
    rng, parts = random.Random(5), PARTS[dialect].split("|")
    taken = plain = 0
    for _ in range(6_000):
        begin = rng.choice(("", "N7 ", "12 ")) + ("L " if dialect == "heidenhain" else "")
        first = begin + rng.choice((" ", " ", "")).join(rng.choices(parts, k=rng.randint(1, 5)))
        likes = [first, *(another(first, rng) for _ in range(3))]
        if re.search(r"R *\d+ *=", "\n".join(likes), re.IGNORECASE):
            continue
        found: list[list[tuple[str, float]]] = []
        for text in likes:
            lines, words = words_taken(text, dialect)
            if not lines:
                break
            found += words
            expected = words_by_grammar(text.replace("F AUTO", "F700").replace("FAUTO", "F700"), dialect)
            if words and expected is not None:
                plain += 1
                assert sorted(words[0]) == sorted(expected), text
            assert not words or expected is not None or COMPUTES.search(text), text
        assert words_taken("\n".join(likes), dialect)[1] == found, likes
        taken += len(found)
    assert taken > 600
    assert plain > 400


#: The kernels that read lines, as plain Python.
PLAIN = uncompiled("language_code", "decimals", "grammar_tables", "gcode_lines")


@pytest.mark.parametrize("dialect", ["sinumerik", "heidenhain"])
def test_lines_are_read_uncompiled(dialect: str) -> None:
    """The same lines are taken, with the same code; nothing before a text is looked at, which plain Python has as its last byte."""
    rng, parts = random.Random(6), PARTS[dialect].split("|")
    texts = ["L X+1 F100\n; N"]
    for _ in range(150):
        first = ("L " if dialect == "heidenhain" else "") + " ".join(rng.choices(parts, k=rng.randint(1, 4)))
        texts.append("\n".join([first, *(another(first, rng) for _ in range(3))]))
    for text in texts:
        found = []
        for make in (code_of, lambda name: PLAIN.LanguageCode(*line_runs.arguments_of(name))):
            code = make(dialect)
            of_class = Lines if make is code_of else PLAIN.Code.room.__globals__["Lines"]
            kept = memoryview(bytearray(8 * ROW)).cast("q", [1, ROW])
            taken = of_class(code, memoryview(text.encode()), kept).taken_from(0)
            found.append((taken, list(code.code[: code.used]), list(code.constants[: code.numbers])))
        assert found[0] == found[1], text


def test_a_number_without_digits_is_no_empty_line() -> None:
    """The grammar has no block N, so it is a fault among plain lines too, as line by line."""
    text = (
        "0 BEGIN PGM T MM\nTOOL CALL 1 Z S900 F500\n"
        + "L X+1 F AUTO\n" * 9
        + "N\n"
        + "L X+2\n" * 9
        + "L X+3 M30\n"
    )
    found = [run(text, "heidenhain", CountingSink(), batches=batches)[1] for batches in (True, False)]
    assert found[0] == found[1]
    assert any("error[unsupported-block]" in one for one in found[0])


def test_most_lines_of_posts_go_through_arrays() -> None:
    """Of 20,000 lines of each shape all but a few go that way: the first ones, and where runs end."""
    texts = {
        "sinumerik": "".join(f"N{k} G1 X{k % 97}.{k % 10} Y={k % 89 - 40} Z-{k % 7}.5 F{500 + k % 9}\n" for k in range(20_000)),
        "heidenhain": "".join(f"{k} L X{k % 97 - 48:+}.{k % 10} Y+{k % 89} Z-{k % 7},5 F{500 + k % 9}\n" for k in range(20_000)),
    }  # fmt: skip
    for dialect, text in texts.items():
        whole = (
            f"G0 X0\n{text}M30\n" if dialect == "sinumerik" else f"0 BEGIN PGM A MM\n{text}9 END PGM A MM\n"
        )
        runner, faults = run(whole, dialect, CountingSink(), batches=True, most=None)
        assert runner._lane.taken > 19_980, faults  # type: ignore[attr-defined]


def test_jumps_find_block_numbers_of_plain_lines() -> None:
    """N100 stands among lines that are kept as a run; N10 and N1000 are others."""
    lines = [f"N{k}{'0' if k > 90 else ''} X{k}" for k in range(1, 120)]
    text = "\n".join(["G1 F100", "GOTOF N1000", *lines, "M30"]) + "\n"
    calls, faults = printed(text, "sinumerik", batches=True)
    moves = [line for line in calls if "STRAIGHT_FEED" in line]
    assert len(moves) == 20, faults
    assert "100.0000" in moves[0]

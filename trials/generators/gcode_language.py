"""Random valid programs over the whole language, as hypothesis strategies.

A program is a list of stretches; each stands by itself, so that any order of them is valid: it says what it needs (a
feed, a plane, a distance mode) and puts back what the next one counts on (G90, G17, a motion mode of G0 or G1, no
compensation). Features in which the peer is known to be wrong (`tests/peer/cases`) are left out, and U V W: its
make-believe machine has no such axes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import count
from pathlib import Path

from hypothesis import strategies as st

Lines = list[str]


class Labels:
    """Numbers for labels, the lines that go behind the program's end, and whether a loop may have been left by BREAK."""

    def __init__(self) -> None:
        self.numbers = count(100)
        self.tail: Lines = []
        self.broken = False

    def __next__(self) -> int:
        return next(self.numbers)


AXES = "XYZABC"
PLANES = {
    "G17": ("X", "Y", "Z", "I", "J"),
    "G18": ("Z", "X", "Y", "K", "I"),
    "G19": ("Y", "Z", "X", "J", "K"),
}
SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")


def number(low: float, high: float, digits: int = 3) -> st.SearchStrategy[float]:
    """Return numbers with so many decimals; they shrink to whole ones near 0."""
    scale = 10**digits
    return st.integers(round(low * scale), round(high * scale)).map(lambda n: n / scale)


def text(value: float) -> str:
    """Write a number the way programs do."""
    return f"{value:.6f}".rstrip("0").rstrip(".") or "0"


#: The stand-alone peer takes the position anew at M6 and M66, without the offsets that no motion followed.
HOME = "G0 X0 Y0 Z0 A0 B0 C0"
COORDINATE = number(-60, 60)
SMALL = number(0.1, 5)


@st.composite
def axis_words(draw: st.DrawFn, letters: str = AXES) -> str:
    """Return words of some axes."""
    chosen = draw(st.lists(st.sampled_from(letters), min_size=1, max_size=3, unique=True))
    return " ".join(f"{letter}{text(draw(COORDINATE))}" for letter in chosen)


@st.composite
def lines(draw: st.DrawFn) -> Lines:
    """Straight motions, modal ones among them."""
    out = [f"{draw(st.sampled_from(['G0', 'G1', 'g 01', 'G00']))} {draw(axis_words())}"]
    out += [draw(axis_words()) for _ in range(draw(st.integers(0, 2)))]
    if draw(st.booleans()):
        out.append(f"F{text(draw(number(1, 900, 1)))} {draw(axis_words())}")
    return out


@st.composite
def incremental(draw: st.DrawFn) -> Lines:
    """Incremental motions."""
    return ["G91", *draw(lines()), "G90"]


@st.composite
def arcs(draw: st.DrawFn) -> Lines:
    """Arcs and helices by centre, incremental so that any start will do; half of them by an absolute centre."""
    plane = draw(st.sampled_from(list(PLANES)))
    first, second, third, one, two = PLANES[plane]
    radius, begin, turn = draw(number(0.5, 40)), draw(number(0, 6.2)), draw(number(0.1, 6.1))
    sense = draw(st.sampled_from(["G2", "G3"]))
    end = begin + (turn if sense == "G3" else -turn)
    words = [
        f"{first}{radius * (math.cos(end) - math.cos(begin)):.6f}",
        f"{second}{radius * (math.sin(end) - math.sin(begin)):.6f}",
        f"{one}{-radius * math.cos(begin):.6f}",
        f"{two}{-radius * math.sin(begin):.6f}",
    ]
    if draw(st.booleans()):
        words.append(f"{third}{text(draw(COORDINATE))}")
    if draw(st.integers(0, 3)) == 0:
        words.append(f"P{draw(st.integers(1, 4))}")
    if draw(st.integers(0, 5)) == 0:
        words.append(f"F{draw(st.integers(1, 999))}")
    if draw(st.integers(0, 5)) == 0:
        words.append(f"A{text(draw(COORDINATE))}")
    draw(st.randoms(use_true_random=False)).shuffle(words)
    return [plane, f"G91 {sense} {' '.join(words)}", "G90 G17", "G1"]


@st.composite
def arcs_by_radius(draw: st.DrawFn) -> Lines:
    """Arcs by radius, the chord no longer than the diameter."""
    plane = draw(st.sampled_from(list(PLANES)))
    first, second, third, *_ = PLANES[plane]
    radius, share, angle = draw(number(1, 40)), draw(number(0.1, 1.0)), draw(number(0, 6.2))
    chord = 2.0 * radius * share * 0.999
    words = f"{first}{chord * math.cos(angle):.5f} {second}{chord * math.sin(angle):.5f}"
    if draw(st.booleans()):
        words += f" {third}{text(draw(COORDINATE))}"
    sign = draw(st.sampled_from(["", "-"]))
    if draw(st.integers(0, 3)) == 0:
        words += f" P{draw(st.integers(1, 3))}"
    return [
        plane,
        f"G91 {draw(st.sampled_from(['G2', 'G3']))} {words} R{sign}{text(radius)}",
        "G90 G17",
        "G1",
    ]


@st.composite
def circles(draw: st.DrawFn) -> Lines:
    """Full circles."""
    sense = draw(st.sampled_from(["G2", "G3"]))
    depth = f" Z{text(draw(COORDINATE))}" if draw(st.booleans()) else ""
    return [f"{sense} I{text(draw(SMALL))} J{text(draw(COORDINATE))}{depth}", "G1"]


@st.composite
def offsets(draw: st.DrawFn) -> Lines:
    """Work offsets, G92 and G52, rotation, and a motion in them."""
    letters = st.sampled_from(["XY", "XYZ", "AB"]).flatmap(axis_words)
    set_offset = [f"G10 L2 P{draw(st.integers(0, 9))} {draw(letters)}"]
    if draw(st.booleans()):
        # The peer's position forgets that the offset of G92 is turned (docs/language.md): none is in force then.
        set_offset = ["G92.2", f"{set_offset[0]} R{text(draw(number(-180, 180)))}"]
    choice = draw(st.integers(0, 6))
    kinds: list[Lines] = [
        set_offset,
        [f"G10 L20 P{draw(st.integers(0, 9))} {draw(letters)}"],
        [draw(st.sampled_from(SYSTEMS))],
        [f"G92 {draw(letters)}"],
        [f"G52 {draw(letters)}"],
        [draw(st.sampled_from(["G92.1", "G92.2", "G92.3"]))],
        [f"G53 G0 {draw(axis_words())}"],
    ]
    return [*kinds[choice], *draw(lines())]


@st.composite
def homes(draw: st.DrawFn) -> Lines:
    """Reference points."""
    which = draw(st.sampled_from(["G28", "G30"]))
    out = [f"{which}.1"] if draw(st.booleans()) else []
    return [
        *out,
        f"G0 {draw(axis_words())}",
        f"{which} {draw(axis_words())}" if draw(st.booleans()) else which,
    ]


@st.composite
def tools(draw: st.DrawFn) -> Lines:
    """Tool changes and offsets; the offset is taken back, for the units may change later."""
    tool = draw(st.sampled_from([1, 2, 3, 10]))
    use = draw(st.sampled_from(["G43", f"G43 H{draw(st.sampled_from([1, 2, 3]))}", "G43.1 Z2.5", "G43.2 H2"]))
    return [HOME, f"T{tool} M6", use, *draw(lines()), "G49", HOME]


@st.composite
def units(draw: st.DrawFn) -> Lines:
    """A change of units."""
    return [draw(st.sampled_from(["G20", "G21"])), *draw(lines())]


@st.composite
def polar(draw: st.DrawFn) -> Lines:
    """Polar words."""
    words = f"@{text(draw(SMALL))} ^{text(draw(number(-180, 360)))}"
    return [
        f"{draw(st.sampled_from(['G0', 'G1']))} {words}",
        f"@{text(draw(SMALL))}",
        f"^{text(draw(number(0, 90)))}",
    ]


@st.composite
def inverse_time(draw: st.DrawFn) -> Lines:
    """Inverse time."""
    blocks = [
        f"G1 {draw(axis_words())} F{text(draw(number(0.1, 50)))}" for _ in range(draw(st.integers(1, 3)))
    ]
    return ["G93", *blocks, "G94 F100"]


@st.composite
def revolutions(draw: st.DrawFn) -> Lines:
    """Feed per revolution, surface speed."""
    css = draw(st.sampled_from([[], ["G96 D2000 S100"], ["G96 S80"]]))
    return ["M3 S500", *css, "G95 F0.25", f"G1 {draw(axis_words())}", "G94 F100 G97 S400"]


@st.composite
def switches(draw: st.DrawFn) -> Lines:
    """M codes and path modes."""
    pool = [
        "M3", "M4 S300", "M5", "M7", "M8", "M9", "M48", "M49", "M50 P0", "M51 P1", "M52 P1", "M53 P0", "M0", "M1",
        "M62 P1", "M63 P2", "M64 P0", "M65 P3", "M67 E1 Q2.5", "M68 E0 Q-1", "G61", "G61.1", "G64",
        "G64 P0.05", "G64 P0.1 Q0.02", "G4 P0.25", "S1200", "M19 R45", "G97", "G98", "G99", "G40", "M60",
    ]  # fmt: skip
    return draw(st.lists(st.sampled_from(pool), min_size=1, max_size=4))


@st.composite
def state(draw: st.DrawFn) -> Lines:
    """State kept and put back."""
    change = draw(
        st.sampled_from([["G20"], ["G91"], ["G18"], ["G55"], ["F77"], ["S88"], ["G61"], ["G91", "G19"]])
    )
    return ["G49", "M70", *change, "G0 X1", "M72", *draw(lines())]


@st.composite
def cycles(draw: st.DrawFn) -> Lines:
    """Canned cycles in three planes (tapping in one), absolute and incremental, with repeats."""
    code = draw(st.sampled_from(["G73", "G81", "G82", "G83", "G85", "G86", "G89", "G84", "G74"]))
    tapping = code in ("G84", "G74")
    plane = "G17" if tapping else draw(st.sampled_from(list(PLANES)))
    first, second, depth, *_ = PLANES[plane]
    extra = {"G73": " Q0.7", "G83": " Q1.1", "G82": " P0.5", "G86": " P0.2", "G89": " P0.3"}.get(code, "")
    level, clear, bottom = draw(number(-5, 9)), draw(number(-5, 9)), draw(number(0.2, 6))
    out = [plane, f"G0 {depth}{text(level)}", "M4 S100" if code == "G74" else "M3 S100"]
    out.append(draw(st.sampled_from(["G98", "G99"])))
    repeat = f" L{draw(st.integers(1, 3))}" if code != "G74" and draw(st.booleans()) else ""
    if draw(st.booleans()):
        words = f"{depth}{text(clear - bottom)} R{text(clear)}"
        out.append(f"{code} {first}{text(draw(COORDINATE))} {words}{extra}{repeat}")
    else:
        words = f"{depth}{text(-bottom)} R{text(clear)}"
        out.append(f"G91 {code} {first}{text(draw(SMALL))} {second}1 {words}{extra}{repeat}")
    for _ in range(draw(st.integers(0, 2))):
        out.append(f"{draw(st.sampled_from([first, second]))}{text(draw(COORDINATE))}")
    if draw(st.booleans()):
        out.append(f"{draw(st.sampled_from(['G98', 'G99']))} {first}{text(draw(COORDINATE))}")
    return [*out, "G80", "G90 G17", "G0"]


@st.composite
def compensation(draw: st.DrawFn) -> Lines:
    """A contour beside which the tool runs; corners too narrow for it are errors on both sides."""
    plane = draw(st.sampled_from(["G17", "G17", "G18"]))
    first, second, _, one, two = PLANES[plane]
    code = draw(st.sampled_from(["G41.1 D2", "G42.1 D2", "G41.1 D0.5", "G42.1 D6"]))
    out = [plane, f"G0 {first}0 {second}0", code, f"G1 {first}15 {second}{text(draw(number(-5, 5)))}"]
    for _ in range(draw(st.integers(1, 5))):
        if draw(st.integers(0, 3)):
            out.append(f"G1 {first}{text(draw(COORDINATE))} {second}{text(draw(COORDINATE))}")
        else:
            radius, begin, turn = draw(number(5, 30)), draw(number(0, 6.2)), draw(number(0.3, 5))
            sense = draw(st.sampled_from(["G2", "G3"]))
            end = begin + (turn if sense == "G3" else -turn)
            out += (
                "G91",
                f"{sense} {first}{radius * (math.cos(end) - math.cos(begin)):.5f} "
                f"{second}{radius * (math.sin(end) - math.sin(begin)):.5f} "
                f"{one}{-radius * math.cos(begin):.5f} {two}{-radius * math.sin(begin):.5f}",
                "G90",
            )
    return [*out, f"G40 G0 {first}{text(draw(number(60, 99)))}", "G17"]


@st.composite
def lathe(draw: st.DrawFn) -> Lines:
    """Diameters, synchronised motion, threads."""
    start = f"G18 M3 S200 G0 X{text(draw(number(10, 60)))} Z{text(draw(number(1, 9)))}"
    pitch = text(draw(number(0.3, 3)))
    first = draw(number(0.1, 0.8))
    full = first + draw(number(0.1, 1.5))
    tail = draw(
        st.sampled_from(["", " R1.5", " R2 H2", " Q29.5", " Q-20 E0.5 L1", " E0.4 L2", " E0.3 L3 H1"])
    )
    sign = draw(st.sampled_from(["-", ""]))
    thread = f"G76 P{pitch} Z{text(draw(number(-30, 0)))} I{sign}1.5 J{text(first)} K{text(full)}{tail}"
    kinds = [[thread], [f"G33 Z-12.5 K{pitch}"], [f"G33.1 Z-3 K{pitch}"], [f"G1 X{text(draw(SMALL))} Z-4"]]
    body = draw(st.sampled_from(kinds))
    mode = draw(st.sampled_from([["G7"], ["G8"], []]))
    return [*mode, start, *body, "G8", "G17 G0"]


# Values, parameters and O-words.


@st.composite
def expression(draw: st.DrawFn, depth: int = 2) -> str:
    """Return an expression in brackets whose value is of moderate size."""
    if depth == 0:
        return draw(
            st.sampled_from(["#1", "#2", "#<a>", "#<_shared>", "3", "2.5", "-1.25", "#<_x>", "0.5", "7"])
        )
    kind = draw(st.integers(0, 4))
    left, right = draw(expression(depth - 1)), draw(expression(depth - 1))
    if kind == 0:
        return f"[{left} {draw(st.sampled_from(['+', '-', '*']))} {right}]"
    if kind == 1:
        return f"[{left} / 4.0]"
    if kind == 2:
        function = draw(st.sampled_from(["ABS", "COS", "SIN", "FIX", "FUP", "ROUND"]))
        return f"{function}[{left}]"
    if kind == 3:
        return f"[{left} {draw(st.sampled_from(['GT', 'GE', 'LT', 'LE', 'EQ', 'NE', 'AND', 'OR', 'XOR']))} {right}]"
    return draw(
        st.sampled_from(
            [f"ATAN[{left}]/[1.5]", f"SQRT[ABS[{left}]]", f"[ABS[{left}] MOD 3]", f"[2 ** [{right} MOD 3]]"]
        )
    )


@st.composite
def values(draw: st.DrawFn) -> Lines:
    """Parameters set, shown and used."""
    target = draw(st.sampled_from(["#1", "#2", "#<a>", "#<_shared>", "#[1 + 1]", "#30"]))
    value = draw(expression())
    show = draw(
        st.sampled_from(
            ["(debug, #1 #2 #<a> #<_shared>)", "(debug, #5420 #5421 #5422)", "(debug, #<_z> #<_feed>)"]
        )
    )
    return [
        f"{target} = {value}",
        show,
        f"G0 X[[{draw(expression(1))}] MOD 50] Y#1 Z[#<a> / 3]",
    ]


@st.composite
def conditions(draw: st.DrawFn, labels: Labels) -> Lines:
    """An if with its branches."""
    label = f"o{next(labels)}"
    out = [f"{label} if [{draw(expression(1))} GT 1]", *draw(lines())]
    if draw(st.booleans()):
        out += [f"{label} elseif [#1 LT 2]", *draw(lines())]
    if draw(st.booleans()):
        out += [f"{label} else", *draw(lines())]
    return [*out, f"{label} endif"]


@st.composite
def loops(draw: st.DrawFn, labels: Labels) -> Lines:
    """A loop of a few rounds."""
    label, counter = f"o{next(labels)}", draw(st.sampled_from(["#20", "#<n>"]))
    rounds = draw(st.integers(0, 4))
    body = [*draw(st.one_of(lines(), incremental(), values(), arcs())), f"{counter} = [{counter} + 1]"]
    # After a BREAK the peer ends the next DO after one round (docs/language.md).
    kind = draw(st.sampled_from([0, 1, 3] if labels.broken else [0, 1, 2, 3]))
    if kind == 0:
        return [f"{label} repeat [{rounds}]", *body[:-1], f"{label} endrepeat"]
    if kind == 1:
        return [f"{counter} = 0", f"{label} while [{counter} LT {rounds}]", *body, f"{label} endwhile"]
    if kind == 2:
        return [f"{counter} = 0", f"{label} do", *body, f"{label} while [{counter} LT {rounds}]"]
    inner = f"o{next(labels)}"
    skip = [f"{inner} if [{counter} EQ 2]", f"{label} continue", f"{inner} endif"]
    head = [f"{counter} = 0", f"{label} while [{counter} LT {rounds}]", f"{counter} = [{counter} + 1]"]
    return [*head, *skip, *body[:-1], f"{label} endwhile"]


@st.composite
def calls(draw: st.DrawFn, labels: Labels) -> Lines:
    """A subroutine and calls of it."""
    label = draw(st.sampled_from([f"o{next(labels)}", f"o<part{next(labels)}>"]))
    body = ["G0 X#1 Y[#2 + #3]", "#<a> = #1", *draw(st.one_of(lines(), arcs(), incremental()))]
    back = draw(st.sampled_from([f"{label} endsub", f"{label} endsub [#1 * 2]"]))
    early = []
    if draw(st.booleans()):
        inner = f"o{next(labels)}"
        early = [f"{inner} if [#1 GT 4]", f"{label} return [#2]", f"{inner} endif"]
    out = [f"{label} sub", *early, *body, back]
    for _ in range(draw(st.integers(1, 3))):
        arguments = " ".join(f"[{text(draw(COORDINATE))}]" for _ in range(draw(st.integers(0, 4))))
        out.append(f"{label} call {arguments}")
    return [*out, "(debug, #<_value> #<_value_returned>)", "G0 Z#<_value>"]


@st.composite
def computed_word(draw: st.DrawFn, letters: str = "XYZ") -> str:
    """Return a word whose value is computed."""
    value = draw(
        st.one_of(
            expression(1),
            st.sampled_from(
                ["#5420", "#<_y>", "-#1", "- -#2", "##31", "#[30 + 1]", "[#<a>**2]", "[SIN[30]*9]"]
            ),
            number(-9, 9).map(lambda a: f"[{text(a)} + #1]"),
        )
    )
    return f"{draw(st.sampled_from(letters))}{value}"


@st.composite
def computed(draw: st.DrawFn) -> Lines:
    """Motions and settings with values to compute, some of them where the machine is."""
    pool = st.one_of(
        computed_word().map(lambda word: f"G1 {word} F[100 + 1]"),
        computed_word().map(lambda word: f"{word} (remark)"),
        number(-9, 9).map(lambda a: f"#2 = {text(a)} #1 = #2"),
        st.sampled_from(
            ["#1 = [#1 / 2 + 1]", "#<a> = #<_x>", "#2 = [ABS[#5421] MOD 7]", "M8", "S[#31 * 100]"]
        ),
        st.sampled_from(["G[0 + 1] X1", "#<b c> = [#<a> + 1]\nG0 Y#<BC>", "G4 P[0.5]", "F[200] X#1 ; end"]),
    )
    body = draw(st.lists(pool, min_size=1, max_size=6))
    return ["#31 = 2", "G1", *"\n".join(body).split("\n")]


@st.composite
def nested_loops(draw: st.DrawFn, labels: Labels) -> Lines:
    """Loops within loops, left and gone on with from inside branches; conditions ask counters or the position."""
    outer, inner, leave = (f"o{next(labels)}" for _ in range(3))
    at, rounds = draw(st.integers(0, 4)), draw(st.integers(1, 4))
    act = draw(
        st.sampled_from(
            [f"{inner} break", f"{inner} continue", f"{outer} break", f"{outer} continue", "G0 Z1"]
        )
    )
    labels.broken |= act.endswith("break")
    condition = draw(
        st.sampled_from([f"#22 EQ {at}", f"#21 GE {at}", f"#22 GT {at} OR #21 EQ 1", "#5420 GT 30"])
    )
    return [
        "G0 X0", "#21 = 0", f"{outer} while [#21 LT {rounds}]", "#21 = [#21 + 1]", "#22 = 0",
        f"{inner} while [#22 LT 3]", "#22 = [#22 + 1]", *draw(st.one_of(lines(), computed(), incremental())),
        f"{leave} if [{condition}]", act, f"{leave} endif", "G1 Y[#21 * 10 + #22]", f"{inner} endwhile",
        f"{outer} endwhile",
    ]  # fmt: skip


@st.composite
def deep_calls(draw: st.DrawFn, labels: Labels) -> Lines:
    """A subroutine that calls itself, with locals of its own, and gives a value back out of a loop."""
    # It asks for no value before its first call: the peer's is that of the last definition passed over.
    name, branch, loop, out = (f"o<{word}{next(labels)}>" for word in ("Deep", "b", "l", "r"))
    depth = draw(st.integers(0, 4))
    return [
        f"{name} sub", "#<mine> = [#1 * 2]", f"{branch} if [#1 GT 0]", f"{name} call [#1 - 1] [#2 + 1]",
        f"{branch} endif", "G1 X[#<mine> + #2] Y#1", "#3 = 0", f"{loop} while [#3 LT 3]", "#3 = [#3 + 1]",
        f"{out} if [#3 + #1 EQ 3]", f"{name.lower()} return [#3]", f"{out} endif", *draw(lines()), f"{loop} endwhile",
        f"{name} endsub", f"{name} call [{depth}] [#1]", "(debug, #1 #3 #<_value> #<_value_returned>)",
    ]  # fmt: skip


@st.composite
def programs_by_number(draw: st.DrawFn, labels: Labels) -> Lines:
    """M98 of a program behind the end, which shares the numbered parameters."""
    number_of = next(labels)
    labels.tail += [
        f"o{number_of}",
        # Names are those of the subroutine alone.
        "#<a> = #1",
        "G91 G1 X[#1 / 10] F100",
        "G90",
        *draw(computed()),
        "#1 = [#1 + 1]",
        "M99",
    ]
    times = draw(st.sampled_from(["", " L2", " L3"]))  # after L0 the peer counts a call too many
    return [f"M98 P{number_of}{times}", "(debug, #1)", f"G0 {draw(axis_words())}"]


@st.composite
def probes(draw: st.DrawFn) -> Lines:
    """Probing, and what it leaves in parameters."""
    code = draw(st.sampled_from(["G38.2", "G38.3", "G38.4", "G38.5"]))
    axis = draw(st.sampled_from("XYZ"))
    return [
        HOME,
        f"G91 {code} {axis}{text(draw(number(1, 20)))}",
        "G90 (debug, #5061 #5062 #5063 #5070 #5420 #5421 #5422)",
        f"G0 {draw(axis_words())}",
    ]


@st.composite
def splines(draw: st.DrawFn) -> Lines:
    """Cubic, quadratic and NURBS motions in XY."""

    def point() -> str:
        return f"X{text(draw(COORDINATE))} Y{text(draw(COORDINATE))}"

    def offset(i: str, j: str) -> str:
        return f"{i}{text(draw(number(1, 9)))} {j}{text(draw(number(1, 9)))}"

    kinds: list[Lines] = [
        [f"G5 {offset('I', 'J')} {offset('P', 'Q')} {point()}", f"G5 {offset('P', 'Q')} {point()}"],
        [f"G5.1 {offset('I', 'J')} {point()}"],
        [
            f"G5.2 P1 L{draw(st.integers(2, 4))} {point()}",
            *(f"P{text(draw(number(0.5, 3)))} {point()}" for _ in range(draw(st.integers(3, 6)))),
            "G5.3",
        ],
    ]
    return ["G17", *draw(st.sampled_from(kinds)), "G1"]


@st.composite
def tables(draw: st.DrawFn) -> Lines:
    """Tools entered from the program, and used."""
    tool = draw(st.sampled_from([1, 2, 3]))
    entry = draw(st.sampled_from(["L1", "L10", "L11"]))
    words = f"Z{text(draw(COORDINATE))}" + draw(st.sampled_from(["", " R1.5", " X2.5"]))
    return [HOME, f"G10 {entry} P{tool} {words}", f"G43 H{tool}", *draw(lines()), "G49", HOME]


@st.composite
def predefined(draw: st.DrawFn) -> Lines:
    """Parameters that tell the state, shown."""
    names = [
        *(f"_{letter}" for letter in "xyzabcuvw"), *(f"_abs_{letter}" for letter in "xyz"), "_plane", "_metric",
        "_imperial", "_absolute", "_incremental", "_units_per_minute", "_coord_system", "_ijk_absolute_mode",
        "_retract_old_z", "_rpm", "_spindle_on", "_spindle_cw", "_mist", "_flood", "_motion_mode", "_call_level",
    ]  # fmt: skip
    chosen = draw(st.lists(st.sampled_from(names), min_size=1, max_size=3, unique=True))
    numbered = draw(
        st.lists(st.sampled_from([5161, 5181, 5211, 5213, 5220, 5221, 5222, 5230, 5241]), max_size=2)
    )
    return [f"(debug, {' '.join(f'#<{name}>' for name in chosen)} {' '.join(f'#{n}' for n in numbered)})"]


@st.composite
def remarks(draw: st.DrawFn) -> Lines:
    """Comments of all kinds, line numbers, blanks and small letters."""
    motion = draw(axis_words("XYZ"))
    pool = [
        f"N{draw(st.integers(1, 99999))} G1 {motion} (cut, pass 2)", f"g1{motion.lower().replace(' ', '')}",
        f"  G 0 1   {motion} ; (not passed on)", f"(MSG, now) G0 {motion}", "(print, #1)", "(plain)", ";", "",
        f"n{draw(st.integers(1, 99))}g00{motion} (a)(b)", "(debug, %d #1 %.3f #2)", f"/G1 {motion}",
    ]  # fmt: skip
    return draw(st.lists(st.sampled_from(pool), min_size=1, max_size=4))


@st.composite
def saving_calls(draw: st.DrawFn, labels: Labels) -> Lines:
    """A subroutine that saves the modal state and has it put back at its end."""
    label = f"o{next(labels)}"
    change = draw(st.sampled_from([["G20"], ["G91"], ["G18"], ["F77"], ["G91", "G19"]]))
    return [
        "G49", f"{label} sub", "M73", *change, "G0 X1", f"{label} endsub", f"{label} call", *draw(lines()),
    ]  # fmt: skip


@st.composite
def file_calls(draw: st.DrawFn) -> Lines:
    """A subroutine in a file beside the program (`FILES`)."""
    arguments = " ".join(f"[{text(draw(COORDINATE))}]" for _ in range(draw(st.integers(0, 3))))
    return [f"o<random_part> call {arguments}", "G0 Z#<_value>"]


#: Files that stand beside a random program.
FILES = {
    "random_part.ngc": "o<random_part> sub\nG1 X#1 Y[#2 / 2] F300\no1 if [#1 GT 0]\no<random_part> return [#1]\n"
    "o1 endif\nG0 Z#3\no<random_part> endsub [5]\nM2\n"
}

STAGES: dict[str, Callable[[Labels], st.SearchStrategy[Lines]]] = {
    "lines": lambda labels: lines(),
    "incremental": lambda labels: incremental(),
    "arcs": lambda labels: st.one_of(arcs(), arcs_by_radius(), circles()),
    "offsets": lambda labels: offsets(),
    "homes": lambda labels: homes(),
    "tools": lambda labels: tools(),
    "units": lambda labels: units(),
    "polar": lambda labels: polar(),
    "feeds": lambda labels: st.one_of(inverse_time(), revolutions()),
    "switches": lambda labels: switches(),
    "state": lambda labels: state(),
    "cycles": lambda labels: cycles(),
    "compensation": lambda labels: compensation(),
    "lathe": lambda labels: lathe(),
    "values": lambda labels: values(),
    "conditions": lambda labels: conditions(labels),
    "loops": lambda labels: loops(labels),
    "nested": lambda labels: nested_loops(labels),
    "computed": lambda labels: computed(),
    "calls": lambda labels: st.one_of(calls(labels), saving_calls(labels), deep_calls(labels)),
    "numbered": lambda labels: programs_by_number(labels),
    "files": lambda labels: file_calls(),
    "probes": lambda labels: probes(),
    "splines": lambda labels: splines(),
    "tables": lambda labels: tables(),
    "predefined": lambda labels: predefined(),
    "remarks": lambda labels: remarks(),
}


def write_files(folder: Path) -> None:
    """Write the files that random programs call beside them."""
    for name, content in FILES.items():
        (folder / name).write_text(content)


@st.composite
def programs(draw: st.DrawFn, stages: tuple[str, ...] = tuple(STAGES)) -> str:
    """Return a program made of stretches of these stages."""
    labels = Labels()
    body: Lines = []
    for _ in range(draw(st.integers(1, 7))):
        body += draw(STAGES[draw(st.sampled_from(stages))](labels))
    setting = ["#1 = 2 #2 = 3.5", "#<a> = 1.5", "#<_shared> = -2", "#<n> = 0"]
    out = [f"{draw(st.sampled_from(['G21', 'G20']))} F200 S300", *setting, *body, "M2", *labels.tail]
    if draw(st.integers(0, 3)) == 0:
        out = [line if _has_number(line) else f"N{10 * k} {line}" for k, line in enumerate(out, 1)]
    return "\n".join([*out, ""])


def _has_number(line: str) -> bool:
    """Tell whether a line has an N word, or can have none."""
    return not line.strip() or line.strip()[0] in "nN/;("

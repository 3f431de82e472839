"""Heidenhain's plain language: one block of text to a `Statement`, by the tables of ``grammars/heidenhain.lark``.

```
0 BEGIN PGM PART MM
1 BLK FORM 0.1 Z X+0 Y+0 Z-20
2 TOOL CALL 3 Z S4850
3 L X+10 Y+0 R0 FMAX M3
4 CC X+0 Y+0
5 C X+0 Y+10 DR+ F500
6 END PGM PART MM
```

Its words become those of G-code if these exist (TOOL CALL: T M6 G43 S), else words of additional codes
(`codes.plain_language`, `codes.heidenhain`). Q parameters are numbered parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple, cast

from cncgen.gcode.block import AXIS_INDEX, LARGEST, Computed, Own, Value, evaluate
from cncgen.gcode.errors import BlockError
from cncgen.gcode.text import expressions
from cncgen.gcode.text.syntax_errors import Language, refusal
from cncgen.kernels import gcode_codes as codes
from cncgen.kernels.grammar_values import Reader
from cncgen.units import INCH

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.state.parameters import Parameters

Words = list[tuple[str, Value]]
#: A word as it is written: its name in capitals, and its value. That of FMAX, FAUTO and sides is their column, that of a name alone NaN.
Raw = tuple[str, Value]
_NO_MARKS: Mapping[str, Value] = {}


class Statement(NamedTuple):
    """A block.

    Attributes:
        kind: What it is: ``block`` (words that are executed), else the rule of the grammar.
        words: Letters of G-code and values.
        data: The other values of its rule.
        marks: Of its words those that the program's run acts on: R0, R+ and R- (R±), M89, M94, M103, M128, and IX IY IA IB IC.
    """

    kind: str
    words: Sequence[tuple[str, Value]] = ()
    data: tuple[Any, ...] = ()
    marks: Mapping[str, Value] = _NO_MARKS


#: Q parameters of a program and those that are kept, QL1 and QR1, and what is added to their numbers: Q ends at Q1999.
_OWN_NUMBERS = {"L": 3000, "R": 3500}
#: The numbers of QL0 to QL499, which are those of one program.
LOCAL = slice(3000, 3500)
#: The number of Q0, since 0 is none of a parameter here.
_FIRST = 4000.0
#: The first number that no parameter has.
_BEYOND = 5602
#: M functions from 100 on that are the control's own; the others are the machine builder's.
_OF_CONTROL = {*range(101, 121), 124, *range(126, 131), *range(132, 139), *range(140, 146), 148, 149, 150}
_REMARK = ("g", Own.REMARK / 10.0)
#: M functions of which a remark tells: some of the control, and those of the machine's builder.
_TOLD = (109.0, 110.0, 111.0, 116.0, *(float(m) for m in range(100, 200) if m not in _OF_CONTROL))
#: M functions that stand for several of G-code, or for another one.
_FUNCTIONS: dict[Value, Words] = {
    13.0: [("m", 3.0), ("m", 8.0)],
    14.0: [("m", 4.0), ("m", 8.0)],
    91.0: [("g", 53.0)],
    92.0: [("g", 53.0), _REMARK, ("remark", 92.0)],
    99.0: [("g", Own.CYCLE_CALL / 10.0)],
    129.0: [("g", Own.TIP_OFF / 10.0)],
    136.0: [("g", 95.0)],
    137.0: [("g", 94.0)],
    **{number: [_REMARK, ("remark", number)] for number in (97.0, 98.0)},
    **{number: [("m", number), _REMARK, ("remark", number)] for number in _TOLD},
}
_NOT_READ: dict[Value, str] = {
    104.0: "the datum that was set last again",
    114.0: "positions of the rotary axes in the program's coordinates",
    130.0: "points in untilted coordinates",
    142.0: "erasing what the program has set",
    144.0: "the kinematics of the rotary axes",
}
_HINT = "--dialect reads other texts as G-code"
_FORMULA_HINT = "Q1 = ( Q2 + 3 ) * SIN Q3"
_OF_TEXTS = ("STRLEN", "STRCOMP", "TONUMB", "INSTR")
_READ = "of the plain language L, LN, LP, CC, C, CR, CP, CT, RND, CHF, APPR, DEP, SPL, TOOL CALL, CYCL DEF, LBL, CALL LBL, FN are read"
_MOTIONS = {
    "SPL": Own.SPL,
    "LP": Own.POLAR_LINE,
    "CC": Own.POLE,
    "CP": Own.POLAR_ARC,
    "CR": Own.RADIUS_ARC,
    "C": Own.CIRCLE,
}
#: Codes of motions that end where their axis words say.
_LEADING = (0.0, 1.0, Own.CIRCLE / 10.0, Own.RADIUS_ARC / 10.0)
#: Operators of functions that the grammar has as one token with others.
_OPERATORS = {"1": ("+",), "2": ("-",), "3": ("*",), "4": ("DIV", "/")}
LANGUAGE = Language(
    names={
        **dict.fromkeys(("NUMBER", "SIGNED"), "a number"),
        **dict.fromkeys(("Q", "TEXT_PARAMETER"), "a parameter Q"),
        **dict.fromkeys(("SIGN",), "a sign"),
        **dict.fromkeys(("FUNCTION", "PI", "ROOT", "SINE", "COSINE"), "a function"),
        **dict.fromkeys(("TIMES", "POWER", "DIVISION"), "an operator"),
        **dict.fromkeys(
            ("OF_SENSE", "AXIS", "NAMED", "OF_TURNS", "COEFFICIENT", "OF_WAY", "FEED", "R", "SIDE", "FAST", "AUTO", "DR", "OVERSIZE", "L", "D", "OWN", "REFERENCE", "CLOSED", "NORMAL",
             "ORIENTATION", "NAME", "TOLERANCE", "M", "M90", "M94", "M103", "M112", "M118", "M120", "M124", "M128", "M138", "M140"),
            "a word",
        ),
        "COLON": ":", "UNIT": "TIME or REV", "STRING": 'a name "…"', "IDENTIFIER": "a name", "TEXT": "a text",
        "LENGTH": "LEN", "ANGLE": "ANG", "EQUALS": "EQU", "DIFFERS": "NE", "GREATER": "GT", "LESS": "LT", "FORM": "LT, LN, CT or LCT",
        "CYCLE": "the number of a cycle", "FEED_WORD": "a feed", "PREDEF": "PREDEF", "PLACES_OF": "POS, ROW, PAT, FRAME, CIRC or PITCHCIRC",
    },
    hint="a word is letters with a value: X+10, IY-2.5, X+Q1, DR-, R0, F200, FMAX, M3",
)  # fmt: skip


def parse(body: str) -> Statement:
    """Read one block, without its number and comment; raise where it is not one of the read statements; the column is that of `body`."""
    found: Statement = read(_reader(), body, "start", _refused)
    return found


def words_of(text: str) -> list[Raw]:
    """Return the words of a part of a cycle: names and values, signs or nothing (NaN)."""
    found: list[Raw] = read(_reader(), text, "named_words", _refused)
    return found


def read(reader: Reader, text: str, start: str, refused: Callable[[Reader, str, str], BlockError]) -> Any:
    """Return what a text says by a grammar of this language, its faults what `refused` makes of them."""
    global _in_use
    _in_use = reader
    found = reader.parse(text, start)
    if reader.error >= 0:
        raise refused(reader, text, start)
    return found


#: The reader of the text whose rules run.
_in_use: Reader | None = None


def _column() -> int:
    return _in_use.begin + 1 if _in_use is not None else 0


@cache
def _reader() -> Reader:
    from cncgen.grammars import tables_heidenhain

    return Reader(tables_heidenhain, RULES)


def _refused(reader: Reader, text: str, start: str) -> BlockError:
    """Describe the text at which a block was refused."""
    before, first = text[: reader.error].lstrip(), text.split(maxsplit=1)[0] if text.strip() else ""
    if start == "start" and (not before or (first.isalpha() and len(before) < len(first))):
        # Letters of words may begin one that is none.
        word = " ".join(word.upper() for word in text.split()[:2] if word.isalpha())
        column = len(text) - len(text.lstrip()) + 1
        if first.upper() == "CONTOUR":
            message = f"{word}, contours joined by a formula, is not read"
            hint = "CYCL DEF 14.1 CONTOUR LABEL 1 /2 names pockets and islands"
            return BlockError("unsupported-block", message, column=column, hint=hint)
        return BlockError("unsupported-block", f"{word or first}: {_READ}", column=column, hint=_HINT)
    second = text[reader.error :].replace("(", " ").upper().partition(" ")[0]
    if second.isalpha() and before.upper().split() in (["SEL"], ["CALL"]):
        message = f"{before.strip().upper()} {second} is not read"
        hint = "SEL and CALL take PGM, SEL also PATTERN and TABLE, CALL also LBL and SELECTED PGM"
        return BlockError("unsupported-block", message, column=1, hint=hint)
    if second == "IS" and "IF" in before.upper().split():
        message = f"{' '.join(text[reader.error :].upper().split()[:2])} is not read: every parameter has a value here"
        hint = "FN 9: IF +Q1 EQU +0 GOTO LBL 5"
        return BlockError("unsupported-block", message, column=reader.error + 1, hint=hint)
    if second in _OF_TEXTS:
        message = f"{second}, a function of texts, is not read"
        return BlockError("unsupported-block", message, column=reader.error + 1, hint=_FORMULA_HINT)
    expected = reader.expected()
    if before.rstrip().endswith(("+", "-")):
        # A sign and its number are one token, so behind a sign alone the tables wait for Q.
        expected = [*expected, "NUMBER"]
    return refusal(text, reader.error, expected, LANGUAGE, _FORMULA_HINT if "=" in before else "")


# Values.


def number(text: str) -> float:
    """Return a number, its decimal sign a point or comma."""
    return float("".join(text.split()).replace(",", "."))


def _number_of(q: str) -> float:
    kind = q[1:2].upper()
    found = float(q[2:]) + _OWN_NUMBERS[kind] if kind in _OWN_NUMBERS else float(q[1:]) or _FIRST
    if found >= _BEYOND:
        message = f"{q.upper()} is not read: Q parameters go up to Q{_BEYOND - 1}"
        raise BlockError("parameter-number", message, column=_column(), hint="take a smaller number")
    return found


def _whole(digits: str) -> int:
    found = number(digits)
    if found > LARGEST:
        message = f"the number is not within ±{LARGEST:g}"
        raise BlockError("number-range", message, column=_column(), hint="take a smaller number")
    return int(found)


def _parameter(q: str) -> Value:
    return expressions.parameter(_number_of(q))


def _unary(sign: str, value: Value) -> Value:
    return expressions.negative(value, expressions.HEIDENHAIN) if sign == "-" else value


def _binary(a: Value, operator: str, b: Value) -> Value:
    return expressions.binary(expressions.OF_HEIDENHAIN[operator.upper()], a, b, expressions.HEIDENHAIN)


def _function(name: str, a: Value) -> Value:
    return expressions.unary(expressions.FUNCTIONS_OF_HEIDENHAIN[name.upper()], a, expressions.HEIDENHAIN)


# Words.


def _word(name: str, value: Value | str) -> tuple[str, Value]:
    return name.rstrip(": \t").upper(), number(value) if isinstance(value, str) else value


def _sense(name: str, sign: str) -> Raw:
    return f"{name.upper()}±", 1.0 if sign == "+" else -1.0


def _setting(name: str) -> Raw:
    """FMAX, FAUTO, RL, RR; a word without a value: its column."""
    return "".join(name.split()).upper(), float(_column())


def _radius(value: Value | str) -> Raw:
    """Return R0, which ends compensation, or a radius."""
    if value == "0":
        return "R0", 0.0
    return "R", number(value) if isinstance(value, str) else value


def _misplaced(name: str, value: Value) -> Raw:
    message = f"{name.upper()}: oversizes of a tool stand in TOOL CALL alone"
    hint = "TOOL CALL 5 Z S2000 DL+0.1 DR-0.02"
    raise BlockError("unsupported-block", message, column=_column(), hint=hint)


def _m_function(value: Value) -> Raw:
    if value in _NOT_READ:
        message = f"M{value:g} ({_NOT_READ[value]}) is not read"
        raise BlockError("unsupported-block", message, column=_column(), hint=_HINT)
    return ("M89" if value == 89.0 else "M"), value


def _corner(kind: str, size: Value, feed: Value | str = 0.0, *_: Value | str) -> Statement:
    """RND R, CHF: its size, and a feed of its own."""
    if isinstance(feed, str):
        feed = called_feed if "AUTO" in feed.upper() else _[0]
    return Statement("corner", data=(kind.upper(), size, feed))


def _turns_left_out(*axes: str) -> Raw:
    """M94: the axes whose whole turns count no longer, as the bits of a number."""
    return "M94", float(sum(1 << AXIS_INDEX[axis.lower().removeprefix("i")] for axis in axes))


def _retract(height: Value | str, *feed: Value | str) -> Raw:
    """M140 MB: the way back, and its own feed, 0 where it is a traverse: both are the value of one word."""
    way = 0.0 if isinstance(height, str) else height
    speed = feed[-1] if feed and feed[-1] is not None and not isinstance(feed[-1], str) else 0.0
    return "M140", cast("Value", (way, speed))


def _retraction(value: Value) -> Words:
    way, feed = cast("tuple[Value, Value]", value)
    return [("g", Own.RETRACT / 10.0), ("mb", way), ("mb_f", feed)]


def meant(words: Iterable[Raw]) -> Words:
    """Return the words of G-code that words of the plain language mean."""
    found: Words = []
    for name, value in words:
        index = AXIS_INDEX.get(name.lower())
        if index is not None:
            found.append((name.lower(), value))
            continue
        own = _MEANINGS[name](value) if name in _MEANINGS else [(name.lower(), value)]
        if _REMARK in own and _REMARK in found:
            own = [word for word in own if word[0] in ("m", "f") or word == ("g", 53.0)]
        found += own
    return found


def _step(index: int) -> Callable[[Value], Words]:
    """Return where an increment leads."""
    letter = "xyzabcuvw"[index]

    def meaning(value: Value) -> Words:
        here: Computed = lambda p: p.interpreter.state.position[index]  # noqa: E731
        return [(letter, expressions.joined_by(codes.ADD, here, value, expressions.HEIDENHAIN))]

    return meaning


def _of_a_turn(value: Value) -> Value:
    """Return the feed a minute of FU, a feed of each turn of the spindle; of FZ, of each tooth, for a tool with one."""
    return expressions.joined_by(
        codes.MULTIPLY, lambda p: p.interpreter.state.speed, value, expressions.HEIDENHAIN
    )


def called_feed(p: Parameters) -> float:
    """Return the feed of the last TOOL CALL that had one, which FAUTO takes."""
    plain = p.interpreter.plain_language
    if plain is None or plain.tool_feed <= 0.0:
        message = "FAUTO takes the feed of TOOL CALL, which has none"
        raise BlockError("feed-missing", message, "F", hint="TOOL CALL 5 Z S2000 F500")
    return plain.tool_feed


#: Meanings of the words that are not a letter of G-code.
_MEANINGS: dict[str, Callable[[Value], Words]] = {
    **{f"I{letter.upper()}": _step(index) for letter, index in AXIS_INDEX.items()},
    "RL": lambda column: [("g", 41.0)],
    "RR": lambda column: [("g", 42.0)],
    "FAUTO": lambda column: [("f", called_feed)],
    "FU": lambda value: [("f", _of_a_turn(value))],
    "FZ": lambda value: [("f", _of_a_turn(value)), _REMARK, ("remark", 3.0)],
    "DR±": lambda sense: [("dr", sense)],
    "M": lambda value: _FUNCTIONS.get(value, [("m", value)]),
    "M128": lambda value: [("g", Own.TIP / 10.0)],
    "M140": _retraction,
    **dict.fromkeys(("R0", "R±", "FMAX", "M89", "M90", "M94", "M103", ""), lambda value: []),
}
_MARKS = frozenset(("R0", "R±", "M89", "M94", "M103", "M128", "IX", "IY", "IA", "IB", "IC"))
#: Words of a refused block that are left out, one after another, for the place where it leads.
_MOST_LEFT_OUT = 16
#: Words of which a block has one: its feed, and the tool's side.
_OF_ONE = frozenset(("F", "FMAX", "FAUTO", "FU", "FZ")), frozenset(("R0", "RL", "RR", "R±"))


def _block(
    words: Words, raw: Iterable[Raw] = (), kind: str = "block", data: tuple[bool, ...] = ()
) -> Statement:
    return Statement(kind, words, data, marks_of(raw))


def marks_of(raw: Iterable[Raw]) -> Mapping[str, Value]:
    """Return the words that are no words of G-code, but functions that stay in force."""
    return {name: value for name, value in raw if name in _MARKS} or _NO_MARKS


def place(body: str) -> Words:
    """Return where a line or arc leads that was refused, and its feed, as far as it was read."""
    for _ in range(_MOST_LEFT_OUT):
        try:
            return place_of(parse(body))
        except BlockError as error:
            read = body[: (error.column or 1) - 1]
            # A block that ends too early is left without its last word.
            body = read if len(read) < len(body) else " ".join(body.split()[:-1])
        if not body.strip():
            break
    return []


def place_of(statement: Statement) -> Words:
    """Return where a line or arc leads, and its feed."""
    moves = any(letter == "g" and value in _LEADING for letter, value in statement.words)
    return [word for word in statement.words if word[0] in AXIS_INDEX or word[0] == "f"] if moves else []


def _is_fast(words: Iterable[Raw]) -> bool:
    return any(name == "FMAX" for name, _ in words)


# Blocks.


def line(words: Iterable[Raw]) -> Words:
    """L: a line, a traverse with FMAX, or functions alone."""
    own = meant(words)
    if any(letter in AXIS_INDEX for letter, _ in own):
        return [("g", 0.0 if _is_fast(words) else 1.0), *own]
    return own


def _refuse_two(words: Sequence[Raw]) -> None:
    """Raise where a block has two feeds, or two sides of the tool."""
    for family in _OF_ONE:
        found = [*dict.fromkeys(name for name, _ in words if name in family)]
        if len(found) > 1:
            message = f"{found[0]} and {found[1]} stand in one block".replace("±", "")
            raise BlockError("repeated-word", message, found[1].rstrip("±"), hint="a block has one of them")


def _motion(head: str, *words: Raw) -> Statement:
    name = head.strip().upper()
    _refuse_two(words)
    if name == "L":
        return _block(line(words), words)
    own, fast = meant(words), _is_fast(words)
    if name == "CC":
        feed = next((word for word, _ in words if word in _OF_ONE[0]), None)
        if feed is not None:
            message = f"CC moves nothing, and has no {feed}"
            raise BlockError("syntax", message, feed, hint="the feed stands in the arc behind it")
    if fast and name != "LP":
        column = next(int(value) for name, value in words if name == "FMAX" and isinstance(value, float))
        raise BlockError("syntax", "this is no traverse: FMAX", column=column, hint="F gives its feed")
    if name in ("CT", "CTP"):
        return _block(own, words, "tangent", (name == "CTP",))
    return _block([("g", _MOTIONS[name] / 10.0), *own, *([("fmax", 1.0)] if fast else [])], words)


def _alone(*words: Raw) -> Statement:
    """M functions, or an axis: a line along it alone (positioning parallel to an axis)."""
    first = words[0][0]
    _refuse_two(words)
    if first[:1] == "M":
        return _block(meant(words), words)
    if first.removeprefix("I").lower() not in AXIS_INDEX:
        raise BlockError("unsupported-block", f"{first}: {_READ}", column=1, hint=_HINT)
    own = line(words)
    if sum(letter in AXIS_INDEX for letter, _ in own) != 1:
        message = "a block that begins with an axis goes along that one alone"
        raise BlockError("unsupported-block", message, column=1, hint="L stands before more of them")
    return _block(own, words)


def _surface_line(*words: Raw) -> Statement:
    """LN: a line, the normal of the surface there, along which oversizes of the tool shift it, and the direction of the tool."""
    return _block([("g", 0.0 if _is_fast(words) else 1.0), *meant(words), _REMARK, ("remark", 4.0)], words)


def _tool_number(text: str) -> float:
    """Return the number of a tool, with the index behind its point."""
    whole, found = _whole(text), number(text)
    return float(whole) if whole == found else found


def _tool_axis(letter: str) -> Raw:
    if letter.upper() != "Z":
        column = _column()
        raise BlockError("unsupported-block", "the tool's axis must be Z", column=column, hint=_HINT)
    return "", 0.0


def _tool_call(tool: Value | tuple[Computed] | None, *words: Raw) -> Statement:
    """TOOL CALL: the tool into the spindle, its length in force, its speed."""
    sizes = {"DL": 0.0, "DR": 0.0} | {name: value for name, value in words if name in ("DL", "DR")}
    given = [name for name, _ in words if name in ("DL", "DR", "DR2")]
    oversize: Words = [("dl", sizes["DL"]), ("dr_", sizes["DR"])]
    rest = meant(word for word in words if word[0] not in ("DL", "DR", "DR2"))
    if any(letter == "f" for letter, _ in rest):
        rest.append(("g", Own.TOOL_FEED / 10.0))
    if any(name == "DR2" and value != 0.0 for name, value in words):
        rest += [_REMARK, ("remark", 5.0)]
    if tool is None:
        rest = [
            ("s", _turns(_tool_in_spindle, value)) if letter == "vc" else (letter, value)
            for letter, value in rest
        ]
        if given:
            # Oversizes alone are those of the tool in the spindle.
            rest = [("t", _tool_in_spindle), ("g", Own.OVERSIZE / 10.0), *oversize, ("g", 43.0), *rest]
        return _block(rest, words)
    found = tool[0] if isinstance(tool, tuple) else tool
    if isinstance(found, float) and not found.is_integer():
        # TOOL CALL 5.1: a second length and radius of tool 5, in a row of their own.
        found = float(math.floor(found))
        rest += [_REMARK, ("remark", 7.0)]
    rest = [("s", _turns(found, value)) if letter == "vc" else (letter, value) for letter, value in rest]
    if isinstance(tool, tuple) and _REMARK not in rest:
        rest += [_REMARK, ("remark", 1.0)]
    if found == 0.0:
        return _block([("t", found), ("m", 6.0), ("g", 49.0), *rest], words)
    return _block(
        [("t", found), ("m", 6.0), ("g", 43.0), ("g", Own.OVERSIZE / 10.0), *oversize, *rest], words
    )


def _cutting_speed(name: str, value: Value) -> Raw:
    """S( VC = 120 ): the speed of the tool's edge, m a minute."""
    if name.upper() != "S":
        raise BlockError("syntax", f"{name} has no VC", column=_column(), hint="TOOL CALL 5 Z S( VC = 120 )")
    return "VC", value


def _turns(tool: Value, cutting_speed: Value) -> Value:
    """Return the speed of a spindle at which the edge of a tool has a speed."""

    def turns(p: Parameters) -> float:
        number, ip = round(evaluate(tool, p)), p.interpreter
        found = ip.tools.find(number)
        if found is None or found.diameter <= 0.0:
            message = f"VC gives the speed of the edge of tool {number}, whose diameter is not known"
            raise BlockError("speed-missing", message, "S", hint="--tool-table gives it; S1000 is a speed")
        if ip.state.inches:
            message = (
                "VC of a program in INCH is read as metres a minute; a control may count it in feet a minute"
            )
            ip.warn_once("feed-inch", message, "S", "S1000 is a speed without doubt")
        return (
            1000.0
            * evaluate(cutting_speed, p)
            / (math.pi * found.diameter * (INCH if ip.options.inch_tables else 1.0))
        )

    return turns


def _tool_sizes(tool: Value | tuple[Computed] | None, *words: Raw) -> Statement:
    """TOOL DEF: length and radius of a tool; without them, it makes the tool ready."""
    names = {"L": "l_size", "R": "r_size", "R0": "r_size"}
    if isinstance(tool, float) and not tool.is_integer():
        return Statement("block", [_REMARK, ("remark", 7.0)])
    other = next((name for name, _ in words if name and name not in names), None)
    if other is not None:
        message = f"TOOL DEF has no word {other.rstrip('±')}"
        raise BlockError(
            "syntax", message, other.rstrip("±"), hint="TOOL DEF 5 L+80 R+4 has length and radius"
        )
    sizes = {names[name]: value for name, value in words if name in names}
    if not sizes or tool is None or isinstance(tool, tuple):
        return Statement("block")
    return Statement("block", [("g", Own.TOOL_SIZES / 10.0), ("tool", tool), *sizes.items()])


def _tool_in_spindle(p: Parameters) -> float:
    return float(p.interpreter.state.tool)


def _tool_named(name: str) -> tuple[Computed]:
    """Return the number of the tool that the table has under a name, or under the text of a parameter QS, 0 for none."""

    def numbered(p: Parameters) -> float:
        known = p.interpreter.plain_language
        bare = name.strip('"') if name[:1] == '"' else known.texts.get(_whole(name[2:]), "") if known else ""
        return float(p.interpreter.tools.named(bare) or 0) if bare else 0.0

    return (numbered,)


def _cycle(head: str, rest: str | None) -> Statement:
    """CYCL DEF: its number, its part or None, and the text behind."""
    digits, _, part = "".join(head.split()).partition(".")
    return Statement("cycle", data=(_whole(digits), str(_whole(part)) if part else None, rest or ""))


def tolerance(words: Iterable[Raw]) -> Words:
    """Return what words of cycle 32.1 mean, the tolerance of the path."""
    return [("g", 64.0), *(("p", value) for name, value in words if name == "T")]


def _cycle_call(places: str | None, *words: Raw) -> Statement:
    """CYCL CALL, at the tool's place, at one that stands behind POS, or at those of a pattern (PAT)."""
    call = ("g", Own.CYCLE_CALL / 10.0)
    if places is None:
        return _block([call, *(word for word in meant(words) if word != call)], words)
    if places.upper() == "POS":
        return _block(line([*words, ("FMAX", 0.0)]), words, "call_at")
    return _block([("g", 0.0 if _is_fast(words) else 1.0), *meant(words)], words, "call_pattern")


def _stop(*words: Raw) -> Statement:
    """STOP: M0, in place of an M0 or M1 that stands beside it."""
    own = meant(words)
    return _block([("m", 0.0), *(word for word in own if word not in (("m", 0.0), ("m", 1.0)))], words)


def _begin_program(name: str = "") -> Statement:
    inches = name.upper().split()[-1:] == ["INCH"]
    doubt: Words = [_REMARK, ("remark", 20.0)] if inches else []
    return Statement("block", [("g", 20.0 if inches else 21.0), ("g", 90.0), *doubt])


def _operation(fn: str, q: str, a: Value, operator: str, b: Value) -> Statement:
    """FN 1 to FN 4, FN 8, FN 13."""
    wanted = _OPERATORS.get(fn.upper().removeprefix("FN").strip().lstrip("0"), (operator.upper(),))
    if operator.upper() not in wanted:
        message = f"{operator} in FN {fn[2:].strip()} where {wanted[0]} was expected"
        raise BlockError("syntax", message, "FN", hint="FN 1: Q1 = +Q2 + +5")
    return Statement("set", data=(_number_of(q), _binary(a, operator, b)))


def _function_unread(text: str) -> Statement:
    name = " ".join(text.upper().split()[:2])
    hint = "FUNCTION TCPM, RESET TCPM, DWELL and MODE MILL are"
    raise BlockError("unsupported-block", f"FUNCTION {name} is not read", "FUNCTION", hint=hint)


def _tip_on(*parts: str) -> Statement:
    """FUNCTION TCPM, whose data are its words by twos (TNC 640, "FUNCTION TCPM")."""
    words = " ".join(parts).upper().split()
    return Statement("tip_on", [("g", Own.TIP / 10.0)], data=tuple(pairwise(words)))


def _kind(kind: str) -> Callable[..., Statement]:
    """Return the function of a rule whose parts are data of its statement."""
    return lambda *parts: Statement(kind, data=parts)


_EMPTY = Statement("block")
RULES: dict[str, Callable[..., Any]] = {
    "start": lambda statement=_EMPTY: statement,
    "number": number, "parameter": _parameter, "signed_parameter": lambda sign, q: _unary(sign, _parameter(q)), "pi": lambda: math.pi, "unary": _unary,
    "binary": _binary, "function": _function,
    "word": _word, "word_shortened": lambda name, value: _word(name, value[1:]), "sense": _sense, "setting": _setting,
    "radius": _radius, "paraxial": lambda sign: _sense("R", sign), "misplaced": _misplaced, "m_function": _m_function,
    "nothing": lambda *parts: ("", 0.0), "idle": lambda *parts: ("M90", 0.0), "turns_left_out": _turns_left_out,
    "tip": lambda *parts: ("M128", 0.0), "retract": _retract,
    "plunge": lambda feed, percent: ("M103", percent or 0.0),
    "normal": lambda name, value: (name.upper(), value), "orientation": lambda name, value: (name.upper(), value),
    "length_of_tool": lambda value: ("L", value), "cutting_speed": _cutting_speed, "diameter": lambda value: ("D", value),
    "named_words": lambda *words: list(words), "flag": lambda name: (name.upper().strip(), math.nan),
    "motion": _motion, "surface_line": _surface_line, "words": _alone, "corner": _corner,
    "way": lambda kind, form, *words: Statement("way", data=(kind.upper(), form.upper(), words)),
    "free": lambda head, *words: Statement("free", data=(head.upper(), words)),
    "select": lambda digits: Statement("select", data=(_whole(digits),)),
    "tool_call": _tool_call, "tool_sizes": _tool_sizes, "tool_axis": _tool_axis, "tool_name": _tool_named,
    "tool_number": _tool_number,
    "cycle": _cycle, "cycle_call": _cycle_call, "stop": _stop, "label": lambda name: name.strip('"').upper(), "label_here": _kind("label"), "call": _kind("call"),
    "repeats": lambda times, *_: times,
    **{rule: _kind(rule) for rule in ("call_program", "select_program", "call_selected", "select_pattern", "select_table", "plane", "transform")},
    "tip_on": _tip_on, "tip_off": lambda *_: Statement("block", [("g", Own.TIP_OFF / 10.0)]),
    "pauses": lambda *_: Statement("block", [_REMARK, ("remark", 6.0)]), "function_unread": _function_unread,
    "pattern": lambda kind, *words: (kind.upper().rstrip("0123456789"), dict(words)),
    "pattern_def": _kind("pattern_def"), "pattern_more": _kind("pattern_more"),
    "dwell": lambda unit, value: Statement("dwell", data=(unit.upper(), value)),
    "global_def": lambda *_: Statement("global_def"),
    "begin_program": _begin_program, "end_program": lambda *_: Statement("end_program", [("m", 2.0)]),
    "text": lambda name, text: Statement("text", data=(_whole(name[2:]), text)), "passed": lambda *_: Statement("passed"),
    "preset": lambda text: Statement("preset", data=(text,)), "probe": lambda *_: Statement("block", [_REMARK, ("remark", 40.0)]),
    "assignment": lambda q, value: Statement("set", data=(_number_of(q), value)),
    "fn_assignment": lambda fn, q, value: Statement("set", data=(_number_of(q), value)),
    "feed_of_parameter": lambda q, word: Statement("feed", data=(_number_of(q), word.upper().lstrip("F \t"))),
    "fn_feed": lambda fn, q, word: Statement("feed", data=(_number_of(q), word.upper().lstrip("F \t"))),
    "predefined": lambda q, *_: Statement("predefined", data=(int(_number_of(q)),)),
    "operation": _operation,
    "one_operand": lambda fn, q, name, a: Statement("set", data=(_number_of(q), _function(name, a))),
    "jump": lambda fn, a, how, b, label: Statement("jump", data=(_binary(a, how, b), label)),
    "alarm": lambda fn, text: Statement("alarm", data=(text or "",)),
    "system_data": lambda fn, q, *asked: Statement("system_data", data=(_number_of(q), *asked)),
    "write_data": lambda fn, *given: Statement("write_data", data=given),
    "open_table": lambda fn, name: Statement("open_table", data=(name,)),
    "write_table": lambda fn, row, _slash, *given: Statement("write_table", data=(row, *given)),
    "function_unknown": lambda fn, *_: Statement("function_unknown", data=("".join(c for c in fn if c.isdigit()),)),
}  # fmt: skip

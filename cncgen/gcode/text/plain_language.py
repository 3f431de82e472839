"""Heidenhain's plain language: one block of text to `Parsed`.

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

import re
from collections.abc import Callable

from cncgen.gcode.block import (
    AXIS_INDEX,
    CIRCLE,
    CYCLE,
    CYCLE_CALL,
    OVERSIZE,
    POLAR_ARC,
    POLAR_LINE,
    POLE,
    RADIUS_ARC,
    REMARK,
    RETRACT,
    SPL,
    TIP,
    TIP_OFF,
    TOOL_FEED,
    TOOL_SIZES,
    Computed,
    Parsed,
    Value,
)
from cncgen.gcode.errors import BlockError
from cncgen.gcode.text import expressions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.state.parameters import Parameters

Words = list[tuple[str, Value]]
#: Reads a block from behind its name on.
_Reader = Callable[[str, int], Words]

_VALUE = r"\s*(?P<value>(?:[+-]\s*)?(?:Q[0-9]+|(?:[0-9]+[.,]?[0-9]*|[.,][0-9]+)(?:E[+-]?[0-9]+)?))"
_WORD = re.compile(
    r"\s*(?:(?P<fast>F\s*MAX)|(?P<auto>F\s*AUTO)|(?P<keep>[FRM])(?=\s+[A-Z]|\s*\Z)|DR(?P<sense>[+-])(?![0-9])|(?P<side>R[0LR])(?![\w.])"
    r"|M140\s+MB\s*(?P<retract>MAX|[0-9]+[.,]?[0-9]*)|(?P<ahead>M(?:120(?:\s+LA\s*[0-9]+)?|112(?:\s+[TA]\s*[0-9.,]+)*|118(?:\s+[XYZABCUVW]\s*[-+0-9.,Q]+)*|124(?:\s+T\s*[0-9.,]+)?|138(?:\s+[ABC](?![A-Z0-9+-]))*|90))(?![0-9])"
    r"|(?P<tip>M128(?:\s*F\s*(?:MAX|Q?[0-9.,]+))?)(?![0-9])"
    rf"|(?:(?P<coefficient>K[123][XYZABCUVW])|(?P<step>I)?(?:(?P<polar>P[RA])|(?P<axis>[XYZABCUVW]))|(?P<letter>F[UZ]|[FMSR])){_VALUE})",
    re.IGNORECASE,
)
_SETTING = re.compile(rf"\s*(?:FN\s*0\s*:\s*)?Q(?P<number>[0-9]+)\s*={_VALUE}\s*\Z", re.IGNORECASE)
_TOOL = re.compile(
    r"\s*(?:(?P<number>Q?[0-9]+)(?:\.[0-9])?|(?P<name>\"[^\"]*\"|QS[0-9]+))?\s*(?P<axis>[XYZUVW](?![\w+-]))?",
    re.IGNORECASE,
)
_CYCLE = re.compile(r"\s*(?P<number>[0-9]+)(?:\s*\.(?P<part>[0-9]+))?(?P<rest>.*)", re.DOTALL)
_TOLERANCE = re.compile(rf"\s*T{_VALUE}", re.IGNORECASE)
#: A datum shift by a line of a table, or by an increment.
_NO_SHIFT = re.compile(r"\s*(?:#|I[XYZABCUVW])", re.IGNORECASE)
#: Q parameters of a program and those that are kept, QL1 and QR1, and what is added to their numbers: Q ends at Q1999.
_OWN_Q = re.compile(r"\"[^\"]*\"|Q(?P<kind>[LR])(?P<number>[0-9]{1,3})(?![0-9])", re.IGNORECASE)
_OWN_NUMBERS = {"L": 3000, "R": 3500}
#: A line of PATTERN DEF, whose points stand in parentheses.
_POINTS = re.compile(
    r"\s*(?:N?\d+\s+)?(?:PATTERN\s+DEF|(?:POS|ROW|PAT|FRAME|(?:PITCH)?CIRC)\d)", re.IGNORECASE
)
_COMMENT = re.compile(r"\s*(?:N?\d+\s*)?(?:;|\*|\Z)", re.IGNORECASE)
#: The number of a block, which simulators write with N.
_NUMBERED = re.compile(r"\s*(?:N?\d+\s+)?", re.IGNORECASE)
#: Cycles that are data of the control, not motions: datum shift, tolerance.
_DATUM_SHIFT, _PATH_TOLERANCE = 7, 32
#: Cycles that CYCL CALL and M99 run have numbers from here on.
_FIRST_CALLED = 200
#: M functions that stand for several of G-code, or for another one.
_FUNCTIONS: dict[float, Words] = {
    13.0: [("m", 3.0), ("m", 8.0)],
    14.0: [("m", 4.0), ("m", 8.0)],
    91.0: [("g", 53.0)],
    92.0: [("g", 53.0), ("g", REMARK / 10.0), ("remark", 92.0)],
    99.0: [("g", CYCLE_CALL / 10.0)],
    129.0: [("g", TIP_OFF / 10.0)],
    136.0: [("g", 95.0)],
    137.0: [("g", 94.0)],
    **{number: [("g", REMARK / 10.0), ("remark", number)] for number in (97.0, 98.0)},
    **{number: [("m", number), ("g", REMARK / 10.0), ("remark", number)] for number in (109.0, 110.0, 116.0)},
}
#: M functions that change the meaning of motions.
_NOT_READ = {
    89.0: "a cycle called in each block",
    114.0: "positions of the rotary axes in the program's coordinates",
    130.0: "points in untilted coordinates",
    144.0: "the kinematics of the rotary axes",
}
_HINT = "--dialect reads other texts as G-code"
_WORDS_HINT = "a word is letters with a value: X+10, IY-2.5, X+Q1, DR-, R0, F200, FMAX, M3"
#: Words of TOOL CALL that add to a tool's length, radius and radius of its corner.
_OVERSIZE = re.compile(rf"(?P<kind>D(?:L|R2|R)(?!2)){_VALUE}", re.IGNORECASE)
#: Words of TOOL DEF.
_SIZES = re.compile(rf"(?<![A-Z0-9])(?P<kind>[LR]){_VALUE}", re.IGNORECASE)
#: Words of LN: the normal of the surface, the direction of the tool's axis.
_NORMAL = re.compile(rf"\bN[XYZ]{_VALUE}", re.IGNORECASE)
_ORIENTATION = re.compile(rf"\bT[XYZ]{_VALUE}", re.IGNORECASE)
#: Motions that end where their axis words say.
_LEADING = re.compile(r"\s*(?:N?\d+\s+)?(?:L|C|CR)(?=[\sXYZABCUVWI])", re.IGNORECASE)
_PLACE = re.compile(rf"(?<![A-Z])(?P<step>I)?(?P<axis>[XYZABCUVWF]){_VALUE}", re.IGNORECASE)


def parse(text: str) -> Parsed:
    """Read one block.

    Raises:
        BlockError: It is not one of the read statements; the column is that of `text`.
    """
    parsed = Parsed()
    body = body_of(text)
    if not body or _COMMENT.match(body):
        return parsed
    setting = _SETTING.match(body, _begin(body))
    if setting:
        parsed.settings = [(float(setting["number"]), _value(setting["value"]))]
        return parsed
    for head, read in _BLOCKS:
        match = head.match(body, _begin(body))
        if match:
            parsed.words = read(body, match.end())
            return parsed
    column = _begin(body) + 1
    word = re.match(r"[A-Z]+(?:\s+[A-Z]+)?", body[column - 1 :], re.IGNORECASE)
    named = f"{' '.join(word[0].upper().split())}: " if word else ""
    raise BlockError(
        "unsupported-block",
        f"{named}of the plain language L, LN, LP, CC, C, CR, CP, CT, RND, CHF, APPR, DEP, SPL, TOOL CALL, CYCL DEF, LBL, CALL LBL, FN are read",
        column=column,
        hint=_HINT,
    )


def body_of(text: str, *, formula: bool = False) -> str:
    """Return a line without its comment. A comment begins with ;, or stands in parentheses behind words, as simulators write it, where the
    line is not the rest of a formula."""
    body = _OWN_Q.sub(_numbered, text.partition(";")[0])
    if "(" in body and "=" not in body and not formula and not _POINTS.match(body):
        body = body.partition("(")[0]
    return body.rstrip().rstrip("~").rstrip()


def _numbered(name: re.Match[str]) -> str:
    return f"Q{_OWN_NUMBERS[name['kind'].upper()] + int(name['number'])}" if name["kind"] else name[0]


def place(text: str) -> Words:
    """Return where a motion leads that was refused as a whole, and its feed."""
    body = body_of(text)
    match = _LEADING.match(body)
    words: Words = []
    for word in _PLACE.finditer(body, match.end()) if match else ():
        letter = word["axis"].lower()
        try:
            value = _value(word["value"])
        except BlockError:  # an unknown parameter was reported when the line was read
            continue
        steps = word["step"] and letter in AXIS_INDEX
        words.append((letter, _step(AXIS_INDEX[letter], value) if steps else value))
    return words


def _begin(body: str) -> int:
    """Return where a block begins behind its number."""
    match = _NUMBERED.match(body)
    assert match
    return match.end()


def _value(text: str) -> Value:
    """Return a number, its decimal sign a point or comma, or a Q parameter."""
    bare = "".join(text.split()).upper().replace(",", ".")
    sign = bare[0] == "-"
    bare = bare.lstrip("+-")
    if bare[0] != "Q":
        return -float(bare) if sign else float(bare)
    value = expressions.parameter(float(bare[1:]))
    return expressions.negative(value) if sign else value


def _words(body: str, at: int) -> tuple[Words, bool]:
    """Return the words from a place on, and whether FMAX is among them."""
    words: Words = []
    fast = False
    while at < len(body):
        match = _WORD.match(body, at)
        if match is None:
            rest = body[at:].lstrip()
            column = len(body) - len(rest) + 1
            oversize = _OVERSIZE.match(rest)
            if oversize:
                message = f"{oversize[0].upper()}: oversizes of a tool stand in TOOL CALL alone"
                hint = "TOOL CALL 5 Z S2000 DL+0.1 DR-0.02"
                raise BlockError("unsupported-block", message, column=column, hint=hint)
            message, hint = "this is no word of a block of the plain language", _WORDS_HINT
            raise BlockError("syntax", message, column=column, hint=hint)
        at = match.end()
        fast = fast or match["fast"] is not None
        if match["side"] and match["side"].upper() != "R0":
            words.append(("g", 41.0 if match["side"].upper() == "RL" else 42.0))
        own = _word(match)
        if ("g", REMARK / 10.0) in own and ("g", REMARK / 10.0) in words:
            own = [word for word in own if word[0] in ("m", "f") or word == ("g", 53.0)]
        words += own
    return words, fast


def _word(match: re.Match[str]) -> Words:
    """Return the meaning of a word."""
    if match["sense"]:
        return [("dr", 1.0 if match["sense"] == "+" else -1.0)]
    if match["retract"]:
        upwards = match["retract"].upper()
        return [("g", RETRACT / 10.0), ("mb", 0.0 if upwards == "MAX" else float(upwards.replace(",", ".")))]
    if match["tip"]:
        # F of M128 bounds the moves that keep the tip in place, which the machine's own limits do here.
        return [("g", TIP / 10.0)]
    if match["auto"]:
        return [("f", _called_feed)]
    if match["value"] is None:
        # F, R and M alone change nothing. M120 LA looks ahead under radius compensation, as is done here always; M112, M118, M124 and M138 are settings of the control.
        return []
    value = _value(match["value"])
    if match["axis"]:
        index = AXIS_INDEX[match["axis"].lower()]
        return [(match["axis"].lower(), _step(index, value) if match["step"] else value)]
    if match["polar"]:
        return [((match["step"] or "").lower() + match["polar"].lower(), value)]
    if match["letter"] in ("M", "m") and isinstance(value, float):
        if value in _NOT_READ:
            message = f"M{value:g} ({_NOT_READ[value]}) is not read"
            raise BlockError("unsupported-block", message, column=match.start("letter") + 1, hint=_HINT)
        return _FUNCTIONS.get(value, [("m", value)])
    letter = (match["coefficient"] or match["letter"]).lower()
    if letter == "fu":
        return [("f", _of_a_turn(value))]
    if letter == "fz":
        return [("f", _of_a_turn(value)), ("g", REMARK / 10.0), ("remark", 3.0)]
    return [(letter, value)]


def _step(index: int, value: Value) -> Computed:
    """Return where an increment leads."""
    return lambda p: p.interpreter.state.position[index] + expressions.evaluate(value, p)


def _of_a_turn(value: Value) -> Computed:
    """Return the feed a minute of FU, a feed of each turn of the spindle; of FZ, of each tooth, for a tool with one."""
    return lambda p: p.interpreter.state.speed * expressions.evaluate(value, p)


def _called_feed(p: Parameters) -> float:
    """Return the feed of the last TOOL CALL that had one, which FAUTO takes."""
    plain = p.interpreter.plain_language
    if plain is None or plain.tool_feed <= 0.0:
        message = "FAUTO takes the feed of TOOL CALL, which has none"
        raise BlockError("feed-missing", message, "F", hint="TOOL CALL 5 Z S2000 F500")
    return plain.tool_feed


def _line(body: str, at: int) -> Words:
    """L: a line, a traverse with FMAX, or functions alone."""
    words, fast = _words(body, at)
    if any(letter in AXIS_INDEX for letter, _ in words):
        return [("g", 0.0 if fast else 1.0), *words]
    return words


def _axis(body: str, at: int) -> Words:
    """A block that begins with an axis: a line along it alone (positioning parallel to an axis)."""
    words = _line(body, at)
    if sum(letter in AXIS_INDEX for letter, _ in words) != 1:
        message = "a block that begins with an axis goes along that one alone"
        raise BlockError("unsupported-block", message, column=at + 1, hint="L stands before more of them")
    return words


def _surface_line(body: str, at: int) -> Words:
    """LN: a line, and the normal of the surface there, along which oversizes of the tool shift it."""
    turned = _ORIENTATION.search(body, at)
    if turned:
        message = "TX, TY, TZ of LN, the direction of the tool's axis, are not read"
        hint = "M128 with A, B, C turns the tool on a machine with kinematics"
        raise BlockError("unsupported-block", message, column=turned.start() + 1, hint=hint)
    bare = _NORMAL.sub(lambda normal: " " * len(normal[0]), body[at:])
    return [*_line((body[:at] + bare).rstrip(), at), ("g", REMARK / 10.0), ("remark", 4.0)]


def _motion(number: int, *, fast_too: bool = False) -> _Reader:
    """Return the reader of a motion of its own."""

    def read(body: str, at: int) -> Words:
        words, fast = _words(body, at)
        if fast and not fast_too:
            column = body.upper().index("F", at) + 1
            raise BlockError("syntax", "this is no traverse: FMAX", column=column, hint="F gives its feed")
        return [("g", number / 10.0), *words, *([("fmax", 1.0)] if fast else [])]

    return read


def _tool_call(body: str, at: int) -> Words:
    """TOOL CALL: the tool into the spindle, its length in force, its speed."""
    head = _TOOL.match(body, at)
    assert head
    sizes: Words = [("dl", 0.0), ("dr_", 0.0)]
    corner: Words = []
    for oversize in _OVERSIZE.finditer(body, head.end()):
        kind, value = oversize["kind"].upper(), _value(oversize["value"])
        if kind != "DR2":
            sizes.append(("dl" if kind == "DL" else "dr_", value))
        elif value != 0.0:
            corner = [("g", REMARK / 10.0), ("remark", 5.0)]
    sizes = list(dict(sizes).items())
    bare = _OVERSIZE.sub(lambda size: " " * len(size[0]), body[head.end() :])
    rest, _ = _words((body[: head.end()] + bare).rstrip(), head.end())
    if head["axis"] and head["axis"].upper() != "Z":
        column = head.start("axis") + 1
        raise BlockError("unsupported-block", "the tool's axis must be Z", column=column, hint=_HINT)
    if any(letter == "f" for letter, _ in rest):
        rest.append(("g", TOOL_FEED / 10.0))
    rest += corner
    if head["number"] is None and not head["name"]:
        if len(sizes) and _OVERSIZE.search(body, head.end()):
            # Oversizes alone are those of the tool in the spindle.
            return [("t", _tool_in_spindle), ("g", OVERSIZE / 10.0), *sizes, ("g", 43.0), *rest]
        return rest
    number = _tool_named(head["name"].strip('"')) if head["name"] else _value(head["number"])
    if head["name"] and ("g", REMARK / 10.0) not in rest:
        rest += [("g", REMARK / 10.0), ("remark", 1.0)]
    if number == 0.0:
        return [("t", number), ("m", 6.0), ("g", 49.0), *rest]
    return [("t", number), ("m", 6.0), ("g", 43.0), ("g", OVERSIZE / 10.0), *sizes, *rest]


def _tool_sizes(body: str, at: int) -> Words:
    """TOOL DEF: length and radius of a tool; without them, it makes the tool ready."""
    sizes = {size["kind"].lower() + "_size": _value(size["value"]) for size in _SIZES.finditer(body, at)}
    number = _TOOL.match(body, at)
    if not sizes or number is None or number["number"] is None:
        return []
    return [("g", TOOL_SIZES / 10.0), ("tool", _value(number["number"])), *sizes.items()]


def _tool_in_spindle(p: Parameters) -> float:
    """Return the number of the tool in the spindle."""
    return float(p.interpreter.state.tool)


def _tool_named(name: str) -> Computed:
    """Return the number of the tool that the table has under a name, 0 for none."""
    return lambda p: float(p.interpreter.tools.named(name) or 0)


def _cycle(body: str, at: int) -> Words:
    """CYCL DEF: a datum shift, the path's tolerance, or a cycle that is called."""
    match = _CYCLE.match(body, at)
    if match is None:
        raise BlockError("syntax", "CYCL DEF has no number", column=at + 1, hint=_HINT)
    number, part = int(match["number"]), match["part"]
    if number == _PATH_TOLERANCE:
        tolerance = _TOLERANCE.match(match["rest"])
        if part != "1":
            return []
        return [("g", 64.0), *([("p", _value(tolerance["value"]))] if tolerance else [])]
    if number == _DATUM_SHIFT and part == "0":
        return []
    if number == _DATUM_SHIFT and part and not _NO_SHIFT.match(match["rest"]):
        return [("g", 52.0), *_words(body, match.start("rest"))[0]]
    if number >= _FIRST_CALLED and part is None:
        return [("g", CYCLE / 10.0), ("cycle", float(number))]
    column = match.start("number") + 1
    raise BlockError("unsupported-block", f"CYCL DEF {number} is not read", column=column, hint=_HINT)


def _begin_program(body: str, at: int) -> Words:
    inches = body.split()[-1].upper() == "INCH"
    doubt: Words = [("g", REMARK / 10.0), ("remark", 20.0)] if inches else []
    return [("g", 20.0 if inches else 21.0), ("g", 90.0), ("g", 94.0), *doubt]


def _before(*first: tuple[str, Value], plain: bool = True) -> _Reader:
    """Return the reader of a block that says some words and, where `plain`, the others that stand in it."""

    def read(body: str, at: int) -> Words:
        own = _words(body, at)[0] if plain else []
        return [*first, *(word for word in own if word not in first)]

    return read


def _stop(body: str, at: int) -> Words:
    """STOP: M0, in place of an M0 or M1 that stands beside it."""
    own = _words(body, at)[0]
    return [("m", 0.0), *(word for word in own if word not in (("m", 0.0), ("m", 1.0)))]


def _probe(body: str, at: int) -> Words:
    """TCH PROBE, which needs the machine."""
    return [("g", REMARK / 10.0), ("remark", 40.0)]


def _nothing(body: str, at: int) -> Words:
    return []


_BLOCKS: tuple[tuple[re.Pattern[str], _Reader], ...] = tuple(
    (re.compile(head, re.IGNORECASE), read)
    for head, read in (
        (r"BEGIN\s+PGM\b", _begin_program),
        (r"END\s+PGM\b", _before(("m", 2.0), plain=False)),
        # A table of datums is read where a shift names its line.
        (r"BLK\s+FORM\b|DECLARE\s+STRING\b|SEL\s+TABLE\b", _nothing),
        (r"TOOL\s+DEF(?![A-Z])", _tool_sizes),
        (r"TOOL\s+CALL(?![A-Z])", _tool_call),
        (r"CYCL\s+DEF(?![A-Z])", _cycle),
        (r"CYCL\s+CALL\b", _before(("g", CYCLE_CALL / 10.0))),
        (r"STOP\b", _stop),
        (r"TCH\s+PROBE\b", _probe),
        # Texts are not kept; statements that use one report it.
        (r"QS[0-9]+\s*=|FN\s*(?:19|26|27)\s*:", _nothing),
        (r"SPL(?![A-Z])", _motion(SPL)),
        (r"LP(?![A-Z])", _motion(POLAR_LINE, fast_too=True)),
        (r"CC(?![A-Z])", _motion(POLE)),
        (r"CP(?![A-Z])", _motion(POLAR_ARC)),
        (r"CR(?![A-Z])", _motion(RADIUS_ARC)),
        (r"C(?=\s)", _motion(CIRCLE)),
        (r"LN(?=\s)", _surface_line),
        (r"L(?=\s|[XYZABCUVWI])(?!BL)", _line),
        (r"(?=M\s*[0-9])", _before()),
        (r"(?=I?[XYZABCUVW]\s*(?:[+-]\s*)?(?:[0-9.,]|Q[0-9]))", _axis),
    )
)

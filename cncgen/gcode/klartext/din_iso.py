"""Heidenhain's DIN/ISO: the language of TNCs in G functions, each block said as blocks of the plain language, which are then run.

```
%PART G71 *                          BEGIN PGM PART MM
N10 T1 G17 S3000 *                   TOOL CALL 1 Z S3000
N20 G00 G40 G90 X-10 Y+5 M3 *        L X-10 Y+5 R0 FMAX M3
N30 G01 G41 X+5 F200 *               L X+5 RL F200
N40 G26 R5 *                         (with N30: APPR LCT X+5 Y+5 R5 RL)
N50 I+50 J+50 *                      CC X+50 Y+50
N60 G02 X+95 Y+50 *                  C X+95 Y+50 DR-
```

The motion and G90 or G91 stay in force from block to block as they are run, so that a label is run with those of its call. What does not
depend on them is said when the text is read. (TNC 410, 426 and iTNC 530, "DIN/ISO programming"; the pilots' lists of G functions.)
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

from cncgen.gcode.errors import BlockError
from cncgen.gcode.klartext import lines
from cncgen.gcode.klartext.program_text import Frame
from cncgen.gcode.klartext.running import HeidenhainRunner
from cncgen.gcode.sinks.sink import Point
from cncgen.gcode.source import Source
from cncgen.grammars.terminals import HEIDENHAIN as TERMINALS

#: Signs of a text in DIN/ISO: its head, tool calls, labels, functions of Q and cycles as no program in plain language has them.
_N, _Q, _STRING = TERMINALS["BLOCK_NUMBER"], TERMINALS["Q"], TERMINALS["STRING"]
_TEXT = re.compile(
    rf"^[ \t]*%[^\n;]*?G7[01]\b|^[ \t]*/?[ \t]*(?=N){_N}[ \t]*"
    rf"(?:G98[ \t]*L|T\d+[ \t]*G1[789]|G99[ \t]*T|D\d\d[ \t]*Q|G2\d\d\b[^\n]*{_Q}[ \t]*=|[^\n;*]+\*[ \t\r]*$)".encode(),
    re.MULTILINE | re.IGNORECASE,
)
_NUMBER = rf"(?:[-+]?\s*{_Q}|{TERMINALS['SIGNED']})"
_HEAD = re.compile(r"%\s*(?P<name>[^\s*;]*?)\s*(?:G7(?P<unit>[01]))?\s*\Z", re.IGNORECASE)
#: G functions have so many digits at most.
_DIGITS_OF_G = 3
_LABEL = re.compile(rf"G98\s*L\s*(?P<name>{_STRING}|\d+)\s*\Z", re.IGNORECASE)
_CALL = re.compile(rf"L\s*(?P<name>{_STRING}|\d+)(?:\s*[.,]\s*(?P<times>\d+))?\s*\Z", re.IGNORECASE)
_CORNER = re.compile(r"G2(?P<kind>[45])\s*R\s*(?P<rest>.*)\Z", re.IGNORECASE | re.DOTALL)
_FUNCTION = re.compile(r"D\s*(?P<number>\d\d?)\b\s*(?P<rest>.*)\Z", re.IGNORECASE | re.DOTALL)
_PART = re.compile(
    rf"P\s*0?(?P<number>\d\d?)(?:\s+|(?=[-+]))(?P<value>{_STRING}|{_NUMBER}|[A-Z_][\w.:\\]*)", re.IGNORECASE
)
_CYCLE = re.compile(r"G(?P<number>[2-4]\d\d|12\d|139)\b(?P<rest>.*)\Z", re.IGNORECASE | re.DOTALL)
_OLD = re.compile(r"G(?P<number>8[3-6]|37|39)\b(?P<rest>.*)\Z", re.IGNORECASE | re.DOTALL)
_TOOL = re.compile(
    rf"(?:(?P<other>G(?:99|51))\s*|G(?P<plane>1[789])\s*)?T\s*(?P<tool>{_STRING}|{_Q}|{TERMINALS['NUMBER']})(?P<rest>.*)\Z",
    re.IGNORECASE | re.DOTALL,
)
_DATA = re.compile(r"G(?P<number>04|0?4|30|31|36|38|62|55)(?!\d)(?P<rest>.*)\Z", re.IGNORECASE | re.DOTALL)
#: Blocks that TNC 7 and TNC 640 write in DIN/ISO as in plain language.
_PLAIN = re.compile(
    r"(?:BEGIN|END|APPR|DEP|PLANE|FUNCTION|PATTERN|SEL|CALL|TRANS|FN|LBL|CYCL|TOOL|BLK|RND|CHF|SPL|DECLARE|TCH|STOP|F(?:POL|LT?|CT?))\b"
    rf"|{lines.SETTING}|\*|\Z",
    re.IGNORECASE,
)
_WORD = re.compile(
    rf"\s*(?:(?P<fast>F\s*MAX)|(?P<auto>F\s*AUTO)|(?P<tail>M\s*(?:140|118|120|128|112|124|138)\b.*)|(?P<letter>F[UZ]|D[LR]|[GXYZABCUVWIJKRHFSMT])\s*(?P<value>{_NUMBER}))",
    re.IGNORECASE | re.DOTALL,
)
_OPERATORS = {0: "", 1: "+", 2: "-", 3: "*", 4: "DIV", 5: "SQRT", 6: "SIN", 7: "COS", 8: "LEN", 9: "EQU", 10: "NE", 11: "GT", 12: "LT",
    13: "ANG"}  # fmt: skip
#: The cycles of P parameters, by their G function.
_OF_PARTS = {83: 1, 84: 2, 85: 17, 86: 18}
_LINES, _ARCS = (0, 1, 7, 10, 11), {2: -1, 12: -1, 3: 1, 13: 1}
_MOTIONS = (0, 1, 2, 3, 5, 6, 7, 10, 11, 12, 13, 15, 16)
_SIDES = {40: "R0", 41: "RL", 42: "RR", 43: "R+", 44: "R-"}
_READ = "G00 to G16, G24 to G31, G54, G62, G70 to G73, G79, G98 and the cycles are"
_POLES = {"I": "X", "J": "Y", "K": "Z"}
_PLANES = {17: "Z", 18: "Y", 19: "X"}


def is_iso(source: Source) -> bool:
    """Tell whether a text is in DIN/ISO."""
    return _TEXT.search(source.data) is not None


def _refused(what: str, hint: str, place: str) -> BlockError:
    return BlockError("unsupported-block", f"{what} of DIN/ISO is not read", place, hint=hint)


def said(body: str, opened: bool) -> list[str]:
    """Return a block that depends on no mode as blocks of the plain language; a motion as it stands.

    Args:
        body: The block, without number, comment and the * at its end.
        opened: Whether the program has begun.
    """
    if _PLAIN.match(body):
        return [body]
    head = _HEAD.match(body)
    if head:
        if head["unit"] is None and opened:
            return [f"CALL PGM {head['name']}"]
        name, unit = head["name"] or "1", "INCH" if head["unit"] == "0" else "MM"
        return [f"{'END' if opened else 'BEGIN'} PGM {name} {unit}"]
    for pattern, say in _SAID:
        match = pattern.match(body)
        if match:
            return say(match)
    return [body]


def _said_call(match: re.Match[str]) -> list[str]:
    repeats = bool((match["times"] or "").strip("0"))
    return [f"CALL LBL {match['name']}" + (f" REP {match['times']}" if repeats else "")]


def _said_corner(match: re.Match[str]) -> list[str]:
    return [f"{'CHF ' if match['kind'] == '4' else 'RND R'}{match['rest']}"]


def _parts(rest: str) -> dict[int, str]:
    return {int(part["number"]): part["value"] for part in _PART.finditer(rest)}


def _said_function(match: re.Match[str]) -> list[str]:
    """D00 to D14: FN."""
    number, rest = int(match["number"]), match["rest"]
    parts = _parts(rest)
    target = re.match(_Q, rest, re.IGNORECASE)
    name = f"D{number:02}"
    if number == 14:
        return [f"FN 14: ERROR = {parts.get(1, rest)}"]
    wanted = 3 if 9 <= number <= 12 else 1 if number in (0, 5, 6, 7) else 2
    if number not in _OPERATORS or not all(k in parts for k in range(1, wanted + 1)):
        raise _refused(f"{name} {rest}".rstrip(), "D00 to D14 with P01, P02 and P03 are", name)
    how = _OPERATORS[number]
    if wanted == 3:
        return [f"FN {number}: IF {parts[1]} {how} {parts[2]} GOTO LBL {parts[3].lstrip('+')}"]
    if target is None:
        raise _refused(f"{name} without Q", "D00 Q1 P01 +5 sets Q1", name)
    value = f"{parts[1]} {how} {parts[2]}" if wanted == 2 else f"{how} {parts[1]}"
    return [f"FN {number}: {target[0]} = {value}"]


def _said_cycle(match: re.Match[str]) -> list[str]:
    """G200 is CYCL DEF 200, G120 to G139 cycles 20 to 39, G4xx probing."""
    number = int(match["number"])
    if number >= 400:
        return ["TCH PROBE"]
    return lines.apart(f"CYCL DEF {number if number >= 200 else number - 100} {match['rest']}")


def _said_parts(match: re.Match[str]) -> list[str]:
    """G83 to G86, whose values are P01 and so on; G37 the contours of a cycle, G39 a program that calls run."""
    number, parts = int(match["number"]), _parts(match["rest"])
    if number == 37:
        return ["CYCL DEF 14.0", "CYCL DEF 14.1 CONTOUR LABEL " + " /".join(parts.values())]
    if number == 39:
        return ["CYCL DEF 12.0", f"CYCL DEF 12.1 PGM {parts.get(1, match['rest'].strip())}"]
    cycle = _OF_PARTS[number]
    return [f"CYCL DEF {cycle}.0", *(f"CYCL DEF {cycle}.{k} V {value}" for k, value in parts.items())]


def _said_tool(match: re.Match[str]) -> list[str]:
    """T1 G17 S500 calls a tool, G99 T1 L+0 R+5 defines one, G51 T2 makes one ready."""
    other, rest = (match["other"] or "").upper(), match["rest"]
    if other:
        return [f"TOOL DEF {match['tool']} {rest if other == 'G99' else ''}"]
    plane = re.search(r"G(1[789])", f"G{match['plane']} {rest}")
    words = re.sub(r"G(?:1[789]|40|90)(?!\d)", " ", rest)
    moves = re.search(r"[XYZABCUVWIJK]\s*[-+\dQ]", words)
    if moves or re.search(r"(?<![A-Z])G\s*\d", words):
        raise _refused("a tool call with a motion", "T1 G17 S500 stands alone", "T")
    return [f"TOOL CALL {match['tool']} {_PLANES[int(plane[1])] if plane else 'Z'} {words}"]


def _said_data(match: re.Match[str]) -> list[str]:
    """G04 a dwell, G30 and G31 the blank, G36 orientation, G38 a stop, G62 the tolerance, G55 probing."""
    number, rest = int(match["number"]), match["rest"].strip()
    if number == 4:
        return ["CYCL DEF 9.0", f"CYCL DEF 9.1 DWELL {rest.lstrip('Ff')}"]
    if number == 62:
        return ["CYCL DEF 32.0", f"CYCL DEF 32.1 {rest}"]
    return {30: ["BLK FORM 0.1"], 31: ["BLK FORM 0.2"], 36: ["CYCL DEF 13"], 38: [f"STOP {rest}"]}.get(
        number, ["TCH PROBE"]
    )


_SAID: tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], list[str]]], ...] = (
    (_LABEL, lambda match: [f"LBL {match['name']}"]),
    (_CALL, _said_call),
    (_CORNER, _said_corner),
    (_FUNCTION, _said_function),
    (_CYCLE, _said_cycle),
    (_OLD, _said_parts),
    (_TOOL, _said_tool),
    (_DATA, _said_data),
)


@dataclass(slots=True)
class _Words:
    """The words of a block: G functions, axes and polar words with I where G91 was in force, centres, others as they stand."""

    g: list[int] = field(default_factory=list)
    axes: list[str] = field(default_factory=list)
    poles: list[str] = field(default_factory=list)
    polar: list[str] = field(default_factory=list)
    bare: dict[str, str] = field(default_factory=dict)
    radius: str = ""
    feed: str = ""
    fast: bool = False
    tail: str = ""


@dataclass(slots=True)
class Modes:
    """The modes that stay in force from block to block: the motion, G91, the sense of the last arc; and the radius of a G27 that waits for its end."""

    motion: int = 1
    steps: bool = False
    sense: int = 1
    leaving: str = ""

    def statements(self, body: str, following: str = "") -> list[str]:
        """Return a block that moves, or changes modes, as blocks of the plain language; the block behind it may be G26.

        Raises:
            BlockError: A function is not read, or an arc has no end.
        """
        words = self._words(body)
        own = [g for g in words.g if g not in (*_MOTIONS, *_SIDES, 90, 91)]
        if own:
            return self._single(own, words)
        motion = next((g for g in words.g if g in _MOTIONS), None)
        self.motion = self.motion if motion is None else motion
        polar = self.motion >= 10
        before = [f"CC {' '.join(words.poles)}"] if words.poles else []
        side = next((_SIDES[g] for g in words.g if g in _SIDES), "")
        if words.radius and polar:
            words.polar.append(f"{'I' if self.steps else ''}PR{words.radius}")
        place = " ".join([*(words.polar if polar else ()), *words.axes])
        if not place:
            if motion in _ARCS and not before:
                hint = "X and Y give it; in polar coordinates, H"
                raise BlockError("arc-end", f"G{motion:02} has no end", f"G{motion:02}", hint=hint)
            rest = " ".join(part for part in (side, words.feed, words.tail) if part)
            return [*before, *([f"L {rest}"] if rest else [])]
        return [*before, *self._moves(place, side, words, following)]

    def _moves(self, place: str, side: str, words: _Words, following: str) -> list[str]:
        soft = re.match(
            rf"G26\s*R\s*(?P<radius>{_NUMBER})\s*(?P<feed>F\s*{_NUMBER})?", following, re.IGNORECASE
        )
        polar = "P" if self.motion >= 10 else ""
        fast = self.motion in (0, 10) or words.fast
        feed = "FMAX" if fast else words.feed
        before = [f"L {words.feed}"] if words.feed and (fast or soft) else []
        if self.leaving:
            if side != "R0" or self.motion not in _LINES:
                message = "G27 is followed by no line with G40, to where it leads"
                raise BlockError("approach-words", message, "G27", hint="G00 G40 X Y follows")
            text, self.leaving = f"DEP {polar}LCT {place} R{self.leaving} {words.tail}", ""
            return [text, *([f"L {words.feed}"] if words.feed else [])]
        if soft:
            if side not in ("RL", "RR") or self.motion not in _LINES:
                message = "G26 stands behind no line with G41 or G42"
                raise BlockError("approach-words", message, "G26", hint="G01 G41 X Y comes before")
            return [
                *before,
                f"APPR {polar}LCT {place} R{soft['radius']} {side} {soft['feed'] or ''} {words.tail}",
            ]
        tail = f"{side} {feed} {words.tail}"
        if self.motion in _LINES:
            return [*before, f"L{polar} {place} {tail}"]
        if self.motion in (6, 16):
            return [f"CT{polar} {place} {tail}"]
        self.sense = _ARCS.get(self.motion, self.sense)
        turn = f"DR{'+' if self.sense > 0 else '-'}"
        if polar:
            return [f"CP {place} {turn} {tail}"]
        return [f"CR {place} R{words.radius} {turn} {tail}" if words.radius else f"C {place} {turn} {tail}"]

    def _single(self, own: list[int], words: _Words) -> list[str]:
        """Return a block of a function that is no motion."""
        g, axes, step = own[0], " ".join(words.axes), "I" if self.steps else ""
        if g == 27 and words.radius:
            self.leaving = f"{words.radius} {words.feed}"
            return []
        simple = {
            26: [],
            29: ["CC"],
            79: ["CYCL CALL " + " ".join(part for part in (words.feed, words.tail) if part)],
            28: ["CYCL DEF 8.0", *([f"CYCL DEF 8.1 {' '.join(words.bare)}"] if words.bare else [])],
            54: ["CYCL DEF 7.0", *(f"CYCL DEF 7.{k} {axis}" for k, axis in enumerate(words.axes, 1))],
            72: ["CYCL DEF 11.0", f"CYCL DEF 11.1 SCL {words.feed[1:].strip()}"],
            73: ["CYCL DEF 10.0", f"CYCL DEF 10.1 {step}ROT{''.join(p.removeprefix('I').removeprefix('PA') for p in words.polar) or '+0'}"],
            80: ["CYCL DEF 19.0", f"CYCL DEF 19.1 {axes}"],
            17: [f"L {words.tail}"] if words.tail else [],
        }  # fmt: skip
        if g not in simple or len(own) > 1:
            name = " ".join(f"G{one:02}" for one in own)
            raise _refused(name, _READ, f"G{g:02}")
        return simple[g]

    def _words(self, body: str) -> _Words:
        """Return the words of a block; G90 and G91 stand before those that they are for."""
        words, at = _Words(), 0
        mirror = re.match(r"G28(?!\d)(?P<axes>[\sXYZABC]*)\Z", body, re.IGNORECASE)
        if mirror:
            words.g, words.bare = [28], dict.fromkeys(mirror["axes"].upper().split(), "")
            return words
        while at < len(body.rstrip()):
            match = _WORD.match(body, at)
            if match is None:
                if words.g and words.g[0] not in (*_MOTIONS, *_SIDES, 90, 91):
                    raise _refused(f"G{words.g[0]:02}", _READ, f"G{words.g[0]:02}")
                message = f"'{body[at:].split()[0]}' is no word of DIN/ISO"
                raise BlockError("syntax", message, hint="G01 G41 X+10 Y-2.5 F200 M3")
            at = match.end()
            if match["fast"]:
                words.fast = True
            elif match["auto"]:
                words.feed = "FAUTO"
            elif match["tail"]:
                words.tail += f" {match['tail']}"
            else:
                self._word(words, match["letter"].upper(), "".join(match["value"].split()))
        return words

    def _word(self, words: _Words, letter: str, value: str) -> None:
        step = "I" if self.steps else ""
        if letter == "G":
            if not value.isdecimal() or len(value.lstrip("0")) > _DIGITS_OF_G:
                raise _refused(f"G{value}", _READ, "G")
            g = int(value)
            words.g.append(g)
            if g in (90, 91):
                self.steps = g == 91
        elif letter in _POLES:
            words.poles.append(f"{step}{_POLES[letter]}{value}")
        elif letter in "XYZABCUVW":
            words.axes.append(f"{step}{letter}{value}")
        elif letter == "H":
            words.polar.append(f"{step}PA{value}")
        elif letter == "R":
            words.radius = value
        elif letter in ("F", "FU", "FZ"):
            words.feed = f"{letter}{value}"
        else:
            words.tail += f" {letter}{value}"


class IsoRunner(HeidenhainRunner):
    """One run of a program in DIN/ISO."""

    ends_with = "% at its end, or M30"
    plain = ""

    def _prepare(self) -> None:
        super()._prepare()
        self._modes = Modes()

    def _said(self, bare: str, *, begun: bool) -> list[str]:
        """Return a block as blocks of the plain language, where that depends on no mode."""
        body = re.sub(rf"\A\s*(?=N){_N}\s*", "", bare, flags=re.IGNORECASE).rstrip()
        body = body.removesuffix("*").strip() if body.strip() != "*" else ""
        try:
            return said(body, begun)
        except BlockError:
            return [body]

    def _run_block(self, frame: Frame, at: int, body: str) -> None:
        if _PLAIN.match(body):
            super()._run_block(frame, at, body)
            return
        said(body, True)
        following = self._following(at)
        behind = self._lines[following].body if following is not None else ""
        for statement in self._modes.statements(body, behind):
            super()._run_block(frame, at, statement)

    def _leads(self, at: int) -> Callable[[Point], complex | None] | None:
        modes, following = replace(self._modes), self._following(at)
        while following is not None:
            body = self._lines[following].body
            if not _PLAIN.match(body):
                for statement in modes.statements(body):
                    if statement.startswith("CC"):
                        self._plain(following, self._ahead(following, statement))
                    elif re.match(r"(?:L|C|CR|CP|LP) (?=.*[XYZAR][-+\dQ])", statement):
                        return partial(self._heading, following, self._ahead(following, statement))
            elif not re.match(r"RND|CHF|LBL", body):
                return super()._leads(at)
            following = self._following(following)
        return None

    def _draws(self, at: int) -> bool:
        return super()._draws(at) or not _PLAIN.match(self._lines[at].body)

"""Heidenhain's DIN/ISO: the language of TNCs in G functions. Its grammar hands on the statements of the plain language, which are run.

```
%PART G71 *                          BEGIN PGM PART MM
N10 T1 G17 S3000 *                   TOOL CALL 1 Z S3000
N20 G00 G40 G90 X-10 Y+5 M3 *        L X-10 Y+5 R0 FMAX M3
N30 G01 G41 X+5 F200 *               L X+5 RL F200
N40 G26 R5 *                         (with N30: APPR LCT X+5 Y+5 R5 RL)
N50 I+50 J+50 *                      CC X+50 Y+50
N60 G02 X+95 Y+50 *                  C X+95 Y+50 DR-
```

The motion and G90 or G91 stay in force from block to block as they are run, so that a label is run with those of its call: what the words
of a block mean is said then (`Modes`). (TNC 410, 426 and iTNC 530, "DIN/ISO programming"; the pilots' lists of G functions.)
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import cache, lru_cache
from typing import Any

from cncgen.gcode.block import Computed, Value
from cncgen.gcode.errors import BlockError
from cncgen.gcode.klartext import cycles, lines, older_cycles, programs
from cncgen.gcode.klartext.contour_lines import is_drawn, is_pole
from cncgen.gcode.klartext.program_text import UNREAD, Frame, Program
from cncgen.gcode.klartext.running import HeidenhainRunner
from cncgen.gcode.source import Source
from cncgen.gcode.text import plain_language
from cncgen.gcode.text.plain_language import Raw, Statement, Words, number
from cncgen.gcode.text.syntax_errors import Language, refusal
from cncgen.grammars.terminals import HEIDENHAIN as TERMINALS
from cncgen.kernels.grammar_values import Reader
from cncgen.records import dataclass, field, replace

#: Signs of a text in DIN/ISO: its head, tool calls, labels, functions of Q and cycles as no program in plain language has them.
_N, _Q = TERMINALS["BLOCK_NUMBER"], TERMINALS["Q"]
_TEXT = re.compile(
    rf"^[ \t]*%[^\n;]*?G7[01]\b|^[ \t]*/?[ \t]*(?=N){_N}[ \t]*"
    rf"(?:G98[ \t]*L|T\d+[ \t]*G1[789]|G99[ \t]*T|D\d\d[ \t]*Q|G2\d\d\b[^\n]*{_Q}[ \t]*=|[^\n;*]+\*[ \t\r]*$)".encode(),
    re.MULTILINE | re.IGNORECASE,
)
#: The number of a block, which is taken off before it is read.
_NUMBER = re.compile(rf"\A\s*(?=N){_N}\s*", re.IGNORECASE)
_DIGITS_OF_G = 3
#: By the number of a function of Q, its operator between or before P01 and P02.
_OPERATORS = {0: "", 1: "+", 2: "-", 3: "*", 4: "DIV", 5: "SQRT", 6: "SIN", 7: "COS", 8: "LEN", 9: "EQU", 10: "NE", 11: "GT", 12: "LT",
    13: "ANG", 14: ""}  # fmt: skip
_VALUES = {0: 1, 5: 1, 6: 1, 7: 1, 9: 3, 10: 3, 11: 3, 12: 3, 14: 1}
_ALARM = 14
#: The cycles of P parameters, by their G function, and the sense in which a pocket is milled.
_OF_PARTS = {74: 3, 75: 4, 76: 4, 77: 5, 78: 5, 83: 1, 84: 2, 85: 17, 86: 18}
_SENSES = {75: -1.0, 76: 1.0, 77: -1.0, 78: 1.0}
#: Slots and pockets: P04 is the feed downwards, which plain language has behind the infeed, P08 the radius of the corners behind the feed.
_PLUNGE, _CORNER = 4, 8
_LINES, _ARCS = (0, 1, 7, 10, 11), {2: -1, 12: -1, 3: 1, 13: 1}
_MOTIONS = (0, 1, 2, 3, 5, 6, 7, 10, 11, 12, 13, 15, 16)
_SIDES: dict[int, Raw] = {40: ("R0", 0.0), 41: ("RL", 0.0), 42: ("RR", 0.0), 43: ("R±", 1.0), 44: ("R±", -1.0)}  # fmt: skip
_MODES = (*_MOTIONS, *_SIDES, 90, 91)
_FRAMES = {54: 7, 72: 11, 73: 10, 80: 19}
#: The kinds of words (`_Words`), those that G91 makes increments, and their names in plain language.
_KINDS = {
    "R": "radius", "H": "polar", "FMAX": "fast", **dict.fromkeys("IJK", "poles"), **dict.fromkeys("XYZABCUVW", "axes"),
    **dict.fromkeys(("F", "FAUTO", "FU", "FZ"), "feed"),
}  # fmt: skip
_STEPPED = ("poles", "axes", "polar")
_PLACES = frozenset(f"{step}{name}" for name in "IJKXYZABCUVWHR" for step in ("", "I"))
_MEANT = {"I": "X", "J": "Y", "K": "Z", "H": "PA"}
_READ = "G00 to G16, G24 to G31, G54, G62, G70 to G79, G98 and the cycles are"
_READ_OF_Q = "D00 to D14 with P01, P02 and P03 are"
_PLANES = {17.0: "Z", 18.0: "Y", 19.0: "X"}
#: The kind of a statement whose meaning hangs on the modes; its data are its words, G functions among them.
_MODAL = "modal"
_LANGUAGE = Language(
    names={
        **plain_language.LANGUAGE.names,
        **dict.fromkeys(("G_FUNCTION", "PLANE_G", "PLACE"), "a word"), "PART": "P01", "CALLED": "a label", "COUNT": "a number",
    },
    hint="a word is a letter with a value: G01 G41 X+10 Y-2.5 F200 M3",
)  # fmt: skip
_SAID = plain_language.RULES
#: P01 and the like: number, and value, or a number or text as it is written.
_Part = tuple[int, Value | str]


def is_iso(source: Source) -> bool:
    """Tell whether a text is in DIN/ISO."""
    return _TEXT.search(source.data) is not None


def parse(body: str) -> Statement:
    """Read one block, without its number, comment and the * at its end.

    Raises:
        BlockError: It is not one of the read statements; the column is that of `body`.
    """
    refused = lambda reader, text, start: refusal(text, reader.error, reader.expected(), _LANGUAGE)  # noqa: E731
    found: Statement = plain_language.read(_reader(), body, "start", refused)
    return found


@cache
def _reader() -> Reader:
    from cncgen.grammars import tables_din_iso

    return Reader(tables_din_iso, {**_SAID, **RULES})


def _refused(what: str, hint: str, place: str) -> BlockError:
    return BlockError("unsupported-block", f"{what} of DIN/ISO is not read", place, hint=hint)


# Blocks.


def _g(text: str) -> Raw:
    digits = text[1:].strip()
    if not digits.isdecimal() or len(digits.lstrip("0")) > _DIGITS_OF_G:
        raise _refused(f"G{digits}", _READ, "G")
    return "G", float(digits)


def _given(value: Value | str) -> Value:
    """Return the value of P01: a number, or what gives one."""
    if isinstance(value, str) and value[0] == '"':
        raise _refused(f"the text {value}", "P01 +5, P01 +Q5", value)
    return number(value) if isinstance(value, str) else value


def _label(value: Value | str) -> str:
    if not isinstance(value, str):
        raise _refused("a label by a parameter", 'P03 5, P03 "NAME"', "P")
    found: str = _SAID["label"](value.lstrip("+"))
    return found


def _function(head: str, q: str | None, *parts: _Part) -> Statement:
    """D00 to D14: FN."""
    which, given = int(head[1:]), dict(parts)
    name, wanted = f"D{which:02}", range(1, _VALUES.get(which, 2) + 1)
    missing = next((k for k in wanted if k not in given), 0)
    if missing:
        raise _refused(f"{name} without P0{missing}", _READ_OF_Q, name)
    values = [given[k] for k in wanted]
    if which == _ALARM:
        return _SAID["alarm"](name, str(values[0]))
    how, a, b = _OPERATORS[which], _given(values[0]), _given((*values, 0.0)[1])
    if len(values) == 3:
        return _SAID["jump"](name, a, how, b, _label(values[2]))
    if q is None:
        raise _refused(f"{name} without Q", "D00 Q1 P01 +5 sets Q1", name)
    if len(values) == 2:
        return _SAID["operation"](f"FN{which}", q, a, how, b)
    return _SAID["one_operand"](name, q, how, a) if how else _SAID["fn_assignment"](name, q, a)


def _unread(head: str, *_: str) -> Statement:
    name = "".join(head.split()).upper()
    raise _refused(name, _READ_OF_Q, name)


def _old_cycle(head: str, *parts: tuple[int, Value | str | Raw]) -> Statement:
    """G74 to G78, G83 to G86: a cycle and the words of each of its parts, as CYCL DEF 4.1 and so on have them."""
    which = int(head[1:])
    given: dict[int, Raw] = {
        k: value if isinstance(value, tuple) else ("V", _given(value)) for k, value in parts
    }
    if which >= 83:
        return Statement("parts", data=(_OF_PARTS[which], [(k, [word]) for k, word in given.items()]))
    words = {k - (k > _PLUNGE): [word] for k, word in given.items() if k not in (_PLUNGE, _CORNER)}
    if _PLUNGE in given:
        words.setdefault(_PLUNGE - 1, []).append(("F", given[_PLUNGE][1]))
    last = max(words, default=1)
    if _CORNER in given:
        words[last].append(("R", given[_CORNER][1]))
    if which in _SENSES:
        words.setdefault(last, []).append(("DR±", _SENSES[which]))
    return Statement("parts", data=(_OF_PARTS[which], list(words.items())))


def _cycle(head: str, rest: str | None) -> Statement:
    """G200 is CYCL DEF 200, G120 to G139 are cycles 20 to 39."""
    which = int(head[1:])
    return Statement("cycle", data=(which if which >= 200 else which - 100, None, rest or ""))


def _tool_call(plane: str | None, tool: Value | tuple[Computed], *words: Raw) -> Statement:
    """T1 G17 S500: a tool into the spindle."""
    own = [word for word in words if word[0] != "G"]
    g = [*([float(plane[1:])] if plane else []), *(value for name, value in words if name == "G")]
    if not {*_PLANES, 40.0, 90.0}.issuperset(g) or any(name in _PLACES for name, _ in own):
        raise _refused("a tool call with a motion", "T1 G17 S500 stands alone", "T")
    axis = _SAID["tool_axis"](next((_PLANES[one] for one in g if one in _PLANES), "Z"))
    return _SAID["tool_call"](tool, axis, *own)


def _frame(which: int, words: Sequence[Raw]) -> Statement:
    return Statement("frame", data=(which, words))


#: The function of each rule that the plain language does not have, by its name.
RULES: dict[str, Callable[..., Any]] = {
    "head": lambda text: Statement("head", data=(text, text[-1] == "0")),
    "call_named": lambda text: Statement("head", data=(text[1:], None)),
    "call_times": lambda name, times: Statement("call", data=(_SAID["label"](name), number(times or "0") or None)),
    "corner_g": lambda head, size, *feed: _SAID["corner"]("CHF" if head[-1] == "4" else "RND", size, "F" if feed else 0.0, *feed),
    "d_function": _function, "unread": _unread, "part": lambda head, value: (int(head[1:]), value),
    "cycle_g": _cycle, "orient": lambda *_: _SAID["cycle"]("13", None),
    "old_cycle": _old_cycle, "side_part": lambda head, axis, value: (int(head[1:]), (axis.upper(), value)),
    "contours": lambda *parts: Statement("contours", data=tuple(_label(value) for _, value in parts)),
    "program_cycle": lambda *parts: Statement("cycle", data=(programs.CYCLE, "1", parts[-1])),
    "tool_call_g": _tool_call, "dwell_g": lambda seconds: _SAID["dwell"]("TIME", seconds),
    "tolerance_g": lambda path, *parts: Statement("block", [("g", 64.0), *([("p", path)] if path is not None else [])]),
    "mirror": lambda *axes: _frame(8, [(axis.upper(), 0.0) for axis in axes]),
    "modal": lambda *words: Statement(_MODAL, data=words), "g_function": _g, "radius_g": lambda value: ("R", value),
}  # fmt: skip


# Words that hang on the modes.


@dataclass(slots=True)
class _Words:
    """The words of a block: G functions; axes, centres and polar words with I where G91 was in force; the radius, feeds, others."""

    g: list[int] = field(default_factory=list)
    axes: list[Raw] = field(default_factory=list)
    poles: list[Raw] = field(default_factory=list)
    polar: list[Raw] = field(default_factory=list)
    radius: list[Raw] = field(default_factory=list)
    feed: list[Raw] = field(default_factory=list)
    fast: list[Raw] = field(default_factory=list)
    others: list[Raw] = field(default_factory=list)


def _motion(head: str, *parts: Sequence[Raw]) -> Statement:
    return _SAID["motion"](head, *(word for words in parts for word in words))


def _alone(*parts: Sequence[Raw]) -> list[Statement]:
    """Return a block L of words alone, none where there are none."""
    return [_motion("L", *parts)] if any(parts) else []


@dataclass(slots=True)
class Modes:
    """The modes that stay in force from block to block: the motion, G91, the sense of the last arc; and the words of a G27 that waits for its end."""

    motion: int = 1
    steps: bool = False
    sense: int = 1
    leaving: Sequence[Raw] = ()

    def statements(self, given: Sequence[Raw], behind: Sequence[Raw] = ()) -> list[Statement]:
        """Return a block that moves, or changes modes, as those of the plain language; the words of the block behind it may be of G26.

        Raises:
            BlockError: A function is not read, or an arc has no end.
        """
        words = self._words(given)
        own = [g for g in words.g if g not in _MODES]
        if own:
            return self._single(own, words)
        motion = next((g for g in words.g if g in _MOTIONS), None)
        self.motion = self.motion if motion is None else motion
        polar = self.motion >= 10
        poles = [_motion("CC", words.poles)] if words.poles else []
        side = [_SIDES[g] for g in words.g if g in _SIDES][:1]
        if polar:
            words.polar += [("IPR" if self.steps else "PR", value) for _, value in words.radius]
        place = [*(words.polar if polar else ()), *words.axes]
        if place:
            return [*poles, *self._moves(place, side, words, behind)]
        if motion in _ARCS and not poles:
            hint = "X and Y give it; in polar coordinates, H"
            raise BlockError("arc-end", f"G{motion:02} has no end", f"G{motion:02}", hint=hint)
        return [*poles, *_alone(side, words.feed, words.others)]

    def _moves(
        self, place: Sequence[Raw], side: Sequence[Raw], words: _Words, behind: Sequence[Raw]
    ) -> list[Statement]:
        soft = [word for word in behind if word[0] in ("R", "F")] if ("G", 26.0) in behind else []
        polar, straight = "P" if self.motion >= 10 else "", self.motion in _LINES
        fast = [("FMAX", 0.0)] if self.motion in (0, 10) else words.fast
        before = _alone(words.feed) if fast or soft else []
        if self.leaving:
            if side != [_SIDES[40]] or not straight:
                message = "G27 is followed by no line with G40, to where it leads"
                raise BlockError("approach-words", message, "G27", hint="G00 G40 X Y follows")
            way = Statement("way", data=("DEP", f"{polar}LCT", [*place, *self.leaving, *words.others]))
            self.leaving = ()
            return [way, *_alone(words.feed)]
        if soft:
            if side not in ([_SIDES[41]], [_SIDES[42]]) or not straight:
                message = "G26 stands behind no line with G41 or G42"
                raise BlockError("approach-words", message, "G26", hint="G01 G41 X Y comes before")
            way = Statement("way", data=("APPR", f"{polar}LCT", [*place, *soft, *side, *words.others]))
            return [*before, way]
        tail = (side, fast or words.feed, words.others)
        if straight:
            return [*before, _motion(f"L{polar}", place, *tail)]
        if self.motion in (6, 16):
            return [_motion(f"CT{polar}", place, *tail)]
        self.sense = _ARCS.get(self.motion, self.sense)
        turn = [("DR±", float(self.sense))]
        if polar:
            return [_motion("CP", place, turn, *tail)]
        return [_motion("CR" if words.radius else "C", place, words.radius, turn, *tail)]

    def _single(self, own: Sequence[int], words: _Words) -> list[Statement]:
        """Return a block of a function that is no motion."""
        g = own[0] if len(own) == 1 else -1
        if g in _FRAMES:
            turn = "IROT" if self.steps else "ROT"
            angles = [(turn, value) for _, value in words.polar] or [(turn, 0.0)]
            given = {72: [("SCL", value) for _, value in words.feed], 73: angles}.get(g, words.axes)
            return [_frame(_FRAMES[g], given)]
        if g == 17:
            return _alone(words.others)
        if g == 26:
            return []
        if g == 27 and words.radius:
            self.leaving = [*words.radius, *words.feed]
            return []
        if g == 29:
            return [_motion("CC")]
        if g == 79:
            return [_SAID["cycle_call"](None, *words.feed, *words.others)]
        raise _refused(" ".join(f"G{one:02}" for one in own), _READ, f"G{own[0]:02}")

    def _words(self, given: Sequence[Raw]) -> _Words:
        """Return the words of a block by what they are; G90 and G91 stand before those that they are for."""
        words = _Words()
        for name, value in given:
            if name == "G":
                words.g.append(round(value))  # type: ignore[arg-type]
                if words.g[-1] in (90, 91):
                    self.steps = words.g[-1] == 91
                continue
            if name.removeprefix("I") != name and len(name) > 1:
                hint = f"G91 {name[1:]} goes by an increment"
                raise BlockError("syntax", f"'{name}' is no word of DIN/ISO", name, hint=hint)
            kind = _KINDS.get(name, "others")
            meant = f"{'I' if self.steps else ''}{_MEANT.get(name, name)}" if kind in _STEPPED else name
            getattr(words, kind).append((meant, value))
        return words


class IsoRunner(HeidenhainRunner):
    """One run of a program in DIN/ISO."""

    ends_with = "% at its end, or M30"
    plain = ""
    parse = staticmethod(lru_cache(4096)(parse))
    label_heads = ("LBL", "G98")

    def _prepare(self) -> None:
        super()._prepare()
        self._modes = Modes()

    def _said(self, bare: str) -> list[str]:
        body = _NUMBER.sub("", bare).rstrip()
        return lines.apart(body.removesuffix("*").strip())

    def _note(self, program: Program, own: str) -> None:
        super()._note(program, own)
        if own[:1] == "%" and program.head < 0:
            program.head = len(program.lines)

    def _place(self, at: int) -> Words:
        with suppress(BlockError):
            said = self._meant(self._ahead(at), replace(self._modes))
            return [word for one in said for word in plain_language.place_of(one)]
        return []

    def _meant(self, statement: Statement, modes: Modes, behind: Sequence[Raw] = ()) -> list[Statement]:
        """Return what a block says in modes, which it changes."""
        return modes.statements(statement.data, behind) if statement.kind == _MODAL else [statement]

    def _behind(self, at: int) -> Iterator[tuple[int, Statement]]:
        modes = replace(self._modes)
        for following, statement in super()._behind(at):
            for one in self._meant(statement, modes):
                if statement.kind != _MODAL or one.kind != "block" or is_drawn(one) or is_pole(one):
                    yield following, one

    def _draws(self, at: int) -> bool:
        return super()._draws(at) or self._ahead(at).kind == _MODAL

    def do_modal(self, frame: Frame, at: int, statement: Statement) -> None:
        """Run words in the modes in force."""
        following = self._following(at)
        behind = UNREAD if following is None else self._ahead(following)
        for one in self._meant(statement, self._modes, behind.data if behind.kind == _MODAL else ()):
            self._run_statement(frame, at, one)

    def do_head(self, frame: Frame, at: int, statement: Statement) -> None:
        """%PART G71 begins and ends a program; %PART calls one."""
        name, inches = statement.data
        if frame.program.head == at:
            self._plain(at, _SAID["begin_program"]("INCH" if inches else "MM"))
        elif inches is None:
            self._call_program(programs.bare(name))
        else:
            self._run_statement(frame, at, _SAID["end_program"]())

    def do_frame(self, frame: Frame, at: int, statement: Statement) -> None:
        self._datums.set(*statement.data)

    def do_parts(self, frame: Frame, at: int, statement: Statement) -> None:
        """G74 to G78, G83 to G86: cycles whose values are P01 and so on."""
        which, parts = statement.data
        cycles.define(self.ip, which)
        for part, words in parts:
            older_cycles.take_value(self.ip, which, part, words)

    def do_contours(self, frame: Frame, at: int, statement: Statement) -> None:
        """G37: the labels of contours."""
        self._take_labels(list(statement.data))

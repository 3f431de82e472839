"""The lines of a program in Heidenhain's plain language: their text without numbers and comments, and what they need to be run."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from cncgen.gcode.source import Source
from cncgen.grammars.terminals import HEIDENHAIN as TERMINALS

_N, _Q = TERMINALS["BLOCK_NUMBER"], TERMINALS["Q"]
#: The setting of a parameter, of a feed also without = (Q206 FAUTO).
SETTING = rf"(?:(?:{_Q}|{TERMINALS['TEXT_PARAMETER']})\s*=|{_Q}\s+(?:{TERMINALS['FEED_WORD']})\b)"


def _form(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern, re.IGNORECASE)


#: A parameter of a cycle that stands behind other words of its line.
_GIVEN = _form(rf"(?:\s|(?<=\AG\d\d\d))(?={_Q}\s*=)")
#: The number of a block, and it alone before a blank.
_NUMBER = _form(rf"\s*(?:{_N}(?:\s+|(?=\*)|\Z))?")
_NUMBERED = _form(rf"\s*{_N}\s")
#: A block that a switch leaves out, before its number or behind it.
_SLASH = _form(rf"\s*(?:{_N}\s+)?/")
_REMARK = _form(rf"\s*(?:{_N}\s*)?(?:{TERMINALS['COMMENT']}|{TERMINALS['HEADING']})")
#: Text behind a comment that ends in ~ and does not belong to it: a parameter, a point, the next block.
_GOES_ON = _form(rf"\s*(?:{SETTING}|{TERMINALS['PLACES_OF']}\s*\(|{_N}\s|/|\Z)")
#: A line of PATTERN DEF, whose points stand in parentheses.
_POINTS = _form(rf"\s*(?:{_N}\s+)?(?:PATTERN\s+DEF|{TERMINALS['PLACES_OF']}(?<=\d))")
_SETS = _form(rf"\s*(?:{SETTING}|FN\b)")
#: The beginning of a block, where a formula may go on.
_BEGINS = _form(
    rf"{_N}\s|\s*(?:{SETTING}|(?:L|LP|CC?|CR|CP|CT|FN|RND|CHF|LBL|CALL|TOOL|CYCL|APPR|DEP|STOP|END|PLANE|FUNCTION|TRANS|BLK)\b|M\s*\d)"
)
#: A formula that goes on behind ~, in lines that begin no block; a comment behind it that goes on is left to `bodies`.
_FORMULA = re.compile(
    rf"[^\S\n]*/?(?:{_N}[^\S\n]+)?(?:{SETTING}|FN\b)[^;~\n]*"
    rf"(?:~[^\S\n]*\n(?!{_BEGINS.pattern})[^;~\n]*)+(?![^\n]*~)".encode(),
    re.IGNORECASE,
)
_NEXT_Q = re.compile(rb"[Qq]")
_STRING = _form(TERMINALS["STRING"])
#: Labels and their calls; those of DIN/ISO are G98 L1 and L1,3.
_LABEL = re.compile(
    rf"^[^\S\n]*(?:{_N}[^\S\n]+)?(?:LBL\b|CALL\b|G98[^\S\n]*L|L\d+,)".encode(), re.IGNORECASE | re.MULTILINE
)
#: Lines that name files and programs, and the blank.
_NAMES = _form(r"\b(?:PGM|TABLE|PATTERN|FILE|BLK)\b")
_NAMES_OF_ISO = _form(rf"\A\s*(?:{_N}\s*)?%")
#: A parameter, and what tells that it is set: = behind it, the D function of DIN/ISO before it.
_USED = _form(rf"()({_Q})\s*(=?)")
_USED_OF_ISO = _form(rf"(?:(?<![A-Z])(D\d+)\s*)?({_Q})\s*(=?)")
#: Numbers of Q parameters that the control, its cycles and those of the machine's builder have (TNC 7, "Variable types").
_FIRST_OF_CYCLES, _BEHIND_CYCLES = 100, 1400
_BROKEN = re.compile(rb"~[^\S\n]*\n")
#: Words of a numbered block in lines of their own, as TNC 145 to 155 put them.
_WORDS_BELOW = _form(
    rf"\s{{4,}}(?:{TERMINALS['AXIS']}|[FMSL]|R|D[RL]|I?P[AR]|CC[XY])\s*(?:[-+.\d]|[0LR]\b|Q\d|MAX\b)"
)


def apart(body: str) -> list[str]:
    """Return a line, its parameters of a cycle apart: CYCL DEF 200 DRILLING Q200=2 Q201=-15."""
    if '"' in body or body[:1] not in "CcQqGg":
        return [body]
    return _GIVEN.split(body)


def body_of(text: str, *, formula: bool = False) -> str:
    """Return a line without its comment. A comment begins with ;, or stands in parentheses behind words, as simulators write it, where the
    line is not the rest of a formula."""
    body = text.partition(";")[0]
    if "(" in body and "=" not in body and not formula and not _POINTS.match(body):
        body = body.partition("(")[0]
    return body.rstrip().rstrip("~").rstrip()


def bare(text: str) -> str:
    """Return a line that is a block without its number and comment."""
    return _without_number(body_of(text))


def _without_number(body: str) -> str:
    match = _NUMBER.match(body)
    assert match
    return body[match.end() :]


class Joined(Source):
    """A text whose formulas stand in one line each, with empty lines behind those that went on, so that lines keep their numbers.

    Attributes:
        broken: By the offset of a line that was joined, the lines as the file has them; a blank stands for each byte between them.
    """

    def __init__(self, data: bytes, name: str, broken: dict[int, Source]) -> None:
        super().__init__(data, name)
        self.broken = broken

    def written(self, offset: int, line: int, column: int) -> tuple[str, int, int]:
        """Return the line of the file that a place is in."""
        lines = self.broken.get(offset)
        if lines is None:
            return super().written(offset, line, column)
        before = len(self.text_at(offset)[: column - 1].encode("utf-8", "replace"))
        begin = lines.line_begin(min(before, len(lines)))
        text = lines.text_at(begin)
        return text, line + lines.data[:begin].count(b"\n"), min(before - begin, len(text)) + 1


def joined(source: Source) -> Source:
    """Return a text with its formulas in one line each."""
    data, parts, done = source.data, list[bytes](), 0
    broken, length = dict[int, Source](), 0
    at = data.find(b"~")
    while at >= 0:
        formula = _FORMULA.match(data, max(data.rfind(b"\n", 0, at) + 1, done))
        if formula:
            text, breaks = _BROKEN.subn(lambda found: len(found[0]) * b" ", formula[0])
            end = source.line_end(formula.end())
            length += formula.start() - done
            broken[length] = Source(data[formula.start() : end], source.name)
            parts += [data[done : formula.start()], text, data[formula.end() : end], breaks * b"\n"]
            length, done = length + end - formula.start() + breaks, end
        at = data.find(b"~", max(done, at + 1))
    return Joined(b"".join([*parts, data[done:]]), source.name, broken) if parts else source


def bodies(
    source: Source, *, block_delete: bool, passed: Callable[[int, int], tuple[int, int]]
) -> Iterator[tuple[int, int, str, bool, bool]]:
    """Yield of each line its offset, number, text without number and comment, whether it goes on with the block above, or with its line.

    Args:
        source: The text.
        block_delete: Whether blocks with a slash are left out.
        passed: Takes offset and number of a line that begins a block; returns those of the first line behind the plain ones that it takes,
            the last of which it leaves, as it may go on.
    """
    offset, number, above = 0, 1, _Above()
    while offset < len(source):
        if not above.goes_on:
            offset, number = passed(offset, number)
        body, below, behind = above.take(source.text_at(offset), block_delete=block_delete)
        yield offset, number, body, below, behind
        offset, number = source.line_end(offset) + 1, number + 1


@dataclass(slots=True)
class _Above:
    """What the lines above a line say of it: whether they go on there, are left out, have a number, are a comment (that began its line), or
    a formula."""

    goes_on: bool = False
    left_out: bool = False
    numbered: bool = False
    remark: bool = False
    whole: bool = False
    formula: bool = False

    def take(self, text: str, *, block_delete: bool) -> tuple[str, bool, bool]:
        """Return the text of a line without number and comment, and whether it goes on with the block above, or with its line."""
        if not self.goes_on:
            self.left_out = _SLASH.match(text) is not None
        begins = _BEGINS.match(text) is not None
        behind = self._is_behind(text, begins)
        # So does a formula, and so do words; the parameters of a cycle are blocks of their own.
        rest = behind and self.formula and not self.remark and not begins
        more = behind and not (self.remark or begins or _GOES_ON.match(text))
        # A block that is left out goes on behind ~ as well.
        self.goes_on = text.rstrip().endswith("~")
        if self.left_out:
            text = "" if block_delete else text.replace("/", " ", 1)
        body = "" if self.remark else body_of(text, formula=rest)
        self.remark = self.remark or self.whole or ";" in text
        below = rest or more or (self.numbered and _WORDS_BELOW.match(body) is not None)
        self.numbered = below or _NUMBERED.match(text) is not None
        said = _without_number(body)
        self.formula = rest or _SETS.match(said) is not None
        return body if rest else said, below, behind

    def _is_behind(self, text: str, begins: bool) -> bool:
        """Tell whether a line goes on with the one above; its comment goes on too, unless a block begins there in the first column, or, of
        one behind words or in a cycle, unless the line is of the block."""
        behind = self.goes_on and not (self.remark and begins and not text[0].isspace())
        self.remark = behind and self.remark and (self.whole or _GOES_ON.match(text) is None)
        self.whole = (self.remark and self.whole) or (_REMARK.match(text) is not None and not behind)
        return behind


def unset(sources: Sequence[Source]) -> dict[str, tuple[int, int, int]]:
    """Return the Q parameters for programs' own use that texts read and never set, or read before the first label or call and set behind that, with
    source, offset and number of the line of the first reading. Those of cycles and of the control have values without a text that sets them."""
    read, given = dict[str, tuple[int, int]](), dict[str, list[tuple[int, int]]]()
    for index, source in enumerate(sources):
        at = _NEXT_Q.search(source.data)
        while at:
            offset = source.data.rfind(b"\n", 0, at.start()) + 1
            body = _STRING.sub("", body_of(source.text_at(offset))).upper()
            named = _NAMES.search(body) or ("%" in body and _NAMES_OF_ISO.search(body))
            used = _USED_OF_ISO if "D" in body else _USED
            for function, name, sign in () if named else used.findall(body):
                if function or sign:
                    given.setdefault(name, []).append((index, offset))
                elif name[1] in "LR" or not _FIRST_OF_CYCLES <= float(name[1:]) < _BEHIND_CYCLES:
                    read.setdefault(name, (index, offset))
            at = _NEXT_Q.search(source.data, source.line_end(offset))
    found = {}
    for name, (index, offset) in read.items():
        data, places = sources[index].data, given.get(name, [])
        label = _LABEL.search(data)
        early = (index, offset) <= min(places, default=(index, offset)) and not (
            label and label.start() < offset
        )
        if not places or (early and all(place[0] == index for place in places)):
            found[name] = index, offset, data[:offset].count(b"\n") + 1
    return found

"""Recognising the control of a program by signs in its text.

Signs are searched in blocks as controls read them: without comments, blanks and N words, so ``N01G50S600`` and ``N1 G50 S600`` are the
same. Each speaks for some dialects and against others with a weight; the weights of all are added.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from cncgen.gcode.source import Source
from cncgen.gcode.text import signs
from cncgen.gcode.text.built_patterns import compiled
from cncgen.gcode.text.signs import UNREAD, Sign
from cncgen.kernels.gcode_signs import different_lines
from cncgen.records import dataclass, replace

TYPE_CHECKING = False
if TYPE_CHECKING:
    import re

#: Bytes that are looked at, at the beginning and at the end of a text.
_HEAD = 65_536
_TAIL = 8_192
#: Leads over the next dialect: from the first on the choice is certain, from the second on it is likely and not a guess.
_CERTAIN, _LIKELY = 6.0, 3.0
#: Weight that a dialect needs to be chosen over plain G-code (a lathe, where X is a diameter), and below which the signs are weak.
_ENOUGH = dict.fromkeys(("fanuc-lathe", "fanuc-lathe-b", "fanuc-lathe-c"), 5.0)
_USUAL, _WEAK = 3.0, 6.0
#: Weight from which on a sign of lathes is of system A.
_SHARED = 10.0
#: Weight from which on a note says that a program is written for LinuxCNC.
_OWN = 20.0
#: Weight of a control that is not read, from which on a program may be of it, unless signs of another lead by `_LIKELY`.
_FOREIGN = 6.0


@dataclass(frozen=True, slots=True)
class Choice:
    """A dialect, the signs that spoke for it (or ""), the line of the first, and what it might be as well (or ""): a dialect, or a
    control whose language is not read, by its name.

    `unread` names a control whose language the program is in, and which is not read; `dialect` is then only a substitute.
    """

    dialect: str
    reason: str
    line: int
    rival: str = ""
    unread: str = ""


@dataclass(frozen=True, slots=True)
class _Lines:
    """The different lines of a text, and of each its first number and how often it stands there (`gcode_signs`)."""

    text: bytes
    numbers: list[int]
    counts: list[int]

    def search(self, pattern: bytes) -> re.Match[bytes] | None:
        """Return the first match of a pattern."""
        return compiled(signs.by_line(pattern)).search(self.text)

    def number(self, match: re.Match[bytes]) -> int:
        """Return the number of the line that a match begins in, behind the end of the line before, which a sign may begin with."""
        ends = len(match[0]) - len(match[0].lstrip(b"\n"))
        return self.numbers[self.text.count(b"\n", 0, match.start() + ends)]


_L, _F, _T, _B, _C, _S = "linuxcnc", "fanuc", "fanuc-lathe", "fanuc-lathe-b", "fanuc-lathe-c", "sinumerik"
_BLANKS = b" \t\r"


def chosen(source: Source, dialect: str) -> Choice:
    """Return the requested dialect, or with ``auto`` that of the text."""
    return choose(source) if dialect == "auto" else Choice(dialect, "", 1)


def bare(text: bytes) -> bytes:
    """Return a text in capitals, line by line, without comments, blanks and N words.

    A slash with a number, ``/2``, is a NUL and the number.
    """
    blocks = _without(signs.OUT_OF_CODE, text.upper()).translate(None, _BLANKS)
    if b"N" not in blocks and b"/" not in blocks:
        return blocks
    return compiled(signs.NUMBERS).sub(_switch, blocks)


def _switch(match: re.Match[bytes]) -> bytes:
    """Return what stands for the beginning of a block: a NUL and the number of the switch that leaves it out, if it has one."""
    number = (match["before"] or match["behind"] or b"")[1:]
    return b"\x00" + number if number else b""


def _without(comments: bytes, text: bytes) -> bytes:
    """Return a text without what a pattern of comments finds, which is looked for where a text may have any."""
    return compiled(comments).sub(b"", text) if b"(" in text or b";" in text else text


def different(source: Source) -> tuple[bytes, list[int], list[int]]:
    """Return the different lines of the beginning and the end of a text (`different_lines`)."""
    if source.different is None:
        head = source.data[:_HEAD]
        if len(source.data) > _HEAD:
            head += source.data[max(_HEAD, len(source.data) - _TAIL) :]
        source.different = different_lines(head)
    return source.different


def choose(source: Source) -> Choice:
    """Return the dialect that the signs in a text speak for; without any sign, LinuxCNC's."""
    written = _Lines(*different(source))
    blocks = _blocks(written)
    found = [
        *_found(signs.WRITTEN, written),
        *_found(signs.SPOKEN, replace(written, text=_without(signs.REMARKS, written.text))),
        *_found(signs.BARE, blocks),
        *_of_feeds(blocks),
        *_of_name(source.name, written),
    ]
    totals = dict.fromkeys((*signs.READ, *UNREAD), 0.0)
    for _, weights, _ in found:
        for dialect, weight in weights.items():
            totals[dialect] += weight
    return _decided(found, totals)


def of_haas(source: Source) -> bool:
    """Tell whether a text has a code that Haas's controls alone have."""
    import re

    return re.search(signs.OF_HAAS, _blocks(_Lines(*different(source))).text) is not None


def _blocks(written: _Lines) -> _Lines:
    """Return the different lines of a text as bare blocks; without N words, more lines are the same."""
    text, numbers, counts = different_lines(bare(written.text), written.counts)
    return _Lines(text, [written.numbers[number - 1] for number in numbers], counts)


_Found = tuple[str, dict[str, float], int]
#: A block with : for N.
_MAIN_BLOCK = rb"^:\d+[ \t]+[A-Z]"


def _found(wanted: Iterable[Sign], lines: _Lines) -> Iterable[_Found]:
    """Yield the signs that a text has: reason, weights, line."""
    for reason, weights, pattern, texts in wanted:
        for text in texts:
            if text in lines.text:
                match = lines.search(pattern)
                if match:
                    yield reason, weights, lines.number(match)
                break


def _of_name(name: str, lines: _Lines) -> Iterable[_Found]:
    """Yield the signs of a file's suffix: SINUMERIK's programs are .mpf and .spf, Okuma's .min; main blocks of SINUMERIK begin with :."""
    if name.lower().endswith(".min"):
        yield "the suffix of Okuma's programs", {"okuma": 10.0}, 1
    if not name.lower().endswith((".mpf", ".spf")):
        return
    yield "the suffix of SINUMERIK's programs", {_S: 4.0}, 1
    main = lines.search(_MAIN_BLOCK) if b":" in lines.text else None
    if main:
        yield "a main block of SINUMERIK", {_S: 20.0, "acramatic": -20.0}, lines.number(main)


def _of_feeds(blocks: _Lines) -> Iterable[_Found]:
    """Yield the signs of feeds and their modes: below 1 they are a revolution's, G99 without cycles says so too."""
    mode = blocks.search(signs.RETRACTS) if b"G99" in blocks.text else None
    if mode and not blocks.search(signs.CYCLES):
        yield "G99 without cycles of mills", {_T: 3.0}, blocks.number(mode)
    if b"Y" in blocks.text:
        return
    feed = blocks.search(signs.A_TURN) if b"G95" in blocks.text else None
    if feed and not blocks.search(signs.HOLES):
        yield "feeds a revolution by G95", {_B: 4.0, _C: 4.0, _L: 2.0}, blocks.number(feed)
    if feed and b"G50S" in blocks.text:
        # No system of FANUC's has both: A has G99 for G95, B and C have G92 S for G50 S.
        yield "feeds a revolution by G95 beside G50 S", {"okuma": 21.0}, blocks.number(feed)
    arc = blocks.search(signs.ARC_IN_XZ) if b"K" in blocks.text and b"J" not in blocks.text else None
    if arc and not blocks.search(signs.PLANE):
        yield "an arc in X and Z without a plane", {_T: 8.0}, blocks.number(arc)
    if b"F" not in blocks.text:
        return
    first = blocks.search(signs.FEEDS)
    if first is None or blocks.search(signs.OTHER_FEEDS) or not blocks.search(signs.X_AND_Z):
        return
    feeds_of = compiled(signs.FEEDS)
    feeds = sorted(
        float(feed)
        for line, count in zip(blocks.text.split(b"\n"), blocks.counts, strict=True)
        for feed in count * feeds_of.findall(line)
    )
    if 0.0 < feeds[len(feeds) // 2] < 1.0:
        yield "feeds below 1", {_T: 4.0}, blocks.number(first)


def _decided(found: list[_Found], totals: dict[str, float]) -> Choice:
    """Return the dialect of the greatest weight, its signs, and the next dialect if it is close."""
    own = {dialect for _, weights, _ in found for dialect in (_B, _C) if weights.get(dialect, 0.0) > 0.0}
    for dialect in own:
        # The signs of all lathes, which are less than those that system A alone has, and those that it has in common with this one.
        shared = (
            w[_T]
            for _, w, _ in found
            if (dialect not in w and w.get(_T, math.inf) < _SHARED) or w.get(dialect) == 0.0
        )
        totals[dialect] += sum(shared)
    for dialect in {_B, _C} - own:
        totals[dialect] = -math.inf
    # At the same weight: LinuxCNC before FANUC, mills before lathes.
    order = sorted(totals, key=lambda dialect: -totals[dialect])
    best = order[0]
    if best in UNREAD and totals[best] >= _OWN / 2.0:
        reasons = _reasons(found, best)
        text = ", ".join(reason for reason, _ in reasons[:3])
        return Choice(_F, text, reasons[0][1], unread=UNREAD[best])
    chosen = _of_read(found, totals, [dialect for dialect in order if dialect in signs.READ])
    foreign = max(UNREAD, key=totals.__getitem__)
    if (
        not chosen.rival
        and totals[foreign] >= _FOREIGN
        and totals[foreign] > totals[chosen.dialect] - _LIKELY
    ):
        return replace(chosen, line=_reasons(found, foreign)[0][1], rival=UNREAD[foreign])
    return chosen


def _of_read(found: list[_Found], totals: dict[str, float], order: list[str]) -> Choice:
    """Return the choice among the dialects that are read, which stand in the order of their weights."""
    best, second = order[0], order[1]
    if best in (_L, _F) and totals[best] <= 0.0:
        return Choice(_L, "", 1)
    if totals[best] < _ENOUGH.get(best, _USUAL):
        reasons = _reasons(found, best)
        return Choice(_L, "", reasons[0][1] if reasons else 1, best if best != _L else "")
    lead = totals[best] - totals[second]
    if {best, second} == {_F, _T} and not any(w.get(second, 0.0) > w.get(best, 0.0) for _, w, _ in found):
        # Nothing speaks for the other of FANUC's two that does not speak for this one.
        rest = max(totals[dialect] for dialect in order[2:])
        lead = totals[best] - rest
    sure = "certain" if lead >= _CERTAIN else "likely" if lead >= _LIKELY else "a guess"
    reasons = _reasons(found, best)
    more = f" and {len(reasons) - 3} more" if len(reasons) > 3 else ""
    text = ", ".join(reason for reason, _ in reasons[:3]) + f"{more} ({sure})"
    rival = second if lead < _LIKELY and totals[second] > 0.0 else ""
    if best == _T and totals[best] < _WEAK and not rival:
        rival = _L
    if best == _L and not rival and totals[best] < _OWN:
        # A text without signs is read as LinuxCNC's without a note.
        text = ""
    return Choice(best, text, reasons[0][1] if reasons else 1, rival)


def _reasons(found: list[_Found], dialect: str) -> list[tuple[str, int]]:
    """Return the signs that speak for a dialect and their lines, the heaviest first."""
    own = [
        (reason, weights[dialect], line) for reason, weights, line in found if weights.get(dialect, 0.0) > 0.0
    ]
    return [(reason, line) for reason, _, line in sorted(own, key=lambda sign: -sign[1])]

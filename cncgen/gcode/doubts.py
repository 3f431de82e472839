"""Remarks on a text that another control than the dialect's reads otherwise: one each, where it stands first.

A control reads these lines without a fault, and so are they read here; but whoever wrote them may have meant another thing.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from cncgen.diagnostics import Severity
from cncgen.gcode.codes.table import BOTH, language_of
from cncgen.gcode.errors import BlockError
from cncgen.gcode.feed_doubts import small_feeds
from cncgen.gcode.source import Source
from cncgen.gcode.text.dialects import Choice
from cncgen.gcode.text.labels import Cursor

#: Bytes that are looked at for what is met early in a text, if at all.
_HEAD = 65_536
#: A line up to a word, without comments.
_BEFORE = rb"^(?P<before>(?:[^(;\n]|\([^)\n]*\))*?)"


class _Doubt(NamedTuple):
    """A sign (its group ``word`` is the place), and the remark on it.

    `within` stands in each such text in capitals; most have none, which is found sooner.
    """

    sign: re.Pattern[bytes]
    message: str
    hint: str
    within: re.Pattern[bytes] | None = None

    def found(self, text: bytes, capitals: bytes) -> re.Match[bytes] | None:
        """Return the first place in a text, which is given in capitals too."""
        return self.sign.search(text) if self.within is None or self.within.search(capitals) else None


_FANUC = (
    _Doubt(
        re.compile(_BEFORE + rb"(?P<word>G50)[ \t]*S\d", re.MULTILINE | re.IGNORECASE),
        "G50 ends scaling and S is the speed of the spindle; on lathes G50 S bounds the speed of G96",
        "--dialect fanuc-lathe reads lathes; on a mill G92 S bounds it",
        re.compile(rb"G50"),
    ),
    _Doubt(
        re.compile(
            _BEFORE + rb"G(?:0?[0-3]|28|30)(?![\d.])[^(;\nG]*?(?P<word>[UW])[ \t]*[-+.\d#\[]",
            re.MULTILINE | re.IGNORECASE,
        ),
        "U and W are axes of their own; on lathes they are distances along X and Z",
        "--dialect fanuc-lathe reads lathes; on a mill G91 makes X and Z distances",
        re.compile(rb"[UW][ \t]*[-+.\d#\[]"),
    ),
)
_OKUMA = _Doubt(
    re.compile(_BEFORE + rb"(?P<word>G1[56])[ \t]*H[ \t]*\d", re.MULTILINE | re.IGNORECASE),
    "G15 H chooses a coordinate system on Okuma's controls, whose language is not read; here it ends polar coordinates",
    "post the program for FANUC: G54 in place of G15 H1, G43 H1 in place of G56 H1",
    re.compile(rb"G1[56][ \t]*H"),
)
_LINUXCNC = (
    _Doubt(
        re.compile(
            _BEFORE + rb"G(?:0?4|74|8[24689])(?![\d.])[^(;\nG]*?(?P<word>P)[ \t]*\d{3,}(?![\d.])",
            re.MULTILINE | re.IGNORECASE,
        ),
        "P is a dwell in seconds; FANUC's controls count it in milliseconds",
        "--dialect fanuc reads milliseconds; P0.5 waits half a second here",
        re.compile(rb"P[ \t]*\d{3}"),
    ),
)
_WORDS_OF_SIEMENS = (
    rb"CYCLE\d+[ \t]*\(|\bR\d+[ \t]*=|=[ \t]*[AI]C[ \t]*\(|\bGOTO[FBC]\b|\bMCALL\b|\bTRA(?:ORI|NS|FOOF)\b"
    rb"|\bT[ \t]*=[ \t]*\"|\bDEF[ \t]+(?:REAL|INT|BOOL|STRING)\b|\bCR[ \t]*="
)
#: Lines that no dialect reads; each is an error, and this remark names their language.
_SIEMENS = _Doubt(
    re.compile(
        _BEFORE + rb"(?P<word>" + _WORDS_OF_SIEMENS + rb")",
        re.MULTILINE | re.IGNORECASE,
    ),
    "this is of SINUMERIK's own language, of which this dialect has BSPLINE alone",
    "--dialect sinumerik reads it",
    re.compile(_WORDS_OF_SIEMENS),
)
_HEIDENHAIN = _Doubt(
    re.compile(
        _BEFORE + rb"[A-Z][ \t]*[-+]?[\d.]+[ \t]*(?P<word>\*)[ \t]*\r?$", re.MULTILINE | re.IGNORECASE
    ),
    "blocks that end in * are of Heidenhain's DIN/ISO, which is not read",
    "post the program as Heidenhain's plain language, or for FANUC or LinuxCNC",
    re.compile(rb"\*[ \t]*\r?$", re.MULTILINE),
)
#: Blocks that ``;`` hides, where it stands for the end of a block as in FANUC's manuals.
_BEHIND_SEMICOLON = _Doubt(
    re.compile(rb"(?P<word>;)[ \t]*(?:[nN]\d+[ \t]*)?[gmxyzfstGMXYZFST][ \t]*[-+.\d#\[]"),
    "what follows ; is a comment, and here it looks like a block",
    "each block stands in a line of its own",
)


def remarks_on(choice: Choice) -> Iterator[tuple[BlockError, Severity]]:
    """Yield remarks on a dialect that signs in the text have chosen: which, why, how sure, and its rival."""
    dialect, why, _, rival, unread = choice
    if unread:
        hint = "post the program for FANUC or LinuxCNC; --dialect reads it as that of another control"
        yield (
            BlockError(
                "control-unread",
                f"this is a program of {unread}, whose language is not read: {why}",
                hint=hint,
            ),
            Severity.ERROR,
        )
    elif why:
        yield BlockError("dialect", f"read as {dialect}: {why}", hint="--dialect overrides"), Severity.NOTE
    if rival:
        message = f"read as {dialect}, but it may as well be of {rival}, where it moves otherwise"
        hint = f"--dialect {dialect} or --dialect {rival} says which"
        yield BlockError("dialect-doubtful", message, hint=hint), Severity.WARNING


def doubts(source: Source, dialect: str) -> Iterator[tuple[Cursor, BlockError]]:
    """Yield what is doubtful about a text, and the line where."""
    yield from small_feeds(source, dialect)
    head = source.data[:_HEAD]
    capitals = head.upper()
    asked = [*((_SIEMENS, _HEIDENHAIN) if language_of(dialect) in BOTH else ())]
    asked += {"fanuc": (*_FANUC, _OKUMA), "linuxcnc": (*_LINUXCNC, _OKUMA)}.get(dialect, ())
    found = [(doubt, doubt.found(head, capitals)) for doubt in asked]
    if language_of(dialect) == "fanuc":
        found.append((_BEHIND_SEMICOLON, _BEHIND_SEMICOLON.sign.search(source.data)))
    for doubt, match in found:
        if match is not None:
            at = match.start("word")
            begin = source.data.rfind(b"\n", 0, at) + 1
            line = source.data[:begin].count(b"\n") + 1
            column = len(source.data[begin:at].decode("utf-8", "replace")) + 1
            yield (
                Cursor(0, begin, line),
                BlockError("other-control", doubt.message, column=column, hint=doubt.hint),
            )

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
    """A sign (its group ``word`` is the place), and the remark on it."""

    sign: re.Pattern[bytes]
    message: str
    hint: str


_FANUC = (
    _Doubt(
        re.compile(_BEFORE + rb"(?P<word>G50)[ \t]*S\d", re.MULTILINE | re.IGNORECASE),
        "G50 ends scaling and S is the speed of the spindle; on lathes G50 S bounds the speed of G96",
        "--dialect fanuc-lathe reads lathes; on a mill G92 S bounds it",
    ),
    _Doubt(
        re.compile(
            _BEFORE + rb"G(?:0?[0-3]|28|30)(?![\d.])[^(;\nG]*?(?P<word>[UW])[ \t]*[-+.\d#\[]",
            re.MULTILINE | re.IGNORECASE,
        ),
        "U and W are axes of their own; on lathes they are distances along X and Z",
        "--dialect fanuc-lathe reads lathes; on a mill G91 makes X and Z distances",
    ),
)
_OKUMA = _Doubt(
    re.compile(_BEFORE + rb"(?P<word>G1[56])[ \t]*H[ \t]*\d", re.MULTILINE | re.IGNORECASE),
    "G15 H chooses a coordinate system on Okuma's controls, whose language is not read; here it ends polar coordinates",
    "post the program for FANUC: G54 in place of G15 H1, G43 H1 in place of G56 H1",
)
_LINUXCNC = (
    _Doubt(
        re.compile(
            _BEFORE + rb"G(?:0?4|74|8[24689])(?![\d.])[^(;\nG]*?(?P<word>P)[ \t]*\d{3,}(?![\d.])",
            re.MULTILINE | re.IGNORECASE,
        ),
        "P is a dwell in seconds; FANUC's controls count it in milliseconds",
        "--dialect fanuc reads milliseconds; P0.5 waits half a second here",
    ),
)
#: Lines that no dialect reads; each is an error, and this remark names their language.
_SIEMENS = _Doubt(
    re.compile(
        _BEFORE
        + rb"(?P<word>CYCLE\d+[ \t]*\(|\bR\d+[ \t]*=|=[ \t]*[AI]C[ \t]*\(|\bGOTO[FBC]\b|\bMCALL\b|\bTRA(?:ORI|NS|FOOF)\b"
        rb"|\bT[ \t]*=[ \t]*\"|\bDEF[ \t]+(?:REAL|INT|BOOL|STRING)\b|\bCR[ \t]*=)",
        re.MULTILINE | re.IGNORECASE,
    ),
    "this is of SINUMERIK's own language, of which this dialect has BSPLINE alone",
    "--dialect sinumerik reads it",
)
_HEIDENHAIN = _Doubt(
    re.compile(
        _BEFORE + rb"[A-Z][ \t]*[-+]?[\d.]+[ \t]*(?P<word>\*)[ \t]*\r?$", re.MULTILINE | re.IGNORECASE
    ),
    "blocks that end in * are of Heidenhain's DIN/ISO, which is not read",
    "post the program as Heidenhain's plain language, or for FANUC or LinuxCNC",
)
#: One of these stands in each such line; most texts have none, which is found sooner.
_OF_SIEMENS = re.compile(rb"=|CYCLE|GOTO|MCALL|TRA|DEF", re.IGNORECASE)
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
    found = []
    if language_of(dialect) in BOTH and _OF_SIEMENS.search(head):
        found.append((_SIEMENS, _SIEMENS.sign.search(head)))
    if language_of(dialect) in BOTH and b"*" in head:
        found.append((_HEIDENHAIN, _HEIDENHAIN.sign.search(head)))
    for doubt in {"fanuc": (*_FANUC, _OKUMA), "linuxcnc": (*_LINUXCNC, _OKUMA)}.get(dialect, ()):
        found.append((doubt, doubt.sign.search(head)))
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

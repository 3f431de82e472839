"""Which control a program is written for, told from its head."""

from __future__ import annotations

import re
from typing import NamedTuple

from cncgen.gcode.source import Source

#: Bytes that are looked at.
_HEAD = 65_536


class Choice(NamedTuple):
    """A dialect, the sign that spoke for it (or ""), and the line of it."""

    dialect: str
    reason: str
    line: int


#: Nothing more on a line but a comment and the sign of its end.
_ALONE = rb"[ \t]*(?:\([^)\n]*\))?[ \t]*;?[ \t]*\r?$"
#: Dialect, what speaks for it, one of the texts that stand in such a line, and the line's pattern: most texts have none of
#: the former, which are found much sooner.
_SIGNS = (
    ("heidenhain", "plain language", (), rb"(?:\d+[ \t]+)?(?:BEGIN[ \t]+PGM\b|SPL[ \t]+I?[XYZ])"),
    ("linuxcnc", "an O-word", (), rb"[oO][ \t]*(?:\d+|<[^>\n]*>)[ \t]*(?:sub|call|if|while|do|repeat|return)\b"),
    ("linuxcnc", "a named parameter", (b"#<",), rb"[^(;\n]*#<"),
    ("fanuc-lathe", "a bound of the spindle's speed by G50", (b"G50",), rb"[^(;\n]*\bG50[ \t]*S[ \t]*[\d#\[]"),
    ("fanuc-lathe", "a turning cycle of lines P to Q", (b"G70", b"G71", b"G72", b"G73"),
     rb"[^(;\n]*\bG7[0-3][ \t]*P[ \t]*\d+[ \t]*Q[ \t]*\d+(?![\d.])"),
    ("fanuc-lathe", "a thread of a lathe", (b"G76",), rb"[^(;\n]*\bG76[ \t]*P[ \t]*\d{5,6}(?![\d.])"),
    ("fanuc-lathe", "a reference point by distances U W", (b"G28", b"G30"),
     rb"[^(;\n]*\bG(?:28|30)[ \t]*U[ \t]*0?\.?0*[ \t]*W[ \t]*0?\.?0*(?![\d.])"),
    ("fanuc", "a jump of a macro", (b"GOTO",), rb"[^(;\n]*\bGOTO[ \t\d#\[]"),
    ("fanuc", "a loop of a macro", (), rb"(?:WHILE[ \t]*\[[^\n]*\][ \t]*DO|END[ \t]*[123]\b)"),
    ("fanuc", "a condition of a macro", (), rb"IF[ \t]*\[[^\n]*\][ \t]*THEN"),
    ("fanuc", "a sum without brackets", (), rb"#\d+[ \t]*=[ \t]*[#\d.][#\d.]*[ \t]*[-+*/][ \t]*[#\d\[]"),
    ("fanuc", "an output command of a macro", (), rb"(?:POPEN|PCLOS|[BD]PRNT)\b"),
    ("fanuc", "a macro call", (b"G65", b"G66"), rb"[^(;\n]*\bG6[56][ \t]*P"),
    ("fanuc", "a mirror, rotation, scaling or polar code", (b"G50.1", b"G51", b"G68", b"G69", b"G15", b"G16"),
     rb"[^(;\n]*\bG(?:50\.1|51\.1|68|69|51|1[56])(?![\d.])"),
    ("fanuc", "a code of FANUC alone", (b"G43.4", b"G54.1", b"G10"),
     rb"[^(;\n]*\bG(?:43\.4(?!\d)|54\.1[ \t]*P|10[ \t]*L1[23](?![\d.]))"),
    ("fanuc", "a look-ahead code", (b"5.1", b"G05", b"G5P", b"G5 ", b"G5\t", b"G08", b"G8"),
     rb"[^(;\n]*\bG0?(?:5\.1[ \t]*Q|5[ \t]*P(?:10000|0)[ \t]*\r?$|8[ \t]*P)"),
    ("fanuc", "a dwell of X", (b"G04", b"G4"), rb"[^(;\n]*\bG0?4[ \t]*X[ \t]*\.?\d"),
    ("fanuc", "a program number", (), rb"[oO:]\d{1,8}" + _ALONE),
    ("fanuc", "a program name", (), rb"[oO]?<[^>\n]*>" + _ALONE),
    ("fanuc", "a program number", (), rb"%[ \t]*[oO:]\d{1,8}" + _ALONE),
    ("fanuc", "a motion code beside G28", (b"G28", b"G30"),
     rb"[^(;\n]*G0?[0-3](?![\d.])[^(;\n]*G(?:28|30)(?![\d.])[^(;\n]*[XYZ][ \t]*[-+.\d#\[]"),
    ("fanuc", "a chamfer or rounding", (b",",), rb"[^(;\n]*,[ \t]*[CR][ \t]*[-+.\d#\[]"),
)  # fmt: skip
_PATTERNS = [
    (
        dialect,
        reason,
        texts,
        re.compile(rb"^[ \t]*(?:[nN][ \t]*\d+[ \t]*)?" + pattern, re.MULTILINE | re.IGNORECASE),
    )
    for dialect, reason, texts, pattern in _SIGNS
]


def chosen(source: Source, dialect: str) -> Choice:
    """Return a dialect that was asked for, or with ``auto`` what the text says."""
    return choose(source) if dialect == "auto" else Choice(dialect, "", 1)


def choose(source: Source) -> Choice:
    """Return the dialect of the first sign that is found, LinuxCNC's where there is none."""
    head = source.data[:_HEAD]
    capitals = head.upper()
    for dialect, reason, texts, pattern in _PATTERNS:
        if texts and not any(text in capitals for text in texts):
            continue
        match = pattern.search(head)
        if match:
            return Choice(dialect, reason, head.count(b"\n", 0, match.start()) + 1)
    return Choice("linuxcnc", "", 1)

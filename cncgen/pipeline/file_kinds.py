"""Kinds of files by their first bytes and their names: a program, setpoints, or another kind that was given by mistake."""

from __future__ import annotations

import codecs
import os

#: Suffixes by language.
SUFFIXES = {
    "gcode": (".nc", ".ngc", ".gcode", ".tap", ".cnc", ".txt"),
    "stepnc": (".stp", ".step", ".stpnc", ".p21", ".238"),
}
#: How an ISO 10303-21 file begins, whatever its name: blanks and comments may stand before and within it.
_COMMENT = rb"/\*(?:[^*]|\*(?!/))*"
_PART21 = rb"(?i)(?:\xef\xbb\xbf)?(?:\s|%b\*/)*(?:ISO-10303-21(?:\s|%b\*/)*;|%b\*?\Z)" % (
    _COMMENT,
    _COMMENT,
    _COMMENT,
)
#: Few programs of G-code begin with one of these bytes: only of those the pattern is compiled.
_PART21_BEGINS = b"iI/"
#: How files of setpoints, and of responses to them, begin: with a header of columns, or a signature. No program begins so.
_SETPOINT_HEADS = (
    *(b"t_s,", b'"t_s"', b'{"t_s"', b"\x93NUMPY", b"ARROW1", b"PAR1", b"\x89HDF\r\n\x1a\n"),
    *(b"\x89MCAP0\r\n", b"MATLAB 5", b"MDF     ", b"CSP1", b'# {"format": "csp"'),
)
_EXPORT = "save the toolpath as G-code in the CAM system"
#: Files that are neither programs nor setpoints: the name of the kind, texts that its first bytes begin with (small letters, without blanks
#: before them and with a blank for each run of them), a text that stands there as well, and a hint.
_OTHERS: tuple[tuple[str, tuple[bytes, ...], bytes, str], ...] = (
    ("a machine file", (b"name", b"period_s", b"[", b"# "), b" [axes.", "-m takes a machine"),
    ("a mesh (STL)", (b"solid ",), b" facet normal ", _EXPORT),
    ("a drawing (DXF)", (b"0 section ", b"999 "), b"0 section 2 ", _EXPORT),
    ("a layer of a printed board (Gerber)", (b"%", b"g04 "), b"%fsla", _EXPORT),
    ("a web page", (b"<!doctype html", b"<html"), b"", ""),
    ("an XML file", (b"<?xml ",), b"", ""),
    ("a PDF document", (b"%pdf-",), b"", ""),
    ("a picture", (b"\x89png", b"gif8", b"\xff\xd8\xff"), b"", ""),
    ("an archive", (b"pk\x03\x04", b"\x1f\x8b", b"bzh", b"\xfd7zxz", b"7z\xbc\xaf", b"rar!"), b"", "unpack it first"),
)  # fmt: skip


def language_of(name: str, head: bytes) -> str:
    """Return ``stepnc`` or ``gcode``: by how the content begins, then by the suffix, else G-code."""
    begin = head.removeprefix(codecs.BOM_UTF8).lstrip()[:1]
    if begin and begin in _PART21_BEGINS:
        import re

        if re.match(_PART21, head):
            return "stepnc"
    suffix = os.path.splitext(name)[1].lower()
    return "stepnc" if suffix in SUFFIXES["stepnc"] else "gcode"


def holds_setpoints(head: bytes) -> bool:
    """Tell by its first bytes whether a file holds setpoints, or a response to them, rather than a program."""
    return head.removeprefix(codecs.BOM_UTF8).startswith(_SETPOINT_HEADS) or _is_npz(head)


def _is_npz(head: bytes) -> bool:
    """Tell whether a file is a ZIP archive of arrays: the name of its first member stands behind its header of 30 bytes."""
    return head.startswith(b"PK\x03\x04") and head[30:].partition(b".npy")[1] != b""


def other_kind(head: bytes) -> tuple[str, str] | None:
    """Return what a file is that is neither a program nor setpoints, and a hint; None where it may be either."""
    begin = b" ".join(head.removeprefix(codecs.BOM_UTF8).lower().split())
    for what, beginnings, text, hint in _OTHERS:
        if begin.startswith(beginnings) and text in begin:
            return what, hint
    return None

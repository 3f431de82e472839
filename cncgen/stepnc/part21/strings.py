"""Strings of ISO 10303-21, clause 6.4.3: control directives to characters and back."""

from __future__ import annotations

import re

_DIRECTIVE = re.compile(
    r"\\\\"
    r"|\\S\\(?P<shifted>.)"
    r"|\\P(?P<page>[A-I])\\"
    r"|\\X\\(?P<octet>[0-9A-Fa-f]{2})"
    r"|\\X2\\(?P<two>(?:[0-9A-Fa-f]{4})*)\\X0\\"
    r"|\\X4\\(?P<four>(?:[0-9A-Fa-f]{8})*)\\X0\\"
    r"|\\[NF]\\",
    re.DOTALL,
)
_LINE_ENDS = re.compile(r"[\r\n]+")
_SPECIAL = re.compile(r"[^ -&(-\[\]-~]+")


def decode(text: str) -> str:
    """Return the characters that the text between the apostrophes means.

    Line ends are dropped (writers break long strings with them); the directives ``\\S\\``, ``\\P.\\``, ``\\X\\``,
    ``\\X2\\``, ``\\X4\\`` give characters, ``\\N\\`` and ``\\F\\`` (print control) nothing. Text that only looks
    like a directive stays.
    """
    if "'" in text:
        text = text.replace("''", "'")
    if "\n" in text or "\r" in text:
        text = _LINE_ENDS.sub("", text)
    if "\\" not in text:
        return text
    page = "iso8859-1"

    def character(match: re.Match[str]) -> str:
        nonlocal page
        if match["page"]:
            page = f"iso8859-{ord(match['page']) - ord('A') + 1}"
            return ""
        if match["shifted"]:
            code = ord(match["shifted"]) | 0x80
            return bytes([code]).decode(page, "replace") if code < 0x100 else match["shifted"]
        if match["octet"]:
            return chr(int(match["octet"], 16))
        if match["two"] is not None:
            units = bytes.fromhex(match["two"])
            return units.decode("utf-16-be", "surrogatepass")
        if match["four"] is not None:
            return _from_four(match["four"])
        return "\\" if match[0] == "\\\\" else ""

    return _DIRECTIVE.sub(character, text)


def _from_four(digits: str) -> str:
    codes = [int(digits[i : i + 8], 16) for i in range(0, len(digits), 8)]
    return "".join(chr(c) if c < 0x110000 else "�" for c in codes)


def encode(text: str) -> str:
    """Return the text to put between apostrophes, ASCII only, that `decode` makes the same string of."""

    def directive(match: re.Match[str]) -> str:
        out = []
        for c in match[0]:
            code = ord(c)
            if c == "'":
                out.append("''")
            elif c == "\\":
                out.append("\\\\")
            elif code < 0x100:
                out.append(f"\\X\\{code:02X}")
            elif code < 0x10000:
                out.append(f"\\X2\\{code:04X}\\X0\\")
            else:
                out.append(f"\\X4\\{code:08X}\\X0\\")
        return "".join(out)

    return _SPECIAL.sub(directive, text)

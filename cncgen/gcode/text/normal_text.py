"""Blocks in normal form: without blanks, in capital letters."""

from __future__ import annotations

import re

from cncgen.grammars.terminals import FANUC

#: Outside comments, capital letters mean the same as small ones (of ASCII: no other character is a letter here), and blanks nothing.
_BARE = {**{c: c + 32 for c in range(ord("A"), ord("Z") + 1)}, **dict.fromkeys(b" \t\r")}
_PIECE = re.compile(rf"{FANUC['COMMENT']}|\(.*|[ \t\r]+")


def normalise(text: str) -> str:
    """Return the block without blanks and in lower case, comments as they are."""

    if "(" not in text and ";" not in text:
        return text.translate(_BARE)
    parts = []
    place = 0
    for match in _PIECE.finditer(text):
        piece = match.group()
        parts.append(text[place : match.start()].translate(_BARE))
        parts.append(piece if piece[0] in "(;" else "")
        place = match.end()
    parts.append(text[place:].translate(_BARE))
    return "".join(parts)

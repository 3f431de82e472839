"""Tables of Heidenhain's controls as text: rows of points (.PNT) and datums (.D) below a head that names their columns."""

from __future__ import annotations

from cncgen.gcode.errors import BlockError


def rows(text: str, name: str, what: str) -> list[dict[str, float]]:
    """Return the rows of a table, by the names of their columns; columns that hold texts are left out.

    Args:
        text: The table.
        name: Its file, for messages.
        what: Which table it is, for messages.

    Raises:
        BlockError: It has no columns X and Y, or X, Y or Z of a row is not a number.
    """
    lines = [line.split() for line in text.splitlines() if line.strip()]
    head = next((k for k, words in enumerate(lines) if {"X", "Y"} <= {word.upper() for word in words}), None)
    if head is None:
        hint = f"a {what} has NR X Y Z in its second line"
        raise BlockError("unsupported-block", f"{name} has no columns X and Y", "SEL", hint=hint)
    names = [word.upper() for word in lines[head]]
    found = []
    for words in lines[head + 1 :]:
        if words[0].upper().startswith(("[END]", "#")):
            break
        row = dict[str, float]()
        for column, word in zip(names, words, strict=False):
            try:
                row[column] = float(word.replace(",", "."))
            except ValueError:
                if column in ("X", "Y", "Z"):
                    message = f"{' '.join(words)} of {name} is no row of a {what}"
                    hint = "NR X Y Z, as in 0 +10 +20 +0"
                    raise BlockError("unsupported-block", message, "SEL", hint=hint) from None
        found.append(row)
    return found

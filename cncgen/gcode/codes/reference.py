"""The list of codes for people, made from the tables of the interpreter."""

from __future__ import annotations

from collections.abc import Iterator

from cncgen import extensions
from cncgen.gcode.block import AXES, NEXT_TOOL
from cncgen.gcode.codes.table import BOTH, LATHES, Code, language_of, table
from cncgen.records import replace

#: Dialects with codes of their own; the others write the same codes under other numbers.
DIALECTS = tuple(dialect for dialect in extensions.DIALECTS if not LATHES.get(dialect))
#: Codes of the user stand in one line.
_USER = "user"


def codes(dialect: str) -> list[Code]:
    """Return the codes of a dialect: G in the order of their numbers, then M, then words that act by themselves."""
    order = {"G": 0, "M": 1}
    rows = table(dialect)
    own = [
        code for code in rows.values() if {dialect, rows.family, language_of(dialect)} & set(code.dialects)
    ]
    written = {number: f"G{own / 10:g}" for own, number in LATHES.get(dialect, {}).items()}
    own = [
        replace(code, title=written[code.number]) if code.letter == "G" and code.number in written else code
        for code in own
    ]
    return sorted(own, key=lambda code: (order.get(code.letter, 2), code.number, code.letter))


def rows(dialects: tuple[str, ...] = DIALECTS) -> Iterator[tuple[str, str, str, str]]:
    """Yield name, words, dialects and help of each code; a code of two meanings has two rows."""
    found: dict[tuple[str, str, str], list[str]] = {}
    for dialect in dialects:
        for code in codes(dialect):
            if code.group != _USER:
                found.setdefault((code.name, _words(code), code.help), []).append(dialect)
    order = {
        code.name: ("GM".find(code.letter) % 3, code.number, code.letter)
        for d in dialects
        for code in codes(d)
    }
    for name, words, text in sorted(found, key=lambda key: order[key[0]]):
        yield name, words, " ".join(found[name, words, text]), text
    both = [dialect for dialect in dialects if language_of(dialect) in BOTH]
    if both:
        yield "M100 … M199", "P Q", " ".join(both), "the user's own: an event"


def _words(code: Code) -> str:
    """Return the words of a code as people write them; all axes together as one."""
    letters = code.words
    shown = []
    if all(letter in letters for letter in AXES):
        shown.append("axes")
        letters = "".join(letter for letter in letters if letter not in AXES)
    shown += sorted(
        letter.upper() for letter in letters if letter not in "@^" and letter.upper() != code.name
    )
    if code.name == "SPL":
        return "axes F K1 K2 K3 of each"
    sign = "" if code.dialects == ("heidenhain",) or code.named == (",k",) else "="
    # The feed of a corner or retraction alone has a name within only: people write F, FRC or FRCM.
    named = [name for name in code.named if name != NEXT_TOOL and not name.endswith("_f")]
    return " ".join([*shown, *(name.upper() + sign for name in named if name.upper() != code.name)])


def markdown() -> str:
    """Return the table of codes for docs/language.md."""
    lines = ["| code | words | dialects | does |", "| --- | --- | --- | --- |"]
    lines += [f"| {name} | {words} | {dialects} | {text} |" for name, words, dialects, text in rows()]
    return "\n".join(lines) + "\n"

"""Cycles of SINUMERIK that are not read: what each does, and what may stand in its place."""

from __future__ import annotations

from cncgen.gcode.errors import BlockError

#: The names with which a call is of a cycle, if no subprogram has it.
_BEGINNINGS = ("CYCLE", "LCYC", "LONGHOLE", "SLOT", "POCKET", "HOLES")
_GROOVE, _STOCK = "CYCLE93 cuts grooves", "CYCLE95 roughs and finishes a contour"
#: The work of a cycle, and the sister that is read. (840D sl, Job planning, "Programming cycles externally")
_KNOWN = {
    "CYCLE63": ("a pocket or spigot of any contour", "CYCLE72 mills along a contour"),
    "CYCLE64": ("predrilling of a pocket", "CYCLE83 drills"), "CYCLE78": ("drilling and milling of a thread", "CYCLE83 drills, CYCLE70 and CYCLE90 mill threads"),
    "CYCLE79": ("a spigot of several edges", "CYCLE72 mills along a contour"), "CYCLE899": ("an open slot", "SLOT1 and POCKET3 clear closed ones"),
    "CYCLE930": ("a groove", _GROOVE),
    **dict.fromkeys(("CYCLE94", "CYCLE96", "CYCLE940"), ("an undercut", "its contour as blocks of G1 and G2")),
    **dict.fromkeys(("CYCLE950", "CYCLE952"), ("stock removal", _STOCK)),
}  # fmt: skip
#: Cycles of the controls before the 840D, which a program calls by R parameters and L.
_OLDER = {
    "L903": "a rectangular pocket, as POCKET1 and POCKET3 here",
    "L930": "a circular pocket, as POCKET2 and POCKET4 here",
}


def hint_of(name: str) -> str:
    """Return advice on a name that no subprogram has."""
    older = f"; on SINUMERIK 810 and 820 it mills {_OLDER[name]}" if name in _OLDER else ""
    return f"{name}.SPF in a folder of --include is found{older}"


def is_cycle(name: str) -> bool:
    """Tell whether a name is a cycle's, as no command has it."""
    return name.startswith(_BEGINNINGS)


def is_step(name: str) -> bool:
    """Tell whether a name has the form of a step of ShopMill or ShopTurn, as no command has it."""
    return name[:2] in ("E_", "F_") and name[2:].isupper()


def refused(name: str) -> BlockError:
    """Return the error of a cycle or a step that is not read."""
    if is_step(name):
        message = f"{name} (a step of ShopMill or ShopTurn, or a subprogram that is not found) is not read"
        hint = "write the step in G code with the cycles of docs/sinumerik.md; --include adds a folder of subprograms"
        return BlockError("not-read", message, name, hint=hint)
    what, instead = _KNOWN.get(name, ("of 802S and 802C" if name[0] == "L" and name[1] == "C" else "", ""))
    message = f"the cycle {name}{f' ({what})' if what else ''} is not read"
    hint = f"{instead}; " if instead else ""
    hint = f"{hint}docs/sinumerik.md lists those that are read; --include adds a folder of subprograms"
    return BlockError("not-read", message, name, hint=hint)

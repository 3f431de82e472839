"""Lines that run again: what was read of a line, kept with what it does and where it leads."""

from __future__ import annotations

from collections.abc import Callable

from cncgen.gcode.block import Block
from cncgen.gcode.flow.leads import Lead
from cncgen.gcode.text.labels import Cursor


class Node:
    """A line that was read: what it does or where it leads, and the line after it.

    Attributes:
        offset: Where it stands in the main program; -1 in other texts.
        following: Node of the next line, once it was needed.
        target, landing: Where it led last, and the node of that place.
        reads: Whether it is computed while it is read, each time, as long as it can be.
        settles: Whether its values tell where the machine is, so that blocks that wait run before.
    """

    __slots__ = (
        "after",
        "block",
        "cursor",
        "following",
        "landing",
        "lead",
        "offset",
        "reads",
        "run",
        "settles",
        "target",
    )

    def __init__(
        self,
        cursor: Cursor,
        after: Cursor,
        run: Callable[[], None] | None = None,
        lead: Lead | None = None,
        *,
        reads: bool = False,
        settles: bool = True,
    ) -> None:
        self.cursor = cursor
        self.after = after
        self.run = run
        self.lead = lead
        self.reads = reads
        self.settles = settles
        self.block = Block({}, source=cursor.source, line=cursor.line, offset=cursor.offset)
        self.offset = -1 if cursor.source else cursor.offset
        self.following: Node | None = None
        self.target: Cursor | None = None
        self.landing: Node | None = None

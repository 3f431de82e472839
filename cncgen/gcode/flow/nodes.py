"""A line that may run again, kept as a node: its effect, and the line that comes next. See `walking`."""

from __future__ import annotations

from collections.abc import Callable

from cncgen.gcode.block import Block
from cncgen.gcode.flow.successors import Successor
from cncgen.gcode.text.labels import Cursor


class Node:
    """A line that was read: its effect or the place it leads to, and the line after it.

    Attributes:
        cursor, after: Where it begins, and where the next line begins.
        run: Effect of a block; None for O-words, and for lines that do nothing.
        successor: Gives the place that an O-word leads to, None for the next line; None for blocks.
        block: An empty block at its place, for diagnostics.
        offset: Where it stands in the main program; -1 in other texts.
        following: Node of the next line, once it was needed.
        target, landing: Where it led last, and the node of that place.
        reads: Whether it is computed while it is read, each time it runs.
        flushes: Whether its values may depend on where the machine is, so that pending blocks must run first.
    """

    __slots__ = (
        "after",
        "block",
        "cursor",
        "flushes",
        "following",
        "landing",
        "offset",
        "reads",
        "run",
        "successor",
        "target",
    )

    def __init__(
        self,
        cursor: Cursor,
        after: Cursor,
        run: Callable[[], None] | None = None,
        successor: Successor | None = None,
        *,
        reads: bool = False,
        flushes: bool = True,
    ) -> None:
        self.cursor = cursor
        self.after = after
        self.run = run
        self.successor = successor
        self.reads = reads
        self.flushes = flushes
        self.block = Block({}, source=cursor.source, line=cursor.line, offset=cursor.offset)
        self.offset = -1 if cursor.source else cursor.offset
        self.following: Node | None = None
        self.target: Cursor | None = None
        self.landing: Node | None = None

"""Lines that run again: where a program jumps back (a loop) or away (a subroutine), each line is read once and kept as a node.

Nodes are walked until the program comes to a line that it has not reached before; from there `stream` goes on. Keeping a line
of plain words, expressions and settings would gain nothing: it is computed while it is read, each time.
"""

from __future__ import annotations

from collections.abc import Generator

from cncgen.gcode.errors import Astray, BlockError
from cncgen.gcode.flow import sub_words
from cncgen.gcode.flow.nodes import Node
from cncgen.gcode.flow.parts import Parts
from cncgen.gcode.flow.recurrence import Recurrence
from cncgen.gcode.flow.stream import Stream
from cncgen.gcode.flow.successors import successor_of
from cncgen.gcode.text.expressions import too_deep
from cncgen.gcode.text.labels import Cursor

#: After so many lines the walk yields, so that rows can be taken away.
_PAUSE = 1024
#: Lines kept as nodes; a loop is rarely longer.
_MAX_NODES = 65_536
#: Blocks that loops may execute after a fault: the faulty line may be the one that would have ended the loop.
_MOST_AFTER_A_FAULT = 1_000_000


class Walker:
    """Walks nodes beside a stream, whose `reached` says where it takes over again."""

    def __init__(self, parts: Parts, stream: Stream) -> None:
        self._parts = parts
        self._stream = stream
        self._frames = parts.control.calls.frames
        self._nodes: dict[Cursor, Node] = {}
        self._recurrence = Recurrence(parts.ip, parts.control.calls)

    def walk(self, cursor: Cursor) -> Generator[None, None, None]:
        """Run line by line from a place until the stream can go on; yields now and then, so that rows can be taken away.

        Raises:
            Astray: The stream can never go on: a round has changed nothing, or a fault keeps the loop from ending.
        """
        ip, frames, parts = self._parts.ip, self._frames, self._parts
        begun = ip.budget.steps
        reached = self._stream.reached.offset
        node = self._node(cursor)
        count = 0
        looks = False
        while not ip.state.ended:
            if node.offset >= reached and not frames:
                self._stream.reached = node.cursor
                break
            count += 1
            if count == _PAUSE:
                parts.ip.budget.count(count)
                count = 0
                if parts.faults.found and ip.budget.steps - begun > _MOST_AFTER_A_FAULT:
                    raise Astray
                looks = True
                yield
            try:
                following = self._after(node, self._step(node))
            except (BlockError, RecursionError) as error:
                parts.faults.fail(node.cursor, error if isinstance(error, BlockError) else too_deep())
                following = self._node(node.after)
            if following is None:
                break
            if looks and following.cursor <= node.cursor:
                looks = False
                self._look(node, following)
            node = following
        parts.ip.budget.count(count)

    def _look(self, node: Node, back: Node) -> None:
        """Raise where a jump back finds everything as it was at the last one: the loop is endless."""
        self._parts.pending.flush()
        if self._recurrence.found(back.cursor):
            if self._parts.faults.found:
                # A faulty line before may be the one that would have ended it.
                raise Astray
            self._parts.ip.base.block = node.block
            message = f"back to line {back.cursor.line} with everything as it was there before: this goes on for ever"
            hint = "does anything in the loop change what ends it? for one round, leave the jump back out"
            raise Astray(BlockError("too-many-steps", message, hint=hint))

    def _step(self, node: Node) -> Cursor | None:
        """Run a line, and those behind it that are computed with it; return where that leads, None for the next line."""
        parts = self._parts
        if node.reads:
            target, _ = parts.pending.compute(node.cursor)
            if target is not node.cursor:
                return node.target if target == node.target else target
            self._read_whole(node)
        if node.run is not None:
            parts.pending.flush()
            node.run()
            if parts.ip.jump is not None:
                return sub_words.follow_jump(parts.control, node.cursor, node.after)
            return None
        if node.successor is None:
            return None
        if node.flushes:
            parts.pending.flush()
        parts.ip.base.block = node.block
        return node.successor()

    def _read_whole(self, node: Node) -> None:
        """Read a line that is not computed while it is read."""
        whole = self._read_node(node.cursor, alone=True)
        node.run, node.successor, node.flushes, node.reads = whole.run, whole.successor, whole.flushes, False

    def _after(self, node: Node, target: Cursor | None) -> Node | None:
        """Return the node of the place where a node led, or of the next line; a node remembers both.

        None where the stream goes on from there: its `reached` is then that place.
        """
        if target is None:
            if node.following is not None:
                return node.following
            target = node.after
        elif target is node.target:
            return node.landing
        if target.source == 0 and target.offset >= self._stream.reached.offset and not self._frames:
            self._stream.reached = target
            return None
        found = self._node(target)
        if target is node.after:
            node.following = found
        else:
            node.landing, node.target = found, target
        return found

    def _node(self, cursor: Cursor) -> Node:
        """Return the node of a line, read now or before."""
        node = self._nodes.get(cursor)
        if node is None:
            if len(self._nodes) >= _MAX_NODES:
                self._nodes.clear()
            node = self._nodes[cursor] = self._read_node(cursor)
        return node

    def _read_node(self, cursor: Cursor, *, alone: bool = False) -> Node:
        """Read a line as a node; one that is wrong says so when it is run. Unless `alone`, it may be read as it runs."""
        parts = self._parts
        if cursor.offset >= len(parts.sources[cursor.source]):
            return self._end_node(cursor)
        after = parts.lines.after(cursor)
        try:
            text = parts.lines.text(cursor)
            bare = text.strip()
            if not bare:
                return Node(cursor, after)
            if bare.startswith("%"):
                run = None if cursor.source else lambda: parts.percent.line(text, self._stream.reached.offset)
                return Node(cursor, after, run=run)
            if parts.pending.computes and not alone and bare[0] not in "oO/":
                return Node(cursor, after, reads=True)
            return self._parsed_node(text, cursor, after)
        except BlockError as error:
            fault = error

            def fail() -> None:
                raise fault

            return Node(cursor, after, run=fail)

    def _parsed_node(self, text: str, cursor: Cursor, after: Cursor) -> Node:
        """Return the node of a line that holds a block."""
        parts = self._parts
        parsed = parts.lines.parse(text)
        if parsed.deletable and parts.ip.options.block_delete:
            return Node(cursor, after)
        if parsed.flow is None:
            return Node(cursor, after, run=parts.compiler.action(parsed, cursor))
        if parsed.flow.then is not None:
            return Node(cursor, after, run=parts.compiler.then(parsed.flow, cursor))
        successor = successor_of(parts.control, parsed.flow, cursor, after)
        return Node(cursor, after, successor=successor, flushes=parsed.flow.asks_state)

    def _end_node(self, cursor: Cursor) -> Node:
        """Return what the end of a text does: the main program ends, a subroutine is not finished."""
        parts = self._parts

        def run() -> None:
            if self._frames:
                name = parts.sources[cursor.source].name
                raise Astray(
                    BlockError("sub-unfinished", f"{name} ends within a subroutine", hint="ENDSUB or M99?")
                )
            parts.ip.state.ended = True

        return Node(cursor, cursor, run=run)

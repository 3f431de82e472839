"""Running a program: blocks from the two lanes, in the order of execution, into the interpreter; faults into diagnostics.

A program runs as a stream while it goes forward: plain blocks are scanned in runs, and runs of plain motions are
interpreted in arrays. Where it goes back (a loop) or away (a subroutine), lines are read once, kept as nodes and
walked, until it is again where it has not been. Either way lines of plain words, expressions and settings are computed
while they are read (`computing`); their blocks wait, and run before anything that needs to know where the machine is.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from pathlib import Path

from cncgen.diagnostics import Diagnostics, Severity
from cncgen.gcode import comments, descent, macros
from cncgen.gcode.batches import Batches
from cncgen.gcode.block import AXIS_INDEX, Block, Flow, Parsed
from cncgen.gcode.compiling import Compiler
from cncgen.gcode.computing import Computing
from cncgen.gcode.dialects import Choice, choose
from cncgen.gcode.errors import Astray, BlockError, Reporter, Stop
from cncgen.gcode.expressions import too_deep
from cncgen.gcode.flow import FlowControl
from cncgen.gcode.interpreter import Interpreter, Plan
from cncgen.gcode.labels import Cursor
from cncgen.gcode.lanes import BLOCKS, PlainBlocks, comment_of
from cncgen.gcode.leads import lead_of
from cncgen.gcode.nodes import Node
from cncgen.gcode.parameters import write_parameters
from cncgen.gcode.sink import Sink
from cncgen.gcode.source import MAX_LINE, Source
from cncgen.kernels import gcode_scan
from cncgen.toolpath.reading import ReadOptions

#: Blocks through the slow lane between two chances to hand rows on, and texts remembered.
_PAUSE = 1024
#: Lines kept as nodes; a loop is rarely longer.
_MAX_NODES = 65_536
_G11 = 110
#: Faults of lines that failed before, after which the loops they stand in count as endless.
_MAX_FAILURES = 1000


class Runner:
    """One run of a program on a sink.

    Without `batches` every block goes through its handlers one by one, which is slower and gives the same. `axes` are
    those that the sink has room for, where it is not for all.
    """

    def __init__(
        self,
        source: Source,
        options: ReadOptions,
        sink: Sink,
        diagnostics: Diagnostics,
        *,
        path: Path | None = None,
        batches: bool = True,
        axes: str | None = None,
    ) -> None:
        self.sources = [source]
        self.options = options
        self.sink = sink
        self.reporter = Reporter(diagnostics)
        self.dialect, self._why, self._why_line = (
            choose(source) if options.dialect == "auto" else Choice(options.dialect, "", 1)
        )
        self.ip = Interpreter(sink, options, self.remark, self.dialect)
        self.flow = self.ip.flow = FlowControl(self.ip, self.sources, path, axes)
        self._increments = self.dialect == "fanuc" and options.least_increment is not None
        #: Whether the scanner cannot read the dialect's plain blocks.
        self._by_line = self._increments or self.dialect == "heidenhain"
        self.steps = 0
        self._plain = PlainBlocks()
        self._batches = Batches(self.ip) if batches else None
        self._compiler = Compiler(self.ip, self.flow, self._execute)
        self._computing = (
            Computing(self.ip.parameters, self.sources, self._plain)
            if batches and self.dialect == "linuxcnc"
            else None
        )
        self.flow.settle = self._settle
        #: Whether the last line in the stream was an O-word.
        self._branched = False
        self._percent = False
        self._seen = False
        self._parsed: dict[str, Parsed] = {}
        self._nodes: dict[Cursor, Node] = {}
        #: Lines that failed, and how; each is said once.
        self._failed: set[tuple[Cursor, str]] = set()
        self._failures = 0
        self._reached = Cursor(0, 0, 1)

    # The loop.

    def run(self) -> Iterator[None]:
        """Run to the end; yields now and then, so that rows can be taken away."""
        source = self.sources[0]
        if source.is_binary():
            hint = "is it UTF-16? save it as UTF-8 or ASCII" if source.is_wide() else ""
            message = f"{source.name} is no text: it holds NUL bytes"
            self._fault(Cursor(0, 0, 1), BlockError("binary-file", message, hint=hint))
            return
        try:
            self._say_dialect(source)
            self.ip.begin()
            yield from self._run(source)
            self._finish(source)
        except Stop as stop:
            block = self.sink.block
            self._fault(Cursor(block.source, block.offset, max(block.line, 1)), stop.error)

    def _run(self, source: Source) -> Iterator[None]:
        """Run until the program ends; where it leads nowhere, go on at the first line not reached yet."""
        while not self.ip.state.ended:
            try:
                yield from self._run_on(source)
                return
            except Astray as astray:
                self._settle()
                if astray.error is not None:
                    block = self.sink.block
                    self._fault(Cursor(block.source, block.offset, max(block.line, 1)), astray.error)
                self.flow.give_up()

    def _run_on(self, source: Source) -> Iterator[None]:
        target: Cursor | None = None
        state = self.ip.state
        while not state.ended:
            if target is not None:
                yield from self._walk(target)
                target = None
            elif self._plain.count or self._branched:
                # Blocks wait, which the scanner would write over, or few are likely to follow.
                target = self._go_on()
            else:
                why, target = self._scan(source)
                if target is None and not state.ended:
                    if why == gcode_scan.END:
                        return
                    if why == gcode_scan.OTHER and not self._compute():
                        target = self._run_line(source)
                yield

    def _scan(self, source: Source) -> tuple[int, Cursor | None]:
        """Run plain blocks; return why the scanner stopped, and where they lead, None for the line where it did."""
        if self._by_line:
            # The scanner does not tell 10 from 10. so every line goes through the grammar.
            return (gcode_scan.OTHER if self._reached.offset < len(source) else gcode_scan.END), None
        self._reached, why = self._plain.scan(source, self._reached)
        return why, self._run_plain(source)

    def _say_dialect(self, source: Source) -> None:
        """Note which dialect was chosen, where something in the text decided it."""
        if self._why:
            message = f"read as {self.dialect}: {self._why}"
            error = BlockError("dialect", message, hint="--dialect overrides")
            offset = 0
            for _ in range(self._why_line - 1):
                offset = source.line_end(offset) + 1
            self.reporter.report(source, self._why_line, offset, error, Severity.NOTE)

    def _finish(self, source: Source) -> None:
        """Say what is missing at the end of the text, and keep the parameters where asked."""
        last = Cursor(0, _last_line(source), max(self._reached.line - 1, 1))
        try:
            self.ip.end_compensation()
        except BlockError as error:
            self._fault(last, error)
        if self.ip.guard is not None:
            self._guarded(Block({}, m=(20,), line=last.line, offset=last.offset))
        if not self._seen:
            self._fault(Cursor(0, 0, 1), BlockError("empty-program", f"{source.name} has no block"))
        elif not self.ip.state.ended:
            self.sink.block = Block({}, line=last.line, offset=last.offset)
            self.remark(
                BlockError("no-program-end", "the program ends without M2, M30 or a closing %"),
                Severity.ERROR if self.options.stand_alone else Severity.WARNING,
            )
        if self.options.save_parameters is not None:
            write_parameters(self.options.save_parameters, self.ip.parameters)

    def _count(self, blocks: int) -> None:
        self.steps += blocks
        if self.steps > self.options.max_steps:
            raise Stop(
                BlockError(
                    "too-many-steps",
                    f"more than {self.options.max_steps} blocks were executed: the program counts as endless",
                    hint="--max-steps sets the bound",
                )
            )

    # Plain blocks, as they come.

    def _run_plain(self, source: Source) -> Cursor | None:
        """Run the blocks that were scanned: in arrays where they are plain motions, else one by one."""
        count, self._plain.count = self._plain.count, 0
        index = 0
        if count and self._plain.word_end[count - 1]:
            self._seen = True
        while index < count and not self.ip.state.ended:
            done = self._batches.run(self._plain, index, count) if self._batches else index
            if done == count:
                self._count(count - index)
                break
            here = self._plain.cursor(done)
            self._run_one(source, done, here)
            self._count(done - index + 1)
            if self.ip.jump is not None:
                after = Cursor(0, source.line_end(here.offset) + 1, here.line + 1)
                self._reached = after
                try:
                    return self._jump(here, after)
                except BlockError as error:
                    self._fail(here, error)
                    return None
            index = done + 1
        return None

    def _run_one(self, source: Source, index: int, here: Cursor) -> None:
        """Run one plain block by itself."""
        flags = self._plain.flags[index]
        if flags & gcode_scan.SLASH and self.options.block_delete:
            return
        try:
            comment = None
            if flags & gcode_scan.ACTIVE or (flags & gcode_scan.COMMENT and self.sink.wants_comments):
                comment = comment_of(source.text_at(here.offset))
            if self.dialect == "fanuc" and self._compiler.call_macro(self._plain.pairs(index)):
                return
            block = self._plain.block(index)
            block.comment = comment
            self._execute(block)
        except BlockError as error:
            self._fail(here, error)

    # Lines with values to compute.

    def _compute(self) -> bool:
        """Read on from `_reached` lines that are computed while they are read; tell whether there was one."""
        if self._computing is None:
            return False
        plain, here = self._plain, self._reached
        if plain.count and (plain.source != 0 or plain.count == BLOCKS):
            self._settle()
        waiting = plain.count
        self._reached = after = self._computing.read(here)
        if after is here:
            return False
        self._seen = True
        self._count(after.line - here.line - (plain.count - waiting))
        return True

    def _go_on(self) -> Cursor | None:
        """Read on lines that are computed, and run the O-word that ends them; else nothing waits any longer."""
        assert self._computing is not None
        self._compute()
        found = self._computing.flow(self._reached)
        if found is not None:
            return self._run_o_word(*found, self._reached)
        self._settle()
        self._branched = False
        return None

    def _settle(self) -> None:
        """Run the blocks that wait."""
        if self._plain.count:
            self._run_plain(self.sources[self._plain.source])

    # Any other line, as it comes.

    def _run_line(self, source: Source) -> Cursor | None:
        """Run the line that nobody took; return where it leads, None for the next line."""
        here = self._reached
        found = self._computing.flow(here) if self._computing is not None else None
        if found is not None:
            return self._run_o_word(*found, here)
        self._reached = after = Cursor(0, source.line_end(here.offset) + 1, here.line + 1)
        self.sink.block = Block({}, line=here.line, offset=here.offset)
        try:
            text = self._text(here)
            if text.lstrip().startswith("%"):
                self._percent_line(text)
                return None
            self._seen = True
            self._count(1)
            parsed = self._parse(text)
            if parsed.deletable and self.options.block_delete:
                return None
            if parsed.flow is not None:
                return self._run_flow(parsed.flow, here, after)
            self._compiler.action(parsed, here)()
            if self.ip.jump is not None:
                return self._jump(here, after)
        except BlockError as error:
            self._fail(here, error)
        return None

    def _run_o_word(self, flow: Flow, after: Cursor, here: Cursor) -> Cursor | None:
        """Run an O-word whose values are computed; as `_run_line`."""
        self._reached = after
        self._seen = self._branched = True
        self.sink.block = Block({}, line=here.line, offset=here.offset)
        try:
            self._count(1)
            return self._run_flow(flow, here, after)
        except BlockError as error:
            self._fail(here, error)
        return None

    def _run_flow(self, flow: Flow, here: Cursor, after: Cursor) -> Cursor | None:
        """Run an O-word (a comment behind it says nothing to the machine)."""
        if flow.then is not None:
            self._compiler.then(flow, here)()
            return self._jump(here, after) if self.ip.jump is not None else None
        target = self.flow.run(flow, here, after)
        if (
            target is not None
            and not self.flow.frames
            and target.source == 0
            and target.offset >= after.offset
        ):
            # Forward within the main program: go on as a stream from there.
            self._reached = target
            return None
        return target

    def _jump(self, here: Cursor, after: Cursor) -> Cursor | None:
        """Do what M98 or M99 asked for."""
        assert self.ip.jump is not None
        (kind, number, times), self.ip.jump = self.ip.jump, None
        if kind == "call":
            return self.flow.call_number(number, times, here, after) if times > 0 else after
        if kind in ("macro", "modal"):
            values, self.ip.macro_values = self.ip.macro_values, None
            if times < 1:
                return after
            target = self.flow.call_number(number, times, here, after, values)
            self.flow.frame.modal = kind == "modal"
            return target
        if self.flow.frames:
            back = self.flow.leave()
            return macros.line_numbered(self.flow, back, number, "P") if number > 0 else back
        self.ip.end_program()
        return None

    def _text(self, here: Cursor) -> str:
        """Return a line's text; raise where it is too long to be one."""
        source = self.sources[here.source]
        length = source.line_end(here.offset) - here.offset
        if length > MAX_LINE:
            raise BlockError(
                "line-too-long", f"a line of {length} bytes; the longest is {MAX_LINE}", column=1
            )
        return source.text_at(here.offset)

    def _percent_line(self, text: str) -> None:
        """Begin or end the program."""
        if self.dialect == "linuxcnc" and text.strip() != "%":
            raise BlockError(
                "syntax",
                "a line of % holds nothing else",
                column=text.index("%") + 1,
                hint="put the rest in a line",
            )
        if not self._seen and not self._percent and not self._is_late():
            self._percent = True
        elif self._percent:
            self.ip.state.ended = True
            self.sink.call("FINISH()")
        else:
            raise BlockError(
                "stray-percent", "a % that ends a program that no % began", column=text.index("%") + 1
            )

    def _is_late(self) -> bool:
        """Tell whether comments stand before the first %: LinuxCNC's interpreter has then begun without it."""
        if not self.options.stand_alone or self.dialect != "linuxcnc":
            return False
        return bool(self.sources[0].data[: self._reached.offset].strip().strip(b"%").strip())

    def _read(self, text: str) -> Parsed:
        """Read a block in the program's dialect."""
        if self.dialect == "heidenhain":
            from cncgen.gcode import heidenhain

            return heidenhain.parse(text)
        return descent.parse(text, self.dialect, self._increments)

    def _parse(self, text: str) -> Parsed:
        """Return the block of a text; the latest ones are remembered."""
        parsed = self._parsed.get(text)
        if parsed is None:
            parsed = self._read(text)
            if len(self._parsed) >= _PAUSE:
                self._parsed.clear()
            self._parsed[text] = parsed
        return parsed

    # Lines that run again.

    def _walk(self, cursor: Cursor) -> Generator[None, None, None]:
        """Run line by line from a place until the stream can go on; the stream's place is then `_reached`."""
        state, frames = self.ip.state, self.flow.frames
        reached = self._reached.offset
        node = self._node(cursor)
        count = 0
        while not state.ended:
            if node.offset >= reached and not frames:
                self._reached = node.cursor
                break
            count += 1
            if count == _PAUSE:
                self._count(count)
                count = 0
                yield
            try:
                following = self._after(node, self._step(node))
            except (BlockError, RecursionError) as error:
                self._fail(node.cursor, error if isinstance(error, BlockError) else too_deep())
                following = self._node(node.after)
            if following is None:
                break
            node = following
        self._count(count)

    def _step(self, node: Node) -> Cursor | None:
        """Run a line, and those behind it that are computed with it; return where that leads, None for the next line."""
        if node.reads:
            target = self._read_on(node)
            if target is not None:
                return target
            self._read_whole(node)
        if node.run is not None:
            self._settle()
            node.run()
            return self._jump(node.cursor, node.after) if self.ip.jump is not None else None
        if node.lead is None:
            return None
        if node.settles:
            self._settle()
        self.sink.block = node.block
        return node.lead()

    def _read_on(self, node: Node) -> Cursor | None:
        """Compute lines from a node on; return the first one that is not computed, None where it is the node's own."""
        assert self._computing is not None
        plain = self._plain
        if plain.count and (plain.source != node.cursor.source or plain.count == BLOCKS):
            self._settle()
        target = self._computing.read(node.cursor)
        if target is node.cursor:
            return None
        return node.target if target == node.target else target

    def _read_whole(self, node: Node) -> None:
        """Read a line that is not computed while it is read."""
        whole = self._read_node(node.cursor, alone=True)
        node.run, node.lead, node.settles, node.reads = whole.run, whole.lead, whole.settles, False

    def _after(self, node: Node, target: Cursor | None) -> Node | None:
        """Return the node of the place where a node led, or of the next line; a node remembers both.

        None where the stream goes on from there: `_reached` is then that place.
        """
        if target is None:
            if node.following is not None:
                return node.following
            target = node.after
        elif target is node.target:
            return node.landing
        if target.source == 0 and target.offset >= self._reached.offset and not self.flow.frames:
            self._reached = target
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
        source = self.sources[cursor.source]
        if cursor.offset >= len(source):
            return self._end_node(cursor)
        after = Cursor(cursor.source, source.line_end(cursor.offset) + 1, cursor.line + 1)
        try:
            text = self._text(cursor)
            bare = text.strip()
            if not bare:
                return Node(cursor, after)
            if bare.startswith("%"):
                run = None if cursor.source else lambda: self._percent_line(text)
                return Node(cursor, after, run=run)
            if self._computing is not None and not alone and bare[0] not in "oO/":
                return Node(cursor, after, reads=True)
            parsed = self._parse(text)
            if parsed.deletable and self.options.block_delete:
                return Node(cursor, after)
            if parsed.flow is not None:
                if parsed.flow.then is not None:
                    return Node(cursor, after, run=self._compiler.then(parsed.flow, cursor))
                lead = lead_of(self.flow, parsed.flow, cursor, after)
                return Node(cursor, after, lead=lead, settles=parsed.flow.asks_state)
            return Node(cursor, after, run=self._compiler.action(parsed, cursor))
        except BlockError as error:
            fault = error

            def fail() -> None:
                raise fault

            return Node(cursor, after, run=fail)

    def _end_node(self, cursor: Cursor) -> Node:
        """Return what the end of a text does: the main program ends, a subroutine is not finished."""

        def run() -> None:
            if self.flow.frames:
                name = self.sources[cursor.source].name
                raise Astray(
                    BlockError("sub-unfinished", f"{name} ends within a subroutine", hint="ENDSUB or M99?")
                )
            self.ip.state.ended = True

        return Node(cursor, cursor, run=run)

    def _execute(self, block: Block, plans: dict[int, Plan] | None = None) -> None:
        """Execute a block; `plans` are those of a line that runs again, by the modal motion."""
        ip = self.ip
        if ip.passing_over and not block.m:
            ip.passing_over = _G11 not in block.g
            return
        if ip.guard is not None:
            self._guarded(block)
        if block.comment is not None:
            comments.comment(ip, block, block.comment)
        if plans is None:
            if block.words or block.g or block.m:
                ip.execute(block)
        else:
            plan = plans.get(ip.state.motion)
            if plan is None:
                plan = plans[ip.state.motion] = ip.plan_of(block)
            ip.perform(plan, block)
        if ip.modal_macros:
            self._call_modal_macro(block)

    def _call_modal_macro(self, block: Block) -> None:
        """Ask for the macro of the last G66 after a motion; motions of that macro ask for the one before it."""
        ip = self.ip
        running = sum(frame.modal for frame in self.flow.frames)
        moves = not AXIS_INDEX.keys().isdisjoint(block.words)
        if moves and ip.jump is None and running < len(ip.modal_macros):
            number, times, ip.macro_values = ip.modal_macros[-1 - running]
            ip.jump = "modal", number, times

    # Faults.

    def _guarded(self, block: Block) -> None:
        """Let an open curve say that a block does not belong to it; the block runs all the same."""
        assert self.ip.guard is not None
        self.sink.block = block
        try:
            self.ip.guard(self.ip, block)
        except BlockError as error:
            self._fault(Cursor(block.source, block.offset, block.line), error)

    def _fail(self, here: Cursor, error: BlockError) -> None:
        """Say that a line failed, once for each kind of fault; the line is left there.

        Raises:
            Astray: Lines failed so often that a loop, whose condition their effects would have ended, counts as endless.
        """
        self._settle()
        if (here, error.code) not in self._failed:
            self._failed.add((here, error.code))
            self._fault(here, error)
            return
        self._failures += 1
        if self._failures % _MAX_FAILURES == 0:
            raise Astray

    def _fault(self, here: Cursor, error: BlockError) -> None:
        self.reporter.report(self.sources[here.source], here.line, here.offset, error)

    def remark(self, error: BlockError, severity: Severity) -> None:
        """Add a warning or note about the block that is executed."""
        block = self.sink.block
        self._settle()
        self.reporter.report(self.sources[block.source], max(block.line, 1), block.offset, error, severity)


def _last_line(source: Source) -> int:
    """Return the offset of the last line that holds anything."""
    end = len(source)
    while end and source.data[end - 1 : end] in b"\r\n":
        end -= 1
    return source.data.rfind(b"\n", 0, end) + 1

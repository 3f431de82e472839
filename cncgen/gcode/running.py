"""Running a program: blocks from the lanes, in the order of execution, into the interpreter; faults into diagnostics."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cncgen.diagnostics import Diagnostics, Severity
from cncgen.gcode import comments, grammar
from cncgen.gcode.arcs import CENTRE_FACTOR, CENTRE_RELATIVE, CENTRE_TOLERANCE, RADIUS_TOLERANCE
from cncgen.gcode.block import Block, Parsed, gather
from cncgen.gcode.errors import BlockError, Reporter, Stop
from cncgen.gcode.expressions import evaluate
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.lanes import BLOCKS, PlainBlocks, comment_of
from cncgen.gcode.sink import MotionBatch, Sink
from cncgen.gcode.source import MAX_LINE, Source
from cncgen.kernels import gcode_motion, gcode_scan
from cncgen.toolpath.reading import ReadOptions

#: Motions that the batch kernel takes, in tenths, and what it calls them.
_BATCHED = {0: 0, 10: 1, 20: 2, 30: 3}
#: Blocks through the slow lane between two chances to hand rows on.
_PAUSE = 1024


class _Batches:
    """Work arrays of `gcode_motion.advance`."""

    def __init__(self) -> None:
        self.position = np.zeros(9)
        self.modes = np.zeros(gcode_motion.MODES, np.int64)
        self.levels = np.zeros(gcode_motion.LEVELS)
        self.block = np.zeros(BLOCKS, np.int64)
        self.motion = np.zeros(BLOCKS, np.int8)
        self.end = np.zeros((BLOCKS, 9))
        self.feed = np.zeros(BLOCKS)
        self.feed_set = np.zeros(BLOCKS, np.uint8)
        self.centre = np.zeros((BLOCKS, 2))
        self.turns = np.zeros(BLOCKS, np.int64)


class Runner:
    """One run of a program on a sink."""

    def __init__(
        self,
        source: Source,
        options: ReadOptions,
        sink: Sink,
        diagnostics: Diagnostics,
        *,
        batches: bool = True,
    ) -> None:
        self.sources = [source]
        self.options = options
        self.sink = sink
        self.reporter = Reporter(diagnostics)
        self.ip = Interpreter(sink, options, self.remark)
        self.steps = 0
        self._plain = PlainBlocks()
        self._batches = _Batches() if batches else None
        self._percent = False
        self._seen = False
        self._parsed: dict[str, Parsed] = {}

    # The loop.

    def run(self) -> Iterator[None]:
        """Run to the end; yields now and then, so that rows can be taken away."""
        source = self.sources[0]
        if source.is_binary():
            self._fault(
                source, 1, 0, BlockError("binary-file", f"{source.name} is no text: it holds NUL bytes")
            )
            return
        try:
            yield from self._stream(source)
            self._finish(source)
        except Stop as stop:
            block = self.sink.block
            self._fault(self.sources[block.source], block.line, block.offset, stop.error)

    def _stream(self, source: Source) -> Iterator[None]:
        offset, line = 0, 1
        slow = 0
        plain = self._plain
        while not self.ip.state.ended:
            offset, line, why = plain.scan(source, offset, line)
            self._run_plain(source)
            if self.ip.state.ended or why == gcode_scan.END:
                break
            if why == gcode_scan.OTHER:
                self._run_line(source, offset, line)
                offset, line = source.line_end(offset) + 1, line + 1
                slow += 1
                if slow % _PAUSE:
                    continue
            yield
        self._line = line

    _line = 1

    def _finish(self, source: Source) -> None:
        """Say what is missing at the end of the text."""
        if self.ip.guard is not None:
            self._guarded(Block({}, m=(20,), line=max(self._line - 1, 1), offset=_last_line(source)))
        if not self._seen:
            self._fault(source, 1, 0, BlockError("empty-program", f"{source.name} has no block"))
        elif not self.ip.state.ended:
            end = Block({}, line=max(self._line - 1, 1), offset=_last_line(source))
            self.sink.block = end
            self.remark(
                BlockError("no-program-end", "the program ends without M2, M30 or a closing %"),
                Severity.WARNING,
            )

    # Plain blocks.

    def _run_plain(self, source: Source) -> None:
        """Run the blocks that were scanned: in arrays where they are plain motions, else one by one."""
        count = self._plain.count
        index = 0
        if count:
            self._seen = True
        while index < count and not self.ip.state.ended:
            done = self._run_batch(index, count)
            if done == count:
                self._count(count - index)
                break
            self._run_one(source, done)
            self._count(done - index + 1)
            index = done + 1

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

    def _run_batch(self, index: int, count: int) -> int:
        """Run plain motions in arrays from a block on; return the first block not taken."""
        work, ip, plain = self._batches, self.ip, self._plain
        if work is None or not ip.batchable():
            return index
        state = ip.state
        work.position[:] = state.position
        work.modes[:] = (
            _BATCHED.get(state.motion, -1),
            state.absolute,
            state.arc_absolute,
            state.plane,
            state.feed_mode == 93,
            self.options.block_delete,
            not self.sink.wants_comments,
        )
        inches = state.inches
        work.levels[:] = (
            state.feed,
            RADIUS_TOLERANCE[inches],
            CENTRE_TOLERANCE[inches],
            CENTRE_RELATIVE,
            CENTRE_FACTOR * CENTRE_TOLERANCE[inches],
        )
        done, rows = gcode_motion.advance(
            index,
            count,
            plain.flags,
            plain.word_end,
            plain.letters,
            plain.values,
            work.position,
            work.modes,
            work.levels,
            work.block,
            work.motion,
            work.end,
            work.feed,
            work.feed_set,
            work.centre,
            work.turns,
        )
        if rows:
            block = work.block[:rows]
            self.sink.motions(
                MotionBatch(
                    work.motion[:rows],
                    work.end[:rows],
                    work.feed[:rows],
                    work.feed_set[:rows],
                    work.centre[:rows],
                    work.turns[:rows],
                    plain.line[block],
                    plain.offset[block],
                    0,
                )
            )
            state.position = work.position.tolist()
            state.motion = 10 * int(work.modes[gcode_motion.MOTION])
            state.feed = float(work.levels[gcode_motion.FEED])
            state.moved = True
        return done

    def _run_one(self, source: Source, index: int) -> None:
        """Run one plain block by itself."""
        plain = self._plain
        flags = int(plain.flags[index])
        if flags & gcode_scan.SLASH and self.options.block_delete:
            return
        line, offset = int(plain.line[index]), int(plain.offset[index])
        try:
            comment = None
            if flags & gcode_scan.ACTIVE or (flags & gcode_scan.COMMENT and self.sink.wants_comments):
                comment = comment_of(source.text_at(offset))
            block = plain.block(index, 0)
            block.comment = comment
            self._execute(block)
        except BlockError as error:
            self._fault(source, line, offset, error)

    # Any other line.

    def _run_line(self, source: Source, offset: int, line: int) -> None:
        """Run a line that the scanner did not take."""
        end = source.line_end(offset)
        try:
            if end - offset > MAX_LINE:
                raise BlockError(
                    "line-too-long", f"a line of {end - offset} bytes; the longest is {MAX_LINE}", column=1
                )
            text = source.text_at(offset)
            if text.lstrip().startswith("%"):
                self._percent_line(text, line, offset)
                return
            self._seen = True
            self._count(1)
            self._run_parsed(self._parse(text), line, offset)
        except BlockError as error:
            self._fault(source, line, offset, error)

    def _percent_line(self, text: str, line: int, offset: int) -> None:
        """Begin or end the program."""
        if not self._seen and not self._percent:
            self._percent = True
        elif self._percent:
            self.ip.state.ended = True
            self.sink.block = Block({}, line=line, offset=offset)
            self.sink.call("FINISH()")
        else:
            raise BlockError(
                "stray-percent", "a % that ends a program that no % began", column=text.index("%") + 1
            )

    def _parse(self, text: str) -> Parsed:
        """Return the block of a text; the latest ones are remembered."""
        parsed = self._parsed.get(text)
        if parsed is None:
            parsed = grammar.parse(text)
            if len(self._parsed) >= _PAUSE:
                self._parsed.clear()
            self._parsed[text] = parsed
        return parsed

    def _run_parsed(self, parsed: Parsed, line: int, offset: int) -> None:
        """Compute the values of a block, then execute it; parameters are set when all of it is read."""
        if parsed.deletable and self.options.block_delete:
            return
        if parsed.flow is not None:
            raise BlockError("unsupported-flow", f"{parsed.flow.keyword} is not supported")
        parameters = self.ip.parameters
        pairs = [(letter, evaluate(value, parameters)) for letter, value in parsed.words]
        settings: list[tuple[float | str, float]] = [
            (target if isinstance(target, str) else evaluate(target, parameters), evaluate(value, parameters))
            for target, value in parsed.settings
        ]
        block = gather(pairs)
        block.source, block.line, block.offset = 0, line, offset
        block.comment = parsed.comments[-1] if parsed.comments else None
        for target, number in settings:
            if isinstance(target, str):
                parameters.set_name(target, number)
            else:
                parameters.set_number(target, number)
        self._execute(block)

    def _execute(self, block: Block) -> None:
        if self.ip.guard is not None:
            self._guarded(block)
        if block.comment is not None:
            comments.comment(self.ip, block, block.comment)
        if block.words or block.g or block.m:
            self.ip.execute(block)

    # Faults.

    def _guarded(self, block: Block) -> None:
        """Let an open curve say that a block does not belong to it; the block runs all the same."""
        assert self.ip.guard is not None
        self.sink.block = block
        try:
            self.ip.guard(self.ip, block)
        except BlockError as error:
            self._fault(self.sources[block.source], block.line, block.offset, error)

    def _fault(self, source: Source, line: int, offset: int, error: BlockError) -> None:
        self.reporter.report(source, line, offset, error)

    def remark(self, error: BlockError, severity: Severity) -> None:
        """Add a warning or note about the block that is executed."""
        block = self.sink.block
        self.reporter.report(self.sources[block.source], max(block.line, 1), block.offset, error, severity)


def _last_line(source: Source) -> int:
    """Return the offset of the last line that holds anything."""
    end = len(source)
    while end and source.data[end - 1 : end] in b"\r\n":
        end -= 1
    return source.data.rfind(b"\n", 0, end) + 1

"""Runs of SINUMERIK and of Heidenhain's plain language: line after line of a program, wherever jumps, loops, repeats and calls lead.

A language says what its lines mean; all that leads from line to line is here.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from itertools import chain
from types import FunctionType
from typing import Any, Generic, TypeVar

from cncgen.diagnostics import Severity
from cncgen.gcode.block import Block
from cncgen.gcode.budget import LINE, PAUSE
from cncgen.gcode.codes.turning_profiles import MAX_MOVES, Recorder, recording
from cncgen.gcode.doubts import tell
from cncgen.gcode.errors import Astray, BlockError, Reporter, Stop
from cncgen.gcode.flow.faults import Faults
from cncgen.gcode.flow.plain_lines import NO_CYCLES, PlainLane
from cncgen.gcode.flow.recurrence import Recurrence
from cncgen.gcode.flow.run import Run
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Sink
from cncgen.gcode.source import Source
from cncgen.gcode.text.dialects import Choice
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import empty_block
from cncgen.gcode.text.line_runs import ProgramLines
from cncgen.gcode.text.search import opened, places, search_path

_YIELD = 512
#: Blocks that move, and what calls or jumps lead to, behind the end of a program, of which so many bytes are looked at.
_MOVES = rb"(?m)^[^;(\n]*(?<![A-Z_$])[XYZ][ =+\-.]*\d"
_LED_TO = rb"(?m)LBL|PROC|^%|^[^;(\n]*[A-Z_]\w*[ \t]*:"
_REST = 65_536
#: How often in a row lines are run together from one on that are too few for it, and how many are enough.
_TRIES, _ENOUGH = 3, 6


@dataclass(slots=True)
class Line:
    """A line of a program: its place."""

    here: Cursor

    def says(self) -> bool:
        """Tell whether it says anything."""
        raise NotImplementedError


L = TypeVar("L", bound=Line)


@dataclass(slots=True)
class Program(Generic[L]):
    """The lines of a program."""

    lines: ProgramLines[L]
    #: The first line that was never run; lines that are run by themselves, whatever leads to them; how often in a row few lines were run
    #: together from a line on; whether each line stands for itself.
    reached: int = field(default=0, kw_only=True)
    apart: set[int] = field(default_factory=set, kw_only=True)
    short: dict[int, int] = field(default_factory=dict, kw_only=True)
    alone: bool = field(default=True, kw_only=True)

    def labelled(self, name: str) -> list[int]:
        """Return the lines of a label, in the order of the text."""
        raise NotImplementedError


P = TypeVar("P", bound=Program)
#: Types of attributes of a run that are not its state, or whose state is compared otherwise.
_FIXED = (Run, Interpreter, Faults, Reporter, Recurrence, PlainLane, Source, Choice, Program, FunctionType)


@dataclass(slots=True)
class Frame(Generic[P]):
    """A program in progress, or a part of one that was called.

    Attributes:
        program: Its lines.
        at: The line that comes next.
        end: The line at which it ends.
        ran: The line that was run last.
        reached: The first line that was never run in it.
        rounds: Rounds of the call that follow this one.
        part: Whether it is a part of the program below it.
        loops: Of loops that count, by their lines: the end, or the rounds left.
        repeats: Parts that are repeated: first and last line, rounds left, and the line behind them.
        back: Gives the caller back what is its own.
    """

    program: P
    at: int = 0
    end: int = -1
    ran: int = -1
    reached: int = 0
    rounds: int = 0
    part: bool = False
    loops: dict[int, float] = field(default_factory=dict)
    repeats: list[tuple[int, int, int, int]] = field(default_factory=list)
    back: Callable[[], None] | None = None

    def __post_init__(self) -> None:
        if self.end < 0:
            self.end = len(self.program.lines)

    def restart(self, at: int) -> None:
        """Go on at a line, outside of all loops."""
        self.at, self.ran = at, -1
        self.loops.clear()
        self.repeats.clear()

    def repeat(self) -> None:
        """Where the end of a part that is repeated was reached, begin it again, or go on behind its REPEAT."""
        first, last, left, behind = self.repeats[-1]
        if self.at == last + 1 and first <= self.ran <= last:
            self.repeats.pop()
            if left > 0:
                self.repeats.append((first, last, left - 1, behind))
            self.at, self.ran = first if left > 0 else behind, -1


class LanguageRun(Run, Generic[P]):
    """A run of a language whose programs are lists of lines.

    Attributes:
        frames: The programs in progress, the innermost last.
    """

    #: The dialect of the interpreter, how a program ends, and the suffixes of files with subprograms, the best first.
    dialect, ends_with = "", ""
    suffixes: tuple[str, ...] = ()
    #: The grammar of lines that are plain in every state, none where lines hang on what stands before them; and whether they are
    #: interpreted in arrays, which gives the same sooner.
    plain, batches = "", True
    #: Whether the end of a motion may hang on the line behind it.
    hangs = False

    def _assemble(self, sink: Sink) -> None:
        self.ip = Interpreter(sink, self._options, self._faults.remark, self.dialect)
        self.frames: list[Frame[P]] = []
        self._folders = search_path(self._path, self._options.include)
        self._files: dict[str, P] = {}
        self._recurrence = Recurrence(self.ip, self._faults, lambda: vars(self), _FIXED)
        #: The first line of the main program that was not run; blocks that were counted when it was reached, and at the last look.
        self._reached = self._begun = self._looked = 0
        #: Lines of the main program that jumps led past when they were reached.
        self._passed: list[range] = []
        self._prepare()
        self._lane: PlainLane | None = None
        if self.plain and self.batches:
            kept = self._made, self._parameter_values(), self._scopes()
            self._lane = PlainLane(self.ip, self.sources, self.plain, *kept, hangs=self.hangs)

    # The parts of a language.

    def _prepare(self) -> None:
        """Make what the language needs."""

    def _load(self, index: int, name: str) -> P:
        raise NotImplementedError

    def _begin(self, main: P) -> None:
        """Put what the language begins with in force."""

    def _line(self, frame: Frame[P], at: int) -> None:
        raise NotImplementedError

    def _handler(self, kind: str) -> Callable[..., None] | None:
        """Return what runs a statement, the method `do_` with its kind; it takes the program in progress, the line, and what that says."""
        return getattr(self, f"do_{kind.replace('-', '_')}", None)

    def _run_plain(self, lane: PlainLane, frame: Frame[P], most: int) -> int:
        """Run so many lines of a run in arrays at most; return the first that was not run."""
        raise NotImplementedError

    def _parameter_values(self) -> array[float]:
        return self.ip.parameters.numbers

    def _scopes(self) -> list[dict[str, Any]]:
        """Return the variables of the programs in progress."""
        return []

    def _led_to(self, program: P, at: int) -> int | None:
        """Return the line to which a line leads, None where that is not certain."""
        raise NotImplementedError

    def _enters(self, frame: Frame[P], at: int) -> None:
        """Begin with a line that was jumped to."""

    def _fault_of(self, program: P, at: int) -> BlockError | None:
        """Return why a line cannot be read, None where it can."""
        raise NotImplementedError

    def _is_plain(self) -> bool:
        """Tell whether lines mean in arrays what they mean in the language."""
        raise NotImplementedError

    def _in_modes(self, run: Callable[[], int]) -> int:
        """Run blocks in arrays, in modes that mean for the interpreter what they mean in the language; return what `run` returns."""
        return run()

    def _run_words(self, at: int, here: Cursor, words: list[tuple[str, float]]) -> None:
        """Run a block of a line whose words are known."""
        raise NotImplementedError

    def _made(self, begin: list[float], motion: memoryview, end: memoryview, centre: memoryview) -> None:
        """Take what the language keeps of motions that were made in arrays."""

    def _take_up(self, frame: Frame[P], at: int) -> None:
        """Go on behind a line that failed."""

    def _settle(self) -> None:
        """End what the lines so far have left open: a curve of several blocks."""
        if self.ip.guard is not None:
            self.ip.guard(self.ip, Block({}, m=(20,)))

    def _counters(self) -> object:
        """Return what in nearly every loop tells one round from the next."""
        return [(frame.loops, frame.repeats) for frame in self.frames]

    # From line to line.

    def run(self) -> Iterator[None]:
        """Run to the end; yields now and then, so that rows can be taken away."""
        source = self.sources[0]
        if self._faults.refuses(source):
            return
        tell(self.reporter, source, self._choice, self._options)
        self.ip.begin()
        try:
            main = self._load(0, "")
            self._begin(main)
            self.frames.append(Frame(main))
            yield from self._run()
            self._finish(main)
        except Stop as stop:
            self._faults.here(stop.error)

    def _run(self) -> Iterator[None]:
        frames, ip = self.frames, self.ip
        main, budget = frames[0], ip.budget
        while frames and not ip.state.ended:
            frame = frames[-1]
            first = frame.at
            try:
                many = False
                try:
                    many = self._step(frame)
                except BlockError as error:
                    self._fail(frame, error)
                if frame is main and frame.reached > self._reached:
                    if first > self._reached:
                        self._passed.append(range(self._reached, first))
                    self._reached = budget.forward = frame.reached
                    self._begun = self._looked = budget.steps
                elif (
                    budget.steps - self._looked >= PAUSE
                    and frame.at <= frame.ran
                    and (self._lane is None or self._lane.waiting < 0)
                ):
                    self._look(frame)
            except Astray as astray:
                self._go_on(astray)
            if many or budget.steps % _YIELD == 0:
                yield

    def _step(self, frame: Frame[P]) -> bool:
        """Run the next line of the innermost program, or leave it at its end; tell whether it was a run of them."""
        lane = self._lane
        if lane is not None and lane.waiting >= 0:
            self._run_waiting(frame, lane)
            return True
        if frame.repeats:
            frame.repeat()
        at = frame.at
        if at >= frame.end:
            self.leave()
            return False
        ip = self.ip
        program = frame.program
        if lane is not None:
            if at < program.reached and self._follow(frame, lane):
                return True
            if program.lines.run_at(at) is not None:
                end = frame.repeats[-1][1] + 1 if frame.repeats and at <= frame.repeats[-1][1] else frame.end
                frame.at = self._run_plain(lane, frame, min(end - at, ip.budget.left()))
                if frame.at > at:
                    frame.ran = frame.at - 1
                    self._reach(frame, frame.at)
                    return True
        frame.at, frame.ran = at + 1, at
        self._reach(frame, frame.at)
        ip.budget.count(1, LINE)
        ip.base.block = empty_block(frame.program.lines[at].here)
        before = [*ip.state.position]
        self._line(frame, at)
        ip.budget.moves += ip.state.position != before
        return False

    def _follow(self, frame: Frame[P], lane: PlainLane) -> bool:
        """Run lines that were run before, wherever they lead; tell whether some were run."""
        program, at = frame.program, frame.at
        tries = program.short.get(at, 0)
        if (
            tries == _TRIES
            or not program.alone
            or at in program.apart
            or frame.repeats
            or frame.end < len(program.lines)
        ):
            return False
        if not self._is_plain() or not self.ip.batchable(NO_CYCLES):
            return False
        steps = self.ip.budget.steps

        def run() -> int:
            return lane.follow(
                program.lines,
                at,
                program.apart,
                partial(self._led_to, program),
                partial(self._enters, frame),
                frame.loops,
                (self._begin_part, self._end_part),
                frame.reached,
                steps - self._looked,
            )

        at_last = self._in_modes(run)
        # A part that was called may be in progress now.
        inner = self.frames[-1]
        inner.at = at_last
        count = self.ip.budget.steps - steps
        program.short[at] = tries + 1 if count < _ENOUGH else 0
        if count:
            inner.ran = lane.ran
            self._reach(frame, lane.reached)
        return count > 0

    def _begin_part(self, at: int, target: int) -> dict[int, float] | None:
        """Begin a call from a line of lines of the same program; return the loops in it, None where calls would nest too deep."""
        caller = self.frames[-1]
        if len(self.frames) > self._options.max_call_depth:
            return None
        caller.at, caller.ran = at + 1, at
        self.frames.append(Frame(caller.program, at=target, part=True))
        return self.frames[-1].loops

    def _end_part(self) -> tuple[tuple[int, int, int, int], dict[int, float]] | None:
        """End it; return the line behind the call, and the loops there, None where that is not one of lines that are run together."""
        caller = self.frames[-2]
        if caller.at >= caller.end or caller.at in caller.program.apart:
            return None
        self._pop()
        place = caller.program.lines.place(caller.at)
        return (caller.at, caller.at, place.offset, place.line), caller.loops

    def _reach(self, frame: Frame[P], at: int) -> None:
        """Say that lines were run up to one."""
        frame.reached = max(frame.reached, at)
        frame.program.reached = max(frame.program.reached, at)

    def _run_waiting(self, frame: Frame[P], lane: PlainLane) -> None:
        """Run the blocks that wait; a fault leaves those behind its block for the next step."""
        while lane.waiting >= 0:
            index = self._in_modes(lane.go_on)
            if index >= 0:
                frame.ran, here = lane.line_of(index), lane.blocks.cursor(index)
                self.ip.base.block = empty_block(here)
                self._run_words(frame.ran, here, lane.blocks.pairs(index))
        frame.ran = lane.ran
        self.ip.base.block = empty_block(lane.last)

    def _enter(self, line: Line) -> None:
        """Begin with a line: remarks and motions are of it."""
        self.ip.base.block = empty_block(line.here)

    def _fail(self, frame: Frame[P], error: BlockError) -> None:
        """Report that the line failed which was run last."""
        lines = frame.program.lines
        at = frame.ran if error.at is None else error.at
        self._faults.fail(lines[min(max(at, 0), len(lines) - 1)].here, error)
        self._take_up(frame, frame.ran)

    def _look(self, frame: Frame[P]) -> None:
        """Raise where a jump back finds everything as it was at an earlier one; a call or an end is none."""
        if not self.frames or self.frames[-1] is not frame:
            return
        # When it was is no part of the state.
        self._looked = 0
        lines = frame.program.lines
        self._recurrence.look(lines[frame.ran].here, lines[frame.at].here, self._begun, self._counters())
        self._looked = self.ip.budget.steps

    def _go_on(self, astray: Astray) -> None:
        """Give up all calls and loops, and go on at the first line that was not run."""
        if astray.error is not None:
            self._faults.here(astray.error)
        if self._lane is not None:
            self._lane.waiting = -1
        while len(self.frames) > 1:
            with suppress(BlockError):
                self._pop()
        for main in self.frames:
            main.restart(self._reached)

    def _finish(self, main: P) -> None:
        last = next((line.here for line in reversed(main.lines) if line.says()), None)
        here = last or Cursor(0, 0, 1)
        try:
            self._settle()
            self.ip.end_compensation()
        except BlockError as error:
            self._faults.at(here, error)
        if last is None:
            self._faults.at(here, BlockError("empty-program", "the program has no block"))
        elif not self.ip.state.ended and not self._faults.found:
            self.ip.base.block = empty_block(here)
            names = self.ends_with
            message = f"the program ends without {names}"
            fault = BlockError("no-program-end", message, hint=f"{names.split()[0]} ends it")
            self._faults.remark(fault, Severity.WARNING)
        elif self._reached < len(main.lines):
            self._tell_of_rest(main)
        passed = chain.from_iterable(self._passed)
        self._faults.passed((main.lines[at].here, self._fault_of(main, at)) for at in passed)

    def _tell_of_rest(self, main: P) -> None:
        """Warn of blocks with motions behind the one that ended the program, where nothing leads to lines behind it."""
        import re

        source, (before, first, last) = (
            self.sources[0],
            (main.lines[at].here.offset for at in (self._reached - 1, self._reached, len(main.lines) - 1)),
        )
        rest = source.data[first : min(source.line_end(last), first + _REST)].upper()
        count = len(re.findall(_MOVES, rest))
        leads = re.search(_LED_TO, rest) or re.search(rb"GOTO|REPEAT", source.data[:first].upper())
        if not count or leads or not self.ip.state.ended or self._faults.found:
            return
        self.ip.base.block = empty_block(main.lines[self._reached - 1].here)
        name = source.text_at(before).strip()
        least = "at least " if source.line_end(last) > first + _REST else ""
        message = f"{least}{count} blocks with motions stand behind {name}, which ends the program: they are not run"
        hint = (
            "remove it where they belong to the program; programs of their own belong into files of their own"
        )
        self._faults.remark(BlockError("text-behind-end", message, hint=hint), Severity.WARNING)

    # Calls.

    def enter(self, frame: Frame[P], word: str) -> None:
        """Begin a call; raise Astray where calls would nest deeper than the options allow."""
        most = self._options.max_call_depth
        if len(self.frames) > most:
            message = f"calls are nested more than {most} deep"
            raise Astray(BlockError("call-depth", message, word, hint="is the recursion without end?"))
        self.frames.append(frame)

    def leave(self) -> None:
        """End the innermost call, or its present round; parts of the program that end with it are left too."""
        while len(self.frames) > 1 and self.frames[-1].part:
            self._pop()
        frame = self.frames[-1]
        if frame.rounds > 0:
            frame.rounds -= 1
            frame.restart(0)
        else:
            self._pop()

    def _pop(self) -> None:
        """End the innermost call, and give its caller back what is its own."""
        frame = self.frames.pop()
        if frame.back is not None:
            frame.back()

    def label(self, program: P, name: str, message: str, word: str, hint: str) -> int:
        """Return the first line of a label; raise where it stands nowhere."""
        found = program.labelled(name)
        if not found:
            raise BlockError("label-missing", message, word, hint=hint)
        return found[0]

    def file(self, name: str, missing: str, word: str, hint: str) -> Source:
        """Return the file of a name beside the program or in a folder of --include; raise where there is none; `missing` says what is looked for."""
        source = opened(self._folders, name, self.suffixes)
        if source is None:
            raise BlockError("sub-missing", f"{missing} in {places(self._folders)}", word, hint=hint)
        return source

    def program_of(self, name: str, missing: str, word: str, hint: str) -> P:
        """Return a program of a file, which is read once."""
        found = self._files.get(name)
        if found is None:
            self.sources.append(self.file(name, missing, word, hint))
            found = self._files[name] = self._load(len(self.sources) - 1, name)
        return found

    # Contours.

    def record(self, frame: Frame[P], name: str, plane: int) -> Recorder:
        """Run lines as a contour, whose motions are taken; the machine is afterwards as it was.

        Raises:
            BlockError: A line is wrong, or reads a contour itself.
        """
        ip, frames, block = self.ip, self.frames, self.ip.base.block
        if isinstance(ip.sink, Recorder):
            raise BlockError("not-read", f"the contour {name} is called within a contour")
        # The frame below is none that can be left.
        self.frames = [Frame(frame.program, end=0), frame]
        try:
            with recording(ip, plane) as recorder:
                while len(self.frames) > 1 and not ip.state.ended:
                    inner = self.frames[-1]
                    try:
                        self._step(inner)
                    except BlockError as error:
                        line = inner.program.lines[max(inner.ran, 0)].here.line
                        raise error.within(f"line {line} of the contour {name}") from None
                    if len(recorder.segments) > MAX_MOVES:
                        message = f"the contour {name} has more than {MAX_MOVES} moves"
                        raise BlockError("profile-length", message)
                self._settle()
        finally:
            self.frames, ip.base.block = frames, block
            if self._lane is not None:
                self._lane.waiting = -1
        return recorder

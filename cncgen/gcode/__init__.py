"""G-code: text to canonical motions.

`read` gives the toolpath of a program, `canon` the text of its canonical calls, `check` its faults. All run the same interpreter, on a
sink that builds columns, prints or only counts.

The rooms; each knows only the rooms before it:

- `state`: the state in force from block to block: modes, parameters, coordinate systems, tools;
- `text`: from text to blocks, by the tables of the grammars. `lanes` turns runs of plain blocks into columns, `grammar` any
  other line into a block; `marked_lines` has the targets of jumps;
- `sinks`: where canonical calls go;
- `codes`: a module a concern, with the handlers of its codes and its rows of the `table`;
- `flow`: the order in which lines are executed, with loops, branches, subroutines and macros: `running` opens and closes a
  run, `course` leads from line to line, `executing` has blocks executed.

Between codes and flow stands the `interpreter`: it looks up what a block does (`block_plans`: which codes, whether they go
together, in which order), and calls their handlers, which change `modal.State` and call the `sink`.

`canon` runs on the machine that LinuxCNC's stand-alone `rs274` pretends to have (`sinks.standalone`), so that its calls agree
with that program's. `compensated_sink`, `frames` and `tool_point` put a sink of their own between the interpreter and its
sink while they are in force; it changes calls and passes them on.

To add a code: write a handler ``(Interpreter, Block) -> None`` in the module of its concern in `codes`, which raises
`errors.BlockError` where the block is wrong; add a `table.Code` with its modal group, stage, words and one line of help
to that module's `CODES`; name a new module in `table._MODULES`; give it a test in ``tests/gcode``.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence

from cncgen.diagnostics import Diagnostics, ProgramError, RunDiagnostics
from cncgen.gcode.codes.table import LATHES, language_of
from cncgen.gcode.errors import BlockError, Reporter
from cncgen.gcode.flow.running import Runner
from cncgen.gcode.sinks.counting import HALF_TURN, LONG_S, CountingSink
from cncgen.gcode.source import Source, open_source
from cncgen.gcode.text.dialects import Choice, chosen
from cncgen.records import replace
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import Program, Toolpath
from cncgen.units import AXIS_LETTERS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from pathlib import Path
    from typing import BinaryIO

    from cncgen.gcode.klartext.running import HeidenhainRunner
    from cncgen.gcode.sinks.sink import Sink
    from cncgen.gcode.sinumerik.running import SinumerikRunner

_DEFAULT = ReadOptions()
FANUC = "fanuc"
SINUMERIK = "sinumerik"
HEIDENHAIN = "heidenhain"


def read(
    source: str | os.PathLike[str] | BinaryIO | Source, name: str, options: ReadOptions = _DEFAULT
) -> Program:
    """Read a program as its toolpath, in machine coordinates, mm and rad.

    The text is mapped or spooled at once; blocks are interpreted as the chunks are drawn.

    Raises:
        UsageError: Where the file cannot be read.
    """
    text = source if isinstance(source, Source) else open_source(source, name)
    path = source if isinstance(source, str | os.PathLike) else None
    return _program(text, path, options, Diagnostics())


def _program(
    text: Source, path: str | os.PathLike[str] | None, options: ReadOptions, diagnostics: Diagnostics
) -> Program:
    """Return a text as a program that is read with these options.

    Raises:
        UsageError: Where the file cannot be read.
    """
    import numpy as np

    from cncgen.gcode.feed_doubts import Clock
    from cncgen.gcode.rotary_doubts import SharedFeeds, Turns
    from cncgen.gcode.sinks.columns import ColumnsSink
    from cncgen.toolpath.building import ToolpathBuilder

    name = text.name
    choice = chosen(text, options.dialect)
    moving = _moving_axes(text, choice, path, options)
    axes = "".join(letter for letter in AXIS_LETTERS if letter in "XYZ" or letter in moving)

    def chunks(spindle: float = 1.0) -> Iterator[Toolpath]:
        how = options
        if spindle != 1.0 and options.fastest_spindle is not None:
            how = replace(options, fastest_spindle=spindle * options.fastest_spindle)
        builder = ToolpathBuilder(axes, np.zeros(len(axes)), [name])
        sink = ColumnsSink(
            builder,
            options.tolerance_mm,
            degrees_count=language_of(choice.dialect) == "fanuc",
            tips=options.tool_tips,
            tells_lengths=options.tool_tips or options.kinematics is not None,
            shown=moving,
        )
        handed = False
        clock, found = Clock(name), RunDiagnostics(diagnostics)
        turns = Turns() if choice.dialect == FANUC else None
        feeds = SharedFeeds() if _unsigned(choice, options) else None

        def timed(chunk: Toolpath) -> Toolpath:
            remark = clock.add(chunk)
            if remark is not None:
                found.add(remark)
            if turns is not None:
                turns.add(chunk, runner.sources, runner.reporter)
            if feeds is not None:
                unit = runner.ip.state.unit_mm
                feeds.add(chunk, runner.sources, runner.reporter, unit)
            if sink.unforeseen is not None and not said and not diagnostics.has_errors:
                said.append(sink.unforeseen)
                _report_unforeseen(runner.reporter, runner.sources, *sink.unforeseen)
            return chunk

        said: list[tuple[str, int, int]] = []
        runner = _runner(text, how, sink, found, path=path, choice=choice)
        for _ in runner.run():
            builder.sources = [source.name for source in runner.sources]
            if builder.count >= options.chunk_rows:
                handed = True
                yield timed(builder.take())
        sink.flush()
        builder.sources = [source.name for source in runner.sources]
        if builder.count or not handed:
            yield timed(builder.take())

    def reread(how: ReadOptions) -> Program:
        return _program(text, path, how, RunDiagnostics(diagnostics))

    lathe = choice.dialect in LATHES
    return Program(name, "gcode", axes, moving, chunks, diagnostics, options, reread, text.count_lines, lathe)


def _unsigned(choice: Choice, options: ReadOptions) -> bool:
    """Tell whether no sign shows the control of a program, which is read as LinuxCNC's then."""
    return choice.dialect == "linuxcnc" and not choice.reason and options.dialect == "auto"


def _report_unforeseen(
    reporter: Reporter, sources: Sequence[Source], axis: str, line: int, source: int
) -> None:
    """Report a motion of an axis for which the output has no column."""
    offset = 0
    for _ in range(line - 1):
        offset = sources[source].line_end(offset) + 1
    message = (
        f"{axis} moves, though no word or code of the program names it: the setpoints have no column of it"
    )
    hint = f"write a block that sends {axis} where it stands already"
    reporter.report(sources[source], line, offset, BlockError("late-axis", message, hint=hint))


def _folders(path: str | os.PathLike[str] | None, options: ReadOptions) -> list[Path]:
    """Return the folders in which subprograms are looked for."""
    from cncgen.gcode.text.search import search_path

    return search_path(path, options.include)


def _moving_axes(
    text: Source, choice: Choice, path: str | os.PathLike[str] | None, options: ReadOptions
) -> str:
    """Return the letters of the axes that a program names."""
    dialect, folders = choice.dialect, _folders(path, options)
    rotary = "".join(AXIS_LETTERS[k] for k in (options.kinematics.axes if options.kinematics else ()))
    if dialect == SINUMERIK:
        from cncgen.gcode.sinumerik import axes as sinumerik_axes

        return sinumerik_axes.moving_axes(text, folders, rotary)
    if dialect == HEIDENHAIN:
        from cncgen.gcode.klartext import axes as plain_axes
        from cncgen.gcode.sinks.counting import MovingSink

        def moved_in_run() -> set[str]:
            sink = MovingSink()
            for _ in _runner(text, options, sink, Diagnostics(), path=path, choice=choice).run():
                pass
            return {AXIS_LETTERS[k] for k in sink.moved}

        return plain_axes.moving_axes(text, folders, rotary, moved_in_run)
    from cncgen.gcode.moved_axes import moving_axes

    def named_in_run() -> set[str]:
        runner = _runner(text, options, CountingSink(), Diagnostics(), path=path, choice=choice)
        for _ in runner.run():
            pass
        return runner.ip.rotary

    return moving_axes(text, dialect, folders, named_in_run, rotary)


def _runner(
    source: Source,
    options: ReadOptions,
    sink: Sink,
    diagnostics: Diagnostics,
    *,
    path: str | os.PathLike[str] | None,
    choice: Choice | None = None,
) -> Runner | SinumerikRunner | HeidenhainRunner:
    """Return one run of a program on a sink, by its dialect."""
    choice = choice or chosen(source, options.dialect)
    if choice.dialect == SINUMERIK:
        from cncgen.gcode.sinumerik.running import SinumerikRunner

        return SinumerikRunner(source, options, sink, diagnostics, path=path, choice=choice)
    if choice.dialect == HEIDENHAIN:
        from cncgen.gcode.klartext.din_iso import IsoRunner, is_iso
        from cncgen.gcode.klartext.running import HeidenhainRunner

        runner = IsoRunner if is_iso(source) else HeidenhainRunner
        return runner(source, options, sink, diagnostics, path=path, choice=choice)
    return Runner(source, options, sink, diagnostics, path=path, choice=choice)


def check(
    source: str | os.PathLike[str] | BinaryIO,
    name: str,
    options: ReadOptions = _DEFAULT,
    diagnostics: Diagnostics | None = None,
) -> int:
    """Interpret a program without keeping it; return the number of motions and events.

    The diagnostics are those of `read`, sooner, because no toolpath is built.

    Args:
        source: The program's file or stream.
        name: Its name in diagnostics.
        options: How it is read.
        diagnostics: Receives its faults; without it, errors are raised after the whole text was read.

    Raises:
        UsageError: Where the file cannot be read.
        ProgramError: Where the program has errors and `diagnostics` is not given.
    """
    found = Diagnostics() if diagnostics is None else diagnostics
    text, path = open_source(source, name), source if isinstance(source, str | os.PathLike) else None
    choice = chosen(text, options.dialect)
    sink = CountingSink()
    if choice.dialect == FANUC:
        sink.longest_turn = HALF_TURN
    elif _unsigned(choice, options):
        # Any turn beside X Y Z may take another time on another control.
        sink.longest_turn = 0.0
    for _ in _runner(text, options, sink, found, path=path, choice=choice).run():
        pass
    known = _moving_axes(text, choice, path, options) if sink.unnamed else ""
    late = any(AXIS_LETTERS[k] not in known for k in sink.unnamed)
    if (late or sink.slow or sink.far or sink.turned or sink.waited > LONG_S) and not found.has_errors:
        from cncgen.toolpath.gate import beyond_numbers

        # Whether the machine's axes moved, and where to, which offsets and rotations decide, and for how long, the columns tell.
        program = read(text, name, replace(options, include=tuple(_folders(path, options))))
        for chunk in program.chunks():
            if not found.has_errors:
                found.extend(beyond_numbers(chunk))
        found.extend(
            [
                one
                for one in program.diagnostics
                if one.code in ("late-axis", "time-doubtful", "roll-over", "feed-rotary")
            ]
        )
    if diagnostics is None and found.has_errors:
        raise ProgramError(list(found))
    return sink.count


def canon(
    source: str | os.PathLike[str] | BinaryIO,
    name: str,
    options: ReadOptions = _DEFAULT,
    diagnostics: Diagnostics | None = None,
) -> Iterator[str]:
    """Yield the canonical calls of a program, a line each, as LinuxCNC's ``rs274 -g`` prints them.

    The machine is the imaginary one of `rs274` (`standalone`), and as there the calls end at the first error; the rest of
    the program is read for its other errors.

    Args:
        source: The program's file or stream.
        name: Its name in diagnostics.
        options: How it is read.
        diagnostics: Receives its faults; without it, errors are raised after the whole text was printed.

    Raises:
        UsageError: Where the file cannot be read.
        ProgramError: Where the program has errors and `diagnostics` is not given.
    """
    from cncgen.gcode.sinks.standalone import CALL_LEVELS, StandAloneSink

    text = open_source(source, name)
    found = Diagnostics() if diagnostics is None else diagnostics
    runner: Runner | SinumerikRunner | HeidenhainRunner | None = None

    def text_at(index: int, offset: int) -> str:
        assert runner is not None
        return runner.sources[index].text_at(offset)

    sink = StandAloneSink(text_at)
    runner = _runner(
        text,
        replace(options, stand_alone=True, max_call_depth=min(options.max_call_depth, CALL_LEVELS)),
        sink,
        found,
        path=source if isinstance(source, str | os.PathLike) else None,
    )
    runner.reporter.on_error = sink.stop
    ip = runner.ip
    sink.outermost = lambda: ip.sink
    for _ in runner.run():
        yield from sink.take()
    # The peer resets twice, but once only with an INI file, which is how it gets a search path.
    sink.reset(1 if options.include else 2)
    yield from sink.take()
    if diagnostics is None and found.has_errors:
        raise ProgramError(list(found))

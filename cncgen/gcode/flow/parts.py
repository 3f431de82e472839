"""The objects that one run of a program consists of, connected to each other in one place."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache, partial

from cncgen.gcode.codes.table import language_of
from cncgen.gcode.flow.executing import Executor
from cncgen.gcode.flow.faults import Faults
from cncgen.gcode.flow.o_words import FlowControl
from cncgen.gcode.flow.pending import PendingBlocks
from cncgen.gcode.flow.reading import LineReader, Percent
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import Sink
from cncgen.gcode.source import Source
from cncgen.records import dataclass
from cncgen.toolpath.reading import ReadOptions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.flow.compiling import Compiler
    from cncgen.gcode.flow.profile_lines import Take
    from cncgen.gcode.text.labels import Cursor, Label


@dataclass(slots=True, eq=False, repr=False)
class Parts:
    """The parts of a run.

    Attributes:
        sources: The texts: the main program, then files in the order in which they were called.
        compiler: Gives the maker of actions.
        by_line: Whether the scanner cannot read the dialect's plain blocks, so that every line is parsed.
    """

    sources: list[Source]
    ip: Interpreter
    control: FlowControl
    lines: LineReader
    percent: Percent
    faults: Faults
    executor: Executor
    compiler: Callable[[], Compiler]
    pending: PendingBlocks
    by_line: bool


def assemble(
    sources: list[Source],
    dialect: str,
    options: ReadOptions,
    sink: Sink,
    faults: Faults,
    *,
    path: str | os.PathLike[str] | None,
    batches: bool,
    plain: bool,
) -> Parts:
    """Put the parts of a run together, which begins with the first of the texts; the arguments are those of `running.Runner`."""
    # The scanner does not tell 10 from 10. where the former counts in least increments.
    language = language_of(dialect)
    increments = language == "fanuc" and options.least_increment is not None
    ip = Interpreter(sink, options, faults.remark, dialect, plain=plain)
    control = ip.flow = FlowControl(ip, sources, path)
    executor = Executor(ip, control.calls, faults)
    compiler = cache(partial(_compiler, control, executor))
    pending = PendingBlocks(control, sources, compiler, executor, faults, batches=batches)
    control.calls.flush = faults.flush = pending.flush
    lines = LineReader(sources, language, increments=increments)
    control.lines, control.execute, control.run_profile = (
        lines,
        executor.execute,
        partial(_run_profile, control),
    )
    faults.recover = partial(_recover, ip)
    return Parts(
        sources=sources,
        ip=ip,
        control=control,
        lines=lines,
        percent=Percent(ip, sources[0]),
        faults=faults,
        executor=executor,
        compiler=compiler,
        pending=pending,
        by_line=increments or dialect == "heidenhain",
    )


def _compiler(control: FlowControl, executor: Executor) -> Compiler:
    """Return what makes actions of parsed blocks; programs whose lines are all plain or computed do not import the module."""
    from cncgen.gcode.flow.compiling import Compiler

    return Compiler(control.ip, control, executor.execute)


def _run_profile(control: FlowControl, take: Take, first: Cursor, end: Cursor | Label, word: str) -> None:
    """Run the lines of a profile; only programs of turning cycles import the module."""
    from cncgen.gcode.flow.profile_lines import run_profile

    run_profile(control, take, first, end, word)


def _recover(ip: Interpreter, text: str) -> None:
    """Put the modes of a faulty line in force; a program without faults does not import the module."""
    from cncgen.gcode.flow.recovery import recover

    recover(ip, text)

"""The order in which the lines of a program of SINUMERIK are executed: branches, loops, jumps, repeats, subprograms."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, cast

from cncgen.diagnostics import UsageError
from cncgen.gcode.block import Block
from cncgen.gcode.budget import LINE
from cncgen.gcode.codes.turning_profiles import MAX_MOVES, Recorder, Segment
from cncgen.gcode.errors import BlockError, Stop
from cncgen.gcode.flow.language_run import LanguageRun
from cncgen.gcode.flow.plain_lines import PlainLane
from cncgen.gcode.sinumerik import expressions
from cncgen.gcode.sinumerik.expressions import RParameter, Scalar, Value, evaluate, number, variable
from cncgen.gcode.sinumerik.motions import Motions
from cncgen.gcode.sinumerik.programs import Line, Program, programs_of
from cncgen.gcode.sinumerik.reading import Item
from cncgen.gcode.sinumerik.variables import Store, Variable
from cncgen.gcode.source import open_source
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.search import candidates, leaves_path, search_path

_YIELD = 512
_ENDS = {2.0, 30.0, 17.0}


#: What does a line of some kind: the program in progress, the number of the line, its data.
Handler = Callable[["Frame", int, tuple[Any, ...]], None]


@dataclass(slots=True)
class Frame:
    """A program in progress.

    Attributes:
        at: The line that comes next. left: Rounds left of the call.
        loops: Ends of FOR loops, by their first lines.
        repeats: Parts that are repeated: first and last line, rounds left, the line where that leads.
        results: Parameters by reference, and the variables of the caller that they are.
    """

    program: Program
    at: int = 0
    left: int = 0
    loops: dict[int, float] = field(default_factory=dict)
    repeats: list[tuple[int, int, int, int]] = field(default_factory=list)
    saved: object | None = None
    modal: bool = False
    results: list[tuple[str, Any]] = field(default_factory=list)


class SinumerikRunner(LanguageRun):
    """One run of a program of SINUMERIK."""

    dialect, ends_with = "sinumerik", "M30, M2 or M17"

    def _prepare(self) -> None:
        self.ip.state.motion = 10
        self.store = Store(self.ip)
        self.motions = Motions(self.ip, self.store, self._begin_call, self._contour)
        self._lane = (
            PlainLane(self.ip, self.sources, self.dialect, self.motions.take_plain) if self.batches else None
        )
        self._folders = search_path(self._path, self._options.include)
        self._programs: dict[str, Program] = {}
        self._frames: list[Frame] = []
        self._handlers: dict[str, Handler] = {
            name.removeprefix("_do_").replace("_", "-"): getattr(self, name)
            for name in dir(self)
            if name.startswith("_do_")
        }

    def run(self) -> Iterator[None]:
        """Run to the end; yields now and then, so that rows can be taken away."""
        if not self._open():
            return
        self.ip.begin()
        main = self._load(0, "")
        self.motions.begin(turns=main.said.turns())
        #: The change of a tool; without it T changes at once, as on lathes.
        self.motions.turret = ("M", 6.0) not in main.said.codes
        self._frames = [Frame(main)]
        self.ip.budget.forward = len(main.lines)
        try:
            yield from self._run()
            self._finish(main)
        except Stop as stop:
            self._faults.here(stop.error)

    def _load(self, index: int, name: str) -> Program:
        """Read the programs of a source; return the first."""
        found, faults = programs_of(self.sources[index], index, name)
        for here, error in faults:
            self._faults.at(here, error)
        for program in found[1:] if not name else found:
            if program.name:
                self._programs.setdefault(program.name, program)
        return found[0]

    def _finish(self, main: Program) -> None:
        """Report missing parts at the end of the text."""
        last = next(
            (line for at in reversed(range(len(main.lines))) if (line := main.lines[at]).statement.items),
            None,
        )
        here = last.here if last else Cursor(0, 0, 1)
        try:
            self.motions.settle()
            self.ip.end_compensation()
        except BlockError as error:
            self._faults.at(here, error)
        if last is None and not any(line.fault for _, line in main.lines.entries()):
            self._faults.at(here, BlockError("empty-program", f"{self.sources[0].name} has no block"))
        else:
            self._check_end(here)

    def _run(self) -> Iterator[None]:
        while self._frames and not self.ip.state.ended:
            frame = self._frames[-1]
            if frame.at >= len(frame.program.lines):
                self._leave()
                continue
            if self._plain(frame):
                yield
                continue
            line = frame.program.lines[frame.at]
            at, frame.at = frame.at, frame.at + 1
            self.ip.budget.count(1, LINE)
            if self.ip.budget.steps % _YIELD == 0:
                yield
            try:
                self._line(frame, at, line)
            except BlockError as error:
                self._fail(line.here, error)
            self._repeat(frame, at)

    def _plain(self, frame: Frame) -> bool:
        """Run plain lines in arrays; tell whether there were some."""
        at, lines = frame.at, frame.program.lines
        if self._lane is None or lines.plain_at(at) is None or not self.motions.is_plain():
            return False
        most = (frame.repeats[-1][1] + 1 if frame.repeats and at <= frame.repeats[-1][1] else len(lines)) - at
        lane = self._lane
        frame.at = self.motions.run_plain(lambda: lane.run(lines, at, min(most, self.ip.budget.left())))
        if frame.at == at:
            return False
        self._repeat(frame, frame.at - 1)
        return True

    def _line(self, frame: Frame, at: int, line: Line) -> None:
        if line.statement.deletable and self._options.block_delete:
            return
        here = line.here
        self._enter(here)
        if line.fault is not None:
            raise line.fault
        statement = line.statement
        if statement.kind == "block":
            self._block(frame, statement.items, here)
        elif statement.kind == "assign":
            self.motions.assignments(statement.items)
        else:
            self._handlers[statement.kind](frame, at, statement.data)

    def _block(self, frame: Frame, items: list[Item], here: Cursor) -> None:
        if not items:
            return
        ends = self.motions.block(items, here)
        if ends and len(self._frames) > 1:
            self._leave()
        elif ends:
            self.ip.end_program()

    def _number(self, value: Value) -> float:
        return number(evaluate(value, self.store))

    # Branches and loops.

    def _do_if(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        if self._number(data[0]) == 0.0:
            frame.at = frame.program.other[at] + 1

    def _do_else(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        frame.at = frame.program.other.get(at, at) + 1

    def _do_endif(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        """Go on."""

    def _do_loop(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        """Go on."""

    _do_repeat = _do_header = _do_loop

    def _back(self, frame: Frame, at: int) -> int:
        """Return the line that opens the loop which a line closes; the line itself where it closes no loop."""
        return frame.program.other.get(at, at)

    def _do_endloop(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        frame.at = self._back(frame, at) if self._back(frame, at) != at else frame.at

    def _do_while(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        if self._number(data[0]) == 0.0:
            frame.at = frame.program.other[at] + 1

    _do_endwhile = _do_endloop

    def _do_until(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        if self._number(data[0]) == 0.0:
            self._do_endloop(frame, at, data)

    def _do_for(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        """Count up, and leave the loop beyond its end; ENDFOR leads back to here."""
        (name, indices), first, last = data
        if at in frame.loops:
            now = self._number(variable(name, indices)) + 1.0
        else:
            now = self._number(first)
        frame.loops[at] = self._number(last)
        self._assign(name, [evaluate(node, self.store) for node in indices], now)
        if now > frame.loops[at]:
            del frame.loops[at]
            frame.at = frame.program.other[at] + 1

    _do_endfor = _do_endloop

    def _assign(self, name: str, indices: list[Scalar], value: Scalar) -> None:
        self.motions.assign(name, indices, value)

    # Jumps.

    def _do_jump(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        self._jump(frame, at, ("jump", *data))

    def _do_if_jump(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        for condition, jump in data[0]:
            if self._number(condition) != 0.0:
                self._jump(frame, at, jump)
                return

    def _do_case(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        value = self._number(data[0])
        usual = None
        for wanted, jump in data[1]:
            if wanted is None:
                usual = jump
            elif self._number(wanted) == value:
                self._jump(frame, at, jump)
                return
        if usual is not None:
            self._jump(frame, at, usual)

    def _jump(self, frame: Frame, at: int, jump: tuple[Any, ...]) -> None:
        """Go to a label: forward (GOTOF), back (GOTOB), either (GOTO, GOTOC; GOTOC goes on where the label is missing)."""
        _, how, label = jump
        if how == "GOTOS":
            frame.at, frame.loops = 0, {}
            parameters = {formal[2] for formal in frame.program.formals}
            scopes = self.store.scopes
            scopes[-1] = {name: value for name, value in scopes[-1].items() if name in parameters}
            return
        if not isinstance(label, str):
            target = str(evaluate(label, self.store)).upper()
        elif frame.program.labels.of(label) or not self.store.has(label):
            target = label
        else:
            target = str(self.store.value(label, [])).upper()
        lines = frame.program.labels.of(target)
        after = [line for line in lines if line > at]
        before = [line for line in lines if line <= at]
        where = {"GOTOF": after[:1], "GOTOB": before[-1:]}.get(how, after[:1] or before[-1:])
        if where:
            frame.at = where[0]
            frame.loops = {
                begin: last
                for begin, last in frame.loops.items()
                if begin < frame.at <= frame.program.other[begin]
            }
        elif how != "GOTOC":
            way = {"GOTOF": " below it", "GOTOB": " above it"}.get(how, "")
            raise BlockError(
                "label-missing", f"{how} {target} leads nowhere: the program has no such label{way}", how, hint=f"a line that begins with {target}: is the label"
            )  # fmt: skip

    def _do_repeat_part(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        names, times = data
        count = round(self._number(times))
        places = [self._label(frame, name) for name in names]
        last = (
            places[1]
            if len(places) == 2
            else (at - 1 if places[0] < at else self._end_label(frame, places[0]))
        )
        self._begin_repeat(frame, places[0], last, count, at)

    def _do_repeat_block(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        place = self._label(frame, data[0])
        self._begin_repeat(frame, place, place, round(self._number(data[1])), at)

    def _begin_repeat(self, frame: Frame, first: int, last: int, count: int, at: int) -> None:
        if count < 1:
            return
        if len(frame.repeats) >= self._options.max_call_depth:
            raise BlockError(
                "call-depth",
                f"REPEAT is nested more than {self._options.max_call_depth} deep",
                "REPEAT",
                hint="does a part repeat itself?",
            )
        frame.repeats.append((first, last, count - 1, at + 1))
        frame.at = first

    def _label(self, frame: Frame, name: str) -> int:
        lines = frame.program.labels.of(name)
        if not lines:
            raise BlockError(
                "label-missing",
                f"REPEAT {name} leads nowhere: there is no such label",
                "REPEAT",
                hint=f"{name}: begins the part",
            )
        return lines[0]

    def _end_label(self, frame: Frame, first: int) -> int:
        return next(
            (at for at in frame.program.labels.of("ENDLABEL") if at >= first),
            len(frame.program.lines) - 1,
        )

    def _repeat(self, frame: Frame, at: int) -> None:
        """Begin a part again whose last line was run, or go on behind its REPEAT."""
        if (
            not frame.repeats
            or at != frame.repeats[-1][1]
            or (self._frames and self._frames[-1] is not frame)
        ):
            return
        first, last, left, back = frame.repeats.pop()
        if left > 0:
            frame.repeats.append((first, last, left - 1, back))
        frame.at = first if left > 0 else back

    # Subprograms.

    def _begin_call(self, name: str, arguments: tuple[Any, ...] | None, times: int) -> None:
        """Run a subprogram."""
        program = self._find(name)
        if len(self._frames) > self._options.max_call_depth:
            message = f"subprogram calls are nested more than {self._options.max_call_depth} deep"
            raise Stop(BlockError("call-depth", message, name, hint="is the recursion without end?"))
        if times < 1:
            return
        scope = self._scope(program, arguments or ())
        results = self._results(program, arguments or ())
        frame = Frame(program, left=times - 1, results=results)
        frame.modal = self.motions.in_modal and not any(f.modal for f in self._frames)
        if program.saves:
            frame.saved = self.motions.save()
        self._frames.append(frame)
        self.store.scopes.append(scope)

    def _contour(self, name: str) -> list[Segment]:
        """Return the motions in the plane of a subprogram, or of the lines between two labels, BEGIN:END, of the program in progress."""
        begin, _, end = (part.strip() for part in name.partition(":"))
        program = self._frames[-1].program if end else self._find(begin)
        first, last = 0, len(program.lines) - 1
        if end:
            first, last = (self._labelled(program, label) for label in (begin, end))
        ip, frames, scopes = self.ip, self._frames, len(self.store.scopes)
        if isinstance(ip.sink, Recorder):
            raise BlockError("not-read", f"the contour {name} is called within a contour")
        state, sink, guard, kept = ip.state, ip.sink, ip.guard, self.motions.fields()
        recorder = Recorder(state.position, state.plane)
        ip.state = replace(state, feed=1.0, feed_mode=94, position=state.position.copy(), compensation=40)
        ip.sink, ip.guard, self._frames = recorder, None, [Frame(program), Frame(program, at=first)]
        self.store.scopes.append({})
        try:
            while len(self._frames) > 1:
                frame = self._frames[-1]
                if frame.at >= len(frame.program.lines) or (len(self._frames) == 2 and frame.at > last):
                    self._leave()
                    continue
                ip.budget.count(1, LINE)
                at, frame.at = frame.at, frame.at + 1
                line = frame.program.lines[at]
                try:
                    self._line(frame, at, line)
                except BlockError as error:
                    message = f"line {line.here.line} of the contour {name}: {error.message}"
                    raise BlockError(error.code, message, hint=error.hint, values=error.values) from None
                self._repeat(frame, at)
                if len(recorder.segments) > MAX_MOVES:
                    raise BlockError("profile-length", f"the contour {name} has more than {MAX_MOVES} moves")
            self.motions.settle()
            if ip.guard is not None:
                ip.guard(ip, Block({}, m=(20,)))
        finally:
            ip.state, ip.sink, ip.guard, self._frames = state, sink, guard, frames
            self.motions.set_fields(kept)
            del self.store.scopes[scopes:]
        return recorder.segments

    def _labelled(self, program: Program, label: str) -> int:
        """Return the line of a label."""
        found = program.labels.of(label)
        if not found:
            message = f"the contour has no label {label} in this program"
            raise BlockError("label-missing", message, hint=f"{label}: stands before its line")
        return found[0]

    def _find(self, name: str) -> Program:
        if name in self._programs:
            return self._programs[name]
        if not leaves_path(name):
            for folder in self._folders:
                for path in (
                    p for suffix in (".spf", ".mpf", "") for p in candidates(folder, f"{name}{suffix}")
                ):
                    try:
                        source = open_source(path, str(path))
                    except UsageError:
                        continue
                    self.sources.append(source)
                    program = self._load(len(self.sources) - 1, name)
                    self._programs[name] = program
                    return program
        places = ", ".join(str(folder) for folder in self._folders) or "the search path, which is empty"
        raise BlockError(
            "sub-missing", f"{name} is not read: it is not a command, and no subprogram of that name is in the text or in {places}",
            name, hint=f"{name}.SPF in a folder of --include is found",
        )  # fmt: skip

    def _scope(self, program: Program, arguments: tuple[Any, ...]) -> dict[str, Variable]:
        """Return the variables that a call begins with: the parameters of PROC."""
        if len(arguments) > len(program.formals):
            raise BlockError(
                "sub-arguments",
                f"{program.name} takes {len(program.formals)} arguments, not {len(arguments)}",
                program.name,
                hint="PROC lists them",
            )
        scope: dict[str, Variable] = {}
        for index, (_, kind, name, by_reference, usual, many) in enumerate(program.formals):
            node = arguments[index] if index < len(arguments) and arguments[index] is not None else usual
            if many:
                scope[str(name)] = self._array(program, str(name), node, bool(by_reference))
                continue
            value: Scalar = (
                evaluate(cast(Value, node), self.store)
                if node is not None
                else ("" if kind == "STRING" else 0.0)
            )
            scope[str(name)] = Variable(str(kind), (), [value])
        return scope

    def _array(self, program: Program, name: str, node: Any, by_reference: bool) -> Variable:
        """Return an array as a subprogram has it: the caller's own (VAR), or a copy."""
        whole = (
            self.store.array(node.name)
            if isinstance(node, expressions.Variable) and not node.indices
            else None
        )
        if whole is None:
            message = f"{name} of {program.name} is an array, and none is given"
            raise BlockError("sub-arguments", message, program.name, hint="DEF REAL AA[3] defines an array")
        return whole if by_reference else Variable(whole.kind, whole.bounds, list(whole.values))

    def _results(self, program: Program, arguments: tuple[Any, ...]) -> list[tuple[str, Any]]:
        """Return the parameters by reference, and the variables of the caller that they are."""
        found = []
        for (_, _, name, by_reference, _, many), node in zip(program.formals, arguments, strict=False):
            if by_reference and not many and node is not None:
                if not isinstance(node, RParameter | expressions.Variable):
                    raise BlockError(
                        "sub-arguments",
                        f"{name} of {program.name} is a variable (VAR), and a value is given",
                        program.name,
                        hint="give a variable or R parameter",
                    )
                found.append((str(name), node))
        return found

    def _leave(self) -> None:
        """End the innermost program, or its present round."""
        frame = self._frames[-1]
        if len(self._frames) == 1:
            self._frames.pop()
            return
        if frame.left > 0:
            frame.left, frame.at, frame.loops, frame.repeats = frame.left - 1, 0, {}, []
            return
        self._frames.pop()
        if frame.modal:
            self.motions.in_modal = False
        scope = self.store.scopes.pop()
        if frame.saved is not None:
            self.motions.restore(frame.saved)
        for name, node in frame.results:
            if isinstance(node, RParameter):
                self.store.set_parameter(self._number(node.index), scope[name].values[0])
            else:
                self.store.set_value(
                    node.name, [evaluate(index, self.store) for index in node.indices], scope[name].values[0]
                )

    # Definitions.

    def _do_def(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        kind, names = data
        for name, bounds, value in names:
            sizes = tuple(round(self._number(node)) for node in bounds)
            values: list[Scalar] = []
            if value is not None:
                nodes = value if isinstance(value, tuple) else (value,)
                values = [evaluate(node, self.store) for node in nodes]
            self.store.define(kind, name, sizes, values)

    def _do_proc(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        """PROC in the main program's text ends it, where it was not called."""
        if len(self._frames) == 1 and at > 0:
            self._leave()

    def _do_extern(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        """EXTERN declares a subprogram: nothing is to be done."""

"""Programs of SINUMERIK: what their statements mean, and the calls of subprograms."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, cast

from cncgen.gcode.block import Block
from cncgen.gcode.codes.turning_profiles import Segment
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.flow import language_run, recovery
from cncgen.gcode.flow.language_run import LanguageRun
from cncgen.gcode.flow.plain_lines import PlainLane
from cncgen.gcode.sinumerik import commands, expressions, unread_cycles
from cncgen.gcode.sinumerik.cycles import doubt_order
from cncgen.gcode.sinumerik.expressions import RParameter, Scalar, Value, evaluate, number, variable
from cncgen.gcode.sinumerik.motions import Motions
from cncgen.gcode.sinumerik.programs import SUFFIXES, Program, programs_of
from cncgen.gcode.sinumerik.said import file_name
from cncgen.gcode.sinumerik.variables import Store, Variable
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.lanes import empty_block
from cncgen.gcode.text.search import opened

Frame = language_run.Frame[Program]
#: Kinds of motion without words of their own.
_LINES = (0.0, 1.0)


def _target(program: Program, at: int, how: str, label: str) -> int | None:
    """Return the line to which a jump leads: forward (GOTOF), back (GOTOB), either (GOTO, GOTOC)."""
    lines = program.labelled(label)
    after = next((line for line in lines if line > at), None)
    before = next((line for line in reversed(lines) if line <= at), None)
    return {"GOTOF": after, "GOTOB": before}.get(how, before if after is None else after)


def _changes(program: Program) -> bool:
    return ("M", 6.0) in program.said.codes


class SinumerikRunner(LanguageRun[Program]):
    """One run of a program of SINUMERIK."""

    dialect, ends_with, suffixes = "sinumerik", "M30, M2 or M17", SUFFIXES
    plain = dialect

    def _prepare(self) -> None:
        self.ip.state.motion = 10
        self.store = Store(self.ip)
        self.store.is_file = self._is_file
        self.motions = Motions(self.ip, self.store, self._begin_call, self._contour)
        self.store.in_force = partial(commands.in_force, self.motions)
        self.store.calls_modally = lambda: self.motions.modal is not None
        self.store.in_diameters = lambda: "G9" in self.motions.diameter
        self._modal: Frame | None = None
        #: Lines of WHILE whose round waits for a signal.
        self._waiting: set[int] = set()
        #: Whether a jump from the second line back to the first never ends.
        self._endless: dict[tuple[int, int], bool] = {}

    def _begin(self, main: Program) -> None:
        self.motions.begin(turns=main.said.turns())
        self._begin_alone(main)
        # The change of a tool; without it T changes at once, as on lathes.
        self.motions.turret = not any(_changes(one) for one in (main, *self._files.values()))

    def _begin_alone(self, main: Program) -> None:
        """Begin a subprogram that nothing has called: its parameters have their usual values, or 0."""
        if not main.formals:
            return
        lines = (main.lines[k] for k in range(len(main.lines)))
        here = next(line.here for line in lines if line.statement.kind == "proc")
        self.ip.base.block = empty_block(here)
        try:
            assumed = [name for name in map(self._formal_alone, main.formals) if name]
        except BlockError as error:
            self._faults.at(here, error)
            return
        if assumed:
            message = f"nothing calls {main.name}, which has parameters: 0 is taken for {', '.join(assumed)}"
            hint = "a program that calls it gives them values"
            self.ip.warn_once("variable-assumed", message, "PROC", hint)

    def _formal_alone(self, formal: tuple[Any, ...]) -> str:
        """Define a parameter that no call gives; return its name where nothing says its value."""
        _, kind, name, _, usual, extent = formal
        bounds = tuple(round(self._number(node)) for node in (extent or ("",))[1:] if node is not None)
        if bounds:
            self.store.define(kind, name, bounds, [])
        elif extent is None:
            zero: Scalar = "" if kind in ("STRING", "AXIS") else 0.0
            value = zero if usual is None else evaluate(usual, self.store)
            self.store.scopes[-1][name] = Variable(kind, (), [value])
        return name if usual is None else ""

    def _load(self, index: int, name: str) -> Program:
        found, faults = programs_of(self.sources[index], index, name)
        for here, error in faults:
            self._faults.at(here, error)
        for program in found[1:] if not name else found:
            self.motions.turret &= not _changes(program)
            if program.name:
                self._files.setdefault(program.name, program)
        return found[0]

    def _settle(self) -> None:
        self.motions.settle()
        super()._settle()

    def _is_plain(self) -> bool:
        return self.motions.is_plain()

    def _run_plain(self, lane: PlainLane, frame: Frame, most: int) -> int:
        at, lines = frame.at, frame.program.lines
        return self._in_modes(lambda: lane.run(lines, at, most)) if self._is_plain() else at

    def _scopes(self) -> list[dict[str, Any]]:
        return self.store.scopes

    def _led_to(self, program: Program, at: int) -> int | None:
        statement = program.lines[at].statement
        other = program.other.get(at)
        if statement.kind in ("if", "while", "for", "else"):
            return None if other is None else other + 1
        if statement.kind in ("endloop", "endwhile", "endfor", "until"):
            return other
        if statement.kind == "jump":
            how, label = statement.data
        elif statement.kind == "if-jump" and len(statement.data[0]) == 1:
            _, how, label = statement.data[0][0][1]
        else:
            return None
        return _target(program, at, how, label) if isinstance(label, str) else None

    def _enters(self, frame: Frame, at: int) -> None:
        """Leave the loops that a line is not in."""
        other = frame.program.other
        for begin in [begin for begin in frame.loops if not begin < at <= other[begin]]:
            del frame.loops[begin]

    def _in_modes(self, run: Callable[[], int]) -> int:
        return self.motions.run_plain(run)

    def _run_words(self, at: int, here: Cursor, words: list[tuple[str, float]]) -> None:
        items = [
            ("set", "CR", (), value) if letter == "r" else ("word", letter.upper(), value)
            for letter, value in words
        ]
        self.motions.block(items, here)

    def _parameter_values(self) -> array[float]:
        return self.store.r

    def _made(self, begin: list[float], motion: memoryview, end: memoryview, centre: memoryview) -> None:
        self.motions.take_plain(begin, motion, end, centre)

    def _counters(self) -> object:
        scalars = [[v.values[0] for v in scope.values()] for scope in self.store.scopes]
        return super()._counters(), self.store.r, self.store.memory(), scalars

    def _line(self, frame: Frame, at: int) -> None:
        line = frame.program.lines[at]
        statement = line.statement
        if statement.deletable and self._options.block_delete:
            return
        if line.fault is not None:
            passed = frame.program.passed_by(at)
            if not passed:
                raise line.fault
            self._faults.fail(line.here, line.fault)
            self._pass_by(frame, passed)
            return
        if statement.kind == "assign":
            self.motions.assignments(statement.items)
        elif statement.kind != "block":
            run = self._handler(statement.kind)
            assert run is not None
            run(frame, at, statement.data)
        elif statement.items and self.motions.block(statement.items, line.here):
            if len(self.frames) > 1:
                self.leave()
            else:
                self.ip.end_program()

    def _fault_of(self, program: Program, at: int) -> BlockError | None:
        return program.lines[at].fault

    def _pass_by(self, frame: Frame, passed: range) -> None:
        """Go on behind a branch or loop whose condition cannot be read; the feeds and kinds of motion in it count for what follows."""
        for inner in passed:
            line = frame.program.lines[inner]
            if line.fault is not None:
                self._faults.fail(line.here, line.fault)
            words = [item[1:] for item in line.statement.items if item[0] == "word"]
            motions = tuple(
                round(10.0 * value) for letter, value in words if letter == "G" and value in _LINES
            )
            feeds = [value for letter, value in words if letter == "F" and value > 0.0]
            if motions:
                self.ip.state.motion = motions[-1]
            if feeds:
                recovery.attempt(self.ip, Block({"f": feeds[-1]}))
        frame.at = passed.stop

    def _number(self, value: Value) -> float:
        return number(evaluate(value, self.store))

    # Branches and loops.

    def do_endif(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        """Go on: the statement begins a loop, ends a branch or declares."""

    def do_synchronous(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        """ID=1 WHEN … DO M8: an output that comes while other blocks move."""
        message = "a synchronous action sends outputs and M functions while other blocks move: passed over"
        self.ip.note_once(
            "synchronous-output", message, "", "a block with its M function shows when it comes"
        )

    do_loop = do_repeat = do_header = do_proc = do_extern = do_endif

    def do_if(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        """IF: go on behind the other end where the condition does not hold."""
        if self._number(data[0]) == 0.0:
            frame.at = frame.program.other[at] + 1

    def do_while(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        """WHILE: as IF; a round that waits for a signal is run once."""
        self.store.asked.clear()
        end = frame.program.other[at]
        if self._number(data[0]) == 0.0:
            frame.at = end + 1
        elif at in self._waiting:
            self._waiting.discard(at)
            self._tell_wait(at, frame, "WHILE")
            frame.at = end + 1
        elif self._waits(frame, at, end):
            self._waiting.add(at)

    def _waits(self, frame: Frame, first: int, last: int) -> bool:
        """Tell whether a loop asks signals of the machine alone, which nothing in it changes."""
        asked = self.store.asked
        return bool(asked) and all(asked.values()) and frame.program.waits(first, last)

    def _tell_wait(self, first: int, frame: Frame, word: str) -> None:
        line = frame.program.lines.place(first).line
        message = f"{word} leads back to line {line} until {next(iter(self.store.asked))} tells of a signal of the machine: it counts as having come after one pass, and the wait takes no time"
        hint = "nothing is wrong where the machine gives the signal"
        self.ip.warn_once("wait-assumed", message, word, hint)

    def do_else(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        frame.at = frame.program.other.get(at, at) + 1

    def do_endwhile(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        """Go to the line that opens the loop which a line closes, if it closes one."""
        frame.at = frame.program.other.get(at, frame.at)

    do_endfor = do_endwhile

    def do_endloop(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        """End a round of LOOP, which has no end but a jump."""
        self.do_endwhile(frame, at, data)
        self._end_endless(frame, at, "ENDLOOP")

    def do_until(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        self.store.asked.clear()
        if self._number(data[0]) == 0.0:
            first = frame.program.other.get(at, at)
            if self._waits(frame, first, at):
                self._tell_wait(first, frame, "UNTIL")
            else:
                self.do_endwhile(frame, at, data)

    def do_for(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        """Count up, and leave the loop beyond its end; ENDFOR leads back to here."""
        (name, indices), first, last = data
        if at in frame.loops:
            now = self._number(variable(name, indices)) + 1.0
        else:
            now = self._number(first)
        frame.loops[at] = self._number(last)
        self.motions.assign(name, [evaluate(node, self.store) for node in indices], now)
        if now > frame.loops[at]:
            del frame.loops[at]
            frame.at = frame.program.other[at] + 1

    # Jumps.

    def do_if_jump(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        for condition, (_, *jump) in data[0]:
            self.store.asked.clear()
            if self._number(condition) == 0.0:
                continue
            first = self._led_to(frame.program, at)
            if first is not None and first <= at and self._waits(frame, first, at):
                self._tell_wait(first, frame, jump[0])
            else:
                self._jump(frame, at, jump)
            return

    def do_case(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        value = self._number(data[0])
        usual = None
        for wanted, (_, *jump) in data[1]:
            if wanted is None:
                usual = jump
            elif self._number(wanted) == value:
                self._jump(frame, at, jump)
                return
        if usual is not None:
            self._jump(frame, at, usual)

    def do_jump(self, frame: Frame, at: int, data: Sequence[Any]) -> None:
        """Jump without a condition."""
        self._jump(frame, at, data)
        self._end_endless(frame, at, data[0])

    def _end_endless(self, frame: Frame, at: int, word: str) -> None:
        """End the program after a line that led back, where nothing between leads elsewhere: one pass is planned, as of bar feeders and warm-ups."""
        first, program = frame.at, frame.program
        if first > at or frame.repeats:
            return
        if (first, at) not in self._endless:
            # A subprogram may go on elsewhere than behind its call.
            aside = any("RET(" in one.said.names for one in (self.frames[0].program, *self._files.values()))
            self._endless[first, at] = not aside and program.never_left(first, at)
        if self._endless[first, at]:
            message = f"{word} leads back to line {program.lines.place(first).line} without end, as nothing between leads elsewhere; one pass is planned"
            self.ip.note("program-repeats", message, word, "M30 ends it")
            self.ip.end_program()

    def _jump(self, frame: Frame, at: int, data: Sequence[Any]) -> None:
        """Go to a label: forward (GOTOF), back (GOTOB), either (GOTO, GOTOC; GOTOC goes on where the label is missing)."""
        how, label = data
        if how == "GOTOS":
            frame.restart(0)
            parameters = {formal[2] for formal in frame.program.formals}
            scopes = self.store.scopes
            scopes[-1] = {name: value for name, value in scopes[-1].items() if name in parameters}
            return
        if not isinstance(label, str):
            target = str(evaluate(label, self.store)).upper()
        elif frame.program.labelled(label) or not self.store.has(label):
            target = label
        else:
            target = str(self.store.value(label, [])).upper()
        where = _target(frame.program, at, how, target)
        if where is not None:
            frame.at = where
            self._enters(frame, where)
        elif how != "GOTOC":
            way = {"GOTOF": " below it", "GOTOB": " above it"}.get(how, "")
            raise BlockError(
                "label-missing", f"{how} {target} leads nowhere: the program has no such label{way}", how, hint=f"a line that begins with {target}: is the label"
            )  # fmt: skip

    def do_repeat_part(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        """REPEAT A B: from label to label; REPEAT A: from a label to here, or to ENDLABEL behind it."""
        names, times = data
        first, *last = (self._repeated(frame, name) for name in names)
        if not last and first >= at:
            ends = frame.program.labelled("ENDLABEL")
            last = [next((end for end in ends if end >= first), len(frame.program.lines) - 1)]
        self._begin_repeat(frame, first, last[0] if last else at - 1, round(self._number(times)), at)

    def do_repeat_block(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        place = self._repeated(frame, data[0])
        self._begin_repeat(frame, place, place, round(self._number(data[1])), at)

    def _begin_repeat(self, frame: Frame, first: int, last: int, count: int, at: int) -> None:
        if count < 1:
            return
        if len(frame.repeats) >= self._options.max_call_depth:
            message = f"REPEAT is nested more than {self._options.max_call_depth} deep"
            raise BlockError("call-depth", message, "REPEAT", hint="does a part repeat itself?")
        frame.repeats.append((first, last, count - 1, at + 1))
        frame.at = first

    def _repeated(self, frame: Frame, name: str) -> int:
        message = f"REPEAT {name} leads nowhere: there is no such label"
        return self.label(frame.program, name, message, "REPEAT", f"{name}: begins the part")

    # Subprograms.

    def _begin_call(self, name: str, arguments: tuple[Any, ...] | None, times: int) -> None:
        if name == "RET":
            self._return_to(arguments or ())
            return
        program = self._find(name)
        if times < 1:
            return
        given = arguments or ()
        scope, results = self._scope(program, given), self._results(program, given)
        frame = Frame(program, rounds=times - 1)
        frame.back = partial(self._give_back, frame, results, self.motions.save() if program.saves else None)
        self.enter(frame, name)
        if self.motions.in_modal and self._modal is None:
            self._modal = frame
        self.store.scopes.append(scope)

    def _return_to(self, arguments: tuple[Any, ...]) -> None:
        """RET(target, behind, levels): end so many calls, 1 without the last one, and go on at a label or block number, or in the line behind it
        where `behind` is above 0; it is looked for as GOTO does, from the call on (from memory of 840D sl, Job planning, "Parameterizable subprogram return").
        """
        given = [None if node is None else evaluate(node, self.store) for node in arguments]
        target, behind, levels, start = (*given, None, None, None, None)[:4]
        if behind or levels:
            doubt_order(self.motions, "RET", "the target, above 0 for the line behind it, how many calls end")
        count = max(1, round(number(levels or 0.0)))
        calls = [frame for frame in self.frames if not frame.part]
        refuse(
            "RET",
            (bool(start), "unsupported-block", "RET to the beginning of the main program is not read", "its fourth parameter is left out"),
            (count >= len(calls), "call-depth", f"RET ends {count} calls, and {len(calls) - 1} are in progress", "the third parameter counts them"),
        )  # fmt: skip
        label = f"N{target:.0f}" if isinstance(target, float) else str(target or "").upper()
        caller = calls[-1 - count]
        if label and _target(caller.program, caller.at - 1, "GOTO", label) is None:
            message = f"RET {label} leads nowhere: the program that it leads back to has no such label"
            raise BlockError(
                "label-missing", message, "RET", hint=f"a line that begins with {label}: is the label"
            )
        for frame in reversed(calls[-count:]):
            if label or frame is not calls[-count]:
                frame.rounds = 0
            self.leave()
        if label:
            frame = self.frames[-1]
            where = _target(frame.program, frame.at - 1, "GOTO", label) or 0
            frame.at = where + (1 if number(behind or 0.0) > 0.0 else 0)
            self._enters(frame, frame.at)

    def _give_back(self, frame: Frame, results: list[tuple[str, Any]], saved: tuple[Any, ...] | None) -> None:
        """End a subprogram: the modes that SAVE kept, and results."""
        if self._modal is frame:
            self.motions.in_modal, self._modal = False, None
        scope = self.store.scopes.pop()
        if saved is not None:
            self.motions.restore(saved)
        for name, node in results:
            value = scope[name].values[0]
            if isinstance(node, RParameter):
                self.store.set_parameter(self._number(node.index), value)
            else:
                self.store.set_value(
                    node.name, [evaluate(index, self.store) for index in node.indices], value
                )

    def _contour(self, name: str) -> list[Segment]:
        """Return the motions in the plane of a subprogram, or of the lines between two labels, BEGIN:END, of the program in progress."""
        begin, _, end = (part.strip() for part in name.partition(":"))
        frame = Frame(self.frames[-1].program if end else self._find(begin))
        if end:
            first, last = (
                self.label(
                    frame.program,
                    one,
                    f"the contour has no label {one} in this program",
                    "",
                    f"{one}: stands before its line",
                )
                for one in (begin, end)
            )
            frame.at, frame.end = first, last + 1
        kept, scopes = self.motions.fields(), len(self.store.scopes)
        self.store.scopes.append({})
        try:
            return self.record(frame, name, self.ip.state.plane).segments
        finally:
            self.motions.set_fields(kept)
            del self.store.scopes[scopes:]

    def _find(self, word: str) -> Program:
        """Return the program of a word, which may be the name of its file in the control (_N_NAME_SPF)."""
        name = file_name(word)
        missing = f"{name} is not read: it is not a command, and no subprogram of that name is in the text or"
        return self.program_of(name, missing, word, unread_cycles.hint_of(name))

    def _is_file(self, text: str) -> bool:
        """Tell whether a program of a name is in the text, beside it or in a folder of --include (828D, Job planning 07/2010, 1.21)."""
        name = file_name(text)
        return name in self._files or opened(self._folders, name, self.suffixes) is not None

    def _scope(self, program: Program, arguments: tuple[Any, ...]) -> dict[str, Variable]:
        """Return the variables that a call begins with: the parameters of PROC."""
        if len(arguments) > len(program.formals):
            message = f"{program.name} takes {len(program.formals)} arguments, not {len(arguments)}"
            raise BlockError("sub-arguments", message, program.name, hint="PROC lists them")
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
                    message = f"{name} of {program.name} is a variable (VAR), and a value is given"
                    hint = "give a variable or R parameter"
                    raise BlockError("sub-arguments", message, program.name, hint=hint)
                found.append((str(name), node))
        return found

    # Definitions.

    def do_def(self, frame: Frame, at: int, data: tuple[Any, ...]) -> None:
        kind, names = data
        for name, bounds, value in names:
            sizes = tuple(round(self._number(node)) for node in bounds)
            values: list[Scalar] = []
            if value is not None:
                nodes = value if isinstance(value, tuple) else (value,)
                values = [evaluate(node, self.store) for node in nodes]
            self.store.define(kind, name, sizes, values)

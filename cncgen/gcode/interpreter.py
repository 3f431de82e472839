"""The modal interpreter: executes one block after another on the state and calls the sink."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cncgen.diagnostics import Severity
from cncgen.gcode.block import AXIS_INDEX, Block
from cncgen.gcode.codes import Code, Handler, table
from cncgen.gcode.errors import BlockError
from cncgen.gcode.modal import NO_MOTION, State, to_machine, to_program
from cncgen.gcode.parameters import Parameters
from cncgen.gcode.sink import Sink
from cncgen.toolpath.reading import ReadOptions

_AXIS_LETTERS = frozenset("xyzabcuvw@^")
#: Plans kept; a program uses some dozens.
_MAX_PLANS = 4096


@dataclass(frozen=True, slots=True)
class Plan:
    """What a block with these codes and letters does in this modal motion, in order."""

    steps: tuple[Handler, ...]


class Interpreter:
    """State, parameters and sink of one run.

    `warn` takes a remark on the block that is executed (a `BlockError` and its severity).
    """

    def __init__(
        self,
        sink: Sink,
        options: ReadOptions,
        warn: Callable[[BlockError, Severity], None],
        dialect: str = "linuxcnc",
    ) -> None:
        self.sink = sink
        self.options = options
        self.warn = warn
        self.dialect = dialect
        self.codes = table(dialect)
        self.state = State()
        self.parameters = Parameters(self)
        #: Looks at each block before it runs while a curve of several blocks is open; set by that curve's handler.
        self.guard: Handler | None = None
        self._plans: dict[tuple[object, ...], Plan] = {}

    def execute(self, block: Block) -> None:
        """Execute a block.

        Raises:
            BlockError: What is wrong with it; parts that come earlier in the order of execution have been done.
        """
        key = (self.state.motion, block.g, block.m, *block.words)
        plan = self._plans.get(key)
        if plan is None:
            if len(self._plans) >= _MAX_PLANS:
                self._plans.clear()
            plan = self._plans[key] = self._plan(block)
        self.sink.block = block
        for step in plan.steps:
            step(self, block)

    def _plan(self, block: Block) -> Plan:
        """Find the codes of a block, check that they go together, and order them."""
        codes = [self._code("G", number) for number in block.g] + [
            self._code("M", number) for number in block.m
        ]
        codes += [
            self.codes[letter, 0] for letter in map(str.upper, block.words) if (letter, 0) in self.codes
        ]
        _check_groups(codes)
        motion = self._motion_of(block, codes)
        if motion is not None and motion not in codes:
            codes.append(motion)
        allowed = set().union(*(code.words for code in codes)) if codes else set()
        for letter in block.words:
            if letter not in allowed:
                raise _unused(letter, self.codes)
        return Plan(tuple(code.run for code in sorted(codes, key=lambda code: code.stage)))

    def _code(self, letter: str, number: int) -> Code:
        """Return a code of the table, or raise."""
        code = self.codes.get((letter, number))
        if code is None:
            name = f"{letter}{number / 10:g}"
            raise BlockError(
                "unknown-code", f"{name} is not supported", name, hint="`cncgen codes` lists all"
            )
        return code

    def _motion_of(self, block: Block, codes: list[Code]) -> Code | None:
        """Return the motion that the block's axis words belong to: its own, or the modal one."""
        own = [code for code in codes if code.axes == "own"]
        motion = next((code for code in codes if code.axes == "motion"), None)
        moves = not _AXIS_LETTERS.isdisjoint(block.words)
        if own and (motion or len(own) > 1) and moves:
            other = motion or own[1]
            raise BlockError(
                "axis-words-twice", f"{own[0].name} and {other.name} both need the axis words", own[0].name
            )
        if own or motion:
            return motion
        modal = self.codes.get(("G", self.state.motion))
        if modal is not None and modal.number != NO_MOTION and not set(modal.summons).isdisjoint(block.words):
            return modal
        if moves:
            letter = next(letter for letter in block.words if letter in _AXIS_LETTERS)
            raise BlockError(
                "no-motion-mode",
                f"{letter.upper()} stands in a block with no motion code, and none is in force",
                letter.upper(),
                hint="begin with G0, G1, G2 or G3",
            )
        return None

    # What handlers share.

    def batchable(self) -> bool:
        """Tell whether plain motions may be interpreted in arrays, without a handler a block."""
        state = self.state
        return (
            state.motion in (0, 10, 20, 30, NO_MOTION)
            and state.plane in (17, 18, 19)
            and state.compensation == 40
            and (state.feed_mode != 95 or (state.speed > 0.0 and state.direction != 0))
            and self.guard is None
        )

    def end_point(self, block: Block) -> list[float]:
        """Return where the block's axis words lead, in program coordinates."""
        state = self.state
        end = state.position.copy()
        words = block.words
        if state.absolute:
            for letter, value in words.items():
                index = AXIS_INDEX.get(letter)
                if index is not None:
                    end[index] = value
        else:
            for letter, value in words.items():
                index = AXIS_INDEX.get(letter)
                if index is not None:
                    end[index] += value
        return end

    def machine_position(self) -> list[float]:
        """Return where the tool's reference point is, in machine coordinates and program units."""
        return to_machine(self.state.position, *self.state.offsets())

    def rebase(self, machine: list[float]) -> None:
        """Take program coordinates anew after an offset changed; the machine stays at `machine`."""
        self.state.position = to_program(machine, *self.state.offsets())


def _check_groups(codes: list[Code]) -> None:
    """Raise where two codes of one modal group stand in one block."""
    seen: dict[str, Code] = {}
    for code in codes:
        other = seen.get(code.group)
        if other is not None:
            raise BlockError(
                "modal-conflict",
                f"{other.name} and {code.name} are of one modal group ({code.group})",
                code.name,
                hint="write them in two blocks",
            )
        seen[code.group] = code


def _unused(letter: str, codes: dict[tuple[str, int], Code]) -> BlockError:
    """Return the fault of a word that no code of its block uses."""
    users = sorted({code.number: code.name for code in codes.values() if letter in code.words}.items())
    names = ", ".join(name for _, name in users[:8])
    return BlockError(
        "unused-word",
        f"{letter.upper()} stands in a block with no code that uses it",
        letter.upper(),
        hint=f"it belongs to {names}" if names else "",
    )

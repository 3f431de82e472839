"""The plan of a block from its codes and letters: which codes, whether they go together, in which order.

A plan is the handlers that the interpreter calls for a block (it is unrelated to the plan of the motion).
Blocks with the same codes, letters and modal motion share one. The order of execution is that of `modal.Stage` (Kramer et al.
(2000), section 3.8); axis words belong to one code of a block, its own or the motion in force (section 3.4).
"""

from __future__ import annotations

from functools import cache, partial

from cncgen.gcode.block import AXES, PROGRAM, Block
from cncgen.gcode.codes.table import (
    ALONE,
    BOTH,
    IS_CYCLE,
    LATHE,
    LATHES,
    OFFSET_NUMBERS,
    Code,
    Codes,
    Handler,
    language_of,
    table,
)
from cncgen.gcode.errors import BlockError
from cncgen.gcode.state.modal import NO_MOTION, PLAIN_MOTIONS, Stage

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

_AXIS_LETTERS = frozenset("xyzabcuvw@^")
_PLAIN_LETTERS = "dehijklpqr"
#: Block plans that are kept; a program uses some dozens.
_MAX_PLANS = 4096
_G4, G49, G53 = 40, 490, 530
_M98 = 980
_STRAIGHT = (0, 10)
#: The group of codes that hold for their block alone.
_ONE_SHOT = "non-modal"


def _run_under(ip: Interpreter, block: Block) -> None:
    """Make the motion that is in force again after G80 of FANUC."""
    ip.codes["G", ip.state.motion].run(ip, block)


_UNDER = Code("G", -1, "motion", Stage.MOTION, _run_under, "", "xyzabcuvwijkr", "motion")


def _traverse_once(ip: Interpreter, block: Block) -> None:
    """Traverse as G53 of FANUC does; the motion in force stays."""
    motion = ip.state.motion
    ip.codes["G", 0].run(ip, block)
    ip.state.motion = motion


@cache
def _only_modal(number: int) -> Code:
    """Return the effect of a motion code of FANUC beside a one-shot code that takes the axis words: it comes into force."""

    def run(ip: Interpreter, block: Block) -> None:
        ip.state.motion = number

    return Code("G", number, "motion", Stage.MOTION, run, "")


def _unsaid(letter: str) -> BlockError:
    message = f"{letter.upper()} stands in a block with no motion code, and none is in force"
    return BlockError("no-motion-mode", message, letter.upper(), hint="begin with G0, G1, G2 or G3")


def _first_traverse(ip: Interpreter, block: Block) -> None:
    """Traverse before the first motion code of a program whose control no sign tells: grbl and FANUC's controls begin with G0."""
    letter = next(letter for letter in block.words if letter in _AXIS_LETTERS)
    if ip.state.moved:
        raise _unsaid(letter)
    message = (
        f"{letter.upper()} stands before the first motion code: it is taken as a traverse, as grbl has it"
    )
    hint = "write G0, without which LinuxCNC refuses the block"
    ip.warn_once("other-control", message, letter.upper(), hint)
    ip.codes["G", 0].run(ip, block)


_FIRST_TRAVERSE = Code("G", 0, "motion", Stage.MOTION, _first_traverse, "", AXES, "motion")
_TRAVERSE_ONCE = Code("G", 0, "motion", Stage.MOTION, _traverse_once, "", AXES, "motion")


class BlockPlans:
    """The plans of a dialect's blocks, each worked out once and kept; `codes` is the dialect's table of codes.

    `plain` says that no sign tells which control the program is for.
    """

    def __init__(self, dialect: str, *, plain: bool = False) -> None:
        self.dialect = language_of(dialect)
        self._plain = plain
        self._table = dialect
        self._alone = frozenset(ALONE + OFFSET_NUMBERS if dialect == "fanuc" else ALONE)
        self.codes: Codes = table(dialect)
        self._plans: dict[tuple[object, ...], tuple[Handler, ...]] = {}

    def of(self, block: Block, motion: int) -> tuple[Handler, ...]:
        """Return the handlers of a block while `motion` is in force, in the order of execution.

        Raises:
            BlockError: Its codes do not go together, or a word belongs to none of them.
        """
        key = (motion, block.g, block.m, *block.words)
        plan = self._plans.get(key)
        if plan is None:
            if len(self._plans) >= _MAX_PLANS:
                self._plans.clear()
            plan = self._plans[key] = self._made(block, motion)
        return plan

    def _made(self, block: Block, in_force: int) -> tuple[Handler, ...]:
        """Find the codes of a block, check that they go together, and order them."""
        codes, remarks = self._named(block)
        motion = self._motion_of(block, codes, in_force)
        if motion is not None and motion not in codes:
            codes.append(motion)
        # Without axis words, G53 of FANUC and Mach does nothing.
        idle = (self.dialect == "fanuc" or self._plain) and _AXIS_LETTERS.isdisjoint(block.words)
        if G53 in block.g and not idle and (motion is None or motion.number not in _STRAIGHT):
            raise BlockError("g53-motion", "G53 goes with G0 and G1 only", "G53")
        # S of G4 is a time with Marlin, where P is none.
        timed = self._plain and _G4 in block.g and "p" not in block.words and not block.m
        codes += self._of_lone_words(block, codes, "s" if timed else "")
        allowed = set().union(*(code.words for code in codes), *(code.named for code in codes))
        if self._plain and G49 in block.g:
            # Posts write G49 H0, which LinuxCNC alone refuses.
            allowed.add("h")
        if timed:
            allowed.add("s")
        for letter in block.words:
            if letter not in allowed:
                raise _unused(letter, self.codes, self._elsewhere(letter, block))
        steps = remarks + [code.run for code in sorted(codes, key=lambda code: code.stage)]
        steps += [code.after for code in codes if code.after is not None]
        return tuple(steps)

    def _named(self, block: Block) -> tuple[list[Code], list[Handler]]:
        """Return the codes of the G and M words of a block, and what remarks on them; raise where they do not go together."""
        codes = _without_cancel([self._code("G", number, block) for number in block.g])
        remarks: list[Handler] = []
        if self._table == "fanuc":
            codes, remarks = _last_of_groups(codes)
        codes += [self._code("M", number, block) for number in block.m]
        _check_groups(codes)
        return _one_mover(codes) if self.dialect == "fanuc" else codes, remarks

    def _elsewhere(self, letter: str, block: Block) -> str:
        """Return the advice on a word that a code of the block takes on lathes, or that seems to be an argument of M98."""
        word = letter.upper()
        if self.dialect == "fanuc" and _M98 in block.m:
            return (
                f"M98 hands no arguments on: G65 P with {word} sets parameters of the program that it calls"
            )
        if self._table != "fanuc":
            return ""
        codes = (table("fanuc-lathe").get(("G", number)) for number in block.g)
        name = next((code.name for code in codes if code is not None and letter in code.words), "")
        return f"{name} takes {word} on lathes, which --dialect fanuc-lathe reads" if name else ""

    def _of_lone_words(self, block: Block, codes: list[Code], besides: str) -> list[Code]:
        """Return the codes of words that mean something by themselves, unless a code of the block takes them, as it does those besides."""
        taken = {letter for code in codes for letter in code.takes} | set(besides)
        return [
            self.codes[letter.upper(), 0]
            for letter in block.words
            if letter.upper() in self._alone and letter not in taken
        ]

    def _code(self, letter: str, number: int, block: Block) -> Code:
        code = self.codes.get((letter, number))
        if code is None and letter == "M" and (self.dialect != "linuxcnc" or self._plain):
            from cncgen.gcode.codes.subprograms import of_builder

            # By itself in a block, it may have words of any letter that is no axis.
            return of_builder(
                number, "pq" if block.g or not _AXIS_LETTERS.isdisjoint(block.words) else _PLAIN_LETTERS
            )
        if code is None:
            from cncgen.gcode.codes.unsupported import MEANING, ON_LATHES, WITHOUT

            name = f"{letter}{number / 10:g}"
            hint = WITHOUT.get((letter, number), "`cncgen codes` lists all that are read")
            others = (*BOTH, LATHE) if self._table == "linuxcnc" else (LATHE, *reversed(BOTH))
            other = next((d for d in others if d != self._table and (letter, number) in table(d)), None)
            meaning = MEANING.get((letter, number), "")
            if other:
                meaning = meaning or table(other)[letter, number].help
                hint = WITHOUT.get(
                    (letter, number), f"it is a code of the {other} dialect: --dialect {other}"
                )
            if letter == "G" and self._table in LATHES:
                hint = ON_LATHES.get(number, hint)
            shown = f"{name} ({meaning})" if meaning else name
            raise BlockError("unknown-code", f"{shown} is not supported", name, hint=hint)
        return code

    def _motion_of(self, block: Block, codes: list[Code], in_force: int) -> Code | None:
        """Return the motion that the block's axis words belong to: its own, or the modal one."""
        own = [code for code in codes if code.axes == "own"]
        motion = next((code for code in codes if code.axes == "motion"), None)
        moves = not _AXIS_LETTERS.isdisjoint(block.words)
        if own or motion:
            takers = own + [code for code in (motion,) if code is not None and code.number != NO_MOTION]
            if own and moves and len(takers) > 1:
                message = f"{own[0].name} and {takers[-1].name} both need the axis words"
                raise BlockError("axis-words-twice", message, own[0].name)
            return motion
        if moves and G53 in block.g and self.dialect == "fanuc":
            return _TRAVERSE_ONCE
        return self._motion_in_force(block, codes, in_force, moves)

    def _motion_in_force(self, block: Block, codes: list[Code], in_force: int, moves: bool) -> Code | None:
        """Return the modal motion that a block without a motion code goes on with."""
        modal = self.codes.get(("G", in_force))
        if any(code.group == "canned cycle" for code in codes):
            modal = _UNDER
        if modal is not None and modal.number != NO_MOTION:
            # R of M19, say, does not belong to a cycle; axis words of other codes have been dealt with.
            used = {letter for code in codes for letter in code.words} - _AXIS_LETTERS
            if not (set(modal.summons) - used).isdisjoint(block.words):
                return modal
        if moves:
            if self._plain and in_force == NO_MOTION:
                return _FIRST_TRAVERSE
            raise _unsaid(next(letter for letter in block.words if letter in _AXIS_LETTERS))
        if modal is not None and modal.refused == IS_CYCLE and self.dialect == "fanuc":
            used = {letter for code in codes for letter in code.words}
            idle = {letter for letter in block.words.keys() - used if letter.upper() not in self._alone}
            if idle and idle <= set(modal.words):
                return _not_kept(modal, "".join(sorted(idle)))
        return None


def _not_kept(cycle: Code, letters: str) -> Code:
    """Return what words of a cycle do in a block that makes no hole: nothing, since FANUC's controls keep them from such blocks only that
    have a place or R ("in a block containing hole position data", B-63324EN, 13.1)."""
    names = " ".join(letters.upper())
    message = f"{names} of {cycle.name} in a block that makes no hole: the holes behind it do not have it"
    hint = "write it in a block with X Y Z or R; some controls keep it all the same"

    def remark(ip: Interpreter, block: Block) -> None:
        ip.warn("cycle-words", message, names[0], hint)

    return Code("G", cycle.number, "motion", Stage.MOTION, remark, "", letters)


def _without_cancel(codes: list[Code]) -> list[Code]:
    """Drop G80 where its block has another motion code, which ends a canned cycle as well."""
    if sum(code.group == "motion" for code in codes) < 2:
        return codes
    return [code for code in codes if (code.letter, code.number) != ("G", NO_MOTION)]


def _one_mover(codes: list[Code]) -> list[Code]:
    """Leave the axis words to a one-shot code of FANUC (``G0 G28 Z0``) that stands beside G0 to G3."""
    if not any(code.axes == "own" and code.group == _ONE_SHOT for code in codes):
        return codes
    return [
        _only_modal(code.number) if code.letter == "G" and code.number in PLAIN_MOTIONS else code
        for code in codes
    ]


def _last_of_groups(codes: list[Code]) -> tuple[list[Code], list[Handler]]:
    """Return the last G code of each modal group, which alone counts on FANUC's mills, and remarks on the others."""
    kept: dict[object, Code] = {}
    remarks: list[Handler] = []
    for code in reversed(codes):
        last = kept.setdefault(code if code.group == _ONE_SHOT else code.group, code)
        if last is not code:
            remarks.insert(0, partial(_remark_on_conflict, code=code, last=last))
    return list(reversed(kept.values())), remarks


def _remark_on_conflict(ip: Interpreter, block: Block, code: Code, last: Code) -> None:
    """Return the warning that a later code of its group replaces a code."""
    message = f"{code.name} and {last.name} are of one modal group ({code.group}): the last one counts"
    ip.warn("modal-conflict", message, code.name, "leave the other one out")


def _check_groups(codes: list[Code]) -> None:
    """Raise where two codes of one modal group stand in one block."""
    seen: dict[str, Code] = {}
    for code in codes:
        other = seen.get(code.group)
        if other is not None:
            message = f"{other.name} and {code.name} are of one modal group ({code.group})"
            raise BlockError("modal-conflict", message, code.name, hint="write them in two blocks")
        seen[code.group] = code


def _unused(letter: str, codes: Codes, advice: str) -> BlockError:
    """Return the fault of a word that no code of its block uses; the advice, if any, goes before the codes that do."""
    # Codes of a blank take nearly all letters, and do nothing.
    users = sorted(
        {
            code.number: code.name
            for code in codes.values()
            if letter in code.words and code.group != "blank"
        }.items()
    )
    names = ", ".join(name for _, name in users[:8])
    hint = advice or (f"it belongs to {names}" if names else "")
    if letter == "e" and not advice:
        hint = "numbers have no exponent in G-code, and printers' extruders are not read" + (
            f"; E {hint[3:]}" if hint else ""
        )
    if letter == PROGRAM:
        message = "a name in < > stands in a block with no code that uses it"
        return BlockError("unused-word", message, "<", hint=hint)
    message = f"{letter.upper()} stands in a block with no code that uses it"
    return BlockError("unused-word", message, letter.upper(), hint=hint)

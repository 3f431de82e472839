"""Canned cycles of LinuxCNC: G73, G74, G81 to G89 (FANUC's are in `canned_cycles_fanuc`).

A cycle makes a hole: the tool goes across to the place of the hole, down to R, and then makes the motions of the cycle. Words stay
in force from block to block of the same cycle; only L (repeats) does not. "Across" is in the plane, "down" along its
normal: the cycles work in G17, G18 and G19.

Source: Kramer et al. (2000), section 3.5.16, and LinuxCNC's manual, "Canned cycles".
"""

from __future__ import annotations

from collections.abc import Callable, Set
from functools import partial

from cncgen.gcode.block import AXES, Block
from cncgen.gcode.codes.lines import check_cycle_feed, check_feed
from cncgen.gcode.codes.spindle import TURNS, turn_to
from cncgen.gcode.codes.table import IS_CYCLE, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.records import dataclass, field
from cncgen.toolpath.record import Event, PathMode

#: How far above the bottom of the last peck the next one begins, by inches (mm and inch units).
PECK_CLEARANCE = {False: 0.254, True: 0.010}
MAX_REPEATS = 100_000
#: Pecks of one hole beyond which Q counts as a mistake.
MAX_PECKS = 100_000


@dataclass(slots=True)
class Sticky:
    """The words that stay in force between blocks of cycles.

    Attributes:
        number: The cycle, in tenths.
        words: Its words as programmed, by letter.
        level: Where the tool was along the normal when the first of a row of cycles began.
        dwell: The last P of any cycle; the tapping cycles, which need none, wait for it.
        relative: Of FANUC's cycles, letters of `words` that were given in incremental mode.
    """

    number: int = 0
    words: dict[str, float] = field(default_factory=dict)
    level: float = 0.0
    dwell: float = 0.0
    relative: Set[str] = frozenset()


@dataclass(slots=True)
class Hole:
    """A hole along the normal of the plane, and the moves that make it.

    Attributes:
        ip, block: The run and the block that the hole comes from.
        normal: Column of the axis to drill along.
        retract, bottom, clear: R, the bottom, and where the tool goes when the hole is done, as heights above the part.
        words: Words in force.
        spindle: Index of the spindle (``$``).
        up: 1, or -1 where heights grow against the axis: the hole leads towards greater coordinates.
    """

    ip: Interpreter
    block: Block
    normal: int
    retract: float
    bottom: float
    clear: float
    words: dict[str, float]
    spindle: int
    up: float = 1.0

    def _moved(self, changes: dict[int, float]) -> list[float]:
        end = self.ip.state.position.copy()
        for column, value in changes.items():
            end[column] = value
        self.ip.state.position = end
        return end

    def unscaled(self, length: float, column: int) -> float:
        """Return a length of the cycle's own in programmed coordinates: steps and clearances are not scaled (Haas 96-8000, G51)."""
        factor = getattr(self.ip.sink, "factor", None)
        return length / factor(column) if factor else length

    @property
    def clearance(self) -> float:
        """How far from the last depth a peck begins."""
        return self.unscaled(PECK_CLEARANCE[self.ip.state.inches], self.normal)

    def across(self, changes: dict[int, float]) -> None:
        """Traverse on the axes given by column."""
        self.ip.sink.straight_traverse(self._moved(changes))

    def traverse(self, level: float) -> None:
        """Traverse along the normal."""
        self.across({self.normal: self.up * level})

    def feed(self, level: float) -> None:
        """Feed along the normal."""
        check_feed(self.ip, self.block, f"G{self.ip.state.motion / 10:g}")
        self.ip.sink.straight_feed(self._moved({self.normal: self.up * level}))

    def dwell(self) -> None:
        """Wait for P seconds."""
        wait(self.ip, self.words["p"])

    def wait(self) -> None:
        """Wait for P, where it is given."""
        if self.words["p"] > 0.0:
            self.dwell()

    def turn(self, direction: int) -> None:
        """Start or stop the spindle; the direction in force before the cycle stays noted."""
        speed = self.ip.state.speed
        self.ip.sink.set_spindle(speed, direction)
        event = Event("spindle", True, values={"speed_rpm": speed, "direction": direction})
        self.ip.sink.call(f"{TURNS[direction]}({self.spindle})", event)

    def stop(self) -> None:
        """Stop for the operator, who takes the tool out."""
        self.ip.sink.call("PROGRAM_STOP()", Event("stop", True, values={"kind": "retract by hand"}))


def wait(ip: Interpreter, seconds: float) -> None:
    """Wait within a cycle."""
    ip.sink.call(f"DWELL({seconds:.4f})", Event("dwell", True, seconds))


# The moves of each cycle from R on.


@dataclass(frozen=True, slots=True)
class HoleMoves:
    """A cycle of straight moves by letters, which the kernel `gcode_motion` makes too.

    B is the bottom, R, C where the tool clears, L the level of a peck, K a clearance above it; capital letters are feeds, small ones
    traverses; p waits for P. Of FANUC's cycles w waits for P where it is given, 0 stops the spindle, 1 starts it, ! stops the program.

    Attributes:
        last: Moves of the hole.
        between: Moves of each step of Q before that; none without Q.
    """

    last: str
    between: str = ""

    def __call__(self, hole: Hole) -> None:
        if self.between:
            step = hole.unscaled(hole.words["q"], hole.normal)
            if (hole.retract - hole.bottom) / step > MAX_PECKS:
                message = f"Q{step:g} makes more than {MAX_PECKS} steps of one hole"
                raise BlockError("cycle-peck", message, "Q")
            level = hole.retract - step
            while level > hole.bottom:
                self._go(hole, self.between, level)
                level -= step
        self._go(hole, self.last, hole.bottom)

    @staticmethod
    def _go(hole: Hole, moves: str, level: float) -> None:
        above = level + hole.clearance
        places = {"b": hole.bottom, "r": hole.retract, "c": hole.clear, "l": level, "k": above}
        for move in moves:
            if move == "p":
                hole.dwell()
            elif move == "w":
                hole.wait()
            elif move in "01":
                hole.turn(int(move))
            elif move == "!":
                hole.stop()
            elif move.isupper():
                hole.feed(places[move.lower()])
            else:
                hole.traverse(places[move])


def _tap(hole: Hole, direction: int) -> None:
    """The tapping cycle of a thread that is cut with the spindle turning in a direction."""
    state, sink = hole.ip.state, hole.ip.sink
    number = f"G{state.motion / 10:g}"
    if state.direction != direction:
        is_ = "stands still" if state.direction == 0 else "turns the other way"
        needed = "M3" if direction > 0 else "M4"
        raise BlockError("cycle-spindle", f"the spindle {is_}: {number} needs {needed}", number)
    sink.call("DISABLE_FEED_OVERRIDE()")
    sink.call("DISABLE_SPEED_OVERRIDE(0)")
    hole.feed(hole.bottom)
    hole.turn(0)
    hole.turn(-direction)
    hole.dwell()
    hole.feed(hole.clear)
    hole.turn(0)
    hole.turn(direction)
    if state.feed_override:
        sink.call("ENABLE_FEED_OVERRIDE()")
    if state.speed_override:
        sink.call("ENABLE_SPEED_OVERRIDE(0)")


def _check_turning(hole: Hole) -> int:
    direction = hole.ip.state.direction
    if direction == 0:
        number = f"G{hole.ip.state.motion / 10:g}"
        raise BlockError("cycle-spindle", f"the spindle stands still: {number} needs M3 or M4", number)
    return direction


def _bore_stop(hole: Hole) -> None:
    direction = _check_turning(hole)
    hole.feed(hole.bottom)
    hole.dwell()
    hole.turn(0)
    hole.traverse(hole.clear)
    hole.turn(direction)


def _back_bore(hole: Hole) -> None:
    """Go through the hole beside its centre, bore back up to K, and come out the same way (NISTIR 6556, 3.5.16.9)."""
    direction = _check_turning(hole)
    state = hole.ip.state
    columns = state.plane_axes()
    # Beside the centre on the two axes of the plane, up to along its normal.
    *offset, middle = (hole.words["ijk"[column]] for column in columns)
    if not state.absolute:
        middle += hole.bottom
    centre = {column: state.position[column] for column in columns[:2]}
    beside = {column: state.position[column] + by for column, by in zip(columns[:2], offset, strict=True)}

    def orient() -> None:
        hole.turn(0)
        turn_to(hole.ip, hole.spindle, 0.0, 2 if direction > 0 else 3)

    hole.across(beside)
    orient()
    hole.traverse(hole.bottom)
    hole.across(centre)
    hole.turn(direction)
    hole.feed(middle)
    hole.feed(hole.bottom)
    orient()
    hole.across(beside)
    hole.traverse(hole.clear)
    hole.across(centre)
    hole.turn(direction)


def _bore_by_hand(hole: Hole) -> None:
    """Stop at the bottom: the operator takes the tool out, to where the next move is reckoned from."""
    direction = _check_turning(hole)
    hole.feed(hole.bottom)
    hole.dwell()
    hole.turn(0)
    hole.stop()
    hole.turn(direction)
    hole.ip.state.position[hole.normal] = hole.clear


@dataclass(frozen=True, slots=True)
class Cycle:
    """A cycle: its moves, the words that it needs beside R and the depth, a line of help, words that it takes; whether it taps, and goes aside."""

    run: Callable[[Hole], None]
    needs: str
    help: str
    takes: str = ""
    taps: bool = False
    aside: bool = False


CYCLES = {
    730: Cycle(HoleMoves("Bc", "Lk"), "q", "drill, breaking chips every Q"),
    740: Cycle(partial(_tap, direction=-1), "", "tap, left-hand, with a dwell of P", "p$", taps=True),
    810: Cycle(HoleMoves("Bc"), "", "drill"),
    820: Cycle(HoleMoves("Bpc"), "p", "drill, dwell for P"),
    830: Cycle(HoleMoves("Bc", "Lrk"), "q", "drill, out of the hole every Q"),
    840: Cycle(partial(_tap, direction=1), "", "tap, right-hand, with a dwell of P", "p$", taps=True),
    850: Cycle(HoleMoves("BRc"), "", "bore, feed out"),
    860: Cycle(_bore_stop, "p", "bore, dwell for P, stop the spindle, traverse out", "$"),
    870: Cycle(_back_bore, "", "back bore: I J beside the centre, up to K", "ijk$", aside=True),
    880: Cycle(_bore_by_hand, "p", "bore, dwell for P, stop for the operator", "$"),
    890: Cycle(HoleMoves("BpC"), "p", "bore, dwell for P, feed out"),
}


def _cycle(ip: Interpreter, block: Block, number: int) -> None:
    sticky = _words_in_force(ip, block, number)
    _check_block(ip, block, number)
    _make_holes(ip, block, number, sticky)


def _words_in_force(ip: Interpreter, block: Block, number: int) -> Sticky:
    """Return the words of this block and those kept from the blocks of the same cycle before it."""
    state = ip.state
    sticky = state.cycle if isinstance(state.cycle, Sticky) else Sticky()
    normal = state.plane_axes()[2]
    if state.motion not in CYCLES:
        sticky = Sticky(level=state.position[normal], dwell=sticky.dwell)
    kept = sticky.words if sticky.number == number else {}
    letters = "rpqijk" + AXES[normal]
    words = {**kept, **block.only(letters)}
    state.cycle = Sticky(number, words, sticky.level, words.get("p", sticky.dwell))
    state.motion = number
    return state.cycle


_MEANINGS = {
    "R": "R is the height that the hole begins at",
    "Q": "Q is the depth of a step, or the way off the wall",
    "P": "P is the dwell",
    **dict.fromkeys("IJK", "I, J and K of G87 are the way beside the centre and the end of the bore"),
}


def _check_block(ip: Interpreter, block: Block, number: int) -> None:
    state, name = ip.state, f"G{number / 10:g}"
    if block.words.keys().isdisjoint("xyzuvw@^"):
        raise BlockError("cycle-words", f"{name} has no axis word", name)
    rotary = next((letter for letter in "abc" if letter in block.words), None)
    if rotary:
        raise BlockError("cycle-rotary", f"{name} cannot turn an axis: {rotary.upper()}", rotary.upper())
    words = state.cycle.words if isinstance(state.cycle, Sticky) else {}
    demand(words, "r" + AXES[state.plane_axes()[2]] + ("ijk" if number == 870 else ""), name)
    check_cycle_feed(ip, block, name)


def demand(words: dict[str, float], needs: str, name: str) -> None:
    """Raise where words are missing."""
    missing = [letter.upper() for letter in needs if letter not in words]
    if missing:
        hint = _MEANINGS.get(missing[0], f"{missing[0]} is the bottom of the hole")
        raise BlockError("cycle-words", f"{name} has no {' and no '.join(missing)}", name, hint=hint)


def check_cut(words: dict[str, float], needs: str, name: str) -> None:
    """Raise where a word of the cut itself is missing or wrong; LinuxCNC finds that when the tool is at R."""
    demand(words, needs, name)
    if words.get("p", 0.0) < 0.0:
        raise BlockError("dwell-negative", f"P{words['p']:g} of {name} is negative", "P")
    if "q" in needs and words["q"] <= 0.0:
        raise BlockError("cycle-peck", f"Q{words['q']:g} of {name} must be greater than 0", "Q")


def repeats(block: Block, letter: str, least: int, slack: float = 0.0) -> int:
    """Return how many holes a block makes; raise where that is no whole number."""
    value = block.words.get(letter, 1.0)
    count = round(value)
    if abs(value - count) > slack or not least <= count <= MAX_REPEATS:
        name = letter.upper()
        message = f"{name}{value:g} must be a whole number from {least} to {MAX_REPEATS}"
        raise BlockError("cycle-repeats", message, name)
    return count


def _hole_of(ip: Interpreter, block: Block, sticky: Sticky) -> Hole:
    """Return the hole that the words make; raise where its bottom is above R."""
    state = ip.state
    normal = state.plane_axes()[2]
    words, level = {"p": sticky.dwell, **sticky.words}, sticky.level
    depth = AXES[normal]
    retract = words["r"] if state.absolute else level + words["r"]
    bottom = words[depth] if state.absolute else retract + words[depth]
    if bottom > retract:
        message = f"the bottom, {depth.upper()} {bottom:.4f}, is above R {retract:.4f}"
        raise BlockError("cycle-depth", message, "R" if "r" in block.words else depth.upper())
    clear = max(level, retract) if state.retract_old else retract
    return Hole(ip, block, normal, retract, bottom, clear, words, max(round(block.words.get("$", 0.0)), 0))


def _make_holes(ip: Interpreter, block: Block, number: int, sticky: Sticky) -> None:
    """Go to R where the tool is below it, then make the holes, with the path exact meanwhile."""
    state = ip.state
    first, second, normal = state.plane_axes()
    hole = _hole_of(ip, block, sticky)
    count = repeats(block, "l", 1, slack=1e-4)
    if sticky.level < hole.retract:
        hole.traverse(hole.retract)
    exact = state.path_mode is PathMode.EXACT_PATH
    if not exact:
        ip.sink.set_motion_control_mode(PathMode.EXACT_PATH, None, None)
    check_cut(sticky.words, CYCLES[number].needs, f"G{number / 10:g}")
    step = block.without(AXES[normal])
    for _ in range(count):
        end = ip.end_point(step)
        high = max(state.position[normal], hole.clear)
        hole.across({first: end[first], second: end[second], normal: high})
        if high != hole.retract:
            hole.traverse(hole.retract)
        CYCLES[number].run(hole)
    state.moved = True
    if not exact:
        path_again(ip)


def path_again(ip: Interpreter) -> None:
    """Put the path mode in force again behind a row of holes, whose path is exact."""
    state = ip.state
    ip.sink.set_motion_control_mode(state.path_mode, state.tolerance, state.naive)
    if state.path_mode is PathMode.EXACT_STOP:
        ip.sink.call(f"SET_NAIVECAM_TOLERANCE({state.naive or 0.0:.4f})")


CODES = tuple(
    Code("G", number, "motion", Stage.MOTION, partial(_cycle, number=number), cycle.help, AXES + "@^rl" + cycle.needs + cycle.takes,
        "motion", dialects=("linuxcnc",), pitched=cycle.taps, moves="plane" if cycle.aside else "",
        waits=isinstance(cycle.run, HoleMoves), refused=IS_CYCLE)
    for number, cycle in CYCLES.items()
)  # fmt: skip

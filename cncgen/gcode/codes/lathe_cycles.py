"""Turning: diameters and radii (G7, G8), and the threading cycle G76.

Source: LinuxCNC's manual, "G7 Lathe Diameter Mode", "G76 Threading Cycle"; the passes were compared with its interpreter.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from functools import partial

from cncgen.gcode.block import Block
from cncgen.gcode.codes.table import SYNCHRONISED, Code
from cncgen.gcode.codes.tools import whole
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.records import dataclass
from cncgen.toolpath.record import Event

MAX_PASSES = 10_000
_X, _Z = 0, 2
_G76 = 760


def _diameter(ip: Interpreter, block: Block, on: bool) -> None:
    state = ip.state
    if state.diameter == on:
        return
    state.diameter = on
    if "x" in block.words:
        block.words["x"] *= 0.5 if on else 2.0
    kind = "diameter" if on else "radius"
    ip.sink.call(f'COMMENT("interpreter: Lathe diameter mode changed to {kind}")')


@dataclass(frozen=True, slots=True)
class Thread:
    """The words of G76, lengths in radius.

    Attributes:
        drive: X of the drive line, where the tool starts.
        start, end: Z of the thread's ends.
        pitch: P.
        peak: I, from the drive line to the thread's peak; negative outside, positive inside.
        first, full: J and K, depth of the first pass and of the thread.
        degression: R: pass n is first·n^(1/R) deep.
        flank: Tangent of the slide angle Q.
        springs: H, passes at full depth beyond the first.
        taper: E, length of the tapers along Z (0: none).
        entry, exit: Which ends have the taper.
    """

    drive: float
    start: float
    end: float
    pitch: float
    peak: float
    first: float
    full: float
    degression: float
    flank: float
    springs: int
    taper: float
    entry: bool
    exit: bool

    @property
    def outwards(self) -> float:
        """Return the sign of X away from the thread."""
        return 1.0 if self.peak < 0.0 else -1.0

    @property
    def direction(self) -> float:
        """Return the sign of Z along the cut."""
        return 1.0 if self.end > self.start else -1.0

    def depths(self, digit: float) -> Iterator[float]:
        """Yield the depth of each pass.

        As in LinuxCNC the last digit may decide whether a multiple of J comes before K: `digit` is its value.
        """
        depth, count = self.first, 1
        while self.full - depth > digit:
            yield depth
            count += 1
            depth = self.first * count ** (1.0 / self.degression)
        for _ in range(1 + self.springs):
            yield self.full


def thread(ip: Interpreter, block: Block) -> None:
    """G76 P Z I J K R Q H E L: the passes, then to the end of the drive line (or to X and Y, where given)."""
    cut = _read(ip, block)
    end = ip.end_point(block)
    ip.state.motion = _G76
    # J and K are compared as they are written, diameters too.
    for depth in cut.depths(sys.float_info.epsilon * (0.5 if ip.state.diameter else 1.0)):
        _pass(ip, cut, depth)
    ip.go(end, rapid=True)


def _check(ip: Interpreter, words: dict[str, float], half: float) -> None:
    """Raise where a word of G76 is missing or wrong, or the spindle stands; `half` makes radii of I J K."""
    missing = [letter.upper() for letter in "pzijk" if letter not in words]
    if missing:
        hint = "G76 with B or C is of Mach3 Turn, and not read" if {"b", "c"} & words.keys() else ""
        raise BlockError("thread-words", f"G76 has no {' and no '.join(missing)}", "G76", hint=hint)
    peak, first, full = (words[letter] * half for letter in "ijk")
    tests = (
        (words["p"] < 0.0, "P", "the pitch", "is negative"),
        (peak == 0.0, "I", "the distance to the thread's peak", "is 0"),
        (first <= 0.0, "J", "the depth of the first pass", "must be above 0"),
        (full <= first, "K", "the full depth", f"must be above the depth of the first pass, J{words['j']:g}"),
    )
    for wrong, letter, what, how in tests:
        if wrong:
            raise BlockError("thread-words", f"{what}, {letter}{words[letter.lower()]:g}, {how}", letter)
    if any(letter in words for letter in "abcuvw"):
        letter = next(letter for letter in "abcuvw" if letter in words).upper()
        raise BlockError("thread-words", f"G76 moves X and Z only, not {letter}", letter)
    if ip.state.direction == 0:
        raise BlockError("spindle-stopped", "G76 cuts in step with a spindle that does not turn", "G76")


def _read(ip: Interpreter, block: Block) -> Thread:
    """Return the thread of G76's words; raise where they make none."""
    state, words = ip.state, block.words
    half = 0.5 if state.diameter else 1.0
    _check(ip, words, half)
    peak, first, full = (words[letter] * half for letter in "ijk")
    degression = words.get("r", 1.0)
    if degression < 1.0:
        ip.warn("thread-degression", f"R{degression:g} of G76 is below 1: taken as 1", "R")
    springs = whole(block, "h", "G76") if "h" in words else 0
    # The root of the count, since a power of R4741 is no number any more.
    if springs >= MAX_PASSES or full > first * (MAX_PASSES - springs) ** (1.0 / max(degression, 1.0)):
        raise BlockError("thread-passes", f"G76 makes more than {MAX_PASSES} passes", "J")
    ends = round(words.get("l", 0.0))
    taper = words.get("e", 0.0)
    return Thread(
        drive=state.position[_X],
        start=state.position[_Z],
        end=ip.end_point(block)[_Z],
        pitch=words["p"],
        peak=peak,
        first=first,
        full=full,
        degression=max(degression, 1.0),
        flank=math.tan(math.radians(words.get("q", 0.0))),
        springs=springs,
        taper=max(taper, 0.0),
        entry=taper > 0.0 and ends in (1, 3),
        exit=taper > 0.0 and ends in (2, 3),
    )


def _pass(ip: Interpreter, cut: Thread, depth: float) -> None:
    """Cut once at a depth: along the flank the pass is moved by depth·tan Q."""
    sink = ip.sink
    drive = cut.drive + cut.outwards * (cut.full - depth)
    bottom = cut.drive + cut.peak - cut.outwards * depth
    start = cut.start - cut.flank * depth
    end = cut.end + cut.flank * (cut.full - depth)
    run = cut.direction * cut.taper
    slant = cut.pitch * math.hypot(cut.taper, cut.full) / cut.taper if cut.taper else cut.pitch
    _go(ip, drive, start, rapid=True)
    if not cut.entry:
        _go(ip, bottom, start, rapid=True)
    sink.call("DISABLE_FEED_OVERRIDE()")
    if cut.entry:
        _synchronise(ip, slant)
        _go(ip, drive + cut.peak, start)
        _go(ip, bottom, start + run)
    _synchronise(ip, cut.pitch)
    _go(ip, bottom, end - run if cut.exit else end)
    if cut.exit:
        _synchronise(ip, slant)
        _go(ip, bottom + cut.outwards * cut.full, end)
    sink.synchronise(None)
    sink.call("STOP_SPEED_FEED_SYNCH()")
    _go(ip, drive, end, rapid=True)
    on = {"what": "feed_override", "on": True}
    sink.call("ENABLE_FEED_OVERRIDE()", Event("override", values=on))


def _synchronise(ip: Interpreter, pitch: float) -> None:
    ip.sink.call(f"START_SPEED_FEED_SYNC({pitch:f},0)")
    ip.sink.synchronise(pitch)


def _go(ip: Interpreter, x: float, z: float, *, rapid: bool = False) -> None:
    end = ip.state.position.copy()
    end[_X], end[_Z] = x, z
    ip.go(end, rapid=rapid)


CODES = (
    Code("G", 70, "diameter", Stage.DIAMETER, partial(_diameter, on=True), "X is a diameter", dialects=("linuxcnc",),
        restores=("diameter", True)),
    Code("G", 80, "diameter", Stage.DIAMETER, partial(_diameter, on=False), "X is a radius", dialects=("linuxcnc",),
        restores=("diameter", False)),
    Code("G", _G76, "motion", Stage.MOTION, thread, "cut a thread of pitch P to Z in passes", "xyzabcuvwpijkrqhel$", "motion",
        dialects=("linuxcnc",), moves="XZ", refused=SYNCHRONISED),
)  # fmt: skip

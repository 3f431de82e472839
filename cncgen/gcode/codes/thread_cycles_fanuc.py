"""G76 of FANUC's lathes: a thread in passes of equal cross section, fed in along one flank (B-64304EN-1, 4.4.7).

Pass n is Δd √n deep, and at least the least depth deeper than the previous pass, until only the finish is left. Then the passes at
full depth follow. P of Haas says so (P1), that passes cut alternately along both flanks (P2), or that pass n is n Δd deep (P3, and P4
along both flanks).
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from cncgen.gcode.block import Block
from cncgen.gcode.codes.lathe_fanuc import (
    DEEP,
    ONLY,
    THREAD_FINISH,
    check_idle,
    check_spindle,
    depth_of,
    increments,
    length_of,
    turning_of,
)
from cncgen.gcode.codes.lathe_words import X, Z
from cncgen.gcode.codes.simple_cycles_fanuc import go, thread_pass
from cncgen.gcode.codes.table import SYNCHRONISED, Code
from cncgen.gcode.codes.tools import whole
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.records import dataclass

_PASSES = 10_000
_TINY = 1e-9
#: Angles that a thread's tool has on this control.
_ANGLES = (0, 29, 30, 55, 60, 80)


def cut(ip: Interpreter, block: Block) -> None:
    """G76 P Q R sets how threads are cut; G76 X Z R P Q F cuts one."""
    if block.words.keys() & set("xz"):
        _cut(ip, block)
    else:
        _set(ip, block)


def _set(ip: Interpreter, block: Block) -> None:
    """Take P (passes at full depth, chamfer in tenths of the lead, angle: two digits each), Q and R."""
    kept, words = turning_of(ip), block.words
    check_idle(ip, block, "G76", "pqr", "before the block with X and Z it takes P, Q and R")
    if "p" in words:
        digits = whole(block, "p", "G76")
        kept.passes, kept.chamfer, kept.angle = digits // 10_000, digits // 100 % 100, float(digits % 100)
        if kept.passes == 0 and kept.angle in _ANGLES:
            kept.passes = 1
            message, hint = f"P{digits:06d} of G76 counts no last passes: one is made", "P01… says so"
            ip.warn_once("thread-words", message, "P", hint)
        if not 1 <= kept.passes <= 99 or kept.angle not in _ANGLES:
            angles = ", ".join(f"{angle:02d}" for angle in _ANGLES)
            message = (
                f"P{digits:06d} of G76 is not passes (01 to 99), chamfer, angle ({angles}), two digits each"
            )
            hint = "P011060: one pass at full depth, a chamfer of one lead, a tool of 60 degrees"
            raise BlockError("thread-words", message, "P", hint=hint)
    if "q" in words:
        kept.least = abs(increments(ip, block, "q"))
    if "r" in words:
        kept.finish = abs(length_of(ip, block, "r", "G76", THREAD_FINISH))


@dataclass(frozen=True, slots=True)
class _Depths:
    """Height of a thread and the depths of its passes."""

    full: float
    first: float
    least: float
    finish: float
    last: int
    even: bool

    def __iter__(self) -> Iterator[float]:
        rough, depth, count = self.full - self.finish, 0.0, 1
        while depth < rough - _TINY:
            steps = count if self.even else math.sqrt(count)
            depth = min(max(self.first * steps, depth + self.least), rough)
            count += 1
            yield depth
        # Without a finish the last pass was one at full depth.
        for _ in range(self.last if self.finish else self.last - 1):
            yield self.full


@dataclass(frozen=True, slots=True)
class _Thread:
    """Where a thread ends at its root, in radius, and how it is cut."""

    x: float
    z: float
    lead: float
    taper: float
    angle: float
    zigzag: bool
    depths: _Depths


def _thread_of(ip: Interpreter, block: Block) -> _Thread:
    """Return the thread of a block: P its height, Q the first depth (of Haas K, D and the angle A), R (I) its taper, F its lead."""
    words, kept = block.words, turning_of(ip)
    of_haas = "k" in words
    hint = "the cycle of Haas takes K D I A P; that of FANUC takes P Q R"
    check_idle(ip, block, "G76", "kdiap" if of_haas else "pqr", hint)
    way = whole(block, "p", "G76") if of_haas and "p" in words else 1
    high, first = ("k", "d") if of_haas else ("p", "q")
    missing = [letter.upper() for letter in ("x", "z", high, first, "f") if letter not in words]
    if missing:
        hint = "G76 X18.2 Z-20 P920 Q250 F1.5: height and first depth in least increments"
        raise BlockError("thread-words", f"G76 has no {' and no '.join(missing)}", "G76", hint=hint)
    if of_haas:
        sizes = [length_of(ip, block, "k", "G76", DEEP), depth_of(ip, block, "G76")]
    else:
        sizes = [increments(ip, block, letter) for letter in "pq"]
    depths = _Depths(sizes[0], sizes[1], kept.least, kept.finish, kept.passes, way in (3, 4))
    slope, angle = "i" if of_haas else "r", words.get("a", kept.angle)
    taper = length_of(ip, block, slope, "G76", DEEP) if slope in words else 0.0
    start_x, start_z = ip.state.position[X], ip.state.position[Z]
    high, first = high.upper(), first.upper()
    many = min(depths.full / max(depths.first, _TINY), 1e9) ** 2 > _PASSES
    tests = (
        (depths.full <= 0.0, high, f"its height, {high}, is {depths.full:g}: it must be above 0"),
        (depths.first <= 0.0, first, f"its first depth, {first}, is {depths.first:g}: it must be above 0"),
        (not 1 <= way <= 4, "P", f"P{way} is none of its ways to feed in, P1 to P4"),
        (words["f"] <= 0.0, "F", f"its lead is F{words['f']:g}: it must be above 0"),
        (not 0.0 <= angle < 180.0, "A", f"its tool has an angle of {angle:g} degrees"),
        (depths.finish >= depths.full, high, f"the finish, R{depths.finish:g}, leaves nothing of its height {depths.full:g}"),
        (many and depths.least < depths.full / _PASSES, first, f"{first}{depths.first:g} makes more than {_PASSES} passes"),
        (start_x == words["x"], "X", "the tool stands on its root, which does not say on which side it is cut"),
        (words["z"] == start_z, "Z", "it has no length along Z"),
    )  # fmt: skip
    for wrong, letter, what in tests:
        if wrong:
            message = f"the thread of G76: {what}"
            raise BlockError("thread-words", message, letter, hint="lengths are in radius")
    root = words["x"]
    if abs(start_x - root) < depths.full - _TINY:
        crest = root + math.copysign(depths.full, start_x - root)
        message = f"G76 begins at radius {start_x:g}, within the thread from {crest:g} to {root:g}: it comes back there after each pass"
        ip.warn_once("thread-words", message, high, f"begin beyond the crest; {high} is the height in radius")
    return _Thread(words["x"], words["z"], words["f"], taper, angle, way in (2, 4), depths)


def _cut(ip: Interpreter, block: Block) -> None:
    thread, chamfer = _thread_of(ip, block), 0.1 * turning_of(ip).chamfer
    check_spindle(ip, "G76")
    start_x, start_z = ip.state.position[X], ip.state.position[Z]
    side = 1.0 if start_x > thread.x else -1.0
    flank = math.copysign(math.tan(math.radians(thread.angle / 2.0)), thread.z - start_z)
    for count, depth in enumerate(thread.depths):
        # Every second pass of a zigzag is as far beyond the place of the last one as those along one flank are before it.
        across = 2.0 * thread.depths.full - depth if thread.zigzag and count % 2 else depth
        x, z = thread.x + side * (thread.depths.full - depth), start_z + flank * across
        go(ip, start_x, z, False)
        go(ip, x + thread.taper, z, False)
        # A pass outside of where the cycle began cuts nothing that it could leave at a slant.
        outside = side * (x - start_x) >= 0.0
        thread_pass(ip, x, thread.z, thread.lead, 0.0 if outside else chamfer * thread.lead, start_x)
        go(ip, start_x, thread.z, False)
    go(ip, start_x, start_z, False)


CODES = (
    Code("G", 760, "non-modal", Stage.MOTION, cut, "cut a thread of height P and lead F in passes; first P Q R alone (Haas: K D A P)",
        "xzuwrpqfkdia", "own", dialects=ONLY, takes="f", moves="XZ", refused=SYNCHRONISED),
)  # fmt: skip

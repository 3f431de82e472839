"""G76 of FANUC's lathes: a thread in passes of equal cross section, fed in along one flank (B-64304EN-1, 4.4.7).

Pass n is Δd √n deep, at least the least depth more than the one before it, until what the finish takes is left; then
the passes at full depth follow.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from cncgen.gcode.block import Block
from cncgen.gcode.codes.lathe_fanuc import ONLY, check_spindle, increments, turning_of
from cncgen.gcode.codes.lathe_words import X, Z
from cncgen.gcode.codes.simple_cycles_fanuc import go, thread_pass
from cncgen.gcode.codes.table import Code
from cncgen.gcode.codes.tools import whole
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage

_PASSES = 10_000
#: Depths that differ by less are equal.
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
    if "p" in words:
        digits = whole(block, "p", "G76")
        kept.passes, kept.chamfer, kept.angle = digits // 10_000, digits // 100 % 100, float(digits % 100)
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
        kept.finish = abs(words["r"])


@dataclass(frozen=True, slots=True)
class _Depths:
    """Height of a thread and what its passes take."""

    full: float
    first: float
    least: float
    finish: float
    last: int

    def __iter__(self) -> Iterator[float]:
        rough, depth, count = self.full - self.finish, 0.0, 1
        while depth < rough - _TINY:
            depth = min(max(self.first * math.sqrt(count), depth + self.least), rough)
            count += 1
            yield depth
        # Without a finish the last pass was one at full depth.
        for _ in range(self.last if self.finish else self.last - 1):
            yield self.full


def _cut(ip: Interpreter, block: Block) -> None:
    """Cut a thread: P its height, Q the first depth (both in radius), R its taper, F its lead."""
    words, kept = block.words, turning_of(ip)
    missing = [letter.upper() for letter in "xzpqf" if letter not in words]
    if missing:
        hint = "G76 X18.2 Z-20 P920 Q250 F1.5: height and first depth in least increments"
        raise BlockError("thread-words", f"G76 has no {' and no '.join(missing)}", "G76", hint=hint)
    check_spindle(ip, "G76")
    depths = _Depths(
        increments(ip, block, "p"), increments(ip, block, "q"), kept.least, kept.finish, kept.passes
    )
    lead, taper = words["f"], words.get("r", 0.0)
    start_x, start_z = ip.state.position[X], ip.state.position[Z]
    root, end = words["x"], words["z"]
    tests = (
        (depths.full <= 0.0, "P", f"its height, P, is {depths.full:g}: it must be above 0"),
        (depths.first <= 0.0, "Q", f"its first depth, Q, is {depths.first:g}: it must be above 0"),
        (lead <= 0.0, "F", f"its lead is F{lead:g}: it must be above 0"),
        (depths.finish >= depths.full, "P", f"the finish, R{depths.finish:g}, leaves nothing of its height {depths.full:g}"),
        (min(depths.full / max(depths.first, _TINY), 1e9) ** 2 > _PASSES and depths.least < depths.full / _PASSES, "Q",
         f"Q{depths.first:g} makes more than {_PASSES} passes"),
        (abs(start_x - root) < depths.full, "X", "the tool stands inside of it: the cycle begins beside the thread"),
        (end == start_z, "Z", "it has no length along Z"),
    )  # fmt: skip
    for wrong, letter, what in tests:
        if wrong:
            raise BlockError(
                "thread-words", f"the thread of G76: {what}", letter, hint="lengths are in radius"
            )
    side = 1.0 if start_x > root else -1.0
    flank = math.copysign(math.tan(math.radians(kept.angle / 2.0)), end - start_z)
    for depth in depths:
        x = root + side * (depths.full - depth)
        go(ip, start_x, start_z + flank * depth, False)
        go(ip, x + taper, start_z + flank * depth, False)
        thread_pass(ip, x, end, lead, 0.1 * kept.chamfer * lead, start_x)
        go(ip, start_x, end, False)
    go(ip, start_x, start_z, False)


CODES = (
    Code("G", 760, "non-modal", Stage.MOTION, cut, "cut a thread of height P and lead F in passes; first P Q R alone",
         "xzuwrpqf", "own", dialects=ONLY, takes="f"),
)  # fmt: skip

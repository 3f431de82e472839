"""Grooving of FANUC's lathes, step by step: G74 along Z (drilling too), G75 along X (B-64304EN-1, 4.4.5 and 4.4.6)."""

from __future__ import annotations

import math
from functools import partial

from cncgen.gcode.block import Block
from cncgen.gcode.codes.lathe_fanuc import LIFT, ONLY, check_idle, go_to, increments, length_of, turning_of
from cncgen.gcode.codes.lathe_words import X, Z
from cncgen.gcode.codes.lines import check_feed
from cncgen.gcode.codes.table import IS_CYCLE, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage

_MAX_STEPS = 10_000
_PLACE, _STEP = {X: "x", Z: "z"}, {X: "p", Z: "q"}
#: The steps of Haas, which are lengths.
_LENGTH = {X: "i", Z: "k"}


def _places(start: float, end: float, step: float) -> list[float]:
    """Return the places from start to end, a step apart, the end last; step 0: the end alone."""
    count = math.ceil(abs(end - start) / step - 1e-9) if step else 1
    return [start + math.copysign(step * k, end - start) for k in range(1, count)] + [end]


def _step(ip: Interpreter, block: Block, axis: int, way: float, name: str) -> float:
    """Return the step along an axis, 0 where the block has none; raise where it makes too many steps of the way."""
    letter = _LENGTH[axis] if _LENGTH[axis] in block.words else _STEP[axis]
    step = 0.0
    if letter in block.words:
        step = abs(increments(ip, block, letter) if letter == _STEP[axis] else block.words[letter])
    if step and abs(way) / step > _MAX_STEPS:
        message = f"{name} makes more than {_MAX_STEPS} steps of {step:g}"
        hint = "whole numbers count in least increments"
        raise BlockError("cycle-peck", message, letter.upper(), hint=hint)
    return step


def _pecking(ip: Interpreter, block: Block, name: str, deep: int, aside: int) -> None:
    """G74 or G75: column of the depth, column of the steps beside it."""
    words, kept = block.words, turning_of(ip)
    alone = words.keys().isdisjoint("xz")
    used = (
        "r"
        if alone
        else "r" + "".join(_LENGTH[axis] if _LENGTH[axis] in words else _STEP[axis] for axis in (X, Z))
    )
    hint = "R alone is how far it goes back; steps are P and Q of FANUC, or I and K of Haas"
    check_idle(ip, block, name, used, hint)
    if alone:
        if "r" in words:
            kept.back = abs(length_of(ip, block, "r", name, LIFT))
        return
    if _PLACE[deep] not in words:
        letter = _PLACE[deep].upper()
        raise BlockError("cycle-words", f"{name} has no {letter}", name, hint=f"{letter} is the bottom")
    check_feed(ip, block, name)
    start, bottom = ip.state.position, words[_PLACE[deep]]
    side = words.get(_PLACE[aside], start[aside])
    step = _step(ip, block, aside, side - start[aside], name)
    if side != start[aside] and not step:
        hint = "it is how far the cuts are apart, in least increments"
        message = f"{name} has no {_STEP[aside].upper()} for its steps aside"
        raise BlockError("cycle-words", message, name, hint=hint)
    cuts = [start[aside], *(_places(start[aside], side, step) if side != start[aside] else ())]
    peck = _step(ip, block, deep, (bottom - start[deep]) * len(cuts), name)
    relief = math.copysign(words.get("r", 0.0), start[aside] - side)
    for place in cuts:
        go_to(ip, {aside: place}, False)
        _cut(ip, deep, _places(start[deep], bottom, peck), kept.back)
        go_to(ip, {aside: place + relief}, False)
        go_to(ip, {deep: start[deep]}, False)
    go_to(ip, {aside: start[aside]}, False)


def _cut(ip: Interpreter, axis: int, levels: list[float], back: float) -> None:
    """Feed from level to level, and a little back between them."""
    back = math.copysign(back, ip.state.position[axis] - levels[-1])
    for level in levels[:-1]:
        go_to(ip, {axis: level}, True)
        go_to(ip, {axis: level + back}, False)
    go_to(ip, {axis: levels[-1]}, True)


CODES = tuple(
    Code("G", number, "non-modal", Stage.MOTION, partial(_pecking, name=name, deep=deep, aside=aside), text, "xzuwrpqik", "own",
        dialects=ONLY, moves="XZ", refused=IS_CYCLE)
    for number, name, deep, aside, text in (
        (740, "G74", Z, X, "groove or drill along Z in steps of Q, cuts P apart; R alone: how far it goes back"),
        (750, "G75", X, Z, "groove along X in steps of P, cuts Q apart; R alone: how far it goes back"),
    )
)  # fmt: skip

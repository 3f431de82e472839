"""Directions of the tool to positions of the rotary axes: TX TY TZ of LN, or the normal of the surface NX NY NZ; spatial angles of TCPM.

"If M128 is active, the TNC maintains the tool perpendicular to the workpiece contour if no tool orientation is programmed in the LN block. If
there is a tool orientation T and M128 (or TCPM) is active, the TNC will position the rotary axes automatically. If you have not activated
M128, the TNC ignores the direction vector T" (iTNC 530, "Face milling: 3-D compensation with and without tool orientation").

Under FUNCTION TCPM AXIS SPAT the words A B C are spatial angles of the tool, in the coordinates in force, which turn as PLANE SPATIAL does.
Under PATHCTRL VECTOR the tool's direction stays in the plane of those at both ends of a line (TNC 640, "FUNCTION TCPM").
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from cncgen.gcode.block import AXES, Block, Own, Value, evaluate
from cncgen.gcode.codes import affine, carried_planes
from cncgen.gcode.codes.plain_language import TIP_MODE, Plain
from cncgen.gcode.codes.tool_vectors import VectorTurn
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.klartext import planes

TOOL, NORMAL = ("tx", "ty", "tz"), ("nx", "ny", "nz")
_ANGLES, _COLUMNS = "abc", (3, 4, 5)
#: Every axis, in bits of the columns.
_ALL = -1
_SHORTEST, _LONGEST = 1260, 1270
_OF_MACHINE = 530


def turn_on(ip: Interpreter, words: tuple[tuple[str, str], ...]) -> None:
    """Take the words of FUNCTION TCPM by twos; none are those of M128; raise where the tool's centre is what the program leads (REFPNT)."""
    plain = Plain.of(ip)
    unread = next((word for word in words if word[0] == "REFPNT" and word[1] != "TIP-TIP"), None)
    if unread:
        message = f"{' '.join(unread)} of FUNCTION TCPM is not read: it needs the radius of the tool's corner"
        hint = "REFPNT TIP-TIP, or none, leads the tip"
        raise BlockError("unsupported-block", message, "FUNCTION", hint=hint)
    if ("F", "CONT") in words:
        message = "F CONT of FUNCTION TCPM is read as F TCP: F is the feed of the tip on the workpiece"
        ip.warn_once("feed-function", message, "FUNCTION", "the path is not changed by it")
    plain.spatial = [0.0, 0.0, 0.0] if ("AXIS", "SPAT") in words else None
    plain.vector = ("PATHCTRL", "VECTOR") in words


def _is_followed(ip: Interpreter) -> bool:
    """Tell whether the tip goes where the program says."""
    return ip.state.length_code == TIP_MODE


def is_plain(ip: Interpreter) -> bool:
    """Tell whether rotary words are positions of axes that turn evenly."""
    plain = Plain.of(ip)
    if plain.shortest or any(plain.turns.values()):
        return False
    return not _is_followed(ip) or (plain.spatial is None and not plain.vector)


def count_turns(ip: Interpreter, block: Block, marks: Mapping[str, Value]) -> None:
    """Take positions of rotary axes as they are displayed, below 360 degrees: by the shorter way under M126, else from the display on.

    M94 counts the display from 0 on again. (TNC 640, "Shortest-path traverse of rotary axes: M126", "Reducing display of a rotary axis to a
    value less than 360 degrees: M94")
    """
    plain, place = Plain.of(ip), ip.state.position
    if not {_SHORTEST, _LONGEST}.isdisjoint(block.m):
        plain.shortest = _SHORTEST in block.m
    if "M94" in marks:
        named = round(evaluate(marks["M94"], ip.parameters)) or _ALL
        plain.turns |= {k: math.floor(place[k] / 360.0) for k in _COLUMNS if named >> k & 1}
    if _is_followed(ip) and plain.spatial is not None:
        return
    kinematics = ip.options.kinematics
    tilts = kinematics.axes[kinematics.tilting] if kinematics else -1
    for letter, column in zip(_ANGLES, _COLUMNS, strict=True):
        if letter not in block.words or f"I{letter.upper()}" in marks:
            continue
        said, turns = block.words[letter], plain.turns.get(column, 0)
        if plain.shortest and column != tilts:
            near = round((place[column] - said) / 360.0)
            if near != turns:
                _tell_way(ip, letter.upper(), place[column], said, 360.0 * near)
            turns = plain.turns[column] = near
        if turns:
            # The sign of 0 stays as arrays leave it.
            block.words[letter] = said + 360.0 * turns


def _tell_way(ip: Interpreter, name: str, at: float, said: float, turns: float) -> None:
    message = f"M126: {name} turns from {at:g} to {said + turns:g}, the shorter way to {said:g}: its display is taken to count from 0 to 360"
    hint = "M127 ends it; an axis that the machine bounds goes the other way on the control"
    ip.note_once("rotary-display", message, name, hint)


def take(ip: Interpreter, block: Block, marks: Mapping[str, Value]) -> None:
    """Take the direction of a block as positions of the rotary axes: the nearer of the two pairs.

    Raises:
        BlockError: The direction has no length, stands beside a rotary axis, or the machine's axes do not reach it.
    """
    if _is_followed(ip) and Plain.of(ip).spatial is not None and _OF_MACHINE not in block.g:
        _take_angles(ip, block, marks)
    given = {name: block.words.pop(name) for name in (*TOOL, *NORMAL) if name in block.words}
    if not given or not (_is_followed(ip) or Own.TIP in block.g):
        return
    names = TOOL if given.keys() & {*TOOL} else NORMAL
    x, y, z = (given.get(name, 0.0) for name in names)
    if math.hypot(x, y, z) == 0.0:
        message = f"the direction of the tool, {names[0].upper()}, has no length"
        raise BlockError("orientation-vector", message, names[0].upper(), hint="TX+0 TY+0 TZ+1 is along Z")
    if (x or y) and (ip.state.compensation != 40 or {410, 420} & {*block.g}) and 400 not in block.g:
        message = "RL and RR of LN shift the tool square to its direction (peripheral milling in space), which is not read"
        hint = "R0, and the points of the tool's centre"
        raise BlockError("tcp-refused", message, names[0].upper(), hint=hint)
    _point(ip, block, (x, y, z), names[0].upper())


def _take_angles(ip: Interpreter, block: Block, marks: Mapping[str, Value]) -> None:
    """Take A B C of a block as spatial angles; one that is left out stays."""
    spatial = Plain.of(ip).spatial
    named = [letter for letter in _ANGLES if letter in block.words]
    if spatial is None or not named:
        return
    step = next((f"I{letter}" for letter in "ABC" if f"I{letter}" in marks), None)
    if step:
        message = f"{step} under AXIS SPAT, an increment of a spatial angle, is not read"
        raise BlockError("unsupported-block", message, step, hint=f"{step[1]} is the angle itself")
    for letter in named:
        spatial[_ANGLES.index(letter)] = block.words.pop(letter)
    a, b, c = spatial
    _point(ip, block, carried_planes.normal_of(planes.spatial((a, b, c)) or affine.UNIT), named[0].upper())


def _point(ip: Interpreter, block: Block, direction: affine.Vector, word: str) -> None:
    """Give a block the positions of the rotary axes at which the tool has a direction of the program's coordinates."""
    kinematics = ip.options.kinematics
    if kinematics is None:
        # M128 has said that no kinematics are known.
        return
    if isinstance(ip.sink, affine.AffineSink):
        direction = affine.applied(ip.sink.program.matrix, direction)
    block.words |= carried_planes.toward(ip, kinematics, direction, word)


def between(ip: Interpreter, block: Block) -> Iterator[Block]:
    """Yield blocks to the ends of the lines, but the last one, that keep the tool's direction in a plane (PATHCTRL VECTOR)."""
    kinematics = ip.options.kinematics
    if kinematics is None or not _is_followed(ip) or not Plain.of(ip).vector:
        return
    if 10 not in block.g or _OF_MACHINE in block.g or ip.state.feed_mode == 93:
        return
    start = ip.state.position.copy()
    end = [block.words.get(letter, at) for letter, at in zip(AXES, start, strict=True)]
    first = carried_planes.positions(ip, kinematics)
    outer, inner = (
        at + end[column] - start[column] for column, at in zip(kinematics.axes, first, strict=True)
    )
    turn = VectorTurn(kinematics, first, (outer, inner))
    named = {*(AXES[column] for column in kinematics.axes), *block.words}
    feed = {"f": block.words["f"]} if "f" in block.words else {}
    for point in turn.between(turn.lines(), start, end):
        yield block.beside(
            {letter: at for letter, at in zip(AXES, point, strict=True) if letter in named} | feed, (10,)
        )

"""Directions of the tool under TRAORI: A3 B3 C3, A2 B2 C2 to positions of the rotary axes, and ORIVECT, which turns the tool in a plane.

A3 B3 C3 is a vector from the tip to the spindle, of any length, in the coordinates of the program (ORIWKS) or of the machine's table
(ORIMKS). Two pairs of positions point the tool there: the nearer one is taken (840D sl, Function Manual, Multi-axis transformations).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from cncgen.gcode.block import AXES
from cncgen.gcode.codes.affine import applied, turn
from cncgen.gcode.codes.carried_planes import unreached
from cncgen.gcode.codes.tool_vectors import VectorTurn
from cncgen.gcode.errors import BlockError
from cncgen.gcode.state.modal import to_machine, zeros
from cncgen.machine.kinematics import Vector

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions, Words
    from cncgen.machine.kinematics import Kinematics

VECTOR = ("A3", "B3", "C3")
#: Angles of the direction, degrees.
ANGLES = ("A2", "B2", "C2")
#: By ORIEULER and ORIRPY: about what axes angles turn the tool from Z on, each about the axis that the ones before have turned (828D, Job
#: planning 07/2010, 6.2 "Three, four and five axis transformation"). C2 of Euler angles turns about the tool.
_TURNS = {"ORIEULER": ((2, "A2"), (0, "B2")), "ORIRPY": ((2, "C2"), (1, "B2"), (0, "A2"))}
#: Words that tell the tool's direction otherwise.
NOT_READ = {
    **dict.fromkeys(("A4", "B4", "C4", "A5", "B5", "C5"), "a normal of the surface"),
    **dict.fromkeys(("A6", "B6", "C6", "A7", "B7", "C7", "NUT", "XH", "YH", "ZH"), "a turn of the tool on a cone"),
    **dict.fromkeys(("LEAD", "TILT", "THETA"), "an angle of the tool to the path"),
    **dict.fromkeys(("AN3", "BN3", "CN3"), "a second direction of the tool"),
}  # fmt: skip
#: How far lines of the axes may lead the tool off its plane, degrees, without a warning.
_TOLD = 0.1
#: Turns of the rotary axes below which no line leads it farther off, degrees.
_SMALL = 1.0


def _kinematics(motions: Motions) -> Kinematics | None:
    """Return the machine's kinematics where TRAORI is in force and they are known."""
    return motions.ip.options.kinematics if motions.ip.state.length_code == 43.4 else None


def _angles(motions: Motions, at: list[float], kinematics: Kinematics) -> tuple[float, float]:
    """Return the positions of the machine's rotary axes at program coordinates."""
    origin, rotation, g92, _ = motions.ip.state.offsets()
    machine = to_machine(at, origin, rotation, g92, zeros())
    outer, inner = kinematics.axes
    return machine[outer], machine[inner]


def take(motions: Motions, words: Words) -> None:
    """Take A3 B3 C3 or A2 B2 C2 of a block as positions of the rotary axes; a missing component of A3 B3 C3 is 0.

    Raises:
        BlockError: No TRAORI is in force, or the direction has no length or stands beside a rotary axis.
    """
    first = next((name for name in (*VECTOR, *ANGLES) if name in words.named), None)
    if first is None:
        return
    if motions.ip.state.length_code != 43.4:
        message = f"{first} is a direction of the tool, and TRAORI is not in force"
        raise BlockError("unused-word", message, first, hint="TRAORI stands before the first A3 B3 C3")
    direction = _vector(words) if first in VECTOR else _turned(motions, words)
    beside = next((axis for axis in words.axes if axis in "ABC"), None)
    if beside or math.hypot(*direction) == 0.0:
        what = f"stands beside {beside}" if beside else "has no length"
        x, y, z = direction
        message = f"the direction of the tool, A3={x:g} B3={y:g} C3={z:g}, {what}"
        raise BlockError("orientation-vector", message, first, hint="A3=0 B3=0 C3=1 is along Z")
    kinematics = _kinematics(motions)
    if kinematics is None:
        return
    if not motions.machine_vectors:
        direction = applied(motions.frames.whole().matrix, direction)
        direction = applied(turn(2, motions.ip.state.rotation), direction)
    position = motions.ip.state.position
    now = _angles(motions, position, kinematics)
    found = kinematics.angles_of(direction, now)
    if found is None:
        raise unreached(kinematics, first)
    for column, before, angle in zip(kinematics.axes, now, found, strict=True):
        words.axes[AXES[column].upper()] = "AC", position[column] + angle - before


def _vector(words: Words) -> Vector:
    x, y, z = (words.named.pop(name, ("", 0.0))[1] for name in VECTOR)
    return x, y, z


def _turned(motions: Motions, words: Words) -> Vector:
    """Return the direction of A2 B2 C2; raise where one of them is missing, or they are of other axes (ORIVIRT1, ORIVIRT2, ORIRPY2)."""
    turns = _TURNS.get(motions.angles or "ORIEULER")
    given = {name: words.named.pop(name)[1] for name in ANGLES if name in words.named}
    missing = next((name for _, name in turns or () if name not in given), None)
    if turns is None or missing:
        what = (
            f"{missing} is missing" if turns else f"{motions.angles} counts them about axes of machine data"
        )
        message = f"{' '.join(given)}, angles of the tool: {what}"
        hint = "A3= B3= C3= say the direction without doubt"
        raise BlockError("not-read", message, next(iter(given)), hint=hint)
    if not motions.angles:
        message = "A2 B2 C2 are read as Euler angles: neither ORIEULER nor ORIRPY stands before them"
        motions.ip.warn_once("orientation-angles", message, "A2", "machine data 21100 of the control decides")
    direction = [0.0, 0.0, 1.0]
    for axis, name in reversed(turns):
        c, s = math.cos(math.radians(given[name])), math.sin(math.radians(given[name]))
        p, q = (axis + 1) % 3, (axis + 2) % 3
        direction[p], direction[q] = c * direction[p] - s * direction[q], s * direction[p] + c * direction[q]
    return direction[0], direction[1], direction[2]


def lines(motions: Motions, given: dict[str, float]) -> Iterator[dict[str, float]]:
    """Yield the ends of lines of the axes that make one block: several where ORIVECT turns the tool in a plane meanwhile."""
    kinematics = _kinematics(motions)
    start = motions.ip.state.position.copy()
    if kinematics is None or motions.motion != "G1" or not _turns(start, given, kinematics):
        yield given
        return
    end = [given.get(AXES[k], value) for k, value in enumerate(start)]
    if motions.turning == "axes":
        yield given
        return
    turn = VectorTurn(kinematics, _angles(motions, start, kinematics), _angles(motions, end, kinematics))
    count = turn.lines() if motions.turning == "plane" and motions.ip.state.feed_mode != 93 else 1
    named = {*given, *(AXES[column] for column in kinematics.axes)}
    for point in turn.between(count, start, end):
        yield {axis: point[AXES.index(axis)] for axis in AXES if axis in named}
    off = turn.off(count)
    if off > _TOLD:
        message = f"the rotary axes turn evenly, which leads the tool up to {off:.2g} degrees off the plane of its two directions"
        hint = "ORIAXES says that they do, ORIVECT (with G94) that the tool stays in the plane"
        motions.ip.warn_once("orientation-path", message, hint=hint)
    yield given


def _turns(start: list[float], given: dict[str, float], kinematics: Kinematics) -> bool:
    return sum(abs(given.get(AXES[k], start[k]) - start[k]) for k in kinematics.axes) > _SMALL

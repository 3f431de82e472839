"""How the machine's rotary axes go to a tilted plane: MOVE, TURN or STAY of PLANE, SEQ, SYM, COORD ROT and TABLE ROT, F and ABST of cycle 19.

TNC 640, "PLANE function", "Specifying the positioning behavior": MOVE turns the axes and keeps the tool's tip, or a point DIST below it, on
the workpiece; TURN turns them alone; after STAY the program does it, by Q120 (A) to Q122 (C). SEQ+ takes the pair of positions where
the axis that tilts the tool is above 0, SEQ- below; without it the shorter way counts. Where the tool is along the other axis, COORD ROT, the
usual one, leaves that where it is, and TABLE ROT turns it by the plane's angle.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cncgen.gcode.block import Value
from cncgen.gcode.codes import affine, carried_planes, tool_point
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.text.plain_language import Raw, called_feed
from cncgen.machine.kinematics import Kinematics
from cncgen.records import dataclass


@dataclass(frozen=True, slots=True)
class Turning:
    """How the rotary axes go to a plane.

    Attributes:
        how: ``MOVE``, ``TURN`` or ``STAY``.
        feed: F, 0 in traverse.
        below: How far below the tip the point lies that MOVE keeps on the workpiece.
        back: Retraction along Z before; infinite for MB MAX.
        sign: Of the axis that tilts the tool, 0 where the shorter way counts.
        table: Whether the axis along the tool turns by the plane's angle.
    """

    how: str = "STAY"
    feed: float = 0.0
    below: float = 0.0
    back: float = 0.0
    sign: int = 0
    table: bool = False


#: The words that say it.
WORDS = frozenset(
    ("MOVE", "TURN", "STAY", "DIST", "ABST", "F", "FMAX", "FAUTO", "MAX", "AUTO", "MB", "SEQ±", "SYM±", "COORD", "TABLE", "ROT")
)  # fmt: skip


def words_of(words: Sequence[Raw], now: Callable[[Value], float]) -> Turning:
    """Return what a PLANE block says of it; `now` gives the present value of a word."""
    names = [name for name, _ in words]
    given = {name: now(value) for name, value in words if value == value}
    if "FAUTO" in names or names[-2:] == ["F", "AUTO"]:
        given["F"] = now(called_feed)
    retracts = "MB" in names and "MB" not in given and names[names.index("MB") + 1 :][:1] == ["MAX"]
    return Turning(
        next((name for name in names if name in ("MOVE", "TURN", "STAY")), "STAY"),
        given.get("F", 0.0),
        given.get("DIST", given.get("ABST", 0.0)),
        float("inf") if retracts else given.get("MB", 0.0),
        round(given.get("SEQ±", given.get("SYM±", 0.0))),
        "TABLE" in names,
    )


def axes_of(
    ip: Interpreter, kinematics: Kinematics, matrix: affine.Matrix, wanted: Turning
) -> affine.Positions:
    """Return the positions of the rotary axes at which the tool is square to a plane; raise where the axes do not turn the tool there."""
    now = carried_planes.positions(ip, kinematics)
    along = carried_planes.turn_in_plane(matrix) if wanted.table else None
    pairs = kinematics.pairs_of(carried_planes.normal_of(matrix), now, along)
    tilt = kinematics.tilting
    signed = [pair for pair in pairs if round(pair[tilt], 6) * wanted.sign >= 0.0]
    if not signed:
        message = "the rotary axes of the machine do not turn the tool square to the plane"
        hint = "SEQ and SYM choose one of two pairs; [kinematics] names the axes"
        raise BlockError("orientation-vector", message, "PLANE", hint=hint)
    return min(signed, key=lambda pair: round(abs(pair[0] - now[0]) + abs(pair[1] - now[1]), 6))


def turn(ip: Interpreter, kinematics: Kinematics, axes: affine.Positions, wanted: Turning) -> None:
    """Turn the rotary axes to positions of the machine, as MOVE or TURN has it."""
    if wanted.how == "STAY":
        return
    if wanted.back == float("inf"):
        message = "MB MAX of PLANE is passed over: where the travel ends is not known here"
        ip.note_once("retract-unknown", message, "MB", "MB 50 retracts by 50")
    elif wanted.back:
        _execute(ip, {"z": ip.state.position[2] + wanted.back}, 0)
    follows = wanted.how == "MOVE" and ip.state.length_code != affine.FOLLOWED
    if follows:
        code, offset = ip.state.length_code, list(ip.state.tool_offset)
        tool_point.begin(ip, offset[2] + wanted.below, "PLANE")
    feed = ip.state.feed
    steps = carried_planes.words(ip, kinematics, axes)
    if wanted.feed > 0.0:
        _execute(ip, {**steps, "f": wanted.feed}, 10)
        ip.sink.set_feed_rate(feed)
        ip.state.feed = feed
    else:
        _execute(ip, steps, 0)
    if follows:
        tool_point.end(ip, code, offset)


def _execute(ip: Interpreter, words: dict[str, float], code: int) -> None:
    """Execute a block of the interpreter's codes, at the line in progress."""
    ip.execute(ip.base.block.beside(words, (code,)))

"""G2 and G3: arcs and helices by centre (I J K) or radius (R), with turns (P, on FANUC's controls L of G90).

Source: Kramer et al. (2000), section 3.5.3; turns as in LinuxCNC's manual, "G2, G3", and as FANUC's spiral interpolation counts them
(B-63944EN/02, 4.7: four turns and a quarter are L5). Runs of plain blocks are interpreted by the kernel `gcode_motion` to the same effect.
"""

from __future__ import annotations

import math
from functools import partial

from cncgen.gcode.block import AXES, Block
from cncgen.gcode.budget import LINE
from cncgen.gcode.codes.lines import check_feed, feed, has_axis
from cncgen.gcode.codes.table import BOTH, Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import (
    CENTRE_FACTOR,
    CENTRE_RELATIVE,
    CENTRE_TOLERANCE,
    RADIUS_TOLERANCE,
)
from cncgen.gcode.state.modal import Stage, swept
from cncgen.kernels.arc_centres import centre_from_radius

_OFFSETS = "ijk"
_POLAR = {"@", "^"}
#: The end of CT that lies no farther beside the direction before it makes no arc, mm.
_STRAIGHT = 1e-9


def tangent_centre(
    begin: complex, way: complex | None, finish: complex, before: str, hints: tuple[str, str]
) -> tuple[complex, int]:
    """Return the centre and the sense of CT, the arc from one place to another that leaves it in a direction.

    Args:
        begin: Where it begins.
        way: The direction of what is before it, if there is anything.
        finish: Where it ends.
        before: The name of the element before it.
        hints: Help where it has no direction, and where it is straight.
    """
    if not way:
        message = f"CT has no {before} before it whose direction it goes on in"
        raise BlockError("arc-tangent", message, "CT", hint=hints[0])
    way, chord = way / abs(way), finish - begin
    aside = (way.conjugate() * chord).imag
    if abs(aside) < _STRAIGHT:
        message = f"CT goes straight on: its end lies in the direction of the {before} before"
        raise BlockError("arc-tangent", message, "CT", hint=hints[1])
    return begin + 1j * way * abs(chord) ** 2 / (2.0 * aside), 1 if aside > 0.0 else -1


def _arc(ip: Interpreter, block: Block, clockwise: bool) -> None:
    """G2, G3."""
    state = ip.state
    name = "G2" if clockwise else "G3"
    state.motion = 20 if clockwise else 30
    words = block.words
    if "l" in words and not state.absolute:
        _repeat(ip, block, clockwise, name)
        return
    has_offset = not set(_OFFSETS).isdisjoint(words)
    if not has_offset and "r" not in words:
        _without_centre(ip, block, name)
        return
    if has_offset and "r" in words:
        _radius_counts(ip, name)
    check_feed(ip, block, name)
    turns = _turns(block, name)
    end = ip.end_point(block)
    if "r" in words and ip.dialect == "fanuc" and end == state.position and has_axis(block):
        message = f"{name} with R ends where it starts: an arc of no degrees, which moves nothing"
        ip.warn("arc-end", message, "R", "a full circle has its centre (I J K)")
        return
    if "r" in words:
        x, y = _centre_by_radius(ip, block, end, clockwise, name)
    else:
        x, y = _centre_by_offset(ip, block, name)
        if not _is_round(ip, block, name, _radii(ip, end, (x, y))):
            _line(ip, block)
            return
    if state.feed_mode == 93:
        ip.sink.set_inverse_time(state.feed, _length(ip, end, (x, y), -turns if clockwise else turns))
    ip.sink.arc_feed(end, x, y, -turns if clockwise else turns, state.plane)
    state.position, state.moved = end, True


def _without_centre(ip: Interpreter, block: Block, name: str) -> None:
    """Move straight where neither I J K nor R is there, as FANUC's controls do (parameter CIR, 3403#5 = 0, B-64310EN); raise in other dialects."""
    message = f"{name} has neither a centre (I J K) nor a radius (R)"
    if ip.dialect != "fanuc" or not has_axis(block):
        hint = "I J K lead from the start to the centre; R does not make full circles"
        raise BlockError("arc-centre", message, name, hint=hint)
    hint = (
        f"write G1 for a line; controls with CIR (3403#5) = 1, and Haas's, refuse {name} without I J K and R"
    )
    ip.warn_once("arc-centre", f"{message}: it is a straight line", name, hint)
    _line(ip, block)


def _repeat(ip: Interpreter, block: Block, clockwise: bool, name: str) -> None:
    """Make an arc of G91 L times, as shops write it for Haas's mills (``G91 G3 I-1.5 Z-.104 L5`` goes .52 deep), and say so."""
    from cncgen.gcode.codes.canned_cycles import repeats

    count = repeats(block, "l", 1)
    message = f"L{count} of {name} in G91 makes its arc {count} times, as on Haas's mills"
    hint = f"on FANUC's controls with spiral interpolation it is one arc of {count} turns; G90 with L is beyond doubt"
    if count > 1:
        ip.warn_once("other-control", message, "L", hint)
    once = block.without("l")
    for _ in range(count):
        ip.budget.count(1, LINE)
        _arc(ip, once, clockwise)


def _line(ip: Interpreter, block: Block) -> None:
    """Move straight in place of an arc."""
    motion = ip.state.motion
    feed(ip, block)
    ip.state.motion = motion


def _is_point(ip: Interpreter, at_start: float, at_end: float) -> bool:
    """Tell whether start, end and centre of an arc are the same within a control's resolution, from its radii.

    CAM systems write such arcs. Only LinuxCNC refuses them: grbl makes no segments of them and goes to the end (mc_arc, radii within
    0.005 mm), and FANUC's I J K are 0 in its least increment of 0.001 mm and count as left out (B-64310EN).
    """
    if ip.dialect != "fanuc" and not ip.plain:
        return False
    inches = ip.state.inches
    same = min(at_start, at_end) < RADIUS_TOLERANCE[inches]
    return same and abs(at_start - at_end) <= CENTRE_TOLERANCE[inches]


def _is_round(ip: Interpreter, block: Block, name: str, radii: tuple[float, float]) -> bool:
    """Tell whether an arc with I J K is one, from its radii at start and end: not so small that it is a line; raise where they differ."""
    at_start, at_end = radii
    inches = ip.state.inches
    if _is_point(ip, at_start, at_end) and (at_start or at_end or has_axis(block)):
        unit = "inch" if inches else "mm"
        message = f"{name} of radius {max(at_start, at_end):.2g} {unit} is less than a control resolves: it is a straight line"
        hint = "let the CAM system write lines for arcs so small; LinuxCNC refuses them"
        ip.warn_once("arc-zero-radius", message, name, hint)
        return False
    word = next(letter.upper() for letter in _OFFSETS if letter in block.words)
    hint = "is I J K meant from the start point (G91.1) or as coordinates (G90.1)?"
    if ip.dialect == "sinumerik":
        hint = f"{word} leads from the start point to the centre; as a coordinate it is {word}=AC(...)"
    check_radii(at_start, at_end, inches, word, hint)
    return True


def _radius_counts(ip: Interpreter, name: str) -> None:
    """Say that R counts beside I J K, as on FANUC's controls (B-63324EN, 4.4); raise in other dialects."""
    message = f"{name} has both a centre (I J K) and a radius (R)"
    if ip.dialect != "fanuc":
        raise BlockError("arc-centre", message, "R")
    ip.warn_once("arc-centre", f"{message}: R counts", "R", "write one of them")


def _length(ip: Interpreter, end: list[float], centre: tuple[float, float], turns: int) -> float:
    first, second, normal = ip.state.plane_axes()
    start = ip.state.position
    begin, finish = (complex(at[first] - centre[0], at[second] - centre[1]) for at in (start, end))
    return math.hypot(abs(begin) * swept(begin, finish, turns)[1], end[normal] - start[normal])


def _turns(block: Block, name: str) -> int:
    """Return P, or L of FANUC's controls in G90, the number of turns begun."""
    given = [letter for letter in "pl" if letter in block.words]
    if len(given) > 1:
        message = f"{name} has both P and L, and each is its number of turns"
        raise BlockError("arc-turns", message, "L", hint="write one of them")
    word = given[0].upper() if given else "P"
    value = block.words.get(word.lower(), 1.0)
    if abs(value - round(value)) > 1e-4:
        raise BlockError("not-whole", f"{word}{value:g} of {name} is not a whole number of turns", word)
    if round(value) < 1:
        raise BlockError("arc-turns", f"{word}{value:g} of {name}: an arc begins at least one turn", word)
    return round(value)


def _centre_by_radius(
    ip: Interpreter, block: Block, end: list[float], clockwise: bool, name: str
) -> tuple[float, float]:
    state = ip.state
    first, second, _ = state.plane_axes()
    start = state.position
    radius = block.words["r"]
    letters = (AXES[first], AXES[second])
    if not _POLAR & block.words.keys() and set(letters).isdisjoint(block.words):
        both = " nor ".join(letter.upper() for letter in letters)
        raise BlockError("arc-end", f"{name} with R has neither {both}: its end is not in the plane", name)
    chord = math.hypot(end[first] - start[first], end[second] - start[second])
    if chord == 0.0:
        message = f"{name} with R ends where it starts: every circle of that radius would do"
        raise BlockError("arc-end", message, "R", hint="a full circle needs its centre (I J K)")
    ends = start[first], start[second], end[first], end[second]
    centre = centre_from_radius(*ends, radius, clockwise, RADIUS_TOLERANCE[state.inches])
    if math.isnan(centre.real):
        message = f"R{radius:g} is too small: the end is {chord:.4f} away, and 2 R is {2 * abs(radius):.4f}"
        hint = f"R must be at least {chord / 2:.4f}"
        raise BlockError("arc-radius", message, "R", hint=hint, values={"radius": radius, "chord": chord})
    return centre.real, centre.imag


def _centre_by_offset(ip: Interpreter, block: Block, name: str) -> tuple[float, float]:
    """Return the centre from I J K."""
    state = ip.state
    first, second, normal = state.plane_axes()
    start = state.position
    # I, J and K belong to X, Y and Z (or U, V and W).
    wrong = _OFFSETS[normal % 3]
    # Posts write K0 of arcs in XY, which can mean nothing else; LinuxCNC refuses it.
    if wrong in block.words and (block.words[wrong] != 0.0 or (ip.dialect == "linuxcnc" and not ip.plain)):
        plane = (AXES[first] + AXES[second]).upper()
        message = f"{wrong.upper()} leads to no centre of an arc in the {plane} plane"
        hint = f"leave {wrong.upper()} out, or choose the plane of the arc: G17 XY, G18 ZX, G19 YZ"
        raise BlockError("arc-plane", message, wrong.upper(), hint=hint)
    centre = []
    for axis in (first, second):
        letter = _OFFSETS[axis % 3]
        if state.arc_absolute:
            if letter not in block.words:
                message = f"{letter.upper()} is missing: G90.1 needs the whole centre"
                raise BlockError("arc-centre", message, name)
            centre.append(block.words[letter])
        else:
            centre.append(start[axis] + block.words.get(letter, 0.0))
    return centre[0], centre[1]


def _radii(ip: Interpreter, end: list[float], centre: tuple[float, float]) -> tuple[float, float]:
    """Return the distances of an arc's start and end from its centre, in its plane."""
    first, second, _ = ip.state.plane_axes()
    start = ip.state.position
    at_start = math.hypot(centre[0] - start[first], centre[1] - start[second])
    return at_start, math.hypot(centre[0] - end[first], centre[1] - end[second])


def check_radii(at_start: float, at_end: float, inches: bool, word: str, hint: str) -> None:
    """Raise where the start and end radius of an arc differ by more than is accepted, or one is nothing."""
    unit = "inch" if inches else "mm"
    if min(at_start, at_end) < RADIUS_TOLERANCE[inches]:
        message = f"the centre is at the arc's {'start' if at_start <= at_end else 'end'}: r1 = {at_start:.4f}, r2 = {at_end:.4f} {unit}"
        raise BlockError("arc-zero-radius", message, word)
    gap = abs(at_start - at_end)
    tolerance = CENTRE_TOLERANCE[inches]
    allowed = min(max(tolerance, CENTRE_RELATIVE * max(at_start, at_end)), CENTRE_FACTOR * tolerance)
    if gap > allowed:
        raise BlockError(
            "arc-radius",
            f"start and end are not on one circle: r1 = {at_start:.3f}, r2 = {at_end:.3f}, "
            f"difference {gap:.3f} > {allowed:.3f} {unit}",
            word,
            hint=hint,
            values={"start_radius": at_start, "end_radius": at_end, "difference": gap, "allowed": allowed},
        )


_SUMMONS = "xyzabcuvwijk@^"
CODES = tuple(
    Code("G", number, "motion", Stage.MOTION, partial(_arc, clockwise=right), f"arc or helix, {way}", _SUMMONS + "rp" + turns,
        "motion", _SUMMONS, dialects=(dialect,), moves="plane", waits=True)
    for dialect, turns in zip(BOTH, ("", "l"), strict=True)
    for number, right, way in ((20, True, "clockwise"), (30, False, "counter-clockwise"))
)  # fmt: skip

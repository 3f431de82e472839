"""G functions of SINUMERIK: modes, origins and poles, paths, and those that move: G33 to G35, G331, G332, G74, G75."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from cncgen.gcode.block import AXES, AXIS_INDEX
from cncgen.gcode.codes.compensated_sink import CompensatedSink
from cncgen.gcode.codes.lathe_fanuc import turns_of_varying_lead
from cncgen.gcode.codes.modes import stopping
from cncgen.gcode.codes.turning_profiles import Recorder
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.sinumerik import commands
from cncgen.gcode.sinumerik.frame_variables import use_origin
from cncgen.units import INCH

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions, Words

#: G functions that are accepted: they choose how corners stop or come close.
_PLAIN = frozenset((9, 60, 601, 602, 603, 62, 621, 63, 290, 460, 461, 462, 810, 820, 830))
#: The side of soft approaches: that of G41 and G42, left, right, where the tool comes from.
_SIDES = {140: 2, 141: 1, 142: -1, 143: 0}
_SURFACE = (96, 97, 961, 962, 971, 972, 973)
_FEED_MODES = (93, 94, 95)
_NOT_READ = {
    291: "the ISO dialect (--dialect fanuc reads it)", 5: "inclined plunge", 7: "inclined plunge", 931: "the feed as a time",
    942: "frozen feed", 952: "frozen feed",
}  # fmt: skip


def mode(motions: Motions, code: int, words: Words) -> None:
    """Put a G function in force."""
    emit = motions.emit
    if code in (17, 18, 19):
        motions.plane_assumed = False
        motions.settle()
        emit({}, (code * 10,))
        motions.pole = 0j
        _doubt_length(motions, code)
    elif code in (40, 41, 42):
        _compensate(motions, code)
    elif code in (70, 71, 700, 710):
        _units(motions, code)
    elif code in (90, 91):
        motions.absolute = code == 90
    elif code in _FEED_MODES:
        motions.feed_said = True
        if motions.ip.state.feed_mode != code:
            emit({}, (10 * code,))
            # An F of another unit does not live on.
            motions.ip.state.feed = 0.0
    elif code in _SURFACE:
        _surface(motions, code, words)
    elif code in (110, 111, 112):
        _pole(motions, code, words)
    elif code in (58, 59):
        commands.part_of_shift(motions, code, words)
    elif 54 <= code <= 57 or 505 <= code <= 599 or code == 500:
        use_origin(motions, 0 if code == 500 else code - 53 if code < 100 else code - 500, f"G{code}")
    elif code in (450, 451):
        motions.sharp_corners = code == 451
        if isinstance(motions.ip.sink, CompensatedSink):
            motions.ip.sink.centre.cut_outside(motions.sharp_corners)
    elif code in (60, 64) or 641 <= code <= 645:
        _path(motions, code, words)
    elif code in (25, 26):
        _bounds(motions, code, words)
    elif code in _SIDES:
        motions.soft_side = _SIDES[code]
    elif code in (340, 341):
        motions.soft_in_plane = code == 341
    elif code in _NOT_READ:
        raise commands.not_read(f"G{code}", _NOT_READ[code])
    elif code not in _PLAIN:
        message = f"G{code} is not read"
        raise BlockError("unknown-code", message, f"G{code}", hint="docs/sinumerik.md lists what is read")


def _units(motions: Motions, code: int) -> None:
    """G70 and G71 change the unit of lengths alone, G700 and G710 that of F too; the feed in force does not change.

    The basic system is metric (840D sl, Fundamentals, "Inch or metric dimensions").
    """
    state, feed, inches = motions.ip.state, motions.ip.state.feed, motions.ip.state.inches
    motions.settle()
    motions.units = code
    motions.emit({}, (200 if code in (70, 700) else 210,))
    motions.feed_scale = 1.0 / INCH if code == 70 else 1.0
    if feed and state.inches != inches and state.feed_mode != 93:
        motions.emit({"f": feed / INCH if state.inches else feed * INCH})


def _bounds(motions: Motions, code: int, words: Words) -> None:
    """G25 and G26: least and largest speed of the spindle, or a working area; neither is checked here."""
    for name in [name for name in words.named if name[0] == "S" and name[1:].isdigit()]:
        words.named.pop(name)
    words.named.pop("S", None)
    if words.axes:
        hint = "travel_mm of the machine file is checked"
        motions.ip.note("zone-not-checked", f"the working area of G{code} is not checked", f"G{code}", hint)
        words.axes.clear()


def _compensate(motions: Motions, code: int) -> None:
    motions.settle()
    ip = motions.ip
    if code == 40:
        motions.emit({}, (400,))
        return
    if isinstance(ip.sink, Recorder):
        raise commands.not_read(f"G{code}", "the cycle keeps the tool beside its contour")
    if motions.edge == 0:
        message = f"G{code} with D0: no radius is in force"
        raise BlockError("comp-diameter", message, f"G{code}", hint="D1 takes the tool's radius")
    if motions.allowance:
        _compensate_with_allowance(motions, code)
    else:
        motions.emit({"d": float(ip.state.tool)} if ip.state.tool else {}, (code * 10,))
    if isinstance(ip.sink, CompensatedSink):
        ip.sink.centre.cut_outside(motions.sharp_corners)


def _compensate_with_allowance(motions: Motions, code: int) -> None:
    """Begin compensation by the tool's radius and OFFN."""
    ip = motions.ip
    tool = ip.tools.find(ip.state.tool)
    radius = (tool.diameter / 2.0 if tool else 0.0) * ip.table_scale() + motions.allowance
    if radius < 0.0:
        message = f"OFFN={motions.allowance:g} leaves a radius of {radius:g} to compensate"
        hint = f"OFFN is {radius - motions.allowance:g} or more below 0"
        raise BlockError("comp-radius", message, "OFFN", hint=hint)
    words = {"d": 2.0 * radius}
    if tool and ip.state.plane == 18:
        words["l"] = float(tool.orientation)
    motions.emit(words, (code * 10 + 1,))


def _doubt_length(motions: Motions, code: int) -> None:
    """Warn where the length of a mill's tool goes to another axis on the control (Tools, "Tool length compensation": length 1 of a milling
    tool is along Z in G17, Y in G18, X in G19, unless setting data 42940 names a plane)."""
    size = motions.ip.state.offsets()[3]
    if code == 17 or not size[2] or size[0] or size[1] or "G9" in motions.diameter:
        return
    message = f"G{code}: the tool's length {size[2]:g} stays along Z; the control takes it along {'Y' if code == 18 else 'X'}"
    hint = (
        "setting data 42940 = 17 keeps it along Z; G17 before the next motion without an arc leaves no doubt"
    )
    motions.ip.warn_once("length-plane", message, f"G{code}", hint)


def _surface(motions: Motions, code: int, words: Words) -> None:
    """G96 and kin, of one group with G94 and G95: G96, G97 and G973 have a feed a revolution, G961 and G971 one a minute, G962 and G972
    that in force.

    F in force counts on where no G94 said what it is (840D sl, Fundamentals, "Constant cutting rate"). G97 without G96 before it does what
    G95 does (840D, Fundamentals 10/2004, 7.13).
    """
    state = motions.ip.state
    feed_mode = {96: 95, 97: 95, 973: 95, 961: 94, 971: 94}.get(code, state.feed_mode)
    if state.feed_mode != feed_mode:
        feed = state.feed
        motions.emit({}, (10 * feed_mode,))
        if feed and not motions.feed_said:
            motions.emit({"f": feed})
    if code >= 971 or code == 97:
        motions.emit({}, (970,))
        return
    speed = words.named.pop("S", words.named.pop(f"S{motions.master}", None))
    if speed is not None:
        motions.emit({"s": speed[1]}, (960,))
    elif state.constant_surface is None:
        if state.surface_speed is None:
            message = f"G{code} has no S"
            raise BlockError("speed-missing", message, f"G{code}", hint="G96 S200 is 200 m a minute")
        motions.emit({"s": state.surface_speed}, (960,))


def _pole(motions: Motions, code: int, words: Words) -> None:
    """G110 from where the tool is, G111 from the origin, G112 from the last pole; by axis words or AP RP."""
    first, second, _ = motions.plane()
    base = {110: motions.here_in_plane(), 111: 0j, 112: motions.pole}[code]
    if {"AP", "RP"} & words.named.keys():
        angle, radius = (words.named.pop(n, ("", 0.0))[1] for n in ("AP", "RP"))
        offset = radius * complex(math.cos(math.radians(angle)), math.sin(math.radians(angle)))
    else:
        offset = complex(*(words.axes.pop(AXES[k].upper(), ("", 0.0))[1] for k in (first, second)))
    if motions.diameter.startswith("G90") and 0 in (first, second):
        raise commands.not_read(f"G{code} while X is a diameter", "a pole of lathes")
    if words.axes:
        message = f"G{code} has an axis outside the plane"
        raise BlockError("pole-plane", message, next(iter(words.axes)), hint="a pole lies in the plane")
    motions.pole = base + offset
    motions.polar = (0.0, 0.0)


def _path(motions: Motions, code: int, words: Words) -> None:
    if code == 60:
        motions.set_path("G60", None)
        return
    motions.set_path(f"G{code}", None if code == 64 or motions.path[0] == "G60" else motions.path[1])
    if code == 641:
        tolerance(motions, words)


def tolerance(motions: Motions, words: Words) -> None:
    """ADIS of G641 and G642, CTOL of G642, G645 and the compressors: how far the path may be left.

    A corner whose rounding begins at the distance ADIS is left by half of it at most.
    """
    found = {
        name: words.named.pop(name)[1] for name in ("ADIS", "ADISPOS", "CTOL", "OTOL") if name in words.named
    }
    value = found.get("CTOL", found["ADIS"] / 2.0 if "ADIS" in found else None)
    if value is None or motions.path[0] == "G60":
        return
    if value < 0.0:
        message = f"a tolerance of {value:g} is negative"
        raise BlockError("negative-tolerance", message, "ADIS", hint="it is 0 or more")
    motions.set_path(motions.path[0], value)


def home(motions: Motions, words: Words) -> None:
    """G74 to the reference point, G75 to the fixed point, of the axes named."""
    code, name = (280, "G74") if 74 in words.g else (300, "G75")
    motions.settle()
    message = f"{name} goes to a point of the machine, and cutter compensation is on"
    refuse(
        name, (motions.ip.state.compensation != 40, "comp-refused", message, "G40 and a straight move end it")
    )
    position = motions.ip.state.position
    if words.named.pop("FP", ("", 1.0))[1] != 1.0:
        message = "where fixed points beyond the first lie is not known"
        raise BlockError("not-read", message, "FP", hint="FP=1 is read")
    named = [*words.axes, *(name[0] for name in commands.MACHINE_AXES if words.named.pop(name, None))]
    axes = {axis.lower(): position[AXIS_INDEX[axis.lower()]] for axis in named}
    words.axes.clear()
    if axes:
        motions.emit(axes, (code,))


#: Threads whose lead changes by F, and which way.
VARYING_LEADS = {"G34": 1.0, "G35": -1.0}
_LEADS = {"I": "x", "J": "y", "K": "z"}


def thread(motions: Motions, words: Words, given: dict[str, float]) -> None:
    """G33 to G35, G331 and G332: a line in step with the spindle, I, J or K a revolution along X, Y or Z.

    That of G34 grows by F each revolution, that of G35 falls.
    """
    leads = {name: abs(words.named.pop(name)[1]) for name in _LEADS if name in words.named}
    here = motions.ip.state.position
    ways = {
        name: given.get(axis, here[AXIS_INDEX[axis]]) - here[AXIS_INDEX[axis]]
        for name, axis in _LEADS.items()
    }
    # Of a taper "the parameter for the lead is based on the taper angle": that of the axis that goes farther (840Di sl, Fundamentals, 11/2006, p. 169).
    name = max(leads, key=lambda one: abs(ways[one]), default="")
    if not leads.get(name):
        message = f"{motions.motion} has no lead"
        raise BlockError("pitch-missing", message, motions.motion, hint="K is the lead along Z")
    lead, length, along = leads[name], math.hypot(*ways.values()), abs(ways[name])
    if length and not along:
        message = f"{name} of {motions.motion} is the lead along {_LEADS[name].upper()}, and the thread does not go there"
        hint = "I is the lead along X, J along Y, K along Z"
        raise BlockError("pitch-missing", message, name, hint=hint)
    words.named.pop("SF", None)
    slant = length / along if length else 1.0
    if motions.motion == "G33":
        motions.emit({**given, "k": lead * slant}, (330,))
        return
    if motions.motion in VARYING_LEADS:
        growth = VARYING_LEADS[motions.motion] * words.named.pop("F", ("", 0.0))[1]
        if not growth:
            message, hint = f"{motions.motion} has no change F of the lead", "G33 has one lead"
            raise BlockError("pitch-missing", message, motions.motion, hint=hint)
        begin = {axis: here[AXIS_INDEX[axis]] for axis in given}
        for share, turn in turns_of_varying_lead(motions.motion, "F", lead, growth, along):
            place = {axis: begin[axis] + share * (end - begin[axis]) for axis, end in given.items()}
            motions.emit({**place, "k": turn * slant}, (330,))
        return
    # Rigid tapping runs in and, by G332, out again, each at lead times speed.
    ip = motions.ip
    if ip.state.speed <= 0.0:
        message = f"{motions.motion} needs the speed of the spindle"
        raise BlockError("spindle-stopped", message, motions.motion, hint="S gives it")
    feed, feed_mode = ip.state.feed, ip.state.feed_mode
    if feed_mode != 94:
        motions.emit({}, (940,))
    with stopping(ip):
        motions.emit({"f": lead * ip.state.speed, **given}, (10,))
    motions.emit({}, (940,)) if feed_mode == 94 else motions.emit({}, (10 * feed_mode,))
    if feed:
        motions.emit({"f": feed})

"""Feeds, speeds, tools and M functions of a block of SINUMERIK."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

from cncgen.gcode.block import Block
from cncgen.gcode.codes.spindle import turns_a_minute
from cncgen.gcode.codes.subprograms import of_builder
from cncgen.gcode.errors import BlockError
from cncgen.gcode.sinumerik import commands, g_functions

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions, Words

_MOST_OVERRIDE = 200.0
#: Words of a spindle's speed. M of a larger number than that of any spindle extends the address of a function of the builder: M20=151.
_SPINDLE, _MOST_SPINDLES = re.compile(r"S\d?"), 9
ENDS = {2: True, 30: True, 17: True}


def modal_values(motions: Motions, words: Words) -> None:
    """OVR, the override of the feed in percent, OFFN, the allowance beside the tool's radius, and LIMS, the bound of the speed under G96."""
    limit = words.named.pop("LIMS", None)
    if 92 in words.g and "S" in words.named and not words.axes:
        words.g.remove(92)
        limit = words.named.pop("S")
        message = (
            "G92 S is read as LIMS: the bound of the spindle's speed under G96, as on SINUMERIK 810 and 820"
        )
        motions.ip.note("speed-bound", message, "G92", "LIMS= says it on later controls")
    if limit is not None:
        state = motions.ip.state
        state.speed_limit = limit[1]
        if state.constant_surface is not None and 96 not in words.g:
            motions.emit({"s": state.speed}, (960,))
    if "OVR" in words.named:
        percent = words.named.pop("OVR")[1]
        if not 0.0 < percent <= _MOST_OVERRIDE:
            message = f"OVR={percent:g} is not above 0 and at most {_MOST_OVERRIDE:g} percent"
            raise BlockError("feed-override", message, "OVR", hint="OVR=100 is the feed as it is written")
        feed, before = motions.ip.state.feed, motions.override
        motions.override = percent / 100.0
        if feed and "F" not in words.named:
            motions.emit({"f": feed * motions.override / before})
    if "OVRRAP" in words.named:
        commands.INDEXED["ACC"](motions, words, "OVRRAP", "", *words.named.pop("OVRRAP"))
    if words.named.get("CUTMOD", ("", 1.0))[1] == 0.0:
        del words.named["CUTMOD"]
    elif "CUTMOD" in words.named:
        commands.check_name("CUTMOD")
    if "OFFN" in words.named:
        value = words.named.pop("OFFN")[1]
        if value != motions.allowance and motions.ip.state.compensation != 40:
            raise commands.not_read("OFFN", "an allowance that changes while compensation is on")
        motions.allowance = value
    if commands.TOOL_OFFSETS.keys() & words.named.keys():
        _add_to_tool(motions, words)


def _add_to_tool(motions: Motions, words: Words) -> None:
    """TOFFL=, TOFFR= and TOFFLR= add to length 1, the radius or both of the tool in the spindle, until they are 0 (SINUMERIK ONE, NC
    programming, 12/2019, p. 88). Whether another tool or edge ends that no text says."""
    tools = motions.store.tools
    before = tools.added
    for name in [name for name in words.named if name in commands.TOOL_OFFSETS]:
        value = words.named.pop(name)[1]
        length, radius = (
            value if changes else old
            for old, changes in zip(tools.added, commands.TOOL_OFFSETS[name], strict=True)
        )
        tools.added = length, radius
    if tools.added[1] != before[1] and motions.ip.state.compensation != 40:
        raise commands.not_read("TOFFR", "a radius that changes while compensation is on")
    if any(tools.added) and not (motions.ip.state.tool and motions.edge):
        raise commands.not_read(
            "TOFFL or TOFFR without a tool, or with D0", "an offset beside the tool's data"
        )
    if tools.added != before:
        commands.take_edge(motions)


def take(motions: Motions, words: Words) -> None:
    """Take F, S, T, D."""
    _take_tool_name(motions, words)
    out = _feed_and_speed(motions, words)
    tool = words.named.pop("T", None)
    if tool is not None:
        out["t"] = tool[1]
    cut = words.named.pop("SVC", None)
    changes = 6 in words.m
    if any(motions.store.tools.added) and (changes or tool is not None or "D" in words.named):
        raise commands.not_read(
            "T or D behind TOFFL or TOFFR", "an offset for another tool; TOFFL=0 and TOFFR=0 end it before"
        )
    if out or changes:
        motions.emit(out, (), (60,) if changes else ())
    if tool is not None and motions.turret:
        _turn_turret(motions, tool[1])
        changes = changes or tool[1] != 0.0
    edge = words.named.pop("D", None)
    if changes or edge is not None:
        motions.edge = whole("D", edge[1]) if edge is not None else 1
        commands.take_edge(motions)
    if cut is not None:
        _cut_at(motions, cut[1])


def _feed_and_speed(motions: Motions, words: Words) -> dict[str, float]:
    """Return F and S of a block, which are left where G4 or a varying lead takes them; keep the speeds of other spindles."""
    other = 4 in words.g or motions.motion in g_functions.VARYING_LEADS
    feed = None if other else words.named.pop("F", None)
    if "FZ" in words.named:
        feed = "", _feed_of_teeth(motions, words.named.pop("FZ")[1])
    out: dict[str, float] = {} if feed is None else {"f": feed[1] * motions.feed_scale * motions.override}
    for name in [name for name in words.named if _SPINDLE.fullmatch(name) and 4 not in words.g]:
        if name in ("S", "S0", f"S{motions.master}"):
            out["s"] = words.named.pop(name)[1]
        else:
            motions.speeds[name] = words.named.pop(name)[1]
    return out


def _turn_turret(motions: Motions, tool: float) -> None:
    """Change the tool at T, as a turret does, to one other than T0; tell so of a mill."""
    if motions.ip.state.plane != 18:
        message = (
            "the program has no M6: T is taken to change the tool at once, as with machine data 22550 = 0"
        )
        motions.ip.note_once("tool-at-once", message, "T", "M6 behind T changes the tool where 22550 is 1")
    if tool:
        motions.emit({"q": tool}, (), (610,))


def _take_tool_name(motions: Motions, words: Words) -> None:
    """Take the number of a tool by its name; tools of other spindles than the first are passed over."""
    for store in (words.texts, words.named):
        if "T1" in store:
            store["T"] = store.pop("T1")  # type: ignore[assignment]
        store.pop("T2", None)
        store.pop("T3", None)
    if "T" in words.texts:
        name = words.texts.pop("T")
        found = motions.ip.tools.named(name)
        if found is None:
            message = (
                f'the tool "{name}" has no length and no radius: no remark of the tool table is that name'
            )
            hint = "T and a number takes one of --tool-table; further names are not reported"
            motions.ip.note_once("tool-name", message, "T", hint)
        words.named.setdefault("T", ("", float(found or 0)))


def _cut_at(motions: Motions, speed: float) -> None:
    """SVC=: turn so fast that the edge of the tool cuts at a speed in m a minute, in G70 and G700 feet a minute (840D sl, Fundamentals,
    "Cutting rate (SVC)")."""
    diameter = 2.0 * motions.ip.tool_radius()
    if diameter <= 0.0:
        message = f"SVC={speed:g} needs the diameter of the tool, which no tool table gives: the speed of the spindle stays"
        motions.ip.warn_once("cutting-speed", message, "SVC", "S is the speed; --tool-table has the diameter")
        return
    way = 12.0 if motions.ip.state.inches else 1000.0
    motions.emit({"s": way * speed / (math.pi * diameter)})


def _feed_of_teeth(motions: Motions, feed: float) -> float:
    """Return the feed a revolution of a feed a tooth, FZ; raise where G95 is not in force, or the number of teeth is not known."""
    tool = motions.ip.state.tool
    teeth = motions.store.tools.teeth.get(tool, 0.0)
    what = (
        "is of G95"
        if motions.ip.state.feed_mode != 95
        else f"needs the number of teeth of tool {tool}"
        if teeth <= 0.0
        else ""
    )
    if what:
        hint = f"G95 F is FZ times the teeth, or $TC_DPNT[{tool},1]=4 says how many there are"
        raise BlockError("feed-missing", f"FZ={feed:g}, a feed a tooth, {what}", "FZ", hint=hint)
    return feed * teeth


def functions(motions: Motions, words: Words) -> bool:
    """Do the M functions; tell whether one ends the program."""
    for name in list(words.named):
        if name[0] == "M" and name[1:].isdigit():
            value = whole("M", words.named.pop(name)[1])
            if name in ("M0", f"M{motions.master}") or int(name[1:]) > _MOST_SPINDLES:
                words.m.append(value)
    ended = False
    for code in words.m:
        if code in ENDS:
            motions.settle()
            ended = True
        elif code == 6:
            continue
        elif code == 70:
            motions.ip.note("axis-spindle", "M70 turns the spindle into an axis: passed over", "M70")
        elif ("M", code * 10) in motions.ip.codes and code < 60:
            motions.emit({}, (), (code * 10,))
        elif code not in (40, 41, 42, 43, 44, 45):
            of_builder(code * 10, "").run(motions.ip, Block({}, m=(code * 10,)))
    return ended or not commands.RETURNS.isdisjoint(words.commands)


def dwell(motions: Motions, words: Words) -> None:
    """G4 F seconds, or S revolutions."""
    if 4 not in words.g:
        return
    seconds = words.named.pop("F", None)
    spindle = next((name for name in words.named if _SPINDLE.fullmatch(name)), "S")
    turns = words.named.pop(spindle, None)
    if seconds is None and turns is None:
        message = "G4 has neither F (seconds) nor S (revolutions)"
        raise BlockError("dwell-missing", message, "G4", hint="G4 F0.5 waits half a second")
    if seconds is None:
        assert turns is not None
        speed = (
            turns_a_minute(motions.ip.state)
            if spindle in ("S", f"S{motions.master}")
            else motions.speeds.get(spindle, 0.0)
        )
        if speed <= 0.0:
            message = f"G4 {spindle} counts revolutions, and the spindle does not turn"
            raise BlockError("spindle-stopped", message, spindle, hint="G4 F waits for seconds")
        seconds = ("", 60.0 * turns[1] / speed)
    motions.end()
    motions.emit({"p": seconds[1]}, (40,))


def whole(letter: str, value: float) -> int:
    """Return the number of a function as a whole one."""
    if value != round(value) or value < 0:
        message = f"{letter}{value:g} is not a whole number of 0 or more"
        raise BlockError("not-whole", message, letter, hint="write it without decimals")
    return round(value)

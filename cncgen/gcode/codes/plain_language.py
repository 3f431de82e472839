"""Motions and tools of Heidenhain's plain language that G-code lacks: CC C CR CP LP, M140, oversizes of tools.

An arc about the pole lies in the plane of the pole's axes, and DR+ is right-handed about the third axis;
angles count from the plane's first axis: X in XY, Y in YZ, Z in ZX (iTNC 530, "Path contours").
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping

from cncgen.gcode.block import AXES, Block, Own
from cncgen.gcode.codes import tool_point
from cncgen.gcode.codes.arcs import check_radii
from cncgen.gcode.codes.cutter_compensation import feed_along_contour
from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.codes.lines import check_feed
from cncgen.gcode.codes.subprograms import tell_builders
from cncgen.gcode.codes.table import Code, Handler
from cncgen.gcode.codes.tools import table_offset, tell_unknown
from cncgen.gcode.codes.turning_profiles import Segment
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinks.sink import RADIUS_TOLERANCE
from cncgen.gcode.state.modal import PLANE_AXES, Stage, in_plane
from cncgen.kernels.arc_centres import centre_from_radius
from cncgen.records import dataclass, field

DIALECT = "heidenhain"
_PLANES = {frozenset(AXES[column] for column in PLANE_AXES[plane][:2]): plane for plane in (17, 18, 19)}
_Z = 2
#: A sweep that is less than this below a full turn counts as full (turns).
_WHOLE = 1e-9


@dataclass(slots=True)
class Plain:
    """The pole, cycle and heading that stay from block to block.

    Attributes:
        pole: In program coordinates, in its plane.
        cycle: The cycle that is called, 0 for none.
        modal: Whether each motion calls it (M89).
        heading: The direction in which the last motion ended, in XY, of length 1.
        parts: Values of a cycle that has them in parts, by their names (1 to 5, 17).
        sizes: Length and diameter, before oversizes, of the tools that had some.
        defined: The tools whose sizes TOOL DEF gave.
        labels: The contours of cycle 14, and `contour`, what reads one: its segments, and the side of the tool.
        train_ways: Whether cycle 270 has given the side and the ways to and from a contour train.
        paraxial: 1 where lines along one axis go the radius of the tool further (R+), -1 where they end so far before (R-), else 0.
        texts: Texts by the number of their parameter QS, as far as they are known.
        spatial: The spatial angles A B C, degrees, to which rotary words turn the tool under AXIS SPAT; None where they are positions of axes.
        vector: Whether the tool's direction turns in a plane while it goes along a line (PATHCTRL VECTOR).
        shortest: Whether rotary axes go the shorter way (M126).
        turns: Whole turns that rotary axes, by column, stand above what their display, and so the program, says.
        tool_feed: The feed of the last TOOL CALL with one, in the program's units a minute, which FAUTO takes.
    """

    pole: complex | None = None
    plane: int = 17
    cycle: int = 0
    modal: bool = False
    heading: complex | None = None
    parts: dict[str, float] = field(default_factory=dict)
    sizes: dict[int, tuple[float, float]] = field(default_factory=dict)
    defined: set[int] = field(default_factory=set)
    paraxial: float = 0.0
    spatial: list[float] | None = None
    vector: bool = False
    shortest: bool = False
    turns: dict[int, int] = field(default_factory=dict)
    tool_feed: float = 0.0
    texts: dict[int, str] = field(default_factory=dict)
    labels: list[str] = field(default_factory=list)
    contour: Callable[[str], tuple[list[Segment], int]] | None = None
    train_ways: bool = False

    @classmethod
    def of(cls, ip: Interpreter) -> Plain:
        """Return that of a run."""
        if not isinstance(ip.plain_language, Plain):
            ip.plain_language = cls()
        return ip.plain_language


def pole(ip: Interpreter, block: Block) -> None:
    """CC: the centre of circles and the pole of polar coordinates; without words, where the tool is."""
    plain = Plain.of(ip)
    letters = frozenset("xyz").intersection(block.words)
    if len(letters) > 2:
        message = "CC has three axes: a pole lies in a plane"
        raise BlockError("pole-plane", message, "CC", hint="leave one out")
    if len(letters) == 2:
        plain.plane = _PLANES[letters]
    first, second, _ = PLANE_AXES[plain.plane]
    at = [ip.state.position[axis] for axis in (first, second)]
    if len(letters) == 1 and plain.pole is not None:
        at = [plain.pole.real, plain.pole.imag]
    plain.pole = complex(
        *(block.words.get(AXES[axis], old) for axis, old in zip((first, second), at, strict=True))
    )


def pole_of(ip: Interpreter, name: str) -> tuple[complex, int]:
    """Return the pole and its plane; raise where the program has not set it."""
    plain = Plain.of(ip)
    if plain.pole is None:
        raise BlockError("pole-missing", f"{name} has no pole", name, hint="CC gives it before")
    return plain.pole, plain.plane


def polar_place(words: dict[str, float], centre: complex, here: complex) -> complex:
    """Return the place of PR, PA, IPR and IPA about a pole, from where the tool is; a radius or angle that is missing stays."""
    spoke = here - centre
    radius = words.get("pr", abs(spoke)) + words.get("ipr", 0.0)
    angle = words.get("pa", math.degrees(cmath.phase(spoke)) if spoke else 0.0) + words.get("ipa", 0.0)
    return centre + cmath.rect(radius, math.radians(angle))


def refuse_cartesian(words: Mapping[str, float], plane: int, name: str) -> None:
    """Raise where a block in polar coordinates has one of the plane's axes."""
    axis = next((AXES[index].upper() for index in PLANE_AXES[plane][:2] if AXES[index] in words), "")
    message = f"{axis} stands beside {name}, whose end is given by PR and PA"
    refuse(axis, (bool(axis), "unused-word", message, "L, C or CT go to X and Y"))


def _sense(block: Block, name: str) -> float:
    """Return 1 for DR+, -1 for DR-."""
    if "dr" not in block.words:
        raise BlockError("arc-sense", f"{name} has no sense of rotation", name, hint="DR+ or DR-")
    return block.words["dr"]


def _arc(ip: Interpreter, end: list[float], centre: complex, turns: int, plane: int, name: str) -> None:
    check_feed(ip, ip.sink.block, name)
    state = ip.state
    start, finish = in_plane(state.position, plane), in_plane(end, plane)
    hint = f"the pole is X{centre.real:g} Y{centre.imag:g}: is it the CC that is meant?"
    if plane != 17:
        hint = "is the last CC the pole that is meant?"
    check_radii(abs(start - centre), abs(finish - centre), state.inches, name, hint)
    if state.plane != plane:
        state.plane = plane
        ip.sink.select_plane(plane)
    ip.sink.arc_feed(end, centre.real, centre.imag, turns, plane)
    state.position, state.moved, state.motion = end, True, 10
    if plane == 17:
        spoke = finish - centre
        Plain.of(ip).heading = (1j if turns > 0 else -1j) * spoke / abs(spoke) if spoke else None


def circle(ip: Interpreter, block: Block) -> None:
    """C: an arc about the pole to a point."""
    centre, plane = pole_of(ip, "C")
    _arc(ip, ip.end_point(block), centre, round(_sense(block, "C")), plane, "C")


def radius_arc(ip: Interpreter, block: Block) -> None:
    """CR: an arc of radius R to a point in XY; of more than half a turn where R is negative."""
    if "r" not in block.words:
        raise BlockError("arc-centre", "CR has no radius R", "CR")
    turns, radius = round(_sense(block, "CR")), block.words["r"]
    start, end = ip.state.position, ip.end_point(block)
    tolerance = RADIUS_TOLERANCE[ip.state.inches]
    centre = centre_from_radius(start[0], start[1], end[0], end[1], radius, turns < 0, tolerance)
    if math.isnan(centre.real):
        chord = math.dist(start[:2], end[:2])
        message = f"R{radius:g} does not reach: the end is {chord:.4f} away"
        raise BlockError("arc-radius", message, "CR", hint="2 R is at least the way from start to end")
    _arc(ip, end, centre, turns, 17, "CR")


def polar_arc(ip: Interpreter, block: Block) -> None:
    """CP: an arc or helix about the pole to the angle PA, or by IPA; without either the angle stays, which makes a whole turn."""
    words, (centre, plane) = block.words, pole_of(ip, "CP")
    refuse_cartesian(words, plane, "CP")
    sense = _sense(block, "CP")
    spoke = in_plane(ip.state.position, plane) - centre
    if "ipa" in words:
        sweep = words["ipa"] / 360.0
        if sweep * sense <= 0.0:
            message = f"IPA{words['ipa']:g} and DR{'+' if sense > 0.0 else '-'} do not go the same way"
            raise BlockError("arc-sense", message, "IPA", hint="the sign of IPA is that of DR")
    else:
        turn = (words["pa"] - math.degrees(cmath.phase(spoke))) / 360.0 if "pa" in words and spoke else 0.0
        sweep = sense * ((sense * turn) % 1.0 or 1.0)
    first, second, _ = PLANE_AXES[plane]
    end = ip.end_point(block)
    finish = centre + spoke * cmath.rect(1.0, 2.0 * math.pi * sweep)
    end[first], end[second] = finish.real, finish.imag
    _arc(ip, end, centre, round(sense) * max(1, math.ceil(abs(sweep) - _WHOLE)), plane, "CP")


def polar_line(ip: Interpreter, block: Block) -> None:
    """LP: a line to a point in polar coordinates about the pole."""
    words, (centre, plane) = block.words, pole_of(ip, "LP")
    refuse_cartesian(words, plane, "LP")
    end = ip.end_point(block)
    first, second, _ = PLANE_AXES[plane]
    finish = polar_place(words, centre, in_plane(ip.state.position, plane))
    end[first], end[second] = finish.real, finish.imag
    if "fmax" not in words:
        check_feed(ip, block, "LP")
    ip.go(end, rapid="fmax" in words)


def retract(ip: Interpreter, block: Block) -> None:
    """M140 MB: back from the workpiece along the tool, by a way; MAX, to the end of travel, is passed over.

    It traverses unless it has a feed of its own, which ends with it.
    """
    way, feed = block.words["mb"], block.words["mb_f"]
    if way:
        cutter = FlatCutter(ip)
        if feed > 0.0:
            cutter.feed(feed)
        cutter.to(z=ip.state.position[_Z] + way, rapid=feed <= 0.0)
        if feed > 0.0:
            cutter.feed(ip.state.feed)
        return
    message = "M140 MB MAX is passed over: where the travel ends is not known here"
    ip.note_once("retract-unknown", message, "M140", "M140 MB 50 retracts by 50")


def oversize(ip: Interpreter, block: Block) -> None:
    """DL and DR of TOOL CALL: add to length and radius of the tool until it is called again."""
    number, sizes = round(block.words["t"]), Plain.of(ip).sizes
    longer, wider = block.words["dl"], block.words["dr_"]
    if number not in sizes and not longer and not wider:
        return
    tell_unknown(ip, number, "T")
    tool = ip.tools.entry(number)
    if tool is None:
        # The tool's own words say that the table lacks it.
        return
    length, diameter = sizes.setdefault(number, (tool.offset[_Z], tool.diameter))
    tool.offset[_Z] = length + longer / ip.table_scale()
    tool.diameter = diameter + 2.0 * wider / ip.table_scale()
    if tool.diameter < 0.0:
        message = f"DR{wider:+g} makes the radius of tool {number} {tool.diameter * ip.table_scale() / 2.0:g}: RL leads it to the right of a contour then, RR to the left"
        ip.warn_once("tool-oversize", message, "DR", "--tool-table gives the radius to which DR adds")


def tool_sizes(ip: Interpreter, block: Block) -> None:
    """TOOL DEF n L R: length and radius of a tool, where --tool-table does not have it."""
    number, words = round(block.words["tool"]), block.words
    defined = Plain.of(ip).defined
    if ip.tools.given and number in ip.tools.tools and number not in defined:
        message = f"TOOL DEF {number} gives sizes of a tool that the tool table has: the table's are taken"
        ip.note_once("tool-defined", message, "TOOL", "leave one of them out")
        return
    defined.add(number)
    Plain.of(ip).sizes.pop(number, None)
    tool = ip.tools.made(number)
    tool.offset[_Z] = words.get("l_size", 0.0) / ip.table_scale()
    tool.diameter = 2.0 * words.get("r_size", 0.0) / ip.table_scale()


def tool_feed(ip: Interpreter, block: Block) -> None:
    """Keep F of TOOL CALL, which FAUTO takes."""
    Plain.of(ip).tool_feed = block.words["f"]


def tip_on(ip: Interpreter, block: Block) -> None:
    """M128, FUNCTION TCPM: the tip of the tool goes where the program says while the rotary axes turn.

    Raises:
        BlockError: Something else is in force beside which it cannot stand.
    """
    tool_point.turn_on(ip, Block({"h": float(ip.state.tool)}), "M128")


def tip_off(ip: Interpreter, block: Block) -> None:
    """M129, FUNCTION RESET TCPM: axis words are those of the machine's axes again, the tool's length in force."""
    if ip.state.length_code != TIP_MODE:
        return
    offset = table_offset(ip, ip.state.tool) if ip.state.tool else ip.state.tool_offset
    tool_point.end(ip, 49, list(offset))


#: The code of tool lengths that M128 and G43.4 are.
TIP_MODE = 43.4
_NAMED, _TEETH, _NORMALS = 1, 3, 4
_REMARKS = {
    _TEETH: ("feed-teeth", "FZ is a feed of each tooth, and the tool table has no number of teeth: it is read as that of one tooth", "FZ",
        "F or FU gives the feed without doubt"),
    _NAMED: ("tool-name", "a tool that is called by its name has no length and no radius: no remark of the tool table is that name", "TOOL",
        "a remark in --tool-table, or TOOL CALL with a number, finds it"),
    _NORMALS: ("surface-normal", "NX NY NZ of LN are passed over: DL and DR of the tool do not shift the point along the normal", "LN",
        "write the points for the tool with its oversizes"),
    5: ("surface-normal", "DR2, the oversize of the corner's radius, is passed over: it counts for LN alone, whose points are not shifted",
        "TOOL", "without LN it changes nothing"),
    6: ("feed-function", "FUNCTION FEED DWELL is not made: the time of its pauses is not counted", "FUNCTION", "the path is not changed by it"),
    7: ("tool-index", "an index of a tool (TOOL CALL 5.1) has a length and a radius of its own in the control's table: those of the tool are taken",
        "TOOL", "a tool of another number has its own row in --tool-table"),
    20: ("feed-inch", "F of a program in INCH is read as inches a minute; TNCs may count it in tenths of an inch a minute", "INCH",
         "compare a feed with what is meant"),
    40: ("probe-not-run", "TCH PROBE measures on the machine: passed over, and datums and Q parameters stay as they are", "TCH",
         "the motions of probing take time that is not counted"),
    92: ("builders-point", "M92 counts from a point of the machine's builder: taken as machine zero, as M91", "M92",
         "M91 counts from machine zero"),
    **{number: ("contour-function", f"M{number} ({what}) is not made: the contour is offset as it stands", f"M{number}",
                "check the corners where it stands")
       for number, what in ((97, "steps smaller than the tool"), (98, "open corners machined to their end"))},
    116: ("feed-function", "M116 (mm a minute of rotary axes) is not read: F is that of the tool's centre along its path", "M116",
          "the path is not changed by it"),
}  # fmt: skip
#: Those that are notes.
_NOTES = (_NAMED, 5)
#: M109, M110 and M111: on which compensated arcs F is the feed along the contour.
_CONTOUR_FEEDS = {109: "all", 110: "inside", 111: ""}


def remark(ip: Interpreter, block: Block) -> None:
    """Remark once in a run on a word that changes no motion: a name where no tool has it, a normal where a tool has oversizes."""
    kind = round(block.words["remark"])
    if kind in _CONTOUR_FEEDS:
        feed_along_contour(ip, _CONTOUR_FEEDS[kind])
        return
    holds = {_NAMED: not block.words.get("t", 0.0), _NORMALS: bool(Plain.of(ip).sizes)}
    if kind not in _REMARKS:
        tell_builders(ip, f"M{kind}")
    elif holds.get(kind, True):
        (ip.note_once if kind in _NOTES else ip.warn_once)(*_REMARKS[kind])


def _own(
    number: int, title: str, run: Handler, text: str, named: tuple[str, ...] = (), words: str = AXES
) -> Code:
    """Return a code that uses axis words itself."""
    return Code("G", number, title, Stage.MOTION, run, text, words, "own", title=title, named=named,
        dialects=(DIALECT,))  # fmt: skip


CODES = (
    _own(Own.POLE, "CC", pole, "centre of circles, pole of polar coordinates", words="xyz"),
    _own(Own.CIRCLE, "C", circle, "arc about the pole", ("dr",)),
    _own(Own.RADIUS_ARC, "CR", radius_arc, "arc of radius R in XY", ("dr",), AXES + "r"),
    _own(Own.POLAR_ARC, "CP", polar_arc, "arc or helix about the pole", ("dr", "pa", "ipa")),
    _own(Own.POLAR_LINE, "LP", polar_line, "line in polar coordinates", ("fmax", "pr", "pa", "ipr", "ipa")),
    Code("G", Own.RETRACT, "retract", Stage.MOTION, retract, "retract along the tool; MAX is passed over", title="M140",
        named=("mb", "mb_f"), dialects=(DIALECT,)),
    Code("G", Own.OVERSIZE, "oversize", Stage.TOOL, oversize, "oversizes of the tool: length, radius", "t", title="DL DR",
        named=("dl", "dr_"), dialects=(DIALECT,)),
    Code("G", Own.TOOL_SIZES, "tool sizes", Stage.TOOL, tool_sizes, "length and radius of a tool", title="TOOL DEF",
        named=("tool", "l_size", "r_size"), dialects=(DIALECT,)),
    Code("G", Own.TOOL_FEED, "tool feed", Stage.TOOL, tool_feed, "the feed of TOOL CALL, which FAUTO takes", title="FAUTO",
        dialects=(DIALECT,)),
    Code("G", Own.TIP, "tip", Stage.TOOL_LENGTH, tip_on, "the tip goes where the program says (TCPM)", title="M128",
        dialects=(DIALECT,), moves="XYZ"),
    Code("G", Own.TIP_OFF, "tip", Stage.TOOL_LENGTH, tip_off, "end of M128", title="M129", dialects=(DIALECT,)),
    Code("G", Own.REMARK, "remark", Stage.COMMENT, remark, "a note on a word that changes no motion", title="M92",
        named=("remark",), dialects=(DIALECT,)),
)  # fmt: skip

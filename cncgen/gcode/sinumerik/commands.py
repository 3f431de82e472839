"""Words of SINUMERIK without a number (TRANS, MCALL, TRAORI …), and commands with arguments."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

from cncgen.gcode.block import AXES, AXIS_INDEX, Block
from cncgen.gcode.codes import affine as frames
from cncgen.gcode.codes import rotary_paths, tool_point
from cncgen.gcode.codes.cutter_compensation import feed_along_contour
from cncgen.gcode.codes.offsets import set_g92
from cncgen.gcode.codes.tools import table_offset
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.sinumerik import frame_variables, measuring, orientation, swivelling, unread_cycles
from cncgen.gcode.sinumerik.expressions import Function, Scalar, Value, Variable, number, whole
from cncgen.records import replace
from cncgen.toolpath.record import Event

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.motions import Motions, Words

#: Axes of the machine, by which G74 and G75 name those that they move.
MACHINE_AXES = ("X1", "Y1", "Z1", "A1", "B1", "C1")
#: Words that add to length and radius of the tool in the spindle, or to one of them.
TOOL_OFFSETS = {"TOFFL": (True, False), "TOFFR": (False, True), "TOFFLR": (True, True)}
#: Names of words that take a value by =.
NAMED = frozenset(
    [*MACHINE_AXES, *orientation.VECTOR, *orientation.ANGLES, *measuring.WORDS, *(f"S{k}" for k in range(10)), *(f"{letter}{k}" for letter in "HM" for k in range(100)),
     "AP", "RP", "FP", "CR", "AR", "ANG", "TURN", "I1", "J1", "K1", "RND", "RNDM", "CHF", "CHR", "FRC", "FRCM", "ADIS", "ADISPOS",
     "CTOL", "OTOL", "CTOLG0", "OTOLG0", "PW", "PL", "SD", "RPL", "SPOS", "SPOSA", "SF", "PO", "DISC", "DISR", "DISCL", "DISRP",
     "OFFN", "OVR", "PIT", "DITS", "DITE", "FB", "FZ", "FAD", "LIMS", "PRIO", "ALF", "DILF", "D1", "SVC", "OVRRAP", "STOLF", "CUTMOD", "T1", "T2", "T3", *TOOL_OFFSETS]
)  # fmt: skip
#: Words that end a subprogram beside M17; ENDPROC is the last line of one that begins with PROC.
RETURNS = frozenset({"RET", "ENDPROC"})
#: Words that change how the control moves, not where to: accepted.
_ACCEPTED = frozenset(
    [
     "SOFT", "BRISK", "DRIVE", "SOFTA", "BRISKA", "FFWON", "FFWOF", "FIFOCTRL", "STARTFIFO", "STOPFIFO",
     "UPATH", "SPATH", "COMPON", "COMPCURV", "COMPCAD", "COMPOF", "COMPSURF", "COMPPATH", "NORM", "STOPRE", "ORISON", "ORISOF", "RTLION",
     "CDOF", "CDOF2", "CDON", "CUT2D", "CUT2DF", "WALIMON", "WALIMOF", "DYNNORM", "DYNPOS", "DYNROUGH", "DYNSEMIFIN", "DYNFINISH",
     "DYNPREC", "SBLON", "SBLOF", "DISPLOF", "DISPLON", "FNORM", "FLIN", "FCUB", "CPRECON", "CPRECOF", "POLYPATH", "BAUTO", "BNAT",
     "BTAN", "EAUTO", "ENAT", "ETAN", "NEWCONF", "WAITP", "FPRAOFF", "LFON", "LFOF", "LFTXT", "LFWP", "LFPOS", "SPCON", "SPCOF", "SAVE", "ACTBLOCNO",
     "DELAYFSTON", "PCALL", "DELAYFSTOF", "IPTRLOCK", "IPTRUNLOCK", "FENDNORM", "ORIC", "ORID", "OSC", "OSS", "OSSE", "OSD", "OST", "OSOF", "PAROTOF", "TOFFOF", "CUTMODOF", "CUTCONOF", "STOPREOF", "CLGOF", "GWPSOF", "TMOF", "FTOCOF", "POLFMASK", "POLFMLIN", "DRFOF", "LIFTFAST", "CP",
     # Coordinates in which wear of tools counts, which the tool table has none of.
     "TOWSTD", "TOWWCS", "TOWBCS", "TOWMCS", "TOWTCS", "TOWKCS",
    ]
)  # fmt: skip
#: Ways to a contour around its first point, where that lies between.
_APPROACHES = ("KONT", "KONTC", "KONTT")
_MOTIONS = ("ASPLINE", "CSPLINE", "BSPLINE", "POLY", "CIP", "CT")
_FRAMES = ("TRANS", "ATRANS", "ROT", "AROT", "ROTS", "AROTS", "SCALE", "ASCALE", "MIRROR", "AMIRROR")
COUPLINGS = ("COUPDEF", "COUPON", "COUPONC", "COUPOF", "COUPOFS", "COUPDEL", "COUPRES")
_NAMED_NOT_READ = {
    **dict.fromkeys(("TRAANG", "TRACON"), "a transformation of inclined axes"),
    **dict.fromkeys(("DIAMCYCOF", "DIAMONA", "DIAMOFA", "DIAM90A"), "diameters of lathes"),
    **dict.fromkeys(("ORIPATH", "ORIPATHS", "ORICONCW", "ORICONCCW", "ORICONIO", "ORICONTO", "ORICURVE"), "a turn of the tool on a cone or a curve"),
    **orientation.NOT_READ,
    **dict.fromkeys(("CUT3DC", "CUT3DF", "CUT3DFF", "CUT3DFS", "CUT3DCC", "CUT3DCCD"), "cutter compensation in space"),
    **dict.fromkeys(("TANG", "TANGON", "TANGOF", "TANGDEL", "TLIFT"), "an axis that follows the direction of the path"),
    **dict.fromkeys(("REPOSA", "REPOSL", "REPOSQ", "REPOSH", "REPOSQA", "REPOSHA"), "the way back to the contour after an interrupt"),
    **dict.fromkeys(("DISPR", "RMIBL", "RMBBL", "RMEBL", "RMNBL"), "the place for the way back to the contour"),
    **dict.fromkeys(("SON", "SONS", "PON", "PONS", "SPIF1", "SPIF2"), "punching and nibbling"),
    **dict.fromkeys(("TCARR", "TCOABS", "TCOFR", "PAROT"), "an oriented tool carrier or workpiece"),
    **dict.fromkeys(("WHENEVER", "WHEN", "EVERY", "DO", "ID", "IDS"), "a synchronous action"),
    **dict.fromkeys(("PTP", "PTPG0", "PTPWOC"), "motions from point to point under a transformation"),
    **dict.fromkeys(("INVCW", "INVCCW"), "an involute"),
    **dict.fromkeys(("TOFF", "TOFFON", "DL", "FTOCON", "PUTFTOC", "PUTFTOCF"), "an offset beside the tool's data"),
    **dict.fromkeys(("FXS", "FXST", "FXSW", "FOCON"), "a motion against a stop"),
    **dict.fromkeys(("OS", "OSP1", "OSP2", "OST1", "OST2", "OSCILL"), "an axis that goes to and fro"),
    **dict.fromkeys(("CUTMOD", "CUTCONON", "CLGON", "ISD"), "cutter compensation other than in the plane"),
    **dict.fromkeys(("GWPSON", "TMON"), "the tool of a grinding machine"),
    **dict.fromkeys(("ADDFRAME", "FRAME", "CORROF"), "a frame as a value"),
    "ORIRESET": "a turn of the rotary axes to where they begin",
    "FPO": "a feed by a polynomial",
    "CROTS": "a rotation by solid angles as a frame",
    "BLOCK": "a part of another program",
    "ISOCALL": "a subprogram of the ISO dialect",
    **dict.fromkeys(("MEASA", "MEAWA", "MEAC"), "measuring by axes"),
    **dict.fromkeys(("CTABDEF", "CTABEND", "CTABDEL"), "a table by which axes are coupled"),
    **dict.fromkeys(("LEADON", "TRAILON", "EGON", *COUPLINGS), "coupled axes"),
}  # fmt: skip


def check_name(name: str) -> None:
    """Raise where a name is a command, or a step of ShopMill, that is not read."""
    if name in _NAMED_NOT_READ:
        raise not_read(name, _NAMED_NOT_READ[name])
    if unread_cycles.is_step(name):
        raise unread_cycles.refused(name)


def couples_spindles(name: str, arguments: Sequence[Value | None]) -> bool:
    """Tell whether a call couples spindles: COUPON(S2,S1), COUPON(SPI(2),SPI(1)), COUPOF(S2)."""
    coupled = arguments[:2]
    return name in COUPLINGS and bool(coupled) and all(map(_is_spindle, coupled))


def _is_spindle(argument: Value | None) -> bool:
    if isinstance(argument, Function):
        return argument.name == "SPI"
    return isinstance(argument, Variable) and argument.name[:1] == "S" and argument.name[1:].isdigit()


def not_read(name: str, what: str = "") -> BlockError:
    message = f"{name} ({what}) is not read" if what else f"{name} is not read"
    return BlockError("not-read", message, name, hint="docs/sinumerik.md lists what is read")


def run(motions: Motions, words: Words) -> None:
    """Do the words without a number of a block."""
    if "MCALL" in words.commands:
        _modal_call(motions, words)
        return
    if any(name == "SETINT" for name, _ in words.calls):
        # The name behind it is that of the subprogram, which no call runs.
        words.commands.clear()
        words.named.pop("PRIO", None)
    _one_frame(words.commands)
    for name in words.commands:
        if name in _FRAMES:
            _frame(motions, name, words)
        elif name in _MOTIONS:
            if motions.store.has(name):
                continue
            motions.set_motion(name)
        elif name in _SWITCHES:
            motions.settle()
            _SWITCHES[name](motions)
        elif name in _APPROACHES:
            message = f"{name} is taken as NORM: the tool goes straight to beside the first point of the contour, and away from beside the last"
            hint = "a first point that the tool need not go around makes no difference"
            motions.ip.warn_once("comp-approach", message, name, hint)
        elif name not in _ACCEPTED and name not in RETURNS and name not in ("SUPA", "RNDM"):
            times = words.named.pop("P", ("", 1.0))[1]
            motions.run_call(name, None, round(times))


def _one_frame(names: Iterable[str]) -> None:
    """Raise where two commands make frames: which axes are of which no one can tell."""
    made = [name for name in names if name in _FRAMES]
    message = f"{' and '.join(made[:2])} stand in one block: a frame has a block of its own"
    hint = "write each in its own block, the second one with A"
    refuse(made[-1] if made else "", (len(made) > 1, "modal-conflict", message, hint))


def _modal_call(motions: Motions, words: Words) -> None:
    """MCALL with a cycle or subprogram, which each motion calls from then on; alone, no longer."""
    motions.settle()
    names = [name for name in words.commands if name != "MCALL"]
    calls = [*words.calls, *((name, None) for name in names)]
    motions.modal = calls[0] if calls else None
    words.calls.clear()


def _frame(motions: Motions, name: str, words: Words) -> None:
    """TRANS ROT SCALE MIRROR set the programmable frame anew, ATRANS … add to it."""
    motions.settle()
    values = _frame_values(motions, name, words, kind_of(name) == "TRANS")
    rpl = words.named.pop("RPL", None)
    if rpl is not None and values:
        message = f"{name} has RPL, a turn in the plane, and turns about {' and '.join(values)} beside it"
        raise BlockError("unused-word", message, "RPL", hint="AROT in a block of its own adds the other one")
    step = _step(motions, kind_of(name), values, None if rpl is None else rpl[1])
    now = motions.frames
    if not name.startswith("A"):
        swivelling.take_frames(motions, replace(now, programmable=step, added=frames.NO_SHIFT))
        return
    whole, added = now.programmable.then(step), now.added
    if name == "ATRANS":
        moved = zip(added, whole.shift, now.programmable.shift, strict=True)
        x, y, z = (one + new - old for one, new, old in moved)
        added = x, y, z
    swivelling.take_frames(motions, replace(now, programmable=whole, added=added))


def _frame_values(motions: Motions, name: str, words: Words, shifts: bool) -> dict[str, float]:
    """Take the values of X Y Z of a frame out of a block."""
    for axis, (mode, _) in words.axes.items():
        if mode not in ("", "AC"):
            raise not_read(f"{axis}={mode}() of {name}", "ATRANS adds to a frame")
    values = {axis: value for axis, (_, value) in words.axes.items() if axis in "XYZ"}
    if motions.diameter.startswith("G90") and shifts and values.get("X"):
        message = f"X{values['X']:g} of {name} is taken as a radius: offsets are, whatever DIAMON says"
        motions.ip.warn("frame-diameter", message, "X", "X0 is both")
    # A shift of a rotary axis by 0 shifts nothing.
    other = [axis for axis, (_, value) in words.axes.items() if axis not in "XYZ" and (value or not shifts)]
    if other:
        raise not_read(f"{name} of {other[0]}", "frames are of X Y Z")
    words.axes.clear()
    return values


def part_of_shift(motions: Motions, code: int, words: Words) -> None:
    """G58 sets the shift of TRANS of the axes it names, G59 that of ATRANS (Fundamentals, "Axial work offset")."""
    motions.settle()
    values = _frame_values(motions, f"G{code}", words, shifts=True)
    wanted = motions.frames
    for axis, value in values.items():
        wanted = wanted.shifted("XYZ".index(axis), value, added=code == 59)
    swivelling.take_frames(motions, wanted)


def kind_of(name: str) -> str:
    """Return which frame a command makes, set anew or added."""
    return name.removeprefix("A")


def _step(motions: Motions, kind: str, values: dict[str, float], rpl: float | None) -> frames.Frame:
    """Return the frame that one command makes."""
    if kind == "ROT" and rpl is not None:
        return frames.Frame(frames.turn(motions.plane()[2], rpl))
    if kind == "ROTS":
        return frames.Frame(swivelling.of_solid_angles(values))
    return frames.made(kind, values)


def position(motions: Motions, words: Words, *, beside: bool) -> None:
    """POS[X]=, POSA[X]=: move axes by themselves, at FA or in traverse; beside a traverse they go along with it."""
    moved, words.positions = words.positions, {}
    if beside:
        if motions.motion != "G0":
            raise not_read("POS", f"an axis that moves by itself beside {motions.motion}")
        words.axes.update(moved)
        return
    feeds = [motions.axis_feeds[axis] for axis in moved if axis in motions.axis_feeds]
    before, feed, mode = motions.motion, motions.ip.state.feed, motions.ip.state.feed_mode
    motions.set_motion("G1" if feeds else "G0")
    if feeds:
        motions.emit({"f": min(feeds)}, (940,) if mode != 94 else ())
    words.axes.update(moved)
    motions.go(words)
    if feeds:
        motions.emit({"f": feed} if feed else {}, (10 * mode,) if mode != 94 else ())
    motions.set_motion(before)


def _axis_name(name: str, at: Scalar) -> str:
    if not isinstance(at, str) or len(at) != 1 or at not in AXES.upper():
        message = (
            f'{name}[…]: "{at}" is not an axis'
            if isinstance(at, str)
            else f"{name}[{at:g}]: an axis is needed"
        )
        raise BlockError("variable-unknown", message, name, hint="axes are X Y Z A B C U V W")
    return at


def _own_position(motions: Motions, words: Words, name: str, at: Scalar, mode: str, value: float) -> None:
    words.positions[_axis_name(name, at)] = mode, value


def _own_feed(motions: Motions, words: Words, name: str, at: Scalar, mode: str, value: float) -> None:
    motions.axis_feeds[_axis_name(name, at)] = value


def _spindle_place(motions: Motions, words: Words, name: str, at: Scalar, mode: str, value: float) -> None:
    words.named[name] = mode, value


def _spindle_function(motions: Motions, words: Words, name: str, at: Scalar, mode: str, value: float) -> None:
    """M[1]=3, S[1]=500: a function or the speed of a spindle; those of other spindles than the master move nothing."""
    spindle = whole(at, "the number of a spindle") or motions.master
    if name == "S":
        words.named["S" if spindle == motions.master else f"S{spindle}"] = mode, value
    elif spindle == motions.master:
        words.m.append(round(value))


def _length_offset(motions: Motions, words: Words, name: str, at: Scalar, mode: str, value: float) -> None:
    """TOFFL[1]=: what is added to the tool's length 1; raise of its other lengths."""
    if number(at, "the number of a length") != 1.0:
        raise not_read(f"{name}[{number(at):g}]", "an offset of another length of the tool than length 1")
    words.named["TOFFL"] = mode, value


def _speed_of_cut(motions: Motions, words: Words, name: str, at: Scalar, mode: str, value: float) -> None:
    """SVC[n]=: the cutting speed of the tool of a spindle."""
    if whole(at, "the number of a spindle") == motions.master:
        words.named["SVC"] = mode, value


def _master(motions: Motions, name: str, values: list[Scalar | None]) -> None:
    """SETMS(n): spindle n is the one that S and M3 without a number mean, and that feeds a revolution follow; SETMS alone is the first."""
    motions.master = whole(values[0], "the number of a spindle") if values and values[0] is not None else 1


def _of_group(motions: Motions, words: Words, name: str, at: Scalar, mode: str, value: float) -> None:
    """G[8]=2: the G function of a group by its place in it (840D sl, Fundamentals, "G functions")."""
    group, place = whole(at, "the number of a group"), round(value)
    members = _GROUPS.get(group, ())
    if not 1 <= place <= len(members):
        raise not_read(
            f"G[{group}]={place}",
            f"of the groups {', '.join(map(str, sorted(_GROUPS)))} those are that G words name",
        )
    words.g.append(members[place - 1])


def _limit(motions: Motions, words: Words, name: str, at: Scalar, mode: str, value: float) -> None:
    """ACC[X]= and kin, in percent, FL[X]= in mm a minute: limits of an axis, which the machine file has."""
    if value != 100.0 or name == "FL":
        message = (
            f"{name}={value:g} changes a limit of an axis: the limits of the machine file are planned with"
        )
        motions.ip.warn_once("limit-kept", message, name, "a machine file of its own has other limits")


def _radius_of_feed(motions: Motions, words: Words, name: str, at: Scalar, mode: str, value: float) -> None:
    """FGREF[A]=: the radius at which F counts for a rotary axis of FGROUP."""
    message = f"FGREF={value:g} is passed over: F of a rotary axis that turns alone is in degrees a minute"
    hint = "the path is not changed by it; with an axis of X Y Z in the block F is the feed of these"
    motions.ip.warn_once("feed-group", message, name, hint)


def _limit_of_spindle(motions: Motions, words: Words, name: str, at: Scalar, mode: str, value: float) -> None:
    """LIMS[n]=: the bound of the speed under G96 of a spindle; those of other spindles than the master bound nothing here."""
    if whole(at, "the number of a spindle") == motions.master:
        words.named["LIMS"] = mode, value


#: G functions by the number of their group, in its order.
_GROUPS = {
    1: (0, 1, 2, 3), 6: (17, 18, 19), 7: (40, 41, 42), 8: (500, 54, 55, 56, 57, *range(505, 600)), 10: (60, 64, 641, 642, 643, 644, 645),
    13: (70, 71, 700, 710), 14: (90, 91), 15: (93, 94, 95, 96, 97, 931, 961, 971, 942, 952, 962, 972, 973), 18: (450, 451),
}  # fmt: skip


def refuse_conflict(codes: list[int]) -> None:
    """Raise where a block has two G functions of one group (alarm 12060 of the control)."""
    if len(codes) < 2:
        return
    found: dict[int, int] = {}
    for code in codes:
        other = found.setdefault(_GROUP_OF[code], code) if code in _GROUP_OF else code
        if other != code:
            message = f"G{other} and G{code} stand in one block: a group has one G function in force"
            raise BlockError("modal-conflict", message, f"G{code}", hint="leave one out, or write two blocks")


def in_force(motions: Motions, group: int) -> float:
    """Return the place in its group of the G function in force, $P_GG; raise where the code in force has no G number, or is not kept."""
    state = motions.ip.state
    origin = state.system if state.system <= frame_variables.LAST_ORIGIN else 0
    code = {
        1: int(motions.motion[1:]) if motions.motion[1:].isdigit() else None, 6: state.plane, 7: state.compensation,
        8: 500 if origin == 0 else (53 if origin < 5 else 500) + origin, 10: int(motions.path[0][1:]),
        13: motions.units, 14: 90 if motions.absolute else 91, 18: 451 if motions.sharp_corners else 450,
        15: state.feed_mode if state.constant_surface is None and state.feed_mode != 95 else None,
    }.get(group)  # fmt: skip
    if code not in _GROUPS.get(group, ()):
        message = f"$P_GG[{group}] is not read where it is none of G functions with a number that are kept"
        hint = f"groups {', '.join(map(str, sorted(_GROUPS)))} are read"
        raise BlockError("variable-unknown", message, "$P_GG", hint=hint)
    return float(_GROUPS[group].index(code) + 1)


#: The groups of G functions, threads among those of group 1.
_GROUP_OF = {
    **{code: group for group, members in _GROUPS.items() if group != 15 for code in members},
    **dict.fromkeys((33, 34, 35, 331, 332), 1), **dict.fromkeys((93, 94, 95), 15),
}  # fmt: skip
#: Settings of one index: an axis, a spindle or a group.
INDEXED: dict[str, Callable[[Motions, Words, str, Scalar, str, float], None]] = {
    **dict.fromkeys(("POS", "POSA"), _own_position),
    "FA": _own_feed,
    **dict.fromkeys(("M", "S"), _spindle_function),
    "G": _of_group,
    **dict.fromkeys(("SPOS", "SPOSA"), _spindle_place),
    "SVC": _speed_of_cut,
    "TOFFL": _length_offset,
    **dict.fromkeys(
        ("ACC", "FL", "OVRA", "VELOLIM", "ACCLIM", "JERKLIM", "VELOLIMA", "ACCLIMA", "JERKLIMA"),
        _limit,
    ),
    "FGREF": _radius_of_feed,
    # An auxiliary function goes to the PLC of the machine, a tolerance of an axis to its smoothing; POLF is where a stop of a thread leads.
    **dict.fromkeys(("H", "ATOL", "POLF"), lambda motions, words, name, at, mode, value: None),
    "LIMS": _limit_of_spindle,
}


def take_edge(motions: Motions) -> None:
    """Put the length of the tool in force, or with D0 none."""
    ip = motions.ip
    if motions.edge and not motions.store.tools.take(ip.state.tool, motions.edge):
        message = f"D{motions.edge} is read as D1: the tool table has one edge of each tool"
        ip.note("tool-edge", message, "D", f"$TC_DP3[{ip.state.tool},{motions.edge}]= describes it")
    if ip.state.length_code == frames.FOLLOWED:
        tool_point.begin(
            ip, table_offset(ip, ip.state.tool)[2] if motions.edge and ip.state.tool else 0.0, "TRAORI"
        )
    else:
        tool = ip.state.tool if motions.edge else 0
        with motions.shifting():
            motions.emit({"h": float(tool)} if tool else {}, (430 if tool else 490,))


# Switches and commands with arguments.


def _traori(motions: Motions, name: str = "", values: Sequence[Scalar | None] = ()) -> None:
    if values and values[0] not in (None, 1.0):
        raise not_read(f"TRAORI({values[0]})", "the machine file describes one transformation")
    ip = motions.ip
    motions.heading = None
    tool_point.turn_on(ip, Block({"h": float(ip.state.tool)}), "TRAORI")


def _transmit(motions: Motions, name: str = "", values: Sequence[Scalar | None] = ()) -> None:
    """TRANSMIT: X and Y are those of the face of the part, where the axes are X and C."""
    if values and values[0] not in (None, 1.0):
        raise not_read(f"TRANSMIT({values[0]})", "the first transformation is")
    motions.settle()
    rotary_paths.face(motions.ip, "TRANSMIT")
    motions.pole, motions.heading = 0j, None


def _tracyl(motions: Motions, name: str, values: list[Scalar | None]) -> None:
    """TRACYL(d): Y is the way on the surface of a cylinder of that diameter, unrolled, where the axis is C."""
    numbers = [0.0 if value is None else number(value) for value in values]
    if not numbers or numbers[0] <= 0.0 or any(value not in (0.0, 1.0) for value in numbers[1:]):
        raise not_read(
            f"TRACYL({', '.join(f'{v:g}' for v in numbers)})", "TRACYL(40) is, with the diameter alone"
        )
    motions.settle()
    plane = motions.ip.state.plane
    rotary_paths.cylinder(motions.ip, Block({"c": numbers[0] / 2.0}, (1070,)))
    motions.ip.rewrite = None
    motions.emit({}, (10 * plane,))
    motions.pole, motions.heading = 0j, None


def _trafoof(motions: Motions) -> None:
    plane = motions.ip.state.plane
    motions.settle()
    if rotary_paths.end(motions.ip, "TRAFOOF"):
        motions.emit({}, (10 * plane,))
        motions.pole, motions.heading = 0j, None
        return
    tool_point.turn_off(motions.ip)
    motions.ip.state.length_code = 49
    take_edge(motions)


def _sets(name: str, value: str | bool) -> Callable[[Motions], None]:
    """Return what a command does that puts a mode in force."""
    return lambda motions: setattr(motions, name, value)


def _contour_feed(arcs: str) -> Callable[[Motions], None]:
    """Return what CFC, CFIN and CFTCP do: F is that along the contour on all compensated arcs, on those inside, or on none."""
    return lambda motions: feed_along_contour(motions.ip, arcs)


def _each_axis_by_itself(motions: Motions) -> None:
    """RTLIOF: in a traverse each axis goes as fast as it can, so that the way is no line (Fundamentals, "RTLION, RTLIOF")."""
    message = "RTLIOF lets each axis traverse by itself; here a traverse goes straight"
    hint = "the ends are the same, the way between them is not; RTLION goes straight"
    motions.ip.warn_once("traverse-straight", message, "RTLIOF", hint)


_SWITCHES: dict[str, Callable[[Motions], None]] = {
    "CFC": _contour_feed("all"),
    "CFIN": _contour_feed("inside"),
    "CFTCP": _contour_feed(""),
    # Rotary axes turn evenly, or the tool turns in a plane; directions are those of the program, or of the machine's table.
    "ORIAXES": _sets("turning", "axes"),
    **dict.fromkeys(("ORIVECT", "ORIPLANE"), _sets("turning", "plane")),
    # They say what A2 B2 C2 turn about.
    **{name: _sets("angles", name) for name in ("ORIEULER", "ORIRPY", "ORIRPY2", "ORIVIRT1", "ORIVIRT2")},
    "ORIWKS": _sets("machine_vectors", False),
    "ORIMKS": _sets("machine_vectors", True),
    "RTLIOF": _each_axis_by_itself,
    "TRAORI": _traori,
    "TRAFOOF": _trafoof,
    "TRANSMIT": _transmit,
    **{
        f"{name}{axis}": swivelling.along_tool(f"{name}{axis}")
        for name in ("TOROT", "TOFRAME")
        for axis in ("", *"XYZ")
    },
    **dict.fromkeys(("TOROTOF", "TOFRAMEOF"), swivelling.turn_back),
    # X is a diameter, in G90 alone, or a radius.
    "DIAMON": _sets("diameter", "G90 G91"),
    "DIAM90": _sets("diameter", "G90"),
    "DIAMOF": _sets("diameter", "none"),
}


def _set_actual(motions: Motions, name: str, values: list[Scalar | None]) -> None:
    """PRESETON(X,0,C,90): axes get other machine coordinates where they stand, which all coordinates of theirs count from; SUPA alone does not.

    Source: NCXchange, "SINUMERIK 840D and 840D sl", sections 2 and 3.
    """
    ip = motions.ip
    offset, preset = ip.state.g92.copy(), dict(motions.store.preset)
    turned = bool(ip.state.rotation) or ip.state.length_code == frames.FOLLOWED or ip.rewrite is not None
    for axis, value in zip(values[::2], values[1::2], strict=False):
        letter, wanted = _axis_name(name, axis if axis is not None else 0.0).lower(), number(value or 0.0)
        column = AXIS_INDEX[letter]
        diameter = letter == "x" and "G9" in motions.diameter and wanted != 0.0
        if ip.state.compensation != 40 or diameter or (turned and column < 3):
            what = (
                "under G41 or G42"
                if ip.state.compensation != 40
                else "of a diameter"
                if diameter
                else "in a turned system"
            )
            raise not_read(f"{name} {what}", "another position of an axis")
        delta = ip.machine_position()[column] - preset.get(letter, 0.0) - wanted
        offset[column] += delta
        preset[letter] = preset.get(letter, 0.0) + delta
    if not values or len(values) % 2:
        message = f"{name} has no axis, or one without a position"
        raise BlockError("sub-arguments", message, name, hint="PRESETON(C,0) makes 0 of where C stands")
    motions.store.preset = preset
    set_g92(ip, offset)


def _message(motions: Motions, name: str, values: list[Scalar | None]) -> None:
    """MSG("..."): show a text."""
    text = "" if not values or values[0] is None else str(values[0])
    if text:
        motions.ip.sink.call(f'MESSAGE("{text}")', Event("message", False, values={"text": text}))


def nothing(motions: Motions, name: str, values: list[Scalar | None]) -> None:
    """Accept a word that changes no motion."""


def _path_axes(motions: Motions, name: str, values: list[Scalar | None]) -> None:
    """FGROUP(X,Y): the axes whose path has the feed F; it is that of X Y Z here, as without FGROUP."""
    axes = {value for value in values if isinstance(value, str)}
    if axes and axes != set("XYZ"):
        message = f"FGROUP of {' '.join(sorted(axes))} is passed over: F is the feed of X Y Z, or of the rotary axes where these alone turn"
        hint = "the path is not changed by it; times where other axes move differ from the control's"
        motions.ip.warn_once("feed-group", message, name, hint)


def _surface_axis(motions: Motions, name: str, values: list[Scalar | None]) -> None:
    """SCC[X]: the axis from whose zero G96 takes the diameter, X here; raise where it is another (SINUMERIK ONE, NC programming, 12/2019, p. 99)."""
    if values != ["X"]:
        raise not_read(name, f"the speed of the spindle by {values[0]}")


def _spline_axes(motions: Motions, name: str, values: list[Scalar | None]) -> None:
    """SPLINEPATH(1,X,Y,Z): the axes of which splines are made, as at the start; raise where one of X, Y and Z goes along a line beside the spline."""
    left = set("XYZ").difference(str(value) for value in values[1:])
    if left:
        raise not_read(f"SPLINEPATH without {' '.join(sorted(left))}", "splines are of X, Y and Z")


def _geometry_axes(motions: Motions, name: str, values: list[Scalar | None]) -> None:
    """GEOAX(): X, Y and Z are the geometry axes, as at the start; GEOAX(1,X) says so of one; raise where another axis becomes one."""
    wanted = dict(zip(values[::2], values[1::2], strict=False))
    if len(values) % 2 or any(
        "XYZ"[whole(k or 0.0) - 1 : whole(k or 0.0)] != axis for k, axis in wanted.items()
    ):
        raise not_read(name, "other axes as those of the geometry")


def _other_channel(motions: Motions, name: str, values: list[Scalar | None]) -> None:
    """INIT, START, WAITE, GET, RELEASE: programs and axes of other channels."""
    message = f"{name} is passed over: the other channels do not run here"
    motions.ip.note_once("channel-alone", message, name, "the time that it waits is not counted")


def _alarm(motions: Motions, name: str, values: list[Scalar | None]) -> None:
    """SETAL(n, "..."): an alarm; the program goes on."""
    which = f"alarm {values[0] or 0.0:g}" if values and not isinstance(values[0], str) else "an alarm"
    motions.ip.note("program-alarm", f"the program raises {which}", name)


def _interrupt(motions: Motions, name: str, values: list[Scalar | None]) -> None:
    """SETINT(n) PRIO=1 NAME: a subprogram that a signal calls."""
    motions.ip.note(
        "interrupt-not-run", "the subprogram of SETINT runs where a signal comes, which none does here", name
    )


def rounding(motions: Motions, words: Words) -> None:
    """RNDM=: rounding of all corners that follow; 0 ends it. FRCM=: their feed, and that of other corners."""
    if "FRCM" in words.named:
        motions.corner_feed = words.named.pop("FRCM")[1]
    if "RNDM" in words.named:
        size = words.named.pop("RNDM")[1]
        if size < 0.0:
            message = f"RNDM={size:g} is negative"
            raise BlockError("corner-size", message, "RNDM", hint="a radius is positive, and RNDM=0 ends it")
        motions.rounding = size


CALLS: dict[str, Callable[[Motions, str, list[Scalar | None]], None]] = {
    "MSG": _message,
    "TRAORI": _traori,
    "TRANSMIT": _transmit,
    "TRACYL": _tracyl,
    "SETAL": _alarm,
    "SETMS": _master,
    "SETINT": _interrupt,
    "FGROUP": _path_axes,
    "SCC": _surface_axis,
    **dict.fromkeys(("PRESETON", "PRESETONS"), _set_actual),
    "SPLINEPATH": _spline_axes,
    "GEOAX": _geometry_axes,
    **measuring.CYCLES,
    **dict.fromkeys(("INIT", "START", "WAITE", "GET", "GETD", "RELEASE"), _other_channel),
    **dict.fromkeys(
        ("WORKPIECE", "CYCLE832", "TRAILOF", "LEADOF", "EGOFS", "POLFMASK", "POLFMLIN", "WAITM", "SETM", "CLEARM", "GETSELT", "STOPRE", "FIFOCTRL",
         "FLIM", "VELOLIM", "ACCLIM", "DISPLOF", "SOFTA", "BRISKA", "SPCON", "SPCOF", "CPROT", "GROUP_BEGIN", "GROUP_END", "GROUP_ADDEND",
         "F_HEAD", "E_HEAD", "E_END", "F_END", "PROTD", "WAITP", "WAITS", "WAITMC",
         "MMC", "WRITE", "DELETE", "CLRINT", "ENABLE", "DISABLE", "CANCEL", "SETPIECE", "COARSEA", "FINEA", "IPOENDA",
         # Folders in which subprograms are looked for; --include names them here.
         "CALLPATH"),
        nothing,
    ),
}  # fmt: skip

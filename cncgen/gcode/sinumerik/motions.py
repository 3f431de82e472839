"""One block of SINUMERIK on the interpreter: modes, positions, motions, and the words that act by themselves."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from cncgen.gcode.block import AXES, AXIS_INDEX, Block
from cncgen.gcode.codes.affine import Frames
from cncgen.gcode.codes.corners import leave_out
from cncgen.gcode.codes.offsets import use_system
from cncgen.gcode.codes.spindle import waited_s
from cncgen.gcode.codes.turning_profiles import Segment
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinumerik import (
    arcs,
    commands,
    contour_cycles,
    corner_turning,
    curves,
    cycles,
    engraving,
    faces,
    feeds_and_tools,
    frame_variables,
    g_functions,
    grooves,
    measuring,
    orientation,
    pockets,
    polar,
    soft_approach,
    swivelling,
    thread_cutting,
    thread_milling,
    unread_cycles,
)
from cncgen.gcode.sinumerik.expressions import Function, Quoted, Scalar, Value, Variable, evaluate, number
from cncgen.gcode.sinumerik.reading import Item
from cncgen.gcode.sinumerik.said import file_name
from cncgen.gcode.sinumerik.variables import Store
from cncgen.gcode.state.modal import PLANE_AXES, in_plane
from cncgen.gcode.text.labels import Cursor

#: Meaning of a coordinate that the block states.
MODES = ("AC", "IC", "DC", "ACP", "ACN")
#: Those of X, and the part of the value that counts: diameters and radii whatever is in force (840D sl, Fundamentals, "DAC, DIC, RAC, RIC").
_OF_X = {"DAC": 0.5, "DIC": 0.5, "RAC": 1.0, "RIC": 1.0}
_UNREAD_MODES = ("CAC", "CIC", "CDC", "CACP", "CACN", "QU", "HF")
_STEPS = ("IC", "DIC", "RIC")
#: Motions: their number among the interpreter's codes; others are worked out here.
_MOTIONS = {0: "G0", 1: "G1", 2: "G2", 3: "G3", 33: "G33", 34: "G34", 35: "G35", 331: "G331", 332: "G332"}
_PLAIN = {"G0": 0, "G1": 10, "G2": 20, "G3": 30}
#: Words that mean nothing where nothing uses them, as the feed of a corner in a block without one.
_IDLE = frozenset(
    ("FRC", "H", *(f"H{k}" for k in range(100)), "SPOS", "SPOSA", "LIMS", "DISC", "FAD", "OTOL", "CTOLG0", "OTOLG0", "STOLF", "N", "ALF", "DILF")
)  # fmt: skip
_FED = frozenset((10, 20, 30, 50))
#: The state that a contour may change while it is only examined.
_EXAMINED = ("motion", "absolute", "pole", "polar", "rounding", "diameter", "modal", "heading", "path", "curve", "here")  # fmt: skip
_CYCLES = {
    **cycles.CYCLES, "CYCLE800": swivelling.swivel, "CYCLE60": engraving.engrave, "CYCLE61": faces.face_of_blank, "CYCLE71": faces.face, "CYCLE76": faces.rectangle,
    "CYCLE77": faces.circle, "POCKET3": pockets.rectangle, "POCKET4": pockets.circle, "SLOT1": pockets.slots,
    "LONGHOLE": pockets.long_holes, "POCKET1": pockets.old_rectangle, "POCKET2": pockets.old_circle, "SLOT2": pockets.bows,
    "CYCLE70": thread_milling.thread_of_profile, "CYCLE90": thread_milling.thread, "CYCLE92": grooves.cut_off, "CYCLE93": grooves.groove, **contour_cycles.CYCLES,
    **corner_turning.CYCLES,
    **thread_cutting.CYCLES,
}  # fmt: skip


@dataclass(slots=True)
class Words:
    """The words of a block, values known."""

    g: list[int] = field(default_factory=list)
    m: list[int] = field(default_factory=list)
    axes: dict[str, tuple[str, float]] = field(default_factory=dict)
    named: dict[str, tuple[str, float]] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)
    polynomials: dict[str, list[float]] = field(default_factory=dict)
    commands: list[str] = field(default_factory=list)
    calls: list[tuple[str, tuple[Value | None, ...] | None]] = field(default_factory=list)
    positions: dict[str, tuple[str, float]] = field(default_factory=dict)

    def value(self, name: str) -> float | None:
        """Return the value of a word, None where it does not stand in the block."""
        found = self.named.get(name)
        return None if found is None else found[1]


class Motions:
    """The state that SINUMERIK keeps from block to block, on an interpreter that is always in G90.

    Attributes:
        motion: The motion in force: ``G0`` … ``G3``, ``G33`` to ``G35``, ``CT``, ``CIP``, ``ASPLINE``, ``CSPLINE``, ``BSPLINE``, ``POLY``.
        pole: Pole of polar coordinates in the plane.
        polar: Last radius and angle (degrees) of polar words.
        rounding: RNDM. corner_feed: FRCM, 0 where corners have the feed of the contour.
        diameter: In which modes X is a diameter: ``G90 G91`` (DIAMON), ``G90`` (DIAM90), ``none``; empty before the program states
        one. turret: Whether T changes the tool at once, as on lathes: the program has no M6. modal: MCALL: name and arguments.
        in_modal: Whether that call is in progress. programmable: The frame of TRANS ROT SCALE MIRROR, and that of CYCLE800 before it.
    """

    def __init__(
        self,
        ip: Interpreter,
        store: Store,
        call: Callable[[str, tuple[Any, ...] | None, int], None],
        contour: Callable[[str], list[Segment]],
    ) -> None:
        self.ip, self.store, self.begin_call, self.contour = ip, store, call, contour
        self.motion = "G1"
        self.absolute = True
        self.pole = 0j
        self.polar = (0.0, 0.0)
        self.rounding = self.corner_feed = 0.0
        #: SD of a block of BSPLINE without axes.
        self.degree = 3.0
        self.diameter = ""
        self.turret = False
        #: Factor of F, since G70 counts lengths in inches and F in mm.
        self.feed_scale = 1.0
        #: G70, G71, G700 or G710.
        self.units = 71
        #: OVR, as a part of F; OFFN; FA of the axes that POS moves.
        self.override = 1.0
        self.allowance = 0.0
        self.axis_feeds: dict[str, float] = {}
        #: The master spindle, and speeds of the others, whose revolutions G4 may count.
        self.master = 1
        self.speeds: dict[str, float] = {}
        self.modal: tuple[str, tuple[Value | None, ...] | None] | None = None
        self.in_modal = False
        #: Contours that CYCLE62 has named for the cycles behind it.
        self.contours: list[str] = []
        self.edge = 1
        self.path: tuple[str, float | None] = ("G64", None)
        self.sharp_corners = False
        self.frames = Frames()
        self.curve: curves.OpenCurve | None = None
        self.here = Cursor(0, 0, 1)
        self.heading: list[float] | None = None
        #: Soft approach: G341, the side (G140 to G143), the one that waits for the contour, and motion and feed before the block.
        self.soft_in_plane, self.soft_side = False, 2
        self.soft: soft_approach.Soft | None = None
        self.before = ("G1", 0.0)
        #: A line by its angle alone, which the next one ends.
        self.angled: polar.Angled | None = None
        #: How the tool turns in one block, "axes", "plane" or unsaid, and whether its directions are those of the machine.
        self.turning = ""
        self.machine_vectors = False
        #: ORIEULER or ORIRPY, what A2 B2 C2 turn about.
        self.angles = ""
        #: Whether G18 is taken for the plane in which a lathe begins.
        self.plane_assumed = False
        #: Whether the program has said what F is: G93, G94 or G95.
        self.feed_said = False
        #: Coordinates of axes before a frame or the tool's length changed, from which increments count until the axis moves.
        self.carried: dict[str, float] = {}
        #: Whether the plain lines that were run last moved.
        self.plain_moved = False

    # State shared by handlers.

    def begin(self, *, turns: bool = False) -> None:
        """Put the modes in force with which SINUMERIK begins, on lathes where the program turns and says no other."""
        self.emit({}, (210,))
        self.ip.contour_feed = "all"
        if turns:
            self.emit({}, (180,))
            self.diameter, self.plane_assumed = "G90 G91", True
            message = "the program turns and says neither DIAMON nor DIAMOF before X: X is read as a diameter, in G18, as most lathes begin"
            hint = "DIAMON or DIAMOF before the first motion says which"
            self.ip.warn("diameter-doubtful", message, hint=hint)

    def emit(self, words: dict[str, float], g: tuple[int, ...] = (), m: tuple[int, ...] = ()) -> None:
        """Execute a block of the interpreter's codes, at the line in progress."""
        here, state = self.here, self.ip.state
        if state.feed_mode == 93 and state.feed and "f" not in words and not _FED.isdisjoint(g):
            # F stays in force under G93, where the interpreter has it in each block (840D sl, Fundamentals, "Feedrate (G93, G94, G95)").
            words["f"] = state.feed
        for name in self.carried.keys() & words.keys():
            del self.carried[name]
        block = Block(words, g, m, None, here.source, here.line, here.offset)
        if self.ip.guard is not None:
            self.ip.base.block = block
            self.ip.guard(self.ip, block)
        self.ip.execute(block)

    @contextmanager
    def shifting(self) -> Iterator[None]:
        """Keep the coordinates while an offset changes: with increments it is traversed (setting data 42440 and 42442 = 1, as delivered)."""
        before = self.ip.state.position.copy()
        yield
        for axis, old, new in zip(AXES, before, self.ip.state.position, strict=True):
            if old != new:
                self.carried.setdefault(axis, old)

    def refuse_turned_origin(self, word: str) -> None:
        """Raise where the origin turns about Z beneath a direction, which would turn with it."""
        if self.ip.state.rotation:
            message = f"{word} gives a direction, and the origin in force is turned by {self.ip.state.rotation:g} degrees: that is not read"
            hint = "ROT Z turns the programmable frame, in which directions are read"
            raise BlockError("not-read", message, word, hint=hint)

    def plane(self) -> tuple[int, int, int]:
        """Return the columns of the plane's axes and of the axis beside it."""
        first, second, normal = PLANE_AXES[self.ip.state.plane]
        return first, second, normal

    def here_in_plane(self) -> complex:
        """Return where the tool is in the plane."""
        return in_plane(self.ip.state.position, self.ip.state.plane)

    def move(self, end: dict[str, float], *, rapid: bool) -> None:
        """Go to coordinates in a straight line."""
        self.emit({axis.lower(): value for axis, value in end.items()}, (0 if rapid else 10,))

    def dwell(self, time: float) -> None:
        """Wait: seconds, or revolutions where negative."""
        seconds = waited_s(self.ip.state, time)
        if seconds:
            self.emit({"p": seconds}, (40,))

    def save(self) -> tuple[Any, ...]:
        """Return the state that SAVE of PROC keeps, as `restore` takes it."""
        state = self.ip.state
        modes = state.plane, state.feed, state.feed_mode, self.path, state.system
        return self.motion, self.absolute, self.frames, *modes

    def fields(self) -> dict[str, Any]:
        """Return the state that a contour may change while it is only examined."""
        return {name: getattr(self, name) for name in _EXAMINED}

    def set_fields(self, fields: dict[str, Any]) -> None:
        for name, value in fields.items():
            setattr(self, name, value)

    def restore(self, saved: tuple[Any, ...]) -> None:
        motion, absolute, frames, plane, feed, feed_mode, path, system = saved
        self.settle()
        self.motion, self.absolute = motion, absolute
        if system != self.ip.state.system:
            use_system(self.ip, system)
        if frames != self.frames:
            swivelling.take_frames(self, frames)
        mode = (feed_mode * 10,) if feed_mode != self.ip.state.feed_mode else ()
        self.emit({"f": feed} if feed else {}, (10 * plane, *mode))
        if path != self.path:
            self.set_path(*path)

    def assign(self, name: str, indices: list[Scalar], value: Scalar) -> None:
        """Set an R parameter or a variable."""
        if name == "R" and len(indices) == 1:
            self.store.set_parameter(number(indices[0], "the number of R"), value)
        elif name[0] == "R" and name[1:].isdigit() and not indices:
            self.store.set_parameter(float(name[1:]), value)
        elif name in frame_variables.VARIABLES:
            frame_variables.set_part(self, name, indices, number(value, f"the value of {name}"))
        else:
            self.store.set_value(name, indices, value)

    # One block.

    def assignments(self, items: list[Item]) -> None:
        """Do a block of R parameters alone."""
        for _, index, value in items:
            where = number(evaluate(index, self.store), "the number of R")
            self.store.set_parameter(where, evaluate(value, self.store))

    def block(self, items: list[Item], here: Cursor) -> bool:
        """Execute a block; tell whether it ends its program."""
        self.here = here
        self.before = self.motion, self.ip.state.feed
        words = Words()
        for item in items:
            self._take(item, words)
        if words.commands or words.calls:
            commands.run(self, words)
        commands.rounding(self, words)
        self._modes(words)
        again = self._calls_again(words)
        feeds_and_tools.take(self, words)
        self._call(words, cycles=False)
        ended = feeds_and_tools.functions(self, words)
        feeds_and_tools.dwell(self, words)
        moved = self._move(words) or again
        self._call(words, cycles=True)
        measuring.keep(self, words)
        self._left_over(words)
        if moved and self.modal is not None and not self.in_modal:
            name, arguments = self.modal
            # A subprogram ends the state when it is left (`running`); its own motions call nothing.
            self.in_modal = True
            self.run_call(name, arguments, 1)
            if name in _CYCLES and not self.store.is_file(name):
                self.in_modal = False
        return ended

    def _calls_again(self, words: Words) -> bool:
        """Tell whether a block without a motion runs the call of MCALL: S or F under G0 or G1, or G0 or G1 with nothing but G functions
        (840D sl, Job planning, "Modal subprogram call (MCALL)")."""
        if (
            self.modal is None
            or self.in_modal
            or words.axes
            or self.motion not in ("G0", "G1")
            or 4 in words.g
        ):
            return False
        bare = not (words.named or words.m or words.commands or words.calls or words.texts)
        said = next((name for name in ("F", "S") if name in words.named), "")
        if words.named.keys() - {"F", "S"} or not (said or (bare and {0, 1} & {*words.g})):
            return False
        message = f"{said or self.motion} without a motion runs {self.modal[0]} of MCALL where the tool is"
        hint = "it does on the control: F, S, G0 and G1 stand before MCALL or in blocks with a motion"
        self.ip.warn_once("modal-call", message, said or "G", hint)
        return True

    def _take(self, item: Item, words: Words) -> None:
        """Sort an item of the block; settings of variables are done at once."""
        kind = item[0]
        if kind == "word":
            self._word(item[1], number(item[2]), words)
        elif kind == "assign":
            self.assignments([item])
        elif kind == "set":
            self._setting(item[1], item[2], item[3], words)
        elif kind == "poly":
            _, (name, indices), values = item
            if name != "PO" or len(indices) != 1:
                message = f"{name}=( , ) does not belong to a polynomial"
                raise BlockError("syntax", message, name, hint="PO[X]=(end, a2, a3)")
            self._polynomial(evaluate(indices[0], self.store), values, words)
        elif kind == "text" and words.commands[-1:] in (["EXTCALL"], ["CALL"]):
            words.calls.append(("EXTCALL", (Quoted(item[1]),)))
            words.commands.pop()
        elif kind == "name" and words.commands[-1:] == ["CALL"]:
            words.calls.append(("EXTCALL", (Variable(item[1], ()),)))
            words.commands.pop()
        elif kind == "name":
            words.commands.append(item[1])
        elif kind == "call":
            words.calls.append((item[1], item[2]))
        else:
            raise BlockError("syntax", "a text stands alone in the block", hint='MSG("...") shows a text')

    def _word(self, letter: str, value: float, words: Words) -> None:
        if letter == "G":
            words.g.append(feeds_and_tools.whole("G", value))
        elif letter == "M":
            words.m.append(feeds_and_tools.whole("M", value))
        elif letter == "L":
            words.calls.append((f"L{feeds_and_tools.whole('L', value)}", None))
        elif letter in AXES.upper():
            _once(words.axes, letter, ("", value))
        else:
            _once(words.named, letter, ("", value))

    def _polynomial(self, axis: Scalar, values: Sequence[Value], words: Words) -> None:
        """Take PO[X]=(end, a2, a3)."""
        words.polynomials[str(axis)] = [number(evaluate(value, self.store)) for value in values]

    def _setting(self, name: str, indices: tuple[Value, ...], node: Value, words: Words) -> None:
        """Take NAME=value: a word, an R parameter or a variable."""
        at = [evaluate(index, self.store) for index in indices]
        if name == "AX" and len(at) == 1 and isinstance(at[0], str):
            if len(at[0]) != 1 or at[0] not in AXES.upper():
                message = f'AX[...]: "{at[0]}" is not an axis'
                raise BlockError("variable-unknown", message, "AX", hint="axes are X Y Z A B C U V W")
            name, at = at[0], []
        if name == "PO" and len(at) == 1:
            # PO[X]=(5) is a line of that axis.
            self._polynomial(at[0], (node,), words)
            return
        mode, node = _mode_of(name, at, node)
        if not mode and frame_variables.is_frame(node):
            frame_variables.set_frame(self, name, at, node)
            return
        own = self.store.has(name)
        if not at and not own and _is_word(name):
            self._set_word(name, mode, evaluate(node, self.store), words)
        elif len(at) == 1 and not own and name in commands.INDEXED:
            commands.INDEXED[name](self, words, name, at[0], mode, number(evaluate(node, self.store)))
        elif mode:
            message = f"{name}={mode}(...): {name} is not an axis"
            raise BlockError("variable-unknown", message, name, hint="axes are X Y Z A B C U V W")
        else:
            if not own:
                commands.check_name(name)
            self.assign(name, at, evaluate(node, self.store))

    def _set_word(self, name: str, mode: str, value: Scalar, words: Words) -> None:
        """Take a word that is written NAME=value."""
        axis = name in AXES.upper()
        if isinstance(value, str):
            words.texts[name] = value
        elif name in ("G", "M", "L") or (axis and not mode):
            self._word(name, value, words)
        else:
            _once(words.axes if axis else words.named, name, (mode, value))

    # Calls.

    def _call(self, words: Words, *, cycles: bool) -> None:
        """Run the calls with arguments: the cycles, which begin where the motion of their block ends, or the others."""
        for name, arguments in [call for call in words.calls if (call[0] in _CYCLES) is cycles]:
            times = words.named.pop("P", ("", 1.0))[1]
            self.run_call(name, arguments, round(times))

    def run_call(self, name: str, arguments: tuple[Value | None, ...] | None, times: int) -> None:
        """Run a cycle, a command with arguments, or a subprogram."""
        if commands.CALLS.get(name) is commands.nothing:
            return
        if commands.couples_spindles(name, arguments or ()):
            message = f"{name} is passed over: a coupling of spindles moves no axis here"
            self.ip.note_once("channel-alone", message, name, "the time until they turn alike is not counted")
            return
        if name in _CYCLES and self.store.is_file(name):
            message = f"{name} is the subprogram of this name, which a control takes before its own cycle"
            self.ip.note_once("cycle-own", message, name, "rename the file if the control's cycle is meant")
            self.begin_call(name, arguments, times)
        elif name in _CYCLES or name in commands.CALLS:
            if name != "MSG":
                self.settle()
            parameters = cycles.CycleParameters(
                None if node is None else evaluate(node, self.store) for node in arguments or ()
            )
            (commands.CALLS.get(name) or _CYCLES[name])(self, name, parameters)
            if name in _CYCLES:
                parameters.tell_beyond(self, name)
        elif unread_cycles.is_cycle(name) or unread_cycles.is_step(name):
            # A cycle of the machine's builder, or the user's, is a subprogram, and its name may begin as a step's does.
            try:
                self.begin_call(name, arguments, times)
            except BlockError as error:
                raise (unread_cycles.refused(name) if error.code == "sub-missing" else error) from None
        elif name == "EXTCALL":
            values = [None if node is None else evaluate(node, self.store) for node in arguments or ()]
            self.begin_call(file_name(str(values[0] if values else "")), None, times)
        else:
            commands.check_name(name)
            self.begin_call(name, arguments, times)

    # Modes and technology.

    def _modes(self, words: Words) -> None:
        """Put the G functions of a block in force, in the order of the text."""
        feeds_and_tools.modal_values(self, words)
        commands.refuse_conflict(words.g)
        for code in words.g:
            if code in _MOTIONS:
                self.set_motion(_MOTIONS[code])
            elif code == 40 and soft_approach.RETRACT.keys() & set(words.g):
                # The retraction ends compensation behind its arc.
                continue
            elif code not in (4, 9, 53, 153, 74, 75) and code not in soft_approach.CODES:
                g_functions.mode(self, code, words)
        if {"ADIS", "ADISPOS", "CTOL", "OTOL"} & words.named.keys():
            g_functions.tolerance(self, words)

    def set_motion(self, name: str) -> None:
        """Take another motion; a curve of several blocks ends."""
        if name != self.motion:
            self.end()
            self.motion, self.degree = name, 3.0

    def end(self) -> None:
        """End a curve of several blocks."""
        if self.curve is not None:
            curve, self.curve = self.curve, None
            curve.close(self)
        if self.motion == "BSPLINE" and self.ip.guard is not None:
            self.emit({}, (210,) if not self.ip.state.inches else (200,))

    def settle(self) -> None:
        """End a curve, and pass on a motion that waits for a corner."""
        self.end()
        leave_out(self.ip)
        if self.soft is not None:
            soft, self.soft = self.soft, None
            self.ip.state.position = soft.begin
            raise soft.fault("is not followed by a motion in the plane")
        if self.angled is not None:
            angled, self.angled = self.angled, None
            raise angled.fault("is not followed by a line to a point at an angle")

    def set_path(self, name: str, tolerance: float | None) -> None:
        """Take a mode of the path: G60, G64 and kin with a tolerance."""
        self.path = (name, tolerance)
        if name == "G60":
            self.emit({}, (611,))
        else:
            self.emit({} if tolerance is None else {"p": tolerance}, (640,))

    # Plain lines.

    def is_plain(self) -> bool:
        """Tell whether words of axes and offsets, and F, mean in plain lines what they mean to the interpreter."""
        return (
            self.motion in _PLAIN
            and self.curve is None
            and self.soft is None
            and self.angled is None
            and (self.modal is None or self.in_modal)
            and self.rounding == 0.0
            and not self.carried
            and "G9" not in self.diameter
            and self.ip.state.feed_mode != 93
            and self.feed_scale == self.override == 1.0
        )

    def run_plain(self, run: Callable[[], int]) -> int:
        """Run plain lines with the modes that the interpreter does not have; return what `run` returns."""
        state = self.ip.state
        before = state.motion
        state.motion, state.absolute = _PLAIN[self.motion], self.absolute
        self.plain_moved = False
        try:
            return run()
        finally:
            state.absolute = True
            self.motion = f"G{state.motion // 10}"
            if not self.plain_moved:
                state.motion = before

    def take_plain(self, begin: list[float], motion: memoryview, end: memoryview, centre: memoryview) -> None:
        """Keep the direction in which the last of plain motions ends."""
        self.plain_moved = True
        last = len(motion) - 1
        rows: Any = end[max(last - 1, 0) :].tolist()
        finish = rows[-1]
        if motion[last] < 2:
            start = rows[0] if last else begin
            self.heading = [b - a for a, b in zip(start, finish, strict=True)]
        else:
            about = complex(centre[last, 0], centre[last, 1])
            arcs.head(self, in_plane(finish, self.ip.state.plane) - about, clockwise=motion[last] == 2)

    # Motion.

    def _move(self, words: Words) -> bool:
        """Make the motion of a block; tell whether it has one."""
        if 74 in words.g or 75 in words.g:
            g_functions.home(self, words)
            return False
        orientation.take(self, words)
        soft = soft_approach.of(self, words)
        if soft is not None:
            run = soft_approach.approach if soft.code in soft_approach.APPROACH else soft_approach.retract
            run(self, soft, words)
            return True
        spoke = {"AP", "RP"} & words.named.keys()
        arc = {"I", "J", "K", "CR", "AR", "ANG", "TURN", "I1", "J1", "K1"} & words.named.keys()
        if words.positions:
            commands.position(self, words, beside=bool(words.axes or spoke or arc or words.polynomials))
        if not (words.axes or spoke or arc or words.polynomials):
            if self.motion == "BSPLINE" and "SD" in words.named:
                self.degree = words.named.pop("SD")[1]
            return False
        if self.angled is not None:
            polar.meet(self, words)
        elif polar.wait(self, words):
            return True
        end = self.end_of(words)
        if {53, 153} & set(words.g) or "SUPA" in words.commands:
            self.settle()
            self._machine(words)
            return True
        feed, own, motion = self.ip.state.feed, words.named.pop("FB", None), self.motion
        if own is not None:
            self.emit({"f": own[1] * self.feed_scale * self.override})
        if 63 in words.g:
            # It taps at F whatever motion is in force, which is so again behind it (840D sl, Fundamentals, "Tapping with compensating chuck").
            self.set_motion("G1")
        if 9 in words.g and self.path[0] != "G60":
            path = self.path
            self.set_path("G60", None)
            self.make(words, end)
            self.set_path(*path)
        else:
            self.make(words, end)
        if 63 in words.g:
            self.motion = motion
        if own is not None and feed:
            self.emit({"f": feed})
        return True

    def go(self, words: Words) -> None:
        """Make the motion in force to the axis words of a block."""
        self.make(words, self.end_of(words))

    def _machine(self, words: Words) -> None:
        """Move to machine coordinates."""
        if self.motion not in ("G0", "G1"):
            message = f"machine coordinates go with G0 and G1, not with {self.motion}"
            raise BlockError("g53-motion", message, hint="write G0 SUPA")
        if not self.absolute and any(mode == "" for mode, _ in words.axes.values()):
            message = "machine coordinates are absolute, and G91 is in force"
            raise BlockError("g53-motion", message, hint="use G90, or AC()")
        preset = {} if "SUPA" in words.commands else self.store.preset
        now, length = self.ip.machine_position(), self.ip.state.offsets()[3]
        out = dict[str, float]()
        for axis, (mode, value) in words.axes.items():
            letter, column = axis.lower(), AXIS_INDEX[axis.lower()]
            here = now[column] - length[column] - preset.get(letter, 0.0)
            step = mode in _STEPS
            out[letter] = (
                here + value * self.scale(axis, mode)
                if step
                else self._coordinate(axis, mode or "AC", value, here)
            )
        words.axes.clear()
        kept = next((axis for axis in out if length[AXIS_INDEX[axis]]), "")
        if kept:
            place, size = out[kept], length[AXIS_INDEX[kept]]
            message = f"{kept.upper()}{place:g} in machine coordinates is where the tool's tip goes, and the axis to {place + size:g}: its length stays in force"
            hint = "D0 in the block ends it; with machine data 10760 = 1 the axis goes to where the word says"
            self.ip.warn_once("machine-length", message, kept.upper(), hint)
        self.emit(
            {axis: value + length[AXIS_INDEX[axis]] + preset.get(axis, 0.0) for axis, value in out.items()},
            (530, 0 if self.motion == "G0" else 10),
        )

    def end_of(self, words: Words) -> list[float]:
        """Return where the words lead."""
        state = self.ip.state
        end = state.position.copy()
        for axis, (mode, value) in words.axes.items():
            column = AXIS_INDEX[axis.lower()]
            end[column] = self._coordinate(axis, mode, value, end[column])
        if {"AP", "RP"} & words.named.keys():
            polar.polar_end(self, words, end)
        if "ANG" in words.named:
            polar.angle_end(self, words, end)
        return end

    def scale(self, axis: str, mode: str = "AC") -> float:
        """Return 0.5 where a value of an axis is a diameter."""
        if mode in _OF_X:
            return _OF_X[mode]
        absolute = self.absolute if mode == "" else mode != "IC"
        return 0.5 if axis == "X" and ("G90" if absolute else "G91") in self.diameter else 1.0

    def _coordinate(self, axis: str, mode: str, value: float, now: float) -> float:
        value *= self.scale(axis, mode)
        if mode in _STEPS or (mode == "" and not self.absolute):
            return self._from_carried(axis, value, now) + value
        if mode in ("DC", "ACP", "ACN"):
            if axis not in "ABC":
                message = f"{mode}() is for rotary axes, and {axis} is linear"
                raise BlockError("axis-mode", message, axis, hint="AC() or IC()")
            step = (value - now) % 360.0
            if mode == "ACN" and step:
                step -= 360.0
            if mode == "DC" and step > 180.0:
                step -= 360.0
            return now + step
        return value

    def _from_carried(self, axis: str, value: float, now: float) -> float:
        """Return where an increment begins: at the coordinate of before a change of the frame, if the axis has not moved since."""
        start = self.carried.get(axis.lower(), now)
        if not math.isclose(start, now, abs_tol=1e-9):
            message = f"the increment {axis}{value:g} goes {start - now + value:g} farther: a frame or tool length that changed is traversed with it"
            hint = "so it is with setting data 42440 and 42442 = 1, as the control comes; with 0 the increment alone is"
            self.ip.warn_once("frame-increment", message, axis, hint)
        return start

    def make(self, words: Words, end: list[float]) -> None:
        """Make the motion in force."""
        if self.soft is not None and soft_approach.take_next(self, words, end):
            return
        about_pole = words.named.pop("_POLAR", None) is not None
        given = {axis.lower(): end[AXIS_INDEX[axis.lower()]] for axis in words.axes}
        words.axes.clear()
        start = self.ip.state.position.copy()
        if self.motion in ("G0", "G1"):
            corner = self.corner(words) if self.motion == "G1" else {}
            for point in orientation.lines(self, given):
                self.emit({**point, **corner}, (0 if self.motion == "G0" else 10,))
            self.heading = [b - a for a, b in zip(start, self.ip.state.position, strict=True)]
        elif self.motion in ("G2", "G3", "CT", "CIP"):
            arcs.make(self, words, given, end, about_pole)
        elif self.motion == "BSPLINE":
            own = {n.lower(): words.named.pop(n)[1] for n in ("PW", "PL", "SD") if n in words.named}
            self.emit({"sd": self.degree, **given, **own}, (10_600,))
        elif self.motion in ("ASPLINE", "CSPLINE", "POLY"):
            curves.point(self, words, end)
        else:
            g_functions.thread(self, words, given)

    def corner(self, words: Words) -> dict[str, float]:
        """Return the chamfer or rounding at the end of a motion, and the feed it has by FRC or FRCM, as words of the interpreter."""
        feed = words.named.pop("FRC", ("", self.corner_feed))[1] * self.feed_scale * self.override
        own = {"corner_f": feed} if feed > 0.0 and self.ip.state.feed_mode != 93 else {}
        for name, word in (("RND", ",r"), ("CHR", ",c"), ("CHF", ",h")):
            if name in words.named:
                return {word: words.named.pop(name)[1], **own}
        return {",m": self.rounding, **own} if self.rounding else {}

    def _left_over(self, words: Words) -> None:
        """Raise where a word belongs to nothing in its block."""
        polynomials = ["PO"] * bool(words.polynomials)
        left = next((name for name in (*words.named, *words.texts, *polynomials) if name not in _IDLE), None)
        if left is not None:
            message = f"{left} stands in a block with nothing that uses it"
            hint = "is it of another motion, or a variable without DEF?"
            raise BlockError("unused-word", message, left, hint=hint)


def _mode_of(name: str, at: Sequence[Scalar], node: Value) -> tuple[str, Value]:
    """Return the mode of a value, as AC of X=AC(5), "" for none, and the value itself.

    Raises:
        BlockError: The mode is not read, or is of diameters and `name` is not X.
    """
    function = node.name if isinstance(node, Function) else ""
    if isinstance(node, Function) and function in (*MODES, *_OF_X) and len(node.arguments) == 1:
        if function in _OF_X and (name != "X" or at):
            message = f"{name}={function}(...): diameters and radii are of X"
            raise BlockError("axis-mode", message, name, hint="AC() or IC()")
        return function, node.arguments[0] or 0.0
    if isinstance(node, Function) and function == "QU" and name[:1] in "MH" and len(node.arguments) == 1:
        # An output that the control does not wait for (840D sl, Fundamentals, "Auxiliary function outputs").
        return "", node.arguments[0] or 0.0
    if function in _UNREAD_MODES:
        message = f"{function}() is not read"
        raise BlockError("not-read", message, function, hint="AC, IC, DC, ACP and ACN are")
    return "", node


def _is_word(name: str) -> bool:
    """Tell whether a name is one of a word, unless a program has a variable of that name."""
    return name in commands.NAMED or (len(name) == 1 and name in "GMFSTDHIJKLP" + AXES.upper())


def _once(words: dict[str, tuple[str, float]], name: str, value: tuple[str, float]) -> None:
    if name in words:
        raise BlockError("repeated-word", f"{name} stands twice in one block", name, hint="write it once")
    words[name] = value

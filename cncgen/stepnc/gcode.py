"""Toolpaths as G-code that this program and LinuxCNC, or FANUC, read back to the same motions.

Lines are G0 and G1, arcs G2 and G3 in their plane (whole turns by P), splines up to degree 3 G6.2 (FANUC); other curves, and splines
if a tolerance is given, become lines within it. Millimetres, degrees, mm/min.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, Diagnostics, Severity, UsageError
from cncgen.stepnc.geometry.chords import polyline_of
from cncgen.stepnc.geometry.pieces import Arc, Nurbs, Piece
from cncgen.stepnc.motion_lengths import motion_length
from cncgen.toolpath.record import Event, FeedMode, Kind, PathMode, Toolpath
from cncgen.units import is_rotary

Floats = NDArray[np.float64]

#: Chord tolerance of curves without a word of their own, mm.
CHORD = 1e-3
#: Work offsets, in the order of setups.
OFFSETS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
#: Controls that G-code is written for.
CONTROLS = ("linuxcnc", "fanuc")
#: Ranks (degree + 1) that G6.2 has.
RANKS = (2, 3, 4)
_PLANES = {0: ("G19", "JK"), 1: ("G18", "IK"), 2: ("G17", "IJ")}


def gcode_lines(
    chunks: Iterable[Toolpath],
    name: str = "",
    linearize: float | None = None,
    describe: Callable[[int], str] | None = None,
    control: str = "linuxcnc",
    remarks: Diagnostics | None = None,
) -> Iterator[str]:
    """Yield the blocks of a program as G-code, without line ends.

    Args:
        chunks: Its toolpath, piece by piece.
        name: For the comment at the top.
        linearize: Chord tolerance, mm, to write splines and arcs as lines; None keeps them.
        describe: Names the source of a line (from 1) in a comment, once a change; None writes none.
        control: The control that reads it, one of `CONTROLS`.
        remarks: Takes what the control has no word for and is left out, once all blocks are drawn.

    Raises:
        UsageError: The control has no word for a motion.
    """
    writer = (_FanucWriter if control == "fanuc" else _GcodeWriter)(linearize, describe)
    for chunk in chunks:
        if not writer.begun:
            yield from writer.begin(chunk, name)
        yield from writer.chunk(chunk)
    yield from writer.end()
    if remarks is not None:
        remarks.extend(writer.remarks())


def number(value: float) -> str:
    """Return a number with nine decimals at most, without needless zeros."""
    text = f"{value:.9f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def comment(text: str) -> str:
    """Return a comment; blanks replace characters that would end it."""
    clean = "".join(c if c.isprintable() and c not in "()" else " " for c in text)
    return f"({clean[:200]})"


@dataclass(slots=True)
class _GcodeWriter:
    """Writes G-code for LinuxCNC.

    Attributes:
        probe: The code of a probing motion.
        offsets: Work offsets, in the order of setups.
        most_turns: Of an arc.
    """

    linearize: float | None
    describe: Callable[[int], str] | None
    probe: ClassVar[str] = "G38.2"
    offsets: ClassVar[tuple[str, ...]] = OFFSETS
    most_turns: ClassVar[float] = math.inf
    begun: bool = False
    _axes: str = "XYZ"
    _position: Floats = field(default_factory=lambda: np.zeros(3))
    _feed: float = math.nan
    _mode: int = -1
    _plane: int = 2
    _line: int = -1
    _closeness: str = "G64"
    _ended: bool = False
    _moved: bool = False
    _tools: dict[str, int] = field(default_factory=dict)
    _pitch: float = 0.0
    _tap: bool = False
    _tapped: bool = False
    _probing: bool = False
    _direction: int = 0
    _speed: float = 0.0
    _coolant: tuple[bool, bool] = (False, False)

    def begin(self, chunk: Toolpath, name: str) -> Iterator[str]:
        self.begun = True
        self._axes = chunk.axes
        self._position = chunk.start
        if name:
            yield comment(name)
        yield comment("START, " + " ".join(self._words(chunk.start, None)))
        yield "G21 G17 G90 G94 G40"
        yield self._closeness

    def end(self) -> Iterator[str]:
        if not self._ended:
            yield "M2"

    def remarks(self) -> Iterator[Diagnostic]:
        """Yield what was left out: here nothing is."""
        return iter(())

    def _number(self, value: float) -> str:
        """Return a number as the control reads it."""
        return number(value)

    def _words(self, end: Floats, before: Floats | None) -> list[str]:
        """Return the axis words of a position: the words that differ from `before`, or all without it."""
        out = []
        for k, letter in enumerate(self._axes):
            value = math.degrees(end[k]) if is_rotary(letter) else float(end[k])
            text = self._number(value)
            if before is not None:
                old = math.degrees(before[k]) if is_rotary(letter) else float(before[k])
                if text == self._number(old):
                    continue
            out.append(letter + text)
        return out

    def chunk(self, path: Toolpath) -> Iterator[str]:
        """Yield the blocks of a chunk."""
        for row in range(len(path)):
            line = int(path.line[row])
            if self.describe is not None and line != self._line:
                self._line = line
                text = self.describe(line)
                if text:
                    yield comment(text)
            kind = path.kind[row]
            if kind == Kind.EVENT:
                yield from self._event(path.events[int(path.curve[row])])
                continue
            if self._pitch and kind == Kind.LINE:
                yield from self._in_step(path.end[row])
                continue
            yield from self._path_mode(int(path.path_mode[row]), float(path.tolerance[row]))
            if not self._moved and (kind != Kind.LINE or path.feed_mode[row] != FeedMode.RAPID):
                # A cut begins where it stands: not every reader knows where that is.
                self._moved = True
                yield " ".join(["G0", *self._words(self._position, None)])
            yield from self._motion(path, row, int(kind))
            self._position = path.end[row]

    def _path_mode(self, mode: int, tolerance: float) -> Iterator[str]:
        """Yield G61, G61.1 or G64 with its tolerance where it changes."""
        word = self._closeness_word(PathMode(mode), tolerance)
        if word != self._closeness:
            self._closeness = word
            yield word

    def _closeness_word(self, mode: PathMode, tolerance: float) -> str:
        """Return the word of a path mode."""
        word = {PathMode.EXACT_PATH: "G61", PathMode.EXACT_STOP: "G61.1"}.get(mode)
        return word or ("G64" if math.isnan(tolerance) else f"G64 P{number(tolerance)}")

    def _motion(self, path: Toolpath, row: int, kind: int) -> Iterator[str]:
        mode, feed = int(path.feed_mode[row]), float(path.feed[row])
        end = path.end[row]
        if kind == Kind.LINE:
            yield from self._straight(end[None, :], mode, feed)
            return
        piece: Piece = _piece(path, row, self._position)
        plane = self._plane_of(piece)
        if mode != FeedMode.RAPID and self.linearize is None:
            if isinstance(piece, Arc) and plane is not None and _turns(piece) <= self.most_turns:
                yield from self._arc(piece, plane, end, mode, feed)
                return
            if isinstance(piece, Nurbs) and piece.degree + 1 in RANKS:
                yield from self._spline(path, row, piece, mode, feed)
                return
        chord = self.linearize or CHORD
        points = polyline_of(piece, chord).points[1:]
        rest = np.linspace(0.0, 1.0, len(points) + 1)[1:, None]
        others = self._position[3:] + rest * (end[3:] - self._position[3:])
        yield from self._straight(np.concatenate([points, others], axis=1), mode, feed, len(points))

    def _plane_of(self, piece: Piece) -> int | None:
        if not isinstance(piece, Arc):
            return None
        axis = int(np.argmax(np.abs(piece.normal)))
        return axis if abs(piece.normal[axis]) > 1.0 - 1e-12 else None

    def _straight(self, points: Floats, mode: int, feed: float, pieces: int = 1) -> Iterator[str]:
        for end in points:
            # The first motion names all axes: not every reader knows where the program starts.
            words = self._words(end, self._position if self._moved else None)
            self._moved = True
            if words:
                code = self.probe if self._probing else "G1"
                code = "G0" if mode == FeedMode.RAPID else code
                yield " ".join([*self._modes(code, mode, feed, pieces, words)])
            self._position = end

    def _modes(self, code: str, mode: int, feed: float, pieces: int, words: list[str]) -> list[str]:
        """Return a block with the feed word, and G93 or G94 before it where the mode changes."""
        out = []
        if mode != FeedMode.RAPID and mode != self._mode:
            out.append("G93" if mode == FeedMode.INVERSE_TIME else "G94")
            self._mode, self._feed = mode, math.nan
        out += [code, *words]
        if mode == FeedMode.INVERSE_TIME:
            out.append(f"F{number(feed * 60.0 * pieces)}")
        elif mode == FeedMode.SPEED:
            rotary_only = words and all(is_rotary(w[0]) for w in words if w[0] in self._axes)
            word = feed * 60.0 * (180.0 / math.pi if rotary_only else 1.0)
            if word != self._feed:
                self._feed = word
                out.append(f"F{number(word)}")
        return out

    def _arc(self, arc: Arc, plane: int, end: Floats, mode: int, feed: float) -> Iterator[str]:
        code, letters = _PLANES[plane]
        if plane != self._plane:
            self._plane = plane
            yield code
        clockwise = arc.normal[plane] < 0
        # About Y the right-handed sense from +Y is that of G3 in the Z-X plane too.
        words = [f"{'XYZ'[k]}{self._number(float(end[k]))}" for k in range(3)]
        words += [w for w in self._words(end, self._position) if w[0] not in "XYZ"]
        arm = arc.centre - arc.start
        words += [f"{a}{self._number(float(arm['IJK'.index(a)]))}" for a in letters]
        if _turns(arc) > 1:
            words.append(f"P{_turns(arc)}")
        yield " ".join(self._modes("G2" if clockwise else "G3", mode, feed, 1, words))

    def _spline(self, path: Toolpath, row: int, curve: Nurbs, mode: int, feed: float) -> Iterator[str]:
        index = int(path.curve[row])
        table = path.nurbs
        control = table.control_points[int(table.point_offset[index]) : int(table.point_offset[index + 1])]
        rank, n = curve.degree + 1, len(control)
        if mode == FeedMode.INVERSE_TIME:  # G6.2 does not go with G93
            way = motion_length(path, row, np.stack([self._position, path.end[row]]))
            mode, feed = FeedMode.SPEED, way * feed
        rational = not (curve.weights == curve.weights[0]).all()
        for k in range(n):
            words = self._words(control[k], None)
            if rational:
                words.append(f"R{self._number(float(curve.weights[k] / curve.weights[0]))}")
            knot = f"K{self._number(float(curve.knots[k]))}"
            if k == 0:
                yield " ".join(self._modes(f"G6.2 P{rank} {knot}", mode, feed, 1, words))
            else:
                yield " ".join([knot, *words])
        for k in range(n, n + rank):
            yield f"K{self._number(float(curve.knots[k]))}"

    # Events

    def _event(self, event: Event) -> Iterator[str]:
        values = event.values
        if event.name == "tool":
            yield from self._tool(str(values.get("tool", "")))
        elif event.name == "spindle" and "direction" in values:
            yield from self._spindle(int(values["direction"]), float(values["speed_rpm"]))
        elif event.name == "coolant":
            yield from self._switch(bool(values.get("flood")), bool(values.get("mist")))
        elif event.name == "synchronise":
            self._pitch, self._tapped = float(values.get("pitch_mm") or 0.0), False
            self._tap = bool(values.get("tap"))
        elif event.name == "setup":
            yield from self._work_offset(int(values["number"]), str(values["setup"]), values["origin_mm"])
        elif event.name == "probe":
            self._probing = bool(values.get("probing"))
        elif event.name == "dwell":
            yield self._dwell(event.dwell_s)
        elif event.name == "stop":
            yield "M1" if values.get("kind") == "optional" else "M0"
        elif event.name == "message":
            yield comment(f"MSG, {values.get('text', '')}")
        elif event.name == "end":
            self._ended = True
            yield "M2"
        else:
            yield comment(" ".join([event.name, *(f"{k}={v}" for k, v in values.items())]))

    def _in_step(self, end: Floats) -> Iterator[str]:
        """Yield G33, or a tap for the way there; the way back, to where it began, is part of it."""
        words = self._words(end, self._position)
        if words and not self._tapped:
            if self._tap:
                yield from self._rigid_tap(end, words)
            else:
                yield " ".join(["G33", *words, self._lead()])
            self._mode, self._tapped = -1, self._tap
            self._position = self._position if self._tap else end

    def _lead(self) -> str:
        """Return the word of G33 for the way of a turn."""
        return f"K{number(self._pitch)}"

    def _dwell(self, seconds: float) -> str:
        return f"G4 P{number(seconds)}"

    def _rigid_tap(self, end: Floats, words: list[str]) -> Iterator[str]:
        """Yield a tap to an end and back."""
        yield " ".join(["G33.1", *words, f"K{number(self._pitch)}"])

    def _work_offset(self, k: int, name: str, origin: list[float] | None) -> Iterator[str]:
        """Select the work offset of a clamping; the machine has its origin."""
        if k > len(self.offsets):
            text = f"the program has {k} setups or more, and G-code {len(self.offsets)} work offsets"
            raise UsageError(Diagnostic("stepnc-setups", text))
        place = (
            ""
            if origin is None
            else " at " + " ".join(f"{a}{number(v)}" for a, v in zip("XYZ", origin, strict=True))
        )
        yield comment(f"setup {name}: {self.offsets[k - 1]}{place}")
        yield self.offsets[k - 1]

    def _tool(self, name: str) -> Iterator[str]:
        """Call a tool by its number; one without gets the next that is free."""
        if name not in self._tools:
            given = int(name) if name.isdigit() and len(name) < 6 else 0
            taken = set(self._tools.values())
            self._tools[name] = given if given and given not in taken else max(taken, default=0) + 1
            if str(self._tools[name]) != name:
                yield comment(f"T{self._tools[name]}: {name}")
        self._direction, self._coolant = 0, (False, False)
        yield f"T{self._tools[name]} M6"

    def _spindle(self, direction: int, speed: float) -> Iterator[str]:
        if direction == 0:
            self._direction = 0
            yield "M5"
            return
        code = {1: " M3", -1: " M4"}[direction] if direction != self._direction else ""
        self._direction, self._speed = direction, speed
        yield f"S{number(speed)}{code}"

    def _switch(self, flood: bool, mist: bool) -> Iterator[str]:
        before, self._coolant = self._coolant, (flood, mist)
        if (before[0] and not flood) or (before[1] and not mist):
            yield "M9"
            before = (False, False)
        if flood and not before[0]:
            yield "M8"
        if mist and not before[1]:
            yield "M7"


@dataclass(slots=True)
class _FanucWriter(_GcodeWriter):
    """Writes G-code for FANUC: rigid tapping by M29, skips for probing; G64 has no tolerance, and arcs are a turn at the most."""

    probe: ClassVar[str] = "G31"
    offsets: ClassVar[tuple[str, ...]] = (*OFFSETS[:6], *(f"G54.1 P{k}" for k in range(1, 49)))
    most_turns: ClassVar[float] = 1
    #: Tolerances of G64 that were left out, mm, each once, in order.
    _untold_mm: dict[float, None] = field(default_factory=dict)

    def _closeness_word(self, mode: PathMode, tolerance: float) -> str:
        if mode != PathMode.CONTINUOUS:
            return "G61"
        if not math.isnan(tolerance):
            self._untold_mm[tolerance] = None
        return "G64"

    def remarks(self) -> Iterator[Diagnostic]:
        """Yield a warning of the tolerances that were left out."""
        if self._untold_mm:
            some = ", ".join(f"P{number(each)}" for each in list(self._untold_mm)[:5])
            more = f" and {len(self._untold_mm) - 5} more" if len(self._untold_mm) > 5 else ""
            yield Diagnostic(
                "gcode-tolerance",
                f"FANUC's G64 has no tolerance: {some}{more} (mm) is left out, and the control goes by its own parameters",
                severity=Severity.WARNING,
                hint="set the tolerance at the control, or give it to cncgen by --path-tolerance",
            )

    def _number(self, value: float) -> str:
        """Return a number with a point: without it, controls may count least increments, and X50 is 0.05 mm (B-64304EN, decimal point)."""
        text = number(value)
        return text if "." in text else f"{text}."

    def _lead(self) -> str:
        return f"F{self._number(self._pitch)}"

    def _dwell(self, seconds: float) -> str:
        """Return a dwell by X, in seconds where it has a point; P would be ms."""
        return f"G4 X{self._number(seconds)}"

    def _rigid_tap(self, end: Floats, words: list[str]) -> Iterator[str]:
        """Yield M29 and a cycle that goes back to where it begins; G74 is that of left-hand threads (B-64304EN, rigid tapping).

        Raises:
            UsageError: The tap does not go down along Z, or the spindle's speed is not known.
        """
        if [w[0] for w in words] != ["Z"] or end[2] >= self._position[2] or not self._speed > 0:
            text = f"a tap to {' '.join(words)} at S{number(self._speed)}: FANUC's cycles tap down along Z, with the spindle turning"
            raise UsageError(Diagnostic("stepnc-unsupported", text, hint="--for linuxcnc writes G33.1"))
        cycle = "G74" if self._direction < 0 else "G84"
        place = [w for w in self._words(self._position, None) if w[0] in "XY"]
        feed = self._pitch * self._speed
        yield f"M29 S{number(self._speed)}"
        yield f"G94 G99 {cycle} {' '.join(place)} {words[0]} R{self._number(float(self._position[2]))} F{number(feed)}"
        yield "G80"


def _turns(arc: Arc) -> int:
    """Return how many turns an arc goes, the last one whole or in part."""
    return math.ceil(arc.sweep / (2 * math.pi) - 1e-9)


def _piece(path: Toolpath, row: int, start: Floats) -> Piece:
    """Return the curve of an ARC or NURBS row."""
    index = int(path.curve[row])
    if path.kind[row] == Kind.ARC:
        arcs = path.arcs
        return Arc(
            start[:3], path.end[row, :3], arcs.centre[index], arcs.normal[index], float(arcs.sweep[index])
        )
    table = path.nurbs
    points = slice(int(table.point_offset[index]), int(table.point_offset[index + 1]))
    knots = table.knots[int(table.knot_offset[index]) : int(table.knot_offset[index + 1])]
    return Nurbs(int(table.degree[index]), table.control_points[points, :3], table.weights[points], knots)

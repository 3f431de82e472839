"""The modal state of a program, which stays in force from block to block, and the order of execution within a block."""

from __future__ import annotations

import cmath
import math

from cncgen.records import dataclass, field
from cncgen.toolpath.record import PathMode
from cncgen.units import INCH

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.codes.bsplines import OpenSpline
    from cncgen.gcode.codes.canned_cycles import Sticky
    from cncgen.gcode.codes.lathe_fanuc import Turning
    from cncgen.gcode.codes.nurbs import OpenCurve
    from cncgen.gcode.codes.splines import OpenNurbs

AXIS_COUNT = 9
#: Modal motion "none" (G80), in tenths.
NO_MOTION = 800
#: States of M29 of FANUC: before the next row of holes, and within that row.
ARMED, IN_ROW = 1, 2


class Stage:
    """Order in which the parts of one block are executed (Kramer et al. (2000), table 8; LinuxCNC, "Order of Execution").

    Numbers alone: an `IntEnum` of as many takes half a millisecond to make.
    """

    COMMENT, SPINDLE_MODE, FEED_MODE, FEED, SPEED, TOOL, PINS, CHANGE, SPINDLE, SAVE = range(10)
    COOLANT, OVERRIDE, USER, DWELL, PLANE, UNITS, DIAMETER, RADIUS_COMPENSATION, TOOL_LENGTH = range(10, 19)
    COORDINATES, PATH, DISTANCE, RETRACT, REFERENCE, MOTION, STOP = range(19, 26)


def zeros() -> list[float]:
    """Return nine zeros, a position or offset."""
    return [0.0] * AXIS_COUNT


@dataclass(slots=True)
class Polar:
    """Polar coordinates of G16, from which the next words of radius and angle (degrees) count.

    Attributes:
        centre: In the plane's two axes: the origin, or where the tool was before an incremental radius.
    """

    centre: tuple[float, float]
    radius: float
    angle: float


# Without comparison and text, of which none is asked for, the class is made in half the time.
@dataclass(slots=True, eq=False, repr=False)
class State:
    """The modes and offsets in force. Lengths and positions are in program units, positions in program coordinates.

    Attributes:
        position: Where the tool is, X Y Z A B C U V W.
        inches: G20.
        plane: 17, 18, 19 (171, 181, 191).
        motion: Modal motion in tenths (10 is G1), `NO_MOTION` for none.
        under: The modal motion that FANUC's G80 leads back to.
        absolute, arc_absolute: G90 and G90.1.
        feed_mode: 93, 94, 95.
        feed: F.
        speed, direction: Spindle: S in rev/min, 1 clockwise, -1, 0 at rest.
        driven: An M code of the machine's builder has started a driven tool with S, while the spindle rests.
        constant_surface: Largest speed of G96 (0: none given), or None in G97.
        surface_speed: S of the last G96 that G97 ended, or None.
        path_mode, tolerance: G61, G61.1, G64 P (None: not given).
        naive: Tolerance of G64 Q.
        retract_old: G98 (else G99).
        system: Work coordinate system, 1 (G54) to 9 (G59.3).
        origin, rotation: Offset and rotation (degrees) of that system.
        g92, g92_on: Offset of G52/G92, and whether it applies.
        tool_offset: Offset of G43 and kin.
        selected, tool: Tool number that T named, and the one in the spindle.
        fetched: Tool number that M6 or M61 named last.
        mist, flood: Coolant.
        moved: Whether a motion was executed (the start position can no longer be set).
        ended: Whether M2, M30 or the closing % came.
        spline: Open NURBS block (G5.2 or G6.2), or None.
        cycle: Words and level of the canned cycles in a row, or None.
        compensation: Cutter radius compensation (40, 41, 42) in force.
        polar: G16 of FANUC, or None.
        pitch: Of the G33 of FANUC in force.
        rigid: `ARMED` by M29 of FANUC, `IN_ROW` in the row of holes behind it, else 0.
        between: Where G28 or G30 of FANUC went by, or None.
        local: Part of `g92` that G52 of FANUC set.
        speed_limit: Largest speed of G96 that G92 S of FANUC set.
        turning: Settings that the cycles of FANUC's lathes keep from block to block, once there was one.
        length_code: 43, 43.4, 44 or 49 of FANUC.
        length_number, radius_number: H and D that FANUC's programs said last, or None.
    """

    position: list[float] = field(default_factory=zeros)
    inches: bool = False
    plane: int = 17
    motion: int = NO_MOTION
    under: int = 0
    absolute: bool = True
    arc_absolute: bool = False
    feed_mode: int = 94
    feed: float = 0.0
    speed: float = 0.0
    direction: int = 0
    driven: bool = False
    constant_surface: float | None = None
    surface_speed: float | None = None
    path_mode: PathMode = PathMode.CONTINUOUS
    tolerance: float | None = None
    naive: float | None = None
    retract_old: bool = False
    system: int = 1
    origin: list[float] = field(default_factory=zeros)
    rotation: float = 0.0
    g92: list[float] = field(default_factory=zeros)
    g92_on: bool = False
    tool_offset: list[float] = field(default_factory=zeros)
    selected: int = 0
    tool: int = 0
    fetched: int = 0
    mist: bool = False
    flood: bool = False
    feed_override: bool = True
    speed_override: bool = True
    adaptive_feed: bool = False
    feed_hold: bool = True
    diameter: bool = False
    moved: bool = False
    ended: bool = False
    spline: OpenCurve | OpenNurbs | OpenSpline | None = None
    cycle: Sticky | None = None
    cubic: tuple[float, float, list[float]] | None = None
    compensation: int = 40
    polar: Polar | None = None
    pitch: float = 0.0
    rigid: int = 0
    between: list[float] | None = None
    local: list[float] = field(default_factory=zeros)
    speed_limit: float | None = None
    turning: Turning | None = None
    length_code: float = 49
    length_number: int | None = None
    radius_number: int | None = None

    @property
    def unit_mm(self) -> float:
        """The unit of lengths in force, mm."""
        return INCH if self.inches else 1.0

    def plane_axes(self) -> tuple[int, int, int]:
        """Return the columns of the plane's first and second axis and of its normal."""
        return PLANE_AXES[self.plane]

    def offsets(self) -> tuple[list[float], float, list[float], list[float]]:
        """Return origin, rotation, G92 in force and tool offset, which lead from program to machine coordinates."""
        return self.origin, self.rotation, self.g92, self.tool_offset


#: First axis, second axis, normal by plane: XY, ZX, YZ; UV, WU, VW.
PLANE_AXES = {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0), 171: (6, 7, 8), 181: (8, 6, 7), 191: (7, 8, 6)}


def in_plane(point: list[float], plane: int) -> complex:
    """Return a point in a plane: its first axis real, its second imaginary."""
    first, second, _ = PLANE_AXES[plane]
    return complex(point[first], point[second])


#: Columns that are lengths: X Y Z and U V W.
LENGTHS = (0, 1, 2, 6, 7, 8)
#: The codes of planes in tenths, with the plane that each chooses.
PLANE_CODES = {10 * plane if plane < 100 else plane: plane for plane in PLANE_AXES}
#: The codes of work coordinate systems 1 to 9, in tenths.
SYSTEM_CODES = (540, 550, 560, 570, 580, 590, 591, 592, 593)
PLAIN_MOTIONS = (0, 10, 20, 30)


def to_machine(
    point: list[float], origin: list[float], rotation: float, g92: list[float], tool: list[float]
) -> list[float]:
    """Return machine coordinates of a position in program coordinates (same units)."""
    out = [p + g for p, g in zip(point, g92, strict=True)]
    if rotation:
        c, s = math.cos(math.radians(rotation)), math.sin(math.radians(rotation))
        out[0], out[1] = out[0] * c - out[1] * s, out[0] * s + out[1] * c
    return [p + o + t for p, o, t in zip(out, origin, tool, strict=True)]


def to_program(
    point: list[float], origin: list[float], rotation: float, g92: list[float], tool: list[float]
) -> list[float]:
    """Return program coordinates of a position in machine coordinates: the inverse of `to_machine`."""
    out = [p - o - t for p, o, t in zip(point, origin, tool, strict=True)]
    if rotation:
        c, s = math.cos(math.radians(rotation)), math.sin(math.radians(rotation))
        out[0], out[1] = out[0] * c + out[1] * s, -out[0] * s + out[1] * c
    return [p - g for p, g in zip(out, g92, strict=True)]


def swept(spoke: complex, last: complex, turns: int) -> tuple[float, float]:
    """Return the sense of an arc, 1 or -1, and the angle that it sweeps between two ways from its centre."""
    spin = 1.0 if turns > 0 else -1.0
    sweep = (spin * cmath.phase(last / spoke)) % (2.0 * math.pi)
    return spin, (sweep if sweep > 1e-9 else 2.0 * math.pi) + 2.0 * math.pi * (abs(turns) - 1)

"""The content of a STEP-NC program, in the same records for files of ISO 14649 and of AP238.

The readers (`cncgen.stepnc.iso14649`, `cncgen.stepnc.ap238`) make these records when the executor asks for them; the executor is
independent of the files. Lengths mm, times s, angles rad, frames as in `geometry.frames`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from cncgen.stepnc.geometry.frames import Matrix
from cncgen.stepnc.geometry.pieces import Piece
from cncgen.stepnc.geometry.solids import Solid

Vector = NDArray[np.float64]

#: How the kinds of turning operations begin: their cutting speed is that at the diameter of the work.
TURNING = ("turning", "facing", "contouring", "grooving", "cutting in", "threading", "knurling")
#: Kinds of tools that stand while the work turns.
TURNING_TOOLS = ("turning tool", "grooving tool", "threading tool")
#: Values of operations and strategies that are angles.
ANGLES = frozenset(["angle", "path_return_angle"])
#: Values of operations and strategies that must lie between 0 and 1.
RATIOS = frozenset(
    ["overlap", "reduced_cut_at_start", "reduced_feed_at_start", "reduced_cut_at_end", "reduced_feed_at_end"]
)


def _empty() -> Mapping[str, Any]:
    return MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Technology:
    """Speeds of an operation or toolpath; None is not given.

    Attributes:
        ident: Its entity.
        feed: mm/s.
        feed_per_tooth, feed_per_rev: mm.
        spindle: rev/s, positive against the clock seen from the spindle towards the work (most cutters: negative).
        cutting_speed: mm/s; below 0 the spindle turns with the clock, above 0 by the hand of the tool.
        synchronised: Whether the feed follows the spindle (tapping).
        max_spindle: Fastest turn of the spindle at a constant cutting speed, rev/s.
    """

    ident: int
    feed: float | None = None
    feed_per_tooth: float | None = None
    feed_per_rev: float | None = None
    spindle: float | None = None
    cutting_speed: float | None = None
    synchronised: bool = False
    max_spindle: float | None = None

    def spindle_at(self, diameter: float, left_handed: bool = False) -> float:
        """Return the spindle speed that the cutting speed makes at a diameter (mm), rev/s, signed as `spindle`."""
        cutting = self.cutting_speed or 0.0
        speed = min(abs(cutting) / (math.pi * diameter), abs(self.max_spindle or math.inf))
        return speed if left_handed and cutting > 0 else -speed


@dataclass(frozen=True, slots=True)
class Functions:
    """Machine functions; None does not change a function."""

    ident: int
    coolant: bool | None = None
    mist: bool | None = None
    through_spindle: bool | None = None
    others: Mapping[str, Any] = field(default_factory=_empty)

    def by_way_of(self, kind: str) -> Functions:
        """Return the functions with the coolant as a coolant_type of ISO 14649-12 says: flood, mist or through the tool."""
        if kind.startswith("mist"):
            return replace(self, coolant=False, mist=self.coolant)
        if kind.startswith("through"):
            return replace(self, coolant=False, through_spindle=self.coolant)
        return self


#: Milling tools whose edges do not reach their middle (ISO 14649-111), and the steepest way down that is usual for them, rad.
_HOLLOW = frozenset(["facemill", "side mill", "t slot mill", "woodruff keyseat mill", "thread mill"])
STEEPEST = math.radians(5.0)


@dataclass(frozen=True, slots=True)
class CuttingTool:
    """A cutting tool. Lengths mm, angles rad; None is not given.

    Attributes:
        ident: Its entity.
        name: Called by a tool change.
        kind: ``twist drill``, ``tapered endmill`` …: the body, lower case with blanks.
        diameter: Of the cut.
        teeth: Number of teeth.
        tip_angle: Angle of a drill's edge from the plane across its axis (14649: tool_top_angle).
        edge_radius, edge_centre_vertical, edge_centre_horizontal, circumference_angle: Of MILLING_TOOL_DIMENSION.
        cutting_length: Longest cut.
        offset_length: Length that the tool length offset takes out.
        left_handed: Whether it cuts turning against the clock.
        pitch: Of a tap or a tool for threads.
        nose: Radius of a turning tool's corner.
        width: Of the end of a tool for grooves.
        trailing: Angle between the work's axis and the edge of a turning tool that follows its corner.
    """

    ident: int
    name: str
    kind: str = ""
    diameter: float | None = None
    teeth: int | None = None
    tip_angle: float | None = None
    edge_radius: float | None = None
    edge_centre_vertical: float | None = None
    edge_centre_horizontal: float | None = None
    circumference_angle: float | None = None
    cutting_length: float | None = None
    offset_length: float | None = None
    left_handed: bool = False
    pitch: float | None = None
    nose: float | None = None
    width: float | None = None
    trailing: float | None = None

    @property
    def centre_cutting(self) -> bool:
        """Tell whether its edges reach its middle, so that it can go straight down."""
        return self.kind not in _HOLLOW

    @property
    def edge(self) -> float:
        """Return the radius of the rounded edge, mm: that given, else half the diameter of a ball, else 0."""
        if self.edge_radius is None:
            return self.diameter / 2 if self.kind.startswith("ball") and self.diameter else 0.0
        return min(self.edge_radius, (self.diameter or 0.0) / 2)


@dataclass(frozen=True, slots=True)
class CutterPath:
    """One toolpath of an operation.

    Attributes:
        ident: Its entity.
        kind: ``trajectory``, ``dwell``, ``connect direct``, ``connect security plane``; ``tap``: along `pieces` and back in
            step with the spindle, which turns back at their end; ``thread``: along them in step with the spindle.
        pieces: Called for the pieces of a trajectory, in the operation's frame; raises `Skip`.
        rapid: Whether the machine moves at its own speed.
        ratio: Factor of the feed.
        technology, functions: Its own, or None for the operation's.
        seconds: Of a dwell.
        turns: Of a dwell that waits for so many turns of the spindle.
        deviation: How far the machine may be from the path, mm, None where that is its own affair.
        pitch: Of a tap or thread, mm a turn.
    """

    ident: int
    kind: str = "trajectory"
    pieces: Callable[[], list[Piece]] = list
    rapid: bool = False
    ratio: float = 1.0
    technology: Technology | None = None
    functions: Functions | None = None
    seconds: float = 0.0
    turns: float = 0.0
    deviation: float | None = None
    pitch: float = 0.0


class Paths(Sequence[CutterPath]):
    """Toolpaths that are read one by one as they are executed, so that an operation may have any number of them.

    Attributes:
        idents: Their entities.
    """

    def __init__(self, idents: Sequence[int], read: Callable[[int], CutterPath]) -> None:
        self.idents = idents
        self._read = read

    def __len__(self) -> int:
        return len(self.idents)

    def __getitem__(self, k: Any) -> Any:
        """Return the toolpath at a place (an index, no slice); raises `Skip` where it has a fault."""
        return self._read(range(len(self.idents))[k])


@dataclass(frozen=True, slots=True)
class MachiningStrategy:
    """A machining, approach or retract strategy: its kind (``contour parallel``, ``plunge helix``) and attributes."""

    ident: int
    kind: str
    values: Mapping[str, Any] = field(default_factory=_empty)


@dataclass(frozen=True, slots=True)
class Operation:
    """The operation of a workingstep.

    Attributes:
        ident, label: Its entity and name.
        kind: ``freeform``, ``plane rough``, ``bottom and side finish``, ``drilling``, ``tapping`` …
        paths: Explicit toolpaths (a tuple, or `Paths`), None where the feature gives them.
        tool, technology, functions: None where missing.
        retract_plane: Height above the feature, mm.
        start_point: Shape (3,), or None.
        values: The further attributes by the names of ISO 14649, mm, s and rad.
        strategy, approach, retract: None where missing.
        tilt: Tool direction in the operation's frame where it is not its Z axis.
    """

    ident: int
    label: str
    kind: str
    paths: Sequence[CutterPath] | None
    tool: CuttingTool | None = None
    technology: Technology | None = None
    functions: Functions | None = None
    retract_plane: float | None = None
    start_point: Vector | None = None
    values: Mapping[str, Any] = field(default_factory=_empty)
    strategy: MachiningStrategy | None = None
    approach: MachiningStrategy | None = None
    retract: MachiningStrategy | None = None
    tilt: Vector | None = None


@dataclass(frozen=True, slots=True)
class Feature:
    """A feature, which a workingstep machines.

    Attributes:
        ident, label: Its entity and name.
        kind: ``closed pocket``, ``round hole`` …
        placement: Its frame, seen from the workpiece.
        shape: Called for its `Shape`, in its frame; raises `Skip`.
    """

    ident: int
    label: str
    kind: str
    placement: Matrix
    shape: Callable[[], Shape]


@dataclass(frozen=True, slots=True)
class Boss:
    """A boss that stays standing inside a feature: its outline at the top, the draft of its walls (rad, wider below).

    `top` is the height of its top in the feature's frame, mm, 0 or below.
    """

    outline: list[Piece]
    slope: float = 0.0
    top: float = 0.0


@dataclass(frozen=True, slots=True)
class Shape:
    """The shape of a feature, in the feature's frame: its top at Z 0, the material below. mm, rad.

    Attributes:
        depth: How deep it goes below its origin, or None.
        diameter: Of a hole.
        bottom: ``through``, ``flat``, ``conical``, ``spherical``, ``radiused`` … or "".
        bottom_angle: Full angle of a conical bottom, rad, or None.
        bottom_radius: Of a spherical bottom, mm, or None.
        outline: Closed boundary as pieces, or None.
        bosses: Left standing inside.
        course: Open path of a slot or step, or None.
        width: Of a slot.
        open_sides: Of an open boundary: the pieces of the outline that are open, by index.
        section: Of a slot across its course: ``vee``, ``arc``; "" for a U.
        section_angle: Between the walls of a vee, or that of the arc, rad.
        section_radius: Of the bottom of a vee, or of the arc, mm.
        ends: Of a slot: ``open``, ``radiused``, ``flat`` …
        slope: Draft of the walls, rad: a pocket or hole is narrower below, an outside profile wider.
        corner_radius: Of the walls' corners (orthogonal_radius), or None.
        floor_radius: Between floor and walls (planar_radius), or None.
        elements: Features that make up this one, their placements within it.
        thread: Major diameter of a thread, mm, or None.
        pitch: Of a thread, mm: negative of a left-handed one; None if not given.
        stock: Outline of the raw piece across the feature's axis, or None if not given.
        contour: Of a turned feature: its profile in the plane of X (the radius) and Z.
        material: Of a turned feature: the direction from its profile into the material, or None if not given.
    """

    depth: float | None = None
    diameter: float | None = None
    bottom: str = ""
    bottom_angle: float | None = None
    bottom_radius: float | None = None
    outline: list[Piece] | None = None
    bosses: tuple[Boss, ...] = ()
    course: list[Piece] | None = None
    width: float | None = None
    open_sides: tuple[int, ...] = ()
    section: str = ""
    section_angle: float = 0.0
    section_radius: float = 0.0
    ends: tuple[str, ...] = ()
    slope: float = 0.0
    corner_radius: float | None = None
    floor_radius: float | None = None
    elements: tuple[Feature, ...] = ()
    thread: float | None = None
    pitch: float | None = None
    stock: list[Piece] | None = None
    contour: list[Piece] | None = None
    material: Vector | None = None

    @property
    def inside(self) -> bool:
        """Tell whether a turned feature is the wall of a bore: the material lies outside of the profile."""
        return self.material is not None and bool(self.material[0] > 0.5)


@dataclass(frozen=True, slots=True)
class WorkSetup:
    """A clamping of a program that has several.

    Attributes:
        number: From 1, in the order of the file: the work offset in G-code (1 is G54).
        label: Its name.
        origin: Where it stands on the machine, as the file has it, or None; motions do not have it in them.
    """

    number: int
    label: str
    origin: Matrix | None = None


@dataclass(frozen=True, slots=True)
class RawPiece:
    """A raw piece in a setup.

    Attributes:
        ident: The workpiece that it is, of a row of workpieces made of one another the first.
        solid: Its shape, in the workpiece's frame.
        frame: The workpiece's frame, seen from the machine.
    """

    ident: int
    solid: Solid
    frame: Matrix

    @property
    def placed(self) -> Solid:
        """Return its shape, seen from the machine."""
        return self.solid.moved(self.frame)

    def same(self, other: RawPiece) -> bool:
        """Tell whether another one is the same, at the same place."""
        return self.ident == other.ident and self.placed.same(other.placed)


@dataclass(frozen=True, slots=True)
class Workingstep:
    """An operation on a feature.

    Attributes:
        ident, label: Its entity and name.
        operation: The work.
        feature: The machined feature, None for explicit toolpaths without one.
        frame: Of its toolpaths, seen from the machine.
        security: Frame of the security plane seen from the machine (Z is its normal), or None.
        rapid: Whether all of it is rapid (RAPID_MOVEMENT).
        raw: Raw piece of the feature's workpiece, without a feature the only one there is, seen from the machine; or None.
        setup: The clamping, None where the program has one alone.
        pieces: All raw pieces in the setup.
    """

    ident: int
    label: str
    operation: Operation
    feature: Feature | None
    frame: Matrix
    security: Matrix | None = None
    rapid: bool = False
    raw: Solid | None = None
    setup: WorkSetup | None = None
    pieces: tuple[RawPiece, ...] = ()


@dataclass(frozen=True, slots=True)
class NcFunction:
    """A function between workingsteps: ``program stop``, ``optional stop``, ``display message``, ``load tool`` …"""

    ident: int
    label: str
    kind: str
    values: Mapping[str, Any] = field(default_factory=_empty)


@dataclass(frozen=True, slots=True)
class ProgramStructure:
    """Executables in their order: a workplan, or the branch of a statement.

    Attributes:
        ident, label: Its entity and name.
        kind: ``workplan``, ``non sequential``, ``selective``, ``parallel``.
        children: Ids of the executables.
        context: Setup and frames, which the reader needs when it reads the children.
    """

    ident: int
    label: str
    kind: str
    children: tuple[int, ...]
    context: Any = None


@dataclass(frozen=True, slots=True)
class Branching:
    """IF and WHILE: `condition` is evaluated by the executor's variables; branches are ids or None."""

    ident: int
    label: str
    loop: bool
    condition: Callable[[dict[str, float]], bool]
    then: int | None
    otherwise: int | None = None
    context: Any = None


@dataclass(frozen=True, slots=True)
class Assignment:
    """``variable := value``, the value from the variables at that moment."""

    ident: int
    label: str
    variable: str
    value: Callable[[dict[str, float]], float]


Executable: TypeAlias = ProgramStructure | Branching | Assignment | Workingstep | NcFunction


class Reader(Protocol):
    """The reader of a file, which the executor asks for its records."""

    def roots(self) -> list[Executable]:
        """Return the main workplans."""

    def executable(self, ident: int, context: Any) -> Executable:
        """Return an executable within a block; raises `Skip`."""

    def orphans(self) -> list[int]:
        """Return workplans and workingsteps that no workplan leads to from a root."""

    def parts(self) -> list[Solid]:
        """Return what bounds the finished parts, as far as the file has their shapes, in the workpieces' frames."""

    def variables(self) -> dict[str, float]:
        """Return the NC variables with their initial values."""

    def needs_rotary(self) -> bool:
        """Tell whether a tool axis may leave the machine's Z, by tools and toolpaths."""

    def may_lean(self) -> bool:
        """Tell whether a setup, workpiece or feature leans; its workingsteps may still be upright."""

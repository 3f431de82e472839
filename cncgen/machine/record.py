"""The machine description: the limits of each axis, and the data of its servo drive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any


@dataclass(frozen=True, slots=True)
class Servo:
    """Servo data of an axis: `model` names the record in `cncgen.servo` that its `parameters` follow.

    Values are kept as the TOML gives them, checked by type and range when the machine is read (the schema of each
    model stands in `cncgen.machine.servo_schema`). `knows` is the data that the controller was designed on, where the plant
    is another one than its designer thought.
    """

    model: str
    parameters: Mapping[str, Any]
    knows: Servo | None = None


@dataclass(frozen=True, slots=True)
class Drive:
    """Scaling of a drive under CiA 402 (cyclic synchronous position): the units of its objects.

    Target position (607Ah) is ``offset + sign · position · counts``, sign being -1 for a reversed drive. Velocity
    offset (60B1h) is ``sign · velocity · velocity_scale``. Torque offset (60B2h), in thousandths of the rated torque,
    is ``sign · (torque_inertia · acceleration + torque_viscous · velocity + torque_friction · sgn(velocity))``.

    Attributes:
        counts: Increments of 607Ah a mm or rad.
        offset: 607Ah at machine zero.
        reversed: Whether counts fall as the axis's position grows.
        velocity_scale: Units of 60B1h a mm/s or rad/s; None: `counts` (increments a second).
        torque_inertia: Thousandths of the rated torque a mm/s² or rad/s².
        torque_viscous: Thousandths of the rated torque a mm/s or rad/s.
        torque_friction: Thousandths of the rated torque against dry friction.
    """

    counts: float
    offset: int = 0
    reversed: bool = False
    velocity_scale: float | None = None
    torque_inertia: float = 0.0
    torque_viscous: float = 0.0
    torque_friction: float = 0.0


@dataclass(frozen=True, slots=True)
class Axis:
    """Limits of one axis, mm or rad.

    Attributes:
        letter: One of ``XYZABCUVW``.
        max_velocity: mm/s or rad/s.
        max_acceleration: mm/s² or rad/s².
        max_jerk: mm/s³ or rad/s³.
        travel: Lowest and highest position, or None if unlimited.
        servo: Drive and controller, or None.
        drive: Scaling of the drive's objects, or None.
    """

    letter: str
    max_velocity: float
    max_acceleration: float
    max_jerk: float
    travel: tuple[float, float] | None = None
    servo: Servo | None = None
    drive: Drive | None = None


@dataclass(frozen=True, slots=True)
class Machine:
    """A machine: its axes and common properties.

    Attributes:
        name: Profile name.
        axes: By letter, in the order of ``XYZABCUVW``.
        period_s: Time between two setpoints.
        chord_tolerance_mm: Largest distance of the chord between two setpoints from the path.
        path_tolerance_mm: Tolerance of G64 where the program gives none.
        max_contour_error_mm: Bound of the predicted error under `ild` (and `optimal` where asked).
        max_centripetal_mm_s2: Limit of v²κ along the path, or None.
        settings: Further tables of the file by name (interpreter settings, kinematics), checked by their readers.
    """

    name: str
    axes: Mapping[str, Axis]
    period_s: float = 0.001
    chord_tolerance_mm: float = 0.001
    path_tolerance_mm: float = 0.01
    max_contour_error_mm: float | None = None
    max_centripetal_mm_s2: float | None = None
    settings: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def is_lathe(self) -> bool:
        """Whether it has X and Z and no Y."""
        return "X" in self.axes and "Z" in self.axes and "Y" not in self.axes

    def __repr__(self) -> str:
        try:
            return f"Machine({self.name!r}, axes {''.join(self.axes)}, every {1e3 * self.period_s:g} ms)"
        except (TypeError, ValueError, OverflowError):  # built wrongly, which is said where it is used
            return f"Machine({self.name!r}, axes {self.axes!r}, period_s {self.period_s!r})"

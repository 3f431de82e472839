"""The machine description: the limits of each axis, and the data of its servo drive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any


def _of_python(value: Any) -> Any:
    """Return numbers and arrays of numpy as numbers and lists of Python, which files of TOML and JSON hold; all else as it is."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, list | tuple) and any(hasattr(each, "tolist") for each in value):
        return type(value)(map(_of_python, value))
    return value


def _keep(record: Any, *names: str) -> None:
    """Keep fields of a record as Python's."""
    for name in names:
        value = getattr(record, name)
        if (found := _of_python(value)) is not value:
            object.__setattr__(record, name, found)


@dataclass(frozen=True, slots=True)
class Servo:
    """Servo data of an axis. They are checked where they are used.

    Attributes:
        model: One of `cncgen.machine.servo_parameters.MODELS`.
        parameters: Values by the keys that ``[axes.x.servo]`` of a machine file has for the model, in the units of these keys. Coefficients
            of polynomials are lists, tuples or arrays, the highest power first.
        knows: The data that the controller was designed on, where the plant is another one than its designer thought; or None.
    """

    model: str
    parameters: Mapping[str, Any]
    knows: Servo | None = None

    def __post_init__(self) -> None:
        if isinstance(self.parameters, Mapping):  # else it is told where it is used
            given = {key: _of_python(value) for key, value in self.parameters.items()}
            if any(given[key] is not value for key, value in self.parameters.items()):
                object.__setattr__(self, "parameters", MappingProxyType(given))


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

    def __post_init__(self) -> None:
        _keep(
            self, "counts", "offset", "velocity_scale", "torque_inertia", "torque_viscous", "torque_friction"
        )


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

    def __post_init__(self) -> None:
        _keep(self, "max_velocity", "max_acceleration", "max_jerk", "travel")


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

    def __post_init__(self) -> None:
        _keep(
            self,
            "period_s",
            "chord_tolerance_mm",
            "path_tolerance_mm",
            "max_contour_error_mm",
            "max_centripetal_mm_s2",
        )

    @property
    def degree_mm(self) -> float:
        """What a degree of a rotary axis counts as in tolerances, mm: 1, as controls count it, or as ``[kinematics]`` says."""
        return (
            float(self.settings["kinematics"].get("degree_mm", 2.0)) if "kinematics" in self.settings else 1.0
        )

    @property
    def is_lathe(self) -> bool:
        """Whether it has X and Z and no Y."""
        return "X" in self.axes and "Z" in self.axes and "Y" not in self.axes

    def __repr__(self) -> str:
        try:
            return f"Machine({self.name!r}, axes {''.join(self.axes)}, every {1e3 * self.period_s:g} ms)"
        except (TypeError, ValueError, OverflowError):  # built wrongly, which is said where it is used
            return f"Machine({self.name!r}, axes {self.axes!r}, period_s {self.period_s!r})"

"""Options of the planner, and the names that they may have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cncgen.arguments import expect, is_number, mistyped
from cncgen.diagnostics import Diagnostic, Severity, UsageError
from cncgen.machine.checking import check_servos
from cncgen.machine.record import Servo

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import TypedDict

#: Those named two-stage leave the path: they change the setpoints of the exact one (`cncgen.setpoints.two_stage`).
TWO_STAGE = ("two-stage-linear", "two-stage-centred", "two-stage-causal")
INTERPOLATORS = ("arclength", "taylor1", "taylor2", "uniform", "stateline", *TWO_STAGE)
SATURATIONS = ("off", "reactive", "predictive")
PROFILES = ("bell", "linear", "exponential")
#: Controls whose own rules ``plan --as`` estimates with.
CONTROLS = ("linuxcnc", "grbl", "exact-stop")
EFFORTS = ("best", "fast")
#: Bounds of the contour error below a nanometre are refused: the speed falls with the root of the bound, and what such a
#: plan gained in days of motion would be the last digits of setpoints.
LEAST_CONTOUR_ERROR_MM = 1e-6


@dataclass(frozen=True, slots=True)
class PlanOptions:
    """How a toolpath is planned. The names are those of ``cncgen plan``.

    Attributes:
        feedrate: Strategy, one of `cncgen.planner.strategies.FEEDRATES`; None: the first of them.
        interpolator: One of `INTERPOLATORS`.
        saturation: One of `SATURATIONS`.
        profile: Acceleration and deceleration of `ild`, one of `PROFILES`.
        effort: One of `EFFORTS`: whether `optimal` plans path and speed together within the tolerance of G64, or the speed alone
            along a path that is chosen before.
        path_tolerance_mm: Tolerance of every continuous row; None: the program's, else the machine's.
        max_contour_error_mm: Predicted contour error that `ild` (and `optimal`, where it is given here) stays under;
            None: `ild` takes the machine's.
        servos: Servo data by axis letter that stand in for the machine's (``--axis-params``).
        kbar_per_mm: The constant κ̄ of Tsai 2010, eq. 25, in 1/mm: the curvature at which the feed is halved.
        corner_distance_mm: Least distance of a sharp corner from the one before it and from the start (`ild`).
        fit_mm: Tolerance within which runs of short lines become cubic NURBS curves before they are planned; None: they do not.
        stateline_bound_mm: δ of the interpolator ``stateline``: following error beyond that of the speed, at which all axes hold.
        master_period_s: Time between the master's points of two-stage interpolation.
        lookahead_rows: Rows that a window of the look-ahead may hold.
        max_steps: Steps that the user allows: of more, the search of the effort ``best`` goes on for longer. None: as the program is read.
        control: One of `CONTROLS`: the times that this control would take by its own rules, instead of a plan of ours.
    """

    feedrate: str | None = None
    interpolator: str = "arclength"
    saturation: str = "off"
    profile: str = "bell"
    effort: str = "best"
    path_tolerance_mm: float | None = None
    max_contour_error_mm: float | None = None
    servos: Mapping[str, Servo] | None = None
    kbar_per_mm: float = 1.0
    corner_distance_mm: float = 1.0
    fit_mm: float | None = None
    stateline_bound_mm: float = 0.05
    master_period_s: float = 0.016
    lookahead_rows: int = 20_000
    max_steps: int | None = None
    control: str | None = None

    @property
    def keeps_limits(self) -> bool:
        """Whether the plan promises velocity, acceleration and jerk of every axis."""
        return (
            self.control is None
            and self.feedrate in (None, "optimal")
            and self.interpolator == "arclength"
            and self.saturation == "off"
        )

    def check(self) -> None:
        """Raise `UsageError` that names every option whose value is not one of those it may have, servo data last."""
        kinds = PlanOptions.__annotations__
        if faults := mistyped({name: getattr(self, name) for name in kinds}, kinds):
            raise UsageError(faults)
        choices = {
            "interpolator": INTERPOLATORS,
            "saturation": SATURATIONS,
            "profile": PROFILES,
            "effort": EFFORTS,
        }
        faults = [
            Diagnostic("option-value", f"{name} = {getattr(self, name)!r} is not one of {', '.join(allowed)}")
            for name, allowed in choices.items()
            if getattr(self, name) not in allowed
        ]
        faults.extend(self._faults_of_control())
        for name, optional in (
            ("path_tolerance_mm", True),
            ("max_contour_error_mm", True),
            ("kbar_per_mm", False),
            ("stateline_bound_mm", False),
            ("master_period_s", False),
            ("fit_mm", True),
            ("lookahead_rows", False),
            ("max_steps", True),
        ):
            value = getattr(self, name)
            if not (value is None and optional) and not (is_number(value) and value > 0):
                faults.append(
                    Diagnostic("option-value", f"{name} = {value!r} must be a number greater than 0")
                )
        bound = self.max_contour_error_mm
        if is_number(bound) and 0 < bound < LEAST_CONTOUR_ERROR_MM:
            message = f"max_contour_error_mm = {bound!r} is below {LEAST_CONTOUR_ERROR_MM:g} mm, the least that is planned"
            faults.append(Diagnostic("option-value", message))
        distance = self.corner_distance_mm
        if not (is_number(distance) and distance >= 0):
            message = f"corner_distance_mm = {distance!r} must be a number that is not negative"
            faults.append(Diagnostic("option-value", message))
        if faults:
            raise UsageError(faults)
        if self.servos is not None:
            check_servos(
                expect(self.servos, Mapping, "servos", "a mapping of letters to cncgen.machine.Servo")
            )

    def unused(self, feedrates: Sequence[str] = (), interpolators: Sequence[str] = ()) -> list[Diagnostic]:
        """Return a warning for each option that was changed and that no plan asks for.

        Args:
            feedrates, interpolators: Those of other plans that are made with these options too.
        """
        usual = PlanOptions()
        planned, followed = {self.feedrate or "optimal", *feedrates}, {self.interpolator, *interpolators}
        asked = {
            "profile": ("ild" in planned, "--feedrate ild"),
            "corner_distance_mm": ("ild" in planned, "--feedrate ild"),
            "kbar_per_mm": (not planned.isdisjoint(("ild", "curvature")), "--feedrate ild or curvature"),
            "effort": ("optimal" in planned, "--feedrate optimal"),
            "stateline_bound_mm": ("stateline" in followed, "--interpolator stateline"),
            "master_period_s": (not followed.isdisjoint(TWO_STAGE), "--interpolator two-stage-…"),
        }
        return [
            Diagnostic(
                "option-unused",
                f"{name} = {getattr(self, name)} changes nothing here: it is an option of {whose}",
                severity=Severity.WARNING,
                values={"option": name},
            )
            for name, (used, whose) in asked.items()
            if not used and getattr(self, name) != getattr(usual, name)
        ]

    def _faults_of_control(self) -> list[Diagnostic]:
        """Return the faults of `control`, and of options beside it."""
        if self.control is None:
            return []
        if self.control not in CONTROLS:
            return [
                Diagnostic("option-value", f"control = {self.control!r} is not one of {', '.join(CONTROLS)}")
            ]
        if self.feedrate is not None or self.interpolator != "arclength" or self.saturation != "off":
            message = f"{self.control} plans by its own rules: feedrate, interpolator and saturation are not asked beside it"
            return [Diagnostic("option-value", message)]
        return []


if TYPE_CHECKING:

    class PlanWords(TypedDict, total=False):
        """The fields of `PlanOptions` as keywords, for type checkers."""

        feedrate: str | None
        interpolator: str
        saturation: str
        profile: str
        effort: str
        path_tolerance_mm: float | None
        max_contour_error_mm: float | None
        servos: Mapping[str, Servo] | None
        kbar_per_mm: float
        corner_distance_mm: float
        fit_mm: float | None
        stateline_bound_mm: float
        master_period_s: float
        lookahead_rows: int
        max_steps: int | None
        control: str | None

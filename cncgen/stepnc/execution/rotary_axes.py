"""Tool axes as angles of two rotary axes, and where the slides of a five-axis machine stand.

Seen from the workpiece the tool's axis is ``Ru(θu) Rt(θt) z``: one rotary axis tilts the tool (A about X or B about Y),
the other turns what is tilted. In a head the axis that carries the other one turns, in a table the one that is carried;
of one in each, the table's (angles as ISO 841 has them: the tool turns that way relative to the workpiece, a table the other way). So

    turn C, tilt B:  (cos C sin B, sin C sin B, cos B)
    turn C, tilt A:  (sin C sin A, -cos C sin A, cos A)
    turn A, tilt B:  (sin B, -sin A cos B, cos A cos B)
    turn B, tilt A:  (sin B cos A, -sin A, cos B cos A)

Of the two solutions the one nearer to where the axes stand is taken, by whole turns nearest too, so that the axes go on
beyond 360 degrees and the tilt passes through the turning axis to its other side; where the tool is along the turning
axis, that stays, or goes where it will be wanted next. Close by that axis a small turn of the tool needs a large one of
the turning axis (`swing`), which no choice of solution avoids. Where a machine says how its axes carry table or head
(``[kinematics]``), X Y Z are those of its slides; else they stay the tip of the tool in the workpiece (tool centre
point programming) and the axes are B and C.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.geometry import elementary
from cncgen.machine.kinematics import Kinematics
from cncgen.stepnc.geometry.frames import Matrix

Floats = NDArray[np.float64]
Angles = tuple[float, float]
Vector = tuple[float, float, float]

#: Sine of the angle to the turning axis below which the tool is along it: 1 µm at 100 mm, the last digit of tool axes
#: with five decimals, whose direction about the turning axis is chance.
ALONG = 1e-5
#: Angle to the turning axis below which it may have to swing round, rad.
CLOSE = math.radians(5.0)


@dataclass(frozen=True)
class RotaryAxes:
    """The rotary axes of a program.

    Attributes:
        turn, tilt: Their letters, by their function.
        mechanism: Of the machine, or None where X Y Z stay the tip.
    """

    turn: str = "C"
    tilt: str = "B"
    mechanism: Kinematics | None = None

    @staticmethod
    def of(mechanism: Kinematics | None) -> RotaryAxes:
        """Return the rotary axes of a machine, B and C of a fork head where none is given.

        Raises:
            UsageError: where the axis that should tilt the tool turns about it.
        """
        if mechanism is None:
            return RotaryAxes()
        tilt, turn = ("ABC"[mechanism.axes[place] - 3] for place in mechanism.turns)
        if tilt == "C":
            text = (
                f"kinematics.axes: {tilt} turns the spindle before {turn}, so no axis tilts the tool out of Z"
            )
            raise UsageError(Diagnostic("machine-kinematics", text))
        return RotaryAxes(turn, tilt, mechanism)

    @property
    def letters(self) -> str:
        """Return the letters in the order of the columns."""
        return "".join(sorted(self.turn + self.tilt))

    def angles_of(self, axis: Floats, before: Angles) -> Angles:
        """Return the angles of `letters`, rad, for a tool axis, shape (3,), nearest to the angles `before`."""
        order = self.letters.index(self.turn)
        was = before[order], before[1 - order]
        found = min(self._solutions(axis, was[0]), key=lambda s: abs(s[0] - was[0]) + abs(s[1] - was[1]))
        return found if order == 0 else (found[1], found[0])

    def _solutions(self, axis: Floats, turned: float) -> list[Angles]:
        """Return both pairs of turn and tilt, the turn by whole turns nearest to `turned`."""
        x, y, z = axis.tolist()
        if self.turn == "C":
            across = math.hypot(x, y)
            turn = math.atan2(y, x) if self.tilt == "B" else math.atan2(x, -y)
            tilt = math.atan2(across, z)
            other = -tilt
        else:
            across = math.hypot(x, z) if self.tilt == "A" else math.hypot(y, z)
            turn = math.atan2(x, z) if self.tilt == "A" else math.atan2(-y, z)
            tilt = math.atan2(-y if self.tilt == "A" else x, across)
            other = math.pi - tilt if tilt > 0 else -math.pi - tilt
        if across < ALONG:
            return [(turned, tilt)]
        return [(_near(turn, turned), tilt), (_near(turn + math.pi, turned), other)]

    def angles_along(self, axes: Floats, before: Angles) -> Floats:
        """Return angles, shape (n, 2), rad, for tool axes, shape (n, 3), each nearest to the one before it.

        While the tool is along the turning axis, that goes where the next leaning of the tool will want it.
        """
        still = np.eye(3)["ABC".index(self.turn)]
        leaning = np.flatnonzero(np.linalg.norm(np.cross(axes, still), axis=1) >= ALONG)
        following = np.searchsorted(leaning, np.arange(len(axes)))
        order = self.letters.index(self.turn)
        out = np.empty((len(axes), 2))
        for k, axis in enumerate(axes):
            if following[k] < len(leaning) and leaning[following[k]] > k:
                ahead = self.angles_of(axes[leaning[following[k]]], before)
                before = (ahead[0], before[1]) if order == 0 else (before[0], ahead[1])
            before = self.angles_of(axis, before)
            out[k] = before
        return out

    def swing(self, axes: Floats, angles: Floats) -> tuple[float, float]:
        """Return the largest swing of the turning axis close by the pole, and the smallest angle to it there, rad.

        A swing is how far it turns while the tool stays within `CLOSE` of the turning axis without being along it. Both
        angles are 0 without a swing.

        Args:
            axes: Of the tool, shape (n, 3).
            angles: Of `letters`, shape (n, 2), rad.
        """
        still = np.eye(3)["ABC".index(self.turn)]
        sine = np.linalg.norm(np.cross(axes, still), axis=1)
        close = (sine < math.sin(CLOSE)) & (sine > ALONG)
        turned = angles[:, self.letters.index(self.turn)]
        worst = (0.0, 0.0)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], close, [False]]).astype(np.int8)))
        for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            part = slice(max(begin - 1, 0), min(end + 1, len(axes)))
            swept = float(np.ptp(turned[part]))
            if swept > worst[0]:
                worst = (swept, float(elementary.arcsin(sine[begin:end].min())))
        return worst

    def slides(self, tip: Floats, angles: Angles, length: float) -> Floats:
        """Return where the slides stand, shape (3,), for a tip in the workpiece; where it is upright they are the tip.

        Args:
            tip: Shape (3,), mm.
            angles: Of `letters`, rad.
            length: Of the tool, mm.
        """
        if self.mechanism is None:
            return tip
        x, y, z = self.mechanism.machine(*self._place(tip, angles), length)
        return np.array([x, y, z - length])

    def lever(self, tip: Floats, angles: Angles, length: float) -> float:
        """Return how far the tip goes as the rotary axes turn, mm/rad; see `Kinematics.lever`. 0 where X Y Z stay the tip."""
        if self.mechanism is None:
            return 0.0
        return self.mechanism.lever(*self._place(tip, angles), length)

    def _place(self, tip: Floats, angles: Angles) -> tuple[tuple[float, float, float], Angles]:
        """Return tip and angles as the mechanism has them, in mm and degrees."""
        assert self.mechanism is not None
        first, second = ("ABC"[column - 3] for column in self.mechanism.axes)
        degrees = dict(zip(self.letters, map(math.degrees, angles), strict=True))
        return (float(tip[0]), float(tip[1]), float(tip[2])), (degrees[first], degrees[second])

    def frame(self, angles: Angles, length: float) -> Matrix:
        """Return the frame in which the slides see the workpiece at fixed angles, shape (4, 4)."""
        out = np.eye(4)
        if self.mechanism is not None:
            out[:3, 3] = self.slides(np.zeros(3), angles, length)
            for k in range(3):
                out[:3, k] = self.slides(np.eye(3)[k], angles, length) - out[:3, 3]
        return out


def _near(angle: float, reference: float) -> float:
    """Return the angle by whole turns nearest to a reference."""
    return angle + 2 * math.pi * round((reference - angle) / (2 * math.pi))

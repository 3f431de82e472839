"""Where a tool is, seen from the workpiece: of the axes of a fork head or of a machine with `[kinematics]`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cncgen.machine.kinematics import Kinematics

Floats = NDArray[np.float64]


class TipPoses:
    """X Y Z are the tip; B tilts the tool and C turns what is tilted, as `cncgen.stepnc` writes programs without a machine."""

    def __call__(self, letters: str, positions: Floats) -> tuple[Floats, Floats]:
        """Return tips and tool axes, shapes (n, 3), of positions, shape (n, letters), mm and rad."""
        axes = np.zeros((len(positions), 3))
        axes[:, 2] = 1.0
        for letter, column in (("A", 3), ("B", 4), ("C", 5)):
            if letter in letters:
                axes = _turned(axes, column, positions[:, letters.index(letter)])
        return positions[:, :3], axes

    def offset(self, length_mm: float) -> None:
        """Take the length of the tool from now on: it changes nothing."""


class MachinePoses:
    """X Y Z are those of a machine's slides less the tool's offset, and its rotary axes carry table or head.

    Tips are seen from the table at 0.
    """

    def __init__(self, kinematics: Kinematics) -> None:
        self._mechanism = kinematics
        self._length = 0.0

    def offset(self, length_mm: float) -> None:
        """Take the length of the tool from now on."""
        self._length = length_mm

    def __call__(self, letters: str, positions: Floats) -> tuple[Floats, Floats]:
        """Return tips and tool axes, shapes (n, 3), of positions, shape (n, letters), mm and rad."""
        mechanism = self._mechanism
        upright = np.zeros((len(positions), 3))
        upright[:, 2] = 1.0
        turns = []
        for place in mechanism.turns:
            column = mechanism.axes[place]
            letter = "ABC"[column - 3]
            angles = positions[:, letters.index(letter)] if letter in letters else np.zeros(len(positions))
            turns.append((column, angles))
        head, table = turns[: mechanism.heads], turns[mechanism.heads :]
        axes = upright
        for column, angles in head:
            axes = _turned(axes, column, angles)
        centre = np.array(mechanism.centre)
        away = positions[:, :3] - centre - (mechanism.pivot + self._length) * (axes - upright)
        for column, angles in table:
            away, axes = _turned(away, column, angles), _turned(axes, column, angles)
        return away + centre, axes


def _turned(vectors: Floats, column: int, angles: Floats) -> Floats:
    """Turn vectors, shape (n, 3), about A, B or C (columns 3, 4, 5) by angles, shape (n,), rad."""
    first, second = ((1, 2), (2, 0), (0, 1))[column - 3]
    c, s = np.cos(angles), np.sin(angles)
    out = vectors.copy()
    out[:, first] = c * vectors[:, first] - s * vectors[:, second]
    out[:, second] = s * vectors[:, first] + c * vectors[:, second]
    return out

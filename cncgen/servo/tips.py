"""Where the tip of the tool is on the workpiece, of a machine whose rotary axes carry table or head (`[kinematics]`)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from cncgen.machine.kinematics import Kinematics
from cncgen.setpoints.record import Setpoints

Floats = NDArray[np.float64]


def tips_on_workpiece(kinematics: Kinematics, axes: str, positions: Floats, lengths: Floats) -> Floats:
    """Return the tips, shape (n, 3), of positions of a machine's axes, seen from the table at 0 (`Kinematics.tip`).

    Args:
        kinematics: Of the machine.
        axes: Letters of the columns.
        positions: Shape (n, axes), mm and rad; axes that are not among them stand at 0.
        lengths: Shape (n,), mm: the offset of the tool along the spindle.
    """
    still = np.zeros(len(positions))
    x, y, z = (positions[:, axes.index(letter)] if letter in axes else still for letter in "XYZ")
    turned = ["ABC"[column - 3] for column in kinematics.axes]
    first, second = (
        np.degrees(positions[:, axes.index(letter)]) if letter in axes else still for letter in turned
    )
    # Each coordinate as an array, for as many points.
    tips = kinematics.tip((x, y, z), (first, second), lengths)  # type: ignore[arg-type]
    return np.column_stack([np.broadcast_to(coordinate, still.shape) for coordinate in tips])


class TipTracker:
    """Follows the tool along a stream of setpoints that has its length, the signal ``tool_length``."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._kinematics = kinematics
        self._lengths = [np.zeros(0)]
        self._last = 0.0

    @staticmethod
    def follows(kinematics: Kinematics | None, head: Setpoints) -> bool:
        """Tell whether the tip can be followed along a stream that begins like this, and another axis than X Y Z carries it."""
        carried = kinematics is not None and any("ABC"[column - 3] in head.axes for column in kinematics.axes)
        return carried and "tool_length" in head.signals

    def noting(self, setpoints: Iterable[Setpoints]) -> Iterator[Setpoints]:
        """Yield setpoints on, and keep the lengths until their rows are asked for."""
        for chunk in setpoints:
            if len(chunk):
                # A stretch of rest at the end may come without the signals of the plan.
                lengths = chunk.signals.get("tool_length", np.full(len(chunk), self._last))
                self._lengths.append(lengths)
                self._last = float(lengths[-1])
            yield chunk

    def lengths(self, rows: int) -> Floats:
        """Return the lengths of the next rows; the last one holds after the end."""
        lengths = np.concatenate(self._lengths)
        here = np.concatenate([lengths[:rows], np.full(max(rows - len(lengths), 0), self._last)])
        self._lengths = [lengths[rows:]]
        return here

    def tips(self, axes: str, positions: Floats, lengths: Floats) -> Floats:
        """Return the tips, shape (n, 3), of positions, shape (n, axes)."""
        return tips_on_workpiece(self._kinematics, axes, positions, lengths)

"""Setpoints in the units of a drive: the objects of CiA 402-2 in cyclic synchronous position mode.

Of each axis, once a period: target position 607Ah, position offset 60B0h (0 here, the target contains all), velocity
offset 60B1h and torque offset 60B2h as feedforward. Each target is the nearest integer to the position, so it is within
half an increment of it at every sample: rounding never adds up.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.machine.drives import INT32
from cncgen.machine.record import Drive
from cncgen.setpoints.columns import check_finite, position_column
from cncgen.setpoints.record import Setpoints
from cncgen.units import file_unit

Floats = NDArray[np.float64]

#: Objects of an axis, with the type of each: 14 bytes, packed.
OBJECTS = (("607a", "<i4"), ("60b0", "<i4"), ("60b1", "<i4"), ("60b2", "<i2"))
#: Names of columns, in words, for the head of a file.
ABOUT = {
    "607a": "target position",
    "60b0": "position offset",
    "60b1": "velocity offset",
    "60b2": "torque offset",
}
_INT16 = 2**15 - 1


def frame_type(axes: str) -> np.dtype:
    """Return the layout of a period: the objects of each axis, one axis after the other."""
    return np.dtype([(f"{axis.lower()}_{name}", kind) for axis in axes for name, kind in OBJECTS])


def drives_of(axes: str, drives: Mapping[str, Drive]) -> list[Drive]:
    """Return the drive of each axis.

    Raises:
        UsageError: An axis has none.
    """
    missing = [axis for axis in axes if axis not in drives]
    if missing:
        tables = ", ".join(f"[axes.{axis.lower()}.drive]" for axis in missing)
        keys = " and ".join(dict.fromkeys(f"counts_per_{file_unit(axis)}" for axis in missing))
        message = f"csp and csp-raw need the drive scaling of axis {', '.join(missing)}"
        raise UsageError(
            Diagnostic("machine-missing", message, hint=f"give the machine file {tables} with {keys}")
        )
    return [drives[axis] for axis in axes]


class FrameMaker:
    """Turns a stream of chunks into frames.

    Velocity and acceleration at a setpoint are central differences of the setpoints, at rest before the first and after
    the last one, so the last row of a chunk waits for the next chunk.
    """

    def __init__(self, axes: str, period_s: float, drives: Mapping[str, Drive]) -> None:
        self.drives = drives_of(axes, drives)
        self._axes, self._period, self._type = axes, period_s, frame_type(axes)
        self._kept = np.zeros((0, len(axes)))
        self._before: Floats | None = None
        self._row = 0

    def frames(self, chunk: Setpoints) -> NDArray[np.void]:
        """Return the frames of all rows up to the one before the chunk's last."""
        check_finite(chunk.position, [position_column(axis) for axis in self._axes], chunk.first)
        rows = np.concatenate([self._kept, chunk.position])
        if self._before is None and len(rows):
            self._before = rows[0]
        self._kept = rows[-1:].copy()
        return self._made(rows[:-1], rows[-1] if len(rows) else None)

    def last(self) -> NDArray[np.void]:
        """Return the frame of the last row."""
        return self._made(self._kept, self._kept[-1] if len(self._kept) else None)

    def _made(self, rows: Floats, after: Floats | None) -> NDArray[np.void]:
        frames = np.zeros(len(rows), self._type)
        if not len(rows) or after is None or self._before is None:
            return frames
        around = np.concatenate([self._before[None], rows, after[None]])
        velocity = (around[2:] - around[:-2]) / (2 * self._period)
        acceleration = (around[2:] - 2 * rows + around[:-2]) / self._period**2
        for k, (axis, drive) in enumerate(zip(self._axes, self.drives, strict=True)):
            sign = -1.0 if drive.reversed else 1.0
            scale = drive.counts if drive.velocity_scale is None else drive.velocity_scale
            v, a = velocity[:, k], acceleration[:, k]
            torque = drive.torque_inertia * a + drive.torque_viscous * v + drive.torque_friction * np.sign(v)
            values = {
                "607a": drive.offset + sign * rows[:, k] * drive.counts,
                "60b1": sign * v * scale,
                "60b2": sign * torque,
            }
            for name, value in values.items():
                frames[f"{axis.lower()}_{name}"] = self._rounded(value, axis, name)
        self._before = rows[-1].copy()
        self._row += len(rows)
        return frames

    def _rounded(self, values: Floats, axis: str, name: str) -> Floats:
        """Return the nearest integers, or raise `UsageError` where the object cannot hold one."""
        bound = _INT16 if name == "60b2" else INT32
        rounded = np.rint(values)
        if not np.abs(rounded).max(initial=0.0) <= bound:  # NaN too
            at = int(np.argmax(~(np.abs(rounded) <= bound)))
            message = (
                f"setpoint {self._row + at}: {ABOUT[name]} {name.upper()}h of axis {axis} is {values[at]:.6g}, "
                f"beyond {bound}"
            )
            hint = f"look at [axes.{axis.lower()}.drive] of the machine"
            raise UsageError(Diagnostic("setpoint-range", message, hint=hint))
        return rounded


def positions(frames: Mapping[str, NDArray], axes: str, drives: Mapping[str, Drive]) -> Floats:
    """Return the positions, shape (n, axes), mm or rad, that frames ask of the axes: 607Ah and 60B0h together."""
    columns = []
    for axis in axes:
        drive, low = drives[axis], axis.lower()
        counts = frames[f"{low}_607a"].astype(np.float64) + frames[f"{low}_60b0"].astype(np.float64)
        columns.append((counts - drive.offset) * (-1.0 if drive.reversed else 1.0) / drive.counts)
    return np.stack(columns, axis=1)


def description(axes: str, period_s: float, drives: Mapping[str, Drive]) -> dict[str, object]:
    """Return the description of frames that stands at the head of a file: period, layout, and scaling of each axis."""
    from cncgen.machine.drives import drive_table

    kind = frame_type(axes)
    return {
        "format": "csp",
        "period_s": period_s,
        "axes": axes,
        "frame_bytes": kind.itemsize,
        "objects": {name: {"type": t, "about": ABOUT[name]} for name, t in OBJECTS},
        "drives": {axis: drive_table(drives[axis], axis) for axis in axes},
    }

"""Several axis loops side by side as the arrays that the kernel runs, with their state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.kernels import servo_loop
from cncgen.servo.loop import AxisLoop

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Coupling:
    """Coupling of the axes over a block of n setpoints; one of the two, as `Axes.run_coupled` of the kernel has it.

    Attributes:
        gains: (proportional, integral a control period) of cross coupling, or empty.
        tangent, curvature: Shape (n, axes), of cross coupling.
        feedforward: Shape (n, 2, axes): drive input and desired velocity, of state feedback.
        feedback: Shape (n, 2, axes, axes), of state feedback.
    """

    gains: Floats
    tangent: Floats
    curvature: Floats
    feedforward: Floats
    feedback: Floats


class LoopBank:
    """Axis loops with their states; `run` carries them over a block.

    All setpoints are relative to where the axes stood at first: loops start at rest at zero.
    """

    def __init__(self, loops: Sequence[AxisLoop], period_s: float) -> None:
        order = max(len(loop.output) for loop in loops)
        levels = max(loop.phi.shape[1] for loop in loops)
        axes = len(loops)
        self.loops = tuple(loops)
        self.feedthrough = np.array([loop.feedthrough for loop in loops])
        self._axes = servo_loop.Axes(
            _stacked([loop.phi for loop in loops], (4, levels, order, order)),
            _stacked([loop.inputs for loop in loops], (4, levels, 5, order)),
            _stacked([loop.output for loop in loops], (order,)),
            _stacked([loop.encoder for loop in loops], (order,)),
            _stacked([loop.jump for loop in loops], (order, order)),
            _stacked([loop.jump_inputs for loop in loops], (3, order)),
            _stacked([loop.law for loop in loops], (order,)),
            _stacked([loop.law_inputs for loop in loops], (2,)),
            _stacked([loop.stick_law for loop in loops], (2, order)),
            _stacked([loop.stick_inputs for loop in loops], (2, 2)),
            np.array([_numbers(loop) for loop in loops]),
            np.array([_switches(loop, period_s) for loop in loops], np.int64),
            np.zeros((axes, order)),
            np.zeros((axes, 3)),
            np.zeros((2, max(order, 5))),
        )
        self._parts = [round(period_s / loop.period) for loop in loops]
        self._integral = np.zeros(axes)
        self._noise = [np.random.default_rng([loop.imperfections.seed, i]) for i, loop in enumerate(loops)]

    def run(
        self, setpoints: Floats, desired: Floats | None = None, coupling: Coupling | None = None
    ) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Carry the loops over n setpoints.

        Args:
            setpoints: Shape (n + 1, axes); the last row is the first one of the next chunk.
            desired: Shape (n + 1, axes): reference of the coupling's errors; None: the setpoints.
            coupling: Coupling of the axes, or None.

        Returns:
            Position, drive input and whether the drive met its bound; each of shape (n, axes).
        """
        rows = np.ascontiguousarray(setpoints.T)
        axes, count = len(rows), rows.shape[1] - 1
        position, force = np.empty((axes, count)), np.empty((axes, count))
        bounded = np.empty((axes, count), np.uint8)
        common = (rows, self._draw(count), position, force, bounded)
        if coupling is None:
            self._axes.run(*common)
        else:
            self._axes.run_coupled(
                *common,
                rows if desired is None else np.ascontiguousarray(desired.T),
                coupling.gains,
                coupling.tangent,
                coupling.curvature,
                coupling.feedforward,
                coupling.feedback,
                self._integral,
                np.zeros((3, axes)),
            )
        position += self.feedthrough[:, None] * rows[:, :-1]
        return position.T, force.T, bounded.T.astype(bool)

    def _draw(self, count: int) -> Floats:
        if not any(loop.imperfections.noise for loop in self.loops):
            return np.zeros((len(self.loops), 1))
        draws = np.zeros((len(self.loops), count * max(self._parts)))
        for i, loop in enumerate(self.loops):
            if loop.imperfections.noise:
                wanted = count * self._parts[i]
                draws[i, :wanted] = self._noise[i].standard_normal(wanted)
        return draws


def _stacked(parts: list[Floats], shape: tuple[int, ...]) -> Floats:
    result = np.zeros((len(parts), *shape))
    for i, part in enumerate(parts):
        index: tuple[slice, ...] = tuple(slice(0, size) for size in part.shape)
        result[i][index] = part
    return result


def _numbers(loop: AxisLoop) -> tuple[float, ...]:
    faults = loop.imperfections
    coulomb = faults.coulomb if loop.velocity >= 0 else 0.0
    return faults.bound, coulomb, loop.dead_band, faults.backlash, faults.encoder_step, faults.noise


def _switches(loop: AxisLoop, period_s: float) -> tuple[int, ...]:
    parts = round(period_s / loop.period)
    return len(loop.output), loop.velocity, parts, int(loop.sampled), int(loop.imperfections.load_feedback)

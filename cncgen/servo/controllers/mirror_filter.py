"""Reference shaping with the loop's own model: r + (r − G r), one pass of iterated mirror compensation.

The model runs one setpoint ahead of the machine, with friction and bounds. `cncgen.servo.mirror` makes more passes and describes their
demands on the machine.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from cncgen.servo.bank import LoopBank
from cncgen.servo.loop import AxisLoop
from cncgen.servo.stream import SampleBlock

Floats = NDArray[np.float64]


class MirrorFilter:
    """The prefilter of all axes (`cncgen.servo.scheme.Prefilter`)."""

    before, after = 0, 2

    def __init__(self, loops: Sequence[AxisLoop]) -> None:
        """Take the model of each axis."""
        self._loops = tuple(loops)

    def started(self) -> Callable[[SampleBlock, Floats], Floats]:
        """Return the filter with its model at rest."""
        bank: list[LoopBank] = []
        carried = np.zeros((0, len(self._loops)))

        def over(block: SampleBlock, origin: Floats) -> Floats:
            nonlocal carried
            if not bank:
                bank.append(LoopBank(self._loops, block.period_s))
            # The first block asks for one row more than it has; each later one has that row from before.
            rows = block.values[block.before + len(carried) : block.before + len(block) + 2] - origin
            position, _, _ = bank[0].run(rows)
            shaped = np.concatenate([carried, 2.0 * rows[:-1] - position])
            carried = shaped[-1:]
            return shaped

        return over

"""A largest speed along a block that comes from outside: from another plan, or from what servo loops make of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.planner.record import Limit

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SpeedCap:
    """The largest speed along the path of a block.

    Attributes:
        speed: Gives mm/s at path coordinates, shape (n,), ascending; infinite where there is no cap.
        limit: What it stands for.
        straight: Whether it may be finite on straight lines.
    """

    speed: Callable[[Floats], Floats]
    limit: Limit
    straight: bool = True

    def lower(self, s: Floats, top: Floats) -> Floats:
        """Return the smaller of `top`, q = v² at ascending path coordinates, and the cap's."""
        out: Floats = np.minimum(top, self.speed(s) ** 2)
        return out

    def on_intervals(self, s: Floats, leaves: NDArray[np.bool_], enters: NDArray[np.bool_]) -> Floats:
        """Return q at the left end, middle and right end of intervals, each seen from inside, shape (n, 3).

        The speed that the cap has at a rest itself, 0 where it is a plan's, is no bound of the motion beside it:
        an interval that leaves or enters rest has the cap of its moving end.

        Args:
            s: Shape (n + 1,), nodes.
            leaves, enters: Shape (n,), intervals that leave and enter rest.
        """
        inside = 1e-6 * np.diff(s)
        q = np.stack(
            [self.speed(at) ** 2 for at in (s[:-1] + inside, 0.5 * (s[:-1] + s[1:]), s[1:] - inside)],
            axis=1,
        )
        q[leaves] = q[leaves, 2:]
        q[enters] = q[enters, :1]
        return q

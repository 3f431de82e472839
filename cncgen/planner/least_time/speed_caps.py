"""A largest speed along a block that comes from outside: from another plan, or from the simulated servo loops.

Made by `cncgen.planner.least_time.contour_bound`, `cncgen.planner.least_time.replanning` and, for chords under G64, `block_planning`; used by `mesh`.
"""

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
        speed: Function of ascending path coordinates, shape (n,), mm, and of the path and its derivatives there (up to the
            second at least), shape (≥ 3, n, axes). Returns the largest speed, shape (n,), mm/s; infinite without one.
        limit: The `Limit` that is named where the cap binds.
        straight: Whether it may be finite on straight lines.
    """

    speed: Callable[[Floats, Floats], Floats]
    limit: Limit
    straight: bool = True

    def lower(self, s: Floats, x: Floats, top: Floats) -> Floats:
        """Return the smaller of `top`, q = v² at ascending path coordinates where the path is `x`, and the cap's."""
        out: Floats = np.minimum(top, self.speed(s, x) ** 2)
        return out

    def on_intervals(
        self, s: Floats, x: Floats, leaves: NDArray[np.bool_], enters: NDArray[np.bool_]
    ) -> Floats:
        """Return q at the left end, middle and right end of intervals, each seen from inside, shape (n, 3).

        At a rest the cap of a plan is 0, which does not bound the motion beside it:
        an interval that leaves or enters rest has the cap of its moving end.

        Args:
            s: Shape (n + 1,), nodes.
            x: Shape (≥ 3, n, 3, axes), the path and its derivatives there.
            leaves, enters: Shape (n,), intervals that leave and enter rest.
        """
        inside = 1e-6 * np.diff(s)
        places = np.stack([s[:-1] + inside, 0.5 * (s[:-1] + s[1:]), s[1:] - inside], axis=1)
        speed = self.speed(places.ravel(), x.reshape(len(x), places.size, -1))
        q = speed.reshape(places.shape) ** 2
        q[leaves] = q[leaves, 2:]
        q[enters] = q[enters, :1]
        return q

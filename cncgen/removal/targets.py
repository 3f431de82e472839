"""The finished part as a mesh: the material that is to stay, and the material that is to go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.geometry import elementary
from cncgen.removal.stock import columns_of, read_stl

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class MeshTarget:
    """A part whose surface seen from above is that of a mesh.

    Attributes:
        triangles: Shape (n, 3, 3), mm.
    """

    triangles: Floats

    @classmethod
    def of_file(cls, name: str) -> MeshTarget:
        """Return the part of an STL file.

        Raises:
            UsageError: The file cannot be read.
        """
        return cls(read_stl(name))

    def moved(self, move: Floats) -> MeshTarget:
        """Return the part after a motion, shape (4, 4)."""
        return MeshTarget(elementary.product(self.triangles, move[:3, :3].T) + move[:3, 3])

    def _top(self, x: Floats, y: Floats) -> Floats:
        top, bottom = columns_of(self.triangles, x[0], y[:, 0])
        return np.where(top > bottom, top, -np.inf)

    def floor(self, x: Floats, y: Floats) -> Floats:
        """Return the part's top over places of a grid, shapes alike, -inf beside it."""
        return self._top(x, y)

    def demanded(self, x: Floats, y: Floats) -> Floats:
        """Return the part's top over places of a grid, shapes alike: nothing may stand above it."""
        return self._top(x, y)

    def owner(self, x: float, y: float) -> tuple[str, int]:
        """Return no name: a mesh belongs to no line of the program."""
        return "", 1

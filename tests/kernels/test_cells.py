"""Cells of the table of lengths."""

import numpy as np

from cncgen.kernels import arc_length


def test_the_cell_of_a_place_is_found_from_whichever_was_found_before() -> None:
    """numpy's bisection finds the same, in tables with cells of no length, from every row and from beyond the table."""
    rng = np.random.default_rng(27)
    for _ in range(50):
        cells = np.zeros((int(rng.integers(2, 12)), 12))
        cells[:, 1] = np.sort(rng.integers(0, 8, len(cells)))
        low, high = np.sort(rng.choice(len(cells) + 1, 2, replace=False)).tolist()
        for reach in (*cells[low:high, 1], -1.0, 3.5, 9.0):
            after = int(np.searchsorted(cells[low:high, 1], reach))
            for near in range(-1, len(cells) + 2):
                assert arc_length.cell_at(cells, low, high, reach, near) == low + max(after - 1, 0)

"""Decimal text of numbers against Python's own formatting and parsing, compiled and as plain Python."""

from __future__ import annotations

import math
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cncgen.kernels import decimal_rows
from tests.kernels.plain import uncompiled

PLAIN = uncompiled("decimal_rows")


def written(kernel: ModuleType, values: list[list[float]], decimals: int) -> str:
    """Format rows with commas."""
    matrix = np.array(values, np.float64)
    n, columns = matrix.shape
    literals = np.frombuffer(b"," * (columns - 1) + b"\n", np.uint8).copy()
    ends = np.arange(columns + 1, dtype=np.int64)
    ends[-1] = columns
    out = np.empty(n * (columns * kernel.MAX_WIDTH + columns), np.uint8)
    size = kernel.write_rows(matrix, np.full(columns, decimals, np.int32), literals, ends, out)
    return out[:size].tobytes().decode()


def read(kernel: ModuleType, text: bytes, columns: int) -> tuple[np.ndarray, int, int]:
    """Parse rows; return the matrix, the place where it stopped, and the rows read."""
    out = np.full((text.count(b"\n"), columns), np.nan)
    state = np.zeros(2, np.int64)
    kernel.read_rows(np.frombuffer(text, np.uint8), 0, 0, 10.0 ** np.arange(23), out, state)
    return out, int(state[0]), int(state[1])


writable = st.floats(min_value=-9e15, max_value=9e15, allow_nan=False)
#: Odd multiples of 2⁻¹⁰ are exactly half way between two numbers of nine decimals.
ties = st.integers(-(10**9), 10**9).map(lambda k: (2 * k + 1) / 1024)
near = st.tuples(st.integers(-(10**13), 10**13), st.sampled_from([-math.inf, math.inf])).map(
    lambda p: math.nextafter(p[0] / 1e9 + 5e-10, p[1])
)


@given(st.one_of(writable, ties, near, st.floats(-1e-6, 1e-6)))
@example(0.0)
@example(-0.0)
@example(-4e-10)
@example(0.9999999995)
@example(1.0 - 2.0**-53)
@example(2.0**53 - 1)
@example(5e-324)
@pytest.mark.parametrize("kernel", [decimal_rows, PLAIN], ids=["installed", "plain"])
def test_nine_decimals_are_those_of_python(kernel: ModuleType, value: float) -> None:
    assert written(kernel, [[value]], 9) == format(value, "z.9f") + "\n"
    assert written(kernel, [[value]], 0) == format(value, "z.0f") + "\n"


def test_many_numbers_in_bulk() -> None:
    rng = np.random.default_rng(7)
    values = np.concatenate(
        [
            rng.uniform(-1000, 1000, 20_000),
            rng.uniform(-1e-3, 1e-3, 10_000),
            (2 * rng.integers(-(10**6), 10**6, 10_000) + 1) / 1024,
            np.round(rng.uniform(-100, 100, 10_000), 9) + 5e-10,
        ]
    ).reshape(-1, 5)
    expected = "".join(",".join(format(x, "z.9f") for x in row) + "\n" for row in values)
    assert written(decimal_rows, values.tolist(), 9) == expected


def test_uncompiled_is_the_same_kernel() -> None:
    assert Path(PLAIN.__file__ or "").suffix == ".py"
    values = np.random.default_rng(1).uniform(-500, 500, (200, 3)).tolist()
    text = written(decimal_rows, values, 9)
    assert written(PLAIN, values, 9) == text
    for ours, other in zip(read(decimal_rows, text.encode(), 3), read(PLAIN, text.encode(), 3), strict=True):
        np.testing.assert_array_equal(ours, other)


@given(st.lists(st.tuples(writable, writable), min_size=1, max_size=5), st.integers(0, 12))
def test_reading_is_as_exact_as_python(rows: list[tuple[float, float]], decimals: int) -> None:
    text = "".join(f"{a:.{decimals}f},{b:+.{decimals}f}\n" for a, b in rows)
    matrix, at, count = read(decimal_rows, text.encode(), 2)
    lines = text.splitlines(keepends=True)
    assert at == sum(map(len, lines[:count]))
    for row, line in zip(matrix[:count], lines, strict=False):
        assert row.tolist() == [float(cell) for cell in line.split(",")]
    if count < len(rows):  # it may only leave rows with more digits than a double's 2⁵³ holds
        assert max(sum(c.isdigit() for c in cell) for cell in lines[count].split(",")) > 15


@pytest.mark.parametrize(
    "line",
    [
        b"1,2,3\n",
        b"1\n",
        b"1,\n",
        b"1,x\n",
        b"1,nan\n",
        b"1,1e3\n",
        b"1,--2\n",
        b"1,2 3\n",
        b"1,2.3.4\n",
        b"\n",
        b"1,.\n",
    ],
)
@pytest.mark.parametrize("kernel", [decimal_rows, PLAIN], ids=["installed", "plain"])
def test_reading_stops_at_what_is_no_plain_row(kernel: ModuleType, line: bytes) -> None:
    assert read(kernel, b"1.5 , -2\r\n" + line + b"3,4\n", 2)[1:] == (10, 1)

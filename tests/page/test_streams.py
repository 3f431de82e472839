"""Streams of the page: what is decoded, as docs/page.md says, is what was encoded."""

from __future__ import annotations

import zlib
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.report.page.streams import DIGITS, Bands, Blob, IntegerStream, RunStream, base85


def decoded(blob: bytes, spec: dict[str, Any]) -> list[int]:
    """Return the integers of a stream, number by number."""

    def part(at: list[int]) -> bytes:
        return zlib.decompress(blob[at[0] : at[0] + at[1]])

    numbers, large = part(spec["at"]), np.frombuffer(part(spec["escapes"]), "<f8").tolist()
    sums = [0] * (spec["order"] + 1)
    found = []
    for number in numbers:
        folded = int(large.pop(0)) if number == 255 else number
        sums[0] = -(folded + 1) // 2 if folded % 2 else folded // 2
        for k in range(spec["order"]):
            sums[k + 1] += sums[k]
        found.append(sums[-1])
    assert len(found) == spec["count"]
    assert not large
    return found


class Bytes(Blob):
    """A blob whose bytes a test can see."""

    @property
    def data(self) -> bytes:
        return b"".join(self._parts)


@given(
    st.lists(st.integers(-(2**40), 2**40) | st.integers(-3, 3), max_size=300),
    st.integers(0, 3),
    st.integers(1, 50),
)
def test_integers_come_back(values: list[int], order: int, size: int) -> None:
    stream, blob = IntegerStream(order), Bytes()
    for start in range(0, len(values), size):
        stream.add(np.array(values[start : start + size], np.int64))
    spec = stream.finish(blob)
    assert decoded(blob.data, spec) == values
    assert spec.get("wide", False) == any(abs(v) > 2**30 for v in values)


@given(st.lists(st.tuples(st.integers(-5, 5), st.integers(1, 9)), max_size=60), st.integers(1, 20))
def test_runs_come_back(runs: list[tuple[int, int]], size: int) -> None:
    values = [value for value, length in runs for _ in range(length)]
    stream, blob = RunStream(), Bytes()
    for start in range(0, len(values), size):
        stream.add(np.array(values[start : start + size], np.int64))
    spec = stream.finish(blob)
    heads, lengths = decoded(blob.data, spec["values"]), decoded(blob.data, spec["lengths"])
    assert [v for v, n in zip(heads, lengths, strict=True) for _ in range(n)] == values
    assert all(a != b for a, b in pairwise(heads))


@pytest.mark.parametrize("rows", [0, 1, 7, 64, 1000, 4097])
@pytest.mark.parametrize("size", [1, 13, 700])
def test_bands_are_the_lowest_and_highest_of_their_blocks(rows: int, size: int) -> None:
    rng = np.random.default_rng(rows + size)
    values = rng.normal(size=(rows, 3)) * [1.0, 100.0, 1e6]
    steps = {"a": 0.01, "b": 1.0, "c": 100.0}
    bands, blob = Bands(steps, most=1500, most_joined=600), Bytes()
    for start in range(0, rows, size):
        bands.add(values[start : start + size])
    found = bands.finish(blob)
    if not rows:
        assert found == {}
        return
    block = bands.block
    assert (block == 1) == (3 * rows <= 1500)
    for column, (name, step) in enumerate(steps.items()):
        whole = np.rint(values[:, column] / step).astype(int)
        parts = [whole[k : k + block] for k in range(0, rows, block)]
        low = decoded(blob.data, found[name]["low"])
        assert low == [int(part.min()) for part in parts]
        if block > 1:
            spread = decoded(blob.data, found[name]["spread"])
            assert [a + b for a, b in zip(low, spread, strict=True)] == [int(part.max()) for part in parts]


@given(st.binary(max_size=200))
def test_base_85_comes_back(data: bytes) -> None:
    text = base85(data)
    assert len(text) == 5 * -(-len(data) // 4)
    words = [text[k : k + 5] for k in range(0, len(text), 5)]
    numbers = [sum(DIGITS.index(c) * 85 ** (4 - k) for k, c in enumerate(word)) for word in words]
    assert b"".join(number.to_bytes(4, "big") for number in numbers)[: len(data)] == data


def test_digits_mean_nothing_in_html_and_scripts() -> None:
    assert len(set(DIGITS)) == len(DIGITS) == 85
    assert not set(DIGITS) & set("<>&\"'`\\$- \n")


def test_differences_of_a_smooth_motion_are_small() -> None:
    """A sine of 40 mm in 2 s at 1 ms: the third difference is below two steps of 0.1 µm, under half a byte a row."""
    t = np.arange(20_000) * 1e-3
    stream, blob = IntegerStream(3), Blob()
    stream.add(np.rint(4e5 * np.sin(np.pi * t)).astype(np.int64))
    stream.finish(blob)
    assert blob.size < 0.45 * len(t)

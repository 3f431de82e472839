"""Packed signals come back as the page's own module reads them, and as plain sums and frequencies have them."""

from __future__ import annotations

import json
import shutil
import subprocess
import zlib
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cncgen.kernels import packed_rows as kernel
from cncgen.report.page import packed_rows
from cncgen.report.page.packed_rows import PackedStream, predictors
from cncgen.report.page.streams import Blob
from tests.kernels.plain import uncompiled

ROOT = Path(__file__).resolve().parent.parent.parent
Integers = NDArray[np.int64]

#: Reads a file of specifications, and one of bytes; prints the numbers in JSON.
_READ = """
import { readFileSync } from "node:fs";
const { packed } = await import(process.argv[3]);
const blob = new Uint8Array(readFileSync(process.argv[2] + "/blob"));
const { specs, predictors } = JSON.parse(readFileSync(process.argv[2] + "/specs"));
const found = [];
for (const spec of specs) found.push([...(await packed(blob, spec, predictors))]);
console.log(JSON.stringify(found));
"""


class Kept(Blob):
    """Bytes that a test can see."""

    @property
    def data(self) -> bytes:
        return b"".join(self._parts)


def read_back(signals: list[Integers], folder: Path, size: int) -> list[list[int]]:
    """Return signals as the page's module reads what the encoder wrote of them, some rows at a time."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed: the browser alone reads signals here")
    blob, specs = Kept(), []
    for signal in signals:
        stream = PackedStream()
        for start in range(0, len(signal), size):
            stream.add(signal[start : start + size])
        specs.append(stream.finish(blob))
    (folder / "blob").write_bytes(blob.data)
    (folder / "specs").write_text(json.dumps({"specs": specs, "predictors": predictors()}))
    (folder / "read.mjs").write_text(_READ)
    module = (ROOT / "cncgen/report/page/packed.js").as_uri()
    words = [node, str(folder / "read.mjs"), str(folder), module]
    run = subprocess.run(words, capture_output=True, timeout=300, check=False)
    assert run.returncode == 0, run.stderr.decode()
    found: list[list[int]] = json.loads(run.stdout)
    return found


def motion(rng: np.random.Generator, rows: int) -> Integers:
    """Return positions of a smooth motion in steps of 0.1 µm: sines whose jerk is a third of a step at most."""
    t = np.arange(rows)[:, None]
    periods = rng.uniform(60.0, 900.0, 5)
    return np.rint((0.06 * periods**3 * np.sin(t / periods + rng.uniform(0, 6, 5))).sum(axis=1)).astype(
        np.int64
    )


def test_signals_of_every_kind_come_back(tmp_path: Path) -> None:
    """Rest, smooth motions over several segments, jumps, noise, and numbers beyond 32 bits."""
    rng = np.random.default_rng()
    signals = [
        np.zeros(0, np.int64),
        np.array([5], np.int64),
        np.zeros(1000, np.int64),
        motion(rng, 150_000),
        motion(rng, packed_rows.SEGMENT),
        rng.integers(-(2**30), 2**30, 3000),
        rng.integers(-(2**45), 2**45, 3000),
        np.cumsum(rng.integers(-2, 3, 70_000)),
        rng.integers(-300, 300, 9000),
        np.repeat(rng.integers(-(2**29), 2**29, 40), 100),
    ]
    assert read_back(signals, tmp_path, int(rng.integers(1000, 90_000))) == [
        list(map(int, s)) for s in signals
    ]


def test_predictors_are_exact_on_polynomials() -> None:
    """A polynomial of the predictor's degree goes on as it is, to the rounding of the weights to a millionth."""
    rng = np.random.default_rng()
    for (degree, rows), parts in zip(packed_rows._PREDICTORS, predictors(), strict=True):
        assert len(parts) == rows - 1
        values = np.polyval(rng.normal(size=degree + 1), np.arange(rows + 1.0) / rows)
        steps = np.diff(values)
        predicted = float(np.dot(parts, steps[-2::-1])) / packed_rows.PARTS
        if degree:
            assert predicted == pytest.approx(steps[-1], abs=1e-4)


def test_the_kernel_predicts_and_codes_as_plain_python_does() -> None:
    rng = np.random.default_rng()
    weights, lengths = packed_rows._weights()
    values = motion(rng, 300)
    differences = np.concatenate(
        [np.zeros(weights.shape[1]), np.diff(values, prepend=0), np.zeros(kernel.BLOCK)]
    )
    found = []
    for module in (kernel, uncompiled("packed_rows")):
        choice, rest, cost = np.zeros(5, np.uint8), np.zeros(320), np.zeros(5)
        module.predicted(differences, 300, weights, lengths, choice, rest, cost)
        symbols = np.minimum(np.abs(rest[:300]), 255).astype(np.uint8)
        counts = np.bincount(symbols, minlength=256).reshape(1, 256)
        code = np.zeros(700, np.uint8)
        frequencies = packed_rows._frequencies(counts)
        length = module.coded(symbols, np.zeros(5, np.uint8), frequencies, code)
        found.append((choice.tolist(), rest.tolist(), cost.tolist(), code[:length].tolist()))
    assert found[0] == found[1]


def test_frequencies_add_up_and_leave_no_symbol_out() -> None:
    rng = np.random.default_rng()
    for spread in (1, 3, 200, 10**6):
        counts = np.floor(rng.random((20, 256)) ** 9 * spread * rng.integers(1, 9)).astype(np.int64)
        found = packed_rows._frequencies(counts)
        assert (found.sum(axis=1) == np.where(counts.any(axis=1), 4096, 0)).all()
        assert ((found > 0) == (counts > 0)).all()


def test_a_smooth_motion_takes_three_quarters_of_deflated_third_differences() -> None:
    values = motion(np.random.default_rng(), 200_000)
    stream, blob = PackedStream(), Blob()
    stream.add(values)
    stream.finish(blob)
    third = np.diff(values, n=3)
    folded = np.where(third < 0, -2 * third - 1, 2 * third)
    deflated = zlib.compress(np.minimum(folded, 255).astype(np.uint8).tobytes(), 9)
    assert blob.size < 0.75 * len(deflated)

"""A program's text comes back from the page byte by byte, as the page's own module reads it."""

from __future__ import annotations

import json
import shutil
import subprocess
import zlib
from pathlib import Path

import numpy as np
import pytest

from cncgen.report.page import numbered_text
from cncgen.report.page.numbered_text import put_text
from cncgen.report.page.streams import Blob

ROOT = Path(__file__).resolve().parent.parent.parent

#: Reads a file of specifications, and one of bytes; prints the texts in JSON.
_READ = """
import { readFileSync } from "node:fs";
const { textOf } = await import(process.argv[3]);
const blob = new Uint8Array(readFileSync(process.argv[2] + "/blob"));
const found = [];
for (const spec of JSON.parse(readFileSync(process.argv[2] + "/specs"))) found.push(await textOf(blob, spec));
console.log(JSON.stringify(found));
"""
_WORDS = [
    "G1 X", " Y", " Z-", " F", "\n", "\r\n", " (é漢)", "-", "+", "--", ".", "#", "=[", "]", "N", ",", "\n\n", "",
]  # fmt: skip
_NUMBERS = [
    "0", "-0", "0.0", "-0.0", "00", "007", ".5", "-.5", "0.5", "-0.50", "10.", "1.2.3", "123456789", "1234567890",
    "999999.999", "0.123456", "0.1234567", ".", "5.", "1e5", ".0", "00.5",
]  # fmt: skip


def read_back(texts: list[bytes], folder: Path) -> list[bytes]:
    """Return texts as the page's module reads what the encoder wrote."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed: the browser alone reads texts here")

    class Kept(Blob):
        def data(self) -> bytes:
            return b"".join(self._parts)

    blob = Kept()
    specs = [put_text(text, blob) for text in texts]
    (folder / "blob").write_bytes(blob.data())
    (folder / "specs").write_text(json.dumps(specs))
    (folder / "read.mjs").write_text(_READ)
    module = (ROOT / "cncgen/report/page/numbered.js").as_uri()
    words = [node, str(folder / "read.mjs"), str(folder), module]
    run = subprocess.run(words, capture_output=True, timeout=300, check=False)
    assert run.returncode == 0, run.stderr.decode()
    return [text.encode() for text in json.loads(run.stdout)]


def written(rng: np.random.Generator) -> bytes:
    """Return a text of random words and numbers, most of them like those of a program."""
    style = rng.choice(["{:.4f}", "{:.3f}", "{:g}", "{:.0f}", "bare"])
    words: list[str] = []
    for _ in range(int(rng.integers(0, 400))):
        words.append(str(rng.choice(_WORDS)))
        number = float(rng.normal()) * 10.0 ** int(rng.integers(-3, 6))
        plain = f"{number:.4f}".rstrip("0").replace("0.", ".") if style == "bare" else style.format(number)
        words.append(str(rng.choice(_NUMBERS)) if rng.random() < 0.2 else plain)
    return "".join(words).encode()


def test_random_texts_come_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng()
    monkeypatch.setattr(numbered_text, "_PIECE", 700)
    texts = [written(rng) for _ in range(150)]
    assert read_back(texts, tmp_path) == texts


def test_every_example_comes_back(programs: Path, tmp_path: Path) -> None:
    files = [path for path in sorted(programs.rglob("*")) if path.is_file()]
    texts = [path.read_bytes().decode("utf-8", "replace").encode() for path in files]
    assert len(texts) > 20
    assert read_back(texts, tmp_path) == texts


def test_a_line_without_end_is_kept_as_it_is(tmp_path: Path) -> None:
    text = b"X1.5 " * 500_000
    assert read_back([text], tmp_path) == [text]


def test_coordinates_take_a_sixth_of_what_deflating_the_text_takes() -> None:
    """A surface in short lines: x even, z of a smooth function to four decimals."""
    x = np.arange(20_000) * 0.3
    z = 2.5 * np.sin(x / 9) + 0.8 * np.sin(x / 3.3)
    text = "".join(f"G1 X{a:.4f} Y7.5000 Z{b:.4f}\n" for a, b in zip(x, z, strict=True)).encode()
    blob = Blob()
    put_text(text, blob)
    assert blob.size < len(zlib.compress(text, 6)) / 6

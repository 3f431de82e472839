"""Inputs of each door of cncgen: seeds, and what changes them."""

from __future__ import annotations

import random
import re
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trials.generators import door_programs, gcode_mutants, stepnc_mutants

ROOT = Path(__file__).resolve().parents[2]
Mutate = Callable[[random.Random, bytes, list[bytes]], bytes]

#: A program that every setpoint file, machine and tool table of the trial goes with.
PROGRAM = "G21 G90 G17 G64 P0.01\nT1 M6 G43 H1\nG1 X1 Y1 F1000\nX2 Y0\nG2 X3 Y0 I0.5 J0\nG0 Z1\nM2\n"

TOOLS = (
    b"T1 P1 D0.5 Z+10.0 ;mill\nT2 P2 D1 X1 Y1 Z1 A1 B1 C1 U1 V1 W1 I10 J-10 Q3\n",
    b"5161\t0.000000\n5220\t1\n5221\t10.5\n5381 1e3\n100 7\n",
)
WORDS = (
    b"1e308", b"-1e300", b"1e-320", b"nan", b"inf", b"-0", b"2147483648", b"99999999999999999999", b"9" * 400, b"9" * 5000, b"0", b"1e9", b"0.001",
    b"1e-15", b",", b"\n", b"\t", b" ", b"=", b"[", b"]", b"{", b"}", b'"', b"#", b"\0", b"\xff", b"\xef\xbb\xbf", b"true", b"[]",
    b"x_mm", b"t_s", b"a_deg", b"Q2147483648", b"LBL 1\n", b"CALL LBL 1 REP 65534\n", b"R1=1EX99\n", b"GOTOB A\n", b"A: ", b"max_jerk_mm_s3",
)  # fmt: skip
NUMBER = re.compile(rb"\d+\.?\d*(?:[eE][-+]?\d+)?")


def change(rng: random.Random, data: bytes, sources: list[bytes]) -> bytes:
    """Change one to four things of a text: a byte, a number, a word, a line, or a part of another source."""
    for _ in range(rng.choice([1, 1, 2, 4])):
        at = rng.randint(0, len(data))
        kind = rng.randrange(7)
        if kind < 2:
            data = numbers(rng, data)
        elif kind == 2:
            data = data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :]
        elif kind == 3:
            data = data[:at] + rng.choice(WORDS) + data[at:]
        elif kind == 4:
            data = data[:at] + data[at + rng.randint(1, 30) :]
        elif kind == 5:
            other = rng.choice(sources)
            begin = rng.randrange(len(other) + 1)
            data = data[:at] + other[begin : begin + rng.randint(1, 200)] + data[at:]
        else:
            lines = data.split(b"\n")
            where = rng.randrange(len(lines))
            lines[where : where + rng.randrange(2)] = [rng.choice(lines)] * rng.choice(
                [0, 0, 1, 1, 2, 2, 3, 20]
            )
            data = b"\n".join(lines)
    return data[:20_000]


def numbers(rng: random.Random, data: bytes) -> bytes:
    """Return a text with a number replaced, or the text where it has none."""
    found = list(NUMBER.finditer(data))
    if not found:
        return data
    match = rng.choice(found)
    return data[: match.start()] + _number(rng) + data[match.end() :]


def _number(rng: random.Random) -> bytes:
    """Return a number: one of the extremes, or any magnitude."""
    if rng.random() < 0.4:
        return rng.choice(WORDS[:14])
    return b"%.9g" % (10.0 ** rng.uniform(-12.0, 12.0) * rng.choice([1, -1]))


def change_binary(rng: random.Random, data: bytes, sources: list[bytes]) -> bytes:
    """Change bytes of a binary file: single ones, whole doubles, its end."""
    out = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 8])):
        at = rng.randrange(max(len(out), 1))
        kind = rng.randrange(5)
        if kind == 0 and out:
            out[at] = rng.randrange(256)
        elif kind == 1:
            extremes = [np.nan, np.inf, 1e300, 5.5e303, 1e-320, -1e9, 0.0]
            out[at & ~7 : (at & ~7) + 8] = np.float64(rng.choice(extremes)).tobytes()
        elif kind == 2:
            del out[at : at + rng.randint(1, 64)]
        elif kind == 3:
            out[at:at] = rng.randbytes(rng.randint(1, 16))
        else:
            out[at : at + 8] = rng.choice([2**63 - 1, 2**31, 0, 2**64 - 1]).to_bytes(8, "little")
    return bytes(out)


def change_gcode(rng: random.Random, data: bytes, sources: list[bytes], dialect: str) -> bytes:
    """Change a program: half of them in ways that its structure outlives, the others, or a few of their lines, anyhow."""
    kind = rng.random()
    if kind < 0.5:
        return door_programs.changed(rng, data, sources, dialect)
    data = few_lines(rng, data)
    return change(rng, data, sources) if kind < 0.7 else gcode_mutants.mutated(rng, data, sources)


def few_lines(rng: random.Random, data: bytes) -> bytes:
    """Return a text, or nearly always one to five lines of it, which take a tenth of the time."""
    if rng.random() < 0.04:
        return data
    lines = data.split(b"\n")
    begin = rng.randrange(len(lines))
    return b"\n".join(lines[begin : begin + rng.randint(1, 5)])


def change_stepnc(rng: random.Random, data: bytes, sources: list[bytes]) -> bytes:
    """Change a STEP-NC file, or mostly its head and some of its statements, whose references lead partly to nothing."""
    if rng.random() < 0.93:
        head, mark, rest = data.partition(b"DATA;")
        statements = rest.split(b";\n")
        begin = rng.randrange(len(statements))
        data = head + mark + b"\n" + b";\n".join(statements[begin : begin + rng.choice([1, 3, 10, 40])])
        data += b";\nENDSEC;\nEND-ISO-10303-21;\n"
    return stepnc_mutants.mutate(data, rng)


@cache
def gcode(dialect: str) -> list[bytes]:
    """Return programs of G-code: those of a dialect, and of others where there is no own way of writing."""
    more = [] if dialect in ("sinumerik", "heidenhain") else gcode_mutants.corpus()
    return door_programs.seeds(dialect) + more


@cache
def stepnc() -> list[bytes]:
    """Return small STEP-NC files."""
    return stepnc_mutants.samples([])[:64]


@cache
def machines() -> list[bytes]:
    """Return the machine files that ship."""
    return [file.read_bytes() for file in sorted((ROOT / "cncgen" / "machine" / "profiles").glob("*.toml"))]


@cache
def setpoints(kind: str) -> list[bytes]:
    """Return 5 and, for one of eight inputs, 200 setpoints in a format."""
    import cncgen

    with tempfile.TemporaryDirectory() as folder:
        found = []
        for rows in (5, 5, 5, 5, 5, 5, 5, 200):
            # At rest, along a sine and back, at rest.
            way = 0.5 - 0.5 * np.cos(np.linspace(0.0, 2.0 * np.pi, rows))
            few = cncgen.Setpoints("XYZ", 1e-3, 0, np.outer(way, [1.0, 1.0, 0.0]))
            file = Path(folder) / f"s{rows}.{kind}"
            cncgen.write(few, file, format=kind)
            found.append(file.read_bytes() if kind != "hdf5" else _small_hdf5(few.axes, few.position, file))
        return found


def _small_hdf5(axes: str, position: NDArray, file: Path) -> bytes:
    """Return setpoints in an HDF5 file of 3 kB: the columns of ours grow in parts, which take half a megabyte."""
    import h5py

    with h5py.File(file, "w") as tables:
        tables.attrs["period_s"] = 1e-3
        tables["t_s"] = 1e-3 * np.arange(len(position))
        for axis, column in zip(axes.lower(), position.T, strict=True):
            tables[f"{axis}_mm"] = column
    return file.read_bytes()


@cache
def logs() -> list[bytes]:
    """Return logs of a first-order axis, noisy, with drive and command."""
    rng = np.random.default_rng(1)
    found = []
    for rows in (12, 12, 12, 20, 20, 20, 400):
        t = np.arange(rows) * 1e-3
        u = np.sign(np.sin(40.0 * t)) + 0.1 * rng.standard_normal(rows)
        x = np.cumsum(u) * 1e-3
        lines = [f"{a:.4f},{b:.6f},{c:.6f},{d:.6f}" for a, b, c, d in zip(t, x, x + 1e-3, u, strict=True)]
        found.append(("t_s,x_mm,x_cmd_mm,x_force\n" + "\n".join(lines) + "\n").encode())
    return found

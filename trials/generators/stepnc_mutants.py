"""Mutants of STEP-NC files."""

import io
import random
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

from cncgen.stepnc import read, write_ap238

ROOT = Path(__file__).parents[2]
TOKENS = (
    b"#1", b"#2", b"#99999", b"$", b"*", b"()", b"(", b")", b",", b";", b"'", b"/*", b"*/", b".T.", b".F.", b"''",
    b"0.", b"-1.", b"1.E300", b"1.E-300", b"1000000000", b"-0.000001", b"\\X2\\D800\\X0\\", b"\xff", b"\n", b"<a>",
    b"#1=A();", b"ENDSEC;", b"DATA;", b"(A()B())", b"NUMERIC_MEASURE(5.)", b".RAPID.", b"\0",
)  # fmt: skip
NUMBER = re.compile(rb"-?\d+\.\d*")
NAME = re.compile(rb"#\d+")


def mutate(data: bytes, chance: random.Random) -> bytes:
    """Return a file with one to four things changed."""
    for _ in range(chance.randint(1, 4)):
        k = chance.randrange(max(len(data), 1))
        kind = chance.randrange(9)
        if kind == 0:
            data = data[:k] + bytes([chance.randrange(256)]) + data[k + 1 :]
        elif kind == 1:
            data = data[:k] + data[k + chance.randint(1, 30) :]
        elif kind == 2:
            data = data[:k] + chance.choice(TOKENS) + data[k:]
        elif kind == 3:
            j = chance.randrange(max(len(data), 1))
            data = data[:k] + data[j : j + chance.randint(1, 200)] + data[k:]
        elif kind in (4, 5):
            data = _replaced(data, NUMBER, chance, lambda: _number(chance))
        elif kind in (6, 7):
            names: list[bytes] = NAME.findall(data) or [b"#1"]
            data = _replaced(data, NAME, chance, partial(chance.choice, names))
        else:
            data = data[: k if chance.random() < 0.1 else len(data)]
    return data


def _number(chance: random.Random) -> bytes:
    value = chance.choice((0.0, 1.0, -1.0, 1e-9, 1e9, 1e308, 0.5, 360.0, chance.uniform(-100, 100)))
    return b"%.9E" % value if chance.random() < 0.3 else b"%.6f" % max(min(value, 1e12), -1e12)


def _replaced(
    data: bytes, pattern: re.Pattern[bytes], chance: random.Random, make: Callable[[], bytes]
) -> bytes:
    found = list(pattern.finditer(data))
    if not found:
        return data
    match = chance.choice(found)
    return data[: match.start()] + make() + data[match.end() :]


def samples(files: list[str]) -> list[bytes]:
    """Return the files to mutate: quick ones many times."""
    if files:
        return [Path(f).read_bytes() for f in files]
    nist = (ROOT / "programs" / "stepnc" / "nist_ex1.stp").read_bytes()
    features = (ROOT / "programs" / "stepnc" / "features.stp").read_bytes()
    plate = (ROOT / "programs" / "stepnc" / "plate_ap238.stp").read_bytes()
    explicit = (ROOT / "programs" / "stepnc" / "nist_ex1E.stp").read_bytes()
    program = read(nist, "x")
    stream = io.StringIO()
    chunk = next(iter(program.chunks()))
    write_ap238([chunk], stream)
    # The first statements of the large ones: their references lead partly to nothing, which is a mutation too.
    aim = stream.getvalue()
    small_aim = aim[: aim.index("\n", 12_000)] + aim[aim.index("\n#", len(aim) - 3000) :]
    head = explicit[explicit.index(b"ISO-10303") :]
    small = head[: head.index(b"#1101=")] + b"ENDSEC;\nEND-ISO-10303-21;\n"
    parts = _parts(plate)
    # About as often as they are quick: a file with pockets to clear takes ten times as long as one with a hole.
    quick = [small, *[small_aim.encode()] * 3, *[part for part in parts if _cutting_rows(part) < 60]]
    return quick * 30 + parts * 2 + [nist, nist, features, plate, explicit, aim.encode()]


def _cutting_rows(data: bytes) -> int:
    """Return how many motions a file makes."""
    return sum(len(chunk) for chunk in read(data, "x").chunks())


def _parts(plate: bytes) -> list[bytes]:
    """Return files that have one of the workingsteps of the plate each: the others are taken out of its plan."""
    links = [m[0] for m in re.finditer(rb"#\d+=MACHINING_PROCESS_SEQUENCE_RELATIONSHIP[^;]*;", plate)]
    out = []
    for kept in links:
        data = plate
        for link in links:
            data = data if link == kept else data.replace(link, b"")
        out.append(data)
    return out

"""Mutate STEP-NC files and read, check and execute each: no exception, no hang, no unbounded memory.

    python -m trials.stepnc_fuzz [--count 100000] [--seed 1] [--seconds 20] [FILE...]

Without files: NIST's two and small ones of our own. Says every file that failed (kept in the folder --keep).
"""

import argparse
import io
import random
import re
import resource
import signal
import sys
import time
import traceback
import warnings
from pathlib import Path

from cncgen.diagnostics import CncgenError
from cncgen.stepnc import read, tree, write_ap238
from cncgen.toolpath.reading import ReadOptions

ROOT = Path(__file__).parents[1]
TOKENS = (
    b"#1", b"#2", b"#99999", b"$", b"*", b"()", b"(", b")", b",", b";", b"'", b"/*", b"*/", b".T.", b".F.", b"''",
    b"0.", b"-1.", b"1.E300", b"1.E-300", b"1000000000", b"-0.000001", b"\\X2\\D800\\X0\\", b"\xff", b"\n", b"<a>",
    b"#1=A();", b"ENDSEC;", b"DATA;", b"(A()B())", b"NUMERIC_MEASURE(5.)", b".RAPID.", b"\0",
)  # fmt: skip
#: Files between two lines that say how far it is.
PROGRESS = 5000
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
            names = NAME.findall(data) or [b"#1"]
            data = _replaced(data, NAME, chance, lambda names=names: chance.choice(names))
        else:
            data = data[: k if chance.random() < 0.1 else len(data)]
    return data


def _number(chance: random.Random) -> bytes:
    value = chance.choice((0.0, 1.0, -1.0, 1e-9, 1e9, 1e308, 0.5, 360.0, chance.uniform(-100, 100)))
    return b"%.9E" % value if chance.random() < 0.3 else b"%.6f" % max(min(value, 1e12), -1e12)


def _replaced(data: bytes, pattern: re.Pattern, chance: random.Random, make) -> bytes:
    found = list(pattern.finditer(data))
    if not found:
        return data
    match = chance.choice(found)
    return data[: match.start()] + make() + data[match.end() :]


def run(data: bytes) -> None:
    """Read, execute, write and list one file; faults of the file are diagnostics."""
    program = read(data, "fuzz.stp", ReadOptions(chunk_rows=4096, max_steps=20_000))
    chunks = list(program.chunks())
    if not program.diagnostics.has_errors:
        write_ap238(chunks, io.StringIO())
    if len(data) < 20_000:
        for _ in tree(data, "fuzz.stp", ReadOptions(max_steps=2_000)):
            pass


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
    # The first statements of the large ones: what they refer to is partly gone, which is a mutation too.
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


def main() -> int:
    """Run the mutations; return 1 where one failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*")
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=int, default=20, help="of CPU per file, before it counts as a hang")
    parser.add_argument("--memory-gb", type=float, default=2.0)
    parser.add_argument("--keep", default="")
    options = parser.parse_args()
    limit = int(options.memory_gb * 2**30)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    warnings.simplefilter("ignore")
    signal.signal(signal.SIGPROF, _hang)
    if options.keep:
        Path(options.keep).mkdir(parents=True, exist_ok=True)
    sources = samples(options.files)
    chance, failed, begin, slowest = random.Random(options.seed), 0, time.time(), 0.0
    for k in range(options.count):
        data = mutate(chance.choice(sources), chance)
        signal.setitimer(signal.ITIMER_PROF, options.seconds)
        now = time.time()
        try:
            run(data)
        except CncgenError:
            pass
        except BaseException as error:
            if isinstance(error, KeyboardInterrupt):
                raise
            failed += 1
            place = traceback.extract_tb(error.__traceback__)[-1]
            print(
                f"{k}: {type(error).__name__}: {error} at {Path(place.filename).name}:{place.lineno}",
                flush=True,
            )
            if options.keep:
                Path(options.keep, f"{k}.stp").write_bytes(data)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
        slowest = max(slowest, time.time() - now)
        if (k + 1) % PROGRESS == 0:
            print(f"{k + 1} files, {failed} failed, {time.process_time():.0f} s of CPU", flush=True)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{options.count} files, {failed} failed, {time.time() - begin:.0f} s, slowest {slowest:.2f} s, {peak:.0f} MB"
    )
    return 1 if failed else 0


def _hang(number: int, frame: object) -> None:
    raise TimeoutError("hang")


if __name__ == "__main__":
    sys.exit(main())

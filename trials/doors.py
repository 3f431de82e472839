"""Fuzzing of every door of cncgen: what reads a file or an option from outside, each against a clock and a bound of memory.

    python -m trials.doors [--door NAME ...] [--seconds 60] [--seed N] [--keep DIR] [--guided]
    python -m trials.doors --replay DIR

An input is bytes. A door may say anything about it, but not fail with an exception that is none of the project's, take more than
`SECONDS` of processor time or `MEMORY`, or have a library warn or print. Inputs run in forked batches, so that whatever ends a
process (a signal, the bound of its time) is found too, with the input; batches grow until one takes `BATCH_SECONDS`. Without ``--seed`` a fresh one is drawn and printed.
``--guided`` hands one door to atheris (libFuzzer), which keeps inputs that reach new code.

Findings are cut to a smaller input of the same kind and kept as files, a folder a door; tests replay those of ``tests/doors``.
"""

from __future__ import annotations

import argparse
import importlib
import io
import mmap
import os
import random
import resource
import secrets
import signal
import sys
import tempfile
import time
import traceback
import warnings
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

from cncgen.diagnostics import CncgenError, Diagnostics, RemarkWarning
from cncgen.toolpath.reading import ReadOptions
from trials.generators import door_inputs as inputs

#: Bounds of one input: seconds of processor time, and bytes beside what the process has already.
SECONDS = 10.0
MEMORY = 2**30
#: Inputs of the first forked process of a door, and at most of each; a process is forked and warms up in the time of hundreds.
BATCH, LARGEST_BATCH = 25, 10_000
#: Time that the inputs of one process take, s.
BATCH_SECONDS = 5.0
#: Modules that inputs need, imported once, before processes are forked.
MODULES = (
    "cncgen.pipeline", "cncgen.planner.least_time.strategy", "cncgen.planner.smoothing.stream", "cncgen.gcode", "cncgen.stepnc",
    "cncgen.verify", "cncgen.machine.shipped", "cncgen.report.identified", "cncgen.cli.app", "cncgen.setpoints.readers",
    "cncgen.gcode.klartext.running", "cncgen.gcode.sinumerik.running", "cncgen.stepnc.iso14649", "cncgen.stepnc.ap238",
)  # fmt: skip
#: Blocks that a program may execute in the doors of G-code: loops end soon, so that there are many inputs a second.
MAX_STEPS = 5_000
#: Setpoints that a plan of a trial may have.
MAX_ROWS = 20_000

Try = Callable[[bytes], None]


@dataclass(frozen=True, slots=True)
class Door:
    """A way in: its seeds, what changes one, and what is done with an input."""

    seeds: Callable[[], list[bytes]]
    change: inputs.Mutate
    run: Try


@dataclass(slots=True)
class Finding:
    """What an input did: a kind that does not depend on the input, all that was said, and the input."""

    door: str
    kind: str
    said: str
    data: bytes


@dataclass(slots=True)
class Outcome:
    """The counts of a run, and the findings, one of each kind."""

    counts: dict[str, int] = field(default_factory=dict)
    findings: dict[tuple[str, str], Finding] = field(default_factory=dict)


def run_gcode(data: bytes, dialect: str) -> None:
    """Read an input to its toolpath, check it, print its calls."""
    from cncgen.gcode import canon, check, read

    options = ReadOptions(dialect=dialect, max_steps=MAX_STEPS, chunk_rows=4096)
    program = read(io.BytesIO(data), "fuzz.ngc", options)
    for _ in program.chunks():
        pass
    checked = Diagnostics()
    check(io.BytesIO(data), "fuzz.ngc", options, checked)
    if _errors(program.diagnostics) != _errors(checked):
        raise AssertionError("a check says something else than reading")
    for _ in canon(io.BytesIO(data), "fuzz.ngc", options, program.diagnostics):
        pass


def _errors(found: Diagnostics) -> list[str]:
    """Return the errors as text; reading tells more warnings than a check, of feeds along motions."""
    return [diagnostic.render() for diagnostic in found if diagnostic.severity == "error"]


def run_stepnc(data: bytes) -> None:
    """Read, execute, write and list a file."""
    from cncgen.stepnc import read, tree, write_ap238

    program = read(data, "fuzz.stp", ReadOptions(chunk_rows=4096, max_steps=20_000))
    chunks = list(program.chunks())
    if not program.diagnostics.has_errors:
        write_ap238(chunks, io.StringIO())
    if len(data) < 20_000:
        for _ in tree(data, "fuzz.stp", ReadOptions(max_steps=2_000)):
            pass


def run_plan(data: bytes) -> None:
    """Plan a program on a machine that its bytes choose, draw some of its setpoints."""
    import cncgen

    machine = ("xy-table", "generic-mill", "dyna-1007")[zlib.crc32(data) % 3]
    program = cncgen.read_text(data, "fuzz.ngc", options=ReadOptions(max_steps=MAX_STEPS))
    _draw(cncgen.sample(cncgen.plan(program, machine)))


def _draw(setpoints: Any) -> None:
    rows = 0
    for chunk in setpoints:
        rows += len(chunk)
        if rows > MAX_ROWS:
            return


def run_machine(data: bytes) -> None:
    """Read a machine file, plan a program on it, simulate its axes."""
    import cncgen

    with _file(data, "m.toml") as file:
        machine = cncgen.load_machine(file)
    _draw(cncgen.sample(cncgen.plan(cncgen.read_text(inputs.PROGRAM, "p.nc"), machine)))


def run_setpoints(data: bytes, kind: str) -> None:
    """Read a file of setpoints, judge it."""
    import cncgen

    with _file(data, f"s.{kind}") as file:
        points = cncgen.read_setpoints(
            file, format=kind, axes="XYZ" if kind in ("f64", "npy", "hal") else None
        )
    cncgen.judge(points, cncgen.read_text(inputs.PROGRAM, "p.nc"), "generic-mill")


def run_log(data: bytes) -> None:
    """Identify an axis by a log, with each model."""
    from cncgen.report.identified import identified

    with _file(data, "log.csv") as file:
        for model in ("velocity-loop", "first-order", "fourth-order", "etfe"):
            try:
                identified(file, model, None)
            except CncgenError:
                continue


def run_tools(data: bytes) -> None:
    """Read a tool table and a parameter file, run a program with them."""
    from cncgen.gcode import read

    with _file(data, "t.tbl") as file:
        for options in (ReadOptions(tool_table=Path(file)), ReadOptions(parameters=Path(file))):
            try:
                for _ in read(io.BytesIO(inputs.PROGRAM.encode()), "p.nc", options).chunks():
                    pass
            except CncgenError:
                continue


def run_options(data: bytes) -> None:
    """Give a command the words of the input, separated by NUL bytes, in a folder with a program."""
    from cncgen.cli import app

    words = [word.decode("utf-8", "replace") for word in data.split(b"\0")]
    here = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "p.nc").write_text("G21 G64 P0.01\nG1 X1 Y1 F1000\nX0\nM2\n")
        os.chdir(folder)
        quiet = io.TextIOWrapper(io.BytesIO())
        out, err, sys.stdout, sys.stderr = sys.stdout, sys.stderr, quiet, quiet
        try:
            code = app.run(words)
        finally:
            sys.stdout, sys.stderr = out, err
            os.chdir(here)
        quiet.flush()
        said = quiet.buffer.getvalue() if hasattr(quiet.buffer, "getvalue") else b""
        if code not in (0, 1, 2, 3):
            raise AssertionError(f"exit {code}: {said[-300:].decode('utf-8', 'replace')}")


def _file(data: bytes, name: str) -> Any:
    """Return a context that gives the name of a file of these bytes."""
    return _Temporary(data, name)


class _Temporary:
    """A file of some bytes in a folder of its own."""

    def __init__(self, data: bytes, name: str) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self._path = Path(self._folder.name, name)
        self._path.write_bytes(data)

    def __enter__(self) -> str:
        return str(self._path)

    def __exit__(self, *_: object) -> None:
        self._folder.cleanup()


FORMATS = ("csv", "jsonl", "npy", "npz", "f64", "hal", "arrow", "parquet", "mat", "hdf5", "mcap", "mf4")
_TEXT_FORMATS = ("csv", "jsonl", "hal")
_OPTIONS = [
    b"\0".join(words)
    for words in (
        (b"plan", b"p.nc", b"-m", b"xy-table", b"-o", b"o.csv", b"--path-tolerance", b"0.01"),
        (b"check", b"p.nc", b"--max-steps", b"10", b"--max-memory", b"512"),
        (b"canon", b"p.nc", b"--dialect", b"fanuc"),
        (b"convert", b"p.nc", b"-o", b"o.nc", b"--linearize", b"0.01"),
        (b"verify", b"p.nc", b"--program", b"p.nc", b"--machine", b"xy-table", b"--period", b"0.001"),
        (b"simulate", b"p.nc", b"--axis-params", b"xy-table", b"-o", b"r.csv"),
        (b"machines", b"show", b"xy-table"),
    )
]


def doors() -> dict[str, Door]:
    """Return the doors by name."""
    found = {
        name: Door(inputs.gcode, inputs.change_gcode, partial(run_gcode, dialect=name))
        for name in ("linuxcnc", "fanuc", "fanuc-lathe", "auto")
    }
    for name, texts in (("sinumerik", inputs.SINUMERIK), ("heidenhain", inputs.HEIDENHAIN)):
        seeds: Callable[[], list[bytes]] = partial(list, [text.encode() for text in texts])
        found[name] = Door(seeds, inputs.change, partial(run_gcode, dialect=name))
    found["plan"] = Door(lambda: [inputs.PROGRAM.encode()], inputs.change_gcode, run_plan)
    found["stepnc"] = Door(inputs.stepnc, inputs.change_stepnc, run_stepnc)
    found["machine"] = Door(inputs.machines, inputs.change, run_machine)
    for kind in FORMATS:
        change = inputs.change if kind in _TEXT_FORMATS else inputs.change_binary
        found[f"setpoints-{kind}"] = Door(
            partial(inputs.setpoints, kind), change, partial(run_setpoints, kind=kind)
        )
    found["log"] = Door(inputs.logs, inputs.change, run_log)
    found["tools"] = Door(lambda: list(inputs.TOOLS), inputs.change, run_tools)
    found["options"] = Door(lambda: _OPTIONS, inputs.change, run_options)
    return found


def fault_of(door: Door, data: bytes) -> tuple[str, str] | None:
    """Run an input; return what kind of fault it shows and all that is known of it, or None."""
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", RemarkWarning)
            door.run(data)
    except CncgenError:
        pass
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        frames = [f for f in traceback.extract_tb(error.__traceback__) if "/cncgen/" in f.filename]
        place = f"{Path(frames[-1].filename).name}:{frames[-1].name}" if frames else "doors"
        return f"{type(error).__name__} in {place}", traceback.format_exc(limit=-6)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return None


def _hang(number: int, frame: object) -> None:
    raise TimeoutError(f"more than {SECONDS:g} s")


def bound_process() -> None:
    """Bound time and memory of this process."""
    with open("/proc/self/status") as status:
        taken = next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmData:"))
    resource.setrlimit(resource.RLIMIT_DATA, (taken + MEMORY, resource.RLIM_INFINITY))
    signal.signal(signal.SIGPROF, _hang)


def batch(name: str, door: Door, data: list[bytes]) -> tuple[int, list[Finding]]:
    """Run inputs in a child; return how many ran, and what they showed."""
    shared = mmap.mmap(-1, 8)
    with tempfile.TemporaryFile() as found, tempfile.TemporaryFile() as errors:
        child = os.fork()
        if child == 0:
            _child(door, data, shared, found.fileno(), errors.fileno())
        _, status = os.waitpid(child, 0)
        ran = int.from_bytes(shared[:8], "little")
        found.seek(0)
        entries = [
            entry.split("\x1f", 2) for entry in found.read().decode("utf-8", "replace").split("\x1e") if entry
        ]
        findings = [Finding(name, kind, said, data[int(index)]) for index, kind, said in entries]
        if status != 0:
            signalled = os.WIFSIGNALED(status)
            how = f"signal {os.WTERMSIG(status)}" if signalled else f"exit {os.WEXITSTATUS(status)}"
            errors.seek(0)
            said = errors.read()[-2000:].decode("utf-8", "replace")
            findings.append(Finding(name, f"the process ends: {how}", said, data[min(ran, len(data) - 1)]))
            ran += 1
    return ran, findings


def _child(door: Door, data: list[bytes], shared: mmap.mmap, found: int, errors: int) -> None:
    """Run inputs one after another, tell of each that it begins, and end the process."""
    os.dup2(errors, 2)
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    done = 0
    for index, each in enumerate(data):
        if index % BATCH == 0:  # what is cached grows from input to input, and is not one's own
            bound_process()
        shared[:8] = index.to_bytes(8, "little")
        resource.setrlimit(
            resource.RLIMIT_CPU, (int(time.process_time() + 2 * SECONDS) + 2, resource.RLIM_INFINITY)
        )
        fault = fault_of(door, each)
        printed = os.lseek(errors, 0, os.SEEK_CUR)
        if fault is None and printed > done:
            said = os.pread(errors, 2000, done).decode("utf-8", "replace")
            fault = f"a library prints: {said[:40]!r}", said
        done = printed
        if fault is not None:
            os.write(found, f"{index}\x1f{fault[0]}\x1f{fault[1]}\x1e".encode())
        shared[:8] = (index + 1).to_bytes(8, "little")
    os._exit(0)


def mutants(door: Door, seed: int) -> Iterator[bytes]:
    """Yield changed inputs for ever; the same seed gives the same ones."""
    rng, seeds = random.Random(seed), door.seeds()
    while True:
        yield door.change(rng, rng.choice(seeds), seeds)


def smaller(name: str, door: Door, finding: Finding, tries: int = 60) -> Finding:
    """Return a finding of the same kind with less input: lines, then stretches of bytes are left out while it stays."""
    best, size = finding.data, max(len(finding.data) // 2, 1)
    while size and tries:
        for begin in range(0, len(best), size):
            shorter = best[:begin] + best[begin + size :]
            tries -= 1
            if tries <= 0:
                break
            _, found = batch(name, door, [shorter])
            if any(each.kind == finding.kind for each in found):
                best = shorter
                break
        else:
            size //= 2
    return Finding(name, finding.kind, finding.said, best)


def run(names: list[str], seed: int, seconds: float) -> Outcome:
    """Try mutants of each door in turn for so many seconds in all."""
    known, outcome = doors(), Outcome()
    for module in MODULES:
        importlib.import_module(module)
    streams = {name: mutants(known[name], seed) for name in names}
    sizes = dict.fromkeys(names, BATCH)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for name in names:
            begin = time.monotonic()
            if begin > end:
                break
            data = list(islice(streams[name], sizes[name]))
            while data:
                ran, found = batch(name, known[name], data)
                outcome.counts[name] = outcome.counts.get(name, 0) + ran
                data = data[ran:]
                for each in found:
                    outcome.findings.setdefault((name, each.kind), each)
            faster = min(BATCH_SECONDS / (time.monotonic() - begin), 4.0)
            sizes[name] = min(max(int(sizes[name] * faster), 1), LARGEST_BATCH)
    return outcome


def guided(name: str, arguments: list[str]) -> None:
    """Hand a door to atheris, which keeps inputs that reach new code; `arguments` are libFuzzer's."""
    import atheris  # type: ignore[import-untyped, unused-ignore]

    door = doors()[name]
    seeds = door.seeds()
    atheris.instrument_all()

    def mutator(data: bytes, most: int, seed: int) -> bytes:
        return door.change(random.Random(seed), data, seeds)[:most]

    def one(data: bytes) -> None:
        fault = fault_of(door, data)
        if fault is not None:
            raise AssertionError(fault[1])

    signal.signal(signal.SIGPROF, _hang)
    atheris.Setup([sys.argv[0], *arguments], one, custom_mutator=mutator)
    atheris.Fuzz()


def replay(folder: Path) -> list[Finding]:
    """Run the kept inputs: a folder a door."""
    known, found = doors(), list[Finding]()
    for place in sorted(path for path in folder.iterdir() if path.is_dir()):
        data = [file.read_bytes() for file in sorted(place.iterdir())]
        while data:
            ran, findings = batch(place.name, known[place.name], data)
            found += findings
            data = data[ran:]
    return found


def main() -> int:
    """Fuzz, print counts and findings, keep these."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--door", action="append", choices=list(doors()))
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--keep", type=Path, help="folder for inputs that show a fault")
    parser.add_argument("--replay", type=Path)
    parser.add_argument(
        "--guided", action="store_true", help="one door by atheris; further words are libFuzzer's"
    )
    arguments, further = parser.parse_known_args()
    names = arguments.door or list(doors())
    if arguments.guided:
        guided(names[0], further)
        return 0
    if arguments.replay:
        findings = replay(arguments.replay)
    else:
        seed = secrets.randbelow(2**31) if arguments.seed is None else arguments.seed
        print(f"seed {seed}", flush=True)
        outcome = run(names, seed, arguments.seconds)
        for name, count in outcome.counts.items():
            print(f"{count:8d} {name}")
        print(f"{sum(outcome.counts.values()):8d} inputs, {len(outcome.findings)} kinds of fault")
        findings = [smaller(each.door, doors()[each.door], each) for each in outcome.findings.values()]
    for each in findings:
        print(f"--- {each.door}: {each.kind}\n{each.said}\n{each.data[:400]!r}", flush=True)
        if arguments.keep:
            folder = arguments.keep / each.door
            folder.mkdir(parents=True, exist_ok=True)
            (folder / f"{zlib.crc32(each.kind.encode()):08x}").write_bytes(each.data)
    return 1 if findings else 0


if __name__ == "__main__":
    raise SystemExit(main())

"""Fuzzing of every door of cncgen: what reads a file or an option from outside, each against a clock and a bound of memory.

    python -m trials.doors [--door NAME ...] [--seconds 60] [--seed N] [--keep DIR] [--tally FILE] [--corpus DIR] [--guided]
    python -m trials.doors --replay DIR
    python -m trials.doors --open tests/doors_open    # known kinds fail nothing, as in `make fuzz`
    python -m trials.doors --tell                     # no kind fails anything, as in `.ci/run`

An input is bytes. A door may say anything about it, but not fail with an exception that is none of the project's, take more than
`SECONDS` of processor time or `MEMORY`, or have a library warn or print. Inputs run in forked batches, so that whatever ends a
process (a signal, the bound of its time) is found too, with the input; batches grow until one takes `BATCH_SECONDS`. Without ``--seed`` a fresh one is drawn and printed.
``--guided`` hands one door to atheris (libFuzzer), which keeps inputs that reach new code.

Findings are cut to a smaller input of the same kind and kept as files, a folder a door; tests replay those of ``tests/doors``, and try
the first inputs of one seed at each door.
"""

from __future__ import annotations

import argparse
import contextlib
import faulthandler
import importlib
import io
import json
import mmap
import os
import random
import re
import resource
import secrets
import select
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import islice
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any
from unittest.mock import patch

from cncgen.diagnostics import CncgenError, Diagnostics, RemarkWarning
from cncgen.machine.kinematics import Kinematics
from cncgen.setpoints.readers import isolated
from cncgen.toolpath.reading import ReadOptions
from trials.generators import door_commands, door_options, door_surroundings, extreme_programs
from trials.generators import door_inputs as inputs

#: Bounds of one input: seconds of processor time on a machine that plans `PACE` in so many of them (a slower one has more), and bytes
#: beside what the process has already.
SECONDS = 10.0
PACE, PACE_SECONDS = Path(__file__).parents[1] / "programs" / "butterfly.nc", 0.045
MEMORY = 2**30
#: Inputs of the first forked process of a door, and at most of each; a process is forked and warms up in the time of hundreds.
BATCH, LARGEST_BATCH = 25, 10_000
#: Processor time that the inputs of one process take, s.
BATCH_SECONDS = 5.0
#: Time by the clock of one input: threads that wait for one another take no processor time, which the other bounds count.
CLOCK_SECONDS = 150.0
#: Modules that inputs need, imported once, before processes are forked.
MODULES = (
    "cncgen.pipeline", "cncgen.planner.least_time.strategy", "cncgen.planner.smoothing.stream", "cncgen.gcode", "cncgen.stepnc",
    "cncgen.verify", "cncgen.machine.shipped", "cncgen.report.identified", "cncgen.cli.app", "cncgen.setpoints.readers",
    "cncgen.gcode.klartext.running", "cncgen.gcode.sinumerik.running", "cncgen.stepnc.iso14649", "cncgen.stepnc.ap238",
)  # fmt: skip
#: Blocks that a program may execute in the doors of G-code, and units of work that it may do: few, and for one of sixteen many.
#: Loops end soon then, and there are three times as many inputs a second.
MAX_STEPS, MANY_STEPS = 500, 5_000
MOST_WORK, MUCH_WORK = 10_000, 100_000
#: Longest input that guided runs begin with, bytes.
GUIDED_BYTES = 3_000
#: Setpoints that a plan of a trial may have.
MAX_ROWS = 20_000

if TYPE_CHECKING:
    import cncgen

Try = Callable[[bytes], None]


@dataclass(frozen=True, slots=True)
class Door:
    """A way in: its seeds, what changes one, what is done with an input, and how many inputs of one seed tests try."""

    seeds: Callable[[], list[bytes]]
    change: inputs.Mutate
    run: Try
    tested: int = 1000


@dataclass(slots=True)
class Finding:
    """What an input did: a kind that does not depend on the input, all that was said, and the input."""

    door: str
    kind: str
    said: str
    data: bytes


def run_gcode(data: bytes, dialect: str) -> None:
    """Read an input to its toolpath, with options that its bytes choose; check one of four beside, and print the calls of another one."""
    from cncgen.gcode import budget

    chosen = zlib.crc32(data)
    long = chosen // 1048576 % 16 == 0
    options = ReadOptions(
        dialect=dialect,
        max_steps=MANY_STEPS if long else MAX_STEPS,
        chunk_rows=4096,
        tool_table=_tools() if chosen % 5 else None,
        kinematics=_KINEMATICS[chosen // 8 % 4],
        least_increment=0.001 if chosen // 32 % 16 == 0 else None,
        units="inch" if chosen // 512 % 8 == 0 else "auto",
        tool_tips=chosen // 4096 % 8 == 0,
        block_delete=chosen // 32768 % 8 != 0,
    )
    # One of 64 may work as long as a user's program.
    most = budget.MOST_WORK if chosen // 262144 % 64 == 0 else MUCH_WORK if long else MOST_WORK
    with patch.object(budget, "MOST_WORK", most):
        _read_gcode(data, options, chosen % 4)


#: No machine, and rotary axes in the table, in the head, and one in each.
_KINEMATICS = (
    None,
    Kinematics(0, (3, 5), (0.0, 0.0, -100.0)),
    Kinematics(2, (5, 4), pivot=100.0),
    Kinematics(1, (4, 5), (0.0, 0.0, -100.0), pivot=100.0),
)


def _tools() -> Path:
    """Return a tool table beside the files of this process."""
    file = Path(tempfile.gettempdir(), "tools.tbl")
    if not file.exists():
        file.write_text(
            "".join(f"T{n} P{n} D{8 / n:g} Z{10 * n} X{n - 1} Q{n % 9} I15 J45\n" for n in range(1, 13))
        )
    return file


def _read_gcode(data: bytes, options: ReadOptions, beside: int) -> None:
    """Read an input, and check it or print its calls."""
    from cncgen.gcode import canon, check, read
    from cncgen.toolpath.gate import beyond_numbers

    program = read(io.BytesIO(data), "fuzz.ngc", options)
    for chunk in program.chunks():
        if not program.diagnostics.has_errors:
            program.diagnostics.extend(beyond_numbers(chunk))
    if beside == 0 and not options.tool_tips:  # a check is not one of tips
        checked = Diagnostics()
        check(io.BytesIO(data), "fuzz.ngc", options, checked)
        both = [_errors(program.diagnostics), _errors(checked)]
        # Rows cost more than counts: a run may have an end to its budget where its check has none.
        if both[0] != both[1] and not any("[too-many-steps]" in text for text in both[0] + both[1]):
            raise AssertionError("a check says something else than reading")
    elif beside == 1:
        for _ in canon(io.BytesIO(data), "fuzz.ngc", options, Diagnostics()):
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

    chosen = zlib.crc32(data)
    program = cncgen.read_text(data, "fuzz.ngc", options=ReadOptions(max_steps=MAX_STEPS))
    machine = _machine(("xy-table", "generic-mill", "dyna-1007")[chosen % 3])
    _draw(cncgen.sample(cncgen.plan(program, machine, effort=("best", "fast")[chosen % 2])))


@cache
def _machine(name: str) -> cncgen.Machine:
    import cncgen

    return cncgen.load_machine(name)


def _draw(setpoints: Any) -> None:
    rows = 0
    for chunk in setpoints:
        rows += len(chunk)
        if rows > MAX_ROWS:
            return


def run_machine(data: bytes) -> None:
    """Read a machine file, plan a program on it, simulate its axes."""
    import cncgen

    machine = cncgen.load_machine(_file(data, "m.toml"))
    _draw(cncgen.sample(cncgen.plan(cncgen.read_text(inputs.PROGRAM, "p.nc"), machine)))


def run_setpoints(data: bytes, kind: str) -> None:
    """Read a file of setpoints, judge it."""
    import cncgen

    with patch.object(isolated, "started", forked):
        file = _file(data, f"s.{kind}")
        points = cncgen.read_setpoints(
            file, format=kind, axes="XYZ" if kind in ("f64", "npy", "hal") else None
        )
        if zlib.crc32(data) % 12 == 0:
            cncgen.judge(points, cncgen.read_text(inputs.PROGRAM, "p.nc"), _machine("generic-mill"))


@contextlib.contextmanager
def forked(kind: str, handle: int) -> Iterator[tuple[IO[bytes], IO[bytes]]]:
    """Do as `isolated.started`, by a process that reads one file after another: one that starts takes as long as fifty inputs."""
    if not _readers:
        _readers.append(_Reader())
    reader = _readers[0]
    reader.ask.write(f"{kind} {handle}\n".encode())
    reader.ask.flush()
    try:
        yield reader.ask, reader.told
    finally:
        if not reader.idle():
            reader.end()
            _readers.clear()


class _Reader:
    """A process that reads files of setpoints which this one has open."""

    MARK = b"\0end\n"

    def __init__(self) -> None:
        (asked_by, asks), (tells, out) = os.pipe(), os.pipe()
        parent = os.getpid()
        self.child = os.fork()
        if self.child == 0:
            os.close(asks)
            os.close(tells)
            with contextlib.suppress(BaseException), open(asked_by, "rb") as ask, open(out, "wb") as told:
                os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
                faulthandler.disable()  # libraries that crash here are expected to
                for line in iter(ask.readline, b""):
                    kind, _, handle = line.decode().strip().partition(" ")
                    if handle:
                        isolated.serve(kind, f"/proc/{parent}/fd/{handle}", ask, told)
                        told.write(self.MARK)
                        told.flush()
            os._exit(0)
        os.close(asked_by)
        os.close(out)
        self.ask, self.told = os.fdopen(asks, "wb"), os.fdopen(tells, "rb")

    def idle(self) -> bool:
        """Let the process end what it does; tell whether it is there for another file."""
        with contextlib.suppress(BrokenPipeError):
            self.ask.write(b"[]\n")  # no columns are wanted, if it waits for their names
            self.ask.flush()
            for _ in range(1000):
                line = self.told.readline(100_000)
                if line.endswith(self.MARK) or not line:
                    return bool(line)
        return False

    def end(self) -> None:
        """End the process."""
        os.kill(self.child, signal.SIGKILL)
        os.waitpid(self.child, 0)
        for pipe in (self.ask, self.told):
            with contextlib.suppress(BrokenPipeError):
                pipe.close()


_readers: list[_Reader] = []


def run_log(data: bytes) -> None:
    """Identify an axis by a log, with a model that its bytes choose."""
    from cncgen.report.identified import identified

    models = ("velocity-loop", "first-order", "fourth-order", "etfe")
    found = identified(_file(data, "log.csv"), models[zlib.crc32(data) % 4], None)
    if re.search(r"= -?(nan|inf)", found.table):
        raise AssertionError(f"a result is not finite: {found.table[:200]}")


def run_tools(data: bytes) -> None:
    """Read a tool table or a parameter file, run a program with it."""
    from cncgen.gcode import read

    file = Path(_file(data, "t.tbl"))
    options = ReadOptions(dialect="linuxcnc", chunk_rows=64)
    options = replace(options, tool_table=file) if zlib.crc32(data) % 2 else replace(options, parameters=file)
    for _ in read(io.BytesIO(inputs.PROGRAM.encode()), "p.nc", options).chunks():
        pass


def run_options(data: bytes) -> None:
    """Give a command the words of the input, separated by NUL bytes, in a folder with files; where it is refused, it writes nothing."""
    words = [word.decode("utf-8", "surrogateescape") for word in data.split(b"\0")]
    given = door_options.files()
    with _folder(given), patch("webbrowser.open", lambda url: False):
        code, said = _command(words)
        if code in (2, 3) and (left := set(os.listdir()) ^ set(given)):
            raise AssertionError(f"exit {code} and files are there or gone: {said} {left}")


def run_extremes(data: bytes) -> None:
    """Plan a case of `extreme_programs`; what is written with exit 0 passes `verify`."""
    words, machine, program = [*data.split(extreme_programs.MARK), b"", b""][:3]
    with _folder({"p.nc": program, "m.toml": machine}):
        options = words.decode("utf-8", "replace").split("\n")
        code, _ = _command(["plan", "p.nc", "-m", "m.toml", "-o", "o", *filter(None, options)])
        if code != 0:
            return
        named = dict(zip(options[::2], options[1::2], strict=False))
        tolerance = ["--path-tolerance", named["--path-tolerance"]] if "--path-tolerance" in named else []
        judging = ["verify", "o", "--program", "p.nc", "--machine", "m.toml", *tolerance]
        signal.setitimer(signal.ITIMER_PROF, most_seconds())  # each command has its own
        code, said = _command([*judging, "--format", named.get("--format", "csv")])
        if code != 0:
            raise AssertionError(f"verify ends with {code}: {said}")


def run_commands(data: bytes) -> None:
    """Run a case of `door_commands`; where it is refused, it writes nothing."""
    words, files = door_commands.parts_of(data)
    with _folder(files):
        code, said = _command(words)
        left = {name for name in os.listdir() if name not in files}
        if left and (code in (2, 3) or not all(name.startswith("o") for name in left)):
            raise AssertionError(f"exit {code} and files are left: {said} {left}")


def run_environment(data: bytes) -> None:
    """Run a command in the environment of a case of `door_surroundings`; where it is refused, it writes nothing."""
    variables, words = door_surroundings.parts_of(data)
    given = door_options.files()
    with _folder(given), patch("webbrowser.open", lambda url: False):
        known = tempfile.tempdir
        variables.setdefault("TMPDIR", str(known))
        try:
            with patch.dict(os.environ, variables):
                tempfile.tempdir = None  # looked for again
                code, said = _command(words)
        finally:
            tempfile.tempdir = known
        if code in (2, 3) and (left := set(os.listdir()) ^ set(given)):
            raise AssertionError(f"exit {code} and files are there or gone: {said} {left}")


def run_completion(data: bytes) -> None:
    """Complete a line, as a shell asks for it."""
    shell, at, line = [*data.decode("utf-8", "surrogateescape").replace("\0", "").split("\n", 2), "", ""][:3]
    with patch.dict(
        os.environ, {"_CNCGEN_COMPLETE": f"{shell}_complete", "COMP_WORDS": line, "COMP_CWORD": at}
    ):
        try:
            _command([])
        except SystemExit as ended:  # by click
            if ended.code not in (0, 1):
                raise AssertionError(f"exit {ended.code}") from None


def run_names(data: bytes) -> None:
    """Show a program, a machine, a plan, setpoints and a verdict with a hostile name in a notebook and as text."""
    import cncgen

    named = data.decode("utf-8", "replace")
    machine = replace(_machine("generic-mill"), name=named)
    text = f"G21 G90\n(MSG, {named[:50]})\nG1 X1 F1000\nM2\n"
    program = cncgen.read_text(text, named, language="gcode")
    planned = cncgen.plan(program, machine)
    points = cncgen.sample(planned).collect()
    judged = cncgen.judge(points, program, machine)
    for each in (program, machine, planned, points, judged):
        repr(each)
        shown = each._repr_html_() if hasattr(each, "_repr_html_") else None
        if shown and "<script>" in named and "<script>" in shown:
            raise AssertionError(f"markup of a name stands in what a notebook shows of {type(each).__name__}")


@contextlib.contextmanager
def _folder(files: dict[str, bytes]) -> Iterator[None]:
    """Work in a folder with some files."""
    here, folder = os.getcwd(), os.path.join(tempfile.gettempdir(), "folder")
    os.mkdir(folder)
    os.chdir(folder)
    try:
        for name, content in files.items():
            Path(name).write_bytes(content)
        yield
    finally:
        os.chdir(here)
        shutil.rmtree(folder)


def _command(words: list[str]) -> tuple[int, str]:
    """Run a command in this process; return its exit code and what it says."""
    from cncgen.cli import app

    quiet = io.TextIOWrapper(io.BytesIO(), "utf-8", "replace")
    out, err, sys.stdout, sys.stderr = sys.stdout, sys.stderr, quiet, quiet
    try:
        code = app.run(words)
    finally:
        sys.stdout, sys.stderr = out, err
    quiet.flush()
    said = quiet.buffer.getvalue() if isinstance(quiet.buffer, io.BytesIO) else b""
    text = said[-800:].decode("utf-8", "replace")
    if code not in (0, 1, 2, 3):
        raise AssertionError(f"exit {code}: {text}")
    return code, text


def _file(data: bytes, name: str) -> str:
    """Write a file of these bytes in place of the former one; return its name."""
    path = os.path.join(tempfile.gettempdir(), name)
    with open(path, "wb") as file:
        file.write(data)
    return path


def scratch() -> tempfile.TemporaryDirectory[str]:
    """Return a folder for files of a process, in memory where the system has such: a disk takes longer than most inputs."""
    return tempfile.TemporaryDirectory(dir="/dev/shm" if os.path.isdir("/dev/shm") else None)


FORMATS = ("csv", "jsonl", "npy", "npz", "f64", "hal", "arrow", "parquet", "mat", "hdf5", "mcap", "mf4")
_TEXT_FORMATS = ("csv", "jsonl", "hal")


def doors(corpus: Path | None = None) -> dict[str, Door]:
    """Return the doors by name; seeds are their own, and the files of a folder of their name in `corpus`."""
    found = _doors()
    for place in sorted(corpus.iterdir()) if corpus else ():
        own, more = found[place.name].seeds(), [file.read_bytes() for file in sorted(place.iterdir())]
        found[place.name] = replace(found[place.name], seeds=partial(list, own + more))
    return found


def _doors() -> dict[str, Door]:
    found = dict[str, Door]()
    for name in ("linuxcnc", "fanuc", "fanuc-lathe", "sinumerik", "heidenhain", "auto"):
        found[name] = Door(
            partial(inputs.gcode, name),
            partial(inputs.change_gcode, dialect=name),
            partial(run_gcode, dialect=name),
        )
    found["plan"] = Door(
        lambda: [inputs.PROGRAM.encode()], partial(inputs.change_gcode, dialect="linuxcnc"), run_plan, 300
    )
    found["stepnc"] = Door(inputs.stepnc, inputs.change_stepnc, run_stepnc, 300)
    found["machine"] = Door(inputs.machines, inputs.change, run_machine)
    for kind in FORMATS:
        change = inputs.change if kind in _TEXT_FORMATS else inputs.change_binary
        found[f"setpoints-{kind}"] = Door(
            partial(inputs.setpoints, kind), change, partial(run_setpoints, kind=kind)
        )
    found["log"] = Door(inputs.logs, inputs.change, run_log, 200)
    found["tools"] = Door(lambda: list(inputs.TOOLS), inputs.change, run_tools)
    found["extremes"] = Door(lambda: [b""], lambda rng, *_: extreme_programs.case(rng), run_extremes, 25)
    found["commands"] = Door(door_commands.seeds, door_commands.change, run_commands, 40)
    found["environment"] = Door(door_surroundings.seeds, door_surroundings.change, run_environment, 30)
    found["completion"] = Door(lambda: [b""], door_surroundings.completion, run_completion, 100)
    found["names"] = Door(lambda: [b"part.nc"], door_surroundings.name, run_names, 50)
    found["options"] = Door(door_options.seeds, door_options.change, run_options, 60)
    return found


@cache
def most_seconds() -> float:
    """Return the processor time that one input may take on this machine, s."""
    import cncgen

    taken = []
    for _ in range(3):
        begin = time.process_time()
        cncgen.sample(cncgen.plan(PACE, "generic-mill")).collect()
        taken.append(time.process_time() - begin)
    return SECONDS * max(1.0, min(taken) / PACE_SECONDS)


def fault_of(door: Door, data: bytes) -> tuple[str, str] | None:
    """Run an input; return what kind of fault it shows and all that is known of it, or None."""
    signal.setitimer(signal.ITIMER_PROF, most_seconds())
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
        place = (
            f"{Path(frames[-1].filename).name}:{frames[-1].name}"
            if frames
            else re.sub(r"[-\d.]+", "#", str(error))[:70]
        )
        return f"{type(error).__name__} in {place}", traceback.format_exc(limit=-6)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return None


class TooLong(BaseException):
    """An input takes more time than it may; no handler of exceptions takes it for something else."""


def _hang(number: int, frame: object) -> None:
    raise TooLong(f"more than {most_seconds():.3g} s")


def bound_process() -> None:
    """Bound time and memory of this process."""
    with open("/proc/self/status") as status:
        taken = next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmData:"))
    _limit(resource.RLIMIT_DATA, taken + MEMORY)
    signal.signal(signal.SIGPROF, _hang)


def _limit(kind: int, value: int) -> None:
    """Set a bound of this process, within what the system allows it."""
    most = resource.getrlimit(kind)[1]
    resource.setrlimit(kind, (value if most == resource.RLIM_INFINITY else min(value, most), most))


def batch(name: str, door: Door, data: list[bytes]) -> tuple[int, list[Finding]]:
    """Run inputs in a child; return how many ran, and what they showed."""
    shared = mmap.mmap(-1, 8)
    most_seconds()  # measured once, not by each child
    with scratch() as folder, tempfile.TemporaryFile() as found, tempfile.TemporaryFile() as errors:
        child = os.fork()
        if child == 0:
            tempfile.tempdir = folder
            try:
                _child(door, data, shared, found.fileno(), errors.fileno())
            except BaseException:
                traceback.print_exc()
            finally:
                os._exit(1)  # nothing of the parent is unwound here
        asleep, status = _awaited(child, shared)
        ran = int.from_bytes(shared[:8], "little")
        found.seek(0)
        entries = [
            entry.split("\x1f", 2) for entry in found.read().decode("utf-8", "replace").split("\x1e") if entry
        ]
        findings = [Finding(name, kind, said, data[int(index)]) for index, kind, said in entries]
        if status != 0:
            signalled = os.WIFSIGNALED(status)
            how = f"signal {os.WTERMSIG(status)}" if signalled else f"exit {os.WEXITSTATUS(status)}"
            how = f"an input ran for {CLOCK_SECONDS:.0f} s by the clock" if asleep else how
            errors.seek(0)
            # Behind the stacks stand the names of hundreds of compiled modules.
            said = errors.read().partition(b"\nExtension modules: ")[0][-6000:].decode("utf-8", "replace")
            findings.append(Finding(name, f"the process ends: {how}", said, data[min(ran, len(data) - 1)]))
            ran += 1
    return ran, findings


def _awaited(child: int, shared: mmap.mmap) -> tuple[bool, int]:
    """Wait for the end of a child, which has the stacks of its threads written and is ended where an input takes too long by the clock.

    Returns:
        Whether that was so, and the status of the child.
    """
    handle = os.pidfd_open(child)
    try:
        at, since = shared[:8], time.monotonic()
        while not select.select([handle], [], [], 1.0)[0]:
            if shared[:8] != at:
                at, since = shared[:8], time.monotonic()
            if time.monotonic() - since > CLOCK_SECONDS:
                os.kill(child, signal.SIGABRT)  # `faulthandler` writes the stacks
                return True, os.waitpid(child, 0)[1]
        return False, os.waitpid(child, 0)[1]
    finally:
        os.close(handle)


def batches(name: str, door: Door, data: list[bytes]) -> Iterator[tuple[int, list[Finding]]]:
    """Run all inputs, in a further child after each that ends one; yield how many each ran, and what they showed."""
    while data:
        ran, found = batch(name, door, data)
        yield ran, found
        data = data[ran:]


def tested(name: str) -> list[Finding]:
    """Return what the first inputs of one seed show at a door: the same ones in each run, which gate a change."""
    door = doors()[name]
    data = list(islice(mutants(door, 1), door.tested))
    return [each for _, found in batches(name, door, data) for each in found]


def _child(door: Door, data: list[bytes], shared: mmap.mmap, found: int, errors: int) -> None:
    """Run inputs one after another, tell of each that it begins, and end the process."""
    os.dup2(errors, 2)
    faulthandler.enable(errors)
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    done = 0
    for index, each in enumerate(data):
        if index % BATCH == 0:  # what is cached grows from input to input, and is not one's own
            bound_process()
        shared[:8] = index.to_bytes(8, "little")
        _limit(resource.RLIMIT_CPU, int(time.process_time() + 2 * most_seconds()) + 2)
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


def smaller(name: str, door: Door, finding: Finding) -> Finding:
    """Return a finding of the same kind with less input: lines, then stretches of bytes are left out while it stays."""
    tries = 8 if finding.kind.startswith("TooLong") else 60
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


def run(
    names: list[str], seed: int, seconds: float, corpus: Path | None = None
) -> Iterator[tuple[str, int, list[Finding]]]:
    """Try mutants of each door in turn for so many seconds in all; yield what each process ran, and what it found."""
    known = doors(corpus)
    for module in MODULES:
        importlib.import_module(module)
    streams = {name: mutants(known[name], seed) for name in names}
    sizes = dict.fromkeys(names, BATCH)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for name in names:
            if time.monotonic() > end:
                break
            begin = _processor_time()
            for ran, found in batches(name, known[name], list(islice(streams[name], sizes[name]))):
                yield name, ran, found
            faster = min(BATCH_SECONDS / max(_processor_time() - begin, 0.01), 40.0)
            sizes[name] = min(max(int(sizes[name] * faster), 1), LARGEST_BATCH)


def _processor_time() -> float:
    """Return what this process and the ended ones that it began have taken, s."""
    return sum(os.times()[:4])


def run_and_keep(
    names: list[str],
    seed: int,
    seconds: float,
    tally: Path | None,
    keep: Path | None,
    corpus: Path | None = None,
) -> set[tuple[str, str]]:
    """Run, print counts and findings, one of each kind, and how often each was found; return the kinds, each with its door.

    Args:
        names: Of the doors.
        seed: Of the mutants.
        seconds: Of the run.
        tally: A file of counts by door, which go on from what it holds; written after each process.
        keep: A folder for findings.
        corpus: A folder of further seeds, a folder a door.
    """
    counts: dict[str, int] = json.loads(tally.read_text()) if tally and tally.exists() else {}
    kinds = dict[tuple[str, str], int]()
    for name, ran, found in run(names, seed, seconds, corpus):
        counts[name] = counts.get(name, 0) + ran
        if tally:
            tally.write_text(json.dumps(counts, indent=1))
        for each in found:
            kinds[name, each.kind] = kinds.get((name, each.kind), 0) + 1
            if kinds[name, each.kind] == 1:
                tell(smaller(name, doors()[name], each), keep)
    for name, count in counts.items():
        print(f"{count:8d} {name}")
    for (name, kind), count in kinds.items():
        print(f"{count:8d} times {name}: {kind}")
    print(f"{sum(counts.values()):8d} inputs, {len(kinds)} kinds of fault")
    return set(kinds)


def tell(finding: Finding, keep: Path | None) -> None:
    """Print a finding, and keep its input."""
    shown = repr(finding.data[:4000]) + (" ..." if len(finding.data) > 4000 else "")
    print(f"--- {finding.door}: {finding.kind}\n{finding.said}\n{shown}", flush=True)
    if keep:
        file = keep / finding.door / f"{zlib.crc32(finding.kind.encode()):08x}"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(finding.data)
        print(f"kept as {file}", flush=True)


def short_seeds(door: Door) -> list[bytes]:
    """Return the seeds of a door up to `GUIDED_BYTES`, and as many changed ones as there are longer seeds: coverage makes long ones slow."""
    seeds = door.seeds()
    found = [seed for seed in seeds if len(seed) <= GUIDED_BYTES]
    changed = (each for each in islice(mutants(door, 1), 100 * len(seeds)) if len(each) <= GUIDED_BYTES)
    return found + list(islice(changed, len(seeds) - len(found)))


def guided(name: str, arguments: list[str], keep: Path | None) -> None:
    """Hand a door to atheris, which keeps inputs that reach new code; `arguments` are libFuzzer's. A kind of fault is told once."""
    import atheris  # type: ignore[import-untyped, unused-ignore]

    with atheris.instrument_imports(include=["cncgen", "lark"]):
        for module in MODULES:
            importlib.import_module(module)
    door, kinds = doors()[name], set[str]()
    seeds = door.seeds()

    def mutator(data: bytes, most: int, seed: int) -> bytes:
        # What libFuzzer has found to differ is mixed in as well.
        changed = door.change(random.Random(seed), data, seeds) if seed % 4 else atheris.Mutate(data, most)
        return bytes(changed[:most])

    def one(data: bytes) -> None:
        fault = fault_of(door, data)
        if fault is not None and fault[0] not in kinds:
            kinds.add(fault[0])
            tell(Finding(name, *fault, data), keep)

    signal.signal(signal.SIGPROF, _hang)
    folder = scratch()
    tempfile.tempdir = folder.name
    corpus = Path(folder.name, "corpus")
    corpus.mkdir()
    for number, seed in enumerate(short_seeds(door)):
        (corpus / str(number)).write_bytes(seed)
    words = [sys.argv[0], "-max_len=20000", "-timeout=600", "-rss_limit_mb=4096", *arguments, str(corpus)]
    atheris.Setup(words, one, custom_mutator=mutator)
    atheris.Fuzz()


def replay(folder: Path) -> list[Finding]:
    """Run the kept inputs: a folder a door."""
    known, found = doors(), list[Finding]()
    for place in sorted(path for path in folder.glob("*") if path.is_dir()):
        data = [file.read_bytes() for file in sorted(place.iterdir())]
        for _, findings in batches(place.name, known[place.name], data):
            found += findings
    return found


def not_known(kinds: set[tuple[str, str]], folder: Path) -> set[tuple[str, str]]:
    """Return the kinds of which no open finding shows the same exception at the same door."""
    if not kinds:
        return kinds
    known = {(each.door, each.kind.partition(" in ")[0]) for each in replay(folder)}
    return {(name, kind) for name, kind in kinds if (name, kind.partition(" in ")[0]) not in known}


def main() -> int:
    """Fuzz, print counts and findings, keep these."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--door", action="append", choices=list(doors()))
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--keep", type=Path, help="folder for inputs that show a fault")
    parser.add_argument("--tally", type=Path, help="file of counts by door, which this run adds to")
    parser.add_argument("--corpus", type=Path, help="folder of further seeds, a folder a door")
    parser.add_argument("--replay", type=Path)
    parser.add_argument(
        "--open", type=Path, help="folder of findings that are known: their kinds fail nothing"
    )
    parser.add_argument("--tell", action="store_true", help="end with 0 whatever is found")
    parser.add_argument(
        "--guided", action="store_true", help="one door by atheris; further words are libFuzzer's"
    )
    arguments, further = parser.parse_known_args()
    names = arguments.door or list(doors())
    if arguments.guided:
        guided(names[0], further, arguments.keep)
        return 0
    if arguments.replay:
        findings = replay(arguments.replay)
        for each in findings:
            tell(each, arguments.keep)
        return 1 if findings else 0
    seed = secrets.randbelow(2**31) if arguments.seed is None else arguments.seed
    print(f"seed {seed}", flush=True)
    kinds = run_and_keep(names, seed, arguments.seconds, arguments.tally, arguments.keep, arguments.corpus)
    new = not_known(kinds, arguments.open) if arguments.open else kinds
    if kinds - new:
        print(f"{len(kinds - new):8d} of them known, and open")
    for name, kind in sorted(new):
        print(
            f"=== A NEW KIND OF FAULT with --seed {seed} at --door {name}: {kind}; its input stands above",
            flush=True,
        )
    return 1 if new and not arguments.tell else 0


if __name__ == "__main__":
    raise SystemExit(main())

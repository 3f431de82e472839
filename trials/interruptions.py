"""Every command that writes, stopped at random moments: what it should write is absent, as it was, or whole.

    python -m trials.interruptions [--runs 1000] [--seconds S] [--seed N] [--command WORD ...]

A command runs once undisturbed: that gives its files and its time. Then it runs again and again in a folder of its own, with and
without a file of the same name there before, and is stopped: by a signal (SIGKILL, SIGTERM, SIGINT) or by the end of standard
output's reader at a random moment, by a file that may not grow beyond a random size, or by a disk of a random size (a tmpfs, for
root). A file that is there then must be the former one or the whole one to the byte; nothing else may lie in the folder or among
the temporary files, and of what the process said nothing may be a traceback.

What SIGKILL leaves in the moment between the two calls of the system that replace a file is removed by the next run that writes
the same file; the trial counts such leftovers, and looks that they go.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import random
import re
import resource
import secrets
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

PROGRAM = "G21 G17 G90 G64 P0.01\nG0 X1 Y1\nG1 X30 Y4 F3000\nX4 Y20\nG2 X14 Y20 I5 J0\nM2\n"
CUT = "G21 G17 G90\nT1 M6 G43 H1\nG0 X-5 Y5 Z5\nG1 Z-2 F1000\nX25\nY15\nX-5\nG0 Z5\nM2\n"
SWEEP = """programs = ["p.nc"]
machine = "xy-table"
[options]
feedrate = "ild"
[vary]
"axes.*.max_jerk_mm_s3" = { list = [2e4, 5e4, 1e5] }
[keep]
figures = ["cycle_time_s"]
"""
FORMATS = ("csv", "jsonl", "npy", "npz", "f64", "hal", "arrow", "parquet", "mat", "hdf5", "mcap", "mf4")
#: What stops a run.
KILL, TERM, INT, READER, SIZE, DISK = "SIGKILL", "SIGTERM", "SIGINT", "reader", "size", "disk"
_SIGNALS = {KILL: signal.SIGKILL, TERM: signal.SIGTERM, INT: signal.SIGINT}
#: Longest time of a command, s.
LONGEST_S = 120.0
#: What differs from run to run: dates, times and names that libraries write.
_OF_THE_MOMENT = re.compile(rb"\d{4}-\d\d-\d\dT[\d:.+-]+|in \d+\.\d+ s|[a-f0-9]{12,}")


@dataclass(frozen=True, slots=True)
class Case:
    """A command: its words, the files that it writes (none: standard output alone), and whether its folder holds results."""

    name: str
    words: tuple[str, ...]
    files: tuple[str, ...]


@dataclass(slots=True)
class Whole:
    """An undisturbed run: contents of the files, seconds, bytes of the largest file."""

    contents: dict[str, bytes]
    seconds: float
    size: int


@dataclass(slots=True)
class Tally:
    """Runs by command and by what stopped them, how files were found, leftovers of SIGKILL, and what was wrong."""

    runs: Counter[tuple[str, str]] = field(default_factory=Counter)
    found: Counter[str] = field(default_factory=Counter)
    left: int = 0
    faults: list[str] = field(default_factory=list)

    def line(self) -> str:
        """Return the sums."""
        runs, files = sum(self.runs.values()), dict(self.found)
        return (
            f"{runs:6d} runs; files: {files}; leftovers of SIGKILL: {self.left}; faults: {len(self.faults)}"
        )


def cases() -> list[Case]:
    """Return the commands that write."""
    plan = ("plan", "p.nc", "-m", "xy-table", "--feedrate", "ild")
    found = [
        Case(f"plan {kind}", (*plan, "--format", kind, "-o", f"o.{kind}"), (f"o.{kind}",)) for kind in FORMATS
    ]
    several = (
        *(*plan, "-o", "o.csv", "--summary", "s.json"),
        *("--events", "e.jsonl", "--save-parameters", "v.var"),
    )
    found += [
        Case("plan four files", several, ("o.csv", "s.json", "e.jsonl", "v.var")),
        Case("plan", plan, ()),
        Case(
            "simulate",
            ("simulate", "in.csv", "--axis-params", "xy-table", "-o", "r.csv", "--summary", "s.json"),
            ("r.csv", "s.json"),
        ),
        Case("compensate", ("compensate", "in.csv", "-m", "xy-table", "-o", "c.csv"), ("c.csv",)),
        Case("convert", ("convert", "p.nc", "--linearize", "0.01", "-o", "c.nc"), ("c.nc",)),
        Case("report", ("report", "p.nc", "-m", "xy-table", "--feedrate", "ild", "-o", "p.html"), ("p.html",)),
        Case(
            "cut",
            ("cut", "cut.nc", "--stock", "box:0,0,-5,20,20,0", "--tool-table", "t.tbl", "-o", "c.stl", "--report", "c.json"),
            ("c.stl", "c.json"),
        ),
        Case("plot", ("plot", "in.csv", "-m", "xy-table", "--kinds", "path", "-o", "p.png"), ("p.png",)),
        Case(
            "tune",
            ("tune", "-m", "xy-table", "--bandwidth", "20", "-o", "g.toml"),
            ("g.toml",),
        ),
        Case("identify", ("identify", "log.csv", "--model", "velocity-loop", "-o", "i.toml"), ("i.toml",)),
        Case("excite", ("excite", "--axis", "X", "--duration", "2", "-m", "xy-table", "-o", "x.csv"), ("x.csv",)),
        Case("compare", ("compare", "p.nc", "-m", "xy-table", "-o", "c.txt"), ("c.txt",)),
        Case("canon", ("canon", "p.nc", "-o", "c.txt"), ("c.txt",)),
        Case("sweep", ("sweep", "sweep.toml", "-o", "out", "--processes", "1", "-q"), ()),
    ]  # fmt: skip
    return found


@contextlib.contextmanager
def inputs() -> Iterator[Path]:
    """Make a folder with what the commands read."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "p.nc").write_text(PROGRAM)
        (folder / "cut.nc").write_text(CUT)
        (folder / "t.tbl").write_text("T1 P1 D6 Z10\n")
        (folder / "sweep.toml").write_text(SWEEP)
        for words in (
            ("plan", "p.nc", "-m", "xy-table", "--feedrate", "ild", "-o", "in.csv"),
            ("excite", "--axis", "X", "--duration", "2", "-m", "xy-table", "-o", "excited.csv"),
            ("simulate", "excited.csv", "--axis-params", "xy-table", "-o", "log.csv"),
        ):
            done = subprocess.run(_command(words), cwd=folder, capture_output=True, check=False)
            if done.returncode:
                raise SystemExit(f"{' '.join(words)}: {done.stderr.decode()}")
        yield folder


def _command(words: tuple[str, ...]) -> list[str]:
    return [sys.executable, "-m", "cncgen", *words]


def undisturbed(case: Case, given: Path) -> Whole:
    """Run a command to its end."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name, "work")
        shutil.copytree(given, folder)
        begin = time.monotonic()
        done = subprocess.run(
            _command(case.words), cwd=folder, capture_output=True, check=False, timeout=LONGEST_S
        )
        seconds = time.monotonic() - begin
        if done.returncode not in (0, 1):
            raise SystemExit(f"{case.name}: exit {done.returncode}: {done.stderr.decode()}")
        contents = {file: (folder / file).read_bytes() for file in case.files}
        sizes = [path.stat().st_size for path in folder.rglob("*") if path.is_file()]
        return Whole(contents, seconds, max(sizes))


def stopped(case: Case, whole: Whole, given: Path, how: str, rng: random.Random, tally: Tally) -> None:
    """Run a command, stop it, and look at what is there."""
    with contextlib.ExitStack() as ends:
        place = Path(ends.enter_context(tempfile.TemporaryDirectory()))
        folder, scratch = place / "work", place / "tmp"
        folder.mkdir()
        scratch.mkdir()
        if how == DISK:
            taken = sum(path.stat().st_size for path in given.iterdir()) + 8 * 4096
            size = taken + int(rng.random() * sum(map(len, whole.contents.values()))) + 4096
            mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
            subprocess.run(mount, check=True)
            ends.callback(subprocess.run, ["umount", str(folder)], check=True)
        shutil.copytree(given, folder, dirs_exist_ok=True)
        before = {file: b"as it was\n" for file in case.files if rng.random() < 0.5}
        for file, content in before.items():
            (folder / file).write_bytes(content)
        said, code = _run(case, whole, how, folder, scratch, rng)
        tally.runs[case.name.partition(" ")[0], how] += 1
        trouble = _faults(case, whole, how, before, folder, scratch, tally)
        # Before the first line of cncgen runs, an interrupt is the interpreter's to tell.
        if (b"Traceback" in said and b"/cncgen/" in said) or b"internal error" in said or code == 70:
            trouble.append(
                f"exit {code}, said {said[max(said.find(b'Traceback'), 0) :][:1500].decode('utf-8', 'replace')}"
            )
        tally.faults += [f"{case.name}, {how}: {each}" for each in trouble]


def _run(
    case: Case, whole: Whole, how: str, folder: Path, scratch: Path, rng: random.Random
) -> tuple[bytes, int]:
    """Start a command and stop it; return what it said and its code."""
    grow = rng.randrange(max(whole.size, 2)) if how == SIZE else None
    environment = {**os.environ, "TMPDIR": str(scratch), "PYTHONDONTWRITEBYTECODE": "1"}
    process = subprocess.Popen(
        _command(case.words),
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        preexec_fn=partial(_prepared, grow),
    )
    assert process.stdout is not None
    # Many moments where files are written, near the end; some anywhere.
    moment = whole.seconds * (rng.uniform(0.6, 1.1) if rng.random() < 0.7 else rng.uniform(0.0, 1.2))
    if how in _SIGNALS:
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(moment)
        process.send_signal(_SIGNALS[how])
    elif how == READER:
        if case.files:
            time.sleep(min(moment, whole.seconds))
        else:
            os.read(process.stdout.fileno(), rng.randrange(1, 20_000))
        process.stdout.close()
        process.stdout = None
    try:
        _, said = process.communicate(timeout=LONGEST_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return b"internal error: it does not end", 70
    return said, process.returncode


def _prepared(grow: int | None) -> None:
    """Let signals end the process as in a shell; bound its files."""
    for each in (signal.SIGINT, signal.SIGTERM):
        signal.signal(each, signal.SIG_DFL)
    if grow is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (grow, grow))


def _faults(
    case: Case, whole: Whole, how: str, before: dict[str, bytes], folder: Path, scratch: Path, tally: Tally
) -> list[str]:
    """Return what is wrong with what a stopped command left."""
    found = []
    for file in case.files:
        path = folder / file
        if not path.exists():
            state = "absent"
            if file in before:
                found.append(f"{file} was there before, and is gone")
        else:
            content = path.read_bytes()
            state = "as it was" if content == before.get(file) else "whole"
            if state == "whole" and not _same(content, whole.contents[file]):
                found.append(f"{file} is neither as it was nor whole: {len(content)} bytes")
        tally.found[state] += 1
    known = set(case.files) | {"p.nc", "cut.nc", "t.tbl", "sweep.toml", "in.csv", "excited.csv", "log.csv"}
    results = case.name == "sweep"
    left = [
        path for path in folder.iterdir() if path.name not in known and not (results and path.name == "out")
    ]
    if results and (folder / "out").exists():
        found += _faults_of_results(folder / "out", how, tally)
    left += list(scratch.iterdir())
    if left and how == KILL and all(path.name.endswith(".part") for path in left):
        tally.left += 1
        left = _after_another(case, folder)
    if left:
        found.append(f"left over: {', '.join(path.name for path in left)}")
    return found


def _after_another(case: Case, folder: Path) -> list[Path]:
    """Run the command again; return what is left of the first run then."""
    subprocess.run(_command(case.words), cwd=folder, capture_output=True, check=False, timeout=LONGEST_S)
    return [path for path in folder.iterdir() if path.name.endswith(".part")]


def _faults_of_results(results: Path, how: str, tally: Tally) -> list[str]:
    """Return which parts of a sweep's results are not whole, and what else lies there."""
    from pyarrow import parquet

    found = []
    for path in results.iterdir():
        if path.name.endswith(".part"):
            if how == KILL:
                tally.left += 1
            else:
                found.append(f"left over: {path.name}")
        elif path.suffix == ".parquet":
            try:
                parquet.read_table(path)
            except Exception as error:
                found.append(f"{path.name}: {error}")
    return found


def _same(content: bytes, other: bytes) -> bool:
    """Tell whether two contents are the same but for what is of the moment."""
    if content == other:
        return True
    return _OF_THE_MOMENT.sub(b"", content) == _OF_THE_MOMENT.sub(b"", other)


def run(
    seed: int,
    runs: int,
    wanted: list[str] | None = None,
    hows: list[str] | None = None,
    seconds: float = math.inf,
) -> Tally:
    """Stop commands, each in turn, for so long at most; return the counts."""
    rng, tally = random.Random(seed), Tally()
    kinds = hows or [KILL, TERM, INT, READER, SIZE, *([DISK] if _mounts() else [])]
    with inputs() as given:
        chosen = [case for case in cases() if not wanted or case.name in wanted]
        wholes = {case.name: undisturbed(case, given) for case in chosen}
        end = time.monotonic() + seconds
        for index in range(runs):
            if time.monotonic() > end:
                break
            case = chosen[index % len(chosen)]
            how = kinds[(index // len(chosen) + index) % len(kinds)]
            stopped(case, wholes[case.name], given, how, rng, tally)
            if (index + 1) % len(chosen) == 0:
                print(tally.line(), flush=True)
    return tally


def _mounts() -> bool:
    """Tell whether this process may mount a tmpfs."""
    if os.geteuid() or not shutil.which("mount"):
        return False
    with tempfile.TemporaryDirectory() as place:
        if subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=65536", "tmpfs", place], capture_output=True, check=False
        ).returncode:
            return False
        subprocess.run(["umount", place], check=True)
        return True


def main() -> int:
    """Run the trial and print the counts."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=math.inf)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--command", action="append", choices=[case.name for case in cases()])
    given = parser.parse_args()
    seed = secrets.randbelow(2**31) if given.seed is None else given.seed
    print(f"seed {seed}", flush=True)
    tally = run(seed, given.runs, given.command, seconds=given.seconds)
    for (command, how), count in sorted(tally.runs.items()):
        print(f"{count:6d} {command}, {how}")
    print(tally.line())
    print("\n".join(tally.faults) or "nothing is wrong")
    return 1 if tally.faults else 0


if __name__ == "__main__":
    raise SystemExit(main())

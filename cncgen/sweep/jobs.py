"""Jobs: one program on one machine with options, its key, and its row. Jobs with the same key give the same row.

The key is the SHA-256 of the hash of the program (with the files that travel with it), the machine's tables, the options, the
figures and the code of cncgen, so a job has the same key in every process and on every computer.
"""

from __future__ import annotations

import atexit
import hashlib
import json
import threading
import time
import warnings
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from cncgen.diagnostics import CncgenError, Diagnostic, RemarkWarning, Severity, UsageError
from cncgen.files import scratch_folder
from cncgen.sweep.quantities import Value


@dataclass(frozen=True, slots=True)
class Bundle:
    """A program with the files that it needs; `bundle_of` makes it.

    Attributes:
        program: Name of the program among the files.
        files: Contents by name.
        hash: SHA-256 over names and contents.
    """

    program: str
    files: Mapping[str, bytes]
    hash: str


def bundle_of(program: str, files: Mapping[str, bytes]) -> Bundle:
    """Return the bundle of a program and its files by name."""
    total = hashlib.sha256(program.encode())
    for name in sorted(files):
        total.update(f"\0{name}\0{len(files[name])}\0".encode())
        total.update(files[name])
    return Bundle(program, files, total.hexdigest())


@dataclass(frozen=True, slots=True)
class SweepJob:
    """One row to be.

    Attributes:
        key: Hash of all that decides the figures.
        bundle: Hash of the program's bundle.
        machine: Its name, for messages.
        tables: The machine as the tables of its file.
        options: By name; see `cncgen.sweep.figures.computed`.
        figures: Names.
    """

    key: str
    bundle: str
    machine: str
    tables: Mapping[str, Any]
    options: Mapping[str, Any]
    figures: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class JobOutcome:
    """The figures of a job, or the reason why it failed.

    Attributes:
        key: The job's.
        figures: Values by name; empty where the job failed.
        code, error: Code and text of the diagnostic of a job that failed; else "".
    """

    key: str
    figures: Mapping[str, float | None]
    code: str = ""
    error: str = ""


@dataclass(frozen=True, slots=True)
class Place:
    """Where a job stands in its sweep: names of program and machine, number of the point, and the values that are varied."""

    program: str
    machine: str
    point: int
    values: tuple[Value, ...]


@cache
def code_version() -> str:
    """Return the version of cncgen with a hash of its sources: rows of other code are rows of other jobs."""
    import cncgen

    home = Path(cncgen.__file__).parent
    total = hashlib.sha256()
    for path in sorted(home.rglob("*.py"), key=lambda path: path.relative_to(home).as_posix()):
        total.update(path.relative_to(home).as_posix().encode() + b"\0" + path.read_bytes())
    return f"{cncgen.__version__}+{total.hexdigest()[:12]}"


def job_of(
    bundle: str, machine: str, tables: Mapping[str, Any], options: Mapping[str, Any], figures: Sequence[str]
) -> SweepJob:
    """Return a job with its key."""
    parts = [code_version(), bundle, tables, options, sorted(figures)]
    key = hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()
    return SweepJob(key, bundle, machine, tables, options, tuple(figures))


#: Bundles by hash that this process has been given, and the folders that hold their files.
_bundles: dict[str, Bundle] = {}
_folders: dict[str, str] = {}
_scratch = ExitStack()
#: A process computes one job at a time: warnings and folders are the process's.
_one = threading.Lock()


def take_bundles(bundles: Sequence[Bundle]) -> None:
    """Keep bundles for the jobs that this process will compute."""
    _bundles.update({bundle.hash: bundle for bundle in bundles})


def _folder_of(bundle: str) -> Path:
    """Return the folder with the files of a bundle, which is written once."""
    if bundle not in _folders:
        folder = _scratch.enter_context(scratch_folder())
        for name, content in _bundles[bundle].files.items():
            path = Path(folder) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        _folders[bundle] = folder
    return Path(_folders[bundle])


def drop_folders() -> None:
    """Remove the files of bundles, at the end of the process."""
    _folders.clear()
    _scratch.close()


atexit.register(drop_folders)


def check_version(version: str) -> None:
    """Refuse to work for a driver that runs other code than this process.

    Args:
        version: The driver's `code_version`.

    Raises:
        UsageError: It differs: rows would depend on who computed them.
    """
    if version != code_version():
        text = f"a worker runs cncgen {code_version()}, the driver {version}"
        hint = "install the same cncgen on all of them"
        raise UsageError(Diagnostic("sweep-version", text, hint=hint))


def compute_batch(version: str, batch: Sequence[SweepJob]) -> tuple[list[JobOutcome], float]:
    """Compute jobs one after the other, whose bundles this process has; return their outcomes and the seconds it took.

    Raises:
        UsageError: This process runs another version of cncgen than the driver, which has `version`.
    """
    check_version(version)
    with _one:
        begun = time.perf_counter()
        return [compute(job) for job in batch], time.perf_counter() - begun


def compute(job: SweepJob) -> JobOutcome:
    """Compute one job; an error in it becomes its outcome."""
    from cncgen.machine.reading import machine_from_tables
    from cncgen.sweep.figures import computed

    folder = _folder_of(job.bundle)
    program = folder / _bundles[job.bundle].program
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RemarkWarning)
            machine = machine_from_tables(job.tables, "", job.machine)
            return JobOutcome(job.key, computed(job.figures, program, machine, job.options, folder))
    except CncgenError as error:
        worst = [item for item in error.diagnostics if item.severity == Severity.ERROR] or error.diagnostics
        return _failed(job, worst[0], folder)
    except MemoryError:
        return _failed(job, Diagnostic("out-of-memory", "the job needs more memory than there is"), folder)
    except Exception as error:
        text = f"{type(error).__name__}: {error}"
        return _failed(job, Diagnostic("internal", f"this is a fault of cncgen: {text}"), folder)


def _failed(job: SweepJob, fault: Diagnostic, folder: Path) -> JobOutcome:
    """Return the outcome of a job that failed; names of files stand as in the sweep, not as in this process."""
    text = fault.render().partition("\n")[0]
    return JobOutcome(job.key, {}, fault.code, text.replace(f"{folder}/", ""))

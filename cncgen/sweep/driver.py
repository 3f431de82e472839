"""The driver of a sweep: hands out missing jobs in batches, and is the only one to write results.

Jobs are batched to `BATCH_S`, since handing one over costs some ms. Results are written after `WRITE_S` at the latest, later
after a hundredth of the time so far: so a killed driver loses at most this much computing, and a day leaves some hundred files.
"""

from __future__ import annotations

import math
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cncgen.diagnostics import Diagnostic, NoPlanError, UsageError
from cncgen.room import MIB, left_of_addresses, room
from cncgen.sweep.jobs import JobOutcome, Place, SweepJob, code_version, compute_batch, take_bundles
from cncgen.sweep.results import DrawnDesign, ResultsFolder, RowLayout, kind_of
from cncgen.sweep.varying import Laid, jobs_of

if TYPE_CHECKING:
    from cncgen.sweep.definition import SweepDefinition
    from cncgen.sweep.local_workers import Batch, Workers

BATCH_S = 0.5
WRITE_S = 2.0
#: Share of the time so far after which results are written.
_WRITE_SHARE = 0.01
#: Batches that wait at each worker, so that none of them waits for the driver.
_AHEAD = 2
#: Memory of a job with its place and key: 1530 bytes were measured with two quantities on one machine.
_JOB_BYTES = 1500
#: A job among whose batches so many workers died is computed alone; it failed when so many died of it alone.
_SUSPECT, _GUILTY = 2, 3


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a sweep is: jobs that are in the results (failed ones among them), and all; jobs and seconds of this run."""

    done: int
    failed: int
    total: int
    computed: int
    seconds: float

    @property
    def rate(self) -> float:
        """Jobs a second in this run."""
        return self.computed / self.seconds if self.seconds > 0.0 else 0.0

    @property
    def left_s(self) -> float:
        """Seconds that the missing jobs will take at this rate; infinite before the first one is done."""
        return (self.total - self.done) / self.rate if self.rate > 0.0 else math.inf


Watch = Callable[[Progress], None]


@dataclass(frozen=True, slots=True)
class Outlook:
    """The jobs of a sweep, done and missing.

    Attributes:
        laid: All of its jobs.
        missing: Keys of those without a row.
        failed: How many rows tell of a failed job.
    """

    laid: Laid
    missing: tuple[str, ...]
    failed: int

    @property
    def jobs(self) -> Mapping[str, tuple[Place, SweepJob]]:
        """Place and job by key."""
        return self.laid.jobs


def outlook(sweep: SweepDefinition, folder: ResultsFolder | None) -> Outlook:
    """Compare a sweep with the rows that a folder has; None: with no rows.

    Raises:
        UsageError: The folder has rows of another sweep, or of another version of cncgen.
        NoPlanError: So many jobs have no room in memory.
    """
    most = min(room(), left_of_addresses())
    if sweep.size * _JOB_BYTES > most:
        text = f"{sweep.size} jobs take some {sweep.size * _JOB_BYTES / MIB:.0f} MiB to lay out, and the run has {most / MIB:.0f} MiB"
        hint = "fewer points or levels, or a larger --max-memory"
        raise NoPlanError(Diagnostic("max-memory", text, hint=hint))
    laid = jobs_of(sweep)
    states = folder.states() if folder else {}
    if folder:
        check_own(folder, states.keys() - laid.jobs.keys(), len(states))
    missing = tuple(key for key in laid.jobs if key not in states)
    return Outlook(laid, missing, sum(states.values()))


def check_own(folder: ResultsFolder, foreign: set[str], rows: int) -> None:
    """Refuse a folder in which rows stand that are not a sweep's.

    Raises:
        UsageError: There are such rows.
    """
    if foreign:
        text = f"{folder.path} has {len(foreign)} of {rows} rows that are not of this sweep"
        hint = "the sweep, a program, a machine or cncgen itself changed since; give -o another folder, or remove this one"
        raise UsageError(Diagnostic("sweep-other", text, hint=hint))


def layout_of(sweep: SweepDefinition) -> RowLayout:
    """Return the columns of a sweep's table."""
    kinds: dict[str, type] = {}
    for quantity in sweep.quantities:
        kind = kind_of(quantity.extremes()) if quantity.discrete else float
        kinds |= dict.fromkeys(quantity.columns, kind)
    return RowLayout(kinds, sweep.figures)


def seconds_a_job(sweep: SweepDefinition, found: Outlook) -> tuple[float, list[str]]:
    """Return the mean time of the missing jobs, by computing the first one of each program here, and why such jobs failed.

    The first job of all is computed twice, since it loads what the others find loaded.
    """
    take_bundles(list(sweep.programs.values()))
    firsts: dict[str, SweepJob] = {}
    counts: Counter[str] = Counter()
    for key in found.missing:
        place, job = found.jobs[key]
        firsts.setdefault(place.program, job)
        counts[place.program] += 1
    version = code_version()
    compute_batch(version, list(firsts.values())[:1])
    first = {program: compute_batch(version, [job]) for program, job in firsts.items()}
    errors = [outcome.error for outcomes, _ in first.values() for outcome in outcomes if outcome.code]
    return sum(first[program][1] * count for program, count in counts.items()) / len(found.missing), errors


def _drawn(sweep: SweepDefinition, laid: Laid) -> DrawnDesign:
    """Return a sweep's design as its results remember it."""
    levels = tuple(
        len(quantity.shares()) if quantity.discrete else 0
        for quantity in sweep.quantities
        for _ in quantity.columns
    )
    return DrawnDesign(
        sweep.design,
        sweep.points,
        sweep.seed,
        tuple(sweep.shares),
        sweep.columns,
        levels,
        sweep.figures,
        laid.groups,
    )


class RowWriter:
    """Gathers rows and writes them as parts when it is time."""

    def __init__(self, folder: ResultsFolder, layout: RowLayout) -> None:
        self._folder, self._layout = folder, layout
        self._rows: list[tuple[Place, JobOutcome]] = []
        self._begun = self._written = time.monotonic()

    def add(self, place: Place, outcome: JobOutcome) -> None:
        """Take a row; write all that wait where the last part is long ago."""
        self._rows.append((place, outcome))
        now = time.monotonic()
        if now - self._written >= max(WRITE_S, _WRITE_SHARE * (now - self._begun)):
            self.flush()

    def flush(self) -> None:
        """Write the rows that wait."""
        if self._rows:
            self._folder.write(self._rows, self._layout)
        self._rows, self._written = [], time.monotonic()


def run_sweep(
    sweep: SweepDefinition,
    path: str | Path,
    workers: Workers,
    *,
    again_failed: bool = False,
    watch: Watch = lambda progress: None,
) -> Progress:
    """Compute the jobs of a sweep that are missing in a folder.

    Args:
        sweep: From `load_sweep`.
        path: The folder.
        workers: Who computes.
        again_failed: Whether jobs that failed are computed again.
        watch: Told of progress.

    Returns:
        How far the sweep is at the end: complete, unless an exception ends it.

    Raises:
        UsageError: The folder cannot be used, or workers run another version.
    """
    folder = ResultsFolder(path)
    folder.prepare()
    with folder.locked():
        if again_failed:
            folder.drop_failed()
        found = outlook(sweep, folder)
        folder.remember(sweep.text)
        folder.remember_design(_drawn(sweep, found.laid))
        queue = JobQueue([found.jobs[key][1] for key in found.missing], workers)
        done, failed, begun = len(found.jobs) - len(found.missing), found.failed, time.monotonic()
        before, writer = done, RowWriter(folder, layout_of(sweep))
        progress = Progress(done, failed, len(found.jobs), 0, 0.0)
        try:
            for outcome in queue.outcomes():
                writer.add(found.jobs[outcome.key][0], outcome)
                done, failed = done + 1, failed + bool(outcome.code)
                seconds = time.monotonic() - begun
                progress = Progress(done, failed, len(found.jobs), done - before, seconds)
                watch(progress)
        finally:
            writer.flush()
    return progress


class JobQueue:
    """Jobs on their way through workers: in batches, again where a worker died, alone where that happens often."""

    def __init__(self, jobs: list[SweepJob], workers: Workers) -> None:
        self._waiting = deque(jobs)
        self._alone: deque[SweepJob] = deque()
        self._deaths: Counter[str] = Counter()
        self._workers = workers
        self._running = 0
        self._seconds = 0.0  # a job takes, of late; 0 before one is done

    def outcomes(self) -> Iterator[JobOutcome]:
        """Yield the outcome of every job, once each, in the order in which they are done."""
        while self._waiting or self._alone or self._running:
            self._hand_out()
            for batch, result in self._workers.completed(1.0):
                self._running -= 1
                if result is None:
                    yield from self._died(batch)
                    continue
                outcomes, seconds = result
                each = seconds / len(batch)
                self._seconds = each if self._seconds == 0.0 else 0.7 * self._seconds + 0.3 * each
                yield from outcomes

    def _hand_out(self) -> None:
        while self._waiting and self._running < (1 + _AHEAD) * self._workers.count:
            size = self._batch_size()
            self._submit([self._waiting.popleft() for _ in range(min(size, len(self._waiting)))])
        if self._alone and not self._waiting and not self._running:
            self._submit([self._alone.popleft()])

    def _submit(self, batch: list[SweepJob]) -> None:
        self._workers.submit(tuple(batch))
        self._running += 1

    def _batch_size(self) -> int:
        """Return the number of jobs that take `BATCH_S`, bounded so that each worker has work at the end."""
        if self._seconds == 0.0:
            return 1
        share = math.ceil(len(self._waiting) / self._workers.count)
        return max(1, min(math.ceil(BATCH_S / self._seconds), share))

    def _died(self, batch: Batch) -> Iterator[JobOutcome]:
        """Take back the jobs of a worker that died; nobody knows which of them killed it, if any did."""
        alone = len(batch) == 1 and self._deaths[batch[0].key] >= _SUSPECT
        for job in batch:
            self._deaths[job.key] += 1
            if alone and self._deaths[job.key] >= _SUSPECT + _GUILTY:
                text = f"error[worker-died]: {_GUILTY} workers died that computed this job alone"
                yield JobOutcome(job.key, {}, "worker-died", text)
            elif self._deaths[job.key] >= _SUSPECT:
                self._alone.append(job)
            else:
                self._waiting.appendleft(job)

"""Workers on this computer: the process pool of the standard library, made again when one of its processes is killed."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context, resource_tracker
from typing import Protocol

from cncgen.interrupts import end_pool, follow_driver, held
from cncgen.sweep.jobs import (
    Bundle,
    JobOutcome,
    SweepJob,
    code_version,
    compute_batch,
    drop_folders,
    take_bundles,
)

Batch = tuple[SweepJob, ...]
#: A batch with its outcomes and seconds; None instead where its worker died.
Done = tuple[Batch, tuple[list[JobOutcome], float] | None]


class Workers(Protocol):
    """The interface of whatever computes batches."""

    @property
    def count(self) -> int:
        """How many batches it computes at once."""
        ...

    def submit(self, batch: Batch) -> None:
        """Hand over a batch."""

    def completed(self, timeout_s: float) -> list[Done]:
        """Wait for batches, at most so long; return those that are done or whose worker died."""

    def close(self) -> None:
        """Give up the batches that are not done."""


def processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class LocalWorkers:
    """Processes on this computer.

    Args:
        count: How many.
        bundles: The programs, which go to each process once.
    """

    def __init__(self, count: int, bundles: Sequence[Bundle]) -> None:
        self.count = count
        self._bundles = tuple(bundles)
        self._running: dict[Future[tuple[list[JobOutcome], float]], Batch] = {}
        # Made for the first batch: an interrupt while the driver still imports would leave the locks of a pool behind.
        self._pool: ProcessPoolExecutor | None = None

    def _started_pool(self) -> ProcessPoolExecutor:
        if self._pool is None:
            # Processes that are forked would share locks with the threads of this one.
            self._pool = ProcessPoolExecutor(
                self.count, get_context("spawn"), initializer=begin_worker, initargs=(self._bundles,)
            )
        return self._pool

    def submit(self, batch: Batch) -> None:
        """Hand over a batch."""
        try:
            if os.name == "posix" and self._pool is None:
                # It is started with the first process, and lets all signals through as it is.
                resource_tracker.ensure_running()
            # A process that is started by half would die with a traceback.
            with held():
                future = self._started_pool().submit(compute_batch, code_version(), batch)
        except BrokenProcessPool:
            future = Future()
            future.set_exception(BrokenProcessPool())
        self._running[future] = batch

    def completed(self, timeout_s: float) -> list[Done]:
        """Wait for batches; where a process was killed, those that it and the others had are returned as not done."""
        finished, _ = wait(self._running, timeout_s, FIRST_COMPLETED)
        done: list[Done] = []
        broken = any(isinstance(future.exception(), BrokenProcessPool) for future in finished)
        if broken and self._pool:
            self._pool.shutdown(wait=True)  # the pool gives all of its futures the exception
            finished, self._pool = set(self._running), None
        for future in finished:
            batch = self._running.pop(future)
            lost = isinstance(future.exception(), BrokenProcessPool)
            done.append((batch, None if lost else future.result()))
        return done

    def close(self) -> None:
        """End the processes and give up their batches."""
        if self._pool is not None:
            end_pool(self._pool)


def begin_worker(bundles: Sequence[Bundle]) -> None:
    """Prepare a process of the pool, which keeps the programs."""
    follow_driver(drop_folders)
    # As in the driver's process, warnings of libraries are none of the user's; faults are in the rows.
    warnings.showwarning = lambda *_, **__: None
    take_bundles(bundles)

"""Workers of a cluster: `dask.distributed`, whose scheduler hands batches out again when a worker dies.

Each worker gets the programs once, as a plugin, also if it joins later. TLS follows dask's own configuration.
"""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import TYPE_CHECKING, Any

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.sweep.jobs import Bundle, code_version, compute_batch, take_bundles

if TYPE_CHECKING:
    from cncgen.sweep.local_workers import Batch, Done

#: Longest wait for the scheduler, s.
_PATIENCE_S = 30
#: Tries to give the workers their programs, each of which a worker that dies in it ends.
_TRIES = 5
#: ``M_TRIM_THRESHOLD`` and ``M_MMAP_THRESHOLD`` of glibc's malloc.h.
_TRIM, _MMAP = -1, -3
#: Wait for a first worker after which the user hears of it, s.
_LONELY_S = 10.0


def needed_distributed() -> ModuleType:
    """Import dask.distributed.

    Raises:
        UsageError: It is missing.
    """
    try:
        import distributed
    except ImportError as error:
        hint = "pip install 'cncgen[cluster]'"
        raise UsageError(
            Diagnostic("missing-package", "--scheduler needs dask.distributed", hint=hint)
        ) from error
    module: ModuleType = distributed
    return module


class ClusterWorkers:
    """Workers behind a dask scheduler.

    Args:
        address: ``tcp://host:8786``, or ``tls://…``.
        bundles: The programs.
        tell: Told when batches wait and the scheduler has had no workers for a while; workers may join yet, as those that Slurm
            starts do.

    Raises:
        UsageError: dask.distributed is missing, the scheduler cannot be reached, or a worker runs another version of cncgen.
    """

    def __init__(
        self, address: str, bundles: Sequence[Bundle], tell: Callable[[str], None] = lambda text: None
    ) -> None:
        self._dask = needed_distributed()
        self._address, self._tell = address, tell
        self._alone_since: float | None = None
        try:
            self._client = self._dask.Client(address, timeout=_PATIENCE_S, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            text = f"cannot reach the scheduler {address}: {error}"
            raise UsageError(Diagnostic("sweep-scheduler", text)) from error
        self._running: dict[Any, Batch] = {}
        try:
            _check_workers(self._client)
            _register(self._client, _plugin(self._dask, tuple(bundles)))
        except BaseException:
            self.close()
            raise

    @property
    def count(self) -> int:
        """Workers that there are now; one at least, which may join yet."""
        return max(1, self._joined())

    def _joined(self) -> int:
        return len(self._client.scheduler_info(n_workers=-1)["workers"])

    def submit(self, batch: Batch) -> None:
        """Hand over a batch."""
        future = self._client.submit(
            compute_batch, code_version(), batch, key=f"cncgen-{batch[0].key}-{len(batch)}", pure=False
        )
        self._running[future] = batch

    def completed(self, timeout_s: float) -> list[Done]:
        """Wait for batches; return those that are done, or that the scheduler gave up as their workers died."""
        try:
            with self._client.as_current():
                self._dask.wait(list(self._running), timeout=timeout_s, return_when="FIRST_COMPLETED")
        except TimeoutError:
            self._watch_workers()
            return []
        done: list[Done] = []
        for future in [future for future in self._running if future.done()]:
            batch = self._running.pop(future)
            if future.status == "finished":
                done.append((batch, future.result()))
                continue
            fault = None if future.status == "cancelled" else future.exception()
            if fault is not None and not isinstance(fault, self._dask.scheduler.KilledWorker):
                raise fault
            done.append((batch, None))
        return done

    def _watch_workers(self) -> None:
        """Tell once each time that the scheduler is left without workers."""
        now = time.monotonic()
        if self._joined():
            self._alone_since = None
        elif self._alone_since is None:
            self._alone_since = now
        elif now - self._alone_since >= _LONELY_S:
            self._alone_since = float("inf")
            self._tell(
                f"the scheduler {self._address} has no workers, for which {len(self._running)} batches wait"
            )

    def close(self) -> None:
        """Leave the cluster; batches that are not done are cancelled."""
        self._client.cancel(list(self._running))
        self._client.close()


def _check_workers(client: Any) -> None:
    """Refuse a cluster with a worker that lacks cncgen or runs other code.

    Raises:
        UsageError: There is one.
    """
    for worker, found in client.run(_version_of_worker, on_error="return").items():
        if isinstance(
            found, OSError
        ):  # it died meanwhile; one that takes its place sees the version with its first batch
            continue
        if isinstance(found, BaseException):
            text = f"the worker {worker} cannot run cncgen: {found}"
            raise UsageError(Diagnostic("sweep-version", text, hint="install the same cncgen there"))
        if found != code_version():
            text = f"the worker {worker} runs cncgen {found}, the driver {code_version()}"
            hint = "install the same cncgen on all of them"
            raise UsageError(Diagnostic("sweep-version", text, hint=hint))


def _register(client: Any, plugin: Any) -> None:
    """Give all workers a plugin; workers that join later get it from the scheduler.

    Raises:
        OSError: It cannot be given.
    """
    for left in reversed(range(_TRIES)):
        try:
            client.register_plugin(plugin, name="cncgen-programs")
            return
        except OSError:  # a worker died meanwhile
            if not left:
                raise


def _version_of_worker() -> str:
    return code_version()


def _keep_freed_memory() -> None:
    """Let the C library of a worker keep the memory that arrays leave, as that of other processes does.

    dask starts its workers with ``MALLOC_TRIM_THRESHOLD_=65536``, by which each array's memory is handed back and asked for again:
    a plan then took half as much time again, most of it page faults.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, TypeError, AttributeError):  # no glibc
        return
    for threshold, size in ((_TRIM, 1 << 27), (_MMAP, 1 << 25)):
        mallopt(threshold, size)


def _plugin(dask: ModuleType, bundles: tuple[Bundle, ...]) -> Any:
    """Return a plugin that gives a worker the programs when it joins."""

    class Programs(dask.WorkerPlugin):  # type: ignore[name-defined]
        def setup(self, worker: Any) -> None:
            _keep_freed_memory()
            take_bundles(bundles)

    return Programs()

"""The memory that this process may still take, for sizes that are checked before allocation, and for threads."""

from __future__ import annotations

import math

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Future, ThreadPoolExecutor
    from typing import ParamSpec, TypeVar

    _P = ParamSpec("_P")
    _T = TypeVar("_T")

try:
    import resource
except ImportError:  # Windows has no such bounds
    resource = None  # type: ignore[assignment]

MIB = 2**20
#: What a thread may take to begin, bytes: its stack of 8 MiB, and blocks of Python's and the system's allocator.
THREAD = 16 * MIB


def taken() -> int:
    """Return the bytes of data that this process has; 0 where the system does not say."""
    return _status("VmData:")


def _status(field: str) -> int:
    """Return a size of this process, bytes; 0 where the system does not say."""
    try:
        with open("/proc/self/status") as status:
            for line in status:
                if line.startswith(field):
                    return int(line.split()[1]) * 1024
    except OSError:
        pass
    return 0


def left_of_addresses() -> float:
    """Return the bytes of addresses that ``ulimit -v`` leaves this process, code and mapped files among them; infinite without it."""
    if resource is None:
        return math.inf
    most = resource.getrlimit(resource.RLIMIT_AS)[0]
    return math.inf if most == resource.RLIM_INFINITY else max(most - _status("VmSize:"), 0)


def room() -> float:
    """Return the bytes of data that this process may take beside those; infinite where nothing bounds them."""
    if resource is None:
        return math.inf
    most = resource.getrlimit(resource.RLIMIT_DATA)[0]
    return math.inf if most == resource.RLIM_INFINITY else max(most - taken(), 0)


def check_thread() -> None:
    """Raise `MemoryError` where this process has no room for one more thread.

    `Thread.start` waits until the thread says that it has begun, and waits for ever if the thread ended before, for want of memory.
    """
    if (left := min(room(), left_of_addresses())) < THREAD:
        raise MemoryError(f"a thread needs {THREAD // MIB} MiB to begin, and {left / MIB:.3g} MiB are left")


def pool(workers: int, name: str = "") -> ThreadPoolExecutor:
    """Return a pool of threads, each of which begins only where there is room for it (`check_thread`)."""
    from concurrent.futures import ThreadPoolExecutor

    class Pool(ThreadPoolExecutor):
        def submit(self, fn: Callable[_P, _T], /, *args: _P.args, **kwargs: _P.kwargs) -> Future[_T]:
            check_thread()
            return super().submit(fn, *args, **kwargs)

    return Pool(workers, name)

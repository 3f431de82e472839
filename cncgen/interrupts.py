"""Signals that wait while what they would interrupt cannot be left by half, and the ends of processes of a pool."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

TYPE_CHECKING = False
if TYPE_CHECKING:
    from concurrent.futures import ProcessPoolExecutor
    from types import FrameType

#: Signals that end a command.
ENDING = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def held() -> Iterator[None]:
    """Hold back the signals that end a command. Processes that are started meanwhile hold them back, too, until `let_through`."""
    if not hasattr(signal, "pthread_sigmask"):  # not a POSIX system
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def let_through() -> None:
    """Take signals again that were held back when this process was started."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)


def follow_driver(tidy: Callable[[], None] = lambda: None) -> None:
    """Let this process of a pool leave Ctrl-C to its driver, and end at once at SIGTERM, or when the driver has ended.

    Args:
        tidy: Called before it ends.
    """
    import threading
    from multiprocessing import connection, parent_process

    def leave(*_: int | FrameType | None) -> None:
        try:
            tidy()
        finally:
            os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, leave)
    parent = parent_process()
    if parent is not None:
        sentinel = parent.sentinel

        def follow() -> None:
            connection.wait([sentinel])
            leave()

        # A pool's process waits for work for ever when its driver was killed. The thread holds signals back: one that it got would not wake
        # the main thread, which alone handles them.
        with held():
            threading.Thread(target=follow, daemon=True).start()
    let_through()


def end_pool(pool: ProcessPoolExecutor) -> None:
    """End the processes of a pool, and give up what they have not done."""
    for process in list((pool._processes or {}).values()):
        process.terminate()
    pool.shutdown(wait=True, cancel_futures=True)

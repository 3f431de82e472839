"""An iterator drawn by a thread of its own, some items ahead: `block_planning` reads and measures beside solving, on two cores."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from queue import Empty, SimpleQueue
from threading import Semaphore, Thread, current_thread
from typing import TypeVar

from cncgen.room import check_thread

Item = TypeVar("Item")

#: How long closing waits for the thread, s: it ends with the item that it draws, which may have to wait for input. So often a
#: thread that gives nothing is looked at: it may have ended for want of memory, before it could say so.
_PATIENCE_S = 2.0


def prefetch(source: Iterable[Item], depth: int) -> Generator[Item, None, None]:
    """Yield the items of an iterable, which are drawn in another thread while the last ones are worked on.

    The order is that of the source, so the result does not depend on timing. An exception of the source is raised here,
    after the items before it. When this generator is closed, or dropped half way, the thread ends with the item that it
    is drawing and closes the source, which is waited for (two seconds at most: the item may have to wait for input).

    Args:
        source: Drawn by that thread alone.
        depth: Items that may wait.

    Raises:
        MemoryError: There is no room for the thread, or it ended without a word.
    """
    done: SimpleQueue[tuple[Item] | BaseException | None] = SimpleQueue()
    room = Semaphore(depth)
    wanted = True

    def draw() -> None:
        try:
            for item in source:
                done.put((item,))
                room.acquire()
                if not wanted:
                    return
        except BaseException as fault:
            done.put(fault)
        else:
            done.put(None)
        finally:
            if isinstance(source, Generator):
                source.close()

    # A daemon: one that waits for more of its input must not keep the process.
    thread = Thread(target=draw, name="prefetch", daemon=True)
    check_thread()
    thread.start()
    try:
        while True:
            try:
                got = done.get(timeout=_PATIENCE_S)
            except Empty:
                if not thread.is_alive() and done.empty():
                    raise MemoryError("a thread ended before it could say why") from None
                continue
            if got is None:
                return
            if isinstance(got, BaseException):
                raise got
            yield got[0]
            room.release()
    finally:
        wanted = False
        room.release()
        # A generator that is collected as garbage may be closed by any thread, by its own too.
        if thread is not current_thread():
            thread.join(_PATIENCE_S)

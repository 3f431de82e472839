"""An iterator drawn in another thread: same items, same faults, no thread left."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from queue import SimpleQueue

import pytest

from cncgen.planner.least_time.prefetch import prefetch


def test_items_come_in_order() -> None:
    assert list(prefetch(range(1000), 3)) == list(range(1000))


def test_a_fault_comes_after_the_items_before_it() -> None:
    def broken() -> Iterator[int]:
        yield 1
        yield 2
        raise KeyError("three")

    items = prefetch(broken(), 5)
    assert [next(items), next(items)] == [1, 2]
    with pytest.raises(KeyError, match="three"):
        next(items)


def test_it_draws_another_thread_and_no_further_than_asked() -> None:
    drawn: list[tuple[int, int]] = []

    def source() -> Iterator[int]:
        for k in range(100):
            drawn.append((k, threading.get_ident()))
            yield k

    with closing(prefetch(source(), 2)) as items:
        assert next(items) == 0
        time.sleep(0.05)
        # One is worked on, two wait, one is in hand.
        assert len(drawn) <= 4
    assert all(thread != threading.get_ident() for _, thread in drawn)


def test_closing_ends_the_thread() -> None:
    closed = threading.Event()

    def endless() -> Iterator[int]:
        try:
            while True:
                yield 0
        finally:
            closed.set()

    items = prefetch(endless(), 2)
    next(items)
    items.close()
    assert closed.wait(5.0)


def test_closing_reaches_a_thread_behind_a_thread() -> None:
    closed = threading.Event()

    def endless() -> Iterator[int]:
        try:
            while True:
                yield 0
        finally:
            closed.set()

    def passed_on() -> Iterator[int]:
        with closing(prefetch(endless(), 2)) as inner:
            yield from inner

    items = prefetch(passed_on(), 2)
    next(items)
    items.close()
    assert closed.wait(5.0)


def test_dropping_it_half_way_waits_for_its_threads() -> None:
    before = threading.active_count()

    def passed_on() -> Iterator[int]:
        with closing(prefetch(iter(int, 1), 2)) as inner:
            yield from inner

    items = prefetch(passed_on(), 2)
    next(items)
    assert threading.active_count() == before + 2
    del items
    assert threading.active_count() == before


#: Plans at the bound of the process's memory; the stack of a thread that has ended is taken again, and nothing else can be had.
AT_THE_BOUND = """
import resource, sys
import cncgen
from cncgen.room import taken

def planned():
    cncgen.sample(cncgen.plan(sys.argv[1], "generic-mill")).collect()

planned()
resource.setrlimit(resource.RLIMIT_DATA, (taken(), taken()))
try:
    planned()
except MemoryError as error:
    sys.exit("a thread needs 16 MiB to begin" not in str(error))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="memory is bounded through Linux's resource limits")
def test_a_thread_without_memory_to_begin_is_not_waited_for() -> None:
    """`Thread.start` waited for ever: a plan at the bound of its memory slept, and took no processor time that a bound counts."""
    program = Path(__file__).parents[3] / "programs" / "butterfly.nc"
    ended = subprocess.run(
        [sys.executable, "-c", AT_THE_BOUND, str(program)], timeout=60, check=False, capture_output=True
    )
    assert ended.returncode == 0, ended.stderr.decode()


def test_a_thread_that_ends_without_a_word_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """As where there is no memory to say what was wrong; its reader waited for ever."""
    from cncgen.planner.least_time import prefetch as module

    class Mute(SimpleQueue):  # type: ignore[type-arg]
        def put(self, *_: object, **__: object) -> None:
            raise MemoryError

    monkeypatch.setattr(module, "SimpleQueue", Mute)
    monkeypatch.setattr(module, "_PATIENCE_S", 0.05)
    monkeypatch.setattr(threading, "excepthook", lambda _: None)
    with pytest.raises(MemoryError, match="ended before it could say why"):
        next(prefetch(iter([1]), 1))

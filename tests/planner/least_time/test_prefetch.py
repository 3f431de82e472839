"""An iterator drawn in another thread: same items, same faults, no thread left."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import closing

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

"""Progress on a terminal: one line, overwritten each second from the first second on; nothing if nobody is there to see it."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from cncgen.cli import messages
from cncgen.files import is_terminal

if TYPE_CHECKING:
    from cncgen.setpoints.record import Setpoints
    from cncgen.sweep.driver import Progress

#: Seconds between two updates, and before the first one.
_INTERVAL_S = 1.0
#: Seconds of work before the first line of `counted_progress`.
_LEAST_S = 2.0


def with_progress(
    chunks: Iterator[Setpoints], name: str, period_s: float, done: Callable[[], float | None] = lambda: None
) -> Iterator[Setpoints]:
    """Hand on chunks of setpoints; show how much motion has gone by, and the time left where that can be said.

    `done` returns the part of the work that is done, 0 to 1; None where nobody knows.
    """
    if messages.is_quiet() or not is_terminal(sys.stderr):
        yield from chunks
        return
    begun = shown = time.monotonic()
    drawn = False
    for chunk in chunks:
        now = time.monotonic()
        if now - shown > _INTERVAL_S:
            seconds = (chunk.first + len(chunk)) * period_s
            part = done()
            left = f", {(now - begun) * (1.0 - part) / part:.0f} s left" if part else ""
            sys.stderr.write(f"\r{name}: {seconds:.1f} s of motion{left}\x1b[K")
            sys.stderr.flush()
            shown, drawn = now, True
        yield chunk
    if drawn:
        sys.stderr.write("\r\x1b[K")


@contextmanager
def counted_progress(what: str) -> Iterator[Callable[[int, int], None]]:
    """Yield a function that shows how many of how many pieces of work are done, and the time left.

    It shows nothing before `_LEAST_S`, and nothing unless standard error is a terminal.
    """
    begun = shown = time.monotonic()
    drawn = False

    def watch(done: int, of: int) -> None:
        nonlocal shown, drawn
        now = time.monotonic()
        if messages.is_quiet() or not is_terminal(sys.stderr) or now - begun < _LEAST_S:
            return
        if now - shown >= _INTERVAL_S:
            left = (now - begun) / done * (of - done)
            sys.stderr.write(f"\r{what} {done} of {of}, {left:.0f} s left\x1b[K")
            sys.stderr.flush()
            shown, drawn = now, True

    yield watch
    if drawn:
        sys.stderr.write("\r\x1b[K")


@contextmanager
def sweep_progress() -> Iterator[Callable[[Progress], None]]:
    """Yield a function that shows how far a sweep is, its rate and the time left; on a terminal alone."""
    shown = time.monotonic()
    drawn = False

    def watch(progress: Progress) -> None:
        nonlocal shown, drawn
        now = time.monotonic()
        if messages.is_quiet() or not is_terminal(sys.stderr) or now - shown < _INTERVAL_S:
            return
        failed = f", {progress.failed} failed" if progress.failed else ""
        text = f"{progress.done} of {progress.total} jobs{failed}, {progress.rate:.3g} a second, {progress.left_s:.0f} s left"
        sys.stderr.write(f"\r{text}\x1b[K")
        sys.stderr.flush()
        shown, drawn = now, True

    yield watch
    if drawn:
        sys.stderr.write("\r\x1b[K")

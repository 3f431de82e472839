"""Progress on a terminal: one line, overwritten each second from the first second on. Without a terminal nothing is printed."""

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


class _Line:
    """The line on a terminal; none is drawn elsewhere, or where the user wants no messages.

    Args:
        least_s: Seconds of work before it is drawn.
    """

    def __init__(self, least_s: float = 0.0) -> None:
        self._begun = self._now = self._shown = time.monotonic()
        self._least_s, self._drawn = least_s, False

    @property
    def seconds(self) -> float:
        """Time from the start of the work to the last `is_due`."""
        return self._now - self._begun

    @property
    def is_seen(self) -> bool:
        """Whether anybody is there to see it."""
        return not messages.is_quiet() and is_terminal(sys.stderr)

    def is_due(self) -> bool:
        """Tell whether it is time for an update."""
        self._now = time.monotonic()
        return self._now - self._shown >= _INTERVAL_S and self.seconds >= self._least_s and self.is_seen

    def show(self, text: str) -> None:
        """Write over the last text."""
        sys.stderr.write(f"\r{text}\x1b[K")
        sys.stderr.flush()
        self._shown, self._drawn = self._now, True

    def erase(self) -> None:
        """Leave an empty line."""
        if self._drawn:
            sys.stderr.write("\r\x1b[K")


def with_progress(
    chunks: Iterator[Setpoints], name: str, period_s: float, done: Callable[[], float | None] = lambda: None
) -> Iterator[Setpoints]:
    """Hand on chunks of setpoints; show how much motion has gone by, and the time left where that is known.

    `done` returns the part of the work that is done, 0 to 1; None where nobody knows.
    """
    line = _Line()
    if not line.is_seen:
        yield from chunks
        return
    for chunk in chunks:
        if line.is_due():
            seconds = (chunk.first + len(chunk)) * period_s
            part = done()
            left = f", {line.seconds * (1.0 - part) / part:.0f} s left" if part else ""
            line.show(f"{name}: {seconds:.1f} s of motion{left}")
        yield chunk
    line.erase()


@contextmanager
def counted_progress(what: str) -> Iterator[Callable[[int, int], None]]:
    """Yield a function that shows how many of how many pieces of work are done, and the time left.

    It shows nothing before `_LEAST_S`, and nothing unless standard error is a terminal.
    """
    line = _Line(_LEAST_S)

    def watch(done: int, of: int) -> None:
        if line.is_due():
            line.show(f"{what} {done} of {of}, {line.seconds / done * (of - done):.0f} s left")

    yield watch
    line.erase()


@contextmanager
def sweep_progress() -> Iterator[Callable[[Progress], None]]:
    """Yield a function that shows how far a sweep is, its rate and the time left; on a terminal alone."""
    line = _Line()

    def watch(progress: Progress) -> None:
        if line.is_due():
            failed = f", {progress.failed} failed" if progress.failed else ""
            line.show(
                f"{progress.done} of {progress.total} jobs{failed}, "
                f"{progress.rate:.3g} a second, {progress.left_s:.0f} s left"
            )

    yield watch
    line.erase()

"""hdf5: a data set a column, named as those of the CSV; period and metadata are attributes of the file (needs h5py)."""

from __future__ import annotations

import atexit
import shutil
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from cncgen.files import Sink
from cncgen.setpoints.columns import INTEGERS, Layout, check_finite
from cncgen.setpoints.packages import needed
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.writers.spooled import spool_of

#: Rows of a chunk of the file, which the last one of each data set fills up: 16 KiB.
_CHUNK_ROWS = 2048
#: Signals whose handlers raise, by name; not every system has each.
_ENDING = ("SIGINT", "SIGTERM", "SIGHUP")


class Writer:
    """Appends rows to data sets that grow."""

    def __init__(self, sink: Sink, layout: Layout) -> None:
        h5py: Any = needed("hdf5")
        self._sink, self._layout, self._rows = sink, layout, 0
        self._spool = _Spool()
        with _signals_held():
            self._file = h5py.File(self._spool, "w", track_order=True)
            # The library writes what it holds at the end of the process, when the spool's methods are gone.
            atexit.register(self._file.close)
            self._file.attrs["period_s"] = layout.period_s
            for key, text in layout.metadata.items():
                self._file.attrs[key] = text
            for name in layout.names:
                kind = np.int64 if name in INTEGERS else np.float64
                self._file.create_dataset(name, (0,), kind, maxshape=(None,), chunks=(_CHUNK_ROWS,))

    def write(self, chunk: Setpoints) -> None:
        """Write the rows of a chunk."""
        matrix = self._layout.matrix(chunk)
        check_finite(matrix, self._layout.names, chunk.first)
        first, self._rows = self._rows, self._rows + len(matrix)
        with _signals_held():
            for name, column in zip(self._layout.names, matrix.T, strict=True):
                self._file[name].resize((self._rows,))
                self._file[name][first:] = column
        if self._spool.fault is not None:
            self._end()

    def close(self) -> None:
        """End the file and send it on."""
        self._end()
        with self._spool.file as file:
            file.seek(0)
            shutil.copyfileobj(file, self._sink, 1 << 20)

    def _end(self) -> None:
        """Close HDF5's side of the file; raise the fault on ours."""
        with _signals_held():
            self._file.close()
        atexit.unregister(self._file.close)
        if self._spool.fault is not None:
            raise self._spool.fault


@contextmanager
def _signals_held() -> Iterator[None]:
    """Hold signals until the block ends: HDF5 loses what a handler raises amid a method of the spool, or ends the process.

    A handler whose signal came meanwhile is called at the end. Other threads than the main one get no signals.
    """
    came: list[int] = []
    handlers: dict[int, Any] = {}
    try:
        for name in _ENDING:
            number = getattr(signal, name, None)
            if number is not None and callable(signal.getsignal(number)):
                handlers[number] = signal.signal(number, lambda number, _: came.append(number))
    except ValueError:  # not the main thread
        handlers.clear()
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for number in came:
            signal.raise_signal(number)


class _Spool:
    """A temporary file of which HDF5 hears no fault: where a disk is full, its library ends the process.

    After the first one, `fault`, nothing is written any more.
    """

    def __init__(self) -> None:
        self.file = spool_of(self)
        self.fault: Exception | None = None
        self._end = 0

    def _try(self, action: Callable[[], int], otherwise: int) -> int:
        if self.fault is None:
            try:
                return action()
            except (OSError, ValueError) as error:  # of a file that is closed, a ValueError
                self.fault = error.with_traceback(None)
        return otherwise

    def seek(self, offset: int, whence: int = 0) -> int:
        """Move to a place."""
        return self._try(lambda: self.file.seek(offset, whence), self._end if whence else offset)

    def tell(self) -> int:
        """Return the place."""
        return self._try(self.file.tell, 0)

    def write(self, data: memoryview) -> int:
        """Write bytes."""
        self._end += len(data)
        return self._try(lambda: self.file.write(data), len(data))

    def readinto(self, buffer: memoryview) -> int:
        """Read bytes."""
        return self._try(lambda: self.file.readinto(buffer), len(buffer))  # type: ignore[attr-defined]

    def read(self, count: int = -1) -> bytes:
        """Read bytes; h5py asks only whether this is there."""
        return self.file.read(count)

    def truncate(self, size: int) -> int:
        """Set the length."""
        return self._try(lambda: self.file.truncate(size), size)

    def flush(self) -> None:
        """Flush the buffer to the system."""
        self._try(lambda: self.file.seek(0, 1), 0)

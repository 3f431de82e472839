"""A temporary file for formats that go back in what is written. It has no name, so that a process that is killed leaves nothing."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from typing import BinaryIO

from cncgen.files import Sink


@contextmanager
def spooled(sink: Sink) -> Iterator[BinaryIO]:
    """Give a file for a with block, which then goes to a sink as a whole."""
    with tempfile.TemporaryFile() as file:
        file.raw.name = "spool"  # type: ignore[attr-defined] # asammdf makes a path of the name, which is the descriptor's number
        yield file
        file.seek(0)
        shutil.copyfileobj(file, sink, 1 << 20)

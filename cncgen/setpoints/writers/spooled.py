"""A temporary file for formats whose libraries write to a path and go back in it."""

from __future__ import annotations

import os
import shutil
import tempfile
from types import TracebackType

from cncgen.files import Sink


class Spool:
    """A file in a temporary folder, which goes to the sink as a whole and is then removed.

    The folder goes with the object, so that a run that ends early leaves nothing.
    """

    def __init__(self, suffix: str) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="cncgen-")
        self.path = os.path.join(self._folder.name, f"setpoints{suffix}")

    def send(self, sink: Sink) -> None:
        """Copy the file to a sink, and remove it."""
        with open(self.path, "rb") as file:
            shutil.copyfileobj(file, sink, 1 << 20)
        self._folder.cleanup()

    def __enter__(self) -> Spool:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._folder.cleanup()

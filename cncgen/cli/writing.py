"""Setpoints to a file or standard output, for commands that make them from something else than a plan."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from itertools import chain

from cncgen.setpoints.record import Setpoints


def write_setpoints(chunks: Iterable[Setpoints], output: str | None, format: str | None) -> int:
    """Write a stream whole or not at all; return its rows. Without a file a terminal receives none.

    Raises:
        UsageError: The format is unknown, or binary output would go to a terminal; what drawing the stream raises.
    """
    from cncgen.diagnostics import Diagnostic, UsageError
    from cncgen.files import is_terminal, open_output
    from cncgen.setpoints.columns import Layout
    from cncgen.setpoints.writers import BINARY, format_of, open_writer

    kind = format_of(output, format)
    if output is None and is_terminal(sys.stdout):
        if kind in BINARY:
            raise UsageError(
                Diagnostic("binary-to-terminal", f"{kind} is binary and is not written to a terminal")
            )
        return sum(len(chunk) for chunk in chunks)
    stream = iter(chunks)
    # The first rows are drawn before anything is opened: what is refused leaves no trace.
    head = next(stream, None)
    if head is None:
        return 0
    rows = 0
    with open_output(output) as sink:
        writer = open_writer(kind, sink, Layout(head.axes, head.period_s))
        for chunk in chain((head,), stream):
            writer.write(chunk)
            rows += len(chunk)
        writer.close()
    return rows

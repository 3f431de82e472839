"""Our canonical calls beside those of the peer, and what must agree."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from cncgen.diagnostics import Diagnostics, Severity
from cncgen.gcode import canon
from cncgen.toolpath.reading import ReadOptions
from trials.generators.gcode_language import write_files
from trials.peer_cases import FILES
from trials.rs274 import Output, Setup, calls_of, run_once, setup_of, without_reset

#: How the peer's errors begin that it finds only at the end of the file; ours stand where the cause is.
FOUND_AT_END = ("EOF in file", "File ended with no percent sign")


@dataclass
class Ours:
    """Our calls without numbering, and the first error."""

    calls: list[str]
    error: str | None
    line: int


def ours(program: Path, setup: Setup | None = None) -> Ours:
    """Interpret a program and return its calls and first error."""
    setup = setup or setup_of(program)
    options = ReadOptions(
        dialect="linuxcnc",
        tool_table=setup.tools,
        parameters=setup.parameters,
        include=setup.include,
        block_delete=setup.block_delete,
        inch_tables=True,  # the peer's machine without an INI file measures in inches
    )
    found = Diagnostics()
    lines = list(canon(program, program.name, options, found))
    errors = [d for d in found if d.severity is Severity.ERROR]
    first = errors[0] if errors else None
    return Ours(
        calls_of(lines), first.render() if first else None, first.span.line if first and first.span else 0
    )


MINUS_ZERO = re.compile(r"-(0\.0+)(?!\d)")


def plain(call: str) -> str:
    """Return a call with minus zero as zero: the sign is the residue of one rounding or another."""
    return MINUS_ZERO.sub(r"\1", call)


def difference(program: Path, mine: Ours, peer: Output) -> str | None:
    """Return what does not agree, or None.

    Without an error all calls agree. With one, the calls before it do, and we report an error in the same line.
    """
    if peer.error is None:
        if mine.error:
            return f"the peer has no error, we have: {mine.error}"
        return _first_difference(mine.calls, peer.calls, whole=True)
    if mine.error is None:
        return f"the peer says {peer.error!r} in {peer.block!r}, we say nothing"
    lines = [
        n for n, text in enumerate(program.read_text().splitlines(), 1) if text.strip() == peer.block.strip()
    ]
    if lines and mine.line not in lines and not peer.error.startswith(FOUND_AT_END):
        return f"the peer's error is in line {lines}, ours in {mine.line}: {mine.error}"
    return _first_difference(mine.calls, peer.calls[: len(peer.calls) - peer.partial], whole=False)


def _first_difference(mine: list[str], peer: list[str], *, whole: bool) -> str | None:
    for index, call in enumerate(peer):
        said = mine[index] if index < len(mine) else "nothing"
        if plain(said) != plain(call):
            return f"call {index + 1}: the peer has {call}, we have {said}"
    if whole and len(mine) > len(peer):
        return f"after the peer's last call we have {mine[len(peer)]}"
    return None


def disagreement(text: str, folder: Path) -> str | None:
    """Return what differs between the two on the text of a random program, or None."""
    program = folder / "random.ngc"
    program.write_text(text)
    write_files(folder)
    setup = Setup(tools=FILES / "mill.tbl")
    peer = run_once(program, setup)
    if peer.error is not None:
        # How many calls of the wrong block come before the error is not known here; no block makes more than these.
        peer.calls = without_reset(peer.calls)
        peer.partial = min(2, len(peer.calls))
    return difference(program, ours(program, setup), peer)

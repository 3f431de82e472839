"""Our canonical calls beside the peer's: what must agree, and the peer's faults that we do not repeat."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rs274 import CALL, Output, Setup, setup_of

from cncgen.diagnostics import Diagnostics, Severity
from cncgen.gcode import canon
from cncgen.toolpath.reading import ReadOptions

#: Programs where we differ on purpose, and why.
PEER_FAULTS: dict[str, str] = {
    "cycle_g74_planes": "the peer mixes up the axes of the feed moves of G74 outside of G17",
    "cycle_g74_repeats_refused": "the manual has L of G74; the peer refuses it",
    "cycle_g84_planes": "the peer mixes up the axes of the feed moves of G84 outside of G17",
    "comp_in_block_of_tool_change": "the peer compensates with the tool that M6 of the same block took away",
    "comp_l_out_of_range": "the manual has orientations 0 to 9; the peer takes L10 and goes on with some other one",
}


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
    calls = [match[1] for line in lines if (match := CALL.match(line))]
    return Ours(calls, first.render() if first else None, first.span.line if first and first.span else 0)


def plain(call: str) -> str:
    """Return a call with minus zero as zero: the sign is the residue of one rounding or another."""
    return call.replace("-0.0000,", "0.0000,").replace("-0.0000)", "0.0000)").replace("-0.0000 ", "0.0000 ")


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
    if lines and mine.line not in lines:
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

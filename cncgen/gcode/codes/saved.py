"""M70 to M73: save and restore the modal state."""

from __future__ import annotations

from collections.abc import Callable

from cncgen.gcode.block import Block
from cncgen.gcode.codes.table import Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.state.modal import Stage
from cncgen.records import dataclass
from cncgen.toolpath.record import PathMode

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from cncgen.gcode.interpreter import Interpreter


@dataclass(frozen=True, slots=True)
class Saved:
    """The modes that M72 compares and brings back, without the motion mode (LinuxCNC manual, "M72")."""

    inches: bool
    feed_mode: int
    feed: float
    speed: float
    constant_surface: bool
    direction: int
    plane: int
    compensation: int
    absolute: bool
    arc_absolute: bool
    diameter: bool
    retract_old: bool
    system: int
    tool_length: bool
    g92_on: bool
    path: tuple[PathMode, float | None, float | None]
    mist: bool
    flood: bool
    feed_override: bool
    speed_override: bool
    adaptive_feed: bool
    feed_hold: bool


def snapshot(ip: Interpreter) -> Saved:
    """Return the modal state."""
    state = ip.state
    made: dict[str, Any] = {
        "constant_surface": state.constant_surface is not None,
        "tool_length": any(state.tool_offset),
        "path": (state.path_mode, state.tolerance, state.naive),
    }
    return Saved(**{name: made[name] if name in made else getattr(state, name) for name in Saved.__slots__})


_COOLANTS, _OVERRIDES = ("mist", "flood"), ("feed_override", "speed_override", "adaptive_feed", "feed_hold")
_Codes = dict[tuple[str, int | None], tuple[str, int]]


def restore(ip: Interpreter, saved: Saved) -> None:
    """Restore the differences, as LinuxCNC does: the units in a block of their own, all codes and words in another.

    So a tool length comes back as G43, of the tool in the spindle, and compensation as G41 or G42 with its diameter.
    """
    here = ip.sink.block
    # The peer's calls have no N word here.
    line = 0 if ip.options.stand_alone else here.line

    def run(words: dict[str, float], g: list[int], m: list[int]) -> None:
        ip.execute(Block(words, tuple(g), tuple(m), None, here.source, line, here.offset))

    now = snapshot(ip)
    codes = {row.restores: (row.letter, row.number) for row in ip.codes.values() if row.restores[0]}
    if now.inches != saved.inches:
        run({}, [codes["inches", saved.inches][1]], [])
    changed = {name for name in Saved.__slots__ if getattr(now, name) != getattr(saved, name)}
    found = [
        codes.get((name, saved.path[0] if name == "path" else getattr(saved, name)), ("", 0))
        for name in changed - {"inches", *_COOLANTS, *_OVERRIDES}
    ]
    g, m = ([number for letter, number in found if letter == wanted] for wanted in "GM")
    words = _words(ip, now, saved, changed)
    if g or m or words:
        run(words, g, m)
    _restore_coolant(saved, changed, codes, run)
    _restore_overrides(ip, saved, changed, codes, run)
    ip.sink.block = here


def _words(ip: Interpreter, now: Saved, saved: Saved, changed: set[str]) -> dict[str, float]:
    """Return the words of the block that brings a state back."""
    # The peer writes the block with one decimal of F and none of S.
    rough = ip.options.stand_alone
    words = {}
    if "feed" in changed and now.feed_mode != 93:
        words["f"] = round(saved.feed, 1) if rough else saved.feed
    if "speed" in changed:
        words["s"] = round(saved.speed, 0) if rough else saved.speed
    if "path" in changed and saved.path[0] is PathMode.CONTINUOUS:
        words |= {
            letter: value for letter, value in zip("pq", saved.path[1:], strict=True) if value is not None
        }
    return words


Run = Callable[[dict[str, float], list[int], list[int]], None]


def _restore_coolant(saved: Saved, changed: set[str], codes: _Codes, run: Run) -> None:
    if changed.isdisjoint(_COOLANTS):
        return
    on = [name for name in _COOLANTS if getattr(saved, name)]
    for name in on or _COOLANTS[:1]:
        run({}, [], [codes[name, bool(on)][1]])


def _restore_overrides(ip: Interpreter, saved: Saved, changed: set[str], codes: _Codes, run: Run) -> None:
    """Bring back M50 to M53; the peer switches none of them off, and mistakes M50 and M51."""
    if ip.options.stand_alone:
        if "feed_override" in changed:
            run(
                {},
                [],
                [codes["overrides", True][1] if saved.feed_override else codes["speed_override", None][1]],
            )
        changed = {name for name in _OVERRIDES[2:] if name in changed and getattr(saved, name)}
    for name in _OVERRIDES:
        if name in changed:
            run({"p": float(getattr(saved, name))}, [], [codes[name, None][1]])


def save(ip: Interpreter, block: Block) -> None:
    """M70: save."""
    ip.frame().saved = snapshot(ip)


def forget(ip: Interpreter, block: Block) -> None:
    """M71: discard the saved state."""
    ip.frame().saved = None


def bring_back(ip: Interpreter, block: Block) -> None:
    """M72: restore."""
    saved = ip.frame().saved
    if not isinstance(saved, Saved):
        raise BlockError("nothing-saved", "M72 restores a state, and none is saved", "M72")
    restore(ip, saved)


def save_for_sub(ip: Interpreter, block: Block) -> None:
    """M73: save, and restore when the subroutine ends."""
    frame = ip.frame()
    frame.saved, frame.restore = snapshot(ip), True


CODES = tuple(
    Code("M", number, "save", Stage.SAVE, run, text, dialects=("linuxcnc",), without="others")
    for number, run, text in (
        (700, save, "save the modal state"),
        (710, forget, "forget the saved modal state"),
        (720, bring_back, "restore the modal state"),
        (730, save_for_sub, "save the modal state until the subroutine ends"),
    )
)

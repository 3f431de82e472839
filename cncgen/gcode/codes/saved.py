"""M70 to M73: save and restore the modal state."""

from __future__ import annotations

from collections.abc import Callable

from cncgen.gcode.block import Block
from cncgen.gcode.codes.table import Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.state.modal import SYSTEM_CODES, Stage
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


_PATH_CODES = {PathMode.EXACT_PATH: 610, PathMode.EXACT_STOP: 611, PathMode.CONTINUOUS: 640}
#: G codes that restore the differences, by field of `Saved`.
_CODES: dict[str, Callable[[Any], int]] = {
    "feed_mode": lambda mode: mode * 10,
    "constant_surface": lambda on: 960 if on else 970,
    "plane": lambda plane: plane if plane > 100 else plane * 10,
    "compensation": lambda side: side * 10,
    "absolute": lambda on: 900 if on else 910,
    "arc_absolute": lambda on: 901 if on else 911,
    "diameter": lambda on: 70 if on else 80,
    "retract_old": lambda on: 980 if on else 990,
    "system": lambda system: SYSTEM_CODES[system - 1],
    "tool_length": lambda on: 430 if on else 490,
    "g92_on": lambda on: 923 if on else 922,
    "path": lambda path: _PATH_CODES[path[0]],
}


_OVERRIDES = {"feed_override": 500, "speed_override": 510, "adaptive_feed": 520, "feed_hold": 530}


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
    if now.inches != saved.inches:
        run({}, [200 if saved.inches else 210], [])
    changed = {name for name in Saved.__slots__ if getattr(now, name) != getattr(saved, name)}
    g = [code(getattr(saved, name)) for name, code in _CODES.items() if name in changed]
    m = [{1: 30, -1: 40, 0: 50}[saved.direction]] if "direction" in changed else []
    words = _words(ip, now, saved, changed)
    if g or m or words:
        run(words, g, m)
    _restore_coolant(saved, changed, run)
    _restore_overrides(ip, saved, changed, run)
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


def _restore_coolant(saved: Saved, changed: set[str], run: Run) -> None:
    if changed.isdisjoint(("mist", "flood")):
        return
    if not (saved.mist or saved.flood):
        run({}, [], [90])
    if saved.mist:
        run({}, [], [70])
    if saved.flood:
        run({}, [], [80])


def _restore_overrides(ip: Interpreter, saved: Saved, changed: set[str], run: Run) -> None:
    """Bring back M50 to M53; the peer switches none of them off, and mistakes M50 and M51."""
    if ip.options.stand_alone:
        if "feed_override" in changed:
            run({}, [], [480 if saved.feed_override else 510])
        changed = {
            name for name in ("adaptive_feed", "feed_hold") if name in changed and getattr(saved, name)
        }
    for name, code in _OVERRIDES.items():
        if name in changed:
            run({"p": float(getattr(saved, name))}, [], [code])


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

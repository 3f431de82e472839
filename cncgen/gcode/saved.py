"""M70 to M73: save and restore the modal state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from cncgen.gcode.block import Block
from cncgen.gcode.codes import Code
from cncgen.gcode.errors import BlockError
from cncgen.gcode.modal import Stage
from cncgen.toolpath.record import PathMode

if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

_PATH_CODES = {PathMode.EXACT_PATH: 610, PathMode.EXACT_STOP: 611, PathMode.CONTINUOUS: 640}


@dataclass(frozen=True, slots=True)
class Saved:
    """Codes and words that bring a modal state back."""

    inches: bool
    feed: float
    speed: float
    plane: int
    path_mode: PathMode
    tolerance: float | None
    naive: float | None
    system: int
    absolute: bool
    arc_absolute: bool
    diameter: bool
    retract_old: bool
    feed_mode: int
    direction: int
    mist: bool
    flood: bool
    feed_override: bool
    speed_override: bool
    motion: int


def snapshot(ip: Interpreter) -> Saved:
    """Return the modal state."""
    state = ip.state
    return Saved(*(getattr(state, name) for name in Saved.__slots__))


def restore(ip: Interpreter, saved: Saved) -> None:
    """Bring back what differs, code by code, as a program would."""
    state = ip.state
    now = snapshot(ip)

    def run(letter: str, number: int, words: dict[str, float] | None = None) -> None:
        block = Block(
            words or {}, source=ip.sink.block.source, line=ip.sink.block.line, offset=ip.sink.block.offset
        )
        ip.codes[letter, number].run(ip, block)

    if now.inches != saved.inches:
        run("G", 200 if saved.inches else 210)
    if now.feed_mode != saved.feed_mode:
        run("G", saved.feed_mode * 10)
    if now.feed != saved.feed or now.feed_mode != saved.feed_mode:
        run("F", 0, {"f": saved.feed})
    if now.speed != saved.speed:
        run("S", 0, {"s": saved.speed})
    if now.plane != saved.plane:
        run("G", saved.plane if saved.plane > 100 else saved.plane * 10)
    if (now.path_mode, now.tolerance, now.naive) != (saved.path_mode, saved.tolerance, saved.naive):
        words = {k: v for k, v in (("p", saved.tolerance), ("q", saved.naive)) if v is not None}
        run("G", _PATH_CODES[saved.path_mode], words)
    if now.system != saved.system:
        run("G", [540, 550, 560, 570, 580, 590, 591, 592, 593][saved.system - 1])
    for name, on, off in (
        ("absolute", 900, 910),
        ("arc_absolute", 901, 911),
        ("diameter", 70, 80),
        ("retract_old", 980, 990),
    ):
        if getattr(now, name) != getattr(saved, name) and ("G", on) in ip.codes:
            run("G", on if getattr(saved, name) else off)
    if now.direction != saved.direction:
        run("M", {1: 30, -1: 40, 0: 50}[saved.direction])
    _restore_coolant(now, saved, run)
    if now.feed_override != saved.feed_override:
        run("M", 500, {"p": float(saved.feed_override)})
    if now.speed_override != saved.speed_override:
        run("M", 510, {"p": float(saved.speed_override)})
    state.motion = saved.motion


def _restore_coolant(now: Saved, saved: Saved, run: object) -> None:
    assert callable(run)
    if (now.mist, now.flood) == (saved.mist, saved.flood):
        return
    if not (saved.mist and saved.flood):
        run("M", 90)
    if saved.mist:
        run("M", 70)
    if saved.flood:
        run("M", 80)


def save(ip: Interpreter, block: Block) -> None:
    """M70: save."""
    ip.frame().saved = snapshot(ip)


def forget(ip: Interpreter, block: Block) -> None:
    """M71: forget what was saved."""
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


CODES = (
    Code("M", 700, "save", Stage.SAVE, save, "save the modal state"),
    Code("M", 710, "save", Stage.SAVE, forget, "forget the saved modal state"),
    Code("M", 720, "save", Stage.SAVE, bring_back, "restore the modal state"),
    Code("M", 730, "save", Stage.SAVE, save_for_sub, "save the modal state until the subroutine ends"),
)

"""From technology to feed and spindle speed: the values that count, and their plausible range."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from cncgen.stepnc.model import CuttingTool, Technology

#: Called with the entity, a code and a text.
Warn = Callable[[int, str, str], None]

#: Spindle speeds beyond this (rev/s) were hardly meant: 200,000 rev/min.
MAX_PLAUSIBLE_SPINDLE = 200_000 / 60
#: Cutting speeds beyond this (mm/s) were hardly meant in m/s: 10 m/s are 600 m/min.
MAX_PLAUSIBLE_CUTTING_SPEED = 10_000.0
#: Cutting speeds below this (mm/s) are slower than any tool cuts: 0.3 m/min.
MIN_PLAUSIBLE_CUTTING_SPEED = 5.0
#: Feeds a turn beyond so many diameters of the tool were hardly meant.
MAX_PLAUSIBLE_BITE = 0.5
#: Feeds a turn below this (mm) cut no chips, and feeds below this (mm/s) take hours: they were hardly meant.
MIN_PLAUSIBLE_BITE = 0.001
MIN_PLAUSIBLE_FEED = 0.1


class SpeedRules(NamedTuple):
    """The meaning of the speeds in files whose writers depart from the standard.

    Attributes:
        per_minute: Cutting speeds are per minute, and count before spindle speeds.
        by_hand: The tool's hand tells the sense of rotation, not the sign of the spindle speed.
    """

    per_minute: bool = False
    by_hand: bool = False

    def applied(self, technology: Technology, tool: CuttingTool | None) -> Technology:
        """Return a technology of the file as the standard would have it."""
        if self.per_minute and technology.cutting_speed is not None:
            counts = tool is not None and tool.diameter is not None
            technology = replace(
                technology,
                cutting_speed=technology.cutting_speed / 60.0,
                spindle=None if counts else technology.spindle,
            )
        if self.by_hand and technology.spindle is not None:
            turn = 1.0 if tool is not None and tool.left_handed else -1.0
            technology = replace(technology, spindle=turn * abs(technology.spindle))
        return technology


def completed(technology: Technology, operation: Technology | None) -> Technology:
    """Return a toolpath's technology with the feed and the speed of its operation where it has none of its own."""
    if operation is None:
        return technology
    if technology.feed is None and technology.feed_per_rev is None and technology.feed_per_tooth is None:
        technology = replace(
            technology,
            feed=operation.feed,
            feed_per_rev=operation.feed_per_rev,
            feed_per_tooth=operation.feed_per_tooth,
        )
    if technology.spindle is None and technology.cutting_speed is None:
        technology = replace(
            technology,
            spindle=operation.spindle,
            cutting_speed=operation.cutting_speed,
            max_spindle=operation.max_spindle,
        )
    return technology


class Speeds(NamedTuple):
    """The values set on the machine: feed in mm/s (None: none given), spindle sense (1 clockwise) and rev/min (None alike)."""

    feed: float | None
    direction: int
    rpm: float | None


def speeds(technology: Technology, tool: CuttingTool | None, ratio: float, warn: Warn) -> Speeds:
    """Return feed and spindle of a technology.

    The spindle speed counts before the cutting speed, the feed before the feed per revolution and that before the
    feed per tooth (the standards let only one of each be given; real files have several).
    """
    spindle = _spindle(technology, tool, warn)
    if spindle is None:
        direction, rpm = 0, None
    else:
        rpm = abs(spindle) * 60.0
        direction = 0 if spindle == 0 else (1 if spindle < 0 else -1)
    feed = technology.feed
    if feed is not None:
        _check_feed(technology, feed, rpm, tool, warn)
    if feed is None and technology.feed_per_rev is not None and rpm:
        feed = technology.feed_per_rev * rpm / 60.0
    if feed is None and technology.feed_per_tooth is not None and rpm:
        if tool is None or not tool.teeth:
            warn(
                technology.ident, "stepnc-teeth", "the feed is per tooth, and the tool has no number of teeth"
            )
        else:
            feed = technology.feed_per_tooth * tool.teeth * rpm / 60.0
    return Speeds(None if feed is None else feed * ratio, direction, rpm)


def _check_feed(
    technology: Technology, feed: float, rpm: float | None, tool: CuttingTool | None, warn: Warn
) -> None:
    """Warn of a feed (mm/s) that was hardly meant: too much in a turn of the tool, or so little that nothing is cut."""
    slow = feed < MIN_PLAUSIBLE_FEED or (rpm and feed * 60.0 / rpm < MIN_PLAUSIBLE_BITE)
    if slow and feed > 0:
        text = f"a feed of {feed:g} mm/s is {feed * 60:g} mm/min"
        text += f", {feed * 60.0 / rpm:.3g} mm a turn" if rpm else ""
        warn(
            technology.ident,
            "stepnc-feed-unit",
            f"{text}; is it meant in m/s (ISO 14649), or per revolution?",
        )
    if not rpm:
        return
    per_turn = feed * 60.0 / rpm
    diameter = tool.diameter if tool is not None else None
    if diameter is not None and per_turn > MAX_PLAUSIBLE_BITE * diameter:
        text = (
            f"the feed is {per_turn:.3g} mm a turn of a tool of {diameter:g} mm; is it meant per revolution?"
        )
        warn(technology.ident, "stepnc-feed-unit", text)


def check_cutting_speed(technology: Technology, warn: Warn) -> None:
    """Warn of a cutting speed that was hardly meant."""
    cutting = technology.cutting_speed
    if cutting is None or technology.spindle is not None:
        return
    cutting = abs(cutting)
    if cutting > MAX_PLAUSIBLE_CUTTING_SPEED:
        text = f"a cutting speed of {cutting / 1000:g} m/s is {cutting * 0.06:.0f} m/min; --speed-unit m/min reads it so"
        warn(technology.ident, "stepnc-speed-unit", text)
    elif 0 < cutting < MIN_PLAUSIBLE_CUTTING_SPEED:
        text = f"a cutting speed of {cutting:g} mm/s is {cutting * 0.06:.3g} m/min; is it meant in m/s?"
        warn(technology.ident, "stepnc-speed-unit", text)


def _spindle(technology: Technology, tool: CuttingTool | None, warn: Warn) -> float | None:
    """Return the spindle speed, rev/s with the sign of ISO 14649."""
    cutting, given = technology.cutting_speed, technology.spindle
    diameter = tool.diameter if tool else None
    from_cutting = None
    if cutting is not None and tool and diameter:
        from_cutting = technology.spindle_at(diameter, tool.left_handed)
    if given is not None:
        if cutting is not None:
            text = "cutspeed and spindle are both given; the spindle speed counts"
            if from_cutting is not None:
                text += f" ({abs(given) * 60:.1f} rev/min; the cutting speed would be {abs(from_cutting) * 60:.1f})"
            warn(technology.ident, "stepnc-speed-both", text)
        if abs(given) > MAX_PLAUSIBLE_SPINDLE:
            text = f"a spindle speed of {given:g} rev/s is {abs(given) * 60:.0f} rev/min; is it meant per minute?"
            warn(technology.ident, "stepnc-speed-unit", text)
        if given > 0 and tool is not None and not tool.left_handed:
            text = f"a spindle speed of +{given:g} rev/s turns against the clock, and the tool is not left-handed"
            text += "; --spindle-sign tool turns it by the tool's hand"
            warn(technology.ident, "stepnc-spindle-sign", text)
        return given
    if cutting is None:
        return None
    check_cutting_speed(technology, warn)
    if from_cutting is None:
        warn(
            technology.ident,
            "stepnc-speed-diameter",
            "a cutting speed is given, and the tool has no diameter",
        )
    return from_cutting

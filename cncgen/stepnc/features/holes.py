"""Round holes: drilling with reduced ends, centre drilling, countersinking, pecking, boring, reaming, tapping."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cncgen.stepnc.features.job import Job, Moves
from cncgen.stepnc.model import CutterPath, CuttingTool, Technology

#: Smaller differences of the angles of a drill's point and of the bottom do not count, rad.
SAME_TIP = math.radians(0.5)


def tip_length(tool: CuttingTool) -> float:
    """Return how far a drill's point stands out below its full diameter, mm.

    The cone of half a diameter under the tip angle a (from the plane across the axis), and what the edge radius r adds
    between the cone and the edge at the circumference angle b: r cos b / tan((90° + a + b) / 2), as NIST's interpreter.
    """
    if tool.tip_angle is None or tool.diameter is None:
        return 0.0
    tip = tool.diameter / 2 * math.tan(tool.tip_angle)
    if tool.edge_radius:
        around = tool.circumference_angle or 0.0
        half = (math.pi / 2 + tool.tip_angle + around) / 2
        tip += tool.edge_radius / math.tan(half) * math.cos(around)
    return tip


#: Diameters and depths closer than this are equal, mm.
SAME_SIZE = 1e-3
#: More steps of one hole than this are a slip of the pen.
MAX_STEPS = 100_000
#: Turns of a milled thread, at most.
MAX_TURNS = 10_000
#: Operations that give the hole the diameter of their tool.
_SIZING = ("boring", "reaming")
#: Finest pitch of ISO 261, mm (M1 x 0.2), the finest in diameters (M300 x 4), and what is coarser than trapezoidal threads.
_FINEST, _FINE, _COARSE = 0.2, 0.012, 0.5


def check_hole(job: Job) -> None:
    """Report a tool that is larger than its hole, and a depth that is deeper than the hole or the raw piece.

    A tool of boring or reaming that is smaller than the hole leaves its wall uncut, which is a warning; a drill may be the
    first of several.

    Raises:
        Skip: where the tool would cut what is to stay.
    """
    hole, tool, kind = job.shape.diameter, job.tool.diameter, job.operation.kind
    if (
        hole is not None
        and tool is not None
        and kind not in ("counter sinking", "center drilling", "tapping")
    ):
        narrowest = hole - 2 * (job.shape.depth or 0.0) * math.tan(job.shape.slope)
        fits = hole if job.shape.slope <= 0 else max(narrowest, 0.0)
        if tool > fits + SAME_SIZE:
            text = f"the tool has {tool:g} mm and the hole {fits:g} mm; the tool must not be larger than the hole"
            raise job.fault("stepnc-tool-size", text)
        if tool < hole - SAME_SIZE and kind in _SIZING:
            text = f"the tool has {tool:g} mm and the hole {hole:g} mm; a ring {(hole - tool) / 2:g} mm wide stays uncut"
            job.warn("stepnc-uncut", text)
    _check_depth(job)


def _asked(job: Job) -> float:
    """Return how deep the full diameter is to go, mm, 0 where cutting_depth does not say.

    Some writers measure cutting_depth at the tip: it then is the hole's depth and the length of the point.
    """
    depth, asked = job.shape.depth, job.value("cutting_depth", 0.0)
    if job.operation.kind not in ("drilling", "multistep drilling") or depth is None:
        return asked
    tip = tip_length(job.tool)
    return depth if tip > SAME_SIZE and abs(asked - depth - tip) < SAME_SIZE else asked


def _check_depth(job: Job) -> None:
    """Raise `Skip` where the full diameter goes below the end of a blind hole, or below the raw piece with no overcut asked."""
    depth, asked = job.shape.depth, _asked(job)
    if depth is None or job.operation.kind == "counter sinking":
        return
    given = job.value("cutting_depth", 0.0)
    if given != asked:
        text = f"cutting_depth is {given:g} mm, the hole's {depth:g} mm and the drill's point; it is taken as measured at the tip"
        job.warn("stepnc-depth", text)
    over = job.value("overcut_length", 0.0)
    reach = asked + over if asked > 0 else depth + over
    if job.shape.bottom not in ("", "through") and reach > depth + SAME_SIZE:
        text = f"the tool goes {reach:g} mm deep (cutting_depth and overcut_length), and the hole ends at {depth:g} mm"
        raise job.fault("stepnc-depth", text)
    low = None if job.raw is None else -job.raw[0]
    if low is not None and asked > low + SAME_SIZE:
        text = f"cutting_depth is {asked:g} mm, and the raw piece ends {low:g} mm below the top of the hole"
        raise job.fault("stepnc-depth", text)
    if asked > depth + SAME_SIZE:
        text = f"cutting_depth is {asked:g} mm, and the hole is {depth:g} mm deep; overcut_length is the way beyond"
        job.warn("stepnc-depth", text)


def _begin(job: Job) -> Moves:
    start = job.operation.start_point
    x, y = (0.0, 0.0) if start is None else (float(start[0]), float(start[1]))
    return Moves(job.operation.ident, np.array([x, y, job.retract]))


def _bottom(job: Job) -> float:
    """Return how deep the full diameter goes, mm."""
    depth = _asked(job)
    if not depth > 0:
        depth = job.depth
    return depth + job.value("overcut_length", 0.0)


def _scaled(technology: Technology, cut: float, feed: float) -> Technology:
    """Return a technology with spindle (or cutting speed) and feed multiplied by ratios."""
    return replace(
        technology,
        feed=None if technology.feed is None else technology.feed * feed,
        feed_per_tooth=None
        if technology.feed_per_tooth is None
        else technology.feed_per_tooth * feed / (cut or 1.0),
        spindle=None if technology.spindle is None else technology.spindle * cut,
        cutting_speed=None if technology.cutting_speed is None else technology.cutting_speed * cut,
    )


def _lift(job: Job, moves: Moves) -> None:
    """Wait at the bottom for the given time, and go up at the feed times feed_on_retract; the spindle does not change."""
    moves.dwell(job.value("dwell_time_bottom", 0.0))
    technology = _scaled(job.technology, 1.0, _ratio(job))
    moves.at(
        replace(technology, spindle=None, cutting_speed=None) if technology.feed is not None else technology
    )
    moves.height(job.retract)


def drill(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths of drilling (DRILLING with a DRILLING_TYPE_STRATEGY, ISO 14649-11).

    A DRILLING_TYPE_STRATEGY reduces cutting speed and feed down to depth_of_start and again from depth_of_end on,
    depths of the tip beyond which the point stands out.
    """
    moves, technology = _begin(job), job.technology
    tip = tip_length(job.tool)
    _check_point(job, tip)
    bottom = -(_bottom(job) + tip)
    start, end = job.strategy_value("depth_of_start", 0.0), job.strategy_value("depth_of_end", 0.0)
    reduced = job.strategy_value
    if start > 0:
        moves.at(
            _scaled(technology, reduced("reduced_cut_at_start", 1.0), reduced("reduced_feed_at_start", 1.0))
        )
        moves.height(max(-(start + tip), bottom))
    moves.at(technology)
    if end > 0:
        if -(end + tip) < moves.position[2]:
            moves.height(max(-(end + tip), bottom))
        moves.at(_scaled(technology, reduced("reduced_cut_at_end", 1.0), reduced("reduced_feed_at_end", 1.0)))
    if bottom < moves.position[2]:
        moves.height(bottom)
    _lift(job, moves)
    return moves.paths()


def _check_point(job: Job, tip: float) -> None:
    """Warn of a point that is not the bottom's: below a flat one, of another angle, or of another radius."""
    kind, wanted, angle = job.shape.bottom, job.shape.bottom_angle, job.tool.tip_angle
    if kind.startswith("flat") and tip > 1e-6:
        job.warn(
            "stepnc-tip", f"the drill's point goes {tip:.3f} mm below the full diameter, the bottom is {kind}"
        )
    elif kind == "spherical":
        job.warn("stepnc-tip", "a drill makes no spherical bottom; mill it with a rounded tool")
    elif kind == "conical" and wanted is not None and angle is not None:
        has = math.pi - 2 * angle
        if abs(has - wanted) > SAME_TIP:
            text = f"the drill's point has {math.degrees(has):.1f} degrees, the bottom {math.degrees(wanted):.1f}"
            job.warn("stepnc-tip", text)


def centre_drill(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths of centre drilling (CENTER_DRILLING, ISO 14649-11): the tip goes to the cutting depth."""
    depth = job.value("cutting_depth", 0.0)
    if not depth > 0:
        raise job.fault("stepnc-missing", "centre drilling needs cutting_depth")
    moves = _begin(job)
    moves.height(-depth)
    _lift(job, moves)
    return moves.paths()


def countersink(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths of countersinking (COUNTER_SINKING, ISO 14649-11).

    It goes to the cutting depth, else so deep that the cone has the diameter.
    """
    depth = job.value("cutting_depth", 0.0)
    if not depth > 0:
        angle, diameter = job.tool.tip_angle, job.shape.diameter
        if angle is None or diameter is None:
            text = "countersinking needs cutting_depth, or the tool's tip angle and the feature's diameter"
            raise job.fault("stepnc-missing", text)
        depth = diameter / 2 * math.tan(angle)
    moves = _begin(job)
    moves.height(-depth)
    _lift(job, moves)
    return moves.paths()


def multistep(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths of pecking (MULTISTEP_DRILLING, ISO 14649-11): first_depth, then depth_of_step each.

    Between the steps the tool goes up by retract_distance to break the chip; where that is not positive, out to the
    retract plane and back in rapid to where it was, less the distance of safety.
    """
    first, each = job.value("first_depth", 0.0), job.value("depth_of_step", 0.0)
    bottom = -(_bottom(job) + tip_length(job.tool))
    first = first if first > 0 else each
    if not first > 0 or not (each > 0 or -bottom <= first):
        raise job.fault("stepnc-missing", "multistep drilling needs first_depth or depth_of_step")
    if each > 0 and (-bottom - first) / each > MAX_STEPS:
        raise job.fault(
            "stepnc-geometry",
            f"depth_of_step {each:g} mm makes {(-bottom - first) / each:.0f} steps; at most {MAX_STEPS} are made",
        )
    back, wait = job.value("retract_distance", 0.0), job.value("dwell_time_step", 0.0)
    moves = _begin(job)
    level = max(-first, bottom)
    while True:
        moves.height(level)
        if level <= bottom:
            break
        moves.dwell(wait)
        if back > 0:
            moves.height(level + back)
        else:
            moves.height(job.retract, rapid=True)
            moves.height(min(level + 1.0, job.retract), rapid=True)
        level = max(level - each, bottom)
    _lift(job, moves)
    return moves.paths()


def bore(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths of BORING and REAMING (ISO 14649-11).

    The tool goes down and up at the feed, with the spindle stopped at the bottom if asked.
    """
    if job.value("depth_of_testcut", 0.0) > 0:
        job.warn("stepnc-testcut", "the test cut is left out: nothing here measures")
    moves = _begin(job)
    moves.height(-_bottom(job))
    if job.operation.values.get("spindle_stop_at_bottom") is True:
        moves.dwell(job.value("dwell_time_bottom", 0.0))
        feed = job.technology.feed
        moves.stop_spindle(replace(job.technology, feed=None if feed is None else feed * _ratio(job)))
        moves.height(job.retract)
    else:
        _lift(job, moves)
    return moves.paths()


def _ratio(job: Job) -> float:
    """Return the factor of the feed on the way out; some files have 0, which stands for 1."""
    ratio = job.value("feed_on_retract", 1.0)
    if ratio > 0:
        return ratio
    job.warn("stepnc-ratio", f"feed_on_retract is {ratio:g}; the tool goes out at the feed")
    return 1.0


def _pitch(job: Job) -> float | None:
    """Return the pitch of the tool, else that of the thread, mm, or None."""
    thread = job.shape.pitch
    if job.tool.pitch is not None and thread is not None and abs(job.tool.pitch - abs(thread)) > 1e-3:
        text = f"the tool has a pitch of {job.tool.pitch:g} mm and the thread one of {abs(thread):g} mm"
        raise job.fault("stepnc-pitch", text)
    return job.tool.pitch if job.tool.pitch is not None or thread is None else abs(thread)


def mill_thread(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths of a thread that is milled: THREAD_DRILLING, or a milling operation on a thread (ISO 14649-11).

    The tool goes onto the thread by half a circle from the middle of the hole, along a helix of the thread's pitch, and back to
    the middle: against the clock (climb), so upwards for a right-handed thread and downwards for a left-handed one, if
    `helical_movement_on_forward` does not say the way.
    """
    pitch, major, minor = _pitch(job), job.shape.thread, job.shape.diameter
    if pitch is None or not pitch > 0:
        raise job.fault("stepnc-missing", "milling a thread needs the pitch of the thread or tool")
    if major is None or minor is None or not major > minor - SAME_SIZE:
        raise job.fault("stepnc-missing", "milling a thread needs major_diameter, above that of its hole")
    if 2 * job.radius >= min(minor + SAME_SIZE, major):
        text = f"a tool of {2 * job.radius:g} mm does not fit the hole of {minor:g} mm before a thread of {major:g} mm"
        raise job.fault("stepnc-tool-size", text)
    depth = _bottom(job)
    if depth / pitch > MAX_TURNS:
        raise job.fault("stepnc-geometry", f"{depth / pitch:.0f} turns of {pitch:g} mm are too many")
    moves, aside, lead = _begin(job), major / 2 - job.radius, pitch / 4
    moves.at(job.technology)
    x, y = (float(v) for v in moves.position[:2])
    left = (job.shape.pitch or 1.0) < 0
    forward = job.operation.values.get("helical_movement_on_forward")
    down = left if forward is None else forward is True
    rise = -(depth - 2 * lead) if down else depth - 2 * lead
    if rise * (-1 if down else 1) <= 0:
        raise job.fault(
            "stepnc-geometry", f"a thread {depth:g} mm deep is shorter than half a turn of {pitch:g} mm"
        )
    sign = math.copysign(1.0, rise)
    # A right-handed thread rises against the clock.
    clockwise = down != left
    turn = -1.0 if clockwise else 1.0
    sweep = 2 * math.pi * abs(rise) / pitch
    z = 0.0 if down else -depth
    moves.height(z)
    begin = np.array([x + aside, y, z + sign * lead])
    moves.arc(begin, np.array([x + aside / 2, y]), clockwise, math.pi)
    angle = turn * sweep
    end = np.array([x + aside * math.cos(angle), y + aside * math.sin(angle), z + sign * lead + rise])
    moves.arc(end, np.array([x, y]), clockwise, sweep)
    middle = np.array([(x + end[0]) / 2, (y + end[1]) / 2])
    moves.arc(np.array([x, y, end[2] + sign * lead]), middle, clockwise, math.pi)
    _lift(job, moves)
    return moves.paths()


def tap(job: Job) -> tuple[CutterPath, ...]:
    """Return the toolpaths of TAPPING (ISO 14649-11): in step with the spindle, which turns back at the bottom.

    The pitch is the tap's; where its entity has none (ISO 14649-111 gives taps no pitch) the thread's, else the feed over the
    speed.
    """
    technology = job.technology
    pitch = _pitch(job)
    speed = technology.spindle
    if speed is None and technology.cutting_speed is not None and job.radius > 0:
        speed = technology.spindle_at(2 * job.radius, job.tool.left_handed)
    if speed is None or speed == 0:
        raise job.fault("stepnc-missing", "tapping needs a spindle speed above 0")
    if technology.feed is not None:
        from_feed = technology.feed / abs(speed)
        if pitch is not None and abs(pitch - from_feed) > 1e-3 * pitch:
            text = f"the feed of {technology.feed:g} mm/s makes {from_feed:.4g} mm a turn, and the thread has a pitch"
            job.warn("stepnc-pitch", f"{text} of {pitch:g} mm; the pitch counts")
        pitch = from_feed if pitch is None else pitch
    if pitch is None or not pitch > 0:
        raise job.fault("stepnc-missing", "tapping needs a feed, or the pitch of the tap or thread, above 0")
    size = 2 * job.radius
    least, most = max(_FINE * size, min(_FINEST, _FINEST * size)), _COARSE * size
    if size and not least <= pitch * (1 + SAME_SIZE) <= most:
        text = f"a tap of {size:g} mm has a pitch of {pitch:.4g} mm; threads of this size have {least:.3g} to {most:.3g} mm"
        job.warn("stepnc-pitch", f"{text}; is the feed or the speed another?")
    if job.value("dwell_time_bottom", 0.0) > 0:
        job.warn(
            "stepnc-dwell", "a tap in step with the spindle turns back at once; dwell_time_bottom is left out"
        )
    hole = job.shape.diameter
    if hole is not None and hole < 2 * (job.radius - pitch):
        text = f"the hole has {hole:g} mm, and a tap of {2 * job.radius:g} mm with a pitch of {pitch:g} mm needs more than"
        raise job.fault("stepnc-tool-size", f"{text} {2 * (job.radius - pitch):g} mm")
    moves = _begin(job)
    moves.at(replace(technology, spindle=speed, cutting_speed=None, feed=pitch * abs(speed)))
    moves.tap(-_bottom(job), pitch)
    return moves.paths()

"""Threads on the outside of a bar."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cncgen.stepnc.features.job import Job, Moves
from cncgen.stepnc.features.turned_bar import CLEAR, LIFT, BarJob
from cncgen.stepnc.model import Technology

#: Height of a thread in pitches (ISO 68-1: 17/24 of that of the triangle), and how many turns the spindle has to get in step.
THREAD_HEIGHT = 17 / 24 * math.sqrt(3) / 2
RUN_IN = 3.0


def thread(work: BarJob) -> Moves:
    """Return the moves of THREADING: passes in step with the spindle, each deeper.

    Depths are those of the strategy, or grow with the square root of the number of the pass, so that each takes as much
    (CONSTANT_REMOVAL_AMOUNT). Without a minor diameter the thread is as high as a metric one (ISO 68-1).
    """
    job, shape = work.job, work.job.shape
    pitch = abs(shape.pitch) if shape.pitch is not None else job.tool.pitch
    if pitch is None or not pitch > 0:
        raise job.fault("stepnc-missing", "a thread needs its pitch: number_of_threads, or that of the tool")
    if shape.pitch is not None and job.tool.pitch is not None and abs(job.tool.pitch - pitch) > 1e-3:
        text = f"the tool has a pitch of {job.tool.pitch:g} mm and the thread one of {pitch:g} mm"
        raise job.fault("stepnc-pitch", text)
    strategy = job.operation.strategy
    if (shape.pitch or 1.0) < 0:
        raise job.fault("stepnc-unsupported", "a left-handed thread is not turned; explicit toolpaths are")
    asked = str(strategy.values.get("threading_direction", "")).lower() if strategy else ""
    if asked not in ("", "center"):
        text = f"threading_direction {asked.replace('_', ' ')}: each pass goes straight in, not along a flank"
        job.warn("stepnc-approach", text)
    major = shape.thread or 2 * float(work.points[:, 1].max())
    minor = shape.diameter or major - 2 * THREAD_HEIGHT * pitch
    if not 0 < minor < major:
        raise job.fault("stepnc-geometry", f"the thread has diameters of {major:g} and {minor:g} mm")
    begin = float(work.points[0, 0])
    end = begin - shape.width if shape.width else float(work.points[-1, 0])
    moves_out = max(work.bounds()[2], major / 2) + CLEAR
    start = begin + RUN_IN * pitch
    height = (major - minor) / 2 - work.allowance
    angle = strategy.values.get("path_return_angle") if strategy else None
    moves = work.begin(start, moves_out)
    moves.at(_steady(job, major, pitch))
    for depth in _thread_depths(work, height):
        r = major / 2 - depth
        moves.rapid(np.array([start, r, 0.0]))
        leave = [np.array([end, r, 0.0])]
        if isinstance(angle, float) and 0 < angle < math.pi / 2:
            run = (major / 2 + LIFT - r) / math.tan(angle)
            leave = [np.array([end + run, r, 0.0]), np.array([end, major / 2 + LIFT, 0.0])]
        moves.thread(leave, pitch)
        moves.rapid(np.array([end, moves_out, 0.0]), np.array([start, moves_out, 0.0]))
    return moves


def _thread_depths(work: BarJob, height: float) -> list[float]:
    """Return the depth of each pass below the major diameter, mm."""
    if not height > 0:
        raise work.job.fault(
            "stepnc-depth", f"nothing is left of the thread: its height less the allowance is {height:g} mm"
        )
    if not work.rough:
        return [height]
    depths = work.depths(height)
    strategy = work.job.operation.strategy
    function = str(strategy.values.get("cut_in_amount_function", "")) if strategy else ""
    if function.lower().replace("_", " ") == "constant removal amount":
        first = depths[0]
        count = math.ceil((height / first) ** 2 - 1e-9)
        depths = [min(first * math.sqrt(k + 1), height) for k in range(count)]
    return depths


def _steady(job: Job, diameter: float, pitch: float) -> Technology:
    """Return the technology of a thread: a spindle speed that does not change, and the pitch as the feed."""
    technology = job.technology
    speed = technology.spindle
    if speed is None and technology.cutting_speed is not None:
        speed = technology.spindle_at(diameter)
        text = f"a thread needs a spindle that keeps its speed: {-speed * 60:.4g} a minute, that of its major diameter"
        job.warn("stepnc-speed", text)
    if not speed:
        raise job.fault("stepnc-missing", "threading needs a spindle speed above 0")
    per_turn = technology.feed_per_rev if technology.feed is None else technology.feed / abs(speed)
    if per_turn is not None and abs(per_turn - pitch) > 1e-3 * pitch:
        job.warn(
            "stepnc-pitch",
            f"the feed makes {per_turn:.4g} mm a turn, and the thread has a pitch of {pitch:g} mm; the pitch counts",
        )
    return replace(technology, spindle=speed, cutting_speed=None, feed=pitch * abs(speed), feed_per_rev=None)

"""Toolpaths of turning (ISO 14649-12) outside of a bar: facing, contouring, grooves and threads.

All is planned in the plane of `cncgen.stepnc.features.turned_bar`. The material left on a bar is kept from one workingstep to the next
(`Bar`), so that rapid motions stay outside of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc import turned_shapes
from cncgen.stepnc.features.job import Job, Moves
from cncgen.stepnc.features.turned_bar import CLEAR, SAME, Bar, BarJob
from cncgen.stepnc.features.turned_contours import contour, face
from cncgen.stepnc.features.turned_grooves import groove
from cncgen.stepnc.features.turned_threads import thread
from cncgen.stepnc.geometry.frames import Matrix
from cncgen.stepnc.geometry.pieces import Piece
from cncgen.stepnc.model import CutterPath

_WAYS: dict[str, Callable[[BarJob], Moves]] = {
    "facing": face,
    "contouring": contour,
    "grooving": groove,
    "threading": thread,
}


def make(job: Job, feature: str, frame: Matrix, bar: Bar | None, sense: float) -> tuple[CutterPath, ...]:
    """Return the toolpaths of a turning operation, in the frame of its workingstep.

    Args:
        job: The work.
        feature: Its kind.
        frame: Of the workingstep, seen from the machine, whose Z is the axis of the work.
        bar: The rest of the raw piece, or None; it is cut.
        sense: 1 where the tool feeds against Z of the machine, −1 where it feeds along it (`turned_shapes.feed_sense`).

    Raises:
        Skip: where they cannot be made, which is reported.
    """
    kind = job.operation.kind.removesuffix(" rough").removesuffix(" finish")
    way = _WAYS.get(kind)
    if way is None or job.shape.contour is None:
        text = f"no toolpath can be made for {kind} of {'an' if feature[:1] in 'aeiou' else 'a'} {feature}"
        raise job.fault("stepnc-unsupported", text, hint="give the operation explicit toolpaths")
    if job.shape.inside:
        raise job.fault(
            "stepnc-unsupported", "the wall of a bore is not turned yet: material_side points outwards"
        )
    if frame[0, 0] < 1 - 1e-9 or abs(abs(frame[2, 2]) - 1) > 1e-9 or np.abs(frame[:2, 3]).max() > 1e-6:
        text = "the axis of the feature must be that of the spindle, X 0 Y 0 along Z, and its X that of the machine"
        raise job.fault("stepnc-geometry", text)
    _note_ignored(job)
    _check_direction(job, frame, sense)
    plane = _plane(sense)
    turn = elementary.product(plane.T, frame)  # the plane is a rotation: its inverse is its transpose
    contour = [p.moved(turn) for p in job.shape.contour]
    if contour[0].start[0] < contour[-1].end[0]:
        contour = [p.reversed() for p in reversed(contour)]
    work = BarJob(job, bar, sense, contour, job.tool.nose or 0.0)
    if min(work.points[:, 1]) < -SAME:
        raise job.fault("stepnc-geometry", "the profile crosses the axis of the work")
    back = elementary.product(np.asarray(np.linalg.inv(frame)), plane)
    return tuple(replace(p, pieces=_moved(p.pieces, back)) for p in way(work).paths())


def _moved(pieces: Callable[[], list[Piece]], frame: Matrix) -> Callable[[], list[Piece]]:
    return lambda: [p.moved(frame) for p in pieces()]


def _plane(sense: float) -> Matrix:
    """Return the frame of (u, r, 0) seen from the machine: u along Z or against it, r along X."""
    plane = np.eye(4)
    plane[:3, :3] = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, sense], [sense, 0.0, 0.0]])
    return plane


def _check_direction(job: Job, frame: Matrix, sense: float) -> None:
    """Check that the strategy's feed_direction can be done; tell where the hand of the tool does not give the feed's.

    Raises:
        Skip: where it cannot.
    """
    kind = job.operation.kind
    given = turned_shapes.feed_direction(job.operation, frame)
    if kind.startswith("facing"):
        return
    if given is not None and abs(given[2]) <= abs(given[0]):
        if kind.startswith("contouring rough"):
            raise job.fault("stepnc-unsupported", "roughing of a contour feeds along the axis, not across it")
        if given[0] > 0:
            raise job.fault("stepnc-unsupported", "a feed_direction away from the axis is not made; -X is")
    if sense > 0 and given is None and job.tool.left_handed and kind.startswith("contouring"):
        text = "the tool is left-handed, and the profile rises against Z: it feeds so; feed_direction can say otherwise"
        job.warn("stepnc-feed-direction", text)


def _note_ignored(job: Job) -> None:
    """Warn of demands of a strategy that are not met."""
    strategy = job.operation.strategy
    asked = [
        n for n in ("lift_feed", "stepover_feed", "variable_feedrate") if strategy and strategy.values.get(n)
    ]
    if asked:
        job.warn("stepnc-speed", f"{', '.join(asked)} of the strategy: the feed of the technology holds")
    if job.operation.approach is not None or job.operation.retract is not None:
        text = f"the tool comes and goes beside the bar, {CLEAR:g} mm away from it, not as approach and retract ask"
        job.warn("stepnc-approach", text)

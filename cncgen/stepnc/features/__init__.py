"""Toolpaths of features that come without explicit ones: one module a strategy.

`make_paths` chooses by operation and feature. If a toolpath cannot be made faithfully, a diagnostic says so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from cncgen.geometry import elementary
from cncgen.stepnc.entities import Skip
from cncgen.stepnc.features import holes, plane, pocket, profile, slot, turned, turned_bar
from cncgen.stepnc.features.job import Job
from cncgen.stepnc.features.offsets import OffsetError
from cncgen.stepnc.geometry.frames import Matrix, identity
from cncgen.stepnc.geometry.pieces import Piece
from cncgen.stepnc.model import TURNING, CutterPath, Feature, Workingstep
from cncgen.stepnc.part21 import Exchange
from cncgen.stepnc.turned_shapes import feed_sense

_HOLES = {
    "drilling": holes.drill,
    "center drilling": holes.centre_drill,
    "counter sinking": holes.countersink,
    "multistep drilling": holes.multistep,
    "boring": holes.bore,
    "reaming": holes.bore,
    "tapping": holes.tap,
    "thread drilling": holes.mill_thread,
}
_MILLING: dict[tuple[str, str], Callable[[Job], tuple[CutterPath, ...]]] = {
    ("plane", "planar face"): plane.mill,
    ("plane", "closed pocket"): pocket.mill,
    ("plane", "open pocket"): pocket.mill,
    ("plane", "slot"): slot.mill,
    ("plane", "step"): slot.step,
    ("bottom and side", "planar face"): plane.mill,
    ("bottom and side", "closed pocket"): pocket.mill,
    ("bottom and side", "open pocket"): pocket.mill,
    ("bottom and side", "slot"): slot.mill,
    ("bottom and side", "step"): slot.step,
    ("bottom and side", "round hole"): pocket.mill_hole,
    ("bottom and side", "general outside profile"): profile.clear_outside,
    ("bottom and side", "boss"): profile.clear_outside,
    ("bottom and side", "thread"): holes.mill_thread,
    ("side", "thread"): holes.mill_thread,
    ("side", "closed pocket"): profile.mill_inside,
    ("side", "open pocket"): profile.mill_inside,
    ("side", "slot"): slot.mill_walls,
    ("side", "step"): slot.step_wall,
    ("side", "round hole"): profile.mill_inside,
    ("side", "general outside profile"): profile.mill_outside,
    ("side", "boss"): profile.mill_outside,
}
_HOLE_GROUPS = ("counterbore hole", "countersunk hole")
_MAX_DEPTH = 5
_MAX_ELEMENTS = 50_000


#: Bars that are being turned, by the values of their raw pieces.
Bars = dict[str, turned_bar.Bar]


def make_paths(step: Workingstep, exchange: Exchange, bars: Bars | None = None) -> tuple[CutterPath, ...]:
    """Return the toolpaths of a workingstep's feature, in the frame of the workingstep.

    Args:
        step: The workingstep.
        exchange: Takes the faults.
        bars: The material that turning has left so far; it is cut further.

    Raises:
        Skip: where they cannot be made, which is reported.
    """
    if step.feature is None:
        text = f"#{step.ident} {step.label!r}: neither toolpaths nor a feature say where to cut"
        exchange.report(step.ident, "stepnc-missing", text)
        raise Skip
    _check_security(step, exchange)
    if step.operation.kind.startswith(TURNING):
        return _turn(step, step.feature, exchange, {} if bars is None else bars)
    return _Maker(step, exchange).paths(step.feature, identity(), 0)


def _turn(step: Workingstep, feature: Feature, exchange: Exchange, bars: Bars) -> tuple[CutterPath, ...]:
    """Return the toolpaths of a turning workingstep."""
    bar = None
    if step.raw is not None:
        bar = bars.setdefault(str(step.raw.values()), turned_bar.Bar.of(step.raw))
    job = Job(step.ident, step.operation, feature.shape(), exchange)
    return turned.make(job, feature.kind, step.frame, bar, feed_sense(step, job.shape))


def _check_security(step: Workingstep, exchange: Exchange) -> None:
    """Raise `Skip` where the security plane lies below the feature or the raw piece: rapids along it would cut."""
    if step.security is None:
        return
    normal, place = step.security[:3, 2], step.security[:3, 3]
    highest = float(elementary.product(step.frame[:3, 3] - place, normal))
    text = f"the security plane lies {highest:g} mm below the feature's origin"
    if step.raw is not None:
        top = step.raw.reach(place, normal)[1]
        if top > highest:
            highest, text = top, f"the security plane lies {top:g} mm below the top of the raw piece"
    if highest > 1e-3:
        hint = f"raise its_secplane by {highest:g} mm at least"
        told = f"#{step.ident} {step.label!r}: {text}; rapid moves along it would cut the part"
        exchange.report(step.ident, "stepnc-security-plane", told, hint=hint)
        raise Skip


class _Maker:
    """Makes the toolpaths of one workingstep; a feature that a pattern repeats is made once and moved."""

    def __init__(self, step: Workingstep, exchange: Exchange) -> None:
        self.step = step
        self.exchange = exchange
        self._made: dict[int, tuple[CutterPath, ...]] = {}
        self._elements = 0

    def paths(self, feature: Feature, frame: Matrix, depth: int) -> tuple[CutterPath, ...]:
        """Return the toolpaths of a feature, moved by a frame; of its elements where it has some."""
        if feature.ident not in self._made:
            shape = feature.shape()
            job = Job(self.step.ident, self.step.operation, shape, self.exchange, self._raw(frame))
            self._elements += len(shape.elements)
            if depth > _MAX_DEPTH or self._elements > _MAX_ELEMENTS:
                raise job.fault("stepnc-geometry", "features hold features too deep, or too many")
            if shape.elements:
                return self._group(job, feature, frame, depth)
            self._made[feature.ident] = self._one(job, feature.kind)
        made = self._made[feature.ident]
        return tuple(replace(p, pieces=_moved(p.pieces, frame)) for p in made) if depth else made

    def _raw(self, frame: Matrix) -> tuple[float, float] | None:
        """Return lowest and highest point of the raw piece in the frame of a feature within that of the workingstep, mm."""
        if self.step.raw is None:
            return None
        place = elementary.product(self.step.frame, frame)
        return self.step.raw.reach(place[:3, 3], place[:3, 2])

    def _one(self, job: Job, kind: str) -> tuple[CutterPath, ...]:
        job.check_sizes()
        if job.operation.kind in _HOLES:
            holes.check_hole(job)
        try:
            return _strategy(job, kind)(job)
        except OffsetError as error:
            raise job.fault("stepnc-geometry", str(error)) from None

    def _group(self, job: Job, feature: Feature, frame: Matrix, depth: int) -> tuple[CutterPath, ...]:
        elements = job.shape.elements
        if feature.kind in _HOLE_GROUPS:
            elements = _holes_for(job, elements)
        out: list[CutterPath] = []
        for element in elements:
            out += self.paths(element, elementary.product(frame, element.placement), depth + 1)
        return tuple(out)


def _moved(pieces: Callable[[], list[Piece]], frame: Matrix) -> Callable[[], list[Piece]]:
    return lambda: [p.moved(frame) for p in pieces()]


def _holes_for(job: Job, elements: tuple[Feature, ...]) -> tuple[Feature, ...]:
    """Return the element of a counterbored or countersunk hole that the operation and tool are for.

    Countersinking is for the tapered one, other operations for the straight ones; of several the one whose diameter
    is nearest the tool's.
    """
    shapes = [(e, e.shape()) for e in elements]
    tapered = job.operation.kind == "counter sinking"
    fitting = [(e, s) for e, s in shapes if (s.slope > 0) == tapered] or shapes
    if len(fitting) == 1:
        return (fitting[0][0],)
    diameter = 2 * job.radius
    return (min(fitting, key=lambda es: abs((es[1].diameter or 0.0) - diameter))[0],)


def _strategy(job: Job, feature: str) -> Callable[[Job], tuple[CutterPath, ...]]:
    kind = job.operation.kind
    if kind in _HOLES:
        if feature not in ("round hole", "thread"):
            raise job.fault("stepnc-unsupported", f"{kind} is for round holes, not for a {feature}")
        return _HOLES[kind]
    base = kind.removesuffix(" rough").removesuffix(" finish")
    make = _MILLING.get((base, feature))
    if make is None:
        text = f"no toolpath can be made for {kind} of {'an' if feature[:1] in 'aeiou' else 'a'} {feature}"
        raise job.fault("stepnc-unsupported", text, hint="give the operation explicit toolpaths")
    return make

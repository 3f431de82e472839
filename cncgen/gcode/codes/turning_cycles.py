"""Turning cycles: finishing G70, roughing along Z (G71) and across (G72), with and without pockets.

The profile of a numbered subroutine is approached from where the tool stands (X and Z of the block); material between
is taken off in cuts of depth I that run along the travel from the approach to the profile. A cut ends where its level
meets the profile; the tool lifts off by R, goes back, and down to the next level. A pocket is a part of the profile that dips below a
level again later. It is cut when the last cut along the profile reaches it. G71.1 leaves pockets out; G71.2 cuts only them.

Source: LinuxCNC's manual, "G70", "G71 G72"; the order of moves was compared with its interpreter.
"""

from __future__ import annotations

import math
from functools import partial

from cncgen.gcode.block import Block
from cncgen.gcode.codes.lines import check_cycle_feed
from cncgen.gcode.codes.modes import is_unit
from cncgen.gcode.codes.table import COMPENSATION, Code
from cncgen.gcode.codes.tools import whole
from cncgen.gcode.codes.turning_profiles import MAX_CUTS, TINY, Segment, check_cuts, moved_aside, read_profile
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.records import dataclass

#: Segments of a profile that is too short for the side of its start to count.
_FEW = 2
_X, _Z = 0, 2


@dataclass(slots=True)
class Lathe:
    """Moves in the frame of a profile: real along the travel, imaginary the depth (see `profiles`)."""

    ip: Interpreter
    across: complex
    swap: bool

    def _end(self, point: complex) -> list[float]:
        z, x = point.real * self.across.real, point.imag * self.across.imag
        if self.swap:
            z, x = x, z
        end = self.ip.state.position.copy()
        end[_X], end[_Z] = x, z
        return end

    def rapid(self, point: complex) -> None:
        self.ip.go(self._end(point), rapid=True)

    def feed(self, point: complex) -> None:
        self.ip.go(self._end(point))

    def follow(self, segment: Segment, end: complex) -> None:
        """Feed along a segment up to a point of it."""
        if segment.centre is None:
            self.feed(end)
            return
        there, centre = self._end(end), self._end(segment.centre)
        mirror = (self.across.real * self.across.imag < 0) != self.swap
        turns = -segment.spin if mirror else segment.spin
        self.ip.sink.arc_feed(there, centre[_Z], centre[_X], turns, 18)
        self.ip.state.position = there


def _frame(profile: list[Segment], swap: bool) -> complex:
    """Return the signs that turn travel to the right, and the profile so that it rises along it.

    The tool comes from above: from outside where the profile opens to the outside, else from inside, as in a bore. To a level profile it
    comes from outside along X, but from behind along Z (seen on LinuxCNC's interpreter): a plain face is no profile of G72.
    """
    way = profile[-1].end - profile[0].start
    travel, rise = (way.imag, way.real) if swap else (way.real, way.imag)
    return complex(1.0 if travel > 0.0 else -1.0, 1.0 if rise > 0.0 or (rise == 0.0 and not swap) else -1.0)


@dataclass(slots=True)
class TurningJob:
    """A profile in its frame, the point that the cuts start from, and whether that is left of the first segment."""

    lathe: Lathe
    start: complex
    profile: list[Segment]
    left: bool


def _prepare(ip: Interpreter, block: Block, name: str, swap: bool) -> TurningJob:
    """Check the words, go to X and Z of the block, read the profile and go to before its first point."""
    state = ip.state
    if "q" not in block.words:
        hint = "Q names the subroutine of the profile: G71 Q100 for o100"
        raise BlockError("profile-missing", f"{name} has no subroutine number Q", name, hint=hint)
    if state.plane != 18:
        raise BlockError("profile-plane", f"{name} works in plane G18, not in G{state.plane}", name)
    number = whole(block, "q", name)
    check_cycle_feed(ip, block, name)
    end = ip.end_point(Block(block.only("xz")))
    ip.go(end, rapid=True)
    try:
        profile = read_profile(ip, block, float(number))[1:]
    except BlockError as error:
        error.word = "Q" if error.code == "sub-missing" else error.word
        raise
    start = complex(end[_Z], end[_X])
    across = _frame(profile, swap)
    profile = [segment.seen(across, swap) for segment in profile]
    start = Segment(start, start).seen(across, swap).start
    if name != "G70" and not all(segment.advances() for segment in profile):
        message = f"the profile of {name} goes back along the travel: that part cannot be cut from one side"
        raise BlockError("profile-not-monotonic", message, "Q")
    lathe = Lathe(ip, across, swap)
    start = complex(min(start.real, profile[0].start.real), start.imag)
    lathe.rapid(start)
    return TurningJob(lathe, start, profile, _is_left(start, profile))


def _is_left(start: complex, profile: list[Segment]) -> bool:
    """Tell whether an allowance lies left of a profile: where the cuts start from, or straight on from there.

    A profile that begins upright has no such side; the rules for it, and for one line alone (the side that the cuts of such a profile
    come from), were measured on LinuxCNC's interpreter.
    """
    heading, way = profile[0].heading(profile[0].start), start - profile[0].start
    if abs(heading.real) < TINY:
        return way.imag > -TINY if len(profile) > _FEW else heading.imag > 0.0
    return len(profile) == 1 or heading.real * way.imag - heading.imag * way.real > -TINY


def finish(ip: Interpreter, block: Block) -> None:
    """G70: follow the profile in P passes, from D to E beside it."""
    if is_unit(ip, block, "G70", 200):
        return
    words = block.words
    first, last = words.get("d", 0.0), words.get("e", 0.0)
    count = whole(block, "p", "G70") if "p" in words else 1
    if not 1 <= count <= MAX_CUTS:
        raise BlockError("profile-passes", f"P{count} of G70 must be from 1 to {MAX_CUTS}", "P")
    job = _prepare(ip, block, "G70", swap=False)
    for index in range(count, 0, -1):
        path = moved_aside(job.profile, (index - 1) * (first - last) / count + last, job.left)
        if index < count:
            job.lathe.rapid(job.start)
        job.lathe.rapid(path[0].start)
        for segment in path:
            job.lathe.follow(segment, segment.end)
    ip.state.moved = True


def _rough(ip: Interpreter, block: Block, swap: bool, kind: int) -> None:
    """G71 (G72 with `swap`), .1 or .2 of it."""
    name = f"G{72 if swap else 71}" + (f".{kind}" if kind else "")
    if name == "G71" and is_unit(ip, block, name, 210):
        return
    words = block.words
    aside, step, lift = words.get("d", 0.0), words.get("i", 1.0), words.get("r", 0.5)
    if step <= 0.0 or lift <= 0.0:
        raise BlockError("profile-step", f"I and R of {name} must be above 0", "I" if step <= 0.0 else "R")
    job = _prepare(ip, block, name, swap)
    aside_path = moved_aside(job.profile, aside, job.left)
    path = [half for segment in aside_path for half in segment.halves()]
    depths = [job.start.imag, *(p.imag for s in path for p in s.extremes())]
    check_cuts(max(depths), min(depths), step, name, "I")
    end = path[-1].end
    out = complex(end.real, job.start.imag)
    segments = [Segment(job.start, path[0].start), *path]
    if out.imag > end.imag:
        segments.append(Segment(end, out))
    _tell_full_depth(ip, job, path, name, swap)
    roughing = Roughing(job.lathe, segments, job.start.imag, step, lift)
    roughing.run(pockets=kind != 1, approach=kind != 2)
    ip.state.moved = True


def _tell_full_depth(ip: Interpreter, job: TurningJob, path: list[Segment], name: str, swap: bool) -> None:
    """Warn where the cuts start beneath the whole profile: no cut is made, and the tool is fed along it at full depth."""
    depths = [point.imag for segment in path for point in segment.extremes()]
    if job.start.imag > min(depths) + TINY:
        return
    sign = job.lathe.across.imag
    axis = "Z" if swap else "X"
    message = (
        f"{name} starts at {axis}{sign * job.start.imag:g}, on the far side of its profile"
        f" ({axis}{sign * path[0].start.imag:g} to {axis}{sign * path[-1].end.imag:g}): it makes no cut, and feeds along the"
        " profile at full depth"
    )
    hint = f"a profile in which {axis} grows is cut from outside, one in which it falls from inside; start on that side"
    if abs(path[0].start.imag - path[-1].end.imag) < TINY:
        hint = f"of a profile in which {axis} stays the same, LinuxCNC cuts the other side alone; G1 makes a plain face"
    ip.warn("profile-full-depth", message, "Q", hint)


@dataclass(slots=True)
class Roughing:
    """The cuts: levels `step` apart below `top`, along a path of approach, profile and way out."""

    lathe: Lathe
    path: list[Segment]
    top: float
    step: float
    lift: float

    def run(self, *, pockets: bool, approach: bool) -> None:
        """Go along the path, cutting each level where the path goes below it."""
        at, skip_to = self.path[0].start, -1
        for index, segment in enumerate(self.path):
            last = index == len(self.path) - 1
            if index < skip_to or abs(segment.end - at) < TINY:
                continue
            if (approach if index == 0 else pockets) and not last:
                self._cuts(index, at, rapid=index == 0)
            if index == 0 and segment.end.imag < at.imag - TINY:
                self.lathe.rapid(segment.end)
            else:
                self.lathe.follow(segment, segment.end)
            at = segment.end
            if not pockets and not last:
                at, skip_to = self._bridge(index, at)

    def _levels(self, high: float, low: float, first: bool) -> list[float]:
        """Return the levels that a way down from `high` to `low` crosses, the highest first."""
        count = math.ceil((self.top - high) / self.step - TINY)
        if not first and abs(self.top - count * self.step - high) < TINY:
            count += 1
        levels = []
        while self.top - count * self.step > low + TINY:
            levels.append(self.top - count * self.step)
            count += 1
        return levels

    def _cuts(self, index: int, at: complex, rapid: bool) -> None:
        """Cut at each level that a segment goes down through."""
        segment = self.path[index]
        go = self.lathe.rapid if rapid else (lambda p: self.lathe.follow(segment, p))
        high = max(p.imag for p in segment.extremes())
        for level in self._levels(high, segment.end.imag, first=rapid):
            points = [p for p in segment.crossings(level) if segment.heading(p).imag < 0.0]
            if not points:
                continue
            point = points[-1]
            hit = self._ahead(index, point)
            go(point)
            if abs(hit - point) < TINY:
                continue
            self.lathe.feed(hit)
            lift = min(self.lift, abs(hit - point) / 2.0)
            self.lathe.rapid(hit + complex(-lift, lift))
            self.lathe.rapid(point + complex(lift, lift))
            (self.lathe.rapid if rapid else self.lathe.feed)(point)

    def _ahead(self, index: int, point: complex) -> complex:
        """Return where the path rises through the level of a point again."""
        for segment in self.path[index:]:
            for crossing in segment.crossings(point.imag):
                if crossing.real > point.real + TINY and segment.heading(crossing).imag > -TINY:
                    return crossing
        return complex(self.path[-1].end.real, point.imag)

    def _bridge(self, index: int, at: complex) -> tuple[complex, int]:
        """Leave out a pocket that begins at a point: go straight to where the path rises to its level again."""
        self.lathe.feed(at)
        following = self.path[index + 1]
        if not following.dives():
            return at, -1
        for later in range(index + 1, len(self.path)):
            for crossing in self.path[later].crossings(at.imag):
                if crossing.real > at.real + TINY and self.path[later].heading(crossing).imag > -TINY:
                    self.lathe.feed(crossing)
                    return crossing, later
        return at, -1


_WORDS = "qxzdir"
CODES = (
    Code("G", 700, "non-modal", Stage.MOTION, finish, "finish the profile of o-Q", "qxzdep", "own", dialects=("linuxcnc",),
        moves="XZ", calls="q"),
    *(
        Code("G", number, "non-modal", Stage.MOTION, partial(_rough, swap=number >= 720, kind=kind), text, _WORDS, "own",
            dialects=("linuxcnc",), moves="XZ", calls="q", refused=("is a roughing cycle", COMPENSATION))
        for number, kind, text in (
            (710, 0, "rough the profile of o-Q along Z"),
            (711, 1, "as G71, leaving pockets out"),
            (712, 2, "as G71, pockets only"),
            (720, 0, "rough the profile of o-Q across"),
            (721, 1, "as G72, leaving pockets out"),
            (722, 2, "as G72, pockets only"),
        )
    ),
)  # fmt: skip

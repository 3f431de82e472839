"""Cycles of Heidenhain's plain language that mill inside threads: 262, 264 with its drilling, 265 downwards in one helix.

Half a turn leads to the wall and away from it, as the manual has it (TNC 640, user's manual for cycles); its height, half a pitch, is ours.
"""

from __future__ import annotations

import math

from cncgen.gcode.errors import BlockError
from cncgen.gcode.klartext.hole_cycle import HoleCycle

_MOST = 10_000


def _arc(cycle: HoleCycle, x: float, z: float, centre: float, turns: int) -> None:
    """Go on an arc about a place beside or at the middle of the thread, which has the Y of the tool."""
    ip = cycle.ip
    end = [x, ip.state.position[1], z, *ip.state.position[3:]]
    ip.sink.arc_feed(end, centre, end[1], turns, 17)
    ip.state.position, ip.state.moved = end, True


def _helix(cycle: HoleCycle, climb: bool, threads: int) -> None:
    """Mill the thread of diameter Q335 and pitch Q239 (below 0: left-hand) in one turn (0), in all (1), or in turns some threads apart."""
    ip, q, tool = cycle.ip, cycle.q, cycle.ip.tool_radius()
    pitch, radius = abs(q[239]), q[335] / 2.0 - tool
    if radius <= 0.0 or pitch == 0.0 or threads < 0:
        message = f"Q335 = {q[335]:g}, Q239 = {q[239]:g} and Q355 = {threads} do not make a thread for a tool of diameter {2.0 * tool:g}"
        hint = "Q335 is wider than the tool, Q239 the pitch, Q355 the threads of one step"
        raise BlockError("cycle-tool", message, "CYCL", hint=hint)
    upwards, sense = (q[239] > 0.0) == climb, 1 if climb else -1
    way = pitch if upwards else -pitch
    turns = math.ceil(-q[201] / pitch - 1e-9) if threads == 1 else 1
    count = math.ceil(-q[201] / (threads * pitch) - 1e-9) if threads > 1 else 1
    if max(turns, count) > _MOST:
        message = f"Q239 = {q[239]:g} makes {max(turns, count)} turns"
        raise BlockError("cycle-infeed", message, "CYCL", hint="Q239 is the pitch")
    bottom = q[203] + q[201]
    first = bottom if upwards else bottom + pitch * turns + (count - 1) * threads * pitch
    middle = ip.state.position[0]
    for k in range(count):
        begin = first + k * math.copysign(threads * pitch, way)
        cycle.feed(q[253] or q[206] or q[207], "Q253")
        cycle.go(begin - way / 2.0, rapid=False)
        cycle.feed(q[207], "Q207")
        _arc(cycle, middle + radius, begin, middle + radius / 2.0, sense)
        _arc(cycle, middle + radius, begin + turns * way, middle, sense * turns)
        _arc(cycle, middle, begin + (turns + 0.5) * way, middle + radius / 2.0, sense)


def _front(cycle: HoleCycle, feed: float, what: str) -> None:
    """Countersink with the tool's front at Q358: half a turn out to Q359 beside the middle, a turn, half a turn back."""
    q, ip = cycle.q, cycle.ip
    if not q[358]:
        return
    middle, z = ip.state.position[0], q[203] + q[358]
    cycle.feed(q[253] or feed, "Q253")
    cycle.go(z, rapid=False)
    if q[359] > 0.0:
        cycle.feed(feed, what)
        edge, hub = middle + q[359], middle + q[359] / 2.0
        for x, centre in ((edge, hub), (edge, middle), (middle, hub)):
            _arc(cycle, x, z, centre, 1)


def _drill(cycle: HoleCycle) -> None:
    """Drill to Q356 in infeeds of Q202: out after each and back to Q258 above it, or back by Q256 after each Q257."""
    q = cycle.q
    bottom, at = q[203] + q[356], q[203]
    step, chip = abs(q[202]) or -q[356], q[257]
    if q[356] < 0.0 and -q[356] / min(step, chip if chip > 0.0 else step) > _MOST:
        message = f"Q202 = {q[202]:g} and Q257 = {chip:g} make more than {_MOST} infeeds"
        raise BlockError("cycle-infeed", message, "CYCL", hint="Q202 is the depth of one infeed")
    cycle.feed(q[206], "Q206")
    while at > bottom:
        depth = max(bottom, at - step)
        while chip > 0.0 and at - chip > depth:
            at -= chip
            cycle.go(at, rapid=False)
            cycle.go(at + abs(q[256]), rapid=False)
        cycle.go(depth, rapid=False)
        at = depth
        cycle.go(cycle.start, rapid=True)
        if at > bottom:
            cycle.go(at + q[258], rapid=True)


def _mill(cycle: HoleCycle) -> None:
    """262."""
    cycle.go(cycle.start, rapid=True)
    _helix(cycle, cycle.q[351] >= 0.0, round(cycle.q[355]))
    cycle.end()


def _drill_and_mill(cycle: HoleCycle) -> None:
    """264: drill, countersink at the front, mill the thread in one turn."""
    cycle.go(cycle.start, rapid=True)
    _drill(cycle)
    _front(cycle, cycle.q[207], "Q207")
    _helix(cycle, cycle.q[351] >= 0.0, 0)
    cycle.end()


def _downwards(cycle: HoleCycle) -> None:
    """265: mill the thread downwards in one helix; countersink at the front before it (Q360 = 0) or after it (1)."""
    cycle.go(cycle.start, rapid=True)
    if not round(cycle.q[360]):
        _front(cycle, cycle.q[254], "Q254")
    _helix(cycle, cycle.q[239] < 0.0, 1)
    if round(cycle.q[360]):
        _front(cycle, cycle.q[254], "Q254")
    cycle.end()


RUN = {262: _mill, 264: _drill_and_mill, 265: _downwards}

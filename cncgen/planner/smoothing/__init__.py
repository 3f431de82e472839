"""G64: runs of lines and arcs become smooth splines within the tolerance (docs/smoothing.md).

`smooth` takes and yields chunks of `Toolpath`. Curvature and its derivative are continuous on every spline; the result
leaves the programmed path by the tolerance at most, and does not depend on how the input is cut into chunks.
"""

from cncgen.planner.smoothing.chords import chord_speed_within, chord_within
from cncgen.planner.smoothing.runs import ROTARY_RADIUS
from cncgen.planner.smoothing.stream import smooth

__all__ = ["ROTARY_RADIUS", "chord_speed_within", "chord_within", "smooth"]

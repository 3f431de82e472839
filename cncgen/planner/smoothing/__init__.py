"""G64: runs of lines and arcs become smooth splines within the tolerance (docs/smoothing.md).

`smooth` takes and yields chunks of `Toolpath`. Curvature and its derivative are continuous on every spline; the result
leaves the programmed path by the tolerance at most, and does not depend on how the input is cut into chunks. Modules in the
order in which data passes them:

    ends             cuts NURBS rows near corners, so that only their ends are rounded
    runs             classifies rows: which may be smoothed together (`Classes`)
    stretches        joins lines that go straight on, and arcs that go on about one centre (`circles`), into one row
    tolerance_split  how the tolerance is shared between smoothing and the chords between setpoints
    stream           fits the splines, window by window (`cncgen.geometry.corridor`)
    output           makes rows of a toolpath of them

`fitted`, which `cncgen convert` uses, is a fit of its own.
"""

from cncgen.planner.smoothing.stream import smooth
from cncgen.planner.smoothing.tolerance_split import chord_speed_within

__all__ = ["chord_speed_within", "smooth"]

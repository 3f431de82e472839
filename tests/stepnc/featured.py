"""Parts of ISO 14649 with one feature and one operation, and what is left of their block."""

import numpy as np
import shapely

from cncgen.toolpath.record import FeedMode
from tests.stepnc.building import E, Part, codes, motions
from tests.stepnc.heightfield import removed

#: Where the features stand, so that all of the block is at positive coordinates.
ORIGIN = (50.0, 40.0, 0.0)
SIZE = (100.0, 80.0)
GRID = 0.5


class Features(Part):
    """A part with one operation on one feature at `ORIGIN`."""

    def size(self, value):
        return self.add("TOLERANCED_LENGTH_MEASURE", float(value), None)

    def head(self, depth=6.0, z=0.0):
        place = self.placement((ORIGIN[0], ORIGIN[1], z))
        return ("f", None, (), place, None if depth is None else self.plane(-depth))

    def rectangle(self, length, width):
        return self.add("RECTANGULAR_CLOSED_PROFILE", None, self.size(width), self.size(length))

    def polygon(self, *corners):
        points = [(x, y, 0) for x, y in corners]
        return self.add("GENERAL_CLOSED_PROFILE", None, self.polyline(*points, points[0]))

    def pocket(
        self, boundary, bosses=(), corner=None, bottom="PLANAR_POCKET_BOTTOM_CONDITION", slope=None, depth=6.0
    ):
        condition = self.add(bottom)
        radius = None if corner is None else self.size(corner)
        return self.add("CLOSED_POCKET", *self.head(depth), bosses, slope, condition, None, radius, boundary)

    def boss(self, boundary, slope=None, top=None):
        place = None if top is None else self.placement((0, 0, top))
        return self.add("BOSS", "b", None, (), place, None, boundary, slope)

    def block(self, low, high):
        """A workpiece whose raw piece is a block between two corners."""
        size = [float(b - a) for a, b in zip(low, high, strict=True)]
        solid = self.add("BLOCK", "", self.placement(low), *size)
        raw = self.add("WORKPIECE", "raw", None, None, None, None, solid, ())
        return self.add("WORKPIECE", "part", None, None, raw, None, None, ())

    def slot(self, profile, course=None, ends=("OPEN_SLOT_END_TYPE", "OPEN_SLOT_END_TYPE")):
        course = course or self.add("LINEAR_PATH", None, self.size(40), self.direction(1, 0, 0))
        return self.add("SLOT", *self.head(), course, profile, tuple(self.add(e) for e in ends))

    def step_feature(self, workpiece, length=30.0, wall=None, along=(0, 1, 0)):
        course = self.add("LINEAR_PATH", None, self.size(length), self.direction(*along))
        name, _, operations, place, depth = self.head()
        return self.add("STEP", name, workpiece, operations, place, depth, course, wall, ())

    def operation(self, kind, *own, approach=None, strategy=None, diameter=8.0, **tool):
        head = (None, None, "op", 5.0, None, self.tool("T", diameter, **tool), self.technology(), None)
        return self.add(kind, *head, None, approach, None, strategy, *own)

    def mill(self, feature, operation):
        self.project(self.plan(self.step(operation, feature, self.plane(20))))
        return self

    def heights(self, radius):
        path, found = self.read()
        assert codes(found, "error") == []
        return removed([path], SIZE, 0.0, GRID, {"T": radius})[1], found


def pocket_operation(
    part, strategy="CONTOUR_PARALLEL", finish=True, side=None, bottom=None, radial=5.0, **more
):
    kind = "BOTTOM_AND_SIDE_FINISH_MILLING" if finish else "BOTTOM_AND_SIDE_ROUGH_MILLING"
    own = (3.0, radial, side, bottom)
    values = {
        "CONTOUR_PARALLEL": (0.4, E("T"), E("CCW"), E("CLIMB")),
        "CONTOUR_SPIRAL": (0.4, E("T"), E("CCW"), E("CLIMB")),
        "BIDIRECTIONAL_MILLING": (0.4, E("T"), None, E("LEFT"), None),
        "UNIDIRECTIONAL_MILLING": (0.4, E("T"), None, E("CLIMB")),
    }
    plan = part.add(strategy, *values[strategy])
    return part.operation(kind, *own, strategy=plan, **more)


def cells():
    x = np.arange(GRID / 2, SIZE[0], GRID) - ORIGIN[0]
    y = np.arange(GRID / 2, SIZE[1], GRID) - ORIGIN[1]
    return shapely.points(np.repeat(x, len(y)), np.tile(y, len(x))), (len(x), len(y))


def check_cut(heights, region, radius, depth):
    """The tool has cut all that it can reach of a region to the depth, and nothing outside it (but for a grid cell)."""
    reach = region.buffer(-radius, quad_segs=64).buffer(radius, quad_segs=64)
    points, shape = cells()
    inside = shapely.contains(reach.buffer(-GRID), points).reshape(shape)
    outside = ~shapely.contains(region.buffer(GRID), points).reshape(shape)
    assert inside.any()
    np.testing.assert_allclose(heights[inside], -depth)
    np.testing.assert_array_equal(heights[outside], 0.0)


def hole_part(
    kind,
    *own,
    strategy=None,
    depth=20.0,
    diameter=10.0,
    bottom="THROUGH_BOTTOM_CONDITION",
    drilling=None,
    feed=0.01,
    **tool,
):
    part = Features()
    hole = part.add("ROUND_HOLE", *part.head(depth), part.size(diameter), None, part.add(bottom))
    head = (None, None, "op", 5.0, None, part.tool("T", diameter, **tool), part.technology(feed, -10.0), None)
    plan = part.add("DRILLING_TYPE_STRATEGY", *strategy) if strategy else None
    operation = part.add(kind, *head, *(drilling or (None,) * 5), plan, *own)
    part.mill(hole, operation)
    return part


def depths(part):
    """Return the heights reached one after the other, and whether in rapid."""
    path, found = part.read()
    assert codes(found, "error") == []
    rows = motions(path)
    return [(round(float(path.end[k, 2]), 6), bool(path.feed_mode[k] == FeedMode.RAPID)) for k in rows], path


def tops(heights):
    """Heights of the four walls' neighbourhood along X through the middle, by distance from the axis."""
    x = np.arange(GRID / 2, SIZE[0], GRID) - ORIGIN[0]
    return x, heights[:, int(ORIGIN[1] / GRID)]

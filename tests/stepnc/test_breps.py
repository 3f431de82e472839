"""Solids by their boundary as raw pieces: the box round them, or the cylinder that they are."""

import math

import numpy as np
import pytest

from cncgen.pipeline.removing import cut
from cncgen.stepnc.cutting import cut_program
from tests.stepnc.building import E
from tests.stepnc.featured import Features
from tests.stepnc.turning_parts import Turned


class Solids(Features):
    """Builds B-reps as CAD systems write them."""

    def vertex(self, point):
        return self.add("VERTEX_POINT", "", self.point(*point))

    def line(self, a, b):
        ray = self.add(
            "LINE", "", self.point(*a), self.add("VECTOR", "", self.direction(*np.subtract(b, a)), 1.0)
        )
        return self.add("EDGE_CURVE", "", self.vertex(a), self.vertex(b), ray, E("T"))

    def shell(self, *faces):
        made = []
        for surface, edges in faces:
            loop = self.add(
                "EDGE_LOOP", "", tuple(self.add("ORIENTED_EDGE", "", None, None, e, E("T")) for e in edges)
            )
            made.append(
                self.add(
                    "ADVANCED_FACE", "", (self.add("FACE_OUTER_BOUND", "", loop, E("T")),), surface, E("T")
                )
            )
        solid = self.add("MANIFOLD_SOLID_BREP", "body", self.add("CLOSED_SHELL", "", tuple(made)))
        far = self.placement((999, 999, 999))  # a placement among the items is no part of the body
        return self.add("ADVANCED_BREP_SHAPE_REPRESENTATION", "", (solid, far), None)

    def brick(self, low, high):
        """A box by its twelve edges (one face holds them all here)."""
        corners = np.array(low) + np.indices((2, 2, 2)).reshape(3, 8).T * np.subtract(high, low)
        edges = [
            self.line(corners[a], corners[b])
            for a in range(8)
            for b in range(a + 1, 8)
            if (a ^ b).bit_count() == 1
        ]
        return self.shell((self.plane(0), edges))

    def rod(self, radius, low, high):
        """A cylinder by its two circles, each from one vertex to itself."""
        rims = []
        for z in (low, high):
            vertex = self.vertex((radius, 0, z))
            rims.append(
                self.add("EDGE_CURVE", "", vertex, vertex, self.circle(radius, origin=(0, 0, z)), E("T"))
            )
        wall = self.add("CYLINDRICAL_SURFACE", "", self.placement((0, 0, low)), float(radius))
        return self.shell((wall, rims), (self.plane(0), rims[:1]), (self.plane(0), rims[1:]))

    def piece(self, solid, finished=None):
        raw = self.add("WORKPIECE", "raw", None, None, None, solid, None, ())
        return self.add("WORKPIECE", "part", None, None, raw, finished, None, ())


def face_of(part, workpiece):
    course = part.add("LINEAR_PATH", None, part.size(80), part.direction(0, 1, 0))
    width = part.add("LINEAR_PROFILE", None, part.add("NUMERIC_PARAMETER", "", 100.0, "mm"))
    return part.add(
        "PLANAR_FACE", "f", workpiece, (), part.placement((0, 0, 0)), part.plane(-2), course, width, None, ()
    )


def faced(part, workpiece):
    own = (None, None, "op", 5.0, None, part.tool("T", 20.0), part.technology(), None)
    operation = part.add("PLANE_FINISH_MILLING", *own, None, None, None, None, 2.0, None)
    part.mill(face_of(part, workpiece), operation)
    return part.text()


def test_a_brick_is_a_raw_piece(tmp_path):
    part = Solids()
    program = tmp_path / "t.stp"
    program.write_text(faced(part, part.piece(part.brick((0, 0, -20), (100, 80, 0)))))
    removal = cut(str(program))
    assert removal.stock.raw_volume == pytest.approx(100 * 80 * 20)
    assert removal.stock.raw_volume - removal.stock.volume == pytest.approx(100 * 80 * 2)


@pytest.mark.parametrize("forward", [True, False])
def test_an_arc_counts_as_far_as_it_goes(forward):
    """A sector from X to Y, and the other way round: half a turn of the circle more on both sides."""
    part = Solids()
    a, b = part.vertex((10, 0, 0)), part.vertex((0, 10, 0))
    arc = part.add("EDGE_CURVE", "", a, b, part.circle(10.0), E("T" if forward else "F"))
    solid = part.shell((part.plane(0), [arc, part.line((0, 10, 0), (0, 10, 5))]))
    (raw,) = cut_program(faced(part, part.piece(solid)).encode()).raw
    low = 0.0 if forward else -10.0
    np.testing.assert_allclose(raw.frame[:3, 3], [low, low, 0.0], atol=1e-9)
    np.testing.assert_allclose(raw.size, [10 - low, 10 - low, 5.0])


def test_a_bar_is_a_cylinder_that_can_be_turned(tmp_path):
    class Shaft(Turned, Solids):
        pass

    part = Shaft(50, 100)
    part.workpiece = part.piece(part.rod(20.0, -80, 1))
    part.turn("FACING_FINISH", part.face(20), part.turning_tool(0.4))
    program = tmp_path / "t.stp"
    program.write_text(part.whole())
    removal = cut(str(program))
    assert removal.stock.raw_volume == pytest.approx(math.pi * 400 * 81, rel=1e-9)
    assert removal.stock.raw_volume - removal.stock.volume == pytest.approx(math.pi * 400, rel=1e-2)


def test_the_shape_of_the_part_alone_is_no_raw_piece(tmp_path, cncgen):
    """It is named in the hint: the raw piece is larger."""
    part = Solids()
    program = tmp_path / "t.stp"
    workpiece = part.add(
        "WORKPIECE", "part", None, None, None, part.brick((0, 0, -20), (100, 80, -2)), None, ()
    )
    program.write_text(faced(part, workpiece))
    done = cncgen("cut", program)
    assert done.returncode == 2
    assert b"box:0,0,-20,100,80,-2" in done.stderr

"""Polar coordinate and cylindrical interpolation: the manual's examples, put back on the part (B-64304EN-1)."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest

#: The example of the manual, "Polar coordinate interpolation", without its cutter compensation: places in radius and axis C.
POLAR = """T0101
G98 G97 S1000 M3
G0 X120. C0 Z5.
{on}
G1 X40. F200.
C10.
G3 X20. C20. R10.
G1 X-40.
C-10.
G3 X-20. C-20. I10. J0
G1 X40.
C0
X120.
{off}
G0 X200.
M30
"""
#: Corners of it and centres of its arcs on the part, with their radius.
CORNERS = [
    (60, 0),
    (20, 0),
    (20, 10),
    (10, 20),
    (-20, 20),
    (-20, -10),
    (-10, -20),
    (20, -20),
    (20, 0),
    (60, 0),
]
ARCS = {2: (10 + 10j), 5: (-10 - 10j)}


def rows(out: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return X, Z and C (degrees) of the motions and their times in minutes (inverse time), not those of traverses."""
    assert out.errors == []
    path = out.path
    keep = path.kind != 3
    columns = [path.axes.index(letter) for letter in "XZC"]
    places = path.end[keep][:, columns].copy()
    places[:, 2] = np.degrees(places[:, 2])
    return places, np.where(np.isfinite(path.feed[keep]), 1.0 / (60.0 * path.feed[keep]), 0.0)


def off_contour(points: np.ndarray) -> np.ndarray:
    """Return how far points of the part are from the contour of the example."""
    corners = [complex(*corner) for corner in CORNERS]
    away = np.full(len(points), np.inf)
    for k, (a, b) in enumerate(itertools.pairwise(corners)):
        if k in ARCS:
            spoke = points - ARCS[k]
            there = np.abs(np.abs(spoke) - 10.0)
            middle = (a + b) / 2.0 - ARCS[k]
            there[(spoke * np.conj(middle)).real < 0.0] = np.inf
        else:
            t = np.clip(((points - a) * np.conj(b - a)).real / abs(b - a) ** 2, 0.0, 1.0)
            there = np.abs(points - a - t * (b - a))
        away = np.minimum(away, there)
    return away


@pytest.mark.parametrize(("on", "off"), [("G12.1", "G13.1"), ("G112", "G113")])
def test_the_polar_example_of_the_manual(run: Any, on: str, off: str) -> None:
    places, minutes = rows(run(POLAR.format(on=on, off=off), dialect="fanuc-lathe"))
    cut = slice(1, -1)
    x, c = places[cut, 0], places[cut, 2]
    # Between the ends of lines too: the axes go evenly from one to the next.
    share = np.linspace(0.0, 1.0, 11)[:, None]
    x_between, c_between = (v[:-1] + share * np.diff(v) for v in (x, c))
    part = x_between * np.exp(1j * np.radians(c_between))
    assert off_contour(part.ravel()).max() < 0.0011
    assert c[-1] == pytest.approx(360.0, abs=1e-9)
    assert places[-1].tolist() == pytest.approx([100.0, 5.0, 360.0])
    length = sum(abs(complex(*b) - complex(*a)) for a, b in itertools.pairwise(CORNERS))
    length += 2 * (5.0 * math.pi - 10.0 * math.sqrt(2.0))
    assert minutes.sum() == pytest.approx(length / 200.0, rel=1e-6)


def test_polar_interpolation_begins_at_the_angle_of_the_axis(run: Any) -> None:
    """The hypothetical axis is 0 where the tool is when G12.1 comes; the axis C is at 30 degrees here."""
    out = run("G98 G0 X20. C30. Z0\nG12.1\nG1 C10. F100.\nG13.1\nM30", dialect="fanuc-lathe")
    places, _ = rows(out)
    assert places[-1].tolist() == pytest.approx([math.sqrt(200.0), 0.0, 30.0 + 45.0])


def test_a_line_through_the_centre(run: Any) -> None:
    """C turns half round where the tool passes the centre; X stays above 0."""
    places, _ = rows(run("G98 G0 X20. C0 Z0\nG12.1\nG1 X-20. F100.\nG13.1\nM30", dialect="fanuc-lathe"))
    assert places[:, 0].min() >= 0.0
    assert places[-1, 0] == pytest.approx(10.0)
    assert abs(places[-1, 2]) == pytest.approx(180.0)


def test_cutter_compensation_in_the_hypothetical_plane(run: Any, tmp_path: Any) -> None:
    """The example with G42: a tool of radius 2 goes round at 22 from the middle of its long sides."""
    table = tmp_path / "a.tbl"
    table.write_text("T1 P1 D4\n")
    text = (
        POLAR.format(on="G12.1", off="G13.1")
        .replace("G1 X40.", "G42 G1 X40.", 1)
        .replace("\nX120.", "\nG40 X120.")
    )
    places, _ = rows(run(text, dialect="fanuc-lathe", tool_table=table))
    part = places[1:-1, 0] * np.exp(1j * np.radians(places[1:-1, 2]))
    assert part.real.min() == pytest.approx(-22.0, abs=1e-3)
    assert (part.imag.max(), part.imag.min()) == pytest.approx((22.0, -22.0), abs=1e-3)


HAAS = """T101
G20 G98 G97
G0 X2.35 C0 Z.1
G112
G0 X-.75 Y.5
G1 Z0 F10.
X.45
G2 X.5 Y.45 R.05
G1 Y-.45
G113
G18
G0 X3.
M30
"""


def test_haas_has_x_and_y_in_radius(run: Any) -> None:
    """The corner of the square of the example, 0.5 from the middle both ways (Haas lathe operator's manual, G112)."""
    places, _ = rows(run(HAAS, dialect="fanuc-lathe"))
    part = places[:, 0] / 25.4 * np.exp(1j * np.radians(places[:, 2]))
    assert part[-2] == pytest.approx(0.5 - 0.45j, abs=1e-9)
    assert (part.real[3:-1].max(), part.imag[3:-1].max()) == pytest.approx((0.5, 0.5), abs=1e-6)
    assert places[-1, 0] == pytest.approx(1.5 * 25.4)


#: The manual's example of cylindrical interpolation: a radius of 57.299, where a degree is a millimetre.
CYLINDER = """G98 G97 S1000 M3
G0 Z100. C0 X40.
G1 G18 W0 H0 F250.
G7.1 C57.299
G1 Z120. F250.
C30.
G3 Z90. C60. R30.
G1 Z70.
G2 Z60. C70. R10.
G1 C150.
G2 Z70. C190. R75.
G1 Z110. C230.
G2 Z120. C270. R75.
G1 C360.
Z100.
G7.1 C0
G1 C0
M30
"""


def test_the_cylindrical_example_of_the_manual(run: Any) -> None:
    places, _ = rows(run(CYLINDER, dialect="fanuc-lathe"))
    assert set(places[2:, 0].round(9)) == {20.0}
    degree = math.radians(57.299)
    surface = places[:, 1] + 1j * places[:, 2] * degree
    first = [p for p in surface if 90.0 <= p.real < 120.0 and 30.0 * degree < p.imag < 60.0 * degree]
    # R30 about Z90 C30, as nearly as a degree is a millimetre.
    assert len(first) > 20
    assert np.abs(np.abs(np.array(first) - (90.0 + 30.0j * degree)) - 30.0).max() < 2e-3
    second = [p for p in surface if 60.0 <= p.real < 70.0 and 60.0 * degree < p.imag < 70.0 * degree]
    assert np.abs(np.abs(np.array(second) - (70.0 + 70.0j * degree)) - 10.0).max() < 2e-3
    assert places[-2].tolist() == pytest.approx([20.0, 100.0, 360.0])
    assert places[-1].tolist() == pytest.approx([20.0, 100.0, 0.0])


def test_a_mill_unrolls_a_cylinder_about_x(run: Any) -> None:
    """G7.1 A: words of A are degrees, arcs lie in X and the unrolled surface; G2 from above turns as in G17."""
    radius = 180.0 / math.pi
    out = run(
        f"G0 X0 A0 Z{radius} F100\nG7.1 A{radius}\nG1 X10.\nG2 X20. A-10. R10.\nG7.1 A0\nG1 A0\nM30",
        dialect="fanuc",
    )
    assert out.errors == []
    columns = [out.path.axes.index(letter) for letter in "XA"]
    points = out.path.end[out.path.kind != 3][:, columns] * [1.0, 180.0 / math.pi]
    arc = [complex(*p) for p in points if p[0] > 10.0 and p[1] < 0.0]
    assert np.abs(np.abs(np.array(arc) - (10.0 - 10.0j)) - 10.0).max() < 1e-6


@pytest.mark.parametrize(
    ("line", "code"),
    [("G28 U0 W0", "rotary-refused"), ("T0202", "rotary-refused"), ("G54", "rotary-refused"), ("G18", "rotary-refused"),
     ("G12.1", "rotary-refused"), ("G7.1 C10.", "rotary-refused"), ("G32 X10. F1.", "rotary-refused"),
     ("G92 X10. Z-5. F1.", "rotary-refused"), ("G76 X10. Z-5. P1000 Q100 F1.", "rotary-refused")],
)  # fmt: skip
def test_what_does_not_go_with_it(run: Any, line: str, code: str) -> None:
    out = run(f"G98 G0 X20. C0 Z0\nG12.1\n{line}\nG13.1\nM30", dialect="fanuc-lathe")
    assert [error[0] for error in out.errors] == [code]


def test_a_cylinder_needs_its_axis(run: Any) -> None:
    assert run("G7.1 C-5.\nM30", dialect="fanuc").errors == [("axis-missing", 1, 6)]
    assert run("G7.1\nM30", dialect="fanuc").errors == [("axis-missing", 1, 1)]

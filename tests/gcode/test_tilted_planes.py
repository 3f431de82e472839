"""Tilted planes G68.2: places worked out by hand from the rotations that the manual names (B-64484EN-2, 7.8)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cncgen.machine.kinematics import Kinematics

HALF = math.sqrt(0.5)


def last(run: Any, plane: str, line: str = "G1 X1. Y2. Z5. F100.") -> list[float]:
    """Return where a motion in a tilted plane leads."""
    out = run(f"G90 G21\n{plane}\nG53.1\n{line}\nM30", dialect="fanuc")
    assert out.errors == []
    assert sum(d.code == "swivel-frame" for d in out.diagnostics) == 1
    return out.path.end[out.path.kind != 3][-1, :3].tolist()


def test_a_plane_without_angles_is_one(run: Any) -> None:
    """Posts write G68.2 I0 J0 K0 and G53.1 for the first side: nothing is turned, and nothing is missing."""
    for plane in ("G68.2 X0 Y0 Z0 I0 J0 K0", "G68.2 P0 X0 Y0 Z0", "G68.2 P1 Q123 X0 Y0 Z0 I0 J0 K0"):
        out = run(f"G90 G21\n{plane}\nG53.1 P1\nG1 X1. Y2. Z5. F100.\nG69\nG0 X0\nM30", dialect="fanuc")
        assert out.diagnostics == []
        assert out.path.end[out.path.kind != 3][:, :3].tolist() == [[1, 2, 5], [0, 2, 5]]


@pytest.mark.parametrize(
    ("plane", "place"),
    [
        # About X by 90 degrees: Y goes to Z, Z to -Y.
        ("G68.2 X10. Y20. Z30. I0 J90. K0", [11, 15, 32]),
        # About Z by 90, the new X by 45, the new Z by -90: about Y by 45.
        ("G68.2 X0 Y0 Z0 I90. J45. K-90.", [6 * HALF, 2, 4 * HALF]),
        # About Z alone.
        ("G68.2 X0 Y0 Z0 I30. J0 K60.", [-2, 1, 5]),
        # About X by 90, then Y of the workpiece by 90: (1, 2, 5) to (1, -5, 2) to (2, -5, -1).
        ("G68.2 P1 Q123 X0 Y0 Z0 I90. J90. K0", [2, -5, -1]),
        # The other way round: (1, 2, 5) to (5, 2, -1) to (5, 1, 2).
        ("G68.2 P1 Q213 X0 Y0 Z0 I90. J90. K0", [5, 1, 2]),
    ],
)
def test_places_in_a_tilted_plane(run: Any, plane: str, place: list[float]) -> None:
    assert last(run, plane) == pytest.approx(place, abs=1e-9)


@pytest.mark.parametrize(
    ("angles", "place"),
    [
        # About X by 90, then Y of the workpiece by 90, as G68.2 P1 Q123 above; about Y alone: X goes to -Z, Z to X.
        ("I90. J90. K0", [12, 15, 29]),
        ("I0 J90. K0", [15, 22, 29]),
    ],
)
def test_the_planes_of_haas(run: Any, angles: str, place: list[float]) -> None:
    """Posts for its mills write G268 with Q123 for angles about the fixed axes, and G253 behind it; G269 ends it."""
    out = run(
        f"G90 G21\nG268 X10. Y20. Z30. {angles} Q123\nG253\nG1 X1. Y2. Z5. F100.\nG269\nX1.\nM30",
        dialect="fanuc",
    )
    assert (out.errors, [d.code for d in out.diagnostics]) == ([], ["swivel-frame"])
    ends = out.path.end[out.path.kind != 3][:, :3].round(9).tolist()
    assert ends == [place, [1, *place[1:]]]


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("G268 X0 Y0 Z0 I0 J90. K0", ("plane-kind", 1, 1)),
        ("G268 X0 Y0 Z0 I0 J90. K0 Q321", ("plane-kind", 1, 26)),
        ("G253", ("plane-missing", 1, 1)),
    ],
)
def test_what_the_planes_of_haas_need(run: Any, text: str, error: tuple[str, int, int]) -> None:
    assert run(text + "\nM30", dialect="fanuc").errors == [error]


def test_cycles_and_incremental_moves_follow_the_plane(run: Any) -> None:
    """A hole of 4 along Z of a plane that is turned by 90 degrees about X goes along Y."""
    text = "G68.2 X0 Y0 Z0 I0 J90. K0\nG53.1\nG0 X0 Y0 Z10.\nG98 G81 X3. Y1. Z-4. R2. F100.\nG80\nG91 G0 X1.\nG90 G69\nG0 Z0\nM30"
    out = run(text, dialect="fanuc")
    assert out.errors == []
    rows = out.path.end[out.path.kind != 3][:, :3].round(9).tolist()
    assert rows == [[0, -10, 0], [3, -10, 1], [3, -2, 1], [3, 4, 1], [3, -10, 1], [4, -10, 1], [4, -10, 0]]


def test_an_arc_in_a_tilted_plane_is_the_same_arc(run: Any) -> None:
    out = run("G68.2 X0 Y0 Z0 I0 J90. K0\nG0 X10. Y0\nG3 X0 Y10. I-10. J0 F100.\nM30", dialect="fanuc")
    assert out.errors == []
    assert out.path.end[out.path.kind != 3][-1, :3].tolist() == pytest.approx([0, 0, 10], abs=1e-9)


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("G53.1", ("plane-missing", 1, 1)),
        ("G68.2 P2 X0 Y0 Z0", ("plane-points", 1, 7)),
        # Its blocks are counted no further: a list of as many ended in no memory.
        ("G68.2 P2 Q1 X0 Y0 Z0\nG68.2 P2 Q90000000 X1.", ("plane-points", 2, 7)),
        ("G68.2 P4 X0 Y0 Z0", ("plane-kind", 1, 7)),
        ("G68.2 P1 Q122 X0 Y0 Z0 I1.", ("plane-kind", 1, 10)),
        ("G68 X0 Y0 R30.\nG68.2 X0 Y0 Z0 J90.", ("frame-compensation", 2, 1)),
        ("G68.2 X0 Y0 Z0 J90.\nG51 X0 Y0 P2.", ("frame-compensation", 2, 1)),
    ],
)
def test_what_a_tilted_plane_needs(run: Any, text: str, error: tuple[str, int, int]) -> None:
    assert run(text + "\nM30", dialect="fanuc").errors == [error]


def test_g53_1_turns_the_axes_of_a_machine(run: Any) -> None:
    """About Y by 30: A30 C90 or A-30 C-90 of a trunnion. A tip p stands at c + R1(-A) R2(-C) (p - c), and G43 comes behind as usual."""
    centre = np.array((0.0, 0.0, -100.0))
    text = "G90 G21\nG0 X1. Y2. Z3.\nG68.2 X10. Y0 Z0 I90. J30. K-90.\nG53.1\nG43 H1 Z5.\nX3. Y4.\nG69\nM30"
    out = run(text, dialect="fanuc", kinematics=Kinematics(0, (3, 5), tuple(centre)))
    assert (out.errors, [d.code for d in out.diagnostics if d.code == "swivel-frame"]) == ([], [])
    ends = out.path.end[out.path.kind != 3]
    a, c = ends[1, 3:]
    assert (ends[1, :3].tolist(), abs(np.degrees(a)), abs(np.degrees(c))) == (
        [1, 2, 3],
        *map(pytest.approx, (30, 90)),
    )

    def turned(axis: int, angle: float) -> np.ndarray:
        out = np.eye(3)
        p, q = (axis + 1) % 3, (axis + 2) % 3
        out[p, p] = out[q, q] = math.cos(angle)
        out[q, p] = math.sin(angle)
        out[p, q] = -out[q, p]
        return out

    tip = np.array((10, 0, 0)) + turned(1, math.radians(30)) @ (3, 4, 5)
    assert ends[-1, :3] == pytest.approx(centre + turned(0, -a) @ turned(2, -c) @ (tip - centre), abs=1e-6)


@pytest.mark.parametrize(
    ("line", "turns", "pitch"),
    [("G3 X0 Y0 Z-3. I-5. J0 F100.", 1, -3.0), ("G2 X-10. Y0 Z2. I-5. J0 P3 F100.", 2.5, 0.8)],
)
def test_a_helix_in_a_tilted_plane_is_one(run: Any, line: str, turns: float, pitch: float) -> None:
    """Ramps of posts: about (-5, 0) with radius 5, and Z in step with the angle; the plane leads X Y Z to X -Z Y (about X by 90 degrees).

    The length is that of the exact helix.
    """
    out = run(f"G90 G21\nG68.2 X0 Y0 Z0 I0 J90. K0\nG53.1\nG0 X0 Y0 Z0\n{line}\nM30", dialect="fanuc")
    assert out.errors == []
    path = out.path.path
    assert path.length == pytest.approx(turns * math.hypot(10.0 * math.pi, pitch), rel=1e-8)
    points = path.evaluate(np.linspace(0.0, path.length, 500))[0][:, :3]
    x, y, z = points[:, 0], points[:, 2], -points[:, 1]
    assert np.hypot(x + 5.0, y) == pytest.approx(np.full(500, 5.0), abs=1e-7)
    angle = np.abs(np.unwrap(np.arctan2(y, x + 5.0)))
    np.testing.assert_allclose(z, pitch * angle / (2.0 * math.pi), atol=2e-6 * abs(pitch))

"""SINUMERIK: directions of the tool under TRAORI (A3 B3 C3) and its turn in a plane (ORIVECT), by closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cncgen.machine.kinematics import Kinematics, unit_vector

CENTRE = (0.0, 0.0, -100.0)
#: A carries C in the table of a trunnion; C carries A in a fork head.
TRUNNION, FORK = Kinematics(0, (3, 5), CENTRE), Kinematics(2, (5, 3), pivot=50.0)


def angles(run: Any, text: str, kinematics: Kinematics) -> list[list[float]]:
    """Return the positions of the rotary axes at the ends of the motions, degrees, in the order of the columns."""
    out = run(f"TRAORI\n{text}\nTRAFOOF\nM30", dialect="sinumerik", kinematics=kinematics)
    assert out.errors == []
    rows = out.path.kind < 3
    return np.degrees(out.path.end[rows, 3:]).round(6).tolist()  # type: ignore[no-any-return]


@pytest.mark.parametrize("kinematics", [TRUNNION, FORK])
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        # About X, z becomes (0, -sin A, cos A); C then turns it about Z.
        ("X1 C3=1", [0, 0]),
        ("A3=0 B3=-1 C3=1", [45, 0]),
        ("A3=0 B3=-2 C3=2", [45, 0]),
        # The nearer of A45 C90 and A-45 C-90 is either; the one with A above 0 comes first.
        ("A3=1 B3=0 C3=1", [45, 90]),
        ("A3=0 B3=1 C3=1", [-45, 0]),
        ("A3=1 B3=-1 C3=0", [90, 45]),
        # An axis along the tool stays where it is.
        ("A3=0 B3=-1 C3=1\nG0 A3=0 B3=0 C3=1", [0, 0]),
        ("A3=1 B3=0 C3=1\nG0 A3=0 B3=0 C3=1", [0, 90]),
    ],
)
def test_directions_are_positions_of_the_axes(
    run: Any, kinematics: Kinematics, words: str, expected: list[float]
) -> None:
    assert angles(run, f"G0 {words}", kinematics)[-1] == expected


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        # z turned about X by B2 becomes (0, -sin, cos), which A2 turns about Z: A45 C30 of the fork.
        ("ORIEULER\nG0 A2=30 B2=45 C2=77", [45, 30]),
        # Rz(90) Ry(B2) z = Rz(90) (sin B2, 0, cos B2) = (0, sin B2, cos B2); A-45.
        ("ORIRPY\nG0 A2=0 B2=45 C2=90", [-45, 0]),
        # Rz(C2) Rx(A2) z: as Euler angles with A2 and C2 exchanged.
        ("ORIRPY\nG0 A2=45 B2=0 C2=30", [45, 30]),
    ],
)
def test_angles_of_the_tool(run: Any, words: str, expected: list[float]) -> None:
    """RPY: "with C2 around the Z axis, then with B2 around the new Y axis and lastly with A2 around the new X axis"; Euler: A2 about Z, B2 about
    the new X, C2 about the new Z (828D, Job planning 07/2010). The printed example, C2 = 90, B2 = 45, A2 = 30, by matrices."""
    assert angles(run, words, TRUNNION)[-1] == expected


def test_angles_of_the_printed_example(run: Any) -> None:
    """Rz(90) Ry(45) Rx(30) z = Rz(90) (cos 30 sin 45, -sin 30, cos 30 cos 45) = (sin 30, cos 30 sin 45, cos 30 cos 45)."""
    a, b = math.radians(30), math.radians(45)
    vector = (
        f"G0 A3={math.sin(a):.12f} B3={math.cos(a) * math.sin(b):.12f} C3={math.cos(a) * math.cos(b):.12f}"
    )
    assert angles(run, "ORIRPY\nG0 A2=30 B2=45 C2=90", FORK)[-1] == pytest.approx(
        angles(run, vector, FORK)[-1], abs=1e-6
    )


def test_angles_without_a_kind_are_told_of(run: Any) -> None:
    out = run("TRAORI\nG0 A2=30 B2=45\nTRAFOOF\nM30", dialect="sinumerik", kinematics=TRUNNION)
    assert "orientation-angles" in [d.code for d in out.diagnostics]


def test_positions_follow_on_over_a_turn(run: Any) -> None:
    """The direction goes round the cone of 45 degrees in steps of 60: C goes on, and back at the nearer side."""
    steps = [
        f"G0 A3={math.sin(math.radians(c)):.15f} B3={-math.cos(math.radians(c)):.15f} C3=1"
        for c in range(0, 421, 60)
    ]
    assert [c for _, c in angles(run, "\n".join(steps), TRUNNION)] == pytest.approx(
        [60 * k for k in range(8)]
    )


def test_a_tip_is_followed_from_where_it_is_under_a_frame(run: Any) -> None:
    """TRAORI and TRAFOOF leave the tool where it is, and so does each coordinate that is programmed again."""
    text = "ROT Z30\nG0 X1 Y2 Z3\nTRAORI\nG0 A20 C30\nG0 X1\nG0 Y2\nG0 Z3\nTRAFOOF\nG0 A0 C0\nM30"
    out = run(text, dialect="sinumerik", kinematics=TRUNNION)
    ends = out.path.end[out.path.kind < 3][:, :3]
    # p of the workpiece stands at c + R1(-20) R2(-30) (p - c), p is (1, 2) turned by 30.
    c, s = math.cos(math.radians(20)), math.sin(math.radians(20))
    x, y, z = 1.0, 2.0, 103.0
    expected = [x, c * y + s * z, c * z - s * y - 100.0]
    assert len(ends) > 3
    assert ends[1:] == pytest.approx(np.array([expected] * (len(ends) - 1)), abs=1e-6)


def test_frames_turn_directions_but_those_of_the_machine(run: Any) -> None:
    """ROT Z90 takes (0, -1, 1) to (1, 0, 1)."""
    text = "ROT Z90\n{}\nG0 A3=0 B3=-1 C3=1"
    assert angles(run, text.format("ORIWKS"), TRUNNION)[-1] == [45, 90]
    assert angles(run, text.format("ORIMKS"), TRUNNION)[-1] == [45, 0]


def directions(run: Any, words: str) -> list[tuple[float, float, float]]:
    """Return the directions in which the tool comes, from (0, -1, 1) to (1, 0, 1)."""
    text = f"G0 X0 Y0 Z0 A3=0 B3=-1 C3=1\n{words}\nG1 X20 A3=1 B3=0 C3=1 F1000"
    return [TRUNNION.direction((a, c)) for a, c in angles(run, text, TRUNNION)]


def test_the_tool_stays_in_the_plane_of_its_directions(run: Any) -> None:
    """ORIVECT: the normal of the plane is (0, -1, 1) x (1, 0, 1); ORIAXES leads off it, by 35.26 degrees of A against 45 at half way."""
    normal = np.array(unit_vector((-1.0, 1.0, 1.0)))
    assert np.abs(np.array(directions(run, "ORIVECT")) @ normal).max() < math.radians(0.011)
    off = np.abs(np.array(directions(run, "ORIAXES")) @ normal).max()
    assert math.degrees(math.asin(off)) == pytest.approx(
        45.0 - math.degrees(math.atan(math.sqrt(0.5))), abs=0.01
    )


def test_a_turn_that_nothing_states_is_said(run: Any) -> None:
    text = "TRAORI\nG0 A3=0 B3=-1 C3=1\n{}G1 X20 A3=1 B3=0 C3=1 F1000\nTRAFOOF\nM30"
    for words, said in (("", ["orientation-path"]), ("ORIAXES\n", []), ("ORIVECT\n", [])):
        found = run(text.format(words), dialect="sinumerik", kinematics=TRUNNION).diagnostics
        assert [d.code for d in found if d.severity.value == "warning"] == said


def test_only_the_machines_axes_have_columns(run: Any) -> None:
    """A3 B3 C3 name no axes: a trunnion of A and C has no column of B."""
    assert (
        run("TRAORI\nG0 X1 B3=-1 C3=1\nM30", dialect="sinumerik", kinematics=TRUNNION).moving_axes == "XYZAC"
    )


@pytest.mark.parametrize(
    ("line", "code", "part"),
    [
        ("G0 A3=0 B3=0 C3=0", "orientation-vector", "has no length"),
        ("G0 A3=1 C5", "orientation-vector", "beside C"),
        ("TRAFOOF\nG0 A3=1", "unused-word", "TRAORI"),
        ("ORIRPY\nG0 A2=10 B2=5", "not-read", "C2 is missing"),
        ("G1 LEAD=5 X1 F100", "not-read", "angle of the tool"),
        ("ORICURVE", "not-read", "cone or a curve"),
    ],
)
def test_faults(run: Any, line: str, code: str, part: str) -> None:
    found = run(f"TRAORI\n{line}\nM30", dialect="sinumerik", kinematics=TRUNNION).diagnostics
    error = next(d for d in found if d.severity == "error")
    assert error.code == code
    assert part in error.message


def test_axes_that_cannot_tilt_the_tool(run: Any) -> None:
    """With C next to the tool nothing tilts it."""
    found = run(
        "TRAORI\nG0 A3=1\nM30", dialect="sinumerik", kinematics=Kinematics(2, (3, 5), pivot=50.0)
    ).diagnostics
    assert [d.code for d in found if d.severity == "error"] == ["orientation-vector"]


def test_angles_are_the_inverse_of_the_direction() -> None:
    """On random directions and kinds of machines: back to the direction, and no pair found is farther than a half turn of both."""
    random = np.random.default_rng(21)
    for heads, axes in (
        (0, (3, 5)),
        (0, (4, 5)),
        (0, (3, 4)),
        (1, (3, 5)),
        (1, (4, 5)),
        (1, (4, 3)),
        (2, (5, 3)),
        (2, (5, 4)),
        (2, (3, 4)),
    ):
        kinematics = Kinematics(heads, axes)
        for _ in range(200):
            wanted, near = unit_vector(tuple(random.normal(size=3))), tuple(random.uniform(-720, 720, 2))
            found = kinematics.angles_of(wanted, near)
            assert found is not None
            assert kinematics.direction(found) == pytest.approx(wanted, abs=1e-9)
            assert max(abs(a - b) for a, b in zip(found, near, strict=True)) <= 180.0 + 1e-9


@pytest.mark.parametrize(
    ("kinematics", "ways"),
    [
        # A table that is turned by A30 has its plane square to the spindle: machine axes go along those of the program.
        (TRUNNION, [(0, 0, 10), (10, 0, 0), (0, 10, 0)]),
        # A head that is turned by A30 points to (0, -sin 30, cos 30); the new X is that of before, Y = Z x X.
        (FORK, [(0, -5, 5 * 3**0.5), (10, 0, 0), (0, 5 * 3**0.5, 5)]),
    ],
)
def test_torot_turns_the_coordinates_to_the_tool(
    run: Any, kinematics: Kinematics, ways: list[tuple[float, ...]]
) -> None:
    """840D sl, Fundamentals 09/2011, 12.8: a frame whose Z axis coincides with the tool; it was refused. TOROTOF was passed over."""
    text = "TRAORI\nG0 X1 Y2 Z3 A30\n{}G0 X0 Y0 Z0\nZ10\nX10\nY10\nTRAFOOF\nM30"
    out = run(text.format("TOROT\n"), dialect="sinumerik", kinematics=kinematics)
    assert out.errors == []
    ends = out.path.end[out.path.kind < 3, :3]
    np.testing.assert_allclose(np.diff(ends[-4:], axis=0), ways, atol=1e-9)
    plain, back = (
        run(text.format(said), dialect="sinumerik", kinematics=kinematics).path
        for said in ("", "TOROT\nTOROTOF\n")
    )
    np.testing.assert_allclose(back.end[back.kind < 3], plain.end[plain.kind < 3], atol=1e-9)


COS = 5.0 * 3**0.5


@pytest.mark.parametrize(
    ("said", "shift", "ways"),
    [
        # A frame of a rotation alone: the shift of TRANS ends. The head at A30 points to t = (0, -sin 30, cos 30).
        ("TOFRAME", (0, 0, 0), [(10, 0, 0), (0, COS, 5), (0, -5, COS)]),
        ("TOFRAMEZ", (0, 0, 0), [(10, 0, 0), (0, COS, 5), (0, -5, COS)]),
        ("TOROTZ", (7, 8, 9), [(10, 0, 0), (0, COS, 5), (0, -5, COS)]),
        # Y along t; the new Z in the plane Y Z of before, a right angle on from Y: (0, -cos 30, -sin 30); X = Y x Z.
        ("TOROTY", (7, 8, 9), [(10, 0, 0), (0, -5, COS), (0, -COS, -5)]),
        ("TOFRAMEY", (0, 0, 0), [(10, 0, 0), (0, -5, COS), (0, -COS, -5)]),
        # X along t; the new Y in the plane X Y of before, square to t: X of before; Z = X x Y = (0, cos 30, sin 30).
        ("TOROTX", (7, 8, 9), [(0, -5, COS), (10, 0, 0), (0, COS, 5)]),
        ("TOFRAMEX", (0, 0, 0), [(0, -5, COS), (10, 0, 0), (0, COS, 5)]),
    ],
)
def test_an_axis_of_the_frame_is_along_the_tool(
    run: Any, said: str, shift: tuple[float, ...], ways: list[tuple[float, ...]]
) -> None:
    """Function Manual Axis Types 08/2005, 2.4, p. 104: the tool's direction is Z, Y or X, and X, Z or Y the secondary axis; all but TOROT were refused."""
    text = f"TRAORI\nTRANS X7 Y8 Z9\nG0 X1 Y2 Z3 A30\n{said}\nG0 X0 Y0 Z0\nX10\nX0 Y10\nY0 Z10\nTOROTOF\nTRANS\nX0 Y0 Z0\nTRAFOOF\nM30"
    out = run(text, dialect="sinumerik", kinematics=FORK)
    assert out.errors == []
    assert any(said in d.message for d in out.diagnostics if d.code == "swivel-frame")
    ends = out.path.end[out.path.kind < 3, :3]
    origin = ends[-5]
    np.testing.assert_allclose(origin - ends[-1], shift, atol=1e-9)
    np.testing.assert_allclose(ends[-4:-1] - origin, ways, atol=1e-9)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("TOROT", "tcp-machine"),
        ("TOFRAMEX", "tcp-machine"),
        ("TRAORI\nTOROTX", "plane-points"),
        ("TRAORI\nSCALE X2 Y2 Z2\nTOROT", "not-read"),
        ("TRAORI\nMIRROR X0\nTOROTY", "not-read"),
    ],
)
def test_torot_of_what_it_cannot_turn_is_refused(run: Any, text: str, code: str) -> None:
    """No tool that turns; a tool along Z, where both axes beside X lie in the plane X Y; scales, which TOROT took out without a word."""
    kinematics = FORK if "TRAORI" in text else None
    out = run(f"{text}\nG0 X1\nM30", dialect="sinumerik", kinematics=kinematics)
    assert [found for found, *_ in out.errors] == [code]

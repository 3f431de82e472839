"""FANUC's lathes: lines by their angle, chamfers C, drilling along Z and X, and roughing under cutter compensation.

Expected places are closed forms: a line at A from (X, Z) is at X + 2 t sin A, Z + t cos A, X a diameter (B-64304EN-1, 5.3).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cncgen.toolpath.record import Kind

from .test_lathe_fanuc import moves, outcome


def places(text: str) -> list[tuple[float, float]]:
    """Return where the motions of a text lead, X as a diameter."""
    return [(round(2 * x, 6), round(z, 6)) for x, z, _ in moves(text)]


def codes(text: str, severity: str) -> list[str]:
    return [d.code for d in outcome(text)[2].diagnostics if d.severity == severity]


def test_an_angle_stands_for_x_or_z() -> None:
    head = "G0 X40. Z0\nG1 F.2 "
    down = 10.0 / math.tan(math.radians(30.0))
    assert places(head + "X60. A150.")[-1] == (60.0, round(-down, 6))
    # The line has no direction: A-30 is the same.
    assert places(head + "X60. A-30.")[-1] == (60.0, round(-down, 6))
    assert places(head + "Z-20. A135.")[-1] == (80.0, -20.0)
    assert places(head + "Z-20. A180.")[-1] == (40.0, -20.0)
    assert places(head + "X60. ,A90.")[-1] == (60.0, 0.0)


@pytest.mark.parametrize("between", ["\n", "\n(A COMMENT)\n\n"])
def test_two_angles_meet(between: str) -> None:
    """From (40, 0) at 170 degrees to a line at 112 degrees that ends in (300, -180), as a drawing has them."""
    found = places(f"G0 X40. Z0\nG1 A170. F.2{between}X300. Z-180. A112.")
    a, b = math.radians(170.0), math.radians(112.0)
    # 20 + t sin a = 150 - u sin b, t cos a = -180 - u cos b.
    t, u = np.linalg.solve([[math.sin(a), math.sin(b)], [math.cos(a), math.cos(b)]], [130.0, -180.0])
    assert found[-2] == pytest.approx((40.0 + 2.0 * t * math.sin(a), t * math.cos(a)), abs=1e-6)
    assert found[-1] == (300.0, -180.0)
    assert u > 0.0


def test_corners_of_lines_by_angles() -> None:
    """C1 and R2 at right corners: 1 along both lines, and 2 (tan 45 = 1)."""
    found = places("G0 X0 Z0\nG1 X60. A90. C1. F.1\nZ-30. A180. R2.\nX100. A90.")
    assert found == [(58.0, 0.0), (60.0, -1.0), (60.0, -28.0), (64.0, -30.0), (100.0, -30.0)]


def test_c_beside_one_axis_is_a_chamfer_until_the_axis_c_moves() -> None:
    text = "G1 X40. F.1\nZ-10. C2.\nX60."
    assert places("G0 X30. Z0\n" + text)[-3:] == [(40.0, -8.0), (44.0, -10.0), (60.0, -10.0)]
    assert codes("G0 X30. Z0\n" + text, "warning") == ["other-control"]
    path, faults, program = outcome("G0 X30. Z0 C0\n" + text)
    assert faults == []
    assert path.end[path.kind != Kind.EVENT, program.axes.index("C")].max() == pytest.approx(
        math.radians(2.0)
    )


@pytest.mark.parametrize(
    ("last", "axes"),
    [
        ("X60.", "XZ"),
        ("X60. A90.", "XZ"),
        ("G0 C90.", "XZC"),
        ("H90.", "XZC"),
        ("X60. C2.\nZ-30.\nG0 C90.", "XZC"),
        ("G0 A90.", "XZA"),
    ],
)
def test_letters_of_drawings_are_no_axes(last: str, axes: str) -> None:
    """The setpoints had columns A and C of axes that a lathe with chamfers and angles does not have."""
    program = outcome(f"G0 X30. Z0\nG1 X40. F.1\nZ-10. C2.\nX50. A135.\n{last}")[2]
    assert (program.moving_axes, program.diagnostics.has_errors) == (axes, False)


def test_two_angles_that_never_meet_are_an_error() -> None:
    assert outcome("G0 X40. Z0\nG1 A170. F.2\nX30. Z-50. A-10.")[1][0][0] == "drawing-angle"
    assert outcome("G0 X40. Z0\nG1 A170. F.2\nX30. Z-50.")[1][0][0] == "drawing-angle"


def test_an_end_counts_more_than_its_angle() -> None:
    text = "G0 X40. Z0\nG1 X60. Z-20. A170. F.2"
    assert places(text)[-1] == (60.0, -20.0)
    assert codes(text, "warning") == ["drawing-angle"]


def test_a_peck_drill_leaves_the_hole_after_each_step() -> None:
    """Steps of 4 from Z2 to Z-7; the clearance is that of the mills' G83, 0.254."""
    found = [z for _, z in places("G0 X0 Z5.\nG83 Z-7. R-3. Q4000 F.1\nG80\nG0 Z20.")]
    assert found[-9:] == [2.0, -2.0, 2.0, -1.746, -6.0, 2.0, -5.746, -7.0, 5.0, 20.0][-9:]


@pytest.mark.parametrize(
    ("cycle", "expected"),
    [
        # A Swiss lathe's, whose Z points into the part: R is the place where the tool stands. Steps of 2, the clearance is 0.254.
        ("G0 Z-1.\nG83 Z4.5 R-1. Q2000", [-1, 1, -1, 0.746, 3, -1, 2.746, 4.5, -1]),
        ("G0 Z-5.\nG85 Z8. R3.", [-5, -2, 8, -2, -5]),
        ("G0 Z-5.\nG85 W8. R3.", [-5, -2, 6, -2, -5]),
    ],
)
def test_a_hole_on_a_second_spindle_leads_upwards(cycle: str, expected: list[float]) -> None:
    """The mirror image of the same hole downwards, with a warning."""
    text = f"G0 X0\n{cycle} F.1\nG80\nG0 Z-20."
    assert [z for _, z in places(text)][:-1] == expected
    assert "cycle-depth" in codes(text, "warning")


@pytest.mark.parametrize(
    ("r", "level", "warned"), [("R-3.", 2.0, ["cycle-level"]), ("R5.", 5.0, []), ("R1.", 1.0, [])]
)
def test_r_is_a_distance_or_the_place_that_can_be_meant(r: str, level: float, warned: list[str]) -> None:
    """Where R may be both, FANUC's distance is taken and the other named, once."""
    text = f"G0 X0 Z5.\nG85 Z-7. {r} F.1\nX2.\nG80"
    found = [z for _, z in places(text)]
    assert found[found.index(-7.0) + 1] == level
    assert codes(text, "warning") == warned


@pytest.mark.parametrize(
    ("cycle", "expected"),
    [
        # Steps of 3 in radius from the level R, whose distance is in radius: from X60 to X56 and down to X40; back to X60.
        ("G87 X40. R-2. Q5000", [56, 46, 56, 46.508, 40, 60]),
        ("G89 X40. R-2.", [56, 40, 56, 60]),
        # From R by 8 in radius: U is a distance in diameter.
        ("G89 U-16. R-2.", [56, 40, 56, 60]),
        ("G88 X40.", [40, 60]),
    ],
)
def test_holes_in_the_side_of_a_part(cycle: str, expected: list[float]) -> None:
    """G87, G88 and G89 are G83, G84 and G85 along X (B-64304EN-1, 5.1); the clearance is that of the mills' G83, 0.254."""
    found = places(f"M3 S500\nG0 X60. Z-5. C0\n{cycle} F.1\nG80\nG0 Z20.")
    assert found[1:-1] == [(x, -5.0) for x in expected]
    again = places(f"M3 S500\nG0 X60. Z-5. C0\n{cycle} F.1\nZ-15.\nG80\nG0 Z20.")
    assert again[-2 - len(expected) : -1] == [(60.0, -15.0), *((x, -15.0) for x in expected)]


@pytest.mark.parametrize(
    ("dialect", "holes", "expected"),
    [
        ("fanuc-lathe", "G98 G83 Z-10. R-3. F100. H30. K3", [30, 60, 90]),
        ("fanuc-lathe", "G98 G83 Z-10. R-3. F100. K0\nC45.\nH45. K2", [45, 90, 135]),
        ("fanuc-lathe", "G98 G83 Z-10. R-3. F100. C30. K2", [30, 30]),
        ("fanuc-lathe-b", "G94 G91 G83 Z-12. R-3. F100. C30. K3", [30, 60, 90]),
    ],
)
def test_k_repeats_a_hole_at_its_distances(run: Any, dialect: str, holes: str, expected: list[float]) -> None:
    """K is the number of repeats, and H the distance along C (B-64304EN-1, 5.1); in G91 of system B R is a distance from the level
    where the cycle began, and Z one from R: 5 - 3 - 12 = -10."""
    path = run(f"G21 G97 M3 S100\nG0 X50. Z5. C0\n{holes}\nG80\nM30", dialect=dialect).path
    drilled = path.end[np.isfinite(path.feed)]
    assert drilled[:, path.axes.index("Z")].round(9).tolist() == [-10.0] * len(expected)
    assert np.degrees(drilled[:, path.axes.index("C")]).round(9).tolist() == expected


def test_the_depth_of_a_hole_by_its_distance_from_r() -> None:
    found = [z for _, z in places("G0 X0 Z5.\nG85 W-9. R-3. F.1\nX2. W-4.\nG80\nG0 W1.")]
    assert found == [5.0, 2.0, -7.0, 2.0, 5.0, 5.0, 2.0, -2.0, 2.0, 5.0, 6.0]


def test_holes_repeat_until_g80() -> None:
    found = places("G0 X0 Z5.\nG81 Z-3. F.1\nX10.\nG80\nX20.")
    assert found == [(0.0, 5.0), (0.0, -3.0), (0.0, 5.0), (10.0, 5.0), (10.0, -3.0), (10.0, 5.0), (20.0, 5.0)]


def test_roughing_under_compensation_roughs_without_it() -> None:
    profile = "N1 G0 X20.\nG1 Z-20.\nN2 X40.\n"
    cycle = f"G71 U5. R1.\nG71 P1 Q2 U.4 W.1 F.2\n{profile}"
    plain = places(f"G0 X42. Z2.\n{cycle}")
    under = places(f"G0 X44. Z2.\nG42 G0 X42.\n{cycle}G40 G0 X60. Z5. T0100")
    assert under[-1 - len(plain) + 1 : -1] == plain[1:]
    assert "comp-roughing" in codes(f"G0 X44. Z2.\nG42 G0 X42.\n{cycle}", "warning")


def test_finishing_takes_the_profile_that_was_roughed() -> None:
    """N1 stands above as well, as the number of the tool's first block."""
    text = "N1 G0 X42. Z2.\nG71 U5. R1.\nG71 P1 Q2 U.4 W.1 F.2\nN1 G0 X20.\nG1 Z-20.\nN2 X40.\nG70 P1 Q2"
    assert places(text)[-4:] == [(20.0, 2.0), (20.0, -20.0), (40.0, -20.0), (42.0, 2.0)]


def test_all_axes_go_home_as_on_haas() -> None:
    assert places("G0 X42. Z2.\nG28")[-1] == (0.0, 0.0)
    assert codes("G0 X42. Z2.\nG28", "warning") == ["axis-missing"]


def test_a_traverse_at_the_end_of_a_profile_that_goes_back_is_not_roughed() -> None:
    """Haas's programs end their profiles with the way off, beside G40."""
    profile = "N1 G0 X20.\nG1 Z-20.\nX40.\n"
    head = "G0 X42. Z2.\nG71 U5. R1.\nG71 P1 Q2 U.4 W.1 F.2\n"
    plain = places(f"{head}{profile.replace('X40.', 'N2 X40.')}")
    assert places(f"{head}{profile}N2 G0 Z2.") == plain
    assert codes(f"{head}{profile}N2 G0 Z2.", "warning") == ["profile-way-off"]
    assert outcome(f"{head}{profile}N2 G1 Z2.")[1][0][0] == "profile-not-monotonic"


@pytest.mark.parametrize(
    ("cycle", "profile"),
    [
        ("G71 U2. R.5\nG71", "N1 G0 X{first}.\nN2 G1 X{last}. Z{end}."),
        ("G72 W2. R.5\nG72", "N1 G0 Z{end}.\nN2 G1 X{first}. Z0."),
    ],
)
@pytest.mark.parametrize(("start", "first", "last", "side"), [(60, 20, 50, 1), (10, 50, 20, -1)])
@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize(("u", "w"), [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_an_allowance_into_the_part_is_said(
    cycle: str, profile: str, start: int, first: int, last: int, side: int, way: int, u: int, w: int
) -> None:
    """Outside U is positive, inside negative; W is so where cuts begin at the larger Z (B-64304EN-1, the four patterns of ΔU and ΔW)."""
    lines = profile.format(first=first, last=last, end=-30 * way)
    text = f"G0 X{start}. Z{2 * way}.\n{cycle} P1 Q2 U{0.4 * u * side:g} W{0.1 * w * way:g} F.2\n{lines}"
    assert codes(text, "warning") == ["allowance-inside"] * ((u < 0) + (w < 0))


def test_an_allowance_in_inches_is_said_in_mm() -> None:
    """U is a diameter: half of 0.04 inch are 0.508 mm."""
    text = "G20\nG0 X2. Z.1\nG71 U.1 R.05\nG71 P1 Q2 U-.04 W.01 F.01\nN1 G0 X1.\nN2 G1 X2. Z-1."
    (found,) = [d for d in outcome(text)[2].diagnostics if d.severity == "warning"]
    assert "0.508 mm" in found.message


def test_g92_s_bounds_the_speed_as_g50_s_does() -> None:
    """G92 S was taken as the speed of the spindle."""
    for word, said in (("G92", ["other-control"]), ("G50", [])):
        path, faults, program = outcome(f"{word} S150\nG96 S200 M3\nG0 X42. Z2.\nG1 X1. F.1")
        assert faults == []
        assert [d.code for d in program.diagnostics if d.severity == "warning"] == said
        # 0.1 mm a turn at 150 turns a minute.
        assert np.nanmax(path.feed[path.kind != Kind.EVENT]) == pytest.approx(15.0 / 60.0)

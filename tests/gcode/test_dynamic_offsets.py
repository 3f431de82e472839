"""G254 of Haas: a table that has turned carries the origin of the work offset, and the axes stay those of the machine.

Expected places are closed forms. Haas, "UMC-750 Operator's Manual Supplement", G254: "G254 allows the user to define the part offset
once; the control moves it with the rotary table about its centre. [...] G255, M02 and M30 cancel it."
"""

from __future__ import annotations

from typing import Any

import pytest

from cncgen.machine.kinematics import Kinematics

#: A trunnion B that carries C, about (10, 20, -100) of the machine.
TABLE = Kinematics(0, (4, 5), (10.0, 20.0, -100.0))


def ends(run: Any, text: str, kinematics: Kinematics | None = TABLE, **options: Any) -> list[list[float]]:
    """Return where the motions of a text lead, in machine coordinates."""
    out = run(f"G21 G90\n{text}\nM30", dialect="fanuc", kinematics=kinematics, **options)
    assert out.errors == []
    return [list(map(float, row)) for row in out.path.end[out.path.kind != 3][:, :3].round(9) + 0.0]


def test_the_origin_goes_along(run: Any) -> None:
    """The origin (40, 20, -80) stands 30 beside the axis of C: at C90 it is 30 before or behind it, and X stays the machine's X."""
    head = "G10 L2 P1 X40. Y20. Z-80.\nG0 C90.\nG254\nX1. Y2. Z3."
    (x, y, z) = ends(run, head)[-1]
    assert (x, abs(y - 22.0), z) == (11.0, 30.0, -77.0)
    # With C at 0, and after G255, the coordinates are those of G54.
    assert ends(run, head.replace("C90.", "C0."))[-1] == [41.0, 22.0, -77.0]
    assert ends(run, f"{head}\nG255\nX1. Y2. Z3.")[-1] == [41.0, 22.0, -77.0]


def test_it_is_where_the_equations_have_it(run: Any) -> None:
    """B and C at once; another work offset under G254 is carried too, and G53 and G28 are the machine's."""
    text = (
        "G10 L2 P1 X40. Y20. Z-80.\nG10 L2 P2 X5. Y6. Z7.\nG54 G0 B30. C40.\nG254\nX0 Y0 Z0\nG55 X0 Y0 Z0\n"
        "G2 X4. Y0 I2. J0 F100.\nG53 Z0\nG91 G28 X0\nG90 G54 X1."
    )
    places = ends(run, text)
    first, second = (
        TABLE.machine(origin, (30.0, 40.0), 0.0) for origin in ((40.0, 20.0, -80.0), (5.0, 6.0, 7.0))
    )
    assert places[1] == pytest.approx(first)
    assert places[2] == pytest.approx(second)
    assert places[3] == pytest.approx((second[0] + 4.0, *second[1:]))
    assert places[4] == pytest.approx((second[0] + 4.0, second[1], 0.0))
    assert places[-1] == pytest.approx((first[0] + 1.0, second[1], 0.0))


def test_without_kinematics(run: Any) -> None:
    """Where no rotary axis has turned nothing is to be carried; else the origin stays, with a warning."""
    out = run("G21 G90\nG254\nG0 X1. Y2.\nG255\nM30", dialect="fanuc")
    assert (out.errors, [d.code for d in out.diagnostics if d.severity == "warning"]) == ([], [])
    out = run("G21 G90\nG0 B90.\nG254\nG0 X1. Y2.\nG255\nM30", dialect="fanuc")
    assert (out.errors, [d.code for d in out.diagnostics if d.severity == "warning"]) == (
        [],
        ["dynamic-offset"],
    )
    assert out.path.end[out.path.kind != 3][-1, :2].tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("G254\nG0 X1. C10.", ("dynamic-offset", 2, 1)),
        ("G254\nG1 B1. F100.", ("dynamic-offset", 2, 1)),
        ("G68 X0 Y0 R30.\nG254", ("frame-compensation", 2, 1)),
        ("G254\nG68 X0 Y0 R30.", ("frame-compensation", 2, 1)),
        ("G254\nG68.2 X0 Y0 Z0 J90.", ("frame-compensation", 2, 1)),
    ],
)
def test_what_does_not_go_with_it(run: Any, text: str, error: tuple[str, int, int]) -> None:
    assert run(text + "\nM30", dialect="fanuc").errors == [error]

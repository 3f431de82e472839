"""Heidenhain's plain language: lines, and SPL splines beside their polynomials."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

HEAD = "0 BEGIN PGM PART MM\n1 L X+28.338 Y+19.385 Z-0.5 R0 FMAX M3\n"
#: The example of the iTNC 530's manual.
SAMPLE = (
    "2 SPL X24.875 Y15.924 Z-0.5 K3X-4.688E-002 K2X2.459E-002 K1X3.486E+000 "
    "K3Y-4.563E-002 K2Y2.155E-002 K1Y3.486E+000 K3Z0.000E+000 K2Z0.000E+000 K1Z0.000E+000 F10000\n"
)
TAIL = "9 END PGM PART MM\n"


def test_lines_and_increments(run: Any) -> None:
    out = run("0 BEGIN PGM A MM\nL X+1 Y2 FMAX\n; a remark\n* - a heading\n5 L IX-3 F600\nL Y0\nEND PGM A MM")
    assert out.errors == []
    rows = out.path.kind == 0
    np.testing.assert_allclose(out.path.end[rows, :2], [[1, 2], [-2, 2], [-2, 0]])
    np.testing.assert_allclose(out.path.feed[rows], [np.nan, 10.0, 10.0])


def test_the_manuals_spline(run: Any) -> None:
    """At places t the curve is the polynomial K3 t³ + K2 t² + K1 t + end; its parameter is 1 - t."""
    out = run(HEAD + SAMPLE + TAIL)
    assert [d.code for d in out.diagnostics] == ["dialect"]
    row = int(np.flatnonzero(out.path.kind == 2)[0])
    np.testing.assert_allclose(out.path.end[row, :3], [24.875, 15.924, -0.5])
    curves = out.path.nurbs
    assert curves.degree.tolist() == [3]
    points = np.asarray(curves.control_points)[:, :3]
    for t in (0.0, 0.25, 0.6):
        u = 1.0 - t
        bernstein = np.array([t**3, 3 * t**2 * u, 3 * t * u**2, u**3])
        x = -4.688e-2 * t**3 + 2.459e-2 * t**2 + 3.486 * t + 24.875
        y = -4.563e-2 * t**3 + 2.155e-2 * t**2 + 3.486 * t + 15.924
        # The first point is where the tool is, which is up to a micrometre off.
        np.testing.assert_allclose(bernstein @ points, [x, y, -0.5], atol=1e-3)


def test_a_start_elsewhere_is_an_error(run: Any) -> None:
    out = run(HEAD.replace("28.338", "28.341") + SAMPLE + TAIL)
    assert [(code, line) for code, line, _ in out.errors] == [("spline-start", 3)]


def test_a_kink_is_remarked(run: Any) -> None:
    turn = "3 SPL X34.875 K1X-10 K2X0 K3X0\n4 SPL X44.875 Y16.924 K1X-10 K1Y-1\n"
    out = run(HEAD + SAMPLE + turn + TAIL)
    assert out.errors == []
    assert [d.code for d in out.diagnostics if d.severity == "warning"] == ["spline-kink", "spline-kink"]


@pytest.mark.parametrize(
    ("block", "error"),
    [
        ("3 CYCL DEF 27.0", ("unsupported-block", 3, 3)),
        ("3 SPL X1 K1Y5 F100", ("spline-words", 3, 3)),
        ("3 L X5 Y", ("syntax", 3, 9)),
        ("3 SPL X28.338 FMAX", ("syntax", 3, 15)),
    ],
)
def test_what_is_not_read(run: Any, block: str, error: tuple[str, int, int]) -> None:
    assert run(HEAD + block + "\n" + TAIL).errors == [error]


def test_a_number_of_more_digits_than_python_reads_is_a_large_number(run: Any) -> None:
    """It was an internal error: Python turns at most 4300 digits into a whole number."""
    out = run(f"0 BEGIN PGM A MM\n1 L X+1 F100 M3\n2 Q{'9' * 5000} = Q{'9' * 5000} + 1\n3 END PGM A MM\n")
    faults = [each for each in out.diagnostics if each.code == "parameter-number"]
    # "2 Q", the digits, " = ": the number that is read is the first fault of its line.
    assert [(each.span.line, each.span.column) for each in faults] == [(3, 3 + 1 + 5000 + 3)]

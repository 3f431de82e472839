"""Turning: diameters, and the passes of a thread by the rule of their depth."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.gcode.codes.lathe_cycles import Thread

Calls = Callable[..., list[str]]


def thread(first: float, full: float, degression: float, springs: int = 0) -> Thread:
    """Return a thread of which only the depths matter."""
    return Thread(10.0, 0.0, -20.0, 1.5, -1.0, first, full, degression, 0.0, springs, 0.0, False, False)


@given(st.floats(0.05, 0.5), st.floats(0.6, 2.0))
def test_degression_1_cuts_equal_depths(first: float, full: float) -> None:
    depths = list(thread(first, full, 1.0).depths(2.2e-16))
    steps = np.diff([0.0, *depths])
    np.testing.assert_allclose(steps[:-1], first, rtol=1e-9)
    assert depths[-1] == full
    assert steps[-1] <= first * (1 + 1e-6)


@given(st.floats(0.05, 0.5), st.floats(0.6, 2.0))
def test_degression_2_cuts_equal_areas(first: float, full: float) -> None:
    """The area of a V is as the square of its depth: pass n goes to first·√n."""
    depths = list(thread(first, full, 2.0).depths(2.2e-16))
    areas = np.diff(np.square([0.0, *depths]))
    np.testing.assert_allclose(areas[:-1], first**2, rtol=1e-9)
    assert len(depths) == pytest.approx((full / first) ** 2, abs=1.0 + 1e-6)


@pytest.mark.parametrize("springs", [0, 1, 4])
def test_spring_passes_repeat_the_full_depth(springs: int) -> None:
    depths = list(thread(0.3, 0.9, 1.0, springs).depths(2.2e-16))
    assert depths == [0.3, 0.6, *[0.9] * (1 + springs)]


def ends(lines: list[str], name: str) -> list[list[float]]:
    """Return X and Z of the calls of a name."""
    found = [line for line in lines if line.startswith(name)]
    return [[float(w) for w in line[line.index("(") + 1 : -1].split(",")][0:3:2] for line in found]


def test_the_slide_angle_shifts_each_pass_along_the_flank(calls: Calls) -> None:
    """Each pass, depth·tan 30° nearer to the head: the bottoms lie on one flank."""
    lines = calls("S100 M3 G18\nG0 X20 Z5\nG76 P1.5 Z-20 I-1 J0.4 K1.2 Q30\nM2\n", dialect="linuxcnc")
    cuts = ends(lines, "STRAIGHT_FEED")
    assert [x for x, _ in cuts] == pytest.approx([18.6, 18.2, 17.8])
    slopes = [(b[1] - a[1]) / (a[0] - b[0]) for a, b in pairwise(cuts)]
    assert slopes == pytest.approx([-math.tan(math.radians(30))] * 2, abs=2e-3)


def test_tapers_have_the_thread_depth_over_their_length_and_a_longer_pitch(calls: Calls) -> None:
    lines = calls("S100 M3\nG0 X0 Z0\nG76 P2 Z-20 I-1 J0.5 K1 E1.5 L3\nM2\n", dialect="linuxcnc")
    pitches = [
        float(li[li.index("(") + 1 : li.index(",")]) for li in lines if li.startswith("START_SPEED_FEED")
    ]
    slant = 2 * math.hypot(1.5, 1.0) / 1.5
    assert pitches[:3] == pytest.approx([slant, 2.0, slant], abs=1e-6)
    cuts = ends(lines, "STRAIGHT_FEED")[:4]
    assert cuts[1][1] - cuts[0][1] == pytest.approx(-1.5)
    assert cuts[3][1] - cuts[2][1] == pytest.approx(-1.5)
    assert cuts[3][0] - cuts[2][0] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("text", "x"),
    [
        ("G7\nG0 X10", 5.0),
        ("G7 G0 X10", 5.0),
        ("G7\nG8\nG0 X10", 10.0),
        ("G7\nG0 X10\nG91 X4", 7.0),
        ("G7\nG8 G0 X10", 10.0),
        ("G0 X3\nG7 G91 G0 X2\nG8 X2", 6.0),
    ],
)
def test_x_is_a_diameter_between_g7_and_g8(calls: Calls, text: str, x: float) -> None:
    assert ends(calls(f"{text}\nM2\n", dialect="linuxcnc"), "STRAIGHT_TRAVERSE")[-1][0] == x


@pytest.mark.parametrize(
    ("block", "word"),
    [
        ("P1 Z-5 I-1 J1 K1", "K"),
        ("P1 Z-5 I0 J1 K2", "I"),
        ("P1 Z-5 I-1 J0 K2", "J"),
        ("P-1 Z-5 I-1 J1 K2", "P"),
    ],
)
def test_faults_of_g76_point_at_the_word(run: Callable[..., object], block: str, word: str) -> None:
    out = run(f"S1 M3\nG76 {block}\nM2\n", dialect="linuxcnc")
    assert out.errors == [("thread-words", 2, f"G76 {block}".index(word) + 1)]  # type: ignore[attr-defined]


def test_diameters_in_a_loop_are_halved_once(calls: Any) -> None:
    """A line that runs again means the same again."""
    found = calls(
        "G7 F100\no1 repeat [3]\nG1 X10\nG8 G1 X1\nG7 G1 X4\no1 endrepeat\nM2\n", dialect="linuxcnc"
    )
    ends = [call.split("(")[1].split(",")[0] for call in found if call.startswith("STRAIGHT_FEED")]
    assert ends == ["5.0000", "1.0000", "2.0000"] * 3


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc-lathe"])
def test_the_g76_of_mach3_turn_is_named(run: Callable[..., Any], dialect: str) -> None:
    text = "G0 X0.6 Z0.1\nM3 S500\nG76 X0.45 Z-1.0 Q1 P0.05 J0.01 L45 H0.008 I29.5 C0.1 B0.002 T0\nM30"
    faults = [d for d in run(text, dialect=dialect).diagnostics if d.severity.value == "error"]
    assert [(d.span.line, "Mach3 Turn" in d.hint) for d in faults] == [(3, True)]

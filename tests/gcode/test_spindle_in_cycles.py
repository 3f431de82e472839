"""What the spindle does in cycles, call by call as NISTIR 6556 (2000), section 3.5.16, lists the steps; arcs in inverse time."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

Calls = Callable[..., list[str]]
SHORT = {
    "START_SPINDLE_CLOCKWISE": "clockwise",
    "START_SPINDLE_COUNTERCLOCKWISE": "counter",
    "STOP_SPINDLE_TURNING": "stop",
    "STRAIGHT_FEED": "feed",
    "STRAIGHT_TRAVERSE": "traverse",
    "ORIENT_SPINDLE": "orient",
    "PROGRAM_STOP": "program stop",
    "DWELL": "dwell",
}


def steps(calls: Calls, block: str, start: str = "M3 S500") -> list[str]:
    """Return what a cycle does from Z5 above X1 Y1, in short: motions with the X and the Z that they go to."""
    found = []
    for line in calls(f"G21 F100\n{start}\nG0 X1 Y1 Z5\n{block}\nM2\n", dialect="linuxcnc"):
        name, _, rest = line.partition("(")
        if name in SHORT:
            words = [word.strip(" )") for word in rest.split(",")]
            if name.startswith("STRAIGHT"):
                found.append(f"{SHORT[name]} {float(words[0]):g} {float(words[2]):g}")
            else:
                found.append(SHORT[name] + (f" {words[-1]}" if name == "ORIENT_SPINDLE" else ""))
    # The spindle's start, and the ways to Z5 and over the hole, come before; M2 stops the spindle.
    assert found[-1] == "stop"
    return found[3:-1]


@pytest.mark.parametrize(
    ("number", "start", "way", "other"),
    [(84, "M3 S500", "clockwise", "counter"), (74, "M4 S500", "counter", "clockwise")],
)
def test_a_tap_turns_back_at_the_bottom_and_on_above(
    calls: Calls, number: int, start: str, way: str, other: str
) -> None:
    """The spindle turns the other way before it leaves the bottom, and as it was once it is out."""
    assert steps(calls, f"G{number} X1 Y1 Z-1 R2 P0.5", start) == [
        "traverse 1 2", "feed 1 -1", "stop", other, "dwell", "feed 1 2", "stop", way,
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("number", "start", "said"),
    [
        (84, "S500", "the spindle stands still: G84 needs M3"),
        (84, "M4 S500", "the spindle turns the other way: G84 needs M3"),
        (74, "S500", "the spindle stands still: G74 needs M4"),
        (74, "M3 S500", "the spindle turns the other way: G74 needs M4"),
    ],
)
def test_a_tap_needs_the_spindle_turning_its_way(
    run: Callable[..., Any], number: int, start: str, said: str
) -> None:
    outcome = run(f"G21 F100\n{start}\nG{number} X1 Z-1 R2\nM2\n", dialect="linuxcnc")
    assert [d.message for d in outcome.diagnostics if d.code == "cycle-spindle"] == [said]


@pytest.mark.parametrize(
    ("start", "way", "turn"), [("M3 S500", "clockwise", "2"), ("M4 S500", "counter", "3")]
)
def test_a_back_bore_goes_in_beside_the_hole_with_the_spindle_oriented(
    calls: Calls, start: str, way: str, turn: str
) -> None:
    """Beside, orient, down, to the centre, turn, up to K and back, orient, beside, up, to the centre, turn."""
    assert steps(calls, "G87 X1 Y1 Z-5 R2 I1 J0 K-3", start)[:14] == [
        "traverse 1 2", "traverse 2 2", "stop", f"orient {turn}", "traverse 2 -5", "traverse 1 -5", way,
        "feed 1 -3", "feed 1 -5", "stop", f"orient {turn}", "traverse 2 -5", "traverse 2 2", "traverse 1 2",
    ]  # fmt: skip
    assert steps(calls, "G87 X1 Y1 Z-5 R2 I1 J0 K-3", start)[14] == way


@pytest.mark.parametrize(("start", "way"), [("M3 S500", "clockwise"), ("M4 S500", "counter")])
def test_a_bore_by_hand_stops_at_the_bottom_and_turns_on(calls: Calls, start: str, way: str) -> None:
    found = steps(calls, "G88 X1 Y1 Z-5 R2 P0.5", start)
    assert found[:6] == ["traverse 1 2", "feed 1 -5", "dwell", "stop", "program stop", way]


def test_m29_is_an_event(run: Callable[..., Any]) -> None:
    """M29 is handed on for the machine's own controller to take as well."""
    outcome = run("G21 G95\nM3 S100\nG0 Z1\nM29 S100\nG84 X1 Z-1 R1 F1.5\nM30\n", dialect="fanuc")
    assert [dict(event.values) for event in outcome.path.events if event.name == "user"] == [{"m": 29}]


@pytest.mark.parametrize(("feed", "pitch"), [("G94 F750", 1.5), ("G95 F1.25", 1.25)])
def test_m29_taps_in_step_until_g80(calls: Calls, run: Callable[..., Any], feed: str, pitch: float) -> None:
    """F is a pitch times the speed, or the pitch; each hole is a tap of its own, and the next cycle after G80 is not in step."""
    text = f"G21 G0 Z5\nM29 S500\nG98 G84 X1 Y1 Z-1 R2 {feed}\nX3\nG80\nM3\nG84 X5 Z-1 R2\nM30\n"
    lines = calls(text, dialect="fanuc")
    assert [line for line in lines if line.startswith("RIGID_TAP")] == [
        "RIGID_TAP(1.0000, 1.0000, -1.0000)", "RIGID_TAP(3.0000, 1.0000, -1.0000)"
    ]  # fmt: skip
    assert [line for line in lines if line.startswith("START_SPEED")] == [
        f"START_SPEED_FEED_SYNC({pitch:f},0)"
    ] * 2
    assert [line.split("(")[0] for line in lines].count("START_SPINDLE_COUNTERCLOCKWISE") == 1
    outcome = run(text, dialect="fanuc")
    told = [dict(event.values) for event in outcome.path.events if event.name == "synchronise"]
    assert told == [{"pitch_mm": pytest.approx(pitch), "tap": True}, {"pitch_mm": None}] * 2
    ends = outcome.path.end[outcome.path.kind < 3, 2].tolist()
    assert ends[:7] == [5.0, 5.0, 2.0, -1.0, 2.0, 5.0, 5.0]


def test_a_tap_in_step_needs_a_speed_and_tells_what_it_leaves_out(run: Callable[..., Any]) -> None:
    without = run("G21 G0 Z5\nM29\nG84 X1 Z-1 R2 F1\nM30\n", dialect="fanuc")
    assert "G84 after M29 has no speed S" in [found.message for found in without.diagnostics]
    steps_ = run("G21 G0 Z5\nM29 S500\nG84 X1 Z-1 R2 Q0.5 F500\nM30\n", dialect="fanuc")
    assert any("Q0.5 of G84 after M29 changes nothing" in found.message for found in steps_.diagnostics)


@pytest.mark.parametrize(
    ("arc", "angle", "rise"),
    [
        ("G2 X0 Y0 I5 P2", 4.0 * math.pi, 0.0),
        ("G3 X10 Y0 Z4 I5", math.pi, 4.0),
        ("G2 X5 Y5 I5", 0.5 * math.pi, 0.0),
        ("G3 X5 Y5 I5 Z-3", 1.5 * math.pi, -3.0),
        ("G3 X5 Y5 I5 P3", 5.5 * math.pi, 0.0),
    ],
)
def test_an_arc_in_inverse_time_goes_at_its_length_by_its_time(
    calls: Calls, arc: str, angle: float, rise: float
) -> None:
    """G93 F2: half a minute for √((r φ)² + z²), whole turns and those that P adds among φ."""
    lines = calls(f"G21 G93\n{arc} F2\nM2\n", dialect="linuxcnc")
    (feed,) = [float(line[14:-1]) for line in lines if line.startswith("SET_FEED_RATE")][:1]
    assert feed == pytest.approx(2.0 * math.hypot(5.0 * angle, rise), abs=1e-4)


@pytest.mark.parametrize(("i", "j"), [(0.1, 5.5), (0.2, 5.5), (0.1, 2.9)])
@pytest.mark.parametrize("code", ["G2", "G3"])
def test_a_whole_circle_in_inverse_time_is_whole(calls: Calls, code: str, i: float, j: float) -> None:
    """The quotient of its two radii, which are equal, has an angle of a rounding above or below 0."""
    lines = calls(f"G21 G93\n{code} I{i} J{j} F2\nM2\n", dialect="linuxcnc")
    (feed,) = [float(line[14:-1]) for line in lines if line.startswith("SET_FEED_RATE")][:1]
    assert feed == pytest.approx(4.0 * math.pi * math.hypot(i, j), abs=1e-4)


def test_a_macro_that_is_called_several_times_has_its_arguments_each_time(calls: Calls) -> None:
    """G65 with L: what the macro makes of its local variables does not reach its next run; a variable without a value is no word."""
    text = "G21 F100\nG65 P9001 L3 A5\nM30\nO9001\nG1 X#1 Y#2\n#1=#1+100\n#2=8\nM99\n"
    feeds = [line for line in calls(text, dialect="fanuc") if line.startswith("STRAIGHT_FEED")]
    assert feeds == ["STRAIGHT_FEED(5.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)"] * 3


@pytest.mark.parametrize(
    ("text", "dialect", "said"),
    [
        ("G21 G0 Z5\nS500 M3\nG84 X1 Z-1 R2 Q0.5 F500\nM30", "fanuc", True),
        ("G21 G0 Z5\nS500 M3\nG83 X1 Z-1 R2 Q0.5 F500\nG84 X2 Z-1\nM30", "fanuc", False),
        ("G21 G99 G0 Z5\nS500 M3\nG84 X0 Z-1 R-2 Q500 F1\nM30", "fanuc-lathe", True),
    ],
)
def test_steps_of_a_tap_are_told(run: Any, text: str, dialect: str, said: bool) -> None:
    """Q of G84 without M29 was passed over without a word; that of a cycle before it is no word of the tap."""
    out = run(text, dialect=dialect)
    assert out.errors == []
    assert any("the tap goes in once" in d.message for d in out.diagnostics) == said

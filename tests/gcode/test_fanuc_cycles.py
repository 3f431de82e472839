"""Canned cycles with FANUC's words: the moves of each hole, point by point, by the manual's figures (B-63324EN, 13.1)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

START = "G0 Z10 M3 S100 F100\n"


def moves(run: Any, text: str) -> list[list[float]]:
    """Return X Y Z of the motions after the start, and of their feeds 1, of traverses 0."""
    out = run(START + text + "\nM30", dialect="fanuc")
    assert out.errors == []
    rows = out.path.kind != 3
    feeds = np.isfinite(out.path.feed[rows]).astype(float)
    return np.column_stack([out.path.end[rows, :3], feeds]).round(9).tolist()[1:]


def names(run: Any, text: str) -> list[str]:
    """Return the events after the start, but the end."""
    out = run(START + text + "\nM30", dialect="fanuc")
    return [event.name for event in out.path.events][2:-1]


def test_drilling_goes_to_r_and_back_to_where_it_began(run: Any) -> None:
    expected = [[1, 1, 10, 0], [1, 1, 2, 0], [1, 1, -5, 1], [1, 1, 10, 0]]
    assert moves(run, "G81 X1 Y1 Z-5 R2") == expected
    assert moves(run, "G99 G81 X1 Y1 Z-5 R2") == [*expected[:3], [1, 1, 2, 0]]


def test_levels_stay_where_they_were_given(run: Any) -> None:
    """R and Z given in G90 hold in G91 (the manual's hole circle changes the mode between its holes), and back."""
    down = moves(run, "G81 X1 Y1 Z-5 R2\nG91 X5")
    assert down[4:] == [[6, 1, 10, 0], [6, 1, 2, 0], [6, 1, -5, 1], [6, 1, 10, 0]]
    back = moves(run, "G91 G81 X1 Z-4 R-8\nG90 X5")
    assert back[4:] == [[5, 0, 10, 0], [5, 0, 2, 0], [5, 0, -2, 1], [5, 0, 10, 0]]


def test_k_and_l_repeat_and_k0_only_keeps_the_words(run: Any) -> None:
    holes = moves(run, "G91 G81 X5 Z-4 R-8 K3")
    assert [row[0] for row in holes if row[2] == -2] == [5, 10, 15]
    assert moves(run, "G91 G81 X5 Z-4 R-8 L3") == holes
    assert moves(run, "G81 X7 Z-1 R1 K0\nX8")[0] == [8, 0, 10, 0]


def test_r_alone_goes_on_with_the_cycle(run: Any) -> None:
    """A block with X, Y, Z, R or another axis drills, and no other one does: M19's R is the spindle's angle."""
    rows = moves(run, "G81 X1 Y1 Z-5 R2\nR3\nF200\nG4 P500\nM19 R90\nX2")
    assert rows[4:7] == [[1, 1, 3, 0], [1, 1, -5, 1], [1, 1, 10, 0]]
    assert [row[0] for row in rows if row[2] == -5] == [1, 1, 2]


@pytest.mark.parametrize("axis", ["A", "B", "C", "U", "V"])
def test_any_other_axis_leads_to_the_next_hole(run: Any, axis: str) -> None:
    """B-63324EN, 13.1: "drilling is not performed in a block that does not contain X, Y, Z, R, or any other axes"."""
    text = f"G0 X1 {axis}0 Z10 F100\nG81 Z-5 R2\n{axis}45\nX3 {axis}90\nG91 {axis}10 K2\nG80\nM30"
    path = run(text, dialect="fanuc").path
    column = path.axes.index(axis)
    unit = np.pi / 180.0 if axis in "ABC" else 1.0
    holes = path.end[np.isfinite(path.feed)]
    places = np.column_stack([holes[:, 0], holes[:, column] / unit, holes[:, 2]])
    assert places.round(9).tolist() == [[1, 0, -5], [1, 45, -5], [3, 90, -5], [3, 100, -5], [3, 110, -5]]


def test_words_stay_from_cycle_to_cycle(run: Any) -> None:
    rows = moves(run, "G81 X1 Z-5 R2\nG83 X2 Q4\nG80")
    assert rows[4:] == [
        [2, 0, 10, 0],
        [2, 0, 2, 0],
        [2, 0, -2, 1],
        [2, 0, 2, 0],
        [2, 0, -1.746, 0],
        [2, 0, -5, 1],
        [2, 0, 10, 0],
    ]


def test_a_dwell_is_in_milliseconds_and_may_be_missing(run: Any) -> None:
    out = run("G82 X1 Z-1 R1 P500 F100\nG89 X2\nM30", dialect="fanuc")
    assert [event.dwell_s for event in out.path.events if event.name == "dwell"] == [0.5, 0.5]
    assert run("G82 X1 Z-1 R1 F100\nM30", dialect="fanuc").errors == []


def test_fine_boring_steps_off_the_wall(run: Any) -> None:
    text = "G99 G76 X5 Z-5 R2 Q.5 P100"
    assert moves(run, text)[2:] == [[5, 0, -5, 1], [5.5, 0, -5, 0], [5.5, 0, 2, 0], [5, 0, 2, 0]]
    assert names(run, text) == ["dwell", "spindle", "spindle", "spindle"]


def test_back_boring_bores_upward(run: Any) -> None:
    rows = moves(run, "G87 X1 Z-5 R-10 Q1")
    assert rows == [
        [1, 0, 10, 0],
        [2, 0, 10, 0],
        [2, 0, -10, 0],
        [1, 0, -10, 0],
        [1, 0, -5, 1],
        [2, 0, -5, 0],
        [2, 0, 10, 0],
        [1, 0, 10, 0],
    ]


@pytest.mark.parametrize("level", ["G98 ", "G99 "])
def test_a_back_bore_comes_out_to_the_initial_level(run: Any, level: str) -> None:
    """R lies beneath the part; a hole before it under G99 has left the tool at the level of its own R."""
    rows = moves(run, f"G99 G81 X5 Z-3 R2\n{level}G87 X1 Z-5 R-10 Q1")
    assert rows[-3:] == [[2, 0, -5, 0], [2, 0, 10, 0], [1, 0, 10, 0]]


def turns(run: Any, text: str) -> list[tuple[str, int, list[float]]]:
    """Return the events after the start with the spindle's sense (0 where it has none) and where the tool is."""
    out = run(START + text + "\nM30", dialect="fanuc")
    assert out.errors == []
    rows = np.flatnonzero(out.path.kind == 3)[2:-1]
    events = [out.path.events[int(out.path.curve[row])] for row in rows]
    places = out.path.end[rows, :3].round(9).tolist()
    return [(e.name, e.values.get("direction", 0), place) for e, place in zip(events, places, strict=True)]


def test_boring_with_a_standing_spindle(run: Any) -> None:
    """G86 stops at the bottom, comes out by traverse to R (G99) or to where it began (G98), and turns again there."""
    assert moves(run, "G86 X1 Z-5 R2")[2:] == [[1, 0, -5, 1], [1, 0, 10, 0]]
    assert moves(run, "G99 G86 X1 Z-5 R2")[2:] == [[1, 0, -5, 1], [1, 0, 2, 0]]
    assert turns(run, "G99 G86 X1 Z-5 R2") == [("spindle", 0, [1, 0, -5]), ("spindle", 1, [1, 0, 2])]


def test_boring_by_hand_stops_the_program_at_the_bottom(run: Any) -> None:
    """G88 waits for P, stops spindle and program for the operator, then comes out and turns again."""
    assert moves(run, "G88 X1 Z-5 R2 P250")[2:] == [[1, 0, -5, 1], [1, 0, 10, 0]]
    bottom = [1, 0, -5]
    wanted = [("dwell", 0, bottom), ("spindle", 0, bottom), ("stop", 0, bottom), ("spindle", 1, [1, 0, 10])]
    assert turns(run, "G88 X1 Z-5 R2 P250") == wanted


def test_tapping_turns_back_and_feeds_out_to_r(run: Any) -> None:
    rows = moves(run, "G84 X1 Z-5 R2")
    assert rows[2:] == [[1, 0, -5, 1], [1, 0, 2, 1], [1, 0, 10, 0]]


def test_g80_brings_the_motion_before_it_back(run: Any) -> None:
    assert moves(run, "G1 X1\nG81 X2 Z-1 R1\nG80 X3")[-1] == [3, 0, 10, 1]
    assert moves(run, "G81 X2 Z-1 R1\nG80\nX3")[-1] == [3, 0, 10, 0]


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("G83 X1 R2", ("cycle-words", 2, 1)),
        ("G76 X1 Z-5 R2", ("cycle-words", 2, 1)),
        ("G83 X1 Z-5 R2 Q0", ("cycle-peck", 2, 15)),
        ("G81 X1 Z5 R2", ("cycle-depth", 2, 11)),
        ("G87 X1 Z-15 R-10 Q1", ("cycle-depth", 2, 13)),
        ("G81 X1 Z-5 R2 K1.5", ("cycle-repeats", 2, 15)),
        ("G82 X1 Z-5 R2 P-1", ("dwell-negative", 2, 15)),
    ],
)
def test_wrong_words(run: Any, text: str, error: tuple[str, int, int]) -> None:
    assert run(START + text + "\nM30", dialect="fanuc").errors == [error]


def test_the_remark_on_a_wrong_bottom_says_which_is_the_higher_one(run: Any) -> None:
    """G81 goes down from R, G87 up from it (B-63534EN, 13.1.10)."""
    for cycle, said in (
        ("G81 X1 Z5 R2", "R is the higher one"),
        ("G87 X1 Z-15 R-10 Q1", "R is beneath the hole"),
    ):
        (error,) = (
            d for d in run(START + cycle + "\nM30", dialect="fanuc").diagnostics if d.code == "cycle-depth"
        )
        assert said in (error.hint or "")


def test_q_and_r_left_out(run: Any) -> None:
    """Without Q the hole is made at once, without R it begins where the tool stands (Haas mill operator's manual, G81); a warning says so."""
    out = run(START + "G83 X1 Z-5 R2\nG80\nM30", dialect="fanuc")
    assert [(d.code, d.severity.name) for d in out.diagnostics if d.code == "cycle-words"] == [
        ("cycle-words", "WARNING")
    ]
    assert moves(run, "G83 X1 Z-5 R2") == [[1, 0, 10, 0], [1, 0, 2, 0], [1, 0, -5, 1], [1, 0, 10, 0]]
    assert moves(run, "G81 X1 Z-5\nX2") == [
        [1, 0, 10, 0],
        [1, 0, -5, 1],
        [1, 0, 10, 0],
        [2, 0, 10, 0],
        [2, 0, -5, 1],
        [2, 0, 10, 0],
    ]


def test_bores_step_off_the_wall_by_i_and_j(run: Any) -> None:
    """I and J are the way aside where Q is none (Haas mill operator's manual, G76); Q of an earlier cycle is not meant."""
    aside = [[1, 0, -5, 1], [1.1, -0.2, -5, 0], [1.1, -0.2, 10, 0], [1, 0, 10, 0]]
    assert moves(run, "G76 X1 Z-5 R2 I.1 J-.2")[2:] == aside
    assert moves(run, "G83 X1 Z-5 R2 Q9\nG76 I.1 J-.2 X1")[-4:] == aside
    assert moves(run, "G76 X1 Z-5 R2 J-.2 K2")[2:6] == [
        [1, 0, -5, 1],
        [1, -0.2, -5, 0],
        [1, -0.2, 10, 0],
        [1, 0, 10, 0],
    ]
    out = run(START + "G76 X1 Z-5 R2 I.1\nG80\nM30", dialect="fanuc")
    assert not any(d.code == "cycle-shift" for d in out.diagnostics)


def test_g77_bores_back_as_g87(run: Any) -> None:
    """``G77 Z-1. R-1.6 Q0.1`` (Haas mill operator's manual, G77)."""
    assert moves(run, "G77 X1 Z-5 R-8 Q1") == moves(run, "G87 X1 Z-5 R-8 Q1")
    assert moves(run, "G77 X1 Z-5 R-8 I1") == moves(run, "G87 X1 Z-5 R-8 Q1")


def test_steps_of_haas(run: Any) -> None:
    """I is the first step, J what each next one is less, K the least one (Haas mill operator's manual, G83 and G73)."""
    levels = [row[2] for row in moves(run, "G83 X1 Z-20 R2 I10 J3 K5") if row[3]]
    assert levels == [-8, -15, -20]
    levels = [row[2] for row in moves(run, "G73 X1 Z-20 R2 I10 J4 K5\nX2") if row[3]]
    assert levels == [-8, -14, -19, -20] * 2
    out = [row for row in moves(run, "G83 X1 Z-20 R2 I10 J3 K5") if not row[3]]
    assert out == [
        [1, 0, 10, 0],
        [1, 0, 2, 0],
        [1, 0, 2, 0],
        [1, 0, -7.746, 0],
        [1, 0, 2, 0],
        [1, 0, -14.746, 0],
        [1, 0, 10, 0],
    ]


def test_a_tap_of_haas_comes_out_faster(run: Any) -> None:
    out = run(START + "G84 X1 Z-5 R2 J2\nM30", dialect="fanuc")
    feeds = out.path.feed[np.isfinite(out.path.feed) & (out.path.kind != 3)]
    assert feeds.tolist() == pytest.approx([100 / 60, 200 / 60])


@pytest.mark.parametrize("words", ["I0", "I-1", "I1 J-1", "I1 K-1"])
def test_wrong_steps_of_haas(run: Any, words: str) -> None:
    assert [error[0] for error in run(START + f"G83 X1 Z-5 R2 {words}\nM30", dialect="fanuc").errors] == [
        "cycle-peck"
    ]


@pytest.mark.parametrize(
    "block",
    [
        "G93 G81 X1 Z-5 R2 F10",
        "G93 G83 X1 Z-5 R2 Q1 F10",
        "G81 X1 Z-5 R2\nG93 X4 F10",
        "G93 G184 Z-5 F10",
        "G93 G13 D1 I5 F10",
    ],
)
def test_a_cycle_under_inverse_time_is_refused(run: Any, block: str) -> None:
    """Its feeds took the time of the last line, or no end: RS274/NGC, 3.5.16, has it that F is no inverse time there."""
    out = run("G10 L12 P1 R2\n" + START + block + "\nM30", dialect="fanuc")
    assert [error[0] for error in out.errors] == ["cycle-feed-mode"]


def test_a_skip_under_inverse_time_takes_its_f(run: Any) -> None:
    """F6 under G93 is ten seconds, whatever the line before took (0.1/s), and also as the first line."""
    out = run("G93\nG31 X5 F6\nG1 X9 F30\nG31 X2 F6\nM30", dialect="fanuc")
    feeds = out.path.feed[out.path.kind == 0]
    assert feeds.tolist() == pytest.approx([0.1, 0.5, 0.1])

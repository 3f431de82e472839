"""Faults put into setpoints that hold: each one is found, with its kind."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import cncgen
from cncgen.cli.app import run
from cncgen.pipeline import judge, read_text, sample
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.stream import SetpointStream

PROGRAM = "G21 G17 G90 {mode} F3000\nG1 X10\nG3 X20 Y10 I0 J10\nG1 X20 Y20\nG1 X10 Y30\nM2\n"
MACHINE = "xy-table"


def planned(mode: str) -> Setpoints:
    """Return setpoints of the program in a path mode."""
    program = read_text(PROGRAM.format(mode=mode))
    return sample(cncgen.plan(program, MACHINE)).collect()


@pytest.fixture(scope="module")
def exact() -> Setpoints:
    return planned("G61")


@pytest.fixture(scope="module")
def rounded() -> Setpoints:
    return planned("G64 P0.05")


def broken(setpoints: Setpoints, position: np.ndarray, mode: str = "G61", axes: str = "XY") -> set[str]:
    """Return the kinds of breach that positions in the place of the planned ones have."""
    chunk = replace(setpoints, position=np.ascontiguousarray(position), axes=axes)
    stream = SetpointStream("test", axes, setpoints.period_s, iter([chunk]))
    verdict = judge(stream, read_text(PROGRAM.format(mode=mode)), MACHINE)
    return {item.code.removeprefix("verify-") for item in verdict.breaches}


def moving(setpoints: Setpoints) -> list[int]:
    """Return some samples in motion, spread over the stream."""
    speed = np.linalg.norm(np.diff(setpoints.position, axis=0), axis=1)
    fast = np.flatnonzero(speed > 0.2 * speed.max())
    return [int(k) for k in fast[:: len(fast) // 12]]


def test_without_a_fault_all_holds(exact: Setpoints, rounded: Setpoints) -> None:
    assert broken(exact, exact.position) == set()
    assert broken(rounded, rounded.position, "G64 P0.05") == set()


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, -1.0)])
def test_a_sample_moved_by_10_um(exact: Setpoints, direction: tuple[float, float]) -> None:
    for k in (1, *moving(exact), len(exact) - 2):
        bent = exact.position.copy()
        bent[k] += 0.01 * np.array(direction)
        assert "jerk" in broken(exact, bent), k


def test_a_sample_left_out_and_one_given_twice(exact: Setpoints) -> None:
    for k in moving(exact):
        assert "jerk" in broken(exact, np.delete(exact.position, k, axis=0)), k
        assert "jerk" in broken(exact, np.insert(exact.position, k, exact.position[k], axis=0)), k


def test_axes_in_another_order(exact: Setpoints) -> None:
    assert {"distance", "coverage"} <= broken(exact, exact.position[:, ::-1])


def test_another_program_or_another_feed(exact: Setpoints) -> None:
    stream = SetpointStream("test", "XY", exact.period_s, iter([exact]))
    other = read_text(PROGRAM.format(mode="G61").replace("I0 J10", "I2.5 J7.5"))
    assert not judge(stream, other, MACHINE).holds
    assert {"velocity", "acceleration", "jerk"} <= broken(exact, exact.position[::20])


def test_an_early_end_and_a_late_start(exact: Setpoints) -> None:
    middle = len(exact) // 2
    assert {"coverage", "velocity"} & broken(exact, exact.position[:middle])
    assert "coverage" in broken(exact, exact.position[:middle])
    assert "coverage" in broken(exact, exact.position[middle:])


def test_an_axis_that_the_program_does_not_name(exact: Setpoints) -> None:
    """A third column that stands still anywhere is no fault; one that moves is, if only by a little."""
    still = np.column_stack([exact.position, np.full(len(exact), 5.0)])
    assert broken(exact, still, axes="XYZ") == set()
    drifting = still.copy()
    drifting[:, 2] += np.linspace(0, 0.01, len(exact))
    assert "axis" in broken(exact, drifting, axes="XYZ")


def test_corners_rounded_and_not_rounded(exact: Setpoints, rounded: Setpoints) -> None:
    """G64 setpoints leave a G61 path; G61 setpoints are within any G64; more than P is found on either side."""
    assert {"distance", "coverage"} <= broken(rounded, rounded.position, "G61")
    assert broken(exact, exact.position, "G64 P0.05") == set()
    assert "coverage" in broken(rounded, rounded.position, "G64 P0.005")


def text_of(setpoints: Setpoints) -> str:
    """Return setpoints as CSV."""
    out = io.StringIO()
    out.write("t_s,x_mm,y_mm\n")
    for t, (x, y) in zip(setpoints.time_s, setpoints.position, strict=True):
        out.write(f"{t:.9f},{x:.9f},{y:.9f}\n")
    return out.getvalue()


@pytest.mark.parametrize(
    ("fault", "code", "says"),
    [
        (lambda lines: lines, 0, "broken: none"),
        (lambda lines: [*lines[:500], *lines[501:]], 2, "row 500"),
        (lambda lines: [*lines[:500], *lines[499:]], 2, "row 500"),
        (lambda lines: [*lines[:-1], lines[-1][:-15]], 2, "columns"),
        (lambda lines: [lines[0], *lines[:0:-1]], 2, "time does not grow"),
        (lambda lines: lines[:1], 2, "no setpoints"),
        (lambda lines: lines[1:], 2, "header"),
        (lambda lines: [*lines[:700], lines[700].replace("0.", "nan", 1), *lines[701:]], 2, "701"),
        (lambda lines: [lines[0].replace("x_mm,y_mm", "y_mm,x_mm"), *lines[1:]], 1, "verify-distance"),
        (lambda lines: [lines[0].replace("x_mm", "x_inch"), *lines[1:]], 2, "not the position of axis X"),
    ],
    ids=["none", "gap", "twice", "cut", "backwards", "nothing", "no header", "nan", "order", "unit"],
)
def test_faults_of_a_file(
    exact: Setpoints,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    fault: Callable[[list[str]], list[str]],
    code: int,
    says: str,
) -> None:
    (tmp_path / "part.nc").write_text(PROGRAM.format(mode="G61"))
    (tmp_path / "s.csv").write_text("\n".join(fault(text_of(exact).splitlines())))
    assert run(["verify", str(tmp_path / "s.csv"), "-p", str(tmp_path / "part.nc"), "-m", MACHINE]) == code
    assert says in capsys.readouterr().err


WAITS = "G21 G17 G90 {mode} F3000\nG4 P0.02\nG1 X10\nG4 P0.05\nG1 X20\nG1 X10\nG4 P0.03\nM8\nG4 P0.02\nG1 Y5\nG4 P0.1\nM2\n"


@pytest.mark.parametrize("mode", ["G61", "G64 P0.05"])
@pytest.mark.parametrize("period_s", [0.00025, 0.004])
def test_waits_that_are_left_out_or_shortened(mode: str, period_s: float) -> None:
    """Each stand of the plan in turn, cut to half: the line of its last wait is named, with what is left of it."""
    machine = replace(cncgen.load_machine(MACHINE), period_s=period_s)

    def waits(position: np.ndarray) -> list[dict[str, float]]:
        chunk = replace(setpoints, position=np.ascontiguousarray(position))
        stream = SetpointStream("test", "XY", period_s, iter([chunk]))
        verdict = judge(stream, read_text(WAITS.format(mode=mode)), machine)
        return [dict(item.values) for item in verdict.breaches if item.code == "verify-dwell"]

    setpoints = sample(cncgen.plan(read_text(WAITS.format(mode=mode)), machine)).collect()
    assert waits(setpoints.position) == []
    still = np.flatnonzero((np.diff(setpoints.position, axis=0) == 0).all(axis=1))
    stands = np.split(still, np.flatnonzero(np.diff(still) > 1) + 1)
    long = [stand for stand in stands if len(stand) * period_s > 0.03]
    assert len(long) == 3
    for stand, line, seconds in zip(long, (4, 9, 11), (0.05, 0.05, 0.1), strict=True):
        (found,) = waits(np.delete(setpoints.position, stand[: len(stand) // 2], axis=0))
        assert found["line"] == line
        assert found["limit"] == pytest.approx(seconds)
        assert found["value"] == pytest.approx(seconds / 2, abs=2.5 * period_s)
        assert found["t_s"] == pytest.approx(stand[0] * period_s, abs=2 * period_s + 0.001)
    (found,) = waits(np.delete(setpoints.position, still, axis=0))
    assert found["samples"] >= 4
    assert found["limit"] == pytest.approx(0.1)


def test_a_wait_before_steps_within_the_tolerance_is_found() -> None:
    """Steps of some µm after it keep the place of the wait open until the stand is long over."""
    steps = "X83.001 Y14.999 X83.005 Y15.001 X83.006 Y15.005 X83.02 Y15.004 X83.021 Y15.005 X83.022 Y15.004 X83.023 "
    steps += "Y15.005 X83.024 Y15.004 X83.025 Y15.005 X83.026 Y15.006 X83.027 Y15.005 X83.028 Y15.004 X83.029 Y15.005 "
    steps += "X83.03 Y15.006 Y15.005"
    arcs = [f"G{2 + k % 2} X{84.331 + 1.3 * k:.3f} Y15.005 R0.6501" for k in range(33)]
    way = ["G1 Y16", "G1 X83", "G1 Y15", "G4 P0.05", *(f"G1 {word}" for word in steps.split()), *arcs]
    text = "\n".join(["G21 G90 G17 G94 F3000 G61", *way, "M2", ""])
    setpoints = sample(cncgen.plan(read_text(text), "generic-mill")).collect()
    assert judge(setpoints, read_text(text), "generic-mill").holds


FOLDS = [
    (1, "G1 X0.07", "G1 X0.06", "G4 P0.05", "G1 Y5"),
    (2, "G1 X0.06", "G4 P0.05", "G1 X0.07", "G1 X0.06", "G4 P0.05", "G1 Y5"),
    (2, "G1 X0.06", "G4 P0.03", "G1 X0.07", "G1 X0.06", "G4 P0.02", "G4 P0.04", "G1 Y5"),
    (3, "G1 X0.06", "G1 X0.05", "G1 X0.06", "G4 P0.04", "G1 X0.055", "G4 P0.03", "G1 X0.06", "G4 P0.05"),
]


@pytest.mark.parametrize(("count", "blocks"), [(count, blocks) for count, *blocks in FOLDS])
def test_waits_where_the_path_folds_within_its_tolerance(count: int, blocks: list[str]) -> None:
    """A pass before the one that is waited at is as near: all waits are found, and one whose stand is left out is missed."""
    text = "\n".join(["G21 G90 F3000 G64 P0.03", *blocks, "M2", ""])

    def waits(position: np.ndarray) -> list[dict[str, float]]:
        chunk = replace(setpoints, position=np.ascontiguousarray(position))
        stream = SetpointStream("test", setpoints.axes, setpoints.period_s, iter([chunk]))
        verdict = judge(stream, read_text(text), MACHINE)
        return [dict(item.values) for item in verdict.breaches if item.code == "verify-dwell"]

    setpoints = sample(cncgen.plan(read_text(text), MACHINE)).collect()
    assert waits(setpoints.position) == []
    still = np.flatnonzero((np.diff(setpoints.position, axis=0) == 0).all(axis=1))
    stands = [stand for stand in np.split(still, np.flatnonzero(np.diff(still) > 1) + 1) if len(stand) > 10]
    assert len(stands) == count
    for stand in stands:
        (found,) = waits(np.delete(setpoints.position, stand, axis=0))
        assert blocks[int(found["line"]) - 2].startswith("G4")

"""The travel of the axes, asked of a program before it is planned: at ends, along curves, where it starts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import cncgen
from cncgen.diagnostics import NoPlanError, ProgramError
from cncgen.geometry import nurbs
from cncgen.geometry.tables import ArcTable
from cncgen.machine import Machine
from cncgen.planner import PlanOptions
from cncgen.planner.checks import checked
from cncgen.toolpath.record import Kind, Toolpath


def as_curve(line: Toolpath, kind: Kind, **tables: object) -> Toolpath:
    """Make the one line of a toolpath the first curve of a table."""
    return replace(line, kind=np.array([kind], np.int8), curve=np.zeros(1, np.int64), **tables)


def test_travel_is_checked_along_curves(lines: Callable[..., Toolpath], table: Machine) -> None:
    """Ends within the travel and a top beyond it: of a half circle at y = 5, of a Bézier parabola at y = 1."""
    y = replace(table.axes["Y"], travel=(-10.0, 0.9))
    machine = replace(table, axes={**table.axes, "Y": y})
    half = ArcTable(np.zeros((1, 3)), np.array([[0.0, 0.0, -1.0]]), np.array([np.pi]))
    parabola = nurbs.single(2, [0, 0, 0, 1, 1, 1], [[0, 0, 0], [1, 2, 0], [2, 0, 0]])
    for chunk, top in (
        (as_curve(lines([(-5, 0), (5, 0)]), Kind.ARC, arcs=half), 5.0),
        (as_curve(lines([(0, 0), (2, 0)]), Kind.NURBS, nurbs=parabola), 1.0),
    ):
        with pytest.raises(NoPlanError) as caught:
            next(checked([chunk], machine, PlanOptions()))
        (fault,) = caught.value.diagnostics
        assert fault.code == "travel-exceeded"
        assert fault.span is not None
        assert fault.span.line == 1
        assert f"axis Y reaches {top:.4f} mm" in fault.message
        high = replace(machine, axes={**machine.axes, "Y": replace(y, travel=(-10.0, top))})
        assert len(next(checked([chunk], high, PlanOptions()))) == 1


def test_a_start_beyond_the_travel(lines: Callable[..., Toolpath], table: Machine) -> None:
    machine = replace(table, axes={**table.axes, "X": replace(table.axes["X"], travel=(5.0, 100.0))})
    with pytest.raises(NoPlanError, match=r"axis X starts at 0\.0000 mm, beyond its travel of 5 to 100 mm"):
        next(checked([lines([(0, 0), (10, 0)], 10.0)], machine, PlanOptions()))
    assert len(next(checked([lines([(6, 0), (10, 0)], 10.0)], machine, PlanOptions()))) == 1


def test_an_arc_of_ten_million_turns_is_refused_before_anything_is_made_of_it() -> None:
    """2π · 5 mm · 10⁷ at 1000 mm/min: 1.885e7 s, where 10⁹ periods of 1 ms are 10⁶ s."""
    text = "G21 G17\nG2 X0 Y0 I5 J0 P10000000 F1000\nM2\n"
    with pytest.raises(NoPlanError, match=r"takes 1\.885e\+07 s at least") as caught:
        list(cncgen.plan(cncgen.read_text(text, "turns.nc"), "xy-table"))
    (fault,) = caught.value.diagnostics
    assert fault.code == "motion-endless"
    assert fault.span is not None
    assert fault.span.line == 2


def test_a_line_of_a_loop_is_named_once_with_its_furthest_place() -> None:
    """It was named a thousand times."""
    text = "G21 G90 F3000\n#1=0\no1 repeat [100]\n#1=[#1+1]\nG1 X[10*#1] Y[-2*#1]\no1 endrepeat\nM2\n"
    with pytest.raises(NoPlanError) as caught:
        list(cncgen.plan(cncgen.read_text(text, "loop.ngc"), "xy-table"))
    (fault,) = caught.value.diagnostics
    assert "axis X is sent to 1000.0000 mm" in fault.message


def test_all_chunks_are_read_for_their_faults(lines: Callable[..., Toolpath], table: Machine) -> None:
    """Three chunks: beyond the travel, within it, and with an axis that the machine lacks; the axis is named once.

    What the program asks of the machine in any chunk is an error of the program, so its exception is the one that is raised.
    """
    machine = replace(table, axes={"X": replace(table.axes["X"], travel=(-10.0, 10.0))})
    far = lines([(0, 0), (20, 0)])
    again = replace(far, line=far.line + 7)
    chunks = [far, lines([(20, 0), (0, 0)]), lines([(0, 0), (0, 5)]), lines([(0, 5), (0, 0)]), again]
    yielded = []
    with pytest.raises(ProgramError) as caught:
        yielded.extend(checked(chunks, machine, PlanOptions()))
    found = [(fault.code, fault.span.line) for fault in caught.value.diagnostics if fault.span]
    # The second chunk starts where the first one ended, and goes back.
    assert found == [("axis-missing", 1), ("travel-exceeded", 1), ("travel-exceeded", 8)]
    assert yielded == []


@pytest.mark.parametrize(
    "curve",
    [
        "G2 X0 I5",
        "G2 X0 J5",
        "G2 X5 R10",
        "G5 I0 J3 P0 Q3 X5 Y0",
        "G6.2 P2 K0 X0 Y0 R1\nK0 X5 Y5 R1\nK1 X9 Y0 R1\nK2\nK2",
    ],
)
def test_a_curve_that_comes_back_moves_its_axes(table: Machine, curve: str) -> None:
    """Y was planned without any limit, as the curve ends at the Y where it begins."""
    machine = replace(table, axes={k: replace(table.axes["X"], letter=k) for k in "XZ"})
    program = cncgen.read_text(f"G21 G90 G17 F1000\n{curve}\nM2\n", "back.ngc")
    with pytest.raises(ProgramError) as caught:
        list(cncgen.plan(program, machine))
    (fault,) = caught.value.diagnostics
    assert fault.code == "axis-missing"
    assert "moves axis Y" in fault.message


def test_a_curve_in_a_plane_does_not_move_the_axis_across(table: Machine) -> None:
    """Lathes have no Y, and turn arcs in X and Z."""
    machine = replace(table, axes={k: replace(table.axes["X"], letter=k) for k in "XZ"})
    text = "G21 G90 G18 F1000\nG2 X0 Z0 I7.3 K-2.1\nG3 X3.1 Z-4.7 R9.77\nM2\n"
    assert len(list(cncgen.plan(cncgen.read_text(text, "turned.ngc"), machine))) == 1


def travel_faults(text: str) -> list[tuple[int, str]]:
    """Return line and message of what a program does beyond the travel of the X-Y table, −500 to 500 mm."""
    with pytest.raises(NoPlanError) as caught:
        list(cncgen.plan(cncgen.read_text(text, "far.nc"), "xy-table"))
    return [(fault.span.line, fault.message) for fault in caught.value.diagnostics if fault.span]


def test_what_leaves_the_travel_and_comes_back_is_one_fault() -> None:
    """Three motions of X beyond its travel, two of Y among them, and X once more: a fault each, with the furthest place."""
    rows = ["X510", "X530 Y-501", "X520 Y-502", "X0", "Y0", "X-600", "X0"]
    assert travel_faults("G21 G90 F3000\n" + "".join(f"G1 {row}\n" for row in rows) + "M2\n") == [
        (2, "axis X is sent to 530.0000 mm (line 3), beyond its travel of -500 to 500 mm; 3 motions from here on are beyond it"),
        (7, "axis X is sent to -600.0000 mm, beyond its travel of -500 to 500 mm"),
        (3, "axis Y is sent to -502.0000 mm (line 4), beyond its travel of -500 to 500 mm; 3 motions from here on are beyond it"),
    ]  # fmt: skip


def test_an_excursion_goes_on_over_chunks_and_events() -> None:
    """20,000 motions at X600, more than a chunk of reading has, with a stop of the spindle among them; the first Y0 is none."""
    rows = "".join(f"G1 Y{k % 7}\n" for k in range(10_000))
    ((line, told),) = travel_faults(f"G21 G90 F3000\nG1 X600\n{rows}M5\n{rows}G1 X0\nM2\n")
    assert line == 2
    wanted = "axis X is sent to 600.0000 mm, beyond its travel of -500 to 500 mm"
    assert told == f"{wanted}; 20000 motions from here on are beyond it"


def test_excursions_beyond_the_kept_ones_are_counted() -> None:
    """1,500 ways out and back: 1,000 are named."""
    rows = "".join(f"G1 X{501 + k}\nG1 X0\n" for k in range(1500))
    with pytest.raises(NoPlanError) as caught:
        list(cncgen.plan(cncgen.read_text(f"G21 G90 F3000\n{rows}M2\n"), "xy-table"))
    assert (len(caught.value.diagnostics), caught.value.suppressed) == (1000, 500)

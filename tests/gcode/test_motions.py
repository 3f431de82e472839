"""Lines and arcs: the toolpath they become, in machine coordinates, and the kernel against the handlers."""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cncgen.diagnostics import Diagnostics
from cncgen.gcode.flow.running import Runner
from cncgen.gcode.moved_axes import moving_axes
from cncgen.gcode.sinks.columns import ColumnsSink
from cncgen.gcode.sinks.counting import CountingSink
from cncgen.gcode.source import Source
from cncgen.kernels import gcode_motion
from cncgen.kernels.arc_centres import centre_from_radius
from cncgen.toolpath.building import ToolpathBuilder
from cncgen.toolpath.reading import ReadOptions
from cncgen.toolpath.record import FeedMode, Kind, PathMode, Toolpath
from tests.kernels.plain import uncompiled

from .reference import OneByOne

ROOT = Path(__file__).resolve().parent.parent.parent


def toolpath(text: str, batches: bool) -> tuple[Toolpath, list[str]]:
    """Read a text through the batch kernel or through the handlers alone."""
    builder = ToolpathBuilder("XYZABCUVW", np.zeros(9), ["t"])
    sink = ColumnsSink(builder)
    diagnostics = Diagnostics()
    for _ in (Runner if batches else OneByOne)(
        Source(text.encode(), "t"), ReadOptions(), sink, diagnostics
    ).run():
        pass
    sink.flush()
    return builder.take(), [d.render() for d in diagnostics]


def counted(text: str, batches: bool) -> tuple[int, list[str]]:
    """Count the motions and events of a text as a check does."""
    sink, diagnostics = CountingSink(), Diagnostics()
    for _ in (Runner if batches else OneByOne)(
        Source(text.encode(), "t"), ReadOptions(), sink, diagnostics
    ).run():
        pass
    return sink.count, [d.render() for d in diagnostics]


def same(a: Toolpath, b: Toolpath) -> None:
    """Assert that two toolpaths are equal to the bit."""
    for name in (
        "kind",
        "end",
        "feed",
        "feed_mode",
        "path_mode",
        "tolerance",
        "curve",
        "line",
        "source",
        "start",
    ):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)
    for name in ("centre", "normal", "sweep"):
        np.testing.assert_array_equal(getattr(a.arcs, name), getattr(b.arcs, name), err_msg=name)
    assert a.events == b.events


#: Whether a rare thing stands here.
_RARELY = st.integers(0, 5).map(lambda n: n == 0)


def decimal(low: float, high: float) -> st.SearchStrategy[str]:
    """A number with up to four decimals."""
    return st.floats(low, high).map(lambda x: f"{x:.4f}".rstrip("0").rstrip("."))


@st.composite
def motion_lines(draw: st.DrawFn) -> str:
    """A block of plain motion, right or wrong, or something between motions."""
    kind = draw(st.integers(0, 9))
    axes = draw(st.lists(st.sampled_from("XYZABCUVW"), max_size=3, unique=True))
    words = [letter + draw(decimal(-50, 50)) for letter in axes]
    if kind < 4:
        words.insert(0, draw(st.sampled_from(["", "G0 ", "G1 ", "g01 "])))
    elif kind < 6:
        offset = draw(decimal(-20, 20))
        words = [draw(st.sampled_from(["G2", "G3", ""])), "I" + offset]
        words += draw(st.sampled_from([["J" + offset], []]))
        # The point opposite the start is on the circle; any other end is most likely an error.
        words += draw(st.sampled_from([[f"X{2 * float(offset):.4f}"], ["Z1"], ["Y3 X1"], []]))
    elif kind == 6:
        words = [draw(st.sampled_from(["G2 ", "G3 "])), *words, "R" + draw(decimal(-60, 60))]
    else:
        words = [
            draw(
                st.sampled_from(
                    [
                        "G91",
                        "G90",
                        "F" + draw(decimal(0, 900)),
                        "G17",
                        "G18",
                        "G19",
                        "G20",
                        "G21",
                        "M3 S100",
                        "(note)",
                    ]
                )
            )
        ]
    if draw(st.integers(0, 4)) == 0:
        words.append("F" + draw(decimal(0, 500)))
    if draw(st.integers(0, 4)) == 0:
        words.insert(0, draw(st.sampled_from(["G17 ", "G18 ", "G90 G17 ", "G17 G17 ", "G91 G19 "])))
    return " ".join(words) + draw(st.sampled_from(["", " (remark)", " ; tail"]))


@st.composite
def shop_lines(draw: st.DrawFn) -> str:
    """A block of what stands between motions in a shop's programs, drilling too, right or wrong."""
    kind = draw(st.integers(0, 9))
    words = [
        x
        for x in ("M3", "M8", "M5", "M9", "M7", "M4", "G17", "G18", "G40", "G80", "G98", "G99", "G54", "M6")
        if draw(_RARELY)
    ]
    if kind < 5:
        places = [
            letter + draw(decimal(-20, 20))
            for letter in "XYUA"
            if draw(st.integers(0, 3)) == 0 or letter in "XY"
        ]
        rest = [f"R{draw(decimal(-1, 9))}", f"Z{draw(decimal(-9, 1))}"] if draw(st.booleans()) else []
        step = [f"{letter}{draw(decimal(-0.2, 4))}" for letter in "PQ" if draw(st.booleans())]
        words += [
            draw(st.sampled_from(["", "G81", "G82", "G73", "G83", "G85", "G89", "G84", "G0", "G1"])),
            *places,
            *rest,
            *step,
        ]
        words += [draw(st.sampled_from(["L2", "L0", "L1.5", "L3"]))] if draw(_RARELY) else []
    elif kind == 5:
        words += ["G4", f"P{draw(decimal(-0.1, 2))}"]
    elif kind == 6:
        words.append(f"S{draw(decimal(-10, 9000))}")
    elif kind == 7:
        words.append(
            draw(
                st.sampled_from(
                    [
                        "G90",
                        "G91",
                        "G20",
                        "G21",
                        "G94",
                        "G95",
                        "G61",
                        "G64",
                        "G96 S90",
                        "G97",
                        "G55",
                        "G1 X#5400",
                    ]
                )
            )
        )
    if draw(_RARELY):
        words.append(draw(st.sampled_from(["T1", "T0", "T12", "T2.5", "T-1", "T7 T8"])))
    if draw(_RARELY):
        words.append(f"F{draw(decimal(0, 500))}")
    return " ".join(words) + draw(st.sampled_from(["", " (remark)"]))


@settings(max_examples=150)
@given(st.lists(st.one_of(shop_lines(), shop_lines(), motion_lines()), min_size=1, max_size=25))
def test_the_batch_kernel_does_what_the_handlers_of_shop_programs_do(lines: list[str]) -> None:
    """Spindle, coolant, dwell, planes and holes in columns, beside each block through its handlers."""
    text = "F100 S500 M3\n" + "\n".join(lines) + "\nG0 X1\nM2\n"
    fast, fast_said = toolpath(text, batches=True)
    slow, slow_said = toolpath(text, batches=False)
    same(fast, slow)
    assert fast_said == slow_said
    assert counted(text, batches=True) == counted(text, batches=False)


@settings(max_examples=150)
@given(st.lists(motion_lines(), min_size=1, max_size=25))
def test_the_batch_kernel_does_what_the_handlers_do(lines: list[str]) -> None:
    text = "G91 F100\n" + "\n".join(lines) + "\nM2\n"
    fast, fast_said = toolpath(text, batches=True)
    slow, slow_said = toolpath(text, batches=False)
    same(fast, slow)
    assert fast_said == slow_said


@pytest.mark.parametrize("path", sorted((ROOT / "programs").glob("*.nc")), ids=lambda p: p.stem)
def test_the_batch_kernel_agrees_on_every_program(path: Path) -> None:
    fast, said = toolpath(path.read_text(), batches=True)
    slow, _ = toolpath(path.read_text(), batches=False)
    same(fast, slow)
    assert said == []
    assert len(fast) > 0


#: A row of holes below where the row before it began: the modes before a block are no other name of those after it.
TWO_ROWS = ["X0 Y1 Z2", "G81 X0 Y0 R1 Z0", "G0 X0 Y1", "Z0", "G98 G82 X0 Y0 R1 Z0 P0"]


@settings(max_examples=30)
@example(TWO_ROWS)
@given(st.lists(st.one_of(motion_lines(), shop_lines()), min_size=1, max_size=15))
def test_the_batch_kernel_runs_uncompiled(lines: list[str]) -> None:
    text = "F100 G1 X0 Y0\n" + "\n".join(lines) + "\n"
    compiled, said = toolpath(text, batches=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gcode_motion, "Advance", uncompiled("gcode_motion", "gcode_words").Advance)
        plain, plain_said = toolpath(text, batches=True)
    same(compiled, plain)
    assert said == plain_said


@given(
    st.floats(-100, 100),
    st.floats(-100, 100),
    st.floats(0.01, 3.1),
    st.floats(0.5, 80),
    st.booleans(),
    st.booleans(),
)
def test_the_centre_from_a_radius_is_the_circles_centre(
    x: float, y: float, angle: float, radius: float, clockwise: bool, large: bool
) -> None:
    """Points of a known circle, less or more than half a turn apart, give its centre back."""
    sense = -1.0 if clockwise else 1.0
    turn = sense * (2 * math.pi - angle if large else angle)
    start = (x + radius, y)
    end = (x + radius * math.cos(turn), y + radius * math.sin(turn))
    given_radius = -radius if large else radius
    centre = centre_from_radius(*start, *end, given_radius, clockwise, 1e-3)
    # The closer to half a turn, the worse the centre is determined.
    assert abs(centre - complex(x, y)) < 1e-5 * radius + 1e-9


def test_rows_of_a_small_program(run: Any) -> None:
    out = run("G21 G64 P0.02\nG0 X10 Y5\nN20 G1 Z-2 F600\nX20 A90\nM2\n")
    path = out.path
    assert (out.axes, out.moving_axes) == ("XYZA", "XYZA")
    assert path.kind.tolist() == [Kind.LINE, Kind.LINE, Kind.LINE, Kind.EVENT]
    np.testing.assert_allclose(
        path.end,
        [[10, 5, 0, 0], [10, 5, -2, 0], [20, 5, -2, math.pi / 2], [20, 5, -2, math.pi / 2]],
        atol=1e-12,
    )
    assert path.feed_mode.tolist()[:3] == [FeedMode.RAPID, FeedMode.SPEED, FeedMode.SPEED]
    np.testing.assert_allclose(path.feed[1:3], 10.0)
    assert np.isnan(path.feed[0])
    assert path.line.tolist() == [2, 3, 4, 5]
    assert (path.path_mode[:3] == PathMode.CONTINUOUS).all()
    np.testing.assert_allclose(path.tolerance[:3], 0.02)
    assert path.events[0].name == "end"


def test_inches_become_millimetres(run: Any) -> None:
    path = run("G20 F10 G1 X1 Y-2\nG21 X10\nM2").path
    np.testing.assert_allclose(path.end[:2, :2], [[25.4, -50.8], [10, -50.8]])
    np.testing.assert_allclose(path.feed[:2], [254.0 / 60.0, 10.0 / 60.0])


def test_feed_modes(run: Any) -> None:
    """G93: 1/s; G95: times the spindle's speed; rotary motion alone: rad/s."""
    path = run("G93 G1 X10 F30\nG95 F0.5 S120 M3\nG1 X20\nG94 F180 G1 A30\nM2").path
    rows = path.kind == Kind.LINE
    assert path.feed_mode[rows].tolist() == [FeedMode.INVERSE_TIME, FeedMode.SPEED, FeedMode.SPEED]
    np.testing.assert_allclose(path.feed[rows], [0.5, 1.0, math.radians(3.0)])


def test_start_comment_places_the_machine(run: Any) -> None:
    out = run("(START, X5 Y-2.5)\nG1 X6 F60\nM2")
    assert out.path.start.tolist() == [5.0, -2.5, 0.0]
    assert out.path.end[0].tolist() == [6.0, -2.5, 0.0]
    assert run("G0 X1\n(START, X5)\nM2").errors == [("start-late", 2, 1)]


@pytest.mark.parametrize(
    ("block", "sweep", "centre"),
    [
        ("G2 X0 Y10 I-10", 1.5 * math.pi, (0, 0, 0)),
        ("G3 X0 Y10 I-10", 0.5 * math.pi, (0, 0, 0)),
        ("G3 I-10", 2 * math.pi, (0, 0, 0)),
        ("G3 X0 Y10 I-10 P3", 4.5 * math.pi, (0, 0, 0)),
        ("G3 X0 Y10 R10", 0.5 * math.pi, (0, 0, 0)),
        ("G3 X0 Y10 R-10", 1.5 * math.pi, (10, 10, 0)),
        ("G2 X0 Y10 R10", 0.5 * math.pi, (10, 10, 0)),
        ("G90.1 G2 X-10 Y0 I0 J0", math.pi, (0, 0, 0)),
    ],
)
def test_arcs_in_the_xy_plane(run: Any, block: str, sweep: float, centre: tuple[float, ...]) -> None:
    out = run(f"(START, X10)\n{block} F100\nM2")
    assert out.errors == []
    np.testing.assert_allclose(out.path.arcs.sweep, [sweep])
    np.testing.assert_allclose(out.path.arcs.centre, [centre], atol=1e-9)
    clockwise = block.startswith("G2") or "G2" in block
    np.testing.assert_allclose(out.path.arcs.normal, [[0, 0, -1 if clockwise else 1]])


@pytest.mark.parametrize(
    ("plane", "block", "normal"),
    [("G18", "G3 Z10 X0 K0 I-10", (0, 1, 0)), ("G19", "G2 Y0 Z-10 J-10", (-1, 0, 0))],
)
def test_arcs_of_the_other_planes_keep_their_radius(run: Any, plane: str, block: str, normal: Any) -> None:
    out = run(f"(START, X10 Y10)\n{plane} {block} F100\nM2")
    assert out.errors == []
    arcs, path = out.path.arcs, out.path
    np.testing.assert_allclose(arcs.normal, [normal], atol=1e-12)
    radius = np.linalg.norm(path.start - arcs.centre[0])
    np.testing.assert_allclose(np.linalg.norm(path.end[0] - arcs.centre[0]), radius)
    np.testing.assert_allclose(turned(path, 1.0), path.end[0], atol=1e-9)


def turned(path: Toolpath, fraction: float) -> np.ndarray:
    """Return the point of the first arc at a fraction of its sweep (Rodrigues), without its helix part."""
    arcs = path.arcs
    n, v = arcs.normal[0], path.start[:3] - arcs.centre[0]
    a = arcs.sweep[0] * fraction
    return arcs.centre[0] + v * math.cos(a) + np.cross(n, v) * math.sin(a) + n * (n @ v) * (1 - math.cos(a))


def test_a_rotated_system_turns_arcs_with_it(run: Any) -> None:
    out = run("G10 L2 P1 X5 R90\nG0 X10 Y0\nG3 X0 Y10 I-10 F100\nM2")
    np.testing.assert_allclose(out.path.end[:2, :2], [[5, 10], [-5, 0]], atol=1e-9)
    np.testing.assert_allclose(out.path.arcs.centre, [[5, 0, 0]], atol=1e-9)
    np.testing.assert_allclose(out.path.arcs.sweep, [math.pi / 2])


def test_lines_of_no_length_are_left_out(run: Any) -> None:
    path = run("G0 X0\nG1 X5 F100\nG1 X5\nG2 I1\nM2").path
    assert path.kind.tolist() == [Kind.LINE, Kind.ARC, Kind.EVENT]


def test_a_million_lines_come_in_chunks_of_bounded_size() -> None:
    from cncgen.gcode import read

    text = b"F100\n" + b"".join(b"G1X%dY%d\n" % (i % 97, i % 89) for i in range(50_000)) + b"M2\n"
    program = read(io.BytesIO(text), "t", ReadOptions(chunk_rows=5_000))
    sizes = [len(chunk) for chunk in program.chunks()]
    # The first line does not move: it starts where it ends.
    assert sum(sizes) == 50_000
    assert max(sizes) < 5_000 + 16_384


@given(st.text("XYZABCUVWxyzabc G01.-\n();", max_size=60))
def test_moving_axes_are_named_axes(text: str) -> None:
    assert set(moving_axes(Source(text.encode(), "t"), "linuxcnc")) <= set(text.upper())

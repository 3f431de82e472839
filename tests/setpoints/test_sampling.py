"""Sampling: exact at every tick, the same however it is cut, derivatives by differences, events in their chunk."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cncgen
from cncgen.diagnostics import NoPlanError, UsageError
from cncgen.geometry.tables import NurbsTable, empty_arcs, empty_nurbs
from cncgen.machine import Machine, load
from cncgen.planner.motion import cut
from cncgen.planner.record import Limit, Profile, Trajectory
from cncgen.setpoints import sampling
from cncgen.setpoints.sampling import sample
from cncgen.toolpath.record import Event, Kind, Toolpath

RNG = np.random.default_rng(11)


@pytest.fixture(scope="module")
def machine() -> Machine:
    """Return a machine of 1 ms."""
    return load("xy-table")


def path_rows(points: np.ndarray, curved: bool = False) -> Toolpath:
    """Return lines through points, or one cubic with these control points."""
    x = np.concatenate([points, np.zeros((len(points), 3 - points.shape[1]))], axis=1)
    n = len(x)
    kind, end, curve, table = np.zeros(n - 1, np.int8), x[1:], np.full(n - 1, -1), empty_nurbs(3)
    if curved:
        knots = np.concatenate([np.zeros(4), np.arange(1, n - 3) / (n - 3), np.ones(4)])
        table = NurbsTable(np.array([3]), np.array([0, n]), np.array([0, n + 4]), x, np.ones(n), knots)
        kind, end, curve = np.array([Kind.NURBS], np.int8), x[-1:], np.zeros(1, np.int64)
    rows = len(kind)
    flat, none = np.zeros(rows, np.int8), np.full(rows, np.nan)
    return Toolpath(
        "XYZ", x[0], kind, end, np.full(rows, 50.0), flat, flat + 1, none, curve, np.arange(rows) + 5,
        np.zeros(rows, np.int16), empty_arcs(), table, (), ("t.nc",),
    )  # fmt: skip


def smooth_profile(length: float) -> Profile:
    """Return a profile of constant jerk pieces from rest to rest: J, −J, −J, J over equal times."""
    tau, jerk = (length / (2.0 * 2e4)) ** (1.0 / 3.0), 2e4
    t = tau * np.arange(5)
    v = jerk * tau**2 * np.array([0.0, 0.5, 1.0, 0.5])
    a = jerk * tau * np.array([0.0, 1.0, 0.0, -1.0])
    j = jerk * np.array([1.0, -1.0, -1.0, 1.0])
    s = np.concatenate([[0.0], np.cumsum(v * tau + a * tau**2 / 2 + j * tau**3 / 6)])
    return Profile(t, s, v, a, j, np.zeros(4), np.array([Limit.JERK] * 4, np.int8))


def trajectory_on(toolpath: Toolpath, **more: object) -> Trajectory:
    """Return a trajectory over a whole toolpath."""

    row_s = toolpath.path.row_s
    return Trajectory(toolpath, row_s, smooth_profile(float(row_s[-1])), **more)


def rows_of(trajectories: list[Trajectory], machine: Machine, **more: object) -> np.ndarray:
    """Sample and put the positions together."""
    return np.concatenate([c.position for c in sample(trajectories, machine, **more)])


def test_line_at_every_tick(machine: Machine) -> None:
    """Closed form on a line: x = J t³/6 at first, from the start at t = 0 to the end at the first tick after it."""
    done = trajectory_on(path_rows(np.array([[1.0, 2.0], [4.0, 6.0]])))
    x = rows_of([done], machine)
    assert done.profile.t[-1] == pytest.approx(0.2)
    assert len(x) == 201
    assert x[0].tolist() == [1.0, 2.0, 0.0]
    assert x[-1].tolist() == [4.0, 6.0, 0.0]
    k = np.arange(10)
    s = 2e4 * (k * 1e-3) ** 3 / 6.0
    np.testing.assert_allclose(x[:10, 0], 1.0 + 0.6 * s, rtol=1e-14)
    np.testing.assert_allclose(x[:10, 1], 2.0 + 0.8 * s, rtol=1e-14)


@given(st.lists(st.floats(0.001, 0.999), min_size=1, max_size=6, unique=True))
def test_cutting_a_trajectory_changes_nothing(places: list[float]) -> None:
    """A trajectory in parts, cut anywhere, gives the same rows to 1e-12 mm."""
    machine = load("xy-table")
    whole = trajectory_on(
        path_rows(np.array([[0.0, 0.0], [10.0, 0.0], [12.0, 9.0], [3.0, 8.0], [1.0, 1.0]]), True)
    )
    end = float(whole.profile.t[-1])
    times = [0.0, *sorted(p * end for p in places), end]
    parts = [
        Trajectory(whole.toolpath, whole.row_s, cut(whole.profile, a, b))
        for a, b in zip(times, times[1:], strict=False)  # noqa: RUF007
    ]
    np.testing.assert_allclose(rows_of(parts, machine), rows_of([whole], machine), atol=1e-12)


def test_chunks_are_bounded(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows come in chunks of the size set, numbered through."""
    whole = trajectory_on(path_rows(np.array([[0.0, 0.0], [50.0, 0.0]])))
    plain = rows_of([whole], machine)
    monkeypatch.setattr(sampling, "CHUNK_ROWS", 16)
    chunks = list(sample([whole], machine))
    assert max(len(c) for c in chunks) == 16
    assert [c.first for c in chunks] == list(np.cumsum([0, *[len(c) for c in chunks[:-1]]]))
    assert (np.concatenate([c.position for c in chunks]) == plain).all()
    assert chunks[1].time_s[0] == pytest.approx(0.016)


def test_signals_are_the_derivatives(machine: Machine) -> None:
    """vel, acc and jerk against central differences of a finely sampled motion; feed, line and limit as planned."""
    whole = trajectory_on(
        path_rows(np.array([[0.0, 0.0], [20.0, 0.0], [22.0, 19.0], [3.0, 18.0], [1.0, 1.0]]), True)
    )
    h, inner = 1e-4, slice(3, -3)
    chunk, _ = sample([whole], replace(machine, period_s=h), signals=sampling.SIGNALS)
    x = chunk.position
    one = (x[2:] - x[:-2]) / (2 * h)
    two = (x[2:] - 2 * x[1:-1] + x[:-2]) / h**2
    three = (x[4:] - 2 * x[3:-1] + 2 * x[1:-3] - x[:-4]) / (2 * h**3)
    v, a, j = (chunk.signals[n] for n in ("vel", "acc", "jerk"))
    np.testing.assert_allclose(v[1:-1][inner], one[inner], atol=1e-3)
    np.testing.assert_allclose(a[1:-1][inner], two[inner], atol=4.0)
    # Where a piece or a knot lies between the samples the third difference is an average over the jump.
    assert np.median(np.abs(j[2:-2] - three)) < 200.0
    np.testing.assert_allclose(chunk.signals["feed"], np.linalg.norm(v, axis=1), rtol=1e-9, atol=1e-9)
    assert set(chunk.signals["line"].tolist()) == {5}
    assert set(chunk.signals["limit"].tolist()) <= {int(Limit.JERK)}


def test_lines_of_rows(machine: Machine) -> None:
    """The line signal follows the rows: 5 on the first, 6 on the second; a joint belongs to the row before it."""
    whole = trajectory_on(path_rows(np.array([[0.0, 0.0], [4.0, 0.0], [8.0, 0.0]])))
    chunks = list(sample([whole], machine, signals=["line"]))
    line = np.concatenate([c.signals["line"] for c in chunks])
    x = np.concatenate([c.position[:, 0] for c in chunks])
    assert (line == np.where(x <= 4.0, 5, 6)).all()


def test_axes_are_chosen_and_ordered(machine: Machine) -> None:
    """`axes` picks columns."""
    whole = trajectory_on(path_rows(np.array([[0.0, 5.0, 7.0], [3.0, 5.0, 7.0]])))
    (chunk, *_) = sample([whole], machine, axes="YX")
    assert chunk.axes == "YX"
    assert chunk.position[0].tolist() == [5.0, 0.0]


def test_events_fall_into_their_chunk(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every event comes out once, in the chunk of its time; those after the last tick with the last row."""
    monkeypatch.setattr(sampling, "CHUNK_ROWS", 10)
    events = tuple((t, i, Event(f"e{i}")) for i, t in enumerate([0.0, 0.0101, 0.05, 10.0]))
    whole = trajectory_on(path_rows(np.array([[0.0, 0.0], [5.0, 0.0]])), events=events)
    chunks = list(sample([whole], machine))
    found = [(e[1], c.first) for c in chunks for e in c.events]
    assert [n for n, _ in found] == [0, 1, 2, 3]
    assert [first // 10 for n, first in found[:3]] == [0, 1, 5]
    assert found[3][1] == chunks[-1].first


def test_a_wait_holds(machine: Machine) -> None:
    """A piece of no speed repeats the position; a whole number of periods does not add a row."""
    toolpath = path_rows(np.array([[2.0, 3.0], [4.0, 3.0]]))
    zero = np.zeros(1)
    wait = Profile(
        np.array([0.0, 0.02]), np.zeros(2), zero, zero, zero, zero, np.array([Limit.STOP], np.int8)
    )
    x = rows_of([Trajectory(toolpath, np.array([0.0, 2.0]), wait)], machine)
    assert x.tolist() == [[2.0, 3.0, 0.0]] * 21


def test_a_motion_of_next_to_no_time_has_its_start_and_its_end(machine: Machine) -> None:
    """1e-7 mm at 167 mm/s at once take 0.6 ns: the first row is the start position all the same."""
    options = cncgen.PlanOptions(feedrate="constant")
    text = "G21 G90 G61\nG1 X0.0000001 F10000\nM2\n"
    got = sample(cncgen.plan(cncgen.read_text(text), machine, options), machine)
    assert np.concatenate([chunk.position[:, 0] for chunk in got]).tolist() == [0.0, 1e-7]


def test_nothing_gives_nothing_and_faults_are_named(machine: Machine) -> None:
    """No trajectories, no rows; unknown signals are all named at once."""
    assert list(sample([], machine)) == []
    with pytest.raises(UsageError, match="speed, thrust"):
        sample([], machine, signals=["vel", "speed", "thrust"])


@pytest.mark.parametrize(("block", "line"), [("G4 P10000000", 3), ("G1 X3 F0.00001", 3)])
def test_a_motion_that_never_ends_is_refused_at_its_line(block: str, line: int) -> None:
    """Ten million seconds of dwell, or 2 mm at 10 nm a minute: at a millisecond more than 10^9 setpoints."""
    text = f"G21 G90 G61\nG1 X1 F600\n{block}\nG1 X0 F600\nM2\n"
    with pytest.raises(NoPlanError) as caught:
        cncgen.sample(
            cncgen.plan(
                cncgen.read_text(text, "slow.nc", options=cncgen.ReadOptions(dialect="linuxcnc")), "xy-table"
            )
        ).collect()
    (fault,) = caught.value.diagnostics
    assert fault.code == "motion-endless"
    assert fault.span is not None
    assert (fault.span.file, fault.span.line) == ("slow.nc", line)


@pytest.mark.parametrize("feedrate", ["optimal", "ild"])
@pytest.mark.parametrize("mode", ["G61", "G64 P0.05"])
def test_while_an_event_lasts_the_line_is_its_own(feedrate: str, mode: str) -> None:
    """Dwells of 0.3 and 0.2 s on lines 3 and 5, at 1 ms; the motions about them are on lines 2 and 4.

    Within the tolerance, path and speed of line 2 are planned together, and the dwell is in the next stretch.
    """
    program = cncgen.read_text(f"G21 G90 {mode} F3000\nG1 X5\nG4 P0.3\nX10\nG4 P0.2\nM2\n")
    stream = cncgen.sample(cncgen.plan(program, "xy-table", feedrate=feedrate), ["line"])
    line = np.concatenate([chunk.signals["line"] for chunk in stream.chunks])
    assert [line[k] for k in np.flatnonzero(np.diff(line, prepend=-1))] in ([2, 3, 4, 5], [2, 3, 4, 5, 4])
    counts = {number: int((line == number).sum()) for number in (3, 5)}
    assert counts == {3: pytest.approx(300, abs=1), 5: pytest.approx(200, abs=1)}

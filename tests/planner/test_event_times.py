"""The machine's own time for events: closed forms of each entry of ``[times]``, and parts that add up to the cycle time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cncgen
from cncgen.diagnostics import UsageError
from cncgen.machine import Machine, load
from cncgen.machine.times import Times, times_of
from cncgen.pipeline import plan_with_summary

ROOT = Path(__file__).resolve().parents[2]
TABLE = {
    "tool_change_s": 4.0,
    "pocket_s": 0.25,
    "pockets": 20,
    "spindle_acceleration_rpm_s": 6000.0,
    "spindle_braking_rpm_s": 8000.0,
    "coolant_s": 0.2,
    "operator_stop_s": 30.0,
    "m_codes": {"m08": 0.3},
}
HEAD = "G21 G90 G17 G64 F3000\n"


def machine(**table: Any) -> Machine:
    return replace(load("xy-table"), settings={"times": table})


def summary_of(text: str, tmp_path: Path, where: Machine, **options: Any) -> tuple[dict[str, Any], Any]:
    path = tmp_path / "part.nc"
    path.write_text(text)
    stream, watch = plan_with_summary(path, where, **options)
    rows = stream.collect()
    return watch.as_json(), rows


def split(text: str, tmp_path: Path, **table: Any) -> dict[str, float]:
    return summary_of(text, tmp_path, machine(**table))[0]["cycle_time_split_s"]


def test_a_tool_change_takes_its_time_the_short_way_round_and_brakes_the_spindle(tmp_path: Path) -> None:
    parts = split(HEAD + "T1 M6\nS12000 M3\nG1 X10\nT18 M6\nX0\nM2\n", tmp_path, **TABLE)
    # The first change has no pocket before it; from pocket 1 to 18 of 20 there are three; 12,000 rpm brake in 1.5 s.
    assert parts["tool"] == pytest.approx(4.0 + 1.5 + 4.0 + 3 * 0.25, abs=1e-12)
    assert parts["spindle"] == pytest.approx(2.0, abs=1e-12)


def test_a_reversal_brakes_and_speeds_up(tmp_path: Path) -> None:
    parts = split(HEAD + "S6000 M3\nG1 X1\nM4\nX0\nM5\nM2\n", tmp_path, **TABLE)
    assert parts["spindle"] == pytest.approx(1.0 + (0.75 + 1.0) + 0.75, abs=1e-12)


def test_a_ramp_is_read_between_its_pairs() -> None:
    times = Times(spindle_ramp=((1000.0, 1.0), (3000.0, 2.0)))
    assert times.spindle_s(0.0, 500.0) == pytest.approx(0.5)
    assert times.spindle_s(0.0, 2000.0) == pytest.approx(1.5)
    assert times.spindle_s(1000.0, 5000.0) == pytest.approx(2.0)
    assert times.spindle_s(1000.0, -1000.0) == pytest.approx(2.0)


def test_coolant_takes_its_time_and_that_of_its_code(tmp_path: Path) -> None:
    parts = split(HEAD + "M8\nG1 X1\nM9\nM9\nX0\nM2\n", tmp_path, **TABLE)
    assert parts["other"] == pytest.approx(0.2 + 0.3 + 0.2, abs=1e-9)


def test_operator_stops_are_counted_apart(tmp_path: Path) -> None:
    parts = split(HEAD + "G1 X1\nM0\nX0\nG4 P0.5\nM2\n", tmp_path, **TABLE)
    assert (parts["stops"], parts["dwell"]) == (30.0, 0.5)


def test_a_control_takes_its_time_for_each_block(tmp_path: Path) -> None:
    text = HEAD + "".join(f"G1 X{k / 100:g}\n" for k in range(1, 1001)) + "M2\n"
    fast = summary_of(text, tmp_path, machine())[0]["cycle_time_s"]
    slow = summary_of(text, tmp_path, machine(block_s=0.002))[0]["cycle_time_s"]
    assert fast < 0.5
    assert slow == pytest.approx(1000 * 0.002, rel=0.05)
    assert slow >= 1000 * 0.002


@pytest.mark.parametrize("feedrate", ["optimal", "ild", "constant"])
def test_axes_stand_while_an_event_lasts(tmp_path: Path, feedrate: str) -> None:
    text = HEAD + "G1 X10\nT2 M6\nX0\nM2\n"
    result, rows = summary_of(text, tmp_path, machine(tool_change_s=1.25), feedrate=feedrate)
    (event,) = [(t, e) for t, _, e in rows.events if e.name == "tool"]
    inside = (rows.time_s > event[0]) & (rows.time_s < event[0] + 1.25)
    assert inside.sum() >= 1249
    assert np.ptp(rows.position[inside], axis=0).max() == 0.0
    assert result["cycle_time_split_s"]["tool"] == 1.25


@pytest.mark.parametrize(
    "name",
    sorted(
        p.relative_to(ROOT / "programs").as_posix()
        for kind in ("*.nc", "lathe/*.nc", "stepnc/*.stp")
        for p in (ROOT / "programs").glob(kind)
    ),
)
def test_parts_add_up_to_the_cycle_time_of_each_program(name: str) -> None:
    """Each part is summed up from pieces and events of its own kind; the setpoints of each kind, counted, say the same."""
    base = load("generic-mill")
    where = replace(base, settings={**base.settings, "times": TABLE})
    stream, watch = plan_with_summary(ROOT / "programs" / name, where, effort="fast", signals=("programmed",))
    rows = stream.collect()
    result = watch.as_json()
    parts = result["cycle_time_split_s"]
    assert sum(parts.values()) == pytest.approx(result["cycle_time_s"], abs=1e-6)
    assert all(seconds >= -1e-9 for seconds in parts.values())
    assert abs(result["cycle_time_s"] - rows.time_s[-1]) <= where.period_s + 1e-9
    # Setpoints between the events that take time, by whether the row that they are on is a rapid.
    standing = np.zeros(len(rows), bool)
    for t_s, _, event in rows.events:
        standing |= (rows.time_s > t_s + 1e-9) & (rows.time_s <= t_s + event.takes_s + event.dwell_s + 1e-9)
    rapid = rows.signals["programmed"] == 0.0
    # A boundary between two kinds falls anywhere within a period.
    edges = 1 + len(rows.events) + np.count_nonzero(np.diff(rapid))
    for kind, found in {"rapid": rapid & ~standing, "cutting": ~rapid & ~standing}.items():
        assert parts[kind] == pytest.approx(found.sum() * where.period_s, abs=edges * where.period_s), kind


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("tool_change_s = -1", "times.tool_change_s: must be a number from 0"),
        ("spindle_ramp = [[2000, 1], [1000, 2]]", "times.spindle_ramp: must be rising pairs"),
        ("m_codes = { G8 = 1 }", "times.m_codes: must be a table like"),
        ("tool_changes_s = 1", "did you mean tool_change_s?"),
    ],
)
def test_wrong_times_are_named(tmp_path: Path, line: str, told: str) -> None:
    path = tmp_path / "m.toml"
    path.write_text(f"{cncgen.machine.to_toml(load('xy-table'))}\n[times]\n{line}\n")
    with pytest.raises(UsageError) as caught:
        load(path)
    assert told in str(caught.value)


def test_times_survive_a_file() -> None:
    path_text = cncgen.machine.to_toml(machine(**TABLE, spindle_ramp=[[1000.0, 1.0]]))
    from cncgen.machine.reading import machine_from_toml

    again = times_of(machine_from_toml(path_text.encode(), "m.toml"))
    assert again == times_of(machine(**TABLE, spindle_ramp=[[1000.0, 1.0]]))
    assert again.m_codes["M8"] == 0.3

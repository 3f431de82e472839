"""Running a sweep: the same rows however it is computed, restarts, failures, deaths of workers and of the driver."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from pathlib import Path

import numpy as np
import pytest

from cncgen.cli.app import run
from cncgen.diagnostics import UsageError
from cncgen.pipeline import plan_with_summary, simulate
from cncgen.planner import PlanOptions
from cncgen.servo.summary import summarize
from cncgen.sweep import jobs, local_workers
from cncgen.sweep.definition import SweepDefinition, load_sweep
from cncgen.sweep.driver import JobQueue, Progress, RowWriter, layout_of, run_sweep
from cncgen.sweep.jobs import JobOutcome, Place, SweepJob
from cncgen.sweep.local_workers import Batch, Done, LocalWorkers
from cncgen.sweep.results import FIRST, LAST, ResultsFolder, RowLayout

pa = pytest.importorskip("pyarrow")

Rows = dict[str, tuple[object, ...]]


def rows_of(path: str | Path) -> Rows:
    """Return the rows of results by key; a key that stands twice fails."""
    table = ResultsFolder(path).table().to_pylist()
    found = {row["key"]: tuple(row.items()) for row in table}
    assert len(found) == len(table)
    return found


class Here:
    """Workers that compute in this process."""

    count = 1

    def __init__(self, sweep: SweepDefinition) -> None:
        jobs.take_bundles(list(sweep.programs.values()))
        self._batches: list[Batch] = []

    def submit(self, batch: Batch) -> None:
        self._batches.append(batch)

    def completed(self, timeout_s: float) -> list[Done]:
        batch = self._batches.pop(0)
        return [(batch, jobs.compute_batch(jobs.code_version(), batch))]

    def close(self) -> None:
        self._batches.clear()


def swept(sweep: SweepDefinition, path: str, processes: int) -> Progress:
    """Run a sweep on processes of its own."""
    workers = LocalWorkers(processes, list(sweep.programs.values()))
    try:
        return run_sweep(sweep, path, workers)
    finally:
        workers.close()


def test_rows_are_what_plan_and_simulate_say(folder: Path) -> None:
    sweep = load_sweep("sweep.toml")
    run_sweep(sweep, "R", Here(sweep))
    for row in ResultsFolder("R").table().to_pylist()[:3]:
        text = (
            subprocess.run(
                [sys.executable, "-m", "cncgen", "machines", "show", "xy-table"],
                capture_output=True,
                check=True,
            )
            .stdout.decode()
            .replace("max_jerk_mm_s3 = 50000.0", f"max_jerk_mm_s3 = {row['axes.*.max_jerk_mm_s3']!r}")
            .replace(
                "position_gain_1_s = 121.31\n",
                f"position_gain_1_s = {row['axes.x.servo.position_gain_1_s']!r}\n",
            )
        )
        (folder / "m.toml").write_text(text)
        stream, summary = plan_with_summary("part.nc", "m.toml", PlanOptions())
        setpoints = stream.collect()
        assert row["cycle_time_s"] == summary.as_json()["cycle_time_s"]
        assert row["contour_error_max_mm"] == summarize(simulate(setpoints, "m.toml"))["contour_error_max_mm"]


def test_one_and_two_processes_and_this_one_give_the_same_rows_to_the_bit(folder: Path) -> None:
    sweep = load_sweep("sweep.toml")
    run_sweep(sweep, "here", Here(sweep))
    ends = [swept(sweep, f"with{count}", count) for count in (1, 2)]
    assert [end.computed for end in ends] == [8, 8]
    assert rows_of("here") == rows_of("with1") == rows_of("with2")
    again = run_sweep(sweep, "with1", Here(sweep))
    assert (again.done, again.computed) == (8, 0)


def test_a_sweep_that_grew_computes_the_new_points_alone(folder: Path) -> None:
    sweep = load_sweep("sweep.toml")
    run_sweep(sweep, "R", Here(sweep))
    (folder / "sweep.toml").write_text(
        (folder / "sweep.toml").read_text().replace("points = 8", "points = 16")
    )
    more = load_sweep("sweep.toml")
    assert run_sweep(more, "R", Here(more)).computed == 8


def test_rows_of_another_sweep_are_not_mixed_in(folder: Path) -> None:
    sweep = load_sweep("sweep.toml")
    run_sweep(sweep, "R", Here(sweep))
    (folder / "part.nc").write_text("G21 G61 F600\nG1 X5\nM2\n")
    other = load_sweep("sweep.toml")
    with pytest.raises(UsageError, match="8 of 8 rows that are not of this sweep"):
        run_sweep(other, "R", Here(other))


def test_a_folder_with_other_files_is_refused(folder: Path) -> None:
    (folder / "R").mkdir()
    (folder / "R" / "thesis.tex").write_text("")
    sweep = load_sweep("sweep.toml")
    with pytest.raises(UsageError, match=r"thesis\.tex"):
        run_sweep(sweep, "R", Here(sweep))


def test_a_second_driver_is_kept_out(folder: Path) -> None:
    sweep = load_sweep("sweep.toml")
    results = ResultsFolder("R")
    results.prepare()
    with results.locked(), pytest.raises(UsageError, match="another sweep writes"):
        run_sweep(sweep, "R", Here(sweep))


def test_processes_are_started_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C amid the start of a process waits for its end: the process died with a traceback of Python's."""
    held: list[set[signal.Signals]] = []

    def blocked() -> set[signal.Signals]:
        return {signal.Signals(each) for each in signal.pthread_sigmask(signal.SIG_BLOCK, ())}

    class Pool:
        def __init__(self, *_: object, **__: object) -> None: ...

        def submit(self, *_: object) -> Future[object]:
            held.append(blocked())
            return Future()

    monkeypatch.setattr(local_workers, "ProcessPoolExecutor", Pool)
    before = blocked()
    LocalWorkers(2, ()).submit(())
    assert held[0] >= {signal.SIGINT, signal.SIGTERM}
    assert blocked() == before


def test_a_lock_that_nobody_can_write_is_named(tmp_path: Path) -> None:
    """As on a read-only disk: it ended in the words of the system."""
    (tmp_path / "_lock").mkdir()
    with (
        pytest.raises(UsageError, match=r"cannot write .*_lock: it is a directory"),
        ResultsFolder(tmp_path).locked(),
    ):
        pass


def test_failed_jobs_are_rows_with_their_diagnostic_and_are_done_again_when_asked(folder: Path) -> None:
    """X900 is beyond the travel of 500 mm."""
    (folder / "s.toml").write_text(
        'programs = ["part.nc"]\nmachine = "xy-table"\n[vary]\nprofile = ["bell", "linear"]\n'
        "max_contour_error_mm = [1e-6, 0.01]\n[options]\nfeedrate = 'ild'\n[keep]\nfigures = ['cycle_time_s']\n"
    )
    (folder / "part.nc").write_text("G21 G61 F600\nG1 X900\nM2\n")
    sweep = load_sweep("s.toml")
    end = run_sweep(sweep, "R", Here(sweep))
    assert (end.total, end.failed) == (4, 4)
    for row in ResultsFolder("R").table().to_pylist():
        assert row["code"] == "travel-exceeded"
        assert row["error"].startswith("part.nc:2:")
        assert row["cycle_time_s"] is None
    assert run_sweep(sweep, "R", Here(sweep)).computed == 0
    assert run_sweep(sweep, "R", Here(sweep), again_failed=True).computed == 4
    assert len(rows_of("R")) == 4


def killed(path: str, moments: Sequence[float], whole_group: bool = False) -> Iterator[int]:
    """Run the command again and again, and kill its driver so many seconds after the start; yield its rows each time."""
    for moment in moments:
        process = subprocess.Popen(
            [sys.executable, "-m", "cncgen", "sweep", "sweep.toml", "-o", path, "--processes", "1", "-q"]
        )
        try:
            process.wait(moment)
        except subprocess.TimeoutExpired:
            os.kill(process.pid, signal.SIGKILL)
            process.wait()
        yield len(rows_of(path)) if ResultsFolder(path).parts() else 0


@pytest.mark.slow
def test_a_killed_driver_loses_no_row_and_doubles_none(folder: Path) -> None:
    sweep = load_sweep("sweep.toml")
    run_sweep(sweep, "whole", Here(sweep))
    counts = list(killed("R", [1.5, 4.0, 6.0]))
    assert counts == sorted(counts)
    end = run_sweep(sweep, "R", Here(sweep))
    assert end.done == 8
    assert rows_of("R") == rows_of("whole")


class Deadly(LocalWorkers):
    """Local workers of which one is killed each time that a batch comes back, up to so many times."""

    deaths = 2

    def completed(self, timeout_s: float) -> list[Done]:
        done = super().completed(timeout_s)
        processes = list((self._pool and self._pool._processes) or ())
        if done and processes and self.deaths:
            self.deaths -= 1
            os.kill(processes[0], signal.SIGKILL)
        return done


@pytest.mark.slow
def test_a_killed_worker_loses_no_row_and_doubles_none(folder: Path) -> None:
    sweep = load_sweep("sweep.toml")
    run_sweep(sweep, "whole", Here(sweep))
    workers = Deadly(2, list(sweep.programs.values()))
    try:
        end = run_sweep(sweep, "R", workers)
    finally:
        workers.close()
    assert (end.done, end.failed) == (8, 0)
    assert workers.deaths < Deadly.deaths
    assert rows_of("R") == rows_of("whole")


class Poisoned:
    """Workers that die of one job."""

    count = 2

    def __init__(self, poison: str) -> None:
        self._poison = poison
        self._batches: list[Batch] = []
        self.alone = 0

    def submit(self, batch: Batch) -> None:
        self._batches.append(batch)

    def completed(self, timeout_s: float) -> list[Done]:
        batches, self._batches = self._batches, []
        if any(job.key == self._poison for batch in batches for job in batch):
            self.alone += len(batches) == 1
            return [(batch, None) for batch in batches]  # a broken pool loses all of them
        return [(batch, ([JobOutcome(job.key, {}) for job in batch], 0.1)) for batch in batches]

    def close(self) -> None:
        pass


def test_a_job_that_kills_its_workers_fails_alone() -> None:
    every = [SweepJob(str(k), "", "", {}, {}, ()) for k in range(9)]
    workers = Poisoned("4")
    found = list(JobQueue(every, workers).outcomes())
    assert sorted(outcome.key for outcome in found) == [job.key for job in every]
    assert [outcome.key for outcome in found if outcome.code] == ["4"]
    assert [outcome.code for outcome in found if outcome.code] == ["worker-died"]
    assert workers.alone == 3


def test_a_part_that_was_damaged_is_named(folder: Path) -> None:
    sweep = load_sweep("sweep.toml")
    run_sweep(sweep, "R", Here(sweep))
    part = ResultsFolder("R").parts()[0]
    part.write_bytes(part.read_bytes()[:-20])
    with pytest.raises(UsageError, match=part.name):
        run_sweep(sweep, "R", Here(sweep))
    part.unlink()
    assert run_sweep(sweep, "R", Here(sweep)).done == 8


def test_figures_without_sensitivities_share_a_line(
    folder: Path, with_sweep: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """No drive saturates and nothing dwells here, whatever is drawn; two rows are too few for an expansion."""
    named = (
        (folder / "sweep.toml")
        .read_text()
        .replace('"setpoints_to_path_mm"', '"saturated_samples", "dwell_time_s"')
    )
    with_sweep(named)
    sweep = load_sweep("sweep.toml")
    run_sweep(sweep, "R", Here(sweep))
    assert run(["sweep", "show", "R"]) == 0
    said = capsys.readouterr().out
    assert said.endswith("\nthe same in all rows: saturated_samples, dwell_time_s\n")
    with_sweep(named.replace("points = 8", "points = 2"))
    sweep = load_sweep("sweep.toml")
    run_sweep(sweep, "two", Here(sweep))
    assert run(["sweep", "show", "two"]) == 0
    assert "too few rows for sensitivities: cycle_time_s, contour_error_max_mm\n" in capsys.readouterr().out


def test_show_ranks_and_writes_the_table(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sweep = load_sweep("sweep.toml")
    run_sweep(sweep, "R", Here(sweep))
    assert run(["sweep", "show", "R", "-o", "t.csv", "--summary", "s.json", "--top", "3"]) == 0
    assert "shares of the variance" in capsys.readouterr().out
    summary = json.loads((folder / "s.json").read_text())
    by_key = {key: dict(row) for key, row in rows_of("R").items()}
    times = [by_key[key]["cycle_time_s"] for key in summary["ranking"]]
    assert times == sorted(times)
    assert (folder / "t.csv").read_text().count("\n") == 9
    assert run(["sweep", "show", "R", "--by", "nonsense"]) == 2
    parts = sorted(path.name for path in Path("R").iterdir())
    assert run(["sweep", "show", "R", "-o", "R/all.parquet"]) == 2  # pandas would read each row twice
    assert sorted(path.name for path in Path("R").iterdir()) == parts


def test_each_program_has_its_front_and_its_best_rows(
    folder: Path, with_sweep: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """A short program beat every row of a longer one, which no front had."""
    (folder / "long.nc").write_text("G21 G17 G90 G61\nF3000\nG1 X50 Y1\nG1 X90 Y5\nM2\n")
    with_sweep((folder / "sweep.toml").read_text().replace('"part.nc"', '"part.nc", "long.nc"'))
    sweep = load_sweep("sweep.toml")
    run_sweep(sweep, "R", Here(sweep))
    assert run(["sweep", "show", "R", "--summary", "s.json", "--top", "3", "--picture", "p.png"]) == 0
    said = capsys.readouterr().out
    rows = {key: dict(row) for key, row in rows_of("R").items()}
    front = [rows[key] for key in json.loads((folder / "s.json").read_text())["pareto"]["rows"]]
    for program in ("part.nc", "long.nc"):
        own = [row for row in rows.values() if row["program"] == program]
        on_front = [row for row in front if row["program"] == program]
        pairs = [(row["cycle_time_s"], row["contour_error_max_mm"]) for row in own]
        unbeaten = [
            (t, e) for t, e in pairs if not any(a <= t and b <= e and (a, b) != (t, e) for a, b in pairs)
        ]
        assert sorted((row["cycle_time_s"], row["contour_error_max_mm"]) for row in on_front) == sorted(
            set(unbeaten)
        )
        assert f"\n{program}, by cycle_time_s:\n" in said
        assert f"\n{program}, Pareto front of cycle_time_s and contour_error_max_mm:\n" in said


def test_dry_run_says_how_many_and_how_long(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["sweep", "sweep.toml", "-o", "R", "--dry-run", "--processes", "2"]) == 0
    assert capsys.readouterr().out.startswith("8 jobs, 8 missing, 0 failed\n")
    assert not (folder / "R").exists()


def test_dry_run_says_that_a_first_job_fails(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its time is that of failing, which says nothing of the jobs that do not."""
    (folder / "part.nc").write_text("G21 G61 F600\nG1 X900\nM2\n")
    assert run(["sweep", "sweep.toml", "-o", "R", "--dry-run", "--processes", "2"]) == 0
    assert "\na first job fails: part.nc:2:" in capsys.readouterr().out


#: A sweep that is interrupted where the driver imports pyarrow, as by a Ctrl-C in its first second.
INTERRUPTED = """
import os, signal, sys
class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == "pyarrow" and __name__ == "__main__":
            os.kill(os.getpid(), signal.SIGINT)
if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.meta_path.insert(0, Interrupting())
    from cncgen.cli import main
    main(["sweep", "sweep.toml", "-o", "R", "--processes", "2"])
"""


def test_an_interrupt_while_the_driver_imports_leaves_nothing_behind(folder: Path) -> None:
    """Locks of a pool that was made before were left to the resource tracker, which complained."""
    (folder / "interrupted.py").write_text(INTERRUPTED)
    run = subprocess.run(
        [sys.executable, "interrupted.py"], capture_output=True, text=True, timeout=60, check=False
    )
    assert (run.returncode, run.stderr) == (130, "error[interrupted]: the command was interrupted\n")


def test_a_hundred_thousand_rows_open_in_pandas_polars_and_duckdb(tmp_path: Path) -> None:
    """What is read is compared with what was written, to the bit."""
    pandas, polars, duckdb = (pytest.importorskip(name) for name in ("pandas", "polars", "duckdb"))
    count, random = 100_000, np.random.default_rng(1)
    x, time_s = random.normal(size=count), random.random(count)
    results = ResultsFolder(tmp_path / "R")
    results.prepare()
    results.remember("")
    layout = RowLayout({"x": float, "feedrate": str}, ["cycle_time_s"])
    for first in range(0, count, 30_000):
        rows = [
            (
                Place("p.nc", "m", k, (float(x[k]), "ild" if k % 2 else "optimal")),
                JobOutcome(f"{k:064x}", {"cycle_time_s": float(time_s[k])}),
            )
            for k in range(first, min(first + 30_000, count))
        ]
        results.write(rows, layout)
    files = str(tmp_path / "R" / "*.parquet")
    frames = [
        pandas.read_parquet(tmp_path / "R").sort_values("point"),
        polars.read_parquet(files).sort("point").to_pandas(),
        duckdb.sql(f"select * from '{files}' order by point").df(),
    ]
    for frame in frames:
        assert list(frame.columns) == [*FIRST, "x", "feedrate", "cycle_time_s", *LAST]
        assert (frame["x"].to_numpy() == x).all()
        assert (frame["cycle_time_s"].to_numpy() == time_s).all()
        assert frame["key"].is_unique
        assert frame["error"].isna().all()
        assert (frame["feedrate"] == "ild").sum() == count // 2
    assert len(results.states()) == count


def test_rows_are_written_while_the_sweep_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A part after two seconds by the clock, later after a hundredth of the time so far."""
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    results = ResultsFolder(tmp_path / "R")
    results.prepare()
    writer = RowWriter(results, RowLayout({}, []))
    parts: list[int] = []
    for k in range(1000):
        now[0] = float(k)
        writer.add(Place("p", "m", k, ()), JobOutcome(str(k), {}))
        parts.append(len(results.parts()))
    writer.flush()
    assert parts[10] == 5
    assert parts[-1] - parts[-101] == pytest.approx(100 / 10, abs=2)
    assert len(rows_of(tmp_path / "R")) == 1000


Make = Callable[[str], Path]


def test_figures_of_cut_and_verify(folder: Path) -> None:
    """A slot of 2 mm depth and 6 mm width, 20 mm long between its ends: 240 mm³ and two half discs (π 9 · 2)."""
    (folder / "slot.nc").write_text("G21 G90 G61 S1000 M3\nG0 X0 Y0 Z5\nG1 Z-2 F300\nX20\nG0 Z5\nM2\n")
    (folder / "s.toml").write_text(
        'programs = ["slot.nc"]\nmachine = "generic-mill"\n[options]\nstock = "box:-10,-10,-10,30,10,0"\n'
        'tools = ["*=flat:6"]\ncell_mm = 0.1\n[keep]\nfigures = ["cut.removed_mm3", "findings", "breaches", "cut.holds"]\n'
    )
    sweep = load_sweep("s.toml")
    assert run_sweep(sweep, "R", Here(sweep)).failed == 0
    (row,) = ResultsFolder("R").table().to_pylist()
    assert row["cut.removed_mm3"] == pytest.approx(240.0 + 18.0 * np.pi, rel=0.005)
    assert (row["breaches"], row["findings"], row["cut.holds"]) == (0.0, 0.0, 1.0)


def test_layout_has_the_kinds_of_lists(with_sweep: Make) -> None:
    text = (
        'programs = ["part.nc"]\nmachine = "xy-table"\n[vary]\nfeedrate = ["ild", "optimal"]\n'
        "path_tolerance_mm = [1, 2]\n"
    )
    assert layout_of(load_sweep(with_sweep(text))).quantities == {"feedrate": str, "path_tolerance_mm": float}

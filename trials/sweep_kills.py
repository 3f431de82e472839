"""Sweeps under fire: the same rows by one process, two processes and a dask cluster, and under ``kill -9`` at random moments.

    python -m trials.sweep_kills --points 2000 --kills 50 --seed 1

A sweep of two small lines on xy-table is computed in full by one process, two processes and a cluster of two local workers; the
rows are compared to the bit. Then a sweep is begun again and again: at random moments its driver or one of its
workers is killed, until all moments are used. In the end no row may be missing, doubled, or another one.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from cncgen.sweep.results import ResultsFolder

PROGRAM = "G21 G17 G90 G61\nF3000\nG1 X10 Y1\nG1 X20 Y5\nM2\n"
SWEEP = """
programs = ["part.nc"]
machine = "xy-table"
[options]
feedrate = "ild"
[vary]
"axes.*.max_jerk_mm_s3" = {{ log = [2e4, 2e5] }}
"axes.*.max_acceleration_mm_s2" = {{ linear = [1000, 2500] }}
"axes.x.servo.position_gain_1_s" = {{ normal = [121, 4] }}
[draw]
design = "latin_hypercube"
points = {points}
seed = {seed}
[keep]
figures = ["cycle_time_s", "contour_error_max_mm", "axes.x.tracking_max_mm"]
"""
#: Longest time between two kills, s. Processes take about a second to start.
LONGEST_S = 5.0


def begun(folder: Path, results: str, *options: str) -> subprocess.Popen[bytes]:
    """Start a sweep."""
    words = [sys.executable, "-m", "cncgen", "sweep", "sweep.toml", "-o", results, "-q", *options]
    return subprocess.Popen(words, cwd=folder)


def rows_of(path: Path) -> dict[str, tuple[object, ...]]:
    """Return rows by key; raise where a key stands twice."""
    table = ResultsFolder(path).table().to_pylist()
    found = {row["key"]: tuple(row.items()) for row in table}
    if len(found) != len(table):
        raise SystemExit(f"{path}: {len(table) - len(found)} rows are doubled")
    return found


def children_of(process: int) -> list[int]:
    """Return the worker processes of a driver (of a spawned pool they are those that multiprocessing's main names)."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
                spawned = b"spawn_main" in (entry / "cmdline").read_bytes()
            except OSError:
                continue
            if parent == process and spawned:
                found.append(int(entry.name))
    return found


def under_fire(folder: Path, results: str, kills: int, chance: random.Random) -> tuple[int, int, int]:
    """Run a sweep while drivers and workers are killed; return how many of each, and how many sweeps ended by themselves."""
    drivers = workers = ended = 0
    process = begun(folder, results)
    while drivers + workers < kills:
        moment = time.monotonic() + chance.uniform(0.2, LONGEST_S)
        while time.monotonic() < moment and process.poll() is None:
            time.sleep(0.01)
        if process.poll() is not None:  # it is complete: all is done again, beside what there is
            ended += 1
            results = f"{results}+"
            process = begun(folder, results)
            continue
        of_workers = chance.random() < 0.5
        while of_workers and process.poll() is None and not children_of(process.pid):
            time.sleep(0.05)
        victims = children_of(process.pid) if of_workers else []
        if of_workers and not victims:
            continue
        if victims:
            os.kill(chance.choice(victims), signal.SIGKILL)
            workers += 1
        else:
            process.kill()
            process.wait()
            drivers += 1
            process = begun(folder, results)
    if process.wait():
        raise SystemExit(f"the sweep ended with {process.returncode}")
    return drivers, workers, ended


def main() -> None:
    """Run the trial."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=2000)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--no-cluster", action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "part.nc").write_text(PROGRAM)
        (folder / "sweep.toml").write_text(SWEEP.format(points=given.points, seed=given.seed))
        whole = {}
        for processes in (1, 2):
            start = time.monotonic()
            if begun(folder, f"with{processes}", "--processes", str(processes)).wait():
                raise SystemExit("the sweep failed")
            whole[f"{processes} processes"] = rows_of(folder / f"with{processes}")
            print(
                f"{processes} processes: {len(whole[f'{processes} processes'])} rows, {time.monotonic() - start:.1f} s"
            )
        if not given.no_cluster:
            from distributed import LocalCluster

            with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
                start = time.monotonic()
                begun(folder, "cluster", "--scheduler", cluster.scheduler_address).wait()
                whole["dask"] = rows_of(folder / "cluster")
                print(f"dask, 2 workers: {len(whole['dask'])} rows, {time.monotonic() - start:.1f} s")
        first = whole["1 processes"]
        for what, rows in whole.items():
            print(f"{what}: {'the same rows to the bit' if rows == first else 'OTHER ROWS'}")
        if not given.kills:
            return
        drivers, workers, ended = under_fire(folder, "fire", given.kills, random.Random(given.seed))
        print(f"killed: {drivers} drivers, {workers} workers; {ended} sweeps were complete meanwhile")
        for path in sorted(folder.glob("fire*")):
            rows = rows_of(path)
            verdict = (
                "the same rows" if rows == first else f"{len(first.keys() - rows.keys())} LOST or changed"
            )
            print(f"{path.name}: {len(rows)} rows, {verdict}")


if __name__ == "__main__":
    main()

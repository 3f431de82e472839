"""Sweeps under fire: the same rows by one process, two processes and a dask cluster, and under ``kill -9`` at random moments.

    python -m trials.sweep_kills --points 2000 --kills 50 --seed 1

A sweep of two small lines on xy-table is computed in full by one process, two processes and a cluster of two local workers; the
rows are compared to the bit. Then a sweep is begun again and again, first on processes and then on the cluster: at random
moments its driver or one of its workers is killed, until all moments are used. In the end no row may be missing, doubled, or
another one.
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
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

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


#: The workers of the driver with this process number.
WorkersOf = Callable[[int], list[int]]


def under_fire(
    folder: Path, results: str, kills: int, chance: random.Random, workers_of: WorkersOf, *options: str
) -> tuple[int, int, int]:
    """Kill so many drivers and as many workers in random order; return how many of each, and how many sweeps ended meanwhile."""
    drivers = workers = ended = 0
    process = begun(folder, results, *options)
    while min(drivers, workers) < kills:
        moment = time.monotonic() + chance.uniform(0.2, LONGEST_S)
        while time.monotonic() < moment and process.poll() is None:
            time.sleep(0.01)
        if process.poll() is not None:  # it is complete: all is done again, beside what there is
            ended += 1
            results = f"{results}+"
            process = begun(folder, results, *options)
            continue
        of_workers = drivers == kills or (workers < kills and chance.random() < 0.5)
        while of_workers and process.poll() is None and not workers_of(process.pid):
            time.sleep(0.05)
        victims = workers_of(process.pid) if of_workers else []
        if of_workers and not victims:
            continue
        if victims:
            os.kill(chance.choice(victims), signal.SIGKILL)
            workers += 1
        else:
            process.kill()
            process.wait()
            drivers += 1
            process = begun(folder, results, *options)
    if process.wait():
        raise SystemExit(f"the sweep ended with {process.returncode}")
    return drivers, workers, ended


@contextmanager
def local_cluster() -> Iterator[Any]:
    """Run a dask cluster of two workers, which are started again when they die."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        # A nanny gives up on a worker that is killed while it starts: another one takes its place.
        cluster.adapt(minimum=2, maximum=2, interval="1s")
        yield cluster


def judged(folder: Path, results: str, wanted: dict[str, tuple[object, ...]]) -> bool:
    """Say whether each of the sweeps under fire has the rows that are wanted."""
    found = [rows_of(path) for path in folder.glob(f"{results}*")]
    changed = sum(rows.get(key) != row for rows in found for key, row in wanted.items())
    more = sum(len(rows.keys() - wanted.keys()) for rows in found)
    total = sum(map(len, found))
    print(
        f"{len(found)} sweeps: {total} rows, {changed} lost or changed, none twice, {more} of no job",
        flush=True,
    )
    return not changed and not more


def main() -> None:
    """Run the trial."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=2000)
    parser.add_argument(
        "--kills",
        type=int,
        default=50,
        help="of drivers and as many of workers, on processes and on the cluster each",
    )
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    chance = random.Random(given.seed)
    with tempfile.TemporaryDirectory() as name, local_cluster() as cluster:
        folder = Path(name)
        (folder / "part.nc").write_text(PROGRAM)
        (folder / "sweep.toml").write_text(SWEEP.format(points=given.points, seed=given.seed))
        on_cluster: tuple[str, ...] = ("--scheduler", cluster.scheduler_address)
        ways: dict[str, tuple[str, ...]] = {
            "1 process": ("--processes", "1"),
            "2 processes": ("--processes", "2"),
            "dask": on_cluster,
        }
        first: dict[str, tuple[object, ...]] = {}
        whole = True
        for way, options in ways.items():
            start = time.monotonic()
            if begun(folder, way, *options).wait():
                raise SystemExit("the sweep failed")
            rows = rows_of(folder / way)
            first = first or rows
            whole &= rows == first
            said = "the same rows to the bit" if rows == first else "OTHER ROWS"
            print(f"{way}: {len(rows)} rows, {time.monotonic() - start:.1f} s, {said}", flush=True)

        def nannies(_: int) -> list[int]:
            return [worker.pid for worker in cluster.workers.values() if worker.pid]

        fires: dict[str, tuple[WorkersOf, tuple[str, ...]]] = {
            "processes": (children_of, ()),
            "cluster": (nannies, on_cluster),
        }
        for results, (workers_of, options) in fires.items() if given.kills else ():
            fire = f"fire on {results} "
            drivers, workers, ended = under_fire(folder, fire, given.kills, chance, workers_of, *options)
            print(f"{results}: killed {drivers} drivers, {workers} workers; {ended} sweeps ended meanwhile")
            whole &= judged(folder, fire, first)
    if not whole:
        raise SystemExit("rows are lost or changed")


if __name__ == "__main__":
    main()

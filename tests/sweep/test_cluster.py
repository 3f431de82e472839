"""A sweep on a dask cluster of two local workers: the same rows as here, also when a worker is killed."""

from __future__ import annotations

import os
import re
import resource
import shutil
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.cli.app import run
from cncgen.diagnostics import UsageError
from cncgen.sweep import cluster, driver
from cncgen.sweep.cluster import ClusterWorkers
from cncgen.sweep.definition import load_sweep
from cncgen.sweep.driver import run_sweep
from cncgen.sweep.local_workers import Done
from tests.sweep.test_run import Here, rows_of

distributed = pytest.importorskip("distributed")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def scheduler() -> Iterator[Any]:
    """A cluster of two worker processes on this computer."""
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as local:
        yield local


def test_rows_are_those_of_this_process_to_the_bit(folder: Path, scheduler: Any) -> None:
    sweep = load_sweep("sweep.toml")
    run_sweep(sweep, "here", Here(sweep))
    assert run(["sweep", "sweep.toml", "-o", "R", "--scheduler", scheduler.scheduler_address, "-q"]) == 0
    assert rows_of("R") == rows_of("here")


def faults_of_arrays() -> int:
    """Return how many pages this process is given while it makes 50 arrays of 800 kB, one after the other."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(50):
        np.ones(100_000)
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before


def test_workers_keep_the_memory_that_arrays_leave(folder: Path, scheduler: Any) -> None:
    """dask has its workers give it back at once: these arrays then have 10,000 pages of 4 kB, and else those of one or two."""
    workers = ClusterWorkers(scheduler.scheduler_address, list(load_sweep("sweep.toml").programs.values()))
    try:
        with distributed.Client(scheduler.scheduler_address, set_as_default=False) as client:
            found = client.run(faults_of_arrays)
    finally:
        workers.close()
    assert max(found.values()) < 2000


class DeadlyCluster(ClusterWorkers):
    """A cluster of which one worker is killed when the first batch comes back."""

    killed = 0

    def completed(self, timeout_s: float) -> list[Done]:
        done = super().completed(timeout_s)
        if done and not self.killed:
            victims = self._client.run(os.getpid)
            DeadlyCluster.killed = next(iter(victims.values()))
            os.kill(DeadlyCluster.killed, signal.SIGKILL)
        return done


def test_a_killed_worker_loses_no_row_and_doubles_none(folder: Path, scheduler: Any) -> None:
    sweep = load_sweep("sweep.toml")
    run_sweep(sweep, "here", Here(sweep))
    workers = DeadlyCluster(scheduler.scheduler_address, list(sweep.programs.values()))
    try:
        end = run_sweep(sweep, "R", workers)
    finally:
        workers.close()
    assert DeadlyCluster.killed
    assert (end.done, end.failed) == (8, 0)
    assert rows_of("R") == rows_of("here")


def test_workers_of_another_version_are_refused(
    folder: Path, scheduler: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "code_version", lambda: "0.0.9+another")
    with pytest.raises(UsageError, match=r"runs cncgen .* the driver 0\.0\.9\+another"):
        ClusterWorkers(scheduler.scheduler_address, [])


def test_a_worker_that_joins_later_with_another_version_ends_the_sweep(
    folder: Path, scheduler: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep = load_sweep("sweep.toml")
    workers = ClusterWorkers(scheduler.scheduler_address, list(sweep.programs.values()))
    monkeypatch.setattr(cluster, "code_version", lambda: "0.0.9+another")
    try:
        with pytest.raises(UsageError, match="install the same cncgen"):
            driver.run_sweep(sweep, "R", workers)
    finally:
        workers.close()


class DyingWorker:
    """A client of dask, one of whose workers dies as soon as it is asked for its version, and again as it gets the programs."""

    def __init__(self, deaths: int) -> None:
        self.deaths, self.registered = deaths, 0

    def run(self, function: Any, on_error: str) -> dict[str, object]:
        assert on_error == "return"
        return {
            "tcp://a": function(),
            "tcp://b": distributed.comm.CommClosedError("connection reset by peer"),
        }

    def register_plugin(self, plugin: Any, name: str) -> None:
        if self.deaths:
            self.deaths -= 1
            raise distributed.comm.CommClosedError("connection reset by peer")
        self.registered += 1


def test_a_worker_that_dies_at_the_start_does_not_end_the_sweep() -> None:
    client = DyingWorker(deaths=2)
    cluster._check_workers(client)
    cluster._register(client, None)
    assert client.registered == 1
    with pytest.raises(OSError, match="reset by peer"):
        cluster._register(DyingWorker(deaths=99), None)


def test_a_scheduler_that_is_not_there_is_named(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "_PATIENCE_S", 1)
    with pytest.raises(UsageError, match="cannot reach the scheduler"):
        ClusterWorkers("tcp://127.0.0.1:9", [])


def test_a_cluster_by_tls_takes_who_has_a_certificate_alone(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As docs/sweep.md says it: a `tls://` address, and the certificates in dask's configuration."""
    dask, openssl = pytest.importorskip("dask"), shutil.which("openssl")
    if openssl is None:
        pytest.skip("openssl, which makes the certificate, is not installed")
    made = [openssl, "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", "k.pem", "-out", "c.pem"]
    subprocess.run([*made, "-days", "2", "-subj", "/CN=localhost"], check=True, capture_output=True)
    sweep = load_sweep("sweep.toml")
    run_sweep(sweep, "here", Here(sweep))
    tls = {"distributed.comm.tls.ca-file": str(folder / "c.pem"), "distributed.comm.require-encryption": True}
    for role in ("client", "scheduler", "worker"):
        tls[f"distributed.comm.tls.{role}.key"] = str(folder / "k.pem")
        tls[f"distributed.comm.tls.{role}.cert"] = str(folder / "c.pem")
    stranger = dict.fromkeys(("distributed.comm.tls.client.key", "distributed.comm.tls.client.cert"))
    with dask.config.set(tls):
        security = distributed.Security(require_encryption=True)
        with distributed.LocalCluster(
            n_workers=1,
            threads_per_worker=1,
            dashboard_address=":0",
            protocol="tls://",
            security=security,
        ) as local:
            address = local.scheduler_address
            assert address.startswith("tls://")
            assert run(["sweep", "sweep.toml", "-o", "R", "--scheduler", address, "-q"]) == 0
            monkeypatch.setattr(cluster, "_PATIENCE_S", 1)
            with dask.config.set(stranger):
                assert run(["sweep", "sweep.toml", "-o", "S", "--scheduler", address, "-q"]) == 2
    assert rows_of("R") == rows_of("here")


def test_the_example_of_slurm_gives_a_job_of_as_many_workers(root: Path) -> None:
    """As far as its job script: here is no Slurm."""
    pytest.importorskip("dask_jobqueue")
    (code,) = re.findall(r"```python\n(.*?)```", (root / "docs/sweep.md").read_text(encoding="utf-8"), re.S)
    made, scaled, rest = code.partition("cluster.scale(jobs=10)")
    assert scaled
    assert "cluster.scheduler_address" in rest
    compile(rest, "sweep.md", "exec")
    names: dict[str, Any] = {}
    exec(compile(made, "sweep.md", "exec"), names)
    with names["cluster"] as cluster:
        script = cluster.job_script()
    assert "#SBATCH -p compute\n" in script
    assert "#SBATCH -t 08:00:00\n" in script
    assert "#SBATCH --cpus-per-task=32\n" in script
    assert "--nthreads 1 " in script
    assert "--nworkers 32 " in script


def test_a_cluster_without_workers_is_told_of_once(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Batches wait for a worker; the rows come once one joins."""
    monkeypatch.setattr(cluster, "_LONELY_S", 0.2)
    told: list[str] = []
    sweep = load_sweep("sweep.toml")
    with distributed.LocalCluster(n_workers=0, threads_per_worker=1, dashboard_address=":0") as local:
        workers = ClusterWorkers(local.scheduler_address, list(sweep.programs.values()), tell=told.append)
        try:
            workers.submit((driver.outlook(sweep, driver.ResultsFolder("R")).jobs.popitem()[1][1],))
            for _ in range(8):
                assert workers.completed(0.1) == []
            assert told == [
                f"the scheduler {local.scheduler_address} has no workers, for which 1 batches wait"
            ]
            local.scale(1)
            done: list[Done] = []
            while not done:
                done = workers.completed(1.0)
        finally:
            workers.close()
    assert len(done) == 1
    assert len(told) == 1

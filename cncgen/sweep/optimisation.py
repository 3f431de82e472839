"""``[search]``: optuna chooses values that make one figure small while others stay under bounds.

A search is a pure function of its file and of the results of its jobs: trials are chosen in groups, and optuna gets all results in
their order before it chooses the next group. A search that is started again therefore asks for the same trials, and computes only
those without a row. The number of processes has no influence.

The sampler is the tree-structured Parzen estimator with constraints (Bergstra et al. 2011; Watanabe and Hutter 2023).
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.sweep.driver import JobQueue, Progress, Watch, check_own, layout_of
from cncgen.sweep.jobs import Place, SweepJob
from cncgen.sweep.quantities import Levels, Range, Varied
from cncgen.sweep.results import ResultsFolder
from cncgen.sweep.varying import job_at

if TYPE_CHECKING:
    from cncgen.sweep.definition import SearchGoal, SweepDefinition
    from cncgen.sweep.local_workers import Workers

Figures = dict[str, float | None]


def needed_optuna() -> ModuleType:
    """Import optuna.

    Raises:
        UsageError: It is missing.
    """
    try:
        import optuna
    except ImportError as error:
        hint = "pip install 'cncgen[search]'"
        raise UsageError(Diagnostic("missing-package", "[search] needs optuna", hint=hint)) from error
    module: ModuleType = optuna
    return module


@dataclass(frozen=True, slots=True)
class SearchResult:
    """The end of a search.

    Attributes:
        progress: Jobs and rate.
        best: Place of the trial with the smallest figure among those that keep all bounds; None where none does.
        figures: Its figures.
    """

    progress: Progress
    best: Place | None
    figures: Figures


def run_search(
    sweep: SweepDefinition, path: str | Path, workers: Workers, *, watch: Watch = lambda progress: None
) -> SearchResult:
    """Search, going on with the rows that a folder has.

    Args:
        sweep: With a `SearchGoal`, one program and one machine.
        path: The folder of the rows.
        workers: Who computes.
        watch: Told of progress.

    Raises:
        UsageError: optuna is missing, the sweep has several programs or machines, or the folder has rows of something else.
    """
    optuna = needed_optuna()
    if sweep.search is None or len(sweep.programs) != 1 or len(sweep.machines) != 1:
        text = f"{sweep.name}: a search needs one program and one machine"
        raise UsageError(Diagnostic("sweep-search", text))
    folder = ResultsFolder(path)
    folder.prepare()
    with folder.locked():
        search = _Search(optuna, sweep, sweep.search, folder, workers)
        folder.remember(sweep.text)
        return search.run(watch)


class _Search:
    """One search on its way."""

    def __init__(
        self,
        optuna: ModuleType,
        sweep: SweepDefinition,
        goal: SearchGoal,
        folder: ResultsFolder,
        workers: Workers,
    ) -> None:
        self._sweep, self._goal, self._folder, self._workers = sweep, goal, folder, workers
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        self._spaces = {q.key: _distribution(optuna, q) for q in sweep.quantities}
        sampler = optuna.samplers.TPESampler(seed=goal.seed, constant_liar=True)
        self._study = optuna.create_study(sampler=sampler)
        self._failed = optuna.trial.TrialState.FAIL
        self._known = folder.figures(sweep.figures)
        self._program, self._machine = next(iter(sweep.programs)), next(iter(sweep.machines))
        self._best: tuple[float, Place, Figures] | None = None

    def run(self, watch: Watch) -> SearchResult:
        """Try all trials."""
        begun, computed, failed = time.monotonic(), 0, 0
        progress = Progress(0, 0, self._goal.trials, 0, 0.0)
        for first in range(0, self._goal.trials, self._goal.together):
            count = min(self._goal.together, self._goal.trials - first)
            trials = [self._study.ask(self._spaces) for _ in range(count)]
            jobs = [self._job(first + k, trial.params) for k, trial in enumerate(trials)]
            if first == 0 and self._known and not any(job.key in self._known for _, job in jobs):
                check_own(self._folder, set(self._known), len(self._known))
            computed += self._compute(jobs)
            for trial, (place, job) in zip(trials, jobs, strict=True):
                failed += not self._told(trial, place, self._known[job.key])
            progress = Progress(first + count, failed, self._goal.trials, computed, time.monotonic() - begun)
            watch(progress)
        if self._best is None:
            return SearchResult(progress, None, {})
        return SearchResult(progress, self._best[1], self._best[2])

    def _job(self, number: int, values: dict[str, Any]) -> tuple[Place, SweepJob]:
        shares = [_share(quantity, values[quantity.key]) for quantity in self._sweep.quantities]
        return job_at(self._sweep, self._program, self._machine, number, shares)

    def _compute(self, jobs: Sequence[tuple[Place, SweepJob]]) -> int:
        """Compute jobs that have no row yet and write their rows; return how many."""
        places = {job.key: place for place, job in reversed(jobs) if job.key not in self._known}
        missing = {job.key: job for _, job in jobs if job.key in places}
        rows = [
            (places[outcome.key], outcome)
            for outcome in JobQueue(list(missing.values()), self._workers).outcomes()
        ]
        if rows:
            self._folder.write(rows, layout_of(self._sweep))
        self._known |= {outcome.key: dict(outcome.figures) for _, outcome in rows}
        return len(rows)

    def _told(self, trial: Any, place: Place, figures: Figures) -> bool:
        """Tell optuna what came of a trial; return whether it has all figures that the goal needs."""
        value = figures.get(self._goal.minimise)
        over = {name: _over(figures.get(name), bound) for name, bound in self._goal.under.items()}
        if value is None or None in over.values():
            self._study.tell(trial, state=self._failed)
            return False
        for name, excess in over.items():
            trial.set_constraint(name, excess)
        self._study.tell(trial, value)
        if all(excess <= 0.0 for excess in over.values() if excess is not None) and (
            self._best is None or value < self._best[0]
        ):
            self._best = value, place, figures
        return True


def _distribution(optuna: ModuleType, quantity: Varied) -> Any:
    """Return optuna's distribution: of a list the numbers of its levels, of a range the share of it."""
    if isinstance(quantity, Levels):
        numeric = all(isinstance(v, int | float) and not isinstance(v, bool) for v in quantity.levels)
        last = len(quantity.levels) - 1
        if numeric and list(quantity.levels) == sorted(quantity.levels):
            return optuna.distributions.IntDistribution(0, last)
        return optuna.distributions.CategoricalDistribution(list(range(last + 1)))
    return optuna.distributions.FloatDistribution(0.0, 1.0)


def _over(value: float | None, bound: float) -> float | None:
    """Return how far a figure is above its bound, negative below it; None without a figure."""
    return None if value is None else value - bound


def _share(quantity: Varied, value: float) -> float:
    """Return the number u of the quantity that a value of its distribution means."""
    if isinstance(quantity, Range):
        return value
    return quantity.shares()[int(value)]

"""`cncgen sweep`: programs × machines × varied keys, on the processes of one machine or of a cluster."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING

import click

from cncgen.cli import messages
from cncgen.cli.once import OnceGroup
from cncgen.cli.options import message_options
from cncgen.cli.types import FILE, FOLDER, WholeRange

if TYPE_CHECKING:
    from cncgen.sweep.definition import SweepDefinition
    from cncgen.sweep.local_workers import Workers


class _SweepGroup(OnceGroup):
    """A group whose command `run` may be left out: ``cncgen sweep SWEEP.toml -o RESULTS/``."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put ``run`` before arguments that begin with no command."""
        if args and args[0] not in (*self.commands, "--help", "-h"):
            args = ["run", *args]
        return super().parse_args(ctx, args)


@click.group("sweep", cls=_SweepGroup)
def command() -> None:
    """Compute many variants of programs and machines.

    `cncgen sweep SWEEP.toml -o RESULTS/` computes what is missing in RESULTS/ (the word run may be left out);
    `cncgen sweep show RESULTS/` ranks the rows and shows sensitivities. docs/sweep.md describes SWEEP.toml.
    """


@command.command("run")
@click.argument("definition", metavar="SWEEP.toml", type=FILE)
@click.option("-o", "--output", metavar="RESULTS/", type=FOLDER, required=True, help="Folder of the results.")
@click.option(
    "--processes",
    metavar="N",
    type=WholeRange(1, 1024),
    help="Processes here [default: one a processor].",
)
@click.option(
    "--scheduler", metavar="ADDRESS", help="Workers of a dask cluster instead: tcp://HOST:PORT or tls://…"
)
@click.option("--failed", is_flag=True, help="Compute jobs that failed again.")
@click.option("--dry-run", is_flag=True, help="Say how many jobs are missing and how long they may take.")
@message_options
def run(
    definition: str, output: str, processes: int | None, scheduler: str | None, failed: bool, dry_run: bool
) -> int:
    """Compute the jobs of a sweep that are missing in RESULTS/.

    A job that fails is a row with its diagnostic. Exit 1 if every job failed, 3 if a search found nothing within its bounds.
    """
    from cncgen.cli.progress import sweep_progress
    from cncgen.kernels import warn_if_uncompiled
    from cncgen.report.tables import counted
    from cncgen.sweep.definition import load_sweep
    from cncgen.sweep.driver import run_sweep

    if processes and scheduler:
        raise click.UsageError("--processes and --scheduler cannot both be given.")
    warn_if_uncompiled()
    sweep = load_sweep(definition)
    messages.show(sweep.remarks)
    if dry_run:
        _dry_run(sweep, output, processes)
        return 0
    if sweep.search:
        return _search(sweep, output, processes, scheduler)
    with _workers(sweep, processes, scheduler) as workers, sweep_progress() as watch:
        end = run_sweep(sweep, output, workers, again_failed=failed, watch=watch)
    rate = f", {end.rate:.3g} a second" if end.computed else ""
    messages.note(f"{output}: {counted(end.done, 'job')}, {end.computed} of them computed now{rate}")
    if end.failed:
        messages.warning(
            "sweep-failed",
            f"{end.failed} of {end.total} jobs failed; cncgen sweep show {output} names the diagnostics",
        )
    return 1 if end.failed and end.failed == end.total else 0


def _search(sweep: SweepDefinition, output: str, processes: int | None, scheduler: str | None) -> int:
    """Search; say which values are the best; return the exit code."""
    from cncgen.cli.progress import sweep_progress
    from cncgen.sweep.optimisation import run_search

    with _workers(sweep, processes, scheduler) as workers, sweep_progress() as watch:
        found = run_search(sweep, output, workers, watch=watch)
    messages.note(f"{output}: {found.progress.done} trials, {found.progress.computed} of them computed now")
    if found.best is None:
        messages.warning(
            "search-bounds", f"none of {found.progress.done} trials keeps all bounds of [search]"
        )
        return 3
    pairs = [*zip(sweep.columns, found.best.values, strict=True), *found.figures.items()]
    messages.note("best: " + ", ".join(f"{name} = {value}" for name, value in pairs))
    return 0


@contextmanager
def _workers(sweep: SweepDefinition, processes: int | None, scheduler: str | None) -> Iterator[Workers]:
    """Yield workers that have the sweep's programs."""
    from cncgen.sweep.local_workers import LocalWorkers, processors

    workers: Workers
    bundles = list(sweep.programs.values())
    if scheduler:
        from cncgen.sweep.cluster import ClusterWorkers

        workers = ClusterWorkers(scheduler, bundles, tell=partial(messages.warning, "sweep-workers"))
    else:
        workers = LocalWorkers(processes or processors(), bundles)
    try:
        yield workers
    finally:
        workers.close()


def _dry_run(sweep: SweepDefinition, output: str, processes: int | None) -> None:
    """Print how many jobs there are, and how long the missing ones may take by the first of each program."""
    import os

    from cncgen.files import write_text
    from cncgen.report.tables import duration
    from cncgen.sweep.driver import outlook, seconds_a_job
    from cncgen.sweep.local_workers import processors
    from cncgen.sweep.results import ResultsFolder

    if sweep.search:
        write_text(None, f"{sweep.size} trials of a search\n")
        return
    found = outlook(sweep, ResultsFolder(output)) if os.path.isdir(output) else outlook(sweep, None)
    lines = [f"{len(found.jobs)} jobs, {len(found.missing)} missing, {found.failed} failed"]
    if found.missing:
        count = processes or processors()
        each, errors = seconds_a_job(sweep, found)
        total = duration(each * len(found.missing) / count)
        lines.append(
            f"{total} at {each:.3g} s a job on {count} processes, as the first job of each program takes"
        )
        lines += [f"a first job fails: {error}" for error in errors]
    write_text(None, "\n".join(lines) + "\n")


@command.command("show")
@click.argument("results", metavar="RESULTS/", type=FOLDER)
@click.option("--by", metavar="FIGURE", help="Rank by this figure [default: the first one].")
@click.option("--largest", is_flag=True, help="Rank the largest value first.")
@click.option("--top", metavar="N", type=WholeRange(0), default=10, show_default=True, help="Rows to show.")
@click.option(
    "--pareto",
    metavar="TIME,ERROR",
    help="Two figures of the Pareto front, both better the smaller [default: the first two].",
)
@click.option("--picture", metavar="FILE", type=FILE, help="Draw front and sensitivities: PNG, SVG or PDF.")
@click.option("-o", "--output", metavar="FILE", type=FILE, help="Write all rows: table.csv or table.parquet.")
@click.option("--summary", metavar="FILE", type=FILE, help="Write ranking, front and sensitivities as JSON.")
@message_options
def show(
    results: str,
    by: str | None,
    largest: bool,
    top: int,
    pareto: str | None,
    picture: str | None,
    output: str | None,
    summary: str | None,
) -> None:
    """Rank the rows of a sweep and show sensitivities.

    Sensitivities are shares of a figure's variance: of the first order, the part that a quantity explains alone; total, with all
    interactions. docs/sweep.md says how they are estimated from the design.
    """
    from cncgen.cli.messages import write_summary
    from cncgen.files import write_text
    from cncgen.sweep.showing import shown_results, write_table

    shown = shown_results(results, by=by, largest=largest, top=top, pareto=pareto)
    if output:
        write_table(shown, output)
    if picture:
        from cncgen.report.drawing import save

        save(shown.picture(), picture)
    write_summary(summary, shown.as_json())
    write_text(None, shown.text)

"""The tables of docs/evidence.md about random programs, and the runs that they show.

    python -m trials.evidence                                   # what is stored
    python -m trials.evidence --run examiner setpoints 200      # two hundred programs of fresh seeds; stores what came out
    python -m trials.evidence --write                           # puts the tables into docs/evidence.md

A run draws from `trials.seeds.EVIDENCE`, behind the seeds that stored runs of the property took. Its result goes into
`trials/evidence.json`, beside the older ones of the property unless ``--replace`` takes these away.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from trials.seeds import EVIDENCE

ROOT = Path(__file__).resolve().parents[1]
STORE = Path(__file__).with_suffix(".json")
PAGE = ROOT / "docs" / "evidence.md"
HEADER = ("property", "what is asked", "seeds", "programs", "fail", "which")


@dataclass(frozen=True, slots=True)
class Result:
    """The result of a run of one property.

    Attributes:
        trial, property: Whose.
        asks: In a few words, with the tolerance.
        seeds: First and last.
        programs: How many were tried.
        failures: How many failed.
        which: The failures, in words.
    """

    trial: str
    property: str
    asks: str
    seeds: tuple[int, int]
    programs: int
    failures: int
    which: str = ""

    def cells(self) -> tuple[str, ...]:
        """Return a row of the table."""
        first, last = self.seeds
        seeds = str(first) if first == last else f"{first} to {last}"
        return (f"`{self.property}`", self.asks, seeds, str(self.programs), str(self.failures), self.which)


def stored() -> list[Result]:
    """Return the stored results, in the order of the tables."""
    found = json.loads(STORE.read_text(encoding="utf-8"))
    return [Result(**{**one, "seeds": tuple(one["seeds"])}) for one in found]


def store(results: Sequence[Result]) -> None:
    """Write the results, one a line."""
    lines = ",\n".join(json.dumps(asdict(one), ensure_ascii=False) for one in results)
    STORE.write_text(f"[\n{lines}\n]\n", encoding="utf-8")


def table(trial: str, results: Sequence[Result]) -> str:
    """Return the table of a trial as Markdown."""
    rows = [HEADER, ("---",) * len(HEADER), *(one.cells() for one in results if one.trial == trial)]
    return "\n".join(f"| {' | '.join(row)} |".replace("|  |", "| |") for row in rows)


def with_tables(page: str, results: Sequence[Result]) -> str:
    """Return the page with the tables between their marks, ``<!-- trial: NAME -->`` and ``<!-- end -->``."""
    return re.sub(
        r"(<!-- trial: (\w+) -->\n).*?(<!-- end -->)",
        lambda match: f"{match[1]}\n{table(match[2], results)}\n\n{match[3]}",
        page,
        flags=re.S,
    )


def _properties(name: str, count: int, seed: int) -> tuple[int, int]:
    from trials.planner_properties import run

    return run(name, count, seed), seed


def _examiner(name: str, count: int, seed: int) -> tuple[int, int]:
    from trials.examiner import examined

    return examined(name, range(seed, seed + count)), seed + count - 1


#: How a property is run: its name, how many programs and the first seed, to the number of failures and the last seed.
RUNS: dict[str, Callable[[str, int, int], tuple[int, int]]] = {
    "planner_properties": _properties,
    "examiner": _examiner,
}


def run(trial: str, name: str, count: int, replace: bool) -> Result:
    """Run a property on fresh seeds and store what came out.

    Raises:
        KeyError: The property has no stored result that says what it asks.
    """
    results = stored()
    before = [one for one in results if (one.trial, one.property) == (trial, name)]
    if not before:
        raise KeyError(
            f"{STORE.name} has no {name} of {trial}: write what it asks there first, with 0 programs"
        )
    first = max([EVIDENCE[trial].start, *(one.seeds[1] + 1 for one in before if one.programs)])
    failures, last = RUNS[trial](name, count, first)
    if last not in EVIDENCE[trial]:
        raise ValueError(f"seed {last} is beyond those for evidence, {EVIDENCE[trial]}")
    result = Result(trial, name, before[0].asks, (first, last), count, failures)
    kept = [one for one in results if one not in before or not (replace or one.programs == 0)]
    at = max((k for k, one in enumerate(kept) if one.trial == trial), default=len(kept) - 1)
    store([*kept[: at + 1], result, *kept[at + 1 :]])
    return result


def main() -> int:
    """Do what the arguments say; 1 where a run has failures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--run", nargs=3, metavar=("TRIAL", "PROPERTY", "COUNT"))
    parser.add_argument("--replace", action="store_true", help="older results of the property go")
    parser.add_argument("--write", action="store_true", help="put the tables into docs/evidence.md")
    asked = parser.parse_args()
    failures = 0
    if asked.run:
        trial, name, count = asked.run
        if trial not in RUNS:
            parser.error(f"no trial {trial!r}; there are {', '.join(RUNS)}")
        failures = run(trial, name, int(count), asked.replace).failures
    if asked.write:
        PAGE.write_text(with_tables(PAGE.read_text(encoding="utf-8"), stored()), encoding="utf-8")
    else:
        for trial in RUNS:
            print(f"{trial}\n{table(trial, stored())}\n")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

"""Seeds of the trials. Those that the planner is tuned on and those that stand as evidence are apart.

A trial starts from a seed for tuning unless it is told another one. A fault that is found there is mended, so those seeds
prove nothing afterwards. `trials.evidence` draws from the others alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

#: First seed, and the one after the last, of what may be tried while something is made.
TUNING: Mapping[str, range] = MappingProxyType(
    {
        "planner_properties": range(130_000),
        "planner_ladders": range(100),
        "examiner": range(20_000),
        "long_programs": range(300),
        "g64_tolerance": range(1_000),
        "language_beside_rs274": range(10_000),
        "bodies_beside_rs274": range(10_000),
        "servo_tables": range(10_000),
        "shortening": range(1_000),
        "beside_ipopt": range(1_000),
    }
)
#: The same of what evidence is drawn from.
EVIDENCE: Mapping[str, range] = MappingProxyType(
    {
        "planner_properties": range(130_000, 1_000_000),
        "planner_ladders": range(100, 10_000),
        "examiner": range(20_000, 1_000_000),
        "long_programs": range(300, 100_000),
        "g64_tolerance": range(1_000, 100_000),
        "language_beside_rs274": range(10_000, 1_000_000),
        "bodies_beside_rs274": range(10_000, 1_000_000),
        "servo_tables": range(10_000, 1_000_000),
        "shortening": range(1_000, 100_000),
        "beside_ipopt": range(1_000, 100_000),
    }
)


def first_for_tuning(trial: str) -> int:
    """Return the seed that a trial starts from where none is given."""
    return TUNING[trial].start

"""Two-stage interpolation: a master gives a position every few periods, a second stage the setpoints between them.

Source: B. K. Jung and W. C. Choi, eqs 2 to 4, after Yellowley and Pottier (1989). Between master points X_i and X_i+1, Δt apart:

    linear   x = X_i + (X_i+1 − X_i) t/Δt                                                                    (2)
    centred  + (X_i+2 − X_i+1 − X_i + X_i−1)/(2Δt²) · (t²/2 − Δt t/2)                                        (3)
    causal   + (X_i+1 − 2X_i + X_i−1)/Δt² · (t²/2 − Δt t/2)                                                  (4)

The setpoints leave the path by the chords of the master's points, which `cncgen verify` judges as any others.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cncgen.setpoints.record import Setpoints

Floats = NDArray[np.float64]

#: Names of the interpolators, and the equation of each.
KINDS = {"two-stage-linear": 2, "two-stage-centred": 3, "two-stage-causal": 4}


def second_stage(master: Floats, parts: int, kind: int) -> Floats:
    """Return the second stage's positions, shape ((n − 1) parts + 1, axes), through master points, shape (n, axes).

    Args:
        master: X_i, one every Δt. Before the first and after the last one the end points repeat.
        parts: Periods in Δt.
        kind: 2, 3 or 4: the equation of the paper.

    Raises:
        ValueError: Another kind.
    """
    if kind not in (2, 3, 4):
        raise ValueError(f"the interpolators are equations 2, 3 and 4, not {kind}")
    padded = np.concatenate([master[:1], master, master[-1:]])
    before, at, after, beyond = padded[:-3], padded[1:-2], padded[2:-1], padded[3:]
    share = (np.arange(parts) / parts)[:, None]
    bend = {
        2: np.zeros_like(at),
        3: 0.5 * (beyond - after - at + before),
        4: after - 2.0 * at + before,
    }[kind]
    rows = at[:, None] + (after - at)[:, None] * share + bend[:, None] * 0.5 * share * (share - 1.0)
    return np.concatenate([rows.reshape(-1, master.shape[1]), master[-1:]])


def two_stage(chunks: Iterable[Setpoints], name: str, master_s: float) -> Iterator[Setpoints]:
    """Yield setpoints of which every Δt/T-th is kept as the master's, and those between are interpolated.

    The last row of the stream is a master's point too, which the last stretch reaches in less than Δt. ``vel``, ``acc`` and ``jerk``
    stay those of the plan. A chunk is yielded when the stream is two master points further.

    Args:
        chunks: Setpoints of a plan.
        name: One of `KINDS`.
        master_s: Δt, s; at least one period, rounded to whole ones.
    """
    kind, parts = KINDS[name], 1
    waiting: list[Setpoints] = []
    ready: list[Floats] = []
    rows, first, done = (
        np.zeros((0, 0)),
        0,
        0,
    )  # rows of the plan from the one before the first stretch to come
    for chunk in chunks:
        if not len(chunk):
            continue
        parts = max(1, round(master_s / chunk.period_s))
        rows = np.concatenate([rows, chunk.position]) if len(rows) else chunk.position
        waiting.append(chunk)
        end = ((first + len(rows) - 1) // parts - 1) * parts
        if end > done:
            found = second_stage(rows[: end + parts - first + 1 : parts], parts, kind)
            ready.append(found[done - first : end - first])
            rows, first, done = rows[end - parts - first :], end - parts, end
            yield from _filled(waiting, ready)
    if waiting:
        last = len(rows) - 1
        padded = np.concatenate([rows, np.repeat(rows[-1:], -last % parts, axis=0)])
        found = second_stage(padded[::parts], parts, kind)[: len(rows)]
        found[-1] = rows[-1]
        ready.append(found[done - first :])
        yield from _filled(waiting, ready)


def _filled(waiting: list[Setpoints], ready: list[Floats]) -> Iterator[Setpoints]:
    """Yield the chunks that interpolated rows fill, and take both out of the lists."""
    rows = np.concatenate(ready)
    while waiting and len(waiting[0]) <= len(rows):
        chunk = waiting.pop(0)
        yield replace(chunk, position=np.ascontiguousarray(rows[: len(chunk)]))
        rows = rows[len(chunk) :]
    ready[:] = [rows]

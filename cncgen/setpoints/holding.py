"""The last check of a plan that promises the machine's limits: finite differences of its setpoints, as they stream."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cncgen.diagnostics import Diagnostic, NoPlanError
from cncgen.machine.record import Machine
from cncgen.setpoints.differences import DifferencePeaks
from cncgen.setpoints.record import Setpoints
from cncgen.units import ORDER_NAMES, file_unit, to_file

#: A difference may be so many times its limit, as in `cncgen verify`.
MARGIN = 1.001
#: Positions are written with nine decimals.
RESOLUTION = 1e-9


def held(chunks: Iterable[Setpoints], machine: Machine) -> Iterator[Setpoints]:
    """Hand on setpoints that keep velocity, acceleration and jerk of each axis.

    Args:
        chunks: Of one plan.
        machine: The machine with the limits that they keep.

    Raises:
        NoPlanError: A difference is over its limit by more than `MARGIN` and the rounding of the ninth decimal. Raised before
            the chunk with it is handed on.
    """
    peaks: DifferencePeaks | None = None
    for chunk in chunks:
        if peaks is None:
            peaks = DifferencePeaks(len(chunk.axes), machine.period_s)
        peaks.add(chunk.position)
        _check(peaks, chunk, machine)
        yield chunk
        last = chunk
    if peaks is not None:
        peaks.finish()
        _check(peaks, last, machine)


def _check(peaks: DifferencePeaks, chunk: Setpoints, machine: Machine) -> None:
    """Raise `NoPlanError` that names every limit that is broken so far."""
    found = []
    for column, letter in enumerate(chunk.axes):
        axis = machine.axes.get(letter)
        if axis is None:
            continue
        for order, name in enumerate(ORDER_NAMES):
            limit = getattr(axis, f"max_{name}")
            peak = float(peaks.peak[order, column])
            rounding = 0.5 * RESOLUTION * (2.0 / machine.period_s) ** (order + 1)
            if not peak <= limit * MARGIN + rounding:
                found.append(_over(letter, name, order, peak, limit))
    if found:
        end = (chunk.first + len(chunk)) * machine.period_s
        last = f"before {end:.3f} s of the motion"
        raise NoPlanError(
            Diagnostic(
                "plan-over-limits",
                f"no plan was found that keeps the machine's limits: {', '.join(found)}, {last}",
                hint="look at curves there whose weights or sizes differ by many orders of magnitude, "
                "and at coordinates so large that they round",
            )
        )


def _over(letter: str, name: str, order: int, peak: float, limit: float) -> str:
    unit = f"{file_unit(letter)}/s{('', '²', '³')[order]}"
    factor = to_file(letter)
    return f"{name} of {letter} would be {peak * factor:.6g} {unit}, {peak / limit:.4g} times its limit"

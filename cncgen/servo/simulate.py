"""Closed-loop simulation of the servo axes along a setpoint stream."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.machine.kinematics import Kinematics
from cncgen.machine.record import Servo
from cncgen.servo.bank import LoopBank
from cncgen.servo.contour import ContourTracker
from cncgen.servo.loop_doubts import telling
from cncgen.servo.models import axis_loop
from cncgen.servo.record import Response
from cncgen.servo.scheme import Scheme, SchemeMaker
from cncgen.servo.stream import SampleBlock, blocks, missing_data
from cncgen.servo.tips import TipTracker
from cncgen.setpoints.record import Setpoints

Floats = NDArray[np.float64]

#: A position beyond this is that of an unstable loop, mm (1,000 km).
RUNAWAY_MM = 1e9


def simulate(
    setpoints: Iterable[Setpoints], servos: Mapping[str, Servo], *, settle_s: float = 0.0
) -> Iterator[Response]:
    """Run the servo axes of a machine on setpoints, each with its own drive and controller.

    The stream is consumed as it comes and the response follows some thousand rows behind.

    Args:
        setpoints: The stream.
        servos: Servo data by axis letter; every axis of the stream needs some.
        settle_s: The last setpoint is held so long at the end.

    Raises:
        UsageError: An axis has no servo data (``servo-missing``), the periods do not fit (``servo-period``), or a loop
            is unstable (``servo-unstable``).
    """
    maker = telling(lambda axes, period: own_scheme(servos, axes, period))
    return simulate_scheme(setpoints, maker, settle_s=settle_s)


def own_scheme(servos: Mapping[str, Servo], axes: str, period_s: float) -> Scheme:
    """Return each axis under the controller of its own servo data.

    Raises:
        UsageError: See `simulate`.
    """
    missing = [letter for letter in axes if letter not in servos]
    if missing:
        raise missing_data(missing, servos)
    return Scheme(tuple(axis_loop(servos[letter], letter, period_s) for letter in axes))


def simulate_scheme(
    setpoints: Iterable[Setpoints],
    scheme: Scheme | SchemeMaker,
    *,
    settle_s: float = 0.0,
    kinematics: Kinematics | None = None,
) -> Iterator[Response]:
    """Run setpoints through a control scheme (`cncgen.servo.scheme`), or through the one made for their axes.

    Args:
        setpoints: The stream.
        scheme: The scheme, or a function of axes and period that makes it.
        settle_s: The last setpoint is held so long at the end.
        kinematics: How rotary axes carry table or head. Contour errors are those of the tool's tip on the workpiece, if the
            setpoints have a rotary axis of it and the signal ``tool_length``; else those of X Y Z.
    """
    stream = iter(setpoints)
    head = next((chunk for chunk in stream if len(chunk)), None)
    if head is None:
        return
    made = scheme if isinstance(scheme, Scheme) else scheme(head.axes, head.period_s)
    if len(made.loops) != len(head.axes):
        raise ValueError(f"a scheme of {len(made.loops)} axes for setpoints of {head.axes}")
    tracker = TipTracker(kinematics) if kinematics and TipTracker.follows(kinematics, head) else None
    run = _Run(made, head, tracker)
    stream = chain([head], stream) if tracker is None else tracker.noting(chain([head], stream))
    for block in blocks(stream, made.before, max(made.after, 1), settle_s):
        yield from run.over(block)


def shaped_command(setpoints: Iterable[Setpoints], scheme: Scheme) -> Floats:
    """Return the setpoints that the loops of a scheme are given, after its prefilter, shape (n, axes)."""
    stream = iter(setpoints)
    head = next((chunk for chunk in stream if len(chunk)), None)
    if head is None:
        return np.zeros((0, len(scheme.loops)))
    origin = np.asarray(head.position[0], float)
    prefilter = scheme.prefilter.started() if scheme.prefilter else None
    rows = [
        block.rows if prefilter is None else prefilter(block, origin)[: len(block)] + origin
        for block in blocks(chain([head], stream), scheme.before, max(scheme.after, 1))
    ]
    return np.concatenate(rows)


class _Run:
    """One simulation: loops with their state, and the rows that wait for their contour error."""

    def __init__(self, scheme: Scheme, head: Setpoints, tips: TipTracker | None) -> None:
        self._scheme = scheme
        self._bank = LoopBank(scheme.loops, head.period_s)
        self._prefilter = scheme.prefilter.started() if scheme.prefilter else None
        self._origin = np.asarray(head.position[0], float)
        self._units = tuple(loop.force_unit for loop in scheme.loops)
        self._contour_axes = contour_axes(head.axes)
        self._tips = tips
        measured = 3 if tips else len(self._contour_axes)
        self._tracker = ContourTracker(measured) if measured else None
        self._waiting: list[tuple[NDArray, ...]] = []
        self._first = head.first

    def over(self, block: SampleBlock) -> Iterator[Response]:
        """Carry the loops over a block and yield the rows that are complete."""
        command = block.values[block.before : block.before + len(block) + 1] - self._origin
        shaped = self._prefilter(block, self._origin) if self._prefilter else command
        coupling = self._scheme.coupling.over(block) if self._scheme.coupling else None
        position, force, bounded = self._bank.run(shaped, command, coupling)
        position = position + self._origin
        _check_stable(position, block)
        lengths = np.zeros(len(block)) if self._tips is None else self._tips.lengths(len(block))
        rows = (block.rows, position, force, bounded, lengths)
        if self._tracker is None:
            yield self._response(block, rows, np.full(len(block), np.nan))
            return
        self._waiting.append(rows)
        commanded, actual = (
            places[:, self._contour_axes]
            if self._tips is None
            else self._tips.tips(block.axes, places, lengths)
            for places in (block.rows, position)
        )
        errors = self._tracker.push(commanded, actual)
        if block.last:
            errors = np.concatenate([errors, self._tracker.finish()])
        if len(errors):
            joined = [np.concatenate(part) for part in zip(*self._waiting, strict=True)]
            known = len(errors)
            yield self._response(block, tuple(part[:known] for part in joined), errors)
            self._waiting = [tuple(part[known:] for part in joined)]

    def _response(self, block: SampleBlock, rows: tuple[NDArray, ...], errors: Floats) -> Response:
        command, position, force, bounded, lengths = rows
        first, self._first = self._first, self._first + len(command)
        return Response(
            axes=block.axes,
            period_s=block.period_s,
            first=first,
            command=command,
            position=position,
            force=force,
            force_unit=self._units,
            saturated=bounded,
            contour_error_mm=errors,
            tool_length_mm=None if self._tips is None else lengths,
        )


def _check_stable(position: Floats, block: SampleBlock) -> None:
    """Raise UsageError (``servo-unstable``) where a position has run away."""
    away = ~(np.abs(position) < RUNAWAY_MM)
    if away.any():
        row, axis = np.argwhere(away)[0]
        time = (block.first + int(row)) * block.period_s
        raise UsageError(
            Diagnostic(
                "servo-unstable",
                f"axis {block.axes[axis]} runs away: more than {RUNAWAY_MM:g} mm at {time:.3f} s",
                hint="the closed loop is unstable; lower its gains",
                values={"axis": block.axes[axis], "t_s": time},
            )
        )


def contour_axes(axes: str) -> list[int]:
    """Return the columns that the contour error is measured in: X Y Z, or U V W where none of them is there."""
    main = [i for i, letter in enumerate(axes) if letter in "XYZ"]
    return main or [i for i, letter in enumerate(axes) if letter in "UVW"]

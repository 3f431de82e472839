"""Gains for the least contour error on a given motion, within stability margins: many gain sets, on all cores.

A trial is a whole simulation with its stability margins, a few milliseconds of which the kernels are a small part: threads
would wait for each other, so trials run in processes.
"""

from __future__ import annotations

import math
import multiprocessing
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.interrupts import end_pool, follow_driver, held
from cncgen.machine.record import Servo
from cncgen.servo.controllers.ccc import MODULUS, own_gain
from cncgen.servo.named_schemes import Settings, cross_coupling, scheme_maker
from cncgen.servo.simulate import contour_axes, own_scheme, simulate_scheme
from cncgen.servo.summary import summarize
from cncgen.servo.tuning.analysis import open_loops
from cncgen.servo.uncertainty import Perturbation, perturbed
from cncgen.setpoints.record import Setpoints

Floats = NDArray[np.float64]

#: Gains that a search changes, by model.
SEARCHED = {
    "first-order": ("position_gain_1_s",),
    "pd-plus": ("position_gain_volt_count", "derivative_gain_volt_s_rad"),
    "pi-p-feedforward": ("velocity_gain_1_s", "integral_rate_1_s", "position_gain_1_s"),
    "plant": ("position_gain_1_{l}", "integral_gain_1_{l}_s", "derivative_gain_s_{l}"),
    "two-mass": ("position_gain_n_m_{l}", "derivative_gain_n_m_s_{l}"),
}
#: Gains of the schemes that couple axes.
_COUPLING = {
    "ccc": ("ccc_proportional", "ccc_integral_1_s"),
    "tcf": ("tcf_tangential_rad_s", "tcf_tangential_damping", "tcf_normal_rad_s", "tcf_normal_damping"),
}


@dataclass(frozen=True, slots=True)
class BestGains:
    """The best gain set of a search.

    Attributes:
        servos, settings: The gains.
        contour_rms_mm, start_rms_mm: Contour error with them, and with those that the search started from (inf where the
            start does not keep the margin).
        tried, refused: Gain sets, and those that were unstable or within the margin.
    """

    servos: Mapping[str, Servo]
    settings: Settings
    contour_rms_mm: float
    start_rms_mm: float
    tried: int
    refused: int


@dataclass(frozen=True, slots=True)
class _Trials:
    """The parts that all trials share."""

    setpoints: tuple[Setpoints, ...]
    controller: str
    servos: dict[str, Servo]
    settings: Settings
    names: tuple[tuple[str, str], ...]
    modulus: float
    perturbation: Perturbation | None = None
    enough: float = math.inf

    def gains(self, draw: Floats) -> tuple[dict[str, Servo], Settings]:
        """Return the gain set of a draw: each searched gain times e to its entry. The letter "" is the coupling."""
        tables = {k: dict(servo.parameters) for k, servo in self.servos.items()}
        coupled: dict[str, Any] = {}
        for (letter, key), step in zip(self.names, draw, strict=True):
            if letter:
                tables[letter][key] *= math.exp(step)
            else:
                coupled[key] = getattr(self.settings, key) * math.exp(step)
        servos = {k: Servo(servo.model, tables[k]) for k, servo in self.servos.items()}
        return servos, replace(self.settings, **coupled)

    def contour_rms(self, draw: Floats) -> float:
        """Return the contour error (rms, mm) of a draw; inf where a loop is unstable or keeps less than the margin.

        With a perturbation it is the worst one over the drawn machines too; a gain set that is above `enough` on the way is not
        looked at further.
        """
        servos, settings = self.gains(draw)
        worst = self._contour_rms_on(servos, settings)
        if self.perturbation is not None:
            for drawn in perturbed(servos, self.setpoints[0].axes, self.perturbation):
                if worst > self.enough:
                    break
                worst = max(worst, self._contour_rms_on(drawn, settings))
        return worst

    def _contour_rms_on(self, servos: Mapping[str, Servo], settings: Settings) -> float:
        head = self.setpoints[0]
        try:
            if not self._sound(servos, settings, head.axes, head.period_s):
                return math.inf
            maker = scheme_maker(self.controller, servos, settings)
            error = summarize(simulate_scheme(iter(self.setpoints), maker))["contour_error_rms_mm"]
        except UsageError:
            return math.inf
        return float(error)

    def _sound(self, servos: Mapping[str, Servo], settings: Settings, axes: str, period_s: float) -> bool:
        for loop in open_loops(self.controller, servos, axes, period_s, settings):
            # The contour loop closes round loops that have their margin already: it is asked for less.
            least = min(self.modulus, MODULUS) if loop.name.startswith("contour") else self.modulus
            if not loop.stable or loop.modulus() < least:
                return False
        return True


_shared: list[_Trials] = []


def _adopt(trials: _Trials) -> None:
    follow_driver()
    _shared[:] = [trials]


def _tried(draw: Floats) -> float:
    return _shared[0].contour_rms(draw)


def search(
    setpoints: Sequence[Setpoints],
    servos: Mapping[str, Servo],
    *,
    controller: str = "p",
    settings: Settings | None = None,
    sets: int = 1000,
    modulus: float = 0.5,
    spread: float = 2.0,
    seed: int = 0,
    workers: int | None = None,
    perturbation: Perturbation | None = None,
) -> BestGains:
    """Try random gain sets round the given ones and keep the one with the least rms contour error.

    Args:
        setpoints: The motion.
        servos: Where the search starts.
        controller: Name of the scheme. Of ``p`` and ``zpetc`` the axes' own gains are searched, each by itself; of
            ``ccc`` and ``zpetc+ccc`` those of the coupling; of ``tcf`` those of the frame.
        settings: Where the search of a coupling starts.
        sets: Gain sets, drawn log-uniformly.
        modulus: Sets with a loop that comes nearer to −1 than this are refused (the contour loop of ``ccc``: nearer
            than 0.25, if that is less).
        spread: Gains change by up to this factor either way.
        seed: Of the draws.
        workers: Processes; None: one for each core. Where the system cannot fork (Windows, macOS), a script that calls
            this with more than one keeps the call under ``if __name__ == "__main__"``.
        perturbation: Gain sets are judged by the worst of the machines that it draws round each, and must keep the margin on all.

    Raises:
        UsageError: No axis has gains that can be searched (``tune-search``), no set keeps the margin, or the scheme
            cannot be had for the axes.
    """
    trials = _trials(tuple(setpoints), dict(servos), controller, settings or Settings(), modulus)
    limit = math.log(spread)
    draws = np.random.default_rng(seed).uniform(-limit, limit, (sets, len(trials.names)))
    trials = replace(trials, perturbation=perturbation)
    start = trials.contour_rms(np.zeros(len(trials.names)))
    trials = replace(trials, enough=start)
    results = _run(trials, draws, workers or len(os.sched_getaffinity(0)))
    best = int(np.argmin(results)) if len(results) else 0
    if min(start, *results) == math.inf:
        raise UsageError(
            Diagnostic("tune-search", f"none of {sets} gain sets keeps the modulus margin {modulus:g}",
                       hint="start from slower gains (--bandwidth), or ask for less margin (--modulus)")
        )  # fmt: skip
    refused = int(np.isinf(results).sum())
    draw = draws[best] if results[best] < start else np.zeros(len(trials.names))
    return BestGains(*trials.gains(draw), min(start, float(results[best])), start, sets, refused)


def _run(trials: _Trials, draws: Floats, workers: int) -> Floats:
    if workers <= 1 or len(draws) < 2:
        return np.array([trials.contour_rms(draw) for draw in draws])
    forks = "fork" in multiprocessing.get_all_start_methods() and os.name == "posix" and not _is_mac()
    context = multiprocessing.get_context("fork" if forks else "spawn")
    pool = ProcessPoolExecutor(workers, context, _adopt, (trials,))
    try:
        with held():  # all processes are started here
            results = pool.map(_tried, draws, chunksize=max(1, len(draws) // (8 * workers)))
        return np.array(list(results))
    except BrokenProcessPool:
        message = "a process that tried gain sets was ended from outside: by the system for memory or time, or by hand"
        raise UsageError(
            Diagnostic("tune-processes", message, hint="--jobs 1 tries them in this process")
        ) from None
    finally:
        end_pool(pool)


def _is_mac() -> bool:
    import sys

    return sys.platform == "darwin"


def _trials(
    setpoints: tuple[Setpoints, ...],
    servos: dict[str, Servo],
    controller: str,
    settings: Settings,
    modulus: float,
) -> _Trials:
    head = setpoints[0]
    own_scheme(servos, head.axes, head.period_s)
    if not contour_axes(head.axes):
        message = "gain sets are judged by the contour error, and rotary axes alone have none"
        raise UsageError(Diagnostic("tune-search", message, hint="place their gains with --bandwidth"))
    # Tables may be read-only views, which do not go from process to process.
    plain = {k: Servo(servo.model, dict(servo.parameters)) for k, servo in servos.items()}
    if controller in ("p", "zpetc"):
        names = tuple((k, key) for k in head.axes if k in plain for key in _searched(plain[k], k))
        if not names:
            raise UsageError(Diagnostic("tune-search", "no axis has a model whose gains can be searched"))
        return _Trials(setpoints, controller, plain, settings, names, modulus)
    made = scheme_maker(controller, plain, settings)(head.axes, head.period_s)
    if "ccc" in controller and settings.ccc_proportional is None:
        coupling = cross_coupling(made.loops, head.axes, settings)
        own = own_gain(made.loops)
        settings = replace(
            settings, ccc_proportional=coupling.proportional / own, ccc_integral_1_s=coupling.integral / own
        )
    keys = _COUPLING["tcf" if controller == "tcf" else "ccc"]
    return _Trials(setpoints, controller, plain, settings, tuple(("", key) for key in keys), modulus)


def _searched(servo: Servo, letter: str) -> list[str]:
    """Return the keys of a servo's gains that are there to be changed."""
    from cncgen.units import file_unit

    if servo.model == "plant" and servo.parameters.get("controller", "pid") != "pid":
        return []
    keys = [key.format(l=file_unit(letter)) for key in SEARCHED.get(servo.model, ())]
    return [key for key in keys if servo.parameters.get(key)]

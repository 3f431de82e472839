"""Motion time, computing time and limits held on given curves: `cncgen` beside copp-py, toppra and ruckig; throughput.

    pip install -e .[bench]
    python benchmarks/plan_vs_peers.py                    # curves, then 10⁴, 10⁵ and 10⁶ short segments
    python benchmarks/plan_vs_peers.py --curves           # curves alone

Every planner is given the same curve (`twin_peaks.nc`, `programs/butterfly.nc`) by its derivatives with respect to arc
length, the same limits an axis, and the same largest speed along the curve (feed and chord error of 1 µm at 1 ms). Its
s(t) is sampled at 1 ms and put on the curve; the ratios are the largest first, second and third differences over the
axes, rest before and after included, by their limits. Seconds are CPU time of the process, the best of `--repeat`
runs, from the curve in memory to s(t).

What each peer can do: copp-py (TOPP3, jerk-limited) by its SOCP after its acceleration-only pass, linearised once and
three times anew; toppra limits velocity and acceleration; ruckig plans one coordinate with constant limits, so it is
given those that hold everywhere on the curve, λF, λ²A, λ³J with the largest λ, found beforehand and not timed.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.metadata
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from types import MappingProxyType, ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

import cncgen
from cncgen.machine import Machine, load
from cncgen.planner.limits.axis_limits import AxisLimits
from cncgen.planner.motion import motion_at
from cncgen.planner.record import Limit
from cncgen.toolpath.record import Toolpath

Floats = NDArray[np.float64]

HERE = FilePath(__file__).parent
PERIOD = 1e-3
#: Curve, feed mm/min, velocity, acceleration and jerk of both axes, and the least time of an independent collocation.
CASES = (
    ("twin_peaks", 6000.0, 250.0, 2000.0, 5e4, 2.095),
    ("twin_peaks", 30000.0, 250.0, 2000.0, 5e4, 1.231),
    ("butterfly", 7000.0, 250.0, 2500.0, 5e4, 4.08),
    ("butterfly", 5000.0, 250.0, 2500.0, 5e4, 5.03),
    ("butterfly", 3500.0, 250.0, 2500.0, 5e4, 6.85),
    ("butterfly", 6000.0, 250.0, 1000.0, 3e4, 5.18),
    ("butterfly", 12000.0, 250.0, 5000.0, 5e5, 2.39),
)
SEGMENTS = (10_000, 100_000, 1_000_000)


@dataclass(frozen=True)
class Case:
    """A curve with its limits, as `cncgen` takes it and as arrays for the others."""

    toolpath: Toolpath
    machine: Machine
    feed: float
    limits: tuple[float, float, float]

    @classmethod
    def of(cls, name: str, feed: float, velocity: float, acceleration: float, jerk: float) -> Case:
        """Read the curve and set the limits."""
        file = HERE / f"{name}.nc"
        chunks = cncgen.read(file if file.exists() else HERE.parent / "programs" / f"{name}.nc").chunks()
        (toolpath,) = (replace(c, feed=np.full(len(c), feed / 60.0)) for c in chunks if c.path.length)
        table = load("xy-table")
        axes = {
            letter: replace(axis, max_velocity=velocity, max_acceleration=acceleration, max_jerk=jerk)
            for letter, axis in table.axes.items()
        }
        machine = replace(
            table, axes=MappingProxyType(axes), chord_tolerance_mm=1e-3, max_contour_error_mm=None
        )
        return cls(toolpath, machine, feed / 60.0, (velocity, acceleration, jerk))

    @property
    def length(self) -> float:
        """Arc length, mm."""
        return float(self.toolpath.path.length)

    def derivatives(self, s: Floats) -> Floats:
        """Return x, x', x'', x''' of X and Y, shape (4, n, 2)."""
        return np.ascontiguousarray(self.toolpath.path.evaluate(s, 3)[:, :, :2])

    def top(self, x: Floats) -> Floats:
        """Return the largest v² by feed, axis velocity and chord error, shape (n,)."""
        wide = np.zeros((2, x.shape[1], len(self.toolpath.axes)))
        wide[:, :, :2] = x[1:3]
        feed = np.full(x.shape[1], self.feed)
        bounds = AxisLimits.of(self.machine, self.toolpath.axes)
        return bounds.top(feed, np.full(len(feed), Limit.FEED, np.int8), *wide)[0]

    def ratios(self, s: Floats) -> Floats:
        """Return the largest first, second and third differences of positions a period apart, by their limits, (3, 2)."""
        x = self.toolpath.path.evaluate(np.clip(s, 0.0, self.length), 0)[0][:, :2]
        x = np.concatenate([np.repeat(x[:1], 3, axis=0), x, np.repeat(x[-1:], 3, axis=0)])
        return np.stack(
            [np.abs(np.diff(x, k, axis=0)).max(axis=0) / PERIOD**k / self.limits[k - 1] for k in (1, 2, 3)]
        )


#: A planner: case -> motion time, and the function that gives s at ascending times.
Planner = Callable[[Case], tuple[float, Callable[[Floats], Floats]]]


def ours(case: Case) -> tuple[float, Callable[[Floats], Floats]]:
    """Plan with `cncgen`."""
    done = list(cncgen.planner.plan([case.toolpath], case.machine))

    def at(t: Floats) -> Floats:
        ends = np.array([trajectory.profile.t[-1] for trajectory in done])
        which = np.minimum(np.searchsorted(ends, t), len(done) - 1)
        return np.concatenate([motion_at(d.profile, t[which == i]).s for i, d in enumerate(done)])

    return float(done[-1].profile.t[-1]), at


def copp(n: int, passes: int) -> Planner:
    """Return copp-py's TOPP3 on n stations, linearised so many times; lengths in dm, near which it is well scaled."""
    import copp_py

    unit = 100.0

    def plan(case: Case) -> tuple[float, Callable[[Floats], Floats]]:
        s = np.linspace(0.0, case.length, n)
        x = case.derivatives(s)
        robot = copp_py.Robot(2, capacity=n)
        robot.append_s(s / unit)
        robot.set_q(x[0] / unit, x[1], x[2] * unit, 0, dddq=x[3] * unit**2)
        for add, limit in zip(
            (robot.add_velocity_limits, robot.add_acceleration_limits, robot.add_jerk_limits),
            case.limits,
            strict=True,
        ):
            bound = np.full(2, limit / unit)
            add(bound, -bound, start_idx_s=0, length=n)
        most = np.minimum(robot.constraints.amax_values(0, n), case.top(x) / unit**2)
        robot.constraints.amax_substitute(most, 0)
        second = copp_py.solver.topp2_ra
        problem = second.Problem(robot.constraints, idx_s_interval=(0, n - 1), a_boundary=(0.0, 0.0))
        a, b = second.solve(problem, second.Options()), None
        third = copp_py.solver.topp3_socp
        for _ in range(passes):
            profile = third.solve(third.Problem(robot.constraints, a, idx_s_start=0, b_linearization=b))
            a, b = profile.a, profile.b
        total, arrival = copp_py.interpolation.s_to_t_topp3(s / unit, profile, 0.0)

        def at(t: Floats) -> Floats:
            inside = np.minimum(t, total)
            inside[1:] = np.maximum(inside[1:], np.nextafter(inside[:-1], np.inf))
            sample = copp_py.interpolation.t_to_s_topp3_samples
            return np.asarray(sample(s / unit, profile, arrival, inside)) * unit

        return float(total), at

    return plan


def toppra(n: int) -> Planner:
    """Return toppra with velocities and accelerations on n stations; between them its acceleration is constant."""
    import toppra as package

    package.setup_logging("ERROR")
    limits = package.constraint

    def plan(case: Case) -> tuple[float, Callable[[Floats], Floats]]:
        class Curve(package.interpolator.AbstractGeometricPath):  # type: ignore[name-defined,misc]
            dof, path_interval = 2, np.array([0.0, case.length])

            def __call__(self, s: Any, order: int = 0) -> Any:
                found = case.derivatives(np.atleast_1d(s))[order]
                return found if np.ndim(s) else found[0]

        def speeds(s: float) -> Any:
            x = case.derivatives(np.array([s]))
            most = np.sqrt(case.top(x)[0]) * np.maximum(np.abs(x[1, 0]), 1e-9)
            return np.stack([-most, most], axis=1)

        acceleration = np.array([[-case.limits[1], case.limits[1]]] * 2)
        s = np.linspace(0.0, case.length, n)
        solver = package.algorithm.TOPPRA(
            [
                limits.JointVelocityConstraintVarying(speeds),
                limits.JointAccelerationConstraint(acceleration, limits.DiscretizationType.Interpolation),
            ],
            Curve(),
            gridpoints=s,
            solver_wrapper="seidel",
        )
        slope, speed, _ = solver.compute_parameterization(0.0, 0.0)
        arrival = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / (speed[:-1] + speed[1:]))])

        def at(t: Floats) -> Floats:
            k = np.clip(np.searchsorted(arrival, t, side="right") - 1, 0, n - 2)
            on = np.minimum(t, arrival[-1]) - arrival[k]
            return s[k] + (speed[k] + 0.5 * slope[k] * on) * on

        return float(arrival[-1]), at

    return plan


class ruckig:
    """ruckig on the coordinate s, rest to rest."""

    def __init__(self) -> None:
        self._package = importlib.import_module("ruckig")
        self._scale: dict[int, float] = {}

    def __call__(self, case: Case) -> tuple[float, Callable[[Floats], Floats]]:
        """Plan with the largest scale of the limits that holds them on the curve."""
        if id(case) not in self._scale:
            self._scale[id(case)] = self._largest(case)
        return self._planned(case, self._scale[id(case)])

    def _planned(self, case: Case, scale: float) -> tuple[float, Callable[[Floats], Floats]]:
        asked = self._package.InputParameter(1)
        asked.current_position, asked.target_position = [0.0], [case.length]
        asked.max_velocity = [scale * case.feed]
        asked.max_acceleration, asked.max_jerk = [scale**2 * case.limits[1]], [scale**3 * case.limits[2]]
        found = self._package.Trajectory(1)
        self._package.Ruckig(1).calculate(asked, found)
        total = float(found.duration)
        return total, lambda t: np.array([found.at_time(min(float(x), total))[0][0] for x in t])

    def _largest(self, case: Case) -> float:
        low, high = 0.0, 1.0
        for _ in range(14):
            middle = 0.5 * (low + high)
            total, at = self._planned(case, middle)
            held = case.ratios(sampled(total, at)).max() <= 1.001
            low, high = (middle, high) if held else (low, middle)
        return low


def sampled(total: float, at: Callable[[Floats], Floats]) -> Floats:
    """Return s a period apart, from rest to rest."""
    return at(np.arange(int(np.ceil(total / PERIOD)) + 1) * PERIOD)


def planners() -> Iterator[tuple[str, Planner]]:
    """Yield ours and those peers that are installed; say which are not."""
    yield "cncgen", ours
    peers: tuple[tuple[str, str, Callable[[], list[tuple[str, Planner]]]], ...] = (
        ("copp_py", "copp-py", lambda: [(f"copp-py {n} × {k}", copp(n, k)) for n, k in COPP]),
        ("toppra", "toppra", lambda: [(f"toppra {n}", toppra(n)) for n in (2001, 10001)]),
        ("ruckig", "ruckig", lambda: [("ruckig along s", ruckig())]),
    )
    for module, package, make in peers:
        if _installed(module):
            print(f"{package} {importlib.metadata.version(package)}")
            yield from make()
        else:
            print(f"{package} is not installed, skipped (pip install -e .[bench])")


#: Stations and linearisations of copp-py.
COPP = ((1001, 1), (1001, 3), (2001, 3))


def _installed(module: str) -> ModuleType | None:
    try:
        return importlib.import_module(module)
    except ImportError:
        return None


def curves(repeat: int) -> None:
    """Print a row for each case and planner."""
    chosen = list(planners())
    for name, feed, velocity, acceleration, jerk, least in CASES:
        case = Case.of(name, feed, velocity, acceleration, jerk)
        print(
            f"\n{name}, F{feed:g}, {velocity:g} mm/s, {acceleration:g} mm/s², {jerk:g} mm/s³: least time {least:.3f} s\n"
            f"{'':22}{'CPU ms':>9}{'motion s':>10}{'of least':>9}   "
            + "".join(f"{axis} {what:9}" for axis in "XY" for what in ("v/V", "a/A", "j/J"))
        )
        for label, planner in chosen:
            print(row(label, planner, case, least, repeat), flush=True)


def row(label: str, planner: Planner, case: Case, least: float, repeat: int) -> str:
    """Run a planner on a case and return its row."""
    seconds = np.inf
    for _ in range(repeat):
        begin = time.process_time()
        try:
            total, at = planner(case)
        except Exception as fault:  # a peer's own errors are part of the result
            return f"{label:22}  failed: {str(fault).splitlines()[0][:90]}"
        seconds = min(seconds, time.process_time() - begin)
        if seconds > 5.0:
            break
    ratios = case.ratios(sampled(total, at))
    shown = "".join(f"{value:11.4f}" for value in ratios.T.ravel())
    return f"{label:22}{1e3 * seconds:9.1f}{total:10.4f}{total / least:9.4f} {shown}"


def throughput() -> None:
    """Print the throughput on short segments, each program in fresh processes."""
    print("\nshort segments of 0.2 mm, G64 P0.01, to f64:", flush=True)
    command = [sys.executable, str(HERE / "short_segments.py"), "butterfly", *map(str, SEGMENTS)]
    subprocess.run(command, check=True)


def main() -> None:
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--curves", action="store_true", help="leave out the throughput")
    parser.add_argument("--repeat", type=int, default=3, help="runs of which the best counts")
    asked = parser.parse_args()
    curves(asked.repeat)
    if not asked.curves:
        throughput()


if __name__ == "__main__":
    main()

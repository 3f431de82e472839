"""Examines the planner with programs and a judge that share nothing with it: `generators/meant_programs.py`, `judge.py`.

    python -m trials.examiner setpoints --seeds 0 300
    python -m trials.examiner splitting relaxing units --seeds 0 300
    python -m trials.examiner setpoints --seeds 0 300 --effort fast
    python -m trials.examiner setpoints --seeds 17 18 --shrink --write /tmp/found

Each property says in its docstring what it asks. A failure is printed with its seed, shrunk with --shrink, and written as
NAME.nc and NAME.toml with --write, to be run by `cncgen plan NAME.nc -m NAME.toml`. Most cases take 0.1 to 0.5 s.
"""

from __future__ import annotations

import argparse
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

import cncgen
from trials.generators.elements import INCH_MM, LINEAR, Floats, Loop, Mode, Move, Writer
from trials.generators.meant_programs import Case, Program, Rig, random_case
from trials.judge import MARGIN, MOST, Fault, end_faults, feed_faults, judged, limit_faults, path_faults
from trials.judge import Path as MeantPath
from trials.seeds import first_for_tuning

FIRST = first_for_tuning("examiner")
#: s of CPU that a plan may take before it is called slow.
SLOW_S = 20.0
#: Cases after which a line of progress is printed.
PROGRESS = 50
#: Mistakes of programs that rounding of arcs makes, rightly refused.
REFUSED = ("arc-",)
#: The X-Y table of Tsai 2010 and the die bonder of Yeh and Sun 2008, as the profiles of these names have them.
TABLE_SERVO: dict[str, str | float] = {
    "model": "pi-p-feedforward",
    "velocity_pole_1_s": 36.4609,
    "velocity_gain_1_s": 346.592,
    "integral_rate_1_s": 146.167,
    "position_gain_1_s": 121.31,
    "feedforward_gain": 0.961191,
    "feedforward_filter_rad_s": 315.347,
    "control_period_s": 0.0005,
}
TABLE = Rig(dict.fromkeys("XY", (250.0, 2450.0, 5e4)), 1e-3, 1e-3, 0.01, dict.fromkeys("XY", TABLE_SERVO))
BONDER_SERVO: dict[str, str | float] = {
    "model": "pd-plus",
    "time_constant_s": 0.31,
    "velocity_gain_rad_s_volt": 2506.17,
    "counts_per_rad": 1591.5494,
    "counts_per_mm": 1000.0,
    "position_gain_volt_count": 0.0136,
    "derivative_gain_volt_s_rad": 0.03,
    "saturation_volt": 10.0,
}
BONDER = Rig(
    {"X": (500.0, 16700.0, 1e7), "Y": (500.0, 48300.0, 1e7)},
    1e-3,
    1e-3,
    0.01,
    {
        "X": BONDER_SERVO,
        "Y": {
            **BONDER_SERVO,
            "time_constant_s": 0.135,
            "velocity_gain_rad_s_volt": 3156.23,
            "position_gain_volt_count": 0.00577,
            "derivative_gain_volt_s_rad": 0.028,
        },
    },
)
#: Largest contour error that is asked for, mm, and what its simulation may have more.
CONTOUR_MM, CONTOUR_MORE = 0.01, 1.01


class TooSlowError(Exception):
    """A case takes longer than it may."""


def _alarm(*_: object) -> NoReturn:
    raise TooSlowError


class Work:
    """Processor seconds that planning takes; the time of judging is the examiner's."""

    seconds = 0.0

    @classmethod
    @contextmanager
    def counted(cls) -> Iterator[None]:
        """Count what is done within."""
        begun = time.process_time()
        try:
            yield
        finally:
            cls.seconds += time.process_time() - begun


# --- plans ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Planned:
    """Setpoints of a case in the order of its axes, mm and degrees, their times, the seconds of motion, and the verdict's input."""

    x: Floats
    times: Floats
    seconds: float
    setpoints: cncgen.Setpoints
    program: Any
    machine: cncgen.Machine


def machine_of(case: Case, unit: float = 1.0) -> cncgen.Machine:
    """Return the machine of a case, read from its file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "random.toml"
        path.write_text(case.rig.toml(unit))
        return cncgen.load_machine(str(path))


def read(case: Case, text: str) -> Any:
    """Return the program as cncgen reads it."""
    return cncgen.read_text(text, "random.nc", options=cncgen.ReadOptions(dialect=case.program.dialect))


def in_degrees(axes: str) -> Floats:
    """Return the degrees (mm) in a radian (mm) of each axis."""
    return np.array([1.0 if letter in LINEAR else 180.0 / np.pi for letter in axes])


def seconds_of(case: Case, options: cncgen.PlanOptions, unit: float = 1.0) -> float:
    """Return the seconds of motion of a case; the machine's lengths times `unit`."""
    with Work.counted():
        chunks, summary = cncgen.plan_with_summary(
            read(case, case.program.written().text()), machine_of(case, unit), options
        )
        for _ in chunks:
            pass
    return float(summary.as_json()["motion_time_s"])


def planned(case: Case, to: Writer, options: cncgen.PlanOptions) -> Planned:
    """Return all setpoints of a case."""
    machine, program = machine_of(case), read(case, to.text())
    with Work.counted():
        setpoints = cncgen.sample(cncgen.plan(program, machine, options)).collect()
    found = setpoints.position * in_degrees(setpoints.axes)
    x = np.repeat(to.pieces[0].curve(np.array([0.0])), len(found), axis=0)
    for i, letter in enumerate(to.axes):
        if letter in setpoints.axes:
            x[:, i] = found[:, setpoints.axes.index(letter)]
    times = setpoints.time_s
    return Planned(x, times, float(times[-1]), setpoints, program, machine)


# --- properties -----------------------------------------------------------------------------------------------------

Property = Callable[[int, Case, cncgen.PlanOptions], list[Fault]]


def setpoints(seed: int, case: Case, options: cncgen.PlanOptions) -> list[Fault]:
    """Limits, ends, period, feed, time, and distances both ways; and `cncgen.judge` finds nothing that is not there."""
    to = case.program.written()
    if not to.pieces:
        return []
    done = planned(case, to, options)
    faults = judged(done.x, done.times, to, case.rig)
    if not faults:
        breaches = cncgen.judge(done.setpoints, done.program, done.machine).breaches
        faults += [Fault(each.code, 1.0, each.message) for each in breaches if each.severity.name != "NOTE"][
            :1
        ]
    return faults


def _differs(name: str, one: float, other: float, allowed: float) -> list[Fault]:
    """Return a fault where a time differs from another by more than a part of it."""
    change = abs(other / one - 1.0) if one > 0.0 else abs(other)
    return [Fault(name, change / allowed, f"{one:.9g} s, {other:.9g} s")] if change > allowed else []


def _longer(name: str, one: float, other: float, allowed: float) -> list[Fault]:
    """Return a fault where the other time is longer by more than a part."""
    return _differs(name, one, other, allowed) if other > one else []


def units(seed: int, case: Case, options: cncgen.PlanOptions) -> list[Fault]:
    """Every length by 25.4, of program and machine: the time stays, to 1e-9."""
    inches = replace(case, program=replace(case.program, unit=INCH_MM))
    return _differs("units", seconds_of(case, options), seconds_of(inches, options, INCH_MM), 1e-9)


def splitting(seed: int, case: Case, options: cncgen.PlanOptions) -> list[Fault]:
    """Lines and arcs in up to three parts each, with no stops between: the time changes by 0.1 % at most."""
    rng = np.random.default_rng((21, seed))
    elements = tuple(Mode("G61") if e == Mode("G61.1") else e for e in case.program.elements)
    parts = [part for element in elements for part in element.split(rng)]
    program = replace(case.program, dialect="linuxcnc")
    one = replace(case, program=replace(program, elements=elements))
    other = replace(case, program=replace(program, elements=tuple(parts)))
    return _differs("splitting", seconds_of(one, options), seconds_of(other, options), 1e-3)


def relaxing(seed: int, case: Case, options: cncgen.PlanOptions) -> list[Fault]:
    """One limit of one axis 1.05 to 100 times as large: no longer by more than 0.1 %."""
    rng = np.random.default_rng((22, seed))
    letter = str(rng.choice(list(case.rig.limits)))
    order, factor = int(rng.integers(3)), float(rng.choice([1.05, 1.5, 3.0, 100.0]))
    wider = list(case.rig.limits[letter])
    wider[order] *= factor
    limits = {**case.rig.limits, letter: (wider[0], wider[1], wider[2])}
    other = replace(case, rig=replace(case.rig, limits=limits))
    name = f"{('velocity', 'acceleration', 'jerk')[order]} of {letter} by {factor:g}"
    return _longer(name, seconds_of(case, options), seconds_of(other, options), 1e-3)


def reversing(seed: int, case: Case, options: cncgen.PlanOptions) -> list[Fault]:
    """The path from its end to its start takes as long, within 1 %."""
    elements = case.program.elements
    modes = tuple(element for element in elements if isinstance(element, Mode))
    back = tuple(element.backwards() for element in elements[::-1] if not isinstance(element, Mode))
    other = replace(case, program=replace(case.program, elements=modes + back))
    return _differs("reversing", seconds_of(case, options), seconds_of(other, options), 1e-2)


def stops(seed: int, case: Case, options: cncgen.PlanOptions) -> list[Fault]:
    """No longer, by more than 0.1 %, than with a stop after each motion."""
    stopping = tuple(Mode("G61.1") if isinstance(e, Mode) else e for e in case.program.elements)
    program = replace(case.program, dialect="linuxcnc")
    at_all = seconds_of(replace(case, program=replace(program, elements=stopping)), options)
    return _longer("stops", at_all, seconds_of(replace(case, program=program), options), 1e-3)


def verify(seed: int, case: Case, options: cncgen.PlanOptions) -> list[Fault]:
    """`cncgen.judge` sees setpoints that are altered by hand and break a limit or a tolerance; and nothing that is not there."""
    to = case.program.written()
    if not to.pieces:
        return []
    done = planned(case, to, options)
    if not 8 <= len(done.x) <= MOST // 2:
        return []
    faults: list[Fault] = []
    rng = np.random.default_rng((23, seed))
    meant = MeantPath(to.pieces, case.rig)
    columns = [(i, done.setpoints.axes.index(a)) for i, a in enumerate(to.axes) if a in done.setpoints.axes]
    scale = in_degrees(done.setpoints.axes)
    for name, x in spoiled(rng, done.x):
        position = np.zeros((len(x), len(scale)))
        for mine, theirs in columns:
            position[:, theirs] = x[:, mine] / scale[theirs]
        given = cncgen.Setpoints(done.setpoints.axes, done.setpoints.period_s, 0, position)
        seen = {
            breach.code.split("-")[1] for breach in cncgen.judge(given, done.program, done.machine).breaches
        }
        resolution = 1e-9 * 8.0 / case.rig.period_s**3 / min(limits[2] for limits in case.rig.limits.values())
        broken = limit_faults(x, to.axes, case.rig, 1.5 * MARGIN + resolution)
        if broken and not seen & {"velocity", "acceleration", "jerk", "lost"}:
            faults.append(Fault(f"verify misses ({name})", broken[0].amount, str(broken[0])))
        off = [f for f in path_faults(x, meant) if f.amount > 1.0015 + 3e-6 / case.rig.chord_mm]
        if off and not seen & {"distance", "coverage", "order", "axis", "lost"}:
            faults.append(Fault(f"verify misses ({name})", off[0].amount, str(off[0])))
        if seen & {"velocity", "acceleration", "jerk"} and not limit_faults(
            x, to.axes, case.rig, 0.5 * MARGIN
        ):
            faults.append(Fault(f"verify sees what is not ({name})", 1.0, str(sorted(seen))))
    return faults


def spoiled(rng: np.random.Generator, x: Floats) -> Iterator[tuple[str, Floats]]:
    """Yield setpoints with a fault put in, each with its name."""
    n, axes = x.shape
    k = int(rng.integers(1, n - 1))
    moved = x.copy()
    moved[k] += rng.normal(size=axes) * 10.0 ** rng.uniform(-6, -1)
    yield "moved", moved
    yield "dropped", np.delete(x, k, axis=0)
    yield "reversed", x[::-1].copy()
    yield (
        "drifting",
        x + np.linspace(0.0, 1.0, n)[:, None] * rng.normal(size=axes) * 10.0 ** rng.uniform(-6, -2),
    )
    yield "cut", x[: max(2, k)]


def strategies(seed: int, case: Case, options: cncgen.PlanOptions) -> list[Fault]:
    """The baselines and `ild` stay on the path with their setpoints, end at its end, and keep the feed."""
    to = case.program.written()
    if not to.pieces:
        return []
    faults: list[Fault] = []
    for name in ("ild", "constant", "adaptive", "curvature"):
        done = planned(case, to, replace(options, feedrate=name))
        found = end_faults(done.x, done.times, to, case.rig) + feed_faults(done.x, to, case.rig)
        if len(done.x) <= MOST:
            ratio = float(MeantPath(to.pieces, case.rig).excess(done.x).max())
            if ratio > 1.0 + MARGIN:
                found.append(Fault("distance", ratio, "of a setpoint"))
        faults += [replace(fault, name=f"{name}: {fault.name}") for fault in found]
    return faults


def saturation(seed: int, case: Case, options: cncgen.PlanOptions) -> list[Fault]:
    """A plan with `--saturation predictive` saturates no drive of the simulation, and keeps all else."""
    to = case.program.written()
    if not to.pieces:
        return []
    done = planned(case, to, replace(options, saturation="predictive"))
    faults = judged(done.x, done.times, to, case.rig)
    saturated = sum(int(chunk.saturated.sum()) for chunk in cncgen.simulate(done.setpoints, done.machine))
    if saturated:
        faults.append(Fault("saturation", 1.0 + saturated, f"{saturated} samples"))
    return faults


def contour(seed: int, case: Case, options: cncgen.PlanOptions) -> list[Fault]:
    """Under `--max-contour-error` the simulation keeps to it, or a warning says that it does not; and all else holds."""
    to = case.program.written()
    if not to.pieces:
        return []
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        done = planned(case, to, replace(options, max_contour_error_mm=CONTOUR_MM))
    faults = judged(done.x, done.times, to, case.rig)
    warned = bool(said) or any("contour" in d.code for d in done.program.diagnostics)
    errors = [chunk.contour_error_mm for chunk in cncgen.simulate(done.setpoints, done.machine)]
    worst = float(max(np.abs(each).max(initial=0.0) for each in errors)) if errors else 0.0
    if worst > CONTOUR_MM * CONTOUR_MORE and not warned:
        faults.append(Fault("contour error", worst / CONTOUR_MM, f"{worst:.6f} mm"))
    return faults


PROPERTIES: dict[str, tuple[Property, dict[str, Any]]] = {
    "setpoints": (setpoints, {}),
    "units": (units, {"linear": True, "digits": True}),
    "splitting": (splitting, {"one_mode": True, "digits": True}),
    "relaxing": (relaxing, {}),
    "reversing": (reversing, {"one_mode": True, "digits": True}),
    "stops": (stops, {"one_mode": True}),
    "verify": (verify, {"most": 10}),
    "strategies": (strategies, {"rig": TABLE}),
    "saturation": (saturation, {"rig": BONDER}),
    "contour": (contour, {"rig": TABLE}),
}


# --- running and shrinking ------------------------------------------------------------------------------------------


def tried(check: Property, seed: int, case: Case, options: cncgen.PlanOptions, most_s: int) -> list[Fault]:
    """Return the faults of a case: a diagnostic, an exception and too long a time are faults too."""
    signal.setitimer(signal.ITIMER_PROF, most_s)
    begun = Work.seconds
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            faults = check(seed, case, options)
    except TooSlowError:
        return [Fault("too slow", 1.0, f"more than {most_s} s of work")]
    except cncgen.CncgenError as error:
        errors = [d for d in error.diagnostics if d.severity.name == "ERROR"]
        if errors and all(d.code.startswith(REFUSED) for d in errors):
            return []
        return [Fault("refused", 1.0, "; ".join(f"{d.code}: {d.message}" for d in errors)[:300])]
    except Exception as error:
        return [Fault(type(error).__name__, 1.0, str(error)[:300])]
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    spent = Work.seconds - begun
    if spent > SLOW_S:
        faults.append(Fault("slow", spent / SLOW_S, f"{spent:.1f} s of work"))
    return faults


def _smaller(case: Case) -> Iterator[Case]:
    """Yield cases with less in them, the boldest first."""
    program = case.program
    elements = program.elements
    size = len(elements) // 2
    while size:
        for i in range(0, len(elements), size):
            yield replace(case, program=replace(program, elements=elements[:i] + elements[i + size :]))
        size //= 2
    for i, element in enumerate(elements):
        if isinstance(element, Loop):
            opened = elements[:i] + element.body + elements[i + 1 :]
            yield replace(case, program=replace(program, elements=opened))
    if program.start:
        yield replace(case, program=replace(program, start=()))
    for digits in (1, 2, 3):
        yield replace(case, program=_coarse(program, digits))
        limits = {a: tuple(float(f"{x:.{digits}g}") for x in v) for a, v in case.rig.limits.items()}
        yield replace(case, rig=replace(case.rig, limits=limits))  # type: ignore[arg-type]


def _coarse(program: Program, digits: int) -> Program:
    """Return a program whose moves and feeds have so many digits."""
    elements = tuple(
        replace(
            element,
            by={letter: float(f"{x:.{digits}g}") for letter, x in element.by.items()},
            feed=replace(element.feed, value=float(f"{element.feed.value:.{digits}g}")),
        )
        if isinstance(element, Move)
        else element
        for element in program.elements
    )
    return replace(program, elements=elements)


def shrunk(case: Case, fault: Fault, fails: Callable[[Case], list[Fault]], seconds: float) -> Case:
    """Return a smaller case with the same fault, by half of its excess at least."""
    least = 1.0 + 0.5 * (fault.amount - 1.0)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for smaller in _smaller(case):
            if smaller == case or time.monotonic() > end:
                continue
            if any(f.name == fault.name and f.amount >= least for f in fails(smaller)):
                case = smaller
                break
        else:
            break
    return case


def keep(case: Case, folder: Path, name: str) -> None:
    """Write program and machine to files."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.nc").write_text(case.program.written().text())
    (folder / f"{name}.toml").write_text(case.rig.toml())


def examine(name: str, asked: argparse.Namespace, options: cncgen.PlanOptions) -> int:
    """Run a property over the seeds, print what fails, and return how many do."""
    check, how = PROPERTIES[name]
    failed: Counter[str] = Counter()
    bad, begun = 0, time.process_time()
    seeds = asked.only or range(*asked.seeds)
    for count, seed in enumerate(seeds):
        if count and count % PROGRESS == 0:
            print(f"{name}: {bad} of {count} fail, {time.process_time() - begun:.0f} s of work", flush=True)
        case = random_case(seed, **how)
        faults = tried(check, seed, case, options, asked.most)
        if not faults:
            continue
        bad += 1
        failed.update({fault.name.split(" of ")[0] for fault in faults})
        print(
            f"{name} {seed} ({case.program.axes}, {case.rig.period_s:g} s): " + "; ".join(map(str, faults)),
            flush=True,
        )
        if asked.shrink:
            worst = faults[0]
            case = shrunk(
                case,
                worst,
                lambda one, seed=seed: tried(check, seed, one, options, asked.most),  # type: ignore[misc]
                asked.shrink_seconds,
            )
            print(f"{case.program.written().text()}{case.rig.toml()}", flush=True)
            print("; ".join(map(str, tried(check, seed, case, options, asked.most))), flush=True)
        if asked.write:
            keep(case, asked.write, f"{name}-{seed}")
    kinds = ", ".join(f"{kind} {count}" for kind, count in failed.most_common())
    print(
        f"{name}: {bad} of {len(seeds)} fail, {time.process_time() - begun:.0f} s of work; {kinds}",
        flush=True,
    )
    return bad


def examined(name: str, seeds: range) -> int:
    """Run a property over seeds as the command does, and return how many fail."""
    signal.signal(signal.SIGPROF, _alarm)
    return examine(
        name, _arguments([name, "--seeds", str(seeds.start), str(seeds.stop)]), cncgen.PlanOptions()
    )


def _arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the arguments of the command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "properties", nargs="*", default=["setpoints"], metavar="PROPERTY", help=", ".join(PROPERTIES)
    )
    parser.add_argument("--seeds", type=int, nargs=2, default=(FIRST, FIRST + 100), metavar=("FIRST", "STOP"))
    parser.add_argument("--only", type=int, nargs="+", metavar="SEED")
    parser.add_argument("--effort", default="best")
    parser.add_argument("--shrink", action="store_true", help="make what fails smaller")
    parser.add_argument("--shrink-seconds", type=float, default=60.0)
    parser.add_argument("--write", type=Path, metavar="DIR", help="write what fails to files")
    parser.add_argument("--most", type=int, default=120, help="seconds of work that a case may take")
    asked = parser.parse_args(arguments)
    for name in asked.properties:
        if name not in PROPERTIES:
            parser.error(f"no property {name!r}: {', '.join(PROPERTIES)}")
    return asked


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what is asked for; 1 if something fails."""
    asked = _arguments(arguments)
    signal.signal(signal.SIGPROF, _alarm)
    options = cncgen.PlanOptions(effort=asked.effort)
    return 1 if sum(examine(name, asked, options) for name in asked.properties) else 0


if __name__ == "__main__":
    sys.exit(main())

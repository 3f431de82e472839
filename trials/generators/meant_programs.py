"""Random NC programs with the paths that they mean, and random machines for them, made apart from cncgen.

Nothing of cncgen is used here: a program is a row of elements, each of which writes its blocks and says what curve they are,
so that a plan can be judged against what was meant. Elements hold increments; so a program can be written again with
elements left out, cut in parts, backwards, or in another unit. `examiner.py` plans and judges.

What is drawn: machines on which one move takes from two to a thousand periods of 0.05 to 10 ms, with limits of axes up to a
thousand to one; linear axes, rotary ones, both; all path modes, tolerances down to 10 nm; lines, traverses, arcs by centre and by
radius in three planes, helices, full circles, more turns than one, NURBS with doubled points and knots, cubic and quadratic
splines, chains of short lines with noise, moves of 1e-7 mm and of nothing, ways back; feeds by minute and by inverse time, far
above and below the limits; inches, increments, loops, subprograms, dwells, stops; places 1000 mm from the origin.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from trials.generators.elements import (
    INCH_MM,
    LINEAR,
    PLANES,
    Arc,
    Dialect,
    Distances,
    Element,
    Feed,
    Floats,
    Loop,
    Mode,
    Move,
    Nurbs,
    Spline,
    Word,
    Writer,
)

# --- programs and machines ------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Program:
    """Elements, and how they are written; `start` is where the machine stands, in the program's units and degrees."""

    axes: str
    elements: tuple[Element, ...]
    unit: float = 1.0
    decimals: int | None = 6
    dialect: Dialect = "linuxcnc"
    start: tuple[float, ...] = ()

    def begun(self) -> Writer:
        """Return a writer at the beginning of the program."""
        at = np.array(self.start) if self.start else np.zeros(len(self.axes))
        to = Writer(self.axes, self.unit, self.decimals, self.dialect, at)
        if self.dialect == "fanuc":
            to.emit("O0001")
        if self.start:
            words = (f"{x}{v!r}" for x, v in zip(self.axes, (at * to.scale).tolist(), strict=True))
            to.emit(f"(START, {' '.join(words)})")
        to.emit("G20" if self.unit == INCH_MM else "G21", "G17 G90 G94")
        return to

    def written(self) -> Writer:
        """Write it."""
        to = self.begun()
        for element in self.elements:
            element.write(to)
        return to


@dataclass(frozen=True)
class Rig:
    """A machine: velocity, acceleration and jerk of each axis, mm or degrees, the keys of its file, servos by axis."""

    limits: Mapping[str, tuple[float, float, float]]
    period_s: float
    chord_mm: float
    path_mm: float
    servos: Mapping[str, Mapping[str, str | float]] = field(default_factory=dict)

    def toml(self, unit: float = 1.0) -> str:
        """Return its file, lengths times `unit`."""
        lines = [
            'name = "random"',
            f"period_s = {self.period_s!r}",
            f"chord_tolerance_mm = {self.chord_mm * unit!r}",
            f"path_tolerance_mm = {self.path_mm * unit!r}",
        ]
        for letter, values in self.limits.items():
            length = "mm" if letter in LINEAR else "deg"
            v, a, j = (x * (unit if letter in LINEAR else 1.0) for x in values)
            lines += [f"[axes.{letter.lower()}]", f"max_velocity_{length}_s = {v!r}"]
            lines += [f"max_acceleration_{length}_s2 = {a!r}", f"max_jerk_{length}_s3 = {j!r}"]
            if servo := self.servos.get(letter):
                values_of = [f"{key} = {value!r}".replace("'", '"') for key, value in servo.items()]
                lines += [f"[axes.{letter.lower()}.servo]", *values_of]
        return "\n".join([*lines, ""])


@dataclass(frozen=True)
class Case:
    """A program and a machine."""

    program: Program
    rig: Rig


#: Axes of a program; the commonest ones more often.
AXES = ["XY", "XYZ"] * 4 + ["XYZA", "XYZAC", "XYA", "A", "BC", "XYZUVW", "ZC", "X", "XYZABC", "XA", "U"]
EVENTS = ("M3 S1000", "M5", "M8", "M9", "M0", "M1", "S500", "M48")


def logarithmic(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw a number whose logarithm is uniform."""
    return float(10.0 ** rng.uniform(math.log10(low), math.log10(high)))


def rounded(value: float, digits: int = 4) -> float:
    """Return a value with so many digits."""
    return float(f"{value:.{digits}g}")


def random_rig(rng: np.random.Generator, axes: str, size: float) -> Rig:
    """Draw a machine on which `size` takes from two to a thousand periods at full speed."""
    period = rounded(logarithmic(rng, 5e-5, 1e-2), 2)
    velocity = size / (logarithmic(rng, 2.0, 1000.0) * period)
    acceleration = velocity / (logarithmic(rng, 0.3, 300.0) * period)
    jerk = acceleration / (logarithmic(rng, 0.3, 200.0) * period)
    wide = rng.random() < 0.3
    limits = {}
    for letter in axes:
        factor = logarithmic(rng, 10**-1.5, 10**1.5) if wide else logarithmic(rng, 0.5, 2.0)
        second = logarithmic(rng, 0.1, 10.0) if wide and rng.random() < 0.5 else 1.0
        v, a, j = velocity * factor, acceleration * factor * second, jerk * factor * second
        # Machine files begin at 1 µm/s.
        limits[letter] = (max(rounded(v), 1e-3), rounded(a), rounded(j))
    chord = size * logarithmic(rng, 1e-6, 1e-3) if rng.random() < 0.5 else 1e-3
    return Rig(
        limits,
        period,
        rounded(float(np.clip(chord, 1e-5, 0.1)), 3),
        rounded(logarithmic(rng, 1e-4, 0.5), 3),
    )


class Drawer:
    """Draws a program, element by element, writing it as it goes to know where it is."""

    def __init__(
        self, rng: np.random.Generator, program: Program, rig: Rig, size: float, one_mode: bool
    ) -> None:
        self.rng, self.program, self.rig, self.size = rng, program, rig, size
        self.axes = program.axes
        self.to = program.begun()
        self.elements: list[Element] = []
        self.one_mode = one_mode
        straight = [letter for letter in self.axes if letter in "XYZ"]
        self.fastest = max(rig.limits[letter][0] for letter in straight or self.axes)
        families = (("G61",), ("G64",), ("G61", "G61.1", "G64"))
        self.modes = families[int(rng.integers(3))]
        self.back: dict[str, float] = {}
        self.feed = self.new_feed()

    def add(self, element: Element) -> None:
        """Append an element."""
        before = self.to.at
        element.write(self.to)
        self.elements.append(element)
        if (self.to.at != before).any():
            self.back = self.named(before - self.to.at)

    def named(self, by: Floats) -> dict[str, float]:
        """Return a step by axis."""
        return dict(zip(self.axes, by.tolist(), strict=True))

    def new_feed(self) -> Feed:
        """Draw a feed: far above the limits, about at them, or below."""
        kind = self.rng.random()
        spread = (10.0, 1000.0) if kind < 0.2 else (0.5, 3.0) if kind < 0.6 else (0.01, 1.0)
        fastest = 60.0 * self.fastest / self.program.unit
        return Feed("minute", min(fastest * logarithmic(self.rng, *spread), 3e7))

    def timed(self, by: Mapping[str, float]) -> Feed:
        """Draw a feed by inverse time, from a tenth to ten times what the axes' speeds allow."""
        scale = dict(zip(self.axes, self.to.scale, strict=True))
        least = max(abs(step) * scale[letter] / self.rig.limits[letter][0] for letter, step in by.items())
        return Feed("time", max(least * logarithmic(self.rng, 0.1, 10.0), 1e-4)) if least else self.feed

    def new_mode(self) -> None:
        name = str(self.rng.choice(self.modes))
        if name == "G61.1" and self.program.dialect == "fanuc":
            name = "G61"
        tolerance = logarithmic(self.rng, 1e-4, 0.5) if name == "G64" and self.rng.random() < 0.85 else None
        self.add(Mode(name, tolerance=tolerance))

    def spread(self, size: float) -> dict[str, float]:
        """Draw a step of all axes."""
        return self.named(self.rng.normal(size=len(self.axes)) * size)

    def line(self) -> None:
        by = self.spread(self.size * logarithmic(self.rng, 1e-2, 1.0))
        if self.rng.random() < 0.4:
            kept = self.rng.choice(
                list(self.axes), size=self.rng.integers(1, len(self.axes) + 1), replace=False
            )
            by = {letter: by[letter] for letter in by if letter in kept}
        timed = self.rng.random() < (0.3 if set(self.axes) & set("ABC") else 0.08)
        self.add(Move(by, self.timed(by) if timed else self.feed))

    def rotary(self) -> None:
        turning = [letter for letter in self.axes if letter not in LINEAR]
        if turning:
            by = {letter: float(self.rng.normal() * self.size) for letter in turning}
            self.add(Move(by, self.timed(by) if self.rng.random() < 0.5 else self.feed))

    def traverse(self) -> None:
        self.add(Move(self.spread(0.5 * self.size), Feed("traverse")))

    def nothing(self) -> None:
        self.add(Move({}, self.feed))

    def tiny(self) -> None:
        letter = str(self.rng.choice(list(self.axes)))
        self.add(Move({letter: 1e-7 * float(self.rng.choice([-1, 1]))}, self.feed, decimals=8))

    def crumb(self) -> None:
        self.add(Move(self.spread(self.size * logarithmic(self.rng, 1e-5, 1e-2)), self.feed))

    def return_(self) -> None:
        if self.back:
            self.add(Move(self.back, self.feed))

    def onward(self) -> None:
        last = self.elements[-1] if self.elements else None
        if isinstance(last, Move) and last.by and last.feed.kind == "minute":
            self.add(replace(last.part(float(self.rng.uniform(0.01, 3.0))), feed=self.feed))

    def drawn_arc(self) -> Arc | None:
        """Draw an arc, half of them in the direction of what came before."""
        rng = self.rng
        planes = [plane for plane in PLANES if set(plane) <= set(self.axes)]
        radius = self.size * logarithmic(rng, 1e-3, 1.0)
        coarse = 20.0 * 10.0 ** -(self.program.decimals or 9)
        if not planes or radius < max(0.005, coarse):
            return None
        plane = str(rng.choice(planes))
        sign, word = float(rng.choice([-1, 1])), "centre"
        sweep = sign * (2.0 * math.pi if rng.random() < 0.25 else float(rng.uniform(0.05, 6.2)))
        if rng.random() < 0.07 and self.program.dialect == "linuxcnc":
            sweep += sign * 2.0 * math.pi * int(rng.integers(1, 4))
        elif rng.random() < 0.25 and 0.2 < abs(sweep) < 5.9:
            word = "radius"
        others = [letter for letter in self.axes if letter not in plane and rng.random() < 0.35]
        by = {letter: float(rng.normal() * radius) for letter in others}
        start = float(rng.uniform(0.0, 2.0 * math.pi))
        if rng.random() < 0.5 and self.to.pieces:
            way = self.to.pieces[-1].curve(np.array([0.999999, 1.0]))
            dx, dy = (way[1] - way[0])[[self.axes.index(letter) for letter in plane]]
            if dx or dy:
                start = math.atan2(dy, dx) - math.copysign(0.5 * math.pi, sweep)
        decimals = 9 if rng.random() < 0.7 else None
        feed = self.feed
        if rng.random() < 0.1:
            feed = self.timed(by | {plane[0]: radius * abs(sweep)})
        return Arc(plane, radius, start, sweep, by, feed, word, decimals)  # type: ignore[arg-type]

    def arc(self) -> None:
        if arc := self.drawn_arc():
            self.add(arc)

    def chain(self) -> None:
        """Append short lines along a wave, with or without noise."""
        rng, n = self.rng, len(self.axes)
        count, length = int(rng.integers(5, 60)), self.size * logarithmic(rng, 0.03, 1.0)
        along = rng.normal(size=n)
        along /= np.linalg.norm(along)
        across = rng.normal(size=n)
        across -= along * (across @ along)
        across /= max(float(np.linalg.norm(across)), 1e-6)
        waves, height = rng.uniform(0.2, 3.0), length * logarithmic(rng, 1e-3, 1.0)
        noise = length * logarithmic(rng, 1e-6, 1e-2) if rng.random() < 0.5 else 0.0
        u = np.linspace(0.0, 1.0, count + 1)
        points = u[:, None] * along * length + np.sin(2.0 * math.pi * waves * u)[:, None] * across * height
        points[1:] += noise * rng.normal(size=(count, n))
        for step in np.diff(points, axis=0):
            self.add(Move(self.named(step), self.feed))

    def nurbs(self) -> None:
        """Append a curve with doubled points and knots, of one to three degrees."""
        rng = self.rng
        degree = int(rng.integers(1, 4))
        count = degree + 1 + (int(rng.integers(40, 120)) if rng.random() < 0.1 else int(rng.integers(0, 8)))
        size = self.size * logarithmic(rng, 1e-2, 1.0) * (0.1 if count > 20 else 1.0)
        points = [np.zeros(len(self.axes))]
        while len(points) < count:
            kind = rng.random()
            if kind < 0.1:
                points.append(points[-1])
            elif kind < 0.15 and len(points) > 1:
                points.append(points[-2])
            else:
                far = 1e-6 if kind > 0.95 else 1.0
                points.append(points[-1] + rng.normal(size=len(self.axes)) * size * far)
        inner = np.sort(rng.uniform(0.0, 1.0, count - degree - 1))
        if len(inner) > 1 and rng.random() < 0.4:
            i = int(rng.integers(len(inner) - 1))
            inner[i : i + int(rng.integers(2, degree + 2))] = inner[i]
        if len(inner) > 1 and rng.random() < 0.1:
            inner[1] = inner[0] + 1e-6
        inner = np.sort(inner).round(9)
        if len(inner) and (
            np.unique(inner, return_counts=True)[1].max() > degree or inner[0] <= 0.0 or inner[-1] >= 1.0
        ):
            return
        spread = math.log(5.0) if rng.random() < 0.5 else 0.0
        weights = np.exp(rng.uniform(-spread, spread, count))
        self.add(
            Nurbs(
                tuple(tuple(point.tolist()) for point in points[1:]),
                tuple(weights.tolist()),
                (0.0,) * (degree + 1) + tuple(inner.tolist()) + (1.0,) * (degree + 1),
                degree,
                self.feed,
            )
        )

    def spline(self) -> None:
        if not {"X", "Y"} <= set(self.axes) or self.program.dialect == "fanuc":
            return
        size = self.size * logarithmic(self.rng, 1e-2, 1.0)
        x = (self.rng.normal(size=(3, 2)) * size).tolist()
        inner = tuple(map(tuple, x[1:] if self.rng.random() < 0.6 else x[1:2]))
        self.add(Spline(tuple(x[0]), inner, self.feed))

    def event(self) -> None:
        if self.rng.random() < 0.3:
            self.add(Word(dwell_s=float(self.rng.choice([0.0, 0.01, 0.0123]))))
        else:
            self.add(Word(str(self.rng.choice(EVENTS))))

    def loop(self) -> None:
        body: list[Move | Arc] = []
        for _ in range(int(self.rng.integers(1, 6))):
            arc = self.drawn_arc() if self.rng.random() < 0.3 else None
            by = self.spread(self.size * logarithmic(self.rng, 1e-3, 0.3))
            body.append(replace(arc, feed=self.feed) if arc else Move(by, self.feed))
        kind = "repeat" if self.rng.random() < 0.5 else "call"
        self.add(Loop(int(self.rng.integers(1, 6)), tuple(body), kind))  # type: ignore[arg-type]

    def drawn(self, most: int) -> Program:
        """Return a program of fewer elements than `most`, chains not counted."""
        kinds: dict[Callable[[], None], float] = {
            self.line: 0.24,
            self.rotary: 0.06,
            self.traverse: 0.05,
            self.nothing: 0.04,
            self.tiny: 0.05,
            self.crumb: 0.06,
            self.return_: 0.05,
            self.onward: 0.05,
            self.arc: 0.15,
            self.chain: 0.10,
            self.nurbs: 0.07,
            self.spline: 0.03,
            self.event: 0.06,
            self.loop: 0.03,
        }
        weights = np.array(list(kinds.values()))
        self.new_mode()
        for _ in range(int(self.rng.integers(1, most))):
            if self.rng.random() < 0.15:
                self.feed = self.new_feed()
            if self.rng.random() < 0.07 and not self.one_mode:
                self.new_mode()
            if self.rng.random() < 0.05:
                self.add(Distances("G90" if self.to.incremental else "G91"))
            list(kinds)[int(self.rng.choice(len(kinds), p=weights / weights.sum()))]()
        return replace(self.program, elements=tuple(self.elements))


def random_case(
    seed: int,
    linear: bool = False,
    one_mode: bool = False,
    digits: bool = False,
    most: int = 30,
    rig: Rig | None = None,
) -> Case:
    """Draw a case by its seed.

    Args:
        seed: Of the draw.
        linear: Without rotary axes.
        one_mode: With one path mode throughout.
        digits: Written with all digits of its numbers, in mm.
        most: Elements.
        rig: The machine, and so the axes; None: any.
    """
    rng = np.random.default_rng((20, seed))
    sets = [axes for axes in AXES if not linear or set(axes) <= LINEAR]
    axes = sets[int(rng.integers(len(sets)))]
    size = logarithmic(rng, 0.03, 100.0)
    if rig:
        axes = "".join(rig.limits)
    rig = rig or random_rig(rng, axes, size)
    unit = INCH_MM if rng.random() < 0.25 else 1.0
    decimals = int(rng.choice([4, 6, 6, 7, 9]))
    dialect: Dialect = "fanuc" if rng.random() < 0.15 else "linuxcnc"
    far = rng.random() < 0.08 and set(axes) <= set("XYZABC")
    start = tuple((rng.choice([-1000.0, 0.0, 1000.0], size=len(axes)) / unit).tolist()) if far else ()
    program = Program(axes, (), 1.0 if digits else unit, None if digits else decimals, dialect, start)
    program = Drawer(rng, program, rig, size / program.unit, one_mode).drawn(most)
    return Case(program, rig)

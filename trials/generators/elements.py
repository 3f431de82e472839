"""Elements of programs that say what path they mean: each writes its blocks and the curves that they are. Made apart from cncgen.

Elements hold increments, so a program can be written again with elements left out, cut in parts, backwards, or in another unit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

Floats = NDArray[np.float64]
Dialect = Literal["linuxcnc", "fanuc"]

LINEAR = frozenset("XYZUVW")
INCH_MM = 25.4
#: Samples of a curve; distances that count are measured on the curve itself.
FINEST = 20_000


@dataclass(frozen=True)
class Feed:
    """How fast a motion is asked to go: `value` in units a minute, or the time of the motion in s; a traverse has none."""

    kind: Literal["minute", "time", "traverse"]
    value: float = 0.0


@dataclass(frozen=True)
class Piece:
    """A motion as it is meant.

    Attributes:
        curve: From u in 0 to 1, shape (n,), to the place, shape (n, axes), mm and degrees.
        u: Where to sample it: lines between these places are within a few hundredths of the tolerance of the curve.
        tolerance: Of the path mode in force; None: the machine's.
        exact: Whether the motion stays on the curve, but for chords of setpoints.
        stop: Whether it ends at rest.
        feed: As in the program, mm or degrees a minute.
    """

    curve: Callable[[Floats], Floats]
    u: Floats
    tolerance: float | None
    exact: bool
    stop: bool
    feed: Feed

    @property
    def points(self) -> Floats:
        """Samples, shape (n, axes)."""
        return self.curve(self.u)


class Element(Protocol):
    """A part of a program."""

    def write(self, to: Writer) -> None:
        """Append blocks, and the pieces that they mean."""

    def split(self, rng: np.random.Generator) -> Sequence[Element]:
        """Return the same motion in parts."""

    def backwards(self) -> Element:
        """Return the motion from its end to its start."""


@dataclass
class Writer:
    """A program that is being written, and where it has led.

    Attributes:
        unit: Millimetres in a unit of length.
        decimals: Of coordinates; None: as many as it takes.
        at: Shape (axes,), in the program's units (and degrees).
        waits: Seconds of all dwells.
    """

    axes: str
    unit: float
    decimals: int | None
    dialect: Dialect
    at: Floats
    lines: list[str] = field(default_factory=list)
    pieces: list[Piece] = field(default_factory=list)
    subprograms: list[str] = field(default_factory=list)
    incremental: bool = False
    inverse: bool = False
    tolerance: float | None = None
    exact: bool = False
    stop: bool = False
    waits: float = 0.0
    loops: int = 0

    @property
    def scale(self) -> Floats:
        """Millimetres (degrees) in a unit of each axis, shape (axes,)."""
        return np.array([self.unit if letter in LINEAR else 1.0 for letter in self.axes])

    def emit(self, *words: str) -> None:
        """Append a block."""
        self.lines.append(" ".join(word for word in words if word))

    def number(self, value: float, decimals: int | None = None) -> str:
        """Write a number with the program's decimals, or those given."""
        decimals = self.decimals if decimals is None else decimals
        if decimals is None:
            return np.format_float_positional(value, trim="0")
        return f"{value:.{decimals}f}"

    def coordinates(self, by: Mapping[str, float], decimals: int | None = None) -> tuple[list[str], Floats]:
        """Return the words of a motion by so much, and where they lead."""
        words, end = [], self.at.copy()
        for letter, step in by.items():
            i = self.axes.index(letter)
            text = self.number(step if self.incremental else self.at[i] + step, decimals)
            end[i] = float(text) + (self.at[i] if self.incremental else 0.0)
            words.append(letter + text)
        return words, end

    def feed_words(self, feed: Feed) -> tuple[str, str, Feed]:
        """Return the words before and after a motion that set its feed, and the feed that these mean."""
        if feed.kind == "traverse":
            return "", "", feed
        before = ""
        if self.inverse != (feed.kind == "time"):
            self.inverse = feed.kind == "time"
            before = "G93" if self.inverse else "G94"
        text = f"{60.0 / feed.value if self.inverse else feed.value:.7f}"
        said = float(text)
        return before, "F" + text, replace(feed, value=60.0 / said if self.inverse else said)

    def add(
        self, curve: Callable[[Floats], Floats], u: Floats, end: Floats, feed: Feed, linear: bool
    ) -> None:
        """Append a piece; `curve` in the program's units."""
        scale = self.scale
        if feed.kind == "minute" and linear:
            feed = replace(feed, value=feed.value * self.unit)
        tolerance = None if self.tolerance is None else self.tolerance * self.unit
        self.pieces.append(Piece(lambda x: curve(x) * scale, u, tolerance, self.exact, self.stop, feed))
        self.at = end

    @property
    def finest(self) -> float:
        """Length that samples of curves are measured by, in the program's units."""
        return max(self.tolerance or 0.0, 1e-5)

    def text(self) -> str:
        """Return the program."""
        last = "M30" if self.subprograms else "M2"
        return "\n".join([*self.lines, last, *self.subprograms, ""])


# --- elements -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Move:
    """A straight motion by so much of each axis; by nothing, the block names the place where the machine stands."""

    by: Mapping[str, float]
    feed: Feed
    decimals: int | None = None

    def write(self, to: Writer) -> None:
        """Append the block."""
        before, after, feed = to.feed_words(self.feed)
        # A program with all digits has them here too: eight of them would end parts of a tiny move elsewhere.
        decimals = None if to.decimals is None else self.decimals
        words, end = to.coordinates(self.by or dict.fromkeys(to.axes, 0.0), decimals)
        to.emit(before, "G0" if feed.kind == "traverse" else "G1", *words, after)
        start = to.at
        linear = any(end[i] != start[i] for i, letter in enumerate(to.axes) if letter in LINEAR)
        to.add(lambda u: start + u[:, None] * (end - start), np.array([0.0, 1.0]), end, feed, linear)

    def split(self, rng: np.random.Generator) -> Sequence[Element]:
        """Cut it in one to three."""
        cuts = np.sort(rng.uniform(0.0, 1.0, int(rng.integers(0, 3))))
        shares = np.diff(np.concatenate([[0.0], cuts, [1.0]]))
        return [self.part(share) for share in shares] if self.by else [self]

    def part(self, share: float) -> Move:
        """Return a part of the motion, in its share of the time."""
        feed = self.feed if self.feed.kind != "time" else replace(self.feed, value=share * self.feed.value)
        return Move({letter: share * step for letter, step in self.by.items()}, feed, self.decimals)

    def backwards(self) -> Element:
        """Return the way back."""
        return replace(self, by={letter: -step for letter, step in self.by.items()})


#: Per plane: code, letters of its axes in the sense of rotation, letters of the centre.
PLANES = {"XY": ("G17", "IJ"), "ZX": ("G18", "KI"), "YZ": ("G19", "JK")}


@dataclass(frozen=True)
class Arc:
    """An arc or helix.

    Attributes:
        plane: Of `PLANES`.
        radius: In the program's units.
        start: Angle of the start seen from the centre, in the plane.
        sweep: Angle gone through, positive from the plane's first axis to its second.
        by: Motion of other axes meanwhile.
        word: What says the circle: its centre, or R.
    """

    plane: str
    radius: float
    start: float
    sweep: float
    by: Mapping[str, float]
    feed: Feed
    word: Literal["centre", "radius"] = "centre"
    decimals: int | None = None

    @property
    def circle(self) -> bool:
        """Whether it ends where it starts, seen along the plane's normal."""
        turns = abs(self.sweep) / (2.0 * math.pi)
        return abs(turns - round(turns)) < 1e-12

    def write(self, to: Writer) -> None:
        """Append the block, or nothing where rounding leaves no circle."""
        i, j = to.axes.index(self.plane[0]), to.axes.index(self.plane[1])
        out = self.radius * np.array([math.cos(self.start), math.sin(self.start)])
        turned = self.start + self.sweep
        step = self.radius * np.array([math.cos(turned), math.sin(turned)]) - out
        by = {} if self.circle else dict(zip(self.plane, step, strict=True))
        words, end = to.coordinates(by | dict(self.by), self.decimals)
        found = self._centre(to, (i, j), end, -out)
        if found is None:
            return
        centre, circle = found
        radii = to.at[[i, j]] - centre, end[[i, j]] - centre
        sizes = [float(np.hypot(*r)) for r in radii]
        if min(sizes) <= 0.0 or abs(sizes[0] - sizes[1]) > 5e-4 * max(sizes):
            return
        before, after, feed = to.feed_words(self.feed)
        turns = int(abs(self.sweep) / (2.0 * math.pi) - 1e-9)
        more = f"P{turns + 1}" if turns else ""
        to.emit(
            PLANES[self.plane][0], before, "G3" if self.sweep > 0.0 else "G2", *words, *circle, more, after
        )
        to.add(*self._piece(to, (i, j), centre, radii, end, turns), end, feed, True)

    def _centre(
        self, to: Writer, plane: tuple[int, int], end: Floats, offset: Floats
    ) -> tuple[Floats, list[str]] | None:
        """Return the centre in the plane, and the words that say it."""
        at = to.at[list(plane)]
        if self.word == "centre":
            said = [to.number(x, self.decimals) for x in offset]
            letters = PLANES[self.plane][1]
            return at + [float(x) for x in said], [
                letter + x for letter, x in zip(letters, said, strict=True)
            ]
        text = to.number(math.copysign(self.radius, math.pi - abs(self.sweep)), self.decimals)
        radius, chord = abs(float(text)), end[list(plane)] - at
        length = float(np.hypot(*chord))
        if not 1e-3 * radius < length < 1.9999 * radius:
            return None
        side = math.copysign(1.0, self.sweep) * math.copysign(1.0, math.pi - abs(self.sweep))
        height = math.sqrt(radius**2 - 0.25 * length**2)
        return at + 0.5 * chord + side * height / length * np.array([-chord[1], chord[0]]), ["R" + text]

    def _piece(
        self,
        to: Writer,
        plane: tuple[int, int],
        centre: Floats,
        radii: tuple[Floats, Floats],
        end: Floats,
        turns: int,
    ) -> tuple[Callable[[Floats], Floats], Floats]:
        start, (first, last) = to.at, (math.atan2(r[1], r[0]) for r in radii)
        sizes = np.hypot(*radii[0]), np.hypot(*radii[1])
        sign = math.copysign(1.0, self.sweep)
        sweep = sign * ((sign * (last - first)) % (2.0 * math.pi))
        if self.circle:
            sweep = sign * 2.0 * math.pi
        sweep += sign * 2.0 * math.pi * turns

        def curve(u: Floats) -> Floats:
            x = start + u[:, None] * (end - start)
            size = sizes[0] + u * (sizes[1] - sizes[0])
            x[:, plane[0]] = centre[0] + size * np.cos(first + u * sweep)
            x[:, plane[1]] = centre[1] + size * np.sin(first + u * sweep)
            return x

        fine = abs(sweep) * math.sqrt(sizes[0] / (8.0 * 0.02 * to.finest))
        return curve, np.linspace(0.0, 1.0, int(np.clip(fine, 16, FINEST)) + 1)

    def split(self, rng: np.random.Generator) -> Sequence[Element]:
        """Cut it in one to three; what would be left out (`_centre`), as a whole or of the parts, leaves it whole."""
        cuts = np.sort(rng.uniform(0.0, 1.0, int(rng.integers(0, 3))))
        ends = np.concatenate([[0.0], cuts, [1.0]])
        sweeps = self.sweep * np.append(np.diff(ends), 1.0)
        chords = 2.0 * np.abs(np.sin(0.5 * sweeps))
        if np.diff(ends).min() * abs(self.sweep) < 0.05 or (
            self.word == "radius" and not ((chords > 1.1e-3) & (chords < 1.9998)).all()
        ):
            return [self]
        return [
            replace(
                self,
                start=self.start + a * self.sweep,
                sweep=(b - a) * self.sweep,
                by={letter: (b - a) * step for letter, step in self.by.items()},
                feed=self.feed
                if self.feed.kind != "time"
                else replace(self.feed, value=(b - a) * self.feed.value),
            )
            for a, b in pairwise(ends)
        ]

    def backwards(self) -> Element:
        """Return the way back."""
        by = {letter: -step for letter, step in self.by.items()}
        return replace(self, start=self.start + self.sweep, sweep=-self.sweep, by=by)


def sampled_spans(breaks: Floats, most: int = 1500) -> Floats:
    """Return places in every span, the breaks among them, scaled to 0 to 1."""
    spans = [np.linspace(a, b, most, endpoint=False) for a, b in pairwise(breaks) if b > a]
    u = np.concatenate([*spans, [breaks[-1]]])
    return (u - u[0]) / (u[-1] - u[0])


@dataclass(frozen=True)
class Nurbs:
    """A curve of G6.2: control points as steps from the place where it starts, shape (n - 1, axes), weights and knots."""

    steps: tuple[tuple[float, ...], ...]
    weights: tuple[float, ...]
    knots: tuple[float, ...]
    degree: int
    feed: Feed
    decimals: int | None = None

    def write(self, to: Writer) -> None:
        """Append its blocks, in coordinates; before them a line to the nearest place that has so many decimals."""
        was, to.incremental = to.incremental, False
        if was:
            to.emit("G90")
        rest = dict.fromkeys(to.axes, 0.0)
        if (to.coordinates(rest, self.decimals)[1] != to.at).any():
            Move(rest, self.feed, self.decimals).write(to)
        before, after, feed = to.feed_words(self.feed)
        start = to.at
        knots = np.array([float(f"{k:.9f}") for k in self.knots])
        weights = np.array([float(f"{w:.5f}") for w in self.weights])
        points = [start]
        for i, step in enumerate([(0.0,) * len(to.axes), *self.steps]):
            words, point = to.coordinates(
                {x: a + b - c for x, a, b, c in zip(to.axes, start, step, to.at, strict=True)}, self.decimals
            )
            points[i:] = [point]
            head = f"{before} G6.2 P{self.degree + 1} " if i == 0 else ""
            to.emit(head.strip(), f"K{knots[i]:.9f}", *words, f"R{weights[i]:.5f}", after if i == 0 else "")
        for knot in knots[len(points) :]:
            to.emit(f"K{knot:.9f}")
        control = np.array(points)
        breaks = np.unique(knots)
        last = np.nextafter(breaks[-1], -np.inf)

        def curve(u: Floats) -> Floats:
            k = np.minimum(breaks[0] + u * (breaks[-1] - breaks[0]), last)
            w = BSpline(knots, weights, self.degree)(k)
            x = BSpline(knots, control * weights[:, None], self.degree)(k) / w[:, None]
            x[u >= 1.0] = control[-1]
            return np.asarray(x)

        linear = any(letter in LINEAR for letter in to.axes)
        to.add(curve, sampled_spans(breaks), control[-1], feed, linear)
        to.incremental = was
        if was:
            to.emit("G91")

    def split(self, rng: np.random.Generator) -> Sequence[Element]:
        """Leave it whole."""
        return [self]

    def backwards(self) -> Element:
        """Return the way back."""
        points = np.array([(0.0,) * len(self.steps[0]), *self.steps])[::-1]
        knots = np.array(self.knots)
        return replace(
            self,
            steps=tuple(map(tuple, (points - points[0])[1:].tolist())),
            weights=self.weights[::-1],
            knots=tuple((knots[0] + knots[-1] - knots)[::-1].tolist()),
        )


@dataclass(frozen=True)
class Spline:
    """G5, a cubic in X Y with the control points `inner` (from the start, and from the end), or G5.1, a parabola with one."""

    by: tuple[float, float]
    inner: tuple[tuple[float, float], ...]
    feed: Feed
    decimals: int | None = None

    def write(self, to: Writer) -> None:
        """Append its block."""
        before, after, feed = to.feed_words(self.feed)
        words, end = to.coordinates(dict(zip("XY", self.by, strict=True)), self.decimals)
        texts = [[to.number(x, self.decimals) for x in point] for point in self.inner]
        letters = ("IJ", "PQ")[: len(texts)]
        offsets = [
            c + x for pair, text in zip(letters, texts, strict=True) for c, x in zip(pair, text, strict=True)
        ]
        to.emit("G17", before, "G5" if len(texts) == 2 else "G5.1", *words, *offsets, after)
        plane = [to.axes.index("X"), to.axes.index("Y")]
        start = to.at
        control = [start[plane]]
        for text, corner in zip(texts, (start, end), strict=False):
            control.append(corner[plane] + [float(x) for x in text])
        control.append(end[plane])

        def curve(u: Floats) -> Floats:
            x = start + u[:, None] * (end - start)
            rows = [np.repeat(point[None], len(u), axis=0) for point in control]
            while len(rows) > 1:  # de Casteljau
                rows = [a + u[:, None] * (b - a) for a, b in pairwise(rows)]
            x[:, plane] = rows[0]
            return x

        to.add(curve, np.linspace(0.0, 1.0, 3001), end, feed, True)

    def split(self, rng: np.random.Generator) -> Sequence[Element]:
        """Leave it whole."""
        return [self]

    def backwards(self) -> Element:
        """Return the way back."""
        (x, y), inner = self.by, self.inner
        if len(inner) == 1:
            inner = ((inner[0][0] - x, inner[0][1] - y),)
        return replace(self, by=(-x, -y), inner=inner[::-1])


@dataclass(frozen=True)
class Word:
    """A block that moves nothing: `text`, or a dwell of so many seconds."""

    text: str = ""
    dwell_s: float = 0.0

    def write(self, to: Writer) -> None:
        """Append the block."""
        if self.text:
            to.emit(self.text)
        else:
            to.emit(f"G4 {'X' if to.dialect == 'fanuc' else 'P'}{self.dwell_s:.6f}")
            to.waits += float(f"{self.dwell_s:.6f}")

    def split(self, rng: np.random.Generator) -> Sequence[Element]:
        """Leave it whole."""
        return [self]

    def backwards(self) -> Element:
        """Return itself."""
        return self


@dataclass(frozen=True)
class Mode(Word):
    """A path mode; `tolerance` (P of G64) in the program's units."""

    tolerance: float | None = None

    def write(self, to: Writer) -> None:
        """Append the block."""
        said = "" if self.tolerance is None else f"{self.tolerance:.9f}"
        to.emit(self.text, "P" + said if said else "")
        to.exact = self.text != "G64"
        to.stop = self.text == "G61.1" or (self.text == "G61" and to.dialect == "fanuc")
        to.tolerance = float(said) if said else (0.0 if to.exact else None)


@dataclass(frozen=True)
class Distances(Word):
    """Whether coordinates or increments follow: G90, G91."""

    def write(self, to: Writer) -> None:
        """Append the block."""
        to.incremental = self.text == "G91"
        to.emit(self.text)


@dataclass(frozen=True)
class Loop:
    """Moves and arcs in increments, run several times by a loop or a subprogram."""

    count: int
    body: tuple[Move | Arc, ...]
    kind: Literal["repeat", "call"]

    def write(self, to: Writer) -> None:
        """Append the loop, and the pieces of every round."""
        to.loops += 1
        name, lines, was = 100 + to.loops, to.lines, to.incremental
        rounds = []
        for _ in range(self.count):
            to.lines, to.incremental, to.inverse = [], True, False
            to.emit("G91 G94")
            for element in self.body:
                element.write(to)
            rounds.append(to.lines)
        to.lines, to.incremental = lines, was
        body = rounds[0]
        if any(other != body for other in rounds):
            raise AssertionError("a round of a loop is written otherwise than the first")
        if to.dialect == "fanuc":
            to.emit(f"M98 P{name} L{self.count}")
            to.subprograms += [f"O{name}", *body, "M99"]
        elif self.kind == "repeat":
            to.lines += [f"o{name} repeat [{self.count}]", *body, f"o{name} endrepeat"]
        else:
            to.lines += [f"o{name} sub", *body, f"o{name} endsub", *[f"o{name} call"] * self.count]
        if not was:
            to.emit("G90")

    def split(self, rng: np.random.Generator) -> Sequence[Element]:
        """Split what it repeats."""
        parts = [part for element in self.body for part in element.split(rng)]
        return [replace(self, body=tuple(parts))]  # type: ignore[arg-type]

    def backwards(self) -> Element:
        """Return the way back."""
        return replace(self, body=tuple(element.backwards() for element in self.body[::-1]))  # type: ignore[misc]

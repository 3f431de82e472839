"""Statements of a program in plain language that draw contours: corners, CT, APPR and DEP, free contours."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

from cncgen.diagnostics import Severity
from cncgen.gcode.block import AXIS_INDEX, Own
from cncgen.gcode.codes.plain_language import Plain
from cncgen.gcode.errors import BlockError
from cncgen.gcode.klartext import contours, free_contours
from cncgen.gcode.klartext.executing import Execution, in_order
from cncgen.gcode.klartext.program_text import UNREAD, Frame
from cncgen.gcode.sinks.sink import Point
from cncgen.gcode.text import plain_language
from cncgen.gcode.text.plain_language import Statement

#: Codes of lines and arcs, to which a contour is approached and which corners join.
_DRAWN = frozenset(
    number / 10.0 for number in (0, 10, Own.CIRCLE, Own.RADIUS_ARC, Own.POLAR_ARC, Own.POLAR_LINE)
)


class ContourLines(Execution):
    """A run, as far as it draws."""

    def _prepare(self) -> None:
        super()._prepare()
        #: The pole of free contours, and the line behind the one that is read.
        self._pole: complex | None = None
        self._beyond = 0

    def _corner_after(self, at: int) -> dict[str, float]:
        """Return the corner RND or CHF that the next line puts at the end of this one, and its feed."""
        following = self._following(at)
        statement = self._ahead(following) if following is not None else UNREAD
        if statement.kind != "corner":
            return {}
        kind, size, feed = statement.data
        return {",r" if kind == "RND" else ",c": self._now(size), "corner_f": self._now(feed)}

    def do_corner(self, frame: Frame, at: int, statement: Statement) -> None:
        kind = statement.data[0]
        before = next((k for k in range(at - 1, -1, -1) if frame.program.lines[k].body), None)
        if before is None or not self._draws(before):
            message = f"{kind} has no element of a contour before it"
            raise BlockError("corner-motion", message, kind, hint="an L or C block leads to the corner")

    def _draws(self, at: int) -> bool:
        """Tell whether a line is an element of a contour, or is not read."""
        statement = self._ahead(at)
        return statement.kind in ("tangent", "free", UNREAD.kind) or is_drawn(statement)

    def do_tangent(self, frame: Frame, at: int, statement: Statement) -> None:
        """CT X Y, CTP PR PA: an arc that goes on in the direction before."""
        block = self._block(at, statement.words)
        if statement.data[0]:
            contours.take_polar_end(self.ip, block.words)
        side = tuple(number for number in block.g if number in (410, 420))
        if side or self.ip.guard is not None:
            self._execute(block.beside({}, side))
        end, centre, sense = contours.tangent_arc(self.ip, block.words)
        if "dr" in block.words:
            message = "DR stands beside CT, whose sense of rotation is that of the element before"
            raise BlockError("unused-word", message, "DR", hint="C and CR have DR")
        words = {"xyzabcuvw"[k]: end[k] for k in range(9) if end[k] != self.ip.state.position[k]}
        rest = {letter: value for letter, value in block.words.items() if letter not in AXIS_INDEX}
        block.words, block.g = {**rest, **words, "dr": float(sense)}, (Own.CIRCLE, *block.g)
        plain = Plain.of(self.ip)
        pole, plane = plain.pole, plain.plane
        plain.pole, plain.plane = centre, 17
        try:
            self._execute_whole(at, statement.marks, block)
        finally:
            plain.pole, plain.plane = pole, plane

    def do_way(self, frame: Frame, at: int, statement: Statement) -> None:
        """APPR and DEP."""
        kind, form, words = statement.data
        way = contours.way_of(kind, form, words, self._now)
        functions = self._block(at, plain_language.meant(way.functions))
        called = self._calls(functions)
        first, *late = in_order(functions, moves=True, calls=called)
        here = self._here(at)
        self._execute(here)
        self._execute(first)
        if way.kind == "APPR":
            contours.approach(self.ip, way, here, self._leads(at))
        else:
            contours.departure(self.ip, way, here)
        if called:
            self._call_cycle(here)
        for part in late:
            self._execute(part)

    def _leads(self, at: int) -> Callable[[Point], complex | None] | None:
        """Return what gives the direction in which the first element behind APPR leaves a point, past corners and poles, which are taken."""
        for following, statement in self._behind(at):
            if statement.kind in ("free", "select"):
                elements = self._elements(following)
                if elements:
                    return partial(free_contours.first_heading, elements)
            elif is_pole(statement):
                self._plain(following, statement)
            elif statement.kind not in ("corner", "label"):
                return partial(self._heading, following, statement) if is_drawn(statement) else None
        return None

    def _behind(self, at: int) -> Iterator[tuple[int, Statement]]:
        """Yield the lines behind one, and what they say."""
        following = self._following(at)
        while following is not None:
            yield following, self._ahead(following)
            following = self._following(following)

    def _heading(self, at: int, statement: Statement, start: Point) -> complex | None:
        return contours.first_heading(self.ip, start, partial(self._block, at, statement.words))

    def _elements(self, at: int) -> list[free_contours.Element]:
        elements: list[free_contours.Element] = []
        pole = self._pole
        following: int | None = at
        while following is not None:
            statement = self._ahead(following)
            if statement.kind == "select":
                if not elements:
                    message = "FSELECT has no element before it whose solution it chooses"
                    hint = "it stands behind FL, FLT, FC or FCT"
                    raise BlockError("free-contour", message, "FSELECT", hint=hint)
                elements[-1].select = statement.data[0]
            elif statement.kind == "free":
                head, words = statement.data
                element = free_contours.element_of(head, words, following, self._now, self._number(following))
                if head == "FPOL":
                    pole = complex(element.values.get("X", 0.0), element.values.get("Y", 0.0))
                else:
                    element.pole = pole
                    elements.append(element)
            elif statement.kind != "corner":
                break
            following = self._following(following)
        self._beyond = len(self._lines) if following is None else following
        self._pole = pole
        return elements

    def _known(self, number: int) -> free_contours.Known | None:
        """Return end and direction of the motion that a block of the text made last."""
        ends = self.frames[-1].program.ends
        return next((ends[k] for k in sorted(ends, reverse=True) if self._number(k) == number), None)

    def do_free(self, frame: Frame, at: int, statement: Statement) -> None:
        """FPOL, FL, FLT, FC, FCT: a free contour, as lines and arcs."""
        plain, state = Plain.of(self.ip), self.ip.state
        try:
            elements = self._elements(at)
        finally:
            frame.at = max(frame.at, self._beyond)
        start = complex(state.position[0], state.position[1])
        chain = free_contours.Chain(elements, start, plain.heading, self._known)
        for element, segment in zip(elements, chain.solve(), strict=True):
            count = next((most for one, most in chain.chosen if one is element), 0)
            free_contours.check_data(element, segment)
            block = self._block(element.at, plain_language.line(element.rest))
            block.words |= {"x": segment.end.real, "y": segment.end.imag}
            if segment.centre is not None:
                spoke = segment.centre - segment.start
                block.words |= {"i": spoke.real, "j": spoke.imag}
            fast = any(name == "FMAX" for name, _ in element.rest)
            if fast and segment.spin:
                raise BlockError("syntax", "this is no traverse: FMAX", "FMAX", hint="F gives its feed")
            block.g = (*block.g, {0: 0 if fast else 10, 1: 30, -1: 20}[segment.spin])
            if count:
                self._enter(self._lines[element.at])
                self.ip.remark(free_contours.choice_of(element, segment, count), Severity.WARNING)
            self._execute_whole(element.at, plain_language.marks_of(element.rest), block)
            plain.heading = segment.heading(segment.end)
            frame.program.ends[element.at] = segment.end, plain.heading

    do_select = do_free


def is_drawn(statement: Statement) -> bool:
    """Tell whether a block is a line or an arc."""
    return statement.kind == "block" and any(word[0] == "g" and word[1] in _DRAWN for word in statement.words)


def is_pole(statement: Statement) -> bool:
    """Tell whether a block is CC."""
    return ("g", Own.POLE / 10.0) in statement.words

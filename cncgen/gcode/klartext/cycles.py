"""Cycles of Heidenhain's plain language: their values are the Q parameters that follow CYCL DEF.

Q200 set-up clearance, Q201 depth (its sign is the direction), Q203 surface, Q204 second clearance, Q206 feed downwards, Q202 infeed. A row
of `ROWS` lists the parameters that a cycle reads. The program is warned of others that it gives, and of those that it leaves out.
The rows follow the TNC 640's cycles. The lists of 21 to 25, 251 to 254, 256 and 257 were compared with a text that cites its manual of 2017, the others
with none.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

from cncgen.gcode.block import Block
from cncgen.gcode.codes.flat_cutter import FlatCutter
from cncgen.gcode.codes.places import in_rows, on_circle
from cncgen.gcode.codes.plain_language import Plain
from cncgen.gcode.codes.steps import MOST
from cncgen.gcode.errors import BlockError, refuse
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.klartext import (
    contour_cycles,
    drilling,
    engraving,
    finishing,
    older_cycles,
    polygon_stud,
    programs,
    slots,
    studs,
    threads,
    trochoids,
)
from cncgen.gcode.klartext.hole_cycle import FASTEST, HoleCycle, lent


class Told(NamedTuple):
    """A parameter that is read at one value alone: that, what is done at each other one, and the diagnostic of it."""

    neutral: float
    done: str
    code: str = "cycle-parameters"


class CycleRow(NamedTuple):
    """The parameters of a cycle, and the function that runs it.

    Attributes:
        run: What runs it where the tool is; None where it is data, or a pattern, which runs at once.
        reads: The Q parameters that it reads.
        idle: Those that change no motion: angles of the spindle, coolant, and what counts under others that are not read alone.
        told: Those that are read at one value alone.
        lacking: What parameters are on controls whose cycle lacks them; those that no control has end what another cycle has set.
        free: Whether it finds its heights by itself.
    """

    run: Callable[..., None] | None
    reads: str
    idle: str = ""
    told: Mapping[int, Told] = {}
    lacking: Mapping[int, float] = {}
    free: bool = False


_TIP = {
    395: Told(
        0.0, "it counts the depth from the width of the drill on, and the tip goes there", "tool-assumed"
    )
}
_STRAIGHT = {366: Told(0.0, "the tool plunges straight down at Q206")}
_EDGE = {439: Told(0.0, "F is the feed of the tool's centre")}
_POCKET = "215 368 207 351 201 202 369 206 338 200 203 204 385"
_STUD = "368 207 351 201 202 206 200 203 204 370 215 369 338 385"
#: Newer controls finish studs; before, Q368 was left.
_ROUGH = {215: 1.0, 369: 0.0, 338: 0.0, 385: 0.0}
_FRONT = "358 359 200 203 204"
_REST = {
    18: Told(
        0.0, "the contour is cut as a whole, since the rest of that tool is not computed", "contour-cleared"
    )
}
_FINISHING = "200 201 206 202 207 203 204 216 217"
_OLD_SLOT = "219 201 207 202 215 200 203 204 216 217 338 206"
#: By number, the cycles that are read whose values are Q parameters.
ROWS: dict[int, CycleRow] = {
    20: CycleRow(None, "1 2 3 4 5 6 7 8 9"),
    21: CycleRow(contour_cycles.pilot, "10 11 13"),
    22: CycleRow(contour_cycles.rough, "10 11 12 208", "404", {19: Told(0.0, "the tool plunges straight down at Q11"), **_REST,
        401: Told(100.0, "F stays Q12 where the tool cuts its whole width")}, {208: FASTEST}),
    23: CycleRow(contour_cycles.floor, "11 12 208", lacking={208: FASTEST}),
    # 438 is the tool that roughed, from which the control finds where the way on begins.
    24: CycleRow(contour_cycles.side, "9 10 11 12 14", "438", lacking={14: 0.0}),
    25: CycleRow(contour_cycles.train, "1 3 5 7 10 11 12 15", "446 447 448", _REST),
    200: CycleRow(drilling.drill, "200 201 206 202 210 203 204 211", "", _TIP),
    201: CycleRow(drilling.ream, "200 201 206 211 208 203 204"),
    202: CycleRow(drilling.bore, "200 201 206 211 208 203 204 214 357", "336", lacking={357: -1.0}),
    203: CycleRow(drilling.universal, "200 201 206 202 210 203 204 212 213 205 211 208 256", "", _TIP, {208: 0.0, 256: 0.0}),
    204: CycleRow(drilling.back_bore, "200 249 250 251 252 253 254 255 203 204 214", "336"),
    205: CycleRow(drilling.peck, "200 201 206 202 203 204 212 205 258 259 257 256 211 379 253 208", "", _TIP, {208: FASTEST, 379: 0.0, 253: 0.0}),
    206: CycleRow(drilling.tap_floating, "200 201 206 211 203 204"),
    207: CycleRow(drilling.tap, "200 201 239 203 204"),
    # 342 tells that a hole may be wider than twice the tool.
    208: CycleRow(drilling.bore_milling, "200 201 206 334 203 204 335 351", "342", {370: Told(0.0, "one helix along the wall mills the hole")}, {351: 1.0}),
    209: CycleRow(drilling.tap_breaking, "200 201 239 203 204 257 256 403", "336", lacking={403: 0.0}),
    # 253 leads to the diameter of a hole that is there already, 342.
    240: CycleRow(drilling.centre, "200 343 201 344 206 211 203 204", "253", {342: Told(0.0, "the tool centres from the surface on")}),
    # 429 and 430 switch coolant; 212 and 205 count for infeeds.
    241: CycleRow(drilling.single_lip, "200 201 206 211 203 204 379 253 208 426 427 428 435 401 202", "429 430 212 205", _TIP,
        {435: 0.0, 401: 0.0, 202: 0.0}),
    251: CycleRow(slots.rectangular_pocket, _POCKET + " 218 219 220 224 367 370", "", _STRAIGHT | _EDGE),
    252: CycleRow(slots.round_pocket, _POCKET + " 223 370", "", _STRAIGHT | _EDGE),
    253: CycleRow(slots.straight_slot, _POCKET + " 218 219 374 367", "", _STRAIGHT | _EDGE, {370: 0.0}),
    254: CycleRow(slots.bows, _POCKET + " 219 375 367 216 217 376 248 378 377", "", _STRAIGHT | _EDGE, {378: 0.0, 377: 1.0}),
    262: CycleRow(threads.mill, "335 239 201 355 253 351 200 203 204 207 512", lacking={512: 0.0}),
    263: CycleRow(threads.countersink_and_mill, "335 239 201 356 253 351 357 254 207 512 " + _FRONT, lacking={512: 0.0}),
    264: CycleRow(threads.drill_and_mill, "335 239 201 356 253 351 202 258 257 256 206 207 512 " + _FRONT, lacking={512: 0.0}),
    265: CycleRow(threads.downwards, "335 239 201 253 360 254 207 " + _FRONT, lacking={512: 0.0}),
    267: CycleRow(threads.mill_outside, "335 239 201 355 253 351 254 207 512 " + _FRONT, lacking={512: 0.0}),
    # TNC 426 has no Q206 here: all goes at Q207.
    210: CycleRow(finishing.slot, _OLD_SLOT + " 218 224", lacking={206: 0.0}),
    211: CycleRow(finishing.bow, _OLD_SLOT + " 244 245 248", lacking={206: 0.0}),
    212: CycleRow(finishing.rectangular_pocket, _FINISHING + " 218 219 220 221"),
    # The blanks, 221 and 222, say where the control begins: 3.5 radii of the tool beside the wall, which is done always.
    213: CycleRow(finishing.rectangular_stud, _FINISHING + " 218 219 220", "221"),
    214: CycleRow(finishing.round_pocket, _FINISHING + " 222 223"),
    215: CycleRow(finishing.round_stud, _FINISHING + " 223", "222"),
    220: CycleRow(None, "216 217 244 245 246 247 241 200 203 204 301 365", lacking={301: 1.0, 365: 0.0}),
    221: CycleRow(None, "225 226 237 238 242 243 224 200 203 204 301", lacking={301: 1.0}),
    # The letters are our own, and so is their font, 515; 517 is the radius of texts on an arc.
    225: CycleRow(engraving.engrave, "513 514 516 374 207 201 206 200 203 204 202 367 574", "515 517", lacking={202: 0.0, 367: 0.0, 574: 0.0}),
    230: CycleRow(studs.multipass, "225 226 227 218 219 240 206 207 209 200", lacking={204: 0.0}, free=True),
    231: CycleRow(studs.ruled, "225 226 227 228 229 230 231 232 233 234 235 236 240 207", lacking={200: 0.0, 204: 0.0}, free=True),
    232: CycleRow(studs.face, "389 225 226 227 386 218 219 202 369 370 207 385 253 200 357 204", lacking={215: 0.0}, free=True),
    # 220, 368 and 338 are those of walls.
    studs.FACE: CycleRow(studs.face_from_here, "215 389 350 218 219 227 386 369 202 370 207 385 253 357 200 204 347 348 349 367", "220 368 338",
        lacking={215: 0.0, 367: -1.0}, free=True),
    256: CycleRow(studs.rectangle, _STUD + " 218 424 219 425 220 224 367 437", lacking={437: 0.0, **_ROUGH}, free=True),
    257: CycleRow(studs.circle, _STUD + " 223 222 376", lacking={376: 0.0, **_ROUGH}, free=True),
    258: CycleRow(polygon_stud.polygon, _STUD + " 573 571 222 572 224 220", free=True),
    275: CycleRow(trochoids.slot, "215 219 368 436 207 351 201 202 206 338 385 200 203 204 369", "", _STRAIGHT | _EDGE, {369: 0.0}, free=True),
    contour_cycles.WAYS: CycleRow(None, "390 391 392 393 394"),
}  # fmt: skip
#: The cycle that chooses a preset, which no call runs.
PRESET = 247
_PRESET = CycleRow(None, "339")
PATTERNS = (220, 221)
#: Cycles that move nothing that is planned: orientation of the spindle; weighing the load, tuning by the machine's builder.
_IDLE = (13, 239, 332, 392)
READ = tuple(sorted((*older_cycles.PARTS, *ROWS, programs.CYCLE, 14)))
#: The cycle in force after one that is not read, whose calls tell nothing more.
_NOT_READ = -1
#: By number, the task of each cycle that is not read.
_UNREAD: tuple[tuple[Sequence[int], str], ...] = (

    ((271, 272, 273, 274, 277, *range(1271, 1283)), "contours in trochoids, OCM"), ((276,), "a contour train in space"),
    ((27, 28, 29, 39), "contours on the surface of a cylinder"), ((30,), "points of digitising"), ((285, 286, 287, 880), "gears"), ((291, 292), "turning by interpolation"),
    (range(400, 500), "probing, which TCH PROBE has"), (range(800, 900), "turning"), (range(1000, 1100), "grinding"),
)  # fmt: skip


def define(ip: Interpreter, number: int) -> None:
    """CYCL DEF: take the cycle that the calls run, which ends M89; a pattern calls the one before it, and M89 stays."""
    if number in _IDLE:
        message = f"cycle {number} moves no tool: passed over"
        ip.note("cycle-idle", message, "CYCL", "is it a cycle of the machine's builder?")
        return
    if number in contour_cycles.DATA:
        Plain.of(ip).train_ways |= number == contour_cycles.WAYS
        return
    plain = Plain.of(ip)
    plain.cycle, plain.modal = 0, plain.modal and number in PATTERNS
    if number not in READ:
        plain.cycle = _NOT_READ
        what = next((f" ({what})" for numbers, what in _UNREAD if number in numbers), "")
        hint = "write its moves as L blocks, or another cycle: docs/heidenhain.md lists those that are read"
        raise BlockError("unsupported-block", f"cycle {number}{what} is not read", "CYCL", hint=hint)
    plain.cycle = number
    if number in older_cycles.PARTS:
        plain.parts = {}


def take_part(ip: Interpreter, number: int, part: int, text: str) -> None:
    """CYCL DEF n.p behind the first part, which has defined the cycle."""
    cycle = Plain.of(ip).cycle
    if number in _IDLE or cycle == _NOT_READ:
        return
    message = f"CYCL DEF {number}.{part} is no part of the cycle that was defined"
    wrong = cycle != number or number not in older_cycles.PARTS
    refuse("CYCL", (wrong, "cycle-words", message, f"CYCL DEF {number}.0 stands before it"))
    older_cycles.take_part(ip, number, part, text)


def take_given(ip: Interpreter, number: int, given: Iterable[int]) -> None:
    """Take what a CYCL DEF gives: parameters that it leaves out are those of a control whose cycle lacks them; tell of others that it leaves
    out, and of those that the cycle has not."""
    row, named = _PRESET if number == PRESET else ROWS.get(number), set(given)
    if row is None:
        return
    for parameter, value in row.lacking.items():
        if parameter not in named:
            ip.parameters.set_number(float(parameter), value)
    for parameter, one in row.told.items():
        if parameter not in named:
            ip.parameters.set_number(float(parameter), one.neutral)
    q, reads = ip.parameters.numbers, {int(one) for one in row.reads.split()}
    # Cycle 225 is given its text beside them.
    beyond = sorted(named - reads - {int(one) for one in row.idle.split()} - row.told.keys())
    missing = sorted(reads - named - row.lacking.keys() - row.told.keys())
    if beyond:
        message = f"cycle {number} has no {_listed(beyond, q)} here: it is made as without"
        ip.warn_once("cycle-parameters", message, "CYCL", f"it reads {_named(sorted(reads))}")
    if missing:
        message = f"cycle {number} is given without {_named(missing)}: the values in force are taken, {_listed(missing, q)}"
        hint = "on the control, CYCL DEF is incomplete without them"
        ip.warn_once("cycle-parameters", message, "CYCL", hint)


def _named(numbers: Iterable[int]) -> str:
    return ", ".join(f"Q{number}" for number in numbers)


def _listed(numbers: Iterable[int], q: Sequence[float]) -> str:
    return ", ".join(f"Q{number} = {q[number]:g}" for number in numbers)


def _tell(ip: Interpreter, number: int, row: CycleRow) -> None:
    for parameter, one in row.told.items():
        if (value := ip.parameters.numbers[parameter]) != one.neutral:
            message = f"Q{parameter} = {value:g} of cycle {number} is not read: {one.done}"
            ip.warn_once(one.code, message, "CYCL", f"Q{parameter} = {one.neutral:g} leaves no doubt")


def call(ip: Interpreter, here: Block) -> None:
    """Run the cycle at the tool's place."""
    plain = Plain.of(ip)
    number, q, name = plain.cycle, ip.parameters.numbers, f"cycle {plain.cycle}"
    ip.sink.block = here
    if number == _NOT_READ:
        return
    if number == programs.CYCLE:
        message = "cycle 12 calls a program at the points of a pattern, or under M89: not read"
        raise BlockError("unsupported-block", message, "CYCL", hint="CYCL CALL and M99 call it")
    if number in older_cycles.PARTS:
        older_cycles.run(ip, number)
        return
    row = ROWS.get(number)
    if row is None or row.run is None:
        raise BlockError("cycle-missing", "no cycle to call", "M99", hint="CYCL DEF gives it before")
    levels = drilling.levels(number, q)
    depths = {"201", "356"}.intersection(row.reads.split())
    if levels is None and q[201] == 0.0 and depths == {"201"}:
        # "If you program the depth = 0, the cycle will not be executed." Of those with several depths one step is left out.
        message = f"cycle {number} has the depth Q201 = 0: it is not made"
        ip.warn("cycle-depth", message, "CYCL", "Q201 is below 0")
        return
    _tell(ip, number, row)
    if row.free:
        row.run(ip, name)
        return
    read = plain.contour or (lambda label: ([], 0))
    if number == contour_cycles.TRAIN:
        contour_cycles.train(ip, name, plain.labels, read)
        return
    of_contours = number in contour_cycles.RUN
    cycle = (
        contour_cycles.Contours(ip, name, plain.labels, read) if of_contours else HoleCycle(ip, name, levels)
    )
    row.run(cycle)
    cycle.end()


def pattern(ip: Interpreter, number: int, cycle: int, here: Block) -> None:
    """220 on a circle, 221 on lines: run the cycle that was defined before at each place.

    From one place to the next the tool goes at the set-up clearance (Q301 = 0) or at the second one (1), straight (Q365 = 0 of 220) or along
    the circle (1).
    """
    q = ip.parameters.numbers
    columns, lines = (q[241], 1.0) if number == 220 else (q[242], q[243])
    counted = columns >= 0.5 and lines >= 0.5 and columns * lines <= MOST
    refuse(
        "CYCL",
        (not cycle, "cycle-missing", f"cycle {number} has no cycle that it calls", "CYCL DEF 200 stands before"),
        (not counted, "cycle-repeats", f"cycle {number} has {columns * lines:g} places", "Q241, or Q242 and Q243, count them"),
    )  # fmt: skip
    across, down, centre, step = round(columns), round(lines), 0j, 0.0
    if number == 220:
        centre = complex(q[216], q[217])
        # The stopping angle is that of the last place, but of a whole circle.
        whole = abs(q[246] - q[245]) >= 360.0
        step = q[247] or (q[246] - q[245]) / max(1, across if whole else across - 1)
        places = on_circle(centre, q[244] / 2.0, q[245], step, across)
    else:
        way = cmath.rect(1.0, math.radians(q[224]))
        places = in_rows(complex(q[225], q[226]), way * q[237], way * 1j * q[238], across, down)
    Plain.of(ip).cycle = cycle
    cutter = FlatCutter(ip)
    for k, place in enumerate(places):
        ip.sink.block = here
        if k and number == 220 and round(q[365]) and q[244]:
            cutter.feed(FASTEST)
            cutter.arc(place, centre, 1 if step > 0.0 else -1)
            cutter.feed(ip.state.feed)
        else:
            ip.go([place.real, place.imag, *ip.state.position[2:]], rapid=True)
        with lent(q, {204: 0.0 if round(q[301]) == 0 and k < len(places) - 1 else q[204]}):
            call(ip, here)

"""Tilted working planes of FANUC: G68.2 turns the coordinates, G53.1 points the tool along their Z, G69 ends them (B-64484EN-2, 7.8).

Angles are Euler's, about Z, the new X, the new Z (I J K); with P1 they are those about the axes X Y Z of the workpiece, in the order of
Q; with P2 the plane has three points, with P3 the directions of its X and Z. On a machine with kinematics G53.1 turns the rotary axes
to the nearer pair of positions, and a turned table or head carries the plane (`affine`); without them a warning says that they stay.

Haas's mills have the same by G268 with Q123, G253 and G269, as posts for them write it: I J K are the angles about the axes X Y Z of the
workpiece, in this order.
"""

from __future__ import annotations

from functools import partial

from cncgen.gcode.block import AXES, Block
from cncgen.gcode.codes import affine, carried_planes
from cncgen.gcode.codes.table import Code
from cncgen.gcode.codes.tools import whole
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.state.modal import Stage
from cncgen.records import replace

_ORDERS = (123, 132, 213, 231, 312, 321)
_UNIT = affine.UNIT
#: Numbers Q of the first block and the last one of P2 (0 may be left out) and P3.
_FIRST, _LAST = {2: (0, 1), 3: (1,)}, {2: 3, 3: 2}
_HINT = "P2: Q1 the origin, Q2 towards X, Q3 on the side of Y; P3: Q1 X Y Z the origin and I J K along X, Q2 I J K along Z"
#: The code that turns the rotary axes into the plane of another one.
_ALIGNS = {"G68.2": "G53.1", "G268": "G253"}
#: Cosine up to which two directions count as square.
_SQUARE = 1e-3


def _matrix(block: Block) -> affine.Matrix:
    """Return the rotation; raise where the plane is given by points or vectors."""
    i, j, k = (block.words.get(letter, 0.0) for letter in "ijk")
    kind = whole(block, "p", "G68.2") if "p" in block.words else 0
    if kind == 0:
        steps = (affine.turn(2, i), affine.turn(0, j), affine.turn(2, k))
    elif kind == 1:
        order = whole(block, "q", "G68.2") if "q" in block.words else 0
        if order not in _ORDERS:
            message = f"Q{order} of G68.2 P1 is no order of the axes 1 2 3"
            hint = "Q123 turns about X, then Y, then Z"
            raise BlockError("plane-kind", message, "Q" if order else "P", hint=hint)
        turns = [affine.turn(int(axis) - 1, (i, j, k)[int(axis) - 1]) for axis in str(order)]
        steps = (turns[2], turns[1], turns[0])
    else:
        hint = "P0 takes Euler's angles, P1 those about X, Y and Z, P2 three points, P3 two directions"
        message = f"P{kind} of G68.2, a plane by the angles of its projections, is not read"
        raise BlockError("plane-kind", message, "P", hint=hint)
    return affine.product(steps[0], affine.product(steps[1], steps[2]))


def _vector(block: Block, letters: str) -> affine.Vector:
    x, y, z = (block.words.get(letter, 0.0) for letter in letters)
    return x, y, z


def _direction(vector: affine.Vector, what: str) -> affine.Vector:
    """Return a vector of length 1; raise where it has none."""
    message = f"{what} of G68.2 have no direction between them"
    return affine.unit(vector, BlockError("plane-points", message, "G68.2", hint=_HINT))


def _gathered(ip: Interpreter, block: Block) -> affine.Frame | None:
    """Take one of the blocks of G68.2 P2 or P3; return the frame once all are there.

    P2: Q1 is the origin, Q1 to Q2 the direction of X, Q3 on the side of Y; Q0 shifts the origin in the plane's own coordinates,
    and R turns about its Z. P3: Q1 has the origin and, I J K, the direction of X, Q2 that of Z.
    """
    kind, step = whole(block, "p", "G68.2"), whole(block, "q", "G68.2") if "q" in block.words else -1
    places = ip.plane_blocks
    begins = step in _FIRST[kind] and (step == _FIRST[kind][0] or set(places) != {(2, 0)})
    if begins:
        places.clear()
    if not begins and not (0 < step <= _LAST[kind] and _in_turn(list(places), kind, step)):
        message = f"G68.2 P{kind} Q{step} does not go on from the block before it"
        if step < 0:
            message = f"G68.2 P{kind} has no Q, which counts its blocks"
        raise BlockError("plane-points", message, "P", hint=_HINT)
    letters = "ijk" if kind == 3 else "xyz"
    places[kind, step] = _vector(block, letters)
    if kind == 3 and step == 1:
        ip.plane_origin = _vector(block, "xyz")
    ip.plane_turn = block.words.get("r", 0.0 if begins else ip.plane_turn)
    if step != _LAST[kind]:
        return None
    x, z, origin = _of_points(ip) if kind == 2 else _of_directions(ip)
    shift = places.get((2, 0), affine.NO_SHIFT)
    places.clear()
    axes = affine.Frame(affine.of_columns(x, affine.cross(z, x), z), origin)
    return axes.then(affine.Frame(affine.turn(2, ip.plane_turn), shift))


def _in_turn(places: list[tuple[int, int]], kind: int, step: int) -> bool:
    """Tell whether the blocks so far are those before one, from the first or the second on."""
    return bool(places) and sorted(places) == [(kind, k) for k in range(min(places)[1], step)]


def _of_points(ip: Interpreter) -> tuple[affine.Vector, affine.Vector, affine.Vector]:
    """Return the directions of X and Z and the origin of the plane through the points Q1 to Q3 of P2."""
    first, second, third = (ip.plane_blocks[2, k] for k in (1, 2, 3))
    x = _direction(_between(first, second), "the points Q1 and Q2")
    z = _direction(affine.cross(x, _between(first, third)), "the three points")
    if any(ip.plane_blocks.get((2, 0), ())) and ip.plane_turn:
        message = "G68.2 P2 with a shift Q0 and a turn R at once is not read"
        raise BlockError("plane-points", message, "R", hint="put the shift into the points")
    return x, z, first


def _of_directions(ip: Interpreter) -> tuple[affine.Vector, affine.Vector, affine.Vector]:
    """Return the directions of X and Z, Q1 and Q2 of P3, and the origin; raise where they are not square to each other."""
    z, x = (_direction(ip.plane_blocks[3, k], f"I J K of Q{k}") for k in (2, 1))
    if abs(sum(p * q for p, q in zip(x, z, strict=True))) > _SQUARE:
        message = "the directions of X and Z of G68.2 P3 are not square to each other"
        raise BlockError("plane-points", message, "P", hint=_HINT)
    return x, z, ip.plane_origin


def _between(a: affine.Vector, b: affine.Vector) -> affine.Vector:
    return b[0] - a[0], b[1] - a[1], b[2] - a[2]


def tilt(ip: Interpreter, block: Block, name: str = "G68.2") -> None:
    """G68.2 X Y Z I J K."""
    if not isinstance(ip.sink, affine.AffineSink) and ip.sink is not ip.base:
        message = f"{name} does not go with G68, G51, G51.1, G43.4, or cutter compensation"
        raise BlockError("frame-compensation", message, name, hint="end them before")
    frame = affine.Frame(_UNIT, _vector(block, "xyz"))
    if block.words.get("p") in _LAST:
        gathered = _gathered(ip, block)
        if gathered is None:
            return
        frame = gathered
    else:
        if "r" in block.words:
            raise BlockError("unused-word", "R stands in a block of G68.2 that has no use for it", "R")
        frame = affine.Frame(_matrix(block), frame.shift)
    if frame.matrix != affine.UNIT and ip.options.kinematics is None:
        message = f"{name} turns the coordinates; the rotary axes of the machine are not turned here"
        hint = f"{_ALIGNS[name]} turns them on a machine with a table [kinematics]; or write A B C"
        ip.warn_once("swivel-frame", message, name, hint)
    # A plane of no angles, as posts write it for the first side, is one that G53.1 and G69 find.
    affine.change(ip, frame, stays=True)


def tilt_haas(ip: Interpreter, block: Block) -> None:
    """G268 X Y Z I J K Q123: G68.2 P1 of Haas."""
    if block.words.get("q") != 123.0:
        order = f"Q{block.words['q']:g}" if "q" in block.words else "no Q"
        message = f"{order} of G268: the order in which I J K turn is not read, but for Q123"
        hint = "Q123 turns about X, then Y, then Z of the workpiece"
        raise BlockError("plane-kind", message, "Q" if "q" in block.words else "G268", hint=hint)
    tilt(ip, replace(block, words={**block.words, "p": 1.0}), "G268")


def convert(ip: Interpreter, block: Block, angle: float) -> None:
    """G68 X Y Z I J K R: shift the origin to X Y Z and turn by an angle, degrees, about I J K; a second G68 does so within the first.

    B-62764EN, 14 ("Three-dimensional coordinate conversion"); Mitsubishi's M700V (13.23) multiplies the same matrices.

    Raises:
        BlockError: No direction, a first G68 without X Y Z, or another frame that it does not go with.
    """
    within = ip.sink.program if isinstance(ip.sink, affine.AffineSink) else affine.Frame()
    hint = "G68 X0 Y0 Z0 I0 J1 K0 R90 turns about Y"
    if not isinstance(ip.sink, affine.AffineSink) and ip.sink is not ip.base:
        message = "G68 with I J K does not go with a rotation, G51, G51.1, G43.4, or cutter compensation"
        raise BlockError("frame-compensation", message, "G68", hint="end them before")
    given = sum(letter in block.words for letter in "xyz")
    if given not in ((0, 3) if within != affine.Frame() else (3,)):
        raise BlockError("axis-missing", "G68 with I J K has no centre X Y Z", "G68", hint=hint)
    message = "I J K of G68 have no direction"
    axis = affine.unit(_vector(block, "ijk"), BlockError("plane-points", message, "G68", hint=hint))
    message = "G68 with I J K turns the coordinates; the tool's length stays along the machine's Z here, and the control turns it too"
    ip.warn_once("swivel-frame", message, "G68", "a tool of length 0 moves as on the control")
    affine.change(ip, within.then(affine.Frame(affine.turn_about(axis, angle), _vector(block, "xyz"))))


def align(ip: Interpreter, block: Block, name: str = "G53.1") -> None:
    """G53.1 (G253 of Haas): turn the rotary axes until the tool stands along Z of the tilted plane."""
    if not isinstance(ip.sink, affine.AffineSink):
        begins = next(first for first, turns in _ALIGNS.items() if turns == name)
        raise BlockError(
            "plane-missing", f"{name} has no tilted plane", name, hint=f"{begins} stands before it"
        )
    kinematics, frame = ip.options.kinematics, ip.sink.program
    if kinematics is None:
        return
    if block.words.get("p"):
        message = f"P{block.words['p']:g} of G53.1, which chooses a pair of positions, is not read"
        raise BlockError("plane-kind", message, "P", hint="without P the nearer pair counts")
    axes = kinematics.angles_of(
        carried_planes.normal_of(frame.matrix), carried_planes.positions(ip, kinematics)
    )
    if axes is None:
        message = "the rotary axes of the machine do not turn the tool square to the plane"
        raise BlockError("orientation-vector", message, name, hint="[kinematics] names the axes")
    place = list(ip.state.position)
    for letter, value in carried_planes.words(ip, kinematics, axes).items():
        place[AXES.index(letter)] = value
    ip.go(place, rapid=True)
    affine.change(ip, frame, axes)


CODES = (
    Code("G", 682, "rotation", Stage.REFERENCE, tilt, "tilted plane: origin X Y Z, angles I J K", "xyzijkpqr", "own",
        dialects=("fanuc",), moves="XYZ"),
    Code("G", 531, "tool along plane", Stage.COORDINATES, align, "tool along Z of the tilted plane", "p", dialects=("fanuc",),
        moves="rotary"),
    Code("G", 2680, "rotation", Stage.REFERENCE, tilt_haas, "tilted plane: origin X Y Z, angles I J K about X Y Z by Q123 (Haas)", "xyzijkq",
        "own", dialects=("fanuc",), moves="XYZ", without="lathes"),
    Code("G", 2530, "tool along plane", Stage.COORDINATES, partial(align, name="G253"), "tool along Z of the tilted plane (Haas)",
        dialects=("fanuc",), moves="rotary", without="lathes"),
)  # fmt: skip

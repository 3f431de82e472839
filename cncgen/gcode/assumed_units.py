"""The unit of a text that does not state it: on FANUC and LinuxCNC it is a setting of the machine.

FANUC keeps the unit of the last run or takes that of a parameter, LinuxCNC that of its INI file.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from cncgen.diagnostics import Severity
from cncgen.gcode.codes.table import BOTH, LATHES, language_of
from cncgen.gcode.errors import BlockError
from cncgen.gcode.source import Source
from cncgen.gcode.text import signs
from cncgen.gcode.text.built_patterns import compiled
from cncgen.gcode.text.labels import Cursor
from cncgen.kernels.gcode_signs import unit_place
from cncgen.toolpath.reading import ReadOptions

#: Bytes in which a unit mostly stands.
_BEGIN = 4_096
#: Bytes in which other spellings than G20 and G21 are looked for, and the signs of inches.
_HEAD = 65_536
#: G20, in tenths.
_INCHES = 200
#: A text in inches has numbers of four decimals, as many at least and none with more, coordinates and feeds up to these; or of three,
#: and as many without a zero before the point.
_INCH_COUNT = 3
_INCH_MOST = {4: (100.0, 200.0), 3: (30.0, 60.0)}
#: The largest usual feed of a lathe a revolution in inches, which half of its feeds keep: 0.05 to 0.5 are those in mm.
_INCH_TURN = 0.03
#: How many times the bound of a lathe's spindle the speed at the largest X is, read in mm, where it is meant in feet a minute and inches;
#: and the least that a bound counts as, since slow heavy lathes turn in mm too.
_BEYOND_BOUND, _LEAST_BOUND = 10.0, 1000.0


def assumed_units(
    source: Source, dialect: str, options: ReadOptions
) -> Iterator[tuple[Cursor, BlockError, Severity]]:
    """Yield a remark at the first coordinate where neither the text nor the options say its unit.

    It is a warning where the numbers look like inches.
    """
    if options.units != "auto" or language_of(dialect) not in BOTH or _says_unit(source, dialect):
        return
    head = source.data[:_HEAD]
    text = _without_comments(head)
    first = compiled(signs.LENGTH).search(text)
    if first is None:
        return
    at = first.start()
    begin = text.rfind(b"\n", 0, at) + 1
    column = len(source.data[begin:at].decode("utf-8", "replace")) + 1
    hint = "G20 or G21 in the program says the unit, or --units, or [interpreter] units of the machine"
    message, code, severity = "neither G20 nor G21: lengths are taken as mm", "units-assumed", Severity.NOTE
    values: dict[str, float] = {}
    if (feed := _inch_feed(text, dialect in LATHES)) is not None:
        message += f", but its decimals and feeds up to F{feed:g} look like inches"
        code, severity, values = "units-doubtful", Severity.WARNING, {"feed": feed}
    elif dialect in LATHES and (speeds := _inch_speed(text)) is not None:
        values = dict(zip(("surface", "x", "speed", "bound"), speeds, strict=True))
        message += ", but G96 S{surface:g} at X{x:g} is {speed:.0f} rpm, far beyond the bound S{bound:g}: that looks like inches".format(
            **values
        )
        code, severity = "units-doubtful", Severity.WARNING
    elif (size := compiled(signs.SIZE_IN_INCHES).search(head)) and not compiled(signs.SIZE_IN_MM).search(
        head
    ):
        message += f", but {size['size'].decode()} in a comment is a size in inches"
        code, severity = "units-doubtful", Severity.WARNING
    yield (
        Cursor(0, begin, text[:begin].count(b"\n") + 1),
        BlockError(code, message, column=column, hint=hint, values=values),
        severity,
    )


def _without_comments(text: bytes) -> bytes:
    if b"(" not in text and b";" not in text:
        return text
    return compiled(signs.OUT_OF_CODE).sub(lambda match: b" " * len(match[0]), text)


def _says_unit(source: Source, dialect: str) -> bool:
    """Tell whether G20 or G21 (G70 or G71 of a lathe that has them so) stands in a text: in any spelling in its head, as they are mostly
    written anywhere."""
    data = source.data
    tens = next(
        (own // 100 for own, number in LATHES.get(dialect, {}).items() if number == _INCHES), _INCHES // 100
    )
    unit = compiled(signs.UNITS[tens])
    for head in (data[: data.rfind(b"\n", 0, _BEGIN) + 1], data[:_HEAD]):
        # Most texts say it in a block, or nowhere.
        if unit.search(head) and unit.search(_without_comments(head)):
            return True
    at = unit_place(source.bytes, _HEAD - 3, tens)
    while at >= 0:
        begin = data.rfind(b"\n", 0, at) + 1
        end = data.find(b"\n", at)
        if unit.search(_without_comments(data[begin : end if end >= 0 else len(data)])):
            return True
        at = unit_place(source.bytes, at + 3, tens)
    return False


def _inch_feed(text: bytes, lathe: bool) -> float | None:
    """Return the largest feed of a text whose numbers look like inches; None where they do not."""
    lengths = [match["number"] for match in compiled(signs.LENGTH).finditer(text)]
    feeds = [float(match["number"]) for match in compiled(signs.FEED).finditer(text)]
    decimals = [len(number.partition(b".")[2]) for number in lengths]
    most = max(decimals)
    bare = sum(number.startswith(b".") for number in lengths)
    if (
        not feeds
        or decimals.count(most) < _INCH_COUNT
        or most not in _INCH_MOST
        or (most == 3 and bare < _INCH_COUNT)
    ):
        return None
    if lathe and max(feeds) < 1.0 and sorted(feeds)[len(feeds) // 2] > _INCH_TURN:
        return None
    length, feed = _INCH_MOST[most]
    return max(feeds) if max(map(float, lengths)) <= length and max(feeds) <= feed else None


def _inch_speed(text: bytes) -> tuple[float, float, float, float] | None:
    """Return the least surface speed of a lathe, its largest X, the speed there read in mm, and the bound that it exceeds by far."""
    surfaces, bounds = (
        [float(match["number"]) for match in compiled(sign).finditer(text)]
        for sign in (signs.SURFACE_SPEED, signs.SPEED_BOUND)
    )
    places = [
        float(match["number"]) for match in compiled(signs.LENGTH).finditer(text) if match[0][:1] in b"Xx"
    ]
    if not (any(surfaces) and any(bounds) and any(places)):
        return None
    surface, bound, x = min(filter(None, surfaces)), max(bounds), max(places)
    speed = 1000.0 * surface / (math.pi * x)
    return (surface, x, speed, bound) if speed > _BEYOND_BOUND * max(bound, _LEAST_BOUND) else None

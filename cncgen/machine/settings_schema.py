"""The tables of a machine file beside its axes: ``[interpreter]``, ``[kinematics]``, ``[coupling]`` and ``[times]``.

The modules that use them state their meaning (`cncgen.gcode.state.settings`, `cncgen.machine.kinematics`,
`cncgen.servo.named_schemes`). Their allowed values are here, so that one run names every fault of a file.
"""

from __future__ import annotations

import difflib
import itertools
import re
from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from cncgen.arguments import is_number
from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.extensions import DIALECTS
from cncgen.machine.servo_parameters import MAGNITUDES

#: How many of a machine's two rotary axes carry the tool, by its model.
KINEMATICS = MappingProxyType({"table-table": 0, "head-table": 1, "head-head": 2})


@dataclass(frozen=True, slots=True)
class Key:
    """One key of a table.

    Attributes:
        name: With its unit.
        about: Its description.
        wanted: The values allowed, in words.
        holds: Tells a right value.
        default: Where the file says nothing, in words; "": it must say it.
    """

    name: str
    about: str
    wanted: str
    holds: Callable[[Any], bool]
    default: str = ""


def _is_of(choices: tuple[str, ...]) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, str) and value in choices


def _from(low: float, high: float) -> Callable[[Any], bool]:
    return lambda value: is_number(value) and low <= value <= high


def _are_two_letters(value: Any) -> bool:
    letters = [str(letter).lower() for letter in value] if isinstance(value, list) else []
    return len(letters) == 2 and letters[0] != letters[1] and set(letters) <= set("abc")


def _is_point(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(map(_from(-FARTHEST, FARTHEST), value))


def _is_ramp(value: Any) -> bool:
    """Tell rising pairs of a speed and a time."""
    if not isinstance(value, list) or not value:
        return False
    pairs = [pair for pair in value if isinstance(pair, list) and len(pair) == 2 and all(map(_is_time, pair))]
    before = [[0.0, 0.0], *pairs]
    rising = all(a[0] < b[0] and a[1] <= b[1] for a, b in itertools.pairwise(before))
    return len(pairs) == len(value) and rising


def _is_m_codes(value: Any) -> bool:
    return isinstance(value, dict) and all(
        re.fullmatch(r"[Mm]\d{1,3}", key) and _is_time(seconds) for key, seconds in value.items()
    )


#: No machine is larger, mm; results computed from lengths stay far within doubles.
FARTHEST = 1e6
#: Longest time of an event, s, and largest speed or rate of a spindle.
_LONGEST = 1e6
_is_time = _from(0.0, _LONGEST)
_TIME = f"a number from 0 to {_LONGEST:g}"
_is_rate = _from(1e-3, 1e9)
_RATE = "a number from 0.001 to 1e9"
_is_gain = _from(*MAGNITUDES)
_GAIN = f"a positive number, at most {MAGNITUDES[1]:g}"

TABLES: Mapping[str, tuple[Key, ...]] = MappingProxyType(
    {
        "interpreter": (
            Key("dialect", "the control's language, where --dialect does not say", f"one of {', '.join(DIALECTS)}",
                _is_of(DIALECTS), "as the program looks"),
            Key("units", "unit of lengths until the program says it", "one of mm, inch", _is_of(("mm", "inch")),
                "mm, with a note"),
            Key("least_increment_mm", "unit of a number without a decimal point (degrees alike; inches: a tenth)",
                "a number from 1e-9 to 1", _from(1e-9, 1.0), "such numbers count like 10."),
        ),
        "kinematics": (
            Key("model", "whether the rotary axes carry the table or the head", f"one of {', '.join(KINEMATICS)}",
                _is_of(tuple(KINEMATICS))),
            Key("axes", "the rotary axes", "two of a, b, c: the one that carries the other first, or the head's before the table's",
                _are_two_letters),
            Key("centre_mm", "a point of the axes of tables, of two where they meet, machine coordinates",
                f"three numbers, none beyond {FARTHEST:g}", _is_point, "the origin"),
            Key("pivot_mm", "of heads: from the spindle's gauge line to their axes, of two to where they meet",
                f"a number from 0 to {FARTHEST:g}", _from(0.0, FARTHEST), "0"),
            Key("tolerance_mm", "how far lines of the machine's axes may be from the tool's path",
                f"a number from 1e-9 to {FARTHEST:g}", _from(1e-9, FARTHEST), "0.001"),
            Key("degree_mm", "what a degree of a rotary axis counts as in the tolerances of path and chords, mm",
                "a number from 0.01 to 100", _from(0.01, 100.0), "2"),
        ),
        "coupling": (
            Key("ccc_proportional", "gain of cross coupling, a multiple of the axes' own", _GAIN, _is_gain,
                "8, or what is stable"),
            Key("ccc_integral_1_s", "its integral gain, 1/s", f"a number from 0 to {MAGNITUDES[1]:g}",
                _from(0.0, MAGNITUDES[1]), "100, or what is stable"),
            Key("tcf_tangential_rad_s", "task frame: natural frequency of the error along the path", _GAIN,
                _is_gain, "295.8"),
            Key("tcf_tangential_damping", "its damping", _GAIN, _is_gain, "1.0142"),
            Key("tcf_normal_rad_s", "task frame: natural frequency of the error across the path", _GAIN, _is_gain,
                "295.8"),
            Key("tcf_normal_damping", "its damping", _GAIN, _is_gain, "1.0142"),
        ),
        "times": (
            Key("tool_change_s", "time of a tool change, without the magazine's way", _TIME, _is_time, "0"),
            Key("pocket_s", "time from one pocket of the magazine to the next", _TIME, _is_time, "0"),
            Key("pockets", "pockets of a magazine that turns both ways", "an integer from 0 to 10000",
                lambda value: isinstance(value, int) and _from(0, 10_000)(value), "0: it goes one way through all between"),
            Key("spindle_acceleration_rpm_s", "how fast the spindle speeds up", _RATE, _is_rate, "no time"),
            Key("spindle_braking_rpm_s", "how fast it slows down", _RATE, _is_rate, "as it speeds up"),
            Key("spindle_ramp", "instead of rates: seconds from standstill to some speeds", "rising pairs [rpm, s]",
                _is_ramp, "the rates"),
            Key("spindle_max_rpm", "how fast it turns at most under G96, whatever the program's bound", _RATE, _is_rate, "no bound"),
            Key("spindle_orient_s", "time to turn to an angle from standstill", _TIME, _is_time, "0"),
            Key("coolant_s", "time to switch coolant", _TIME, _is_time, "0"),
            Key("pallet_s", "time of a pallet change", _TIME, _is_time, "0"),
            Key("operator_stop_s", "time that an operator takes at M0, M1 and M60", _TIME, _is_time, "0"),
            Key("block_s", "least time that the control takes for a block with a feed", "a number from 0 to 10",
                _from(0.0, 10.0), "0"),
            Key("m_codes", "further time by M code", "a table like { M8 = 0.3 }, each from 0 to 1e6", _is_m_codes, "none"),
        ),
    }
)  # fmt: skip


def faults(name: str, table: Mapping[str, Any]) -> Iterator[tuple[str, str, str, str]]:
    """Yield every fault of a table: diagnostic code, key, message and hint.

    Args:
        name: One of `TABLES`.
        table: As tomllib gives it.
    """
    keys = {key.name: key for key in TABLES[name]}
    for key in table:
        if key not in keys:
            near = difflib.get_close_matches(key, keys, 1)
            hint = f"did you mean {near[0]}?" if near else f"known keys: {', '.join(keys)}"
            yield "machine-key", key, "unknown key", hint
    for key, known in keys.items():
        if key not in table:
            if not known.default:
                yield "machine-missing", key, f"missing ({known.about})", f"it must be {known.wanted}"
        elif not known.holds(table[key]):
            yield "machine-value", key, f"must be {known.wanted}; is {table[key]!r}", ""
    pair = ("ccc_proportional", "ccc_integral_1_s")
    if name == "coupling" and len(set(pair) & set(table)) == 1:
        given, other = sorted(pair, key=lambda key: key not in table)
        yield "machine-missing", given, f"needs {other} beside it", ""


def without_axis(settings: Mapping[str, Any], axes: Container[str]) -> Iterator[str]:
    """Yield what is wrong with each axis of ``[kinematics]`` that is none of the machine's: it would stand at 0, whatever moves.

    Args:
        settings: Tables by name.
        axes: Letters of the machine's axes.
    """
    letters = settings.get("kinematics", {}).get("axes", ())
    if _are_two_letters(letters):
        for letter in letters:
            if letter.upper() not in axes:
                yield f"{letter} carries table or head, and the machine has no [axes.{letter.lower()}]"


def check(name: str, table: Mapping[str, Any]) -> None:
    """Raise `UsageError` that names every fault of a table of a machine that no file described."""
    found = [
        Diagnostic(code, f"{name}.{key}: {message}", hint=hint)
        for code, key, message, hint in faults(name, table)
    ]
    if found:
        raise UsageError(found)

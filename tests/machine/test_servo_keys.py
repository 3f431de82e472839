"""Every key of every servo model: what it may be, in which unit, and the fault that each wrong value gives."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.machine import servo_schema
from cncgen.machine.reading import machine_from_toml, servos_from_toml
from cncgen.machine.record import Servo
from cncgen.machine.servo_parameters import MODELS, Parameter
from cncgen.servo.named_schemes import COUPLING_KEYS, settings_of

KEYS = [
    pytest.param(name, parameter, id=f"{name}-{parameter.symbol}")
    for name, model in MODELS.items()
    for parameter in model.parameters
]

#: An integer that TOML allows and a double does not hold.
HUGE = 10**400


def minimal(name: str, letter: str = "X") -> dict[str, Any]:
    """The smallest table of a model that has no fault."""
    given = {"numerator": [2.0], "denominator": [1.0, 3.0, 0.0]}
    table = {p.key(letter): given.get(p.name, 1.0) for p in MODELS[name].parameters if p.required}
    if name == "plant":
        table["position_gain_1_mm" if letter == "X" else "position_gain_1_deg"] = 5.0
    return {"model": name, **table}


def wrong_values(parameter: Parameter) -> list[Any]:
    """Values that a parameter cannot have."""
    others: dict[str, list[Any]] = {
        "word": ["nonsense", 3, True, ["motor"], ""],
        "text": ["", "  ", 3, ["V"]],
        "flag": [1, 0.0, "true"],
        "numbers": [[], [0.0, 0], ["1"], 3.0, [1.0, math.nan], [True], [1, HUGE], [1.0, 1e-91]],
    }
    if parameter.kind in others:
        return others[parameter.kind]
    found: list[Any] = ["1", True, math.nan, math.inf, -math.inf, HUGE, 1e16, 1e-16, [1.0], {"a": 1}]
    if parameter.kind == "integer":
        found.append(1.5)
    if math.isfinite(parameter.low):
        found.append(parameter.low - 1.0)
    if parameter.open_low:
        found.append(parameter.low)
    if math.isfinite(parameter.high):
        found.append(parameter.high + 1.0)
    return found


@pytest.mark.parametrize("letter", ["X", "C"])
@pytest.mark.parametrize("name", list(MODELS))
def test_the_smallest_table_has_no_fault(name: str, letter: str) -> None:
    assert list(servo_schema.faults(minimal(name, letter), letter)) == []


@pytest.mark.parametrize(("name", "parameter"), KEYS)
def test_each_wrong_value_is_a_fault_of_its_key_alone(name: str, parameter: Parameter) -> None:
    for value in wrong_values(parameter):
        table = {**minimal(name), parameter.key("X"): value}
        # The word that chooses a controller also says which other keys have to be there.
        found = [(code, key) for code, key, _ in servo_schema.faults(table, "X") if key == parameter.key("X")]
        assert found == [("machine-value", parameter.key("X"))], value


@pytest.mark.parametrize(("name", "parameter"), KEYS)
def test_a_key_is_missed_only_where_it_is_required(name: str, parameter: Parameter) -> None:
    table = {key: value for key, value in minimal(name).items() if key != parameter.key("X")}
    missed = {(code, key) for code, key, _ in servo_schema.faults(table, "X")}
    needed = parameter.required or (name == "plant" and parameter.symbol == "position_gain_1_mm")
    assert missed == ({("machine-missing", parameter.key("X"))} if needed else set())


@pytest.mark.parametrize(("name", "parameter"), KEYS)
def test_a_rotary_axis_has_its_own_key_and_radians_inside(name: str, parameter: Parameter) -> None:
    linear, rotary = parameter.key("X"), parameter.key("C")
    assert (linear == rotary) == ("{l}" not in parameter.name)
    if parameter.kind in ("word", "text", "flag"):
        return
    value = [2.0, 3.0] if parameter.kind == "numbers" else 0.5 if parameter.high < 1.0 else 2.0
    turned = servo_schema.resolve(Servo(name, {**minimal(name, "C"), rotary: value}), "C")[parameter.symbol]
    straight = servo_schema.resolve(Servo(name, {**minimal(name), linear: value}), "X")[parameter.symbol]
    assert straight == value
    assert np.asarray(turned) == pytest.approx(np.asarray(value) * math.radians(1.0) ** parameter.power)
    if linear != rotary:
        found = {k for _, k, _ in servo_schema.faults({**minimal(name, "C"), linear: value}, "C")}
        assert found == {linear}


#: What stands before the length in the unit of a key where it divides: 1/mm, N·m/mm, N·m·s/mm, s/mm, counts per mm.
UNITS_ABOVE = {"1", "m", "s", "per"}
#: Lists of coefficients, whose units stand in no name: of a plant mm a drive input, of a controller drive input a mm.
POWERS_OF_LISTS = {("plant", "numerator"): 1, ("plant", "controller_numerator"): -1}


@pytest.mark.parametrize(("name", "parameter"), KEYS)
def test_a_keys_name_says_the_power_of_its_length(name: str, parameter: Parameter) -> None:
    """``{l}`` divides where another unit or a 1 stands before it, and multiplies where it is the first one."""
    words = parameter.name.split("_")
    if "{l}" not in words:
        expected = POWERS_OF_LISTS.get((name, parameter.name), 0)
    else:
        expected = -1 if words[words.index("{l}") - 1] in UNITS_ABOVE else 1
    assert parameter.power == expected


#: Defaults of a design, which is asked for by keys without a default.
DESIGN = {
    "sensitivity_peak", "sensitivity_offset", "control_weight", "frequency_uncertainty", "gain_uncertainty",
    "complementary_peak",
}  # fmt: skip


@pytest.mark.parametrize(("name", "parameter"), KEYS)
def test_what_a_table_does_not_say_has_no_effect(name: str, parameter: Parameter) -> None:
    """No friction, play, noise, dead time or gain is there unless it is given."""
    resolved = servo_schema.resolve(Servo(name, minimal(name)), "X")
    if parameter.key("X") not in minimal(name) and parameter.kind in ("number", "integer", "numbers"):
        assert (resolved[parameter.symbol] or 0) == 0 or parameter.name in DESIGN
    kinds = {"feedback": "motor", "controller": "pid", "feedforward": True}
    if parameter.name in kinds:
        assert resolved[parameter.symbol] == kinds[parameter.name]


@pytest.mark.parametrize(
    ("size", "fault"), [(1e-90, ""), (1e90, ""), (-1e90, ""), (0.99e-90, "size"), (-1.01e90, "size")]
)
def test_coefficients_are_within_what_their_products_can_hold(size: float, fault: str) -> None:
    table = {**minimal("plant"), "numerator": [1.0], "denominator": [size, 3.0, 0.0]}
    found = [text for _, key, text in servo_schema.faults(table, "X") if key == "denominator"]
    assert len(found) == bool(fault)
    assert all(fault in text for text in found)


@pytest.mark.parametrize("degree", [11, 12])
def test_a_denominator_has_eleven_powers_at_most(degree: int) -> None:
    table = {**minimal("plant"), "numerator": [1.0], "denominator": [1.0] * (degree + 1)}
    found = [text for _, key, text in servo_schema.faults(table, "X") if key == "denominator"]
    assert found == (["has degree 12; 11 is the most"] if degree == 12 else [])


def test_integers_are_doubles_inside() -> None:
    """TOML's integers are Python's: arrays of those beyond 64 bits would hold objects."""
    table = {**minimal("transfer-function"), "numerator": [10**22], "denominator": [1, 10**22]}
    values = servo_schema.resolve(Servo("transfer-function", table), "X")
    assert (np.asarray(values["numerator"]).dtype, values["denominator"]) == (np.float64, [1.0, 1e22])


@pytest.mark.parametrize(
    ("keys", "found"),
    [
        ({"controller": "ratio"}, {"controller_numerator", "controller_denominator"}),
        ({"controller": "h-infinity"}, {"sensitivity_bandwidth_rad_s", "robustness_crossover_rad_s"}),
        ({"numerator": [1.0, 2.0, 3.0]}, {"numerator"}),
        ({"denominator": [1.0] * 14}, {"denominator"}),
        ({"sample_time_s": 0.001, "control_period_s": 0.002}, {"control_period_s"}),
        ({"sample_time_s": 0.001, "control_period_s": 0.001}, set()),
        (
            {
                "controller": "h-infinity",
                "sample_time_s": 0.001,
                "sensitivity_bandwidth_rad_s": 100.0,
                "robustness_crossover_rad_s": 900.0,
            },
            {"controller"},
        ),
        (
            {
                "controller": "ratio",
                "controller_numerator": [1.0, 0.0, 1.0],
                "controller_denominator": [1.0, 1.0],
            },
            {"controller_numerator"},
        ),
    ],
)
def test_what_a_plants_keys_ask_of_each_other(keys: dict[str, Any], found: set[str]) -> None:
    assert {key for _, key, _ in servo_schema.faults({**minimal("plant"), **keys}, "X")} == found


#: Loops as block diagrams: controller C and plant G by hand, the closed loop CG/(1 + CG) of unit feedback.
S = 1j * np.array([1.0, 30.0, 200.0, 900.0])
LOOPS = {
    "first-order": (
        {"position_gain_1_s": 40.0, "time_constant_s": 0.01, "viscous_share": 0.1},
        40.0,
        1.0 / (S * (0.01 * S + 1.1)),
    ),
    "plant": (
        {
            "numerator": [8.0],
            "denominator": [1.0, 3.0, 0.0],
            "position_gain_1_mm": 50.0,
            "integral_gain_1_mm_s": 7.0,
            "derivative_gain_s_mm": 0.4,
            "derivative_filter_rad_s": 500.0,
            "viscous_s_mm": 0.2,
        },
        50.0 + 7.0 / S + 0.4 * S / (S / 500.0 + 1.0),
        8.0 / (S**2 + 3.0 * S + 0.2 * 8.0 * S),
    ),
    "plant-ratio": (
        {
            "numerator": [8.0],
            "denominator": [1.0, 3.0, 0.0],
            "controller": "ratio",
            "controller_numerator": [2.0, 9.0],
            "controller_denominator": [0.001, 1.0],
        },
        (2.0 * S + 9.0) / (0.001 * S + 1.0),
        8.0 / (S**2 + 3.0 * S),
    ),
}


@pytest.mark.parametrize("name", list(LOOPS))
def test_closed_loops_are_their_block_diagrams(name: str) -> None:
    values, controller, plant = LOOPS[name]
    loop = servo_schema.closed_loop(Servo(name.removesuffix("-ratio"), values))
    expected = controller * plant / (1.0 + controller * plant)
    assert np.polyval(loop.numerator, S) / np.polyval(loop.denominator, S) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ({"delay_s": 0.001}, "dead time"),
        ({"sample_time_s": 0.001}, "in z"),
        ({"controller": "h-infinity"}, "H-infinity"),
    ],
)
def test_a_plant_that_is_no_ratio_in_s_says_why(more: dict[str, Any], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        servo_schema.closed_loop(Servo("plant", {**minimal("plant"), **more}))


LIMITS = "[axes.x]\nmax_velocity_mm_s = 1\nmax_acceleration_mm_s2 = 1\nmax_jerk_mm_s3 = 1\n"
TOP = ("period_s", "chord_tolerance_mm", "path_tolerance_mm", "max_contour_error_mm", "max_centripetal_mm_s2")


@pytest.mark.parametrize("key", TOP)
@pytest.mark.parametrize(
    ("value", "code"),
    [
        ("0", "machine-value"),
        ("-0.001", "machine-value"),
        ("nan", "machine-value"),
        ("-inf", "machine-value"),
        (str(HUGE), "machine-value"),
        ('"0.001"', "machine-type"),
        ("true", "machine-type"),
        ("[0.001]", "machine-type"),
        ("{ a = 1 }", "machine-type"),
        ("1979-05-27", "machine-type"),
        ("9" * 5000, "machine-syntax"),
    ],
)
def test_numbers_at_the_top_of_a_file(key: str, value: str, code: str) -> None:
    with pytest.raises(UsageError) as caught:
        machine_from_toml(f"{key} = {value}\n{LIMITS}".encode(), "m.toml")
    [fault] = caught.value.diagnostics
    assert fault.code == code
    assert code == "machine-syntax" or (fault.values["key"], fault.span and fault.span.line) == (key, 1)


@pytest.mark.parametrize("travel", ["[1]", "[1, 2, 3]", '["a", 2]', "3", "[true, 2]", "{ low = 1 }", "[]"])
def test_travel_is_two_numbers(travel: str) -> None:
    with pytest.raises(UsageError, match=r"axes\.x\.travel_mm: must be two numbers \[lowest, highest\]"):
        machine_from_toml(f"{LIMITS}travel_mm = {travel}\n".encode(), "m.toml")


@pytest.mark.parametrize("travel", ["[2, 1]", "[1, 1]", "[nan, 1]", "[0, inf]", f"[0, {HUGE}]"])
def test_travel_rises_and_is_finite(travel: str) -> None:
    with pytest.raises(UsageError, match="must be below highest"):
        machine_from_toml(f"{LIMITS}travel_mm = {travel}\n".encode(), "m.toml")


@pytest.mark.parametrize("key", sorted(COUPLING_KEYS))
@pytest.mark.parametrize("value", [math.nan, -1.0, "2", True, HUGE, [1.0]])
def test_gains_of_coupling_are_positive_numbers(key: str, value: Any) -> None:
    beside = {"ccc_proportional": 1.0, "ccc_integral_1_s": 1.0} if key.startswith("ccc") else {}
    with pytest.raises(UsageError) as caught:
        settings_of({**beside, key: value})
    assert [(d.code, key in d.message) for d in caught.value.diagnostics] == [("machine-value", True)]


def test_faults_of_servo_tables_stand_at_their_lines() -> None:
    text = f"{LIMITS}[axes.x.servo]\nmodel = 'first-order'\nposition_gain_1_s = 0\nfeedback = 'table'\n"
    with pytest.raises(UsageError) as caught:
        servos_from_toml(text.encode(), "m.toml")
    assert [(d.span.line, d.values["key"]) for d in caught.value.diagnostics if d.span] == [
        (7, "axes.x.servo.position_gain_1_s"),
        (8, "axes.x.servo.feedback"),
    ]

"""Random tables of servo data."""

from __future__ import annotations

import random

from cncgen.machine.servo_parameters import MODELS, Parameter


def number(rng: random.Random) -> float:
    """Return a number of usual size, sometimes zero or extreme."""
    if rng.random() < 0.05:
        return rng.choice([0.0, 1e-300, 1e300, -1.0, 1e-12, 1e9])
    return 10.0 ** rng.uniform(-4, 5)


def value(parameter: Parameter, rng: random.Random) -> str:
    """Return a value of a parameter as TOML."""
    if parameter.name == "control_period_s":
        return rng.choice(["0.001", "0.0005", "0.00025"])
    if parameter.name == "sample_time_s":
        return "0.001"
    if parameter.name == "delay_s":
        return rng.choice(["0.0", "0.001", "0.0013"])
    kinds = {
        "word": f'"{rng.choice(parameter.choices or ("",))}"',
        "flag": "true",
        "text": '"V"',
        "integer": "3",
    }
    if parameter.kind == "numbers":
        return str([number(rng) * rng.choice([1, 1, 1, -1]) for _ in range(rng.randint(1, 4))])
    return kinds.get(parameter.kind, repr(number(rng)))


def table(rng: random.Random) -> str:
    """Return servo tables of X and Y of one model."""
    name = rng.choice(list(MODELS))
    lines = []
    for letter in "XY":
        lines += [f"[axes.{letter.lower()}.servo]", f'model = "{name}"']
        lines += [
            f"{p.key(letter)} = {value(p, rng)}"
            for p in MODELS[name].parameters
            if p.required or rng.random() < 0.35
        ]
    return "\n".join(lines) + "\n"

"""The result of an axis's identification, as a servo table and as a distribution to draw machines from.

The covariance of a fit (`cncgen.servo.identification.fits`) is that of a normal distribution: of positive parameters, of
their logarithms. Machines drawn from it are possible by the log.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np

from cncgen.files import read_bytes
from cncgen.units import file_unit, is_rotary, to_file

#: Servo models by the model that is identified; others (``etfe``) have no parameters to draw.
SERVO_MODELS = {"velocity-loop": "plant", "first-order": "first-order", "fourth-order": "transfer-function"}
#: A summary is smaller, bytes.
LARGEST_SUMMARY = 100_000_000


@dataclass(frozen=True, slots=True)
class IdentifiedSpread:
    """The parameters that an identification found of an axis, normal with its covariance; positive ones by their logarithms.

    Attributes:
        letter: The axis, ``X``.
        model: The identified model, a key of `SERVO_MODELS`.
        names: Shape (k,): its parameters.
        means: Shape (k,): the values found; logarithms where `logarithms` says so.
        logarithms: Shape (k,).
        root: Shape (k, k): lower Cholesky factor of the covariance.
    """

    letter: str
    model: str
    names: tuple[str, ...]
    means: tuple[float, ...]
    logarithms: tuple[bool, ...]
    root: tuple[tuple[float, ...], ...]

    def values(self, u: Sequence[float]) -> tuple[float, ...]:
        """Return parameters, shape (k,), at a point `u` of the unit cube: mean + root · z, z independent normal numbers."""
        z = np.array([normal_quantile(share) for share in u])
        theta = np.array(self.means) + np.array(self.root) @ z
        return tuple(math.exp(t) if log else float(t) for t, log in zip(theta, self.logarithms, strict=True))

    def table(self, values: Sequence[float], before: Mapping[str, Any]) -> dict[str, Any]:
        """Return the servo table of drawn parameters.

        Args:
            values: Shape (k,), from `values`.
            before: The axis's servo table. Where its model is the same, its other keys are kept.
        """
        found = dict(zip(self.names, values, strict=True))
        if self.model != "fourth-order":
            found = {
                name: abs(value) for name, value in found.items()
            }  # of friction and the like, which have no sign
        wanted = SERVO_MODELS[self.model]
        kept = before if before.get("model") == wanted else {}
        return {**kept, "model": wanted, **servo_values(self.letter, self.model, found)}


def servo_values(letter: str, model: str, found: Mapping[str, float]) -> dict[str, Any]:
    """Return the keys of a servo table that identified parameters give.

    Args:
        letter: The axis; a rotary one has degrees in its table.
        model: A key of `SERVO_MODELS`.
        found: Parameters by name, in mm, rad and s.
    """
    if model == "fourth-order":
        return {
            "numerator": [found["b2"], found["b1"], found["a0"]],
            "denominator": [1.0, found["a3"], found["a2"], found["a1"], found["a0"]],
        }
    if model == "velocity-loop":
        return {
            "numerator": [found["gain"] * to_file(letter)],
            "denominator": [found["time_constant_s"], 1.0, 0.0],
            "coulomb": found.get("coulomb", 0.0),
        }
    values = {}
    for name, value in found.items():
        if name == "coulomb_lag_mm":
            name = f"coulomb_lag_{file_unit(letter)}"
            value = math.degrees(value) if is_rotary(letter) else value
        if name != "offset":  # of the encoder's zero, and not of the axis
            values[name] = value
    return values


def spread_of(summary: Mapping[str, Any], letter: str) -> IdentifiedSpread:
    """Return the data of an axis in a summary of ``cncgen identify``.

    Args:
        summary: The JSON as plain values.
        letter: The axis, ``X``.

    Raises:
        ValueError: It is not a summary of `identify`, or its covariance leaves a parameter open; the text says which.
    """
    try:
        axis, model = summary["axes"][letter.lower()], str(summary["model"])
        spread = axis["covariance"]
        names, logarithms = tuple(map(str, spread["parameters"])), tuple(map(bool, spread["logarithm"]))
        matrix = np.array(spread["matrix"], np.float64)
        found = [float(axis["parameters"][name]) for name in names]
        means = tuple(math.log(v) if log else v for v, log in zip(found, logarithms, strict=True))
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"not a summary of cncgen identify for axis {letter.lower()}: {error}") from error
    if model not in SERVO_MODELS or matrix.shape != (len(names), len(names)):
        raise ValueError(f"the model {model} has no parameters to draw")
    try:
        root = np.linalg.cholesky(matrix if np.isfinite(matrix).all() else -np.eye(len(names)))
    except np.linalg.LinAlgError as error:
        text = "the covariance is not positive definite: the log does not determine all parameters"
        raise ValueError(text) from error
    return IdentifiedSpread(
        letter, model, names, means, logarithms, tuple(tuple(map(float, r)) for r in root)
    )


def read_summary(path: str) -> dict[str, Any]:
    """Return the JSON object of a file.

    Raises:
        UsageError: It cannot be read.
        ValueError: It is not a JSON object.
    """
    summary = json.loads(read_bytes(path, at_most=LARGEST_SUMMARY))
    if not isinstance(summary, dict):
        raise ValueError("not a JSON object")
    return summary


def normal_quantile(share: float) -> float:
    """Return z with P(Z ≤ z) = share of a standard normal Z; shares within 1e-12 of 0 and 1 count as that far from them."""
    return NormalDist().inv_cdf(min(max(share, 1e-12), 1.0 - 1e-12))

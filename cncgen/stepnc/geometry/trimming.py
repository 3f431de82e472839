"""The trims of a TRIMMED_CURVE: by points, by parameters, or by both, of which the master counts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cncgen.stepnc.entities import Entity
from cncgen.stepnc.geometry.frames import Placements
from cncgen.stepnc.part21 import Ref, Typed


class Trim(NamedTuple):
    """Where a curve begins or ends: at a point, shape (3,) mm, or, without one, at a parameter."""

    point: NDArray[np.float64] | None
    parameter: float | None


def read_trims(entity: Entity, placements: Placements) -> tuple[Trim, Trim]:
    """Return both trims. Points count where they are given, unless the master representation is PARAMETER.

    Raises:
        Skip: where one has neither.
    """
    by_parameter = entity.enum("master_representation") == "PARAMETER"
    return _trim(entity, "trim_1", placements, by_parameter), _trim(
        entity, "trim_2", placements, by_parameter
    )


def _trim(entity: Entity, name: str, placements: Placements, by_parameter: bool) -> Trim:
    given = entity.get(name)
    values = given if isinstance(given, tuple) and not isinstance(given, Typed) else (given,)
    point, parameter = None, None
    for value in values:
        if isinstance(value, Ref):
            point = placements.point(int(value), entity.id)
        else:
            number = value.value if isinstance(value, Typed) else value
            parameter = float(number) if isinstance(number, int | float) else parameter
    if point is None and parameter is None:
        raise entity.fault("stepnc-missing", f"{name} must hold a point or a parameter")
    if by_parameter and parameter is not None:
        point = None
    return Trim(point, parameter)

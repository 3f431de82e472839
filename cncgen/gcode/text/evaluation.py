"""Present values of a block's words, which are numbers or programs that compute them."""

from __future__ import annotations

from cncgen.gcode.block import Value

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.state.parameters import Parameters


#: Numbers closer than this are equal.
EQUAL = 1e-4


def evaluate(value: Value, parameters: Parameters) -> float:
    """Return the number that a value is now."""
    return value if isinstance(value, float) else value(parameters)

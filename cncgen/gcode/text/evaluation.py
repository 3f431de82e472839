"""Present values of a block's words, which are numbers or programs that compute them."""

from __future__ import annotations

from cncgen.gcode.block import Value
from cncgen.gcode.errors import BlockError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.state.parameters import Parameters


#: Numbers closer than this are equal.
EQUAL = 1e-4


def evaluate(value: Value, parameters: Parameters) -> float:
    """Return the number that a value is now; a `BlockError` where it is nested deeper than can be followed."""
    if isinstance(value, float):
        return value
    try:
        return value(parameters)
    except RecursionError:
        raise too_deep() from None


def too_deep() -> BlockError:
    """Return the fault of a value whose computing nests deeper than can be followed."""
    return BlockError(
        "expression-depth",
        "the expression is nested too deep to be evaluated",
        hint="split it over several parameters",
    )

"""Parameters: numbered, named (local and global) and those that tell the machine's state."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cncgen.gcode.errors import BlockError

if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter

#: Numbers of parameters: 1 to this less 1 (LinuxCNC's RS274NGC_MAX_PARAMETERS).
COUNT = 5603


class Parameters:
    """All parameters of a run."""

    def __init__(self, interpreter: Interpreter) -> None:
        self.interpreter = interpreter
        self.numbers = [0.0] * COUNT
        self.named: dict[str, float] = {}

    def number(self, index: float) -> float:
        """Return a numbered parameter; the index may come from an expression."""
        whole = round(index)
        if abs(index - whole) > 1e-4 or not 0 < whole < COUNT:
            raise BlockError("parameter-number", f"there is no parameter #{index:g} (1 to {COUNT - 1})", "")
        return self.numbers[whole]

    def set_number(self, index: float, value: float) -> None:
        """Set a numbered parameter."""
        whole = round(index)
        if abs(index - whole) > 1e-4 or not 0 < whole < COUNT:
            raise BlockError("parameter-number", f"there is no parameter #{index:g} (1 to {COUNT - 1})", "")
        self.numbers[whole] = value

    def name(self, name: str) -> float:
        """Return a named parameter."""
        try:
            return self.named[name]
        except KeyError:
            raise BlockError("unknown-parameter", f"#<{name}> has no value", "") from None

    def set_name(self, name: str, value: float) -> None:
        """Set a named parameter."""
        self.named[name] = value

    def has(self, name: str) -> bool:
        """Tell whether a named parameter has a value."""
        return name in self.named

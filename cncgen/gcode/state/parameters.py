"""Parameters: numbered, named (local and global), and parameters with the state of the machine."""

from __future__ import annotations

import math
from array import array

from cncgen.diagnostics import Diagnostic, Span, UsageError
from cncgen.files import read_utf8, write_text
from cncgen.gcode.block import nearest
from cncgen.gcode.errors import BlockError
from cncgen.gcode.state.modal import LENGTHS
from cncgen.gcode.state.predefined import NAMED, POSITION, TOOL_CHANGER, position_parameter
from cncgen.gcode.state.systems import SYSTEM, SYSTEM_COUNT, SYSTEM_STEP, SYSTEMS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from pathlib import Path

    from cncgen.gcode.interpreter import Interpreter

#: Numbered parameters are 1 to this (LinuxCNC's RS274NGC_MAX_PARAMETERS, less 1).
LAST = 5601
LAST_FANUC = 20_020
#: The first common variable of FANUC's macros, and the parameters that begin without a value: local, common, kept common.
COMMON = 100
VACANT_AT_START = (range(34), range(100, 200), range(500, 1000))
#: Further common variables of FANUC's controls, an option, and of the makers of machines; they begin without a value.
COMMON_BEYOND = (range(98_000, 98_500), range(100_000, 300_000), range(900_000, 907_400))
#: Where the tables begin; offsets are X Y Z A B C U V W, work systems have their rotation after W.
HOME_28, HOME_30 = 5161, 5181
G92_ON, G92 = 5210, 5211
#: FANUC's common variables that keep their values when the control is switched off.
KEPT_FANUC = range(500, 1000)
INPUT = 5399
#: Whether (DEBUG, …) is shown; it begins as 1.
DEBUGGING = 5599
TOOL = 5400
#: Names of pins and of entries of the INI file begin so.
_OF_THE_MACHINE = ("_hal[", "_ini[")
#: Bytes that are read of a parameter file; a full one has some 120 kB.
MAX_FILE_BYTES = 16_000_000


class Parameters:
    """All parameters of a run.

    Attributes:
        numbers: By number; #1 to #30 are those of the innermost subroutine.
        local: Named parameters of the innermost subroutine.
        named: Global ones (their names begin with ``_``).
        listed: Numbers that the parameter file names; they are kept, as are some others always.
        stored: Numbers of FANUC's plain storage that the program has set.
        unset: The common variable of FANUC's that was read last without a value, or 0.
        untold: The variable that was read last of those that tell of the control or the machine, and that nothing tells here, or 0.
        unset_told: The variables without a value that a remark has named.
        shifted: Whether the program has set an origin by lengths.
    """

    def __init__(self, interpreter: Interpreter) -> None:
        self.interpreter = interpreter
        self.last = LAST if interpreter.dialect in ("linuxcnc", "heidenhain") else LAST_FANUC
        self.numbers = array("d", bytes(8 * (self.last + 1)))
        #: FANUC's #0, which never has a value, and those that begin without one.
        self.vacant = interpreter.dialect == "fanuc"
        if self.vacant:
            from cncgen.gcode.state import macro_variables

            self._system = macro_variables
            for numbers in VACANT_AT_START:
                for index in numbers:
                    self.numbers[index] = math.nan
        self.numbers[SYSTEM] = self.numbers[DEBUGGING] = 1.0
        self.local: dict[str, float] = {}
        self.named: dict[str, float] = {}
        self.listed: set[int] = set()
        self.stored: set[int] = set()
        self.unset = self.untold = 0
        self.unset_told: set[str] = set()
        self.shifted = False
        #: Values of the common variables that lie beyond the others.
        self._beyond: dict[int, float] = {}

    def _is_beyond(self, index: float) -> bool:
        return (
            self.vacant
            and index > self.last
            and any(self._whole(index) in numbers for numbers in COMMON_BEYOND)
        )

    def _whole(self, index: float) -> int:
        whole = nearest(index, "the number of a parameter")
        if abs(index - whole) > 1e-4:
            message = f"#{index:g} does not name a parameter: its number is not whole"
            raise BlockError("parameter-number", message, "#")
        return whole

    def _index(self, index: float) -> int:
        whole = self._whole(index)
        if not (0 < whole <= self.last or (whole == 0 and self.vacant)):
            message = f"parameter #{whole} does not exist: the last is #{self.last}"
            raise BlockError("parameter-number", message, "#")
        return whole

    def number(self, index: float) -> float:
        """Return a numbered parameter for an expression, which may have computed its index."""
        if self._is_beyond(index):
            return self.told(self._whole(index), self._beyond.get(self._whole(index), math.nan))
        whole = self._index(index)
        if whole in POSITION and not self.vacant and self.interpreter.state.compensation != 40:
            message = f"#{whole} is the position, which cannot be read while cutter compensation is on"
            raise BlockError("comp-refused", message, "#", hint="read it before G41 or G42")
        return self.told(whole, self.shown(whole))

    def told(self, whole: int, value: float) -> float:
        """Return the value of a parameter; where it is a common variable without one, `unset` keeps its number."""
        if value != value and whole >= COMMON:
            self.unset = whole
        return value

    def shown(self, index: int) -> float:
        """Return a numbered parameter for a message, which may show the position at any time, and #0."""
        whole = self._index(index) if index else 0
        if self.vacant:
            return self._system.read(self.interpreter, whole)
        if whole in TOOL_CHANGER:
            return 0.0
        return position_parameter(self.interpreter, whole) if whole in POSITION else self.numbers[whole]

    def set_number(self, index: float, value: float) -> None:
        """Set a numbered parameter."""
        if self._is_beyond(index):
            self._beyond[self._whole(index)] = value
            return
        whole = self._index(index)
        if whole == 0:
            hint = "#0 takes the value from another parameter: #1=#0"
            raise BlockError("parameter-read-only", "#0 never has a value: it cannot be set", "#", hint=hint)
        if self.vacant:
            self._system.store(self.interpreter, whole, value)
            return
        if whole in POSITION or TOOL <= whole <= 5413:
            message = f"#{whole} tells the machine's state: it cannot be set"
            raise BlockError("parameter-read-only", message, "#")
        self.numbers[whole] = value

    def name(self, name: str) -> float:
        """Return a named parameter."""
        if name.startswith("_"):
            if name in self.named:
                return self.named[name]
            known = NAMED.get(name)
            if known is not None:
                return float(known(self.interpreter))
        elif name in self.local:
            return self.local[name]
        hint = "set it before it is used"
        if name.startswith(_OF_THE_MACHINE):
            hint = f'pins and INI entries are the running machine\'s: a line "{name} 1000" in the file of --parameters gives one'
        raise BlockError("unknown-parameter", f"#<{name}> has no value", "#", hint=hint)

    def set_name(self, name: str, value: float) -> None:
        """Set a named parameter: global where its name begins with ``_``."""
        if name in NAMED:
            message = f"#<{name}> tells the machine's state: it cannot be set"
            raise BlockError("parameter-read-only", message, "#")
        (self.named if name.startswith("_") else self.local)[name] = value

    def has(self, name: str) -> bool:
        """Tell whether a named parameter has a value."""
        return name in self.local or name in self.named or name in NAMED

    def has_number(self, index: float) -> bool:
        """Tell whether there is a parameter of that number."""
        return 0 < self._whole(index) <= self.last

    # Tables that live in parameters, in program units.

    def offset(self, first: int, scale: float) -> list[float]:
        """Return nine parameters from one on as an offset; lengths times `scale`."""
        return [
            value * (1.0 if 3 <= k <= 5 else scale) for k, value in enumerate(self.numbers[first : first + 9])
        ]

    def set_offset(self, first: int, offset: list[float], scale: float) -> None:
        """Set nine parameters from one on; lengths divided by `scale`."""
        self.shifted = self.shifted or any(offset[k] for k in LENGTHS)
        for k, value in enumerate(offset):
            self.numbers[first + k] = value / (1.0 if 3 <= k <= 5 else scale)


def _finite(text: str) -> float:
    """Return a number.

    Raises:
        ValueError: It is none, or has no end.
    """
    value = float(text)
    if not math.isfinite(value):
        raise ValueError
    return value


def read_parameters(path: Path, parameters: Parameters) -> None:
    """Read a parameter file: lines of a number and a value; a pin or INI entry (`_hal[plasmac.cut-feed-rate]`) is named in place of a number.

    Raises:
        UsageError: Where it cannot be read or a line is wrong; all of them are named.
    """
    lines = read_utf8(path, at_most=MAX_FILE_BYTES).decode("utf-8", "replace").splitlines()
    faults = []
    first: dict[str, int] = {}
    for count, line in enumerate(lines, 1):
        words = line.split()
        if not words or words[0][0] in ";#":
            continue
        before = first.setdefault(words[0].lower(), count)
        if before < count:
            message = f"{words[0][:60]} stands in line {before} already"
            faults.append(Diagnostic("parameter-file", message, span=Span(str(path), count)))
            continue
        try:
            if words[0].lower().startswith(_OF_THE_MACHINE):
                parameters.named[words[0].lower()] = _finite(words[1])
                continue
            number, value = int(words[0]), float(words[1])
            if not (0 < number <= parameters.last and math.isfinite(value)):
                raise ValueError
        except (ValueError, IndexError):
            message = (
                f"{line.strip()[:60]!r}: a line has a parameter number (1 to {parameters.last}) and a value"
            )
            faults.append(Diagnostic("parameter-file", message, span=Span(str(path), count)))
            continue
        parameters.numbers[number] = value
        parameters.listed.add(number)
    if faults:
        raise UsageError(faults)


#: Parameters that a file keeps from run to run (LinuxCNC manual, "Persistent parameters").
def persistent() -> list[int]:
    """Return the numbers of the parameters that are kept in a file."""
    kept = [n for first in (HOME_28, HOME_30) for n in range(first, first + 9)]
    kept += [*range(G92_ON, G92 + 9), SYSTEM]
    for system in range(SYSTEM_COUNT):
        kept += range(SYSTEMS + SYSTEM_STEP * system, SYSTEMS + SYSTEM_STEP * system + 10)
    return sorted(kept)


def write_parameters(path: Path, parameters: Parameters, replaces: Path | None) -> None:
    """Write the parameters that are kept, whole or not at all; the file may be the one that was read, which is `replaces`.

    Beside those of `persistent` they are what the file that was read names (LinuxCNC manual, "Parameter file format":
    a line in the file makes a parameter persistent), and FANUC's #500 to #999. One without a value has no line.

    Raises:
        UsageError: Where it cannot be written.
    """
    numbers = {*persistent(), *parameters.listed, *(KEPT_FANUC if parameters.vacant else ())}
    values = {number: parameters.numbers[number] for number in sorted(numbers)}
    text = "".join(f"{n}\t{value:.6f}\n" for n, value in values.items() if not math.isnan(value))
    write_text(path, text, replaces)

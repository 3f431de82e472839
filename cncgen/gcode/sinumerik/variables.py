"""The values of SINUMERIK's programs: R parameters, DEF variables, and system variables that are read here."""

from __future__ import annotations

import re
from array import array
from collections.abc import Callable
from dataclasses import dataclass, field

from cncgen.gcode.block import AXIS_INDEX
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.sinumerik import frame_variables, measuring, tool_data
from cncgen.gcode.sinumerik.expressions import IS_FILE, Scalar, number, whole

MOST_R = 32_767
#: Outputs of the control and data of its PLC, which move nothing.
_OUTPUTS = frozenset(("$A_OUT", "$A_OUTA", "$A_DBB", "$A_DBW", "$A_DBD", "$A_DBR"))
#: Memory of the channel, 0 until a program sets it.
_MARKERS = frozenset(("$AC_MARKER", "$AC_PARAM"))
#: Data of the machine and settings of its operator, which a program may write: $SC_…, $MA_….
_SETTINGS = re.compile(r"\$[MS][ACN]_")
#: A spindle by its name, as an index or an argument: ACC[S1].
_SPINDLE = re.compile(r"S[1-9]\d?")
#: What the machine tells the program: its inputs, and how far the handwheel has moved an axis.
_INPUTS = frozenset(("$A_IN", "$A_INA", "$A_INCO", "$AC_DRF"))
#: The axes of the plane in force, and the one across it.
_PLANE_AXES = ("$P_AXN1", "$P_AXN2", "$P_AXN3")
#: Times and counters that run on the control.
_COUNTERS = frozenset(
    f"$AC_{n}" for n in ("TIMER", "TIME", "CYCLE_TIME", "CUTTING_TIME", "OPERATING_TIME", "ACTUAL_PARTS", "TOTAL_PARTS",
                         "REQUIRED_PARTS", "SPECIAL_PARTS")
)  # fmt: skip
#: System variables of an axis: from which place they are.
_PLACES = {"$AA_IW": "program", "$P_EP": "program", "$AA_IB": "program", "$AA_IM": "machine"}


@dataclass(slots=True)
class Variable:
    """A variable: its type, the bounds of an array, and its values in a row."""

    kind: str
    bounds: tuple[int, ...]
    values: list[Scalar] = field(default_factory=list)

    def place(self, name: str, indices: list[Scalar]) -> int:
        """Return where an element stands; raise where the variable lacks it."""
        wanted = [whole(index, "an index") for index in indices]
        if len(wanted) != len(self.bounds):
            message = f"{name} has {len(self.bounds)} indices, not {len(wanted)}"
            raise BlockError("variable-index", message, name, hint="DEF gives the bounds")
        at = 0
        for index, bound in zip(wanted, self.bounds, strict=True):
            if not 0 <= index < bound:
                message = f"{name}[{index}]: its indices are 0 to {bound - 1}"
                raise BlockError("variable-index", message, name, hint="DEF gives the bounds")
            at = at * bound + index
        return at


def _said(name: str, *indices: Scalar) -> str:
    """Return a system variable as a program says it."""
    return f"{name}[{indices[0]:g}]" if len(indices) == 1 and isinstance(indices[0], float) else name


class Store:
    """The variables of a run; `scopes` are those of the programs in progress, the innermost last."""

    def __init__(self, ip: Interpreter) -> None:
        self.ip = ip
        self.tools = tool_data.ToolData(ip)
        #: How far machine coordinates 0 have gone by PRESETON, by axis.
        self.preset: dict[str, float] = {}
        #: Whether a text is the name of a program that is found (ISFILE).
        self.is_file: Callable[[str], bool] = lambda name: False
        #: The place in its group of the G function in force ($P_GG), and whether MCALL calls ($P_MC).
        self.in_force: Callable[[int], float] = float
        self.calls_modally: Callable[[], bool] = bool
        self.in_diameters: Callable[[], bool] = bool
        self.r = array("d", bytes(8 * (MOST_R + 1)))
        self.scopes: list[dict[str, Variable]] = [{}]
        #: Where the last motion with MEAS ended, in the program's coordinates and in the machine's.
        self.touched: tuple[list[float], list[float]] | None = None
        #: Outputs, and data shared with the PLC, that the program has set, by name and number.
        self._sent: dict[tuple[str, Scalar], Scalar] = {}
        #: Of these the signals of the machine that nothing has told; the system variables that a condition has asked, and whether each is one.
        self._untold: set[tuple[Scalar, ...]] = set()
        self.asked: dict[str, bool] = {}
        #: Settings of the machine that the program has written, by their names and indices.
        self._settings: dict[tuple[Scalar, ...], Scalar] = {}

    def define(self, kind: str, name: str, bounds: tuple[int, ...], values: list[Scalar]) -> None:
        """Define a variable of the program in progress."""
        count = 1
        for bound in bounds:
            count *= bound
        if not 1 <= count <= 1_000_000:
            message = f"{name} has {count} elements; an array has 1 to 1000000"
            raise BlockError("variable-index", message, name, hint="DEF REAL A[10]")
        if name in self.scopes[-1] or name in AXIS_INDEX or len(name) < 2:
            hint = "take another name of two characters or more"
            raise BlockError("variable-name", f"{name} is taken: it cannot be a variable", name, hint=hint)
        usual: Scalar = "" if kind in ("STRING", "AXIS") else 0.0
        row = (values + [usual] * count)[:count] if len(values) != 1 or bounds else [values[0]]
        self.scopes[-1][name] = Variable(kind, bounds, [self._kept(kind, name, value) for value in row])

    def _kept(self, kind: str, name: str, value: Scalar) -> Scalar:
        """Return a value as a variable of a type keeps it."""
        if kind in ("STRING", "CHAR", "AXIS"):
            return value
        what = f"the value of {name}"
        if kind == "INT":
            return float(whole(value, what))
        given = number(value, what)
        return float(given != 0.0) if kind == "BOOL" else given

    def _found(self, name: str) -> Variable | None:
        for scope in (self.scopes[-1], self.scopes[0]):
            if name in scope:
                return scope[name]
        return None

    def has(self, name: str) -> bool:
        """Tell whether a variable is defined."""
        return self._found(name) is not None

    def array(self, name: str) -> Variable | None:
        """Return a variable that is an array, as a whole."""
        variable = self._found(name)
        return variable if variable is not None and variable.bounds else None

    def memory(self) -> object:
        """Return what the program has kept in outputs, markers and settings."""
        return dict(self._sent), dict(self._settings)

    def parameter(self, index: float) -> float:
        return self.r[self._number(index)]

    def set_parameter(self, index: float, value: Scalar) -> None:
        self.r[self._number(index)] = number(value, f"the value of R{index:g}")

    def _number(self, index: float) -> int:
        if not 0 <= index <= MOST_R or index % 1.0:
            message = f"R{index:g}: R parameters are R0 to R{MOST_R}"
            raise BlockError("parameter-number", message, hint="its number is whole")
        return int(index)

    def value(self, name: str, indices: list[Scalar]) -> Scalar:
        """Return the value of a variable or of a system variable."""
        variable = self._found(name)
        if variable is not None:
            return variable.values[variable.place(name, indices)]
        if name == IS_FILE and len(indices) == 1 and isinstance(indices[0], str):
            return float(self.is_file(indices[0]))
        if name.startswith("$"):
            value = self._system(name, indices)
            self.asked[_said(name, *indices)] = (name, *indices) in self._untold
            return value
        if (name in "XYZABCUVW" or name in frame_variables.PARTS or _SPINDLE.fullmatch(name)) and not indices:
            return name
        hint = f"DEF REAL {name} at the top of the program; a parameter of PROC has a value where a program calls it"
        raise BlockError("variable-unknown", f"{name} has no value: no DEF gives it one", name, hint=hint)

    def set_value(self, name: str, indices: list[Scalar], value: Scalar) -> None:
        if name == "$R" and len(indices) == 1:
            self.set_parameter(number(indices[0], "the number of R"), value)
            return
        if (name in _OUTPUTS or name in _MARKERS) and len(indices) == 1:
            self._sent[name, indices[0]] = value
            self._untold.discard((name, indices[0]))
            return
        if _SETTINGS.match(name):
            self._settings[name, *indices] = value
            message = (
                f"{name} is a setting of the machine: what the program writes is kept, and does not act here"
            )
            hint = "the machine file has what is known of the machine here"
            self.ip.warn_once("machine-data", message, name, hint)
            return
        if name in _COUNTERS or name in _OUTPUTS:
            return
        if tool_data.names(name):
            self.tools.set(
                name, indices, number(value, f"the value of {name}") if not isinstance(value, str) else 0.0
            )
            return
        variable = self._found(name)
        if variable is None:
            message = f"{name} is not a variable, axis or word that is read"
            raise BlockError(
                "variable-unknown",
                message,
                name,
                hint=f"DEF REAL {name} defines a variable; axes are X Y Z A B C U V W here",
            )
        variable.values[variable.place(name, indices)] = self._kept(variable.kind, name, value)

    def _system(self, name: str, indices: list[Scalar]) -> Scalar:
        state = self.ip.state
        if name in _PLANE_AXES and not indices:
            return {17: "XYZ", 18: "ZXY", 19: "YZX"}[state.plane][_PLANE_AXES.index(name)]
        if len(indices) == 1 and (found := self._of_index(name, indices[0])) is not None:
            return found
        if name == frame_variables.ORIGINS:
            return frame_variables.part(self.ip, indices)
        if name in _COUNTERS:
            message = f"{name} is read as 0: the control's times and counters of parts do not run here"
            self.ip.warn_once("counter-stands", message, name, "check what the program does with it")
            return 0.0
        if (name, *indices) in self._settings:
            return self._settings[name, *indices]
        if tool_data.names(name):
            return self.tools.value(name, indices)
        tool = self.ip.tools.find(state.tool)
        plain = {
            "$P_TOOLNO": float(state.tool), "$P_F": state.feed, "$P_S": state.speed, "$P_MSNUM": 1.0, "$P_SIM": 0.0,
            "$P_TOOLR": (tool.diameter if tool else 0.0) * self.ip.table_scale() / 2.0, "$P_TOOLL": state.tool_offset[2],
            "$P_ISTEST": 0.0, "$P_SEARCH": 0.0, "$P_DRYRUN": 0.0, "$P_MC": float(self.calls_modally()),
            # The basic system is metric, as for G700 and G710.
            "$MN_SCALING_SYSTEM_IS_METRIC": 1.0,
        }  # fmt: skip
        if name not in plain:
            hint = f"read are {', '.join([*_PLACES, *_PLANE_AXES, *plain])}, $P_GG, $P_UIFR, $TC_DP"
            raise BlockError("variable-unknown", f"the system variable {name} is not read", name, hint=hint)
        return plain[name]

    def _of_index(self, name: str, index: Scalar) -> Scalar | None:
        """Return a system variable that has one index, None where it is none of those."""
        state, axis = self.ip.state, AXIS_INDEX.get(str(index).lower())
        if name in _PLACES and axis is not None:
            if _PLACES[name] == "program":
                return self._seen(name, axis, state.position[axis])
            return self.ip.machine_position()[axis] - self.preset.get(str(index).lower(), 0.0)
        if name in measuring.PLACES and axis is not None and self.touched is not None:
            place = self.touched[measuring.PLACES[name]][axis]
            return place if measuring.PLACES[name] else self._seen(name, axis, place)
        if name == measuring.SWITCHED:
            return float(self.touched is not None)
        if name in _INPUTS or name in _OUTPUTS:
            return self._signal(name, index)
        if name in _MARKERS:
            return self._sent.get((name, index), 0.0)
        if name == "$R":
            return self.parameter(number(index, "the number of R"))
        if name == "$P_GG":
            return self.in_force(whole(index, "the number of a group"))
        if name == "$P_AD":
            return self.tools.value(f"$TC_DP{whole(index)}", [float(state.tool), float(self.tools.edge)])
        return None

    def _seen(self, name: str, axis: int, place: float) -> float:
        """Return a place in the workpiece as words of its axis say it: of X a diameter where X words are."""
        if axis or not place or not self.in_diameters():
            return place
        message = f"{name}[X] is read as the diameter {2.0 * place:g}, as words of X are, not as the radius"
        hint = "so an X that is read and written back is the same; DIAMOF before it reads the radius"
        self.ip.warn_once("diameter-doubtful", message, name, hint)
        return 2.0 * place

    def _signal(self, name: str, index: Scalar) -> Scalar:
        """Return an input of the machine, or what the program has set of an output or of the data of the PLC."""
        if (name, index) not in self._sent:
            self._sent[name, index] = 0.0
            at = _said(name, index)
            message = f"{at} is a signal of the machine or its PLC, which is not known here: it counts as 0"
            hint = f"check what the program does where {at} is not 0"
            self.ip.warn_once("variable-assumed", message, name, hint)
            self._untold.add((name, index))
        return self._sent[name, index]

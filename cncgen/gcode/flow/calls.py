"""The calls in progress: the return place of each, and the local parameters that it restores."""

from __future__ import annotations

from array import array
from collections.abc import Callable

from cncgen.gcode.block import Value, evaluate
from cncgen.gcode.budget import CALL
from cncgen.gcode.errors import Astray, BlockError
from cncgen.gcode.text.labels import Cursor, Label

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter
    from cncgen.kernels.gcode_frames import Frame

#: Local numbered parameters: the arguments of a subroutine, #1 to #30, of a macro, #1 to #33.
LOCALS = 30
MACRO_LOCALS = 33


class Calls:
    """The stack of calls.

    Attributes:
        frames: The calls in progress; the kernel of `computing` begins and ends some.
    """

    def __init__(self, ip: Interpreter) -> None:
        self.ip = ip
        self.frames: list[Frame] = []
        self._outermost: Frame | None = None
        self._locals = MACRO_LOCALS if ip.dialect == "fanuc" else LOCALS
        #: Runs the blocks that wait, where the machine's state is about to change.
        self.flush: Callable[[], None] = lambda: None

    @property
    def outermost(self) -> Frame:
        """Return the record of the main program; its kernel is imported with the first one."""
        if self._outermost is None:
            self._outermost = self._record(0.0, {})
        return self._outermost

    @staticmethod
    def _record(label: Label, named: dict[str, float]) -> Frame:
        from cncgen.kernels.gcode_frames import Frame

        return Frame(label, named)

    @property
    def frame(self) -> Frame:
        """Return the innermost call, or the record of the main program."""
        return self.frames[-1] if self.frames else self.outermost

    @property
    def records(self) -> list[Frame]:
        """Return the records of the main program and of all calls in progress."""
        return [self.outermost, *self.frames]

    def enter(self, label: Label, back: Cursor, values: list[float] | None) -> Frame:
        """Begin a call with these local parameters (None, of M98: the numbered ones of the caller go on).

        Raises:
            Astray: Calls would nest deeper than the options allow.
        """
        self.ip.budget.spend(CALL if values is None else 3 * CALL)
        if len(self.frames) >= self.ip.options.max_call_depth:
            message = f"subroutine calls are nested more than {self.ip.options.max_call_depth} deep"
            raise Astray(BlockError("call-depth", message, hint="is the recursion without end?"))
        parameters = self.ip.parameters
        count = 0 if values is None else self._locals
        frame = self._record(label, parameters.local)
        frame.back = back
        frame.keep(parameters.numbers, count)
        self.frames.append(frame)
        parameters.local = {}
        if values is not None:
            frame.values = parameters.numbers[1 : count + 1] = array("d", values)
        return frame

    def leave(self, returned: tuple[Value, ...] = ()) -> Cursor:
        """End the innermost call, or its present time of several; return where that leads."""
        parameters = self.ip.parameters
        frame = self.frame
        value = evaluate(returned[0], parameters) if returned else 0.0
        if frame.again is not None and frame.again[1] > 0:
            self.ip.budget.spend(CALL)
            frame.again = (frame.again[0], frame.again[1] - 1)
            if frame.values is not None:
                parameters.numbers[1 : self._locals + 1] = frame.values
            return frame.again[0]
        self.frames.pop()
        frame.put_back(parameters.numbers)
        parameters.local = frame.named
        parameters.named["_value"] = value
        parameters.named["_value_returned"] = 1.0 if returned else 0.0
        if frame.restore and frame.saved is not None:
            from cncgen.gcode.codes.saved import restore

            self.flush()
            restore(self.ip, frame.saved)
        return Cursor(*frame.back)

    def give_up(self) -> None:
        """End all calls in progress; the main program has its local parameters back."""
        if self.frames:
            for frame in reversed(self.frames):
                frame.put_back(self.ip.parameters.numbers)
            self.ip.parameters.local = self.frames[0].named
            self.frames.clear()

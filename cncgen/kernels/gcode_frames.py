"""The calls in progress of a program in G-code, with what each keeps of its caller, and where its branches and loops lead."""

import cython
from cython.cimports.cncgen.kernels.gcode_codes import (
    AT_NEXT, AT_PREVIOUS, O_BREAK, O_CONTINUE, O_DO, O_ELSE, O_ELSEIF, O_ENDREPEAT, O_ENDWHILE, O_IF, O_REPEAT, O_WHILE,
    PAST_NEXT, PAST_PREVIOUS, STAY,
)  # fmt: skip

#: By keyword from IF on: where it leads whatever its value.
_ALWAYS = cython.declare(cython.int[15])
_k: cython.int
for _k in range(15):
    _ALWAYS[_k] = STAY
_ALWAYS[O_ELSE - O_IF] = _ALWAYS[O_ELSEIF - O_IF] = _ALWAYS[O_BREAK - O_IF] = PAST_NEXT
_ALWAYS[O_ENDWHILE - O_IF], _ALWAYS[O_CONTINUE - O_IF] = AT_PREVIOUS, AT_NEXT


@cython.freelist(64)
@cython.cclass
class Frame:
    """A call in progress.

    Attributes:
        label: Of the subroutine called.
        named: Local named parameters of the caller.
        count: How many numbered ones of the caller, from #1 on, are kept and put back; 0 where they go on.
        values: Numbered parameters that each time of several begins with, or None.
        again: Where a program called by its number begins, and how often it is still to run after this time; None for a subroutine.
        doing: Labels of DO loops under way, or None.
        left: Rounds left of REPEAT loops, by label, or None.
        saved, restore: Modal state that M70 or M73 kept here; whether the end of the call brings it back.
        modal: Whether G66 called it.
    """

    def __init__(self, label, named):
        if not cython.compiled:
            self.kept = [0.0] * 33
        self.label = label
        self.named = named
        self.source = self.offset = self.line = 0
        self.row = -1
        self.count = 0
        self.values = self.again = self.saved = self.doing = self.left = None
        self.restore = self.modal = False

    @property
    def back(self):
        """The line that the call goes back to: source, offset and number."""
        return self.source, self.offset, self.line

    @back.setter
    def back(self, line):
        self.source, self.offset, self.line = line

    @cython.ccall
    @cython.exceptval(check=False)
    def keep(self, numbers: cython.double[::1], count: cython.int) -> cython.void:
        """Keep numbered parameters, #1 and on."""
        k: cython.int
        self.count = count
        for k in range(count):
            self.kept[k] = numbers[k + 1]

    @cython.ccall
    @cython.exceptval(check=False)
    def put_back(self, numbers: cython.double[::1]) -> cython.void:
        """Give the caller its numbered parameters again."""
        k: cython.int
        for k in range(self.count):
            numbers[k + 1] = self.kept[k]

    def __reduce__(self):
        """Return the whole state of a call, in the form that the search for recurring states compares."""
        numbers = [self.kept[k] for k in range(self.count)]
        begun = (self.label, self.named)
        return (
            Frame,
            begun,
            (
                self.back,
                numbers,
                self.values,
                self.again,
                self.doing,
                self.left,
                self.saved,
                self.restore,
                self.modal,
            ),
        )

    @cython.ccall
    def repeats(self, label) -> cython.bint:
        """Tell whether REPEAT of a label goes round, so that its count is not asked for."""
        return self.left is not None and label in self.left

    @cython.ccall
    def lead(self, keyword: cython.longlong, label, value: cython.double) -> cython.int:
        """Return where an O-word of a branch or loop leads, and keep which loops go round.

        It leads on (`STAY`), or to or behind the O-word of its label that it looks for below or above (`AT_NEXT` …).

        A REPEAT that is met while it goes round, as CONTINUE of a loop around had left it, counts as the end of that round (seen on
        LinuxCNC's interpreter).

        Args:
            keyword: As in `gcode_codes.KEYWORDS`.
            label: Its label.
            value: The value of its condition, or the whole count of REPEAT; 0 where it has none.
        """
        if keyword == O_IF:
            return STAY if value != 0.0 else PAST_NEXT
        if keyword == O_WHILE:
            return self._at_while(label, value != 0.0)
        if keyword == O_REPEAT or keyword == O_ENDREPEAT:
            return self._at_repeat(keyword == O_REPEAT, label, value)
        if keyword == O_DO:
            if self.doing is None:
                self.doing = set()
            self.doing.add(label)
        elif keyword == O_BREAK:
            if self.doing is not None:
                self.doing.discard(label)
            self._go_round(label, 0)
        return _ALWAYS[keyword - O_IF]

    @cython.cfunc
    def _at_while(self, label, holds: cython.bint) -> cython.int:
        """Return where WHILE leads, the foot of a loop that DO began or the head of one."""
        if self.doing is None or label not in self.doing:
            return STAY if holds else PAST_NEXT
        if holds:
            return PAST_PREVIOUS
        self.doing.discard(label)
        return STAY

    @cython.cfunc
    def _at_repeat(self, begins: cython.bint, label, count: cython.double) -> cython.int:
        """Return where REPEAT or ENDREPEAT leads, with one round less to go."""
        rounds: cython.longlong = (
            self.left[label] - 1 if self.repeats(label) else cython.cast(cython.longlong, count)
        )
        self._go_round(label, rounds)
        if (rounds > 0) == begins:
            return STAY
        return PAST_NEXT if begins else PAST_PREVIOUS

    @cython.cfunc
    def _go_round(self, label, rounds: cython.longlong) -> cython.int:
        """Keep how many rounds of a REPEAT are left, this one with them."""
        if rounds > 0:
            self.left = self.left or {}
            self.left[label] = rounds
        elif self.left is not None:
            self.left.pop(label, None)
        return 0

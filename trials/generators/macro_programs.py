"""Random programs with FANUC's macros: settings, conditions, jumps, loops, calls, and what the control has no value for."""

from __future__ import annotations

import random

_VARIABLES = (1, 2, 3, 100, 101, 102, 103)
_FUNCTIONS = (
    "ABS",
    "FIX",
    "FUP",
    "ROUND",
    "SQRT",
    "SIN",
    "COS",
    "TAN",
    "ASIN",
    "ACOS",
    "BIN",
    "BCD",
    "LN",
    "EXP",
)
_OPERATORS = ("+", "-", "*", "/", " MOD ", " AND ", " OR ", " XOR ")
_RELATIONS = ("EQ", "NE", "GT", "GE", "LT", "LE")
#: Lines that act on the control, call, set vacant values, or are wrong.
_OTHERS = (
    "M98 P2000", "M98 P2000 L2", "G65 P3000 A1.5 B2. C#1", "G65 P3000 A#2", "T1 M6", "G4 P100", "S500 M3", "M8", "M9", "G91", "G90",
    "#3006=1 (STOP)", "/ G1 X3.", "#1=#0", "#2=#5041", "#103=#4003", "G0 Z5. T2", "G66 P3000 A2.", "G67", "G92 X0", "#100=#0",
    "#2=1.5 #3=#2+1", "G1 X#1 Y#2", "IF[1EQ1]THEN G1 X5.", "#1=3 GOTO 9990", "G1 G91 X1.", "G81 X1. Y1. Z-2. R1. F100.", "G80",
    "G1 X1. X2.", "DO 1", "END 2", "GOTO 77", "G17", "G2 X1. Y1. I.5 J0", "N5 G1 Z-#1", "M98 <SUB>", "G1 <SUB> X2.", "G10 L2 P1 X1.",
    "DPRNT[X#1[53]]", "#[#1+100]=2.", "#1=#[100+1]", "G1 X1. ,R1.", "G1 X#3 (A (B)", "G1 X#3 (A (B))", "#1=ROUND[#1*10]/10",
    "GOTO 20.5", "#101=9990 / G1 X2.", "G0 X[ROUND[#1]]", "M98 P2000 L3 (SUB)", "M98 P#101", "#1=4 M98 P3000", "G65 P3000 D1. E2. H3 M8 T#1",
    "G65 P2000 I1. J2. I3. L2", "N7 G65 P3000 X1. (ARGUMENTS)", "G65 A1. P2000 #2=3", "G90 G65 P3000", "G1 X2. M98 P2000", "/M98 P2000",
    "IF[#1GT1]THEN M98 P3000", "M99", "#2=1 M99 (BACK)", "M99 P20", "G65 P3000 S2 Q1. K5. M98", "M98 P3000.5", "M98 P32000", "M98 P9",
)  # fmt: skip


class MacroProgram:
    """A program with two subprograms; `text` is the whole of it."""

    def __init__(self, dice: random.Random) -> None:
        self._dice = dice
        self._labels = 0
        self._counters = 105
        settings = [f"#{k}={dice.randint(0, 5)}" for k in _VARIABLES if dice.random() < 0.8]
        lines = ["%", "O1000 (MAIN)", "G21 G90 G17 G0 X0 Y0 Z0", "F200.", *settings]
        lines += [*self._lines(dice.randint(5, 25), 0), "N9990", "M30"]
        for number in (2000, 3000):
            lines += [
                f"O{number}{dice.choice(('', ' G1 X1.', ' (PART)'))}",
                *self._lines(dice.randint(1, 6), 1),
                "M99",
            ]
        self.text = "\n".join([*lines, "%", ""])

    def _variable(self) -> str:
        return f"#{self._dice.choice(_VARIABLES)}"

    def _expression(self, depth: int = 0) -> str:
        dice, kind = self._dice, self._dice.random()
        if depth > 2 or kind < 0.3:
            return dice.choice(
                [self._variable(), self._variable(), f"{dice.uniform(-5, 9):.2f}", str(dice.randint(0, 9))]
            )
        if kind < 0.75:
            return f"[{self._expression(depth + 1)}{dice.choice(_OPERATORS)}{self._expression(depth + 1)}]"
        if kind < 0.95:
            return f"{dice.choice(_FUNCTIONS)}[{self._expression(depth + 1)}]"
        return f"ATAN[{self._expression(depth + 1)}]/[{self._expression(depth + 1)}]"

    def _condition(self) -> str:
        right = self._expression(1) if self._dice.random() < 0.7 else "#0"
        return f"[{self._expression(1)} {self._dice.choice(_RELATIONS)} {right}]"

    def _lines(self, count: int, depth: int) -> list[str]:
        return [line for _ in range(count) for line in self._step(depth)]

    def _step(self, depth: int) -> list[str]:
        dice, kind = self._dice, self._dice.random()
        if kind < 0.3:
            return [f"{self._variable()}={self._expression()}"]
        if kind < 0.5:
            feed = dice.choice(["", " F500.", " (NOTE)"])
            return [f"G{dice.choice([0, 1])} X[{self._expression(1)}] Y{dice.uniform(-9, 9):.2f}{feed}"]
        if kind < 0.6:
            return [
                f"IF{self._condition()}{dice.choice(['THEN', ''])}{self._variable()}={self._expression()}"
            ]
        if kind < 0.66:
            self._labels += 10
            label = self._labels
            go = f"IF{self._condition()}GOTO{label}" if dice.random() < 0.8 else f"#101={label}\nGOTO#101"
            return [
                go,
                *self._lines(dice.randint(0, 3), depth),
                f"N{label} {dice.choice(['', '#2=#2+1', 'G1 X1.'])}",
            ]
        if kind < 0.78 and depth < 3:
            self._counters += 1
            counter = f"#{self._counters}"
            begin = [f"{counter}=0", f"WHILE[{counter}LT{dice.randint(0, 4)}]DO{depth + 1}"]
            end = [f"{counter}={counter}+1", f"END{depth + 1}{dice.choice(['', ' (END)'])}"]
            return [*begin, *self._lines(dice.randint(1, 5), depth + 1), *end]
        if kind < 0.86:
            return [dice.choice(_OTHERS)]
        return [f"G1 X{dice.uniform(-9, 9):.3f} Y{dice.uniform(-9, 9):.3f} Z{dice.uniform(-2, 2):.2f}"]

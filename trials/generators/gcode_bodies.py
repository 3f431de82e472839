"""Random bodies of O-words: branches and loops within one another, left by BREAK, CONTINUE and RETURN of any label around them.

Every loop counts its rounds in a parameter of its own and ends after a few, whatever leaves the loops within it. What LinuxCNC's
interpreter does otherwise by intent of ours (docs/language.md) is left out: BREAK and CONTINUE of a REPEAT and of a DO, BREAK beside a DO,
and RETURN within a loop.
"""

from __future__ import annotations

import random
from collections.abc import Iterator

#: Structures within one another, and lines of a body at most.
_DEPTH = 4
_LINES = 70
#: Labels from one body to the next.
_STEP = 1000


class _Body:
    """The lines of a body while they are drawn."""

    def __init__(self, dice: random.Random, number: int, does: bool, again: bool) -> None:
        self.dice = dice
        self.lines: list[str] = []
        self.sub = self.label = _STEP * (number + 1)
        self.counter = 110
        #: Whether the body has DO loops, and then no BREAK.
        self.does = does
        #: Whether it can be called again, so that no REPEAT is left within a round.
        self.again = again
        #: REPEAT loops around.
        self.repeats = 0

    def move(self) -> None:
        """Add a line of motion that no other is like, monotonic in X and Z as profiles of turning are."""
        self.lines += ["#100=[#100+1]", "G1 X[#100] Z[0-#100]"]

    def condition(self) -> str:
        """Return a condition on how many motions there were."""
        divisor = self.dice.randint(2, 5)
        return f"[#100 MOD {divisor}] {self.dice.choice(('EQ', 'NE', 'LT', 'GE'))} {self.dice.randint(0, divisor - 1)}"

    def part(self, depth: int, loops: list[int]) -> None:
        """Add a few statements; `loops` are labels of the WHILE and DO loops around."""
        for _ in range(self.dice.randint(1, 3)):
            if len(self.lines) > _LINES:
                break
            kind = self.dice.random()
            if depth >= _DEPTH or kind < 0.35:
                self.move()
            elif kind < 0.5 and loops and not (self.again and self.repeats):
                self.leave(loops)
            elif kind < 0.4 and not self.repeats:
                self.give_back()
            elif kind < 0.7:
                self.branch(depth, loops)
            else:
                self.loop(depth, loops)

    def leave(self, loops: list[int]) -> None:
        """Add what leaves a loop where a condition holds."""
        self.label += 1
        label = self.label
        what = (
            f"o{self.dice.choice(loops)} {'continue' if self.does or self.dice.random() < 0.5 else 'break'}"
        )
        self.lines += [f"o{label} if [{self.condition()}]", what, f"o{label} endif"]

    def give_back(self) -> None:
        """Add what leaves the subroutine where a condition holds."""
        self.label += 1
        label = self.label
        self.lines += [f"o{label} if [{self.condition()}]", f"o{self.sub} return", f"o{label} endif"]

    def branch(self, depth: int, loops: list[int]) -> None:
        """Add IF with its branches."""
        self.label += 1
        label = self.label
        self.lines.append(f"o{label} if [{self.condition()}]")
        self.part(depth + 1, loops)
        for _ in range(self.dice.choice((0, 0, 1, 2))):
            self.lines.append(f"o{label} elseif [{self.condition()}]")
            self.part(depth + 1, loops)
        if self.dice.random() < 0.5:
            self.lines.append(f"o{label} else")
            self.part(depth + 1, loops)
        self.lines.append(f"o{label} endif")

    def loop(self, depth: int, loops: list[int]) -> None:
        """Add a loop of a few rounds."""
        self.label += 1
        self.counter += 1
        label, counter, rounds = self.label, self.counter, self.dice.randint(0, 3)
        count = f"#{counter}=[#{counter}+1]"
        kind = self.dice.choice(("while", "do" if self.does else "while", "repeat"))
        self.lines.append(f"#{counter}=0")
        if kind == "while":
            self.lines += [f"o{label} while [#{counter} LT {rounds}]", count]
            self.part(depth + 1, [*loops, label])
            self.lines.append(f"o{label} endwhile")
        elif kind == "do":
            self.lines += [f"o{label} do", count]
            self.part(depth + 1, loops)
            self.lines.append(f"o{label} while [#{counter} LT {rounds}]")
        else:
            self.lines.append(f"o{label} repeat [{rounds}]")
            self.repeats += 1
            self.part(depth + 1, loops)
            self.repeats -= 1
            self.lines.append(f"o{label} endrepeat")


def body(dice: random.Random, number: int, does: bool, again: bool) -> list[str]:
    """Return the lines of a random body with motions at its beginning and end.

    Args:
        dice: Draws.
        number: Of the body in its program, from 0.
        does: Whether it has loops of DO, and then no BREAK; the same for all bodies of a program.
        again: Whether it is called more than once, so that no REPEAT is left within a round.
    """
    drawn = _Body(dice, number, does, again)
    drawn.move()
    drawn.move()
    drawn.part(0, [])
    drawn.move()
    drawn.move()
    return drawn.lines


def ways(bodies: list[list[str]], file: str, again: bool) -> Iterator[tuple[str, str, str]]:
    """Yield each way of running bodies one after another: its name, the program, and the text of the file `file` (or "").

    Those that call a body more than once are among them if `again`.
    """
    labels = [_STEP * (number + 1) for number in range(len(bodies))]
    subs = [
        "\n".join([f"o{label} sub", *lines, f"o{label} endsub", ""])
        for label, lines in zip(labels, bodies, strict=True)
    ]
    head = "G21 G90 G18 G40 G8\nF100\n"

    def each(text: str) -> str:
        return (
            "".join(subs)
            + head
            + "".join("#100=0\n" + text.replace("LABEL", str(k)) for k in labels)
            + "M2\n"
        )

    flat = [
        "\n".join(["#100=0", *lines, ""]) for lines in bodies if not any("return" in line for line in lines)
    ]
    yield "in the main program", head + "".join(flat) + "M2\n", ""
    yield "called", each("oLABEL call\n"), ""
    yield (
        "called with blanks and remarks",
        each("/N 1 O LABEL Call [1] (x)\n").replace("\nG1 ", "\n(a remark)\nG1 "),
        "",
    )
    yield (
        "called in a file",
        f"{head}#100=0\no<{file}> call\nM2\n",
        subs[0].replace(f"o{labels[0]} ", f"o<{file}> "),
    )
    yield "as profiles", each("G0 X0 Z5\nG70 QLABEL X0 Z5\n"), ""
    if not again:
        return
    yield (
        "called in a loop",
        each("o[LABEL+900] repeat [2]\noLABEL call\n#100=0\no[LABEL+900] endrepeat\n"),
        "",
    )
    yield (
        "called by a subroutine",
        "o2 sub\no[#1] call\no2 endsub\n" + each("o2 call [LABEL]\no2 call [LABEL]\n"),
        "",
    )

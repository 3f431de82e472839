"""The tables of a grammar (``grammars/lalr.py``), and their run over a text: one for all languages.

One DFA finds the tokens that the parser's state allows, the longest first; the LALR automaton shifts and reduces them. A class with
`Tables` for its base gives meaning to tokens and rules. Small letters count as capitals.
"""

import cython
from cython.cimports.cncgen.kernels.decimals import is_blank, is_of_name


@cython.cclass
class Tables:
    """The tables of a grammar.

    Args:
        tables: A module of tables (``grammars/tables_*.py``).

    Attributes:
        text: The text, a byte a character; those beyond ASCII are alike.
        silent: By rule, whether it does nothing.
        stack: States, up to `depth`.
        taken: The place behind the token that is shifted.
        ended: The state of the DFA in which it ended.
        refused: Where the last text was refused, behind its last token where it ends too early.
        terminals: Names of the terminals, the end of the text last.
    """

    def __init__(self, tables):
        if not cython.compiled:
            self.widths = [0] * 5
        self.action, self.widths[0] = rows_of(tables.ACTION)
        self.goto, self.widths[1] = rows_of(tables.GOTO)
        self.move, self.widths[2] = rows_of(tables.MOVE)
        self.token, self.widths[3] = rows_of(tables.TOKEN)
        self.lead, self.widths[4] = rows_of(tables.LEAD)
        self.mode, self.classes = rows_of(tables.MODE)[0], rows_of(tables.CLASSES)[0]
        self.passed, self.apart = rows_of(tables.PASSED)[0], rows_of(tables.APART)[0]
        self.origin, self.length = rows_of(tables.ORIGIN)[0], rows_of(tables.LENGTH)[0]
        self.terminals, self.starts = tables.TERMINALS, tables.STARTS
        self.end = len(self.terminals) - 1
        self.stack = memoryview(bytearray(4 * 64)).cast("i")
        self.silent = memoryview(bytearray(4 * len(tables.RULES))).cast("i")
        self.depth = 0
        self.choose("start")

    def choose(self, start: str):
        """Choose the rule by which texts are read."""
        self.first, self.accept = self.starts[start]

    @cython.cfunc
    def run(self, at: cython.Py_ssize_t, size: cython.Py_ssize_t) -> cython.int:
        """Read the text from `at` to `size` by the rule that was chosen; return 1, or 0 where it is refused."""
        text: cython.const[cython.uchar][::1] = self.text
        kind: cython.int
        step: cython.int
        state: cython.int = self.first
        behind: cython.Py_ssize_t = at
        depth: cython.int = 0
        self.depth = 0
        self.stack[0] = state
        while True:
            # Most blanks are one.
            at += at < size and text[at] == 32
            while at < size and text[at] <= 32 and is_blank(text[at]):
                at += 1
            kind = self.end
            if at < size:
                kind = _find(self, text, at, size, self.mode[state] * self.widths[3])
                if kind < 0:
                    break
                if self.passed[kind]:
                    at = self.taken
                    continue
            step = self.action[state * self.widths[0] + kind]
            while step < 0 and (kind != self.end or state != self.accept):
                if not self.silent[-step - 1] and self._reduced(-step - 1, at) == 0:
                    return 0
                depth -= self.length[-step - 1]
                step = self.goto[self.stack[depth] * self.widths[1] + self.origin[-step - 1]]
                state = self.lead[step * self.widths[4] + kind]
                depth = _put(self, depth + 1, state)
                step = self.action[state * self.widths[0] + kind]
            if kind == self.end and state == self.accept:
                return 1
            if step <= 0:
                break
            if self._shifted(kind, at) == 0:
                return 0
            state = step - 1
            depth = _put(self, depth + 1, state)
            at = behind = self.taken
        self.refused = at if at < size else behind
        return 0

    @cython.cfunc
    def _shifted(self, kind: cython.int, at: cython.Py_ssize_t) -> cython.int:
        """Take a token that begins at a place; return 0 to refuse the text."""
        raise NotImplementedError

    @cython.cfunc
    def _reduced(self, rule: cython.int, at: cython.Py_ssize_t) -> cython.int:
        """Take a rule whose parts were taken, before the token at a place; return 0 to refuse the text."""
        raise NotImplementedError

    def expected(self) -> list:
        """Return the names of the terminals that could stand where the last text was refused."""
        return [self.terminals[kind] for kind in range(self.end + 1) if self._fits(kind)]

    def _fits(self, kind: cython.int) -> bool:
        """Tell whether a terminal could stand where the last text was refused: its reductions lead to a shift."""
        # Of the stack the lower part, as far as it stays, and what is put on it.
        kept: cython.int = self.depth
        more: list = [self.stack[kept]]
        state: cython.int = more[0]
        step: cython.int
        gone: cython.int
        while not (kind == self.end and state == self.accept):
            step = self.action[state * self.widths[0] + kind]
            if step >= 0:
                return step > 0
            gone = min(self.length[-step - 1], len(more))
            kept -= self.length[-step - 1] - gone
            del more[len(more) - gone :]
            state = more[len(more) - 1] if more else self.stack[kept - 1]
            state = self.goto[state * self.widths[1] + self.origin[-step - 1]]
            state = self.lead[state * self.widths[4] + kind]
            more.append(state)
        return True


@cython.cfunc
@cython.inline
def _put(tables: Tables, depth: cython.int, state: cython.int) -> cython.int:
    """Put a state on the stack, which becomes twice as deep where it must; return its place."""
    if depth == tables.stack.shape[0]:
        deeper = memoryview(bytearray(8 * depth)).cast("i")
        deeper[:depth] = tables.stack
        tables.stack = deeper
    tables.stack[depth] = state
    tables.depth = depth
    return depth


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _find(
    tables: Tables,
    text: cython.const[cython.uchar][::1],
    at: cython.Py_ssize_t,
    size: cython.Py_ssize_t,
    mode: cython.int,
) -> cython.int:
    """Return the terminal of the longest token at a place that a mode of the scanner has, -1 for none; `taken` is the place behind it."""
    found: cython.int = -1
    kind: cython.int
    ended: cython.int = 0
    taken: cython.Py_ssize_t = at
    d: cython.int = 0
    c: cython.int
    while at < size:
        c = text[at]
        d = tables.move[d * tables.widths[2] + tables.classes[c]]
        if d < 0:
            break
        at += 1
        kind = tables.token[mode + d]
        if kind == -2:
            break
        # c is the last character of the token.
        if kind >= 0 and not (tables.apart[kind] and is_of_name(c) and at < size and is_of_name(text[at])):
            found, taken, ended = kind, at, d
    tables.taken, tables.ended = taken, ended
    return found


def rows_of(table):
    """Return the numbers of a table of a generated module, and how many columns it has."""
    return memoryview(table[1]).cast("h"), table[0]

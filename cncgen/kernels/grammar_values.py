"""Read text by the tables of a grammar (``grammars/lalr.py``) into values: each rule's function makes its value of those of its parts.

One DFA finds the tokens that the parser's state allows, the longest first; the LALR automaton shifts them, as strings, and calls
the functions of the rules that it reduces. Blanks and comments stand between tokens, and small letters count as capitals. Parts are
left out, spliced in and passed on as Lark's own parser does, which is the reference in the tests.
"""

import cython


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _is_blank(c: cython.int) -> cython.bint:
    """Tell whether a character is a blank."""
    return c == 32 or c == 9 or c == 13


@cython.cfunc
@cython.inline
@cython.exceptval(check=False)
def _is_of_name(c: cython.int) -> cython.bint:
    """Tell whether a character may stand in a name."""
    return 48 <= c <= 57 or 97 <= (c | 32) <= 122 or c == 95


@cython.final
@cython.cclass
class Reader:
    """The tables of a grammar, and what reads texts by them.

    Args:
        tables: A module of tables (``grammars/tables_*.py``).
        functions: Functions that make the value of a rule, by its alias or name.

    Attributes:
        begin: Where the rule begins whose function runs.
        error: Where the last text was refused, behind its last token where it ends too early; -1 where it was read.
        terminals: Names of the terminals, the end of the text last.
    """

    begin = cython.declare(cython.Py_ssize_t, visibility="public")
    error = cython.declare(cython.Py_ssize_t, visibility="public")
    terminals = cython.declare(tuple, visibility="public")
    action: cython.const[cython.short][::1]
    goto: cython.const[cython.short][::1]
    move: cython.const[cython.short][::1]
    token: cython.const[cython.short][::1]
    mode: cython.const[cython.short][::1]
    classes: cython.const[cython.short][::1]
    origin: cython.const[cython.short][::1]
    length: cython.const[cython.short][::1]
    alone: cython.int[::1]
    passed: cython.const[cython.short][::1]
    apart: cython.const[cython.short][::1]
    widths = cython.declare(cython.int[4])
    starts = cython.declare(dict)
    functions = cython.declare(list)
    parts = cython.declare(list)
    single = cython.declare(list)
    states = cython.declare(list)
    accept = cython.declare(cython.int)
    end = cython.declare(cython.int)
    taken = cython.declare(cython.Py_ssize_t)

    def __init__(self, tables, functions):
        if not cython.compiled:
            self.widths = [0] * 4
        self.action, self.widths[0] = _rows(tables.ACTION)
        self.goto, self.widths[1] = _rows(tables.GOTO)
        self.move, self.widths[2] = _rows(tables.MOVE)
        self.token, self.widths[3] = _rows(tables.TOKEN)
        self.mode, self.classes = _rows(tables.MODE)[0], _rows(tables.CLASSES)[0]
        self.passed, self.apart = _rows(tables.PASSED)[0], _rows(tables.APART)[0]
        self.origin, self.length = _rows(tables.ORIGIN)[0], _rows(tables.LENGTH)[0]
        self.terminals, self.starts = tables.TERMINALS, tables.STARTS
        self.end = len(self.terminals) - 1
        self.functions = [functions[name] if name else None for name, _, _ in tables.RULES]
        self.single = [single for _, single, _ in tables.RULES]
        self.alone = memoryview(bytearray(4 * len(tables.RULES))).cast("i")
        for k, (name, single, parts) in enumerate(tables.RULES):
            self.alone[k] = single and len(parts) == 1 and parts[0] == 0 and self.length[k] == 1
        self.parts = [parts for _, _, parts in tables.RULES]
        self.states = []
        self.begin, self.error = 0, -1

    def expected(self) -> list:
        """Return the names of the terminals that could stand where the last text was refused."""
        return [self.terminals[kind] for kind in range(self.end + 1) if self._fits(kind)]

    def parse(self, text: str, start: str = "start"):
        """Return the value of a text, None where it is refused (then `error` says where).

        Args:
            text: One block, or a part of one.
            start: The rule that it is read by.
        """
        at: cython.Py_ssize_t = 0
        behind: cython.Py_ssize_t = 0
        size: cython.Py_ssize_t = len(text)
        kind: cython.int
        step: cython.int
        state: cython.int
        states: list = []
        values: list = []
        places: list = []
        state, self.accept = self.starts[start]
        states.append(state)
        self.error = -1
        while True:
            while at < size and _is_blank(ord(text[at])):
                at += 1
            kind = self.end
            if at < size:
                kind = self._token(text, at, size, self.mode[state] * self.widths[3])
                if kind < 0:
                    break
                if self.passed[kind]:
                    at = self.taken
                    continue
            step = self.action[state * self.widths[0] + kind]
            while step < 0 and (kind != self.end or state != self.accept):
                if self.alone[-step - 1]:
                    # An operand of an operator that is not there: its value stays as it is.
                    state = states[len(states) - 2]
                    state = self.goto[state * self.widths[1] + self.origin[-step - 1]]
                    states[len(states) - 1] = state
                else:
                    state = self._reduce(-step - 1, states, values, places, at)
                step = self.action[state * self.widths[0] + kind]
            if kind == self.end and state == self.accept:
                return values[0]
            if step <= 0:
                break
            state = step - 1
            states.append(state)
            values.append(text[at : self.taken])
            places.append(at)
            at = behind = self.taken
        self.error, self.states = (at if at < size else behind), states
        return None

    @cython.cfunc
    @cython.exceptval(-2, check=False)
    def _token(
        self, text: str, at: cython.Py_ssize_t, size: cython.Py_ssize_t, mode: cython.int
    ) -> cython.int:
        """Return the terminal of the longest token at a place that a mode of the scanner has, -1 for none; `taken` is the place behind it."""
        found: cython.int = -1
        kind: cython.int
        d: cython.int = 0
        c: cython.int
        while at < size:
            c = ord(text[at])
            d = self.move[d * self.widths[2] + self.classes[c if c < 128 else 128]]
            if d < 0:
                break
            at += 1
            kind = self.token[mode + d]
            # c is the last character of the token.
            if kind >= 0 and not (
                self.apart[kind] and _is_of_name(c) and at < size and _is_of_name(ord(text[at]))
            ):
                found = kind
                self.taken = at
        return found

    @cython.cfunc
    @cython.exceptval(-1)
    def _reduce(
        self, rule: cython.int, states: list, values: list, places: list, at: cython.Py_ssize_t
    ) -> cython.int:
        """Put the value of a rule in the place of those of its parts, and return the state behind it."""
        base: cython.Py_ssize_t = len(values) - self.length[rule]
        part: cython.int
        function = self.functions[rule]
        children: list = []
        parts: tuple = self.parts[rule]
        first: cython.Py_ssize_t = 0
        if function is None and len(parts) > 0 and parts[0] == 1:
            # A list that grows.
            children = values[base]
            first = 1
        for k in range(first, len(parts)):
            part = parts[k]
            if part < 0:
                children.append(None)
            elif part & 1:
                children.extend(values[base + (part >> 1)])
            else:
                children.append(values[base + (part >> 1)])
        if base < len(places):
            at = places[base]
        self.begin = at
        value = children
        if self.single[rule] and len(children) == 1:
            value = children[0]
        elif function is not None:
            value = function(*children)
        del values[base:]
        del places[base:]
        del states[base + 1 :]
        values.append(value)
        places.append(at)
        state: cython.int = states[base]
        state = self.goto[state * self.widths[1] + self.origin[rule]]
        states.append(state)
        return state

    def _fits(self, kind: cython.int) -> bool:
        """Tell whether a terminal could stand where the last text was refused: its reductions lead to a shift."""
        stack: list = list(self.states)
        state: cython.int = stack.pop()
        step: cython.int
        while not (kind == self.end and state == self.accept):
            step = self.action[state * self.widths[0] + kind]
            if step >= 0:
                return step > 0
            stack.append(state)
            del stack[len(stack) - self.length[-step - 1] :]
            state = stack[len(stack) - 1]
            state = self.goto[state * self.widths[1] + self.origin[-step - 1]]
        return True


def _rows(table):
    """Return the numbers of a table of a generated module, and how many columns it has."""
    return memoryview(table[1]).cast("h"), table[0]

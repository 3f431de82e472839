"""Read text by the tables of a grammar (`grammar_tables`) into values: each rule's function makes its value of those of its parts.

Tokens are strings. Parts are left out, spliced in and passed on as Lark's own parser does, which is the reference in the tests.
"""

import cython
from cython.cimports.cncgen.kernels.grammar_tables import Tables


@cython.final
@cython.cclass
class Reader(Tables):
    """The tables of a grammar, and what reads texts by them.

    Args:
        tables: A module of tables (``grammars/tables_*.py``).
        functions: Functions that make the value of a rule, by its alias or name.

    Attributes:
        begin: Where the rule begins whose function runs.
        error: Where the last text was refused, behind its last token where it ends too early; -1 where it was read.
    """

    begin = cython.declare(cython.Py_ssize_t, visibility="public")
    error = cython.declare(cython.Py_ssize_t, visibility="public")
    functions = cython.declare(list)
    parts = cython.declare(list)
    single = cython.declare(list)
    said = cython.declare(str)
    values = cython.declare(list)
    places = cython.declare(list)

    def __init__(self, tables, functions):
        Tables.__init__(self, tables)
        self.functions = [functions[name] if name else None for name, _, _ in tables.RULES]
        self.single = [single for _, single, _ in tables.RULES]
        for k, (name, single, parts) in enumerate(tables.RULES):
            # An operand of an operator that is not there: its value stays as it is.
            self.silent[k] = single and len(parts) == 1 and parts[0] == 0 and self.length[k] == 1
        self.parts = [parts for _, _, parts in tables.RULES]
        self.begin, self.error = 0, -1

    def parse(self, text: str, start: str = "start"):
        """Return the value of a text, None where it is refused (then `error` says where).

        Args:
            text: One block, or a part of one.
            start: The rule that it is read by.
        """
        self.text = text.encode("ascii") if text.isascii() else bytes([min(ord(c), 128) for c in text])
        self.said, self.values, self.places = text, [], []
        self.choose(start)
        if self.run(0, len(text)):
            self.error = -1
            return self.values[0]
        self.error = self.refused
        return None

    @cython.cfunc
    def _shifted(self, kind: cython.int, at: cython.Py_ssize_t) -> cython.int:
        """Take a token as a string."""
        self.values.append(self.said[at : self.taken])
        self.places.append(at)
        return 1

    @cython.cfunc
    def _reduced(self, rule: cython.int, at: cython.Py_ssize_t) -> cython.int:
        """Put the value of a rule in the place of those of its parts."""
        values: list = self.values
        places: list = self.places
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
        values.append(value)
        places.append(at)
        return 1

"""Parse tables of the grammars, made when cncgen is built: Lark's LALR tables, and one DFA of all terminals.

``setup.py`` calls `write_all`, which writes a module of bytes for each grammar beside it (``tables_NAME.py``). The kernel
`cncgen.kernels.grammar_tables` runs them: for `gcode_parse` those of `GRAMMARS`, by actions that it knows, for `grammar_values` those of
`VALUES`, whose rules have functions in Python. A table is made anew where the grammar, this module or the kernel's list of actions has changed.

    action[state, terminal]   0 error, n > 0 shift to state n - 1, n < 0 reduce by rule -n - 1
    goto[state, nonterminal]  number of the pair, -1 for none
    lead[pair, terminal]      the state behind the nonterminal, once rules that pass it on alone are reduced too (a sum of one product)
    move[d, class of a byte]  next state of the DFA, -1 where no terminal goes on
    token[mode, d]            terminal that ends in d, for parser states of that mode; -1 for none, -2 where none ends further on either

The longest match that the parser's state allows wins, then the higher priority, then what is written as a string. Two terminals of one
priority that match the same text in one state break the build, unless `BEATEN` has a reason why the string is meant. What a pattern says of the text behind it, (?!...), is for Lark, whose first match wins, and is passed over here, but `APART`. A blank that no terminal takes is
passed over, and capital letters are small ones.
"""

from __future__ import annotations

import ast
import hashlib
import runpy
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

HERE = Path(__file__).parent
KERNEL = HERE.parent / "cncgen" / "kernels" / "gcode_codes.py"
#: The kernel that reads plain blocks by itself, and names the terminals that it does so for.
SCANNER = KERNEL.with_name("gcode_scan.py")
#: Grammar files by the name of their tables.
GRAMMARS = {"linuxcnc": "gcode.lark", "fanuc": "fanuc.lark"}
#: The same of languages whose rules make values, and the rules that a text may be read by.
VALUES: dict[str, tuple[str, tuple[str, ...]]] = {
    "heidenhain": ("heidenhain.lark", ("start", "named_words")),
    "din_iso": ("din_iso.lark", ("start",)),
    "sinumerik": ("sinumerik.lark", ("start",)),
}
#: What no letter, digit or underscore may follow, though no longer token is allowed there: GOTOFLABEL is no GOTOF LABEL.
APART = "(?![A-Z0-9_])"
#: Patterns that may match what is written as a string too, with no priority to tell which is meant, by grammar; and why the string wins.
BEATEN = {"sinumerik": {"NAME": "a word of the language is no name where both may stand"}}
#: Bytes of the alphabet: ASCII, and one for all others.
_OTHER = 128
#: Blanks, which may stand anywhere in a token of G-code.
_BLANKS = b" \t\r"


class GrammarError(Exception):
    """A grammar and the kernel's actions do not fit."""


class _Label(NamedTuple):
    """What ends in a state of the automaton: a terminal, and which of its literals (-1: it is no list of literals)."""

    terminal: int
    literal: str


class _Automaton:
    """A nondeterministic automaton of all terminals."""

    def __init__(self) -> None:
        self.moves: list[list[tuple[frozenset[int], int]]] = []
        self.silent: list[list[int]] = []
        self.labels: dict[int, _Label] = {}

    def state(self) -> int:
        self.moves.append([])
        self.silent.append([])
        return len(self.moves) - 1

    def add(self, terminal: int, pattern: Any, start: int) -> None:
        """Add a pattern of Lark's."""
        literals = [pattern.value] if pattern.type == "str" else _literals(pattern.value)
        if literals is None:
            end = self.state()
            self._join(self._sequence(_parsed(pattern.value), start), end)
            self.labels[end] = _Label(terminal, "")
            return
        for literal in literals:
            here = start
            for character in literal:
                here = self._step(here, _both({min(ord(character), _OTHER)}))
            end = self.state()
            self._join(here, end)
            self.labels[end] = _Label(terminal, literal)

    def _join(self, a: int, b: int) -> None:
        self.silent[a].append(b)

    def _step(self, here: int, characters: frozenset[int]) -> int:
        end = self.state()
        self.moves[here].append((characters, end))
        return end

    def _sequence(self, parsed: Any, here: int) -> int:
        for kind, value in parsed:
            here = self._part(str(kind), value, here)
        return here

    def _part(self, kind: str, value: Any, here: int) -> int:
        if kind == "LITERAL":
            return self._step(here, _both({min(value, _OTHER)}))
        if kind == "NOT_LITERAL":
            return self._step(here, frozenset(range(_OTHER + 1)) - _both({value}))
        if kind == "IN":
            return self._step(here, _set_of(value))
        if kind == "SUBPATTERN":
            return self._sequence(value[3], here)
        if kind == "BRANCH":
            end = self.state()
            for branch in value[1]:
                self._join(self._sequence(branch, here), end)
            return end
        if kind == "MAX_REPEAT":
            return self._repeat(*value, here)
        if kind == "ASSERT_NOT":
            return here
        raise GrammarError(f"{kind} is not of the regular expressions that tables are made of")

    def _repeat(self, least: int, most: Any, inner: Any, here: int) -> int:
        for _ in range(least):
            here = self._sequence(inner, here)
        if str(most) == "MAXREPEAT":
            loop, end = self.state(), self.state()
            self._join(here, loop)
            self._join(self._sequence(inner, loop), loop)
            self._join(loop, end)
            return end
        end = self.state()
        for _ in range(int(most) - least):
            self._join(here, end)
            here = self._sequence(inner, here)
        self._join(here, end)
        return end

    def closure(self, states: frozenset[int]) -> frozenset[int]:
        waiting, found = list(states), set(states)
        while waiting:
            for state in self.silent[waiting.pop()]:
                if state not in found:
                    found.add(state)
                    waiting.append(state)
        return frozenset(found)


def _parsed(pattern: str) -> Any:
    import re._parser as parser  # type: ignore[import-not-found]

    return parser.parse(pattern)


def _both(characters: Iterable[int]) -> frozenset[int]:
    """Return characters with the other case of the letters among them."""
    return frozenset(ord(c) for code in characters for c in (chr(code).upper(), chr(code).lower()))


def _set_of(parts: Any) -> frozenset[int]:
    """Return the characters of a set in brackets."""
    found: set[int] = set()
    negative = False
    for kind, value in parts:
        if str(kind) == "NEGATE":
            negative = True
        elif str(kind) == "LITERAL":
            found.add(min(value, _OTHER))
        elif str(kind) == "RANGE":
            found.update(range(value[0], min(value[1], _OTHER) + 1))
        else:
            raise GrammarError(f"{kind} in a set of characters")
    return frozenset(range(_OTHER + 1)) - _both(found) if negative else _both(found)


def _literals(pattern: str) -> list[str] | None:
    """Return the strings of a pattern that is nothing but alternatives of strings, else None."""
    import re

    parts = re.split(r"(?<!\\)\|", pattern)
    if any(re.search(r"[\[\](){}*+?.^$\\]", re.sub(r"\\\W", "", part)) for part in parts):
        return None
    return [re.sub(r"\\(\W)", r"\1", part) for part in parts]


class _Scanner(NamedTuple):
    """One DFA: moves, what ends in each state."""

    moves: list[list[int]]
    ends: list[list[_Label]]


def _scanner(patterns: list[Any]) -> _Scanner:
    """Return the DFA of terminals by subset construction."""
    automaton = _Automaton()
    start = automaton.state()
    for terminal, pattern in enumerate(patterns):
        automaton.add(terminal, pattern, start)
    first = automaton.closure(frozenset({start}))
    number, waiting = {first: 0}, [first]
    moves: list[list[int]] = []
    ends: list[list[_Label]] = []
    while waiting:
        here = waiting.pop(0)
        ends.append([automaton.labels[s] for s in sorted(here) if s in automaton.labels])
        steps = [step for state in here for step in automaton.moves[state]]
        row = []
        for byte in range(_OTHER + 1):
            to = automaton.closure(frozenset(end for characters, end in steps if byte in characters))
            if to and to not in number:
                number[to] = len(number)
                waiting.append(to)
            row.append(number[to] if to else -1)
        moves.append(row)
    return _Scanner(moves, ends)


def _spread(scanner: _Scanner) -> _Scanner:
    """Return a DFA of the same tokens with blanks within them, which none ends with."""
    moves, ends = [[*row] for row in scanner.moves], [*scanner.ends]
    for state, row in enumerate(scanner.moves):
        blanks = [blank for blank in _BLANKS if row[blank] < 0]
        if state > 0 and blanks and max(row) >= 0:
            among = [*row]
            for blank in blanks:
                moves[state][blank] = among[blank] = len(moves)
            moves.append(among)
            ends.append([])
    return _Scanner(moves, ends)


def _alike(moves: list[list[int]], ends: list[list[_Label]]) -> list[int]:
    """Return the number of the class of each state of a DFA; states of one class scan alike (Moore)."""
    found = [ends.index(labels) for labels in ends]
    while True:
        keys = [
            (found[state], *(found[to] if to >= 0 else -1 for to in row)) for state, row in enumerate(moves)
        ]
        numbers = {key: k for k, key in enumerate(dict.fromkeys(keys))}
        finer = [numbers[key] for key in keys]
        if len(numbers) == len(set(found)):
            return finer
        found = finer


def _shaped(scanner: _Scanner) -> bool:
    """Tell whether no terminal hangs on which digits stand in a number, or on how many (`gcode_lines`)."""
    moves, classes = scanner.moves, _alike(scanner.moves, scanner.ends)
    digits = range(ord("0"), ord("9") + 1)
    if any(len({row[digit] for digit in digits}) > 1 for row in moves):
        return False
    firsts = {row[digits[0]] for row in moves} - {-1}
    return all(
        (again := moves[first][digits[0]]) >= 0 and classes[again] == classes[first] for first in firsts
    )


def _folded(moves: list[list[int]]) -> tuple[list[int], list[list[int]]]:
    """Return the class of each of 256 bytes, and the moves by class."""
    columns = [tuple(row[byte] for row in moves) for byte in range(_OTHER + 1)]
    classes = {column: index for index, column in enumerate(dict.fromkeys(columns))}
    of_byte = [classes[columns[min(byte, _OTHER)]] for byte in range(256)]
    return of_byte, [list(row) for row in zip(*classes, strict=True)]


def _terminals_of_scanner() -> dict[str, tuple[str, ...]]:
    """Return how the scanner of plain blocks reads terminals, from its source, which takes a compiler to import."""
    nodes = (n for n in ast.parse(SCANNER.read_text("utf-8")).body if isinstance(n, ast.Assign))
    value = next(
        n.value for n in nodes if isinstance(n.targets[0], ast.Name) and n.targets[0].id == "TERMINALS"
    )
    found: dict[str, tuple[str, ...]] = ast.literal_eval(value)
    return found


def _kernel_names() -> tuple[Any, ...]:
    """Return the actions of rules and the literals that the kernel knows."""
    kernel = runpy.run_path(str(KERNEL))
    return kernel["ACTIONS"], kernel["LITERALS"]


def _check_scanner(terminals: dict[str, Any]) -> None:
    """Raise where the scanner of plain blocks reads a terminal otherwise than a grammar has it."""
    patterns = {_bare(name): terminal.pattern.value for name, terminal in terminals.items()}
    for name, readings in _terminals_of_scanner().items():
        if patterns.get(name) not in readings:
            raise GrammarError(
                f"{SCANNER.name} reads {name} as {readings[0]}, the grammar has {patterns.get(name)}"
            )


def _path_and_starts(name: str) -> tuple[str, tuple[str, ...]]:
    return VALUES.get(name) or (GRAMMARS[name], ("start",))


def _lark(name: str) -> Any:
    from lark import Lark

    path, starts = _path_and_starts(name)
    options = {"parser": "lalr", "lexer": "contextual", "maybe_placeholders": name in VALUES}
    return Lark.open(str(HERE / path), start=list(starts), **options)


def _bare(name: str) -> str:
    """Return a name without the prefix that an import gives it."""
    return name.rpartition("__")[2] if not name.startswith("_") else name


def digest(name: str) -> str:
    """Return what tells the tables of a grammar from those of another state of it."""
    parts = [path.read_bytes() for path in sorted(HERE.glob("*.lark"))]
    parts += [
        Path(__file__).read_bytes(),
        SCANNER.read_bytes(),
        repr((name, _kernel_names())).encode(),
    ]
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def _check_actions(rules: list[Any], actions: dict[str, int]) -> None:
    """Raise where the kernel does not know a rule that is more than the value of a part."""
    for rule in rules:
        name = _made_of(rule)[0]
        alone = not rule.alias and len([s for s in rule.expansion if not s.is_term]) == 1
        if name and name not in actions and not alone:
            raise GrammarError(f"the rule {name} has no action in {KERNEL.name}")


def _leads(
    rules: tuple[tuple[str, bool, tuple[int, ...]], ...],
    origins: list[int],
    action: list[list[int]],
    goto: list[list[int]],
) -> tuple[list[list[int]], list[list[int]]]:
    """Return `goto` by pairs, and `lead`, from the states that nonterminals lead to."""
    passes = [not name and single and parts == (0,) for name, single, parts in rules]
    pairs = [[-1] * len(row) for row in goto]
    lead: list[list[int]] = []
    for below, row in enumerate(goto):
        for nonterminal, first in enumerate(row):
            if first < 0:
                continue
            pairs[below][nonterminal] = len(lead)
            lead.append([first] * len(action[0]))
            for terminal in range(len(action[0])):
                while (rule := -action[lead[-1][terminal]][terminal] - 1) >= 0 and passes[rule]:
                    lead[-1][terminal] = goto[below][origins[rule]]
    return pairs, lead


class _Rows(NamedTuple):
    """Lark's LALR table as lists: terminals by name, with the end; number of each state; rules, and the nonterminal of each."""

    terminals: dict[str, Any]
    names: list[str]
    states: dict[Any, int]
    rules: list[Any]
    origins: list[int]
    action: list[list[int]]
    goto: list[list[int]]


def _rows(lark: Any) -> _Rows:
    table = lark.parser.parser._parse_table
    terminals = {str(t.name): t for t in lark.terminals}
    names = [*terminals, "$END"]
    number = {n: i for i, n in enumerate(names)}
    states = {s: i for i, s in enumerate(table.states)}
    rules: dict[Any, int] = {}
    nonterminals: dict[str, int] = {}
    action = [[0] * len(names) for _ in states]
    jumps: list[dict[int, int]] = [{} for _ in states]
    for state, row in table.states.items():
        for symbol, (kind, to) in row.items():
            symbol = str(symbol)
            if symbol not in number:
                jumps[states[state]][nonterminals.setdefault(symbol, len(nonterminals))] = states[to]
            elif "Shift" in repr(kind):
                action[states[state]][number[symbol]] = states[to] + 1
            else:
                action[states[state]][number[symbol]] = -(rules.setdefault(to, len(rules)) + 1)
    origins = [nonterminals.setdefault(str(r.origin.name), len(nonterminals)) for r in rules]
    goto = [[jump.get(k, -1) for k in range(len(nonterminals))] for jump in jumps]
    return _Rows(terminals, names, states, list(rules), origins, action, goto)


def tables(name: str) -> dict[str, Any]:
    """Return the tables of a grammar as plain lists.

    Beside those that parse, ``passed`` tells of each terminal whether it is passed over (comments), ``apart`` whether it is `APART`, and
    ``rules`` says of each rule the name of its function or action ("": its parts are a list), whether one part alone is passed on, and its
    parts: twice the place among its symbols, one more where that is a list to be spliced in; -1 for one that is left out in brackets.
    Those of G-code have the number of the literal that ends in a state of the DFA, and whether lines of one shape have one code.

    Raises:
        GrammarError: The kernel does not know a rule or a literal of it, or two terminals match the same text.
    """
    lark = _lark(name)
    table = lark.parser.parser._parse_table
    terminals, names, states, rows, origins, action, goto = _rows(lark)
    rules = tuple(_made_of(rule) for rule in rows)
    scanner = _scanner([terminals[n].pattern for n in terminals])
    passed = [n in lark.ignore_tokens for n in terminals]
    _check_alike(name, scanner, action, list(terminals.values()), passed)
    own: dict[str, Any] = {}
    if name in GRAMMARS:
        actions, literals = _kernel_names()
        _check_scanner(terminals)
        _check_actions(rows, actions)
        own["shaped"] = _shaped(scanner)
        scanner = _spread(scanner)
        own["literal"] = _literal_of(scanner, list(terminals.values()), literals)
    classes, move = _folded(scanner.moves)
    token, modes = _tokens(scanner, action, list(terminals.values()), passed)
    pairs, lead = _leads(rules, origins, action, goto)
    return {
        "action": action,
        "goto": pairs,
        "lead": lead,
        "length": [len(r.expansion) for r in rows],
        "origin": origins,
        "classes": classes,
        "move": move,
        "token": token,
        "mode": modes,
        "passed": [*map(int, passed), 0],
        "apart": [*(int(terminals[n].pattern.value.endswith(APART)) for n in terminals), 0],
        "rules": rules,
        "starts": {
            start: (states[state], states[table.end_states[start]])
            for start, state in table.start_states.items()
        },
        "terminals": tuple(_bare(n) for n in names),
        **own,
    }


def _made_of(rule: Any) -> tuple[str, bool, tuple[int, ...]]:
    """Return what `tables` says of a rule, as Lark's ``ParseTreeBuilder`` does it."""
    name = _bare(str(rule.alias or rule.origin.name))
    gaps = [0] * (len(rule.expansion) + 1)
    if rule.options.empty_indices:
        shown = "".join("01"[there] for there in rule.options.empty_indices)
        gaps = [len(ones) for ones in shown.split("0")]
    parts: list[int] = []
    for k, symbol in enumerate(rule.expansion):
        parts += [-1] * gaps[k]
        if not (symbol.is_term and symbol.filter_out):
            parts.append(2 * k + (not symbol.is_term and symbol.name.startswith("_")))
    parts += [-1] * gaps[len(rule.expansion)]
    single = bool(rule.options.expand1) and not rule.alias
    alone = single and len(parts) == 1 and not parts[0] & 1
    return "" if alone or name.startswith("_") else name, single, tuple(parts)


def _fitting(labels: list[_Label], state: list[int], terminals: list[Any], passed: list[bool]) -> list[int]:
    """Return the terminals that a parser state allows of those that end in a state of the DFA, the one that wins first."""
    can = {a.terminal for a in labels if state[a.terminal] or passed[a.terminal]}
    return sorted(can, key=lambda i: (-terminals[i].priority, terminals[i].pattern.type != "str"))


def _check_alike(
    name: str,
    scanner: _Scanner,
    action: list[list[int]],
    terminals: list[Any],
    passed: list[bool],
) -> None:
    """Raise where two terminals match the same text in one parser state, and neither a priority nor `BEATEN` says which is meant."""
    for state in action:
        for place, labels in enumerate(scanner.ends):
            first, *others = _fitting(labels, state, terminals, passed) or [0]
            for other in others:
                wins, loses = terminals[first], terminals[other]
                reserved = wins.pattern.type == "str" and _bare(str(loses.name)) in BEATEN.get(name, {})
                if wins.priority == loses.priority and not reserved:
                    raise GrammarError(
                        f"{_bare(str(wins.name))} and {_bare(str(loses.name))} of {name} both match"
                        f" {_shortest(scanner.moves, place)!r}: a priority says which is meant"
                    )


def _shortest(moves: list[list[int]], place: int) -> str:
    """Return a shortest text that leads to a state of the DFA."""
    waiting = [(0, "")]
    seen = {0}
    for state, text in waiting:
        if state == place:
            return text
        for byte, to in enumerate(moves[state]):
            if to >= 0 and to not in seen:
                seen.add(to)
                waiting.append((to, text + chr(byte)))
    raise AssertionError(place)


def _tokens(
    scanner: _Scanner, action: list[list[int]], terminals: list[Any], passed: list[bool]
) -> tuple[list[list[int]], list[int]]:
    """Return `token` by mode, and the mode of each parser state. What is passed over may stand in all of them."""
    rows: dict[tuple[int, ...], int] = {}
    modes = []
    for state in action:
        row = []
        for labels in scanner.ends:
            row.append(next(iter(_fitting(labels, state, terminals, passed)), -1))
        modes.append(rows.setdefault(tuple(row), len(rows)))
    return [_ended(scanner.moves, row) for row in rows], modes


def _ended(moves: list[list[int]], row: tuple[int, ...]) -> list[int]:
    """Return a row of `token` with -2 for states from which no terminal of the mode is reached.

    There the scan ends: to the end of a text that some terminal of another mode takes whole, at each token, is a time as its square.
    """
    before: list[list[int]] = [[] for _ in moves]
    for d, to in enumerate(moves):
        for after in {*to} - {-1}:
            before[after].append(d)
    waiting = [d for d, kind in enumerate(row) if kind >= 0]
    lives = {*waiting}
    for d in waiting:
        waiting += (new := {*before[d]} - lives)
        lives |= new
    return [kind if d in lives else -2 for d, kind in enumerate(row)]


def _literal_of(scanner: _Scanner, terminals: list[Any], literals: dict[str, int]) -> list[int]:
    """Return the number of the literal that ends in each state of the DFA, 0 for none."""
    found = [0] * len(scanner.ends)
    for d, labels in enumerate(scanner.ends):
        for label in labels:
            if label.literal in literals:
                found[d] = literals[label.literal]
            elif label.literal and terminals[label.terminal].pattern.type != "str":
                raise GrammarError(
                    f"{label.literal!r} of {terminals[label.terminal].name} has no number in {KERNEL.name}"
                )
    return found


def write_all() -> None:
    """Write the tables of all grammars, and the kernels' constants, that are not up to date.

    Raises:
        GrammarError: The kernel does not know a rule or a literal of one.
    """
    constants = KERNEL.with_suffix(".pxd")
    if not constants.exists() or constants.read_text("utf-8") != _constants_of_c():
        constants.write_text(_constants_of_c(), "utf-8")
    for name in (*GRAMMARS, *VALUES):
        path = HERE / f"tables_{name}.py"
        wanted = digest(name)
        if not path.exists() or f'DIGEST = "{wanted}"' not in path.read_text("utf-8"):
            path.write_text(_module(name, wanted), "utf-8")


def _constants_of_c() -> str:
    """Return the declaration of the constants that kernels share."""
    constants = runpy.run_path(str(KERNEL))["CONSTANTS"]
    lines = [f"    {name} = {number}" for name, number in constants.items()]
    return "\n".join(
        ["# Made of the module beside it by lalr.py: not to be edited.", "", "cdef enum:", *lines, ""]
    )


def _module(name: str, wanted: str) -> str:
    """Return the text of a module of tables: rows of 16-bit numbers as bytes, and how many columns each has."""
    from array import array

    lines = [
        f'"""Tables of {VALUES[name][0] if name in VALUES else GRAMMARS[name]}, made by lalr.py: not to be edited."""',
        "",
        f'DIGEST = "{wanted}"',
    ]
    for key, value in tables(name).items():
        if isinstance(value, list):
            rows = value if value and isinstance(value[0], list) else [value]
            data = array("h", [n for row in rows for n in row]).tobytes()
            lines += [f"{key.upper()} = {len(rows[0])}, {data!r}"]
        else:
            lines += [f"{key.upper()} = {value!r}"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    write_all()

"""Parse tables of the grammars, made when cncgen is built: Lark's LALR tables, and one DFA of all terminals.

``setup.py`` calls `write_all`, which writes a module of bytes for each grammar beside it (``tables_NAME.py``). The kernel
`cncgen.kernels.gcode_parse` runs those of `GRAMMARS`, by actions that it knows; `cncgen.kernels.grammar_values` those of `VALUES`, whose
rules have functions in Python. A table is made anew where the grammar, this module or the kernel's list of actions has changed.

    action[state, terminal]   0 error, n > 0 shift to state n - 1, n < 0 reduce by rule -n - 1
    goto[state, nonterminal]  number of the pair, -1 for none
    lead[pair, terminal]      the state behind the nonterminal, once rules of it alone that write nothing are reduced too
    to[pair]                  the same where nothing else is reduced
    move[d, class of a byte]  next state of the DFA, -1 where no terminal goes on
    token[mode, d]            terminal that ends in d, for parser states of that mode; -1 for none
    again[state, terminal]    action of a rule of this one token that leads back to `state` (a word behind a word), else -1

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
#: Columns of the tables that the kernel looks into for each byte or token, where a shift finds a row.
COLUMNS = {"action": 64, "again": 64, "lead": 64, "goto": 32, "move": 64, "token": 512}


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
    """Return the actions of rules and the literals that the kernel knows, and the bounds of its tables."""
    kernel = runpy.run_path(str(KERNEL))
    return kernel["ACTIONS"], kernel["LITERALS"], kernel["MOST"]


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
    actions, literals, most = _kernel_names()
    parts += [
        Path(__file__).read_bytes(),
        SCANNER.read_bytes(),
        repr((name, actions, literals, most)).encode(),
    ]
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def _rule_actions(rules: list[Any], actions: dict[str, int]) -> list[int]:
    """Return the action of each rule.

    Every rule has an action of its alias, of its own name, or of the list where it leaves no value but passes one on (its action is 0).

    Raises:
        GrammarError: The kernel does not know the alias of a rule, or a rule that it counts on is missing.
    """
    found = []
    for rule in rules:
        name = _bare(str(rule.alias or rule.origin.name))
        if name in actions:
            found.append(actions[name])
        elif rule.alias or (
            len([s for s in rule.expansion if not s.is_term]) != 1 and not name.startswith("_")
        ):
            raise GrammarError(f"the rule {name} has no action in {KERNEL.name}")
        else:
            found.append(0)
    return found


def _again(
    action: list[list[int]], goto: list[list[int]], rules: list[Any], made: list[int], origins: list[int]
) -> list[list[int]]:
    """Return `again`: where a shift and the reductions that must follow lead back to the state, whatever comes next."""

    def forced(state: int) -> int | None:
        steps = set(action[state]) - {0}
        return -next(iter(steps)) - 1 if len(steps) == 1 and min(steps) < 0 else None

    found = [[-1] * len(row) for row in action]
    for state, row in enumerate(action):
        for terminal, step in enumerate(row):
            first = forced(step - 1) if step > 0 else None
            if first is None or len(rules[first].expansion) != 1:
                continue
            second = forced(goto[state][origins[first]])
            if second is None or len(rules[second].expansion) != 2 or made[second] != 0:
                continue
            # The second rule is left-recursive, and `state` is where its own left part leads.
            if str(rules[second].expansion[0].name) == str(rules[second].origin.name):
                found[state][terminal] = made[first]
    return found


def _leads(
    action: list[list[int]], goto: list[list[int]], rules: list[Any], made: list[int], origins: list[int]
) -> tuple[list[list[int]], list[int], list[list[int]]]:
    """Return `goto` by pairs, `to` and `lead`: operands of operators that are not there are passed on in one step."""
    pairs = [[-1] * len(row) for row in goto]
    to: list[int] = []
    lead: list[list[int]] = []
    for below, row in enumerate(goto):
        for nonterminal, first in enumerate(row):
            if first < 0:
                continue
            pairs[below][nonterminal] = len(to)
            to.append(first)
            lead.append([])
            for terminal in range(len(action[0])):
                state = first
                while action[state][terminal] < 0:
                    rule = -action[state][terminal] - 1
                    if made[rule] != 0 or len(rules[rule].expansion) != 1:
                        break
                    state = goto[below][origins[rule]]
                lead[-1].append(state)
    return pairs, to, lead


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

    Raises:
        GrammarError: The kernel does not know a rule or a literal of it.
    """
    actions, literals, _ = _kernel_names()
    lark = _lark(name)
    table = lark.parser.parser._parse_table
    terminals, names, states, rows, origins, action, goto = _rows(lark)
    _check_scanner(terminals)
    made = _rule_actions(rows, actions)
    scanner = _scanner([terminals[n].pattern for n in terminals])
    classes, move = _folded(scanner.moves)
    pairs, to, lead = _leads(action, goto, rows, made, origins)
    _check_alike(name, scanner, action, list(terminals.values()))
    token, literal, modes = _tokens(scanner, action, [terminals[n] for n in terminals], literals)
    return {
        "action": action,
        "goto": pairs,
        "to": to,
        "lead": lead,
        "length": [len(r.expansion) for r in rows],
        "origin": origins,
        "made": made,
        "again": _again(action, goto, rows, made, origins),
        "classes": classes,
        "move": move,
        "token": token,
        "mode": modes,
        "literal": literal,
        "shaped": _shaped(scanner),
        "start": states[next(iter(table.start_states.values()))],
        "accept": states[next(iter(table.end_states.values()))],
        "terminals": tuple(_bare(n) for n in names),
    }


def value_tables(name: str) -> dict[str, Any]:
    """Return the tables of a grammar whose rules make values.

    Beside those of `tables` that parse, ``passed`` tells of each terminal whether it is passed over (comments), ``apart`` whether it is `APART`, and ``rules`` says of each
    rule the name of its function ("": its parts are a list), whether one part alone is passed on, and its parts: twice the place among its
    symbols, one more where that is a list to be spliced in; -1 for one that is left out in brackets.
    """
    lark = _lark(name)
    table = lark.parser.parser._parse_table
    terminals, names, states, rows, origins, action, goto = _rows(lark)
    scanner = _scanner([terminals[n].pattern for n in terminals])
    classes, move = _folded(scanner.moves)
    passed = [n in lark.ignore_tokens for n in terminals]
    _check_alike(name, scanner, action, list(terminals.values()), passed)
    token, _, modes = _tokens(scanner, action, [terminals[n] for n in terminals], None, passed)
    return {
        "action": action,
        "goto": goto,
        "length": [len(r.expansion) for r in rows],
        "origin": origins,
        "classes": classes,
        "move": move,
        "token": token,
        "mode": modes,
        "passed": [*map(int, passed), 0],
        "apart": [*(int(terminals[n].pattern.value.endswith(APART)) for n in terminals), 0],
        "rules": tuple(_made_of(rule) for rule in rows),
        "starts": {
            start: (states[state], states[table.end_states[start]])
            for start, state in table.start_states.items()
        },
        "terminals": tuple(_bare(n) for n in names),
    }


def _made_of(rule: Any) -> tuple[str, bool, tuple[int, ...]]:
    """Return what `value_tables` says of a rule, as Lark's ``ParseTreeBuilder`` does it."""
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


def _fitting(
    labels: list[_Label], state: list[int], terminals: list[Any], passed: list[bool] | None
) -> list[int]:
    """Return the terminals that a parser state allows of those that end in a state of the DFA, the one that wins first."""
    can = {a.terminal for a in labels if state[a.terminal] or (passed and passed[a.terminal])}
    return sorted(can, key=lambda i: (-terminals[i].priority, terminals[i].pattern.type != "str"))


def _check_alike(
    name: str,
    scanner: _Scanner,
    action: list[list[int]],
    terminals: list[Any],
    passed: list[bool] | None = None,
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
    scanner: _Scanner,
    action: list[list[int]],
    terminals: list[Any],
    literals: dict[str, int] | None,
    passed: list[bool] | None = None,
) -> tuple[list[list[int]], list[list[int]], list[int]]:
    """Return `token` by mode, the number of the literal by terminal and DFA state, and the mode of each parser state.

    What is passed over may stand in all of them.
    """
    rows: dict[tuple[int, ...], int] = {}
    modes = []
    for state in action:
        row = []
        for labels in scanner.ends:
            row.append(next(iter(_fitting(labels, state, terminals, passed)), -1))
        modes.append(rows.setdefault(tuple(row), len(rows)))
    literal = [0] * len(scanner.ends)
    for d, labels in enumerate(scanner.ends):
        for label in labels if literals is not None else ():
            if label.literal in literals:
                literal[d] = literals[label.literal]
            elif label.literal and terminals[label.terminal].pattern.type != "str":
                raise GrammarError(
                    f"{label.literal!r} of {terminals[label.terminal].name} has no number in {KERNEL.name}"
                )
    return [list(row) for row in rows], literal, modes


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

    most = _kernel_names()[2]
    lines = [
        f'"""Tables of {VALUES[name][0] if name in VALUES else GRAMMARS[name]}, made by lalr.py: not to be edited."""',
        "",
        f'DIGEST = "{wanted}"',
    ]
    made = value_tables(name) if name in VALUES else tables(name)
    for key, value in made.items():
        if isinstance(value, list):
            rows = value if value and isinstance(value[0], list) else [value]
            width = len(rows[0]) if name in VALUES else COLUMNS.get(key, len(rows[0]))
            if len(rows[0]) > width:
                raise GrammarError(f"{key} has {len(rows[0])} columns; the kernel takes {width}")
            rows = [row + [-1] * (width - len(row)) for row in rows]
            if name not in VALUES and len(rows) * width > most[key]:
                raise GrammarError(
                    f"{key} has {len(rows)} rows; {KERNEL.name} has room for {most[key] // width}"
                )
            data = array("h", [n for row in rows for n in row]).tobytes()
            lines += [f"{key.upper()} = {len(rows[0])}, {data!r}"]
        else:
            lines += [f"{key.upper()} = {value!r}"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    write_all()

"""Write the terminals of the grammars as regular expressions, and compile patterns of `cncgen.gcode.text.signs` for the engine of the
Python that builds the package.

What looks into a text without the parser takes the forms of numbers, comments and labels from ``terminals.py``.

Importing `re` and compiling some twenty patterns took an eighth of the time of a small check. `cncgen.gcode.text.built_patterns` takes the
code that is written here, and compiles by `re` what is missing or is of another engine.
"""

import _sre
import hashlib
import re
import runpy
import sys
from array import array
from pathlib import Path
from types import ModuleType

HERE = Path(__file__).parent
SIGNS = HERE.parent / "cncgen" / "gcode" / "text" / "signs.py"
WRITTEN = HERE / "pattern_codes.py"
TERMINALS = HERE / "terminals.py"


def write() -> None:
    """Write the terminals and the codes of all patterns, where those that stand there are others."""
    write_terminals()
    # The package is not installed yet: its module of terminals is the one just written.
    module = sys.modules[f"cncgen.grammars.{TERMINALS.stem}"] = ModuleType(TERMINALS.stem)
    vars(module).update(runpy.run_path(str(TERMINALS)))
    try:
        codes = {pattern: code_of(pattern) for pattern in runpy.run_path(str(SIGNS))["patterns"]()}
    except AttributeError:
        # The compiler of `re` is no public interface: a Python that has another one compiles when it runs.
        codes = {}
    lines = [
        '"""Codes of patterns, made by patterns.py: not to be edited."""',
        "",
        f"MAGIC = {_sre.MAGIC}",
        "CODES = {",
        *(f"    {pattern!r}: {code!r}," for pattern, code in codes.items()),
        "}",
        "",
    ]
    text = "\n".join(lines)
    if not WRITTEN.exists() or WRITTEN.read_text("utf-8") != text:
        WRITTEN.write_text(text, "utf-8")


def write_terminals() -> None:
    """Write each terminal of each grammar as a regular expression."""
    lalr = runpy.run_path(str(HERE / "lalr.py"))
    sources = [Path(__file__), HERE / "lalr.py", *sorted(HERE.glob("*.lark"))]
    digest = hashlib.sha256(b"\0".join(path.read_bytes() for path in sources)).hexdigest()
    if TERMINALS.exists() and digest in TERMINALS.read_text("utf-8"):
        return
    lines = [
        '"""Terminals of the grammars, made by patterns.py: not to be edited."""',
        "",
        f'DIGEST = "{digest}"',
    ]
    for name in (*lalr["GRAMMARS"], *lalr["VALUES"]):
        # Those that no rule has as well: what is taken off a text before its blocks are read.
        found = lalr["_lark"](name).grammar.compile(list(lalr["_path_and_starts"](name)[1]), "*")[0]
        patterns = {lalr["_bare"](str(t.name)): t.pattern.to_regexp() for t in found}
        lines.append(f"{name.upper()} = {patterns!r}")
    TERMINALS.write_text("\n".join([*lines, ""]), "utf-8")


def code_of(pattern: bytes) -> tuple[int, tuple[str | None, ...], bytes]:
    """Return flags, names of groups (None: without) and code of a pattern, as the engine takes them (``re/_compiler.py``)."""
    parsed = re._parser.parse(pattern, 0)
    flags = parsed.state.flags
    names: list[str | None] = [None] * parsed.state.groups
    for name, k in parsed.state.groupdict.items():
        names[k] = name
    return flags, tuple(names), array("I", re._compiler._code(parsed, flags)).tobytes()


if __name__ == "__main__":
    write()

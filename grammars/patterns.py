"""Compile patterns of `cncgen.gcode.text.signs` for the engine of the Python that builds the package.

Importing `re` and compiling some twenty patterns took an eighth of the time of a small check. `cncgen.gcode.text.built_patterns` takes the
code that is written here, and compiles by `re` what is missing or is of another engine.
"""

import _sre
import re
import runpy
from array import array
from pathlib import Path

HERE = Path(__file__).parent
SIGNS = HERE.parent / "cncgen" / "gcode" / "text" / "signs.py"
WRITTEN = HERE / "pattern_codes.py"


def write() -> None:
    """Write the codes of all patterns, where those that stand there are others."""
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

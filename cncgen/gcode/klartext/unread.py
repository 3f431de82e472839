"""Words of PLANE and of parts of cycles (9, 19, 32) that those do not have."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from cncgen.gcode.block import AXES
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.text.plain_language import Raw


def tell(ip: Interpreter, name: str, words: Sequence[Raw], known: Collection[str]) -> None:
    """Warn of words that are passed over, whose names may be those of another language of the control.

    Raises:
        BlockError: One is that of an axis, which every language has.
    """
    for word, _ in words:
        if not word or word in known:
            continue
        bare = word.rstrip("±")
        message = f"{bare} of {name} is not read"
        hint = f"it has {', '.join(sorted(one.rstrip('±') for one in known))}" if known else ""
        if bare.removeprefix("I") in [*AXES.upper()]:
            raise BlockError("not-read", message, bare, hint=hint)
        ip.warn_once("not-read", f"{message}: it is passed over", bare, hint)

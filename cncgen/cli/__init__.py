"""The command line: one module a command, imported when it is used. `main` is the console entry point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NoReturn


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command that the arguments (default: the process's own) name, and exit with its code."""
    import sys

    from cncgen.cli.app import run

    sys.exit(run(arguments))

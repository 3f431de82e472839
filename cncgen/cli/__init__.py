"""The command line: one module a command, imported when it is used. `main` is the console entry point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NoReturn


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command that the arguments (default: the process's own) name, and exit with its code."""
    import os
    import sys

    # Matrices are small here, and the cores are the planner's: threads of the linear algebra would spin beside it.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        from cncgen.cli.app import run

        code = run(arguments)
    except KeyboardInterrupt:  # before `run` could say so
        code = 130
    _leave_threads(code)
    sys.exit(code)


def _leave_threads(code: int) -> None:
    """End the process at once where an interrupted command left threads at work.

    `run` has flushed and cleaned up; the interpreter would stop such a thread within its compiled code, which aborts.
    """
    import os
    import sys

    threading = sys.modules.get("threading")
    if threading is not None and threading.active_count() > 1:
        os._exit(code)

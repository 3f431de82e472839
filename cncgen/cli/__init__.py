"""The command line: one module a command, imported when it is used. `main` is the console entry point.

Signals are taken before anything else is imported; the interpreter has the imports of this file at its start.
"""

from __future__ import annotations

# `signal` itself imports `enum`, which takes time in which an interrupt would be shown as a traceback.
import _signal  # type: ignore[import-not-found]
import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from sys import UnraisableHookArgs
    from types import FrameType
    from typing import Any, NoReturn

#: Objects made before the garbage collector looks for circles: of imports nothing is thrown away.
_COLLECTED_AFTER = 50_000
#: Time for which a thread may run while others wait, s. The planner's threads come back from kernels often, and waited 5 ms each time.
_TURN_S = 0.0005
#: The function that takes the signal's number where one ends the process amid an import, once `main` has imported it.
_last_words: list[Callable[[int], None]] = []


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command that the arguments (default: the process's own) name, and exit with its code."""
    before: dict[int, Any] = {}
    unraised = sys.unraisablehook
    try:
        sys.unraisablehook = _end_unraised
        _take_signals(before)
        import gc

        gc.set_threshold(_COLLECTED_AFTER, *gc.get_threshold()[1:])
        sys.setswitchinterval(_TURN_S)
        # Matrices are small here, and the cores are the planner's: threads of the linear algebra would spin beside it.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        from cncgen.cli.app import last_words, run

        _last_words[:] = [last_words]
        code = run(arguments)
    except KeyboardInterrupt:  # before `run` could say so
        code = 130
    _leave_threads(code)
    for number, handler in before.items():
        _signal.signal(number, handler)
    sys.unraisablehook = unraised
    if arguments is None and sys.getprofile() is None:
        _leave(code)
    sys.exit(code)


def _take_signals(before: dict[int, Any]) -> None:
    """Let `_end` handle the signals that end a process; where one is ignored (nohup) or handled it stays so.

    Args:
        before: Takes what handled them, by number.
    """
    for name, usual in (
        ("SIGINT", _signal.default_int_handler),
        ("SIGTERM", _signal.SIG_DFL),
        ("SIGHUP", _signal.SIG_DFL),
    ):
        number = getattr(_signal, name, None)  # not every system has each
        if number is None or _signal.getsignal(number) != usual:
            continue
        try:
            _signal.signal(number, _end)
        except ValueError:  # not in the main thread, which alone may
            return
        before[number] = usual


def _end(number: int, frame: FrameType | None) -> None:
    """End the run on a signal as an exception does, so that half-written files are removed; amid an import at once.

    There an exception may be lost in a callback of the import system, which prints it and goes on, or come out as
    another: of a class that is being made, as RuntimeError.
    """
    while frame is not None:
        if frame.f_code.co_filename == "<frozen importlib._bootstrap>":
            _end_at_once(number)
        frame = frame.f_back
    if number == _signal.SIGINT:
        raise KeyboardInterrupt
    raise SystemExit(128 + number)


def _end_unraised(lost: UnraisableHookArgs) -> None:
    """End the run where a signal came amid a destructor or a library's callback, which cannot pass its exception on."""
    if lost.exc_type is KeyboardInterrupt:
        _end_at_once(_signal.SIGINT)
    if isinstance(lost.exc_value, SystemExit):
        _end_at_once(int(str(lost.exc_value.code)) - 128)
    sys.__unraisablehook__(lost)


def _end_at_once(number: int) -> NoReturn:
    """Say the last words of a run that a signal ends, and end the process."""
    for say in _last_words:
        say(number)
    os._exit(128 + number)


def _leave_threads(code: int) -> None:
    """End the process at once where an interrupted command left threads at work.

    `run` has flushed and cleaned up; the interpreter would stop such a thread within its compiled code, which aborts.
    """
    threading = sys.modules.get("threading")
    if threading is not None and threading.active_count() > 1:
        os._exit(code)


def _leave(code: int) -> NoReturn:
    """End the process without freeing its objects one by one, a fifth of the time of a small check.

    `run` has flushed and cleaned up; the exit handlers of modules run here.
    """
    import atexit

    atexit._run_exitfuncs()
    os._exit(code)

"""The bound of a run's memory: a run that needs more ends with a message, before it exhausts the memory of the computer."""

from __future__ import annotations

try:
    import resource
except ImportError:  # Windows has no such bounds
    resource = None  # type: ignore[assignment]


from cncgen.diagnostics import Diagnostic, NoPlanError
from cncgen.room import MIB, left_of_addresses, taken

TYPE_CHECKING = False
if TYPE_CHECKING:
    import click

#: Memory that a run may take by default, MiB.
DEFAULT_MIB = 1024


class _Bound:
    """The bound in force, MiB, the option of ulimit that sets it ("": the run's own), and the process's bound before, as `resource` has it."""

    mib = DEFAULT_MIB
    ulimit = ""
    before: tuple[int, int] | None = None


def set_bound(context: click.Context, parameter: click.Parameter, value: int) -> None:
    """Bound the memory of this process (the callback of ``--max-memory``)."""
    bound(value)


def bound(mib: int) -> None:
    """Bound the memory that this process takes from now on."""
    _Bound.mib, _Bound.ulimit = mib, ""
    if resource is None:
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    if _Bound.before is None:
        _Bound.before = soft, hard
    has = taken()
    most = min(n for n in (has + mib * MIB, _Bound.before[0], hard) if n != resource.RLIM_INFINITY)
    # The system may allow less than is asked for.
    _Bound.mib = max(most - has, 0) // MIB
    _Bound.ulimit = "-d" if _Bound.mib < mib else ""
    addresses = left_of_addresses() / MIB
    if addresses < _Bound.mib:
        _Bound.mib, _Bound.ulimit = int(addresses), "-v"
    resource.setrlimit(resource.RLIMIT_DATA, (most, hard))


def lift() -> None:
    """Put the bound back that the process had before."""
    if resource is not None and _Bound.before is not None:
        resource.setrlimit(resource.RLIMIT_DATA, _Bound.before)
        _Bound.before = None


def is_lack(error: Exception) -> bool:
    """Tell whether an error says that memory is lacking: Python's own, or that of a thread that did not start."""
    return isinstance(error, MemoryError) or _is_of_a_thread(error)


def _is_of_a_thread(error: Exception) -> bool:
    """Tell whether a thread did not start.

    There is no room for its stack, or the system allows no more threads: Python tells neither from the other, and the
    threads of the run may have ended, and freed their room, before anyone asks.
    """
    return isinstance(error, RuntimeError) and "start new thread" in str(error)


def exhausted(error: Exception) -> NoPlanError:
    """Return the message that ends a run that needs more than an `error` says it has."""
    if _Bound.ulimit:
        who, hint = "which the system allows this process", f"ulimit {_Bound.ulimit} shows and sets that"
    else:
        who, hint = "the bound of a run", "--max-memory sets the bound, in MiB"
    if _is_of_a_thread(error):
        hint += ", and ulimit -u that of threads, which may be the one that is met"
    return NoPlanError(
        Diagnostic(
            "max-memory",
            f"the run needs more memory than {_Bound.mib} MiB, {who}",
            hint=f"{hint}; a shorter program or a longer period needs less",
            values={"max_memory_mib": _Bound.mib},
        )
    )

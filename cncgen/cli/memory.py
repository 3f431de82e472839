"""The bound of a run's memory: a run that needs more ends with a message, before the machine's own memory is used up."""

from __future__ import annotations

try:
    import resource
except ImportError:  # Windows has no such bounds
    resource = None  # type: ignore[assignment]


from cncgen.diagnostics import Diagnostic, NoPlanError

TYPE_CHECKING = False
if TYPE_CHECKING:
    import click

#: Memory that a run may take where nothing is said, MiB.
DEFAULT_MIB = 4096
_MIB = 2**20


class _Bound:
    """The bound in force, MiB, and the one that the process had before, as `resource` has it."""

    mib = DEFAULT_MIB
    before: tuple[int, int] | None = None


def set_bound(context: click.Context, parameter: click.Parameter, value: int) -> None:
    """Bound the memory of this process (the callback of ``--max-memory``)."""
    bound(value)


def bound(mib: int) -> None:
    """Bound the memory that this process takes from now on."""
    _Bound.mib = mib
    if resource is None:
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    if _Bound.before is None:
        _Bound.before = soft, hard
    asked = _taken() + mib * _MIB
    least = [most for most in (asked, _Bound.before[0], hard) if most != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_DATA, (min(least), hard))


def lift() -> None:
    """Put the bound back that the process had before."""
    if resource is not None and _Bound.before is not None:
        resource.setrlimit(resource.RLIMIT_DATA, _Bound.before)
        _Bound.before = None


def exhausted() -> NoPlanError:
    """Return what ends a run that asked for more."""
    return NoPlanError(
        Diagnostic(
            "max-memory",
            f"the run needs more memory than {_Bound.mib} MiB",
            hint="--max-memory sets the bound, in MiB; a shorter program or a longer period needs less",
            values={"max_memory_mib": _Bound.mib},
        )
    )


def _taken() -> int:
    """Return the bytes of memory that this process has now."""
    try:
        with open("/proc/self/status") as status:
            for line in status:
                if line.startswith("VmData:"):
                    return int(line.split()[1]) * 1024
    except OSError:
        pass
    return 0

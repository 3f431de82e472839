"""The memory that this process may still take, for sizes that are checked before allocation."""

from __future__ import annotations

import math

try:
    import resource
except ImportError:  # Windows has no such bounds
    resource = None  # type: ignore[assignment]

MIB = 2**20


def taken() -> int:
    """Return the bytes of data that this process has; 0 where the system does not say."""
    return _status("VmData:")


def _status(field: str) -> int:
    """Return a size of this process, bytes; 0 where the system does not say."""
    try:
        with open("/proc/self/status") as status:
            for line in status:
                if line.startswith(field):
                    return int(line.split()[1]) * 1024
    except OSError:
        pass
    return 0


def left_of_addresses() -> float:
    """Return the bytes of addresses that ``ulimit -v`` leaves this process, code and mapped files among them; infinite without it."""
    if resource is None:
        return math.inf
    most = resource.getrlimit(resource.RLIMIT_AS)[0]
    return math.inf if most == resource.RLIM_INFINITY else max(most - _status("VmSize:"), 0)


def room() -> float:
    """Return the bytes of data that this process may take beside those; infinite where nothing bounds them."""
    if resource is None:
        return math.inf
    most = resource.getrlimit(resource.RLIMIT_DATA)[0]
    return math.inf if most == resource.RLIM_INFINITY else max(most - taken(), 0)

"""Fixtures and settings that every room's tests share."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

settings.register_profile(
    "cncgen",
    max_examples=50,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
settings.load_profile("cncgen")

# As cncgen itself sets it before it loads Arrow: tests load Arrow too, and its own allocator would take a GiB at once
# from the memory that tests of bounds leave.
os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")

#: The top of the checkout.
ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def root() -> Path:
    """The top of the checkout."""
    return ROOT


@pytest.fixture(scope="session")
def programs() -> Path:
    """The folder of example programs."""
    return ROOT / "programs"


@pytest.fixture
def cncgen(tmp_path: Path) -> Callable[..., subprocess.CompletedProcess[bytes]]:
    """Run the console command in a process of its own, in an empty directory."""

    def run(*arguments: object, stdin: bytes = b"", **options: object) -> subprocess.CompletedProcess[bytes]:
        return subprocess.run(
            [sys.executable, "-m", "cncgen", *map(str, arguments)],
            input=stdin,
            capture_output=True,
            timeout=120,
            cwd=tmp_path,
            check=False,
            **options,  # type: ignore[call-overload]
        )

    return run

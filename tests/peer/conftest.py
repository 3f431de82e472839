"""The programs of the peer's cases, as files."""

from __future__ import annotations

from pathlib import Path

import pytest

from trials.peer_cases import write_programs


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """All programs, with the files that they ask for."""
    made = tmp_path_factory.mktemp("peer")
    write_programs(made)
    return made

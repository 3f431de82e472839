"""Commands that are stopped while they write; `python -m trials.interruptions` does it a thousand times to all of them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from cncgen import files
from trials import interruptions

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="files without a name are Linux's")


@pytest.mark.slow
@pytest.mark.parametrize("how", [interruptions.KILL, interruptions.TERM, interruptions.SIZE])
def test_nothing_partial_is_left(how: str) -> None:
    """Of formats that are spooled, four files of one run, and standard output."""
    tally = interruptions.run(1, 4, ["plan mf4", "plan hdf5", "plan four files", "cut"], [how])
    assert tally.faults == []
    assert sum(tally.runs.values()) == 4


def test_the_trial_finds_what_is_wrong(tmp_path: Path) -> None:
    """A part of a file, a file that is gone, and one beside it are each a fault."""
    case, tally = interruptions.Case("any", (), ("o.csv", "s.json")), interruptions.Tally()
    work, scratch = tmp_path / "work", tmp_path / "tmp"
    work.mkdir()
    scratch.mkdir()
    (work / "o.csv").write_bytes(b"who")
    (scratch / "cncgen-1").mkdir()
    whole = interruptions.Whole({"o.csv": b"whole", "s.json": b"{}"}, 1.0, 5)
    found = interruptions._faults(case, whole, interruptions.TERM, {"s.json": b"was"}, work, scratch, tally)
    assert [each.split()[0] for each in found] == ["o.csv", "s.json", "left"]


def test_what_a_killed_process_left_beside_a_file_is_removed(tmp_path: Path) -> None:
    """By the next run that writes the file, while that of a process that lives stays."""
    out = tmp_path / "o.csv"
    out.write_bytes(b"was")
    code = (
        "import os, signal\nfrom cncgen.files import OutputFile\n"
        "file = OutputFile('o.csv')\nfile.write(b'new')\nfile.finish()\nfile.name_beside()\n"
    )
    killed = [sys.executable, "-c", code + "os.kill(os.getpid(), signal.SIGKILL)"]
    subprocess.run(killed, cwd=tmp_path, check=False)
    assert sorted(os.listdir(tmp_path)) == [".o.csv.part", "o.csv"]
    with subprocess.Popen(
        [sys.executable, "-c", code + "print(file._temporary, flush=True)\ninput()"],
        cwd=tmp_path,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as living:
        assert living.stdout is not None
        assert living.stdout.readline()
        file = files.OutputFile(out)
        file.write(b"ours")
        file.commit()
        assert sorted(os.listdir(tmp_path)) == [".o.csv.part", "o.csv"]
        assert out.read_bytes() == b"ours"
        living.kill()
    files.OutputFile(out).discard()
    assert os.listdir(tmp_path) == ["o.csv"]


def test_scratch_folders_of_killed_processes_are_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where nobody holds their lock and they are older than the moment between making and locking one."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    old, young = tmp_path / "cncgen-scratch-a", tmp_path / "cncgen-scratch-b"
    for folder in (old, young):
        folder.mkdir()
        (folder / "file").write_bytes(b"left")
    os.utime(old, (0, 0))
    with files.scratch_folder() as held:
        os.utime(held, (0, 0))
        with files.scratch_folder():
            assert os.path.isdir(held)
    assert os.listdir(tmp_path) == ["cncgen-scratch-b"]

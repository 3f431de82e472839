"""What people do to a command: each wrong input ends with a clear message, its exit code, and no partial file."""

from __future__ import annotations

import json
import os
import re
import resource
import shlex
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from cncgen import files
from cncgen.cli import app, main

Run = Callable[..., "subprocess.CompletedProcess[bytes]"]

#: A short program for which every strategy has a plan.
SMALL = b"G21 G17 G90 G61\nG0 X0 Y0\nG1 X10 F1000\nG1 Y10\nM30\n"


def refused(run: subprocess.CompletedProcess[bytes], code: int, *words: str) -> str:
    """Check the exit code and the message; return what was said."""
    said = run.stderr.decode()
    assert run.returncode == code, said
    assert "Traceback" not in said
    assert "internal error" not in said
    for word in words:
        assert word in said, said
    return said


@pytest.fixture
def small(tmp_path: Path) -> Path:
    path = tmp_path / "small.nc"
    path.write_bytes(SMALL)
    return path


@pytest.fixture
def in_folder(small: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of `small`, which commands run in."""
    monkeypatch.chdir(small.parent)
    return small.parent


#: A strategy is named so that these tests stay quick and stand for the command line alone.
PLAN = ("plan", "--feedrate", "ild")

COMMANDS = [
    ("check", "{}"),
    ("canon", "{}"),
    (*PLAN, "{}", "-o", "out.csv"),
    ("simulate", "{}", "--feedrate", "ild", "-m", "xy-table", "-o", "out.csv"),
]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda c: c[0])
def test_missing_file_and_directory(cncgen: Run, tmp_path: Path, command: tuple[str, ...]) -> None:
    (tmp_path / "folder.nc").mkdir()
    run = cncgen(*(part.format("none.nc") for part in command))
    refused(run, 2, "none.nc", "no such file")
    run = cncgen(*(part.format("folder.nc") for part in command))
    refused(run, 2, "folder.nc", "directory")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["folder.nc"]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda c: c[0])
@pytest.mark.parametrize("content", [b"", b"\n\n  \n"], ids=["nothing", "blank lines"])
def test_empty_program(cncgen: Run, tmp_path: Path, command: tuple[str, ...], content: bytes) -> None:
    (tmp_path / "empty.nc").write_bytes(content)
    run = cncgen(*(part.format("empty.nc") for part in command))
    refused(run, 1, "empty.nc", "empty")
    assert not (tmp_path / "out.csv").exists()
    assert run.stdout == b"" or command[0] == "canon"


@pytest.mark.parametrize("command", COMMANDS, ids=lambda c: c[0])
def test_binary_file(cncgen: Run, tmp_path: Path, command: tuple[str, ...]) -> None:
    (tmp_path / "binary.nc").write_bytes(bytes(range(256)) * 100)
    run = cncgen(*(part.format("binary.nc") for part in command))
    assert run.returncode in (1, 2)
    refused(run, run.returncode, "binary.nc")
    assert not (tmp_path / "out.csv").exists()


@pytest.mark.parametrize("kind", ["spaces", "digits", "words", "comment"])
def test_a_line_of_100_mb(cncgen: Run, tmp_path: Path, kind: str) -> None:
    pieces = {"spaces": b" ", "digits": b"1", "words": b"X1Y1", "comment": b"(c"}
    piece = pieces[kind]
    with open(tmp_path / "long.nc", "wb") as file:
        file.write(b"G1 F100 X")
        file.write(piece * (100_000_000 // len(piece)))
        file.write(b"\nG1 X1\n")
    said = refused(cncgen("check", "long.nc"), 1, "long.nc:1")
    assert len(said) < 5000


@pytest.mark.parametrize("number", ["nan", "NaN", "inf", "1e400", "9" * 400, "-" * 50, "1.2.3", "."])
def test_numbers_that_are_none(cncgen: Run, tmp_path: Path, number: str) -> None:
    (tmp_path / "n.nc").write_text(f"G21 G90\nG1 X{number} F100\n")
    refused(cncgen(*PLAN, "n.nc", "-o", "out.csv"), 1, "n.nc:2")
    assert not (tmp_path / "out.csv").exists()


@pytest.mark.parametrize(
    "text", [b"a = [1,", b"\xff\xfe", b"period_s = -1\n", b""], ids=["syntax", "bytes", "fault", "empty"]
)
def test_bad_machine_file(cncgen: Run, tmp_path: Path, small: Path, text: bytes) -> None:
    (tmp_path / "m.toml").write_bytes(text)
    refused(cncgen(*PLAN, small, "-m", "m.toml", "-o", "out.csv"), 2, "m.toml")
    assert not (tmp_path / "out.csv").exists()


def test_unreadable_toml(cncgen: Run, tmp_path: Path, small: Path) -> None:
    (tmp_path / "m.toml").mkdir()
    refused(cncgen(*PLAN, small, "-m", "m.toml"), 2, "m.toml", "directory")
    refused(cncgen(*PLAN, small, "-m", "none.toml"), 2, "none.toml", "no such file")


@pytest.mark.parametrize(
    ("text", "place"),
    [
        (b'# one\nname = "\xfc"\n', "m.toml:2:9: error[machine-syntax]: byte 0xfc is not UTF-8"),
        ("# ä\n# ö ".encode() + b"\xfc", "m.toml:2:5: error[machine-syntax]: byte 0xfc is not UTF-8"),
        ('name = "m"\n'.encode("utf-16-le"), "help: is it UTF-16 without its mark?"),
        (
            b"\nperiod_s = " + b"9" * 5000,
            "m.toml:2:12: error[machine-syntax]: an integer has too many digits: 5000",
        ),
    ],
)
def test_where_a_machine_file_is_no_toml(
    in_folder: Path, capsys: pytest.CaptureFixture[str], text: bytes, place: str
) -> None:
    (in_folder / "m.toml").write_bytes(text)
    assert app.run([*PLAN, "small.nc", "-m", "m.toml"]) == 2
    assert place in capsys.readouterr().err


def test_texts_that_powershell_wrote_are_read(in_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """``cncgen machines show xy-table > m.toml`` of its version 5 writes UTF-16: programs were read, all other texts refused."""

    def piped(name: str, *words: str) -> None:
        assert app.run([*words]) == 0
        text = capsys.readouterr().out.replace("\n", "\r\n")
        (in_folder / name).write_bytes(text.encode("utf-16"))

    piped("m.toml", "machines", "show", "xy-table")
    piped("s.csv", "plan", "small.nc", "-m", "m.toml")
    assert app.run(["verify", "s.csv", "--program", "small.nc", "-m", "m.toml"]) == 0
    piped("r.csv", "simulate", "s.csv", "--axis-params", "m.toml")
    assert app.run(["identify", "r.csv", "--model", "first-order"]) == 0
    (in_folder / "t.tbl").write_bytes("T1 P1 Z10 D6 ;ä\r\n".encode("utf-16"))
    (in_folder / "v.var").write_bytes("5161 1.0\r\n".encode("utf-16"))
    assert app.run(["check", "small.nc", "--tool-table", "t.tbl", "--parameters", "v.var"]) == 0


@pytest.mark.skipif(not os.path.exists("/proc/self/mem"), reason="needs Linux's files of a process")
@pytest.mark.parametrize(
    "command", ["check {}", "plan {}", "canon {}", "simulate {} -m xy-table", "verify {} -p small.nc"]
)
def test_a_file_that_opens_and_cannot_be_read_is_named(
    in_folder: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    """As on a failing disk: the first page of a process is never mapped, so that reading gives EIO."""
    assert app.run(command.format("/proc/self/mem").split()) == 2
    assert "error[file-read]: cannot read /proc/self/mem: Input/output error" in capsys.readouterr().err


def test_unwritable_output(cncgen: Run, tmp_path: Path, small: Path) -> None:
    refused(cncgen(*PLAN, small, "-o", "none/out.csv"), 2, "none/out.csv", "directory does not exist")
    (tmp_path / "folder.csv").mkdir()
    refused(cncgen(*PLAN, small, "-o", "folder.csv"), 2, "folder.csv", "directory")
    refused(cncgen(*PLAN, small, "-o", "new/"), 2, "cannot write new/: it is a directory")
    refused(cncgen(*PLAN, small, "-o", ""), 2, "cannot write the file with an empty name")
    assert not (tmp_path / "new").exists()
    refused(cncgen(*PLAN, small, "-o", "out.csv", "--summary", "none/s.json"), 2, "none/s.json")
    refused(cncgen(*PLAN, small, "-o", "out.csv", "--events", "none/e.jsonl"), 2, "none/e.jsonl")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
@pytest.mark.parametrize("format", ["csv", "npy", "npz", "f64", "hal"])
def test_full_disk(cncgen: Run, tmp_path: Path, small: Path, format: str) -> None:
    refused(cncgen(*PLAN, small, "-o", "/dev/full", "--format", format), 2, "/dev/full", "no space")
    with open("/dev/full", "wb") as full:
        run = subprocess.run(
            [sys.executable, "-m", "cncgen", *PLAN, str(small), "--format", format],
            stdout=full,
            stderr=subprocess.PIPE,
            timeout=60,
            check=False,
        )
    refused(run, 2, "standard output", "no space")
    assert Path("/dev/full").is_char_device()


@pytest.mark.parametrize(
    "command", [("machines",), ("machines", "show", "xy-table"), ("--help",), ("canon", "small.nc")]
)
def test_full_disk_behind_standard_output(tmp_path: Path, small: Path, command: tuple[str, ...]) -> None:
    with open("/dev/full", "wb") as full:
        run = subprocess.run(
            [sys.executable, "-m", "cncgen", *command],
            stdout=full,
            stderr=subprocess.PIPE,
            timeout=60,
            check=False,
            cwd=tmp_path,
        )
    refused(run, 2, "no space" if command[0] != "--help" else "")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_diagnostics_that_find_no_room_on_standard_output(small: Path) -> None:
    """It ended in a traceback: the message that said so went to the same full disk."""
    small.write_bytes(b"G1 X1.2.3\n")
    with open("/dev/full", "wb") as full:
        command = [sys.executable, "-m", "cncgen", "check", "--json", str(small)]
        run = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, timeout=60, check=False)
    (line,) = refused(run, 2, "no space").splitlines()
    assert json.loads(line)["code"] == "file-write"


def test_standard_input_that_finds_no_room(small: Path) -> None:
    """It is kept in a temporary file; that the disk is full was said of reading ``-``."""
    command = [sys.executable, "-m", "cncgen", *PLAN, "-", "-o", "out.csv"]
    run = subprocess.run(
        command,
        input=SMALL + b"(" + b"a" * 300_000 + b")\n",
        capture_output=True,
        timeout=60,
        check=False,
        cwd=small.parent,
        env={**os.environ, "TMPDIR": str(small.parent), "PYTHONDONTWRITEBYTECODE": "1"},
        preexec_fn=lambda: (
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN),
            resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000)),
        ),
    )
    refused(run, 2, f"cannot write {small.parent}: ", "standard input is kept in a temporary file", "TMPDIR")
    assert [path.name for path in small.parent.iterdir()] == ["small.nc"]


def test_what_controls_a_terminal_is_shown(cncgen: Run, tmp_path: Path) -> None:
    """In the name of a file or a machine: it was sent to the terminal as it is."""
    (tmp_path / "a\x1b[31mb.nc").write_bytes(SMALL)
    said = cncgen("check", "a\x1b[31mb.nc").stderr.decode()
    assert said == "a\u241b[31mb.nc: no errors, 4 motions and events\n"


def test_what_follows_a_line_feed_in_a_name_is_no_message(cncgen: Run, tmp_path: Path) -> None:
    """`ls` shows such a name in one line, too; `x: no errors` of a name was a line of its own."""
    name = "a\nx: no errors\nb.nc"
    shown = "a␊x: no errors␊b.nc"
    (tmp_path / name).write_bytes(SMALL)
    assert cncgen("check", name).stderr.decode() == f"{shown}: no errors, 4 motions and events\n"
    assert cncgen(*PLAN, name, "-o", "o.csv").stderr.decode().startswith(f"{shown} on ")
    (tmp_path / name).write_bytes(b"G21\nG1 X\n")
    said = cncgen("check", name).stderr.decode().splitlines()
    assert said[0].startswith(f"{shown}:2:")
    assert said[-1].startswith(f"{shown}: 1 error")


def test_setpoints_of_standard_input_are_named_so(cncgen: Run) -> None:
    """The messages named a file "-", and did not say that a format without a head has to be named."""
    rows = struct.pack("<4d", 0.0, 0.0, 0.001, 0.0)
    said = cncgen("simulate", "--axis-params", "xy-table", stdin=rows).stderr.decode()
    assert said.startswith(
        "standard input:1:1: error[setpoints-header]: standard input is not a setpoint file"
    )
    assert "--format names another format" in said
    named = cncgen("simulate", "--axis-params", "xy-table", "--format", "f64", "--axes", "X", stdin=rows)
    assert named.returncode == 0


@pytest.mark.parametrize("content", [b"", b"\n\n"])
def test_standard_input_without_a_block(cncgen: Run, content: bytes) -> None:
    """The message was "- has no block"."""
    said = cncgen("check", "-", stdin=content).stderr.decode()
    assert "error[empty-program]: the program has no block" in said


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_a_log_that_is_full_costs_no_setpoints(tmp_path: Path, small: Path) -> None:
    """Standard error goes to a file on a full disk: the plan was thrown away, and its exit code blamed the program."""
    with open("/dev/full", "wb") as full:
        command = [sys.executable, "-m", "cncgen", *PLAN, str(small), "-o", "out.csv"]
        run = subprocess.run(command, stderr=full, timeout=60, check=False, cwd=tmp_path)
    assert run.returncode == 0
    assert len((tmp_path / "out.csv").read_text().splitlines()) > 2


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
@pytest.mark.parametrize("stderr", ["/dev/full", None], ids=["full", "closed"])
@pytest.mark.parametrize("command", [PLAN, ("simulate", "--feedrate", "ild", "-m", "xy-table")])
def test_a_summary_that_finds_no_room_on_standard_error(
    small: Path, command: tuple[str, ...], stderr: str | None
) -> None:
    """It was asked for there, unlike a log: the run fails as with a file, and leaves none."""
    with open(stderr or os.devnull, "wb") as sink:
        run = subprocess.run(
            [sys.executable, "-m", "cncgen", *command, str(small), "-o", "out.csv", "--summary", "-"],
            stderr=sink,
            timeout=60,
            check=False,
            cwd=small.parent,
            preexec_fn=None if stderr else lambda: os.close(2),
        )
    assert run.returncode == 2
    assert [path.name for path in small.parent.iterdir()] == ["small.nc"]


def test_a_summary_whose_reader_goes_away_costs_no_setpoints(small: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    run = subprocess.run(
        [sys.executable, "-m", "cncgen", *PLAN, str(small), "-q", "-o", "out.csv", "--summary", "-"],
        stderr=writer,
        timeout=60,
        check=False,
        cwd=small.parent,
    )
    os.close(writer)
    assert run.returncode == 0
    assert (small.parent / "out.csv").exists()


def test_a_disk_that_fills_leaves_no_partial_file(tmp_path: Path, small: Path) -> None:
    """A limit on the size of files stands in for the disk; what was there before stays."""
    out = tmp_path / "out.csv"
    out.write_text("before")
    run = subprocess.run(
        [sys.executable, "-m", "cncgen", *PLAN, str(small), "-o", str(out)],
        capture_output=True,
        timeout=60,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)),
    )
    refused(run, 2, "out.csv", "too large")
    assert out.read_text() == "before"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out.csv", "small.nc"]


@pytest.mark.skipif(not hasattr(os, "O_TMPFILE"), reason="needs files without a name")
def test_a_process_that_is_killed_leaves_no_file(tmp_path: Path) -> None:
    """SIGKILL, or power that fails, gives nobody the time to remove what was written: it has no name until it is whole."""
    code = (
        "from cncgen.files import OutputFile\n"
        "file = OutputFile('out.csv')\nfile.write(bytes(100000))\nfile.flush()\nprint('written', flush=True)\n"
        "input()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code], cwd=tmp_path, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as run:
        assert run.stdout is not None
        assert run.stdout.readline() == b"written\n"
        run.kill()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("nameless", [True, False])
def test_a_file_appears_whole_whatever_the_system_knows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, nameless: bool
) -> None:
    """Also where the system knows no files without a name."""
    if not nameless:
        monkeypatch.delattr(os, "O_TMPFILE", raising=False)
    out = tmp_path / "out.csv"
    out.write_text("before")
    out.chmod(0o640)
    for text in ("dropped", "after"):
        file = files.OutputFile(out)
        file.write(text.encode())
        assert out.read_text() == "before"
        if text == "dropped":
            file.discard()
        else:
            file.commit()
    assert out.read_text() == "after"
    assert out.stat().st_mode & 0o777 == 0o640
    assert [path.name for path in tmp_path.iterdir()] == ["out.csv"]


@pytest.mark.parametrize(
    "command", ["plan --feedrate ild programs/butterfly.nc -m xy-table", "canon programs/butterfly_g1.nc"]
)
def test_a_reader_that_goes_away(root: Path, command: str) -> None:
    run = subprocess.run(
        ["bash", "-c", f"set -o pipefail; {sys.executable} -m cncgen {command} | head -n 1"],
        capture_output=True,
        timeout=120,
        check=False,
        cwd=root,
    )
    assert run.returncode == 0
    assert run.stdout.count(b"\n") == 1
    assert b"Broken" not in run.stderr
    assert b"Traceback" not in run.stderr
    assert b"Exception" not in run.stderr


def test_closed_standard_output(tmp_path: Path, small: Path) -> None:
    run = subprocess.run(
        ["bash", "-c", f"{sys.executable} -m cncgen plan --feedrate ild {small} >&-"],
        capture_output=True,
        timeout=60,
        check=False,
    )
    refused(run, 2, "standard output")


def writes_into(process: subprocess.Popen[bytes], folder: Path) -> bool:
    """Tell whether a process has opened a file in a folder, one with a name or one without (which Linux shows alone)."""
    with suppress(OSError):  # files are opened and closed meanwhile
        opened = [os.readlink(link) for link in Path(f"/proc/{process.pid}/fd").iterdir()]
        if any(Path(link).parent == folder for link in opened):
            return True
    return bool(list(folder.glob(".out.csv.*")))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_stopped_in_the_middle(tmp_path: Path, number: signal.Signals) -> None:
    """The program comes through a pipe that stays open, so the command is at work when the signal arrives."""
    process = subprocess.Popen(
        [sys.executable, "-m", "cncgen", "simulate", "--axis-params", "xy-table", "-o", "out.csv"],
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=tmp_path,
        # A test run in the background ignores SIGINT (and SIGHUP, under nohup), and its children inherit that.
        preexec_fn=lambda: [signal.signal(s, signal.SIG_DFL) for s in (signal.SIGINT, signal.SIGHUP)],
    )
    assert process.stdin is not None
    rows = "".join(f"{k / 1000:.3f},0.0\n" for k in range(200_000))
    process.stdin.write(b"t_s,x_mm\n" + rows.encode())
    process.stdin.flush()
    deadline = time.monotonic() + 60
    while not writes_into(process, tmp_path) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert writes_into(process, tmp_path), "the command never began to write"
    process.send_signal(number)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 128 + number
    assert b"Traceback" not in said
    assert list(tmp_path.iterdir()) == []


def test_wrong_usage(cncgen: Run, small: Path) -> None:
    refused(cncgen("plan"), 2, "PROGRAM")
    refused(cncgen("plan", small, "--feedrate", "fast"), 2, "fast")
    refused(cncgen(*PLAN, small, "--nonsense"), 2, "--nonsense")
    refused(cncgen("verify", "-", "-p", "-", stdin=SMALL), 2, "both", "standard input")
    refused(cncgen("plna", small), 2, "plna", "did you mean plan?")
    refused(cncgen("xyz", small), 2, "No such command 'xyz'.")
    refused(cncgen(*PLAN, small, "--signals", "vel,speed"), 2, "speed")
    refused(cncgen(*PLAN, small, "-m", "xy-tabel"), 2, "did you mean xy-table")
    refused(cncgen(*PLAN, small, "--feedrate", "optimal"), 2, "--feedrate is given more than once")
    refused(cncgen(*PLAN, "a\0b"[:1] + "\u2028.nc"), 2, "no such file")


def test_an_error_in_the_middle_leaves_no_file(cncgen: Run, tmp_path: Path) -> None:
    lines = [
        b"G21 G90 G64 P0.01",
        *(b"G1 X%d Y%d F6000" % (k % 2, k) for k in range(3000)),
        b"G1 X1 Q=",
        b"M30",
    ]
    (tmp_path / "late.nc").write_bytes(b"\n".join(lines))
    refused(
        cncgen(*PLAN, "late.nc", "-o", "out.csv", "--summary", "s.json", "--events", "e.jsonl"),
        1,
        "late.nc:3002",
    )
    assert [p.name for p in tmp_path.iterdir()] == ["late.nc"]


def test_programs_from_standard_input(cncgen: Run, small: Path) -> None:
    by_file, by_pipe = cncgen(*PLAN, small), cncgen(*PLAN, "-", stdin=SMALL)
    assert by_file.returncode == by_pipe.returncode == 0
    assert by_file.stdout == by_pipe.stdout
    assert by_file.stdout.startswith(b"t_s,x_mm,y_mm\n0.000000000,0.000000000,0.000000000\n")


def test_json_diagnostics(cncgen: Run, tmp_path: Path) -> None:
    (tmp_path / "bad.nc").write_text("G21 G90\nG1 X1e F100\nG1 Y= F100\n")
    run = cncgen("check", "bad.nc", "--json")
    assert run.returncode == 1
    records = [json.loads(line) for line in run.stdout.splitlines()]
    assert {r["line"] for r in records} >= {2, 3}
    assert all(
        {"code", "severity", "message", "file", "line", "column", "hint", "values"} <= set(r) for r in records
    )
    planned = cncgen(*PLAN, "bad.nc", "--json")
    assert planned.returncode == 1
    assert planned.stdout == b""
    assert [json.loads(line) for line in planned.stderr.splitlines()]


def test_an_output_that_is_a_link_is_followed(cncgen: Run, tmp_path: Path, small: Path) -> None:
    (tmp_path / "real.csv").write_text("before")
    (tmp_path / "link.csv").symlink_to("real.csv")
    assert cncgen(*PLAN, small, "-o", "link.csv").returncode == 0
    assert (tmp_path / "link.csv").is_symlink()
    assert (tmp_path / "real.csv").read_text().startswith("t_s,")


def test_the_mode_of_a_file_is_kept_and_of_a_new_one_usual(cncgen: Run, tmp_path: Path, small: Path) -> None:
    old = tmp_path / "old.csv"
    old.write_text("")
    old.chmod(0o640)
    assert cncgen(*PLAN, small, "-o", "old.csv").returncode == 0
    assert cncgen(*PLAN, small, "-o", "new.csv").returncode == 0
    umask = os.umask(0)
    os.umask(umask)
    assert old.stat().st_mode & 0o777 == 0o640
    assert (tmp_path / "new.csv").stat().st_mode & 0o777 == 0o666 & ~umask


@pytest.mark.parametrize("joined", ["2>&1", "2>/dev/null", "-o out.csv 2>&1"])
def test_files_are_written_though_the_reader_goes_away(root: Path, tmp_path: Path, joined: str) -> None:
    program = root / "programs" / "butterfly.nc"
    plan = f"plan --feedrate ild {program} -m xy-table --summary s.json --events e.jsonl"
    run = subprocess.run(
        ["bash", "-c", f"set -o pipefail; {sys.executable} -m cncgen {plan} {joined} | head -n 1"],
        capture_output=True,
        timeout=120,
        check=False,
        cwd=tmp_path,
    )
    assert run.returncode == 0
    assert run.stderr == b""
    summary = json.loads((tmp_path / "s.json").read_text())
    assert summary["samples"] > 1000
    assert summary["path_length_mm"] == pytest.approx(382.8566, abs=1e-3)
    assert {p.name for p in tmp_path.iterdir()} >= {"s.json", "e.jsonl"}
    if "-o" in joined:
        assert len((tmp_path / "out.csv").read_text().splitlines()) == summary["samples"] + 1


@pytest.mark.parametrize("late", ["/dev/full", "none/s.json"])
def test_a_summary_that_cannot_be_written_leaves_no_setpoints(
    cncgen: Run, tmp_path: Path, small: Path, late: str
) -> None:
    (tmp_path / "out.csv").write_text("before")
    refused(cncgen(*PLAN, small, "-o", "out.csv", "--summary", late), 2, late)
    assert (tmp_path / "out.csv").read_text() == "before"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out.csv", "small.nc"]


@pytest.mark.parametrize(
    "command",
    [
        ("simulate", "small.nc", "--feedrate", "ild", "-m", "xy-table"),
        ("tune", "--bandwidth", "10", "-m", "xy-table"),
        ("compare", "small.nc", "--feedrates", "ild", "-m", "xy-table"),
    ],
    ids=lambda command: command[0],
)
def test_files_of_one_run_appear_together(
    in_folder: Path, capsys: pytest.CaptureFixture[str], command: tuple[str, ...]
) -> None:
    """A summary that finds no room takes the result with it, whichever is written first."""
    assert app.run([*command, "-o", "out.txt", "--summary", "/dev/full"]) == 2
    assert "/dev/full: no space" in capsys.readouterr().err
    assert [p.name for p in in_folder.iterdir()] == ["small.nc"]


def test_parameters_are_kept_of_a_run_that_goes_well(in_folder: Path) -> None:
    (in_folder / "bad.nc").write_text("#5221=7\nG1 X= F1\nM2\n")
    assert app.run(["check", "bad.nc", "--save-parameters", "out.var"]) == 1
    assert app.run([*PLAN, "bad.nc", "-o", "out.csv", "--save-parameters", "out.var"]) == 1
    assert not (in_folder / "out.var").exists()
    assert app.run(["check", "bad.nc", "small.nc", "--save-parameters", "out.var"]) == 1
    assert "5221\t0.000000" in (in_folder / "out.var").read_text()


def test_a_machine_and_servo_data_from_pipes(in_folder: Path) -> None:
    """As ``-m <(cncgen machines show xy-table)`` of a shell hands them over; the machine's file is read more than once."""
    content = (Path(files.__file__).parent / "machine" / "profiles" / "xy-table.toml").read_bytes()
    names = []
    for _ in range(2):
        reader, writer = os.pipe()
        os.write(writer, content)
        os.close(writer)
        names.append(f"/dev/fd/{reader}")
    assert app.run(["plan", "small.nc", "-m", "xy-table", "-o", "of-file.csv"]) == 0
    assert app.run(["plan", "small.nc", "-m", names[0], "--axis-params", names[1], "-o", "of-pipe.csv"]) == 0
    assert (in_folder / "of-pipe.csv").read_bytes() == (in_folder / "of-file.csv").read_bytes()
    for name in names:
        os.close(int(name.rpartition("/")[2]))


@pytest.mark.parametrize("option", ["-o", "--summary", "--events", "--save-parameters"])
def test_a_subprogram_that_was_read_is_not_overwritten(cncgen: Run, tmp_path: Path, option: str) -> None:
    """Only the run of the program tells which files it calls: they were replaced, with exit 0."""
    (tmp_path / "sub.ngc").write_text("o<sub> sub\nG1 X5 F600\no<sub> endsub\nM2\n")
    (tmp_path / "main.nc").write_text("G21 G90\nG1 X1 F600\no<sub> call\nM2\n")
    before = (tmp_path / "sub.ngc").read_bytes()
    output = ["-o", "o.csv"] if option != "-o" else ["--format", "csv"]
    run = cncgen("plan", "main.nc", "-m", "xy-table", *output, option, "sub.ngc")
    refused(run, 2, "sub.ngc would overwrite a file that was read")
    assert (tmp_path / "sub.ngc").read_bytes() == before
    assert not (tmp_path / "o.csv").exists()


def test_a_device_may_be_read_and_written(tmp_path: Path) -> None:
    """A terminal, say: here a pseudo-terminal, of which the program comes and to which the setpoints go."""
    pty = pytest.importorskip("pty")
    ours, theirs = pty.openpty()
    os.write(ours, SMALL.replace(b"\n", b"\r") + b"\x04\x04")
    command = [
        sys.executable,
        "-m",
        "cncgen",
        "convert",
        "-",
        "--linearize",
        "0.01",
        "-o",
        os.ttyname(theirs),
    ]
    with open(theirs, "rb") as terminal:
        run = subprocess.run(
            command, cwd=tmp_path, stdin=terminal, capture_output=True, check=False, timeout=120
        )
    os.close(ours)
    assert (run.returncode, run.stderr) == (0, b"")


def test_the_file_of_standard_input_is_not_overwritten(tmp_path: Path) -> None:
    """`cncgen convert - < p.nc -o p.nc` is the program's own file, under no name."""
    (tmp_path / "p.nc").write_bytes(SMALL)
    with open(tmp_path / "p.nc", "rb") as file:
        command = [sys.executable, "-m", "cncgen", "convert", "-", "--linearize", "0.01", "-o", "p.nc"]
        run = subprocess.run(command, cwd=tmp_path, stdin=file, capture_output=True, check=False, timeout=120)
    refused(run, 2, "p.nc would overwrite a file that was read")
    assert (tmp_path / "p.nc").read_bytes() == SMALL


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (("convert", "small.nc", "-o", "small.nc"), "--output small.nc would overwrite the program"),
        (("canon", "small.nc", "-o", "./small.nc"), "would overwrite the program"),
        (("simulate", "small.nc", "-o", "small.nc"), "would overwrite what is read"),
        (("check", "x.nc", "small.nc", "--save-parameters", "small.nc"), "would overwrite a program"),
        (("verify", "small.nc", "-p", "p.nc", "--report", "small.nc"), "would overwrite the setpoints"),
        (("plan", "p.nc", "-m", "small.nc", "--summary", "small.nc"), "would overwrite the machine file"),
        (("plan", "p.nc", "--parameters", "small.nc", "-o", "small.nc"), "overwrite the parameter file"),
        (("cut", "p.nc", "--stock", "small.nc", "--report", "small.nc"), "would overwrite the stock"),
        (("cut", "p.nc", "--target", "small.nc", "-o", "small.nc"), "would overwrite the finished part"),
        (("tune", "-o", "a", "--summary", "a"), "--summary a would overwrite what --output writes"),
    ],
    ids=lambda part: part[0] if isinstance(part, tuple) else "",
)
def test_no_command_overwrites_what_it_reads(
    in_folder: Path, capsys: pytest.CaptureFixture[str], command: tuple[str, ...], words: str
) -> None:
    assert app.run(list(command)) == 2
    assert words in capsys.readouterr().err
    assert (in_folder / "small.nc").read_bytes() == SMALL


def test_parameters_may_go_back_to_their_file(in_folder: Path) -> None:
    (in_folder / "p.var").write_text("5221 3\n")
    assert app.run(["check", "small.nc", "--parameters", "p.var", "--save-parameters", "p.var"]) == 0
    assert "5221\t3.000000" in (in_folder / "p.var").read_text()


def test_an_interrupt_while_commands_are_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(arguments: object) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(app, "run", interrupted)
    with pytest.raises(SystemExit) as left:
        main([])
    assert left.value.code == 130


def test_the_entry_imports_nothing() -> None:
    """Until `main` takes the signals, an interrupt is the interpreter's, which shows it as a traceback."""
    script = (
        "import sys; before = set(sys.modules); import cncgen.cli; print(*sorted({*sys.modules} - before))"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, timeout=60, check=True)
    assert run.stdout.split() == [b"cncgen", b"cncgen.cli"]


#: A run that interrupts itself where a function of a name, in a file of a name, is called for the n-th time.
INTERRUPTED = """
import os, signal, sys
file, function, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
def profile(frame, event, argument):
    global count
    code = frame.f_code
    if event == "call" and file in code.co_filename and function in (code.co_name, "*"):
        count -= 1
        if count == 0:
            sys.setprofile(None)
            os.kill(os.getpid(), signal.SIGINT)
signal.signal(signal.SIGINT, signal.default_int_handler)
from cncgen.cli import main
sys.setprofile(profile)
main(["plan", "--feedrate", "ild", "small.nc", "-o", "out.csv"])
"""


@pytest.mark.parametrize(
    ("file", "function", "count"),
    [
        # Of a weak reference: what it raises is printed, and the import goes on.
        *(("importlib._bootstrap", "cb", count) for count in (1, 2, 7, 40)),
        # What it raises becomes RuntimeError.
        *(("functools.py", "__set_name__", count) for count in (1, 2, 7)),
        # Any call after that of `main`.
        *(("", "*", count) for count in (2, 7, 40, 400, 4000)),
    ],
)
def test_an_interrupt_amid_imports(in_folder: Path, file: str, function: str, count: int) -> None:
    run = subprocess.run(
        [sys.executable, "-c", INTERRUPTED, file, function, str(count)],
        capture_output=True,
        timeout=60,
        check=False,
    )
    assert run.returncode == 130
    assert run.stderr in (b"", b"error[interrupted]: the command was interrupted\n")
    assert [path.name for path in in_folder.iterdir()] == ["small.nc"]


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_amid_a_destructor_ends_the_run(name: str) -> None:
    """What a destructor raises is printed and lost: the command would go on, and end with 0."""
    script = (
        "import os, signal\nfrom cncgen.cli import app, main\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        # A process takes over what its parent ignores.
        "signal.signal(signal.SIGTERM, signal.SIG_DFL)\n"
        f"class Last:\n    def __del__(self):\n        os.kill(os.getpid(), signal.{name})\n"
        "def run(arguments):\n    Last()\n    return 0\n"
        "app.run = run\nmain([])\n"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, timeout=60, check=False)
    assert run.returncode == 128 + getattr(signal, name)
    assert run.stderr == (b"error[interrupted]: the command was interrupted\n" if name == "SIGINT" else b"")


@pytest.mark.parametrize("count", [1, 2, 5, 9])
def test_an_interrupt_while_hdf5_writes(in_folder: Path, count: int) -> None:
    """HDF5 calls the file's methods back, and ends the process where one of them raises."""
    pytest.importorskip("h5py")
    script = INTERRUPTED.replace("out.csv", "out.h5")
    run = subprocess.run(
        [sys.executable, "-c", script, "hdf5.py", "write", str(count)],
        capture_output=True,
        timeout=60,
        check=False,
    )
    assert run.returncode == 130
    assert run.stderr == b"error[interrupted]: the command was interrupted\n"
    assert [path.name for path in in_folder.iterdir()] == ["small.nc"]


def test_a_signal_amid_an_import_leaves_no_temporary_file(
    in_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the system has no nameless files, what is half written has a name, and is removed before the process ends."""
    monkeypatch.setattr(files, "_nameless", lambda folder: None)
    file = files.OutputFile("out.csv")
    assert len(list(in_folder.iterdir())) == 2
    app.last_words(signal.SIGTERM)
    assert [path.name for path in in_folder.iterdir()] == ["small.nc"]
    file.discard()
    assert files._temporaries == set()


@pytest.mark.parametrize("command", ["check", "plan", "convert"])
def test_under_json_every_line_is_json(
    in_folder: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    """No summary, no text between: a script reads standard error (of check, standard output) line by line."""
    (in_folder / "bad.nc").write_text("G1 X\n" * 30 + "M2\n")
    for name, code in (("bad.nc", 1), ("small.nc", 0), ("none.nc", 2)):
        assert app.run([command, name, "--json", *(["-o", "out.csv"] if command != "check" else [])]) == code
        said = capsys.readouterr()
        lines = [json.loads(line) for line in (said.out + said.err).splitlines()]
        assert [item["severity"] for item in lines].count("error") == {0: 0, 1: 10, 2: 1}[code]
        assert [item["values"]["count"] for item in lines if item["code"] == "suppressed"] == [20] * (
            code == 1
        )


def test_wrong_usage_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (["plan", "--nonsense", "--json"], ["check", "--json"], ["--json"]):
        assert app.run(arguments) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert json.loads(line)["code"] == "usage"


def test_beyond_the_travel_there_is_no_plan(in_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The program is sound, and the machine does not reach: exit 3; without the axis it is the wrong program: 1."""
    (in_folder / "far.nc").write_text("G21 G90\nG1 X600 F1000\nM2\n")
    assert app.run(["check", "far.nc"]) == 0
    assert app.run([*PLAN, "far.nc", "-m", "xy-table", "-o", "out.csv"]) == 3
    assert "far.nc:2:1: error[travel-exceeded]" in capsys.readouterr().err
    (in_folder / "far.nc").write_text("G21 G90\nG1 X600 Z1 F1000\nM2\n")
    assert app.run([*PLAN, "far.nc", "-m", "xy-table", "-o", "out.csv"]) == 1
    assert not (in_folder / "out.csv").exists()


@pytest.mark.parametrize("name", ["a.jpg", "/dev/null/a", "small.nc"])
def test_pictures_have_their_formats_and_folders(
    in_folder: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    assert app.run(["plot", "small.nc", "--feedrate", "ild", "-m", "xy-table", "-o", name]) == 2
    said = capsys.readouterr().err
    assert name in said
    assert said.startswith("error[")
    assert [p.name for p in in_folder.iterdir()] == ["small.nc"]


def test_outputs_do_not_overwrite_each_other_or_the_program(cncgen: Run, tmp_path: Path, small: Path) -> None:
    before = small.read_bytes()
    refused(cncgen(*PLAN, small, "-o", small), 2, "overwrite the program")
    (tmp_path / "link.nc").symlink_to(small)
    refused(cncgen(*PLAN, small, "--summary", "link.nc"), 2, "--summary", "overwrite the program")
    refused(cncgen(*PLAN, small, "-o", "a.csv", "--events", "./a.csv"), 2, "--events", "what --output writes")
    assert small.read_bytes() == before
    assert not (tmp_path / "a.csv").exists()
    assert cncgen(*PLAN, small, "-o", "/dev/null", "--events", "/dev/null").returncode == 0


def test_names_that_are_no_utf8_and_names_with_letters(cncgen: Run, tmp_path: Path) -> None:
    for name in ("größe 文.nc", os.fsdecode(b"bad\xff.nc")):
        (tmp_path / name).write_bytes(SMALL)
        run = cncgen(*PLAN, name, "-o", f"{name}.csv", "--summary", "s.json")
        assert run.returncode == 0, run.stderr
        assert (tmp_path / f"{name}.csv").is_file()
        assert json.loads((tmp_path / "s.json").read_text())["program"] == name
        assert cncgen("report", name, "--feedrate", "ild", "-o", "r.html").returncode == 0


def test_a_program_cannot_steer_the_terminal(cncgen: Run, tmp_path: Path) -> None:
    (tmp_path / "steer.nc").write_bytes(b"G21\nG1 X\x1b[31mRED\x07 \x9b2J F1\nM2\n")
    said = cncgen("check", "steer.nc").stderr
    assert b"\x1b" not in said
    assert b"\x07" not in said
    assert "\x9b" not in said.decode()
    assert "G1 X␛[31mRED␇".encode() in said


@pytest.mark.parametrize("nothing", [b"", b"\n\n", b"# a comment alone\n"])
def test_a_pipe_whose_writer_failed_is_empty_and_no_strange_file(cncgen: Run, nothing: bytes) -> None:
    """As of ``cncgen plan bad.nc | cncgen simulate``."""
    run = cncgen("simulate", "--axis-params", "xy-table", stdin=nothing)
    said = refused(run, 2, "setpoints-")
    assert ("did the command before the pipe end with an error?" in said) == (b"#" not in nothing)


def test_npz_through_a_pipe(cncgen: Run, small: Path) -> None:
    planned = cncgen(*PLAN, small, "-m", "xy-table", "--format", "npz")
    judged = cncgen("verify", "-", "-p", small, "-m", "xy-table", stdin=planned.stdout)
    assert b"setpoints every 1 ms" in judged.stderr
    assert judged.returncode in (0, 1)


def test_a_thread_left_at_work_does_not_hold_or_break_the_exit() -> None:
    """A command that is interrupted leaves its threads; the process ends with its code, all output written."""
    script = """
import sys, threading, time
from cncgen.cli import app, main
def command(arguments):
    threading.Thread(target=time.sleep, args=(60,)).start()
    print("x" * 100_000)
    sys.stdout.flush()
    return 130
app.run = command
main([])
"""
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, timeout=30, check=False)
    assert run.returncode == 130
    assert len(run.stdout) == 100_001


@pytest.mark.parametrize("number", ["nan", "inf", "1e300", "1e-300"])
@pytest.mark.parametrize(
    "command",
    [
        ("plan", "p.nc", "--path-tolerance"),
        ("plan", "p.nc", "--max-contour-error"),
        ("verify", "s.csv", "-p", "p.nc", "--path-tolerance"),
        ("verify", "s.csv", "-p", "p.nc", "--period"),
        ("simulate", "s.csv", "--settle"),
        ("simulate", "s.csv", "--period"),
        ("convert", "p.nc", "--fit"),
        ("convert", "p.nc", "--linearize"),
        ("compensate", "s.csv", "--settle"),
        ("excite", "--axis", "X", "--duration"),
        ("tune", "--bandwidth"),
        ("cut", "p.nc", "--cell"),
    ],
    ids=lambda command: f"{command[0]} {command[-1]}",
)
def test_options_are_within_what_a_double_holds(
    capsys: pytest.CaptureFixture[str], command: tuple[str, ...], number: str
) -> None:
    """A tolerance that is no number would hold whatever the setpoints do, a wait without end would never end, and 1e300² is no number."""
    assert app.run([*command, number]) == 2
    assert command[-1] in capsys.readouterr().err


def test_a_run_that_needs_more_memory_than_it_may_take(
    in_folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """An array of 2 GiB beyond a bound of 1 GiB is never made; the bound ends with the run."""

    def greedy(*_: object, **__: object) -> None:
        np.ones(2**28)

    monkeypatch.setattr("cncgen.pipeline.check", greedy)
    assert app.run(["check", "small.nc", "--max-memory", "1024"]) == 3
    said = capsys.readouterr().err
    assert "error[max-memory]: the run needs more memory than 1024 MiB" in said
    assert "--max-memory sets the bound" in said
    assert len(np.empty(2**28)) == 2**28


def test_a_thread_without_room_for_its_stack_is_a_lack_of_memory(
    in_folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Stacks of 8 MiB each do not fit 64 times into 64 MiB, and are free again when the error is looked at."""

    def threads(*_: object, **__: object) -> None:
        end = threading.Event()
        started = []
        try:
            for _ in range(64):
                started.append(threading.Thread(target=end.wait, daemon=True))
                started[-1].start()
        finally:
            end.set()
            for thread in started[:-1]:
                thread.join()

    monkeypatch.setattr("cncgen.pipeline.check", threads)
    assert app.run(["check", "small.nc", "--max-memory", "64"]) == 3
    said = capsys.readouterr().err
    assert "error[max-memory]: the run needs more memory than 64 MiB" in said
    assert "ulimit -u" in said


def test_a_bound_of_memory_beyond_what_a_system_counts(in_folder: Path) -> None:
    assert app.run(["check", "small.nc", "--max-memory", "99999999999999999999"]) == 2


@pytest.mark.skipif(sys.platform != "linux", reason="memory is bounded through Linux's resource limits")
def test_what_the_system_allows_is_said_where_it_is_less(tmp_path: Path) -> None:
    """Of 200 MB that ulimit allows, the interpreter takes some: cutting counts what is left, and a run names it."""
    (tmp_path / "p.nc").write_text("G21 G90\nG1 X450 F1\nM2\n")

    def run(*words: str, ulimit: str = "-d 200000") -> tuple[int, str]:
        script = f"ulimit {ulimit}; exec {shlex.quote(sys.executable)} -m cncgen {shlex.join(words)}"
        done = subprocess.run(["sh", "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)
        return done.returncode, done.stderr

    code, said = run("cut", "p.nc", "--stock", "box:0,0,-5,40,30,0", "--tool", "*=flat:6", "--cell", "0.01")
    assert code == 2
    assert re.search(r"4000 x 3000 columns, which take 641 MiB, and there is room for 1?\d\d MiB", said)
    code, said = run("compare", "p.nc", "-m", "xy-table")
    assert code == 3
    assert re.search(r"more memory than 1\d\d MiB, which the system allows this process", said)
    assert "ulimit -d" in said
    # Of 300 MB of addresses, code and mapped files take some too.
    code, said = run("compare", "p.nc", "-m", "xy-table", ulimit="-v 300000")
    assert code == 3
    assert re.search(r"more memory than [12]\d\d MiB, which the system allows this process", said)
    assert "ulimit -v" in said


def test_a_fault_of_ours_is_one_line_and_its_own_exit_code(
    in_folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fails(*_: object, **__: object) -> None:
        raise ValueError("odd")

    monkeypatch.setattr("cncgen.pipeline.check", fails)
    assert app.run(["check", "small.nc"]) == app.INTERNAL_ERROR
    said = capsys.readouterr().err
    assert "ValueError: odd" in said
    assert "Traceback" not in said
    monkeypatch.setenv("CNCGEN_TRACEBACK", "1")
    assert app.run(["check", "small.nc", "--json"]) == app.INTERNAL_ERROR
    said = capsys.readouterr()
    assert "Traceback" in said.err
    assert json.loads(said.out)["code"] == "internal"


def test_control_characters_of_a_message_are_printed_as_escapes(
    in_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A message could colour a terminal, or ring it."""
    (in_folder / "m.nc").write_text("G21\n(MSG,a\x1b[31mb\x07)\nM2\n")
    assert app.run(["canon", "m.nc"]) == 0
    assert 'MESSAGE("a\\x1b[31mb\\x07")' in capsys.readouterr().out


def test_a_working_directory_that_is_gone_is_named(
    in_folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (in_folder / "gone").mkdir()
    monkeypatch.chdir(in_folder / "gone")
    (in_folder / "gone").rmdir()
    assert app.run(["plan", str(in_folder / "small.nc"), "-o", "small.csv"]) == 2
    assert "the working directory: No such file or directory" in capsys.readouterr().err

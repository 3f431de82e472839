"""Runs LinuxCNC's stand-alone interpreter `rs274` on our programs and reads what it prints.

The peer stops at the first error (its default, ``-n 2``); it has printed the calls of the blocks before. It *rewrites* its parameter file, so every run gets a scratch copy.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

OPTIONS = re.compile(r"^; peer: (.*)$", re.M)
CALL = re.compile(r"^ *\d+ +N(\.+|\d*) +(.*)$")


@dataclass(frozen=True)
class Setup:
    """Files and options of a program, as its first line gives them: ``; peer: tools=mill.tbl block-delete``."""

    tools: Path | None = None
    parameters: Path | None = None
    include: tuple[Path, ...] = ()
    block_delete: bool = False


@dataclass
class Output:
    """The canonical calls, without the peer's numbering, and the error that ended the run, or None.

    Of a run that an error ended, the last `partial` calls are those that the wrong block made before it was found wrong.
    """

    calls: list[str] = field(default_factory=list)
    error: str | None = None
    block: str = ""
    partial: int = 0

    def text(self) -> str:
        """Return the form in which expected output is stored."""
        tail = (
            []
            if self.error is None
            else [
                f"error: {self.error}",
                f"block: {self.block}",
                f"partial: {self.partial}",
            ]
        )
        return "\n".join([*self.calls, *tail]) + "\n"

    @classmethod
    def parse(cls, text: str) -> Output:
        """Read back what `text` wrote."""
        result = cls()
        for line in text.splitlines():
            if line.startswith("error: "):
                result.error = line.removeprefix("error: ")
            elif line.startswith("block: "):
                result.block = line.removeprefix("block: ")
            elif line.startswith("partial: "):
                result.partial = int(line.removeprefix("partial: "))
            else:
                result.calls.append(line)
        return result


def installed() -> bool:
    """Tell whether the peer is on this machine."""
    return shutil.which("rs274") is not None


def setup_of(program: Path) -> Setup:
    """Read the options in the first line of a program."""
    found = OPTIONS.search(program.read_text())
    words = dict(w.partition("=")[::2] for w in found[1].split()) if found else {}
    here = program.parent
    return Setup(
        tools=here / words["tools"] if "tools" in words else None,
        parameters=here / words["parameters"] if "parameters" in words else None,
        include=(here / words["include"],) if "include" in words else (),
        block_delete="block-delete" in words,
    )


def run(program: Path, setup: Setup | None = None) -> Output:
    """Run `rs274 -g` on a program and return what it printed."""
    setup = setup or setup_of(program)
    result = run_once(program, setup)
    if result.error is not None:
        result.calls = without_reset(result.calls)
        result.partial = _partial(program, setup, result)
    return result


def calls_of(lines: Iterable[str]) -> list[str]:
    """Return the canonical calls among printed lines, without their count, behind the N word of their line if any."""
    found = [match for line in lines if (match := CALL.match(line))]
    return [match[2] if match[1].startswith(".") else f"N{match[1]} {match[2]}" for match in found]


def without_reset(calls: list[str]) -> list[str]:
    """Drop what the peer prints when it is reset at the end of a run."""
    count = len(calls)
    while count and calls[count - 1] == "ON_RESET()":
        count -= 1
    return calls[:count]


def _partial(program: Path, setup: Setup, result: Output) -> int:
    """Count the calls of the wrong block: run the lines before it alone (0 where these do not lead straight to it)."""
    lines = program.read_text().splitlines()
    wrong = next((n for n, text in enumerate(lines) if text.strip() == result.block.strip()), 0)
    with tempfile.NamedTemporaryFile("w", suffix=".part", dir=program.parent) as start:
        start.write("\n".join([*lines[:wrong], ""]))
        start.flush()
        before = without_reset(run_once(Path(start.name), setup).calls)
    agrees = result.calls[: len(before)] == before
    return len(result.calls) - len(before) if agrees else 0


def run_once(program: Path, setup: Setup, timeout_s: float = 20.0) -> Output:
    """Run the peer and read its output; nothing is known of `partial`."""
    with tempfile.TemporaryDirectory(prefix="rs274-") as scratch:
        command = [*_command(setup, Path(scratch)), program.name]
        done = subprocess.run(
            command,
            cwd=program.parent,
            # The peer keeps its tool table in the home directory, where runs side by side would share it.
            env=os.environ | {"HOME": scratch},
            capture_output=True,
            timeout=timeout_s,
            check=False,
            encoding="latin-1",
        )
    # Messages of the peer must not show where the checkout lies.
    return read_output(done.stdout, done.stderr.replace(f"{program.parent}{os.sep}", ""), done.returncode)


def _command(setup: Setup, scratch: Path) -> list[str]:
    variables = scratch / "rs274.var"
    variables.write_text(setup.parameters.read_text() if setup.parameters else "")
    command = ["rs274", "-v", str(variables), "-g"]
    if setup.tools:
        command += ["-t", str(setup.tools)]
    if setup.block_delete:
        command.append("-b")
    if setup.include:
        ini = scratch / "rs274.ini"
        path = ":".join(str(p) for p in setup.include)
        ini.write_text(f"[RS274NGC]\nSUBROUTINE_PATH = {path}\n")
        command += ["-i", str(ini)]
    return command


def read_output(stdout: str, stderr: str, status: int) -> Output:
    """Take the calls from standard output and the error (its last two lines) from standard error."""
    calls = calls_of(stdout.splitlines())
    if status == 0:
        return Output(calls)
    remarks = [line for line in stderr.splitlines() if line and line != "executing"]
    error, block = (
        (remarks[-2], remarks[-1]) if len(remarks) > 1 else ("".join(remarks) or f"status {status}", "")
    )
    return Output(calls, error, block)

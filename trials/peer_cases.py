"""The cases of `tests/peer/cases`: programs with the canonical calls that LinuxCNC's `rs274` printed for them.

A file holds the cases of one concern, one after the other:

    ==== arcs_radius
    G21 F100
    G2 X10 Y0 R5
    ----
    USE_LENGTH_UNITS(CANON_UNITS_MM)
    ...

The line ``====`` names the case; above the rule ``----`` stands the program, below it the expected output as
`trials.rs274.Output.text` writes it. Where we differ from the peer, the first line says why: ``| the peer's fault: …`` or
``| our choice: …``. A new case may lack the rule: ``python -m trials.regenerate_peer_cases NAME`` adds it with the output.

Tables, parameter files and subprograms that programs ask for stand in `tests/peer/files`.
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

PEER = Path(__file__).resolve().parents[1] / "tests" / "peer"
CASES = PEER / "cases"
FILES = PEER / "files"

BEGIN, RULE = "==== ", "----\n"
FAULT, CHOICE = " | the peer's fault: ", " | our choice: "


@dataclass(frozen=True, slots=True)
class PeerCase:
    """A program and the output of the peer.

    Attributes:
        name: The stem of its file when it is run.
        program: Its text.
        expected: The peer's output, None where it was not run yet.
        fault: How the peer is wrong by its own manual, or by geometry; empty where it is right.
        choice: Why we differ although the peer is not wrong; empty where we agree.
    """

    name: str
    program: str
    expected: str | None = None
    fault: str = ""
    choice: str = ""

    @property
    def differs(self) -> bool:
        """Tell whether our calls must differ from those of the peer."""
        return bool(self.fault or self.choice)

    def text(self) -> str:
        """Return the case as its file has it."""
        reason = f"{FAULT}{self.fault}" if self.fault else f"{CHOICE}{self.choice}" if self.choice else ""
        output = "" if self.expected is None else f"{RULE}{self.expected}"
        return f"{BEGIN}{self.name}{reason}\n{self.program}{output}"

    @classmethod
    def parse(cls, text: str) -> PeerCase:
        """Read back what `text` wrote."""
        head, _, body = text.removeprefix(BEGIN).partition("\n")
        head, _, fault = head.partition(FAULT)
        name, _, choice = head.partition(CHOICE)
        program, rule, output = body.partition(f"\n{RULE}")
        return cls(name, f"{program}\n" if rule else program, output if rule else None, fault, choice)


def read_file(path: Path) -> list[PeerCase]:
    """Return the cases of one concern, in the order of the file."""
    _, *parts = f"\n{path.read_text(encoding='utf-8')}".split(f"\n{BEGIN}")
    last = len(parts) - 1
    return [PeerCase.parse(part if k == last else f"{part}\n") for k, part in enumerate(parts)]


def write_file(path: Path, found: list[PeerCase]) -> None:
    """Write the cases of one concern."""
    path.write_text("".join(case.text() for case in found), encoding="utf-8")


def peer_cases() -> list[PeerCase]:
    """Return all cases, sorted by name."""
    return sorted(
        (case for path in sorted(CASES.glob("*.txt")) for case in read_file(path)), key=lambda c: c.name
    )


def write_programs(folder: Path) -> None:
    """Write every program as ``NAME.ngc`` into a folder, beside the files that programs ask for."""
    shutil.copytree(FILES, folder, dirs_exist_ok=True)
    for case in peer_cases():
        (folder / f"{case.name}.ngc").write_text(case.program, encoding="utf-8")

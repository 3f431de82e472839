"""Fuzzing of every door: what was found stays mended, and a few changed inputs of each show nothing."""

from __future__ import annotations

import sys
import threading
from pathlib import Path

import pytest

from trials import doors

CORPUS = Path(__file__).parent / "doors"
OPEN = Path(__file__).parent / "doors_open"

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="memory is bounded through Linux's resource limits"
)


def said(findings: list[doors.Finding]) -> str:
    """Return all that is known of findings."""
    return "\n".join(f"{each.door}: {each.kind}\n{each.said}\n{each.data!r}" for each in findings)


def test_kept_inputs_show_nothing() -> None:
    """Each of them ended in an exception, a warning or a signal before it was mended."""
    assert said(doors.replay(CORPUS)) == ""


@pytest.mark.xfail(
    strict=True,
    reason="not mended yet",
)
@pytest.mark.parametrize("file", sorted(OPEN.glob("*/*")), ids=lambda file: file.name)
def test_open_findings_show_nothing(file: Path) -> None:
    """An input that is mended moves to the kept ones."""
    door = file.parent.name
    _, findings = doors.batch(door, doors.doors()[door], [file.read_bytes()])
    assert said(findings) == ""


def test_a_new_kind_of_fault_is_told_from_open_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """A known exception at another door, and another one at the same door, are new."""
    known = doors.Finding("plan", "MemoryError in another function", "", b"")
    monkeypatch.setattr(doors, "replay", lambda folder: [known])
    kinds = {
        ("plan", "MemoryError in arcs.py:evaluate"),
        ("tools", "MemoryError in x"),
        ("plan", "KeyError in x"),
    }
    assert doors.not_known(kinds, OPEN) == {("tools", "MemoryError in x"), ("plan", "KeyError in x")}


def test_kept_inputs_belong_to_doors() -> None:
    assert {path.name for folder in (CORPUS, OPEN) for path in folder.glob("*")} <= set(doors.doors())


@pytest.mark.parametrize("name", doors.doors())
def test_changed_inputs_show_nothing_new(name: str) -> None:
    """Some seconds of one seed; `python -m trials.doors` draws fresh ones, for as long as it is told."""
    found = doors.tested(name)
    new = doors.not_known({(name, each.kind) for each in found}, OPEN)
    assert said([each for each in found if (name, each.kind) in new]) == ""


def test_the_harness_finds_what_is_wrong() -> None:
    """An exception, a warning of a library, what it prints, and the end of the process are each a finding."""

    def one(data: bytes) -> None:
        import faulthandler
        import os
        import warnings

        if data == b"raises":
            raise KeyError("odd")
        if data == b"warns":
            warnings.warn("odd", RuntimeWarning, stacklevel=1)
        if data == b"prints":
            os.write(2, b"** On entry to DLASCL parameter number 4 had an illegal value\n")
        if data == b"ends":
            faulthandler.disable()  # the end is wanted: nobody reads where
            os.abort()

    door = doors.Door(lambda: [b""], lambda rng, data, seeds: data, one)
    inputs = [b"fine", b"raises", b"warns", b"prints", b"ends"]
    ran, findings = doors.batch("any", door, inputs)
    assert ran == len(inputs)
    assert [each.data for each in findings] == inputs[1:]
    kinds = [each.kind.split()[0] for each in findings]
    assert kinds == ["KeyError", "RuntimeWarning", "a", "the"]


def test_an_input_that_sleeps_is_ended_and_told_with_its_stack(monkeypatch: pytest.MonkeyPatch) -> None:
    """A child that waits takes no processor time: one waited until the test's own limit, and nobody saw for what."""
    lock = threading.Lock()
    lock.acquire()

    def waits(data: bytes) -> None:
        if data == b"waits":
            lock.acquire()

    monkeypatch.setattr(doors, "CLOCK_SECONDS", 1.0)
    door = doors.Door(lambda: [b""], lambda rng, data, seeds: data, waits)
    inputs = [b"fine", b"waits", b"fine"]
    findings = [each for _, found in doors.batches("any", door, inputs) for each in found]
    assert [(each.data, each.kind) for each in findings] == [
        (b"waits", "the process ends: an input ran for 1 s by the clock")
    ]
    assert "in waits" in findings[0].said

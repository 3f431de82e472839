"""Records beside the dataclasses of the standard library, which they are to mean the same as."""

from __future__ import annotations

import copy
import dataclasses
import enum
import inspect
import json
import pickle
from typing import Any, ClassVar

import pytest

from cncgen import records


def both(**how: bool) -> list[Any]:
    """Return one class made a record, and made a dataclass."""
    made = []
    for module in (records, dataclasses):

        class Pair:
            """Two values."""

            SIZE: ClassVar = 2
            first: int
            second: float = 2.0
            notes: list[str] = module.field(default_factory=list)  # type: ignore[attr-defined]
            _kept: list[int] = module.field(default_factory=list, init=False, repr=False)  # type: ignore[attr-defined]

            def total(self) -> float:
                """Return the sum."""
                return self.first + self.second

        made.append(module.dataclass(slots=True, **how)(Pair))  # type: ignore[attr-defined]
    return made


@pytest.mark.parametrize("how", [{}, {"frozen": True}, {"eq": False}, {"repr": False}], ids=str)
def test_a_record_does_what_a_dataclass_does(how: dict[str, bool]) -> None:
    record, expected = both(**how)
    for made_before in (0, 200):  # the first are made without a function of their class
        for _ in range(made_before):
            record(1)
        compare(record, expected, how)


def compare(record: Any, expected: Any, how: dict[str, bool]) -> None:
    """Compare what the two classes do."""
    for make in (
        lambda kind: kind(),
        lambda kind: kind(1, 2, [], []),
        lambda kind: kind(1, other=2),
        lambda kind: kind(1, first=1),
    ):
        with pytest.raises(TypeError):
            make(expected)
        with pytest.raises(TypeError):
            make(record)
    told = []
    for kind in (record, expected):
        one, same, other = kind(1), kind(first=1, second=2.0), kind(1, 3.0, ["x"])
        with pytest.raises((AttributeError, TypeError)):  # a TypeError of frozen dataclasses with slots
            one.unknown = 1
        changed: Any = None
        try:
            one.second = 5.0
            changed = one.second
            one.second = 2.0
        except dataclasses.FrozenInstanceError as error:
            changed = str(error)
        try:
            hashed: Any = hash(dataclasses.replace(one, notes=())) if how else hash(one)
        except TypeError:
            hashed = "no hash"
        told.append(
            (
                (one == same, one == other, one != other, one == 1, one.notes is same.notes),
                repr(one).partition("(")[2] if how != {"repr": False} else "",
                (changed, hashed == "no hash"),
                (one.total(), kind.SIZE, kind.__match_args__, kind.__slots__),
                dataclasses.asdict(other),
                [each.name for each in dataclasses.fields(kind)],
                dataclasses.is_dataclass(one),
                str(inspect.signature(kind)),
                dataclasses.astuple(copy.deepcopy(other)),
                dataclasses.astuple(records.replace(other, first=7)) if kind is record else None,
            )
        )
    assert told[0][:-2] == told[1][:-2]
    assert told[0][-2] == told[1][-2] == (1, 3.0, ["x"], [])
    assert told[0][-1] == (7, 3.0, ["x"], [])


@records.dataclass(frozen=True, slots=True)
class Place:
    """A record that a pickle finds again."""

    x: float
    y: float = 0.0


def test_a_frozen_record_is_pickled() -> None:
    assert pickle.loads(pickle.dumps(Place(1.0))) == Place(1.0, 0.0)
    assert hash(Place(1.0)) == hash((1.0, 0.0))


class Grade(records.IntEnum):
    """An enumeration that a pickle finds again."""

    LOW = 0
    HIGH = 1


class Tone(records.StrEnum):
    """One of texts."""

    SOFT = "soft"
    LOUD = "loud"


@pytest.mark.parametrize(
    ("ours", "base", "missing"),
    [(Grade, enum.IntEnum, 2), (Tone, enum.StrEnum, "shrill")],
    ids=["int", "str"],
)
def test_an_enumeration_does_what_one_of_the_standard_library_does(
    ours: Any, base: Any, missing: Any
) -> None:
    theirs = base(ours.__name__, {member.name: member.value for member in ours})
    told = []
    for kind in (ours, theirs):
        with pytest.raises(ValueError, match=f"is not a valid {kind.__name__}"):
            kind(missing)
        told.append(
            [
                (
                    m.name,
                    m.value,
                    str(m),
                    repr(m),
                    f"{m:>5}",
                    json.dumps([m]),
                    hash(m) == hash(m.value),
                    m == m.value,
                )
                for m in kind
            ]
        )
        assert len(kind) == 2
        assert all(kind(m.value) is getattr(kind, m.name) is m for m in kind)
        assert all(copy.copy(m) is m is copy.deepcopy(m) for m in kind)
    assert told[0] == told[1]
    assert all(pickle.loads(pickle.dumps(m)) is m and isinstance(m, ours) for m in ours)

"""Checks of the library's arguments: a wrong argument raises a `UsageError` that names the expected values."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.units import AXIS_LETTERS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, TypeGuard, TypeVar

    _T = TypeVar("_T")
    _Function = TypeVar("_Function", bound=Callable[..., Any])

#: Words for types of annotations.
_WORDS = {
    "str": "a text",
    "bool": "True or False",
    "PlanOptions": "cncgen.PlanOptions",
    "ReadOptions": "cncgen.ReadOptions",
}
#: Types whose values are looked at where they are used: numbers by their range, files as they are opened, containers by their elements.
_LATER = {"Any", "Callable", "float", "int", "PathLike", "Path", "Iterable", "Sequence", "Mapping", "tuple"}


def wrong(message: str, hint: str = "") -> UsageError:
    """Return the exception of a wrong argument."""
    return UsageError(Diagnostic("argument", message, hint=hint))


def expect(value: Any, kinds: type | tuple[type, ...], name: str, wanted: str, hint: str = "") -> Any:
    """Return `value` where it is of the `kinds`.

    Raises:
        UsageError: It is not; `name` is that of the argument and `wanted` describes the expected value.
    """
    if not isinstance(value, kinds):
        raise wrong(f"{name} is of type {type(value).__name__}; it is to be {wanted}", hint)
    return value


def declared(function: _Function) -> _Function:
    """Let a function refuse texts, truth values and records that its annotations do not allow, before it runs.

    The function itself looks at numbers, files and containers: it knows what they are for.
    """
    import functools

    code = function.__code__
    positional, all_of_them = code.co_argcount, code.co_argcount + code.co_kwonlyargcount
    names, annotations = code.co_varnames[:all_of_them], function.__annotations__

    @functools.wraps(function)
    def checked(*given: Any, **named: Any) -> Any:
        values = dict(zip(names[:positional], given, strict=False)) | named
        faults = mistyped({name: values[name] for name in names if name in values}, annotations)
        if faults:
            raise UsageError(faults)
        return function(*given, **named)

    return checked  # type: ignore[return-value]


def mistyped(values: Mapping[str, Any], annotations: Mapping[str, str]) -> list[Diagnostic]:
    """Return a fault of each value that is of no type of the annotation under its name; see `declared`.

    Types are told by their names: those of records are not imported for it.
    """
    faults = []
    for name, value in values.items():
        types = _types(annotations[name])
        known = {"None" if kind is type(None) else kind.__name__ for kind in type(value).__mro__}
        if known.isdisjoint(types) and _LATER.isdisjoint(types):
            wanted = " or ".join(_WORDS.get(kind, kind) for kind in types)
            message = f"{name} is of type {type(value).__name__}; it is to be {wanted}"
            faults.append(Diagnostic("argument", message))
    return faults


def _types(annotation: str) -> list[str]:
    """Return the names of the types of an annotation, without their modules and parameters."""
    depth, plain = 0, ""
    for sign in annotation:
        depth += (sign == "[") - (sign == "]")
        plain += sign if depth == 0 and sign != "]" else ""
    return [kind.strip().rpartition(".")[2] for kind in plain.split("|")]


def expect_path(value: Any, name: str, wanted: str) -> str:
    """Return a file's name, or raise `UsageError`; see `expect`."""
    return str(os.fsdecode(expect(value, (str, os.PathLike), name, wanted)))


def expect_axes(value: Any, name: str) -> str:
    """Return letters of axes, which stand in capitals and once each.

    Raises:
        UsageError: They do not.
    """
    if isinstance(value, str) and value and len(set(value)) == len(value) and set(value) <= set(AXIS_LETTERS):
        return value
    raise wrong(f"{name} = {value!r} must be letters of axes, of {AXIS_LETTERS}, once each")


def is_number(value: object) -> TypeGuard[float]:
    """Tell a number that is a finite double (numpy's too) from everything else, truth values included."""
    if isinstance(value, bool):
        return False
    if not isinstance(value, float | int):
        import numbers

        if not isinstance(value, numbers.Real):
            return False
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number too long for a double
        return False


def expect_number(
    value: Any, name: str, low: float = 0.0, high: float = math.inf, *, open_low: bool = False
) -> float:
    """Return a finite number from `low` (`open_low`: above it) to `high`.

    Raises:
        UsageError: It is none.
    """
    if is_number(value) and (value > low or (value == low and not open_low)) and value <= high:
        return float(value)
    wanted = f"{'above' if open_low else 'not below'} {low:g}"
    raise wrong(
        f"{name} = {value!r} must be a finite number {wanted}{f', up to {high:g}' if high < math.inf else ''}"
    )


def expect_fields(options: Any, asked: Iterable[str]) -> None:
    """Refuse keywords that are not fields of a record of options.

    Raises:
        UsageError: Naming them all, and what may be meant.
    """
    from dataclasses import fields

    known = [field.name for field in fields(options)]
    faults = []
    for name in asked:
        if name not in known:
            import difflib

            near = difflib.get_close_matches(name, known, 1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
            faults.append(Diagnostic("argument", f"there is no option {name!r}", hint=hint))
    if faults:
        raise UsageError(faults)


def undrawn(chunks: Iterator[_T], what: str) -> Iterator[_T]:
    """Return a stream, which can be drawn once.

    Raises:
        UsageError: It has been drawn to its end: a second use would look like an empty one.
    """
    if getattr(chunks, "gi_frame", chunks) is None:  # of a generator that has ended
        raise wrong(
            f"{what} was drawn already, and can be drawn once", hint="make it again, or keep what it gave"
        )
    return chunks


def untouched(chunks: Iterator[_T], what: str) -> Iterator[_T]:
    """Return a stream of which all is wanted.

    Raises:
        UsageError: Some of it has been drawn: the rest would look like all of it.
    """
    from inspect import GEN_CREATED, getgeneratorstate, isgenerator

    chunks = undrawn(chunks, what)
    if isgenerator(chunks) and getgeneratorstate(chunks) != GEN_CREATED:
        raise wrong(f"{what} was drawn in part already, and here all of it is wanted", hint="make it again")
    return chunks

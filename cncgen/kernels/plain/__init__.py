"""The module `cython` for kernels that run as plain Python: the names of Cython's pure-Python mode that they use.

Compiled kernels do not import it, so an installation needs no Cython. `cncgen.kernels` puts it in place where a kernel is
uncompiled.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from importlib import import_module
from types import ModuleType
from typing import Any


class _Type:
    """A C type: called it converts a value, indexed it is the type of an array."""

    def __init__(self, python: Any = None) -> None:
        self._python = python

    def __call__(self, *value: Any) -> Any:
        return cast(self._python, *value) if value else self._new()

    def __getitem__(self, index: Any) -> _Type:
        # double[14] is an array of C; double[::1] and const[double] are types of arguments.
        return _Array(index) if isinstance(index, int) else self

    def _new(self) -> Any:
        return None


class _Array(_Type):
    """An array of C of a fixed length."""

    def __init__(self, length: int) -> None:
        super().__init__()
        self._length = length

    def _new(self) -> list[Any]:
        return [None] * self._length


class _Struct:
    """A record of C, whose members are given in order, by name, or as another record of its type."""

    _members: dict[str, Any]

    def __init__(self, *values: Any, **named: Any) -> None:
        if len(values) == 1 and type(values[0]) is type(self):
            values = tuple(getattr(values[0], name) for name in self._members)
        for name in self._members:
            setattr(self, name, None)
        given = dict(zip(self._members, values, strict=False)) | named
        for name, value in given.items():
            if name not in self._members:
                raise ValueError(f"a struct with {', '.join(self._members)} has no {name}")
            setattr(self, name, value)


class _Unchanged:
    """A decorator with or without arguments, or the context of a with block, that changes nothing."""

    def __call__(self, *values: Any, **named: Any) -> Any:
        alone = len(values) == 1 and not named and (callable(values[0]) or isinstance(values[0], type))
        return values[0] if alone else self

    def __enter__(self) -> None:
        pass

    def __exit__(self, *error: object) -> None:
        pass


class _Cimports(ModuleType):
    """``cython.cimports.…``: the Python module of the same name."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.__path__ = []

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return import_module(name)


_UNSAID = object()


def struct(**members: Any) -> type[_Struct]:
    """Return the type of a record with such members."""
    return type("struct", (_Struct,), {"_members": members})


def cast(kind: Any, value: Any) -> Any:
    """Convert a value to a type; records and objects of their own class stay as they are."""
    if isinstance(kind, _Type):
        return kind(value)
    if isinstance(kind, type) and not (value is None or isinstance(value, kind)):
        return kind(value)
    return value


def declare(kind: Any = None, value: Any = _UNSAID, **_: Any) -> Any:
    """Return the value of a variable that is declared: the one given, else a new array or record, else None."""
    if value is not _UNSAID:
        return cast(kind, value)
    if isinstance(kind, _Type):
        return kind()
    return kind() if isinstance(kind, type) and issubclass(kind, _Struct) else None


def typedef(kind: Any) -> _Type:
    """Return another name of a type."""
    return _Type(kind)


def _fmax(x: float, y: float) -> float:
    """Return the larger number, the other one beside a NaN (C11, 7.12.12.2); Python's `math` lacks it."""
    return y if math.isnan(x) or y > x else x


def _fmin(x: float, y: float) -> float:
    """Return the smaller number, the other one beside a NaN (C11, 7.12.12.3)."""
    return y if math.isnan(x) or y < x else x


def _of_c(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function of `math` as C has it: a double, infinite or NaN (Annex F) where Python raises, and −0 rounded to −0."""

    def computed(*values: float) -> Any:
        try:
            value = function(*values)
        except OverflowError:
            # Only a power is negative there, of a negative number to an odd one.
            negative = len(values) == 2 and values[0] < 0.0 and math.fmod(values[1], 2.0) != 0.0
            return values[0] if math.isinf(values[0]) else -math.inf if negative else math.inf
        except ValueError:
            return math.nan
        return (
            math.copysign(value, values[0]) if function in (math.floor, math.ceil) and value == 0 else value
        )

    return computed


def math_of_c() -> ModuleType:
    """Return the functions of ``libc.math``."""
    functions: Any = ModuleType("cython.cimports.libc.math")
    known = {name: each for name, each in vars(math).items() if not name.startswith("_")}
    functions.__dict__.update(
        {name: _of_c(each) if callable(each) else each for name, each in known.items()},
        fmax=_fmax,
        fmin=_fmin,
    )
    return functions  # type: ignore[no-any-return]


_INTEGERS = ("char", "schar", "uchar", "short", "int", "uint", "longlong", "ulonglong", "Py_ssize_t")
_DECORATORS = ("cclass", "cfunc", "ccall", "inline", "final", "nogil", "exceptval", "locals", "freelist")


def install() -> None:
    """Put this module in the place of `cython`, with ``cython.cimports``."""
    module: Any = ModuleType("cython", __doc__)
    module.__path__ = []
    module.compiled = False
    for name in _INTEGERS:
        setattr(module, name, _Type(int))
    for name in _DECORATORS:
        setattr(module, name, _Unchanged())
    module.double, module.bint, module.void, module.p_double = _Type(float), _Type(bool), _Type(), _Type()
    module.const, module.doublecomplex = _Type(), _Type(complex)
    for function in (struct, cast, declare, typedef):
        setattr(module, function.__name__, function)
    sys.modules["cython"] = module
    for path in ("cimports", "cimports.libc", "cimports.cncgen", "cimports.cncgen.kernels"):
        sys.modules[f"cython.{path}"] = _Cimports(f"cython.{path}")
    sys.modules["cython.cimports.libc.math"] = math_of_c()
    sys.meta_path.append(_Finder())


class _Finder:
    """Finds ``cython.cimports.cncgen.kernels.NAME``, which is ``cncgen.kernels.NAME``."""

    def find_spec(self, name: str, path: object = None, target: object = None) -> Any:
        """Return the specification of such a module; None of others."""
        if not name.startswith("cython.cimports.cncgen.kernels."):
            return None
        from importlib.machinery import ModuleSpec

        return ModuleSpec(name, self)  # type: ignore[arg-type]

    def create_module(self, spec: Any) -> ModuleType:
        """Return the kernel that is meant."""
        return import_module(spec.name.removeprefix("cython.cimports."))

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: the kernel is loaded."""

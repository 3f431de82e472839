"""Dataclasses and enumerations without the start of `dataclasses` and `enum`: these take a fifth of the time of a small run.

`IntEnum` and `StrEnum` have members with names and values, each one object. `dataclass`, `field` and `replace` have the same meaning, and records have slots. Data for introspection (`fields`, `asdict`,
signatures) come from `dataclasses` itself, at the first request.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
    from dataclasses import field as field
    from dataclasses import replace as replace
    from enum import IntEnum as IntEnum
    from enum import StrEnum as StrEnum
else:
    from operator import attrgetter

    _NONE = object()
    _set = object.__setattr__
    #: Instances of a class that are made before a function of its own is compiled, which takes as long as 100 to 200 of them.
    _FEW = 150

    class field:
        """A field: its default, or a function that makes one for each instance; whether it is an argument, and is shown."""

        def __init__(self, *, default=_NONE, default_factory=None, init=True, repr=True):
            self.default, self.maker, self.init, self.repr = default, default_factory, init, repr

    class _Late:
        """An attribute of a record's class that `dataclasses` makes when it is looked up."""

        def __init__(self, name):
            self._name = name

        def __get__(self, instance, owner):
            return getattr(_twin(owner), self._name)

    _LATE = {name: _Late(name) for name in ("__dataclass_fields__", "__dataclass_params__", "__signature__")}

    def dataclass(*, slots, frozen=False, eq=True, repr=True):
        """Return a decorator that makes a record of a class; `slots` stands for the reader and is always True."""

        def made(cls):
            body = dict(cls.__dict__)
            fields = {}
            for name in _fields_of(cls):
                default = body.pop(name, _NONE)
                fields[name] = default if isinstance(default, field) else field(default=default)
            for name in ("__dict__", "__weakref__"):
                body.pop(name, None)
            body["__slots__"] = names = tuple(fields)
            body["__match_args__"] = tuple(name for name, each in fields.items() if each.init)
            body["__record__"] = fields, frozen
            body.update(_LATE)
            body.setdefault("__init__", _initialiser(fields))
            if repr:
                body.setdefault("__repr__", _repr)
            if eq:
                _compare(body, attrgetter(*names), hashed=frozen)
            if frozen:
                body["__setattr__"] = body["__delattr__"] = _refuse
                body.setdefault("__setstate__", _set_state)
            return type(cls)(cls.__name__, cls.__bases__, body)

        return made

    def _fields_of(cls):
        """Return the names of the fields of a class, whose annotations are texts."""
        return [name for name, kind in cls.__annotations__.items() if not kind.startswith("ClassVar")]

    def _initialiser(fields):
        """Return the function that initialises the first instances of a class, until one of its own is worth its compiling."""
        asked = dict.fromkeys(name for name, each in fields.items() if each.init)
        most, made = len(asked), 0

        def __init__(self, *values, **named):
            nonlocal made
            made += 1
            if made > _FEW:
                cls = next(cls for cls in type(self).__mro__ if "__record__" in cls.__dict__)
                cls.__init__ = _compiled_init(cls, *cls.__record__)
                cls.__init__(self, *values, **named)
                return
            given = dict(zip(asked, values))  # noqa: B905
            given.update(named)
            if (
                len(values) > most
                or len(given) < len(values) + len(named)
                or not named.keys() <= asked.keys()
            ):
                raise TypeError(f"{type(self).__qualname__}() takes {', '.join(asked)}, each once")
            for name, each in fields.items():
                value = given[name] if name in given else each.default if each.maker is None else each.maker()
                if value is _NONE:
                    raise TypeError(f"{type(self).__qualname__}() misses {name}")
                _set(self, name, value)
            if hasattr(self, "__post_init__"):
                self.__post_init__()

        return __init__

    def _compiled_init(cls, fields, frozen):
        """Return the function that initialises instances of a class."""
        known = {"_none": _NONE, "_set": _set}
        arguments, body = ["self"], []
        for name, each in fields.items():
            known["_default_" + name] = each.default if each.maker is None else each.maker
            value = name
            if each.init:
                late = "_none" if each.maker else "_default_" + name
                arguments.append(name if each.default is _NONE and not each.maker else f"{name}={late}")
            if each.maker:
                value = f"_default_{name}()" + (f" if {name} is _none else {name}" if each.init else "")
            body.append(f"_set(self, {name!r}, {value})" if frozen else f"self.{name} = {value}")
        if hasattr(cls, "__post_init__"):
            body.append("self.__post_init__()")
        exec(f"def __init__({', '.join(arguments)}):\n " + "\n ".join(body), known)
        known["__init__"].__qualname__ = f"{cls.__qualname__}.__init__"
        return known["__init__"]

    def _repr(self):
        shown = (f"{name}={getattr(self, name)!r}" for name, each in self.__record__[0].items() if each.repr)
        return f"{type(self).__qualname__}({', '.join(shown)})"

    def _compare(body, values, hashed):
        """Give a class equality, and a hash where its records are frozen."""

        def __eq__(self, other):
            return values(self) == values(other) if other.__class__ is self.__class__ else NotImplemented

        body.setdefault("__eq__", __eq__)
        body.setdefault("__hash__", (lambda self: hash(values(self))) if hashed else None)

    def replace(record, /, **changes):
        """Return a copy of a record with other values in some fields."""
        kept = {name: getattr(record, name) for name, each in record.__record__[0].items() if each.init}
        return type(record)(**kept | changes)

    def _refuse(self, name, *value):
        from dataclasses import FrozenInstanceError

        raise FrozenInstanceError(f"cannot assign to field {name!r}")

    def _set_state(self, state):
        """Take the values of a pickle or a copy."""
        for name, value in state[1].items():
            object.__setattr__(self, name, value)

    def _twin(owner):
        """Return the class as `dataclasses` makes it; it is kept."""
        cls = next(cls for cls in owner.__mro__ if "__record__" in cls.__dict__)
        twin = cls.__dict__.get("__record_twin__")
        if twin is None:
            import dataclasses
            import inspect

            fields, frozen = cls.__record__
            body = {"__module__": cls.__module__, "__doc__": cls.__doc__}
            body["__annotations__"] = {name: cls.__annotations__[name] for name in fields}
            for name, each in fields.items():
                how = {"init": each.init, "repr": each.repr}
                if each.maker is not None:
                    how["default_factory"] = each.maker
                elif each.default is not _NONE:
                    how["default"] = each.default
                body[name] = dataclasses.field(**how)
            twin = dataclasses.dataclass(frozen=frozen)(type(cls.__name__, (), body))
            twin.__signature__ = inspect.signature(twin)
            cls.__record_twin__ = twin
        return twin

    class _Enumeration(type):
        """The class of an enumeration, whose members are the values of its body that have a name without ``_``."""

        def __new__(cls, name, bases, body):
            values = {
                key: value for key, value in body.items() if key[0] != "_" and not hasattr(value, "__get__")
            }
            made = super().__new__(cls, name, bases, body)
            made._members = {}
            for key, value in values.items():
                member = made.__base__.__base__.__new__(made, value)
                member.name, member.value = key, value
                setattr(made, key, member)
                made._members[value] = member
            return made

        def __iter__(cls):
            return iter(cls._members.values())

        def __len__(cls):
            return len(cls._members)

        def __call__(cls, value):
            if value not in cls._members:
                raise ValueError(f"{value!r} is not a valid {cls.__qualname__}")
            return cls._members[value]

    def _by_value(self, *_):
        return type(self), (self.value,)

    def _itself(self, *_):
        return self

    _MEMBER = {
        "__repr__": lambda self: f"<{type(self).__qualname__}.{self.name}: {self.value!r}>",
        "__reduce_ex__": _by_value,
        "__copy__": _itself,
        "__deepcopy__": _itself,
    }
    IntEnum = type.__new__(_Enumeration, "IntEnum", (int,), {**_MEMBER, "__str__": int.__repr__})
    StrEnum = type.__new__(_Enumeration, "StrEnum", (str,), {**_MEMBER, "__str__": str.__str__})

"""Dataclasses without the start of `dataclasses`: that module, with all it imports, takes a fifth of the time of a small run.

`dataclass`, `field` and `replace` have the same meaning, and records have slots. Data for introspection (`fields`, `asdict`,
signatures) come from `dataclasses` itself, at the first request.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
    from dataclasses import field as field
    from dataclasses import replace as replace
else:
    from operator import attrgetter

    _NONE = object()
    #: Instances of a class that are made before a function of its own is compiled.
    _FEW = 8

    class field:
        """A field: its default, or a function that makes one for each instance; whether it is an argument, and is shown."""

        def __init__(self, *, default=_NONE, default_factory=None, init=True, repr=True):
            self.default, self.maker, self.init, self.repr = default, default_factory, init, repr

    class _Late:
        """An attribute of a record's class that `dataclasses` makes when it is looked up."""

        def __set_name__(self, owner, name):
            self._name = name

        def __get__(self, instance, owner):
            return getattr(_twin(owner), self._name)

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
            body["__dataclass_fields__"], body["__dataclass_params__"], body["__signature__"] = (
                _Late() for _ in range(3)
            )
            body["__made__"] = 0
            body.setdefault("__init__", _init)
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

    def _init(self, *values, **named):
        """Initialise one of the first instances of a class: most classes have few, and a function of their own takes time to compile."""
        cls = next(cls for cls in type(self).__mro__ if "__record__" in cls.__dict__)
        fields, frozen = cls.__record__
        cls.__made__ += 1
        if cls.__made__ > _FEW:
            cls.__init__ = _compiled_init(cls, fields, frozen)
            cls.__init__(self, *values, **named)
            return
        asked = [name for name, each in fields.items() if each.init]
        given = dict(zip(asked, values, strict=False))
        twice, unknown = given.keys() & named.keys(), named.keys() - asked
        if len(values) > len(asked) or twice or unknown:
            raise TypeError(f"{cls.__qualname__}() takes {', '.join(asked)}, each once")
        given.update(named)
        for name, each in fields.items():
            if name in given:
                value = given[name]
            elif each.maker is not None:
                value = each.maker()
            elif each.default is not _NONE:
                value = each.default
            else:
                raise TypeError(f"{cls.__qualname__}() misses {name}")
            object.__setattr__(self, name, value)
        if hasattr(cls, "__post_init__"):
            self.__post_init__()

    def _compiled_init(cls, fields, frozen):
        """Return the function that initialises instances of a class."""
        known = {"_none": _NONE, "_set": object.__setattr__}
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

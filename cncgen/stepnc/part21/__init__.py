"""ISO 10303-21: read and write exchange structures, whatever schema they follow.

`Exchange.load` splits a file into statements and parses those that are asked for; `write` puts instances back into
text, and reading its output gives the same instances.
"""

from cncgen.stepnc.part21.exchange import Exchange
from cncgen.stepnc.part21.values import (
    DERIVED,
    Binary,
    Constant,
    Enumeration,
    Instance,
    Record,
    Ref,
    Resource,
    Typed,
    Value,
    ValueRef,
)
from cncgen.stepnc.part21.writer import format_instance, format_value, write

__all__ = [
    "DERIVED",
    "Binary",
    "Constant",
    "Enumeration",
    "Exchange",
    "Instance",
    "Record",
    "Ref",
    "Resource",
    "Typed",
    "Value",
    "ValueRef",
    "format_instance",
    "format_value",
    "write",
]

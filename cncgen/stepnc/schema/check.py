"""All faults of a file's instances in one pass: syntax, attributes, kinds, dangling references, cycles.

One regular expression for each entity type tests whether an instance is correct. Only other instances are parsed and examined.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Severity
from cncgen.kernels import part21_graph
from cncgen.kernels import part21_scan as scan
from cncgen.stepnc.part21 import DERIVED, Enumeration, Exchange, Instance, Ref, Typed
from cncgen.stepnc.schema.iso14649 import LATER_ATTRIBUTES
from cncgen.stepnc.schema.tables import Attribute, Table

_BLANK = rb"[ \t\r\n]*"
_NUMBER = rb"[+-]?(?:[0-9]{1,300}\.?[0-9]{0,300}|\.[0-9]{1,300})(?:[Ee][+-]?[0-9]{1,2})?"
_STRING = rb"'(?:[^'\\\x80-\xff]|'')*+'"
_REF = rb"\#[0-9]+"
_ENUM = rb"\.[A-Za-z_][A-Za-z0-9_]*\."
_SCALAR = rb"(?:" + rb"|".join((_NUMBER, _STRING, _REF, _ENUM, rb"\$", rb"\*")) + rb")"
_LIST = (
    rb"\("
    + _BLANK
    + rb"(?:(?:"
    + _SCALAR
    + _BLANK
    + rb","
    + _BLANK
    + rb")*+"
    + _SCALAR
    + rb")?"
    + _BLANK
    + rb"\)"
)
_TYPED = rb"[A-Za-z_][A-Za-z0-9_]*" + _BLANK + rb"\(" + _BLANK + rb"%s" + _BLANK + rb"\)"
_KINDS = {
    "s": _STRING,
    "n": rb"(?:" + _NUMBER + rb"|" + _TYPED % _NUMBER + rb")",
    "e": _ENUM,
    "r": _REF,
    "l": _LIST,
    "*": rb"(?:" + _SCALAR + rb"|" + _TYPED % _SCALAR + rb"|" + _LIST + rb")",
}
_ITEM = rb"(?:" + _SCALAR + rb"|" + _LIST + rb"|" + _TYPED % _SCALAR + rb")" + _BLANK
_ITEMS = _BLANK + rb"(?:(?:" + _ITEM + rb"," + _BLANK + rb")*+" + _ITEM + rb")?"
_PART = rb"[A-Za-z_][A-Za-z0-9_]*" + _BLANK + rb"\(" + _ITEMS + rb"\)" + _BLANK
#: Any instance, simple or complex, without nested lists: its syntax is right.
_ANY = re.compile(rb"(?:" + _PART + rb"|\(" + _BLANK + rb"(?:" + _PART + rb")++\)" + _BLANK + rb")")
_KIND_NAMES = {"s": "a string", "n": "a number", "e": "an .ENUMERATION.", "r": "a reference", "l": "a list"}

#: Cycles that are reported of one file.
MAX_CYCLES = 10


def check(exchange: Exchange, table: Table) -> None:
    """Report every fault of the instances of a file against a schema's table, without executing anything."""
    _check_types(exchange, table)
    targets_ok = _check_references(exchange, table)
    if targets_ok:
        _check_cycles(exchange)


def _pattern(attributes: tuple[Attribute, ...]) -> re.Pattern[bytes]:
    """Return what the body of a correct instance matches."""
    each = [rb"(?:" + _KINDS[a.kind] + rb"|\$|\*)" for a in attributes if a.kind != "+"]
    inside = (_BLANK + rb"," + _BLANK).join(each)
    if attributes and attributes[-1].kind == "+":
        inside += rb"(?:" + _BLANK + rb"," + _BLANK + _KINDS["*"] + rb")*+"
    return re.compile(rb"[!A-Za-z0-9_]+" + _BLANK + rb"\(" + _BLANK + inside + _BLANK + rb"\)" + _BLANK)


def _check_types(exchange: Exchange, table: Table) -> None:
    rows = exchange.instance_rows
    point_rows, _, dimensions = exchange.points
    rows = np.setdiff1d(rows, point_rows[dimensions > 0], assume_unique=True)
    types = exchange.rows.types[rows]
    known = {scan.keyword_hash(name.encode()): name for name in table}
    unknown: dict[str, tuple[int, int]] = {}
    for code in np.unique(types).tolist():
        members = rows[types == code]
        name = known.get(code)
        if name is None or code == 0:
            exchange.check_syntax(_not_matching(exchange, members, _ANY))
            if code:
                _note_unknown(exchange, members, unknown)
        else:
            _check_entity(exchange, members, name, table[name])
    for name, (ident, count) in unknown.items():
        if "MACHINING_WORKPLAN" in table and not name.startswith("MACHINING_"):
            continue  # the AIM has 1,400 more, of products and their shape
        instances = f"{count} instances of {name} are" if count > 1 else f"an instance of {name} is"
        text = f"{instances} not used: the entity is not known"
        exchange.report(ident, "stepnc-unknown-entity", text, severity=Severity.NOTE)


def _note_unknown(
    exchange: Exchange, members: NDArray[np.int64], unknown: dict[str, tuple[int, int]]
) -> None:
    first = exchange.at_row(int(members[0]))
    if first is not None and len(unknown) < 50:
        unknown[first.keyword] = (first.id, len(members))


def _check_entity(
    exchange: Exchange, members: NDArray[np.int64], name: str, attributes: tuple[Attribute, ...]
) -> None:
    for row in _not_matching(exchange, members, _pattern(attributes)).tolist():
        instance = exchange.at_row(row)
        if instance is not None:
            _diagnose(exchange, instance, name, attributes)


def _not_matching(
    exchange: Exchange, members: NDArray[np.int64], pattern: re.Pattern[bytes]
) -> NDArray[np.int64]:
    """Return the rows whose body a pattern does not match."""
    bodies, ends = exchange.rows.bodies[members].tolist(), exchange.rows.ends[members].tolist()
    match, data = pattern.fullmatch, exchange.data
    good = [match(data, begin, end) is not None for begin, end in zip(bodies, ends, strict=True)]
    return members[~np.array(good, bool)]


def _diagnose(exchange: Exchange, instance: Instance, name: str, attributes: tuple[Attribute, ...]) -> None:
    """Report what is wrong with the attributes of an instance, if anything is."""
    given = instance.parameters
    if attributes and attributes[-1].kind == "+":
        attributes = attributes[:-1]
        given = given[: len(attributes)]
    missing = len(attributes) - len(given)
    if missing and missing != LATER_ATTRIBUTES.get(name, 0):
        parts = exchange.partial_entities(instance.id)
        whose = f"in its parts {', '.join(parts)} " if parts else ""
        if missing > 0:
            left = f"; missing: {', '.join(a.name for a in attributes[len(given) :])}"
            text = f"#{instance.id} {name} has {whose}{len(given)} attributes of {len(attributes)}"
            text += "" if parts else left
        else:
            text = (
                f"#{instance.id} {name} has {whose}{len(given)} attributes, {-missing} more than the entity"
            )
        exchange.report(instance.id, "stepnc-attributes", text)
        return
    for attribute, value in zip(attributes, given, strict=False):
        if not _fits(value, attribute.kind):
            wanted = _KIND_NAMES[attribute.kind]
            text = f"#{instance.id} {name}: {attribute.name} is {_shown(value)}, not {wanted}"
            exchange.report(instance.id, "stepnc-type", text)


def _shown(value: object) -> str:
    if isinstance(value, str) and not isinstance(value, Enumeration):
        return f"the string {value[:40]!r}"
    return f"{value!r}"[:60]


def _fits(value: object, kind: str) -> bool:
    if value is None or value is DERIVED or kind == "*":
        return True
    if kind == "r":
        return isinstance(value, Ref)
    if kind == "l":
        return isinstance(value, tuple) and not isinstance(value, Typed)
    if kind == "e":
        return isinstance(value, Enumeration)
    if isinstance(value, Typed):
        value = value.value
    if kind == "s":
        return isinstance(value, str) and not isinstance(value, Enumeration)
    return isinstance(value, int | float) and not isinstance(value, Ref)


def _check_references(exchange: Exchange, table: Table) -> bool:
    """Report references to what is not there; tell whether all are there."""
    targets, offsets = exchange.links
    rows = exchange.rows_of_ids(targets)
    external = {int(k) for k in exchange.references if isinstance(k, Ref)}
    dangling = np.flatnonzero(rows < 0)
    sources = np.searchsorted(offsets, dangling, side="right") - 1
    complete = True
    for target, source in zip(targets[dangling].tolist(), sources.tolist(), strict=True):
        if target in external or exchange.rows.ids[source] < 0:
            continue
        complete = False
        exchange.report_missing(source, target)
    if complete:
        _check_targets(exchange, table)
    return complete


def _check_targets(exchange: Exchange, table: Table) -> None:
    """Report references of attributes that must have one type and lead to another."""
    subtypes: dict[str, tuple[str, ...]] = {"CARTESIAN_POINT": ("VIA_ARC_POINT", "VIA_HELIX_POINT", "POINT")}
    for name, attributes in table.items():
        wanted = [(k, a) for k, a in enumerate(attributes) if a.target]
        members = exchange.rows_of_type(name)
        # All references of an instance in one go where every attribute before them is a scalar.
        for row in members.tolist() if wanted else ():
            _check_row_targets(exchange, row, name, wanted, subtypes)


def _check_row_targets(
    exchange: Exchange,
    row: int,
    name: str,
    wanted: list[tuple[int, Attribute]],
    subtypes: dict[str, tuple[str, ...]],
) -> None:
    links = exchange.links_of(row)
    if not len(links):
        return
    codes = exchange.rows.types[exchange.rows_of_ids(links)]
    targets = {a.target for _, a in wanted}
    good = {scan.keyword_hash(t.encode()) for t in targets}
    if len(links) == len(wanted) and len(targets) == 1 and all(c in good for c in codes.tolist()):
        return
    instance = exchange.at_row(row)
    if instance is None:
        return
    for k, attribute in wanted:
        value = instance.parameters[k] if k < len(instance.parameters) else None
        found = exchange.instance(value) if isinstance(value, Ref) else None
        if found is None or found.part(attribute.target) is not None:
            continue
        if found.keyword in (attribute.target, *subtypes.get(attribute.target, ())):
            continue
        text = (
            f"#{instance.id} {name}: {attribute.name} #{found.id} is {found.keyword}, not {attribute.target}"
        )
        exchange.report(instance.id, "stepnc-type", text)


def _check_cycles(exchange: Exchange) -> None:
    """Warn of instances that refer to themselves by way of others; executing one is an error."""
    targets, offsets = exchange.links
    rows = exchange.rows_of_ids(targets)
    cycles = part21_graph.cycles(offsets, np.maximum(rows, 0), MAX_CYCLES)
    for cycle in cycles:
        ids = [int(exchange.rows.ids[row]) for row in cycle]
        if min(ids) < 0:
            continue
        shown = " → ".join(f"#{i}" for i in ids[:8]) + (" → …" if len(ids) > 8 else "")
        text = f"#{ids[0]} refers to itself: {shown} → #{ids[0]}"
        exchange.report(ids[0], "part21-cycle", text, severity=Severity.WARNING)

"""The tables of entities: every entity is taken as it should be, and every attribute that is wrong is named."""

import io

import pytest

from cncgen.diagnostics import Severity
from cncgen.stepnc.part21 import Enumeration, Exchange, Instance, Record, Ref, write
from cncgen.stepnc.schema.check import check
from cncgen.stepnc.schema.iso14649 import LATER_ATTRIBUTES
from cncgen.stepnc.schema.short_names import SHORT_NAMES
from cncgen.stepnc.schema.tables import ap238_table, iso14649_table, positions

TABLES = {"iso14649": iso14649_table(), "ap238": ap238_table()}
GOOD = {"s": "text", "n": 1.5, "e": Enumeration("T"), "l": (1.0, Ref(1)), "r": Ref(1), "*": None, "+": None}
BAD = {"s": 1.0, "n": "text", "e": "text", "l": 1.0, "r": "text"}
#: What attributes that need a certain type refer to, with names of their own.
TARGETS = sorted(
    {a.target for t in TABLES.values() for attributes in t.values() for a in attributes if a.target}
)
IDS = {name: 10 + k for k, name in enumerate(TARGETS)}


#: Instances in one file: no more of a code are reported.
BATCH = 40


def faults_of(table, cases):
    """Return the codes of the errors of each case, (entity, values), many in a file."""
    out = []
    for begin in range(0, len(cases), BATCH):
        batch = cases[begin : begin + BATCH]
        found = _check(table, [Instance(1000 + k, (Record(n, tuple(v)),)) for k, (n, v) in enumerate(batch)])
        out += [found.get(1000 + k, []) for k in range(len(batch))]
    return out


def faults(table, name, values):
    """Return the codes of the errors of one instance."""
    return faults_of(table, [(name, values)])[0]


def _check(table, instances):
    base = [Instance(1, (Record("ANYTHING", ()),))]
    base += [Instance(i, (Record(n, tuple(None for _ in table.get(n, ()))),)) for n, i in IDS.items()]
    stream = io.StringIO()
    write(stream, [*base, *instances], ["X"])
    file = Exchange.load(stream.getvalue().encode(), "t", aliases=SHORT_NAMES)
    check(file, table)
    out = {}
    for d in file.reporter.diagnostics:
        if d.severity is Severity.ERROR:
            out.setdefault(int(d.message.split()[0].strip("#:")), []).append(d.code)
    return out


def values_of(attributes):
    return [Ref(IDS[a.target]) if a.target else GOOD[a.kind] for a in attributes]


@pytest.mark.parametrize("schema", sorted(TABLES))
def test_every_entity_is_taken_with_the_right_kinds(schema):
    table = TABLES[schema]
    cases = [(n, values_of(a)) for n, a in table.items()] + [(n, [None] * len(a)) for n, a in table.items()]
    for case, found in zip(cases, faults_of(table, cases), strict=True):
        assert found == [], case


@pytest.mark.parametrize("schema", sorted(TABLES))
def test_every_attribute_that_is_wrong_is_named(schema):
    table = TABLES[schema]
    cases = []
    for name, attributes in table.items():
        good = values_of(attributes)
        for k, attribute in enumerate(attributes):
            if attribute.kind in BAD:
                cases.append((name, [*good[:k], BAD[attribute.kind], *good[k + 1 :]]))
    assert len(cases) > 250
    for case, found in zip(cases, faults_of(table, cases), strict=True):
        assert found == ["stepnc-type"], case


@pytest.mark.parametrize("schema", sorted(TABLES))
def test_too_few_and_too_many_attributes(schema):
    table = TABLES[schema]
    open_ended = {n for n, a in table.items() if a and a[-1].kind == "+"}
    cases = [(n, [*values_of(a), None]) for n, a in table.items() if n not in open_ended]
    exempt = {*LATER_ATTRIBUTES, *open_ended}
    cases += [(n, values_of(a)[:-1]) for n, a in table.items() if a and n not in exempt]
    cases += [(n, values_of(table[n])[:-2]) for n in sorted(open_ended)]
    for case, found in zip(cases, faults_of(table, cases), strict=True):
        assert found == ["stepnc-attributes"], case


def test_attributes_of_the_2001_draft_may_be_missing():
    assert faults(TABLES["iso14649"], "CUTTING_COMPONENT", [80.0, None, None, None]) == []


def test_references_must_lead_to_the_right_type():
    placement = [None, Ref(IDS["DIRECTION"]), None, None]
    assert faults(TABLES["iso14649"], "AXIS2_PLACEMENT_3D", placement) == ["stepnc-type"]


def test_positions_follow_the_standard():
    """Places that the files of NIST and of the standard's annexes show."""
    assert positions("CUTTER_LOCATION_TRAJECTORY", True)["basiccurve"] == 6
    assert positions("DRILLING", True)["its_machining_strategy"] == 13
    assert positions("CLOSED_POCKET", True)["feature_boundary"] == 10
    assert positions("MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP", False)["sequence_position"] == 4
    assert positions("MACHINING_TOOL", False)["usage"] == 2


def test_short_names_are_those_of_known_entities():
    assert len(SHORT_NAMES) > 120
    unknown = {n for n in SHORT_NAMES.values() if n not in TABLES["ap238"]}
    assert len(unknown) < 20  # parts of complex instances (units), supertypes

"""The external mapping of ISO 10303-21 (conformance class 2): an entity with its supertypes is the entity."""

import re
from pathlib import Path

import numpy as np
import pytest

from cncgen.diagnostics import Diagnostics
from cncgen.stepnc.part21 import DERIVED, Enumeration, Exchange, Record, Ref
from cncgen.stepnc.reading import entities_by_line
from cncgen.stepnc.schema import ap238, iso14649
from cncgen.stepnc.schema.short_names import SHORT_NAMES
from cncgen.stepnc.schema.tables import ap238_table, iso14649_table, supertypes
from tests.stepnc.aim import Aim
from tests.stepnc.building import run
from tests.stepnc.external import OWN, external

PROGRAMS = sorted((Path(__file__).parents[2] / "programs" / "stepnc").glob("*.stp"))


def load(*lines, found=None):
    text = "ISO-10303-21;HEADER;ENDSEC;DATA;\n" + "\n".join(lines) + "\nENDSEC;END-ISO-10303-21;"
    return Exchange.load(text.encode(), "t.stp", found, SHORT_NAMES, supertypes())


def records(*lines):
    exchange = load(*lines)
    return [exchange.at_row(row).parts for row in exchange.instance_rows.tolist()]


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda p: p.stem)
def test_every_program_says_the_same_in_both_mappings(path):
    text = path.read_text()
    other = external(text)
    assert not re.search(r"^#\d+\s*=\s*[A-Z]", other, re.MULTILINE)
    (first, told), (second, told_again) = run(text), run(other)
    assert len(first) > 50
    np.testing.assert_array_equal(second.end, first.end)
    np.testing.assert_array_equal(second.feed, first.feed)
    assert [d[:2] for d in told_again] == [d[:2] for d in told]


def test_attributes_have_the_order_of_the_schema_not_of_the_text():
    """ISO 10303-21, 12.2.5: the partial entities are in alphabetical order."""
    assert records(
        "#1=(CARTESIAN_POINT((1.,2.,3.))GEOMETRIC_REPRESENTATION_ITEM()POINT()REPRESENTATION_ITEM('p'));",
        "#2=(ACTION_METHOD('ws','d','c','u')MACHINING_PROCESS_EXECUTABLE()MACHINING_WORKINGSTEP()PROCESS_OPERATION());",
        "#3 = ( MEASURE_REPRESENTATION_ITEM() /* ; */ MEASURE_WITH_UNIT(LENGTH_MEASURE(2.),#1) REPRESENTATION_ITEM('(') ) ;",
        "#4=(PRODUCT('a','b',$,(#1)));",
    ) == [
        (Record("CARTESIAN_POINT", ("p", (1.0, 2.0, 3.0))),),
        (Record("MACHINING_WORKINGSTEP", ("ws", "d", "c", "u")),),
        (Record("MEASURE_REPRESENTATION_ITEM", ("(", ("LENGTH_MEASURE", 2.0), Ref(1))),),
        (Record("PRODUCT", ("a", "b", None, (Ref(1),))),),
    ]


def test_several_entities_in_one_instance_stay_several():
    """Units and contexts are two entities in one instance in either mapping."""
    unit = "#1=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));"
    stranger = "#2=(NEW_THING(5)POINT()REPRESENTATION_ITEM(''));"
    double = "#3=(POINT()POINT()REPRESENTATION_ITEM(''));"
    ((*one,), (*two,), (*three,)) = records(unit, stranger, double)
    assert one == [
        Record("LENGTH_UNIT", ()),
        Record("NAMED_UNIT", (DERIVED,)),
        Record("SI_UNIT", (Enumeration("MILLI"), Enumeration("METRE"))),
    ]
    assert [len(two), len(three)] == [3, 3]


def test_references_and_types_are_those_of_the_simple_form():
    """A relationship's related method stands first in the text: SEQUENTIAL_METHOD is behind it in either mapping."""
    exchange = load(
        "#7=(ACTION_METHOD_RELATIONSHIP('','',#1,#2)MACHINING_PROCESS_BODY_RELATIONSHIP()"
        "MACHINING_PROCESS_SEQUENCE_RELATIONSHIP()SEQUENTIAL_METHOD(3.)SERIAL_ACTION_METHOD());",
        "#8=(CONIC(#5)CIRCLE(4.)CURVE()GEOMETRIC_REPRESENTATION_ITEM()REPRESENTATION_ITEM(''));",
        "#9=(BOUNDED_CURVE()B_SPLINE_CURVE(1,(#3,#4),.U.,.F.,.F.)B_SPLINE_CURVE_WITH_KNOTS((2,2),(0.,1.),.U.)CURVE()"
        "GEOMETRIC_REPRESENTATION_ITEM()REPRESENTATION_ITEM(''));",
        "#10=(FACE((#1))ADVANCED_FACE()FACE_SURFACE(#2,.T.)GEOMETRIC_REPRESENTATION_ITEM()REPRESENTATION_ITEM('')"
        "TOPOLOGICAL_REPRESENTATION_ITEM());",
        "#11=(MACHINING_TOOL()ACTION_RESOURCE('T','',(#6),#5));",
        "#12=(EDGE_CURVE(#4,.T.)EDGE(#2,#3)GEOMETRIC_REPRESENTATION_ITEM()REPRESENTATION_ITEM('')"
        "TOPOLOGICAL_REPRESENTATION_ITEM());",
        "#13=CIRCLE('',#5,4.);",
    )
    rows = [exchange.row_of(i) for i in range(7, 14)]
    assert [exchange.links_of(row).tolist() for row in rows] == [
        [1, 2], [5], [3, 4], [1, 2], [6, 5], [2, 3, 4], [5]
    ]  # fmt: skip
    assert exchange.rows_of_type("CIRCLE").tolist() == [rows[1], rows[6]]
    assert exchange.last_number(rows[0]) == 3.0
    assert exchange.last_number(rows[1]) == 4.0
    assert exchange.last_number(rows[2]) is None
    assert exchange.instance(8).keyword == exchange.instance(13).keyword


def test_short_names_stand_in_the_external_mapping_too():
    ((point,),) = records("#1=(CRTPNT((1.,2.,3.))GMRPIT()POINT()RPRITM('p'));")
    assert point == Record("CARTESIAN_POINT", ("p", (1.0, 2.0, 3.0)))


def test_a_missing_supertype_is_told_with_the_parts_that_there_are():
    aim = Aim()
    text = aim_text(aim)
    gap = re.sub(r"\(ACTION_METHOD\('op'.*?\)", "(", text, count=1)
    assert gap != text
    found = messages(gap)
    assert any("has in its parts" in m and "0 attributes of 4" in m for m in found), found


def test_the_name_of_an_item_may_be_left_out():
    ((point,),) = records("#1=(CARTESIAN_POINT((1.,2.,3.))POINT());")
    assert point == Record("CARTESIAN_POINT", (None, (1.0, 2.0, 3.0)))


def test_an_inherited_attribute_of_an_instance_of_several_entities_is_found_in_its_part():
    from cncgen.stepnc.entities import Entities

    exchange = load(
        "#1=(LENGTH_MEASURE_WITH_UNIT()MEASURE_REPRESENTATION_ITEM()MEASURE_WITH_UNIT(LENGTH_MEASURE(2.),#2)"
        "REPRESENTATION_ITEM('depth'));",
        "#2=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));",
    )
    entity = Entities(exchange, iso=False).get(1)
    assert len(entity.instance.parts) == 4
    assert (entity.text("name"), entity.number("value_component"), entity.ref("unit_component")) == (
        "depth",
        2,
        2,
    )
    assert Entities(exchange, iso=False).get(2).enum("prefix") == "MILLI"


def test_the_entity_of_a_line_is_the_one_of_the_simple_form():
    text = (
        "ISO-10303-21;HEADER;ENDSEC;DATA;\n#1=(CURVE()CONIC(#5)CIRCLE(4.)REPRESENTATION_ITEM(''));\nENDSEC;"
    )
    assert entities_by_line(text.encode()) == {2: "#1 CIRCLE"}


@pytest.mark.parametrize("schema", [ap238, iso14649])
def test_attributes_of_a_supertype_begin_those_of_its_subtypes(schema):
    """By EXPRESS; of several supertypes all attributes are there. INSTANCED_FEATURE and others have a name twice."""
    table = ap238_table() if schema is ap238 else iso14649_table()
    checked = 0
    for line in schema.SUBTYPES.split("\n"):
        supertype, *names = line.split() or [""]
        for name in names:
            if supertype in table and name in table and name != supertype:
                above, own = ([a.name for a in table[n] if a.kind != "+"] for n in (supertype, name))
                assert set(above) <= set(own), (supertype, name)
                checked += 1
    assert checked > 60


def test_each_entity_has_the_attributes_that_its_supertypes_have_by_count():
    """The sums of the counts of EXPRESS (`external.OWN`) do not exceed what the tables give an entity."""
    for name, above in supertypes().items():
        assert name not in above
    assert OWN["ACTION_METHOD"] == len(ap238_table()["MACHINING_WORKPLAN"])
    assert OWN["ACTION_METHOD_RELATIONSHIP"] + OWN["SEQUENTIAL_METHOD"] == len(
        ap238_table()["MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP"]
    )


def aim_text(aim):
    step, operation = aim.step()
    aim.path(operation, aim.polyline((0, 0, 0), (10, 0, 0)), aim.technology())
    aim.file.project(aim.plan(step), "p")
    head = "ISO-10303-21;\n/* (START, X0 Y0 Z0) */\nHEADER;\nFILE_SCHEMA(('X'));\nENDSEC;\nDATA;\n"
    return external(head + aim.stream.getvalue() + "ENDSEC;\nEND-ISO-10303-21;\n")


def messages(text):
    import io

    from cncgen.stepnc import read
    from tests.stepnc.building import WHOLE

    found = read(io.BytesIO(text.encode()), "t.stp", WHOLE)
    list(found.chunks())
    assert isinstance(found.diagnostics, Diagnostics)
    return [d.message for d in found.diagnostics]

"""Files in the external mapping (ISO 10303-21, conformance class 2): every instance with its supertypes, in alphabetical order."""

from cncgen.stepnc.part21 import Exchange, Record
from cncgen.stepnc.part21.writer import format_record
from cncgen.stepnc.schema import ap238, iso14649

#: Attributes of supertypes' own, where they have any (EXPRESS of ISO 10303-41, -42, -43, -49 and -238).
OWN = {
    "ACTION": 3,
    "ACTION_METHOD": 4,
    "ACTION_METHOD_WITH_ASSOCIATED_DOCUMENTS": 1,
    "ACTION_METHOD_RELATIONSHIP": 4,
    "SEQUENTIAL_METHOD": 1,
    "ACTION_PROPERTY": 3,
    "ACTION_RESOURCE": 4,
    "APPLICATION_CONTEXT_ELEMENT": 2,
    "CHARACTERIZED_OBJECT": 2,
    "SHAPE_ASPECT": 4,
    "SHAPE_ASPECT_RELATIONSHIP": 4,
    "PRODUCT": 4,
    "PRODUCT_DEFINITION_RELATIONSHIP": 5,
    "PROPERTY_DEFINITION": 3,
    "PROPERTY_DEFINITION_REPRESENTATION": 2,
    "REPRESENTATION": 3,
    "REPRESENTATION_CONTEXT": 2,
    "REPRESENTATION_RELATIONSHIP": 4,
    "REPRESENTATION_ITEM": 1,
    "MEASURE_WITH_UNIT": 2,
    "NAMED_UNIT": 1,
    "CARTESIAN_POINT": 1,
    "PLACEMENT": 1,
    "CONIC": 1,
    "B_SPLINE_CURVE": 5,
    "ELEMENTARY_SURFACE": 1,
    "EXECUTABLE": 1,
    "WORKINGSTEP": 1,
    "OPERATION": 2,
    "MACHINING_OPERATION": 6,
    "MILLING_MACHINING_OPERATION": 1,
    "MILLING_TYPE_OPERATION": 2,
    "TWO5D_MILLING_OPERATION": 1,
    "BOTTOM_AND_SIDE_MILLING": 4,
    "PLANE_MILLING": 2,
    "SIDE_MILLING": 3,
    "DRILLING_TYPE_OPERATION": 5,
    "BORING_OPERATION": 3,
    "TECHNOLOGY": 2,
    "TOOLPATH": 5,
    "TRAJECTORY": 1,
    "APPROACH_LIFT_PATH": 2,
    "TWO5D_MILLING_STRATEGY": 2,
    "APPROACH_RETRACT_STRATEGY": 1,
    "MANUFACTURING_FEATURE": 3,
    "TWO5D_MANUFACTURING_FEATURE": 1,
    "MACHINING_FEATURE": 1,
    "COMPOUND_FEATURE": 1,
    "POCKET": 5,
    "PROFILE_FEATURE": 1,
    "REPLICATE_FEATURE": 1,
    "PROFILE": 1,
    "TRAVEL_PATH": 1,
    "PROPERTY_PARAMETER": 1,
    "MACHINING_TOOL": 1,
    "CUTTING_TOOL": 3,
    "MILLING_TOOL_BODY": 5,
}
#: The same names with other attributes in the AIM.
AIM = {"MACHINING_OPERATION": 0, "MILLING_TYPE_OPERATION": 0, "BORING_OPERATION": 0, "POCKET": 0, "COMPOUND_FEATURE": 0,
       "REPLICATE_FEATURE": 0, "DRILLING_TYPE_OPERATION": 0, "MACHINING_TOOL": 0}  # fmt: skip


def external(text):
    """Return a file of ISO 14649 or AP238 with every instance in the external mapping."""
    exchange = Exchange.load(text.encode())
    aim = any(True for _ in exchange.instances("MACHINING_WORKPLAN"))
    own, tree = (OWN | AIM, _tree(iso14649) | _tree(ap238)) if aim else (OWN, _tree(iso14649))
    lines = []
    for row in exchange.instance_rows.tolist():
        instance = exchange.at_row(row)
        parts = instance.parts if len(instance.parts) > 1 else _split(*instance.parts[0], own, tree)
        lines.append(f"#{instance.id}=({''.join(map(format_record, parts))});\n")
    begin = text.index("DATA;") + 6
    return text[:begin] + "".join(lines) + text[text.index("ENDSEC;", begin) :]


def _tree(schema):
    found = {}
    for line in schema.SUBTYPES.split("\n"):
        supertype, *names = line.split() or [""]
        for name in names:
            found.setdefault(name, []).append(supertype)
    return found


def _above(name, tree):
    """Return the supertypes of an entity in the order of their attributes, each once."""
    return list(dict.fromkeys(n for s in tree.get(name, ()) for n in (*_above(s, tree), s)))


def _split(name, values, own, tree):
    """Return a simple instance as partial entities, the attributes told apart by how many each supertype has."""
    parts, at = [], 0
    for supertype in _above(name, tree):
        parts.append(Record(supertype, values[at : at + own.get(supertype, 0)]))
        at += own.get(supertype, 0)
    assert at <= len(values), name
    return sorted([*parts, Record(name, values[at:])], key=lambda part: part.keyword)

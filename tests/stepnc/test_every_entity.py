"""Every entity of ISO 14649's tables where it belongs: it is executed, or a diagnostic names it. Nothing is passed over."""

import io

import pytest

from cncgen.diagnostics import Severity
from cncgen.stepnc import read
from cncgen.stepnc.schema.tables import iso14649_table
from cncgen.toolpath.record import Kind
from tests.stepnc.building import WHOLE
from tests.stepnc.featured import Features

TABLE = iso14649_table()
NAMES = {k: [a.name for a in attributes] for k, attributes in TABLE.items()}
#: What does nothing alone, and need not: blocks without elements, connectors without a path after them.
EMPTY = ("NON_SEQUENTIAL", "PARALLEL", "SELECTIVE", "WORKPLAN", "CONNECT_DIRECT", "CONNECT_SECPLANE")


def those(*needed, without=()):
    """Return the entities that have all of some attributes and none of others."""
    return [k for k, n in NAMES.items() if set(needed) <= set(n) and not set(without) & set(n)]


def like(*endings):
    return [k for k in TABLE if k.endswith(endings)]


OPERATIONS = those("its_toolpath", "its_technology", "start_point")
FEATURES = those("its_id", "its_operations")
TOOLPATHS = those("its_priority", "its_type")
FUNCTIONS = [
    k for k in those("its_id", without=("its_operations", "its_technology"))
    if NAMES[k][0] == "its_id" and not k.endswith(("TOOL", "SETUP", "PROBE", "PROJECT", "CHANNEL", "WORKPIECE"))
]  # fmt: skip
PROFILES = [k for k in like("_PROFILE") if "its_id" not in NAMES[k]] + ["PROFILE"]
PATHS = [k for k in like("_PATH") if NAMES[k][:1] == ["placement"]]
BOTTOMS = like("_BOTTOM", "_BOTTOM_CONDITION")
ENDS = like("_SLOT_END_TYPE")
STRATEGIES = those("overlap") + those("pathmode") + ["DRILLING_TYPE_STRATEGY"]
APPROACHES = [*those("tool_orientation"), "PLUNGE_STRATEGY", "APPROACH_RETRACT_STRATEGY"]
BODIES = those("dimension", "hand_of_cut")
DIRECTIONS = [*like("_TOOL", "_TILT_YAW", "_AXES")]
CURVES = [
    *like("_CURVE", "PCURVE"),
    "CURVE",
    "POLYLINE",
    "LINE",
    "CIRCLE",
    "ELLIPSE",
    "HELIX",
    "HYPERBOLA",
    "PARABOLA",
]
CONDITIONS = [*like("_EXPRESSION"), *(k for k in TABLE if k.startswith("COMPARISON_"))]
DIRECTIONS = [k for k in DIRECTIONS if k.startswith(("THREE", "TWO", "FIVE", "TOOL_DIRECTION"))]


class Minimal(Features):
    """A part whose entities have nothing but what is given."""

    def bare(self, keyword, **given):
        """Add an entity with the attributes given, `$` for the others."""
        return self.add(keyword, *[given.get(name) for name in NAMES[keyword]])

    def sized(self, keyword, **given):
        """Add an entity with lengths of 5 mm and no other attributes than those given."""
        sizes = {a.name: self.size(5) for a in TABLE[keyword] if a.target == "TOLERANCED_LENGTH_MEASURE"}
        return self.bare(keyword, **(sizes | given))

    def cut(self, feature, keyword="BOTTOM_AND_SIDE_FINISH_MILLING", **given):
        """Make the program that machines a feature."""
        own = {"its_id": "op", "its_tool": self.tool("T", 4.0), "its_technology": self.technology()}
        return self.mill(feature, self.bare(keyword, **(own | given)))

    def follow(self, **given):
        """Make the program of a toolpath."""
        line = self.polyline((0, 0, 0), (5, 0, 0))
        path = self.bare("CUTTER_LOCATION_TRAJECTORY", **({"basiccurve": line} | given))
        self.project(self.plan(self.step(self.freeform(path))))
        return self


def element(part, item):
    part.project(part.plan(item))
    return part


def pocket_of(part, **given):
    head = dict(zip(NAMES["CLOSED_POCKET"], part.head(), strict=False))
    values = {"its_boss": (), "bottom_condition": part.add("PLANAR_POCKET_BOTTOM_CONDITION")}
    return part.bare(
        "CLOSED_POCKET", **(head | values | {"feature_boundary": part.rectangle(30, 20)} | given)
    )


def hole_of(part, **given):
    head = dict(zip(NAMES["ROUND_HOLE"], part.head(), strict=False))
    return part.bare("ROUND_HOLE", **(head | {"diameter": part.size(20)} | given))


def slot_of(part, **given):
    course = part.add("LINEAR_PATH", None, part.size(40), part.direction(1, 0, 0))
    section = part.add("SQUARE_U_PROFILE", None, part.size(4), None, None, None, None)
    head = dict(zip(NAMES["SLOT"], part.head(), strict=False))
    return part.bare("SLOT", **(head | {"course_of_travel": course, "swept_shape": section} | given))


def feature(part, keyword):
    head = dict(zip(NAMES["ROUND_HOLE"], part.head(), strict=False))
    return part.sized(keyword, **{k: v for k, v in head.items() if k in NAMES[keyword]})


def body(part, keyword):
    size = part.add("MILLING_TOOL_DIMENSION", 4.0, None, None, None, None, None, None)
    tool = part.add("MILLING_CUTTING_TOOL", "T", part.bare(keyword, dimension=size), (), None, None, None)
    return part.cut(pocket_of(part), its_tool=tool)


PLACES = {
    "element": (FUNCTIONS, lambda p, k: element(p, p.bare(k))),
    "operation": (OPERATIONS, lambda p, k: p.cut(hole_of(p), k)),
    "feature": (FEATURES, lambda p, k: p.cut(feature(p, k))),
    "toolpath": (TOOLPATHS, lambda p, k: element(p, p.step(p.freeform(p.bare(k))))),
    "profile": (PROFILES, lambda p, k: p.cut(pocket_of(p, feature_boundary=p.sized(k)))),
    "section": (PROFILES, lambda p, k: p.cut(slot_of(p, swept_shape=p.sized(k)))),
    "path": (PATHS, lambda p, k: p.cut(slot_of(p, course_of_travel=p.sized(k)))),
    "bottom": (BOTTOMS, lambda p, k: p.cut(hole_of(p, bottom_condition=p.sized(k)))),
    "end": (ENDS, lambda p, k: p.cut(slot_of(p, end_conditions=(p.sized(k), p.sized(k))))),
    "strategy": (STRATEGIES, lambda p, k: p.cut(pocket_of(p), its_machining_strategy=p.bare(k))),
    "approach": (APPROACHES, lambda p, k: p.cut(pocket_of(p), approach=p.bare(k))),
    "body": (BODIES, body),
    "direction": (DIRECTIONS, lambda p, k: element(p, p.step(p.freeform(p.trajectory(p.polyline((0, 0, 0), (5, 0, 0))), direction=p.bare(k))))),
    "curve": (CURVES, lambda p, k: p.follow(basiccurve=p.bare(k))),
    "condition": (CONDITIONS, lambda p, k: element(p, p.add("IF_STATEMENT", "", p.bare(k), None, None))),
}  # fmt: skip


@pytest.mark.parametrize(
    ("place", "keyword"), [(place, k) for place, (keys, _) in PLACES.items() for k in dict.fromkeys(keys)]
)
def test_every_entity_is_executed_or_named(place, keyword):
    part = Minimal()
    PLACES[place][1](part, keyword)
    program = read(io.BytesIO(part.text().encode()), "t.stp", WHOLE)
    (path,) = program.chunks()
    done = (path.kind != Kind.EVENT).any() or (place == "element" and len(path.events) > 1)
    refused = [d for d in program.diagnostics if d.severity == Severity.ERROR]
    assert done or refused or keyword in EMPTY
    # What is not known here is named; the others say what they miss.
    for fault in (d for d in refused if d.code == "stepnc-unsupported"):
        kind = keyword.lower().replace("_", " ")
        words = (keyword, kind.split()[0], "bottom", "floor")
        assert any(w in fault.message for w in words) or fault.span.line == line_of(part, keyword)


def line_of(part, keyword):
    """Return the line of the last entity of a kind: the one that is looked at."""
    lines = part.text().splitlines()
    return max((k for k, line in enumerate(lines, 1) if f"={keyword}(" in line), default=0)


def test_the_places_hold_the_entities_that_an_executor_meets():
    """A table that grows by an operation, feature, toolpath … grows this test too."""
    held = {k for keys, _ in PLACES.values() for k in keys}
    for kind in (OPERATIONS, FEATURES, TOOLPATHS, PROFILES, BOTTOMS, STRATEGIES, BODIES, CURVES):
        assert len(kind) >= 8
    assert {
        "THREAD_DRILLING",
        "WOODRUFF_SLOT_END_TYPE",
        "WORKPIECE_PROBING",
        "TEE_PROFILE",
        "HYPERBOLA",
    } <= held

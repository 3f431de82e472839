"""A small reader of AP238 files with explicit toolpaths, written for tests from ISO 10303-21 and the mapping tables of AP238.

It shares no line with `cncgen`: a tokeniser, entities as lists of parameters, and a walk from the project down to curves.
"""

import math
import re
from dataclasses import dataclass, field

TOKEN = re.compile(
    r"/\*.*?\*/|\s+|(?P<text>'(?:[^']|'')*')|(?P<ref>#\d+)|(?P<enum>\.[A-Z0-9_]+\.)"
    r"|(?P<number>[+-]?\d+(?:\.\d*)?(?:E[+-]?\d+)?)|(?P<word>[A-Z_][A-Z0-9_]*)|(?P<sign>[()=;,$*])",
    re.S | re.I,
)


@dataclass
class Motion:
    kind: str
    points: list
    rapid: bool
    feed: float | None
    spindle: float | None
    tool: str
    step: str
    pitch: float | None = None
    curve: tuple = ()


@dataclass
class File:
    motions: list = field(default_factory=list)
    tools: dict = field(default_factory=dict)
    stock: tuple | None = None


def tokens(text):
    at = text.index("DATA;") + 5
    while at < len(text):
        found = TOKEN.match(text, at)
        assert found, text[at : at + 40]
        at = found.end()
        if found.lastgroup:
            if found.group().upper() == "ENDSEC":
                return
            yield found.lastgroup, found.group()


def values(stream):
    """Return the parameters up to a closing bracket."""
    out = []
    for kind, token in stream:
        if token == ")":
            return out
        if token == "(":
            inner = values(stream)
            typed = out and isinstance(out[-1], str) and out[-1].startswith("@")
            out.append(inner[0] if typed and out.pop() else inner)
        elif kind == "ref":
            out.append(("#", int(token[1:])))
        elif kind == "number":
            out.append(float(token))
        elif kind == "text":
            out.append(token[1:-1].replace("''", "'"))
        elif kind == "word":
            out.append("@" + token)
        elif kind == "enum":
            out.append(token)
        elif token in "$*":
            out.append(None)
    raise AssertionError("a bracket is not closed")


class Data:
    """Instances by number: a dict of keyword to parameters."""

    def __init__(self, text):
        self.parts, stream = {}, tokens(text)
        for kind, token in stream:
            assert kind == "ref", token
            ident, parts = int(token[1:]), {}
            assert next(stream)[1] == "="
            kind, word = next(stream)
            if word == "(":
                for _, name in stream:
                    if name == ")":
                        break
                    assert next(stream)[1] == "("
                    parts[name] = values(stream)
            else:
                assert next(stream)[1] == "("
                parts[word] = values(stream)
            assert next(stream)[1] == ";"
            self.parts[ident] = parts
        self.users = {}
        for ident, parts in self.parts.items():
            for word, given in parts.items():
                for k, value in enumerate(given):
                    for v in value if isinstance(value, list) else [value]:
                        if isinstance(v, tuple):
                            self.users.setdefault((word, k, v[1]), []).append(ident)

    def get(self, ref, word=None):
        parts = self.parts[ref[1]]
        return parts[word] if word else next(iter(parts.values()))

    def related(self, word, ident):
        found = [self.parts[u][word] for u in self.users.get((word, 2, ident), [])]
        return [f[3][1] for f in sorted(found, key=lambda f: f[4] if len(f) > 4 else 0.0)]

    def properties(self, ident, owner="ACTION"):
        out = {}
        for prop in self.users.get((f"{owner}_PROPERTY", 2, ident), []):
            name = self.parts[prop][f"{owner}_PROPERTY"][0]
            for link in self.users.get((f"{owner}_PROPERTY_REPRESENTATION", 2, prop), []):
                representation = self.parts[link][f"{owner}_PROPERTY_REPRESENTATION"][3]
                out.setdefault(name, []).extend(self.get(representation)[1])
        return out

    def unit(self, ref):
        """Return a unit as a factor to mm, s, rad and turns."""
        parts = self.parts[ref[1]]
        if "SI_UNIT" in parts:
            prefix, name = parts["SI_UNIT"]
            return {".METRE.": 1000.0}.get(name, 1.0) * {".MILLI.": 1e-3}.get(prefix, 1.0)
        if "CONVERSION_BASED_UNIT" in parts:
            value, base = self.get(parts["CONVERSION_BASED_UNIT"][1])
            return value * self.unit(base)
        if "DERIVED_UNIT" in parts:
            elements = [self.get(e) for e in parts["DERIVED_UNIT"][0]]
            return math.prod(self.unit(u) ** exponent for u, exponent in elements)
        return 1.0

    def measure(self, ref):
        _, value, unit = self.get(ref)
        return value * self.unit(unit)


class Walk:
    def __init__(self, text):
        self.data, self.file = Data(text), File()
        context = next(p for p in self.data.parts.values() if "GLOBAL_UNIT_ASSIGNED_CONTEXT" in p)
        self.mm = self.data.unit(context["GLOBAL_UNIT_ASSIGNED_CONTEXT"][0][0])
        self.tool_of = {}
        for ident, parts in self.data.parts.items():
            if "MACHINING_TOOL" in parts:
                self.tool(ident, *parts["MACHINING_TOOL"][:3])
        for parts in self.data.parts.values():
            if (
                "PRODUCT_DEFINITION_PROCESS" in parts
                and parts["PRODUCT_DEFINITION_PROCESS"][0] == "machining"
            ):
                self.plan(parts["PRODUCT_DEFINITION_PROCESS"][2][1])
        for parts in self.data.parts.values():
            for word in ("BLOCK_SHAPE_REPRESENTATION", "CYLINDRICAL_SHAPE_REPRESENTATION"):
                if word in parts:
                    self.stock(*(self.data.get(i) for i in parts[word][1]))

    def tool(self, ident, name, form, users):
        sizes = {}
        for item in self.data.properties(ident, "RESOURCE").get("tool body", []):
            given = self.data.get(item)
            sizes[given[0]] = given[1] if len(given) == 2 else self.data.measure(item)
        self.file.tools[name] = {"form": form, **sizes}
        self.tool_of |= {ref[1]: name for ref in users}

    def plan(self, ident):
        for child in self.data.related("MACHINING_PROCESS_SEQUENCE_RELATIONSHIP", ident):
            name = next(iter(self.data.parts[child].values()))[0]
            for operation in self.data.related("MACHINING_OPERATION_RELATIONSHIP", child):
                for path in self.data.related("MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP", operation):
                    self.path(path, operation, name)

    def path(self, ident, operation, step):
        given = self.data.properties(ident)
        if "basic curve" not in given:
            return
        rapid = any(self.data.get(i)[1] == "rapid" for i in given.get("speed profile", []))
        feed = spindle = pitch = None
        for technology in self.data.related("MACHINING_TECHNOLOGY_RELATIONSHIP", ident):
            known = self.data.properties(technology)
            spindle = next((self.data.measure(i) for i in known.get("spindle", [])), None)
            feed = next((self.data.measure(i) for i in known.get("feedrate", [])), None)
            if "synchronize spindle with feed" in known:
                pitch, feed = feed, None
        tool = self.tool_of.get(operation, "")
        kind, points, curve = self.curve(given["basic curve"][0])
        stretches = [points[k : k + 2] for k in range(len(points) - 1)] if kind == "line" else [points]
        for stretch in stretches:
            self.file.motions.append(Motion(kind, stretch, rapid, feed, spindle, tool, step, pitch, curve))

    def point(self, ref):
        return [v * self.mm for v in self.data.get(ref)[1]]

    def curve(self, ref):
        parts = self.data.parts[ref[1]]
        if "POLYLINE" in parts:
            return "line", [self.point(p) for p in parts["POLYLINE"][1]], ()
        if "TRIMMED_CURVE" in parts:
            _, basis, first, last, *_ = parts["TRIMMED_CURVE"]
            place, radius = self.data.get(basis)[1:3]
            centre, axis = self.data.get(place)[1:3]
            about = (self.point(centre), self.data.get(axis)[1], radius * self.mm)
            return "arc", [self.point(first[0]), self.point(last[0])], about
        spline = parts.get("B_SPLINE_CURVE") or parts["B_SPLINE_CURVE_WITH_KNOTS"][1:]
        return "spline", [self.point(p) for p in spline[1]], (int(spline[0]),)

    def stock(self, *items):
        *sizes, place = items
        size = [value * self.data.unit(unit) for _, value, unit in sizes]
        kind = "block" if len(size) == 3 else "cylinder"
        self.file.stock = (kind, self.point(place[1]), size)


def read_file(text):
    """Return the motions, tools and raw piece of an AP238 file."""
    return Walk(text).file

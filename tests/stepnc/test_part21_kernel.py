"""The scanning kernel against regular expressions, and compiled against uncompiled."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cncgen.kernels import part21_graph, part21_scan
from cncgen.stepnc.part21.parsing import grammar_body
from tests.kernels.plain import uncompiled

ROOT = Path(__file__).parents[2]
PROGRAMS = sorted((ROOT / "programs" / "stepnc").glob("*.stp"))


def scan_all(kernel, data: bytes):
    buffer = np.frombuffer(data, np.uint8)
    room = data.count(b";") + data.count(b"#") + 2
    columns = [np.zeros(room, np.int64) for _ in range(5)] + [np.zeros(room, np.int32)]
    n, end = kernel.split(buffer, 0, *columns)
    ids, starts, bodies, ends, types, flags = (c[:n].copy() for c in columns)
    targets, offsets = np.zeros(data.count(b"#") + 1, np.int64), np.zeros(n + 1, np.int64)
    total = kernel.references(buffer, bodies, ends, targets, offsets)
    xyz, dimensions = np.zeros((n, 3)), np.zeros(n, np.int8)
    kernel.points(buffer, bodies, ends, xyz, dimensions, 10.0 ** np.arange(23))
    return ids, starts, bodies, ends, types, flags, targets[:total], offsets, xyz, dimensions, end


def partials(kernel, data: bytes):
    _, _, bodies, ends, *_ = scan_all(kernel, data)
    columns = [np.zeros(len(data) // 3 + len(bodies) + 1, np.int64) for _ in range(4)]
    count = kernel.partials(np.frombuffer(data, np.uint8), bodies, ends, *columns)
    return [column[:count] for column in columns]


fragments = st.sampled_from(
    [
        "#1",
        "#22=",
        " = ",
        "A(",
        "CARTESIAN_POINT('',(",
        "1.5,",
        "-2.E3",
        ")",
        "))",
        ";",
        "'",
        "/*",
        "*/",
        "\n",
        "<",
        ">",
    ]
)


@settings(max_examples=300, deadline=None)
@given(st.lists(fragments | st.text(max_size=3), max_size=30).map("".join))
def test_compiled_and_uncompiled_agree_on_anything(text):
    data = text.encode()
    plain = uncompiled("part21_scan")
    for look in (scan_all, partials):
        for a, b in zip(look(part21_scan, data), look(plain, data), strict=True):
            np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda p: p.stem)
def test_statements_as_regular_expressions_find_them(path):
    """Comments blanked out (same length), the instances are what `#id = … ;` outside strings matches."""
    data = path.read_bytes()
    plain = re.sub(rb"/\*.*?\*/", lambda m: re.sub(rb"[^\n]", b" ", m[0]), data, flags=re.DOTALL)
    found = [
        (int(m[1]), m.start(), m.start(2), m.end(2))
        for m in re.finditer(rb"#(\d+)\s*=\s*((?:[^;']|'[^']*')*);", plain)
    ]
    ids, starts, bodies, ends, _, flags, targets, offsets, xyz, dimensions, _ = scan_all(part21_scan, data)
    mine = [tuple(r) for r in zip(ids.tolist(), starts.tolist(), bodies.tolist(), ends.tolist(), strict=True)]
    assert [r for r in mine if r[0] >= 0] == found
    for k, row in enumerate(mine):
        body = re.sub(rb"'[^']*'", b"", plain[row[2] : row[3]])
        assert targets[offsets[k] : offsets[k + 1]].tolist() == [int(t) for t in re.findall(rb"#(\d+)", body)]
        point = re.fullmatch(rb"CARTESIAN_POINT\s*\('[^']*',\s*\(([^()]*)\)\s*\)\s*", plain[row[2] : row[3]])
        if point and not flags[k] & part21_scan.HAS_COMMENT:
            numbers = [float(v) for v in point[1].split(b",")]
            assert xyz[k, : dimensions[k]].tolist() == numbers


@settings(max_examples=300, deadline=None)
@given(
    st.lists(st.floats(allow_nan=False, allow_infinity=False, width=64), min_size=1, max_size=3),
    st.sampled_from(["{!r}", "{:.6f}", "{:.3E}", "{:+.4f}"]),
)
def test_points_read_exactly_or_not_at_all(values, form):
    text = ",".join(form.format(v) for v in values)
    *_, xyz, dimensions, _ = scan_all(part21_scan, f"#1=P('x',({text}));".encode())
    if dimensions[0] > 0:
        assert xyz[0, : dimensions[0]].tolist() == [float(t) for t in text.split(",")]


def test_hash_of_the_kernel_is_the_hash_in_python():
    *_, types, _, _, _, _, _, _ = scan_all(part21_scan, b"#1=Cartesian_Point('',(0.,0.,0.));")
    assert types[0] == part21_scan.keyword_hash(b"CARTESIAN_POINT")


@settings(max_examples=200, deadline=None)
@given(st.lists(st.lists(st.integers(0, 7), max_size=4), min_size=8, max_size=8))
def test_cycles_are_found_where_a_node_reaches_itself(edges):
    """Against the transitive closure (Warshall)."""
    reach = np.zeros((8, 8), bool)
    for k, to in enumerate(edges):
        reach[k, to] = True
    for k in range(8):
        reach |= reach[:, k, None] & reach[None, k, :]
    offsets = np.cumsum([0] + [len(e) for e in edges]).astype(np.int64)
    targets = np.array([t for e in edges for t in e], np.int64)
    found = part21_graph.cycles(offsets, targets, 10)
    assert bool(found) == bool(np.diag(reach).any())
    for cycle in found:
        assert all(b in edges[a] for a, b in zip(cycle, cycle[1:] + cycle[:1], strict=True))
    assert found == uncompiled("part21_graph").cycles(offsets, targets, 10)


PARTS = st.lists(
    st.tuples(st.sampled_from(["A", "B_2", "CURVE"]), st.text("a,#1()'; ", max_size=6)), max_size=4
)


@settings(max_examples=200, deadline=None)
@given(st.lists(PARTS, min_size=1, max_size=4))
def test_partial_entities_are_those_that_the_grammar_finds(instances):
    texts = [
        "(" + "".join(f"{name}(#7,'{text.replace(chr(39), chr(39) * 2)}',(1.))" for name, text in parts) + ")"
        for parts in instances
    ]
    data = "".join(f"#{k} = /* ( */ {text};\n" for k, text in enumerate(texts)).encode()
    owners, types, begins, stops = partials(part21_scan, data)
    found = [[] for _ in instances]
    for owner, code, begin, stop in zip(owners, types, begins, stops, strict=True):
        found[owner].append((code, data[begin:stop].decode()))
    for k, parts in enumerate(instances):
        records = grammar_body(texts[k]) if parts else ()
        assert [code for code, _ in found[k]] == [
            part21_scan.keyword_hash(r.keyword.encode()) for r in records
        ]
        for (_, inside), record in zip(found[k], records, strict=True):
            assert grammar_body(record.keyword + inside) == (record,)

"""ISO 10303-21: values, strings, lanes, faults, and reading what was written."""

import io
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cncgen.stepnc import read
from cncgen.stepnc.part21 import (
    DERIVED,
    Binary,
    Constant,
    Enumeration,
    Exchange,
    Instance,
    Record,
    Ref,
    Typed,
    ValueRef,
    format_instance,
    write,
)
from cncgen.stepnc.part21.parsing import SyntaxFault, grammar_body, parse_statement, quick_body
from cncgen.stepnc.part21.strings import decode, encode
from cncgen.stepnc.part21.writer import format_record

PROGRAMS = sorted((Path(__file__).parents[2] / "programs" / "stepnc").glob("*.stp"))

names = st.from_regex(r"[A-Z][A-Z0-9_]{0,8}", fullmatch=True)
scalars = st.one_of(
    st.none(),
    st.just(DERIVED),
    st.integers(-(10**12), 10**12),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(max_size=8),
    names.map(Enumeration),
    st.integers(0, 10**9).map(Ref),
    st.from_regex(r"[0-3][0-9A-F]{0,4}", fullmatch=True).map(Binary),
)
#: What edition 3 adds, which the quick lane leaves to the grammar.
rare = st.integers(0, 10**9).map(ValueRef) | names.map(lambda name: Constant(f"#{name}"))


def instances_of(scalars):
    """Return a strategy of the records of an instance."""
    values = st.recursive(
        scalars,
        lambda inner: st.lists(inner, max_size=3).map(tuple) | st.builds(Typed, names, scalars),
        max_leaves=8,
    )
    records = st.builds(Record, names, st.lists(values, max_size=4).map(tuple))
    return st.lists(records, min_size=1, max_size=3).map(tuple)


parts, all_parts = instances_of(scalars), instances_of(scalars | rare)


def exchange(body: str, **options) -> Exchange:
    text = (
        f"ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('X'));\nENDSEC;\nDATA;\n{body}\nENDSEC;\nEND-ISO-10303-21;\n"
    )
    return Exchange.load(text.encode(), "t", **options)


def codes(file: Exchange) -> list[tuple[str, int]]:
    file.check_syntax(file.instance_rows)
    return [(d.code, d.span.line) for d in file.reporter.diagnostics]


@settings(max_examples=200, deadline=None)
@given(parts)
def test_both_lanes_give_what_was_written(written):
    body = "".join(map(format_record, written))
    body = f"({body})" if len(written) > 1 else body
    assert grammar_body(body) == written
    assert quick_body(body) == written


@settings(max_examples=300, deadline=None)
@given(st.text(alphabet="AB(),'#1.5$*/E-\"!\n _", max_size=20))
def test_the_quick_lane_takes_only_what_the_grammar_takes(text):
    quick = quick_body(text)
    if quick is not None:
        assert quick == grammar_body(text)


@settings(max_examples=100, deadline=None)
@given(st.dictionaries(st.integers(1, 10**9), all_parts, max_size=6))
def test_reading_what_was_written(content):
    stream = io.StringIO()
    instances = [Instance(k, v) for k, v in content.items()]
    write(stream, instances, ["A_SCHEMA"], comments=["(START) */ x"])
    file = Exchange.load(stream.getvalue().encode("ascii"))
    assert not list(file.reporter.diagnostics)
    assert [file.instance(i.id) for i in instances] == instances
    assert file.schemas == ("A_SCHEMA",)


@settings(max_examples=300, deadline=None)
@given(st.text(max_size=20))
def test_strings_survive_encoding(text):
    assert encode(text).isascii()
    assert decode(encode(text)) == text


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("it''s", "it's"),
        (r"\\", "\\"),
        (r"\S\D", "Ä"),
        (r"\PB\\S\q", "ń"),
        (r"\X\E9", "é"),
        (r"\X2\03B103B2\X0\x", "αβx"),
        (r"\X2\D83DDE00\X0\ ", "😀 "),
        (r"\X4\0001F600\X0\ ", "😀 "),
        (r"a\N\b", "ab"),
        ("two\nlines", "twolines"),
        (r"\Q\ stays", r"\Q\ stays"),
    ],
)
def test_control_directives(text, meaning):
    assert decode(text) == meaning


def test_every_construct_of_a_file():
    """Editions 1 to 3: comments anywhere, several DATA sections, anchors, references, signature, lower case."""
    text = b"""/* before */ ISO-10303-21;
    HEADER; FILE_DESCRIPTION((''),'4;1'); /* between */ FILE_SCHEMA(('A','B { 1 0 10303 }')); ENDSEC;
    ANCHOR; <top> = #1 {note: 'x'}; <list>=(1,2); ENDSEC;
    REFERENCE; #9 = <http://example.org/a;b#c>; @3 = <other.stp#d>; ENDSEC;
    DATA ('first',('A'));
    #1 /* here too */ = /* and here */ cartesian_point('a /* no comment */ ; b', (1., /* in */ .5, -2.E+1));
    ENDSEC;
    DATA; #2=(A(1)B()C(.T.,$,*,"0F",MEASURE(2.5))); #3=!USER('new
line',#1,#9); ENDSEC;
    END-ISO-10303-21;
    SIGNATURE bm8gc2VtaWNvbG9ucw== ENDSEC;
    """
    file = Exchange.load(text, "t")
    assert codes(file) == []
    assert file.schemas == ("A", "B")
    assert file.anchors == {"top": 1, "list": (1, 2)}
    assert file.references[9] == "http://example.org/a;b#c"
    assert file.instance(1) == Instance(
        1, (Record("CARTESIAN_POINT", ("a /* no comment */ ; b", (1.0, 0.5, -20.0))),)
    )
    assert file.instance(2).keyword == "A+B+C"
    assert file.instance(2).part("C").parameters == (
        Enumeration("T"),
        None,
        DERIVED,
        "0F",
        Typed("MEASURE", 2.5),
    )
    assert file.instance(3).parameters == ("newline", Ref(1), Ref(9))
    assert [file.line(k) for k in (1, 2, 3)] == [6, 8, 8]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("#1=A(1,);", [("part21-syntax", 6)]),
        ("#1=A((1,2);", [("part21-syntax", 6)]),
        ("#1=A(1)\n#2=B();", [("part21-semicolon", 7)]),
        ("#1=A();\n#1=B();", [("part21-duplicate", 7)]),
        ("#1=A('x\n);\n#2=B(1);", [("part21-string", 6)]),
        ("/* never\n#1=A();", [("part21-comment", 6)]),
        ("#1 A();", [("part21-syntax", 6)]),
        ("A();", [("part21-section", 6)]),
        ("#1=A(1.E999);", [("part21-syntax", 6)]),
        ("#1=A(" + "(" * 80 + ")" * 80 + ");", [("part21-syntax", 6)]),
        (
            "#1=A(1 2);\n#2=B(,);\n#3=C(#);",
            [("part21-syntax", 6), ("part21-syntax", 7), ("part21-syntax", 8)],
        ),
        ("#" + "9" * 30 + "=A();", [("part21-syntax", 6)]),
    ],
)
def test_faults_are_named_with_their_lines(body, expected):
    found = codes(exchange(body))
    assert [c for c in found if c[0] != "part21-section" or c in expected] == expected


@pytest.mark.parametrize("end", [b"\x1a", b"\r\n\x1a\r\n", b"\0\0\0"])
def test_marks_at_the_end_of_a_file_are_passed_over(end):
    data = exchange("#1=A(1);").data
    file = Exchange.load(data + end, "t")
    assert codes(file) == []
    assert codes(Exchange.load(end, "t")) == codes(Exchange.load(b"", "t"))


def test_a_file_without_its_last_line_is_taken_if_its_data_are_whole():
    data = exchange("#1=A(1);").data
    file = Exchange.load(data[: data.index(b"END-ISO")], "t")
    (found,) = file.reporter.diagnostics
    assert (found.code, found.severity) == ("part21-section", "warning")
    cut_off = Exchange.load(data[: data.index(b"ENDSEC;\nEND-ISO")], "t")
    assert any(d.severity == "error" for d in cut_off.reporter.diagnostics)


def test_a_file_cut_off_says_so():
    file = Exchange.load(b"ISO-10303-21;HEADER;FILE_SCHEMA(('X'));ENDSEC;DATA;\n#1=A(1,", "t")
    assert ("part21-truncated", 2) in codes(file)
    assert any("does not end" in d.message for d in file.reporter.diagnostics)


def test_bytes_that_are_no_utf_8_are_read_as_latin_1_with_a_warning():
    file = exchange("#1=A('x');")
    file = Exchange.load(file.data.replace(b"'x'", b"'\xe9'"), "t")
    assert file.instance(1).parameters == ("é",)
    assert [d.code for d in file.reporter.diagnostics] == ["part21-encoding"]


def test_a_byte_order_mark_is_no_statement():
    file = Exchange.load(b"\xef\xbb\xbf" + exchange("#1=A('x');").data, "t")
    assert file.instance(1).parameters == ("x",)
    assert not file.reporter.diagnostics.has_errors


def test_aliases_of_entities():
    file = exchange(
        "#1=CRTPNT('',(1.,2.,3.));\n#2=(X()CRTPNT('',()));", aliases={"CRTPNT": "CARTESIAN_POINT"}
    )
    assert file.instance(1).keyword == "CARTESIAN_POINT"
    assert file.instance(2).keyword == "X+CARTESIAN_POINT"
    assert file.rows_of_type("CARTESIAN_POINT").tolist() == [file.row_of(1)]
    assert file.points[1].tolist() == [[1.0, 2.0, 3.0]]


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda p: p.stem)
def test_programs_read_the_same_after_writing(path):
    file = Exchange.load(path.read_bytes(), path.name)
    instances = [file.at_row(r) for r in file.instance_rows.tolist()]
    assert codes(file) == []
    stream = io.StringIO()
    write(stream, instances, file.schemas)
    again = Exchange.load(stream.getvalue().encode())
    assert [again.at_row(r) for r in again.instance_rows.tolist()] == instances


@pytest.mark.parametrize("path", PROGRAMS[:1], ids=lambda p: p.stem)
def test_the_whole_file_rule_of_the_grammar_takes_a_program(path):
    tree = parse_statement(path.read_text(), "exchange_file")
    data = next(c for c in tree.children if getattr(c, "data", "") == "data")
    file = Exchange.load(path.read_bytes(), path.name)
    expected = [file.at_row(r) for r in file.instance_rows.tolist()]
    assert [tuple(c) for c in data.children if isinstance(c, tuple) and c] == [
        (i.id, i.parts) for i in expected
    ]


def test_the_error_says_what_was_expected():
    with pytest.raises(SyntaxFault, match="where a value is expected") as caught:
        grammar_body("A(1,)")
    assert caught.value.offset == 4


def test_what_has_no_text_is_refused():
    with pytest.raises(ValueError, match="inf"):
        format_instance(Instance(1, (Record("A", (float("inf"),)),)))
    with pytest.raises(TypeError):
        format_instance(Instance(1, (Record("A", (object(),)),)))


def test_statements_do_not_overlap_after_restarts():
    """Strings and comments without ends, references in all that follows: each is counted once."""
    body = "\n".join(f"#{k}=A(#1,#2,'x);" if k % 2 else f"#{k}=B(#1); /* y" for k in range(3, 40))
    file = exchange("#1=A();\n#2=A();\n" + body)
    targets, offsets = file.links
    assert len(targets) == offsets[-1] <= file.data.count(b"#")
    assert (file.rows.starts[1:] >= file.rows.ends[:-1]).all()


def test_too_little_room_for_references_is_an_error():
    import numpy as np

    from cncgen.kernels import part21_scan

    data = np.frombuffer(b"A(#1,#2)", np.uint8)
    bounds = np.array([0]), np.array([8])
    with pytest.raises(ValueError, match="too short"):
        part21_scan.references(data, *bounds, np.zeros(1, np.int64), np.zeros(2, np.int64))


@pytest.mark.parametrize("signature", ["SIGNATURE MIIa+/==\nENDSEC;", "signature;\nMIIa+/=\nMIIb ENDSEC;"])
@pytest.mark.parametrize("inside", [True, False])
def test_signatures_with_and_without_a_semicolon(signature, inside):
    end = "END-ISO-10303-21;"
    tail = f"{signature}\n{end}" if inside else f"{end}\n{signature}"
    text = f"ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('A'));\nENDSEC;\nDATA;\n#1=A();\nENDSEC;\n{tail}\n"
    file = Exchange.load(text.encode(), "t")
    assert codes(file) == []
    assert file.instance(1).keyword == "A"


@pytest.mark.parametrize(
    "text", ["G21 G90\n#1=5\nG1 X10 F100 ; along\nM2\n", "", "solid part\nfacet normal 0 0 1\n"]
)
def test_another_file_is_told_as_a_whole(text):
    """Each of its lines was a statement cut off."""
    file = Exchange.load(text.encode(), "part.stp")
    (found,) = file.reporter.diagnostics
    assert (found.code, found.span.line) == ("part21-section", 1)
    assert "this is no STEP-NC" in found.message
    assert ("--language gcode" in found.hint) == bool(text)
    assert [d.code for d in check_text(text)] == ["part21-section"]


@pytest.mark.parametrize(
    ("content", "words"), [("ISO-10303-21;".encode("utf-16"), "UTF-16"), (b"<?xml version='1.0'?>", "XML")]
)
def test_another_form_of_step_is_told(content, words):
    (found,) = Exchange.load(content, "part.stp").reporter.diagnostics
    assert words in found.hint


def check_text(text):
    """Return what reading a text as STEP-NC says of it."""
    program = read(text.encode(), "part.stp")
    list(program.chunks())
    return program.diagnostics


def test_a_file_of_a_shape_alone_is_told_so():
    text = "ISO-10303-21;HEADER;FILE_SCHEMA(('CONFIG_CONTROL_DESIGN'));ENDSEC;DATA;#1=CARTESIAN_POINT('',(0.,0.,0.));ENDSEC;END-ISO-10303-21;"
    (found,) = (d for d in check_text(text) if d.code == "stepnc-no-project")
    assert "AP203" in found.hint

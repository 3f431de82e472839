"""Several raw pieces in a STEP-NC file: each workpiece has its own, and stands where its setup places it."""

import io
import math

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.pipeline.removing import coarse_findings, cut, raw_stock
from cncgen.removal.stock import box
from cncgen.stepnc import read, write_ap238
from cncgen.stepnc.geometry.frames import translation
from cncgen.stepnc.geometry.solids import Solid
from cncgen.toolpath.reading import ReadOptions
from tests.stepnc.aim import E, Shaped
from tests.stepnc.building import codes, run
from tests.stepnc.featured import Features

#: Of a pocket of 30 x 20 mm with corners of 4 mm radius.
AREA = 30 * 20 - (4 - math.pi) * 16


class Pieces(Features):
    """Blocks of 60 x 40 x 20 mm, each with a pocket in the middle of its top."""

    def pocketed(self, workpiece, depth, name):
        """A workingstep whose pocket stands in the workpiece's frame."""
        bottom = self.add("PLANAR_POCKET_BOTTOM_CONDITION")
        head = (name, workpiece, (), self.placement((30, 20, 0)), self.plane(-depth))
        pocket = self.add(
            "CLOSED_POCKET", *head, (), None, bottom, None, self.size(4), self.rectangle(30, 20)
        )
        own = (None, None, name, 5.0, None, self.tool("T", 8.0), self.technology(), None)
        kind, rest = "BOTTOM_AND_SIDE_FINISH_MILLING", (None, None, None, None, 3.0, 4.0, None, None)
        return self.step(self.add(kind, *own, *rest), pocket, self.plane(25))

    def setup(self, name, *places):
        """A setup in which workpieces stand at places."""
        stand = tuple(
            self.add("WORKPIECE_SETUP", piece, self.placement(origin), None, None, ())
            for piece, origin in places
        )
        return self.add("SETUP", name, None, self.plane(25), stand)

    def made_of(self, raw, size=(60.0, 40.0, 20.0)):
        """A workpiece whose raw piece is another one, and its own bounding geometry, which is smaller."""
        solid = self.add("BLOCK", "", self.placement((0, 0, -20)), *size)
        return self.add("WORKPIECE", "next", None, None, raw, None, solid, ())


def written(part, tmp_path):
    name = tmp_path / "p.stp"
    name.write_text(part.text())
    return str(name)


def removed(removal):
    return [o.volume_mm3 for o in removal.operations]


def block(part, low=(0, 0, -20), high=(60, 40, 0)):
    return part.block(low, high)


def test_two_workpieces_in_one_setup_are_both_cut(tmp_path):
    """The second one stood in the air before: only the first raw piece was there."""
    part = Pieces()
    one, two = block(part), block(part, high=(70, 40, 0))
    setup = part.setup("vices", (one, (0, 0, 0)), (two, (100, 10, 0)))
    steps = part.pocketed(one, 6.0, "one"), part.pocketed(two, 9.0, "two")
    part.project(part.plan(*steps, setup=setup))
    removal = cut(written(part, tmp_path), cell_mm=0.2)
    assert [f.code for f in removal.findings] == []
    assert removal.raw_volume_mm3 == pytest.approx((60 + 70) * 40 * 20, rel=5e-3)
    assert removed(removal) == pytest.approx([AREA * 6, AREA * 9], rel=5e-3)
    assert coarse_findings(written(part, tmp_path), ReadOptions()) == []


def test_workpieces_of_a_project_without_setups_are_all_there(tmp_path):
    part = Pieces()
    one, two = block(part), block(part, (80, 0, -20), (120, 40, 0))
    plan = part.plan(part.step(part.freeform(part.trajectory(part.polyline((-20, 5, -2), (150, 5, -2))))))
    part.add("PROJECT", "p", plan, (one, two), None, None, None)
    removal = cut(written(part, tmp_path), cell_mm=0.2)
    # The tool of 10 mm goes along the edge of both blocks.
    assert removed(removal) == pytest.approx([(60 + 40) * 10 * 2], rel=5e-3)


def test_setups_with_different_raw_pieces_are_refused_by_that_name(tmp_path):
    """One was cut alone where they are alike in size; else nothing was said to stand where it does."""
    part = Pieces()
    one, two = block(part), block(part)
    first = part.plan(part.pocketed(one, 6.0, "one"), setup=part.setup("a", (one, (0, 0, 0))))
    second = part.plan(part.pocketed(two, 6.0, "two"), setup=part.setup("b", (two, (0, 0, 0))))
    part.project(part.plan(first, second))
    name = written(part, tmp_path)
    with pytest.raises(
        UsageError, match=f"different raw pieces, of the workpieces #{one - 1} and #{two - 1}"
    ):
        cut(name)
    (told,) = coarse_findings(name, ReadOptions())
    assert (told.code, str(told.severity)) == ("cut-setups", "note")


@pytest.mark.parametrize("apart", [100.0, 90.0])
def test_two_workpieces_go_together_from_setup_to_setup(tmp_path, apart):
    part = Pieces()
    one, two = block(part), block(part)
    first = part.setup("a", (one, (0, 0, 0)), (two, (100, 0, 0)))
    second = part.setup("b", (one, (0, 50, 0)), (two, (apart, 50, 0)))
    plans = (
        part.plan(part.pocketed(one, 6.0, "one"), setup=first),
        part.plan(part.pocketed(two, 9.0, "two"), setup=second),
    )
    part.project(part.plan(*plans))
    name = written(part, tmp_path)
    if apart == 90.0:
        with pytest.raises(UsageError, match="place their raw pieces otherwise to one another"):
            cut(name)
        return
    removal = cut(name, cell_mm=0.2)
    assert [f.code for f in removal.findings] == []
    assert removed(removal) == pytest.approx([AREA * 6, AREA * 9], rel=1e-2)


def test_a_workpiece_made_of_the_one_before_goes_on_with_what_is_left_of_it(tmp_path):
    """ISO 14649-10: its_rawpiece is a workpiece, which may have one too. The second pocket is the deeper part of the first."""
    part = Pieces()
    one = block(part)
    two = part.made_of(one)
    first = part.plan(part.pocketed(one, 6.0, "one"), setup=part.setup("a", (one, (0, 0, 0))))
    second = part.plan(part.pocketed(two, 9.0, "two"), setup=part.setup("b", (two, (5, 5, 0))))
    part.project(part.plan(first, second))
    removal = cut(written(part, tmp_path), cell_mm=0.2)
    assert removed(removal) == pytest.approx([AREA * 6, AREA * 3], rel=1e-2)


def test_raw_pieces_that_stand_in_one_another_are_told(tmp_path):
    part = Pieces()
    one, two = block(part), block(part)
    setup = part.setup("both", (one, (0, 0, 0)), (two, (50, 0, 0)))
    part.project(part.plan(part.pocketed(one, 6.0, "one"), setup=setup))
    with pytest.raises(UsageError, match="one stands in another"):
        cut(written(part, tmp_path))
    (told,) = coarse_findings(written(part, tmp_path), ReadOptions())
    assert (told.code, str(told.severity)) == ("cut-stock", "warning")


@pytest.mark.parametrize("kind", ["block", "cylinder"])
@pytest.mark.parametrize("degrees", [0.0, 30.0, 90.0])
def test_a_raw_piece_that_is_turned_keeps_its_volume(kind, degrees):
    """About X for the cylinder, which lies then; the box round a turned block was the stock before."""
    angle = math.radians(degrees)
    c, s = math.cos(angle), math.sin(angle)
    frame = translation(3, 4, 5)
    frame[:3, :3] = (
        [[c, -s, 0], [s, c, 0], [0, 0, 1]] if kind == "block" else [[1, 0, 0], [0, c, -s], [0, s, c]]
    )
    size = (40.0, 20.0, 10.0) if kind == "block" else (8.0, 8.0, 30.0)
    volume = 8000.0 if kind == "block" else math.pi * 64 * 30
    stock = raw_stock([Solid(kind, frame, size)])
    assert stock.field(0.05).raw_volume == pytest.approx(volume, rel=5e-3)


# AP238


class Held(Shaped):
    """Workpieces of blocks, in setups."""

    def product(self, name):
        return self.file.add("PRODUCT_DEFINITION", name, "", None, None)

    def workpiece(self, corner=(0.0, 0.0, -20.0), size=(60.0, 40.0, 20.0)):
        piece, raw = self.product("part"), self.product("raw")
        one = self.file.add("MEASURE_WITH_UNIT", 1.0, self.file.tooth)
        self.file.add("MAKE_FROM_USAGE_OPTION", "", "", "", piece, raw, 1, "", one)
        shape = self.file.add("PRODUCT_DEFINITION_SHAPE", "", "", raw)
        frame = translation(*corner)
        solid = self.file._solid({"kind": "block", "frame": frame, "size": size})
        self.file.add("SHAPE_DEFINITION_REPRESENTATION", shape, solid)
        return piece

    def setup(self, plan, *places):
        setup = self.product("setup")
        process = self.file.add("PRODUCT_DEFINITION_PROCESS", "setup", "", plan, "")
        self.file.add("PROCESS_PRODUCT_ASSOCIATION", "", "", setup, process)
        for piece, origin in places:
            relation = self.file.add("MACHINING_SETUP_WORKPIECE_RELATIONSHIP", "", "", "", setup, piece)
            shape = self.file.add("PRODUCT_DEFINITION_SHAPE", "", "", relation)
            change = self.file.add(
                "ITEM_DEFINED_TRANSFORMATION", "", "", self.place(0, 0, 0), self.place(*origin)
            )
            link = self.file.add_complex(
                ("REPRESENTATION_RELATIONSHIP", ("", "", None, None)),
                ("REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION", (change,)),
                ("SHAPE_REPRESENTATION_RELATIONSHIP", ()),
            )
            self.file.add("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION", link, shape)
        return plan

    def hole(self, piece, x, y):
        """A step that mills a hole of 20 mm, 12 mm deep, in a workpiece (None: of none)."""
        shape = None if piece is None else self.file.add("PRODUCT_DEFINITION_SHAPE", "", "", piece)
        feature = self.file.add_complex(
            ("CHARACTERIZED_OBJECT", ("hole", "")), ("FEATURE_DEFINITION", ()), ("INSTANCED_FEATURE", ()),
            ("ROUND_HOLE", ()), ("SHAPE_ASPECT", ("hole", "", shape, E("T"))),
        )  # fmt: skip
        held = self.file.add("PRODUCT_DEFINITION_SHAPE", "", "", feature)
        self.describe(held, "SHAPE_REPRESENTATION_WITH_PARAMETERS", "", self.place(x, y, 0))
        z, ex = np.array([0, 0, 1.0]), np.array([1.0, 0, 0])
        plane = self.file.add("PLANE", "", self.file.placement(np.array([0, 0, -12.0]), z, ex))
        self.describe(held, "SHAPE_REPRESENTATION", "maximum feature limit", plane)
        occurrence = self.file.add("SHAPE_ASPECT", "", "diameter occurrence", held, E("T"))
        profile = self.file.add("CIRCULAR_CLOSED_PROFILE", "", "", None, E("T"))
        self.file.add("SHAPE_DEFINING_RELATIONSHIP", "diameter", "profile usage", profile, occurrence)
        own = self.file.add("PRODUCT_DEFINITION_SHAPE", "", "", profile)
        self.describe(own, "SHAPE_REPRESENTATION_WITH_PARAMETERS", "", *self.sizes([("diameter", 20.0)]))
        step, _ = self.machine(feature)
        self.file.property(
            step, "security plane", "REPRESENTATION", "", self.file.add("PLANE", "", self.place(0, 0, 30))
        )
        return step

    def text(self, plan):
        self.file.project(plan, "p")
        head = "ISO-10303-21;\n/* (START, X0 Y0 Z50) */\nHEADER;\nFILE_SCHEMA(('X'));\nENDSEC;\nDATA;\n"
        return head + self.stream.getvalue() + "ENDSEC;\nEND-ISO-10303-21;\n"


def test_ap238_each_workpiece_of_a_setup_has_its_place_and_raw_piece(tmp_path):
    """Two places of workpieces in a setup were refused; the first raw piece was that of all."""
    aim = Held()
    one, two = aim.workpiece(), aim.workpiece(size=(70.0, 40.0, 20.0))
    plan = aim.plan(aim.hole(one, 30, 20), aim.hole(two, 50, 15))
    text = aim.text(aim.setup(plan, (one, (0, 0, 0)), (two, (100, 0, 0))))
    (tmp_path / "p.stp").write_text(text)
    removal = cut(str(tmp_path / "p.stp"), cell_mm=0.2)
    assert [f.code for f in removal.findings] == []
    assert removal.raw_volume_mm3 == pytest.approx((60 + 70) * 40 * 20, rel=5e-3)
    assert removed(removal) == pytest.approx([math.pi * 100 * 12] * 2, rel=1e-2)


@pytest.mark.parametrize("raws", [1, 2])
def test_ap238_what_a_workpiece_is_made_from_may_be_its_material(raws):
    """ISO 10303-238, J.7: a product without a shape, which has the material. Two raw pieces with shapes are refused."""
    aim = Held()
    piece = aim.workpiece()
    one = aim.file.add("MEASURE_WITH_UNIT", 1.0, aim.file.tooth)
    other = aim.product("material") if raws == 1 else aim.workpiece(size=(10.0, 10.0, 10.0))
    aim.file.add("MAKE_FROM_USAGE_OPTION", "", "", "", piece, other, 1, "", one)
    plan = aim.plan(aim.hole(piece, 30, 20))
    _, found = run(aim.text(aim.setup(plan, (piece, (0, 0, 0)))))
    assert codes(found, "error") == (["stepnc-several"] if raws == 2 else [])


def test_ap238_a_feature_of_none_of_several_workpieces_is_refused():
    aim = Held()
    one, two = aim.workpiece(), aim.workpiece()
    plan = aim.plan(aim.hole(None, 30, 20))
    found = run(aim.text(aim.setup(plan, (one, (0, 0, 0)), (two, (100, 0, 0)))))[1]
    assert codes(found, "error") == ["stepnc-workpiece"]


def test_ap238_an_orientation_of_toolpaths_leaves_the_workpiece_where_it_is(tmp_path):
    """ISO 10303-238, 4.3.345.3: it places toolpaths. Two workplans had two raw pieces, and the first counted."""
    aim = Held()
    piece = aim.workpiece()
    steps = []
    for x in (10.0, 40.0):
        step, operation = aim.step()
        technology = aim.technology(600.0)
        aim.file.add("MACHINING_TECHNOLOGY_RELATIONSHIP", "", "", operation, technology)
        aim.tool(operation, "endmill")
        aim.path(operation, aim.polyline((0, -10, -2), (0, 50, -2)))
        inner = aim.plan(step)
        aim.file.property(inner, "toolpath orientation", "REPRESENTATION", "", aim.place(x, 0, 0))
        steps.append(inner)
    text = aim.text(aim.setup(aim.plan(*steps), (piece, (0, 0, 0))))
    (tmp_path / "p.stp").write_text(text)
    removal = cut(str(tmp_path / "p.stp"), cell_mm=0.2)
    assert removed(removal) == pytest.approx([8 * 40 * 2] * 2, rel=5e-3)


def test_ap238_a_fault_of_the_feature_leaves_explicit_toolpaths():
    """Which workpiece a feature is of does not matter to them."""
    aim = Shaped()
    step, operation = aim.step()
    aim.path(operation, aim.polyline((0, 0, 0), (7, 0, 0)), aim.technology())
    process = aim.file.method("MACHINING_FEATURE_PROCESS")
    aim.file.add("MACHINING_FEATURE_RELATIONSHIP", "", "", step, process)
    action = aim.file.add("PROPERTY_PROCESS", "machining", "", process, "")
    aim.file.add("PROCESS_PROPERTY_ASSOCIATION", "", "", action, "no reference")
    path, found = aim.read(aim.plan(step))
    assert "stepnc-type" in codes(found, "error")
    assert path.end[-2, 0] == 7.0


@pytest.mark.parametrize("length", [1, 3, 5000])
def test_ap238_workpieces_made_of_one_another_in_a_ring_or_a_long_row(length):
    aim = Held()
    pieces = [aim.product(f"p{k}") for k in range(length)]
    one = aim.file.add("MEASURE_WITH_UNIT", 1.0, aim.file.tooth)
    ring = length < 100
    for k in range(length if ring else length - 1):
        aim.file.add("MAKE_FROM_USAGE_OPTION", "", "", "", pieces[k], pieces[(k + 1) % length], 1, "", one)
    plan = aim.plan(aim.hole(pieces[0], 30, 20))
    found = run(aim.text(aim.setup(plan, (pieces[0], (0, 0, 0)))))[1]
    assert ("part21-cycle" if ring else "stepnc-nesting") in codes(found, "error")


def test_ap238_says_which_raw_pieces_of_one_setup_are_left_out(tmp_path):
    """The second one was left out without a word."""
    part = Pieces()
    one, two = block(part), block(part, high=(70, 40, 0))
    setup = part.setup("vices", (one, (0, 0, 0)), (two, (100, 10, 0)))
    part.project(part.plan(part.pocketed(one, 6.0, "one"), part.pocketed(two, 9.0, "two"), setup=setup))
    program = read(written(part, tmp_path), options=ReadOptions(workingsteps=True))
    (told,) = write_ap238(program.chunks(), io.StringIO())
    assert told.code == "stepnc-raw-pieces"
    assert "has 2 raw pieces" in told.message


def setups(part, other):
    """A pocket in each of two setups, of a piece that stands elsewhere in the second one, or of another piece."""
    piece = block(part)
    second = block(part, high=(70, 40, 0)) if other else piece
    first = part.plan(part.pocketed(piece, 6.0, "one"), setup=part.setup("a", (piece, (0, 0, 0))))
    last = part.plan(part.pocketed(second, 6.0, "two"), setup=part.setup("b", (second, (5, 0, 0))))
    part.project(part.plan(first, last))


@pytest.mark.parametrize("other", [False, True], ids=["elsewhere", "another"])
def test_ap238_has_the_raw_piece_of_each_setup(tmp_path, other):
    """One was written, and a warning said that the next one is left out."""
    part = Pieces()
    setups(part, other)
    source = written(part, tmp_path)
    program = read(source, options=ReadOptions(workingsteps=True))
    stream = io.StringIO()
    assert write_ap238(program.chunks(), stream) == []
    (tmp_path / "aim.stp").write_text(stream.getvalue())
    again = read(str(tmp_path / "aim.stp"), options=ReadOptions(workingsteps=True))
    before, after = (
        [
            event.values["stock"]
            for chunk in each.chunks()
            for event in chunk.events
            if event.name == "workingstep" and "stock" in event.values
        ]
        for each in (read(source, options=ReadOptions(workingsteps=True)), again)
    )
    assert len(before) == len(after) == 2
    for one, two in zip(before, after, strict=True):
        assert one["kind"] == two["kind"]
        np.testing.assert_allclose(two["size"], one["size"], rtol=0, atol=1e-9)
        np.testing.assert_allclose(two["frame"], one["frame"], rtol=0, atol=1e-9)
    files = (source, str(tmp_path / "aim.stp"))
    if other:
        for file in files:
            with pytest.raises(UsageError, match="have different raw pieces"):
                cut(file)
    else:
        # The second pocket is at the place of the first one in the piece, which went with it.
        assert [removed(cut(file, cell_mm=0.5)) for file in files] == [pytest.approx([3519, 0], abs=40)] * 2


def test_ap238_a_raw_piece_that_is_given_is_that_of_all(tmp_path):
    part = Pieces()
    setups(part, True)
    program = read(written(part, tmp_path), options=ReadOptions(workingsteps=True))
    stream = io.StringIO()
    given = {"kind": "block", "frame": np.eye(4), "size": (200.0, 100.0, 20.0)}
    assert write_ap238(program.chunks(), stream, stock=given) == []
    assert stream.getvalue().count("BLOCK_SHAPE_REPRESENTATION") == 1


def test_ap238_the_same_raw_piece_in_all_workingsteps_is_no_fault(tmp_path):
    part = Pieces()
    piece = block(part)
    setup = part.setup("a", (piece, (0, 0, 0)))
    part.project(part.plan(part.pocketed(piece, 6.0, "one"), part.pocketed(piece, 9.0, "two"), setup=setup))
    program = read(written(part, tmp_path), options=ReadOptions(workingsteps=True))
    assert write_ap238(program.chunks(), io.StringIO()) == []


@pytest.mark.parametrize(("x", "y"), [(120.0, 80.0), (100.0, 60.0), (77.0, 33.3), (500.0, 3.0), (40.0, 40.0)])
def test_columns_fill_a_box_without_a_rest(x, y):
    """Without a width given, columns as wide as they are many along both sides: their volume is the box's."""
    field = box((0, 0, -10), (x, y, 0)).field()
    assert field.raw_volume == pytest.approx(x * y * 10, rel=2e-3)
    assert min(len(field.x), len(field.y)) >= 10


@pytest.mark.parametrize("cell", [7.0, 0.7, 1.1])
def test_columns_of_a_given_width_are_as_many_as_come_nearest(cell):
    field = box((0, 0, -10), (100, 60, 0)).field(cell)
    assert (len(field.x), len(field.y)) == (round(100 / cell), round(60 / cell))


def test_a_column_wider_than_the_stock_is_refused():
    with pytest.raises(UsageError, match="wider than the stock of 100 x 60 mm"):
        box((0, 0, -10), (100, 60, 0)).field(61.0)

"""Programs with several setups: a work offset each; probing ends its lines with G38.2."""

import io
import json
import math

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.gcode import read as read_gcode
from cncgen.stepnc import gcode_lines
from cncgen.toolpath.record import Kind
from tests.stepnc.aim import Aim
from tests.stepnc.building import WHOLE, Part, codes, motions, run
from tests.stepnc.featured import Features
from tests.stepnc.test_ap238_written import from_gcode, written


def two_setups(count=2):
    """Return a part whose setups k stand at X 100 k, each with a line from (k, 0, 0) to (k, 10, 0)."""
    part = Part()
    plans = []
    for k in range(count):
        origin = part.placement((100.0 * k, 0, 0))
        plane = part.add("PLANE", "", part.placement((0, 0, 30)))
        setup = part.add("SETUP", f"side {k}", origin, plane, ())
        step = part.step(part.freeform(part.trajectory(part.polyline((k, 0, 0), (k, 10, 0)))))
        plans.append(part.plan(step, setup=setup))
    part.project(part.plan(*plans))
    return part


def test_each_setup_has_its_work_offset():
    path, found = two_setups().read()
    assert codes(found, "error") == []
    setups = [dict(e.values) for e in path.events if e.name == "setup"]
    assert setups == [
        {"number": 1, "setup": "side 0", "origin_mm": [0, 0, 0]},
        {"number": 2, "setup": "side 1", "origin_mm": [100, 0, 0]},
    ]
    lines = list(gcode_lines([path]))
    offsets = [line for line in lines if line in ("G54", "G55")]
    assert offsets == ["G54", "G55"]
    assert "(setup side 1: G55 at X100 Y0 Z0)" in lines
    # Positions are those of each setup: the offsets are set at the machine.
    again = from_gcode("\n".join(lines))
    np.testing.assert_allclose(again.end[motions(again)], path.end[motions(path)], atol=1e-9)
    np.testing.assert_allclose(path.end[motions(path)][-1], [1, 10, 0])
    calls = [c.split(maxsplit=1)[1] for c in two_setups().calls()]
    assert [c for c in calls if c.startswith("SET_G5X")] == [
        f"SET_G5X_OFFSET({k}, 0.0000, 0.0000, 0.0000)" for k in (1, 2)
    ]


def test_one_setup_needs_no_word():
    path, _ = two_setups(1).read()
    assert [e.name for e in path.events if e.name == "setup"] == []
    assert not {"G54", "G55"} & set(gcode_lines([path]))


def test_more_setups_than_work_offsets_are_refused():
    path, _ = two_setups(10).read()
    with pytest.raises(UsageError, match="10 setups"):
        list(gcode_lines([path]))


def test_a_stock_that_is_not_known_in_each_setup_is_refused(tmp_path, cncgen):
    program = tmp_path / "two.stp"
    program.write_text(two_setups().text())
    done = cncgen("cut", program, "--stock", "box:0,0,-5,20,20,0")
    assert done.returncode == 2
    assert b"cut-setups" in done.stderr


def test_setups_of_ap238():
    aim = Aim()
    file, plans = aim.file, []
    for k in range(2):
        step, operation = aim.step()
        aim.path(operation, aim.polyline((k, 0, 0), (k, 9, 0)), aim.technology())
        plan = aim.plan(step, name=f"plan {k}")
        process = file.add("PRODUCT_DEFINITION_PROCESS", "setup", "", plan, "")
        product = file.add("MACHINING_SETUP", f"setup {k}", "", "", ())
        formation = file.add("PRODUCT_DEFINITION_FORMATION", "", "", product)
        setup = file.add("PRODUCT_DEFINITION", "", "", formation, None)
        file.add("PROCESS_PRODUCT_ASSOCIATION", "", "", setup, process)
        plans.append(plan)
    path, found = aim.read(aim.plan(*plans))
    assert codes(found, "error") == []
    assert [e.values["number"] for e in path.events if e.name == "setup"] == [1, 2]
    assert "display message" in written(path)


def test_probing_becomes_g38():
    """The lines of a touch probing at feed; what is read back goes to their ends."""
    part = Part()
    technology = part.technology(0.002)
    path = part.trajectory(part.polyline((0, 0, 5), (0, 0, -2)), technology=technology)
    paths = part.add("TOOLPATH_LIST", (path,))
    part.project(part.plan(part.add("TOUCH_PROBING", "probe", None, paths, None, None)))
    original, found = part.read()
    assert ("probe-not-run", "note") in [(c, s) for c, s, _ in found]
    lines = list(gcode_lines([original]))
    assert [line for line in lines if "G38" in line] == ["G94 G38.2 Z-2 F120"]
    program = read_gcode(io.BytesIO("\n".join(lines).encode()), "p.ngc", WHOLE)
    (again,) = program.chunks()
    np.testing.assert_allclose(again.end[again.kind != Kind.EVENT][-1], [0, 0, -2])


class Sides(Features):
    """A block of 60 x 40 x 20 mm with a pocket from above and one from below, each in a setup of its own."""

    def pocketed(self, depth, name, setup, axis=(0, 0, 1)):
        """A pocket of 30 x 20 mm in the middle of a side; the placement stands in the workpiece's frame."""
        z = 0.0 if axis[2] > 0 else -20.0
        place = self.placement((30, 20, z), axis, (1, 0, 0))
        bottom = self.add("PLANAR_POCKET_BOTTOM_CONDITION")
        head = (name, self.workpiece, (), place, self.plane(-depth))
        feature = self.add(
            "CLOSED_POCKET", *head, (), None, bottom, None, self.size(4), self.rectangle(30, 20)
        )
        own = (None, None, name, 5.0, None, self.tool(name, 8.0), self.technology(), None)
        operation = self.add(
            "BOTTOM_AND_SIDE_FINISH_MILLING", *own, None, None, None, None, 3.0, 4.0, None, None
        )
        return self.plan(self.step(operation, feature, self.plane(25)), setup=setup)

    def clamped(self, name, origin=(0, 0, 0), axis=(0, 0, 1)):
        stands = self.add(
            "WORKPIECE_SETUP", self.workpiece, self.placement(origin, axis, (1, 0, 0)), None, None, ()
        )
        return self.add("SETUP", name, None, self.plane(25), (stands,))

    def both(self, above, below):
        self.workpiece = self.block((0, 0, -20), (60, 40, 0))
        first = self.pocketed(above, "above", self.clamped("top"))
        # Turned about X: the underside is on top, and Y goes the other way.
        second = self.pocketed(below, "below", self.clamped("turned", (0, 40, -20), (0, 0, -1)), (0, 0, -1))
        self.project(self.plan(first, second))
        return self.text()


@pytest.mark.parametrize("below", [6.0, 14.0])
def test_the_stock_is_turned_between_setups(tmp_path, cncgen, below):
    """Pockets 8 mm deep from above, and from below 6 mm (12 mm stay between) or 14 mm (they meet: 2 mm of one is air)."""
    program = tmp_path / "sides.stp"
    program.write_text(Sides().both(8.0, below))
    done = cncgen("cut", program, "--cell", "0.2", "--report", tmp_path / "r.json")
    assert done.returncode == 0, done.stderr.decode()
    found = json.loads((tmp_path / "r.json").read_text())
    area = 30 * 20 - (4 - math.pi) * 16
    removed = [o["removed_mm3"] for o in found["operations"]]
    assert removed[0] == pytest.approx(area * 8, rel=5e-3)
    assert removed[1] == pytest.approx(area * min(below, 12.0), rel=5e-3)
    assert found["volume_mm3"] == pytest.approx(60 * 40 * 20 - sum(removed), rel=5e-3)
    assert cncgen("check", program).returncode == 0


def test_what_its_setup_stands_upright_needs_no_rotary_axes():
    """A pocket in the underside of a block that is turned over; without the turn it needs them."""
    path, found = run(Sides().both(8.0, 6.0))
    assert codes(found, "error") == []
    assert path.axes == "XYZ"
    part = Sides()
    part.workpiece = part.block((0, 0, -20), (60, 40, 0))
    part.project(part.pocketed(6.0, "below", part.clamped("as it is"), (0, 0, -1)))
    assert run(part.text())[0].axes == "XYZBC"

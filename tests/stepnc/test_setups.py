"""Programs with several setups: a work offset each; probing ends its lines with G38.2."""

import io

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.gcode import read as read_gcode
from cncgen.stepnc import gcode_lines
from cncgen.toolpath.record import Kind
from tests.stepnc.aim import Aim
from tests.stepnc.building import WHOLE, Part, codes, motions
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


def test_a_stock_is_cut_in_one_clamping(tmp_path, cncgen):
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

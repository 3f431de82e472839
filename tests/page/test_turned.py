"""Which parts lie with Z to the right: turned ones, by machine, dialect, spindle and tools."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import pytest

import cncgen
from cncgen.machine.record import Machine

MILL = cncgen.load_machine("generic-mill")
WITHOUT_Y = replace(MILL, axes=MappingProxyType({letter: MILL.axes[letter] for letter in "XZ"}))


@pytest.mark.parametrize(
    ("text", "machine", "reading", "turned"),
    [
        pytest.param("G1 X20 Z-1 F900", MILL, {}, False, id="a groove of a mill"),
        pytest.param("G1 X20 Z-1 F900", WITHOUT_Y, {}, True, id="a machine without Y"),
        pytest.param("G96 S200 M3\nG1 X20 Z-1 F900", MILL, {}, True, id="a constant surface speed"),
        pytest.param(
            "G20\nG96 S200 M3\nG1 X2 Z-1 F90", MILL, {}, True, id="a constant surface speed in feet"
        ),
        pytest.param("G1 X20 Z-1 F900", MILL, {"dialect": "fanuc-lathe"}, True, id="a dialect of lathes"),
        pytest.param(
            "G1 X20 Y5 Z-1 F900", MILL, {"dialect": "fanuc-lathe"}, False, id="motion across X and Z"
        ),
    ],
)
def test_a_part_is_turned(
    tmp_path: Path, text: str, machine: Machine, reading: Mapping[str, str], turned: bool
) -> None:
    (tmp_path / "a.nc").write_text(f"G21 G90 G94\n{text}\nM2\n".replace("G94", "G98" if reading else "G94"))
    how = cncgen.ReadOptions(**reading)
    page = cncgen.report_page(cncgen.read(tmp_path / "a.nc", options=how), machine)
    header = re.search(r'<script type="application/json" id="header">(.*?)</script>', page.html, re.S)
    assert header
    assert json.loads(header[1])["parts"][0]["turned"] is turned


def test_tools_that_cut_nothing_are_told(tmp_path: Path) -> None:
    """The page shows the whole stock then, as if the program left it so; only the page's tab said why."""
    from cncgen.pipeline import ShownPart

    (tmp_path / "a.nc").write_text("G21 G90 G94\nG1 X20 Z-1 F900\nM2\n")
    page = cncgen.report_page(tmp_path / "a.nc", MILL, shown_part=ShownPart(stock="box:0,-5,-5,20,5,0"))
    assert "cut-tool" in [found.code for found in page.remarks]

"""The unit of programs that do not say it: a note, a warning where it looks like inches, and two ways to name it."""

from __future__ import annotations

from typing import Any

import pytest

from cncgen.gcode.state.settings import interpreter_settings
from cncgen.toolpath.reading import ReadOptions
from cncgen.units import INCH

INCHES = "G90 G94 F12.5\nG1 X1.1250 Y0.3125\nX2.0625\nM2\n"


def said(run: Any, text: str, **options: Any) -> list[tuple[str, int, int]]:
    found = run(text, **{"units": "auto", **options}).diagnostics
    return [(d.code, d.span.line, d.span.column) for d in found if d.code.startswith("units") and d.span]


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc", "fanuc-lathe"])
def test_lengths_without_a_unit_are_mm_and_said_so(run: Any, dialect: str) -> None:
    text = (
        "G90 G98 F600\nG0 Z5.\nG1 X10.\nM2\n" if dialect == "fanuc-lathe" else "F600\nG0 Z5.\nG1 X10.\nM2\n"
    )
    assert said(run, text, dialect=dialect) == [("units-assumed", 2, 4)]
    assert run(text, dialect=dialect, units="auto").path.end[0, 2] == 5.0


@pytest.mark.parametrize("word", ["G21", "G20", "g21", "G 21", "G021", "N5G21"])
def test_a_text_that_says_its_unit_anywhere_has_no_note(run: Any, word: str) -> None:
    assert said(run, f"{word}\nF600\nG1 X10\nM2\n") == []
    # A late G20 leaves lengths of another unit before it.
    late = [("units-doubtful", 3, 1)] if word == "G20" else []
    assert said(run, f"F600\nG1 X10\n{word}\nM2\n") == late


@pytest.mark.parametrize("word", ["G[20 OR ABS[20]]", "#1=20\nG#1"])
def test_a_computed_code_may_say_the_unit(run: Any, word: str) -> None:
    out = run(f"{word}\nG0 X1.\nM30\n", dialect="fanuc", units="auto")
    assert out.path.end[0, 0] == INCH
    assert [d.code for d in out.diagnostics if d.code.startswith("units")] == []


@pytest.mark.parametrize("text", ["(G21 is in force)", "; G21", "G21.1", "G210", "X#21"])
def test_what_only_looks_like_a_unit_says_none(run: Any, text: str) -> None:
    codes = [code for code, _, _ in said(run, f"F600 G1 X1\n{text}\nM2\n")]
    assert codes == ["units-assumed"]


def test_a_unit_far_down_a_long_text_is_found(run: Any) -> None:
    """A program of many lines: the first 64 kB hold no unit."""
    lines = "".join(f"G1 X{k % 7} F600\n" for k in range(8_000))
    assert said(run, lines + "G21\nM2\n") == []
    assert said(run, lines + "(G21)\nM2\n") == [("units-assumed", 1, 4)]


def test_a_text_without_lengths_needs_no_unit(run: Any) -> None:
    assert said(run, "M3 S1000\nM30\n") == []


def test_numbers_that_look_like_inches_are_warned_of(run: Any) -> None:
    """Four decimals, small coordinates and slow feeds; each of them alone is usual in mm."""
    found = [d for d in run(INCHES, units="auto").diagnostics if d.code == "units-doubtful"]
    assert [(str(d.severity), d.values) for d in found] == [("warning", {"feed": 12.5})]
    for other in (
        INCHES.replace("F12.5", "F600"),
        INCHES.replace("2.0625", "206.25"),
        INCHES.replace("1.1250", "1.125"),
    ):
        assert [code for code, _, _ in said(run, other)] == ["units-assumed"]


@pytest.mark.parametrize(
    ("comment", "code"),
    [
        ("(T1 = 1in FACE MILL)", "units-doubtful"),
        ('; 3/4" DRILL', "units-doubtful"),
        ("(.5 INCH CUTTER)", "units-doubtful"),
        ("(T1 IN THE SPINDLE)", "units-assumed"),
        ("(1/4IN SHANK, 6MM CUTTER)", "units-assumed"),
    ],
)
def test_sizes_in_comments_tell_inches(run: Any, comment: str, code: str) -> None:
    """A program by hand without G20, whose feeds are too fast to tell (CadeKiely/Hass-CNC-Programs, TEAMMACHINE-ENGRAVE)."""
    assert [found for found, _, _ in said(run, f"{comment}\nF80\nG1 X-.750 Y.125\nX3.5\nM2\n")] == [code]


def test_numbers_without_a_zero_before_the_point_look_like_inches(run: Any) -> None:
    """As programs by hand have them; three decimals with zeros are usual in mm."""
    text = "F50\nG1 X-.750 Y.125\nX4.750 Y-.500\nM2\n"
    assert [code for code, _, _ in said(run, text)] == ["units-doubtful"]
    for other in (text.replace(".", "0."), text.replace("F50", "F90"), text.replace("4.750", "47.500")):
        assert [code for code, _, _ in said(run, other)] == ["units-assumed"]


@pytest.mark.parametrize(
    ("feeds", "code"), [((0.08, 0.05, 0.35), "units-assumed"), ((0.008, 0.005, 0.1), "units-doubtful")]
)
def test_feeds_a_revolution_tell_inches_from_millimetres(
    run: Any, feeds: tuple[float, ...], code: str
) -> None:
    """Turning takes 0.05 to 0.5 mm a revolution, 0.002 to 0.02 inches; programs by hand leave out zeros in both, and a lead may be larger."""
    text = (
        "T0101\nG97 S750 M3\nG0 X6.9 Z2.\nG1 Z-.375 F{}\nX7.9 Z-.475 F{}\nZ-.675\nX9.98 F{}\nG28 U0 W0\nM30\n"
    )
    assert [found for found, _, _ in said(run, text.format(*feeds), dialect="fanuc-lathe")] == [code]


@pytest.mark.parametrize(
    ("bound", "surface", "x", "code"),
    [
        ("G50 S1600", "G96 S1000", "2.0", "units-doubtful"),
        ("G92 S2000", "G96 M3 S400", "1.5", "units-doubtful"),
        ("(G50 S1600)", "G96 S1000", "2.0", "units-assumed"),
        ("G50 S1600", "G97 S1000", "2.0", "units-assumed"),
        ("G50 S2000", "G96 S200", "50.0", "units-assumed"),
        ("G50 S150", "G96 S200", "42.0", "units-assumed"),
        # A small drill's hole, faced in mm.
        ("G50 S2000", "G96 S150", "6.0", "units-assumed"),
    ],
)
def test_a_surface_speed_far_beyond_the_bound_looks_like_inches(
    run: Any, bound: str, surface: str, x: str, code: str
) -> None:
    """As in feet a minute at inches; the feeds of roughing may be large for them."""
    text = f"T0101\n{bound}\n{surface} M3\nG0 X{x} Z0.1\nG1 Z-1.5 F.12\nX0.5\nG28 U0 W0\nM30\n"
    assert [found for found, _, _ in said(run, text, dialect="fanuc-lathe")] == [code]


@pytest.mark.parametrize(("units", "factor"), [("mm", 1.0), ("inch", INCH)])
def test_a_unit_that_is_named_holds_until_the_program_says_another(
    run: Any, units: str, factor: float
) -> None:
    assert said(run, INCHES, units=units) == []
    path = run("F60\nG1 X2\nG21 X3\nM2\n", units=units).path
    assert path.end[:2, 0].tolist() == [2.0 * factor, 3.0]
    assert path.feed[0] == pytest.approx(factor, abs=0.0, rel=1e-15)


def test_the_machine_names_the_unit_where_no_option_does() -> None:
    assert interpreter_settings({"units": "inch"}, ReadOptions()).units == "inch"
    assert interpreter_settings({"units": "inch"}, ReadOptions(units="mm")).units == "mm"


def test_canonical_motions_begin_in_the_unit_that_is_named(calls: Any) -> None:
    """A line of 1 inch is printed in inches, as under G20."""
    named = calls("F60\nG1 X1\nM2\n", units="inch")
    assert "STRAIGHT_FEED(1.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)" in named

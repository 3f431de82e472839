"""Pictures: each kind is drawn in each format, keeps peaks when thinned, and says what it lacks."""

import sys

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.machine.record import Axis
from cncgen.report import drawing, plots
from cncgen.report.plot_data import PlotData, of_log, of_response, of_setpoints
from cncgen.servo.identification.log import AxisLog
from cncgen.servo.record import Response
from cncgen.setpoints.record import Setpoints

pytest.importorskip("matplotlib")
MAGIC = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}


def data(count=500):
    angle = np.linspace(0, 6, count)
    command = 10.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    return PlotData(
        "a circle",
        "XY",
        0.001,
        command,
        command * 0.999,
        command * 0.2,
        ("V", "V"),
        (10.0, np.nan),
        np.full(count, 0.009),
        {k: Axis(k, 250.0, 2500.0, 5e4) for k in "XY"},
        command[::100],
    )


@pytest.mark.parametrize("kind", list(plots.KINDS))
@pytest.mark.parametrize("suffix", plots.FORMATS)
def test_every_picture_in_every_format(kind, suffix, tmp_path):
    file = tmp_path / f"picture{suffix}"
    assert plots.draw(data(), [kind], str(file)) == [str(file)]
    assert file.read_bytes().startswith(MAGIC[suffix])


def test_a_folder_takes_all(tmp_path):
    files = plots.draw(data(), plots.available(data()), str(tmp_path / "pictures"))
    assert len(files) == 6


def test_limits_and_corners_are_drawn():
    figure = plots.axes(data())
    lines = [line for part in figure.axes for line in part.get_lines() if line.get_linestyle() == "--"]
    assert len(lines) == 12
    assert {abs(line.get_ydata()[0]) for line in lines} == {250.0, 2500.0, 5e4}
    marks = [line for line in plots.path(data()).axes[0].get_lines() if line.get_marker() == "o"]
    assert len(marks[0].get_xdata()) == 5


def test_the_contour_error_is_magnified_to_a_round_number():
    """0.009 mm on a path of 20 mm: a twentieth of it is 1 mm, so 111 times at most."""
    assert any(
        "contour error × 100 " in text for text in plots.path(data()).axes[0].get_legend_handles_labels()[1]
    )


def test_thinning_keeps_the_peaks():
    y = np.zeros(300_000)
    y[123_456], y[200_001] = 7.0, -9.0
    _, ((part,),) = drawing.new_figure("peaks")
    drawing.line(part, np.arange(300_000.0), y)
    shown = part.get_lines()[0].get_ydata()
    assert len(shown) <= drawing.MAX_POINTS
    assert (shown.max(), shown.min()) == (7.0, -9.0)


def test_curvature_of_a_circle_is_one_over_its_radius():
    figure = plots.curvature(data())
    assert figure.axes[0].get_lines()[0].get_ydata() == pytest.approx(np.full(498, 0.1), rel=1e-4)


@pytest.mark.parametrize("name", ["name.xyz", "v1.2"])
def test_a_name_with_a_suffix_is_a_folder_where_one_exists_or_a_slash_ends_it(tmp_path, name):
    with pytest.raises(UsageError, match="plot-format"):
        plots.draw(data(), ["path"], str(tmp_path / name))
    assert not list(tmp_path.iterdir())
    for _ in range(2):
        files = plots.draw(data(), ["path"], f"{tmp_path / name}/")
        assert files == [str(tmp_path / name / "path.png")]
    assert plots.draw(data(), ["path"], str(tmp_path / name)) == files


def test_what_is_missing_is_said(tmp_path):
    rows = np.column_stack([np.arange(50.0), np.zeros(50)])
    bare = of_setpoints([Setpoints("XY", 0.001, 0, rows)], "bare")
    assert plots.available(bare) == ["path", "feed", "axes", "curvature"]
    with pytest.raises(UsageError, match="plot-needs-response"):
        plots.draw(bare, ["force"], str(tmp_path / "x.png"))
    with pytest.raises(UsageError, match="plot-kind"):
        plots.draw(bare, ["pie"], str(tmp_path / "x.png"))
    with pytest.raises(UsageError, match="plot-format"):
        plots.save(plots.feed(bare), tmp_path / "x.gif")
    still = of_setpoints([Setpoints("XY", 0.001, 0, np.zeros((5, 2)))], "still")
    assert plots.available(still) == ["path", "feed", "axes"]
    with pytest.raises(UsageError, match="plot-empty"):
        plots.curvature(still)


def test_a_response_file_gives_its_own_contour_error():
    x = np.linspace(0.0, 5.0, 100)
    log = {
        "X": AxisLog("X", 0.001, x, x, x * 0),
        "Y": AxisLog("Y", 0.001, np.full(100, 0.02), np.zeros(100), x * 0),
    }
    assert of_log(log, "r.csv").contour == pytest.approx(np.full(100, 0.02))


def test_a_log_without_commands_is_a_fault_of_the_file():
    x = np.linspace(0.0, 5.0, 100)
    log = {"X": AxisLog("X", 0.001, x, x, x * 0), "A": AxisLog("A", 0.001, x, None, x * 0)}
    with pytest.raises(UsageError, match="no commanded positions stand beside a_deg"):
        of_log(log, "r.csv")


def test_axes_that_turn_have_no_contour_error(tmp_path):
    rows = np.linspace(0.0, 1.0, 50)[:, None]
    none = np.full(50, np.nan)
    response = Response("A", 0.001, 0, rows, rows, 0.0 * rows, ("rad/s",), rows < 0, none)
    data = of_response([response], "turning")
    assert data.contour is None
    assert plots.draw(data, ["path", "errors"], str(tmp_path)) == [
        f"{tmp_path}/{k}.png" for k in ("path", "errors")
    ]


def test_no_folder_without_a_picture(tmp_path, monkeypatch):
    """It stayed, empty, where matplotlib is missing."""
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(UsageError, match="matplotlib"):
        plots.draw(data(), ["path", "feed"], str(tmp_path / "pictures"))
    assert list(tmp_path.iterdir()) == []

"""What results show in a notebook, and the notebook of the docs, run as it stands."""

from __future__ import annotations

import re
import sys
from html import unescape
from pathlib import Path

import pytest

import cncgen
from cncgen.shown import html_of
from tests.page.conftest import Browser

ROOT = Path(__file__).resolve().parent.parent.parent
SQUARE = "G21 G90 G94 G61 F1200\nG1 X10\nY10\nX0\nY0\nM2\n"


def frame(shown: str) -> str:
    """Return the document in the frame of what a notebook shows."""
    (document,) = re.findall(r'<iframe srcdoc="([^"]*)" sandbox="allow-scripts"', shown)
    return unescape(document)


def test_a_plan_is_shown_without_being_drawn() -> None:
    plan = cncgen.plan(cncgen.read_text(SQUARE), "xy-table")
    assert '"machine":"xy-table"' in frame(plan._repr_html_() or "")
    assert len(cncgen.sample(plan).collect()) > 1000


def test_setpoints_and_responses_have_figures_a_picture_and_the_viewer() -> None:
    points = cncgen.sample(cncgen.plan(cncgen.read_text(SQUARE), "xy-table")).collect()
    shown = points._repr_html_() or ""
    assert "0.0000 to 10.0000 mm" in shown
    assert "<svg" in shown
    assert '"x_jerk_mm_s3"' in frame(shown)
    (response,) = cncgen.simulate(points, "xy-table")
    told = response._repr_html_() or ""
    largest = 1e3 * abs(response.position - response.command).max(axis=0)[0]
    assert f"<td>X: largest tracking error</td><td>{largest:.3f} µm</td>" in told
    assert '"contour_error_mm"' in frame(told)


def test_a_verdict_says_what_holds(tmp_path: Path) -> None:
    file = tmp_path / "square.nc"
    file.write_text(SQUARE)
    points = cncgen.sample(cncgen.plan(file, "xy-table")).collect()
    assert "Every limit holds" in (cncgen.judge(points, file, "xy-table")._repr_html_() or "")
    wrong = cncgen.Setpoints("XY", 0.001, 0, 3.0 * points.position)
    verdict = cncgen.judge(wrong, file, "xy-table")
    shown = verdict._repr_html_() or ""
    assert "Limits are broken" in shown
    assert shown.count("<li>") == len(verdict.breaches)


def test_what_no_room_shows_has_its_repr() -> None:
    assert html_of(object()) is None


def test_the_notebook_of_the_docs_runs() -> None:
    nbformat = pytest.importorskip("nbformat", reason="the extra cncgen[notebook] is not installed")
    nbclient = pytest.importorskip("nbclient", reason="the extra cncgen[notebook] is not installed")
    pytest.importorskip("ipykernel", reason="the extra cncgen[notebook] is not installed")
    from jupyter_client import KernelManager

    book = nbformat.read(ROOT / "docs" / "notebook.ipynb", as_version=4)
    manager = KernelManager()
    manager.kernel_spec.argv[0] = sys.executable
    client = nbclient.NotebookClient(
        book, km=manager, timeout=120, resources={"metadata": {"path": str(ROOT)}}
    )
    client.execute()
    results = [cell["outputs"][-1]["data"] for cell in book.cells if cell.cell_type == "code"]
    assert all("text/html" in data for data in results)
    framed = ["<iframe" in data["text/html"] for data in results]
    assert framed == [True, True, True, False, True]


@pytest.mark.slow
def test_the_viewer_works_in_a_frame(browser: Browser, tmp_path: Path) -> None:
    points = cncgen.sample(cncgen.plan(cncgen.read_text(SQUARE), "xy-table")).collect()
    file = tmp_path / "book.html"
    file.write_text(f"<!doctype html><meta charset=utf-8>{points._repr_html_()}", encoding="utf-8")
    browser.driver.get(file.as_uri())
    browser.driver.switch_to.frame(browser.find("iframe"))
    try:
        browser.wait("return document.documentElement.dataset.ready === 'all'")
        browser.find("[data-view=top]").click()
        assert browser.run("return cncgen.part.rows") == len(points)
        assert browser.run("return cncgen.scene.drawer !== null")
    finally:
        browser.driver.switch_to.default_content()

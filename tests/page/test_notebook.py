"""What results show in a notebook, and the notebook of the docs, run as it stands."""

from __future__ import annotations

import json
import re
import sys
import time
from html import unescape
from pathlib import Path
from typing import Any

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


@pytest.fixture(scope="module")
def book() -> Any:
    """The notebook of the docs, run."""
    nbformat = pytest.importorskip("nbformat", reason="the extra cncgen[notebook] is not installed")
    nbclient = pytest.importorskip("nbclient", reason="the extra cncgen[notebook] is not installed")
    for name in ("ipykernel", "anywidget"):
        pytest.importorskip(name, reason="the extra cncgen[notebook] is not installed")
    from jupyter_client import KernelManager

    book = nbformat.read(ROOT / "docs" / "notebook.ipynb", as_version=4)
    manager = KernelManager()
    manager.kernel_spec.argv[0] = sys.executable
    # Jupyter starts a notebook in its own folder.
    client = nbclient.NotebookClient(
        book, km=manager, timeout=120, resources={"metadata": {"path": str(ROOT / "docs")}}
    )
    client.execute()
    return book


def test_the_notebook_of_the_docs_runs(book: Any) -> None:
    *results, live = [cell["outputs"][-1]["data"] for cell in book.cells if cell.cell_type == "code"]
    assert all("text/html" in data for data in results)
    framed = ["<iframe" in data["text/html"] for data in results]
    assert framed == [True, True, True, False, True]
    assert WIDGET in live


def test_a_viewer_needs_anywidget(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cncgen.report.widget", None)
    with pytest.raises(cncgen.CncgenError, match="anywidget"):
        cncgen.viewer(cncgen.read_text(SQUARE), "xy-table")


def test_a_viewer_shows_the_machine_that_is_given() -> None:
    """With results of a plan, which have one of their own, it is refused: it was left unused without a word."""
    pytest.importorskip("anywidget", reason="the extra cncgen[notebook] is not installed")
    plan = cncgen.plan(cncgen.read_text(SQUARE), "xy-table")
    points = cncgen.sample(plan).collect()
    (response,) = cncgen.simulate(points, "xy-table")
    limits = '"limits":{"velocity":250.0,"acceleration":2450.0,"jerk":50000.0}'
    for result in (points, response):
        assert limits in cncgen.viewer(result, "xy-table").page
        assert limits not in cncgen.viewer(result).page
        with pytest.raises(cncgen.CncgenError, match="options of a plan are given"):
            cncgen.viewer(result, options=cncgen.PlanOptions())
    with pytest.raises(cncgen.CncgenError, match="there is no machine profile 'xytable'"):
        cncgen.viewer(points, "xytable")
    for planned in (plan, cncgen.report_page(cncgen.read_text(SQUARE), "xy-table")):
        with pytest.raises(cncgen.CncgenError, match="the plan to be viewed has its own"):
            cncgen.viewer(planned, "generic-mill")
        assert limits in cncgen.viewer(planned).page


#: A notebook's side of a widget, as https://anywidget.dev/en/afm/ describes it.
HOST = """<!doctype html><meta charset=utf-8><title>host</title><div id=el></div><script type=module>
const state = STATE, heard = {};
const model = {
  saved: 0,
  get: (name) => state[name],
  set(name, value) {
    const before = state[name];
    state[name] = value;
    if (value !== before) for (const call of heard[`change:${name}`] ?? []) call();
  },
  on: (event, call) => (heard[event] ??= []).push(call),
  off: (event, call) => (heard[event] = (heard[event] ?? []).filter((one) => one !== call)),
  save_changes: () => model.saved++,
};
const { default: widget } = await import(URL.createObjectURL(new Blob([state._esm], { type: "text/javascript" })));
const el = document.getElementById("el");
Object.assign(window, { model, show: () => widget.render({ model, el }), heard });
window.away = window.show();
</script>"""
WIDGET = "application/vnd.jupyter.widget-view+json"


def inside(browser: Browser, script: str) -> Any:
    """Run a script in the widget's frame."""
    with browser.frame("iframe"):
        return browser.run(script)


@pytest.mark.slow
def test_the_live_viewer_of_the_notebook(book: Any, browser: Browser, tmp_path: Path) -> None:
    """Moment, line and view go both ways; a widget that is shown again has the view that it had."""
    shown = book.cells[-1]["outputs"][-1]["data"][WIDGET]["model_id"]
    state = book.metadata["widgets"]["application/vnd.jupyter.widget-state+json"]["state"][shown]["state"]
    asked = state["t_s"]
    assert asked > 0.0
    text = json.dumps({name: state[name] for name in ("_esm", "page", "height", "view", "t_s", "line")})
    file = tmp_path / "host.html"
    file.write_text(HOST.replace("STATE", text.replace("</", "<\\/")), encoding="utf-8")
    browser.driver.get(file.as_uri())
    row = "return [cncgen.now, cncgen.part.rows, cncgen.scene.drawer !== null]"
    browser.wait("return model.get('view') !== ''")
    # The moment that Python set stands until the page says another one.
    assert browser.run("return model.get('t_s')") == pytest.approx(asked, abs=1e-3)
    line = inside(browser, "return cncgen.part.line(cncgen.now)")
    assert browser.run("return model.get('line')") == line > 0
    now, rows, drawn = inside(browser, row)
    assert (now, drawn) == (round(asked / 1e-3), True)
    # From Python to the page.
    browser.run("model.set('t_s', 1.5)")
    browser.wait("return model.get('view').includes('t=1.5')")
    assert inside(browser, row)[0] == 1500
    # From a person to Python.
    inside(browser, "cncgen.look('top'); cncgen.setColour('limit'); cncgen.seek(800)")
    browser.wait("return model.get('t_s') === 0.8")
    # The page says its view a while after it has changed, more than once as the picture turns.
    end, seen = time.monotonic() + 60.0, ["", " "]
    while seen[-1] != seen[-2] or seen[-1] != inside(browser, "return cncgen.link().slice(1)"):
        assert time.monotonic() < end, seen[-2:]
        time.sleep(0.5)
        seen.append(browser.run("return model.get('view')"))
    view = seen[-1]
    assert "c=limit" in view
    # Shown again, in another frame.
    browser.run("away(); document.getElementById('el').replaceChildren(); window.away = show()")
    look = "return document.documentElement.dataset.ready === 'all' && cncgen.link().slice(1)"
    with browser.frame("iframe"):
        browser.wait(f"return ({look.removeprefix('return ')}) === {json.dumps(view)}")
    assert browser.run("return heard['change:view'].length") == 1
    assert rows > 3000


@pytest.mark.slow
def test_the_viewer_works_in_a_frame(browser: Browser, tmp_path: Path) -> None:
    points = cncgen.sample(cncgen.plan(cncgen.read_text(SQUARE), "xy-table")).collect()
    file = tmp_path / "book.html"
    file.write_text(f"<!doctype html><meta charset=utf-8>{points._repr_html_()}", encoding="utf-8")
    browser.driver.get(file.as_uri())
    with browser.frame("iframe"):
        browser.wait("return document.documentElement.dataset.ready === 'all'")
        browser.click("[data-view=top]")
        assert browser.run("return cncgen.part.rows") == len(points)
        assert browser.run("return cncgen.scene.drawer !== null")

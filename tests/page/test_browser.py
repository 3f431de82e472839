"""The page in a browser: each control as a person uses it, numbers beside the CSV, and nothing that leaves the page."""

from __future__ import annotations

import itertools
import json
import math
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.page.conftest import Browser

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parent.parent.parent
PROGRAM = ROOT / "programs" / "bracket.nc"
SIGNALS = "vel,acc,jerk,feed,line"
#: A click and a way of the pointer, as the browser makes them of a person's hand.
DRAG = 80


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the page and the CSV of one program."""
    folder = tmp_path_factory.mktemp("page")
    for words in (
        ["report", PROGRAM, "-o", "page.html", "--compare", "feedrate=ild"],
        ["plan", PROGRAM, "-o", "plan.csv", "--signals", SIGNALS, "--summary", "plan.json"],
    ):
        command = [sys.executable, "-m", "cncgen", *map(str, words)]
        run = subprocess.run(command, cwd=folder, capture_output=True, timeout=120, check=False)
        assert run.returncode == 0, run.stderr.decode()
    return folder


@pytest.fixture(scope="module")
def csv(made: Path) -> dict[str, list[str]]:
    """The columns of the CSV as they are printed."""
    lines = (made / "plan.csv").read_text().splitlines()
    columns = zip(*(line.split(",") for line in lines[1:]), strict=True)
    return dict(zip(lines[0].split(","), map(list, columns), strict=True))


@pytest.fixture
def shown(browser: Browser, made: Path) -> Browser:
    """The browser with the page freshly opened."""
    browser.driver.set_window_size(1440, 1000)
    browser.open(made / "page.html")
    return browser


def settled(browser: Browser) -> None:
    """Wait until the picture stands, and has the size that the window gives it."""
    browser.wait(
        "const { camera, moving, pending } = cncgen.scene, canvas = document.getElementById('path');"
        "return !moving && !pending && camera.width === canvas.clientWidth && camera.height === canvas.clientHeight",
        seconds=180.0,
    )


def agrees(text: str, value: str) -> bool:
    """Tell whether a printed number is the CSV's, rounded to its last digit; whole numbers may end in zeros."""
    places = len(text.partition(".")[2])
    if places:
        return text == f"{round(float(value), places) + 0.0:.{places}f}"
    zeros = len(text) - len(text.rstrip("0")) if text.strip("-0") else 9
    return any(float(text) == round(float(value) / 10**k) * 10**k for k in range(zeros + 1))


def test_nothing_leaves_the_page_and_nothing_is_complained_of(shown: Browser) -> None:
    for option in range(shown.run("return document.querySelectorAll('#colour option').length")):
        shown.run(
            "const c = document.getElementById('colour'); c.selectedIndex = arguments[0]; c.dispatchEvent(new Event('change'))",
            option,
        )
    settled(shown)
    assert shown.requested() == []
    assert shown.complaints() == []


def test_the_page_is_complete_when_it_has_loaded(browser: Browser, made: Path) -> None:
    """Whoever takes its picture then, as a browser without a window does, sees all of it."""
    browser.driver.get("about:blank")
    browser.driver.get((made / "page.html").as_uri())
    assert browser.run("return [document.documentElement.dataset.ready, Boolean(cncgen.charts.all)]") == [
        "all",
        True,
    ]


def test_without_webgl_the_path_is_drawn_as_well(browser: Browser, made: Path) -> None:
    """The middle of a side of the outline, at its full feed, is blue as the legend has it."""
    without = "HTMLCanvasElement.prototype.getContext = ((of) => function (kind, ...how) { return kind === 'webgl2' ? null : of.call(this, kind, ...how) })(HTMLCanvasElement.prototype.getContext)"
    added = browser.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": without})
    try:
        browser.open(made / "page.html", "#c=feed")
        settled(browser)
        assert browser.run("return cncgen.scene.drawer.surface") is None
        red, _, blue, alpha = browser.run(
            "const { part, scene } = cncgen, rows = Array.from({ length: part.rows }, (_, k) => k).filter((k) => part.line(k) === 16);"
            "const k = rows[rows.length >> 1];"
            "const [x, y] = scene.camera.project(...part.points.map((one) => one[k])), r = scene.ratio;"
            "return [...scene.canvas.getContext('2d').getImageData(Math.floor(x * r), Math.floor(y * r), 1, 1).data]"
        )
        assert alpha > 200
        assert blue > red + 50
    finally:
        browser.driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", added)


def test_a_straight_line_has_the_colours_of_its_feed(browser: Browser, tmp_path: Path) -> None:
    """Its middle is at the full feed, its ends are at rest: it is drawn blue, as the legend has it, and not as its ends are.

    The lines of X and Z are of two axes and five, so that the captions of the charts are long, and the page is no wider for them.
    """
    part = tmp_path / "line.nc"
    part.write_text("G21 G90\nG0 Z-5\nG1 Z-15 F1000\nG1 X10 Y10 A10 B10\nM2\n")
    machine = tmp_path / "five.toml"
    axes = "".join(
        f"[axes.{letter}]\nmax_velocity_{unit}_s = 250.0\nmax_acceleration_{unit}_s2 = 2500.0\nmax_jerk_{unit}_s3 = 50000.0\n"
        for letter, unit in zip("xyzab", ("mm", "mm", "mm", "deg", "deg"), strict=True)
    )
    machine.write_text(f'name = "five"\nperiod_s = 0.001\nchord_tolerance_mm = 0.001\n{axes}')
    words = [sys.executable, "-m", "cncgen", "report", str(part), "-m", str(machine), "-o", "line.html"]
    subprocess.run(words, cwd=tmp_path, check=True, timeout=120, capture_output=True)
    browser.driver.set_window_size(1440, 1000)
    browser.open(tmp_path / "line.html", "#c=feed")
    settled(browser)
    # Between the points that are drawn the colour runs from one to the next.
    drawn = (
        "const { scene, colour, part } = cncgen, { rows } = scene.layers[0].fine, middle = (line) => {"
        "  const all = Array.from({ length: part.rows }, (_, k) => k).filter((k) => part.line(k) === line), row = all[all.length >> 1];"
        "  const at = rows.findIndex((one) => one > row), [a, b] = [rows[at - 1], rows[at]];"
        "  return [scene.layers[0].rapid(b), Math.min(colour.bytes[a], colour.bytes[b]) - colour.bytes[row]];"
        "}; return [2, 3, 4].map(middle)"
    )
    (rapid, _), (feed, plunge), (_, cut) = browser.run(drawn)
    assert (rapid, feed) == (1, 0)  # one straight line as well, along Z
    assert abs(plunge) <= 8
    assert abs(cut) <= 8
    size = {"width": 390, "height": 800, "deviceScaleFactor": 1, "mobile": False}
    browser.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    try:
        browser.open(tmp_path / "line.html", "#c=feed")
        settled(browser)
        assert browser.run("return document.documentElement.scrollWidth") <= 390
    finally:
        browser.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_the_hovered_line_is_the_lines_signal_at_a_hundred_places(
    shown: Browser, csv: dict[str, list[str]]
) -> None:
    """The pointer goes from place to place; the page keeps what it shows after each.

    A browser may join moves that come within one frame, so a place that was passed unheard is visited again.
    """
    from selenium.webdriver.common.action_chains import ActionChains

    # Software draws the picture here: fewer pixels take less time.
    shown.driver.set_window_size(1000, 760)
    shown.wait("return innerWidth <= 1000")
    shown.click("[data-view=top]")
    settled(shown)
    canvas = shown.find("#path")
    rows = np.random.default_rng().permutation(len(csv["line"]))[:4000].tolist()
    places = [tuple(place) for place in shown.run(_FREE_PLACES, rows)]
    left = list(dict.fromkeys(places))[:100]
    assert len(left) == 100
    shown.run(_HEAR)
    middle = [int(canvas.rect["width"] / 2), int(canvas.rect["height"] / 2)]
    while left:
        for k in range(0, len(left), 10):
            hand = ActionChains(shown.driver, duration=0)
            hand.move_to_element_with_offset(
                canvas, 2 - middle[0], 2 - middle[1]
            )  # never where it is already
            for x, y in left[k : k + 10]:
                hand.move_to_element_with_offset(canvas, x - middle[0], y - middle[1])
            hand.perform()
            # The last move of a hand is joined to no other, so each turn hears ten places at least until all are.
            shown.wait(_HEARD.format(*left[k : k + 10][-1]))
        heard = shown.run("return window.heard")
        unheard = []
        for place in left:
            told = [each for each in heard if each[0] == pytest.approx(place, abs=1.0)]
            if not told:
                unheard.append(place)
            for at, hovered, line, text, near in told:
                assert line == csv["line"][hovered]
                assert f"line {line}" in text
                assert np.hypot(near[0] - at[0], near[1] - at[1]) < 12
        left = unheard


_HEARD = "return window.heard.some(([[x, y]]) => Math.abs(x - {}) <= 1 && Math.abs(y - {}) <= 1)"
#: Pixels of rows that no control lies over, nor ends beside: the pointer's place is rounded.
_FREE_PLACES = """
const p = cncgen.part.points, box = document.getElementById('path').getBoundingClientRect();
return arguments[0].map((k) => cncgen.scene.camera.project(p[0][k], p[1][k], p[2][k]).slice(0, 2).map(Math.round))
  .filter(([x, y]) => [[-2, -2], [-2, 2], [2, -2], [2, 2]].every(([i, j]) => document.elementFromPoint(box.left + x + i, box.top + y + j)?.id === 'path'));
"""
#: Keeps where the pointer was, what the tip said then, and where the row that it named lies.
_HEAR = """
window.heard = [];
const p = cncgen.part.points, tip = document.getElementById('tip');
document.getElementById('path').addEventListener('pointermove', (event) => {
  const k = +tip.dataset.row, near = cncgen.scene.camera.project(p[0][k], p[1][k], p[2][k]);
  window.heard.push([[event.offsetX, event.offsetY], k, tip.dataset.line, tip.textContent, near]);
});
"""


def test_scrubbing_and_charts_agree_with_the_csv_to_the_printed_digit(
    shown: Browser, csv: dict[str, list[str]]
) -> None:
    shown.run("cncgen.charts.shown = new Set(cncgen.charts.all.map((p) => p.id)); cncgen.charts.rebuild()")
    seen: set[str] = set()
    for row in np.random.default_rng().integers(len(csv["line"]), size=60).tolist():
        texts = shown.run(
            "const s = document.getElementById('scrub'); s.value = arguments[0]; s.dispatchEvent(new Event('input'));"
            "for (const view of cncgen.charts.views) cncgen.charts.captioned(view);"
            "const spans = document.querySelectorAll('#readout [data-signal], #charts [data-signal]');"
            "return [...spans].map((e) => [e.dataset.signal, e.lastChild.textContent.split(' ').pop()])",
            row,
        )
        for signal, text in texts:
            if signal in csv:
                seen.add(signal)
                assert agrees(text, csv[signal][row]), (
                    f"row {row}, {signal}: {text}, in the file {csv[signal][row]}"
                )
    assert {"t_s", "x_mm", "feed_mm_s", "line", "x_vel_mm_s", "y_acc_mm_s2", "z_jerk_mm_s3"} <= seen


def test_pointer_turns_moves_and_zooms_the_path(shown: Browser) -> None:
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.keys import Keys

    canvas = shown.find("#path")
    camera = "const c = cncgen.scene.camera; return [c.azimuth, c.elevation, c.scale, ...c.centre]"
    before = shown.run(camera)
    ActionChains(shown.driver).move_to_element(canvas).click_and_hold().move_by_offset(
        DRAG, 40
    ).release().perform()
    turned = shown.run(camera)
    assert turned[0] == pytest.approx(before[0] - 0.008 * DRAG, abs=1e-6)
    assert turned[2:] == before[2:]
    ActionChains(shown.driver).key_down(Keys.SHIFT).move_to_element(canvas).click_and_hold().move_by_offset(
        DRAG, 0
    ).release().key_up(Keys.SHIFT).perform()
    moved = shown.run(camera)
    assert moved[:3] == turned[:3]
    assert np.linalg.norm(np.subtract(moved[3:], turned[3:])) == pytest.approx(DRAG / turned[2], rel=1e-6)
    ActionChains(shown.driver).scroll_from_origin(_origin(canvas), 0, -300).perform()
    shown.wait(f"return cncgen.scene.camera.scale > {1.2 * moved[2]}")
    shown.click("[data-view=fit]")
    shown.wait(f"return cncgen.scene.camera.scale < {1.2 * moved[2]}")
    for name, angles in {"top": [0, np.pi / 2], "front": [0, 0], "side": [np.pi / 2, 0]}.items():
        shown.click(f"[data-view={name}]")
        assert shown.run(
            "return [cncgen.scene.camera.azimuth, cncgen.scene.camera.elevation]"
        ) == pytest.approx(angles)


def _origin(element: Any) -> Any:
    from selenium.webdriver.common.actions.wheel_input import ScrollOrigin

    return ScrollOrigin.from_element(element)


def test_a_click_on_the_path_is_a_moment_and_on_a_line_its_path(
    shown: Browser, csv: dict[str, list[str]]
) -> None:
    lines = [int(v) for v in csv["line"]]
    wanted = max(set(lines), key=lines.count)
    field = shown.find("#search")
    field.send_keys(f":{wanted}")
    row = f".row[data-line='{wanted}']"
    assert shown.text(f"{row} .time")
    shown.click(f"{row} .code")
    shown.wait("return cncgen.scene.highlight?.rows.length > 1")
    assert lines[shown.run("return cncgen.now")] == wanted
    spans = shown.run(f"return cncgen.spansOf(0, {wanted})")
    assert sum(b - a for a, b in spans) == pytest.approx(lines.count(wanted), abs=len(spans) + 1)
    shown.click(f"{row} .code")
    shown.shows("return cncgen.scene.highlight", None)


def test_the_search_finds_what_stands_in_the_text(shown: Browser) -> None:
    from selenium.webdriver.common.keys import Keys

    text = PROGRAM.read_text().splitlines()
    expected = [k for k, line in enumerate(text, start=1) if "g1" in line.lower()]
    field = shown.find("#search")
    field.send_keys("g1")
    found = "return document.querySelector('.found').textContent"
    shown.shows(found, f"{len(expected)} found")
    field.send_keys(Keys.ENTER)
    shown.shows(found, f"1 of {len(expected)}")
    shown.click("[data-find='1']")
    shown.shows("return cncgen.source.matches", expected)
    shown.shows(found, f"2 of {len(expected)}")


def test_charts_zoom_and_lead_to_a_moment(shown: Browser) -> None:
    from selenium.webdriver.common.action_chains import ActionChains

    def chart() -> Any:
        return shown.find(".chart canvas")

    whole = shown.run("return cncgen.charts.range")
    ActionChains(shown.driver).scroll_from_origin(_origin(chart()), 0, -400).perform()
    shown.wait("return cncgen.charts.touched")
    assert shown.visible("#unzoom")
    shown.click("#unzoom")
    shown.shows("return cncgen.charts.range", whole)
    ActionChains(shown.driver).move_to_element(chart()).click_and_hold().move_by_offset(
        DRAG, 0
    ).release().perform()
    a, b = shown.run("return cncgen.charts.range")
    width = shown.run("return arguments[0].clientWidth", chart()) - 70
    assert b - a == pytest.approx(DRAG / width * (whole[1] - whole[0]), rel=0.03)
    ActionChains(shown.driver).move_to_element(chart()).click().perform()
    assert a <= shown.run("return cncgen.now * cncgen.part.period") <= b
    ActionChains(shown.driver).double_click(chart()).perform()
    shown.shows("return cncgen.charts.range", whole)
    shown.click(".picker summary")
    count = shown.count(".chart")
    shown.click("#chart-feed")
    shown.shows("return document.querySelectorAll('.chart').length", count - 1)


def test_places_lead_to_where_time_is_lost(shown: Browser, made: Path) -> None:
    shown.click("#tab-losses")
    texts = "return [...document.querySelectorAll(arguments[0])].map((e) => e.innerText)"
    buttons = shown.run(texts, "#panel-losses tbody .link")
    assert 1 <= len(buttons) <= 20
    places = shown.run("return cncgen.part.header.places")
    # The lines are those that the terminal names, also where a place is the end of one line and the start of the next.
    summary = json.loads((made / "plan.json").read_text())["slowest"]
    assert [place["line"] for place in places[: len(summary)]] == [place["line"] for place in summary]
    for button, place in zip(buttons, places, strict=True):
        assert re.fullmatch(rf"line {place['line']}(, (\d+ % along|at its (start|end)))?", button)
    shown.click("#panel-losses tbody .link", 1)
    shown.shows("return cncgen.now", round(places[1]["t_s"] / 0.001))
    assert len(set(buttons) | set(shown.run(texts, "#panel-losses tbody small"))) > len(buttons)


def test_the_first_rows_of_the_tables_stand_at_the_top(shown: Browser) -> None:
    """Where most time is lost, and what holds the motion back: as links to the place, and to the colours and the table."""
    texts = "return [...document.querySelectorAll('#answers > span:nth-child(%d) button')].map((e) => e.firstChild.data)"
    names = "return [...document.querySelectorAll('#panel-losses tbody .link')].slice(0, 3).map((e) => e.innerText)"
    shown.click("#tab-losses")
    places = shown.run("return cncgen.part.header.places")
    assert shown.run(texts % 1) == shown.run(names)
    shown.click("#tab-program")
    shown.click("#answers button", 2)
    shown.shows("return [cncgen.tab, cncgen.now]", ["losses", round(places[2]["t_s"] / 0.001)])
    # The longest times of the table of limits, standing and free motion left out.
    table = "table[aria-label='By what limits it'] tbody tr"
    limits = shown.run(
        f"return [...document.querySelectorAll(`{table}`)].map((row) => row.cells[0].innerText)"
    )
    assert shown.run(texts % 2) == [each for each in limits if each not in ("stop", "nothing")][:3]
    shown.click("#answers > span:nth-child(2) button")
    shown.shows("return [cncgen.tab, cncgen.colour.id]", ["time", "limit"])


def test_the_ranking_of_changes_is_that_of_why_and_leads_to_lines(browser: Browser, tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_text("G21 G90 G94 G17 G61\nG1 X20 F3000\nG1 Y15\nG0 X0 Y0\nM2\n")
    for words in (["report", "a.nc", "--why", "-o", "page.html"], ["why", "a.nc", "--summary", "why.json"]):
        command = [sys.executable, "-m", "cncgen", *words, "-m", "xy-table"]
        run = subprocess.run(command, cwd=tmp_path, capture_output=True, timeout=120, check=False)
        assert run.returncode == 0, run.stderr.decode()
    found = json.loads((tmp_path / "why.json").read_text())["quantities"]
    browser.driver.set_window_size(1360, 900)
    browser.open(tmp_path / "page.html")
    browser.click("#tab-time")
    table = "table[aria-label='What would shorten it']"
    cells = f"return [...document.querySelectorAll(`{table} tbody tr`)].map((row) => row.cells[0].firstChild.textContent)"
    assert browser.run(cells) == [each["name"] for each in found]
    assert browser.run(
        f"const t = document.querySelector(`{table}`); return t.scrollWidth <= t.parentElement.clientWidth"
    )
    first = browser.run(
        f"return [...document.querySelectorAll(`{table} tbody tr`)].map((row) => row.cells[2].textContent)"
    )
    kinds = {each["kind"]: text for each, text in zip(found, first, strict=True)}
    assert all(" ± " in text for kind, text in kinds.items() if kind in ("few plans", "scatter", "bend"))
    saving = [each["name"] for each in found if each["saved_s"] > 0][:3]
    answers = browser.run(
        "return [...document.querySelectorAll('#answers > span:last-child button')].map((e) => e.firstChild.data)"
    )
    assert [text.rsplit(" ", 2)[0] for text in answers] == saving
    line = found[0]["lines"][0]
    assert browser.text(f"{table} .link").startswith(f"line {line['line']}: ")
    browser.click(f"{table} .link")
    browser.shows("return cncgen.part.line(cncgen.now)", line["line"])


@pytest.mark.parametrize("tab", ["program", "losses", "time", "checks", "compare"])
def test_tabs_show_their_panel(shown: Browser, tab: str) -> None:
    shown.click(f"#tab-{tab}")
    shown.shows(
        "return [...document.querySelectorAll('.panel')].filter((e) => e.checkVisibility()).map((e) => e.id)",
        [f"panel-{tab}"],
    )
    assert shown.text(f"#panel-{tab}").strip()


#: A clock of the test's own, so that a busy machine shows the same pictures.
_CLOCK = """
const real = {now: performance.now, frame: window.requestAnimationFrame};
window.clock = {
  now: 1000, waiting: [],
  pass(ms) {
    this.now += ms;
    const due = this.waiting;
    this.waiting = [];
    for (const step of due) step(this.now);
  },
  restore() { performance.now = real.now; window.requestAnimationFrame = real.frame; },
};
performance.now = () => window.clock.now;
window.requestAnimationFrame = (step) => window.clock.waiting.push(step);
"""


def test_it_plays_in_real_time_and_faster(shown: Browser) -> None:
    """The moment shown is the time that passed, times the speed, in setpoints of 1 ms."""
    shown.run(_CLOCK)
    try:
        shown.click("#play")
        shown.shows("return document.getElementById('play').ariaLabel", "Pause")
        passed = 0.0
        for milliseconds in (16.0, 17.0, 150.5, 400.0):
            passed += milliseconds
            shown.run("clock.pass(arguments[0])", milliseconds)
            shown.shows("return cncgen.now", int(passed))
        shown.run(
            "const s = document.getElementById('speed'); s.value = '20'; s.dispatchEvent(new Event('change'))"
        )
        shown.run("clock.pass(10)")
        shown.shows("return cncgen.now", int(passed + 200))
        shown.click("#play")
        shown.run("clock.pass(1000)")
        shown.shows("return cncgen.now", int(passed + 200))
    finally:
        shown.run("clock.restore()")


def test_it_plays_to_the_end(shown: Browser) -> None:
    shown.run(
        "const s = document.getElementById('speed'); s.value = '1000'; s.dispatchEvent(new Event('change'))"
    )
    shown.click("#play")
    shown.wait("return cncgen.now === cncgen.part.rows - 1 && !cncgen.playing")


def test_keys(shown: Browser) -> None:
    from selenium.webdriver.common.keys import Keys

    body = shown.find("#path")
    body.send_keys(Keys.END)
    rows = shown.run("return cncgen.part.rows")
    shown.shows("return cncgen.now", rows - 1)
    body.send_keys(Keys.ARROW_LEFT)
    shown.shows("return cncgen.now", rows - 2)
    body.send_keys(Keys.HOME)
    body.send_keys(Keys.ARROW_RIGHT)
    shown.shows("return cncgen.now", 1)
    body.send_keys("2")
    shown.wait("return Math.abs(cncgen.scene.camera.elevation - Math.PI / 2) < 1e-6")
    theme = shown.run("return document.documentElement.dataset.theme")
    body.send_keys("t")
    shown.wait(f"return document.documentElement.dataset.theme !== {json.dumps(theme)}")
    body.send_keys("l")
    shown.shows("return cncgen.tab", "losses")
    body.send_keys("/")
    shown.shows("return document.activeElement.id", "search")
    shown.click("#help")
    assert shown.visible("#keys")
    shown.click("#keys button")
    assert not shown.visible("#keys")


def test_marks_and_colours_change_the_picture(shown: Browser) -> None:
    settled(shown)
    seen = set()
    for option in shown.run("return [...document.querySelectorAll('#colour option')].map((o) => o.value)"):
        shown.run(
            "const c = document.getElementById('colour'); c.value = arguments[0]; c.dispatchEvent(new Event('change'))",
            option,
        )
        shown.shows("return cncgen.colour.id", option)
        shown.wait("return document.getElementById('legend').children.length > 0")
        seen.add(_picture(shown))
    # The page's other plan and the grid stay; the path's colours differ.
    assert len(seen) >= shown.run("return document.querySelectorAll('#colour option').length") - 1
    shown.click(".marks summary")
    boxes = "return [...document.querySelectorAll('#marks input')].map((e) => e.checked)"
    for place, before in enumerate(shown.run(boxes)):
        shown.click("#marks input", place)
        shown.shows(f"{boxes}[{place}]", not before)


def _picture(browser: Browser) -> str:
    script = "cncgen.scene.draw(); return cncgen.scene.canvas.toDataURL()"
    return str(browser.run(script))


def test_a_changed_address_changes_the_view(shown: Browser) -> None:
    shown.run("location.hash = '#c=limit&t=2.5&p=losses&x=2,3&theme=light&m=grid'")
    shown.wait("return cncgen.now === 2500")
    state = "return [cncgen.colour.id, cncgen.tab, cncgen.charts.range, cncgen.theme, cncgen.scene.showGrid]"
    shown.shows(state, ["limit", "losses", [2, 3], "light", False])


def test_a_link_restores_the_view(shown: Browser, made: Path) -> None:
    from selenium.webdriver.common.action_chains import ActionChains

    ActionChains(shown.driver).drag_and_drop_by_offset(shown.find("#path"), 60, 25).perform()
    shown.run(
        "const c = document.getElementById('colour'); c.value = 'limit'; c.dispatchEvent(new Event('change'))"
    )
    shown.click("#tab-time")
    shown.run("cncgen.seek(777); cncgen.charts.setRange(0.5, 1.5)")
    shown.click("#share")
    link = shown.run("return location.hash")
    state = "return [cncgen.scene.camera.state(), cncgen.colour.id, cncgen.tab, cncgen.now, cncgen.charts.range, cncgen.theme]"
    before = shown.run(state)
    shown.open(made / "page.html", link)
    shown.shows(state, before)


def test_what_a_program_and_a_machine_say_stays_text(
    browser: Browser, tmp_path: Path, cncgen: Callable[..., Any]
) -> None:
    bad = "</script><img src=x onerror=\"document.title='broken'\"><script>document.title='broken'</script>"
    program = tmp_path / "a<b>&'\" é漢.nc"
    program.write_text(
        f"(MSG, {bad.replace('(', '[').replace(')', ']')})\nG21 G90 F600\nG1 X5 Y2 ; {bad} {{{{script}}}}\nX0 ; \u202e1X 0G\nM2\n",
        encoding="utf-8",
    )
    machine = (
        (ROOT / "cncgen/machine/profiles/xy-table.toml")
        .read_text()
        .replace('name = "xy-table"', f"name = '''{bad}'''")
    )
    (tmp_path / "m.toml").write_text(machine)
    run = cncgen("report", program, "-m", "m.toml", "-o", "page.html")
    assert run.returncode == 0, run.stderr.decode()
    browser.open(tmp_path / "page.html")
    assert browser.run("return document.querySelectorAll('img:not(#printed)').length") == 0
    assert browser.run("return document.title").startswith(program.name + " on </script>")
    assert bad in browser.run("return document.querySelector('.row[data-line=\"3\"] .code').textContent")
    # What is written from right to left would be shown as G0 X1.
    assert "X0 ; \ufffd1X 0G" in browser.run(
        "return document.querySelector('.row[data-line=\"4\"]').textContent"
    )
    for tab in ("losses", "time", "checks"):
        browser.click(f"#tab-{tab}")
    assert browser.run("return document.title") != "broken"
    assert browser.complaints() == []
    assert browser.requested() == []


def test_what_takes_no_time_is_said(browser: Browser, tmp_path: Path) -> None:
    """The number of tool changes, where the machine has no times: beside the parts of the time, and on a badge."""
    (tmp_path / "two.nc").write_text("G21 G90 F1000\nT1 M6\nG1 X5\nT2 M6\nG1 X0\nM2\n")
    command = [sys.executable, "-m", "cncgen", "report", "two.nc", "-m", "xy-table", "-o", "two.html"]
    subprocess.run(command, cwd=tmp_path, capture_output=True, timeout=120, check=True)
    browser.open(tmp_path / "two.html")
    text = browser.run("return document.querySelector('#badges .without').title")
    assert "2 tool changes" in text
    browser.click("#badges .without")
    assert text in browser.text("#panel-time")


def test_every_control_has_a_name(shown: Browser) -> None:
    unnamed = shown.run(
        "return [...document.querySelectorAll('button, input, select, canvas, summary, [tabindex], [role]:not([role=status])')].filter((e) =>"
        " !e.closest('[aria-hidden=true]') && !(e.getAttribute('aria-label') || e.textContent.trim() || e.labels?.[0]?.textContent.trim()))"
        ".map((e) => e.outerHTML.slice(0, 120))"
    )
    assert unnamed == []


@pytest.mark.parametrize("width", [390, 760, 1000])
def test_a_small_screen_shows_all_of_it(browser: Browser, made: Path, width: int) -> None:
    browser.driver.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": width < 700},
    )
    try:
        browser.open(made / "page.html")
        assert browser.run("return document.documentElement.scrollWidth") <= width
        assert browser.run("return document.getElementById('path').clientHeight") >= 250
        assert browser.run("return document.getElementById('play').getBoundingClientRect().right") <= width
    finally:
        browser.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


#: From above.
_PAPER = ("printed", "legend", "charts", "panel-losses", "panel-time")


def test_a_turned_screen_shows_the_whole_path(shown: Browser) -> None:
    """The path was cut off where a window became narrow, and the view of a person keeps its part of the picture."""
    corners = """const { box, camera } = cncgen.scene, out = [];
        for (const x of [0, 3]) for (const y of [1, 4]) for (const z of [2, 5]) out.push(camera.project(box[x], box[y], box[z]));
        return [camera.width, camera.height, out]"""
    for width, height in ((500, 900), (1000, 500), (1440, 1000)):
        shown.driver.set_window_size(width, height)
        settled(shown)
        wide, high, points = shown.run(corners)
        xs, ys = ([p[k] for p in points] for k in (0, 1))
        buttons, legend, canvas = shown.run(
            "return ['.views', '#legend', '#path'].map((one) => document.querySelector(one).getBoundingClientRect().toJSON())"
        )
        left, top = legend["left"] - canvas["left"], legend["top"] - canvas["top"]
        above = buttons["bottom"] - canvas["top"]
        assert min(xs) >= 0
        assert min(ys) >= above
        assert max(xs) <= wide
        assert max(ys) <= high
        assert max(xs) <= left or max(ys) <= top
        # One of both directions is filled, up to the margin of 10 %.
        filled = [(max(xs) - min(xs)) / each for each in (left, wide)]
        filled += [(max(ys) - min(ys)) / (each - above) for each in (top, high)]
        assert any(part == pytest.approx(0.9, abs=0.01) for part in filled)


def test_paper_has_tables_and_the_picture(shown: Browser) -> None:
    settled(shown)
    camera = "const c = cncgen.scene.camera; return [c.width, c.height, c.scale]"
    before = shown.run(camera)
    shown.run("dispatchEvent(new Event('beforeprint'))")
    shown.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    try:
        shown.wait("return document.getElementById('printed').naturalWidth > 100")
        for name in ("panel-losses", "panel-time", "panel-checks", "printed", "charts"):
            assert shown.visible(f"#{name}"), name
        for name in ("path", "play", "search"):
            assert not shown.visible(f"#{name}"), name
        # From above: the picture, the charts, the tables. Charts are painted in the size that they have on paper, 22 mm high.
        rects = [shown.of(f"#{name}", lambda one: one.rect) for name in _PAPER]
        for above, below in itertools.pairwise(rects):
            assert above["y"] + above["height"] <= below["y"] + 1
        # The picture has the paper's shape, not the screen's, and says what its colours mean.
        assert rects[0]["width"] / rects[0]["height"] == pytest.approx(176 / 84, rel=0.01)
        assert shown.text("#legend strong") == "Feed"
        sizes = shown.run(
            "return [...document.querySelectorAll('.chart canvas')].map((c) => [c.width / c.clientWidth, c.height / c.clientHeight])"
        )
        assert np.array(sizes) == pytest.approx(3.0, rel=0.02)
        assert shown.of(".chart", lambda one: one.rect["height"]) == pytest.approx(22 / 25.4 * 96, abs=0.5)
        assert shown.run("return getComputedStyle(document.body).color") == "rgb(17, 17, 17)"
        shown.shows("return cncgen.theme", "light")
    finally:
        shown.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    shown.run("dispatchEvent(new Event('afterprint'))")
    assert not shown.run("return document.documentElement.classList.contains('paper')")
    assert shown.run(camera) == before


def test_head_and_transport_tell_one_cycle_time(shown: Browser, made: Path) -> None:
    """The last setpoint lies up to a period after the end of the motion; the cycle time is the summary's."""
    seconds = json.loads((made / "plan.json").read_text())["cycle_time_s"]
    told = f"{int(seconds // 60)}:{seconds % 60:06.3f} min"
    shown.run("cncgen.seek(cncgen.part.rows - 1)")
    assert shown.text("#cycle") == told
    assert shown.text("#now") == f"{told} of {told}"
    assert shown.run("return document.getElementById('scrub').getAttribute('aria-valuetext')") == told


def test_a_plan_that_takes_as_long_changes_no_line(
    browser: Browser, tmp_path: Path, cncgen: Callable[..., Any]
) -> None:
    """G61 keeps the path exactly, whatever the tolerance."""
    (tmp_path / "a.nc").write_text("G21 G90 G61 F1200\nG1 X10\nY10\nM2\n")
    cncgen("report", "a.nc", "--compare", "tolerance=0.02", "-o", "page.html")
    browser.open(tmp_path / "page.html", "#p=compare")
    assert "No line takes another time." in browser.text("#panel-compare")
    assert browser.count("#panel-compare table") == 1


def test_a_long_plan_is_drawn_with_few_vertices_while_it_moves(browser: Browser, tmp_path: Path) -> None:
    """Half a million setpoints of a curve that turns all the time: each of them matters when it is looked at closely."""
    from selenium.webdriver.common.action_chains import ActionChains

    from cncgen.machine import load_machine
    from cncgen.report.page import Contents, Recording, html
    from cncgen.setpoints.record import Setpoints

    machine = load_machine("xy-table")
    t = np.arange(500_000) * 1e-3
    position = np.column_stack([40 * np.sin(1.7 * t) + np.sin(61 * t), 40 * np.cos(1.3 * t) + np.cos(67 * t)])
    recording = Recording(machine, "XY", 1e-3)
    for _ in recording.over_setpoints([Setpoints("XY", 1e-3, 0, position)]):
        pass
    page = tmp_path / "long.html"
    page.write_text(html("long", [Contents("long", machine, recording, {})]), encoding="utf-8")
    browser.open(page)
    settled(browser)
    assert browser.run("return Boolean(cncgen.worker)")
    assert browser.run("return cncgen.scene.drawer.vertices") > 300_000
    canvas = browser.find("#path")
    browser.run(
        "cncgen.most = 0; const d = cncgen.scene.draw.bind(cncgen.scene); cncgen.scene.draw = () => { d(); if (cncgen.scene.moving) cncgen.most = Math.max(cncgen.most, cncgen.scene.drawer.vertices) }"
    )
    ActionChains(browser.driver).move_to_element(canvas).click_and_hold().move_by_offset(
        30, 10
    ).move_by_offset(30, 10).release().perform()
    ActionChains(browser.driver).scroll_from_origin(_origin(canvas), 0, -500).perform()
    settled(browser)
    assert 0 < browser.run("return cncgen.most") <= 300_000


def test_a_turned_part_lies_with_z_to_the_right(
    browser: Browser, tmp_path: Path, cncgen: Callable[..., Any]
) -> None:
    """A profile without Y, at a constant surface speed: 80 mm along Z are 80 mm to the right, 20 mm of X are 20 mm up, at one scale."""
    (tmp_path / "a.nc").write_text("G21 G90 G61 G96 S200 M3\nG1 Z80 F6000\nX20\nM2\n")
    cncgen("report", "a.nc", "-o", "page.html")
    browser.open(tmp_path / "page.html")
    settled(browser)
    places = browser.run(
        "const { part, scene } = cncgen, [x, y, z] = part.points;"
        "const corner = part.row.x_mm.findIndex((v) => v > 0) - 1;"
        "return [0, corner, part.rows - 1].map((k) => scene.camera.project(x[k], y[k], z[k]))"
    )
    (x0, y0, _), (x1, y1, _), (x2, y2, _) = np.array(places) / browser.run("return cncgen.scene.camera.scale")
    assert [x1 - x0, y0 - y1, x2 - x1, y1 - y2] == pytest.approx([80.0, 0.0, 0.0, 20.0], abs=1e-2)


def test_the_part_that_is_cut_is_shown_with_what_is_wrong_with_it(
    browser: Browser, tmp_path: Path, cncgen: Callable[..., Any]
) -> None:
    """A slot of 8 mm, 3 mm deep, through 40 mm of a block; then a rapid through the block, on line 6."""
    from selenium.webdriver.common.action_chains import ActionChains

    (tmp_path / "a.nc").write_text(
        "G21 G90 G61 S1000 M3\nG0 X-10 Y15\nG1 Z-3 F3000\nX50\nG1 Y25\nG0 X-10\nM2\n"
    )
    words = ("--stock", "box:0,0,-20,40,30,0", "--tool", "*=flat:8", "--cell", "0.25")
    run = cncgen("report", "a.nc", *words, "-o", "page.html")
    assert run.returncode == 0, run.stderr.decode()
    browser.driver.set_window_size(1440, 1000)
    browser.open(tmp_path / "page.html")
    settled(browser)
    removal = browser.run("return cncgen.part.header.removal")
    # The second slot ends at Y 29, so both take their whole width.
    assert removal["removed_mm3"] == pytest.approx(2 * 40 * 8 * 3, rel=0.01)
    assert browser.run("return cncgen.scene.surface.box") == [0, 0, -20, 40, 30, 0]
    # The slots' floor is seen from above and hidden from below, where the block is before it.
    seen = "const { scene } = cncgen, [x, y, z] = [20, 15, -3]; scene.camera.elevation = arguments[0]; scene.draw(); return scene.depths().hides(scene.camera.project(x, y, z))"
    assert [browser.run(seen, angle) for angle in (1.2, -1.2)] == [False, True]
    browser.click("[data-view=iso]")
    settled(browser)
    with_part = _picture(browser)
    browser.click(".marks summary")
    browser.click("#mark-part")
    browser.shows("return cncgen.scene.showSurface", False)
    assert _picture(browser) != with_part
    browser.wait("return location.hash.includes('part')")
    browser.click("#mark-part")
    assert browser.text("#badges .bad") == "✕ 1 fault of the cut"
    browser.click("#badges .bad")
    assert "rapid" in browser.text("#panel-checks .error")
    browser.click("#panel-checks .error .link")
    browser.shows("return cncgen.part.line(cncgen.now)", 6)
    browser.run(
        "const d = cncgen.scene.drawer, f = d.fill.bind(d); cncgen.filled = 0; d.fill = (...a) => { f(...a); if (cncgen.scene.moving) cncgen.filled++ }"
    )
    ActionChains(browser.driver).drag_and_drop_by_offset(browser.find("#path"), 40, 20).perform()
    browser.wait("return cncgen.filled > 0")
    assert browser.complaints() == []


def test_a_shallow_floor_has_another_colour_than_the_top(
    browser: Browser, tmp_path: Path, cncgen: Callable[..., Any]
) -> None:
    """A slot 0.2 mm deep in a block of 20 mm: an eye tells a grey from another that is 2 % brighter (Weber's law)."""
    (tmp_path / "a.nc").write_text("G21 G90 G61 S1000 M3\nG0 X-10 Y15\nG1 Z-0.2 F3000\nX50\nG0 Z10\nM2\n")
    words = ("--stock", "box:0,0,-20,40,30,0", "--tool", "*=flat:8", "--cell", "0.25")
    assert cncgen("report", "a.nc", *words, "-o", "page.html").returncode == 0
    browser.open(tmp_path / "page.html")
    browser.click("[data-view=iso]")
    settled(browser)
    top, floor = browser.run(
        "const { scene } = cncgen, r = scene.ratio, one = document.createElement('canvas').getContext('2d'); scene.draw();"
        "return [[20, 25, 0], [20, 17, -0.2]].map((place) => { const [x, y] = scene.camera.project(...place);"
        "one.clearRect(0, 0, 1, 1); one.drawImage(scene.canvas, -Math.round(x * r), -Math.round(y * r));"
        "return [...one.getImageData(0, 0, 1, 1).data] })"
    )
    assert top[3] == floor[3] == 255
    assert all(a > 1.05 * b for a, b in zip(top[:3], floor[:3], strict=True))


def test_short_lines_are_named_and_rotary_axes_drawn(
    browser: Browser, tmp_path: Path, cncgen: Callable[..., Any]
) -> None:
    """Five waves in lines of 0.02 mm, four of which pass in a period: setpoints miss lines where time is lost."""
    lines = "".join(f"G1 X{0.02 * k:.2f} Y{math.sin(0.04 * k):.4f} A{0.01 * k:.2f}\n" for k in range(1, 800))
    (tmp_path / "a.nc").write_text(f"G21 G90 G64 P0.001 F60000\n{lines}M2\n")
    cncgen("report", "a.nc", "-o", "page.html")
    browser.open(tmp_path / "page.html")
    browser.click("#tab-losses")
    names = browser.run(
        "return [...document.querySelectorAll('#panel-losses .link')].map((e) => e.innerText)"
    )
    lines_of = browser.run("return cncgen.part.header.places.map((place) => place.line)")
    visited = browser.run(
        "return cncgen.part.header.places.map((p) => cncgen.part.stretches.visits.has(p.line))"
    )
    assert not all(visited)
    assert [re.match(r"line (\d+)", name)[1] for name in names] == [str(line) for line in lines_of]
    assert browser.run("return cncgen.charts.views[0].panel.unit") == "mm/s of the slides"
    titles = browser.run("return cncgen.charts.views.map((view) => view.panel.id)")
    assert [title for title in titles if title.endswith("deg")] == ["acc-deg", "jerk-deg"]

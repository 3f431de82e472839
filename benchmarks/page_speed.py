"""The page in numbers: its size, its first picture, the vertices of a drag, and what a report takes beside its plan.

    python -m benchmarks.page_speed              # all of it; some ten minutes, on a machine that does nothing else
    python -m benchmarks.page_speed --short      # a tenth of every program, to see that it runs

The browser is the system's Chromium without a window and without a graphics card. The stopwatch is ours: from the moment that it is
told to go to the page until a picture of its window has coloured pixels where the path belongs; the browser has shown another page
before, so that its own start is not counted; pictures are taken one after the other, so that what it says is late by one of them at
most. Beside it stand the seconds of CPU that the page's process took until
then, and the time at which the page itself says that it has drawn. Vertices are counted where the page hands them to WebGL, between a
pointer's press and its release.
"""

from __future__ import annotations

import argparse
import base64
import io
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.short_segments import FEED, spent
from tests.page.conftest import FLAGS

#: Kind, segments, feed in mm/min, and what the page may take: bytes, and seconds to its first picture.
PAGES = (
    ("butterfly", 100_000, 1200, 1_000_000, 1.5),
    ("surface", 130_000, FEED, 1_000_000, 1.5),
    ("surface", 500_000, 600, 8_000_000, 5.0),
)
#: Lines of the program whose report is measured beside its plan, and how often each is run, by turns.
LINES, RUNS = 200_000, 3
MOST_VERTICES = 300_000
MACHINE = "generic-mill"
#: The picture of the path, without what lies over its edges, in pixels of the window: x, y, width, height.
STAGE = {"x": 250, "y": 120, "width": 480, "height": 300}
#: A pixel is coloured where its channels differ by so much.
COLOURED = 60

#: Counts the vertices of each picture while a pointer is down.
COUNT = """
window.dragged = [];
let down = false, current = 0;
addEventListener("pointerdown", () => { down = true; current = 0; }, true);
addEventListener("pointerup", () => { down = false; }, true);
const gl = WebGL2RenderingContext.prototype;
const wrap = (name, count) => {
  const before = gl[name];
  gl[name] = function (...a) { current += count(a); if (down) window.dragged.push(current); return before.apply(this, a); };
};
wrap("clear", () => -current);
wrap("drawArraysInstanced", (a) => a[2] * a[3]);
wrap("drawArrays", (a) => a[2]);
wrap("drawElements", (a) => a[1]);
"""


def written(kind: str, count: int, feed: int, path: Path) -> None:
    """Write a program of `count` segments of a kind at a feed, by another process."""
    script = Path(__file__).with_name("short_segments.py")
    subprocess.run([sys.executable, str(script), kind, str(count), "--write", str(path)], check=True)
    path.write_text(path.read_text().replace(f"F{FEED}\n", f"F{feed}\n", 1))


@contextmanager
def browser() -> Iterator[Any]:
    """Yield a driver of a fresh Chromium that does not wait for pages."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    chromium, server = (
        shutil.which("chromium") or shutil.which("chromium-browser"),
        shutil.which("chromedriver"),
    )
    if chromium is None or server is None:
        raise SystemExit("there is no chromium with chromedriver here")
    options = webdriver.ChromeOptions()
    options.binary_location, options.page_load_strategy = chromium, "none"
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        for flag in (*FLAGS, f"--user-data-dir={profile}", "--window-size=1440,900"):
            options.add_argument(flag)
        driver = webdriver.Chrome(options=options, service=Service(server))
        try:
            driver.execute_cdp_cmd("Performance.enable", {})
            driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": COUNT})
            yield driver
        finally:
            driver.quit()


def arrived(driver: Any, protocol: str) -> None:
    """Wait until the browser is at a page of a protocol: a picture that is asked for while it is on its way is refused."""
    while driver.execute_script("return location.protocol") != protocol:
        pass


def shows_path(driver: Any) -> bool:
    """Tell whether the window has coloured pixels where the path belongs."""
    from matplotlib.image import imread

    # A picture of a part, or at another scale, would make the browser lay out and draw the page once more.
    shot = driver.execute_cdp_cmd("Page.captureScreenshot", {"optimizeForSpeed": True})
    left, top = STAGE["x"], STAGE["y"]
    pixels = (
        255.0
        * imread(io.BytesIO(base64.b64decode(shot["data"])), format="png")[
            top : top + STAGE["height"], left : left + STAGE["width"], :3
        ]
    )
    return bool(np.count_nonzero(np.ptp(pixels, axis=2) > COLOURED) > 20)


def cpu(driver: Any) -> float:
    """Return the seconds of CPU that the page's process has taken."""
    metrics = {m["name"]: m["value"] for m in driver.execute_cdp_cmd("Performance.getMetrics", {})["metrics"]}
    return float(metrics.get("ProcessTime", metrics.get("TaskDuration", np.nan)))


def opened(page: Path) -> dict[str, float]:
    """Open a page in a fresh browser; return the seconds to its first picture and to the rest, and the vertices of a drag."""
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By

    with browser() as driver:
        driver.get("data:text/html,<p>before")
        arrived(driver, "data:")
        shows_path(driver)
        begin = time.perf_counter()
        driver.get(page.as_uri())
        arrived(driver, "file:")
        while not shows_path(driver):
            if time.perf_counter() - begin > 300.0:
                raise SystemExit(f"{page}: no path after 300 s")
        first, worked = time.perf_counter() - begin, cpu(driver)
        while driver.execute_script("return document.documentElement.dataset.ready") != "all":
            time.sleep(0.02)
        whole = time.perf_counter() - begin
        told = driver.execute_script("return performance.getEntriesByName('path-drawn')[0].startTime / 1000")
        while driver.execute_script("return cncgen.scene.moving || cncgen.scene.pending"):
            time.sleep(0.05)
        hand = ActionChains(driver, duration=20).move_to_element(driver.find_element(By.ID, "path"))
        hand.click_and_hold()
        for k in range(20):
            hand.move_by_offset(6, 3 if k % 2 else -3)
        hand.release().perform()
        dragged = driver.execute_script("return window.dragged")
    return {"first": first, "cpu": worked, "told": told, "whole": whole, "vertices": max(dragged, default=0)}


def pages(folder: Path, part: int) -> bool:
    """Print a row for each of `PAGES`, of a part of its segments; tell whether all keep to what is asked."""
    holds = True
    print(
        f"{'page':28} {'setpoints':>10} {'bytes':>9} {'picture s':>9} {'CPU s':>6} {'told s':>6} {'all s':>6} {'vertices':>8}"
    )
    for kind, count, feed, most, seconds in PAGES:
        program, page = folder / "page.nc", folder / "page.html"
        written(kind, count // part, feed, program)
        spent("report", program, "-m", MACHINE, "-o", page)
        with open(page, encoding="utf-8") as file:
            text = file.read()
        at = text.index('id="header">') + len('id="header">')
        rows = json.loads(text[at : text.index("</script>", at)])["parts"][0]["rows"]
        size, seen = page.stat().st_size, opened(page)
        held = size <= most and seen["first"] <= seconds and 0 < seen["vertices"] <= MOST_VERTICES
        holds &= held
        print(
            f"{f'{kind}, {count // part} lines':28} {rows:10d} {size:9d} {seen['first']:9.2f} {seen['cpu']:6.2f} {seen['told']:6.2f}"
            f" {seen['whole']:6.2f} {seen['vertices']:8.0f}  {'holds' if held else f'asked: {most} bytes, {seconds} s'}",
            flush=True,
        )
    return holds


def beside_plan(folder: Path, part: int) -> bool:
    """Print what a report takes beside a plan of the same program, by turns; tell whether the ratios hold."""
    program = folder / "lines.nc"
    written("surface", LINES // part, FEED, program)
    found = {"plan": [], "report": []}
    for _ in range(RUNS):
        for name, output in (("plan", "lines.csv"), ("report", "lines.html")):
            found[name].append(spent(name, program, "-m", MACHINE, "-o", folder / output))
    plan, report = (np.min(found[name], axis=0) for name in ("plan", "report"))
    ratio = report / plan
    for name, values in (("plan", plan), ("report", report)):
        print(f"{name:8} {values[0]:8.2f} s {values[1]:8.2f} s of CPU {values[2]:8.0f} MiB")
    print(
        f"{'ratio':8} {ratio[0]:8.2f}   {ratio[1]:8.2f}          {ratio[2]:8.2f}      asked: 1.5 of the time, 2 of the memory"
    )
    return bool(ratio[0] <= 1.5 and ratio[2] <= 2.0)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--short", action="store_true", help="a tenth of every program")
    part = 10 if parser.parse_args().short else 1
    with tempfile.TemporaryDirectory() as name:
        shown = pages(Path(name), part)
        return 0 if beside_plan(Path(name), part) and shown else 1


if __name__ == "__main__":
    sys.exit(main())

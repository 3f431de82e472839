"""Pictures of the page for docs/page.md, in the Chromium that is installed: python docs/figures/page.py [NAME ...]"""

import base64
import math
import shutil
import subprocess
import sys
import tempfile
import time
from html import escape
from pathlib import Path

from selenium import webdriver

HERE = Path(__file__).resolve().parent
PROGRAMS = HERE.parent.parent / "programs"
FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--hide-scrollbars",
)
STOCK = ("--stock", "box:-20,-15,-15,100,60,0", "--tool", "1=flat:10", "--tool", "2=drill:6,118")
#: The arguments of `cncgen report` for each page.
PAGES = {
    "bracket": (f"{PROGRAMS}/bracket.nc", "--why", *STOCK),
    "butterfly": (f"{PROGRAMS}/butterfly.nc", "-m", "xy-table", "--compare", "feedrate=ild", "--why"),
    "features": (f"{PROGRAMS}/stepnc/features.stp",),
    "shaft": (f"{PROGRAMS}/stepnc/shaft.stp", "-m", "generic-lathe"),
    "surface": ("surface.nc",),
}
#: Page, link, size of the window, and medium of each picture.
PICTURES = {
    "program": ("bracket", "theme=dark&t=34.2", (1280, 800), ""),
    "losses": ("bracket", "theme=light&p=losses&c=limit&m=part", (1280, 800), ""),
    "time": ("bracket", "theme=dark&p=time&c=ratio&m=part", (1280, 800), ""),
    "checks": ("bracket", "theme=light&p=checks&c=x_jerk_mm_s3&m=part,places,corners", (1280, 800), ""),
    "compare": ("butterfly", "theme=dark&p=compare&c=contour_error_mm", (1280, 800), ""),
    "surface": ("surface", "theme=dark", (1280, 800), ""),
    "part": ("features", "theme=light&p=checks&m=corners,places,tools,rapids", (1280, 800), ""),
    "lathe": ("shaft", "theme=dark&p=losses&m=none", (1280, 800), ""),
    "small": ("bracket", "theme=light", (390, 844), ""),
    "print": ("butterfly", "", (794, 1123), "print"),
    "notebook": ("notebook", "", (1000, 1100), ""),
}


def surface() -> str:
    """Return a surface in 20,000 short lines, to and fro."""
    lines = ["G21 G90 G64 P0.01", "(START, X0 Y0 Z30)", "S12000 M3", "G0 X0 Y0 Z5", "G1 Z-3 F4000"]
    for j in range(50):
        for i in range(400) if j % 2 == 0 else reversed(range(400)):
            x, y = 0.2 * i, 0.5 * j
            z = 2.0 * math.sin(x / 9.0) * math.cos(y / 5.0) + math.exp(
                -((x - 40) ** 2 + (y - 12) ** 2) / 30.0
            )
            lines.append(f"G1 X{x:.3f} Y{y:.3f} Z{z - 3.0:.4f}")
    return "\n".join([*lines, "G0 Z30", "M2", ""])


def notebook() -> str:
    """Return the notebook of the docs, run: the source of its cells and what they show."""
    import nbclient
    import nbformat

    book = nbformat.read(HERE.parent / "notebook.ipynb", as_version=4)
    nbclient.NotebookClient(book, timeout=120, resources={"metadata": {"path": str(HERE.parent)}}).execute()
    shown = ["<!doctype html><meta charset='utf-8'><body style='font: 14px sans-serif; margin: 1em'>"]
    for cell in book.cells:
        shown.append(f"<pre style='background: #f3f5f8; padding: .6em'>{escape(cell.source)}</pre>")
        shown += [o.data["text/html"] for o in cell.get("outputs", ()) if "text/html" in o.get("data", {})]
    return "\n".join(shown)


def page(folder: Path, name: str) -> Path:
    """Write a page, unless it is there, and return its file."""
    file = folder / f"{name}.html"
    if name == "notebook":
        file.write_text(notebook(), encoding="utf-8")
    elif not file.exists():
        command = [sys.executable, "-m", "cncgen", "report", *PAGES[name], "-o", str(file)]
        subprocess.run(command, cwd=folder, check=True)
    return file


def shown(driver: webdriver.Chrome, address: str) -> None:
    """Open a page and wait until its picture stands."""
    driver.get("about:blank")
    driver.get(address)
    ready = "return document.documentElement.dataset.ready === 'all' && !cncgen.scene.moving && !cncgen.scene.pending"
    while not driver.execute_script(ready):
        time.sleep(0.1)


def main(names: list[str]) -> None:
    """Draw them, or those that are named."""
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or ""
    for flag in FLAGS:
        options.add_argument(flag)
    driver = webdriver.Chrome(
        options=options, service=webdriver.ChromeService(shutil.which("chromedriver") or "")
    )
    driver.set_page_load_timeout(60)
    try:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "surface.nc").write_text(surface())
            for name in names or PICTURES:
                what, link, (width, height), medium = PICTURES[name]
                metrics = {
                    "width": width,
                    "height": height,
                    "deviceScaleFactor": 1,
                    "mobile": width < 500,
                }
                driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
                driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
                address = page(folder, what).as_uri()
                if what == "notebook":
                    driver.get(address)
                    time.sleep(20.0)
                else:
                    shown(driver, f"{address}#{link}")
                if medium == "print":
                    driver.execute_script("dispatchEvent(new Event('beforeprint'))")
                    driver.execute_script("document.body.style.margin = '10mm'")  # as printers leave them
                    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": medium})
                time.sleep(1.0)
                shot = driver.execute_cdp_cmd("Page.captureScreenshot", {})
                (HERE / f"page-{name}.png").write_bytes(base64.b64decode(shot["data"]))
    finally:
        driver.quit()


if __name__ == "__main__":
    main(sys.argv[1:])

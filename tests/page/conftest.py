"""A browser for the page's tests: the Chromium that the system has, driven by Selenium."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--hide-scrollbars",
)


class Browser:
    """A window with one page, and what a person does with it."""

    def __init__(self, driver: Any) -> None:
        self.driver = driver

    def run(self, script: str, *arguments: object) -> Any:
        """Run a script in the page and return its value."""
        return self.driver.execute_script(script, *arguments)

    def open(self, page: Path, link: str = "") -> None:
        """Open a page and wait until all of it is decoded."""
        self.driver.get("about:blank")
        self.driver.get_log("browser")
        self.driver.get_log("performance")
        self.driver.get(page.as_uri() + link)
        self.wait("return document.documentElement.dataset.ready === 'all'")

    def wait(self, condition: str, seconds: float = 60.0) -> None:
        """Wait until a script returns true."""
        end = time.monotonic() + seconds
        while not self.run(condition):
            assert time.monotonic() < end, f"{condition}: {self.driver.get_log('browser')}"
            time.sleep(0.02)

    def shows(self, script: str, expected: object, seconds: float = 20.0) -> None:
        """Wait until a script returns a value: what a hand does is heard at the page's next frame."""
        end = time.monotonic() + seconds
        while (value := self.run(script)) != expected and time.monotonic() < end:
            time.sleep(0.02)
        assert value == expected

    def find(self, selector: str) -> Any:
        """Return the element of a CSS selector, for what the page never draws anew."""
        from selenium.webdriver.common.by import By

        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def count(self, selector: str) -> int:
        """Return how many elements a CSS selector has."""
        return int(self.run("return document.querySelectorAll(arguments[0]).length", selector))

    def of(self, selector: str, ask: Callable[[Any], Any], place: int = 0) -> Any:
        """Ask one of a selector's elements, which is looked up again where the page has drawn it anew meanwhile."""
        from selenium.common.exceptions import StaleElementReferenceException
        from selenium.webdriver.common.by import By

        end = time.monotonic() + 20.0
        while True:
            try:
                return ask(self.driver.find_elements(By.CSS_SELECTOR, selector)[place])
            except (StaleElementReferenceException, IndexError):
                assert time.monotonic() < end, f"{selector} has no element {place}"
                time.sleep(0.02)

    def click(self, selector: str, place: int = 0) -> None:
        """Click one of a selector's elements with the pointer."""
        self.of(selector, lambda element: element.click(), place)

    def text(self, selector: str, place: int = 0) -> str:
        """Return what one of a selector's elements says."""
        return str(self.of(selector, lambda element: element.text, place))

    def visible(self, selector: str, place: int = 0) -> bool:
        """Tell whether one of a selector's elements can be seen."""
        return bool(self.of(selector, lambda element: element.is_displayed(), place))

    @contextmanager
    def frame(self, selector: str) -> Iterator[None]:
        """Stay within a frame of the page."""
        self.driver.switch_to.frame(self.find(selector))
        try:
            yield
        finally:
            self.driver.switch_to.default_content()

    def requested(self) -> list[str]:
        """Return the addresses that the page asked for since it was opened, the page itself left out."""
        messages = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        sent = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
        return [url for url in sent if not url.startswith(("file:", "blob:", "data:"))]

    def complaints(self) -> list[str]:
        """Return what the browser's console says."""
        return [entry["message"] for entry in self.driver.get_log("browser")]


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """A headless Chromium with an empty profile; tests are skipped where there is none."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    server = shutil.which("chromedriver")
    if chromium is None or server is None:
        pytest.skip("there is no chromium with chromedriver here")
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for flag in (*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}", "--window-size=1440,1000"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(server))
    driver.set_script_timeout(60)
    yield Browser(driver)
    driver.quit()

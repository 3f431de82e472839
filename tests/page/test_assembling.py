"""The page as one file: self-contained, and what a program, a file or a machine is called stays text."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import shutil
import subprocess
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import pytest

from cncgen.pipeline import report_page
from cncgen.report.page.assembling import assemble, asset, bundle

Run = Callable[..., "subprocess.CompletedProcess[bytes]"]
HERE = Path(__file__).resolve().parent


class Elements(HTMLParser):
    """Collects elements with their attributes, and the text of scripts and styles."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self.within = False
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))
        self.texts.append("")
        self.within = True

    def handle_data(self, data: str) -> None:
        if self.within:
            self.texts[-1] += data

    def handle_endtag(self, tag: str) -> None:
        self.within = False

    def text_of(self, **wanted: str) -> str:
        """Return the text of the element that has these attributes."""
        (at,) = [k for k, (_, has) in enumerate(self.found) if wanted.items() <= has.items()]
        return self.texts[at]


def test_the_page_fetches_nothing(cncgen: Run, programs: Path, tmp_path: Path) -> None:
    run = cncgen("report", programs / "square_r5.nc", "-m", "xy-table", "-o", "page.html")
    assert run.returncode == 0, run.stderr.decode()
    page = Elements((tmp_path / "page.html").read_text(encoding="utf-8"))
    fetched = [
        value
        for _, has in page.found
        for name, value in has.items()
        if name in ("src", "href", "srcset", "data")
    ]
    assert fetched == []
    assert not {"link", "iframe", "object", "embed", "base"} & {tag for tag, _ in page.found}
    assert not any(name.startswith("on") or name == "style" for _, has in page.found for name in has)
    (policy,) = [
        has["content"] or "" for _, has in page.found if has.get("http-equiv") == "Content-Security-Policy"
    ]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy


def test_the_policy_names_the_script_and_the_style() -> None:
    page = Elements(assemble("t", {"parts": []}, "!!!!!"))
    (policy,) = [
        has["content"] or "" for _, has in page.found if has.get("http-equiv") == "Content-Security-Policy"
    ]
    for tag, has in page.found:
        if tag == "style" or (tag == "script" and "type" not in has):
            text = page.texts[page.found.index((tag, has))]
            assert f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'" in policy


@pytest.mark.parametrize("text", ["</script><b>", "<!--", "{{script}}", "\u2028 é 漢 \"'`$&", "\udce9"])
def test_texts_stay_texts(text: str) -> None:
    page = Elements(assemble(text, {"title": text}, "!!!!!"))
    shown = text.encode("utf-8", "replace").decode()
    assert json.loads(page.text_of(id="header")) == {"title": shown}
    assert [tag for tag, _ in page.found].count("b") == 0
    assert [tag for tag, _ in page.found].count("script") == 3


def test_scripts_can_stand_in_a_page() -> None:
    text = bundle("main.js")
    assert not re.search(r"</script|<!--", text, re.I)
    assert not re.search(r"^(import|export)\b", text, re.M)
    assert set(re.findall(r"\{\{(\w+)\}\}", asset("index.html"))) == {
        "policy", "title", "style", "header", "blob", "script",
    }  # fmt: skip


def test_the_page_says_what_is_broken_and_what_the_planner_remarks(tmp_path: Path) -> None:
    from cncgen.planner import PlanOptions

    lines = "".join(f"G1 X{k % 3} Y{k % 7} F3000\n" for k in range(1, 150))
    file = tmp_path / "a<b>.nc"
    file.write_text(f"G21 G90 G61\n{lines}M2\n")
    page = report_page(file, "xy-table", PlanOptions(feedrate="constant"))
    (part,) = json.loads(Elements(page.html).text_of(id="header"))["parts"]
    assert not part["verdict"]["holds"]
    assert {"t_s", "message", "code"} <= part["verdict"]["breaches"][0].keys()
    assert "plan-over-limits" in [item["code"] for item in part["summary"]["diagnostics"]]
    assert [item.code for item in page.remarks] == ["plan-over-limits"]
    assert "a&lt;b&gt;.nc on xy-table" in page.html


@pytest.mark.parametrize("file", sorted(path.name for path in HERE.glob("*.test.mjs")))
def test_modules(file: str) -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed: the page's modules are tested in the browser alone")
    run = subprocess.run(
        [node, "--test", str(HERE / file)], capture_output=True, text=True, timeout=120, check=False
    )
    assert run.returncode == 0, run.stdout[-3000:] + run.stderr[-2000:]

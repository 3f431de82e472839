"""The page's files as one HTML text: it includes styles, scripts and data, and a browser fetches nothing else.

Scripts are ES modules, each in a file of its own. Here each becomes a function that is called once, after the modules that it imports.
So the page needs neither a server nor a build. The page's content security policy names the hash of its only script; a text of a
program that looks like one stays text.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from functools import cache
from html import escape
from importlib import resources
from typing import Any

_IMPORT = re.compile(r'^import \{([^}]*)\} from "\./([\w-]+\.js)";\n', re.M)
_COMMENT = re.compile(r"^[ \t]*(?://[^\n]*|/\*\*.*?\*/[ \t]*)\n", re.M | re.S)
_INDENT = re.compile(r"^[ \t]+", re.M)
_EXPORT = re.compile(r"^export (?:async )?(?:function\*?|const|class|let) ([A-Za-z_$][\w$]*)", re.M)


@cache
def asset(name: str) -> str:
    """Return the text of a file of the page."""
    return resources.files("cncgen.report.page").joinpath(name).read_text(encoding="utf-8")


@cache
def bundle(entry: str) -> str:
    """Return a module with all that it imports as one script.

    Raises:
        ValueError: Modules import each other in a circle, or something stands in a form that this does not know.
    """
    order: list[str] = []
    _visit(entry, order, ())
    parts = [_wrapped(name) for name in order]
    return '"use strict";\n' + _INDENT.sub("", _COMMENT.sub("", "\n".join(parts)))


def _visit(name: str, order: list[str], above: tuple[str, ...]) -> None:
    if name in above:
        raise ValueError(f"modules import each other: {' '.join((*above, name))}")
    if name not in order:
        for _, other in _IMPORT.findall(asset(name)):
            _visit(other, order, (*above, name))
        order.append(name)


def _wrapped(name: str) -> str:
    """Return a module as a constant that holds its exports."""
    text = asset(name)
    exports = _EXPORT.findall(text)
    body = _IMPORT.sub(lambda m: f"const {{{m[1].replace(' as ', ': ')}}} = {_constant(m[2])};\n", text)
    body = re.sub(r"^export ", "", body, flags=re.M)
    if re.search(r"^import\b", body, re.M):
        raise ValueError(f"{name} has an import in a form that is not known")
    return f"const {_constant(name)} = (() => {{\n{body}\nreturn {{ {', '.join(exports)} }};\n}})();"


def _constant(name: str) -> str:
    return "$" + name.removesuffix(".js").replace("-", "_")


def assemble(title: str, header: dict[str, Any], blob: str) -> str:
    """Return the page.

    Args:
        title: Of the window.
        header: Data of the page, and the places of its streams in the blob (docs/page.md).
        blob: The streams in base 85.
    """
    script, style = bundle("main.js"), asset("style.css")
    policy = (
        f"default-src 'none'; script-src '{_hash(script)}' blob:; worker-src blob:; "
        f"style-src '{_hash(style)}'; img-src data: blob:; base-uri 'none'; form-action 'none'"
    )
    values = {
        "policy": escape(policy),
        "title": escape(title),
        "style": style,
        "header": _json(header),
        "blob": blob,
        "script": script,
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda match: values[match[1]], asset("index.html"))


def _hash(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _json(value: Any) -> str:
    """Return JSON that may stand in a script element: nothing in it begins a tag or a comment."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    # A lone surrogate stands for a byte outside UTF-8 (in a file name); it has no place in a text.
    return text.encode("utf-8", "replace").decode()

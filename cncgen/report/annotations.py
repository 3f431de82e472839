"""Diagnostics for other tools: a SARIF log, and the annotations of GitHub's workflows."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import Any
from urllib.parse import quote

from cncgen.diagnostics import Diagnostic, Severity, json_values
from cncgen.explanations import explanation

#: The levels of SARIF (2.1.0, 3.27.10) and the commands of GitHub's workflows.
_LEVELS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.NOTE: "note"}
_COMMANDS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.NOTE: "notice"}


def sarif(found: Sequence[Diagnostic], version: str) -> str:
    """Return the diagnostics of one run as a SARIF log.

    Source: OASIS, *Static Analysis Results Interchange Format (SARIF) Version 2.1.0* (2020), clauses 3.13, 3.14 and 3.27.

    Args:
        found: The diagnostics, in order.
        version: Version of the tool.
    """
    codes = list(dict.fromkeys(item.code for item in found))
    driver = {"name": "cncgen", "version": version, "rules": [_rule(code) for code in codes]}
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "results": [_result(item, codes.index(item.code)) for item in found],
    }
    log = {
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [run],
    }
    return json.dumps(log, indent=2) + "\n"


def _rule(code: str) -> dict[str, Any]:
    """Return a reportingDescriptor (3.49) of a code."""
    told = explanation(code)
    if told is None:
        return {"id": code}
    return {
        "id": code,
        "shortDescription": {"text": told.cause},
        "help": {"text": told.text()},
    }


def _result(item: Diagnostic, rule: int) -> dict[str, Any]:
    """Return a result (3.27) of a diagnostic."""
    text = f"{item.message}\n{item.hint}" if item.hint else item.message
    out: dict[str, Any] = {
        "ruleId": item.code,
        "ruleIndex": rule,
        "level": _LEVELS[item.severity],
        "message": {"text": text},
    }
    if item.span:
        region = {"startLine": item.span.line, "startColumn": item.span.column}
        if item.span.length:
            region["endColumn"] = item.span.column + item.span.length
        artifact = {"uri": quote(item.span.file.replace("\\", "/"))}
        out["locations"] = [{"physicalLocation": {"artifactLocation": artifact, "region": region}}]
    if item.values:
        out["properties"] = json_values(item.values)
    return out


def github(found: Iterable[Diagnostic]) -> str:
    """Return a workflow command a diagnostic, which GitHub shows beside the line.

    Source: GitHub Docs, "Workflow commands for GitHub Actions", setting an error message.
    """
    lines = []
    for item in found:
        place = {"title": item.code}
        if item.span:
            place = {
                "file": item.span.file,
                "line": str(item.span.line),
                "col": str(item.span.column),
            } | place
        words = ",".join(f"{key}={_escaped(value, ':,')}" for key, value in place.items())
        text = f"{item.message}\nhelp: {item.hint}" if item.hint else item.message
        lines.append(f"::{_COMMANDS[item.severity]} {words}::{_escaped(text)}\n")
    return "".join(lines)


def _escaped(text: str, more: str = "") -> str:
    """Return a text with per cent signs for what would end a command: line breaks, and within values `more`."""
    for sign in ("%", "\r", "\n", *more):
        text = text.replace(sign, f"%{ord(sign):02X}")
    return text

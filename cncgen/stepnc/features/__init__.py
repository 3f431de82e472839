"""Toolpaths of features that come without explicit ones."""

from __future__ import annotations

from cncgen.stepnc.entities import Skip
from cncgen.stepnc.model import Path, Workingstep
from cncgen.stepnc.part21 import Exchange


def make_paths(step: Workingstep, exchange: Exchange) -> tuple[Path, ...]:
    """Return the toolpaths of a workingstep's feature.

    Raises:
        Skip: always so far: no feature has a strategy yet, which is reported.
    """
    text = f"#{step.ident}: no toolpath can be made for this feature; give explicit toolpaths"
    exchange.report(step.ident, "stepnc-unsupported", text)
    raise Skip

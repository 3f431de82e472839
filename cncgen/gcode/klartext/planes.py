"""Tilted planes of Heidenhain's plain language as frames: PLANE SPATIAL, PLANE RESET, cycle 19 with A B C (TNC 640, "PLANE function").

Spatial angles turn about the machine's X (SPA), then its Y (SPB), then its Z (SPC). The rotary axes of the machine are not moved.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from cncgen.gcode.codes import affine
from cncgen.gcode.errors import BlockError

_NUMBER = r"\s*((?:[-+]\s*)?(?:Q\d+|\d++[.,]?+\d*+|[.,]\d+))"
_SPATIAL = re.compile(r"PLANE\s+SPATIAL\b(?P<rest>.*)\Z", re.IGNORECASE | re.DOTALL)
_RESET = re.compile(r"PLANE\s+RESET\b", re.IGNORECASE)
_KIND = re.compile(r"PLANE\s+(\w+)", re.IGNORECASE)
#: Functions that change no motion, or end what is never begun here.
_IDLE = re.compile(
    r"FUNCTION\s+(?:RESET\s+TCPM|MODE\s+MILL|FEED\s+DWELL\s+RESET|FEED\s+RESET|S-PULSE\s+RESET|TCPM\s+RESET)\b",
    re.IGNORECASE,
)

Evaluate = Callable[[str], float]


def idle(body: str) -> bool:
    """Tell whether a FUNCTION block changes nothing.

    Raises:
        BlockError: It is a FUNCTION that is not read.
    """
    if _IDLE.match(body):
        return True
    name = " ".join(body.upper().split()[:3])
    raise BlockError(
        "unsupported-block",
        f"{name} is not read",
        "FUNCTION",
        hint="FUNCTION RESET TCPM and FUNCTION MODE MILL are; post the program without TCPM",
    )


def spatial(body: str, value: Evaluate) -> tuple[float, float, float]:
    """Return the spatial angles of a PLANE block, zeros of PLANE RESET.

    Raises:
        BlockError: The plane is defined otherwise.
    """
    if _RESET.match(body):
        return 0.0, 0.0, 0.0
    match = _SPATIAL.match(body)
    if match is None:
        kind = _KIND.match(body)
        raise BlockError(
            "unsupported-block",
            f"PLANE {kind[1].upper() if kind else ''} is not read",
            "PLANE",
            hint="PLANE SPATIAL and PLANE RESET are",
        )
    return _angles(match["rest"], ("SPA", "SPB", "SPC"), value)


def of_cycle(rest: str, value: Evaluate) -> tuple[float, float, float]:
    """Return the angles A B C of cycle 19; an angle that is left out is 0."""
    return _angles(rest, ("A", "B", "C"), value)


def _angles(rest: str, names: tuple[str, str, str], value: Evaluate) -> tuple[float, float, float]:
    found = [re.search(rf"(?<![A-Z]){name}{_NUMBER}", rest, re.IGNORECASE) for name in names]
    a, b, c = (value(match[1]) if match else 0.0 for match in found)
    return a, b, c


def frame(angles: tuple[float, float, float]) -> affine.Frame | None:
    """Return the frame of spatial angles, None where they turn nothing."""
    if not any(angles):
        return None
    a, b, c = angles
    turned = affine.product(affine.turn(2, c), affine.product(affine.turn(1, b), affine.turn(0, a)))
    return affine.Frame(turned)

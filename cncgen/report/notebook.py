"""What a notebook shows of results: the page in a frame."""

from __future__ import annotations

from html import escape

#: Height of the frame, in pixels.
HEIGHT = 720


def framed(page: str, height: int = HEIGHT) -> str:
    """Return a whole HTML document in a frame, as a notebook shows it; nothing in it reaches the notebook."""
    style = f"width:100%;height:{height}px;border:1px solid #8884;border-radius:8px"
    return f'<iframe srcdoc="{escape(page)}" sandbox="allow-scripts" title="cncgen" style="{style}"></iframe>'

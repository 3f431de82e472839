"""The page: one HTML file on a plan, with its path, curves, source and losses; docs/page.md describes it.

streams         signals as small streams of bytes
recording       what a plan leaves behind for the page while it streams by
contents        what the page says of a plan beside its signals: figures, places, verdict, source
assembling      styles, scripts and data as one text
*.html, *.css, *.js    the page itself: a style sheet and ES modules, each with its own tests
"""

from cncgen.report.page.contents import Contents, contents, html
from cncgen.report.page.recording import SIGNALS, Recording

__all__ = ["SIGNALS", "Contents", "Recording", "contents", "html"]

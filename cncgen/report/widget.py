"""The page as a live widget of a notebook (extra ``cncgen[notebook]``): Python reads and sets its view."""

from __future__ import annotations

import anywidget
import traitlets

from cncgen.report.page.assembling import asset


class Viewer(anywidget.AnyWidget):
    """The page in a frame.

    Attributes:
        page: The whole document.
        height: Of the frame, in pixels.
        view: The part behind ``#`` in a link to the view; set, it restores that view.
        t_s: The moment, s; set, it is gone to.
        line: The line of the program at the moment; 0 before the first one.
    """

    _esm = asset("widget.js")
    page = traitlets.Unicode().tag(sync=True)
    height = traitlets.Int(720).tag(sync=True)
    view = traitlets.Unicode().tag(sync=True)
    t_s = traitlets.Float(0.0).tag(sync=True)
    line = traitlets.Int(0).tag(sync=True)

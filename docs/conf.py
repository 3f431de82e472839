"""The site: ``sphinx-build docs BUILD`` (``make docs``)."""

from __future__ import annotations

import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS))

import generate  # noqa: E402

import cncgen  # noqa: E402

generate.write_generated()

project = "cncgen"
author = "The cncgen authors"
copyright = "The cncgen authors"
release = version = cncgen.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
# Two hyphens begin an option; a dash would be another word.
smartquotes = False
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence", "deflist"]
root_doc = "index"
exclude_patterns = ["figures/*.py", "notebook.ipynb"]
html_theme = "furo"
html_title = "cncgen"
html_static_path = ["static"]
html_css_files = ["site.css"]
autodoc_member_order = "bysource"
autodoc_typehints = "description"
napoleon_use_rtype = False
# A link to a file of the repository has no page here.
suppress_warnings = ["myst.xref_missing"]

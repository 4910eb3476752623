"""Configuration of the documentation."""

import sys
from pathlib import Path

from drivegate import __version__

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

project = "drivegate"
author = "drivegate contributors"
copyright = f"2026, {author}"
version = release = __version__

extensions = ["check_catalogue", "myst_parser", "numpydoc", "sphinx.ext.autodoc", "sphinx.ext.mathjax"]
exclude_patterns = ["_build"]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

autodoc_typehints = "none"
numpydoc_show_class_members = False

html_theme = "furo"
html_title = f"drivegate {__version__}"

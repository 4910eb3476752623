"""Configuration of the documentation."""

from drivegate import __version__

project = "drivegate"
author = "drivegate contributors"
copyright = f"2026, {author}"
version = release = __version__

extensions = ["myst_parser", "numpydoc", "sphinx.ext.autodoc", "sphinx.ext.mathjax"]
exclude_patterns = ["_build"]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

autodoc_typehints = "none"
numpydoc_show_class_members = False

html_theme = "furo"
html_title = f"drivegate {__version__}"

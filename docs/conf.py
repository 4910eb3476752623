"""Configuration of the documentation, whose pages are plain Markdown that a git host shows as well."""

import re
from pathlib import Path

from sphinx.application import Sphinx

from drivegate import __version__

project = "drivegate"
author = "drivegate contributors"
copyright = f"2026, {author}"
version = release = __version__

extensions = ["myst_nb", "numpydoc", "sphinx.ext.autodoc", "sphinx.ext.mathjax"]
exclude_patterns = ["_build"]

# Notebooks are stored without outputs; each build runs them.
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_timeout = 900
nb_execution_raise_on_error = True

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

autodoc_typehints = "none"
numpydoc_show_class_members = False

html_theme = "furo"
html_title = f"drivegate {__version__}"

PAGES = re.compile(r"(?:^## ([^\n]+)\n\n)?<!-- pages -->(.*?)<!-- end of pages -->", re.DOTALL | re.MULTILINE)
"""A list of links, under its heading."""


def complete(_app: Sphinx, page: str, source: list[str]) -> None:
    """Make the trees of contents from a page's own lists of links, and read the changelog from the repository."""
    if page == "changelog":
        source[0] = (Path(__file__).parents[1] / "CHANGELOG.md").read_text(encoding="utf-8")
    listed: set[str] = set()
    for heading, part in PAGES.findall(source[0]):
        linked = [link for link in re.findall(r"\]\((\S+)\.(?:md|ipynb)\)", part) if link not in listed]
        listed.update(linked)
        if linked:
            caption = f":caption: {heading}\n" if heading else ""
            tree = "\n".join(dict.fromkeys(linked))
            source[0] += f"\n```{{toctree}}\n:hidden:\n{caption}\n{tree}\n```\n"


def setup(app: Sphinx) -> None:
    """Have every page completed as it is read."""
    app.connect("source-read", complete)

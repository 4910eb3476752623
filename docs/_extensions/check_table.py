"""The directive ``check-table``: every check of the catalogue, as the installed drivegate has it."""

from __future__ import annotations

from docutils import nodes
from docutils.parsers.rst import Directive
from sphinx.application import Sphinx

from drivegate.catalogue import CHECKS

COLUMNS = {
    "check": ("id", 1),
    "requirement": ("requirement", 5),
    "limit": ("limit", 2),
    "level": ("level", 1),
    "subject": ("subject", 1),
    "applies to": ("scenarios", 3),
    "source": ("source", 1),
}
"""For each heading, the attribute of a check and the relative width of the column."""


class CheckTable(Directive):
    """A table with one row for each check."""

    def run(self) -> list[nodes.Node]:
        """Make the table.

        Returns
        -------
        list of Node
            The table.
        """
        group = nodes.tgroup(cols=len(COLUMNS))
        group.extend(nodes.colspec(colwidth=width) for _, width in COLUMNS.values())
        rows = [[getattr(check, attribute) for attribute, _ in COLUMNS.values()] for check in CHECKS]
        group += nodes.thead("", _row(list(COLUMNS)))
        group += nodes.tbody("", *map(_row, rows))
        return [nodes.table("", group)]


def _row(texts: list[str]) -> nodes.row:
    return nodes.row("", *(nodes.entry("", nodes.paragraph(text=text)) for text in texts))


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive.

    Parameters
    ----------
    app : Sphinx
        The application.

    Returns
    -------
    dict
        What Sphinx asks of an extension.
    """
    app.add_directive("check-table", CheckTable)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

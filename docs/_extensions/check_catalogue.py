"""Directives that insert what drivegate itself knows of its checks and scenarios, so that nothing is typed twice.

``check-table``
    Every check, each with a link to its page.
``check ID``
    One check: requirement, limit, margin, source and what exercises it.
``known-faults ID``
    The faulty controllers that the self-test has for one check.
``fault-kinds``
    All of them, by kind of fault.
``near-designs``
    The correct controllers near a limit.
``fixed-scenarios``
    The scenarios that are always run.
``drawn-scenarios``
    The families that are drawn, from the docstrings of the functions that draw them.
``coverage-table``
    Every key of a scenario and every field of the nameplate: what varies it, over what range, or why nothing does.
``signal-table``
    Every field of `Sense` and `Command`: what reaches or judges it.
``joint-table``
    What is varied jointly, and which pairs are impossible.
``fact-table``
    Every fact of the paper with what covers it.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Sequence
from typing import ClassVar, TypeAlias

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from drivegate.candidates.builtin.faults.catalogue import MUTATIONS
from drivegate.candidates.builtin.faults.mutation import Mutation
from drivegate.candidates.builtin.near import NEAR_DESIGNS
from drivegate.checks.coverage import JUDGED, NOT_VARIED, SENSED, Varied, drawn_by_family, varied_keys
from drivegate.checks.traceability import DRAWN, EVERY_RUN, family_name, traced_checks, traced_facts
from drivegate.drives.kinds import DEFAULT_MOTOR
from drivegate.scenarios.covering import FACTORS, IMPOSSIBLE, covering_rows
from drivegate.scenarios.drawn.families import FAMILY_GROUPS, Family
from drivegate.scenarios.fixed import fixed_scenarios
from drivegate_cases.motor.motor import load_motor

Cell: TypeAlias = str | Sequence[nodes.Node]
"""A text, or the inline nodes of a paragraph."""

LEVELS = {
    "required": "required: a failure fails the candidate",
    "advisory": "advisory: a failure is reported and fails nobody",
}
SUBJECTS = {
    "candidate": "the candidate",
    "plant": "drivegate itself: a failure is a harness fault, with exit code 3",
}


class CheckTable(SphinxDirective):
    """A table with one row for each check."""

    def run(self) -> list[nodes.Node]:
        """Make the table.

        Returns
        -------
        list of Node
            The table.
        """
        rows: list[list[Cell]] = [
            [[self._link(row["id"])], row["requirement"], row["limit"], row["level"], row["source"]]
            for row in traced_checks()
        ]
        heads = {"check": 2, "requirement": 9, "limit": 4, "level": 2, "source": 2}
        return [_table(list(heads.values()), rows, list(heads))]

    def _link(self, check: str) -> nodes.Node:
        link = addnodes.pending_xref(
            "",
            nodes.literal(text=check),
            refdomain="std",
            reftype="doc",
            reftarget=f"/checks/{check}",
            refexplicit=True,
            refwarn=True,
            refdoc=self.env.docname,
        )
        link.source, link.line = self.get_source_info()
        return link


class CheckFacts(SphinxDirective):
    """What the catalogue says of one check."""

    required_arguments: ClassVar[int] = 1

    def run(self) -> list[nodes.Node]:
        """Make a table of two columns.

        Returns
        -------
        list of Node
            The table.

        Raises
        ------
        DirectiveError
            When there is no such check.
        """
        check = next((row for row in traced_checks() if row["id"] == self.arguments[0]), None)
        if check is None:
            raise self.error(f"there is no check {self.arguments[0]}")
        sources = "; ".join(f"{fact['id']}, {fact['title']} ({fact['where']})" for fact in check["facts"])
        rows: list[list[Cell]] = [
            [[nodes.strong(text=head)], text]
            for head, text in (
                ("Requirement", check["requirement"]),
                ("Why", check["why"]),
                ("Level", LEVELS[check["level"]]),
                ("Subject", SUBJECTS[check["subject"]]),
                ("Limit", check["limit"]),
                ("Margin", check["formula"]),
                ("Source", sources or check["source"]),
                ("Judged on", check["scenarios"]),
                ("Exercised by", ", ".join(check["families"])),
            )
        ]
        return [_table([1, 5], rows)]


class KnownFaults(SphinxDirective):
    """A list of the faulty controllers that a check must catch."""

    required_arguments: ClassVar[int] = 1

    def run(self) -> list[nodes.Node]:
        """Make the list.

        Returns
        -------
        list of Node
            The list; nothing where the self-test has none for the check.
        """
        known = [mutation for mutation in MUTATIONS.values() if mutation.check == self.arguments[0]]
        items = [
            nodes.list_item(
                "",
                nodes.paragraph(
                    "",
                    "",
                    nodes.literal(text=f"faulty:{mutation.name}"),
                    nodes.Text(f": {mutation.sentence}{_shown_by(mutation)}"),
                ),
            )
            for mutation in known
        ]
        return [nodes.bullet_list("", *items)] if items else []


class FaultKinds(SphinxDirective):
    """A table of all faulty controllers, by kind of fault."""

    def run(self) -> list[nodes.Node]:
        """Make the table.

        Returns
        -------
        list of Node
            The table.
        """
        kinds = dict.fromkeys(mutation.kind for mutation in MUTATIONS.values())
        rows: list[list[Cell]] = []
        for kind in kinds:
            names = [mutation.name for mutation in MUTATIONS.values() if mutation.kind == kind]
            rows.append([kind, str(len(names)), ", ".join(names)])
        return [_table([2, 1, 8], rows, ["kind of fault", "faults", "their names"])]


class NearDesigns(SphinxDirective):
    """A list of the correct controllers that are near a limit by design."""

    def run(self) -> list[nodes.Node]:
        """Make the list.

        Returns
        -------
        list of Node
            The list.
        """
        rows: list[list[Cell]] = [
            [[nodes.literal(text=f"near:{design.name}")], design.sentence] for design in NEAR_DESIGNS.values()
        ]
        return [_table([2, 5], rows, ["design", "what it does"])]


class FixedScenarios(SphinxDirective):
    """A table of the scenarios that are always run."""

    def run(self) -> list[nodes.Node]:
        """Make the table.

        Returns
        -------
        list of Node
            The table.
        """
        rows: list[list[Cell]] = [
            [[nodes.literal(text=scenario.name)], scenario.description]
            for scenario in fixed_scenarios(load_motor(DEFAULT_MOTOR))
        ]
        return [_table([2, 3], rows, ["scenario", "what it is"])]


class DrawnScenarios(SphinxDirective):
    """A table of the families that are drawn."""

    def run(self) -> list[nodes.Node]:
        """Make the table.

        Returns
        -------
        list of Node
            The table.
        """
        rows: list[list[Cell]] = [_family(family) for group in FAMILY_GROUPS for family in group]
        return [_table([1, 4, 2], rows, ["family", "drawn", f"exercises, beside {', '.join(EVERY_RUN)}"])]


class FactTable(SphinxDirective):
    """A table of the paper's facts and what covers each."""

    def run(self) -> list[nodes.Node]:
        """Make the table.

        Returns
        -------
        list of Node
            The table.
        """
        rows: list[list[Cell]] = []
        for fact in traced_facts():
            by = fact["covered_by"]
            tests = "; ".join(name.partition("::")[2].removeprefix("test_") for name in by["properties"])
            figures = ", ".join(by["figures"])
            cells = (fact["id"], fact["title"], ", ".join(by["checks"]), tests, figures)
            rows.append([text.replace("_", " ") for text in cells])
        return [_table([1, 3, 3, 5, 2], rows, ["fact", "stated", "checks", "tests", "figures"])]


def _shown_by(mutation: Mutation) -> str:
    return f" It takes {mutation.shown_by} to show it." if mutation.shown_by else ""


class CoverageTable(SphinxDirective):
    """A table of what the runs vary, measured on drawn scenarios."""

    def run(self) -> list[nodes.Node]:
        """Make the table.

        Returns
        -------
        list of Node
            The table.
        """
        rows: list[list[Cell]] = []
        for row in varied_keys(drawn_by_family(load_motor(DEFAULT_MOTOR))):
            where = ", ".join(row.families) if row.key not in NOT_VARIED else f"none: {NOT_VARIED[row.key]}"
            rows.append([[nodes.literal(text=row.key)], _range(row), where])
        return [_table([3, 3, 6], rows, ["key or field", "range", "varied by"])]


class SignalTable(SphinxDirective):
    """A table of the fields of `Sense` and `Command`."""

    def run(self) -> list[nodes.Node]:
        """Make the table.

        Returns
        -------
        list of Node
            The table.
        """
        rows: list[list[Cell]] = [
            [[nodes.literal(text=f"{kind}.{field}")], ", ".join(given)]
            for kind, fields in (("Sense", SENSED), ("Command", JUDGED))
            for field, given in fields.items()
        ]
        return [_table([2, 5], rows, ["field", "reached by the keys, or judged by the checks"])]


class JointTable(SphinxDirective):
    """A table of the factors that are varied jointly, and one of the pairs that are impossible."""

    def run(self) -> list[nodes.Node]:
        """Make the tables.

        Returns
        -------
        list of Node
            Both of them.
        """
        factors: list[list[Cell]] = [
            [factor, ", ".join(levels), str(sum(row[factor] != levels[0] for row in covering_rows()))]
            for factor, levels in FACTORS.items()
        ]
        pairs: list[list[Cell]] = [
            [" with ".join(f"{factor} {level}" for factor, level in sorted(pair)), reason]
            for pair, reason in IMPOSSIBLE.items()
        ]
        heads = ["factor", "levels, the plain one first", f"rows of {len(covering_rows())} that change it"]
        return [
            _table([2, 6, 2], factors, heads),
            _table([3, 4], pairs, ["impossible pair", "reason"]),
        ]


def _range(row: Varied) -> str:
    """Write the range of numbers, or all words."""
    if row.key in ("name", "description", "schema") or not row.values:
        return "–"
    if isinstance(row.values[0], str):
        return ", ".join(map(str, row.values))
    lowest, highest = (f"{value:.6g}" for value in row.values)
    return lowest if lowest == highest else f"{lowest} to {highest}"


def _family(family: Family) -> list[Cell]:
    """Take a family's words from the docstring of its function."""
    text = inspect.getdoc(family) or ""
    summary = text.partition("\n")[0].removeprefix("Draw ").rstrip(".")
    returned = re.search(r"Of scenarios ?(.*?)\.?(\n\n|\Z)", text, re.DOTALL)
    detail = "" if returned is None else " ".join(returned[1].split())
    name = family_name(family.__name__)
    return [name, f"{summary}: {detail}" if detail else summary, ", ".join(DRAWN[name])]


def _table(widths: Sequence[int], rows: Iterable[Sequence[Cell]], heads: Sequence[str] = ()) -> nodes.table:
    group = nodes.tgroup(cols=len(widths))
    group.extend(nodes.colspec(colwidth=width) for width in widths)
    if heads:
        group += nodes.thead("", _row(heads))
    group += nodes.tbody("", *map(_row, rows))
    return nodes.table("", group)


def _row(cells: Sequence[Cell]) -> nodes.row:
    return nodes.row("", *(nodes.entry("", _paragraph(cell)) for cell in cells))


def _paragraph(cell: Cell) -> nodes.paragraph:
    return nodes.paragraph(text=cell) if isinstance(cell, str) else nodes.paragraph("", "", *cell)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directives.

    Parameters
    ----------
    app : Sphinx
        The application.

    Returns
    -------
    dict
        What Sphinx requires of an extension.
    """
    app.add_directive("check-table", CheckTable)
    app.add_directive("check", CheckFacts)
    app.add_directive("known-faults", KnownFaults)
    app.add_directive("fault-kinds", FaultKinds)
    app.add_directive("near-designs", NearDesigns)
    app.add_directive("fixed-scenarios", FixedScenarios)
    app.add_directive("drawn-scenarios", DrawnScenarios)
    app.add_directive("coverage-table", CoverageTable)
    app.add_directive("signal-table", SignalTable)
    app.add_directive("joint-table", JointTable)
    app.add_directive("fact-table", FactTable)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

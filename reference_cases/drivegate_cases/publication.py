"""What the paper states, what it leaves open, and what was found on the way, as data.

The facts are numbered as everywhere in drivegate: P1 to P12. Findings are results that contradict or qualify
the paper; they are part of every reproduction report.
"""

from functools import cache
from importlib.resources import as_file, files
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from drivegate_cases.documents.document import Document, Section, read_document

_Sentence = Annotated[str, Field(min_length=1, max_length=2000)]
_CheckName = Annotated[str, Field(pattern=r"^[A-Z]{3}-[1-9]$")]
_TestName = Annotated[str, Field(pattern=r"^tests/[a-z_/]+\.py::test_[a-z0-9_]+$")]
_FigureName = Annotated[str, Field(pattern=r"^[a-z_]+$")]


class Quantity(Section):
    """A published number."""

    name: _Sentence = Field(description="what is measured")
    value: float = Field(description="the published value")
    unit: str = Field(max_length=40, description="unit of value and tolerance, empty for a pure number")
    tolerance: float | None = Field(
        default=None,
        ge=0.0,
        description="how far ours may lie from it; none for a statement that is no measurement",
    )
    bound: Literal["equal", "at_most", "at_least"] = Field(
        default="equal", description="whether the value is met by equality or is a limit"
    )

    def agrees(self, ours: float) -> bool:
        allowed = self.tolerance or 0.0
        above_lower = self.bound == "at_most" or ours >= self.value - allowed
        below_upper = self.bound == "at_least" or ours <= self.value + allowed
        return above_lower and below_upper


class Coverage(Section):
    """What would fail if a fact were not respected; every name must exist, which a test looks after."""

    checks: tuple[_CheckName, ...] = Field(default=(), description="checks whose source is the fact")
    properties: tuple[_TestName, ...] = Field(
        default=(), description="tests of the models and controllers, as file.py::test_name"
    )
    figures: tuple[_FigureName, ...] = Field(
        default=(), description="figures of the reports that reproduce what is published, as module names"
    )


class Fact(Section):
    """Something that the paper states."""

    id: str = Field(pattern=r"^P[1-9][0-9]*$", description="number of the fact")
    title: _Sentence = Field(description="a few words on the fact")
    statement: _Sentence = Field(description="the fact in our own words")
    source: _Sentence = Field(description="where in the paper it is")
    kind: Literal["check", "plant_property", "figure", "assumption"] = Field(
        description="how it is held: by a check of candidates, by a property of the plant, "
        "by a reproduced figure, or taken unchanged"
    )
    covered_by: Coverage = Field(
        default=Coverage(), description="checks, properties and figures that hold it"
    )
    cases: tuple[str, ...] = Field(
        default=(), description="scenarios, points and sweeps that belong to the fact"
    )
    quantities: tuple[Quantity, ...] = Field(default=(), description="published numbers")

    @model_validator(mode="after")
    def _check_is_named(self) -> Self:
        if self.kind == "check" and not self.covered_by.checks:
            raise ValueError(
                f"the fact '{self.id}' is held by a check, but must name it in 'covered_by.checks'"
            )
        return self


class Assumption(Section):
    """Something that the paper leaves open, and what is taken for it."""

    id: str = Field(pattern=r"^A[1-9][0-9]*$", description="number of the assumption")
    keys: tuple[str, ...] = Field(default=(), description="keys of a drive that it sets")
    statement: _Sentence = Field(description="what is assumed")
    basis: _Sentence = Field(description="what it rests on")


class Finding(Section):
    """A result that contradicts or qualifies the paper."""

    id: str = Field(pattern=r"^F[1-9][0-9]*$", description="number of the finding")
    title: _Sentence = Field(description="the finding in a few words")
    statement: _Sentence = Field(description="the finding with its numbers")
    facts: tuple[str, ...] = Field(default=(), description="facts that it bears on")
    checks: tuple[_CheckName, ...] = Field(default=(), description="checks that it bears on")


class Publication(Document):
    """All that is known of the paper: facts and open assumptions."""

    title: _Sentence = Field(description="what the facts are taken from")
    fact: tuple[Fact, ...] = Field(min_length=1, description="list of tables, one a fact")
    open: tuple[Assumption, ...] = Field(default=(), description="list of tables, one an assumption")

    @model_validator(mode="after")
    def _ids_are_unique(self) -> Self:
        _refuse_repeats([fact.id for fact in self.fact] + [assumption.id for assumption in self.open])
        return self


class Findings(Document):
    """All findings."""

    finding: tuple[Finding, ...] = Field(min_length=1, description="list of tables, one a finding")

    @model_validator(mode="after")
    def _ids_are_unique(self) -> Self:
        _refuse_repeats([entry.id for entry in self.finding])
        return self


def _refuse_repeats(ids: list[str]) -> None:
    repeated = sorted({entry for entry in ids if ids.count(entry) > 1})
    if repeated:
        raise ValueError(f"the id '{repeated[0]}' is given more than once, but must be unique")


@cache
def publication() -> Publication:
    with as_file(files("drivegate_cases") / "facts.toml") as path:
        return read_document(path, Publication)


def facts() -> tuple[Fact, ...]:
    return publication().fact


def open_assumptions() -> tuple[Assumption, ...]:
    """Take what the paper leaves open and what is assumed for it."""
    return publication().open


@cache
def findings() -> tuple[Finding, ...]:
    with as_file(files("drivegate_cases") / "findings.toml") as path:
        return read_document(path, Findings).finding

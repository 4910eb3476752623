"""The file of a campaign: candidates, cases, parameters on a grid, and how manufacture spreads the plant."""

from __future__ import annotations

from collections.abc import Mapping
from math import prod
from pathlib import Path
from typing import Annotated, Final, Literal, Self

from pydantic import Field, field_validator, model_validator

from drivegate.scenarios.parameters import GRID_KEYS, SPREADABLE
from drivegate_cases.documents.document import Document, Section, read_document
from drivegate_cases.documents.wording import nearest, one_line

MOST_RUNS: Final = 10_000_000
"""Runs of one campaign at most."""
_INTENDED_FILES = 64
_MOST_RUNS_A_FILE = 100
_Name = Annotated[str, Field(min_length=1, max_length=2000)]


class UniformSpread(Section):
    """Every value between two bounds is as likely as any other."""

    kind: Literal["uniform"] = Field(description="kind of distribution")
    lowest: float = Field(description="smallest value")
    highest: float = Field(description="greatest value")

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        _check_range(self.lowest, self.highest)
        return self


class NormalSpread(Section):
    """A normal distribution cut off at two bounds, beyond which parts are rejected in manufacture."""

    kind: Literal["normal"] = Field(description="kind of distribution")
    mean: float = Field(description="mean of the distribution before it is cut off")
    sigma: float = Field(gt=0.0, description="standard deviation before it is cut off")
    lowest: float = Field(description="smallest value")
    highest: float = Field(description="greatest value")

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        _check_range(self.lowest, self.highest)
        if not self.lowest <= self.mean <= self.highest:
            raise ValueError(
                f"the key 'mean' is {self.mean:g}, but must lie from 'lowest', {self.lowest:g}, "
                f"to 'highest', {self.highest:g}"
            )
        return self


Spread = Annotated[UniformSpread | NormalSpread, Field(discriminator="kind")]


class Campaign(Document):
    """Many runs: every candidate through every case, at every point of a grid, as often as drives are drawn."""

    name: str = Field(min_length=1, max_length=200, description="name of the campaign")
    description: str = Field(default="", max_length=2000, description="what the campaign is to show")
    seed: int = Field(default=0, ge=0, lt=2**63, description="seed of everything random in the campaign")
    candidates: tuple[_Name, ...] = Field(
        min_length=1, description="list of candidates, each as drivegate check takes it"
    )
    cases: tuple[_Name, ...] = Field(
        min_length=1, description="list of included scenarios, or of paths of files"
    )
    checks: tuple[str, ...] | None = Field(
        default=None, min_length=1, description="list of the checks that judge every run, by default all"
    )
    draws: int = Field(
        default=1, ge=1, le=MOST_RUNS, description="drives drawn for each case and point of the grid"
    )
    runs_per_file: int | None = Field(
        default=None, ge=1, le=100_000, description="runs in each file of results, which are made in one go"
    )
    grid: dict[str, tuple[float, ...]] = Field(
        default_factory=dict, description="table of parameters, each with the list of its values"
    )
    spread: dict[str, Spread] = Field(
        default_factory=dict, description="table of parameters, each with a table of its distribution"
    )

    @field_validator("candidates", "cases", "checks")
    @classmethod
    def _are_different(cls, names: tuple[str, ...] | None) -> tuple[str, ...] | None:
        for place, name in enumerate(names or ()):
            if names is not None and name in names[:place]:
                raise ValueError(f"'{one_line(name)}' is listed twice")
        return names

    @field_validator("checks")
    @classmethod
    def _are_checks(cls, names: tuple[str, ...] | None) -> tuple[str, ...] | None:
        from drivegate.studies.campaign.row import JUDGED_CHECKS

        # Of which contract the cases are is known only when they have been found.
        known = tuple(dict.fromkeys(name for checks in JUDGED_CHECKS.values() for name in checks))
        _refuse_unknown(names or (), known, "check that a campaign judges")
        return names

    @field_validator("grid")
    @classmethod
    def _is_a_grid(cls, grid: dict[str, tuple[float, ...]]) -> dict[str, tuple[float, ...]]:
        _refuse_unknown(grid, GRID_KEYS, "parameter of a grid")
        for key, values in grid.items():
            if not values:
                raise ValueError(f"the parameter '{key}' has no values")
            if len(set(values)) < len(values):
                raise ValueError(f"the parameter '{key}' has a value twice")
        return grid

    @field_validator("spread")
    @classmethod
    def _are_spreadable(cls, spread: dict[str, Spread]) -> dict[str, Spread]:
        _refuse_unknown(spread, SPREADABLE, "parameter that can be spread")
        return spread

    @model_validator(mode="after")
    def _keys_fit_together(self) -> Self:
        both = [key for key in self.spread if key in self.grid]
        if both:
            raise ValueError(
                f"the parameter '{both[0]}' is in 'grid' and in 'spread', but must be in one of them"
            )
        runs = len(self.candidates) * self.runs_per_candidate
        if runs > MOST_RUNS:
            raise ValueError(f"the campaign has {runs} runs, but must have at most {MOST_RUNS}")
        return self

    @property
    def grid_points(self) -> int:
        """Number of combinations of the grid's values, 1 without a grid."""
        return prod(len(values) for values in self.grid.values())

    @property
    def runs_per_candidate(self) -> int:
        return len(self.cases) * self.grid_points * self.draws

    @property
    def file_length(self) -> int:
        """Runs in each file: few in a small campaign, so that there is work for every processor."""
        if self.runs_per_file is not None:
            return self.runs_per_file
        runs = len(self.candidates) * self.runs_per_candidate
        return min(max(runs // _INTENDED_FILES, 1), _MOST_RUNS_A_FILE)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Parameters that differ between runs: those of the grid, then those that are drawn."""
        return (*self.grid, *self.spread)


def read_campaign(path: str | Path) -> Campaign:
    return read_document(path, Campaign)


def _check_range(lowest: float, highest: float) -> None:
    if lowest >= highest:
        raise ValueError(f"the key 'lowest' is {lowest:g}, but must be below 'highest', {highest:g}")


def _refuse_unknown(names: Mapping[str, object] | tuple[str, ...], known: tuple[str, ...], noun: str) -> None:
    for name in names:
        if name not in known:
            raise ValueError(f"'{one_line(name)}' is no {noun}, the nearest is '{nearest(name, known)}'")

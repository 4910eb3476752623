"""Comparing margins with those of an earlier result, scenario by scenario."""

from __future__ import annotations

import json
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, Literal

import numpy as np
from pydantic import BeforeValidator, ConfigDict, Field

from drivegate.checks.check import Check, JudgedRun
from drivegate.results.counterexample import resolved_scenario
from drivegate.results.document import ComparisonSection
from drivegate.results.result import RESULT_SCHEMA, alteration_of
from drivegate.results.stored import read_stored
from drivegate_cases.documents.document import Document, Section, parse_document
from drivegate_cases.documents.wording import shown_path
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

FEWEST_PAIRS: Final = 5
"""Pairs below which no test could show anything: with 4, the least p-value there is is 1/16."""
SIGNIFICANCE: Final = 0.05
"""p-value below which a loss is taken for real."""
LEAST_LOSS: Final = 0.05
"""Loss of margin, in the median, that is put up with."""


class FixedRun(Section):
    """A fixed scenario of an earlier result, and the margins that it had."""

    name: str = Field(description="name of the scenario")
    scenario: Annotated[Scenario, BeforeValidator(resolved_scenario)] = Field(
        description="table with the whole scenario"
    )
    margins: dict[str, float | None] = Field(description="table of margins by check")


class Baseline(Document):
    """What a comparison needs of an earlier result."""

    model_config = ConfigDict(extra="ignore")
    schema_current: ClassVar[int] = RESULT_SCHEMA
    kind: Literal["check"] = Field(description="kind of document")
    fixed: tuple[FixedRun, ...] = Field(description="list of fixed scenarios with their margins")
    alteration: str = Field(
        default="",
        description="how it differs from what drivegate wrote, in words that follow its name; not read",
    )


def read_baseline(path: Path) -> Baseline:
    mapping = read_stored(path)
    if mapping.get("schema") == RESULT_SCHEMA - 1:
        raise InputError(
            f"{shown_path(path)} is a result of schema {RESULT_SCHEMA - 1}, which kept no margins of single "
            "scenarios; check its candidate again for a baseline"
        )
    stated = {key: value for key, value in mapping.items() if key != "alteration"}
    read = parse_document(stated, Baseline, str(path), folder=path.parent)
    return read.model_copy(update={"alteration": alteration_of(mapping)})


def scenario_key(scenario: Mapping[str, Any]) -> str:
    """Write a scenario so that equal ones give the same text."""
    return json.dumps(scenario, sort_keys=True)


def compared(
    baseline: Baseline, runs: Iterable[JudgedRun], checks: Iterable[Check]
) -> tuple[ComparisonSection, ...]:
    now: dict[str, dict[str, float]] = {}
    for run in runs:
        margins = {margin.check: margin.value for margin in run.margins}
        now.setdefault(scenario_key(run.scenario), margins)
    then = {scenario_key(run.scenario.to_mapping()): run.margins for run in baseline.fixed}
    made = []
    for check in checks:
        if check.subject == "plant" or all(check.id not in margins for margins in then.values()):
            continue
        changes = [
            new - old
            for key, margins in then.items()
            if (old := margins.get(check.id)) is not None
            and (new := now.get(key, {}).get(check.id)) is not None
        ]
        made.append(_comparison(check, changes, baseline.alteration))
    return tuple(made)


def _comparison(check: Check, changes: Sequence[float], alteration: str) -> ComparisonSection:
    from statistics import median

    pairs, p_value = len(changes), None
    change = median(changes) if changes else None
    if change is None or pairs < FEWEST_PAIRS:
        verdict = "too few pairs"
        message = f"{pairs} scenarios have a margin in both results, but it takes {FEWEST_PAIRS} to compare"
    elif not any(changes):
        verdict, message = "no difference", f"the margins of {pairs} scenarios are the same"
    else:
        p_value = loss_by_chance(changes)
        verdict = "fail" if p_value < SIGNIFICANCE and change < -LEAST_LOSS else "pass"
        message = (
            f"the margin changed by {change:+.3g} in the median of {pairs} scenarios (p = {p_value:.3g}); a loss "
            f"above {LEAST_LOSS:g} with p below {SIGNIFICANCE:g} fails"
        )
    return ComparisonSection.model_construct(
        check=check.id,
        level=check.level,
        pairs=pairs,
        median_change=change,
        p_value=p_value,
        verdict=verdict,
        message=f"{message}; the baseline {alteration}" if alteration else message,
    )


def loss_by_chance(changes: Sequence[float]) -> float:
    """Test whether paired values have fallen, with Wilcoxon's signed ranks, exactly and also where changes are equal.

    Returns the probability that gains have at most the ranks that they have, if each change had either sign by chance.
    Pairs without a change say nothing.
    """
    changed = [change for change in changes if change != 0.0]
    ranks = _doubled_ranks([abs(change) for change in changed])
    gained = sum(rank for rank, change in zip(ranks, changed, strict=True) if change > 0.0)
    # The probability of each sum of ranks, one change after the other.
    probability = np.zeros(sum(ranks) + 1)
    probability[0] = 1.0
    for rank in ranks:
        also_gained = np.concatenate((np.zeros(rank), probability[: probability.size - rank]))
        probability = 0.5 * (probability + also_gained)
    return min(float(probability[: gained + 1].sum()), 1.0)


def _doubled_ranks(sizes: Sequence[float]) -> list[int]:
    """Rank numbers from 1; equal ones share the mean of their ranks, which is doubled to stay whole."""
    ordered = sorted(sizes)
    return [bisect_left(ordered, size) + bisect_right(ordered, size) + 1 for size in sizes]

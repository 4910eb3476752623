"""What the results of a campaign say: quantiles of margins, and how likely a violation is."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.results.proportion import CONFIDENCE, Proportion, proportion
from drivegate.studies.campaign.folder import MARGIN, CampaignFolder, columns_of
from drivegate.studies.campaign.plan import CampaignPlan
from drivegate.studies.campaign.row import FAIL, HARNESS_FAULT, PASS, UNCOUNTED

QUANTILES: Final = (0.0, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)
"""Shares of the runs whose margins are at most as large as what is reported."""
_MOST_VALUES = 4_000_000
CURVE_POINTS: Final = 200
"""Most margins of a check that are kept of its distribution, at equal shares of the runs."""


@dataclass(frozen=True)
class Shares:
    """How often something happened at each point that was chosen; over all of them only counts mean anything."""

    points: tuple[Proportion, ...]
    """At every case with every point of the grid, in their order."""

    @property
    def happened(self) -> int:
        return sum(point.happened for point in self.points)

    @property
    def runs(self) -> int:
        return sum(point.runs for point in self.points)


@dataclass(frozen=True)
class CheckStatistics:
    """What all runs say of one check of one candidate."""

    check: str
    violated: Shares
    """How often it was violated, of the runs in which it is binding."""
    advised: int
    """Runs in which it only advises, which count nowhere here."""
    quantiles: tuple[float, ...] = ()
    """Margins at `QUANTILES`; empty without runs."""
    worst_run: int | None = None
    """The run with the least margin, the first of equals; None without runs."""
    worst_margin: float | None = None
    curve: tuple[float, ...] = ()
    """All margins from the least to the greatest, or `CURVE_POINTS` of them at equal shares of the runs."""


@dataclass(frozen=True)
class CandidateStatistics:
    """What all runs say of one candidate."""

    name: str
    verdicts: dict[str, int]
    """Number of runs by verdict."""
    violated: Shares
    """How often a run did not pass, of those that were made."""
    checks: tuple[CheckStatistics, ...]
    """In the order of the catalogue; those that never applied are left out."""
    first_faults: dict[str, int] = field(default_factory=dict)
    """By kind of fault, the first run that it ended."""


def quantiles_of(margins: NDArray[np.float64]) -> tuple[float, ...]:
    if len(margins) == 0:
        return ()
    return tuple(float(value) for value in np.quantile(margins, QUANTILES, method="inverted_cdf"))


def curve_of(margins: NDArray[np.float64]) -> tuple[float, ...]:
    """Return a distribution as margins in order, the least and the greatest among them."""
    ordered = np.sort(margins)
    if len(ordered) > CURVE_POINTS:
        ordered = ordered[np.linspace(0, len(ordered) - 1, CURVE_POINTS).round().astype(np.int64)]
    return tuple(float(value) for value in ordered)


def statistics(
    plan: CampaignPlan, folder: CampaignFolder, confidence: float = CONFIDENCE
) -> tuple[CandidateStatistics, ...]:
    """Read the results of a complete campaign, one file after the other."""
    paths: list[list[Path]] = [[] for _ in plan.candidates]
    for chunk in plan.chunks():
        paths[chunk.candidate].append(folder.path_of(chunk))
    return tuple(
        _of_candidate(plan, candidate.name, own, confidence)
        for candidate, own in zip(plan.candidates, paths, strict=True)
    )


def _of_candidate(
    plan: CampaignPlan, name: str, paths: Sequence[Path], confidence: float
) -> CandidateStatistics:
    verdicts: Counter[str] = Counter()
    failed, made = [0] * len(plan.places), [0] * len(plan.places)
    faults: dict[str, int] = {}
    for table in columns_of(paths, ("run", "verdict")):
        for run, verdict in zip(*(column.to_pylist() for column in table.columns), strict=True):
            verdicts[verdict] += 1
            counted = verdict not in UNCOUNTED
            made[plan.place_of(run)] += counted
            failed[plan.place_of(run)] += counted and verdict != PASS
            if verdict == HARNESS_FAULT or (counted and verdict not in (PASS, FAIL)):
                faults.setdefault(verdict, run)
    group = max(_MOST_VALUES // plan.campaign.runs_per_candidate, 1)
    checks: list[CheckStatistics] = []
    for start in range(0, len(plan.checks), group):
        checks += _of_checks(plan, plan.checks[start : start + group], paths, confidence)
    return CandidateStatistics(
        name=name,
        verdicts=dict(sorted(verdicts.items())),
        violated=_shares(failed, made, confidence),
        checks=tuple(checks),
        first_faults=faults,
    )


def _shares(happened: Sequence[int], runs: Sequence[int], confidence: float) -> Shares:
    return Shares(tuple(proportion(*counts, confidence) for counts in zip(happened, runs, strict=True)))


def _of_checks(
    plan: CampaignPlan, checks: Sequence[str], paths: Sequence[Path], confidence: float
) -> list[CheckStatistics]:
    found: dict[str, list[NDArray[np.float64]]] = {check: [] for check in checks}
    places: dict[str, list[NDArray[np.int64]]] = {check: [] for check in checks}
    worst: dict[str, tuple[float, int]] = {}
    advised: Counter[str] = Counter()
    for table in columns_of(paths, ("run", "advisory", *(MARGIN + check for check in checks))):
        runs = table.column("run").to_numpy()
        advice = [text.split() for text in table.column("advisory").to_pylist()]
        for check in checks:
            column = table.column(MARGIN + check)
            applies = ~column.is_null().to_numpy()
            advises = np.array([check in names for names in advice], dtype=np.bool_)
            advised[check] += int(np.count_nonzero(applies & advises))
            binding = applies & ~advises
            margins = column.to_numpy()[binding]
            if len(margins):
                found[check].append(margins)
                places[check].append(plan.place_of(runs[binding]))
                least = int(margins.argmin())
                here = (float(margins[least]), int(runs[binding][least]))
                worst[check] = min(worst.get(check, here), here)
    made = []
    for check in checks:
        if found[check] or advised[check]:
            margins = np.concatenate(found[check]) if found[check] else np.empty(0)
            at = np.concatenate(places[check]) if places[check] else np.empty(0, np.int64)
            happened, made_there = (
                np.bincount(some, minlength=len(plan.places)).tolist() for some in (at[margins < 0.0], at)
            )
            violated = _shares(happened, made_there, confidence)
            quantiles, curve = quantiles_of(margins), curve_of(margins)
            margin, run = worst.get(check, (None, None))
            made.append(CheckStatistics(check, violated, advised[check], quantiles, run, margin, curve))
    return made


def plain(stated: Shares, plan: CampaignPlan) -> dict[str, Any]:
    """Write shares as plain data; where several points were chosen, each has its own probability, and all have none."""
    (first, *others) = stated.points
    several = {"points": _points(stated, plan)} if others else {}
    return {
        "violations": stated.happened,
        "runs": stated.runs,
        "probability": None if others else first.estimate,
        "interval": None if others else [first.low, first.high],
        **several,
    }


def _points(stated: Shares, plan: CampaignPlan) -> list[dict[str, Any]]:
    return [
        {
            "case": case,
            "parameters": parameters,
            "violations": point.happened,
            "runs": point.runs,
            "probability": point.estimate,
            "interval": [point.low, point.high],
        }
        for (case, parameters), point in zip(plan.places, stated.points, strict=True)
    ]

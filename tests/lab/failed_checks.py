"""The checks that a candidate fails in a run."""

from __future__ import annotations

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.drives.running import recorded
from drivegate_cases.scenario.scenario import Scenario


def failed_checks(name: str, *runs: Scenario) -> frozenset[str]:
    """Return the checks that a candidate fails in any of some runs."""
    loaded = own_candidate(resolve_candidate(name))
    return frozenset(
        margin.check
        for run in runs
        for margin in judged(
            recorded(loaded, run, loaded.controller()), contract_of(run.drive).checks
        ).margins
        if not margin.met
    )

"""Runs on the kind of drive that a scenario names."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from drivegate.checks.record import Record
from drivegate.containment.messages import AnyController, JudgedCandidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.current.run import run_in_closed_loop
from drivegate.drives.choice import require_contract
from drivegate.drives.kinds import kind_of
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.loop.closed_loop import ClosedLoopRun


def run_scenario(
    scenario: Scenario,
    controller: AnyController,
    *,
    power_window: float = 0.0,
    trace_every: int = 0,
    kept: NDArray[Any] | None = None,
) -> ClosedLoopRun:
    """Reset a controller and run it through a scenario."""
    return run_in_closed_loop(
        kind_of(scenario.drive).prepare_loop(),
        scenario,
        controller,
        power_window=power_window,
        trace_every=trace_every,
        kept=kept,
    )


def recorded(
    loaded: JudgedCandidate,
    scenario: Scenario,
    controller: AnyController,
    *,
    trace_every: int = 0,
    kept: NDArray[Any] | None = None,
) -> Record:
    """Run a candidate through a scenario for the checks, observed as its declaration requires."""
    require_contract(loaded.candidate, scenario.drive)
    kind = kind_of(scenario.drive)
    return contract_of(scenario.drive).record(
        kind.prepare_loop(),
        loaded.candidate.declaration,
        scenario,
        controller,
        trace_every=trace_every,
        kept=kept,
    )

"""Runs on the drive that a scenario's motor belongs to."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drivegate.candidates.controller import Controller
from drivegate.containment.messages import LoadedCandidate
from drivegate.drives.kinds import kind_of
from drivegate.runs.record import RunRecord
from drivegate.runs.scenario import run_in_closed_loop
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.loop.closed_loop import ClosedLoopRun

if TYPE_CHECKING:
    from drivegate.containment.shared_progress import SharedProgress


def run_scenario(
    scenario: Scenario,
    controller: Controller,
    *,
    progress: SharedProgress | None = None,
    power_window: float = 0.0,
    trace_every: int = 0,
) -> ClosedLoopRun:
    """Reset a controller and run it through a scenario."""
    return run_in_closed_loop(
        kind_of(scenario.motor).closed_loop(),
        scenario,
        controller,
        progress=progress,
        power_window=power_window,
        trace_every=trace_every,
    )


def recorded(
    loaded: LoadedCandidate, scenario: Scenario, controller: Controller, *, trace_every: int = 0
) -> RunRecord:
    """Run a candidate through a scenario for the checks, observed as its declaration requires."""
    declaration = loaded.candidate.declaration
    run = run_scenario(
        scenario,
        controller,
        progress=loaded.progress,
        trace_every=trace_every,
        power_window=declaration.power_window_s,
    )
    return RunRecord(scenario, run, declaration)

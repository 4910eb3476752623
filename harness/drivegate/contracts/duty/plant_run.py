"""A run on a PM AC drive: nothing but the scenario and what answers it."""

from __future__ import annotations

from drivegate.containment.messages import AnyController
from drivegate.containment.playback import Wrap
from drivegate.contracts.duty.run import DutyClosedLoopRun, PrepareDutyLoop, run_duty
from drivegate.contracts.duty.sensing import duty_failure, duty_sensors
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.pm_ac.loop_records import TRACE


def duty_run(
    prepare: PrepareDutyLoop, scenario: Scenario, controller: AnyController, wrap: Wrap | None = None
) -> DutyClosedLoopRun:
    """Reset a controller and run it through a scenario, once."""
    return run_duty(
        prepare, TRACE, scenario, controller, duty_sensors(scenario), duty_failure(scenario), wrap
    )

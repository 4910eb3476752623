"""A run on a PM AC drive: nothing but the scenario and what answers it."""

from __future__ import annotations

from drivegate.containment.messages import AnyController
from drivegate.contracts.duty.run import DutyClosedLoopRun, run_duty
from drivegate.contracts.duty.sensing import duty_failure, duty_sensors
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.pm_ac.closed_loop import prepared_duty_loop
from drivegate_models.pm_ac.loop_records import TRACE


def duty_run(scenario: Scenario, controller: AnyController) -> DutyClosedLoopRun:
    """Reset a controller and run it through a scenario, once."""
    return run_duty(
        prepared_duty_loop, TRACE, scenario, controller, duty_sensors(scenario), duty_failure(scenario)
    )

"""What a controller of current reference and advance angle sensed in a run, next to what was true."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.contract import Columns
from drivegate.contracts.given_steps import sensed_phases
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.layout import CURRENT
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.loop.step_recording import row_layout
from drivegate_models.units import RPM


def empty_steps(scenario: Scenario, every: int) -> NDArray[Any]:
    """Return empty rows for what a controller senses and answers in every n-th step of a run."""
    return np.zeros(-(-scenario.control_periods // every), row_layout(CURRENT, scenario.drive.machine.phases))


def sensed_signals(_scenario: Scenario, run: ClosedLoopRun, steps: NDArray[Any]) -> Columns:
    """Return what was sensed, one row for each row of the trace; without speed and supply if they were exact."""
    sense = steps["sense"][: len(run.trace)]
    columns = {
        **sensed_phases(steps["currents"][: len(run.trace)]),
        "sensed_current_sum_a": sense["current_magnitude_sum"],
    }
    for name, field, true, factor in (
        ("sensed_speed_rpm", "speed", "speed_rpm", RPM),
        ("sensed_half_supply_v", "half_supply_voltage", "half_supply_v", 1.0),
    ):
        if not np.array_equal(factor * sense[field], run.trace[true]):
            columns[name] = factor * sense[field]
    return columns

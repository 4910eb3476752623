"""What a controller of duty ratios sensed in a run, next to what was true."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.contract import Columns
from drivegate.contracts.duty.run import DutyClosedLoopRun
from drivegate.contracts.given_steps import sensed_phases
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.layout import DUTY
from drivegate_models.loop.step_recording import row_layout
from drivegate_models.machine.rotor_frame import rotor_currents
from drivegate_models.units import RPM

MOST_STEPS: Final = 200_000
"""Greatest number of steps that are kept of a run; of a longer one, every n-th is."""
_TURN: Final = 2.0 * math.pi
_SAME: Final = 1e-9


def empty_steps(scenario: Scenario) -> NDArray[Any]:
    """Return empty rows for what a controller senses and answers in a run."""
    every = -(-scenario.control_periods // MOST_STEPS)
    return np.zeros(-(-scenario.control_periods // every), row_layout(DUTY, scenario.drive.machine.phases))


def sensed_signals(scenario: Scenario, run: DutyClosedLoopRun, steps: NDArray[Any]) -> Columns:
    """Return what was sensed, one row for each control period; without the errors of what was exact."""
    count = len(run.trace)
    steps = np.repeat(steps, -(-count // len(steps)))[:count]
    sense, currents = steps["sense"], np.ascontiguousarray(steps["currents"])
    electrical = scenario.drive.machine.pole_pairs * sense["angle"]
    frame = rotor_currents(currents, electrical)
    error = np.degrees(np.mod(electrical - run.column("angle") + math.pi, _TURN) - math.pi)
    columns = {
        **sensed_phases(currents),
        "sensed_shaft_angle_deg": np.degrees(sense["angle"]),
        "sensed_direct_current_a": frame[:, 0],
        "sensed_quadrature_current_a": frame[:, 1],
    }
    if np.any(np.abs(error) > _SAME):
        columns["sensed_angle_error_deg"] = error
    for name, field, true, factor in (
        ("sensed_speed_rpm", "speed", "speed", RPM),
        ("sensed_link_voltage_v", "supply_voltage", "link", 1.0),
    ):
        if not np.array_equal(sense[field], run.column(true)):
            columns[name] = factor * sense[field]
    return columns

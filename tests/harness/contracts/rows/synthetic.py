"""Runs that no plant made: signals written down for a scenario, judged by rows."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.checks.check import Record
from drivegate.checks.margin import Margin
from drivegate.contracts.catalogue import contract_named
from drivegate.contracts.duty.run import DUTY_RATIOS, DutyClosedLoopRun
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.contracts.rows.judging import margin_of
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.requirements.row import Row
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.pm_ac.loop_records import TRACE
from drivegate_models.units import RPM

INTERIOR = load_drive("pm-ac-interior").replaced(settling_s=0.1)
assert isinstance(INTERIOR, PmAcDocument)
DUTY = contract_named("duty")
CONTRACT: Any = SimpleNamespace(
    signal=lambda run, name: run[name],
    signal_names=DUTY.signal_names,
    settled_until=DUTY.settled_until,
    recorded_names=DUTY.recorded_names,
)
"""A contract whose runs are their signals."""


def row(**keys: Any) -> Row:
    usual = {"id": "REQ-1", "text": "What is required.", "quantity": "speed_rpm"}
    return Row.model_validate({**usual, **keys})


def times_of(scenario: Scenario) -> NDArray[np.float64]:
    return np.arange(scenario.control_periods) * scenario.control_period_s


def record_of(scenario: Scenario, **signals: Any) -> Record:
    """Make the record of a run with some signals, each an array or a number; all others are 0."""
    time = times_of(scenario)
    columns = {name: np.zeros(len(time)) for name in DUTY.signal_names}
    columns["link_voltage_v"] += 48.0
    columns |= {
        name: np.broadcast_to(np.asarray(values, float), time.shape) for name, values in signals.items()
    }
    columns["time_s"] = time
    run: Any = columns
    return Record(scenario, run, NOTHING_DECLARED)


def judged(one: Row, scenario: Scenario, **signals: Any) -> Margin | None:
    return margin_of(one, CONTRACT, record_of(scenario, **signals))


HELD_AT_SPEED = torque_scenario(INTERIOR, 1000.0, (1.0,))


def record_with_run(scenario: Scenario, shaft_w: float, given_w: float) -> Record:
    """Make the record of a run of duty ratios with constant powers at the shaft and from the link."""
    steps = scenario.control_periods
    speed = 1000.0 / RPM
    values = {"time": times_of(scenario), "speed": speed, "torque": shaft_w / speed, "input_power": given_w}
    trace = np.zeros((steps, len(TRACE)))
    for name, value in values.items():
        trace[:, TRACE.index(name)] = value
    commands = np.zeros(steps, [(name, np.float64) for name in DUTY_RATIOS])
    run: Any = DutyClosedLoopRun(TRACE, trace, commands, np.zeros(1), 0.0, np.zeros(1), 0)
    return Record(scenario, run, NOTHING_DECLARED)

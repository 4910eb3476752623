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
from drivegate.contracts.rows.judging import margin_of
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.requirements.row import Row
from drivegate_cases.scenario.scenario import Scenario

INTERIOR = load_drive("pm-ac-interior").replaced(settling_s=0.1)
DUTY = contract_named("duty")
CONTRACT: Any = SimpleNamespace(
    signals=lambda run: run, settled_until=DUTY.settled_until, recorded_names=DUTY.recorded_names
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

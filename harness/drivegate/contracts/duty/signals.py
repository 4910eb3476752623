"""The trace of a run with duty ratios as columns in people's units."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from drivegate.contracts.duty.columns import COLUMNS, VOLTAGE
from drivegate.contracts.duty.run import DutyClosedLoopRun


def signals(run: DutyClosedLoopRun) -> dict[str, NDArray[Any]]:
    """Return the columns of a run, one row for each control period."""
    columns = {name: factor * run.column(source) for name, (source, factor) in COLUMNS.items()}
    return {**columns, VOLTAGE: run.voltages}

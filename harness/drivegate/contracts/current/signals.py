"""The trace of a run as columns in people's units."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.current.columns import RECORDED
from drivegate_models.loop.closed_loop import ClosedLoopRun


def signals(run: ClosedLoopRun) -> dict[str, NDArray[Any]]:
    """Return every column of a run with a trace."""
    return {name: run.trace[name] for name in run.trace.dtype.names or ()}


def recorded_signals(run: ClosedLoopRun) -> dict[str, NDArray[Any]]:
    """Return the columns that a result keeps; the supply only where it varies."""
    varying = (name for name in RECORDED if name != "half_supply_v" or np.ptp(run.trace[name]) != 0.0)
    return {name: run.trace[name] for name in varying}

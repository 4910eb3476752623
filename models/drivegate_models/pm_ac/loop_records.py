"""What a closed loop of duty ratios fills in: its trace, exact integrals, and how far it has come."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine import ledger

TRACE: Final = (
    "time",
    "speed_reference",
    "speed",
    "torque",
    "direct",
    "quadrature",
    "peak_current",
    "input_power",
    "load",
    "angle",
    "link",
    "torque_reference",
)
"""Columns of a run's trace: means over a control period, currents of the rotor frame at its end, greatest current.

Speed, electrical angle, link voltage and references are those of its start.
"""


RUN_RECORD: Final = np.dtype(
    [("steps", np.int64), ("speed_final", np.float64), ("worst_balance", np.float64)], align=True
)
"""Control periods that were run, speed of the shaft behind them (rad/s), and the worst balance of energy (1)."""


class DutyRecords(NamedTuple):
    """What a run fills in."""

    run: NDArray[Any]
    """Shape (1,) of RUN_RECORD."""
    trace: NDArray[np.float64]
    """Shape (steps, len(TRACE))."""
    totals: NDArray[np.float64]
    """Exact integrals over the run, shape (ledger.ENTRIES,)."""


def make_records(steps: int) -> DutyRecords:
    """Make room for what a run of so many steps fills in."""
    # A row is read only once its control period has been run.
    return DutyRecords(np.zeros(1, RUN_RECORD), np.empty((steps, len(TRACE))), np.zeros(ledger.ENTRIES))


@inlined
def keep_period(
    row: NDArray[np.float64],
    period: NDArray[np.float64],
    length: float,
    rotor_currents: NDArray[np.float64],
    begin: tuple[float, ...],
    load: float,
) -> None:
    """Write a row of the trace.

    Parameters
    ----------
    row : ndarray, shape (len(TRACE),)
        Receives it.
    period : ndarray, shape (ledger.ENTRIES,)
        Exact integrals over the period.
    length : float
        Its length (s).
    rotor_currents : ndarray, shape (2,)
        At its end (A).
    begin : tuple of float
        Time, reference of the speed, speed, angle, link's voltage and reference of the torque at its start.
    load : float
        Torque of the load in it (N m).
    """
    row[0] = begin[0]
    row[1] = begin[1]
    row[2] = begin[2]
    rate = 1.0 / length
    row[3] = period[ledger.IMPULSE] * rate
    row[4] = rotor_currents[0]
    row[5] = rotor_currents[1]
    row[6] = period[ledger.PEAK]
    row[7] = ledger.source_energy(period) * rate
    row[8] = load
    row[9] = begin[3]
    row[10] = begin[4]
    row[11] = begin[5]

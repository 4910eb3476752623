"""The records that a closed loop of duty ratios fills: its trace, exact integrals, and progress."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine import ledger, shaft_ledger

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
    "link_mean",
    "link_highest",
    "source_current",
    "chopper_power",
    "winding_temperature",
)
"""Columns of a run's trace: means over a control period, d-q currents at its end, and maximum current in it.

Speed, electrical angle, link voltage, references and the temperature of the winding (deg C, NaN without thermal data)
are those at its start. The last four before that temperature are mean and maximum of the link's voltage, and means of
the source's current and of the chopper's power.
"""
TEMPERATURE: Final = TRACE.index("winding_temperature")
"""Column of the temperature of the winding."""


RUN_RECORD: Final = np.dtype(
    [("steps", np.int64), ("speed_final", np.float64), ("worst_balance", np.float64)], align=True
)
"""Control periods of the run, speed of the shaft after them (rad/s), and maximum relative imbalance of energy (1)."""


class DutyRecords(NamedTuple):
    """The records that a run fills."""

    run: NDArray[Any]
    """Progress and balance, shape (1,) of RUN_RECORD."""
    trace: NDArray[np.float64]
    """One row per control period, shape (steps, len(TRACE))."""
    totals: NDArray[np.float64]
    """Exact integrals over the run, shape (ledger.ENTRIES,)."""
    shaft: NDArray[np.float64]
    """Energy ledger of the shaft, shape (shaft_ledger.ENTRIES,)."""


def make_records(steps: int) -> DutyRecords:
    # A row is read only once its control period has been run.
    trace = np.empty((steps, len(TRACE)))
    shaft = np.zeros(shaft_ledger.ENTRIES)
    return DutyRecords(np.zeros(1, RUN_RECORD), trace, np.zeros(ledger.ENTRIES), shaft)


@inlined
def write_period(
    row: NDArray[np.float64],
    period: NDArray[np.float64],
    length: float,
    rotor_currents: NDArray[np.float64],
    begin: tuple[float, ...],
    load: float,
    link: tuple[float, float, float, float],
) -> None:
    """Write a row of the trace.

    - `row`, shape (len(TRACE),): overwritten.
    - `period`, shape (ledger.ENTRIES,): exact integrals over the control period.
    - `length`: length of the period (s).
    - `rotor_currents`, shape (2,): d-axis and q-axis currents at its end (A).
    - `begin`: time (s), speed reference and speed (rad/s), electrical angle (rad), link voltage (V) and torque
      reference (N m) at its start.
    - `load`: torque of the load in the period, positive against forward rotation (N m).
    - `link`: mean and maximum of the link's voltage (V), means of the source's current (A) and the chopper's power (W).
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
    row[12] = link[0]
    row[13] = link[1]
    row[14] = link[2]
    row[15] = link[3]

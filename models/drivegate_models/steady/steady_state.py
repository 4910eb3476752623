"""Means and torque extremes of the steady state at fixed speed, advance angle and current reference.

With a hysteresis band there may be no periodic state. Then the means are over `AVERAGED_CYCLES` cycles, and the
state is marked as aperiodic.
"""

from __future__ import annotations

from math import inf, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import called, kernel
from drivegate_models.machine import ledger
from drivegate_models.machine.period import APERIODIC, PERIODIC
from drivegate_models.machine.torque import torque_range
from drivegate_models.steady.plant import (
    AnyDrive,
    AnyPhases,
    advance_phases,
    make_phases,
    periodic_start,
    torque_period,
)

AVERAGED_CYCLES: int = 32
"""Electrical cycles that are averaged if there is no periodic state."""
KEPT_TIME: float = 1e-3
"""Maximum length of a part of a torque period whose segments are stored at once (s)."""


class SteadyState(NamedTuple):
    """Means over the steady state at one point."""

    certified: int
    """`PERIODIC` or `APERIODIC`."""
    torque: float
    """Mean electromagnetic torque (N m)."""
    torque_lowest: float
    """Minimum torque (N m)."""
    torque_highest: float
    """Maximum torque (N m)."""
    current_sum: float
    """Mean of the sum of the phase currents' magnitudes (A)."""
    exchanged_power: float
    """Power exchanged with the half-sources (W)."""
    returned_power: float
    """The part of `exchanged_power` that flows back (W)."""
    source_power: float
    """Net power from the supply to windings and devices (W)."""
    copper_loss: float
    """Loss in the windings' resistance (W)."""
    device_loss: float
    """Forward drops and switching (W)."""
    core_loss: float
    """Core loss, from the supply and from the shaft (W)."""
    core_source_power: float
    """The part of the core loss supplied directly by the source (W)."""
    core_drag: float
    """Drag torque of the core loss of floating phases (N m)."""
    current_peak: float
    """Maximum magnitude of a phase current (A)."""
    switching_loss: float
    """Turn-on and turn-off losses (W), also part of `device_loss`."""


@kernel
def _summarised(
    drive: AnyDrive,
    certified: int,
    speed: float,
    duration: float,
    totals: NDArray[np.float64],
    lowest: float,
    highest: float,
) -> SteadyState:
    per = 1.0 / duration
    drag = totals[ledger.CORE_DRAG_IMPULSE] * per
    core_source = totals[ledger.CORE_SOURCE] * per
    switching = totals[ledger.SWITCHING] * per
    return SteadyState(
        certified,
        totals[ledger.IMPULSE] * per,
        lowest,
        highest,
        totals[ledger.MAGNITUDE] * per,
        totals[ledger.EXCHANGED] * per,
        totals[ledger.RETURNED] * per,
        (totals[ledger.UPPER] + totals[ledger.LOWER]) * per,
        drive.resistance * totals[ledger.SQUARE] * per,
        totals[ledger.DEVICE] * per + switching,
        core_source + drag * speed,
        core_source,
        drag,
        totals[ledger.PEAK],
        switching,
    )


@called
@kernel
def advance_with_extremes(
    drive: AnyDrive,
    phases: AnyPhases,
    angle: float,
    speed: float,
    voltage: float,
    reference: float,
    advance: float,
    duration: float,
    totals: NDArray[np.float64],
) -> tuple[int, float, float]:
    """Advance all phases in parts that are short enough to store their segments, and return the torque's range.

    `drive`, `phases`, `angle`, `speed`, `reference`, `advance`, `duration`, `totals`: arguments of
    `drivegate_models.steady.plant.advance_phases`; `phases` has space for `KEPT_TIME`. `voltage`: voltage of each
    half-source (V). Returns `status`: status of the advance, 0 if it reached its end; `lowest`, `highest`: extremes of
    the torque (N m).
    """
    lowest = inf
    highest = -inf
    positions = np.zeros(drive.phases, np.int64)
    # At low speed a torque period exceeds the space for segments.
    pieces = int(duration / KEPT_TIME) + 1
    length = duration / pieces
    status = 0
    turn = drive.pole_pairs * speed * length
    for piece in range(pieces):
        status = max(
            status,
            advance_phases(
                drive,
                phases,
                angle + piece * turn,
                speed,
                voltage,
                voltage,
                reference,
                advance,
                length,
                totals,
            ),
        )
        lowest, highest = torque_range(drive, phases, positions, length, lowest, highest)
    return status, lowest, highest


@kernel
def solve_steady_state(
    drive: AnyDrive,
    work: AnyPhases,
    slices: AnyPhases,
    speed: float,
    voltage: float,
    reference: float,
    advance: float,
) -> SteadyState:
    """Return the steady state at one operating point.

    `drive`, `work`, `slices`, `speed`, `voltage`, `reference`, `advance`: arguments of `periodic_start`; `work` has
    space for segments of `KEPT_TIME`.
    """
    periods = periodic_start(drive, work, slices, speed, voltage, reference, advance)
    angle = 0.5 * (pi - drive.window) - advance
    totals = np.zeros(ledger.ENTRIES)
    electrical = drive.pole_pairs * speed
    if periods != APERIODIC:
        # All phases are identical, so everything repeats with the phase shift; a cycle would cost 2 m times as much.
        duration = periods * torque_period(drive, electrical)
        _, lowest, highest = advance_with_extremes(
            drive, work, angle, speed, voltage, reference, advance, duration, totals
        )
        return _summarised(drive, PERIODIC, speed, duration, totals, lowest, highest)
    cycle = 2.0 * pi / electrical
    lowest = 0.0
    highest = 0.0
    for k in range(AVERAGED_CYCLES):
        _, low, high = advance_with_extremes(
            drive, work, angle, speed, voltage, reference, advance, cycle, totals
        )
        # Without a period, the cycle with the widest range represents the ripple.
        if k == 0 or high - low > highest - lowest:
            lowest = low
            highest = high
    return _summarised(drive, APERIODIC, speed, AVERAGED_CYCLES * cycle, totals, lowest, highest)


@kernel
def cycles_from_rest(
    drive: AnyDrive,
    work: AnyPhases,
    speed: float,
    voltage: float,
    reference: float,
    advance: float,
    cycles: int,
) -> SteadyState:
    """Run electrical cycles from angle 0 without current and with latches on, and return means over the last one.

    `drive`, `work`, `speed`, `voltage`, `reference`, `advance`: arguments of `periodic_start`; `work` is unchanged
    since `make_phases`. `cycles`: at least 1. Result: marked `APERIODIC`, because nothing is certified.
    """
    cycle = 2.0 * pi / (drive.pole_pairs * speed)
    totals = np.zeros(ledger.ENTRIES)
    lowest = 0.0
    highest = 0.0
    for _ in range(cycles):
        totals[:] = 0.0
        _, lowest, highest = advance_with_extremes(
            drive, work, 0.0, speed, voltage, reference, advance, cycle, totals
        )
    return _summarised(drive, APERIODIC, speed, cycle, totals, lowest, highest)


def steady_state(
    drive: AnyDrive, speed: float, reference: float, advance: float, voltage: float | None = None
) -> SteadyState:
    """Return the steady state at one operating point, with its own work space.

    `speed`: shaft speed (rad/s), above 0. `reference`: current reference i* (A). `advance`: advance angle (rad
    electrical). `voltage`: voltage of each half-source (V); the drive's nominal one by default.
    """
    work = make_phases(drive, KEPT_TIME)
    slices = make_phases(drive)
    supply = drive.half_supply_voltage if voltage is None else voltage
    return solve_steady_state(drive, work, slices, speed, supply, reference, advance)

"""Writing down what is observed of a run, one control period after the other."""

from __future__ import annotations

from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.loop.schedule import Conditions
from drivegate_models.machine import ledger
from drivegate_models.units import DEGREES, RPM


class Applied(NamedTuple):
    """What drove the plant in one control period, and what came of it."""

    reference: float
    """Current reference, clamped (A)."""
    advance: float
    """Advance angle, clamped (rad)."""
    speed: float
    """True speed (rad/s)."""
    current_sum: float
    """Mean of the sum of the phase currents' magnitudes (A)."""
    torque: float
    """Mean electromagnetic torque (N m)."""
    load_torque: float
    """Torque of the load (N m)."""
    input_power: float
    """Mean net power from the supply (W)."""
    exchanged_power: float
    """Mean power exchanged with the half-sources (W)."""
    peak: float
    """Greatest phase current (A)."""


@inlined
def observe_command(
    run: Any, reference: float, advance: float, time: float, measured_speed: float, base_speed: float
) -> None:
    """Add a command, as the controller gave it, to what is observed of a run.

    Parameters
    ----------
    run : record of RUN_RECORD
        Updated.
    reference, advance : float
        The command (A, rad).
    time : float
        Time of the step (s).
    measured_speed : float
        The speed that the controller saw (rad/s).
    base_speed : float
        Base speed (rad/s).
    """
    if reference < run.reference_lowest:
        run.reference_lowest = reference
    if reference > run.reference_highest:
        run.reference_highest = reference
    if advance < run.angle_lowest:
        run.angle_lowest = advance
    if advance > run.angle_highest:
        run.angle_highest = advance
    # The controller cannot know better than its Sense whether it is below base speed.
    if measured_speed < base_speed:
        run.steps_below_base += 1.0
        if abs(advance) > run.angle_below_base:
            run.angle_below_base = abs(advance)
            run.first_below_base = time


@inlined
def observe_power_estimate(run: Any, estimate: float, product: float) -> None:
    """Add a controller's estimate of its input power, if it gave one, to what is observed of a run.

    Parameters
    ----------
    run : record of RUN_RECORD
        Updated.
    estimate : float
        The estimate (W); NaN for none.
    product : float
        Measured supply voltage times measured current sum, or its mean (W).
    """
    if estimate == estimate:
        run.power_estimates += 1.0
        error = abs(estimate - product)
        if error > run.power_error:
            run.power_error = error
        relative = error / max(product, 1.0)
        if relative > run.power_error_relative:
            run.power_error_relative = relative


@inlined
def observe_energy(
    run: Any, resistance: float, speed: float, before: float, after: float, period: NDArray[np.float64]
) -> None:
    """Add the energies of one control period to what is observed of a run, and hold them against each other.

    Parameters
    ----------
    run : record of RUN_RECORD
        Updated.
    resistance : float
        Winding resistance (ohm).
    speed : float
        Shaft speed that was held (rad/s).
    before, after : float
        Energy in the windings at the start and at the end of the period (J).
    period : ndarray, shape (ledger.ENTRIES,)
        Exact integrals over the period.
    """
    exchanged = period[ledger.EXCHANGED]
    shaft = speed * period[ledger.IMPULSE]
    spent = resistance * period[ledger.SQUARE] + shaft + period[ledger.DEVICE] + (after - before)
    throughput = exchanged + before + after
    # What is not a number must not pass for a balance, hence the comparisons the other way round.
    if not throughput <= 0.0:
        mismatch = abs(exchanged - 2.0 * period[ledger.RETURNED] - spent) / throughput
        if not mismatch <= run.exchange_error:
            run.exchange_error = mismatch if mismatch == mismatch else inf
    run.shaft_energy += shaft
    run.input_energy += ledger.source_energy(period)


@inlined
def observe_balance(
    run: Any, currents: NDArray[np.float64], halves_are_equal: bool, period: NDArray[np.float64]
) -> None:
    """Add what the currents of one control period leave for a return that is common to all phases.

    A neutral that is isolated has none: the currents sum to zero, and equal halves of a supply give the same energy.

    Parameters
    ----------
    run : record of RUN_RECORD
        Updated.
    currents : ndarray, shape (m,)
        Phase currents at the end of the period (A).
    halves_are_equal : bool
        Whether the half-sources have the same voltage.
    period : ndarray, shape (ledger.ENTRIES,)
        Exact integrals over the period.
    """
    total = 0.0
    size = 0.0
    for current in currents:
        total += current
        size += abs(current)
    if abs(total) > run.neutral_current * size:
        run.neutral_current = abs(total) / size
    difference = abs(period[ledger.UPPER] - period[ledger.LOWER])
    if halves_are_equal and difference > run.unequal_halves * period[ledger.EXCHANGED]:
        run.unequal_halves = difference / period[ledger.EXCHANGED]


@inlined
def observe_window(
    row: Any, applied: Applied, speed_reference: float, block_sum: float, done: int, block: int
) -> float:
    """Add one control period to a window.

    Parameters
    ----------
    row : record of WINDOW_RECORD
        Updated.
    applied : Applied
        The period.
    speed_reference : float
        Speed reference (rad/s).
    block_sum : float
        Sum of the current sum in the block of periods that is being averaged (A).
    done : int
        Periods of the window done, this one included.
    block : int
        Periods in a block.

    Returns
    -------
    float
        The block's sum behind this period, 0 where the block has just ended (A).
    """
    row.steps += 1.0
    deviation = abs(applied.speed - speed_reference)
    if deviation > row.speed_error:
        row.speed_error = deviation
    if applied.advance < row.angle_lowest:
        row.angle_lowest = applied.advance
    if applied.advance > row.angle_highest:
        row.angle_highest = applied.advance
    row.current_sum += applied.current_sum
    row.torque += applied.torque
    row.input_power += applied.input_power
    row.exchanged_power += applied.exchanged_power
    row.angle += applied.advance
    row.reference += applied.reference
    row.speed += applied.speed
    if applied.peak > row.peak:
        row.peak = applied.peak
    block_sum += applied.current_sum
    if done % block != 0:
        return block_sum
    mean = block_sum / block
    if mean < row.mean_lowest:
        row.mean_lowest = mean
    if mean > row.mean_highest:
        row.mean_highest = mean
    return 0.0


@inlined
def write_trace(
    row: Any, time: float, conditions: Conditions, applied: Applied, speed: float, measured_speed: float
) -> None:
    """Write one control period into a trace, in people's units.

    Parameters
    ----------
    row : record of TRACE_RECORD
        Written.
    time : float
        Start of the period (s).
    conditions : Conditions
        What acted from outside.
    applied : Applied
        The period.
    speed, measured_speed : float
        True speed at the start of the period, and the one that the controller saw then (rad/s).
    """
    row.time_s = time
    row.speed_reference_rpm = conditions.speed_reference * RPM
    row.speed_rpm = speed * RPM
    row.current_sum_a = applied.current_sum
    row.current_reference_a = applied.reference
    row.advance_deg = applied.advance * DEGREES
    row.torque_nm = applied.torque
    row.load_torque_nm = applied.load_torque
    row.input_power_w = applied.input_power
    row.half_supply_v = conditions.supply
    row.measured_speed_rpm = measured_speed * RPM

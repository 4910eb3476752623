"""Accumulation of what is observed in a run, one control period at a time."""

from __future__ import annotations

from math import inf, nan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.loop.schedule import Conditions
from drivegate_models.machine import ledger
from drivegate_models.units import DEGREES, RPM


class Applied(NamedTuple):
    """The inputs of the plant in one control period, and the results."""

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
    """Maximum magnitude of a phase current (A)."""


@inlined
def observe_command(
    run: Any, reference: float, advance: float, time: float, measured_speed: float, base_speed: float
) -> None:
    """Add the controller's command, before clamping, to the record of a run.

    - `run`: its extremes of reference and angle, and its steps below base speed, are updated.
    - `reference`, `advance`: the command (A, rad electrical).
    - `time`: time of the step (s).
    - `measured_speed`: speed in the controller's Sense (rad/s).
    - `base_speed`: speed below which no advance is allowed (rad/s).
    """
    if reference < run.reference_lowest:
        run.reference_lowest = reference
    if reference > run.reference_highest:
        run.reference_highest = reference
    if advance < run.angle_lowest:
        run.angle_lowest = advance
    if advance > run.angle_highest:
        run.angle_highest = advance
    # The controller knows only from its Sense whether it is below base speed.
    if measured_speed < base_speed:
        run.steps_below_base += 1.0
        if abs(advance) > run.angle_below_base:
            run.angle_below_base = abs(advance)
            run.first_below_base = time


@inlined
def observe_power_estimate(run: Any, estimate: float, product: float) -> None:
    """Add the controller's estimate of its input power, if there is one, to the record of a run.

    `estimate`: the estimate (W); NaN for none. `product`: measured supply voltage times measured current sum, or its
    mean over the power window (W).
    """
    # Only NaN, which stands for no estimate, differs from itself.
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
    """Add the energies of one control period to the record of a run, and check their balance.

    `resistance`: winding resistance (ohm). `speed`: shaft speed at which the period was computed (rad/s). `before`,
    `after`: energy in the windings at the start and at the end of the period (J). `period`, shape (ledger.ENTRIES,):
    exact integrals over the period.
    """
    exchanged = period[ledger.EXCHANGED]
    shaft = speed * period[ledger.IMPULSE]
    spent = resistance * period[ledger.SQUARE] + shaft + period[ledger.DEVICE] + (after - before)
    throughput = exchanged + before + after
    # NaN must not count as balanced, hence the negated comparisons.
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
    """Add the share of the phase currents that needs a common return path to the record of a run.

    An isolated neutral has no such path: the currents sum to zero, and equal halves of a supply deliver equal
    energies.

    `run`: its `neutral_current` and `unequal_halves` are updated. `currents`, shape (m,): phase currents at the end of
    the period (A). `halves_are_equal`: true if the half-sources have the same voltage. `period`, shape
    (ledger.ENTRIES,): exact integrals over the period.
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
    row: Any,
    applied: Applied,
    speed_reference: float,
    sums: NDArray[np.float64],
) -> None:
    """Add one control period to a window.

    - `speed_reference`: speed reference in the period (rad/s).
    - `sums`, shape (3,): sums of current sum (A), squared current reference (A²) and advance angle (rad) over the
      periods of the present averaging time.
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
    sums[0] += applied.current_sum
    # A reference that swings within the averaging time may have the same mean as one that stands still.
    sums[1] += applied.reference * applied.reference
    sums[2] += applied.advance


@inlined
def write_trace(
    row: Any,
    time: float,
    conditions: Conditions[float],
    applied: Applied,
    speed: float,
    measured_speed: float,
) -> None:
    """Write one control period into a trace, in the units of its columns.

    `time`: start of the period (s). `speed`, `measured_speed`: true speed at the start of the period, and the measured
    one (rad/s).
    """
    row.time_s = time
    row.speed_reference_rpm = conditions.speed * RPM
    row.speed_rpm = speed * RPM
    row.current_sum_a = applied.current_sum
    row.current_reference_a = applied.reference
    row.advance_deg = applied.advance * DEGREES
    row.torque_nm = applied.torque
    row.load_torque_nm = applied.load_torque
    row.input_power_w = applied.input_power
    row.half_supply_v = conditions.supply
    row.measured_speed_rpm = measured_speed * RPM
    row.current_peak_a = applied.peak
    row.torque_lowest_nm = nan
    row.torque_highest_nm = nan

"""The compiled loop over the control periods of a run: controller, plant, sensors, shaft and observations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import inf, pi
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.loop.exchange import COMPLETED, Exchange, digested_command
from drivegate_models.loop.observing import (
    Applied,
    observe_balance,
    observe_command,
    observe_energy,
    observe_power_estimate,
    observe_window,
    write_trace,
)
from drivegate_models.loop.restarting import Restarts, step_or_restart, steps_since
from drivegate_models.loop.ripple_watch import RippleWatch, fresh_watch, observe_ripple, widened_watch
from drivegate_models.loop.schedule import Conditions, Schedule, conditions_at
from drivegate_models.loop.sensing.sensors import (
    Sensors,
    show_currents,
    shown_speed,
    shown_supply,
    turn_sensors,
)
from drivegate_models.loop.shaft import forward_motion, held_speed, within_a_turn
from drivegate_models.machine import ledger
from drivegate_models.machine.load import LOCKED, Load, drag_torque, opposing_torque, weight_torque
from drivegate_models.machine.shaft_ledger import account_shaft

PLANT_FAULT: Final = 3
"""Status of a run, in addition to those of `exchange`: the plant reported a fault of the harness."""

_BEGIN, _END, _RIPPLE_BEGIN, _FIRST_BLOCK = range(4)


@dataclass(frozen=True)
class PlantKernels:
    """The plant's functions in the closed loop; all except the first are compiled."""

    make_phases: Callable[..., Any]
    """``(drive, longest_advance=0.0)`` returns phases at rest: a named tuple with `currents` (A), `magnitudes`
    (A s), both of shape (m,), and `rows` and `row_counts` for the segments of an advance."""
    advance_phases: Callable[..., int]
    """``(drive, phases, angle, speed, upper, lower, reference, advance, duration, totals)`` advances them in
    SI units and returns `machine.advance_status.COMPLETED`, or another status of it."""
    stored_energy: Callable[..., float]
    """``(drive, currents)`` returns the energy in the windings (J)."""
    drifted: Callable[..., Any]
    """``(drive, resistance_factor, emf_factor)`` returns the drive at another temperature."""
    torque_range: Callable[..., tuple[float, float]]
    """``(drive, phases, positions, duration, lowest, highest)`` extends a range by the torque over the last
    advance (N m); `positions` is work space of shape (m,)."""

    @cached_property
    def loop(self) -> Any:
        """The closed loop with them, which is compiled on its first call."""
        return loop_of(self)


class Timing(NamedTuple):
    """Times of a run, most of them in control periods."""

    control_period: float
    steps: int
    initial_speed: float
    initial_angle: float
    """Electrical angle of the rotor at the start (rad)."""
    clock_start: float
    """Time in the controller's first Sense (s)."""
    base_speed: float
    block: int
    """Control periods over which the current sum is averaged."""
    trace_every: int
    """Record every n-th control period; n is at least 1."""
    windows: NDArray[np.int64]
    """First step, step after the last, first step whose ripple is observed, and first row of `Records.blocks`, of each
    window; shape (w, 4)."""
    blocks: int
    """Blocks of all windows, the last of a window whole or not."""


class Records(NamedTuple):
    """The records that a run fills."""

    run: NDArray[Any]
    windows: NDArray[Any]
    blocks: NDArray[np.float64]
    """Sums over each block of periods of each window, shape (n, 3)."""
    trace: NDArray[Any]
    totals: NDArray[np.float64]
    shaft: NDArray[np.float64]


class Workspace(NamedTuple):
    """Work space of the loop."""

    course_positions: NDArray[np.int64]
    row_positions: NDArray[np.int64]
    products: NDArray[np.float64]
    period: NDArray[np.float64]


class _Measured(NamedTuple):
    """The measured values, stored here because a controller may overwrite its Sense."""

    speed: float
    supply: float
    current_sum: float


@inlined
def _write_sense(
    exchange: Exchange,
    sensors: Sensors,
    phases: Any,
    conditions: Conditions[float],
    timing: Timing,
    time: float,
    speed: float,
    current_sum: float,
) -> _Measured:
    """Write the Sense of a control period, and return the measured values."""
    measured_speed = shown_speed(sensors, time, speed)
    measured_supply = shown_supply(sensors, time, conditions.supply)
    measured_sum = show_currents(
        sensors, time, phases.currents, phases.magnitudes, timing.control_period, exchange.sensed_currents
    )
    if sensors.ideal and not sensors.biased and measured_sum > 0.0:
        # Use the ledger's sum over the phases, not the sum of its differences.
        measured_sum = current_sum
    sense = exchange.sense
    sense[0].time = timing.clock_start + time
    sense[0].speed_reference = conditions.speed
    sense[0].speed = measured_speed
    sense[0].current_magnitude_sum = measured_sum
    sense[0].half_supply_voltage = measured_supply
    return _Measured(measured_speed, measured_supply, measured_sum)


@inlined
def _mean_product(products: NDArray[np.float64], step: int, product: float) -> float:
    """Add a product (W), and return the mean of the last ``products.size`` ones."""
    count = products.size
    products[step % count] = product
    if count == 1:
        return product
    known = min(step + 1, count)
    # Added up again each time: a running sum would collect rounding errors, and never lose a NaN.
    total = 0.0
    for index in range(known):
        total += products[index]
    return total / known


@inlined
def _watched_window(windows: NDArray[np.int64], step: int) -> int:
    """Return the last window whose ripple is observed in a step, or -1."""
    watched = -1
    for window in range(windows.shape[0]):
        if windows[window, _RIPPLE_BEGIN] <= step < windows[window, _END]:
            watched = window
    return watched


@inlined
def _observe_windows(
    timing: Timing,
    records: Records,
    step: int,
    speed_reference: float,
    applied: Applied,
) -> None:
    """Add one control period to every window that contains it."""
    windows = timing.windows
    for window in range(windows.shape[0]):
        if windows[window, _BEGIN] <= step < windows[window, _END]:
            block = windows[window, _FIRST_BLOCK] + (step - windows[window, _BEGIN]) // timing.block
            observe_window(records.windows[window], applied, speed_reference, records.blocks[block])


@inlined
def _observe_command(
    observed: Any, exchange: Exchange, time: float, measured: _Measured, base_speed: float, product: float
) -> None:
    """Add the controller's command, before clamping, to the record of the run."""
    command = exchange.command
    observe_command(
        observed, command[0].current_reference, command[0].advance_angle, time, measured.speed, base_speed
    )
    observe_power_estimate(observed, command[0].input_power, product)


@inlined
def _applied(
    period: NDArray[np.float64],
    length: float,
    reference: float,
    advance: float,
    speed: float,
    current_sum: float,
    load: float,
) -> Applied:
    """Return the inputs of the plant in a control period, and the results."""
    return Applied(
        reference,
        advance,
        speed,
        current_sum,
        period[ledger.IMPULSE] / length,
        load,
        ledger.source_energy(period) / length,
        period[ledger.EXCHANGED] / length,
        period[ledger.PEAK],
    )


def _ripple_follower(torque_range: Callable[..., tuple[float, float]]) -> Callable[..., RippleWatch]:
    """Return the compiled function that adds a control period to the observed electrical period."""

    def follow(
        plant: Any,
        recorded: Any,
        records: Records,
        workspace: Workspace,
        watched: int,
        watch: RippleWatch,
        length: float,
        wraps: bool,
        row: int,
    ) -> RippleWatch:
        if watched < 0:
            return fresh_watch(False)
        lowest, highest = torque_range(plant, recorded, workspace.row_positions, length, inf, -inf)
        if row >= 0:
            records.trace[row].torque_lowest_nm = lowest
            records.trace[row].torque_highest_nm = highest
        lowest, highest = min(lowest, watch.lowest), max(highest, watch.highest)
        watch = widened_watch(watch, lowest, highest, workspace.period[ledger.IMPULSE], length)
        if not wraps:
            return watch
        observe_ripple(records.windows[watched], watch)
        return fresh_watch(True)

    return inlined(follow)


def loop_of(kernels: PlantKernels) -> Any:
    """Return the compiled loop of a kind of drive, with the plant's kernels as compile-time constants."""
    advance_phases = kernels.advance_phases
    stored_energy = kernels.stored_energy
    drifted = kernels.drifted
    follow_ripple = _ripple_follower(kernels.torque_range)

    def run(
        drive: Any,
        phases: Any,
        recorded: Any,
        load: Load,
        schedule: Schedule,
        sensors: Sensors,
        exchange: Exchange,
        restarts: Restarts,
        timing: Timing,
        records: Records,
        workspace: Workspace,
    ) -> tuple[int, int]:
        observed = records.run[0]
        period = workspace.period
        length = timing.control_period
        stored = stored_energy(drive, phases.currents)
        speed = timing.initial_speed
        gained = 0.0
        angle = timing.initial_angle
        current_sum = 0.0
        digest = 0
        traced = 0
        restarted = 0
        watch = fresh_watch(False)
        for k in range(timing.steps):
            time = k * length
            conditions = conditions_at(schedule, workspace.course_positions, time)
            plant = drifted(drive, conditions.resistance, conditions.emf_constant)
            if load.kind == LOCKED:
                speed = conditions.speed
            measured = _write_sense(exchange, sensors, phases, conditions, timing, time, speed, current_sum)
            status, restarted = step_or_restart(exchange, restarts, restarted, k)
            if status != COMPLETED:
                observed.steps = k
                return status, digest
            digest = digested_command(digest, exchange)
            since = steps_since(restarts, restarted, k)
            product = _mean_product(workspace.products, since, measured.supply * measured.current_sum)
            _observe_command(observed, exchange, time, measured, timing.base_speed, product)
            # The inverter limits every command; the checks judge the command before this limit.
            reference = min(max(exchange.command[0].current_reference, 0.0), drive.current_limit)
            advance = min(max(exchange.command[0].advance_angle, 0.0), 0.5 * pi)

            for entry in range(ledger.ENTRIES):
                period[entry] = 0.0
            watched = _watched_window(timing.windows, k)
            # Segments are recorded only where the ripple is observed, since that takes time.
            moving = recorded if watched >= 0 else phases
            upper = conditions.supply * (1.0 + conditions.imbalance)
            lower = conditions.supply * (1.0 - conditions.imbalance)
            # The conduction windows use the sensors' angle; its error shifts them like an advance.
            # The extrapolated speed may be negative just before standstill, but the shaft never turns backward.
            held = max(held_speed(speed, gained), 0.0)
            shifted = advance + turn_sensors(sensors, k, time, length, held)
            if advance_phases(plant, moving, angle, held, upper, lower, reference, shifted, length, period):
                observed.steps = k
                return PLANT_FAULT, digest
            ledger.add_period(records.totals, period)
            now_stored = stored_energy(drive, phases.currents)
            observe_energy(observed, plant.resistance, held, stored, now_stored, period)
            observe_balance(observed, phases.currents, upper == lower, period)
            stored = now_stored
            current_sum = period[ledger.MAGNITUDE] / length
            opposing = opposing_torque(load, conditions.load, held)
            load_now = opposing + weight_torque(load, conditions.load)
            applied = _applied(period, length, reference, advance, held, current_sum, load_now)
            _observe_windows(timing, records, k, conditions.speed, applied)
            row = -1
            if traced < records.trace.shape[0] and k % timing.trace_every == 0:
                row = traced
                write_trace(records.trace[row], time, conditions, applied, speed, measured.speed)
                traced += 1

            turned = angle + drive.pole_pairs * held * length
            wraps = turned >= 2.0 * pi
            watch = follow_ripple(plant, recorded, records, workspace, watched, watch, length, wraps, row)
            angle = within_a_turn(turned)
            if load.kind != LOCKED:
                inertia = conditions.inertia * (drive.inertia + load.inertia)
                resisting = load_now + conditions.friction + drive.friction + drive.viscous_friction * held
                driving = period[ledger.IMPULSE] - period[ledger.CORE_DRAG_IMPULSE]
                motion = forward_motion(driving, resisting, inertia, speed, length)
                gained = motion.gained
                account_shaft(
                    records.shaft,
                    load,
                    conditions.load,
                    inertia,
                    (speed, gained, motion.share),
                    length,
                    driving / length,
                    opposing,
                    drag_torque(load, held),
                    conditions.friction + drive.friction + drive.viscous_friction * held,
                    0.0,
                )
                observed.kinetic_residual += inertia * gained * (speed + 0.5 * gained - held)
                speed += gained
        observed.steps = timing.steps
        observed.speed_final = speed
        return COMPLETED, digest

    return unallocating(run)

"""A controller and the plant in closed loop, in simulated time alone.

One compiled loop serves every kind of controller: it calls the controller's step by address, once a control
period, and advances the plant exactly by that period. Memory does not grow with the length of a run.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, inf, isfinite, nan, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step
from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.contract.outer_loop.records import COMMAND, SENSE
from drivegate_models.half_bridge.plant.drive import Drive, drifted
from drivegate_models.half_bridge.plant.phase import COMPLETED
from drivegate_models.half_bridge.plant.phases import Phases, advance_phases, make_phases, stored_energy
from drivegate_models.half_bridge.plant.torque import torque_extremes
from drivegate_models.loop import observation
from drivegate_models.loop.schedule import Schedule, follow
from drivegate_models.loop.sensors import (
    Sensors,
    ideal_sensors,
    show_currents,
    shown_speed,
    shown_supply,
    turn_encoder,
)
from drivegate_models.machine import ledger
from drivegate_models.machine.load import LOCKED, Load, load_torque

FINISHED = 0
"""Status: the run reached its end."""
STOPPED = 1
"""Status: the controller's bridge asked to stop; it knows why."""
NOT_FINITE = 2
"""Status: the controller's command was not finite; the last Sense shows what it saw."""
PLANT_FAULT = 3
"""Status: the plant reported a fault of the harness."""

_RADIANS_TO_RPM = 30.0 / pi
_DEGREES = 180.0 / pi


class Exchange(NamedTuple):
    """The records through which loop and controller talk, and the loop's progress."""

    sense: NDArray[Any]
    """Shape (1,) of contract.SENSE."""
    command: NDArray[Any]
    """Shape (1,) of contract.COMMAND."""
    command_bits: NDArray[np.int64]
    """The command's bits, shape (4,)."""
    sensed_currents: NDArray[np.float64]
    """Shape (m,) (A)."""
    progress: NDArray[np.int64]
    """Shape (1,): number of steps done, watched by the parent process."""
    sense_address: int
    """Address of `sense`."""
    command_address: int
    """Address of `command`."""


class RippleWatch(NamedTuple):
    """The electrical period whose torque is being followed."""

    positions: NDArray[np.int64]
    """Room for the search of extremes, shape (m,)."""
    values: NDArray[np.float64]
    """Lowest and highest torque (N m), impulse (N m s), time (s), whether it began in full; shape (5,)."""


_LOWEST, _HIGHEST, _IMPULSE, _TIME, _WHOLE = range(5)


@inlined
def _follow_ripple(
    watch: RippleWatch, drive: Drive, phases: Phases, period: float, impulse: float, wraps: bool, row: Any
) -> None:
    """Add one control period to the electrical period that is followed, and close it where the angle wraps."""
    values = watch.values
    lowest, highest = torque_extremes(
        phases.rows,
        phases.row_counts,
        watch.positions,
        drive.emf_constant,
        drive.resistance / drive.inductance,
        period,
        values[_LOWEST],
        values[_HIGHEST],
    )
    values[_LOWEST] = lowest
    values[_HIGHEST] = highest
    values[_IMPULSE] += impulse
    values[_TIME] += period
    if wraps:
        mean = values[_IMPULSE] / values[_TIME]
        if values[_WHOLE] > 0.0 and mean > 0.0:
            ripple = (highest - lowest) / mean
            one_sided = max(highest - mean, mean - lowest) / mean
            row[observation.WINDOW_RIPPLE] = max(row[observation.WINDOW_RIPPLE], ripple)
            row[observation.WINDOW_RIPPLE_ONE_SIDED] = max(
                row[observation.WINDOW_RIPPLE_ONE_SIDED], one_sided
            )
        values[_LOWEST] = inf
        values[_HIGHEST] = -inf
        values[_IMPULSE] = 0.0
        values[_TIME] = 0.0
        values[_WHOLE] = 1.0


@inlined
def _mean_product(products: NDArray[np.float64], step: int, product: float) -> float:
    """Return the mean of the last products, as many as there is room for."""
    count = products.size
    products[step % count] = product
    if count == 1:
        return product
    known = min(step + 1, count)
    total = 0.0
    for index in range(known):
        total += products[index]
    return total / known


_WORD = 0xFFFFFFFF
_FNV_PRIME = 16777619


@inlined
def _digested(digest: int, bits: int) -> int:
    """Add a 64-bit word to a digest: two rounds of FNV-1a over its halves, each mixed downward, in 63 bits."""
    low = digest & _WORD
    high = digest >> 32
    low = ((low ^ (bits & _WORD)) * _FNV_PRIME) & _WORD
    low ^= low >> 15
    high = ((high ^ low ^ ((bits >> 32) & _WORD)) * _FNV_PRIME) & _WORD
    high = (high ^ (high >> 15)) & 0x7FFFFFFF
    return (high << 32) | low


@unallocating
def _run(
    drive: Drive,
    phases: Phases,
    recorded: Phases,
    load: Load,
    schedule: Schedule,
    sensors: Sensors,
    exchange: Exchange,
    step_address: int,
    state_address: int,
    initial_speed: float,
    base_speed: float,
    control_period: float,
    steps: int,
    window_steps: NDArray[np.int64],
    watch: RippleWatch,
    products: NDArray[np.float64],
    positions: NDArray[np.int64],
    totals: NDArray[np.float64],
    period: NDArray[np.float64],
    block_sums: NDArray[np.float64],
    run: NDArray[np.float64],
    windows: NDArray[np.float64],
    trace: NDArray[np.float64],
    trace_every: int,
) -> tuple[int, int]:
    sense = exchange.sense
    command = exchange.command
    speed = initial_speed
    angle = 0.0
    current_sum = 0.0
    digest = 0
    inertia = drive.inertia + load.inertia
    block = max(round(observation.MEAN_TIME / control_period), 1)
    stored = stored_energy(drive, phases.currents)
    traced = 0
    for k in range(steps):
        time = k * control_period
        wanted = follow(schedule.speed, positions, 0, time)
        factor = follow(schedule.load, positions, 1, time)
        supply = follow(schedule.supply, positions, 2, time)
        imbalance = follow(schedule.imbalance, positions, 3, time)
        resistance_factor = follow(schedule.resistance, positions, 4, time)
        emf_factor = follow(schedule.emf, positions, 5, time)
        plant = drifted(drive, resistance_factor, emf_factor)
        if load.kind == LOCKED:
            speed = wanted

        measured_speed = shown_speed(sensors, time, speed)
        measured_supply = shown_supply(sensors, time, supply)
        measured_sum = show_currents(
            sensors, time, phases.currents, phases.magnitudes, control_period, exchange.sensed_currents
        )
        if sensors.ideal and measured_sum > 0.0:
            # The sum over the phases as the ledger has it, not the sum of its differences.
            measured_sum = current_sum
        sense[0].time = time
        sense[0].speed_reference = wanted
        sense[0].speed = measured_speed
        sense[0].current_magnitude_sum = measured_sum
        sense[0].half_supply_voltage = measured_supply
        command[0].current_reference = nan
        command[0].advance_angle = nan
        command[0].input_power = nan
        exchange.progress[0] = k + 1
        call_step(step_address, state_address, exchange.sense_address, exchange.command_address)
        if command[0].struct_size < 0:
            run[observation.RUN_STEPS] = k
            return STOPPED, digest
        reference = command[0].current_reference
        advance = command[0].advance_angle
        estimate = command[0].input_power
        if not (isfinite(reference) and isfinite(advance)) or abs(estimate) == inf:
            run[observation.RUN_STEPS] = k
            return NOT_FINITE, digest
        for word in range(1, 4):
            digest = _digested(digest, exchange.command_bits[word])

        if reference < run[observation.RUN_REFERENCE_LOWEST]:
            run[observation.RUN_REFERENCE_LOWEST] = reference
        if reference > run[observation.RUN_REFERENCE_HIGHEST]:
            run[observation.RUN_REFERENCE_HIGHEST] = reference
        if advance < run[observation.RUN_ANGLE_LOWEST]:
            run[observation.RUN_ANGLE_LOWEST] = advance
        if advance > run[observation.RUN_ANGLE_HIGHEST]:
            run[observation.RUN_ANGLE_HIGHEST] = advance
        if measured_speed < base_speed:
            run[observation.RUN_STEPS_BELOW_BASE] += 1.0
            if abs(advance) > run[observation.RUN_ANGLE_BELOW_BASE]:
                run[observation.RUN_ANGLE_BELOW_BASE] = abs(advance)
                run[observation.RUN_FIRST_BELOW_BASE] = time
        product = _mean_product(products, k, measured_supply * measured_sum)
        if estimate == estimate:
            run[observation.RUN_POWER_ESTIMATES] += 1.0
            error = abs(estimate - product)
            if error > run[observation.RUN_POWER_ERROR]:
                run[observation.RUN_POWER_ERROR] = error
            relative = error / max(product, 1.0)
            if relative > run[observation.RUN_POWER_ERROR_RELATIVE]:
                run[observation.RUN_POWER_ERROR_RELATIVE] = relative
        reference = min(max(reference, 0.0), drive.current_limit)
        advance = min(max(advance, 0.0), 0.5 * pi)

        for entry in range(ledger.ENTRIES):
            period[entry] = 0.0
        watched = -1
        for window in range(window_steps.shape[0]):
            if window_steps[window, 2] <= k < window_steps[window, 1]:
                watched = window
        moving = recorded if watched >= 0 else phases
        status = advance_phases(
            plant,
            moving,
            angle,
            speed,
            supply * (1.0 + imbalance),
            supply * (1.0 - imbalance),
            reference,
            advance,
            control_period,
            period,
        )
        if status != COMPLETED:
            run[observation.RUN_STEPS] = k
            return PLANT_FAULT, digest

        peak = max(totals[ledger.PEAK], period[ledger.PEAK])
        for entry in range(ledger.ENTRIES):
            totals[entry] += period[entry]
        totals[ledger.PEAK] = peak
        impulse = period[ledger.IMPULSE]
        drag = period[ledger.CORE_DRAG_IMPULSE]
        exchanged = period[ledger.EXCHANGED]
        returned = period[ledger.RETURNED]
        now_stored = stored_energy(drive, phases.currents)
        spent = (
            plant.resistance * period[ledger.SQUARE]
            + speed * impulse
            + period[ledger.DEVICE]
            + (now_stored - stored)
        )
        throughput = exchanged + stored + now_stored
        if throughput > 0.0:
            mismatch = abs(exchanged - 2.0 * returned - spent) / throughput
            if mismatch > run[observation.RUN_EXCHANGE_ERROR]:
                run[observation.RUN_EXCHANGE_ERROR] = mismatch
        stored = now_stored
        source = (
            period[ledger.UPPER]
            + period[ledger.LOWER]
            + period[ledger.CORE_SOURCE]
            + period[ledger.SWITCHING]
        )
        current_sum = period[ledger.MAGNITUDE] / control_period
        run[observation.RUN_SHAFT_ENERGY] += speed * impulse
        run[observation.RUN_INPUT_ENERGY] += source
        asked = load_torque(load, factor, speed)

        for window in range(window_steps.shape[0]):
            if window_steps[window, 0] <= k < window_steps[window, 1]:
                row = windows[window]
                row[observation.WINDOW_STEPS] += 1.0
                deviation = abs(speed - wanted)
                if deviation > row[observation.WINDOW_SPEED_ERROR]:
                    row[observation.WINDOW_SPEED_ERROR] = deviation
                if advance < row[observation.WINDOW_ANGLE_LOWEST]:
                    row[observation.WINDOW_ANGLE_LOWEST] = advance
                if advance > row[observation.WINDOW_ANGLE_HIGHEST]:
                    row[observation.WINDOW_ANGLE_HIGHEST] = advance
                row[observation.WINDOW_CURRENT_SUM] += current_sum
                row[observation.WINDOW_TORQUE] += impulse / control_period
                row[observation.WINDOW_INPUT_POWER] += source / control_period
                row[observation.WINDOW_EXCHANGED_POWER] += exchanged / control_period
                row[observation.WINDOW_ANGLE] += advance
                row[observation.WINDOW_REFERENCE] += reference
                row[observation.WINDOW_SPEED] += speed
                block_sums[window] += current_sum
                if (k + 1 - window_steps[window, 0]) % block == 0:
                    mean = block_sums[window] / block
                    block_sums[window] = 0.0
                    if mean < row[observation.WINDOW_MEAN_LOWEST]:
                        row[observation.WINDOW_MEAN_LOWEST] = mean
                    if mean > row[observation.WINDOW_MEAN_HIGHEST]:
                        row[observation.WINDOW_MEAN_HIGHEST] = mean
                if period[ledger.PEAK] > row[observation.WINDOW_PEAK]:
                    row[observation.WINDOW_PEAK] = period[ledger.PEAK]
        if traced < trace.shape[0] and k % trace_every == 0:
            trace[traced, 0] = time
            trace[traced, 1] = wanted * _RADIANS_TO_RPM
            trace[traced, 2] = speed * _RADIANS_TO_RPM
            trace[traced, 3] = current_sum
            trace[traced, 4] = reference
            trace[traced, 5] = advance * _DEGREES
            trace[traced, 6] = impulse / control_period
            trace[traced, 7] = asked
            trace[traced, 8] = source / control_period
            trace[traced, 9] = supply
            trace[traced, 10] = measured_speed * _RADIANS_TO_RPM
            traced += 1

        turn_encoder(sensors, k, time, control_period, speed)
        turned = angle + drive.pole_pairs * speed * control_period
        if watched >= 0:
            _follow_ripple(
                watch, plant, recorded, control_period, impulse, turned >= 2.0 * pi, windows[watched]
            )
        else:
            watch.values[_WHOLE] = 0.0
        angle = turned - 2.0 * pi * floor(turned * (0.5 / pi))
        if load.kind != LOCKED:
            resisting = asked + drive.friction + drive.viscous_friction * speed
            change = (impulse - drag - resisting * control_period) / inertia
            # Load and friction hold a shaft at standstill; they never drive it backward.
            following = max(speed + change, 0.0)
            run[observation.RUN_KINETIC_RESIDUAL] += 0.5 * inertia * (following - speed) ** 2
            speed = following
    run[observation.RUN_STEPS] = steps
    run[observation.RUN_SPEED_FINAL] = speed
    return FINISHED, digest


@dataclass(frozen=True)
class ClosedLoopRun:
    """What is kept of one run."""

    status: int
    """`FINISHED`, `STOPPED`, `NOT_FINITE` or `PLANT_FAULT`."""
    digest: int
    """Digest of every command, bit for bit."""
    totals: NDArray[np.float64]
    """Exact integrals over the run, shape (ledger.ENTRIES,)."""
    run: NDArray[np.float64]
    """Shape (observation.RUN_ENTRIES,)."""
    windows: NDArray[np.float64]
    """Shape (w, observation.WINDOW_ENTRIES); sums are turned into means."""
    trace: NDArray[np.float64]
    """Kept control periods, shape (n, len(observation.TRACE_COLUMNS))."""
    last_sense: NDArray[Any]
    """The Sense of the last step, shape (1,) of contract.SENSE."""
    last_currents: NDArray[np.float64]
    """Its phase currents, shape (m,) (A)."""
    last_command: NDArray[Any]
    """The last command, shape (1,) of contract.COMMAND."""

    @property
    def steps(self) -> int:
        """Number of control periods done."""
        return int(self.run[observation.RUN_STEPS])


_MEANS = (
    observation.WINDOW_CURRENT_SUM,
    observation.WINDOW_TORQUE,
    observation.WINDOW_INPUT_POWER,
    observation.WINDOW_EXCHANGED_POWER,
    observation.WINDOW_ANGLE,
    observation.WINDOW_REFERENCE,
    observation.WINDOW_SPEED,
)


def run_closed_loop(
    drive: Drive,
    load: Load,
    schedule: Schedule,
    *,
    step_address: int,
    state_address: int,
    initial_speed: float,
    base_speed: float,
    control_period: float,
    duration: float,
    windows: list[tuple[float, float]],
    sensors: Sensors | None = None,
    power_window: float = 0.0,
    sense: NDArray[Any] | None = None,
    sensed_currents: NDArray[np.float64] | None = None,
    progress: NDArray[np.int64] | None = None,
    trace_every: int = 0,
) -> ClosedLoopRun:
    """Run a controller, already reset, against the plant.

    Parameters
    ----------
    drive : Drive
        The plant's constants.
    load : Load
        The load.
    schedule : Schedule
        What happens during the run.
    step_address, state_address : int
        Addresses of the controller's step function and of its state.
    initial_speed : float
        Shaft speed at the start (rad/s).
    base_speed : float
        Speed below which no advance is allowed (rad/s); only observed.
    control_period : float
        (s).
    duration : float
        (s).
    windows : list of tuple of float
        Start and end of each observed window (s).
    sensors : Sensors, optional
        What the controller sees the plant through, made for this run; ideal by default.
    power_window : float
        Time over which the controller's estimate of its input power is a mean (s); 0 for the last period alone.
    sense : ndarray of SENSE, shape (1,), optional
        The record to hand to the controller, where another process is to see it.
    sensed_currents : ndarray, shape (m,) or longer, optional
        Where its phase currents belong (A).
    progress : ndarray of int64, shape (1,), optional
        Receives the number of steps done.
    trace_every : int
        Keep every n-th control period in the trace; 0 keeps none.

    Returns
    -------
    ClosedLoopRun
        Observations of the run.
    """
    steps = round(duration / control_period)
    phases = make_phases(drive)
    room = make_phases(drive, control_period)
    recorded = phases._replace(rows=room.rows, row_counts=room.row_counts)
    sense = np.zeros(1, SENSE) if sense is None else sense
    currents = np.zeros(drive.phases) if sensed_currents is None else sensed_currents
    command = np.zeros(1, COMMAND)
    sense[0]["struct_size"] = SENSE.itemsize
    sense[0]["phase_count"] = drive.phases
    sense[0]["phase_currents"] = currents.ctypes.data
    command[0]["struct_size"] = COMMAND.itemsize
    exchange = Exchange(
        sense=sense,
        command=command,
        command_bits=command.view(np.int64),
        sensed_currents=currents,
        progress=np.zeros(1, np.int64) if progress is None else progress,
        sense_address=sense.ctypes.data,
        command_address=command.ctypes.data,
    )
    run = np.zeros(observation.RUN_ENTRIES)
    run[[observation.RUN_REFERENCE_LOWEST, observation.RUN_ANGLE_LOWEST]] = inf
    run[[observation.RUN_REFERENCE_HIGHEST, observation.RUN_ANGLE_HIGHEST]] = -inf
    rows = np.zeros((len(windows), observation.WINDOW_ENTRIES))
    rows[:, [observation.WINDOW_ANGLE_LOWEST, observation.WINDOW_MEAN_LOWEST]] = inf
    rows[:, [observation.WINDOW_ANGLE_HIGHEST, observation.WINDOW_MEAN_HIGHEST]] = -inf
    window_steps = np.array(
        [
            [round(time / control_period) for time in (start, end, max(start, end - observation.RIPPLE_TIME))]
            for start, end in windows
        ],
        np.int64,
    ).reshape(-1, 3)
    watch = RippleWatch(np.zeros(drive.phases, np.int64), np.array([inf, -inf, 0.0, 0.0, 0.0]))
    kept = -(-steps // trace_every) if trace_every > 0 else 0
    trace = np.zeros((kept, len(observation.TRACE_COLUMNS)))
    totals = np.zeros(ledger.ENTRIES)
    status, digest = _run(
        drive,
        phases,
        recorded,
        load,
        schedule,
        ideal_sensors(drive.phases) if sensors is None else sensors,
        exchange,
        step_address,
        state_address,
        initial_speed,
        base_speed,
        control_period,
        steps,
        window_steps,
        watch,
        np.zeros(max(round(power_window / control_period), 1)),
        np.zeros(len(Schedule._fields), np.int64),
        totals,
        np.zeros(ledger.ENTRIES),
        np.zeros(len(windows)),
        run,
        rows,
        trace,
        max(trace_every, 1),
    )
    rows[:, _MEANS] /= np.maximum(rows[:, [observation.WINDOW_STEPS]], 1.0)
    done = int(run[observation.RUN_STEPS])
    return ClosedLoopRun(
        status=status,
        digest=int(digest),
        totals=totals,
        run=run,
        windows=rows,
        trace=trace[: -(-done // trace_every)] if trace_every > 0 else trace,
        last_sense=sense.copy(),
        last_currents=currents[: drive.phases].copy(),
        last_command=command,
    )

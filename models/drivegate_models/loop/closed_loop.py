"""A controller and the plant in closed loop, in simulated time alone.

The loop calls the controller's step by address once per control period, and advances the plant exactly by that
period. It is independent of the kind of drive: `plant_of` builds the loop from the kernels of a plant. Memory does not
grow with the length of a run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate_models.loop import observation
from drivegate_models.loop.exchange import Exchange, make_exchange
from drivegate_models.loop.loop_kernel import PlantKernels, Records, Room, Timing, loop_of
from drivegate_models.loop.observation import (
    RunObservation,
    WindowObservation,
)
from drivegate_models.loop.restarting import Restarts, no_restarts
from drivegate_models.loop.schedule import Conditions, Schedule
from drivegate_models.loop.sensing.sensors import Sensors, ideal_sensors
from drivegate_models.machine import ledger
from drivegate_models.machine.load import Load


@dataclass(frozen=True)
class Plant:
    """A kind of drive that controllers can be run against."""

    kernels: PlantKernels
    """The plant's functions in the loop."""
    loop: Any
    """The compiled loop."""


@dataclass(frozen=True)
class ClosedLoopRun:
    """The results of one run."""

    status: int
    """`exchange.COMPLETED`, `exchange.STOPPED`, `exchange.NOT_FINITE` or `PLANT_FAULT`."""
    digest: int
    """Digest of every command, bit for bit."""
    totals: NDArray[np.float64]
    """Exact integrals over the run, shape (ledger.ENTRIES,)."""
    observed: RunObservation
    """Observations over the whole run."""
    windows: tuple[WindowObservation, ...]
    """Observations in each window."""
    trace: NDArray[Any]
    """Recorded control periods, shape (n,) of observation.TRACE_RECORD."""
    last_sense: NDArray[Any]
    """The Sense of the last step, shape (1,) of contract.SENSE."""
    last_currents: NDArray[np.float64]
    """Its phase currents, shape (m,) (A)."""
    last_command: NDArray[Any]
    """The last command, shape (1,) of contract.COMMAND."""

    @property
    def steps(self) -> int:
        """Number of control periods done."""
        return int(self.observed.steps)


def plant_of(kernels: PlantKernels) -> Plant:
    """Return the kernels of a kind of drive with their closed loop, which is compiled on its first call."""
    return Plant(kernels, loop_of(kernels))


@dataclass(frozen=True)
class PreparedLoop:
    """A run that is ready to begin."""

    loop: Any
    """The compiled loop."""
    arguments: tuple[Any, ...]
    """The arguments of the loop."""
    exchange: Exchange
    """The records between loop and controller."""
    records: Records
    """The records that the run fills."""
    trace_every: int
    """Every n-th control period is recorded in the trace; 0 for none."""

    def run(self) -> ClosedLoopRun:
        """Run the controller, already reset, until the end or until it stops."""
        status, digest = self.loop(*self.arguments)
        return self.finished(int(status), int(digest))

    def finished(self, status: int, digest: int) -> ClosedLoopRun:
        """Return the results of a run from its records, and from the status and digest that its loop returned."""
        observed = observation.observed_run(self.records.run)
        trace, every = self.records.trace, self.trace_every
        return ClosedLoopRun(
            status=status,
            digest=digest,
            totals=self.records.totals,
            observed=observed,
            windows=observation.observed_windows(self.records.windows),
            trace=trace[: -(-int(observed.steps) // every)] if every > 0 else trace,
            last_sense=self.exchange.sense.copy(),
            last_currents=self.exchange.sensed_currents.copy(),
            last_command=self.exchange.command,
        )


def prepared_loop(
    plant: Plant,
    drive: Any,
    load: Load,
    schedule: Schedule,
    *,
    step_address: int,
    state_address: int,
    initial_speed: float,
    base_speed: float,
    control_period: float,
    duration: float,
    windows: Sequence[tuple[float, float]] = (),
    initial_angle: float = 0.0,
    clock_start: float = 0.0,
    restarts: Restarts | None = None,
    sensors: Sensors | None = None,
    power_window: float = 0.0,
    mean_time: float = observation.MEAN_TIME,
    progress: NDArray[np.int64] | None = None,
    kept: NDArray[Any] | None = None,
    trace_every: int = 0,
) -> PreparedLoop:
    """Prepare a run of a controller against a plant.

    Parameters
    ----------
    plant : Plant
        Kernels and compiled loop of the kind of drive.
    drive : named tuple
        Constants of machine and inverter, of the plant's own type.
    load : Load
        Torque and inertia at the shaft.
    schedule : Schedule
        External conditions over time.
    step_address, state_address : int
        Addresses of the controller's step function and of its state.
    initial_speed : float
        Shaft speed at the start (rad/s).
    base_speed : float
        Speed below which no advance is allowed (rad/s); steps below it are only observed.
    control_period : float
        Time between two steps of the controller (s).
    duration : float
        Length of the run (s), rounded to control periods.
    windows : sequence of tuple of float
        Start and end of each observed window (s); none by default.
    initial_angle : float
        Electrical angle of the rotor at the start, 0 to 2 pi (rad).
    clock_start : float
        Time in the controller's first Sense (s).
    restarts : Restarts, optional
        Resets of the controller during the run; none by default.
    sensors : Sensors, optional
        Sensors between plant and controller, made for this run; ideal by default.
    power_window : float
        Averaging time of the controller's estimate of its input power (s); 0 for the last period alone.
    mean_time : float
        Averaging time of the current sum, whose extreme means are observed in each window (s).
    progress : ndarray of int64, shape (1,), optional
        Receives the number of steps begun.
    kept : ndarray of COMMAND, shape (n,), optional
        Receives the commands of the first n steps.
    trace_every : int
        Record every n-th control period in the trace; 0 for none.

    Returns
    -------
    PreparedLoop
        The run, before its first step; the controller must be reset before it starts.
    """
    exchange = make_exchange(
        drive.phases, step_address=step_address, state_address=state_address, progress=progress, kept=kept
    )
    timing = _timing(control_period, duration, windows, mean_time, trace_every)._replace(
        initial_speed=initial_speed,
        initial_angle=initial_angle,
        clock_start=clock_start,
        base_speed=base_speed,
    )
    traced = -(-timing.steps // trace_every) if trace_every > 0 else 0
    records = Records(
        observation.empty_run(),
        observation.empty_windows(len(windows)),
        np.zeros(traced, observation.TRACE_RECORD),
        np.zeros(ledger.ENTRIES),
    )
    phases = plant.kernels.make_phases(drive)
    # Work space for the segments of a control period, in which the torque's extremes are found. The currents are shared
    # with `phases`; the loop chooses one of both in each period.
    room = plant.kernels.make_phases(drive, control_period)
    arguments = (
        drive,
        phases,
        phases._replace(rows=room.rows, row_counts=room.row_counts),
        load,
        schedule,
        ideal_sensors(drive.phases) if sensors is None else sensors,
        exchange,
        no_restarts() if restarts is None else restarts,
        timing,
        records,
        _room(drive.phases, len(windows), round(power_window / control_period)),
    )
    return PreparedLoop(plant.loop, arguments, exchange, records, trace_every)


def _timing(
    control_period: float,
    duration: float,
    windows: Sequence[tuple[float, float]],
    mean_time: float,
    trace_every: int,
) -> Timing:
    """Return the timing in control periods, with the initial values of shaft and clock still 0."""
    steps = [
        [round(time / control_period) for time in (start, end, max(start, end - observation.RIPPLE_TIME))]
        for start, end in windows
    ]
    return Timing(
        control_period,
        round(duration / control_period),
        0.0,
        0.0,
        0.0,
        0.0,
        max(round(mean_time / control_period), 1),
        max(trace_every, 1),
        np.array(steps, np.int64).reshape(-1, 3),
    )


def _room(phases: int, windows: int, products: int) -> Room:
    return Room(
        np.zeros(len(Conditions._fields), np.int64),
        np.zeros(phases, np.int64),
        np.zeros(max(products, 1)),
        np.zeros(ledger.ENTRIES),
        np.zeros(windows),
    )

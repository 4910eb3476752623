"""A controller and the plant in closed loop, in simulated time alone.

The loop calls the controller's step by address once per control period, and advances the plant exactly by that
period. It is independent of the kind of drive: it is made from the kernels of a plant. Memory grows with the
observed windows by 24 bytes per averaging time alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.layout import CURRENT
from drivegate_models.loop import observation
from drivegate_models.loop.exchange import Exchange, make_exchange
from drivegate_models.loop.loop_inputs import CurrentLoopInputs, SteppedController
from drivegate_models.loop.loop_kernel import PlantKernels, Records, Timing, Workspace
from drivegate_models.loop.observation import RunObservation, WindowObservation
from drivegate_models.loop.restarting import Restarts, no_restarts
from drivegate_models.loop.schedule import Conditions
from drivegate_models.loop.sensing.sensors import ideal_sensors
from drivegate_models.machine import ledger, shaft_ledger

Run = TypeVar("Run", covariant=True)


@dataclass(frozen=True)
class ClosedLoopRun:
    """The results of one run."""

    status: int
    """`exchange.COMPLETED`, `exchange.STOPPED`, `exchange.NOT_FINITE` or `PLANT_FAULT`."""
    digest: int
    """Digest of every command, bit for bit."""
    totals: NDArray[np.float64]
    """Exact integrals over the run, shape (ledger.ENTRIES,)."""
    shaft: NDArray[np.float64]
    """Energy ledger of the shaft, shape (shaft_ledger.ENTRIES,)."""
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


@dataclass(frozen=True)
class PreparedLoop(Generic[Run]):
    """A run that is ready to begin."""

    loop: Callable[..., tuple[int, int]]
    """The compiled loop."""
    arguments: tuple[Any, ...]
    """The arguments of the loop."""
    exchange: Exchange
    """The records between loop and controller; after the run, those of its last step."""
    records: Any
    """The records that the run fills, with `run` and `totals`."""
    results: Callable[[int, int], Run]
    """Returns the results of the run from what its loop returned."""

    def run(self) -> Run:
        """Run the controller, already reset, until the end or until it stops."""
        status, number = self.loop(*self.arguments)
        return self.results(int(status), int(number))


def prepared_loop(
    plant: PlantKernels,
    inputs: CurrentLoopInputs,
    controller: SteppedController,
    restarts: Restarts | None = None,
) -> PreparedLoop[ClosedLoopRun]:
    """Prepare a run of a controller against a plant; the controller must be reset before it starts."""
    drive = inputs.drive
    exchange = make_exchange(CURRENT, drive.phases, controller)
    timing = _timing(inputs)
    every = inputs.trace_every
    records = Records(
        observation.empty_run(),
        observation.empty_windows(len(inputs.windows)),
        np.zeros((timing.blocks, 3)),
        np.zeros(-(-timing.steps // every) if every > 0 else 0, observation.TRACE_RECORD),
        np.zeros(ledger.ENTRIES),
        np.zeros(shaft_ledger.ENTRIES),
    )
    phases = plant.make_phases(drive)
    # Work space for the segments of a control period, in which the torque's extremes are found. The currents are shared
    # with `phases`; the loop chooses one of both in each period.
    made = plant.make_phases(drive, inputs.control_period)
    arguments = (
        drive,
        phases,
        phases._replace(rows=made.rows, row_counts=made.row_counts),
        inputs.load,
        inputs.schedule,
        ideal_sensors(drive.phases) if inputs.sensors is None else inputs.sensors,
        exchange,
        no_restarts() if restarts is None else restarts,
        timing,
        records,
        _workspace(drive.phases, round(inputs.power_window / inputs.control_period)),
    )
    return PreparedLoop(
        plant.loop, arguments, exchange, records, partial(_results, records, exchange, timing, every)
    )


def _results(
    records: Records, exchange: Exchange, timing: Timing, trace_every: int, status: int, digest: int
) -> ClosedLoopRun:
    observed = observation.observed_run(records.run)
    trace = records.trace
    return ClosedLoopRun(
        status=status,
        digest=digest,
        totals=records.totals,
        shaft=records.shaft,
        observed=observed,
        windows=observation.observed_windows(
            records.windows, records.blocks, timing.windows[:, -1], timing.block
        ),
        trace=trace[: -(-int(observed.steps) // trace_every)] if trace_every > 0 else trace,
        last_sense=exchange.sense.copy(),
        last_currents=exchange.sensed_currents.copy(),
        last_command=exchange.command,
    )


def _timing(inputs: CurrentLoopInputs) -> Timing:
    period = inputs.control_period
    block = max(round(inputs.mean_time / period), 1)
    windows: list[list[int]] = []
    blocks = 0
    for start, end in inputs.windows:
        steps = [round(time / period) for time in (start, end, max(start, end - observation.RIPPLE_TIME))]
        windows.append([*steps, blocks])
        blocks += -(-(steps[1] - steps[0]) // block)
    return Timing(
        period,
        round(inputs.duration / period),
        inputs.initial_speed,
        inputs.initial_angle,
        inputs.clock_start,
        inputs.base_speed,
        block,
        max(inputs.trace_every, 1),
        np.array(windows, np.int64).reshape(-1, 4),
        blocks,
    )


def _workspace(phases: int, products: int) -> Workspace:
    return Workspace(
        np.zeros(len(Conditions._fields), np.int64),
        np.zeros(phases, np.int64),
        np.zeros(max(products, 1)),
        np.zeros(ledger.ENTRIES),
    )

"""The closed loop of a PM AC drive with a controller that answers with duty ratios: a run made ready, and begun."""

from __future__ import annotations

from math import pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.duty.signals import LEG_OFF
from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.loop.schedule import Course, Schedule, steady
from drivegate_models.machine import ledger
from drivegate_models.machine.load import Load
from drivegate_models.pm_ac.exchange import DutyExchange, make_exchange
from drivegate_models.pm_ac.failure import Failure, make_failure
from drivegate_models.pm_ac.loop_kernel import DutyRoom, DutyTiming, run_periods
from drivegate_models.pm_ac.loop_records import DutyRecords, make_records
from drivegate_models.pm_ac.plant.advance import make_phases
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.sensing import DutySensors, ideal_duty_sensors, low_side_ratio


class DutyRun(NamedTuple):
    """What came of a run."""

    status: int
    """`COMPLETED`, or another status of `loop.exchange`, `loop_kernel.PLANT_FAULT` or `duty_command.BAD_LEG`."""
    steps: int
    """Control periods that were run."""
    trace: NDArray[np.float64]
    """Shape (steps, len(TRACE))."""
    totals: NDArray[np.float64]
    """Exact integrals over the run, shape (ledger.ENTRIES,)."""
    worst_balance: float
    """Greatest energy that a period misses, over its throughput (1)."""
    commands: NDArray[Any]
    """The command of each step that was asked for, shape (n,) of DUTY_COMMAND."""


class PreparedDutyLoop(NamedTuple):
    """A run that is ready to begin."""

    loop: Any
    """The compiled loop."""
    arguments: tuple[Any, ...]
    """What it is called with."""
    exchange: DutyExchange
    """The records between loop and controller."""
    records: DutyRecords
    """What the run fills in."""

    def run(self) -> DutyRun:
        """Run the controller, already reset, to the end or to where it stops."""
        status, done = self.loop(*self.arguments)
        records = self.records
        asked = self.exchange.kept[: done + (status != COMPLETED)]
        worst = float(records.run["worst_balance"][0])
        return DutyRun(int(status), int(done), records.trace[:done], records.totals, worst, asked)


def prepared_duty_loop(
    drive: PmAcDrive,
    load: Load,
    schedule: Schedule,
    *,
    step_address: int,
    state_address: int,
    control_period: float,
    duration: float,
    initial_speed: float = 0.0,
    initial_angle: float = 0.0,
    clock_start: float = 0.0,
    torque_reference: Course | None = None,
    sensors: DutySensors | None = None,
    failure: Failure | None = None,
    progress: NDArray[np.int64] | None = None,
    kept: NDArray[Any] | None = None,
) -> PreparedDutyLoop:
    """Make a run of a controller against the plant ready to begin.

    Parameters
    ----------
    drive : PmAcDrive
        The drive.
    load : Load
        What it drives.
    schedule : Schedule
        What happens; its supply is half of the link's voltage, and its speed the reference.
    step_address, state_address : int
        Addresses of the controller's step function and of its state.
    control_period : float
        (s).
    duration : float
        (s).
    initial_speed : float
        Of the shaft (rad/s).
    initial_angle : float
        Electrical, from the first phase's axis to the magnet's (rad).
    clock_start : float
        Time that the controller senses in the first step (s).
    torque_reference : Course, optional
        What the controller is given in place of the schedule's speed (N m).
    sensors : DutySensors, optional
        What the controller sees through; the plant as it is where they are left out.
    failure : Failure, optional
        What fails.
    progress : ndarray of int64, shape (1,), optional
        Receives the number of steps begun.
    kept : ndarray of DUTY_COMMAND, shape (n,), optional
        Receives the commands, with room for those of all steps.

    Returns
    -------
    PreparedDutyLoop
        The run. All legs are off until the first answer acts. A machine whose EMF exceeds the link begins in the
        steady state in which its diodes rectify.
    """
    steps = round(duration / control_period)
    exchange = make_exchange(steps, step_address, state_address, progress, kept)
    records = make_records(steps)
    room = DutyRoom(
        np.zeros(7, np.int64),
        np.zeros(ledger.ENTRIES),
        np.zeros((2, 3)),
        np.full((2, 3), LEG_OFF, np.int64),
        np.full(3, low_side_ratio(0.0, LEG_OFF)),
    )
    timing = DutyTiming(
        float(control_period),
        steps,
        float(initial_speed),
        float(initial_angle % (2.0 * pi)),
        torque_reference is not None,
        float(clock_start),
    )
    torque = steady(0.0) if torque_reference is None else torque_reference
    shown = ideal_duty_sensors() if sensors is None else sensors
    fails = make_failure() if failure is None else failure
    arguments = (drive, make_phases(), load, schedule, torque, exchange, timing, room, shown, fails, records)
    return PreparedDutyLoop(run_periods, arguments, exchange, records)


def run_duty_loop(drive: PmAcDrive, load: Load, schedule: Schedule, **options: Any) -> DutyRun:
    """Run a controller that has been reset against the plant.

    Parameters
    ----------
    drive : PmAcDrive
        The drive.
    load : Load
        What it drives.
    schedule : Schedule
        What happens.
    **options
        As `prepared_duty_loop` has them.

    Returns
    -------
    DutyRun
        Its trace, totals and commands.
    """
    return prepared_duty_loop(drive, load, schedule, **options).run()

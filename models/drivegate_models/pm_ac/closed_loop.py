"""The closed loop of a PM AC drive with a controller that commands duty ratios: preparation and run."""

from __future__ import annotations

from math import pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.duty.signals import LEG_OFF
from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.loop.restarting import Restarts, no_restarts
from drivegate_models.loop.schedule import Conditions, Course, Schedule, steady
from drivegate_models.machine import advance_status, ledger
from drivegate_models.machine.load import Load
from drivegate_models.pm_ac.exchange import DutyExchange, make_exchange
from drivegate_models.pm_ac.failure import Failure, make_failure
from drivegate_models.pm_ac.loop_kernel import DutyRoom, DutyTiming, release_before_start, run_periods
from drivegate_models.pm_ac.loop_records import DutyRecords, make_records
from drivegate_models.pm_ac.plant.advance import PmAcPhases, make_phases
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.rectifying import rectifies, settle_rectifying
from drivegate_models.pm_ac.sensing import DutySensors, delayed_glitches, ideal_duty_sensors, low_side_ratio


class DutyRun(NamedTuple):
    """The results of a run."""

    status: int
    """`COMPLETED`, or another status of `loop.exchange`, `loop_kernel.PLANT_FAULT` or `duty_command.BAD_LEG`."""
    steps: int
    """Number of completed control periods, including those before the run."""
    trace: NDArray[np.float64]
    """One row per control period, shape (steps, len(TRACE))."""
    totals: NDArray[np.float64]
    """Exact integrals over the run, shape (ledger.ENTRIES,)."""
    worst_balance: float
    """Maximum missing energy of a period, relative to its throughput (1)."""
    commands: NDArray[Any]
    """The command of each step, shape (n,) of DUTY_COMMAND; it includes those before the run and of an early end."""
    before: int = 0
    """Number of steps before the run."""


class PreparedDutyLoop(NamedTuple):
    """A run that is ready to begin."""

    loop: Any
    """The compiled loop."""
    arguments: tuple[Any, ...]
    """The arguments of the loop."""
    exchange: DutyExchange
    """The records between loop and controller."""
    records: DutyRecords
    """The records that the run fills."""
    before: int = 0
    """Number of steps before the run."""

    def run(self) -> DutyRun:
        """Run the controller, already reset, until the end or until it stops."""
        status, done = self.loop(*self.arguments)
        records = self.records
        commands = self.exchange.kept[: done + (status != COMPLETED)]
        worst = float(records.run["worst_balance"][0])
        trace = records.trace[: max(done - self.before, 0)]
        return DutyRun(int(status), int(done), trace, records.totals, worst, commands, self.before)


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
    resting: int = 0,
    waiting: int = 0,
    torque_reference: Course | None = None,
    sensors: DutySensors | None = None,
    failure: Failure | None = None,
    restarts: Restarts | None = None,
    progress: NDArray[np.int64] | None = None,
    kept: NDArray[Any] | None = None,
) -> PreparedDutyLoop:
    """Prepare a run of a controller against the plant.

    Parameters
    ----------
    drive : PmAcDrive
        Constants of machine, bridge and modulator.
    load : Load
        Torque and inertia at the shaft.
    schedule : Schedule
        External conditions. The supply is half of the link voltage, and the speed is the reference.
    step_address, state_address : int
        Addresses of the controller's step function and of its state.
    control_period : float
        Time between two steps (s).
    duration : float
        Length of the run (s), rounded to control periods.
    initial_speed : float
        Speed of the shaft at the start (rad/s).
    initial_angle : float
        Electrical angle at the start, from the first phase's axis to the d axis (rad).
    clock_start : float
        Time in the controller's first Sense (s).
    resting, waiting : int
        Numbers of control periods before the run, in which the controller is stepped with `enable` 0 and all legs are
        off: first at standstill, then at the initial speed.
    torque_reference : Course, optional
        Torque reference, instead of the schedule's speed (N m).
    sensors : DutySensors, optional
        Sensors between plant and controller; ideal by default.
    failure : Failure, optional
        A failure during the run; none by default.
    restarts : Restarts, optional
        Resets of the controller during the run; none by default.
    progress : ndarray of int64, shape (1,), optional
        Receives the number of steps begun.
    kept : ndarray of DUTY_COMMAND, shape (n,), optional
        Receives the commands, with space for those of all steps, including those before the run.

    Returns
    -------
    PreparedDutyLoop
        The run. All legs are off until the first command acts. A machine whose EMF exceeds the link voltage begins in
        the steady state of its rectifying diodes.
    """
    steps = round(duration / control_period)
    before = resting + waiting
    exchange = make_exchange(before + steps, step_address, state_address, progress, kept)
    records = make_records(steps)
    room = DutyRoom(
        np.zeros(len(Conditions._fields) + 1, np.int64),
        np.zeros(ledger.ENTRIES),
        np.zeros((2, 3)),
        np.full((2, 3), LEG_OFF, np.int64),
        np.full(3, low_side_ratio(0.0, LEG_OFF)),
        np.zeros(3),
    )
    timing = DutyTiming(
        float(control_period),
        steps,
        float(initial_speed),
        float(initial_angle % (2.0 * pi)),
        torque_reference is not None,
        float(clock_start),
        int(resting),
        int(waiting),
    )
    torque = steady(0.0) if torque_reference is None else torque_reference
    shown = ideal_duty_sensors() if sensors is None else delayed_glitches(sensors, waiting * control_period)
    fails = make_failure() if failure is None else failure
    resets = no_restarts() if restarts is None else restarts
    phases = make_phases()
    if not _settle_before_start(drive, phases, load, schedule, timing, room):
        timing = timing._replace(has_no_start=True)
    arguments = (
        drive,
        phases,
        load,
        schedule,
        torque,
        exchange,
        timing,
        room,
        shown,
        fails,
        resets,
        records,
    )
    return PreparedDutyLoop(run_periods, arguments, exchange, records, before)


def _settle_before_start(
    drive: PmAcDrive, phases: PmAcPhases, load: Load, schedule: Schedule, timing: DutyTiming, room: DutyRoom
) -> bool:
    """Set the machine to its steady state at the initial speed, with the legs off; return True if there is one.

    It is without current, or with the diodes' current. The transient to this state is not part of the run.
    """
    speed, link, factors = release_before_start(drive, phases, load, schedule, timing, room)
    _, flux_factor = factors
    # There is nothing to settle then, and the loop need not wait for that kernel's compilation.
    if not rectifies(drive, flux_factor * speed, link):
        return True
    status = settle_rectifying(
        drive,
        phases,
        timing.initial_angle,
        speed,
        link,
        factors,
        timing.control_period,
        room.ratios[0],
        room.legs[0],
        room.period,
    )
    return int(status) == advance_status.COMPLETED

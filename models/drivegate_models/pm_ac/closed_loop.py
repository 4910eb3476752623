"""The closed loop of a PM AC drive with a controller that commands duty ratios: preparation and run."""

from __future__ import annotations

from functools import partial
from math import pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.duty.records import DUTY_COMMAND
from drivegate_models.contract.duty.signals import LEG_OFF
from drivegate_models.contract.layout import DUTY
from drivegate_models.loop.closed_loop import PreparedLoop
from drivegate_models.loop.exchange import COMPLETED, make_exchange
from drivegate_models.loop.loop_inputs import SteppedController
from drivegate_models.loop.restarting import Restarts, no_restarts
from drivegate_models.loop.schedule import Conditions, Schedule, steady
from drivegate_models.machine import advance_status, ledger
from drivegate_models.machine.load import Load
from drivegate_models.pm_ac.failure import make_failure
from drivegate_models.pm_ac.loop_inputs import DutyLoopInputs
from drivegate_models.pm_ac.loop_kernel import (
    NEVER,
    DutyTiming,
    DutyWorkspace,
    release_before_start,
    run_periods,
)
from drivegate_models.pm_ac.loop_records import DutyRecords, make_records
from drivegate_models.pm_ac.mean_voltages import no_mean_voltages, unused_mean_voltages
from drivegate_models.pm_ac.plant.advance import PmAcPhases, make_phases
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.rectifying import rectifies, settle_rectifying
from drivegate_models.pm_ac.sensing import delayed_glitches, ideal_duty_sensors, low_side_ratio
from drivegate_models.pm_ac.turning import no_turning
from drivegate_models.pm_ac.winding import Winding, copied_winding, no_winding


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
    shaft: NDArray[np.float64]
    """Energy ledger of the shaft, shape (shaft_ledger.ENTRIES,)."""
    commands: NDArray[Any]
    """The command of each step, shape (n,) of DUTY_COMMAND; it includes those before the run and of an early end."""
    before: int = 0
    """Number of steps before the run."""


def prepared_duty_loop(
    inputs: DutyLoopInputs, controller: SteppedController, restarts: Restarts | None = None
) -> PreparedLoop[DutyRun]:
    """Prepare a run of a controller against the plant; the controller must be reset before it starts.

    All legs are off until the first command acts. A machine whose EMF exceeds the link voltage begins in the steady
    state of its rectifying diodes.
    """
    drive, load, schedule = inputs.drive, inputs.load, inputs.schedule
    period, torque, sensors = inputs.control_period, inputs.torque_reference, inputs.sensors
    steps = round(inputs.duration / period)
    before = inputs.resting + inputs.waiting
    if controller.kept is None:
        # Every entry is written before it is read.
        controller = controller._replace(kept=np.empty(before + steps, DUTY_COMMAND))
    exchange = make_exchange(DUTY, 3, controller)
    records = make_records(steps)
    workspace = DutyWorkspace(
        np.zeros(len(Conditions._fields) + 1, np.int64),
        np.zeros(ledger.ENTRIES),
        np.zeros((2, 3)),
        np.full((2, 3), LEG_OFF, np.int64),
        np.full(2, np.nan),
        np.full(3, low_side_ratio(0.0, LEG_OFF)),
        np.zeros(3),
    )
    timing = DutyTiming(
        float(period),
        steps,
        float(inputs.initial_speed),
        float(inputs.initial_angle % (2.0 * pi)),
        torque is not None,
        float(inputs.clock_start),
        int(inputs.resting),
        int(inputs.waiting),
        NEVER if inputs.released is None else int(inputs.released),
    )
    voltages = (
        no_mean_voltages() if inputs.mean_voltages is None else unused_mean_voltages(inputs.mean_voltages)
    )
    phases = make_phases(follows_voltages=voltages.is_sensed)
    winding = no_winding() if inputs.winding is None else copied_winding(inputs.winding)
    if not _settle_before_start(drive, phases, load, schedule, timing, workspace, winding):
        timing = timing._replace(has_no_start=True)
    phases.volt_seconds[:] = 0.0
    arguments = (
        drive,
        phases,
        load,
        schedule,
        steady(0.0) if torque is None else torque,
        exchange,
        timing,
        workspace,
        ideal_duty_sensors() if sensors is None else delayed_glitches(sensors, inputs.waiting * period),
        make_failure() if inputs.failure is None else inputs.failure,
        no_restarts() if restarts is None else restarts,
        no_turning() if inputs.turning is None else inputs.turning,
        winding,
        voltages,
        records,
    )
    return PreparedLoop(
        run_periods, arguments, exchange, records, partial(_results, records, exchange.kept, before)
    )


def _results(records: DutyRecords, kept: NDArray[Any], before: int, status: int, done: int) -> DutyRun:
    worst = float(records.run["worst_balance"][0])
    commands = kept[: done + (status != COMPLETED)]
    trace = records.trace[: max(done - before, 0)]
    return DutyRun(status, done, trace, records.totals, worst, records.shaft, commands, before)


def _settle_before_start(
    drive: PmAcDrive,
    phases: PmAcPhases,
    load: Load,
    schedule: Schedule,
    timing: DutyTiming,
    workspace: DutyWorkspace,
    winding: Winding,
) -> bool:
    """Set the machine to its steady state at the initial speed, with the legs off; return True if there is one.

    It is without current, or with the diodes' current. The transient to this state is not part of the run.
    """
    speed, link, factors = release_before_start(drive, phases, load, schedule, timing, workspace, winding)
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
        workspace.ratios[0],
        workspace.legs[0],
        workspace.period,
    )
    return int(status) == advance_status.COMPLETED

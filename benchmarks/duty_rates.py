"""The closed loop of duty ratios: field-oriented control of a PM AC machine at 10 kHz, one update a period."""

from __future__ import annotations

import time
from typing import Final

import numpy as np

from drivegate_cases.scenario.courses import COURSES
from drivegate_lab.bench.workbench import Correctness, Value, Workbench, rate, timed
from drivegate_models.contract.current.signals import PM_AC
from drivegate_models.contract.duty.records import duty_nameplate_record
from drivegate_models.contract.duty.signals import SPEED_REFERENCE, DutyNameplate
from drivegate_models.controllers.duty.foc import reset_function, step_function
from drivegate_models.controllers.duty.state import FOC_STATE
from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.loop.loop_inputs import SteppedController
from drivegate_models.loop.schedule import Conditions, steady
from drivegate_models.machine.load import CONSTANT_TORQUE, Load
from drivegate_models.pm_ac.closed_loop import DutyRun, prepared_duty_loop
from drivegate_models.pm_ac.loop_inputs import DutyLoopInputs
from drivegate_models.pm_ac.loop_records import TRACE
from drivegate_models.pm_ac.plant.drive import Modulator, PmAcDrive, make_pm_ac_drive

SIMULATED: Final = 8.0
"""Simulated time of each run (s)."""
PERIOD: Final = 1e-4
"""Control period (s)."""
DEAD_TIMES: Final = {"ideal": 0.0, "dead-time": 2e-6}
"""Dead time of the bridge (s)."""

SPEED: Final = 110.0
"""Speed of the runs (rad/s)."""
TORQUE: Final = 1.2
"""Their load (N m)."""

_BASE_SPEED = 230.0
_NOMINAL = Conditions(*(steady(COURSES[name].nominal or 0.0) for name in Conditions._fields))


def duty_rate(bench: Workbench, bridge: str) -> Value:
    """Measure the closed loop of the interior machine at half its base speed and half its torque."""
    simulated = bench.simulated(SIMULATED)
    run = _run(DEAD_TIMES[bridge], simulated)
    speed = float(run.trace[-1, TRACE.index("speed")])
    correctness = Correctness(
        run.status == COMPLETED and run.worst_balance <= 1e-9 and abs(speed / SPEED - 1.0) <= 1e-3,
        f"ended at {speed:.2f} of {SPEED:g} rad/s, ledger within {run.worst_balance:.0e}",
    )
    times = timed(lambda: _run(DEAD_TIMES[bridge], simulated), time.process_time, bench.rounds)
    return rate(simulated, times, correctness)


def foc_run(
    drive: PmAcDrive, nameplate: DutyNameplate, speed: float, torque: float, simulated: float
) -> DutyRun:
    """Run field-oriented control at a speed (rad/s) against a torque (N m)."""
    state = np.zeros(1, FOC_STATE)
    reset_function()(state, duty_nameplate_record(nameplate))
    link = steady(0.5 * drive.link_voltage)
    return prepared_duty_loop(
        DutyLoopInputs(
            drive=drive,
            load=Load(CONSTANT_TORQUE, torque),
            schedule=_NOMINAL._replace(speed=steady(speed), supply=link),
            control_period=nameplate.control_period,
            duration=simulated,
            initial_speed=speed,
        ),
        SteppedController(step_function().address, state.ctypes.data),
    ).run()


def interior_drive(dead_time: float) -> PmAcDrive:
    """Return the machine with saliency, behind a bridge of a dead time (s)."""
    return make_pm_ac_drive(
        pole_pairs=2,
        resistance=0.57,
        direct_inductance=8.72e-3,
        quadrature_inductance=22.78e-3,
        magnet_flux=0.0879,
        link_voltage=122.5,
        current_limit=7.07,
        inertia=0.002,
        modulator=Modulator(dead_time=dead_time),
    )


def interior_nameplate(drive: PmAcDrive) -> DutyNameplate:
    """Return the nameplate of its controller."""
    return DutyNameplate(
        PM_AC,
        SPEED_REFERENCE,
        drive.pole_pairs,
        drive.modulator.updates,
        drive.modulator.update_delay,
        drive.link_voltage,
        _BASE_SPEED,
        3.0 * _BASE_SPEED,
        2.0 * TORQUE * _BASE_SPEED,
        drive.current_limit,
        PERIOD,
        drive.modulator.dead_time,
        drive.resistance,
        drive.direct_inductance,
        drive.quadrature_inductance,
        drive.magnet_flux,
        drive.inertia,
    )


def _run(dead_time: float, simulated: float) -> DutyRun:
    drive = interior_drive(dead_time)
    return foc_run(drive, interior_nameplate(drive), SPEED, TORQUE, simulated)

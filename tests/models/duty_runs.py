"""Runs of the controllers of duty ratios: a drive's rating, its nameplate, and a controller in closed loop with it."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray
from tests.models.schedules import schedule_of

from drivegate_models.contract.current.signals import PM_AC
from drivegate_models.contract.duty.records import duty_nameplate_record
from drivegate_models.contract.duty.signals import SPEED_REFERENCE, TORQUE_REFERENCE, DutyNameplate
from drivegate_models.controllers.duty.foc import reset_function, step_function
from drivegate_models.controllers.duty.state import foc_state
from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.loop.loop_inputs import SteppedController
from drivegate_models.loop.schedule import Course, Schedule, steady
from drivegate_models.machine.load import LOCKED, Load
from drivegate_models.pm_ac.closed_loop import DutyRun, prepared_duty_loop
from drivegate_models.pm_ac.fundamental import LINEAR_LIMIT, base_speed
from drivegate_models.pm_ac.loop_inputs import DutyLoopInputs
from drivegate_models.pm_ac.loop_records import TRACE
from drivegate_models.pm_ac.oracle import Limits, greatest_torque
from drivegate_models.pm_ac.plant.drive import PmAcDrive

PERIOD = 1e-4
COLUMN = {name: k for k, name in enumerate(TRACE)}


def limits_of(drive: PmAcDrive) -> Limits:
    """Return what the modulator can give without distortion."""
    return Limits(drive.current_limit, LINEAR_LIMIT * drive.link_voltage)


def rating(drive: PmAcDrive) -> tuple[float, float]:
    """Return base speed and the greatest power there."""
    speed = base_speed(drive, *limits_of(drive))
    return speed, speed * greatest_torque(drive, limits_of(drive), speed).torque


def course(drive: PmAcDrive, reference: Course, load: Course) -> Schedule:
    """Return what happens, at the nominal voltage of the link."""
    return schedule_of(reference, 0.5 * drive.link_voltage, load=load)


def nameplate_of(
    drive: PmAcDrive, reference_kind: int = SPEED_REFERENCE, period: float = PERIOD
) -> DutyNameplate:
    """Return the nominal data of a drive."""
    base, power = rating(drive)
    return DutyNameplate(
        kind=PM_AC,
        reference_kind=reference_kind,
        pole_pairs=drive.pole_pairs,
        updates=drive.modulator.updates,
        update_delay=drive.modulator.update_delay,
        supply_voltage=drive.link_voltage,
        base_speed=base,
        highest_speed=3.0 * base,
        rated_power=power,
        current_limit=drive.current_limit,
        control_period=period,
        dead_time=drive.modulator.dead_time,
        resistance=drive.resistance,
        direct_inductance=drive.direct_inductance,
        quadrature_inductance=drive.quadrature_inductance,
        magnet_flux=drive.magnet_flux,
        inertia=drive.inertia,
        core_loss_conductance=drive.core_loss_conductance,
        switch_drop=drive.switch_drop,
        diode_drop=drive.diode_drop,
        link_capacitance=drive.dc_link.capacitance,
        source_resistance=drive.dc_link.source_resistance,
        link_limit=drive.dc_link.limit,
        charge_limit=drive.dc_link.charge_limit,
        discharge_limit=drive.dc_link.discharge_limit,
        chopper_voltage=drive.dc_link.chopper_on,
        chopper_resistance=(
            1.0 / drive.dc_link.chopper_conductance if drive.dc_link.chopper_conductance else 0.0
        ),
    )


def reset_controller(name: str, nameplate: DutyNameplate) -> NDArray[Any]:
    """Return the state of a controller that has been reset."""
    state = foc_state(name)
    reset_function()(state, duty_nameplate_record(nameplate))
    return state


def controlled(
    drive: PmAcDrive,
    load: Load,
    schedule: Schedule,
    duration: float,
    *,
    name: str = "foc",
    reference_kind: int = SPEED_REFERENCE,
    initial_speed: float = 0.0,
    initial_angle: float = 0.0,
    period: float = PERIOD,
    known: PmAcDrive | None = None,
) -> DutyRun:
    """Run a controller with a drive; `known` is the drive on its nameplate, by default the same."""
    state = reset_controller(name, nameplate_of(known or drive, reference_kind, period))
    return prepared_duty_loop(
        DutyLoopInputs(
            drive=drive,
            load=load,
            schedule=schedule,
            control_period=period,
            duration=duration,
            initial_speed=initial_speed,
            initial_angle=initial_angle,
        ),
        SteppedController(step_function().address, state.ctypes.data),
    ).run()


def held(
    drive: PmAcDrive, name: str, speed: float, torque: Course, *, plant: PmAcDrive | None = None
) -> tuple[DutyRun, NDArray[Any]]:
    """Run a controller of a torque for 0.1 s at a held speed; return the run and the state at its end."""
    state = reset_controller(name, nameplate_of(drive, TORQUE_REFERENCE))
    run = prepared_duty_loop(
        DutyLoopInputs(
            drive=plant or drive,
            load=Load(LOCKED),
            schedule=course(drive, steady(speed), steady(0.0)),
            control_period=PERIOD,
            duration=0.1,
            initial_speed=speed,
            torque_reference=torque,
        ),
        SteppedController(step_function().address, state.ctypes.data),
    ).run()
    assert run.status == COMPLETED
    return run, state

"""The shaft of a PM AC drive in closed loop: vehicles on slopes, standstill within a period, changing inertia."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable

import numpy as np
import pytest
from tests.models.duty_runs import COLUMN, PERIOD, controlled
from tests.models.pm_ac.test_closed_loop import stubborn
from tests.models.schedules import schedule_of

from drivegate_models.contract.duty.signals import LEG_OFF
from drivegate_models.loop.loop_inputs import SteppedController
from drivegate_models.loop.schedule import Course, Schedule, steady
from drivegate_models.machine import shaft_ledger
from drivegate_models.machine.load import CONSTANT_TORQUE, HOIST, VEHICLE, Load
from drivegate_models.pm_ac.closed_loop import DutyRun, prepared_duty_loop
from drivegate_models.pm_ac.failure import LOCKED_ROTOR, Failure, make_failure
from drivegate_models.pm_ac.loop_inputs import DutyLoopInputs
from drivegate_models.pm_ac.plant.drive import PmAcDrive

Factory = Callable[..., PmAcDrive]
_KEPT, _OFF = stubborn(0.0, 0.0, 0.0, leg=int(LEG_OFF))


def coasted(
    drive: PmAcDrive,
    load: Load,
    schedule: Schedule,
    *,
    duration: float,
    speed: float = 0.0,
    period: float = PERIOD,
    address: int = _OFF,
    failure: Failure | None = None,
) -> DutyRun:
    """Run the drive with its bridge off, or with the same duty ratios all the time."""
    inputs = DutyLoopInputs(
        drive=drive,
        load=load,
        schedule=schedule,
        control_period=period,
        duration=duration,
        initial_speed=speed,
        failure=failure,
    )
    return prepared_duty_loop(inputs, SteppedController(address, 0)).run()


def final_speed(run: DutyRun) -> float:
    """Return the speed at the start of the last control period."""
    return float(run.trace[-1, COLUMN["speed"]])


@pytest.mark.parametrize("speed", [20.0, -20.0])
def test_a_vehicle_goes_up_and_down_its_hill_as_its_weight_says(interior: Factory, speed: float) -> None:
    """The road rises in the forward direction, so backward the weight drives and rolling resistance alone opposes."""
    drive, grade, rolling = interior(inertia=0.01, magnet_flux=1e-6), 0.1, 0.03
    load = Load(VEHICLE, 4.0, rolling=rolling, inertia=0.04)
    run = coasted(drive, load, schedule_of(0.0, 60.0, load=steady(grade)), duration=0.1, speed=speed)
    slope = 4.0 / math.hypot(1.0, grade)
    rate = -slope * (grade + math.copysign(rolling, speed)) / (drive.inertia + load.inertia)
    end = speed + rate * (0.1 - PERIOD)
    assert final_speed(run) == pytest.approx(end, rel=1e-9)
    lifted = slope * grade * 0.5 * (2.0 * speed + rate * 0.1) * 0.1
    assert run.shaft[shaft_ledger.GRADE] == pytest.approx(lifted, rel=1e-9)
    assert run.shaft[shaft_ledger.ROLLING] == pytest.approx(abs(lifted) * rolling / grade, rel=1e-9)
    assert shaft_ledger.shaft_error(run.shaft) < 1e-12


@pytest.mark.parametrize(("grade", "rolls"), [(0.1, -1.0), (0.02, 0.0), (-0.02, 0.0), (-0.1, 1.0)])
def test_a_slope_rolls_a_standing_vehicle_where_rolling_resistance_does_not_hold_it(
    interior: Factory, grade: float, rolls: float
) -> None:
    drive, load = interior(magnet_flux=1e-6), Load(VEHICLE, 4.0, rolling=0.03, inertia=0.04)
    run = coasted(drive, load, schedule_of(0.0, 60.0, load=steady(grade)), duration=0.1)
    assert np.sign(final_speed(run)) == rolls
    assert shaft_ledger.shaft_error(run.shaft) < 1e-12


@pytest.mark.parametrize("speed", [60.0, -60.0])
def test_a_regulated_vehicle_takes_its_climbing_power_from_the_link_and_feeds_it_back(
    interior: Factory, speed: float
) -> None:
    drive, load = interior(), Load(VEHICLE, 8.0, rolling=0.005, inertia=0.002)
    run = controlled(
        drive,
        load,
        schedule_of(speed, 0.5 * drive.link_voltage, load=steady(0.1)),
        0.6,
        initial_speed=speed,
    )
    late = run.trace[-1000:]
    assert late[:, COLUMN["speed"]].mean() == pytest.approx(speed, rel=1e-2)
    mechanical = late[:, COLUMN["torque"]].mean() * speed
    assert mechanical * speed > 0.0, "uphill it drives, downhill it brakes"
    assert late[:, COLUMN["torque"]].mean() == pytest.approx(late[:, COLUMN["load"]].mean(), rel=1e-2)
    assert late[:, COLUMN["input_power"]].mean() > mechanical
    assert shaft_ledger.shaft_error(run.shaft) < 1e-11


def test_standstill_under_a_brake_is_passed_with_an_error_of_second_order(interior: Factory) -> None:
    """A hoist stops a shaft and lowers its weight against a brake; its light rotor is fast at once."""
    drive = interior(inertia=1e-5, friction=0.02, magnet_flux=1e-6)
    load = Load(HOIST, 0.05)
    errors = []
    for period in (4e-4, 2e-4, 1e-4):
        duration = 0.0201
        steps = math.floor(duration / period) + 1
        run = coasted(
            drive,
            load,
            schedule_of(0.0, 60.0, load=steady(1.0)),
            duration=steps * period,
            speed=20.0,
            period=period,
        )
        rest = 20.0 * drive.inertia / (0.05 + 0.02)
        time = float(run.trace[-1, COLUMN["time"]])
        exact = -(0.05 - 0.02) / drive.inertia * (time - rest)
        errors.append(abs(final_speed(run) - exact))
        assert shaft_ledger.shaft_error(run.shaft) < 1e-12
    assert max(errors) < 1e-6, errors


def test_a_machine_that_reverses_against_a_brake_converges_with_the_square_of_the_period(
    interior: Factory,
) -> None:
    drive = interior(inertia=2e-5)
    drive = drive._replace(modulator=drive.modulator._replace(update_delay=0), resistance=4.0)
    kept, address = stubborn(0.5, 0.45, 0.55)
    load = Load(CONSTANT_TORQUE, 0.05)
    assert kept is not None

    def ended(period: float) -> tuple[float, float]:
        run = coasted(
            drive,
            load,
            schedule_of(0.0, 0.5 * drive.link_voltage, load=steady(1.0)),
            duration=0.0205,
            speed=30.0,
            period=period,
            address=address,
        )
        speeds = run.trace[:, COLUMN["speed"]]
        crossings = np.count_nonzero(np.diff(np.sign(speeds)))
        assert crossings >= 1, "it does not pass standstill, which shows nothing"
        return float(np.interp(0.02, run.trace[:, COLUMN["time"]], speeds)), float(crossings)

    exact = ended(3.125e-6)[0]
    coarse, fine = abs(ended(1e-4)[0] - exact), abs(ended(2.5e-5)[0] - exact)
    assert fine < coarse / 8.0, f"a quarter of the period leaves {fine / coarse:.2f} of {coarse:.2g} rad/s"


def test_inertia_that_is_uncoupled_takes_its_kinetic_energy_along(interior: Factory) -> None:
    drive = interior(magnet_flux=1e-6)
    inertia = Course(np.array([0.0, 0.01, 0.01, 0.02, 0.02]), np.array([1.0, 1.0, 0.4, 0.4, 1.0]))
    schedule = schedule_of(0.0, 60.0, load=steady(1.0), inertia=inertia)
    run = coasted(drive, Load(CONSTANT_TORQUE, 0.0), schedule, duration=0.05, speed=20.0)
    assert final_speed(run) == pytest.approx(20.0, rel=1e-6), "it keeps its speed"
    assert shaft_ledger.shaft_error(run.shaft) < 1e-12
    less = schedule_of(
        0.0, 60.0, load=steady(1.0), inertia=Course(np.array([0.0, 0.01, 0.01]), np.array([1.0, 1.0, 0.4]))
    )
    lighter = coasted(drive, Load(CONSTANT_TORQUE, 0.0), less, duration=0.05, speed=20.0)
    taken = -0.6 * 0.5 * drive.inertia * 20.0**2
    assert lighter.shaft[shaft_ledger.BROUGHT] == pytest.approx(taken, rel=1e-6)


def test_a_rotor_that_locks_loses_its_kinetic_energy(interior: Factory) -> None:
    drive = interior(magnet_flux=1e-6)
    schedule = schedule_of(0.0, 60.0, load=steady(1.0))
    locks = make_failure(LOCKED_ROTOR, 30)
    load = Load(CONSTANT_TORQUE, 0.1)
    run = coasted(drive, load, schedule, duration=0.01, speed=20.0, failure=locks)
    assert final_speed(run) == 0.0
    braked = run.shaft[shaft_ledger.BRAKE]
    assert braked > 0.0
    stopped = 0.5 * drive.inertia * 20.0**2 - braked
    assert run.shaft[shaft_ledger.STOPPED] == pytest.approx(stopped, rel=1e-6)
    assert shaft_ledger.shaft_error(run.shaft) < 1e-12


def test_an_energy_that_a_shaft_gains_between_two_periods_is_not_missed(interior: Factory) -> None:
    drive = interior()
    inputs = DutyLoopInputs(
        drive=drive,
        load=Load(CONSTANT_TORQUE, 0.1),
        schedule=schedule_of(0.0, 60.0, load=steady(1.0)),
        control_period=PERIOD,
        duration=0.01,
        initial_speed=50.0,
    )
    prepared = prepared_duty_loop(inputs, SteppedController(_OFF, 0))
    step = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
    answer = step(_OFF)
    account = prepared.records.shaft

    def grow(state: int, sense: int, command: int) -> None:
        account[shaft_ledger.KINETIC] *= 1.0 - 1e-8
        answer(state, sense, command)

    callback = step(grow)
    exchange = prepared.arguments[5]._replace(step_address=ctypes.cast(callback, ctypes.c_void_p).value)
    arguments = (*prepared.arguments[:5], exchange, *prepared.arguments[6:])
    assert (
        shaft_ledger.shaft_error(prepared_duty_loop(inputs, SteppedController(_OFF, 0)).run().shaft) < 1e-12
    )
    prepared.loop(*arguments)
    assert shaft_ledger.shaft_error(account) > 5e-9

"""The closed loop over the star: controllers that know nothing of it hold its speed, and every period closes."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from tests.models.schedules import schedule_of

from drivegate_models.contract.current.records import nameplate_record
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.controllers.current.builtin import SEARCHES, reset_function, step_function
from drivegate_models.controllers.current.state import CONTROLLER_STATE
from drivegate_models.loop import exchange
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.loop.loop_inputs import CurrentLoopInputs, SteppedController
from drivegate_models.loop.schedule import Course
from drivegate_models.machine.load import CONSTANT_TORQUE, Load
from drivegate_models.star.closed_loop import prepared_loop
from drivegate_models.star.plant.drive import StarDrive

RPM = math.pi / 30.0
CONTROL_PERIOD = 5e-4
BASE_SPEED = 520.0 * RPM


def simulate(drive: StarDrive, speed: float, torque: float, duration: float) -> ClosedLoopRun:
    """Return a run with the reference controller, whose load comes after 0.2 s."""
    state = np.zeros(1, CONTROLLER_STATE)
    nameplate = Nameplate(
        drive.phases,
        drive.pole_pairs,
        48.0,
        BASE_SPEED,
        1500.0,
        drive.current_limit,
        CONTROL_PERIOD,
        drive.hysteresis_band,
        drive.resistance,
        drive.inductance,
        drive.emf_constant,
        drive.inertia,
        1,
        drive.window,
        drive.phases * drive.window / np.pi,
        np.radians(33.0),
        np.radians(0.043) / RPM,
        1500.0 * RPM,
    )
    reset_function()(state, nameplate_record(nameplate), SEARCHES["reference"])
    load = Course(np.array([0.0, 0.2]), np.array([0.0, 1.0]))
    course = schedule_of(speed, 48.0, load=load)
    return prepared_loop(
        CurrentLoopInputs(
            drive=drive,
            load=Load(CONSTANT_TORQUE, torque, 1.0),
            schedule=course,
            initial_speed=speed,
            base_speed=BASE_SPEED,
            control_period=CONTROL_PERIOD,
            duration=duration,
            windows=[(0.5 * duration, duration)],
        ),
        SteppedController(step_function().address, state.ctypes.data),
    ).run()


@pytest.mark.parametrize("rpm", [300.0, 1000.0, 1500.0])
def test_the_reference_controller_holds_the_speed(star: Callable[..., StarDrive], rpm: float) -> None:
    drive = star(hysteresis_band=0.25, core_loss_conductance=3e-3, inertia=0.05)
    torque = 0.6 * 1500.0 / max(rpm * RPM, BASE_SPEED)
    run = simulate(drive, rpm * RPM, torque, 3.0)
    assert run.status == exchange.COMPLETED
    assert run.observed.exchange_error < 1e-9, "a control period does not close"
    window = run.windows[0]
    assert abs(window.speed - rpm * RPM) < 0.01 * BASE_SPEED, f"the speed is {window.speed / RPM:.1f} rpm"
    assert window.torque == pytest.approx(torque, rel=0.05), "the mean torque does not carry the load"

"""Which currents the controllers of duty ratios choose: least current, least loss by model and by search, weakening."""

from __future__ import annotations

import numpy as np
import pytest
from tests.models.duty_runs import COLUMN, controlled, course, limits_of, rating
from tests.models.pm_ac.conftest import INTERIOR, SURFACE

from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.loop.schedule import Course, steady
from drivegate_models.machine.load import CONSTANT_POWER, CONSTANT_TORQUE, Load
from drivegate_models.pm_ac.oracle import LOSS, greatest_torque, least_at
from drivegate_models.pm_ac.plant.drive import Modulator, PmAcDrive, make_pm_ac_drive


def machine(name: str, dead_time: float = 0.0) -> PmAcDrive:
    """Return a machine with a core."""
    constants, resistance = (SURFACE, 240.0) if name == "surface" else (INTERIOR, 330.0)
    return make_pm_ac_drive(
        **constants, core_loss_conductance=1.0 / resistance, modulator=Modulator(dead_time=dead_time)
    )


def loss_above_least(drive: PmAcDrive, name: str, speed: float, torque: float, duration: float) -> float:
    """Return by what share a controller's steady loss lies above the least."""
    run = controlled(
        drive,
        Load(CONSTANT_TORQUE, torque),
        course(drive, steady(speed), steady(1.0)),
        duration,
        name=name,
        initial_speed=speed,
    )
    assert run.status == COMPLETED
    late = run.trace[-2000:]
    made = late[:, COLUMN["torque"]].mean()
    loss = late[:, COLUMN["input_power"]].mean() - made * late[:, COLUMN["speed"]].mean()
    return float(loss / least_at(drive, limits_of(drive), speed, made, LOSS).loss - 1.0)


@pytest.mark.parametrize("share", [0.3, 0.9, 1.5])
@pytest.mark.parametrize("kind", ["interior", "surface"])
@pytest.mark.parametrize(("name", "duration"), [("foc-loss-model", 0.6), ("foc-loss-search", 2.0)])
def test_with_free_voltage_the_loss_is_least(name: str, duration: float, kind: str, share: float) -> None:
    drive = machine(kind)
    speed = share * rating(drive)[0]
    torque = 0.2 * greatest_torque(drive, limits_of(drive), speed).torque
    above = loss_above_least(drive, name, speed, torque, duration)
    assert abs(above) < 0.005, f"{name} makes {100.0 * above:.2f} % more loss than the least"


def test_least_current_is_far_from_least_loss_at_light_load() -> None:
    drive = machine("surface")
    speed = 2.0 * rating(drive)[0]
    torque = 0.2 * greatest_torque(drive, limits_of(drive), speed).torque
    above = loss_above_least(drive, "foc", speed, torque, 0.6)
    assert 0.5 < above < 0.8, f"{100.0 * above:.0f} % above the least loss"


def test_without_a_known_core_the_model_takes_least_current() -> None:
    drive = machine("surface")._replace(core_loss_conductance=0.0)
    speed = 0.5 * rating(drive)[0]
    run = controlled(
        drive,
        Load(CONSTANT_TORQUE, 5.0),
        course(drive, steady(speed), steady(1.0)),
        0.3,
        name="foc-loss-model",
        initial_speed=speed,
    )
    assert abs(run.trace[-500:, COLUMN["direct"]].mean()) < 0.01


def into_weakening(drive: PmAcDrive, name: str, share: float, duration: float) -> tuple[float, float, float]:
    """Return end speed over three times base speed, torque over that wanted, and peak current over its limit."""
    base, power = rating(drive)
    reference = Course(np.array([0.0, 0.5 * duration]), np.array([0.0, 3.0 * base]))
    load = Course(np.array([0.0, 0.65 * duration, 0.65 * duration]), np.array([0.0, 0.0, 1.0]))
    run = controlled(
        drive, Load(CONSTANT_POWER, share * power), course(drive, reference, load), duration, name=name
    )
    assert run.status == COMPLETED
    late = run.trace[-2000:]
    return (
        float(late[:, COLUMN["speed"]].mean() / (3.0 * base)),
        float(late[:, COLUMN["torque"]].mean() / (share * power / (3.0 * base))),
        float(run.trace[:, COLUMN["peak_current"]].max() / drive.current_limit),
    )


@pytest.mark.parametrize("dead_time", [0.0, 2e-6])
@pytest.mark.parametrize(("kind", "duration"), [("interior", 1.5), ("surface", 3.0)])
@pytest.mark.parametrize("name", ["foc-loss-model", "foc-loss-search", "predictive-flux", "direct-torque"])
def test_other_controllers_than_foc_hold_constant_power_up_to_three_times_base_speed(
    name: str, kind: str, duration: float, dead_time: float
) -> None:
    speed, torque, peak = into_weakening(machine(kind, dead_time), name, 0.85, duration)
    assert speed == pytest.approx(1.0, abs=2e-3)
    assert torque == pytest.approx(1.0, rel=1e-2)
    assert peak < 1.05


@pytest.mark.parametrize("kind", ["interior", "surface"])
def test_without_weakening_the_speed_stalls(kind: str) -> None:
    drive = machine(kind)
    speed, _, peak = into_weakening(drive, "foc-mtpa", 0.85, 1.5)
    assert speed < 0.8, f"it reaches {speed:.2f} of three times base speed"
    assert peak < 1.2
    # Below base speed it is the same controller.
    below = 0.5 * rating(drive)[0]
    load, schedule = Load(CONSTANT_TORQUE, 0.5), course(drive, steady(below), steady(1.0))
    runs = [
        controlled(drive, load, schedule, 0.1, name=name, initial_speed=below) for name in ("foc", "foc-mtpa")
    ]
    assert runs[0].trace.tobytes() == runs[1].trace.tobytes()

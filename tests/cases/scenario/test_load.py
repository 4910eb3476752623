import math

import pytest

from drivegate_cases.scenario.load import GRAVITY, ConstantPowerLoad, ConstantTorqueLoad, FanLoad, VehicleLoad

FULL = ((0.0, 1.0),)


def test_a_constant_torque_does_not_depend_on_speed() -> None:
    load = ConstantTorqueLoad(kind="constant_torque", torque_nm=9.8, factor=FULL)
    assert load.torque_at(0.0) == load.torque_at(1500.0) == 9.8


def test_a_constant_power_is_torque_times_speed() -> None:
    load = ConstantPowerLoad(kind="constant_power", power_w=1500.0, factor=FULL)
    for speed in (550.0, 1500.0):
        assert load.torque_at(speed) * speed * 2.0 * math.pi / 60.0 == pytest.approx(1500.0)


def test_a_fan_asks_for_four_times_the_torque_at_twice_the_speed() -> None:
    load = FanLoad(kind="fan", torque_nm=10.0, speed_rpm=1000.0, factor=FULL)
    assert load.torque_at(1000.0) == 10.0
    assert load.torque_at(2000.0) == 40.0
    assert load.torque_at(0.0) == 0.0


@pytest.mark.parametrize("speed", [600.0, -600.0])
@pytest.mark.parametrize("grade", [0.0, 10.0, -10.0])
def test_backward_a_road_that_rises_forward_drives_a_vehicle(speed: float, grade: float) -> None:
    load = VehicleLoad(
        kind="vehicle",
        mass_kg=10.0,
        wheel_radius_m=0.1,
        gear_ratio=2.0,
        rolling_resistance=0.01,
        drag_area_m2=0.5,
        grade_percent=((0.0, grade),),
    )
    slope = math.atan(grade / 100.0)
    rolling = 10.0 * GRAVITY * math.cos(slope) * 0.01
    drag = 0.5 * 1.2 * 0.5 * (600.0 * math.pi / 30.0 * 0.05) ** 2
    weight = math.copysign(10.0 * GRAVITY * math.sin(slope), grade * speed)
    assert load.torque_at(speed, grade) == pytest.approx(0.05 * (rolling + drag + weight), rel=1e-12)

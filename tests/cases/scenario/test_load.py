import math

import pytest

from drivegate_cases.scenario.load import ConstantPowerLoad, ConstantTorqueLoad, FanLoad

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

"""Torques of loads: what opposes the rotation, and a weight, which keeps its sense."""

from __future__ import annotations

import math

import pytest

from drivegate_models.machine.load import (
    CONSTANT_POWER,
    CONSTANT_TORQUE,
    FAN,
    HOIST,
    LOCKED,
    SLOWEST,
    VEHICLE,
    Load,
    opposing_torque,
    weight_torque,
)

pytestmark = pytest.mark.kernel


def test_kinds_of_load() -> None:
    assert opposing_torque(Load(CONSTANT_TORQUE, 7.0, 1.0), 0.5, 10.0) == 3.5
    assert opposing_torque(Load(CONSTANT_POWER, 100.0, 1.0), 1.0, 20.0) == 5.0
    assert opposing_torque(Load(CONSTANT_POWER, 100.0, 1.0), 1.0, 0.0) == 100.0 / SLOWEST
    assert opposing_torque(Load(FAN, 8.0, 40.0), 1.0, 20.0) == pytest.approx(2.0)
    assert opposing_torque(Load(LOCKED, 0.0, 1.0), 1.0, 20.0) == 0.0
    for kind in (CONSTANT_TORQUE, CONSTANT_POWER, FAN, LOCKED):
        assert weight_torque(Load(kind, 7.0, 1.0), 1.0) == 0.0


def test_a_weight_does_not_oppose_and_what_opposes_is_no_weight() -> None:
    assert opposing_torque(Load(HOIST, 3.0), 1.0, 5.0) == 0.0
    assert weight_torque(Load(HOIST, 3.0), 0.5) == 1.5
    vehicle = Load(VEHICLE, 40.0, rolling=0.02, drag=1e-3)
    for grade in (-0.3, 0.0, 0.3):
        slope = math.atan(grade)
        rolling = 0.02 * 40.0 * math.cos(slope)
        assert opposing_torque(vehicle, grade, 10.0) == pytest.approx(rolling + 0.1, rel=1e-14)
        assert weight_torque(vehicle, grade) == pytest.approx(40.0 * math.sin(slope), rel=1e-14)

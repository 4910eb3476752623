"""The observer of the stator flux follows a machine of known motion, from wrong beginnings, in both senses."""

from __future__ import annotations

import cmath
from math import degrees, pi, radians
from typing import Any

import numpy as np
import pytest

from drivegate_models.contract.duty.records import DUTY_NAMEPLATE
from drivegate_models.controllers.duty.current_regulator import reset_regulator
from drivegate_models.controllers.duty.flux_observer import (
    argument,
    observe_rotor,
    place_rotor,
    reset_flux_observer,
)
from drivegate_models.controllers.duty.sensorless_state import SENSORLESS_STATE
from drivegate_models.machine.cycle import within_half_turn

pytestmark = pytest.mark.kernel

PERIOD = 1e-4
RESISTANCE, DIRECT, QUADRATURE, FLUX = 3.6, 36e-3, 51e-3, 0.545


def observer() -> Any:
    plate: Any = np.zeros(1, DUTY_NAMEPLATE).view(np.recarray)[0]
    plate.control_period, plate.pole_pairs, plate.control_every = PERIOD, 3, 1
    plate.resistance, plate.magnet_flux, plate.current_limit = RESISTANCE, FLUX, 9.1
    plate.direct_inductance, plate.quadrature_inductance = DIRECT, QUADRATURE
    state: Any = np.zeros(1, SENSORLESS_STATE).view(np.recarray)[0]
    state.machine.control_period = PERIOD
    state.least_speed = 35.0
    reset_regulator(state.machine, plate)
    reset_flux_observer(state, plate)
    return state


def follow(state: Any, speed: float, current: complex, steps: int) -> float:
    """Turn a machine at constant speed (rad/s) and d-q current (A); return the error of the angle (rad)."""
    linkage = DIRECT * current.real + FLUX + 1j * QUADRATURE * current.imag
    angle = 0.0
    for _ in range(steps):
        turned = cmath.exp(1j * angle)
        ahead = cmath.exp(1j * (angle + speed * PERIOD))
        # The mean voltage of the period: that of the flux's change and across the resistance.
        voltage = linkage * (ahead - turned) / PERIOD + 0.5 * RESISTANCE * current * (ahead + turned)
        state.along_before, state.across_before = (current * turned).real, (current * turned).imag
        measured = current * ahead
        observe_rotor(state, measured.real, measured.imag, (voltage.real, voltage.imag))
        angle += speed * PERIOD
    return within_half_turn(state.angle - angle)


@pytest.mark.parametrize("degree", range(-175, 180, 25))
def test_the_argument_of_a_vector(degree: int) -> None:
    vector = 2.0 * cmath.exp(1j * radians(degree))
    assert degrees(argument(vector.real, vector.imag)) == pytest.approx(degree, abs=1e-9)


def test_the_argument_of_a_half_turn() -> None:
    assert abs(argument(-1.0, 0.0)) == pytest.approx(pi)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("speed", [80.0, 800.0, -80.0, -800.0])
@pytest.mark.parametrize("off_deg", [0.0, 60.0, -60.0])
def test_it_converges_to_angle_and_speed(speed: float, off_deg: float) -> None:
    state, current = observer(), 0.5 + 4.0j
    place_rotor(state, radians(off_deg), 0.9 * speed, current.real, current.imag)
    error = follow(state, speed, current, 2500)
    assert degrees(error) == pytest.approx(0.0, abs=0.5)
    assert state.speed == pytest.approx(speed, rel=1e-3)
    assert state.flux_error == pytest.approx(0.0, abs=1e-3)


def test_a_wrong_resistance_costs_angle_at_low_speed_alone() -> None:
    errors = []
    for speed in (40.0, 400.0):
        state, current = observer(), 4.0j
        state.machine.resistance = 1.1 * RESISTANCE
        place_rotor(state, 0.0, speed, current.real, current.imag)
        errors.append(abs(degrees(follow(state, speed, current, 2500))))
    assert errors[0] > 2.0 > errors[1]

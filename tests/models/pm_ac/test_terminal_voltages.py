"""Voltages of the terminals that controllers of duty ratios sense, with the bridge off and with conducting legs."""

from __future__ import annotations

from math import pi
from typing import Any, Final

import numpy as np
import pytest
from tests.models.duty_runs import PERIOD
from tests.models.pm_ac.conftest import INTERIOR, SURFACE
from tests.models.pm_ac.recorded_senses import Recorded, motoring, recorded

from drivegate_models.contract.duty.signals import LEG_HIGH, LEG_LOW, LEG_OFF
from drivegate_models.pm_ac.plant.drive import Modulator, PmAcDrive, make_pm_ac_drive

SWITCH: Final = 1.1
DIODE: Final = 0.7
START: Final = 2.5
"""Electrical angle at the start (rad)."""
EITHER_WAY: Final = pytest.mark.parametrize("way", [1.0, -1.0], ids=["forward", "backward"])
LEGS: Final = ("first_leg", "second_leg", "third_leg")


def drive_of(pole_pairs: int, machine: dict[str, Any] = SURFACE, **changes: Any) -> PmAcDrive:
    """Return a drive with forward drops."""
    drops = {"switch_drop": SWITCH, "diode_drop": DIODE}
    return make_pm_ac_drive(**(machine | {"pole_pairs": pole_pairs} | drops | changes))


def legs_are(*legs: int) -> Any:
    """Return answers that set the legs."""

    def answer(_sense: Any, command: Any) -> None:
        for name in ("first_duty", "second_duty", "third_duty"):
            command[name] = 0.5
        for name, leg in zip(LEGS, legs, strict=True):
            command[name] = leg

    return answer


def flux_of_the_third(shown: Recorded) -> np.ndarray:
    """Return the flux linkage of the third phase at the start of each period, from the second on, shape (n,) (V s)."""
    drive, angle = shown.drive, shown.column("angle") - 4.0 * pi / 3.0
    direct, quadrature = (
        np.concatenate(([0.0], shown.column(name)[:-1])) for name in ("direct", "quadrature")
    )
    along = drive.direct_inductance * direct + drive.magnet_flux
    return np.asarray(np.cos(angle) * along - np.sin(angle) * drive.quadrature_inductance * quadrature)


def emfs(shown: Recorded) -> np.ndarray:
    """Return the back-EMFs of the phases at the start of each period, shape (n, 3) (V)."""
    electrical = shown.drive.pole_pairs * shown.column("speed")
    angles = shown.drive.pole_pairs * shown.turned(START / shown.drive.pole_pairs)
    return np.asarray(
        -(electrical * shown.drive.magnet_flux)[:, None]
        * np.sin(angles[:, None] - np.arange(3) * 2.0 * pi / 3.0)
    )


@EITHER_WAY
@pytest.mark.parametrize("pole_pairs", [3, 7])
def test_a_bridge_that_is_off_shows_the_emf_above_the_lowest_terminal(pole_pairs: int, way: float) -> None:
    drive = drive_of(pole_pairs)
    speed = way * 0.9 * drive.link_voltage / (3.0**0.5 * pole_pairs * drive.magnet_flux)
    shown = recorded(drive, speed, 300, legs_are(LEG_OFF, LEG_OFF, LEG_OFF), initial_angle=START)
    assert not shown.currents.any(), "the EMF is below the link"
    induced = emfs(shown)
    voltages = shown.senses["phase_voltages"]
    assert voltages == pytest.approx(induced - induced.min(axis=1)[:, None] - DIODE, abs=1e-9)
    assert voltages.max() > 0.8 * drive.link_voltage


@EITHER_WAY
def test_they_show_angle_and_speed_of_a_shaft_without_a_sensor(way: float) -> None:
    drive = drive_of(3)
    shown = recorded(drive, way * 250.0, 200, legs_are(LEG_OFF, LEG_OFF, LEG_OFF), initial_angle=START)
    first, second, third = shown.senses["phase_voltages"].T
    vector = (2.0 * first - second - third) / 3.0 + 1j * (second - third) / 3.0**0.5
    turned = np.angle(vector[1:] / vector[:-1])
    assert turned / (drive.pole_pairs * PERIOD) == pytest.approx(way * 250.0, rel=1e-9)
    # The EMF is a quarter of an electrical turn ahead of the magnet, seen in the direction of rotation.
    behind = np.angle(vector * np.exp(-1j * (drive.pole_pairs * shown.turned(START / 3) + way * 0.5 * pi)))
    assert np.abs(behind).max() < 1e-9


@EITHER_WAY
def test_a_leg_that_conducts_shows_its_switch_or_diode(way: float) -> None:
    drive = drive_of(3)
    shown = recorded(drive, way * 250.0, 300, motoring(drive), initial_angle=START)
    # Between two pulses all lower switches are on.
    expected = np.where(shown.currents > 0.0, -DIODE, SWITCH)[2:]
    assert shown.senses["phase_voltages"][2:] == pytest.approx(expected, abs=1e-12)


@EITHER_WAY
def test_between_two_half_carriers_the_upper_switches_are_on(way: float) -> None:
    drive = drive_of(3, modulator=Modulator(updates=2, update_delay=1))
    shown = recorded(drive, way * 250.0, 300, motoring(drive), initial_angle=START)
    upper = np.where(shown.currents > 0.0, drive.link_voltage - SWITCH, drive.link_voltage + DIODE)
    lower = np.where(shown.currents > 0.0, -DIODE, SWITCH)
    voltages = shown.senses["phase_voltages"]
    assert voltages[3::2] == pytest.approx(upper[3::2], abs=1e-12)
    assert voltages[4::2] == pytest.approx(lower[4::2], abs=1e-12)


@EITHER_WAY
@pytest.mark.parametrize("machine", [SURFACE, INTERIOR], ids=["surface", "interior"])
def test_a_leg_that_is_off_between_two_that_conduct_shows_its_emf(
    machine: dict[str, Any], way: float
) -> None:
    drive = drive_of(3, machine, switch_drop=0.0, diode_drop=0.0)
    shown = recorded(drive, way * 30.0, 400, legs_are(LEG_HIGH, LEG_LOW, LEG_OFF), initial_angle=START)
    voltages = shown.senses["phase_voltages"]
    assert (voltages[2:, 0] == drive.link_voltage).all()
    assert (voltages[2:, 1] == 0.0).all()
    is_held = np.abs(shown.currents[:, 2]) < 1e-9
    # In periods between two others without current in this leg.
    held = 3 + np.flatnonzero(is_held[2:-2] & is_held[3:-1] & is_held[4:])
    assert len(held) > 100
    flux = flux_of_the_third(shown)
    induced = (flux[held + 1] - flux[held - 1]) / (2.0 * PERIOD)
    assert voltages[held, 2] == pytest.approx(0.5 * drive.link_voltage + 1.5 * induced, abs=0.02)
    assert np.ptp(voltages[held, 2]) > 5.0


@EITHER_WAY
def test_a_bridge_that_is_off_and_rectifies_shows_its_diodes_from_the_first_step(way: float) -> None:
    drive = drive_of(3)
    speed = way * 1.5 * drive.link_voltage / (3.0**0.5 * 3 * drive.magnet_flux)
    shown = recorded(drive, speed, 200, legs_are(LEG_OFF, LEG_OFF, LEG_OFF), initial_angle=START)
    voltages, currents = shown.senses["phase_voltages"], shown.currents
    assert voltages[currents > 1e-6] == pytest.approx(-DIODE, abs=1e-12)
    assert voltages[currents < -1e-6] == pytest.approx(drive.link_voltage + DIODE, abs=1e-12)
    assert currents[0].any()

"""Where in the plane of d and q current a PM AC drive is best, and its efficiency."""

from __future__ import annotations

from math import hypot, sqrt

import pytest

from drivegate.contracts.duty.best_operation import efficiency_map, known_map, trajectories
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.pm_ac.fundamental import steady_state
from drivegate_models.pm_ac.oracle import greatest_torque, undistorted_limits
from drivegate_models.units import RADIANS_PER_RPM


def drive_of(name: str) -> PmAcDocument:
    drive = load_drive(name)
    assert isinstance(drive, PmAcDocument)
    return drive


def test_most_torque_per_ampere_is_the_closed_form() -> None:
    drive = drive_of("pm-ac-interior")
    plant = drive.plant()
    saliency = plant.quadrature_inductance - plant.direct_inductance
    for row in trajectories(drive)["most_torque_per_ampere"][1:]:
        current = row["current_a"]
        root = sqrt(plant.magnet_flux**2 + 8.0 * saliency**2 * current**2)
        assert row["direct_a"] == pytest.approx((plant.magnet_flux - root) / (4.0 * saliency), rel=1e-9)
        assert hypot(row["direct_a"], row["quadrature_a"]) == pytest.approx(current, rel=1e-12)


@pytest.mark.parametrize("name", ["pm-ac-surface", "pm-ac-interior", "pm-ac-2kw", "pm-ac-msl"])
def test_the_ellipses_take_the_voltage_and_weakening_stays_within(name: str) -> None:
    drive = drive_of(name)
    plant = drive.plant()
    limits = undistorted_limits(plant)
    stated = trajectories(drive)
    assert [row["speed_rpm"] for row in stated["voltage_limits"]] == [
        drive.rating.base_speed_rpm,
        drive.rating.highest_speed_rpm,
    ]
    for row in stated["voltage_limits"]:
        for direct, quadrature in zip(row["direct_a"], row["quadrature_a"], strict=True):
            state = steady_state(plant, row["speed_rpm"] * RADIANS_PER_RPM, direct, quadrature)
            assert state.voltage == pytest.approx(limits.voltage, rel=1e-9)
    for row in stated["greatest_torque"]:
        state = steady_state(plant, row["speed_rpm"] * RADIANS_PER_RPM, row["direct_a"], row["quadrature_a"])
        assert state.current <= limits.current * (1.0 + 1e-9)
        assert state.voltage <= limits.voltage * (1.0 + 1e-9)
        assert state.torque == pytest.approx(row["torque_nm"], rel=1e-9)


def test_the_efficiency_reaches_up_to_the_greatest_torque() -> None:
    drive = drive_of("pm-ac-interior")
    plant = drive.plant()
    charted = efficiency_map(drive)
    speeds, torques, values = known_map(charted)
    assert len(speeds) == len(charted["speed_rpm"]), "torque is in reach at every speed"
    for speed, row, efficiencies in zip(speeds, torques, values, strict=True):
        state = greatest_torque(plant, undistorted_limits(plant), speed[0] * RADIANS_PER_RPM)
        assert row[-1] == pytest.approx(state.torque, rel=1e-12)
        power = state.torque * speed[0] * RADIANS_PER_RPM
        # At the greatest torque there is one choice of currents alone.
        assert efficiencies[-1] == pytest.approx(100.0 * power / (power + state.loss), rel=1e-4)
        assert all(0.0 < value < 100.0 for value in efficiencies)


def test_speeds_without_torque_are_left_out_of_the_map() -> None:
    charted = {
        "speed_rpm": [1.0, 2.0, 3.0],
        "torque_nm": [[1.0, 2.0], [1.0, 2.0], [None, None]],
        "efficiency_percent": [[50.0, 60.0], [50.0, 60.0], [None, None]],
    }
    assert known_map(charted)[0] == [[1.0, 1.0], [2.0, 2.0]]
    assert known_map({key: rows[1:] for key, rows in charted.items()}) == ([], [], [])

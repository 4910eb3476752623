"""A drive cycle as a run: brakes, energy and distance."""

import numpy as np
import pytest

from drivegate.candidates.builtin.loading import BuiltinController
from drivegate.contracts.current.comparison.drive_cycle import (
    braking_grade,
    cycle_figures,
    cycle_scenario,
    cycle_vehicle,
)
from drivegate.drives.running import run_scenario
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.drive_cycle import DriveCycle, load_drive_cycle
from drivegate_cases.scenario.load import GRAVITY
from drivegate_cases.scenario.sensors import MCS96
from drivegate_models.controllers.current.builtin import SEARCHES
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

DRIVE = load_drive("paper-5-phase")
VEHICLE = cycle_vehicle(DRIVE)
SHORT = DriveCycle(
    name="short", speed_km_h=((0.0, 0.0), (1.0, 0.0), (6.0, 20.0), (9.0, 20.0), (13.0, 0.0), (15.0, 0.0))
)


@pytest.fixture(scope="module")
def short_figures():
    scenario = cycle_scenario(SHORT, DRIVE)
    run = run_scenario(scenario, BuiltinController(SEARCHES["reference"]), trace_every=1)
    return cycle_figures(scenario, run)


def test_the_reference_is_the_cycle_s_speed_through_wheel_and_gear():
    scenario = cycle_scenario(load_drive_cycle("ece-15"), DRIVE)
    highest = max(speed for _, speed in scenario.speed_rpm)
    assert highest * RADIANS_PER_RPM * VEHICLE.lever_m * 3.6 == pytest.approx(50.0)
    assert scenario.duration_s == 195.0
    assert scenario.sensors.kind == "ideal"
    assert cycle_scenario(SHORT, DRIVE, noise_seed=3).sensors.kind == MCS96.kind


def test_the_vehicle_of_the_paper_s_drive_is_a_scooter():
    assert VEHICLE.model_dump(exclude={"kind", "air_density_kg_m3", "grade_percent"}) == {
        "mass_kg": 130.0,
        "wheel_radius_m": 0.25,
        "gear_ratio": 3.0,
        "rolling_resistance": 0.01,
        "drag_area_m2": 0.4,
    }


@pytest.mark.parametrize("name", ["fan-3-phase", "traction-7-phase"])
def test_the_vehicle_of_another_drive_takes_the_same_share_of_its_rating(name):
    drive = load_drive(name)

    def shares(of):
        vehicle, rating = cycle_vehicle(of), of.rating
        shaft_rpm = 50.0 / 3.6 / vehicle.lever_m / RADIANS_PER_RPM
        power = vehicle.torque_at(shaft_rpm) * shaft_rpm * RADIANS_PER_RPM
        return (
            vehicle.mass_kg / rating.rated_power_w,
            shaft_rpm / rating.highest_speed_rpm,
            power / rating.rated_power_w,
        )

    assert shares(drive) == pytest.approx(shares(DRIVE), rel=0.03)


def test_the_vehicle_stays_below_overspeed():
    rating = DRIVE.rating
    drive = DRIVE.replaced(overspeed_rpm=rating.highest_speed_rpm)
    highest = max(speed for _, speed in cycle_scenario(load_drive_cycle("ece-15"), drive).speed_rpm)
    assert highest < drive.rating.overspeed_rpm


def test_the_brake_gives_what_coasting_does_not():
    grade = braking_grade(SHORT, DRIVE)
    slope = [percent for time, percent in grade if time == 9.0][-1] / 100.0
    brake = VEHICLE.mass_kg * GRAVITY * slope / np.hypot(1.0, slope)
    by_itself = VEHICLE.mass_kg * GRAVITY * 0.010 + 0.5 * 1.2 * 0.4 * (20.0 / 3.6) ** 2
    mass = VEHICLE.mass_kg + DRIVE.machine.inertia_kg_m2 / VEHICLE.lever_m**2
    assert brake + by_itself == pytest.approx(mass * (20.0 / 3.6) / 4.0, rel=1e-3)
    assert [percent for time, percent in grade if 1.0 < time < 9.0] == [0.0], "nobody brakes while driving"
    assert grade[-1] == (15.0, 5.0), "the brake holds the vehicle at a stop"


def test_a_cycle_without_braking_has_no_brake():
    rising = DriveCycle(name="rising", speed_km_h=((0.0, 5.0), (10.0, 20.0)))
    assert {percent for _, percent in braking_grade(rising, DRIVE)} == {0.0}


def test_a_cycle_that_brakes_too_hard_is_refused():
    crash = DriveCycle(name="crash", speed_km_h=((0.0, 50.0), (1.0, 0.0)))
    with pytest.raises(
        InputError, match=r"'crash' slows down by 13\.9 m/s² at 0 s, but may by 6 m/s² at most"
    ):
        cycle_scenario(crash, DRIVE)


def test_the_reference_controller_follows_and_stops(short_figures):
    assert short_figures["outside_tolerance_s"] == 0.0
    assert short_figures["distance_km"] == pytest.approx(SHORT.distance_m / 1000.0, rel=0.002)
    assert abs(short_figures["samples"]["speed_km_h"][-1]) < 0.1, "the vehicle stands in the end"


def test_energy_is_what_physics_asks_for(short_figures):
    # Kinetic energy and rolling resistance at the least; the drive's losses come on top.
    lowest = 0.5 * VEHICLE.mass_kg * (20.0 / 3.6) ** 2 / 3600.0
    assert lowest < short_figures["shaft_energy_wh"] < short_figures["energy_wh"] < 2.0 * lowest
    assert sum(short_figures["energy_wh_by_phase"].values()) == pytest.approx(
        short_figures["energy_wh"], rel=1e-9
    )
    by_phase = short_figures["energy_wh_by_phase"]
    assert by_phase["accelerating"] > by_phase["cruising"] > by_phase["slowing"]
    assert short_figures["energy_wh_per_km"] == pytest.approx(
        short_figures["energy_wh"] / short_figures["distance_km"]
    )

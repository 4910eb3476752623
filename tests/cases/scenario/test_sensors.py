"""Which sensors a drive has: converters of its own size, and Hall switches where there is no encoder."""

import pytest

from drivegate_cases.drive.converter_ranges import converter_ranges
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import HALL, MCS96, HallSensors, counted_s, has_encoder, real_sensors

STAR = load_drive("star-3-phase")
RUN = Scenario(
    name="run",
    drive=STAR,
    duration_s=1.0,
    initial_speed_rpm=700.0,
    speed_rpm=((0.0, 700.0),),
    load={"kind": "locked"},
    sensors="hall",
)


@pytest.mark.parametrize("name", ["paper-5-phase", "fan-3-phase", "traction-7-phase"])
def test_decoupled_phases_have_the_published_implementation_s_encoder(name: str) -> None:
    assert real_sensors(load_drive(name)) == MCS96
    assert has_encoder(MCS96)


def test_a_star_of_three_phases_has_hall_switches_and_no_encoder() -> None:
    assert real_sensors(STAR) == HALL
    assert not has_encoder(HALL)
    # Three switches do not tell where the windows of five phases lie.
    five = STAR.replaced(phases=5)
    assert real_sensors(five) == MCS96


def test_any_drive_with_three_phases_may_have_hall_switches() -> None:
    assert RUN.replaced(drive=load_drive("fan-3-phase")).sensors.kind == "hall"


def test_the_converters_are_the_drive_s_unless_stated() -> None:
    sensors = RUN.sensors
    assert isinstance(sensors, HallSensors)
    assert sensors.current_range_a == converter_ranges(STAR).current_range_a
    moved = RUN.replaced(drive=load_drive("fan-3-phase")).sensors
    assert isinstance(moved, HallSensors)
    assert moved.current_range_a == converter_ranges(load_drive("fan-3-phase")).current_range_a


def test_the_speed_is_counted_over_the_window_or_over_an_electrical_cycle() -> None:
    assert counted_s(MCS96, 100.0) == MCS96.speed_window_s
    assert counted_s(HALL, 100.0) == pytest.approx(0.0628318530718)

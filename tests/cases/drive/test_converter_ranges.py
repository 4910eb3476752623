"""Converters are chosen for the drive that they measure, unless a scenario states others."""

import pytest

from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.scenario.scenario import Scenario, load_scenario
from drivegate_cases.scenario.sensors import ConverterRanges, Mcs96Sensors, converter_ranges

PAPER, TRACTION = load_drive("paper-5-phase"), load_drive("traction-7-phase")
RUN = load_scenario("fig5-search")


def sensors_of(scenario: Scenario) -> Mcs96Sensors:
    assert isinstance(scenario.sensors, Mcs96Sensors)
    return scenario.sensors


def test_the_drive_of_the_paper_has_the_published_converters() -> None:
    assert converter_ranges(PAPER) == ConverterRanges(
        current_range_a=40.0,
        current_offset_a=0.05,
        current_noise_a=0.02,
        voltage_range_v=100.0,
        voltage_noise_v=0.02,
    )


@pytest.mark.parametrize("drive", [PAPER, TRACTION, load_drive("fan-3-phase")], ids=lambda drive: drive.name)
def test_converters_show_what_the_drive_can_have(drive: DriveDocument) -> None:
    ranges = converter_ranges(drive)
    assert 1.3 * drive.rating.current_limit_a < ranges.current_range_a < 2.0 * drive.rating.current_limit_a
    supply = drive.inverter.supply_voltage_v
    assert 1.5 * supply < ranges.voltage_range_v < 3.0 * supply, "a swell must be seen, and in fine steps"


def test_a_scenario_has_the_converters_of_its_drive_and_changes_them_with_it() -> None:
    noisy = RUN.replaced(sensors="mcs96")
    assert sensors_of(noisy).voltage_range_v == 100.0
    assert sensors_of(noisy.replaced(drive=TRACTION)).voltage_range_v == 620.0


def test_stated_converters_stay() -> None:
    own = RUN.replaced(sensors={"kind": "mcs96", "voltage_range_v": 80.0})
    moved = sensors_of(own.replaced(drive=TRACTION))
    assert (moved.voltage_range_v, moved.current_range_a) == (80.0, 62.0)

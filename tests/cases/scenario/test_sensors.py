"""Which sensors a drive has: converters of its own size, and Hall switches where there is no encoder."""

import pytest

from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import (
    HALL,
    IDEAL,
    MCS96,
    SHUNTS,
    HallSensors,
    ShuntSensors,
    converter_ranges,
    counted_s,
    has_edges,
    has_encoder,
    position_of,
    real_sensors,
)
from drivegate_models.errors import InputError

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

EXACT = load_drive("pm-ac-interior")
BY_HALL = EXACT.with_overrides(["sensing.position=hall"])


@pytest.mark.parametrize("name", ["paper-5-phase", "fan-3-phase", "traction-7-phase"])
def test_decoupled_phases_have_the_published_implementation_s_encoder(name: str) -> None:
    assert real_sensors(load_drive(name)) == MCS96
    assert has_encoder(MCS96, load_drive(name))


def test_a_star_of_three_phases_has_hall_switches_and_no_encoder() -> None:
    assert real_sensors(STAR) == HALL
    assert not has_encoder(HALL, STAR)
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


def test_a_drive_states_what_shows_its_shaft_in_every_run() -> None:
    assert position_of(IDEAL, EXACT) == "exact"
    assert position_of(SHUNTS, EXACT) == "encoder"
    assert not has_edges(IDEAL, EXACT)
    for sensors in (IDEAL, SHUNTS):
        assert position_of(sensors, BY_HALL) == "hall"
        assert has_edges(sensors, BY_HALL)
    assert EXACT.values_hash != BY_HALL.values_hash
    assert BY_HALL.with_overrides(["position=encoder"]).value("position") == "encoder"


def held_on(drive: DriveDocument, sensors: object) -> Scenario:
    """Read a run of a drive whose shaft is held."""
    values = {"schema": 2, "name": "run", "drive": drive.to_mapping(), "duration_s": 0.1, "sensors": sensors}
    held = {"speed_rpm": [[0.0, 700.0]], "load": {"kind": "locked"}}
    return parse_document(values | held, Scenario, "the scenario")


def test_shunts_show_the_shaft_as_the_drive_states() -> None:
    for drive, shown in ((EXACT, "encoder"), (BY_HALL, "hall")):
        sensors = held_on(drive, "shunts").sensors
        assert isinstance(sensors, ShuntSensors)
        assert sensors.position == shown
    moved = held_on(EXACT, "shunts").replaced(drive=BY_HALL).sensors
    assert isinstance(moved, ShuntSensors)
    assert moved.position == "hall"


@pytest.mark.parametrize("position", ["exact", "encoder"])
def test_a_run_with_another_sensor_than_the_drive_has_is_refused(position: str) -> None:
    assert held_on(EXACT, {"kind": "shunts", "position": position})
    with pytest.raises(InputError, match=f"'{position}', but the drive's .sensing. states 'hall'"):
        held_on(BY_HALL, {"kind": "shunts", "position": position})

"""Drives without a position sensor: what they must do at low speed, and what is refused."""

from __future__ import annotations

from math import pi

import pytest

from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.sensorless import natural_period_s
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM


def without_sensor(name: str, *overrides: str) -> PmAcDocument:
    drive = load_drive(name).with_overrides(["sensing.position=none", *overrides])
    assert isinstance(drive, PmAcDocument)
    return drive


def run_of(drive: DriveDocument) -> Scenario:
    load = ConstantTorqueLoad(kind="constant_torque", torque_nm=0.0)
    return Scenario(name="run", drive=drive, duration_s=1.0, load=load, speed_rpm=((0.0, 500.0),))


def test_the_least_speed_is_the_greatest_of_three() -> None:
    # 65 rpm are 5 % of base speed, dead time needs 96 rpm, and the resistance 110 rpm.
    assert without_sensor("pm-ac-2kw").least_speed_rpm == pytest.approx(109.7, abs=0.1)
    ideal = without_sensor("pm-ac-2kw", "resistance_ohm=0.036", "dead_time_s=0")
    assert ideal.least_speed_rpm == pytest.approx(65.0)
    dead = without_sensor("pm-ac-2kw", "resistance_ohm=0.036", "dead_time_s=2e-6")
    emf = 3.0 * 4.0 / pi * 540.0 * 2e-6 * 4000.0
    assert dead.least_speed_rpm == pytest.approx(emf / (3 * 0.545) / RADIANS_PER_RPM)


def test_the_drops_of_switch_and_diode_count_as_dead_time_does() -> None:
    drive = without_sensor("pm-ac-servo")
    lost = 300.0 * 1.5e-6 * 10e3 + 0.5 * (1.6 + 1.5)
    emf = 3.0 * 4.0 / pi * lost
    assert drive.least_speed_rpm == pytest.approx(emf / (4 * 0.0608) / RADIANS_PER_RPM)


def test_the_resistance_decides_at_80_percent_of_rated_torque() -> None:
    drive = without_sensor("pm-ac-surface")
    current = 0.8 * drive.rating.rated_torque_nm / (1.5 * 11 * 0.0308)
    expected = 0.08 * current / (11 * 0.0308) / RADIANS_PER_RPM
    assert drive.least_speed_rpm == pytest.approx(expected)


def test_stated_values_win() -> None:
    drive = without_sensor("pm-ac-2kw", "sensing.least_speed_rpm=200", "sensing.start_time_s=3")
    plate = drive.duty_nameplate(drive.control_period_s, torque_reference=False)
    assert (plate.least_speed, plate.start_time) == (pytest.approx(200.0 * RADIANS_PER_RPM), 3.0)


def test_the_filter_of_mean_voltages_is_on_the_nameplate() -> None:
    drive = without_sensor("pm-ac-2kw", "sensing.mean_voltages=true", "sensing.voltage_filter_hz=300")
    plate = drive.duty_nameplate(drive.control_period_s, torque_reference=False)
    assert plate.voltage_filter == pytest.approx(1.0 / (2.0 * pi * 300.0))


def test_a_heavier_rotor_has_more_time() -> None:
    drive, heavy = without_sensor("pm-ac-2kw"), without_sensor("pm-ac-2kw", "inertia_kg_m2=0.15")
    assert natural_period_s(drive) == pytest.approx(0.105, abs=1e-3)
    assert heavy.start_time_s > drive.start_time_s > 2.0 * natural_period_s(drive)


def test_every_included_drive_exists_without_a_sensor() -> None:
    drive = load_drive("pm-ac-2kw-sensorless")
    assert isinstance(drive, PmAcDocument)
    assert (drive.name, drive.position, drive.machine) == (
        "pm-ac-2kw-sensorless",
        "none",
        load_drive("pm-ac-2kw").machine,
    )


@pytest.mark.parametrize("name", ["paper-5-phase-sensorless", "my-sensorless"])
def test_no_other_name_ends_so(name: str) -> None:
    with pytest.raises(InputError, match=name):
        load_drive(name)


@pytest.mark.parametrize(
    ("overrides", "sentence"),
    [
        (["sensing.position=none", "sensing.least_speed_rpm=1301"], "at most the base speed of 1300 rpm"),
        (["sensing.position=none", "sensing.start_time_s=0.1"], "must be at least 0.105"),
        (["sensing.start_time_s=1"], "'sensing.position' is missing, it gives what shows angle"),
        (["sensing.position=hall", "sensing.start_time_s=1"], "must be left out where 'position' is 'hall'"),
        (
            ["sensing.position=none", "sensing.voltage_filter_hz=300"],
            "left out without 'mean_voltages = true'",
        ),
        (
            ["sensing.position=none", "sensing.mean_voltages=true", "sensing.voltage_filter_hz=1300"],
            "must be at most 1273, where the filter is as slow as a control period",
        ),
    ],
)
def test_what_no_controller_could_do_is_refused(overrides: list[str], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        load_drive("pm-ac-2kw").with_overrides(overrides)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (
            {"sensors": {"kind": "shunts", "encoder_lines": 256}},
            "'encoder_lines' is 256, but must be left out",
        ),
        ({"sensors": {"kind": "shunts", "position": "encoder"}}, "the drive's .sensing. states 'none'"),
        ({"failure": {"kind": "lost-position", "time_s": 0.5}}, "needs a sensor on the shaft"),
        (
            {"dropouts": ({"signal": "speed", "start_s": 0.5, "duration_s": 0.1},)},
            "the dropout of 'speed' needs a sensor on the shaft",
        ),
    ],
)
def test_what_needs_a_sensor_is_refused(given: dict[str, object], sentence: str) -> None:
    plain = run_of(without_sensor("pm-ac-2kw"))
    with pytest.raises(InputError, match=sentence):
        plain.replaced(**given)


def test_a_drive_with_a_sensor_cannot_hide_it() -> None:
    with pytest.raises(InputError, match="the drive has a sensor"):
        run_of(load_drive("pm-ac-2kw")).replaced(sensors={"kind": "shunts", "position": "none"})

"""The document of a PM AC drive: packaged drives, what is refused, and what the plant takes from it."""

from __future__ import annotations

import copy
from typing import Any

import jsonschema
import pytest

from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import DriveDocument, drive_names, load_drive
from drivegate_cases.drive.drive_file import drive_schema, drive_toml
from drivegate_cases.drive.limits import limits_of, mechanical_time
from drivegate_cases.drive.plant import Scales
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError
from drivegate_models.pm_ac.fundamental import LINEAR_LIMIT
from drivegate_models.pm_ac.oracle import Limits, greatest_torque
from drivegate_models.units import RADIANS_PER_RPM

PACKAGED = (
    "pm-ac-2kw",
    "pm-ac-chopper",
    "pm-ac-hub",
    "pm-ac-interior",
    "pm-ac-msl",
    "pm-ac-servo",
    "pm-ac-servo-48v",
    "pm-ac-surface",
)
VOLTAGE_IN_HAND = 0.98


def packaged(name: str) -> PmAcDocument:
    drive = load_drive(name)
    assert isinstance(drive, PmAcDocument)
    return drive


def test_the_packaged_drives_are_of_this_kind() -> None:
    assert tuple(name for name in drive_names() if load_drive(name).kind == "pm-ac") == PACKAGED


@pytest.mark.parametrize("name", PACKAGED)
def test_every_value_of_a_packaged_drive_has_a_source_and_its_rating_is_in_reach(name: str) -> None:
    drive = packaged(name)
    for table in drive.tables:
        if table in ("requirements", "sensing") or table not in drive.to_mapping():
            # What its file leaves out has a default.
            continue
        stated = set(drive.to_mapping().get(table, {}))
        assert stated == set(drive.provenance.get(table, {})), f"{table} has values without a sentence"
    plant, rating = drive.plant(), drive.rating
    limits = Limits(plant.current_limit, VOLTAGE_IN_HAND * LINEAR_LIMIT * plant.link_voltage)
    for speed in (rating.base_speed_rpm, rating.highest_speed_rpm):
        power = greatest_torque(plant, limits, speed * RADIANS_PER_RPM).torque * speed * RADIANS_PER_RPM
        assert power > rating.rated_power_w, f"{power:.0f} W at {speed:g} rpm"
    jsonschema.validate(drive.to_mapping(), drive_schema())
    assert parse_document(drive.to_mapping(), DriveDocument, "again") == drive
    assert f'name = "{name}"' in drive_toml(drive)


def test_the_plant_differs_from_the_document_by_the_scales_alone() -> None:
    drive = packaged("pm-ac-interior")
    plant = drive.plant(Scales(resistance=2.0, inductance=0.7, emf_constant=0.8, friction_added_n_m=0.1))
    nominal = drive.plant()
    assert plant.resistance == pytest.approx(2.0 * nominal.resistance)
    assert plant.direct_inductance == pytest.approx(0.7 * nominal.direct_inductance)
    assert plant.quadrature_inductance == pytest.approx(0.7 * nominal.quadrature_inductance)
    assert plant.magnet_flux == pytest.approx(0.8 * nominal.magnet_flux)
    assert plant.friction == pytest.approx(0.1)
    assert drive.duty_nameplate(1e-4, torque_reference=True).resistance == nominal.resistance
    assert packaged("pm-ac-2kw").control_period_s == pytest.approx(125e-6), "two updates a period of 4 kHz"


def test_a_limit_that_is_left_out_follows_from_the_drive() -> None:
    drive = packaged("pm-ac-interior")
    limits = limits_of(drive)
    assert limits.speed_tolerance_rpm == pytest.approx(0.01 * drive.rating.base_speed_rpm)
    assert limits.peak_a == pytest.approx(1.2 * drive.rating.current_limit_a + limits.peak_ripple_a)
    stated = drive.with_overrides(["peak_current_percent=150", "requirements.settling_s=0.3"])
    assert isinstance(stated, PmAcDocument)
    assert limits_of(stated).peak_a == pytest.approx(
        1.5 * drive.rating.current_limit_a + limits.peak_ripple_a
    )
    assert limits_of(stated).settling_s == limits_of(stated).held_settling_s == 0.3


def test_a_speed_settles_in_the_longer_of_control_periods_and_mechanical_times() -> None:
    drive = packaged("pm-ac-interior")
    periods = 8000 * drive.control_period_s
    assert limits_of(drive).settling_s == limits_of(drive).held_settling_s == periods
    heavy = drive.replaced(inertia_kg_m2=30.0 * drive.machine.inertia_kg_m2)
    assert limits_of(heavy).settling_s == pytest.approx(3.0 * mechanical_time(heavy), rel=0.05)
    assert limits_of(heavy).settling_s > 20.0 * periods
    assert limits_of(heavy).held_settling_s == periods, "a shaft that is held has no mechanics"


def test_currents_settle_no_sooner_than_the_voltage_can_move_them() -> None:
    drive = packaged("pm-ac-interior")
    slow = drive.replaced(quadrature_inductance_h=1000.0 * drive.machine.quadrature_inductance_h)
    flux = slow.machine.quadrature_inductance_h * slow.rating.current_limit_a
    assert limits_of(slow).held_settling_s == pytest.approx(4.0 * flux / 122.5, rel=0.05)
    assert limits_of(slow).held_settling_s > 5.0 * limits_of(drive).held_settling_s


@pytest.mark.parametrize(
    ("carrier", "parts"), [("single", 12.0), ("double", 12.0), ("sawtooth", 6.0)], ids=str
)
def test_the_ripple_of_the_currents_follows_from_link_carrier_and_inductance(
    carrier: str, parts: float
) -> None:
    drive = packaged("pm-ac-interior").with_overrides([f"inverter.carrier={carrier}"])
    inverter, machine = drive.inverter, drive.machine
    flux = inverter.link_voltage_v / inverter.carrier_frequency_hz
    ripple = limits_of(drive).peak_ripple_a
    assert ripple == pytest.approx(flux / (parts * machine.direct_inductance_h))


def test_ripple_of_the_currents_counts_up_to_the_current_limit() -> None:
    drive = packaged("pm-ac-interior")
    with_little = drive.replaced(direct_inductance_h=1e-5, quadrature_inductance_h=1e-5)
    assert limits_of(with_little).peak_ripple_a == drive.rating.current_limit_a


@pytest.mark.parametrize(
    ("table", "change", "words"),
    [
        (
            "inverter",
            {"hysteresis_band_a": 0.25},
            "'inverter.hysteresis_band_a' is for other kinds of drives",
        ),
        ("machine", {"magnet_flux_v_s": None}, "'machine.magnet_flux_v_s' is missing"),
        ("machine", {"direct_inductance_h": -1.0}, "must be greater than 0"),
        ("machine", {"resistance_ohm": float("nan")}, "must be a finite number"),
        ("inverter", {"dead_time_s": 1.0}, "at most a quarter of the time between two updates"),
        ("inverter", {"control_every": 6}, "with a carrier of 10000 Hz must be at most 5"),
        ("inverter", {"control_every": 2, "carrier": "double"}, 'must be left out with carrier = "double"'),
        ("inverter", {"control_every": 0}, "must be greater than or equal to 1"),
        ("inverter", {"switch_drop_v": 100.0}, "below half of the link's"),
        ("inverter", {"carrier": "triangle"}, "'single', 'double' or 'sawtooth'"),
        ("rating", {"highest_speed_rpm": 10.0}, "must be above the base speed"),
        ("advance", {"start_deg": 1.0, "slope_deg_per_rpm": 0.1}, "has no advance angle"),
        ("machine", {"carrier_frequency_hz": 1e4}, "belongs in the table [inverter]"),
    ],
)
def test_what_such_a_drive_cannot_be_is_refused_in_one_sentence(
    table: str, change: dict[str, Any], words: str
) -> None:
    mapping = copy.deepcopy(packaged("pm-ac-interior").to_mapping())
    section = mapping.setdefault(table, {})
    section |= change
    for key in [key for key, value in section.items() if value is None]:
        del section[key]
    with pytest.raises(InputError) as refused:
        parse_document(mapping, DriveDocument, "my-drive.toml")
    sentence = str(refused.value)
    assert words in sentence
    assert "\n" not in sentence


def scenario(**changes: Any) -> Scenario:
    values: dict[str, Any] = {
        "schema": 2,
        "name": "a torque step",
        "drive": "pm-ac-interior",
        "duration_s": 0.2,
        "speed_rpm": [[0.0, 1000.0]],
        "load": {"kind": "dynamometer", "torque_reference_nm": [[0.0, 0.0], [0.1, 0.0], [0.1, 1.0]]},
    }
    return parse_document(values | changes, Scenario, "the scenario")


def test_a_scenario_carries_the_whole_drive_and_its_control_period() -> None:
    first = scenario()
    assert first.control_period_s == pytest.approx(1e-4)
    assert first.to_mapping()["drive"]["machine"]["magnet_flux_v_s"] == pytest.approx(0.0879)
    assert parse_document(first.to_mapping(), Scenario, "again") == first


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"control_period_s": 2e-4}, "must be left out or 0.0001"),
        ({"control_period_s": 5e-4}, "must be left out or 0.0001"),
        ({"sensors": {"kind": "shunts", "settling_s": 2e-6}}, "'settling_s' is 2e-06, but must be left out"),
        ({"sensors": {"kind": "shunts", "hysteresis_deg": 2.0}}, "it acts only with 'hall'"),
        ({"sensors": {"kind": "shunts", "position": "hall", "encoder_lines": 64}}, "only with 'encoder'"),
        (
            {"sensors": {"kind": "shunts", "position": "exact", "clock_s": 1e-6}},
            "only with 'encoder' or 'hall'",
        ),
        ({"sensors": "mcs96"}, 'one of the kind "pm-ac" has ideal or shunts'),
        ({"current_errors": [{"phase": 1, "gain": 1.1}]}, "'current_errors' is for other"),
        ({"failure": {"kind": "slip", "time_s": 0.1}}, "must give 'slip_deg' for the kind 'slip'"),
        ({"drive": "paper-5-phase"}, "the load 'dynamometer' is for drives of the kind"),
        ({"failure": {"kind": "lost-edge", "time_s": 0.1}}, "an exact position has no edges"),
        (
            {
                "failure": {"kind": "lost-edge", "time_s": 0.1},
                "sensors": {"kind": "shunts", "position": "exact"},
            },
            "'lost-edge' needs the sensors 'shunts' with the position 'encoder' or 'hall'",
        ),
        ({"failure": {"kind": "lost-edge", "time_s": 0.1, "phase": 2}, "sensors": "shunts"}, "no phase's"),
    ],
)
def test_a_scenario_that_the_kind_cannot_have_is_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        scenario(**changes)

"""The facts of a scenario: each key that is not as in the plain run, in words."""

import pytest

from drivegate.contracts.current.scenarios.building import plain_scenario, steady_scenario
from drivegate.contracts.current.scenarios.drawn.courses import load_course
from drivegate.contracts.current.scenarios.simplification import SIMPLIFICATIONS
from drivegate.contracts.duty.scenarios.fixed import range_scenario
from drivegate.output.wording import scenario_in_short
from drivegate.scenarios.changes import (
    stepped,
    with_drift,
    with_dropout,
    with_glitch,
    with_imbalance,
    with_load_factor,
    with_load_shares,
    with_real_sensors,
    with_scales,
    with_speed,
    with_supply,
)
from drivegate.scenarios.drive_scale import scale_of
from drivegate.scenarios.facts import facts_in_short, facts_of
from drivegate.scenarios.simplification import simplified, size_of
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario

DRIVE = load_drive("paper-5-phase")
PLAIN = plain_scenario(DRIVE)


def steady(speed_rpm: float, *, constant_power: bool = False) -> Scenario:
    return steady_scenario(DRIVE, speed_rpm, power_share=1.0, constant_power=constant_power)


@pytest.mark.parametrize(
    ("scenario", "facts"),
    [
        (PLAIN, ()),
        (PLAIN.replaced(duration_s=9.2), ()),
        (PLAIN.replaced(duration_s=120.0), ("for 120 s",)),
        (PLAIN.replaced(control_period_s=50e-6), ("control period s 5e-05",)),
        (PLAIN.replaced(initial_speed_rpm=0.0), ("starting from 0 rpm",)),
        (steady(1500.0, constant_power=True), ("constant power 1500 W",)),
        (steady(700.0), ("700 rpm", "constant torque 20.463 N·m")),
        (with_load_shares(PLAIN, (0.0, 0.5), (10.0, 1.0)), ("50 → 100 % of the load at 10 s",)),
        (with_load_shares(PLAIN, (0.0, 0.0)), ("unloaded",)),
        (with_speed(PLAIN, stepped(900.0, 1500.0, 10.0)), ("900 → 1500 rpm at 10 s",)),
        (with_supply(PLAIN, stepped(1.0, 0.9, 10.0)), ("half-supply 48 → 43.2 V at 10 s",)),
        (with_imbalance(PLAIN, stepped(0.0, 0.03, 10.0)), ("halves of the supply apart by 0 → 3 % at 10 s",)),
        (with_scales(PLAIN, resistance=2.0, friction_added_n_m=0.5), ("R × 2", "friction + 0.5 N·m")),
        (with_drift(PLAIN, resistance=stepped(1.0, 1.4, 2.0)), ("R drifts by 1 → 1.4 times at 2 s",)),
        (with_dropout(PLAIN, "speed", 10.0, 0.01), ("speed lost for 10 ms at 10 s",)),
        (
            with_glitch(with_real_sensors(PLAIN, 3), 20, 10.0),
            ("mcs96 sensors of seed 3", "+20 encoder counts at 10 s"),
        ),
    ],
)
def test_each_key_that_is_not_as_in_the_plain_run_is_a_fact(
    scenario: Scenario, facts: tuple[str, ...]
) -> None:
    assert sorted(facts_of(scenario.to_mapping())) == sorted(facts)


def test_a_key_without_words_of_its_own_is_a_fact_too() -> None:
    """A key that the scenario gets one day must not go uncounted."""
    stated = facts_of(
        {**PLAIN.to_mapping(), "magnet_age_years": 12.0, "restarts": [3.0, 4.0], "none_at_all": []}
    )
    assert stated == ("magnet age years 12", "restarts 3", "restarts 4")


def test_facts_are_reported_in_one_line() -> None:
    assert facts_in_short(PLAIN.to_mapping()) == "the plain run"
    assert facts_in_short(steady(700.0).to_mapping()) == "700 rpm, constant torque 20.463 N·m"
    assert facts_in_short({"kind": "script", "rows": [{}, {}]}) == "a script of 2 rows"


def test_hall_switches_are_reported_counted_and_made_plainer_like_other_sensors() -> None:
    star = steady_scenario(load_drive("star-3-phase"), 1000.0, power_share=0.5, constant_power=False)
    seen = with_real_sensors(star, 3)
    far_off = seen.replaced(sensors={"kind": "hall", "placement_error_deg": 4.0, "current_noise_a": 1.0})
    assert "hall sensors of seed 3" in facts_of(seen.to_mapping())
    assert "hall sensors, seed 3" in seen.description
    assert size_of(star.to_mapping()) < size_of(seen.to_mapping()) < size_of(far_off.to_mapping())
    fields = (fields for simplification in SIMPLIFICATIONS for fields in simplification(far_off))
    plainer = [run.sensors for run in (simplified(far_off, changed) for changed in fields) if run is not None]
    assert seen.sensors in plainer, "the sensors' own defaults are never tried"


@pytest.mark.parametrize("drive", ["pm-ac-surface", "star-3-phase"])
def test_the_supply_of_a_link_without_a_tap_is_stated_as_a_whole(drive: str) -> None:
    document = load_drive(drive)
    made = range_scenario(document) if isinstance(document, PmAcDocument) else plain_scenario(document)
    sagging = with_supply(made, stepped(1.0, 0.9, 1.0))
    assert sagging.supply_v == ((0.0, 48.0), (1.0, 48.0), (1.0, 43.2))
    assert "96-86.4V" in sagging.name
    assert "; link 96, then 86.4 V (changing at 1 s)" in sagging.description
    assert "link 96 → 86.4 V at 1 s" in facts_of(sagging.to_mapping())
    assert ", link 96 → 86.4 V" in scenario_in_short(sagging.to_mapping())


def test_the_supply_of_a_link_with_a_tap_is_stated_by_halves() -> None:
    sagging = with_supply(PLAIN, stepped(1.0, 0.9, 10.0))
    assert "half-supply 48, then 43.2 V" in sagging.description
    assert ", half-supply 48 → 43.2 V" in scenario_in_short(sagging.to_mapping())


@pytest.mark.parametrize("course", ["ramp", "vanishing", "gone", "repeated"])
def test_a_drawn_load_may_change_just_when_it_is_there(course: str) -> None:
    scale = scale_of(DRIVE)
    factor = load_course(course, 0.3, 0.6, scale.load_ramp_s, 0.5, scale)
    with_load_factor(PLAIN, factor)
    assert factor[:2] == ((0.0, 0.0), (scale.load_ramp_s, 0.3))


def test_a_load_may_change_just_when_it_is_there() -> None:
    changed = with_load_shares(PLAIN, (0.0, 0.3), (scale_of(DRIVE).load_ramp_s, 0.0))
    assert changed.load.factor == ((0.0, 0.0), (0.2, 0.3), (0.2, 0.0))

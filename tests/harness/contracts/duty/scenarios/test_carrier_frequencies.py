"""Any usual carrier frequency can be planned for: every time in a scenario is that of a whole number of its periods."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import get_args

import pytest
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from drivegate.contracts.comparison import ComparisonRequest
from drivegate.contracts.duty.comparison.declaration import planned_duty_runs
from drivegate.contracts.duty.scenarios.building import PERIODS_AT_A_TIME, dwell_periods, torque_scenario
from drivegate.contracts.duty.scenarios.drawn.failures import failure_scenarios
from drivegate.contracts.duty.scenarios.drawn.families import FAMILY_GROUPS, serves
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios
from drivegate.contracts.duty.scenarios.simplification import DUTY_SIMPLIFICATIONS
from drivegate.contracts.duty.scenarios.windows import duty_windows
from drivegate.contracts.traceability import family_name
from drivegate.scenarios.simplification import simplified
from drivegate.studies.campaign.plan import with_parameters
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.control_periods import seen_at_s
from drivegate_cases.scenario.drive_cycle import load_drive_cycle
from drivegate_cases.scenario.failure_kind import FAILURE_KINDS
from drivegate_cases.scenario.reference import Reference
from drivegate_cases.scenario.scenario import Scenario

KILOHERTZ = (
    *(
        3,
        4,
        5,
        6,
        7,
        8,
        9,
        10,
        11,
        12,
        13,
        14,
        15,
        16,
        17,
        18,
        19,
        20,
        21,
        22,
        23,
        24,
        25,
        26,
        27,
        28,
        29,
        30,
    ),
    *(32, 33, 35, 36, 37, 40, 42, 44, 45, 48, 50, 53, 55, 60, 64, 66, 70, 72, 75, 80, 85, 90, 96, 99, 100),
    *(3.3, 7.8125, 10.007, 13.333, 14.4, 17.77, 21.739, 31.25, 33.333, 44.1, 47.619, 61.803, 97.6561),
)
SURFACE = load_drive("pm-ac-surface")
assert isinstance(SURFACE, PmAcDocument)
FAMILIES = list(
    dict.fromkeys(family for group in FAMILY_GROUPS for family in group if serves(family, SURFACE))
)
FRACTION = 1e-3
"""Greatest distance of a time from a whole number of control periods (periods)."""


def on_carrier(kilohertz: float, carrier: str) -> PmAcDocument:
    drive = SURFACE.replaced(carrier_frequency_hz=1e3 * kilohertz, carrier=carrier)
    assert isinstance(drive, PmAcDocument)
    return drive


DRIVES = [on_carrier(kilohertz, carrier) for kilohertz in KILOHERTZ for carrier in ("single", "double")]
TINY = parse_document(
    {
        "schema": 1,
        "name": "tiny",
        "kind": "pm-ac",
        "machine": {
            "pole_pairs": 7,
            "resistance_ohm": 0.005,
            "direct_inductance_h": 1e-6,
            "quadrature_inductance_h": 1e-6,
            "magnet_flux_v_s": 0.002,
            "inertia_kg_m2": 2e-5,
        },
        "inverter": {"link_voltage_v": 24.0, "carrier_frequency_hz": 48e3},
        "rating": {
            "base_speed_rpm": 4000.0,
            "highest_speed_rpm": 6000.0,
            "overspeed_rpm": 6500.0,
            "rated_power_w": 150.0,
            "current_limit_a": 60.0,
        },
    },
    PmAcDocument,
    "tiny",
)


def times_of(scenario: Scenario) -> list[float]:
    profiles = (
        scenario.speed_rpm,
        scenario.load_profile,
        scenario.torque_reference_profile,
        scenario.supply_profile,
    )
    failures = [] if scenario.failure is None else [scenario.failure.time_s]
    return [scenario.duration_s, *failures, *(time for profile in profiles for time, _ in profile)]


def assert_on_whole_periods(scenario: Scenario) -> None:
    period = scenario.control_period_s
    for time in times_of(scenario):
        number = round(time / period)
        assert abs(time / period - number) < FRACTION, f"{time} s is no whole number of periods of {period} s"
        assert seen_at_s(time, period) <= number * period, f"what happens at {time} s is a period late"
    if scenario.failure is not None:
        assert scenario.failure.first_period(period) == round(scenario.failure.time_s / period)


def assert_comes_back_from_a_file(scenario: Scenario) -> None:
    written = json.loads(scenario.to_json())
    assert parse_document(written, Scenario, "written").to_json() == scenario.to_json()


@pytest.mark.one_in(8)
@pytest.mark.parametrize("kilohertz", KILOHERTZ)
def test_fixed_scenarios_are_whole_periods_of_any_carrier(kilohertz: float) -> None:
    def windows(fixed: Iterable[Scenario]) -> list[int]:
        # How many clocks wrap around depends on the carrier.
        return [len(duty_windows(scenario)) for scenario in fixed if scenario.clock_start_s == 0.0]

    usual = windows(fixed_scenarios(SURFACE, detected=FAILURE_KINDS))
    for carrier in ("single", "double"):
        fixed = fixed_scenarios(on_carrier(kilohertz, carrier), detected=FAILURE_KINDS)
        for scenario in fixed:
            assert_on_whole_periods(scenario)
        assert windows(fixed) == usual


def test_at_least_sixty_frequencies_are_tried() -> None:
    assert len(set(KILOHERTZ)) >= 60
    assert (min(KILOHERTZ), max(KILOHERTZ)) == (3, 100)


@pytest.mark.one_in(5)
@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family_name(family.__name__))
def test_drawn_scenarios_are_whole_periods_of_any_carrier(family: object) -> None:
    def drawn(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
        if family is failure_scenarios:
            return failure_scenarios(drive, detected=FAILURE_KINDS, references=("speed", "torque"))
        return family(drive)  # type: ignore[operator,no-any-return]

    @seed(0)
    @settings(
        max_examples=40,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(st.sampled_from(DRIVES).flatmap(drawn))
    def draw(scenario: Scenario) -> None:
        assert_on_whole_periods(scenario)
        assert_comes_back_from_a_file(scenario)

    draw()


def test_a_microhenry_at_48_khz_is_planned() -> None:
    assert isinstance(TINY, PmAcDocument)
    for scenario in fixed_scenarios(TINY, detected=FAILURE_KINDS):
        assert_on_whole_periods(scenario)
        assert duty_windows(scenario)


@pytest.mark.parametrize("kilohertz", [13.333, 22, 30, 44.1])
def test_a_dwell_of_exactly_what_it_takes_is_judged_at_every_step(kilohertz: float) -> None:
    drive = on_carrier(kilohertz, "double")
    each = dwell_periods(drive, held=True)
    assert each % PERIODS_AT_A_TIME == 0
    run = torque_scenario(drive, 100.0, [0.1 * number for number in range(12)])
    assert run.control_periods == 12 * each
    assert len(duty_windows(run)) == 12


@pytest.mark.parametrize("kilohertz", [13, 22, 30, 47.619])
def test_simpler_scenarios_and_other_studies_are_whole_periods_too(kilohertz: float) -> None:
    drive = on_carrier(kilohertz, "double")
    run = torque_scenario(drive, 123.0, (0.0, 1.237, 0.4))
    simpler = [
        found
        for simplification in DUTY_SIMPLIFICATIONS
        for fields in simplification(run)
        if (found := simplified(run, fields)) is not None
    ]
    compared = [
        planned.scenario
        for kind in get_args(Reference)
        for planned in planned_duty_runs(
            ComparisonRequest(drive, "quick", 0, load_drive_cycle("ece-15"), kind)
        )
    ]
    changed = with_parameters(
        torque_scenario(SURFACE, 123.0, (0.0, 1.0)),
        {"carrier_frequency_hz": 1e3 * kilohertz},
        name="campaign",
        seed=1,
    )
    assert simpler
    for scenario in (*simpler, *compared):
        assert_on_whole_periods(scenario)
    assert abs(changed.duration_s / changed.control_period_s - changed.control_periods) < FRACTION

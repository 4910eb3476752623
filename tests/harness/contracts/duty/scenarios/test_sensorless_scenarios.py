"""Scenarios of drives without a position sensor: fair, judged, and set aside where nobody can do more."""

from __future__ import annotations

from collections import Counter

import pytest
from hypothesis import HealthCheck, Phase, given, seed, settings

from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.building import (
    hoist_scenario,
    load_step_scenario,
    share_scenario,
    speed_scenario,
    torque_of,
)
from drivegate.contracts.duty.scenarios.drawn.families import SENSORLESS_GROUPS
from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios
from drivegate.contracts.duty.scenarios.sensorless import ANGLES_DEG, least_loaded_rpm, least_rpm
from drivegate.contracts.duty.scenarios.windows import duty_windows
from drivegate.contracts.traceability import family_name
from drivegate_cases.drive.drive_document import drive_names, load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario

DRIVES = [
    duty_document(load_drive(f"{name}-sensorless"))
    for name in drive_names()
    if isinstance(load_drive(name), PmAcDocument)
]
INTERIOR = next(drive for drive in DRIVES if drive.name == "pm-ac-interior-sensorless")
BASE = INTERIOR.rating.base_speed_rpm
LEAST = least_rpm(INTERIOR)
FAMILIES = list(dict.fromkeys(family for group in SENSORLESS_GROUPS for family in group))


@pytest.mark.one_in(3)
@pytest.mark.parametrize("drive", DRIVES, ids=lambda drive: drive.name)
def test_the_fixed_scenarios_are_fair_judged_somewhere_and_reported_apart(drive: PmAcDocument) -> None:
    fixed = fixed_scenarios(drive)
    unfair = {run.name: reason for run in fixed if (reason := unfair_because(run)) is not None}
    if drive.real_link is not None:
        # No torque holds a weight whose power neither the source takes nor the windings burn.
        unfair = {name: reason for name, reason in unfair.items() if "hoist" not in name}
    assert unfair == {}
    assert [run.name for run in fixed if not duty_windows(run)] == []
    counts = Counter(run.name for run in fixed)
    assert [name for name, count in counts.items() if count > 1] == [], "one name for different runs"
    starts = {run.initial_angle_deg for run in fixed if run.initial_speed_rpm == 0.0}
    assert {angle % 180.0 for angle in ANGLES_DEG} <= {angle % 180.0 for angle in starts}


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family_name(family.__name__))
def test_what_a_family_draws_is_judged_and_mostly_fair(family: object) -> None:
    drawn: list[Scenario] = []

    @seed(0)
    @settings(
        max_examples=10, database=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck)
    )
    @given(family(INTERIOR))  # type: ignore[operator]
    def draw(scenario: Scenario) -> None:
        drawn.append(scenario)

    draw()
    assert all(duty_windows(scenario) for scenario in drawn)
    reasons = [reason for scenario in drawn if (reason := unfair_because(scenario)) is not None]
    assert len(reasons) <= 2, reasons


@pytest.mark.parametrize(
    ("run", "because"),
    [
        (share_scenario(INTERIOR, 0.9 * LEAST, 0.5), "below the least speed"),
        (speed_scenario(INTERIOR, (BASE, 0.0, BASE)), "below the least speed"),
        (
            speed_scenario(
                INTERIOR, (BASE,), torque_nm=torque_of(INTERIOR, BASE, 0.7), initial_speed_rpm=0.0
            ),
            "above half of rated torque",
        ),
        (
            speed_scenario(INTERIOR, (2.0 * LEAST,), torque_nm=torque_of(INTERIOR, BASE, 0.8)),
            "before a controller without a position sensor can take it over",
        ),
        (
            load_step_scenario(INTERIOR, 2.0 * LEAST, torque_of(INTERIOR, BASE, 0.8), (0.0, 1.0)),
            "before a controller without a position sensor can act",
        ),
        (
            hoist_scenario(INTERIOR, (BASE,), 0.5).replaced(initial_speed_rpm=0.0),
            "before a start has found the rotor",
        ),
        (speed_scenario(INTERIOR, (BASE,)).replaced(restarts_s=(0.5,)), "after a restart"),
    ],
    ids=lambda value: value if isinstance(value, str) else value.name,
)
def test_what_nobody_can_do_without_a_sensor_is_set_aside(run: Scenario, because: str) -> None:
    reason = unfair_because(run)
    assert reason is not None
    assert because in reason
    sensed = load_drive("pm-ac-interior")
    assert "without a position sensor" not in (unfair_because(run.replaced(drive=sensed)) or "")


def test_a_load_may_come_on_where_it_leaves_the_least_speed() -> None:
    for share in (0.1, 0.4, 0.8):
        speed = least_loaded_rpm(INTERIOR, share)
        torque = torque_of(INTERIOR, speed, share)
        assert unfair_because(load_step_scenario(INTERIOR, speed, torque, (0.0, 1.0))) is None

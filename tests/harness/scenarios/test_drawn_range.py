"""No simplification of a drawn scenario leaves the range that its family is drawn from."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import Any

import pytest
from varied_keys import draws

from drivegate.contracts.catalogue import contract_named, contract_of
from drivegate.contracts.current.scenarios.building import steady_scenario
from drivegate.contracts.current.scenarios.drawn import families
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.building import failing, speed_scenario, torque_of, torque_scenario
from drivegate.contracts.duty.scenarios.drawn import families as duty
from drivegate.contracts.traceability import family_name
from drivegate.scenarios.changes import (
    stepped,
    with_dropout,
    with_glitch,
    with_imbalance,
    with_load_shares,
    with_real_sensors,
    with_scales,
    with_supply,
)
from drivegate.scenarios.simplification import simplified
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.piecewise import breakpoints, value_from
from drivegate_cases.scenario.scenario import Scenario

PAPER, INTERIOR = load_drive("paper-5-phase"), load_drive("pm-ac-interior")
assert isinstance(INTERIOR, PmAcDocument)
BASE, TOP = INTERIOR.rating.base_speed_rpm, INTERIOR.rating.highest_speed_rpm
RATED = INTERIOR.rating.rated_power_w / (BASE * 0.1047197551)

# Speeds over base speed, and torques over rated torque at their speed, written down without the harness's own rule.
DUTY_RANGES = {
    "torque step": ((0.0, TOP / BASE), (-1.0, 1.0)),
    "weakening": ((1.0, TOP / BASE), (0.0, 3.0)),
    "overspeed": ((TOP / BASE, INTERIOR.rating.overspeed_rpm / BASE), (-1.0, 0.0)),
    "speed step": ((0.1, TOP / BASE), (0.0, 0.85)),
    "reversal": ((0.1, TOP / BASE), (0.0, 0.85)),
    "load step": ((0.1, TOP / BASE), (0.0, 0.85)),
    "hoist": ((0.1, 1.0), (-0.6, 0.85)),
    "low speed": ((0.0, TOP / BASE), (0.0, 0.2)),
    "start": ((0.1, 1.0), (0.0, 0.85)),
    "released": ((0.0, TOP / BASE), (-1.0, 1.0)),
    "restart": ((0.1, 1.0), (0.0, 1.0)),
    "position error": ((0.1, 1.0), (0.0, 1.0)),
    "lost sample": ((0.1, 1.0), (0.0, 1.0)),
    "false edge": ((0.1, 1.0), (0.0, 1.0)),
    "joint change": ((0.1, TOP / BASE), (-1.0, 1.0)),
    "parameter": ((0.1, TOP / BASE), (0.0, 0.85)),
    "supply step": ((0.1, TOP / BASE), (0.0, 0.85)),
    "torque supply step": ((0.0, TOP / BASE), (-1.0, 1.0)),
    "sensor": ((0.1, TOP / BASE), (0.0, 0.85)),
    "failure": ((0.2, 1.0), (0.3, 0.6)),
}
OUTER_FAMILIES = [family for group in families.FAMILY_GROUPS for family in group]
# Those of drives with thermal data or a link of their own are drawn in test_duty_scenarios.py.
DUTY_FAMILIES = list(
    dict.fromkeys(
        family
        for group in duty.FAMILY_GROUPS
        for family in group
        if duty.serves(family, duty_document(INTERIOR))
    )
)


def simplifications(scenario: Scenario) -> Iterator[Scenario]:
    """Make what shrinking would try first in every respect, and of the last of it the same again."""
    contract, start = contract_of(scenario.drive), scenario
    for _ in range(2):
        made = [
            simpler
            for simplification in contract.simplifications
            for fields in islice(simplification(scenario), 6)
            if (simpler := simplified(scenario, fields)) is not None and contract.is_as_fair(simpler, start)
        ]
        yield from made
        if not made:
            return
        scenario = made[-1]


def corners(scenario: Scenario) -> Iterator[tuple[float, float]]:
    """Give speed and torque wherever something changes."""
    profiles = (scenario.speed_rpm, scenario.load_profile, scenario.torque_reference_profile)
    for time in breakpoints(profiles, scenario.duration_s):
        speed, share, torque = (value_from(profile, time) for profile in profiles)
        demanded = 0.0 if scenario.load.kind == "dynamometer" else scenario.load.torque_at(speed, share)
        # Speeds count without their sign, torques in the sense of rotation.
        yield abs(speed), (torque if speed >= 0.0 else -torque) + demanded


def test_every_family_is_tried() -> None:
    assert {family_name(family.__name__) for family in OUTER_FAMILIES} == set(
        contract_named("current").families
    )
    assert (
        {family_name(family.__name__) for family in DUTY_FAMILIES}
        == set(DUTY_RANGES)
        <= set(contract_named("duty").families)
    )


@pytest.mark.one_in(5)
@pytest.mark.parametrize("family", DUTY_FAMILIES, ids=lambda family: family_name(family.__name__))
def test_what_duty_ratios_are_judged_on_stays_in_the_range_of_its_family(family: Any) -> None:
    (slowest, fastest), (least, greatest) = DUTY_RANGES[family_name(family.__name__)]
    scenarios = draws(family(INTERIOR), 4, start=1)
    for scenario in scenarios:
        for simpler in (scenario, *simplifications(scenario)):
            assert contract_of(INTERIOR).is_fair(simpler) or simpler is scenario, simpler.name
            for speed, torque in corners(simpler):
                share = torque / (RATED * BASE / max(speed, BASE))
                assert slowest - 0.01 <= speed / BASE <= fastest + 0.01, f"{simpler.name} of {scenario.name}"
                assert least - 0.01 <= share <= greatest + 0.01, f"{simpler.name} of {scenario.name}"


@pytest.mark.one_in(5)
@pytest.mark.parametrize("family", OUTER_FAMILIES, ids=lambda family: family_name(family.__name__))
def test_what_angles_are_judged_on_stays_in_the_range_of_its_family(family: Any) -> None:
    for scenario in draws(family(PAPER, None), 2, start=1):
        # A required point may take a little more than rated power.
        watts = [torque * speed * 0.1047197551 for speed, torque in corners(scenario)]
        power = max([PAPER.rating.rated_power_w, *watts])
        at_least = min([550.0, *(speed for speed, torque in corners(scenario) if torque)])
        at_most = max([1500.0, *(speed for _, speed in scenario.speed_rpm)])
        for simpler in simplifications(scenario):
            assert contract_of(PAPER).is_fair(simpler), simpler.name
            read = parse_document(simpler.to_mapping(), Scenario, "the simpler scenario")
            assert read == simpler, f"{simpler.name} of {scenario.name} is not valid"
            for speed, torque in corners(simpler):
                where = f"{simpler.name} of {scenario.name}"
                assert speed <= at_most, where
                assert torque == 0.0 or speed >= at_least, where
                assert torque * speed * 0.1047197551 <= 1.01 * power, where


def disturbed() -> Scenario:
    scenario = steady_scenario(PAPER, 1430.0, power_share=0.9, constant_power=True)
    scenario = with_supply(scenario, stepped(1.0, 0.97, 9.0))
    scenario = with_scales(scenario, resistance=1.3, inductance=0.8, friction_added_n_m=0.3)
    scenario = with_dropout(with_glitch(with_real_sensors(scenario, 7), 13, 9.0), "currents", 9.0, 0.001)
    return with_imbalance(scenario, stepped(0.0, 0.03, 8.0))


def test_no_simplification_makes_a_disturbance_greater() -> None:
    for simpler in simplifications(disturbed()):
        assert simpler.scales.resistance in (1.3, 1.25, 1.0)
        assert simpler.scales.inductance in (0.8, 1.0)
        assert simpler.scales.friction_added_n_m in (0.0, 0.25, 0.3)
        assert all(abs(glitch.counts) <= 13 for glitch in simpler.glitches)
        assert all(dropout.duration_s <= 0.001 for dropout in simpler.dropouts)
        assert simpler.imbalance is None or max(share for _, share in simpler.imbalance) <= 0.03
        assert simpler.supply_v is None or min(volts for _, volts in simpler.supply_v) >= 0.97 * 48.0 - 1e-6


def test_what_goes_beyond_the_range_goes_no_further() -> None:
    contract = contract_of(INTERIOR)
    own = torque_scenario(INTERIOR, BASE, (0.0, torque_of(INTERIOR, BASE, 1.6)))
    assert contract.is_as_fair(torque_scenario(INTERIOR, BASE, (torque_of(INTERIOR, BASE, 1.5),)), own)
    assert not contract.is_as_fair(torque_scenario(INTERIOR, BASE, (torque_of(INTERIOR, BASE, 2.0),)), own)


def test_a_failure_is_not_moved_to_where_it_does_not_show() -> None:
    contract = contract_of(INTERIOR)

    def failed(speed: float, share: float) -> Scenario:
        held = torque_scenario(INTERIOR, speed, (torque_of(INTERIOR, speed, share),))
        return failing(held, "open-phase", 0.6 * held.duration_s)

    start = failed(0.5 * BASE, 0.4)
    assert contract.is_as_fair(failed(BASE, 0.5), start)
    assert not contract.is_as_fair(failed(0.0, 0.5), start)
    assert not contract.is_as_fair(failed(TOP, 0.5), start)
    assert not contract.is_as_fair(failed(BASE, 1.0), start)
    assert not contract.is_as_fair(failed(BASE, 0.1), start)


def test_a_start_stays_a_start_of_a_speed_that_is_drawn() -> None:
    contract = contract_of(INTERIOR)
    start = speed_scenario(INTERIOR, (0.5 * BASE,), torque_nm=0.5, initial_speed_rpm=0.0)
    assert contract.is_as_fair(speed_scenario(INTERIOR, (BASE,), torque_nm=0.5, initial_speed_rpm=0.0), start)
    assert not contract.is_as_fair(
        speed_scenario(INTERIOR, (0.0,), torque_nm=0.5, initial_speed_rpm=0.0), start
    )


def test_two_changes_at_one_time_are_no_simpler_scenario() -> None:
    """Rounding times may put two steps of the load on one time, which no scenario can have."""
    scenario = with_load_shares(
        steady_scenario(PAPER, 1000.0, power_share=1.0, constant_power=True),
        (0.0, 1.0),
        (9.0, 0.5),
        (9.1, 0.8),
    )
    crowded = ((0.0, 0.0), (0.2, 1.0), (9.0, 1.0), (9.0, 0.5), (9.0, 0.8))
    fields = {"load": scenario.load.model_copy(update={"factor": crowded})}
    assert simplified(scenario, fields) is None

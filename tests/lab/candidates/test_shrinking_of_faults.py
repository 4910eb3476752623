"""Counterexamples of faulty controllers become simple, within the speeds that the controllers are made for."""

from dataclasses import replace

import pytest

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.controller import Controller
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.current.scenarios.building import steady_scenario
from drivegate.gate.shrinking import ShrinkPlan, Shrunk, run_shrink
from drivegate.scenarios.changes import (
    pulsed,
    stepped,
    with_drift,
    with_dropout,
    with_glitch,
    with_imbalance,
    with_load_shares,
    with_real_sensors,
    with_scales,
    with_speed,
    with_supply,
)
from drivegate.scenarios.facts import facts_of
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario

DRIVE = load_drive("paper-5-phase")

RATED_AT_970_RPM, RATED_AT_730_RPM = (
    steady_scenario(DRIVE, speed, power_share=1.0, constant_power=True) for speed in (970.0, 730.0)
)

AT_1400_RPM = steady_scenario(DRIVE, 1400.0, power_share=0.6, constant_power=False)


class Loaded:
    """A built-in candidate in this very process."""

    def __init__(self, name: str) -> None:
        self.candidate: Candidate = resolve_candidate(name)

    def controller(self) -> Controller:
        return load_controller(self.candidate)


def shrunk(
    name: str, scenario: Scenario, check: str, budget: int = 60, worst: float | None = None
) -> Shrunk | None:
    plan = ShrinkPlan(scenario.to_mapping(), check, budget, worst)
    return run_shrink(Loaded(name), plan)  # type: ignore[arg-type]


def disturbed() -> Scenario:
    """1430 rpm with nearly everything that a scenario can have."""
    scenario = steady_scenario(DRIVE, 1430.0, power_share=0.95, constant_power=True)
    scenario = with_load_shares(scenario, (0.0, 0.8), (9.5, 1.0), (12.3, 0.9))
    scenario = with_supply(scenario, pulsed(1.0, 0.95, 11.0, 0.4))
    scenario = with_scales(scenario, resistance=1.3, emf_constant=0.98, friction_added_n_m=0.2)
    scenario = with_dropout(with_glitch(with_real_sensors(scenario, 77), 13, 10.5), "currents", 9.0, 0.007)
    scenario = with_drift(scenario, resistance=stepped(1.0, 1.2, 3.0, over_s=4.0))
    return with_imbalance(scenario, stepped(0.0, 0.02, 8.0))


def changing() -> Scenario:
    scenario = steady_scenario(DRIVE, 1430.0, power_share=0.95, constant_power=True)
    scenario = with_speed(scenario, stepped(1210.0, 1430.0, 9.5, over_s=0.7))
    return with_supply(scenario, stepped(1.0, 0.96, 8.5))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("budget", [15, 40])
@pytest.mark.parametrize(
    ("name", "scenario", "check"),
    [
        ("faulty:never-rearms", with_load_shares(RATED_AT_970_RPM, (0.0, 0.3), (6.0, 0.95)), "CNV-3"),
        (
            "faulty:line-is-the-limit",
            with_scales(RATED_AT_730_RPM, resistance=1.7, inductance=1.15, emf_constant=0.97),
            "ROB-1",
        ),
    ],
)
def test_a_simplest_counterexample_has_three_facts_at_most(
    name: str, scenario: Scenario, check: str, budget: int
) -> None:
    found = shrunk(name, scenario, check, budget)
    assert found is not None
    facts = facts_of(found.scenario)
    assert len(facts) <= 3, facts


def test_a_simpler_scenario_keeps_to_the_speeds_that_the_candidate_is_made_for() -> None:
    loaded = Loaded("faulty:power-a-billionth-off")
    declared = replace(loaded.candidate.declaration, speed_range_rpm=(0.0, 1400.0))
    loaded.candidate = replace(loaded.candidate, declaration=declared)
    plan = ShrinkPlan(AT_1400_RPM.to_mapping(), "PWR-2", 40)
    found = run_shrink(loaded, plan)  # type: ignore[arg-type]
    assert found is not None
    assert max(speed for _, speed in found.scenario["speed_rpm"]) <= 1400.0, found.scenario["speed_rpm"]

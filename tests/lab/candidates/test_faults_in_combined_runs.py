"""Combined runs show the fault that they are made for: a search that restarts few times only."""

import pytest

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.current.checks.convergence import CNV_2
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.combined import long_scenarios
from drivegate.drives.running import run_scenario
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("name", ["paper-5-phase", "star-3-phase"])
def test_the_busy_run_shows_a_search_that_restarts_twenty_times_only(name: str, seed: int) -> None:
    *_, busy = long_scenarios(load_drive(name), None, seed)
    assert_shown("twenty-restarts", (busy,))


def assert_shown(fault: str, scenarios: tuple[Scenario, ...]) -> None:
    """Check that `reference` meets `CNV-2` in all scenarios, and that the fault fails it in one."""
    missed = [scenario.name for scenario in scenarios if not meets("reference", scenario)]
    assert missed == []
    assert not all(meets(f"faulty:{fault}", scenario) for scenario in scenarios)


def meets(specification: str, scenario: Scenario) -> bool:
    candidate = resolve_candidate(specification)
    run = run_scenario(scenario, load_controller(candidate))
    margin = CNV_2.evaluate(CurrentRecord(scenario, run, candidate.declaration))
    assert margin is not None, f"CNV-2 does not judge {scenario.name}"
    assert not margin.advisory, f"CNV-2 only advises on {scenario.name}"
    return margin.met

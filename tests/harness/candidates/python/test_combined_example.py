"""The example of two blocks: a regulator of its own with the search of another controller."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.contracts.current.scenarios.rare import rare_scenarios
from drivegate.drives.running import run_scenario
from drivegate_cases.drive.drive_document import load_drive

EXAMPLES = Path(__file__).parents[4] / "examples" / "python"
PAPER = load_drive("paper-5-phase")
# Of operations that are rarely tried one is enough: they take long in Python.
RARE = rare_scenarios(PAPER)[1:]
SCENARIOS = {scenario.name: scenario for scenario in fixed_scenarios(PAPER) if scenario not in RARE}
CANDIDATE = resolve_candidate(str(EXAMPLES / "combined.toml"))


@pytest.fixture(scope="module")
def combined() -> Iterator[Any]:
    """Load it as its own process would, where no other test has imported a module of the same name before."""
    with pytest.MonkeyPatch.context() as patched:
        patched.syspath_prepend(CANDIDATE.folder)
        for source in CANDIDATE.sources:
            patched.delitem(sys.modules, source.stem, raising=False)
        yield load_controller(CANDIDATE)


def test_the_hash_covers_both_blocks() -> None:
    assert [source.name for source in CANDIDATE.sources] == ["combined.py", "controller.py"]


@pytest.mark.one_in(12)
@pytest.mark.parametrize("name", SCENARIOS)
def test_it_meets_the_required_checks_on_the_fixed_scenarios(combined: Any, name: str) -> None:
    run = run_scenario(SCENARIOS[name], combined)
    record = CurrentRecord(SCENARIOS[name], run, CANDIDATE.declaration)
    required = {check.id for check in CHECKS if check.level == "required"}
    margins = [one for one in judged(record, CHECKS).margins if one.check in required and not one.advisory]
    assert margins, "there must be something to judge"
    assert [f"{one.check} {one.value:+.3g}: {one.measured}" for one in margins if one.value < 0.0] == []


def test_the_regulator_is_the_one_of_the_example(combined: Any) -> None:
    scenario = SCENARIOS["lock-up"]
    first = run_scenario(scenario, combined)
    assert run_scenario(scenario, combined).digest == first.digest, "reset must forget everything"
    plain = load_controller(resolve_candidate(f"{EXAMPLES / 'controller.py'}:Controller"))
    assert run_scenario(scenario, plain).digest != first.digest, "another regulator gives other currents"

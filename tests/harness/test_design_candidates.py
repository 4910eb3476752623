"""Correct controllers of other designs: they are found by name, and each finds the published optimum its own way."""

import pytest

from drivegate.candidate import resolve_candidate
from drivegate.catalogue import CHECKS
from drivegate.controller_loading import load_controller
from drivegate.design_candidates import DESIGN_CANDIDATES
from drivegate.run_record import RunRecord
from drivegate.scenario_run import run_scenario
from drivegate.selftest.correct_designs import correct_designs
from drivegate_cases.scenario import load_scenario
from drivegate_models.errors import InputError


@pytest.mark.parametrize("name", DESIGN_CANDIDATES)
def test_a_design_rests_at_the_published_optimum(name: str) -> None:
    candidate = resolve_candidate(name)
    scenario = load_scenario("lock-up")
    run = run_scenario(scenario, load_controller(candidate))
    record = RunRecord(scenario, run, candidate.declaration)
    margins = [check.evaluate(record) for check in CHECKS if check.level == "required"]
    failed = [margin for margin in margins if margin is not None and not margin.met]
    assert not failed, failed


def test_designs_move_differently() -> None:
    scenario = load_scenario("fig5-search")
    digests = {
        name: run_scenario(scenario, load_controller(resolve_candidate(name))).digest
        for name in ("reference", *DESIGN_CANDIDATES)
    }
    assert len(set(digests.values())) == len(digests), digests


def test_an_unknown_design_is_told_with_the_nearest() -> None:
    with pytest.raises(InputError, match="design:golden-section"):
        resolve_candidate("design:golden-sectoin")


def test_the_self_test_judges_designs_that_are_there() -> None:
    names = [design.candidate for design in correct_designs()]
    assert {"reference", "published"} < set(names), names
    assert set(names) - {"reference", "published"} <= set(DESIGN_CANDIDATES), names

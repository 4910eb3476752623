"""What becomes of a failure that its own scenario does not show a second time."""

from tests.harness.made import made_outcome

from drivegate.checks.check import JudgedRun
from drivegate.checks.margin import Margin
from drivegate.gate.shrinking import FailedRun, Shrunk, with_simplest
from drivegate.results.document import FoundSection
from drivegate.scenarios.simplification import size_of
from drivegate_cases.scenario.scenario import load_scenario

SCENARIO = load_scenario("lock-up").to_mapping()
MARGIN = Margin("CNV-1", -2.0, "speed error 15 rpm")
OUTCOME = made_outcome(
    "CNV-1", "fail", margin=-2.0, measured=MARGIN.measured, scenario=SCENARIO, counterexample=SCENARIO
)
FAILED = FailedRun("CNV-1", MARGIN, JudgedRun(SCENARIO, (MARGIN,)))


def test_a_failure_that_does_not_show_again_is_kept_and_says_so():
    found = with_simplest([OUTCOME], [FAILED], {"CNV-1": None})[0].found
    assert found is not None
    assert found.margin == -2.0
    assert found.measured == (
        "speed error 15 rpm; run again, it did not fail: two runs of the same scenario differ; if the controller draws "
        "random numbers, seed them in reset"
    )


def test_a_failure_that_there_was_no_time_to_run_again_is_not_doubted():
    found = with_simplest([OUTCOME], [FAILED], {})[0].found
    assert found is not None
    assert found.measured == "speed error 15 rpm"


def test_a_simpler_one_takes_its_place():
    simpler = SCENARIO | {"duration_s": 12.0}
    shrunk = Shrunk(simpler, Margin("CNV-1", -1.0, "speed error 10 rpm"), 5)
    (outcome,) = with_simplest([OUTCOME], [FAILED], {"CNV-1": shrunk})
    assert outcome.counterexample == simpler
    assert outcome.found == FoundSection(
        margin=-1.0, measured="speed error 10 rpm", size=size_of(simpler), runs=5
    )

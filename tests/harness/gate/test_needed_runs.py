"""Which runs of an outer loop's controller some checks need."""

from __future__ import annotations

import pytest

from drivegate.candidates.declaration import Declaration, FlowchartProfile
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import own_candidate
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.drives.running import recorded
from drivegate.gate.focus import Focus
from drivegate.gate.plan import Origin, planned_work
from drivegate.gate.shard import DrawnRuns, FixedRuns, is_needed, run_drawn
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.plant import NOMINAL

PAPER, INTERIOR = load_drive("paper-5-phase"), load_drive("pm-ac-interior")
FIXED = fixed_scenarios(PAPER)
NAMES = {check.id for check in CHECKS}
DECLARATION = Declaration(
    FlowchartProfile(
        speed_tolerance=0.5, power_tolerance=0.0, power_tolerance_fraction=0.001, step=0.02, period=0.1
    )
)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("number", range(0, len(FIXED), 5))
def test_no_check_judges_a_run_that_it_does_not_need(number: int) -> None:
    loaded = own_candidate(resolve_candidate("initial"))
    declaration, scenario = loaded.candidate.declaration, FIXED[number]
    needed = {name for name in NAMES if is_needed(scenario, declaration, (name,))}
    seen = {
        margin.check for margin in judged(recorded(loaded, scenario, loaded.controller()), CHECKS).margins
    }
    assert seen <= needed
    assert len(needed) < len(NAMES)


def test_the_published_ripple_needs_the_runs_at_the_required_point_alone() -> None:
    needed = [scenario.name for scenario in FIXED if is_needed(scenario, Declaration(), ("RIP-1",))]
    assert needed == ["lock-up", "fig5-search"]


def planned(only: str) -> set[Origin]:
    work = planned_work("default", 0, declaration=DECLARATION, drive=PAPER, focus=Focus((only,)))
    return {item.origin for item in work}


def test_checks_of_runs_of_their_own_need_no_others() -> None:
    assert planned("TIM-1") == {Origin.TIMED}
    assert planned("FLO-1") == {Origin.SCRIPTS}
    assert planned("DET-1") == {Origin.FIXED}
    assert planned("CNV-1") == {Origin.FIXED, Origin.DRAWN}


def test_only_a_check_of_repetitions_repeats_runs() -> None:
    for only, repeats in (("DET-1", True), ("CNV-1", False)):
        first = planned_work("quick", 0, drive=PAPER, focus=Focus((only,)))[0].job.payload
        assert isinstance(first, FixedRuns)
        assert first.repeat is repeats


@pytest.mark.parametrize(
    ("candidate", "drive"), [("reference", PAPER), ("foc", INTERIOR)], ids=["reference", "foc"]
)
def test_runs_in_weakening_off_nominal_and_with_trouble_are_repeated_too(
    candidate: str, drive: DriveDocument
) -> None:
    """What a controller keeps may not show in the first run."""
    declaration = resolve_candidate(candidate).declaration
    work = planned_work("quick", 0, drive=drive, declaration=declaration)
    plans = [item.job.payload for item in work]
    repeated = [plan.scenarios[0] for plan in plans if isinstance(plan, FixedRuns) and plan.repeat]
    fastest = max(speed for run in repeated for _, speed in run.speed_rpm)
    assert fastest >= drive.rating.highest_speed_rpm
    assert sum(run.scales != NOMINAL for run in repeated) == 1
    assert sum(bool(run.dropouts) for run in repeated) == 1
    failing = [run.failure for run in repeated if run.failure is not None]
    assert len(failing) == bool(declaration.detects)


def test_a_shard_that_no_check_looks_at_is_left_out() -> None:
    loaded = own_candidate(resolve_candidate("initial"))
    assert run_drawn(loaded, DrawnRuns(PAPER, 1, 2, only=("RIP-1",))).runs == ()

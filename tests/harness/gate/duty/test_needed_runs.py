"""A check that is confined makes the runs that its checks look at, and says of them what the whole check says."""

from __future__ import annotations

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.scenarios.building import (
    failing,
    load_step_scenario,
    speed_scenario,
    torque_of,
    torque_scenario,
)
from drivegate.drives.running import recorded
from drivegate.gate.engine import check_candidate
from drivegate.gate.events import CheckFinished, RunDone
from drivegate.gate.focus import Focus
from drivegate.gate.options import CheckOptions
from drivegate.gate.plan import planned_work
from drivegate.gate.shard import DrawnRuns, FixedRuns, is_needed, run_drawn, run_fixed
from drivegate.results.document import ResultDocument
from drivegate.results.verdict import check_outcomes
from drivegate.scenarios.changes import with_real_sensors, with_scales
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario

INTERIOR = load_drive("pm-ac-interior").replaced(settling_s=0.2)
CONTRACT = contract_of(INTERIOR)
FOC = own_candidate(resolve_candidate("foc"))


def short_runs() -> tuple[Scenario, ...]:
    assert isinstance(INTERIOR, PmAcDocument)
    slow, top = 1200.0, INTERIOR.rating.highest_speed_rpm
    steps = torque_scenario(INTERIOR, slow, [torque_of(INTERIOR, slow, share) for share in (0.0, 0.5, 0.3)])
    released = torque_scenario(INTERIOR, top, (0.0, torque_of(INTERIOR, top, 3.0), 0.0))
    start = speed_scenario(INTERIOR, (600.0,), torque_nm=0.3, initial_speed_rpm=0.0)
    loaded = load_step_scenario(INTERIOR, slow, 1.0, (0.0, 1.0))
    return (
        steps,
        released,
        start,
        loaded,
        with_scales(loaded, resistance=1.5),
        with_real_sensors(steps, 1),
        failing(steps, "open-phase", 0.5 * steps.duration_s),
        torque_scenario(INTERIOR, 0.08 * INTERIOR.rating.base_speed_rpm, [torque_of(INTERIOR, slow, 0.5)]),
    )


def test_no_check_judges_a_run_that_it_does_not_need() -> None:
    controller = FOC.controller()
    skipped = 0
    for scenario in short_runs():
        margins = judged(recorded(FOC, scenario, controller), CONTRACT.checks).margins
        seen = {margin.check for margin in margins}
        needed = {
            check.id
            for check in CONTRACT.checks
            if is_needed(scenario, FOC.candidate.declaration, (check.id,))
        }
        assert seen <= needed, f"{seen - needed} judge {scenario.name}"
        skipped += len(CONTRACT.checks) - len(needed)
    assert skipped > 8 * len(short_runs()), "most checks look at few kinds of runs"


def test_runs_of_a_torque_step_are_all_that_its_check_needs() -> None:
    declaration = FOC.candidate.declaration
    needed = [run.name for run in short_runs() if is_needed(run, declaration, ("STP-1",))]
    assert needed == [short_runs()[0].name]
    assert all(is_needed(run, declaration, ()) for run in short_runs()), "no names mean all checks"
    outcome = run_fixed(FOC, FixedRuns(short_runs()[:3], only=("STP-1",)))
    assert [run.scenario["name"] for run in outcome.runs] == needed


def test_a_shard_is_made_as_in_a_whole_check_or_not_at_all() -> None:
    whole = run_drawn(FOC, DrawnRuns(INTERIOR, 0, 3))
    assert run_drawn(FOC, DrawnRuns(INTERIOR, 0, 3, only=("STP-1",))) == whole
    assert run_drawn(FOC, DrawnRuns(INTERIOR, 2, 3, only=("STP-1",))).runs == ()


def test_the_last_run_of_a_shard_is_left_out_where_no_named_check_looks_at_it() -> None:
    whole = run_drawn(FOC, DrawnRuns(INTERIOR, 0, 2))
    assert run_drawn(FOC, DrawnRuns(INTERIOR, 0, 2, only=("DEC-1",))).runs == whole.runs[:1]


def check(candidate: str, only: tuple[str, ...] = ()) -> tuple[ResultDocument, list[RunDone]]:
    events = list(
        check_candidate(
            resolve_candidate(candidate),
            CheckOptions(drive=INTERIOR, effort="quick", workers=1, focus=Focus(only)),
        )
    )
    assert isinstance(events[-1], CheckFinished)
    return events[-1].result, [event for event in events if isinstance(event, RunDone)]


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("kilohertz", "carrier"),
    [
        (13, "double"),
        *(
            pytest.param(kilohertz, carrier, marks=pytest.mark.nightly)
            for kilohertz, carrier in [
                (48, "single"),
                (22, "double"),
                (30, "single"),
                (35.7, "single"),
                (44.1, "double"),
            ]
        ),
    ],
)
def test_a_quick_check_on_any_carrier_ends_with_a_verdict(kilohertz: float, carrier: str) -> None:
    drive = load_drive("pm-ac-surface").replaced(
        carrier_frequency_hz=1e3 * kilohertz, carrier=carrier, settling_s=0.1
    )
    declaration, only = FOC.candidate.declaration, ("STP-1",)
    work = planned_work("quick", 0, declaration=declaration, drive=drive, focus=Focus(only))
    runs = [run for item in work for run in item.job.target(FOC, item.job.payload).runs]
    outcomes = check_outcomes(runs, declaration, drive, complete=True)
    verdicts = {outcome.id: outcome.verdict for outcome in outcomes if outcome.id in only}
    assert verdicts == {"STP-1": "pass"}
    assert len(runs) >= 7

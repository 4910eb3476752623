"""A check that is confined to one requirement concludes the same on a faulty controller as the whole check."""

from __future__ import annotations

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.duty.scenarios.building import (
    failing,
    load_step_scenario,
    speed_scenario,
    torque_of,
    torque_scenario,
)
from drivegate.gate.engine import check_candidate
from drivegate.gate.events import CheckFinished, RunDone
from drivegate.gate.focus import Focus
from drivegate.gate.options import CheckOptions
from drivegate.results.document import ResultDocument
from drivegate.scenarios.changes import with_real_sensors, with_scales
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario

INTERIOR = load_drive("pm-ac-interior").replaced(settling_s=0.2)


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


@pytest.fixture
def few_runs(monkeypatch: pytest.MonkeyPatch, little_shrunk: None) -> None:
    monkeypatch.setattr(
        "drivegate.contracts.duty.scenarios.fixed.fixed_scenarios", lambda *_, **__: short_runs()
    )
    monkeypatch.setattr("drivegate.gate.plan.SHARDS", 2)
    monkeypatch.setattr("drivegate.gate.plan.EXAMPLES", {"quick": 2})


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
@pytest.mark.usefixtures("few_runs")
def test_a_confined_check_concludes_what_the_whole_check_does() -> None:
    only = ("STP-1", "FWK-2")
    whole, _ = check("faulty:stuck-weakening")
    part, progress = check("faulty:stuck-weakening", only)
    assert part.runs < whole.runs
    assert progress[-1].done == progress[-1].planned == part.runs
    assert {event.worst.partition(" ")[0] for event in progress} <= {"", *only}
    expected = [outcome for outcome in whole.checks if outcome.id in only]
    assert [(mine.id, mine.verdict, mine.margin, mine.measured, mine.scenario) for mine in part.checks] == [
        (its.id, its.verdict, its.margin, its.measured, its.scenario) for its in expected
    ]

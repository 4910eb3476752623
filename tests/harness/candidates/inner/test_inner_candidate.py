"""Any candidate of current references runs on duty ratios behind the loop of currents, and is judged there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.building import load_step_scenario, speed_scenario, torque_scenario
from drivegate.drives.running import recorded
from drivegate.gate.plan import Origin, planned_work
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

SURFACE = load_drive("pm-ac-surface")
LOADED = load_step_scenario(SURFACE, 100.0, 3.0, (1.0,))
PYTHON = """
from drivegate import Command

class Mine:
    def reset(self, nameplate):
        self.given = nameplate

    def step(self, sense):
        {answer}
"""


def run_once(loaded: JudgedCandidate, scenario: Scenario) -> DutyRecord:
    record = recorded(loaded, scenario, loaded.controller())
    assert isinstance(record, DutyRecord)
    return record


def ended(specification: str, scenario: Scenario = LOADED) -> DutyRecord | Fault:
    with Judge(resolve_candidate(specification)) as judge:
        return judge.run(Job(run_once, scenario))


def mine(folder: Path, answer: str) -> str:
    (folder / "mine.py").write_text(PYTHON.format(answer=answer), encoding="utf-8")
    return f"inner:pi:{folder / 'mine.py'}:Mine"


def test_the_reference_keeps_the_speed() -> None:
    record = ended("inner:pi:reference")
    assert isinstance(record, DutyRecord), record
    assert record.steady[-1].speed == pytest.approx(100.0 * np.pi / 30.0, rel=1e-3)


def test_a_python_controller_gives_its_current_and_its_angle(tmp_path: Path) -> None:
    record = ended(mine(tmp_path, "return Command(4.0, 0.5)"))
    assert isinstance(record, DutyRecord), record
    late = slice(-200, None)
    assert record.run.column("direct")[late].mean() == pytest.approx(-4.0 * np.sin(0.5), rel=0.05)
    assert record.run.column("quadrature")[late].mean() == pytest.approx(4.0 * np.cos(0.5), rel=0.05)


def test_a_fault_behind_the_loop_is_the_candidates(tmp_path: Path) -> None:
    fault = ended(mine(tmp_path, "raise ValueError('no')"))
    assert isinstance(fault, Fault)
    assert (fault.kind, fault.error, fault.message) == (FaultKind.EXCEPTION, "ValueError", "ValueError: no")


def test_a_torque_reference_is_refused_since_such_a_controller_follows_a_speed() -> None:
    with pytest.raises(InputError, match="follows a speed, but this run gives a torque reference"):
        ended("inner:pi:reference", torque_scenario(SURFACE, 100.0, (1.0,)))


def test_a_drive_without_field_weakening_is_refused_since_such_a_controller_advances_its_angle() -> None:
    unweakened = SURFACE.replaced(highest_speed_rpm=SURFACE.rating.base_speed_rpm)
    with pytest.raises(InputError, match="the drive is stated without field weakening; choose a drive"):
        ended("inner:pi:reference", speed_scenario(unweakened, (100.0,)))


def test_it_is_judged_on_speed_references_alone() -> None:
    candidate = resolve_candidate("inner:pi:reference")
    work = planned_work("quick", 0, drive=SURFACE, declaration=candidate.declaration)
    fixed = [
        scenario for item in work if item.origin is Origin.FIXED for scenario in item.job.payload.scenarios
    ]
    assert fixed
    assert [scenario.name for scenario in fixed if scenario.load.kind == "dynamometer"] == []


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("inner:pd:reference", "names the loop of currents 'pd', but there is 'pi' only"),
        ("inner:pi:", "names no controller; write inner:pi:CANDIDATE"),
        ("inner:pi", "names no controller; write inner:pi:CANDIDATE"),
        ("inner:pi:foc", "'foc' answers with duty ratios itself; name it without 'inner:pi:'"),
        ("inner:pi:referenze", "the nearest known one is 'reference'"),
    ],
)
def test_names_that_mean_nothing_are_refused(name: str, words: str) -> None:
    with pytest.raises(InputError) as refusal:
        resolve_candidate(name)
    assert words in str(refusal.value)


def test_what_is_behind_the_loop_decides_on_the_hash(tmp_path: Path) -> None:
    first = resolve_candidate(mine(tmp_path, "return Command(4.0, 0.5)")).content_hash
    assert resolve_candidate(mine(tmp_path, "return Command(4.0, 0.6)")).content_hash != first

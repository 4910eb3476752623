"""The plan of a check is made for one drive, which stands in every job as a whole."""

from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegate.candidates.declaration import Declaration, FlowchartProfile
from drivegate.candidates.resolution import resolve_candidate
from drivegate.gate import engine
from drivegate.gate.options import CheckOptions
from drivegate.gate.plan import SHARDS, planned_work, shard_seeds
from drivegate.gate.shard import FixedRuns, JointRuns, run_joint
from drivegate_cases.drive.drive_document import load_drive

PAPER = load_drive("paper-5-phase")
MINE = PAPER.replaced(name="mine", resistance_ohm=0.1)
FLOWCHART = FlowchartProfile(
    speed_tolerance=0.5, power_tolerance=0.0, power_tolerance_fraction=0.001, step=0.02, period=0.1
)


def test_every_job_is_on_the_drive_that_is_given() -> None:
    work = planned_work("default", 0, declaration=Declaration(FLOWCHART), drive=MINE)
    for item in work:
        payload: Any = item.job.payload
        if isinstance(payload, FixedRuns):
            drives = {scenario.drive for scenario in payload.scenarios}
        else:
            drives = {payload.scenario.drive if hasattr(payload, "scenario") else payload.drive}
        assert drives == {MINE}, f"{item.label} runs on {drives}"


def test_joint_runs_are_drawn_for_their_drive(monkeypatch: Any) -> None:
    made: list[FixedRuns] = []
    monkeypatch.setattr("drivegate.gate.shard.run_fixed", lambda _, plan: made.append(plan))
    run_joint(engine_loaded(), JointRuns(MINE, 0, 0, 8))
    assert {scenario.drive for scenario in made[0].scenarios} == {MINE}


def engine_loaded() -> Any:
    from drivegate.containment.judge import own_candidate

    return own_candidate(resolve_candidate("reference"))


def test_a_check_is_planned_on_the_drive_that_is_named(monkeypatch: Any) -> None:
    planned: list[Any] = []
    monkeypatch.setattr(engine, "planned_work", lambda *_, **options: planned.append(options["drive"]) or [])
    for count, drive in enumerate((None, MINE), start=1):
        events = iter(engine.check_candidate(resolve_candidate("reference"), CheckOptions(drive=drive)))
        # A check first reports that it has started and, with a cold cache, that it compiles.
        while len(planned) < count:
            next(events)
    assert planned == [PAPER, MINE]


def test_runs_of_some_minutes_are_made_every_night_alone() -> None:
    drive = load_drive("pm-ac-interior")
    planned = {
        effort: [
            scenario.duration_s
            for item in planned_work(effort, 0, drive=drive, declaration=Declaration(references=("torque",)))
            if isinstance(item.job.payload, FixedRuns)
            for scenario in item.job.payload.scenarios
        ]
        for effort in ("default", "nightly")
    }
    assert max(planned["default"]) < 100.0
    added = Counter(planned["nightly"]) - Counter(planned["default"])
    assert added == Counter([150.0, 2.0]), "one of some minutes, and one after a million turns"


@given(seed=st.integers(0, 2**63 - 1), one=st.text(min_size=1), other=st.text(min_size=1))
def test_half_of_the_shards_are_a_candidates_own(seed: int, one: str, other: str) -> None:
    common, own = shard_seeds(seed), shard_seeds(seed, one)
    assert own == shard_seeds(seed, one), "equal sources and an equal seed draw the same"
    assert common == tuple(range(seed * SHARDS, (seed + 1) * SHARDS))
    changed = [shard for shard in range(SHARDS) if common[shard] != own[shard]]
    assert changed == [1, 3, 5, 7]
    if one != other:
        assert not {own[shard] for shard in changed} & set(shard_seeds(seed, other))
    assert not {own[shard] for shard in changed} & set(shard_seeds(seed + 1, one))
    for groups in range(1, 17):
        assert [made % groups for made in own] == [made % groups for made in common], (
            "the families take turns"
        )


@pytest.mark.parametrize(("specification", "is_own"), [("initial", False), ("{folder}/mine.py:Mine", True)])
def test_the_gate_draws_by_the_sources_of_a_candidate(
    specification: str, is_own: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    planned: list[str] = []

    def plan(*_given: object, content_hash: str, **_named: object) -> list[Any]:
        planned.append(content_hash)
        raise KeyboardInterrupt

    (tmp_path / "mine.py").write_text("class Mine: pass", encoding="utf-8")
    candidate = resolve_candidate(specification.format(folder=tmp_path))
    monkeypatch.setattr(engine, "planned_work", plan)
    with pytest.raises(KeyboardInterrupt):
        list(engine.check_candidate(candidate, CheckOptions()))
    assert planned == [candidate.content_hash if is_own else ""]


def test_compared_candidates_meet_the_same_scenarios() -> None:
    drawn = [
        item.job.payload for item in planned_work("quick", 3, drive=PAPER) if item.label.startswith("shard")
    ]
    assert [plan.seed for plan in drawn] == list(shard_seeds(3))

"""The comparison over whole families counts the runs of the faulty controller up to the first that shows it."""

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from drivegate.checks.check import JudgedRun
from drivegate.checks.margin import Margin
from drivegate_cases.drive.drive_document import load_drive
from measured_text import write_measured
from search_on_families import SEARCHES, Trial, allowance, table

FAULT = "slope-doubled"


@pytest.fixture
def judged_by_speed(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], list[str]]:
    """Put a margin that falls toward a speed in the place of runs and checks; return who runs, in turn."""

    def install(base_margin: float) -> list[str]:
        ran: list[str] = []

        def judged(record: Any, _checks: object) -> JudgedRun:
            ran.append(record.name)
            away = abs(record.scenario.speed_rpm[-1][1] - 1003.0) / 1000.0
            margin = away - 0.02 if record.name.startswith("faulty") else base_margin
            return JudgedRun(record.scenario.to_mapping(), (Margin("ADV-2", margin, "made up"),))

        def recorded(loaded: Any, scenario: Any, _controller: object, **_: object) -> SimpleNamespace:
            return SimpleNamespace(name=loaded.candidate.name, scenario=scenario)

        monkeypatch.setattr("drivegate.gate.shard.recorded", recorded)
        monkeypatch.setattr("search_on_families.judged", judged)
        return ran

    return install


@pytest.mark.parametrize("name", SEARCHES)
def test_a_trial_ends_with_the_first_run_that_shows_the_fault(
    name: str, judged_by_speed: Callable[[float], list[str]]
) -> None:
    ran = judged_by_speed(0.5)
    runs = Trial(load_drive("paper-5-phase"), FAULT).runs_to_failure(SEARCHES[name], 1)
    assert ran[-1] == "reference", "the last run is that of the controller without the fault"
    assert runs == len(ran) - 1 == ran.count(f"faulty:{FAULT}") < allowance(FAULT)


def test_what_the_controller_without_the_fault_fails_as_well_is_not_counted(
    judged_by_speed: Callable[[float], list[str]],
) -> None:
    ran = judged_by_speed(-0.5)
    assert Trial(load_drive("paper-5-phase"), f"{FAULT}:1").runs_to_failure(SEARCHES["shard"], 1) is None
    assert "reference" in ran
    assert ran.count(f"faulty:{FAULT}") <= allowance(f"{FAULT}:1")


def test_a_row_is_written_when_all_of_its_trials_are_there() -> None:
    key = f"paper-5-phase/{FAULT}"
    runs = {"default/climbing": (None, 12), "default/shard": (3, 7)}
    runs |= {"nightly/climbing": (12, None), "nightly/shard": (4, 6)}
    trials = {f"{key}/{name}/{number}": each for name in runs for number, each in enumerate(runs[name])}
    document = {"trials": trials, "processor_seconds": 120.0}
    mean = (allowance(FAULT, "nightly") + 12) // 2
    row = f"| `{FAULT}` | `ADV-2` | all | 1 of 2 | 2 of 2 | 1 of 2 | 2 of 2 | {mean} | 5 |"
    assert row in table(document, 2)
    assert f"| *all* | | | | | | | {mean} | 5 |" in table(document, 2)
    assert "in 2 minutes of processor time" in table(document, 2)
    assert FAULT not in table(document, 3), "the third seed is missing"


def test_what_is_measured_replaces_what_was_between_the_marks(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- one: begin -->\nold\n<!-- one: end -->\nafter\n", encoding="utf-8")
    write_measured(page, "one", "new")
    expected = "before\n<!-- one: begin -->\n\nnew\n\n<!-- one: end -->\nafter\n"
    assert page.read_text(encoding="utf-8") == expected

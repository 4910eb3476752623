"""The table of kinds of faults in the docs has every kind, and is measured in the order that is cheapest."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from drivegate.gate.shard import FixedRuns
from drivegate_cases.drive.drive_document import load_drive
from drivegate_lab.selftest.operations import operations
from drivegate_lab.selftest.run import SelftestEffort, planned_trial
from drivegate_lab.selftest.trial import Catch, TrialOutcome
from kinds_of_faults import PAGE, Row, caught_with, expected_first, place_of, table, without_fixed_runs
from measured_text import write_measured

NAMED = "pm-ac-interior"
DRIVE = load_drive(NAMED)
KIND = next(each for each in operations(DRIVE) if each.kind == "large torque steps")


def test_the_page_has_every_kind_with_its_faulty_controllers() -> None:
    place = re.search(
        r"<!-- kinds of faults on pm ac interior: begin -->(.*?)<!--", PAGE.read_text("utf-8"), re.DOTALL
    )
    assert place is not None
    rows = [re.split(r" *\| *", line)[1:] for line in place[1].splitlines() if line.startswith("| ")][2:]
    expected = [(each.kind, f"`{fault.name}`") for each in operations(DRIVE) for fault in each.faults]
    assert [(kind, fault) for kind, fault, *_ in rows] == expected
    assert [run for _, _, _, run, *_ in rows if not run.startswith("`")] == []


def test_runs_of_the_kind_come_first_and_drawn_runs_have_their_seeds() -> None:
    effort = SelftestEffort("quick", seeds=1, drive=DRIVE)
    trial = planned_trial(KIND.faults[0], effort)
    expected = frozenset(run.name for run in KIND.runs)
    first = expected_first(trial, expected).fixed
    assert {run.name for job in first[: len(KIND.runs)] for run in job.payload.scenarios} == expected
    assert len(first) == len(trial.fixed)
    drawn = without_fixed_runs(trial, SelftestEffort("quick", seeds=2, drive=DRIVE))
    assert drawn.fixed == ()
    usual = [job.payload for job in trial.seeded[0] if not isinstance(job.payload, FixedRuns)]
    assert [job.payload for job in drawn.seeded[0]] == usual
    assert drawn.seeded[0] != drawn.seeded[1]


def test_a_row_has_the_run_and_the_share_of_seeds() -> None:
    catch = Catch(1, "a run", "0 Nm", 1, ())
    assert caught_with(TrialOutcome({0: catch, 1: None}, (), 2, (), 0)) == "1 of 2"
    row = Row("clocks", "late", "ACC-1", "a-run", "every effort and seed")
    assert table([row]).endswith("\n| clocks | `late` | ACC-1 | `a-run` | every effort and seed |")
    assert table([replace(row, run="", caught="quick 1 of 2", alone="1 of 2")]).splitlines() == [
        "| kind of operation | faulty controller | check | caught in | caught at | drawing alone, quick |",
        "| --- | --- | --- | --- | --- | --- |",
        "| clocks | `late` | ACC-1 | drawn runs | quick 1 of 2 | 1 of 2 |",
    ]


def test_a_page_without_a_place_for_the_drive_is_refused(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "<!-- kinds of faults on my drive: begin -->\nold\n<!-- kinds of faults on my drive: end -->", "utf-8"
    )
    write_measured(page, place_of("my-drive"), "new")
    assert "\nnew\n" in page.read_text("utf-8")
    with pytest.raises(SystemExit, match="has no place '<!-- kinds of faults on other: begin -->'"):
        write_measured(page, place_of("other"), "new")

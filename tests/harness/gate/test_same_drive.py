"""Records of another drive are refused: a baseline, a counterexample, a waiver."""

from typing import Any

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.gate.engine import check_candidate
from drivegate.gate.focus import Focus
from drivegate.gate.options import CheckOptions
from drivegate.results.baseline import Baseline
from drivegate.results.counterexample import Counterexample
from drivegate.results.waivers import WaiverFile
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.errors import InputError

PAPER = load_drive("paper-5-phase")
MINE = PAPER.replaced(name="mine", resistance_ohm=0.1)
RENAMED = PAPER.replaced(name="renamed", provenance={})
SCENARIO = load_scenario("lock-up")


def baseline(drive: DriveDocument) -> Baseline:
    run = {
        "name": "lock-up",
        "scenario": SCENARIO.replaced(drive=drive).to_mapping(),
        "margins": {"CNV-1": 0.5},
    }
    return parse_document({"schema": 2, "kind": "check", "fixed": [run]}, Baseline, "the baseline")


def counterexample(drive: DriveDocument) -> Counterexample:
    stored = {
        "schema": 2,
        "kind": "counterexample",
        "check": "CNV-1",
        "candidate": {"name": "x"},
        "scenario": SCENARIO.replaced(drive=drive).to_mapping(),
    }
    return parse_document(stored, Counterexample, "the counterexample")


def waivers(drive: str | None) -> Any:
    waiver = {
        "check": "CNV-2",
        "candidate": "reference",
        "reason": "later",
        "owner": "us",
        "expires": "2999-01-01",
        "margin": -1.0,
    }
    content = {"schema": 1, "waiver": [waiver | ({} if drive is None else {"drive": drive})]}
    return parse_document(content, WaiverFile, "the waivers").waiver


def begun(drive: DriveDocument, **records: Any) -> None:
    next(iter(check_candidate(resolve_candidate("reference"), CheckOptions(drive=drive, **records))))


@pytest.mark.parametrize(
    ("records", "reported"),
    [
        ({"baseline": baseline(PAPER)}, 'the baseline is of the drive "paper-5-phase"'),
        ({"corpus": (counterexample(PAPER),)}, 'a counterexample to CNV-1 is of the drive "paper-5-phase"'),
        ({"focus": Focus(first=(counterexample(PAPER),))}, "a counterexample to CNV-1 is of the drive"),
        ({"waivers": waivers(None)}, 'is for the drive "paper-5-phase", but the check is on "mine"'),
        ({"waivers": waivers("other")}, 'is for the drive "other", but the check is on "mine"'),
    ],
    ids=["baseline", "corpus", "last failed", "waiver without drive", "waiver"],
)
def test_a_record_of_another_drive_is_refused(records: dict[str, Any], reported: str) -> None:
    with pytest.raises(InputError) as refusal:
        begun(MINE, **records)
    assert reported in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_record_of_the_same_drive_is_taken() -> None:
    begun(MINE, baseline=baseline(MINE), corpus=(counterexample(MINE),), waivers=waivers("mine"))
    begun(PAPER, baseline=baseline(PAPER), corpus=(counterexample(PAPER),), waivers=waivers(None))


def test_a_drive_is_known_by_its_values_and_not_by_its_name() -> None:
    assert RENAMED.values_hash == PAPER.values_hash != MINE.values_hash
    begun(RENAMED, baseline=baseline(PAPER), corpus=(counterexample(PAPER),))


def test_a_waiver_of_another_candidate_is_left_alone() -> None:
    next(iter(check_candidate(resolve_candidate("initial"), CheckOptions(drive=MINE, waivers=waivers(None)))))

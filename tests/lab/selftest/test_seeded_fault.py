"""Faulty controllers of either contract: those of the drive's are chosen, and described for it."""

import pytest

from drivegate.contracts.catalogue import contract_named
from drivegate_cases.drive.drive_document import load_drive
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS
from drivegate_lab.candidates.faults.catalogue import MUTATIONS
from drivegate_lab.candidates.field_faults import FIELD_FAULTS
from drivegate_lab.selftest.run import SelftestEffort, planned_trial
from drivegate_lab.selftest.subjects import chosen_faults, correct_designs
from drivegate_models.errors import InputError

INTERIOR, SURFACE, PAPER = map(load_drive, ("pm-ac-interior", "pm-ac-surface", "paper-5-phase"))


def test_without_names_all_of_the_contract_are_chosen() -> None:
    assert [fault.name for fault in chosen_faults((), INTERIOR)] == [*DUTY_FAULTS, *FIELD_FAULTS]
    assert [fault.name for fault in chosen_faults((), PAPER)] == list(MUTATIONS)


def test_each_names_a_check_of_its_contract_and_a_kind() -> None:
    chosen = chosen_faults((), INTERIOR)
    assert {fault.check_on(INTERIOR) for fault in chosen} <= {
        check.id for check in contract_named("duty").checks
    }
    assert {fault.base for fault in chosen} == {"foc"}
    assert {fault.kind for fault in chosen if fault.name not in FIELD_FAULTS} == {
        "Wrong numbers of the drive",
        "Regulation",
        "Senses and answers",
        "Instances and resets",
        "DC link",
        "Temperature of the windings",
    }


def test_names_may_have_the_prefix_and_count_once() -> None:
    chosen = chosen_faults(("swapped-phases", "faulty:swapped-phases"), INTERIOR)
    assert [fault.name for fault in chosen] == ["swapped-phases"]


@pytest.mark.parametrize(("name", "idles"), [("saliency-ignored", True), ("wrong-pole-pairs", False)])
def test_a_saliency_that_a_machine_does_not_have_cannot_be_taken_wrongly(name: str, idles: bool) -> None:
    (fault,) = chosen_faults((name,), SURFACE)
    assert (fault.on(SURFACE).idle_because is not None) is idles
    assert fault.on(INTERIOR).idle_because is None
    assert fault.on(INTERIOR).sentence == DUTY_FAULTS[name].sentence


def test_a_dead_time_can_be_taken_wrongly_on_a_drive_that_is_run_with_one_all_the_same() -> None:
    assert SURFACE.to_mapping()["inverter"]["dead_time_s"] == 0.0
    (fault,) = chosen_faults(("dead-time-times-ten",), SURFACE)
    assert fault.on(SURFACE).idle_because is None


@pytest.mark.parametrize(
    ("name", "named"),
    [
        ("angle-offset", ("ACC-1", "ACC-1", "FWK-2")),
        ("strong-magnets-assumed", ("FWK-2", "FWK-2", "ACC-1")),
        ("saliency-ignored", ("MTP-1", "FWK-2", "FWK-2")),
        ("swapped-phases", ("ACC-1", "ACC-1", "ACC-1")),
    ],
)
def test_what_shows_by_reluctance_torque_shows_elsewhere_without(name: str, named: tuple[str, ...]) -> None:
    drives = (INTERIOR, load_drive("pm-ac-2kw"), SURFACE)
    assert tuple(chosen_faults((name,), drive)[0].check_on(drive) for drive in drives) == named


@pytest.mark.parametrize(
    ("name", "drive", "stated"),
    [
        ("drifts", INTERIOR, "takes duty ratios; name a drive such as paper-5-phase with --drive"),
        ("swapped-phases", PAPER, "answers with duty ratios"),
        ("swaped-phases", INTERIOR, "is unknown, the nearest known one is 'swapped-phases'"),
    ],
)
def test_one_that_the_drive_cannot_have_is_refused(name, drive, stated) -> None:
    with pytest.raises(InputError) as refused:
        chosen_faults((name,), drive)
    assert stated in str(refused.value)


def test_a_trial_is_planned_from_the_runs_of_the_drive() -> None:
    (fault,) = chosen_faults(("swapped-phases",), INTERIOR)
    trial = planned_trial(fault, SelftestEffort("quick", seeds=2, drive=INTERIOR))
    assert (trial.candidate.name, trial.base.name, trial.check) == ("faulty:swapped-phases", "foc", "ACC-1")
    scenarios = [scenario for job in trial.fixed for scenario in job.payload.scenarios]
    assert {scenario.drive for scenario in scenarios} == {INTERIOR}
    assert all(trial.seeded.values())


def test_correct_controllers_of_duty_ratios_are_those_that_weaken() -> None:
    names = [design.candidate for design in correct_designs("duty")]
    assert "foc" in names
    assert "foc-mtpa" not in names
    assert all(design.checks is None for design in correct_designs("duty"))

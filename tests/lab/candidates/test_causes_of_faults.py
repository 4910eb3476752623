"""Every planted fault of duty ratios belongs to one likely cause, and typical ones are explained by it."""

from __future__ import annotations

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_named
from drivegate.contracts.duty.likely_causes import LIKELY_CAUSES, likely_causes
from drivegate.contracts.duty.scenarios.building import share_scenario, with_lost_samples
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS
from drivegate_lab.candidates.field_faults import FIELD_FAULTS


def test_every_known_fault_has_one_cause() -> None:
    listed = [name for cause in LIKELY_CAUSES for name in cause.faults]
    assert len(listed) == len(set(listed))
    assert set(DUTY_FAULTS) <= set(listed) <= set(DUTY_FAULTS) | set(FIELD_FAULTS)


@pytest.mark.parametrize(
    ("name", "share", "words"),
    [
        ("eager-integrals", 0.5, "or its integral alone is"),
        ("undervoltage-at-once", 0.5, "the bridge is off where nothing has failed"),
    ],
)
def test_a_faulty_controller_is_explained_by_its_own_cause(name: str, share: float, words: str) -> None:
    drive = load_drive("pm-ac-interior").replaced(settling_s=0.1)
    assert isinstance(drive, PmAcDocument)
    loaded = own_candidate(resolve_candidate(f"faulty:{name}"))
    run = share_scenario(drive, share * drive.rating.base_speed_rpm, 0.2, 0.6)
    if name == "undervoltage-at-once":
        run = with_lost_samples(run, ("supply",), (0.1,))
    record = recorded(loaded, run, loaded.controller())
    margins = [
        margin for check in contract_named("duty").checks if (margin := check.evaluate(record)) is not None
    ]
    failed = [
        {"id": each.check, "measured": each.measured}
        for each in margins
        if not each.met and not each.advisory
    ]
    assert words in likely_causes(failed)[0][0].words

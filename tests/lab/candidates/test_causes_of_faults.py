"""Every planted fault of duty ratios belongs to one likely cause."""

from __future__ import annotations

from drivegate.contracts.duty.likely_causes import (
    LIKELY_CAUSES,
)
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS


def test_every_known_fault_has_one_cause() -> None:
    listed = [name for cause in LIKELY_CAUSES for name in cause.faults]
    assert sorted(listed) == sorted(DUTY_FAULTS)

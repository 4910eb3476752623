"""The likely causes of failed checks: every known fault has one cause, and typical failures name it."""

from __future__ import annotations

import pytest

from drivegate.contracts.catalogue import contract_named
from drivegate.contracts.duty.likely_causes import (
    LIKELY_CAUSES,
    MOST_NAMED,
    likely_causes,
    likely_causes_in_words,
)

CHECKS = {check.id for check in contract_named("duty").checks}


def test_signs_and_what_confirms_a_cause_name_checks_that_there_are() -> None:
    for cause in LIKELY_CAUSES:
        assert {sign.partition(":")[0] for sign in cause.signs} <= CHECKS, cause.words
        assert cause.confirming_check in CHECKS, cause.words


@pytest.mark.parametrize(
    ("failed", "fault"),
    [
        (
            {"STP-1": "5.1 ms to 90 %, 2.252 ms are allowed", "DEC-1": "d current moved by 0.1 A"},
            "slow-currents",
        ),
        ({"STP-1": "overshoot 14.9 % from 0.5 to 1 N·m"}, "nervous-currents"),
        ({"OVC-1": "9.9323 A", "OVC-2": "9.89 A, the limit is 7.07 A"}, "generous-current-limit"),
        ({"EST-1": "estimate 1.608 N·m of a torque of 2.274 N·m"}, "torque-of-rms-currents"),
        ({"DTM-1": "torque swings by 0.07 N·m, 20 times"}, "dead-time-times-ten"),
        ({"DEC-1": "d current moved by 0.2 A"}, "late-samples"),
        ({"FWK-3": "braking with 0.2978 N·m, 13.1 %"}, "delay-turned-back"),
        (
            {"ROB-5": "torque off by 1 N·m, where the controller has turned all legs off"},
            "undervoltage-at-once",
        ),
        ({"ROB-4": "speed off by 9 rpm, where the controller has turned all legs off"}, "lowering-refused"),
        ({"DEC-1": "d current moved by 0.2 A"}, "eager-integrals"),
        ({"STP-1": "overshoot 14.9 % from 0.5 to 1 N·m"}, "eager-integrals"),
        ({"SAF-1": "torque 72.82 N·m beyond its reference"}, "third-current-computed"),
    ],
)
def test_typical_failures_name_the_cause(failed: dict[str, str], fault: str) -> None:
    checks = [{"id": check, "measured": measured} for check, measured in failed.items()]
    named = likely_causes(checks)
    assert 1 <= len(named) <= MOST_NAMED
    assert any(fault in cause.faults for cause in named)
    assert len(likely_causes_in_words(checks)) == len(named)


def test_modulation_that_is_not_declared_is_named_where_a_leg_is_clamped() -> None:
    swing = "torque swings by 0.1 N·m, 1.8 times the 0.0556 N·m of ideal modulation, at 750 rpm, 0.9 to 1 s"
    clamped = likely_causes([{"id": "RIP-4", "measured": f"{swing}; a leg is clamped nearly always: if"}])
    assert "not declare" in clamped[0].words
    plain = likely_causes([{"id": "RIP-4", "measured": swing}])
    assert all("not declare" not in cause.words for cause in plain)


def test_nothing_is_named_where_nothing_fails() -> None:
    assert likely_causes([]) == ()

"""The likely causes of failed checks: every known fault has one cause, and typical failures name it."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from drivegate.contracts.catalogue import contract_named
from drivegate.contracts.duty.likely_causes import (
    LIKELY_CAUSES,
    MOST_NAMED,
    LikelyCause,
    likely_causes,
    likely_causes_in_words,
)

CHECKS = {check.id for check in contract_named("duty").checks}


def named_for(failed: list[dict[str, str]]) -> list[LikelyCause]:
    return [cause for cause, _ in likely_causes(failed)]


def in_words(failed: dict[str, str], *, met: Iterable[str] = (), unjudged: Iterable[str] = ()) -> list[str]:
    checks = [{"id": check, "measured": measured} for check, measured in failed.items()]
    return list(
        likely_causes_in_words(checks, set(met), set(unjudged), "drivegate check mine --only {}".format)
    )


OFFSET = {"ACC-1": "torque off by 0.3 N·m", "FWK-2": "d current -2 A, 0 A is best", "FWK-1": "torque"}
"""What an offset of the angle shows, but for the check that tells it from other causes."""


def test_a_cause_is_confirmed_by_a_further_check_that_failed() -> None:
    first = in_words(OFFSET | {"SYM-1": "torque 1 N·m against 0.8 N·m"})[0]
    assert first.startswith(
        "the angle of the shaft has an offset; SYM-1 fails too, which confirms it: a run back"
    )


def test_a_check_that_did_not_run_confirms_nothing_and_the_command_runs_it() -> None:
    for unjudged in (["SYM-1"], CHECKS):
        listed = in_words({"ACC-1": OFFSET["ACC-1"], "FWK-1": "torque"}, unjudged=unjudged)
        (offset,) = (words for words in listed if "angle of the shaft" in words)
        assert "confirms" not in offset
        assert "not confirmed yet; drivegate check mine --only SYM-1 fails if so: " in offset


def test_a_cause_is_not_named_that_checks_which_are_met_speak_against() -> None:
    listed = in_words({"ACC-1": OFFSET["ACC-1"]}, met=CHECKS - {"ACC-1"})
    assert listed
    for words in listed:
        assert "angle of the shaft" not in words
        assert "STA-1" not in words


@pytest.mark.parametrize("check", sorted(CHECKS))
@pytest.mark.parametrize("others", ["met", "unjudged"])
def test_no_failed_check_confirms_itself(check: str, others: str) -> None:
    measured = "overshoot 14 %" if check == "STP-1" else "as measured"
    for words in in_words({check: measured}, **{others: CHECKS - {check}}):
        assert "fails too" not in words
        assert others == "met" or "see in the run of" in words or "drivegate check" in words


@pytest.mark.parametrize(
    ("failed", "words"),
    [
        ({"ROB-4": "speed overshoots by 60 rpm", "DEC-1": "d current moved by 0.2 A"}, "the speed reaches"),
        (
            {
                "ACC-1": "torque off by 14.55 N·m from 1.161 N·m",
                "STP-1": "90 % is not reached",
                "FWK-1": "-6.349 of 1.415 N·m",
                "FWK-3": "braking with 293.5 N·m",
                "RIP-4": "torque swings by 373 N·m",
                "MTP-1": "1.37e+04 % above 0.8876 A",
                "OVC-1": "203.75 A",
                "STA-1": "0 % of the speed",
            },
            "frozen",
        ),
        ({"ACC-1": "torque off by 0.1 N·m from -0.1 N·m", "SYM-1": "torque"}, "loses its sign"),
        (
            {
                "ACC-1": "torque off by 1.127 N·m from 0 N·m at 640 rpm",
                "STP-1": "overshoot 1.19e+03 % from 0.2274 to 0 N·m",
                "FWK-2": "d current -9.996 A, -0.3031 A is best",
                "FWK-3": "braking with 4.446 N·m",
                "MTP-1": "657 % above 1.324 A",
                "OVC-1": "20.571 A",
                "OVC-2": "10.073 A",
            },
            "quotient by a reference of 0",
        ),
    ],
)
def test_causes_that_were_missing_are_named(failed: dict[str, str], words: str) -> None:
    assert any(words in listed for listed in in_words(failed, unjudged=CHECKS - set(failed)))


def test_signs_and_what_confirms_a_cause_name_checks_that_there_are() -> None:
    for cause in LIKELY_CAUSES:
        assert {sign.partition(":")[0] for sign in cause.signs} <= CHECKS, cause.words
        assert cause.confirmations, cause.words
        assert {sign.partition(":")[0] for sign, _ in cause.confirmations} <= CHECKS, cause.words


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
    named = named_for(checks)
    assert 1 <= len(named) <= MOST_NAMED
    assert any(fault in cause.faults for cause in named)


def test_modulation_that_is_not_declared_is_named_where_a_leg_is_clamped() -> None:
    swing = "torque swings by 0.1 N·m, 1.8 times the 0.0556 N·m of ideal modulation, at 750 rpm, 0.9 to 1 s"
    clamped = named_for([{"id": "RIP-4", "measured": f"{swing}; a leg is clamped nearly always: if"}])
    assert "not declare" in clamped[0].words
    plain = named_for([{"id": "RIP-4", "measured": swing}])
    assert all("not declare" not in cause.words for cause in plain)


def test_nothing_is_named_where_nothing_fails() -> None:
    assert likely_causes([]) == ()

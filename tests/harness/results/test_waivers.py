"""Waivers: what they accept, what they do not, and what is wrong with a file of them."""

from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

import pytest
from tests.harness.made import made_outcome

from drivegate.candidates.fault import Fault, FaultKind
from drivegate.results.document import CheckSection
from drivegate.results.verdict import candidate_verdict
from drivegate.results.waivers import Waiver, present_day, read_waivers, under_waivers
from drivegate_models.errors import InputError

TODAY = date(2030, 6, 15)


def waiver(**changes: Any) -> Waiver:
    values = {
        "check": "CNV-2",
        "candidate": "mine",
        "reason": "known since spring",
        "owner": "Ada",
        "expires": date(2030, 12, 31),
        "margin": -1.0,
    }
    return Waiver.model_validate(values | changes)


def outcome(
    verdict: str, margin: float | None, level: str = "required", check: str = "CNV-2"
) -> CheckSection:
    return made_outcome(check, verdict, margin=margin, level=level, message="3 %")


def judged(verdict: str, margin: float | None, one: Waiver, level: str = "required") -> tuple[str, str, int]:
    outcomes = under_waivers([outcome(verdict, margin, level)], "mine", [one], TODAY)
    assert outcomes[0].waiver == {
        "reason": one.reason,
        "owner": one.owner,
        "expires": one.expires.isoformat(),
        "margin": one.margin,
    }
    return outcomes[0].verdict, outcomes[0].message, candidate_verdict(outcomes, [])[1]


def test_a_failure_is_waived_until_its_day_and_down_to_its_margin() -> None:
    verdict, message, code = judged("fail", -1.0, waiver())
    assert (verdict, code) == ("waived", 0)
    assert "waived by Ada until 2030-12-31: known since spring" in message
    assert judged("fail", -0.2, waiver(expires=TODAY))[0] == "waived", "a waiver holds on its last day"


def test_below_its_margin_a_waiver_does_not_hold() -> None:
    verdict, message, code = judged("fail", -1.01, waiver())
    assert (verdict, code) == ("fail", 1)
    assert "accepts margins down to -1, not -1.01" in message
    assert judged("fail", float("nan"), waiver())[0] == "fail"
    assert judged("fail", None, waiver())[0] == "fail"


def test_a_waiver_expires() -> None:
    verdict, message, code = judged("fail", -0.5, waiver(expires=date(2030, 6, 14)))
    assert (verdict, code) == ("waiver expired", 1)
    assert "expired after 2030-06-14" in message


@pytest.mark.parametrize("level", ["required", "advisory"])
def test_a_check_that_passes_needs_no_waiver(level: str) -> None:
    verdict, message, code = judged("pass", 0.5, waiver(), level)
    assert (verdict, code) == ("unexpectedly passes", 1)
    assert "is no longer needed; remove it" in message


@pytest.mark.parametrize("verdict", ["inconclusive", "not applicable"])
def test_what_was_not_judged_stays_so(verdict: str) -> None:
    assert judged(verdict, None, waiver())[0] == verdict


def test_a_waiver_is_for_its_candidate_and_check_alone() -> None:
    outcomes = [outcome("fail", -0.5), outcome("fail", -0.5, check="CNV-1")]
    assert under_waivers(outcomes, "other", [waiver()], TODAY) == tuple(outcomes)
    own = under_waivers(outcomes, "mine", [waiver()], TODAY)
    assert [one.verdict for one in own] == ["waived", "fail"]
    assert candidate_verdict(own, []) == ("fail", 1)


@pytest.mark.parametrize("kind", list(FaultKind))
def test_no_waiver_covers_a_fault(kind: FaultKind) -> None:
    waived = under_waivers([outcome("fail", -0.5)], "mine", [waiver()], TODAY)
    assert candidate_verdict(waived, []) == ("waived", 0)
    assert candidate_verdict(waived, [Fault(kind, "it happened", "step")]) == (kind.value, 1)


FILE = """
schema = 1
[[waiver]]
check = "CNV-2"
candidate = "mine"
reason = "known"
owner = "Ada"
expires = 2030-12-31
margin = -1.0
"""


def read(folder: Path, text: str, name: str = "waivers.toml") -> tuple[Waiver, ...]:
    (folder / name).write_text(text, encoding="utf-8")
    return read_waivers(folder / name, ["mine", "yours"])


def test_a_file_is_read(tmp_path: Path) -> None:
    assert read(tmp_path, FILE) == (waiver(reason="known"),)
    assert read(tmp_path, "schema = 1\n") == ()
    as_json = (
        '{"schema": 1, "waiver": [{"check": "CNV-2", "candidate": "mine", "reason": "known", "owner": "Ada", '
    )
    assert read(tmp_path, as_json + '"expires": "2030-12-31", "margin": -1}]}', "w.json") == read(
        tmp_path, FILE
    )


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("schema = 1", "schema = 2", "schema 2 is newer"),
        (
            "CNV-2",
            "CNV-22",
            'waiver 1 is for the check "CNV-22", but must be for one that there is, the nearest',
        ),
        ("CNV-2", "PWR-1", "a failure of the plant is never accepted"),
        ("CNV-2", "DET-1", "not deterministic is never accepted"),
        (
            '"mine"',
            '"his"',
            "is for the candidate \"his\", but must be for one of those checked, 'mine', 'yours'",
        ),
        ("expires = 2030-12-31", "", "the key 'waiver[0].expires' is missing"),
        ("2030-12-31", '"tomorrow"', "must be a day such as 2030-12-31"),
        ("2030-12-31", "2030-12-31T12:00:00", "must be a day such as 2030-12-31"),
        ("2030-12-31", "2030-02-31", "not well-formed TOML"),
        ("margin = -1.0", "margin = 0.0", "waiver[0].margin"),
        ("margin = -1.0", "margin = nan", "must be a finite number"),
        ('owner = "Ada"', 'owner = ""', "waiver[0].owner"),
        ("owner", "ovner", "the nearest known key is 'owner'"),
    ],
)
def test_a_bad_file_is_refused_in_one_sentence(tmp_path: Path, old: str, new: str, reason: str) -> None:
    assert old in FILE
    with pytest.raises(InputError) as refused:
        read(tmp_path, FILE.replace(old, new))
    assert reason in str(refused.value)
    assert "waivers.toml" in str(refused.value)


def test_two_waivers_for_the_same_are_refused(tmp_path: Path) -> None:
    twice = FILE + FILE.replace("schema = 1", "")
    with pytest.raises(InputError, match=r"waiver 2 .* for which there is one before"):
        read(tmp_path, twice)


def test_the_day_is_the_one_of_the_build(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    assert present_day() == date(1970, 1, 2)
    monkeypatch.delenv("SOURCE_DATE_EPOCH")
    assert present_day() == datetime.now(UTC).date()


@pytest.mark.parametrize("text", ["", "tomorrow", "1e400", "9" * 30])
def test_a_day_that_is_none_is_refused(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", text)
    with pytest.raises(InputError, match=r"SOURCE_DATE_EPOCH is .* whole number of seconds"):
        present_day()

"""The view of a result document: bounded, printable text, and plain numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from drivegate_models.errors import InputError
from drivegate_reports.conformance import words
from drivegate_reports.conformance.report import page
from drivegate_reports.conformance.view import page_values
from drivegate_reports.page.page import LONGEST_BLOCK, LONGEST_TEXT, clean, plain_data, plain_number

Factory = Callable[..., dict[str, Any]]


def test_counts_and_verdict_come_from_the_document(passing: dict[str, Any]) -> None:
    values = page_values(passing)
    result = values["result"]
    shown = (result["candidate"]["name"], result["verdict"], words.tone_of(result), result["exit_code"])
    assert shown == ("golden section", "pass", "pass", 0)
    assert [result[key] for key in ("runs", "set_aside", "seed", "effort")] == [131, 4, 7, "default"]
    assert [check["id"] for check in result["checks"]] == ["PWR-1", "ADV-1", "CNV-1", "FLO-1"]
    assert list(values["check_of"]) == ["PWR-1", "ADV-1", "CNV-1", "FLO-1"]


def test_what_was_set_aside_is_listed_with_the_reason(make_document: Factory) -> None:
    drawn = {"scenario": "550rpm <b>", "reason": "no advance angle gives the torque"}
    document = make_document(set_aside=1, infeasible=[drawn])
    assert page_values(document)["result"]["infeasible"] == [drawn]
    text = page(document)
    assert "<code>550rpm &lt;b&gt;</code>: no advance angle gives the torque" in text
    assert "Scenarios set aside" not in page(make_document(set_aside=0, infeasible=[]))


def test_a_failure_names_its_counterexample_and_what_to_do(failing: dict[str, Any]) -> None:
    values = page_values(failing)
    assert values["failing"] == ["CNV-1"], "an advisory failure does not fail the candidate"
    failed, advised, met = values["result"]["checks"][:3]
    assert words.tone_of(failed) == "fail"
    assert words.counterexample_file(failed) == "counterexamples/CNV-1.json"
    short = words.run_in_short(failed)
    assert short.startswith("fig5-search: 12 s, 1500 rpm"), short
    assert "duration_s: 12.0" in words.block(words.shown_run(failed))
    assert words.tone_of(advised) == "caution", "an advisory failure is no alarm"
    assert met not in values["broken"], "a check that is met has no counterexample"
    assert values["next_step"] == (
        "drivegate replay counterexamples/CNV-1.json --candidate 'golden.py:Golden Section' --plot CNV-1.svg"
    )


def test_a_check_that_does_not_apply_has_no_margin(passing: dict[str, Any]) -> None:
    check = page_values(passing)["result"]["checks"][-1]
    assert (words.margin_text(check["margin"]), words.tone_of(check)) == ("–", "quiet")
    assert words.shown_run(check) is None
    assert not words.is_known(check["margin"]), "so that no bar is drawn"
    assert check not in page_values(passing)["met"]


def test_the_message_does_not_repeat_what_was_measured(passing: dict[str, Any]) -> None:
    check = page_values(passing)["result"]["checks"][0]
    assert (check["measured"], words.outcome_in_words(check)) == ("speed error 3 rpm", "met in all 12 runs")


@pytest.mark.parametrize(
    ("margin", "start", "width"),
    [(0.5, 50.0, 24.0), (-0.5, 26.0, 24.0), (9.0, 50.0, 48.0), (-300.0, 2.0, 48.0)],
)
def test_margin_bars_go_from_the_middle_and_are_clipped(margin: float, start: float, width: float) -> None:
    bar = words.margin_bar(margin)
    assert (bar.start, bar.width) == pytest.approx((start, width))


def test_unprintable_characters_become_escapes() -> None:
    assert clean("a\x00b\u202ec\ud800\nd") == "a\\x00b\\u202ec\\ud800\nd"


def test_texts_are_bounded(make_document: Factory, make_check: Factory) -> None:
    scenario = make_check("CNV-1")["scenario"] | {"description": "x" * 100_000}
    fault = {
        "kind": "crash",
        "message": "m" * 9_000,
        "phase": "step",
        "error": "SIGSEGV",
        "traceback": "t" * 90_000,
        "step": None,
        "time_s": None,
        "sense": None,
    }
    checks = [make_check("CNV-1", scenario=scenario, message="y" * 9_000)]
    values = page_values(make_document(checks=checks, faults=[fault] * 500))
    (check,) = values["result"]["checks"]
    assert len(words.outcome_in_words(check)) == LONGEST_TEXT
    assert len(words.block(words.shown_run(check))) == LONGEST_BLOCK
    assert len(values["faults"][0]["traceback"]) == LONGEST_BLOCK
    assert (len(values["faults"]), len(values["result"]["faults"])) == (20, 500)


def test_plain_data_has_a_line_for_each_key() -> None:
    assert plain_data({"a": 1, "b": {"c": [[0.0, 1.0]]}, "d": {}}) == "a: 1\nb:\n  c: [[0.0, 1.0]]\nd: {}"


def test_a_scenario_that_cannot_be_given_in_short_is_named(
    make_document: Factory, make_check: Factory
) -> None:
    values = page_values(make_document(checks=[make_check("CNV-1", scenario={"name": "odd"})]))
    assert words.run_in_short(values["result"]["checks"][0]) == "odd"


@pytest.mark.parametrize(
    ("changes", "named"),
    [({"schema": 3}, "schema 3"), ({"schema": None}, "schema None"), ({"kind": "other"}, "other")],
)
def test_a_document_of_another_kind_or_newer_schema_is_refused(
    make_document: Factory, changes: dict[str, Any], named: str
) -> None:
    with pytest.raises(InputError) as refused:
        page_values(make_document(**changes))
    assert named in str(refused.value)


def test_waivers_and_a_baseline_are_shown(make_document: Factory, make_check: Factory) -> None:
    message = "Σ|i| 3 % too high; waived by Ada until 2030-12-31: known"
    waived = make_check("CNV-2", verdict="waived", margin=-0.5, message=message)
    entry = {"check": "CNV-1", "level": "required", "pairs": 9, "median_change": -0.2, "p_value": 0.01}
    lost = entry | {"verdict": "fail", "message": "the margin <b>fell</b>"}
    document = make_document(verdict="fail", exit_code=1, checks=[waived], baseline=[lost])
    values = page_values(document)
    shown = (values["result"]["checks"][0], values["result"]["baseline"][0])
    assert tuple(map(words.tone_of, shown)) == ("caution", "fail")
    assert values["meaning"] == "The margin of a required check has fallen against the baseline."
    text = page(document)
    assert "waived by Ada until 2030-12-31: known" in text
    assert 'id="baseline"' in text
    assert "the margin &lt;b&gt;fell&lt;/b&gt;" in text, "nothing in a result may act on the page"


def test_numbers_that_depend_on_the_machine_are_shown_with_their_check(
    make_document: Factory, make_check: Factory
) -> None:
    timed = make_check("TIM-1", level="advisory", margin=None, measured="", scenario=None)
    timing = {"seconds": 1.0, "checks": {"TIM-1": {"margin": 0.5, "measured": "12 µs a step"}}}
    values = page_values(make_document(checks=[timed], timing=timing))
    (check,) = values["result"]["checks"]
    assert (words.margin_text(check["margin"]), check["measured"]) == ("+0.5", "12 µs a step")
    assert "timing checks" not in dict(values["provenance"])
    assert not any("TIM-1" in name for name, _ in values["provenance"])


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (-399.2, 2, "−399"),
        (-46.3, 3, "−46.3"),
        (1e-12, 3, "+0"),
        (0.5538, 3, "+0.554"),
        (12345.0, 3, "+12345"),
    ],
)
def test_numbers_are_not_written_in_powers_of_ten(value: float, digits: int, text: str) -> None:
    assert plain_number(value, digits) == text


def test_a_failure_that_is_not_witnessed_yet_has_a_section_of_its_own(failing: dict[str, Any]) -> None:
    failing["verdict"] = failing["checks"][0]["verdict"] = "not yet witnessed"
    values = page_values(failing)
    assert [check["id"] for check in values["unwitnessed"]] == ["CNV-1"]
    assert failing["checks"][0]["id"] not in {check["id"] for check in values["broken"]}
    assert words.tone_of(values["result"]) == "caution"
    assert not values["failing"]
    text = page(failing)
    assert '<h2><span id="not-yet-witnessed">Not yet witnessed</span>' in text
    assert "ended before known good controllers were run in the same scenario" in text


def test_the_page_says_that_its_result_was_altered(passing: dict[str, Any]) -> None:
    assert page_values(passing)["alteration"] == ""
    edited = passing | {"verdict": "pass", "runs": 5000}
    assert "This result was altered after drivegate wrote it" in page(edited)
    assert "was altered" not in page(passing)

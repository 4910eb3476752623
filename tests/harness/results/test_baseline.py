"""The comparison with an earlier result: a real loss of margin fails, chance and small changes do not."""

import json
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import rankdata, wilcoxon

from drivegate.checks.check import JudgedRun
from drivegate.checks.margin import Margin
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.gate.plan import Origin, planned_work
from drivegate.results.baseline import Baseline, compared, loss_by_chance, read_baseline
from drivegate.results.document import ComparisonSection
from drivegate.results.result import content_hash
from drivegate.results.verdict import candidate_verdict
from drivegate_cases.scenario.scenario import Scenario, load_scenario
from drivegate_models.errors import InputError

LOCK_UP = load_scenario("lock-up")


def scenario(number: int) -> Scenario:
    return LOCK_UP.replaced(name=f"number {number}")


def earlier(margins: list[float | None], check: str = "CNV-2", **changes: Any) -> dict[str, Any]:
    fixed = [
        {"name": f"number {number}", "scenario": scenario(number).to_mapping(), "margins": {check: margin}}
        for number, margin in enumerate(margins)
    ]
    document = {"schema": 2, "kind": "check", "candidate": {"name": "any"}, "verdict": "pass", "fixed": fixed}
    return document | changes


def read(folder: Path, document: Any) -> Baseline:
    file = folder / "result.json"
    file.write_text(document if isinstance(document, str) else json.dumps(document), encoding="utf-8")
    return read_baseline(file)


def comparison(
    folder: Path, then: list[float | None], now: list[float], check: str = "CNV-2"
) -> ComparisonSection:
    runs = [
        JudgedRun(scenario(number).to_mapping(), (Margin(check, margin, "as measured"),))
        for number, margin in enumerate(now)
    ]
    (only,) = compared(read(folder, earlier(then, check)), runs, CHECKS)
    assert only.check == check
    return only


def test_a_real_loss_fails(tmp_path: Path) -> None:
    found = comparison(tmp_path, [0.9] * 6, [0.7, 0.8, 0.75, 0.8, 0.6, 0.9])
    assert (found.verdict, found.pairs) == ("fail", 6)
    assert found.median_change == pytest.approx(-0.125)
    assert found.p_value == pytest.approx(1 / 32), "five losses of five changes are one in 32 by chance"
    assert candidate_verdict([], [], [found]) == ("fail", 1)


def test_a_loss_that_chance_explains_passes(tmp_path: Path) -> None:
    found = comparison(tmp_path, [0.9] * 6, [0.1, 0.2, 1.9, 0.8, 1.6, 0.5])
    assert found.verdict == "pass"
    assert found.p_value is not None
    assert found.p_value > 0.05
    assert candidate_verdict([], [], [found]) == ("pass", 0)


def test_a_small_loss_passes_however_certain(tmp_path: Path) -> None:
    found = comparison(tmp_path, [0.9] * 8, [0.86] * 8)
    assert found.verdict == "pass"
    assert found.p_value == pytest.approx(1 / 256)


def test_a_gain_passes(tmp_path: Path) -> None:
    found = comparison(tmp_path, [0.1] * 8, [0.9] * 8)
    assert (found.verdict, found.p_value) == ("pass", 1.0)


def test_equal_margins_are_no_difference(tmp_path: Path) -> None:
    found = comparison(tmp_path, [0.5] * 8, [0.5] * 8)
    assert (found.verdict, found.median_change, found.p_value) == ("no difference", 0.0, None)


def test_it_takes_five_pairs(tmp_path: Path) -> None:
    found = comparison(tmp_path, [0.9, 0.9, 0.9, 0.9, None, 0.9], [0.1, 0.1, 0.1, 0.1, 0.1])
    assert (found.verdict, found.pairs) == ("too few pairs", 4)
    assert comparison(tmp_path, [0.9], []).median_change is None


def test_an_advisory_loss_is_reported_and_does_not_fail(tmp_path: Path) -> None:
    found = comparison(tmp_path, [0.9] * 5, [0.1] * 5, "CUR-1")
    assert (found.verdict, found.level) == ("fail", "advisory")
    assert candidate_verdict([], [], [found]) == ("pass", 0)


def test_the_plant_is_not_compared(tmp_path: Path) -> None:
    assert compared(read(tmp_path, earlier([0.9] * 5, "PWR-1")), [], CHECKS) == ()


@pytest.mark.parametrize("count", [5, 8, 9, 30])
def test_the_test_is_one_sided_and_certain_with_many(count: int) -> None:
    lost = [-0.1 - 0.001 * number for number in range(count)]
    assert loss_by_chance(lost) == pytest.approx(0.5**count, rel=1e-9)
    assert loss_by_chance([-change for change in lost]) == pytest.approx(1.0)


CHANGE = st.sampled_from([0.0, -1.5, 1.5, -0.5, 0.25]) | st.floats(-10.0, 10.0)


@given(st.lists(CHANGE, max_size=9))
def test_any_few_changes_have_the_probability_that_counting_signs_gives(changes: list[float]) -> None:
    """Each change has either sign by chance: of all signs, count those whose gains have ranks as small."""
    changed = [change for change in changes if change]
    ranks = rankdata(np.abs(changed))
    signs = np.array(list(product((0.0, 1.0), repeat=len(changed)))).reshape(2 ** len(changed), -1)
    gains = signs @ ranks
    expected = np.mean(gains <= ranks @ (np.array(changed) > 0.0))
    assert loss_by_chance(changes) == pytest.approx(expected, rel=1e-9)


@given(st.lists(st.floats(-10.0, 10.0).filter(bool), min_size=10, max_size=30, unique_by=abs))
def test_many_changes_have_the_probability_of_scipy(changes: list[float]) -> None:
    expected = wilcoxon(changes, alternative="less", method="exact").pvalue
    assert loss_by_chance(changes) == pytest.approx(expected, rel=1e-9)


def test_a_single_change_is_one_of_two_by_chance(tmp_path: Path) -> None:
    assert loss_by_chance([0.0, 0.0, 0.0, 0.0, -1.5]) == 0.5
    assert comparison(tmp_path, [0.9] * 5, [0.9, 0.9, 0.9, 0.9, -0.6]).verdict == "pass"


def test_a_comparison_says_that_its_baseline_was_altered(tmp_path: Path) -> None:
    runs = [JudgedRun(scenario(0).to_mapping(), (Margin("CNV-2", 0.5, "as measured"),))]
    document = earlier([0.9], faults=[], provenance={}, alteration="is as good as new")
    document["provenance"]["content_hash"] = content_hash(document)
    whole = read(tmp_path, document)
    document["fixed"][0]["margins"]["CNV-2"] = -3.0
    altered = read(tmp_path, document)
    (first,), (second,) = (compared(baseline, runs, CHECKS) for baseline in (whole, altered))
    assert "the baseline" not in first.message
    assert "the baseline was altered after drivegate wrote it" in second.message


def test_scenarios_of_the_baseline_are_run_once(tmp_path: Path) -> None:
    document = earlier([0.9, 0.9])
    document["fixed"].append({"name": "lock-up", "scenario": LOCK_UP.to_mapping(), "margins": {}})
    document["fixed"].append(document["fixed"][0])
    work = planned_work("quick", 0, baseline=read(tmp_path, document))
    assert [item.label for item in work if item.origin is Origin.BASELINE] == ["number 0", "number 1"]


@pytest.mark.parametrize(
    ("document", "reason"),
    [
        (json.dumps(earlier([0.9]))[:-3], "not well-formed JSON"),
        (earlier([0.9], schema=3), "schema 3 is newer"),
        (earlier([0.9], schema=1), "kept no margins of single scenarios"),
        (earlier([0.9], kind="counterexample"), 'is of kind "counterexample"'),
        ({"schema": 1, "kind": "checks", "results": []}, "results of several candidates"),
        ({"schema": 2, "kind": "check"}, "the key 'fixed' is missing"),
        (earlier([0.9], fixed=[{"name": "x", "scenario": "lock-up", "margins": {}}]), "not a name"),
        (earlier([0.9], fixed=[{"name": "x", "margins": {}}]), "fixed[0].scenario"),
    ],
)
def test_what_is_no_earlier_result_is_refused(tmp_path: Path, document: Any, reason: str) -> None:
    with pytest.raises(InputError) as refused:
        read(tmp_path, document)
    assert reason in str(refused.value)
    assert "result.json" in str(refused.value)

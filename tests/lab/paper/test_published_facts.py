"""Every published quantity beside ours, with a verdict that follows from the numbers."""

from __future__ import annotations

import pytest

from drivegate_cases.publication import facts, findings
from drivegate_lab.paper.facts import all_comparisons
from drivegate_lab.paper.findings import local_minima, recomputed_findings
from drivegate_lab.paper.quantities import quantity_keys
from drivegate_lab.paper.verdicts import ComparedStatement, verdict_counts


@pytest.fixture(scope="module")
def rows() -> dict[tuple[str, str], ComparedStatement]:
    return {(row.fact, row.quantity): row for row in all_comparisons()}


def test_every_published_quantity_is_compared(rows: dict[tuple[str, str], ComparedStatement]) -> None:
    published = {(fact.id, quantity.name) for fact in facts() for quantity in fact.quantities}
    assert quantity_keys() <= published, "a quantity of ours is not published"
    assert published <= set(rows), f"not compared: {sorted(published - set(rows))}"


@pytest.mark.parametrize(
    ("key", "verdict"),
    [
        (("P3", "rated power"), "reproduced"),
        (("P5", "angle below that speed"), "reproduced"),
        (("P7", "angle of Fig. 9"), "reproduced"),
        (("P8", "necessary angle at 1500 rpm"), "reproduced"),
        (("P8", "torque ripple at 1500 rpm"), "reproduced"),
        (("P10", "greatest speed over base speed"), "reproduced"),
        (("P1", "phases"), "taken as given"),
        (("P7", "angle of Fig. 10"), "open in the paper"),
        (("P6", "Fig. 4 taken literally, at 1500 rpm and 9.8 N·m"), "not reproduced"),
        (("P4", "net input power at 1500 rpm, 9.8 N·m, 52.5°"), "not reproduced"),
    ],
)
def test_verdicts(rows: dict[tuple[str, str], ComparedStatement], key: tuple[str, str], verdict: str) -> None:
    assert rows[key].verdict == verdict, rows[key]


def test_values_carry_units_and_residuals_signs(rows: dict[tuple[str, str], ComparedStatement]) -> None:
    row = rows["P8", "necessary angle at 1500 rpm"]
    assert (row.published, row.ours, row.tolerance) == ("52°", "51.9°", "± 0.5°")
    assert row.residual.startswith("−0.1")
    row = rows["P3", "rated power"]
    assert (row.published, row.ours, row.tolerance) == ("1500 W", "1504 W", "± 15 W")
    assert row.residual == "+3.7 W"


def test_verdicts_are_counted(rows: dict[tuple[str, str], ComparedStatement]) -> None:
    counts = dict(verdict_counts(tuple(rows.values())))
    assert sum(counts.values()) == len(rows)
    assert set(counts) == {
        "reproduced",
        "not reproduced",
        "open in the paper",
        "taken as given",
    }
    assert all(counts.values()), "every verdict occurs"


def test_every_finding_has_numbers() -> None:
    recomputed = recomputed_findings()
    assert [item.finding for item in recomputed] == list(findings())
    for item in recomputed:
        assert item.numbers, f"the finding {item.finding.id} has no numbers"


def test_numbers_agree_with_what_the_findings_say() -> None:
    numbers = {item.finding.id: dict(item.numbers) for item in recomputed_findings()}
    assert numbers["F3"]["exchanged power at 1500 rpm, 9.8 N·m, 52.5°"] == "1949 W"
    assert numbers["F3"]["net input power there"] == "1571 W"
    assert numbers["F3"]["Σ|i| from 58° to 52.5°"] == "−8.5 %"
    assert numbers["F7"]["peak EMF reaches 48 V at"] == "1352 rpm"


def test_only_light_loads_have_several_minima() -> None:
    assert local_minima(0.1) > 1, "at a tenth of rated power the current sum has several minima"
    assert local_minima(1.0) == 1, "at rated power it has one"

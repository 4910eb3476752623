import json
from collections.abc import Callable
from typing import Any

import pytest

from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import TABLE_KEYS, load_drive
from drivegate_cases.publication import (
    Fact,
    Findings,
    Publication,
    Quantity,
    facts,
    findings,
    open_assumptions,
    publication,
)
from drivegate_cases.scenario.operating_point import (
    load_operating_point,
    operating_point_names,
    power_sweep_names,
)
from drivegate_cases.scenario.scenario import scenario_names


def test_all_twelve_facts_are_there_in_order() -> None:
    assert [fact.id for fact in facts()] == [f"P{number}" for number in range(1, 13)]


def test_every_fact_held_by_a_check_names_it() -> None:
    assert all(fact.covered_by.checks for fact in facts() if fact.kind == "check")


@pytest.mark.parametrize("fact", facts(), ids=lambda fact: fact.id)
def test_the_cases_of_a_fact_exist(fact: Fact) -> None:
    known = {*scenario_names(), *operating_point_names(), *power_sweep_names()}
    assert set(fact.cases) <= known, f"{fact.id} names cases that do not exist"


def test_every_published_case_belongs_to_a_fact() -> None:
    named = {case for fact in facts() for case in fact.cases}
    published = {*operating_point_names(), *power_sweep_names()}
    assert published <= named, f"no fact names {published - named}"


def test_findings_bear_on_facts_that_exist() -> None:
    known = {fact.id for fact in facts()}
    for finding in findings():
        assert set(finding.facts) <= known, f"{finding.id} bears on facts that do not exist"


def test_assumptions_are_exactly_what_the_drive_does_not_take_from_the_paper() -> None:
    assumed = {key for assumption in open_assumptions() for key in assumption.keys}
    assert assumed <= set(TABLE_KEYS)
    provenance = load_drive("paper-5-phase").provenance
    sentences = {key: sentence for table in provenance.values() for key, sentence in table.items()}
    unstated = {key for key, sentence in sentences.items() if not sentence.startswith("stated:")}
    assert unstated - {"emf_shape"} == assumed


def quantity(identifier: str, name: str) -> float:
    fact = next(fact for fact in facts() if fact.id == identifier)
    return next(entry.value for entry in fact.quantities if entry.name == name)


def test_drive_and_points_have_the_values_of_the_facts() -> None:
    drive = load_drive("paper-5-phase")
    assert drive.machine.phases == quantity("P1", "phases")
    assert 2 * drive.machine.pole_pairs == quantity("P1", "poles")
    assert drive.inverter.window_deg == quantity("P1", "conduction in each half cycle")
    assert drive.inverter.supply_voltage_v == quantity("P2", "voltage of one half of the supply")
    assert drive.rating.rated_power_w == quantity("P3", "rated power")
    assert drive.rating.base_speed_rpm == quantity("P3", "base speed")
    assert drive.rating.current_limit_a == quantity("P3", "rated phase current")
    assert load_operating_point("fig9-currents-1200").torque_nm == quantity("P7", "torque of Fig. 9")
    assert load_operating_point("fig10-currents-1500").advance_deg == quantity("P7", "angle of Fig. 10")
    assert load_operating_point("fig6-torque-1500").advance_deg == quantity(
        "P8", "necessary angle at 1500 rpm"
    )


@pytest.mark.parametrize(
    ("bound", "ours", "agrees"),
    [
        ("equal", 9.0, False),
        ("equal", 9.5, True),
        ("equal", 10.5, True),
        ("equal", 10.6, False),
        ("at_most", -100.0, True),
        ("at_most", 10.6, False),
        ("at_least", 1e9, True),
        ("at_least", 9.4, False),
        ("equal", float("nan"), False),
        ("at_most", float("nan"), False),
        ("at_least", float("nan"), False),
    ],
)
def test_a_value_agrees_within_its_tolerance(bound: Any, ours: float, agrees: bool) -> None:
    published = Quantity(name="q", value=10.0, unit="A", tolerance=0.5, bound=bound)
    assert published.agrees(ours) == agrees


def test_without_a_tolerance_only_the_value_itself_agrees() -> None:
    published = Quantity(name="q", value=10.0, unit="A")
    assert published.agrees(10.0)
    assert not published.agrees(10.0 + 1e-9)


FACT = {"id": "P1", "title": "t", "statement": "s", "source": "Fig. 1", "kind": "figure"}


@pytest.mark.parametrize(
    ("facts_given", "reported"),
    [
        ([FACT, FACT], "the id 'P1' is given more than once"),
        ([FACT | {"kind": "check"}], "must name it in 'covered_by.checks'"),
        ([FACT | {"kind": "guess"}], "the key 'fact[0].kind' is \"guess\""),
        ([FACT | {"id": "Q1"}], "the key 'fact[0].id' is \"Q1\""),
        (
            [FACT | {"covered_by": {"checks": ["pwr1"]}}],
            "the key 'fact[0].covered_by.checks[0]' is \"pwr1\"",
        ),
        (
            [FACT | {"covered_by": {"properties": ["test_it"]}}],
            "the key 'fact[0].covered_by.properties[0]' is \"test_it\"",
        ),
        ([FACT | {"sorce": "x"}], "the key 'fact[0].sorce' is unknown, the nearest known key is 'source'"),
        ([FACT | {"quantities": [{"name": "q", "unit": "A"}]}], "'fact[0].quantities[0].value' is missing"),
        ([], "the key 'fact' is []"),
    ],
)
def test_wrong_facts_are_reported(
    refusal: Callable[..., str], facts_given: list[dict[str, Any]], reported: str
) -> None:
    mapping = {"schema": 1, "title": "x", "fact": facts_given}
    assert reported in refusal(parse_document, mapping, Publication, "facts.toml")


def test_repeated_findings_are_reported(refusal: Callable[..., str]) -> None:
    finding = {"id": "F1", "title": "t", "statement": "s"}
    mapping = {"schema": 1, "finding": [finding, finding]}
    assert "the id 'F1' is given more than once" in refusal(
        parse_document, mapping, Findings, "findings.toml"
    )


def test_the_publication_survives_a_round_trip() -> None:
    text = publication().to_json()
    assert parse_document(json.loads(text), Publication, "there") == publication()

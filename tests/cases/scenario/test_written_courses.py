"""The ways in which people write a course over time, and the voltage of a link."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.piecewise import as_profile, value_from, value_until
from drivegate_cases.scenario.scenario import Scenario, load_scenario, scenario_names, scenario_schema
from drivegate_models.errors import InputError

SCHEMA_FILE = Path(__file__).parents[3] / "docs" / "schemas" / "scenario.schema.json"
BASE: dict[str, Any] = {
    "schema": 2,
    "name": "written",
    "drive": "pm-ac-interior",
    "duration_s": 1.0,
    "speed_rpm": 1000,
    "load": {"kind": "constant_torque", "torque_nm": 0.5},
}


def made(**changes: Any) -> Scenario:
    return parse_document({**BASE, **changes}, Scenario, "here")


def test_a_number_is_a_constant_from_the_start() -> None:
    run = made()
    assert run.speed_rpm == ((0.0, 1000.0),)
    assert run.initial_speed_rpm == 1000.0
    assert run.load_profile == ((0.0, 1.0),), "the whole load, where nothing else is stated"


def test_a_step_needs_no_doubled_point() -> None:
    doubled = made(speed_rpm=[[0.0, 1000.0], [0.5, 1000.0], [0.5, 1500.0], [0.7, 1500.0], [0.7, 1200.0]])
    assert made(speed_rpm={"steps": [[0.0, 1000.0], [0.5, 1500.0], [0.7, 1200.0]]}) == doubled
    load = {"kind": "dynamometer", "torque_reference_nm": {"steps": [[0.0, 0.0], [0.5, 1.0]]}}
    assert made(load=load).torque_reference_profile == ((0.0, 0.0), (0.5, 0.0), (0.5, 1.0))


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=6))
def test_each_step_lasts_until_the_next(values: list[float]) -> None:
    points = as_profile({"steps": tuple((0.1 * place, value) for place, value in enumerate(values))})
    for place, value in enumerate(values):
        assert value_from(points, 0.1 * place) == value
        assert value_until(points, 0.1 * (place + 1)) == value


def test_a_link_is_stated_in_the_words_of_its_drive() -> None:
    halves = made(supply_v=[[0.0, 60.0], [0.5, 60.0], [0.5, 50.0]])
    assert made(link_voltage_v={"steps": [[0.0, 120.0], [0.5, 100.0]]}) == halves
    assert "link_voltage_v" not in halves.to_mapping()
    assert made(link_voltage_v=110).replaced(seed=3).supply_v == ((0.0, 55.0),), "also in a copy"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"speed_rpm": "fast"}, "the key 'speed_rpm' is \"fast\", but must be a number, a list of"),
        ({"speed_rpm": True}, "must be a number, a list of"),
        (
            {"speed_rpm": {"step": [[0.0, 1.0]]}},
            "or a table of steps such as {steps = [[0.0, 1.0], [0.5, 2.0]]}",
        ),
        ({"speed_rpm": {"steps": [[0.0, 1.0, 2.0]]}}, "must have steps of two numbers each"),
        ({"speed_rpm": {"steps": [[0.0, 1.0], [0.0, 2.0]]}}, "must have steps at different times"),
        ({"speed_rpm": {"steps": [["0", 1.0]]}}, "the key 'speed_rpm[0][0]' is \"0\", but must be a number"),
        ({"link_voltage_v": "24 V"}, "the key 'link_voltage_v' is \"24 V\", but must be a number"),
        ({"link_voltage_v": -3.0}, "the key 'link_voltage_v' is -3"),
        ({"link_voltage_v": 24.0, "supply_v": 12.0}, "state the same voltage; leave one of them out"),
        ({"drive": "paper-5-phase", "link_voltage_v": 96.0}, "state the voltage of each half as supply_v"),
    ],
)
def test_anything_else_is_refused_in_one_sentence(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError) as refused:
        made(**changes)
    assert words in str(refused.value)
    assert "; " not in str(refused.value).replace("; state", "").replace("; leave", ""), "one reason"


def test_the_published_schema_is_that_of_the_document() -> None:
    assert json.loads(SCHEMA_FILE.read_text(encoding="utf-8")) == scenario_schema(), (
        "docs/schemas/scenario.schema.json is out of date; write it again from drivegate_cases.scenario.scenario"
    )


def test_the_schema_takes_what_people_write_and_what_results_keep() -> None:
    written = BASE | {"speed_rpm": {"steps": [[0.0, 1.0]]}, "sensors": "shunts"}
    for scenario in (written, *(load_scenario(name).to_mapping() for name in scenario_names())):
        jsonschema.validate(scenario, scenario_schema())
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(BASE | {"speed": 5}, scenario_schema())

"""The result document: its published schema, which is the one that results are read by."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from tests.harness.made import made_outcome, made_result

from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.output.result_file import as_json
from drivegate.results.document import CheckSection, FaultSection, ResultDocument, result_schema
from drivegate.results.result import content_hash, counted_levels
from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.errors import InputError

SCHEMA_FILE = Path(__file__).parents[3] / "docs" / "schemas" / "result.schema.json"


@pytest.fixture
def schema() -> dict[str, Any]:
    return json.loads(SCHEMA_FILE.read_text(encoding="utf-8"))


@pytest.fixture
def document() -> dict[str, Any]:
    return {
        "schema": 2,
        "kind": "check",
        "candidate": {"name": "n", "kind": "builtin", "specification": "n", "hash": "h", "declaration": {}},
        "verdict": "pass",
        "exit_code": 0,
        "seed": 0,
        "effort": "quick",
        "checks": [],
        "faults": [],
        "runs": 0,
        "set_aside": 0,
        "traces": [{"time_s": [0.0, 1.0]}],
        "provenance": {"drivegate": "0.1.0"},
        "timing": {},
    }


def test_the_published_schema_is_that_of_the_code(schema: dict[str, Any]) -> None:
    jsonschema.Draft202012Validator.check_schema(schema)
    assert schema == result_schema(), (
        "docs/schemas/result.schema.json is out of date; write it again from drivegate.results.document.result_schema()"
    )


def test_what_the_gate_makes_is_read_again_with_every_key_in_the_order_of_the_schema() -> None:
    scenario = load_scenario("lock-up").to_mapping()
    fault = Fault(FaultKind.CRASH, "it ended", "step", "SIGSEGV", "trace", 3, 0.5, {"speed": 1.0})
    outcome = made_outcome("CNV-1", "fail", margin=-math.inf, margins=(-math.inf, 0.5), scenario=scenario)
    written = made_result(resolve_candidate("initial"), checks=(outcome,), faults=(fault,)).written()
    assert list(written) == ["schema", *list(ResultDocument.model_fields)[1:-1]]
    # A check of drivegate's own has no row.
    assert list(written["checks"][0]) == [key for key in CheckSection.model_fields if key != "row"]
    assert set(written["faults"][0]) == set(FaultSection.model_fields)
    assert list(written["faults"][0])[-1] == "time_s", "where it has always been"
    assert written["checks"][0]["margins"] == [None, 0.5], "JSON has no infinite number"
    assert written["provenance"]["content_hash"] == content_hash(written)
    read = parse_document(json.loads(as_json(written)), ResultDocument, "the result")
    assert read.checks[0].margin is None
    assert read.faults == (FaultSection.of(fault),)


def test_schema_and_reader_agree(schema: dict[str, Any], document: dict[str, Any]) -> None:
    jsonschema.Draft202012Validator(schema).validate(document)
    assert parse_document(document, ResultDocument, "the result").verdict == "pass"


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("verdict", 3),
        ("exit_code", 7),
        ("checks", {}),
        ("surplus", 1),
        ("traces", [{"time_s": ["0"]}]),
        ("schema", 99),
    ],
)
def test_schema_and_reader_refuse_the_same(
    schema: dict[str, Any], document: dict[str, Any], key: str, value: object
) -> None:
    document[key] = value
    assert not jsonschema.Draft202012Validator(schema).is_valid(document)
    with pytest.raises(InputError, match=key):
        parse_document(document, ResultDocument, "the result")


@pytest.mark.parametrize(
    ("fail_on", "counted"),
    [(None, {"required"}), ("required", {"required"}), ("advisory", {"required", "advisory"})],
)
def test_the_levels_that_count_are_required_ones_unless_a_result_says_more(
    fail_on: str | None, counted: set[str]
) -> None:
    assert set(counted_levels(fail_on)) == counted


def test_lists_of_numbers_stand_on_one_line() -> None:
    document = {"a": [1.5, -2e-07, None], "text": "[\n  1\n]", "b": [[0.0, 1.0], [2.0, 3.0]], "c": []}
    text = as_json(document)
    assert json.loads(text) == document
    assert '"a": [1.5, -2e-07, null]' in text
    assert "[0.0, 1.0],\n" in text

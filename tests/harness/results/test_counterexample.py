"""Counterexamples: written and read by one model, and everything that is wrong with one reported in one sentence."""

import json
import os
from pathlib import Path
from typing import Any

import pytest

from drivegate.isolation.layers import roots_named
from drivegate.results.counterexample import Counterexample, read_corpus, read_counterexample
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.errors import InputError

Table = dict[str, Any]


def stored(**changes: Any) -> Table:
    table = {
        "schema": 2,
        "kind": "counterexample",
        "check": "CNV-1",
        "margin": -0.5,
        "measured": "speed error 7.5 rpm",
        "seed": 3,
        "size": 4,
        "candidate": {"name": "published", "hash": "00ff"},
        "versions": {"drivegate": "0.1.0", "packages": {"numpy": "2.0"}},
        "scenario": load_scenario("lock-up").to_mapping(),
    }
    return {key: value for key, value in (table | changes).items() if value is not ...}


def written(folder: Path, table: Any, name: str = "one.json") -> Path:
    file = folder / name
    file.write_text(table if isinstance(table, str) else json.dumps(table), encoding="utf-8")
    return file


def test_what_is_read_is_what_was_written(tmp_path: Path) -> None:
    first = read_counterexample(written(tmp_path, stored()))
    assert first.scenario == load_scenario("lock-up"), "the scenario must come back as it was"
    again = read_counterexample(written(tmp_path, first.to_mapping()))
    assert again == first


def test_the_schema_before_is_read(tmp_path: Path) -> None:
    earlier = read_counterexample(written(tmp_path, stored(schema=1, size=...)))
    assert (earlier.size, earlier.margin) == (None, -0.5)


def test_a_margin_without_a_number_is_left_out() -> None:
    assert "margin" not in Counterexample.model_validate(stored(margin=None, schema=0)).to_mapping()


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"schema": 3}, "schema 3 is newer than this drivegate reads, which is 1 or 2"),
        ({"schema": ...}, "the key 'schema' is missing"),
        (
            {"kind": "check"},
            "is of kind \"check\", but must be a document with the key kind = 'counterexample'",
        ),
        ({"kind": ...}, "does not give its kind"),
        ({"check": "CNV-9"}, "'check' is \"CNV-9\", but must be one of the checks, the nearest is 'CNV-"),
        ({"check": "\x1b[31m<script>"}, r"\u001b[31m<script>"),
        ({"scenario": "lock-up"}, "must be a table with the whole scenario, not a name"),
        ({"scenario": ...}, "the key 'scenario' is missing"),
        ({"scenario": {**stored()["scenario"], "drive": "paper-5-phase"}}, "all of the drive's keys"),
        ({"scenario": {**stored()["scenario"], "duration_s": -1}}, "'duration_s' is -1"),
        ({"scenario": {**stored()["scenario"], "schema": 99}}, "schema 99 is newer"),
        ({"candidate": {"name": ""}}, "candidate.name"),
        ({"candidate": {"name": 3}}, "must be text in quotes"),
        ({"candidate": {"name": "x" * 5000}}, "candidate.name"),
        ({"candidate": {"name": "x", "command": "rm"}}, "'candidate.command' is unknown"),
        ({"seed": -1}, "'seed' is -1"),
        ({"margin": "far"}, "must be a number"),
        ({"marginn": 1}, "the nearest known key is 'margin'"),
    ],
)
def test_what_is_wrong_is_reported_in_one_sentence(tmp_path: Path, changes: Table, reason: str) -> None:
    with pytest.raises(InputError) as refused:
        read_counterexample(written(tmp_path, stored(**changes)))
    sentence = str(refused.value)
    assert reason in sentence
    assert "one.json" in sentence
    assert sentence.isprintable(), "a hostile text must not reach the terminal"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (json.dumps(stored())[:-40], "not well-formed JSON"),
        ("", "not well-formed JSON"),
        ("[]", "must hold a table"),
        ("[" * 100_000, "nested too deeply"),
        ('{"kind": "counterexample", "margin": NaN}', "NaN is no JSON number"),
        ('{"kind": "counterexample", "schema": ' + "9" * 5000 + "}", "not well-formed JSON"),
    ],
)
def test_what_is_no_document_is_reported_in_one_sentence(tmp_path: Path, text: str, reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        read_counterexample(written(tmp_path, text))


def test_a_file_of_a_gigabyte_is_refused_without_reading_it(tmp_path: Path) -> None:
    file = tmp_path / "huge.json"
    with file.open("wb") as stream:
        os.truncate(stream.fileno(), 1 << 30)
    with pytest.raises(InputError, match="larger than 16 MB"):
        read_counterexample(file)


def test_a_corpus_is_read_in_the_order_of_its_names(tmp_path: Path) -> None:
    written(tmp_path, stored(seed=2), "b.json")
    written(tmp_path, stored(seed=1), "a.json")
    written(tmp_path, "anything", "notes.txt")
    assert [one.seed for one in read_corpus(tmp_path)] == [1, 2]


def test_an_empty_corpus_is_one(tmp_path: Path) -> None:
    assert read_corpus(tmp_path) == ()


@pytest.mark.parametrize(
    ("place", "reason"),
    [("nowhere", "does not exist"), ("file", "is no folder"), ("zero\0byte", "does not exist")],
)
def test_a_corpus_that_is_no_folder_is_refused(tmp_path: Path, place: str, reason: str) -> None:
    (tmp_path / "file").write_text("x", encoding="utf-8")
    with pytest.raises(InputError, match=f"--corpus .*{reason}"):
        read_corpus(tmp_path / place)


def test_a_link_out_of_a_corpus_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "corpus"
    folder.mkdir()
    written(tmp_path, stored(), "mine.json")
    (folder / "a.json").symlink_to("../mine.json")
    with pytest.raises(
        InputError, match=r"'a\.json' is a link that leads out of the folder; copy the file, or name"
    ):
        read_corpus(folder)
    with roots_named([str(tmp_path)]):
        assert len(read_corpus(folder)) == 1


def test_one_bad_file_spoils_a_corpus(tmp_path: Path) -> None:
    written(tmp_path, stored(), "a.json")
    written(tmp_path, "{", "b.json")
    with pytest.raises(InputError, match=r"b\.json is not well-formed"):
        read_corpus(tmp_path)

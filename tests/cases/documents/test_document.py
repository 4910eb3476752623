import json
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import Field, ValidationError

from drivegate_cases.documents.document import Document, Section, parse_document, read_document
from drivegate_cases.documents.wording import LONGEST_MESSAGE
from drivegate_models.errors import InputError


class Square(Section):
    kind: Literal["square"]
    side: float = Field(gt=0.0, description="length of a side")


class Circle(Section):
    kind: Literal["circle"]
    radius: float = Field(gt=0.0, description="distance from the centre")


class Sheet(Document):
    title: str = Field(max_length=10, description="what is written on top")
    count: int = Field(default=1, ge=1, le=9, description="number of copies")
    shape: Square | Circle = Field(
        default=Square(kind="square", side=1.0), discriminator="kind", description="what is drawn"
    )
    points: tuple[tuple[float, float], ...] = Field(default=(), description="list of pairs")
    copies: tuple[Square, ...] = Field(default=(), description="list of squares")


class SecondSheet(Sheet):
    schema_current: ClassVar[int] = 2

    @classmethod
    def from_previous(cls, mapping: dict[str, Any]) -> dict[str, Any]:
        return {("title" if key == "heading" else key): value for key, value in mapping.items()}


VALID = {"schema": 1, "title": "one"}


def test_a_document_is_read_from_toml_and_json(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text('schema = 1\ntitle = "one"\npoints = [[0, 1], [2.5, 3]]\n')
    (tmp_path / "a.json").write_text('{"schema": 1, "title": "one", "points": [[0, 1], [2.5, 3]]}')
    sheet = read_document(tmp_path / "a.toml", Sheet)
    assert sheet == read_document(str(tmp_path / "a.json"), Sheet)
    assert sheet.points == ((0.0, 1.0), (2.5, 3.0))


def test_the_message_names_the_file(tmp_path: Path, refusal: Callable[..., str]) -> None:
    (tmp_path / "a.toml").write_text("schema = 1\n")
    assert "a.toml: the key 'title' is missing" in refusal(read_document, tmp_path / "a.toml", Sheet)


@pytest.mark.parametrize(
    ("changes", "reported"),
    [
        ({"tittle": "x"}, "the key 'tittle' is unknown, the nearest known key is 'title'"),
        ({"a\nb": 1}, "the key 'a\\nb' is unknown"),
        ({"title": 5}, "the key 'title' is 5, but must be text in quotes"),
        ({"title": "\ud800"}, "the key 'title' is"),
        ({"title": "x" * 11}, "but must have at most 10 characters"),
        ({"count": 0}, "the key 'count' is 0, but must be greater than or equal to 1"),
        ({"count": 10}, "the key 'count' is 10, but must be less than or equal to 9"),
        ({"count": 1.5}, "the key 'count' is 1.5, but must be a whole number"),
        ({"count": True}, "the key 'count' is true, but must be a whole number"),
        ({"count": "3"}, "the key 'count' is \"3\", but must be a whole number"),
        ({"shape": 5}, "the key 'shape' is 5, but must be a table"),
        ({"shape": {}}, "the key 'shape.kind' is missing"),
        (
            {"shape": {"kind": "blob"}},
            "the key 'shape.kind' is \"blob\", but must be one of 'square', 'circle'",
        ),
        ({"shape": {"kind": "circle"}}, "'shape.radius' is missing, it gives the distance from the centre"),
        ({"shape": {"kind": "circle", "radius": -1}}, "'shape.radius' is -1, but must be greater than 0"),
        (
            {"shape": {"kind": "circle", "radius": 1, "sides": 1}},
            "the key 'shape.sides' is unknown, known are kind, radius",
        ),
        (
            {"shape": {"kind": "circle", "radius": 1, "radios": 1}},
            "'shape.radios' is unknown, the nearest known",
        ),
        ({"points": 1}, "the key 'points' is 1, but must be a list"),
        ({"points": [[0, 1], [1]]}, "the key 'points[1]' has too few entries, 1"),
        ({"points": [[0, 1, 2]]}, "the key 'points[0]' has 3 entries, but must have at most 2"),
        ({"points": [[0, "a"]]}, "the key 'points[0][1]' is \"a\", but must be a number"),
        ({"points": [[0, float("nan")]]}, "the key 'points[0][1]' is NaN, but must be a finite number"),
        ({"points": [[float("inf"), 0]]}, "the key 'points[0][0]' is Infinity, but must be a finite number"),
        ({"points": [[10**400, 0]]}, "the key 'points[0][0]' is an integer of 1329 bits"),
        (
            {"copies": [{"kind": "square", "sid": 1}]},
            "'copies[0].sid' is unknown, the nearest known key is 'side'",
        ),
    ],
)
def test_each_mistake_is_reported_with_its_key(
    refusal: Callable[..., str], changes: dict[str, Any], reported: str
) -> None:
    message = refusal(parse_document, VALID | changes, Sheet, "sheet.toml")
    assert message.startswith("sheet.toml: ")
    assert reported in message


def test_all_mistakes_are_reported_at_once(refusal: Callable[..., str]) -> None:
    message = refusal(parse_document, {"schema": 1, "count": 0, "points": 1, "zzz": 1}, Sheet, "here")
    assert message.count("; ") == 3
    for key in ("title", "count", "points", "zzz"):
        assert f"'{key}'" in message, f"the mistake in '{key}' is not reported: {message}"


def test_of_very_many_mistakes_the_first_are_reported(refusal: Callable[..., str]) -> None:
    message = refusal(parse_document, VALID | {"points": [["a", "b"]] * 100}, Sheet, "here")
    assert re.search(r"; and 19\d more$", message)
    assert 200 < len(message) <= LONGEST_MESSAGE


def test_a_report_of_long_names_and_values_is_short(refusal: Callable[..., str]) -> None:
    long = "x" * 10_000
    wrong = {"count": long, long: 1, "title": [long]}
    message = refusal(parse_document, VALID | wrong, Sheet, f"{long}/sheet.toml")
    assert len(message) <= LONGEST_MESSAGE
    assert "/sheet.toml: the key " in message
    assert message.endswith("more")


def test_of_a_great_many_mistakes_the_first_are_reported_at_once(refusal: Callable[..., str]) -> None:
    began = time.process_time()
    message = refusal(parse_document, VALID | dict.fromkeys(map(str, range(20_000)), 1), Sheet, "here")
    assert re.search(r"; and 199\d\d more$", message)
    assert time.process_time() - began < 5.0


@pytest.mark.parametrize(
    ("schema", "reported"),
    [
        (None, "the key 'schema' is missing, but must be 1"),
        (2, "schema 2 is newer than this drivegate reads"),
        (10**400, "schema an integer of 1329 bits is newer"),
        (0, "schema 0 is older"),
        (-3, "schema -3 is older"),
        ("1", "the key 'schema' is \"1\", but must be the integer 1"),
        (1.0, "the key 'schema' is 1.0, but must be the integer 1"),
        (True, "the key 'schema' is true, but must be the integer 1"),
    ],
)
def test_only_a_supported_schema_is_read(refusal: Callable[..., str], schema: object, reported: str) -> None:
    mapping = {"title": "one"} if schema is None else {"schema": schema, "title": "one"}
    assert reported in refusal(parse_document, mapping, Sheet, "here")


def test_the_previous_schema_is_translated(refusal: Callable[..., str]) -> None:
    old = parse_document({"schema": 1, "heading": "one"}, SecondSheet, "here")
    assert old == parse_document({"schema": 2, "title": "one"}, SecondSheet, "here")
    assert old.to_mapping()["schema"] == 2
    assert "newer than this drivegate reads, which is 1 or 2" in refusal(
        parse_document, {"schema": 3, "title": "one"}, SecondSheet, "here"
    )


@pytest.mark.parametrize("mapping", [5, None, [], "text"])
def test_what_is_no_table_is_no_document(refusal: Callable[..., str], mapping: object) -> None:
    assert "must hold a table" in refusal(parse_document, mapping, Sheet, "here")


def test_a_document_cannot_be_changed() -> None:
    sheet = parse_document(VALID, Sheet, "here")
    with pytest.raises(ValidationError, match="frozen"):
        sheet.title = "two"  # type: ignore[misc]


def test_a_replaced_key_is_checked(refusal: Callable[..., str]) -> None:
    sheet = parse_document(VALID, Sheet, "here")
    assert sheet.replaced(count=2, points=[[0, 1]]).points == ((0.0, 1.0),)
    assert sheet.count == 1, "the original changed"
    assert "the key 'count' is 99" in refusal(sheet.replaced, count=99)
    assert "the key 'cuont' is unknown" in refusal(sheet.replaced, cuont=9)


NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
SHEETS = st.fixed_dictionaries(
    {"schema": st.just(1), "title": st.text(max_size=10)},
    optional={
        "count": st.integers(1, 9),
        "points": st.lists(st.tuples(NUMBERS, NUMBERS), max_size=4),
        "shape": st.fixed_dictionaries({"kind": st.just("circle"), "radius": st.floats(1e-3, 1e3)}),
    },
)


@given(SHEETS)
def test_a_document_survives_a_round_trip(mapping: dict[str, Any]) -> None:
    sheet = parse_document(mapping, Sheet, "here")
    text = sheet.to_json()
    again = parse_document(json.loads(text), Sheet, "there")
    assert again == sheet
    assert again.to_json() == text, "equal documents were written differently"


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


@given(st.dictionaries(st.sampled_from([*Sheet.model_fields, "schema"]) | st.text(max_size=6), ANYTHING))
def test_any_table_gives_a_document_or_a_sentence(mapping: dict[str, Any]) -> None:
    reported = "here"
    try:
        parse_document({"schema": 1} | mapping, Sheet, "here")
    except InputError as error:
        reported = str(error)
    assert reported.isprintable(), f"the message does not fit on one line: {reported!r}"
    assert reported.startswith("here"), f"the message does not say where: {reported}"

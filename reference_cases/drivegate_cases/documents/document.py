"""The documents that people write for drivegate: typed, closed to unknown keys, with a schema number.

A document is a pydantic model whose keys are the model's fields. Whatever is wrong with one is reported in a
single sentence that names the document, each offending key, and what would be right.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Final, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from drivegate_cases.documents.problems import described
from drivegate_cases.documents.reach import Reach
from drivegate_cases.documents.reading import read_mapping
from drivegate_cases.documents.wording import LONGEST_MESSAGE, shown, shown_path
from drivegate_models.errors import InputError

DocumentT = TypeVar("DocumentT", bound="Document")

_MARKS: Final = {
    "exit_code": "the result of a check",
    "measured": "a counterexample",
    "entry": "the manifest of a candidate",
    "waiver": "a file of waivers",
    "candidates": "a campaign",
    "duration_s": "a scenario",
    "machine": "the file of a drive",
}
"""A key that each kind of file has, and no other kind."""


class Section(BaseModel):
    """A table inside a document: frozen, closed to unknown keys, strict in its types, all numbers finite."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        strict=True,
        allow_inf_nan=False,
        validate_default=True,
        # A table that was copied with other values is checked again where it goes into a document.
        revalidate_instances="always",
    )


class Document(Section):
    """A whole file: a section with the number of the schema that it is written in.

    A kind of document whose schema has changed sets `schema_current` and translates the previous one in
    `from_previous`.
    """

    # Whole documents were checked as they were made, and are too large to be checked with each of their copies.
    model_config = ConfigDict(revalidate_instances="never")

    schema_current: ClassVar[int] = 1
    schema_version: int = Field(default=0, alias="schema", description="number of the document's schema")

    @field_validator("schema_version")
    @classmethod
    def _is_current(cls, number: int) -> int:
        """Tables that stand inside another document may leave the number out; it is the current one then."""
        if number not in (0, cls.schema_current):
            raise ValueError(f"must be {cls.schema_current} here")
        return cls.schema_current

    @classmethod
    def of_kind(cls, values: Mapping[str, Any]) -> "type[Document]":
        """Choose the model of what a document says of its own kind, where there are several."""
        del values
        return cls

    @classmethod
    def from_previous(cls, mapping: dict[str, Any]) -> dict[str, Any]:
        """Translate the previous schema's keys into the current one's."""
        return mapping

    def to_mapping(self) -> dict[str, Any]:
        return self.model_dump(mode="json", by_alias=True, exclude_none=True)

    def to_json(self) -> str:
        """Write the document as JSON; equal documents give the same characters."""
        return json.dumps(self.to_mapping(), indent=2, ensure_ascii=False, allow_nan=False) + "\n"

    def replaced(self, **changes: Any) -> Self:
        """Make a document that differs in a few keys, checked like any other."""
        values = {field.alias or name: getattr(self, name) for name, field in type(self).model_fields.items()}
        return _validated({**values, **_frozen(changes)}, type(self), type(self).__name__.lower(), None)


def read_document(path: str | Path, model: type[DocumentT], reach: Reach | None = None) -> DocumentT:
    """Read a TOML or JSON file as a document of a given kind.

    `reach`: where the files lie that it may name; None for a document of the user's own, which may name any.
    """
    return parse_document(read_mapping(path), model, str(path), folder=Path(path).parent, reach=reach)


def parse_document(
    mapping: Mapping[str, Any],
    model: type[DocumentT],
    where: str,
    *,
    folder: Path | None = None,
    reach: Reach | None = None,
) -> DocumentT:
    """Check plain data as a document of a given kind."""
    if not isinstance(mapping, Mapping):
        raise InputError(
            f"{shown_path(where)} holds {shown(mapping)}, but must hold a table of keys and values"
        )
    values = dict(mapping)
    _refuse_other_kind(values, model, where)
    chosen: Any = model.of_kind(values)
    model = chosen
    schema = _supported_schema(values.pop("schema", None), model, where)
    if schema < model.schema_current:
        values = model.from_previous(values)
    return _validated(_frozen(values), model, where, folder, reach)


def kind_in_words(values: Mapping[str, Any]) -> str | None:
    """Return what kind of file a document is by a key that only its kind has; None where none shows."""
    return next((words for mark, words in _MARKS.items() if mark in values), None)


def _refuse_other_kind(values: Mapping[str, Any], model: type[Document], where: str) -> None:
    """Refuse a file of another kind in one sentence, in place of one for each of its keys."""
    own = [mark for mark in _MARKS if mark in model.model_fields]
    if not own or any(mark in values for mark in own):
        return
    for mark, words in _MARKS.items():
        if mark in values:
            raise InputError(
                f"{shown_path(where)} is {words}, as its key '{mark}' shows, but {_MARKS[own[0]]} is required here"
            )


def _supported_schema(number: object, model: type[Document], where: str) -> int:
    place = shown_path(where)
    current = model.schema_current
    oldest = max(1, current - 1)
    supported = f"{oldest} or {current}" if oldest < current else f"{current}"
    if number is None:
        raise InputError(f"{place}: the key 'schema' is missing, but must be {supported}")
    if not isinstance(number, int) or isinstance(number, bool):
        raise InputError(f"{place}: the key 'schema' is {shown(number)}, but must be the integer {supported}")
    if number > current:
        raise InputError(
            f"{place}: schema {shown(number)} is newer than this drivegate reads, which is {supported}; "
            "a newer drivegate reads it"
        )
    if number < oldest:
        raise InputError(
            f"{place}: schema {shown(number)} is older than this drivegate reads, which is {supported}"
        )
    return number


def _validated(
    values: Mapping[str, Any],
    model: type[DocumentT],
    where: str,
    folder: Path | None,
    reach: Reach | None = None,
) -> DocumentT:
    try:
        return model.model_validate(values, context={"folder": folder, "reach": reach})
    except ValidationError as error:
        place = f"{shown_path(where)}: "
        raise InputError(place + described(error, model, LONGEST_MESSAGE - len(place))) from error


def _frozen(value: Any) -> Any:
    """Make lists tuples, since documents are immutable and strict about it."""
    if isinstance(value, Mapping):
        return {key: _frozen(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return tuple(_frozen(item) for item in value)
    return value

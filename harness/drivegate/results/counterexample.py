"""A counterexample: the file with a scenario that breaks a check, from which it can be run again."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, Literal

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator

from drivegate.isolation.layers import named_roots
from drivegate_cases.documents.document import Document, Section, kind_in_words, parse_document
from drivegate_cases.documents.reach import Reach
from drivegate_cases.documents.reading import read_mapping
from drivegate_cases.documents.wording import nearest, one_line, shown, shown_path
from drivegate_cases.requirements.row import Row
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.script import Script
from drivegate_models.errors import InputError

KIND: Final = "counterexample"

Line = Annotated[str, Field(max_length=2000)]


def resolved_scenario(value: Any) -> Any:
    """Read a scenario that another document has in full: nothing in it is looked up by name."""
    return _resolved(value, Scenario, "the scenario")


def resolved_script_or_scenario(value: Any) -> Any:
    """Read a scenario, or a script, that is part of another document in full."""
    if isinstance(value, Mapping) and value.get("kind") == "script":
        return _resolved(value, Script, "the script")
    return resolved_scenario(value)


def _resolved(value: Any, model: type[Scenario] | type[Script], noun: str) -> Any:
    if isinstance(value, Document):
        return value
    if not isinstance(value, Mapping):
        raise ValueError("must be a table with the whole scenario, not a name")
    if not isinstance(value.get("drive"), Mapping):
        raise ValueError("the key 'drive' must be a table with all of the drive's keys")
    try:
        return parse_document(value, model, noun)
    except InputError as error:
        raise ValueError(str(error)) from error


class Provenance(Section):
    """Who broke the check; a candidate that has been put right has another hash."""

    name: Line = Field(min_length=1, description="name of the candidate")
    hash: Line = Field(default="", description="hash of the candidate's sources")


class DriveIdentity(Section):
    """The drive on which the check was broken; the scenario has it in full."""

    name: Line = Field(min_length=1, description="name of the drive")
    kind: Line = Field(default="", description="kind of drive")
    hash: Line = Field(default="", description="hash of its values")


class Counterexample(Document):
    """A scenario, fully resolved, with the check that it breaks and what was measured then."""

    schema_current: ClassVar[int] = 2
    kind: Literal["counterexample"] = Field(default=KIND, description="kind of document")
    # Before the check, which is known by it.
    row: Row | None = Field(
        default=None, description="table of the user's row that fails, where it is no check of drivegate"
    )
    check: str = Field(description="identifier of the check that fails")
    requirement: Line = Field(default="", description="requirement in one sentence")
    limit: Line = Field(default="", description="limit of the check")
    margin: float | None = Field(
        default=None, description="margin that was found; left out where it is no finite number"
    )
    measured: Line = Field(default="", description="what the margin was measured as")
    seed: int = Field(default=0, ge=0, lt=2**63, description="seed of the search that found it")
    size: int | None = Field(default=None, ge=0, description="number of things that differ from nominal")
    candidate: Provenance = Field(description="table with the candidate's name and hash")
    drive: DriveIdentity | None = Field(
        default=None, description="table with the drive's name, kind and hash"
    )
    versions: dict[str, Any] = Field(default_factory=dict, description="versions that it was found with")
    scenario: Annotated[Scenario | Script, BeforeValidator(resolved_script_or_scenario)] = Field(
        description="table with the whole scenario or script"
    )

    @field_validator("check")
    @classmethod
    def _is_a_check(cls, name: str, info: ValidationInfo) -> str:
        row: Row | None = info.data.get("row")
        if row is not None and row.id == name:
            return name
        # The catalogue brings the compiled plant, which a file that is refused before does not need.
        from drivegate.contracts.catalogue import all_checks

        known = list(all_checks())
        if name not in known:
            raise ValueError(f"must be one of the checks, the nearest is '{nearest(name, known)}'")
        return name


def read_counterexample(path: str | Path) -> Counterexample:
    mapping = read_mapping(path)
    require_kind(mapping, KIND, path)
    return parse_document(mapping, Counterexample, str(path), folder=Path(path).parent)


def require_kind(mapping: Mapping[str, Any], kind: str, path: str | Path) -> None:
    """Refuse a document of another kind before its keys are looked at."""
    if mapping.get("kind") == kind:
        return
    # A drive has a kind too, of its own.
    words = kind_in_words(mapping) if "machine" in mapping else None
    actual = f"is of kind {shown(mapping['kind'])}" if "kind" in mapping else "does not give its kind"
    actual = f"is {words}" if words else actual
    raise InputError(
        f"{shown_path(path)} {actual}, but must be a document with the key kind = '{one_line(kind)}'"
    )


def read_corpus(folder: Path) -> tuple[Counterexample, ...]:
    try:
        if not folder.is_dir():
            problem = "is no folder" if folder.exists() else "does not exist"
            raise InputError(f"--corpus {shown_path(folder)} {problem}; name a folder of counterexamples")
        files = sorted(path for path in folder.iterdir() if path.name.endswith(".json"))
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"--corpus {shown_path(folder)} cannot be read: {one_line(reason)}; name a readable folder"
        ) from error
    # A link in a stranger's checkout may lead to any file, and what is wrong with that would be printed.
    reach = Reach.of(folder, named_roots())
    for file in files:
        if not reach.holds(Path(os.path.realpath(file))):
            raise InputError(
                f"--corpus {shown_path(folder)}: '{one_line(file.name)}' is a link that leads out of the folder; copy "
                "the file, or name its folder with --root"
            )
    return tuple(read_counterexample(file) for file in files)

"""The drives of every kind, each read as the document of its kind, by its name, its file or inside another document."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import BeforeValidator, SerializeAsAny, ValidationError, ValidationInfo

from drivegate_cases.documents.packaged import load_named, packaged_names
from drivegate_cases.documents.problems import described
from drivegate_cases.documents.reach import Reach
from drivegate_cases.drive.document import PM_AC, SPLIT_SUPPLY, TABLE_KEYS, DriveDocument

# It enters itself as the document of its kind.
from drivegate_cases.drive.pm_ac import document  # noqa: F401
from drivegate_models.errors import InputError

__all__ = [
    "PM_AC",
    "SENSORLESS",
    "SPLIT_SUPPLY",
    "TABLE_KEYS",
    "DriveDocument",
    "DriveReference",
    "drive_names",
    "is_included",
    "load_drive",
]


SENSORLESS: Final = "-sensorless"
"""End of the name of a PM AC drive that has no position sensor."""


def load_drive(
    name_or_path: str | Path, *, relative_to: Path | None = None, reach: Reach | None = None
) -> DriveDocument:
    """Load a drive that comes with drivegate, or one from a file.

    The name of a PM AC drive with `SENSORLESS` behind it is that drive without a position sensor.
    """
    name = str(name_or_path)
    sensed = name.removesuffix(SENSORLESS)
    if name != sensed and sensed in drive_names():
        drive = load_drive(sensed)
        if "sensing" in drive.tables:
            return drive.replaced(name=name, sensing={"position": "none"})
        raise InputError(
            f"no drive is called '{name}': of the kind '{drive.kind}' there is no variant without a position sensor, "
            f"as PM AC drives have one, such as pm-ac-2kw{SENSORLESS}"
        )
    return load_named(
        name_or_path,
        DriveDocument,
        "drives",
        "drive",
        relative_to=relative_to,
        reach=reach,
        further=included_drives,
    )


def is_included(name: str) -> bool:
    """Return True if a name is that of a drive that comes with drivegate, also without its position sensor."""
    sensed = name.removesuffix(SENSORLESS)
    return sensed in drive_names() and (name == sensed or "sensing" in load_drive(sensed).tables)


def included_drives() -> tuple[str, ...]:
    """List the drives that come with drivegate, those of PM AC also without a position sensor."""
    names = drive_names()
    return (*names, *(name + SENSORLESS for name in names if is_included(name + SENSORLESS)))


def drive_names(*, but: str = "") -> tuple[str, ...]:
    """List the drives that come with drivegate, or those of all kinds but one."""
    names = packaged_names("drives")
    return tuple(name for name in names if load_drive(name).kind != but) if but else names


def _drive_by_name(value: Any, info: ValidationInfo) -> Any:
    """Take a drive from the package or a file where a document only names it, and one of its own kind of document."""
    if isinstance(value, Mapping):
        return _of_its_kind(value, info)
    if not isinstance(value, str):
        return value
    try:
        context = info.context or {}
        return load_drive(value, relative_to=context.get("folder"), reach=context.get("reach"))
    except InputError as error:
        raise ValueError(str(error)) from error


def _of_its_kind(value: Mapping[str, Any], info: ValidationInfo) -> Any:
    model = DriveDocument.of_kind(value)
    if model is DriveDocument:
        return value
    try:
        return model.model_validate(value, context=info.context)
    except ValidationError as error:
        raise ValueError(described(error, model)) from error


DriveReference = Annotated[SerializeAsAny[DriveDocument], BeforeValidator(_drive_by_name)]
"""A table of a drive's keys, the bare name of a drive, or the path of its file."""

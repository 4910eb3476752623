"""A drive inside another document: a whole one, or just the name or the file of one."""

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, SerializeAsAny, ValidationError, ValidationInfo

from drivegate_cases.documents.problems import described
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_models.errors import InputError


def _drive_by_name(value: Any, info: ValidationInfo) -> Any:
    """Take a drive from the package or a file where a document only names it, and one of its own kind of document."""
    if isinstance(value, Mapping):
        return _of_its_kind(value, info)
    if not isinstance(value, str):
        return value
    try:
        return load_drive(value, relative_to=(info.context or {}).get("folder"))
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

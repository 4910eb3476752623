"""A drive inside another document: a whole one, or just the name or the file of one."""

from typing import Annotated, Any

from pydantic import BeforeValidator, ValidationInfo

from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_models.errors import InputError


def _drive_by_name(value: Any, info: ValidationInfo) -> Any:
    """Take a drive from the package or a file where a document only names it."""
    if not isinstance(value, str):
        return value
    try:
        return load_drive(value, beside=(info.context or {}).get("folder"))
    except InputError as error:
        raise ValueError(str(error)) from error


DriveReference = Annotated[DriveDocument, BeforeValidator(_drive_by_name)]
"""A table of a drive's keys, the bare name of a drive, or the path of its file."""

"""A drive as a file with a comment for each key, as a place to start from."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import shown_path
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.drive_file import drive_toml
from drivegate_models.errors import InputError

SUFFIX = ".toml"
_FOLLOWING: Final = {"speed_tolerance_rpm": None, "settling_s": None, "point": ()}
"""Requirements that follow from the rating, as they are left out."""


def write_drive(file: Path, start: DriveDocument) -> DriveDocument:
    """Write a drive with the values of another, named after its file; nothing is ever overwritten.

    What follows from the values is left out, since of other values it would be wrong.
    """
    if file.suffix != SUFFIX:
        raise InputError(f"{shown_path(file)} is no name for a drive's file, which ends in {SUFFIX}")
    if file.is_symlink() or file.exists():
        raise InputError(
            f"{shown_path(file)} exists already, and nothing is ever overwritten; name another file"
        )
    known = type(start.requirements).model_fields
    following = {key: value for key, value in _FOLLOWING.items() if key in known}
    drive = start.replaced(name=file.stem, advance=None, provenance=_not_stated(start), **following)
    write_atomically(file, drive_toml(drive))
    return drive


def _not_stated(start: DriveDocument) -> dict[str, dict[str, str]]:
    """Say of each value that nobody has said where it is from, which stays true when it is changed."""
    sentence = f"not stated; as in {start.name} until it is changed"[:200]
    return {
        table: {key: sentence for key in sentences if key not in _FOLLOWING}
        for table, sentences in start.provenance.items()
        if table != "advance"
    }

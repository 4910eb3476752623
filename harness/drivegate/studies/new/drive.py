"""A drive as a file with a comment for each key, as a place to start from."""

from __future__ import annotations

from pathlib import Path

from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import shown_path
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.drive_file import drive_toml
from drivegate_models.errors import InputError

SUFFIX = ".toml"


def write_drive(file: Path, start: DriveDocument) -> DriveDocument:
    """Write a drive with the values of another, named after its file; nothing is ever overwritten."""
    if file.suffix != SUFFIX:
        raise InputError(f"{shown_path(file)} is no name for a drive's file, which ends in {SUFFIX}")
    if file.is_symlink() or file.exists():
        raise InputError(
            f"{shown_path(file)} exists already, and nothing is ever overwritten; name another file"
        )
    drive = start.replaced(name=file.stem, provenance=_as_in(start))
    write_atomically(file, drive_toml(drive))
    return drive


def _as_in(start: DriveDocument) -> dict[str, dict[str, str]]:
    """Say of each value that it is not one's own yet."""
    sentence = f"as in {start.name}"[:200]
    return {table: dict.fromkeys(sentences, sentence) for table, sentences in start.provenance.items()}

"""The drives of every kind: each is read as the document of its kind."""

from __future__ import annotations

from pathlib import Path

from drivegate_cases.documents.packaged import load_named, packaged_names
from drivegate_cases.drive.document import PM_AC, SPLIT_SUPPLY, TABLE_KEYS, DriveDocument

# It enters itself as the document of its kind.
from drivegate_cases.drive.pm_ac import document  # noqa: F401

__all__ = ["PM_AC", "SPLIT_SUPPLY", "TABLE_KEYS", "DriveDocument", "drive_names", "load_drive"]


def load_drive(name_or_path: str | Path, *, relative_to: Path | None = None) -> DriveDocument:
    """Load a drive that comes with drivegate, or one from a file."""
    return load_named(name_or_path, DriveDocument, "drives", "drive", relative_to=relative_to)


def drive_names(*, but: str = "") -> tuple[str, ...]:
    """List the drives that come with drivegate, or those of all kinds but one."""
    names = packaged_names("drives")
    return tuple(name for name in names if load_drive(name).kind != but) if but else names

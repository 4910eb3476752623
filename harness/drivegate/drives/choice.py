"""The drive that a candidate is judged on: the one that is named, its manifest's, or the default."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from drivegate.candidates.candidate import Candidate
from drivegate.drives.kinds import DEFAULT_DRIVE
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument


def drive_for(candidate: Candidate | None, named: DriveDocument | None = None) -> DriveDocument:
    """Choose the drive of a candidate; what a user names wins over its manifest."""
    from drivegate_cases.drive.drive_document import load_drive

    if named is not None:
        return named
    if candidate is not None and candidate.drive is not None:
        return candidate.drive
    return load_drive(DEFAULT_DRIVE)


def common_drive(candidates: Iterable[Candidate], named: DriveDocument | None = None) -> DriveDocument:
    """Choose the one drive of candidates that are compared."""
    found = [drive_for(candidate, named) for candidate in candidates]
    first = found[0] if found else drive_for(None, named)
    other = next((drive for drive in found if drive != first), None)
    if other is not None:
        raise InputError(
            f"the candidates' manifests name the drives '{first.name}' and '{other.name}', but candidates are compared "
            "on one; name it with --drive"
        )
    return first

"""The drive that a candidate is judged on: the one that is named, its manifest's, or the default."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.contract import ANSWERS
from drivegate.drives.kinds import DEFAULT_DRIVES, kind_of
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument


def drive_for(candidate: Candidate | None, named: DriveDocument | None = None) -> DriveDocument:
    """Choose the drive of a candidate; what a user names wins over its manifest."""
    from drivegate_cases.drive.drive_document import load_drive

    own = None if candidate is None else candidate.drive
    contract = None if candidate is None else candidate.contract
    drive = named or own or load_drive(DEFAULT_DRIVES[contract or "current"])
    if candidate is not None:
        require_contract(candidate, drive)
    return drive


def require_contract(candidate: Candidate, drive: DriveDocument) -> None:
    """Refuse a candidate of one contract on a drive of another."""
    if candidate.contract in (None, drive.contract):
        return
    raise InputError(
        f"the candidate '{one_line(candidate.name)}' answers with {ANSWERS[candidate.contract]}, but the drive "
        f"'{one_line(drive.name)}' of the kind '{drive.kind}' takes {ANSWERS[drive.contract]}; name a drive such as "
        f"{DEFAULT_DRIVES[candidate.contract]} with --drive"
    )


def require_angles(drive: DriveDocument) -> DriveDocument:
    """Refuse a drive whose controllers answer with no advance angle, where all is about angles."""
    kind_of(drive).require_angles()
    return drive


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

"""Single checks explained: what is required on a drive, how it is judged, and what usually breaks it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.contracts.catalogue import all_checks, all_contracts, check_of, contract_of
from drivegate.contracts.traceability import traced_checks
from drivegate.drives.kinds import DEFAULT_DRIVES
from drivegate.gate.focus import is_called, named_checks
from drivegate_cases.documents.wording import one_line
from drivegate_cases.drive.drive_document import DriveDocument, included_drives, load_drive
from drivegate_models.errors import InputError


def explained_checks(
    names: Sequence[str], drive: DriveDocument | None, own: DriveDocument | None = None
) -> list[dict[str, Any]]:
    """Explain checks or families of them, on a drive.

    Without one it is the user's own where that is judged by them, else the default drive of each contract.
    """
    wanted = named_checks(names, list(all_checks()))
    if drive is None and own is not None and (rows := _explained(own, wanted)):
        return rows
    drives = [load_drive(DEFAULT_DRIVES[contract.name]) for contract in all_contracts()]
    rows = [row for each in ([drive] if drive else drives) for row in _explained(each, wanted)]
    if not rows:
        assert drive is not None, "every check belongs to a contract"
        raise InputError(
            f"the drive '{one_line(drive.name)}' is not judged by {', '.join(wanted)}; leave --drive out, or name "
            "another"
        )
    return rows


def _explained(drive: DriveDocument, wanted: Iterable[str]) -> list[dict[str, Any]]:
    causes = contract_of(drive).causes_of
    return [
        row
        | {
            "drive": drive.name,
            "likely_causes": list(causes(row["id"])),
            **_where_it_applies(row["id"], drive),
        }
        for row in traced_checks(drive)
        if any(is_called(row["id"], name) for name in wanted)
    ]


def _where_it_applies(check: str, drive: DriveDocument) -> dict[str, str | None]:
    """Return why a check does not apply on a drive, and an included drive on which it does; None where it does."""
    stated = check_of(drive.contract, check, NOTHING_DECLARED)
    reason = stated.reason_not_applicable(NOTHING_DECLARED, drive)
    if reason is None:
        return {"not_applicable": None, "applies_on": None}
    others = (load_drive(name) for name in included_drives())
    found = (
        other.name
        for other in others
        if other.contract == drive.contract and stated.reason_not_applicable(NOTHING_DECLARED, other) is None
    )
    return {"not_applicable": reason, "applies_on": next(found, None)}

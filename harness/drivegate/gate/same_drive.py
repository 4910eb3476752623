"""Refusing to mix what was found on different drives."""

from __future__ import annotations

from collections.abc import Iterable

from drivegate.drives.kinds import DEFAULT_DRIVE
from drivegate.results.baseline import Baseline
from drivegate.results.counterexample import Counterexample
from drivegate.results.waivers import Waiver
from drivegate_cases.documents.wording import shown
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import InputError


def require_same_drive(
    drive: DriveDocument,
    *,
    baseline: Baseline | None = None,
    counterexamples: Iterable[Counterexample] = (),
    waivers: Iterable[Waiver] = (),
) -> None:
    """Refuse records of another drive than the one that is checked."""
    if baseline is not None:
        for run in baseline.fixed:
            _require("the baseline", run.scenario.drive, drive)
    for stored in counterexamples:
        _require(f"a counterexample to {stored.check}", stored.scenario.drive, drive)
    for waiver in waivers:
        named = waiver.drive or DEFAULT_DRIVE
        if named != drive.name:
            raise InputError(
                f"the waiver of {waiver.check} for the candidate {shown(waiver.candidate)} is for the drive "
                f"{shown(named)}, but the check is on {shown(drive.name)}; a waiver names its drive in its key "
                "'drive', the paper's where it is left out"
            )


def _require(record: str, theirs: DriveDocument, ours: DriveDocument) -> None:
    if theirs.values_hash == ours.values_hash:
        return
    raise InputError(
        f"{record} is of the drive {_named(theirs)}, but the check is on {_named(ours)}; records of two drives are not "
        "mixed, so name the first with --drive, or leave the record out"
    )


def _named(drive: DriveDocument) -> str:
    return f"{shown(drive.name)} ({drive.values_hash[:12]})"

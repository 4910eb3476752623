"""The document of a drive whose controllers answer with duty ratios."""

from __future__ import annotations

from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.pm_ac.document import PmAcDocument


def duty_document(drive: DriveDocument) -> PmAcDocument:
    """Return a drive as the document that it is here."""
    assert isinstance(drive, PmAcDocument), "a controller of duty ratios runs on a drive that takes them"
    return drive

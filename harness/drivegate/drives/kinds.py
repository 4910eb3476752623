"""All kinds of drives, and which of them a drive belongs to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from drivegate.drives.drive_kind import DriveKind
from drivegate.drives.half_bridge import HALF_BRIDGE
from drivegate.drives.pm_ac import PM_AC
from drivegate.drives.star import STAR

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument

DRIVE_KINDS: Final[Mapping[str, DriveKind]] = {kind.name: kind for kind in (HALF_BRIDGE, STAR, PM_AC)}
"""Every kind there is, by its name, which is the `kind` of its documents."""
DEFAULT_KIND: Final = HALF_BRIDGE
"""The kind that controllers are made for where nothing says another."""
DEFAULT_DRIVE: Final = DEFAULT_KIND.default_drive
"""Name of the drive that is meant where nobody names one."""
DEFAULT_DRIVES: Final[Mapping[str, str]] = {"current": DEFAULT_DRIVE, "duty": PM_AC.default_drive}
"""Name of the drive that a candidate of each contract is judged on where nobody names one."""


def kind_of(drive: DriveDocument) -> DriveKind:
    """Find the kind that a drive belongs to."""
    return DRIVE_KINDS[drive.kind]

"""What drives of each kind can do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from drivegate.drives.ability import Ability
from drivegate.drives.angle_ability import ANGLE_ABILITY
from drivegate.drives.duty_ability import DUTY_ABILITY
from drivegate.drives.kinds import HALF_BRIDGE, PM_AC, STAR
from drivegate_cases.drive.drive_document import DriveDocument

ABILITIES: Final[Mapping[str, Ability]] = {
    HALF_BRIDGE.name: ANGLE_ABILITY,
    STAR.name: ANGLE_ABILITY,
    PM_AC.name: DUTY_ABILITY,
}
"""What a drive can do, by its kind."""


def ability_of(drive: DriveDocument) -> Ability:
    """Return what a drive of that kind can do, whoever controls it."""
    return ABILITIES[drive.kind]

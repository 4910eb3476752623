"""All kinds of drives, and which of them a motor belongs to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from drivegate.drives.drive_kind import DriveKind
from drivegate.drives.half_bridge import HALF_BRIDGE

if TYPE_CHECKING:
    from drivegate_cases.motor.motor import Motor

DRIVE_KINDS: Final[Mapping[str, DriveKind]] = {kind.name: kind for kind in (HALF_BRIDGE,)}
"""Every kind there is, by its name."""
DEFAULT_KIND: Final = HALF_BRIDGE
"""The kind that controllers are made for where nothing says another."""
DEFAULT_MOTOR: Final = DEFAULT_KIND.default_motor
"""Name of the motor that is meant where nobody names one."""


def kind_of(motor: Motor) -> DriveKind:
    """Find the kind of drive that a motor belongs to."""
    return next(kind for kind in DRIVE_KINDS.values() if isinstance(motor, kind.motor()))

"""The kinds of drives that can be drawn at random."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from drivegate.drives.drawn_bounds import BOUNDS, Bound
from drivegate.drives.drawn_drives import DrawnDrive, drawn_drive, per_unit_values
from drivegate.drives.pm_ac_drawn_bounds import PM_AC_BOUNDS
from drivegate.drives.pm_ac_drawn_drives import drawn_pm_ac_drive, pm_ac_per_unit_values
from drivegate_cases.drive.drive_document import DriveDocument


@dataclass(frozen=True)
class DrawnKind:
    """How drives of a kind are drawn."""

    bounds: Mapping[str, Bound]
    """What each quantity is drawn within, by its name."""
    draw: Callable[[int, int], DrawnDrive]
    """From a seed and a number to a drive whose rating can be met."""
    per_unit: Callable[[DriveDocument], dict[str, float]]
    """From such a drive to its values without its size, by the names of the bounds."""


DRAWN_KINDS: Final[Mapping[str, DrawnKind]] = MappingProxyType(
    {
        "half-bridge": DrawnKind(BOUNDS, drawn_drive, per_unit_values),
        "pm-ac": DrawnKind(PM_AC_BOUNDS, drawn_pm_ac_drive, pm_ac_per_unit_values),
    }
)
"""They by their names."""

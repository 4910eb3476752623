"""Names of what may be changed in a run: the plant, the nominal drive, and shares of the case's profiles."""

from __future__ import annotations

from typing import Final

from drivegate_cases.drive.advance import Advance
from drivegate_cases.drive.drive_document import TABLE_KEYS
from drivegate_cases.drive.plant import Scales
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.requirements import PmAcRequirements
from drivegate_cases.drive.requirements import Requirements

SCALES: Final = tuple(Scales.model_fields)
"""Parameters of the plant that its controller does not know."""
SHARES: Final = ("load_share", "supply_share")
"""Parameters that multiply a profile of the case."""
SPREADABLE: Final = (*SCALES, *SHARES)
"""Parameters that may be drawn at random; each has its own place in a run's random numbers."""
SPEED: Final = "speed_rpm"
"""The parameter that replaces the case's speed reference by a constant one."""
_NO_GRID: Final = ("emf_shape", "emf_table", *Advance.model_fields, *Requirements.model_fields)
DRIVE_KEYS: Final = tuple(key for key in TABLE_KEYS if key not in _NO_GRID)
"""Numeric keys of the nominal drive, which the controller knows."""
_NO_DUTY_GRID: Final = ("carrier", *PmAcRequirements.model_fields)
DUTY_DRIVE_KEYS: Final = tuple(key for key in PmAcDocument.table_of_key() if key not in _NO_DUTY_GRID)
"""The same of a drive whose controllers answer with duty ratios."""
GRID_KEYS: Final = tuple(dict.fromkeys((*SPREADABLE, SPEED, *DRIVE_KEYS, *DUTY_DRIVE_KEYS)))
"""Parameters that may stand on a grid, of a drive that has them."""

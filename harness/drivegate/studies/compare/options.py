"""How much is compared, and on what."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument


@dataclass(frozen=True)
class ComparisonOptions:
    """How much is compared, and on what.

    Attributes
    ----------
    effort : str
        ``quick``, ``default`` or ``nightly``.
    seed : int
        Seed of everything drawn.
    workers : int or None
        Number of processes; None for as many as there are processors.
    checks : bool
        Whether the checks are made as well.
    cycle : str
        Name or file of the drive cycle.
    drive : DriveDocument or None
        The drive; None for that of the candidates' manifests, or the default.
    """

    effort: str = "default"
    seed: int = 0
    workers: int | None = None
    checks: bool = True
    cycle: str = "ece-15"
    drive: DriveDocument | None = None

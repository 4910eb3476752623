"""How much is compared, and on what."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from drivegate.candidates.contract import ANSWERS
from drivegate.contracts.catalogue import contract_of
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument

DEFAULT_CYCLE: Final = "ece-15"
"""Drive cycle where none is named."""


@dataclass(frozen=True)
class ComparisonOptions:
    """How much is compared, and on what."""

    effort: str = "default"
    """``quick``, ``default`` or ``nightly``."""
    stated_seed: int | None = None
    """Seed of everything drawn, where one is stated."""
    workers: int | None = None
    """Number of processes; None for as many as there are processors."""
    checks: bool = True
    """Whether the checks are made as well."""
    cycle: str | None = None
    """Name or file of the drive cycle; None for the default."""

    @property
    def seed(self) -> int:
        """Seed of everything drawn."""
        return self.stated_seed or 0

    def refuse_unused(self, drive: DriveDocument) -> None:
        """Refuse an option that changes nothing in a comparison on a drive."""
        ignores = contract_of(drive).comparison().ignores
        if not ignores:
            return
        because = f"the drive '{one_line(drive.name)}' takes {ANSWERS[drive.contract]}, and {ignores}"
        if self.cycle is not None:
            raise InputError(f"--cycle has no effect, since {because}; leave it out")
        if self.stated_seed is not None and not self.checks:
            raise InputError(
                f"--seed has no effect with --no-checks, since {because}; leave out one of the two"
            )

"""What fails during a run of a PM AC drive."""

from typing import Final, Self

from pydantic import Field, model_validator

from drivegate_cases.documents.document import Section
from drivegate_cases.scenario.control_periods import first_period_from
from drivegate_cases.scenario.failure_kind import FailureKind

PHASED: Final[frozenset[FailureKind]] = frozenset({"open-phase", "stuck-current"})
"""Those of one phase."""
SURVIVABLE: Final[frozenset[FailureKind]] = frozenset({"lost-edge"})
"""Those behind which a drive may also go on."""


class Failure(Section):
    """A part of the drive that fails for good, or an edge that is lost once."""

    kind: FailureKind = Field(
        description="what fails: 'open-phase', a leg whose switches both stay off; 'stuck-current', a current sensor "
        "whose reading stays; 'lost-position', the edges of encoder or Hall switches; 'locked-rotor', the shaft; "
        "'lost-edge', the next edge of encoder or Hall switches alone; 'slip', the magnet of the sensor of an exact "
        "position, which turns on the shaft"
    )
    time_s: float = Field(ge=0.0, le=86400.0, description="time from which on it has failed, in seconds")
    phase: int = Field(
        default=1, ge=1, le=3, description="number of the phase, from 1, where the failure is that of one"
    )

    slip_deg: float | None = Field(
        default=None,
        ge=-180.0,
        le=180.0,
        description="angle by which the magnet turns where it slips, in electrical degrees",
    )

    def first_period(self, control_period_s: float) -> int:
        """Return the number of the first control period that begins with it."""
        return first_period_from(self.time_s, control_period_s)

    @model_validator(mode="after")
    def _only_a_phase_has_a_number(self) -> Self:
        if self.kind not in PHASED and self.phase != 1:
            raise ValueError(f"must not give 'phase' for the kind '{self.kind}', which is no phase's")
        if (self.kind == "slip") is (self.slip_deg is None):
            raise ValueError("must give 'slip_deg' for the kind 'slip', and for no other")
        return self

"""The table `[sensing]` of a PM AC drive: what its controllers see of the shaft in every run."""

from typing import Literal, TypeAlias

from pydantic import Field

from drivegate_cases.documents.document import Section

Position: TypeAlias = Literal["exact", "encoder", "hall"]
"""What shows angle and speed of the shaft."""


class PmAcSensing(Section):
    """The sensor on the shaft that the drive always has."""

    position: Position = Field(
        description='what shows angle and speed of the shaft in every run: "exact", without error, "encoder" or "hall"'
    )

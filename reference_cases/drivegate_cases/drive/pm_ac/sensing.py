"""The table `[sensing]` of a PM AC drive: what its controllers see of the shaft in every run."""

from pydantic import Field

from drivegate_cases.documents.document import Section
from drivegate_cases.drive.position import Position


class PmAcSensing(Section):
    """The sensor on the shaft that the drive always has."""

    position: Position = Field(
        description='what shows angle and speed of the shaft in every run: "exact", without error, "encoder" or "hall"'
    )

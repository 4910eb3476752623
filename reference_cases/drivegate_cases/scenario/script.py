"""A script: what a controller senses, interval by interval, without a plant behind it."""

from typing import Literal, Self

from pydantic import Field, model_validator

from drivegate_cases.documents.document import Document, Section
from drivegate_cases.drive.drive_document import DriveDocument, DriveReference
from drivegate_models.contract.current.signals import Nameplate


class ScriptRow(Section):
    """What holds from one decision of the controller's search to the next."""

    speed_reference_rpm: float = Field(ge=0.0, le=1e6, description="speed reference, in rpm")
    speed_rpm: float = Field(ge=0.0, le=1e6, description="measured speed, in rpm")
    current_sum_a: float = Field(
        ge=0.0, le=1e6, description="sum of the magnitudes of the phase currents, in amperes"
    )
    supply_v: float = Field(
        gt=0.0,
        le=1e5,
        description="voltage of each half of the supply, or half the voltage of a link without a tap, in volts",
    )


class Script(Document):
    """Signals for a controller whose search decides at a fixed period; each row is held for one such period."""

    kind: Literal["script"] = Field(description="kind of document")
    name: str = Field(min_length=1, max_length=200, description="name of the script")
    description: str = Field(default="", max_length=2000, description="what the script tries")
    drive: DriveReference = Field(
        description="nominal drive: the name of one, the path of its file, or a table of its keys"
    )
    control_period_s: float = Field(
        default=0.0005, gt=0.0, le=0.0005, description="time between two steps of the controller, in seconds"
    )
    rows: tuple[ScriptRow, ...] = Field(
        min_length=1, max_length=100_000, description="list of tables of what the controller senses"
    )

    @model_validator(mode="after")
    def _starts_above_base_speed(self) -> Self:
        slow = [row.speed_rpm for row in self.rows if row.speed_rpm <= self.drive.rating.base_speed_rpm]
        if slow:
            raise ValueError(
                f"the key 'rows' has a speed_rpm of {slow[0]:g}, but must have speeds above the drive's base speed "
                f"of {self.drive.rating.base_speed_rpm:g} rpm, where there is an advance angle to search for"
            )
        return self

    def nameplate(self) -> Nameplate:
        drive: DriveDocument = self.drive
        return drive.nameplate(self.control_period_s)

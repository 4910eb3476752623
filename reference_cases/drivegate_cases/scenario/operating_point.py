"""Published operating points: one speed, torque and advance angle each, or one power over many speeds."""

import math
from itertools import pairwise
from pathlib import Path
from typing import Annotated

from pydantic import Field, field_validator

from drivegate_cases.documents.document import Document
from drivegate_cases.documents.packaged import load_named, packaged_names

Speed = Annotated[float, Field(gt=0.0, le=1e6)]


class OperatingPoint(Document):
    """A steady state at a fixed speed, torque and advance angle."""

    name: str = Field(min_length=1, max_length=200, description="name of the operating point")
    description: str = Field(default="", max_length=2000, description="what the point shows")
    source: str = Field(default="", max_length=500, description="where the point is published")
    speed_rpm: Speed = Field(description="speed of the shaft, in rpm")
    torque_nm: float = Field(ge=0.0, le=1e6, description="mean electromagnetic torque, in newton metres")
    advance_deg: float = Field(ge=0.0, le=90.0, description="advance angle, in electrical degrees")


class PowerSweep(Document):
    """One power at many speeds."""

    name: str = Field(min_length=1, max_length=200, description="name of the sweep")
    description: str = Field(default="", max_length=2000, description="what the sweep shows")
    source: str = Field(default="", max_length=500, description="where the sweep is published")
    speeds_rpm: tuple[Speed, ...] = Field(min_length=1, description="speeds of the shaft, in rpm, increasing")
    power_w: float = Field(gt=0.0, le=1e9, description="power at the shaft, in watts")

    @field_validator("speeds_rpm")
    @classmethod
    def _speeds_increase(cls, speeds: tuple[float, ...]) -> tuple[float, ...]:
        if any(later <= earlier for earlier, later in pairwise(speeds)):
            raise ValueError("must have strictly increasing speeds")
        return speeds

    def torque_at(self, speed_rpm: float) -> float:
        return self.power_w / (speed_rpm * 2.0 * math.pi / 60.0)


def load_operating_point(name_or_path: str | Path) -> OperatingPoint:
    """Load an operating point that comes with drivegate, or one from a file."""
    return load_named(name_or_path, OperatingPoint, "points", "operating point")


def load_power_sweep(name_or_path: str | Path) -> PowerSweep:
    """Load a power sweep that comes with drivegate, or one from a file."""
    return load_named(name_or_path, PowerSweep, "sweeps", "power sweep")


def operating_point_names() -> tuple[str, ...]:
    return packaged_names("points")


def power_sweep_names() -> tuple[str, ...]:
    return packaged_names("sweeps")

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
        """Torque that gives the sweep's power at a speed.

        Parameters
        ----------
        speed_rpm : float
            Speed of the shaft (rpm), above 0.

        Returns
        -------
        float
            Torque (N·m), power over angular speed.
        """
        return self.power_w / (speed_rpm * 2.0 * math.pi / 60.0)


def load_operating_point(name_or_path: str | Path) -> OperatingPoint:
    """Load an operating point that comes with drivegate, or one from a file.

    Parameters
    ----------
    name_or_path : str or Path
        A bare name such as ``fig9-currents-1200``, or the path of a TOML or JSON file.

    Returns
    -------
    OperatingPoint
        The point, valid throughout.

    Raises
    ------
    InputError
        When there is no such point, or its file is not valid.
    """
    return load_named(name_or_path, OperatingPoint, "points", "operating point")


def load_power_sweep(name_or_path: str | Path) -> PowerSweep:
    """Load a power sweep that comes with drivegate, or one from a file.

    Parameters
    ----------
    name_or_path : str or Path
        A bare name such as ``fig7-input-current``, or the path of a TOML or JSON file.

    Returns
    -------
    PowerSweep
        The sweep, valid throughout.

    Raises
    ------
    InputError
        When there is no such sweep, or its file is not valid.
    """
    return load_named(name_or_path, PowerSweep, "sweeps", "power sweep")


def operating_point_names() -> tuple[str, ...]:
    """List the operating points that come with drivegate.

    Returns
    -------
    tuple of str
        Bare names, as `load_operating_point` takes them.
    """
    return packaged_names("points")


def power_sweep_names() -> tuple[str, ...]:
    """List the power sweeps that come with drivegate.

    Returns
    -------
    tuple of str
        Bare names, as `load_power_sweep` takes them.
    """
    return packaged_names("sweeps")

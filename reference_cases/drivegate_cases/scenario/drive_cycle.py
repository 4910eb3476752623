"""Drive cycles: the speed of a vehicle over time, as they come with drivegate or from a user's CSV file."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Final

from pydantic import Field, field_validator

from drivegate_cases.documents.csv_file import read_columns
from drivegate_cases.documents.document import Document, parse_document
from drivegate_cases.documents.packaged import load_named, packaged_names
from drivegate_cases.documents.wording import one_line
from drivegate_cases.scenario.piecewise import Profile

CSV_COLUMNS: Final = ("time_s", "speed_km_h")
"""Columns that a user's file must have; others are left alone."""
LONGEST_CYCLE_S: Final = 3600.0
MOST_POINTS: Final = 3601
"""Most points of a cycle, one a second."""
HIGHEST_SPEED_KM_H: Final = 300.0


class DriveCycle(Document):
    """The speed of a vehicle over time, straight between points."""

    name: str = Field(min_length=1, max_length=200, description="name of the cycle")
    description: str = Field(default="", max_length=2000, description="what the cycle stands for")
    source: str = Field(default="", max_length=1000, description="where the cycle is published")
    speed_km_h: Profile = Field(description="list of [time in seconds, speed in km/h]")

    @field_validator("speed_km_h")
    @classmethod
    def _can_be_driven(cls, points: Profile) -> Profile:
        if not 2 <= len(points) <= MOST_POINTS:
            raise ValueError(f"must have 2 to {MOST_POINTS} points")
        if points[0][0] != 0.0:
            raise ValueError("must have its first point at time 0")
        backward = [later for (earlier, _), (later, _) in pairwise(points) if later <= earlier]
        if backward:
            raise ValueError(f"must have times that increase, which the point at {backward[0]:g} s does not")
        if points[-1][0] > LONGEST_CYCLE_S:
            raise ValueError(f"must end within {LONGEST_CYCLE_S:g} s")
        if any(not 0.0 <= speed <= HIGHEST_SPEED_KM_H for _, speed in points):
            raise ValueError(f"must have speeds from 0 to {HIGHEST_SPEED_KM_H:g} km/h")
        if all(speed == 0.0 for _, speed in points):
            raise ValueError("must have a speed above 0 somewhere")
        return points

    @property
    def duration_s(self) -> float:
        return self.speed_km_h[-1][0]

    @property
    def distance_m(self) -> float:
        """Way of a vehicle that follows the cycle exactly (m): the area under straight pieces."""
        return sum(
            0.5 * (before + after) / 3.6 * (later - earlier)
            for (earlier, before), (later, after) in pairwise(self.speed_km_h)
        )


def cycle_names() -> tuple[str, ...]:
    return packaged_names("cycles")


def load_drive_cycle(name_or_path: str | Path) -> DriveCycle:
    """Load a cycle that comes with drivegate, or one from a file."""
    if str(name_or_path).lower().endswith(".csv"):
        return _from_csv(Path(name_or_path))
    return load_named(name_or_path, DriveCycle, "cycles", "drive cycle")


def _from_csv(path: Path) -> DriveCycle:
    content = {
        "schema": DriveCycle.schema_current,
        "name": one_line(path.stem)[:200] or "cycle",
        "source": f"the file {one_line(path.name)}"[:1000],
        "speed_km_h": read_columns(path, CSV_COLUMNS, what="a drive cycle"),
    }
    return parse_document(content, DriveCycle, str(path))

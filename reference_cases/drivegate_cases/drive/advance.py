"""The table `[advance]` of a drive: its recommended line of advance angles, computed where it is left out."""

from __future__ import annotations

from functools import lru_cache
from math import isnan, pi, radians

from pydantic import Field

from drivegate_cases.documents.document import Section
from drivegate_cases.documents.wording import one_line
from drivegate_cases.drive.usual_values import DriveValues
from drivegate_models.errors import InputError

_LINES_KEPT = 256


class Advance(Section):
    """A line of initial advance angles over speed (paper, Fig. 3)."""

    start_deg: float = Field(ge=0.0, le=90.0, description="angle at base speed, in electrical degrees")
    slope_deg_per_rpm: float = Field(
        ge=-90.0,
        le=90.0,
        description="rise above base speed, in electrical degrees for each turn a minute",
    )


def advance_line(drive: DriveValues) -> tuple[float, float]:
    """Return the line's angle at base speed (rad electrical) and its slope (rad electrical per rad/s of the shaft).

    If the drive states no line, it is computed by the oracle with ideal current regulators, once a process. If rated
    power is out of reach there is none, which raises `InputError`.
    """
    if drive.advance is None:
        return _computed_line(drive)
    # In this order of operations, which is that of the first controllers: bit for bit.
    return radians(drive.advance.start_deg), radians(drive.advance.slope_deg_per_rpm) * 30.0 / pi


@lru_cache(maxsize=_LINES_KEPT)
def _computed_line(drive: DriveValues) -> tuple[float, float]:
    from drivegate_models.steady.advance_line import recommended_line

    rating = drive.rating
    line = recommended_line(
        # The regulators' band hardly moves the line, but costs time with each chop.
        drive.plant()._replace(hysteresis_band=0.0),
        radians(6.0 * rating.base_speed_rpm),
        radians(6.0 * rating.highest_speed_rpm),
        rating.rated_power_w,
    )
    if isnan(line.start):
        raise InputError(
            f"the drive '{one_line(drive.name)}' has no table [advance], and no line of angles can be computed: "
            f"at most speeds between {rating.base_speed_rpm:g} and {rating.highest_speed_rpm:g} rpm its rated power of "
            f"{rating.rated_power_w:g} W is out of reach at {rating.current_limit_a:g} A"
        )
    return line.start, line.slope

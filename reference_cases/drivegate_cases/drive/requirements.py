"""The table `[requirements]` of a drive: the limits that its controllers are judged by."""

from __future__ import annotations

from typing import Annotated, Any, Final

from pydantic import ConfigDict, Field, ValidationInfo, field_validator

from drivegate_cases.documents.document import Section
from drivegate_cases.drive.limits import (
    POINT_POWER_SHARE,
    SETTLING,
    SPEED_TOLERANCE,
    Limit,
    ripple_limit,
    rounded,
    share,
)
from drivegate_cases.drive.rating import Rating
from drivegate_cases.drive.usual_values import DriveValues
from drivegate_models.units import RADIANS_PER_RPM

_SUMS: Final = "the plant's sums are exact to 1e-9 of themselves"
LEAST: Final[dict[str, tuple[float, str]]] = {
    "speed_tolerance_rpm": (
        1e-6,
        "the speed is a sum over some hundred thousand steps, each of them rounded",
    ),
    "power_tolerance_percent": (1e-7, _SUMS),
    "angle_tolerance_deg": (1e-4, "the feasible edge is located to 1e-4 degree"),
    "optimum_tolerance_percent": (1e-3, "the angle of the least current sum is located to 1e-3 degree"),
    "ripple_percent": (1e-7, _SUMS),
    "closed_loop_ripple_percent": (1e-7, _SUMS),
}
"""Least value of each limit, and why a finer one would judge rounding instead of a candidate."""


def _with_least(schema: dict[str, Any]) -> None:
    """State the least values in a JSON Schema; a validator refuses lesser ones with the reason."""
    for key, (least, _) in LEAST.items():
        schema["properties"][key]["minimum"] = least


class RequiredPoint(Section):
    """An operating point at which the torque ripple is required to stay below its limit."""

    speed_rpm: float = Field(gt=0.0, le=1e6, description="speed, in turns a minute")
    torque_n_m: float = Field(gt=0.0, le=2e6, description="torque of the load, in newton metres")


class Requirements(Section):
    """Limits of the checks; one that has a unit follows from the rating where it is left out."""

    model_config = ConfigDict(json_schema_extra=_with_least)

    speed_tolerance_rpm: Annotated[float | None, SPEED_TOLERANCE] = Field(
        default=None,
        le=1e6,
        description="greatest speed error k1 of a search that has converged, by default 1 % of base speed",
    )
    power_tolerance_percent: Annotated[float, Limit("power_tolerance", share, "k2")] = Field(
        default=0.5,
        le=100.0,
        description="greatest variation k2 of the current sum of a search that has converged, in percent",
    )
    angle_tolerance_deg: Annotated[float, Limit("angle_tolerance_deg", in_texts="angle")] = Field(
        default=1.0,
        le=90.0,
        description="greatest movement of the advance angle of a search that has converged, in electrical degrees",
    )
    settling_s: Annotated[float | None, SETTLING] = Field(
        default=None,
        ge=0.1,
        le=3600.0,
        description="time in which a search has to converge, by default 66 mechanical time constants (inertia times "
        "base speed over rated torque) or 550 electrical periods at base speed, the longer of both in steps of "
        "1, 1.5, 2, 3, 5, 7 times 6 s and never less than 6 s",
    )
    optimum_tolerance_percent: Annotated[float, Limit("optimum_tolerance", share, "optimum")] = Field(
        default=2.0,
        le=1000.0,
        description="greatest excess of the current sum over the least one, in percent",
    )
    ripple_percent: Annotated[float | None, ripple_limit("ripple", 0.13)] = Field(
        default=None,
        le=1000.0,
        description="limit of the torque ripple with the ideal regulator, peak to peak over mean, in percent, by "
        "default 13 of decoupled phases, and none of a star",
    )
    closed_loop_ripple_percent: Annotated[float | None, ripple_limit("closed_loop_ripple", 0.20)] = Field(
        default=None,
        le=1000.0,
        description="limit of the torque ripple with band and speed regulator, peak to peak over mean, in percent, by "
        "default 20 of decoupled phases, and none of a star",
    )
    point: tuple[RequiredPoint, ...] = Field(
        default=(),
        max_length=20,
        description="list of points at which the ripple is required, each a table [[requirements.point]], by default "
        "2.6 % above rated power at the highest speed, as in the paper's Fig. 6",
    )

    @field_validator(*LEAST)
    @classmethod
    def _can_be_resolved(cls, value: float | None, info: ValidationInfo) -> float | None:
        """A limit is no finer than what the plant and its oracle can resolve."""
        least, reason = LEAST[str(info.field_name)]
        if value is not None and not value >= least:
            raise ValueError(f"must be at least {least:g}, since {reason}")
        return value

    @field_validator("settling_s")
    @classmethod
    def _settling_is_whole_tenths(cls, settling: float | None) -> float | None:
        """A tenth of a second is a whole number of control periods."""
        if settling is not None and abs(10.0 * settling - round(10.0 * settling)) > 1e-6:
            raise ValueError("must be a whole number of tenths of a second")
        return settling


NO_REQUIREMENTS = Requirements()
"""Limits that follow from the rating alone."""


def points_of(drive: DriveValues) -> tuple[RequiredPoint, ...]:
    """Return the operating points at which the ripple of a drive is required."""
    rating, stated = drive.rating, drive.requirements.point
    torque = POINT_POWER_SHARE * rating.rated_power_w / (rating.highest_speed_rpm * RADIANS_PER_RPM)
    return stated or (RequiredPoint(speed_rpm=rating.highest_speed_rpm, torque_n_m=rounded(torque, 3)),)


def check_points(requirements: Requirements, rating: Rating) -> None:
    """Refuse a point at a speed at which no search is judged."""
    for point in requirements.point:
        if not rating.base_speed_rpm < point.speed_rpm <= rating.overspeed_rpm:
            raise ValueError(
                f"the key 'requirements.point' has one at {point.speed_rpm:g} rpm, but must be above the base speed of "
                f"{rating.base_speed_rpm:g} rpm and at most the overspeed of {rating.overspeed_rpm:g} rpm"
            )

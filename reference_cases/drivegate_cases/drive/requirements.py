"""The table `[requirements]` of a drive: the limits that its controllers are judged by."""

from __future__ import annotations

from typing import Any, Final

from pydantic import Field, ValidationInfo, field_validator

from drivegate_cases.documents.document import Section
from drivegate_cases.drive.rating import Rating

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


def _from_least(key: str) -> dict[str, Any]:
    """Return what a JSON Schema states of the least value, which a validator refuses with its reason."""
    return {"minimum": LEAST[key][0]}


class RequiredPoint(Section):
    """An operating point at which the torque ripple is required to stay below its limit."""

    speed_rpm: float = Field(gt=0.0, le=1e6, description="speed, in turns a minute")
    torque_n_m: float = Field(gt=0.0, le=2e6, description="torque of the load, in newton metres")


class Requirements(Section):
    """Limits of the checks; one that has a unit follows from the rating where it is left out."""

    speed_tolerance_rpm: float | None = Field(
        default=None,
        json_schema_extra=_from_least("speed_tolerance_rpm"),
        le=1e6,
        description="greatest speed error k1 of a search that has converged, by default 1 % of base speed",
    )
    power_tolerance_percent: float = Field(
        default=0.5,
        json_schema_extra=_from_least("power_tolerance_percent"),
        le=100.0,
        description="greatest variation k2 of the current sum of a search that has converged, in percent",
    )
    angle_tolerance_deg: float = Field(
        default=1.0,
        json_schema_extra=_from_least("angle_tolerance_deg"),
        le=90.0,
        description="greatest movement of the advance angle of a search that has converged, in electrical degrees",
    )
    settling_s: float | None = Field(
        default=None,
        ge=0.1,
        le=3600.0,
        description="time in which a search has to converge, by default 66 mechanical time constants (inertia times "
        "base speed over rated torque) or 550 electrical periods at base speed, the longer of both in steps of "
        "1, 1.5, 2, 3, 5, 7 times 6 s and never less than 6 s",
    )
    optimum_tolerance_percent: float = Field(
        default=2.0,
        json_schema_extra=_from_least("optimum_tolerance_percent"),
        le=1000.0,
        description="greatest excess of the current sum over the least one, in percent",
    )
    ripple_percent: float | None = Field(
        default=None,
        json_schema_extra=_from_least("ripple_percent"),
        le=1000.0,
        description="limit of the torque ripple with the ideal regulator, peak to peak over mean, in percent, by "
        "default 13 of decoupled phases, and none of a star",
    )
    closed_loop_ripple_percent: float | None = Field(
        default=None,
        json_schema_extra=_from_least("closed_loop_ripple_percent"),
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


def check_points(requirements: Requirements, rating: Rating) -> None:
    """Refuse a point at a speed at which no search is judged."""
    for point in requirements.point:
        if not rating.base_speed_rpm < point.speed_rpm <= rating.overspeed_rpm:
            raise ValueError(
                f"the key 'requirements.point' has one at {point.speed_rpm:g} rpm, but must be above the base speed of "
                f"{rating.base_speed_rpm:g} rpm and at most the overspeed of {rating.overspeed_rpm:g} rpm"
            )

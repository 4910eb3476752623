"""What the drive of a result can do, as it is read again: every key with its type and meaning."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from drivegate_cases.documents.document import Section

Number = Annotated[float | None, Field(description="null where it is no finite number")]
Finite = Annotated[float, Field(allow_inf_nan=False)]


class RatingSection(Section):
    """What the drive is rated for."""

    base_speed_rpm: Finite = Field(gt=0.0, description="speed from which on power is constant")
    highest_speed_rpm: Finite = Field(gt=0.0, description="speed up to which it is")
    overspeed_rpm: Finite = Field(gt=0.0, description="greatest speed")
    rated_power_w: Finite = Field(description="rated power at the shaft")
    current_limit_a: Finite = Field(description="greatest current reference")


class LineSection(Section):
    """The recommended line of initial angles."""

    start_deg: Number = Field(
        description="angle at base speed; null where rated power is out of reach throughout"
    )
    slope_deg_per_rpm: Number = Field(description="rise above base speed")
    least_in_hand_percent: Number = Field(description="least torque in hand along it, over rated torque")
    least_in_hand_at_rpm: Number = Field(description="where that is")


class TimeScalesSection(Section):
    """Times that follow from the drive's constants, in seconds, and a frequency."""

    electrical_s: Number = Field(description="time constant of a winding, L/R; null without resistance")
    current_rise_s: Finite = Field(description="from none to the current limit at standstill, L·I/V")
    mechanical_at_base_s: Finite = Field(description="J·ω/T at base speed")
    mechanical_at_highest_s: Finite = Field(description="J·ω/T at the highest speed")
    run_up_s: Finite = Field(description="from base to highest speed with rated power")
    electrical_frequency_hz: Finite = Field(description="electrical frequency at the highest speed")
    half_cycle_s: Finite = Field(description="half an electrical cycle there")
    drift_s: Finite = Field(description="in which a lost rated torque costs 1 % of base speed")
    decision_s: Finite = Field(description="for which a search watches Σ|i| before it moves again")
    search_s: Number = Field(
        description="that a search takes from the line to the least Σ|i|; null without a line"
    )
    largest_control_period_s: Finite = Field(description="largest sensible control period")


class SpeedPointSection(Section):
    """What the drive can do at one speed; null where rated power is out of reach."""

    speed_rpm: Finite = Field(gt=0.0, description="speed")
    rated_torque_nm: Finite = Field(description="torque of rated power, constant below base speed")
    greatest_torque_nm: Finite = Field(description="greatest torque at the current limit over all angles")
    greatest_torque_deg: Finite = Field(description="the angle that gives it")
    greatest_power_w: Finite = Field(description="its power, before friction takes its part")
    torque_without_advance_nm: Finite = Field(description="torque at the current limit and 0°")
    edge_deg: Number = Field(description="smallest angle for rated torque")
    advance_deg: Number = Field(description="angle that gives it with the least Σ|i|")
    current_sum_a: Number = Field(description="Σ|i| there")
    input_power_w: Number = Field(description="net input power there")
    ripple_percent: Number = Field(
        description="torque ripple there, of the ideal regulator, peak to peak over mean"
    )
    line_deg: Number = Field(description="angle of the recommended line")
    line_torque_nm: Number = Field(description="torque at the current limit along it")


class EnvelopeSection(Section):
    """What the drive can do over speed, whoever controls it."""

    rating: RatingSection = Field(description="rating of the drive")
    has_band: bool = Field(
        description="flag that is false where the band is so narrow that it is taken as none"
    )
    line: LineSection = Field(description="the recommended line of initial angles")
    rated_torque_without_advance_up_to_rpm: Number = Field(
        description="speed up to which rated torque takes no advance; null where it always does"
    )
    greatest_ripple_percent: Number = Field(
        description="greatest of the ripples where rated power is required"
    )
    time_scales: TimeScalesSection = Field(description="times, and what they mean for a controller")
    points: tuple[SpeedPointSection, ...] = Field(
        min_length=2, description="from the lowest speed to the highest"
    )

"""Sections of the result document: what its drive can do, and how a controller of duty ratios behaved in plain runs."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from drivegate_cases.documents.document import Section

Finite = Annotated[float, Field(allow_inf_nan=False)]
Number = Annotated[float | None, Field(description="null where it is no finite number")]
Curve = Annotated[tuple[Finite, ...], Field(min_length=2, max_length=5000)]


class StepSection(Section):
    """The step of the torque reference with the least margin, and what followed it."""

    speed_rpm: Finite = Field(description="speed that the shaft was held at")
    before_nm: Finite = Field(description="reference before it")
    after_nm: Finite = Field(description="reference from time 0 on")
    overshoot_percent: Finite = Field(description="greatest torque beyond the reference, over the step")
    rise_ms: Number = Field(
        description="time to `reached_percent` of the step; null where that was not reached"
    )
    reached_percent: Finite = Field(
        default=90.0,
        description="share of the step by which its time is measured, less by what dead time loses",
    )
    allowed_ms: Finite = Field(description="longest time that is allowed")
    overshoot_limit_percent: Finite = Field(description="greatest overshoot that is allowed")
    time_ms: Curve = Field(description="end of each control period")
    torque_nm: Curve = Field(description="mean torque of each")
    direct_current_a: Curve = Field(description="current along the magnet's axis at its end")
    quadrature_current_a: Curve = Field(description="current across it at its end")


class PathSection(Section):
    """Currents of the rotor frame through a run, at points that are evenly far apart."""

    scenario: str = Field(description="name of the scenario")
    speed_rpm: Curve = Field(description="speed")
    direct_current_a: Curve = Field(description="current along the magnet's axis")
    quadrature_current_a: Curve = Field(description="current across it")


class EfficiencyPointSection(Section):
    """A steady state at one of eight operating points derived from those of IEC 61800-9-2."""

    speed_share: Finite = Field(description="speed over base speed")
    torque_share: Finite = Field(description="torque over rated torque")
    speed_rpm: Finite = Field(description="speed")
    torque_nm: Finite = Field(description="torque of the fundamental")
    direct_current_a: Finite = Field(description="mean current along the magnet's axis")
    quadrature_current_a: Finite = Field(description="mean current across it")
    loss_w: Finite = Field(description="copper and core loss of the fundamental")
    least_loss_w: Number = Field(
        description="least such loss for the same torque within the limits; null where none is known"
    )
    least_loss_direct_a: Number = Field(description="current along the magnet's axis that gives it")
    least_loss_quadrature_a: Number = Field(description="current across it that gives it")
    above_least_percent: Number = Field(description="loss above the least one")
    efficiency_percent: Number = Field(
        description="mechanical power over that and the loss; null at standstill"
    )


class TorqueSection(Section):
    """Torque at base speed and rated torque within control periods, by the exact plant and the recorded commands."""

    speed_rpm: Finite = Field(description="speed")
    mean_nm: Finite = Field(description="mean torque")
    turns: int = Field(ge=1, description="electrical periods that were followed")
    electrical_frequency_hz: Finite = Field(description="electrical frequency")
    carrier_frequency_hz: Finite = Field(description="frequency of the carrier")
    peak_to_peak_percent: Finite = Field(
        description="greatest less least torque at any instant, over rated torque"
    )
    angle_deg: Curve = Field(
        description="electrical angle at the start of control periods, over one electrical period"
    )
    least_nm: Curve = Field(description="least torque at any instant of them")
    greatest_nm: Curve = Field(description="greatest torque at any instant of them")
    frequency_hz: Curve = Field(
        description="frequencies of the spectrum; of many neighbours that of the greatest"
    )
    amplitude_percent: Curve = Field(
        description="amplitudes by Fourier integrals under a Hann window, over rated torque"
    )


class BehaviourSection(Section):
    """How a controller of duty ratios behaves in plain runs."""

    step: StepSection | None = Field(default=None, description="a step; null where none was judged")
    range: PathSection = Field(description="from half of base speed to the highest speed and back")
    release: PathSection | None = Field(
        description="at the highest speed, a torque reference out of reach, and then none; null for a drive without "
        "field weakening"
    )
    points: tuple[EfficiencyPointSection, ...] = Field(max_length=8, description="the efficiency points")
    torque: TorqueSection | None = Field(
        default=None, description="null where an electrical period takes too many control periods"
    )


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

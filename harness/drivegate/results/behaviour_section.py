"""How a controller of duty ratios behaves in plain runs, as a result shows it: every key with its type and meaning."""

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
    rise_ms: Number = Field(description="time to 90 % of the step; null where that was not reached")
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

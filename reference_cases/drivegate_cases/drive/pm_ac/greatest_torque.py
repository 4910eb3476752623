"""The greatest torque that controllers of a PM AC drive have to reach, with field weakening and without it."""

from __future__ import annotations

from math import nan

from drivegate_models.pm_ac.fundamental import (
    LINEAR_LIMIT,
    SteadyState,
    most_torque_per_ampere,
    steady_state,
)
from drivegate_models.pm_ac.link_oracle import BRAKING, DRIVING, greatest_on_link
from drivegate_models.pm_ac.oracle import Limits, greatest_torque
from drivegate_models.pm_ac.plant.drive import PmAcDrive

_HALVINGS = 60


def greatest_within(plant: PmAcDrive, limits: Limits, speed: float, *, weakens: bool) -> SteadyState:
    """Find the steady state of greatest torque within limits at a speed (rad/s); all NaN where there is none.

    Without field weakening the currents are those of most torque per ampere. Their voltage rises with the current. On a
    link that is not ideal, the limit of the voltage is that of a source without a current.
    """
    if plant.dc_link.capacitance > 0.0:
        return _on_link(plant, limits, speed, DRIVING, weakens=weakens)
    if weakens:
        return greatest_torque(plant, limits, speed)

    def state(current: float) -> SteadyState:
        return steady_state(plant, speed, *most_torque_per_ampere(plant, current))

    if not state(0.0).voltage <= limits.voltage:
        return steady_state(plant, speed, nan, nan)
    low, high = 0.0, limits.current
    if state(high).voltage <= limits.voltage:
        return state(high)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if state(middle).voltage <= limits.voltage:
            low = middle
        else:
            high = middle
    return state(low)


def braking_within(plant: PmAcDrive, limits: Limits, speed: float, *, weakens: bool) -> SteadyState:
    """Find the steady state of greatest braking torque, which is negative, as `greatest_within` does.

    An ideal link takes whatever the shaft supplies: the driving torque, which needs more voltage, counts for both.
    """
    if plant.dc_link.capacitance > 0.0:
        return _on_link(plant, limits, speed, BRAKING, weakens=weakens)
    driving = greatest_within(plant, limits, speed, weakens=weakens)
    return driving._replace(quadrature=-driving.quadrature, torque=-driving.torque)


def _on_link(plant: PmAcDrive, limits: Limits, speed: float, sign: float, *, weakens: bool) -> SteadyState:
    source = limits.voltage / LINEAR_LIMIT + 2.0 * plant.switch_drop
    return greatest_on_link(plant, float(source), float(speed), float(limits.current), sign, weakens)

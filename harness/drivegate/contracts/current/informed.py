"""A witness that knows the plant: its angle is the optimum of the true plant, found by exhaustive search.

It serves every drive of this contract. It shows that a requirement can be met, not that a search can meet it.
"""

from __future__ import annotations

from math import inf, isfinite, pi, radians
from typing import Final

from drivegate_cases.drive.limits import limits_of
from drivegate_cases.scenario.circumstance import Circumstance, circumstance
from drivegate_cases.scenario.profile import Dwell, dwell_torque, dwells
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.current.signals import Command, Nameplate, Sense
from drivegate_models.machine.friction import friction_torque
from drivegate_models.steady.oracle import least_current_sum, point_at_torque
from drivegate_models.units import RADIANS_PER_RPM

# A loop has to stay off the edge below which the torque is lost. It leaves the optimum by a few steps (rad), and where
# `CNV-2` judges the current sum by no more than costs this share of what the check allows (1).
_SHARE_FOR_EDGE: Final = 0.4
_STEP: Final = radians(0.25)
_MOST_STEPS: Final = 12
# Rate of the angle (rad/s), so that no step of it disturbs the speed.
_SLEW: Final = radians(40.0)
# Share of the reference within which the speed is held (1).
_HELD: Final = 0.01
# Rates of the speed regulator: over the electrical frequency at base speed, the second where the shaft is light (1);
# over the rate at which rated power moves the shaft (1); and in a control period (1).
_BANDWIDTH: Final = 0.12
_FASTEST: Final = 0.3
_OF_SHAFT: Final = 7.0
_IN_A_PERIOD: Final = 0.08
_INTEGRAL: Final = 0.2


class InformedController:
    """Regulates the speed, and takes the angle from the true plant's optimum at the present conditions."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._dwells = dwells(scenario)
        self._start = scenario.clock_start_s
        self._optima: dict[Dwell, float] = {}

    def reset(self, nameplate: Nameplate) -> None:
        """Forget everything but the scenario."""
        plate = nameplate
        self._plate = plate
        torque_per_ampere = plate.conducting_phases * plate.emf_constant
        electrical = plate.pole_pairs * plate.base_speed
        shaft = plate.rated_power / (plate.inertia * plate.base_speed * plate.base_speed)
        bandwidth = max(_BANDWIDTH * electrical, min(_OF_SHAFT * shaft, _FASTEST * electrical))
        bandwidth = min(bandwidth, _IN_A_PERIOD / plate.control_period)
        self._proportional = bandwidth * plate.inertia / torque_per_ampere
        self._integral_step = self._proportional * _INTEGRAL * bandwidth * plate.control_period
        self._integral = 0.0
        self._angle = 0.0
        self._place = 0

    def step(self, sense: Sense) -> Command:
        plate = self._plate
        error = sense.speed_reference - sense.speed
        wanted = self._integral + self._integral_step * error
        reference = min(max(self._proportional * error + wanted, 0.0), plate.current_limit)
        # At a limit the integral may only return.
        if reference == self._proportional * error + wanted or (error > 0.0) == (reference == 0.0):
            self._integral = min(max(wanted, 0.0), plate.current_limit)
        aim = self._aim(sense)
        # Only the way down is slow, so that the speed regulator follows it.
        lowest = self._angle - _SLEW * plate.control_period if sense.speed >= plate.base_speed else aim
        self._angle = max(aim, lowest)
        return Command(reference, self._angle, sense.half_supply_voltage * sense.current_magnitude_sum)

    def _aim(self, sense: Sense) -> float:
        """Return the optimum's angle where the speed is held, and no less than the nameplate's line elsewhere."""
        above = sense.speed - self._plate.base_speed
        if above < 0.0:
            return 0.0
        dwell = self._dwell(sense.time - self._start)
        if dwell is not None and dwell not in self._optima:
            self._optima[dwell] = optimum_angle(self._scenario, dwell)
        optimum = 0.0 if dwell is None else self._optima[dwell]
        if optimum > 0.0 and abs(sense.speed_reference - sense.speed) <= _HELD * sense.speed_reference:
            return optimum
        line = self._plate.advance_start + self._plate.advance_slope * above
        return max(optimum, min(max(line, 0.0), 0.5 * pi))

    def _dwell(self, time: float) -> Dwell | None:
        """Return the constant conditions at a time; None while something changes."""
        found = self._dwells
        while self._place + 1 < len(found) and found[self._place + 1].start <= time:
            self._place += 1
        if not found or not found[self._place].start <= time <= found[self._place].end:
            return None
        return found[self._place]


def optimum_angle(scenario: Scenario, dwell: Dwell) -> float:
    """Return the angle of the least current sum in constant conditions (rad electrical), 0 where there is none."""
    speed = dwell.speed_rpm * RADIANS_PER_RPM
    load = dwell_torque(scenario, dwell)
    if speed < scenario.drive.rating.base_speed_rpm * RADIANS_PER_RPM or load <= 0.0:
        return 0.0
    drive = scenario.drive.plant(dwell.scales)
    torque = load + friction_torque(drive, speed)
    voltage = dwell.supply_v * (1.0 - abs(dwell.imbalance))
    best = least_current_sum(drive, speed, torque, voltage)
    if not isfinite(best.advance):
        return 0.0
    is_judged = circumstance(scenario) is Circumstance.NOMINAL
    allowed = _SHARE_FOR_EDGE * limits_of(scenario.drive).optimum_tolerance if is_judged else inf
    angle, most = best.advance, (1.0 + allowed) * best.current_sum
    for step in range(1, _MOST_STEPS + 1):
        point = point_at_torque(drive, speed, best.advance + step * _STEP, torque, voltage)
        if not (point.robust and point.current_sum <= most):
            break
        angle = best.advance + step * _STEP
    return angle

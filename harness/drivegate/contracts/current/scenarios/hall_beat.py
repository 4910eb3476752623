"""Speeds at which Hall edges and control periods run almost in step, so that neither averages over the other."""

from __future__ import annotations

from itertools import pairwise

from drivegate_cases.drive.limits import mean_time
from drivegate_cases.scenario.piecewise import breakpoints, value_from, value_until
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import HallSensors

MOST_PERIODS = 12
"""Control periods in an electrical cycle up to which their number matters: two from one edge to the next (1)."""


def beats_with_edges(scenario: Scenario) -> bool:
    """Tell whether Hall edges fall on nearly the same instants of a control period, cycle after cycle, at some speed.

    The instants at which the edges are seen then drift so slowly that the commutation they give moves for longer than
    the means last by which convergence is judged: Σ|i| moves by 1 % at an angle that no controller has changed.
    """
    if not isinstance(scenario.sensors, HallSensors):
        return False
    rate = 1.0 / scenario.control_period_s
    slowest = 1.0 / mean_time(scenario.drive)
    for start, end in pairwise(breakpoints((scenario.speed_rpm,), scenario.duration_s)):
        speed = value_from(scenario.speed_rpm, start)
        frequency = scenario.drive.machine.pole_pairs * speed / 60.0
        if frequency == 0.0 or value_until(scenario.speed_rpm, end) != speed:
            continue
        periods = round(rate / frequency)
        if periods <= MOST_PERIODS and abs(periods * frequency - rate) < slowest:
            return True
    return False

"""What the plant could do at the operating point that a run was judged on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from drivegate.contracts.current.words.run_signals import RunSignals
from drivegate_cases.scenario.profile import Dwell, dwell_scales, dwell_torque, dwells
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError
from drivegate_models.steady import oracle
from drivegate_models.units import RADIANS_PER_RPM


@dataclass(frozen=True)
class JudgedPoint:
    """An operating point of a run, and the oracle's answers there."""

    begins_s: float
    """When its conditions begin (s)."""
    speed_rpm: float
    torque_nm: float
    """Speed reference, and torque of the load and of friction (N·m)."""
    edge_deg: float
    """Smallest angle that gives the torque (electrical deg)."""
    best_deg: float
    least_current_sum_a: float
    """Angle of least Σ|i|, and that (A)."""


def judged_point(signals: RunSignals) -> JudgedPoint | None:
    """Evaluate the oracle at the conditions at the end of the judged stretch."""
    end = signals.judged_s[1]
    held = [dwell for dwell in dwells(signals.scenario) if dwell.start < end]
    if not held or held[-1].end + 1e-9 < end:
        return None
    return _answers(signals.scenario, _from_its_begin(signals.scenario, held))


def _from_its_begin(scenario: Scenario, held: Sequence[Dwell]) -> Dwell:
    """Return the last stretch, from where its conditions began: a sensor that fails meanwhile changes none of them."""
    failures = {(lost.start_s, lost.end_s) for lost in scenario.dropouts}
    whole = held[-1]
    for earlier in reversed(held[:-1]):
        resumed = replace(earlier, start=whole.start, end=whole.end) == whole
        joined = earlier.end == whole.start or (earlier.end, whole.start) in failures
        if not (resumed and joined):
            break
        whole = replace(whole, start=earlier.start)
    return whole


@lru_cache(maxsize=200)
def _answers(scenario: Scenario, dwell: Dwell) -> JudgedPoint | None:
    drive = scenario.drive.plant(dwell_scales(scenario, dwell))
    speed = dwell.speed_rpm * RADIANS_PER_RPM
    load = dwell_torque(scenario, dwell)
    voltage = dwell.supply_v * (1.0 - abs(dwell.imbalance))
    torque = load + drive.friction + drive.viscous_friction * speed
    if load <= 0.0 or speed <= 0.0:
        return None
    try:
        edge = oracle.feasible_edge(drive, speed, torque, voltage)
        least = oracle.least_current_sum(drive, speed, torque, voltage)
    except InputError:
        return None
    if not (math.isfinite(edge) and math.isfinite(least.advance)):
        return None
    angles = np.degrees([edge, least.advance])
    return JudgedPoint(
        dwell.start, dwell.speed_rpm, torque, float(angles[0]), float(angles[1]), least.current_sum
    )

"""How a run lost its speed, in one clause."""

from __future__ import annotations

from typing import Final

import numpy as np

from drivegate.contracts.current.words.account import lost_at, passes_edge
from drivegate.contracts.current.words.run_signals import RunSignals

_STANDING: Final = 0.02


def loss_of_speed(signals: RunSignals) -> str | None:
    """Return how the speed was lost; None where it was maintained."""
    if lost_at(signals) is None:
        return None
    if abs(signals.speed_rpm[-1]) < _STANDING * float(np.max(np.abs(signals.speed_reference_rpm))):
        return "the motor stalls"
    if passes_edge(signals):
        return "the search takes the angle past the feasible edge, and the speed is lost"
    limit = signals.scenario.drive.rating.current_limit_a
    if signals.speed_error_rpm[-1] < 0.0 and signals.current_reference_a[-1] > 0.999 * limit:
        return f"the speed is lost with the current reference at its limit of {limit:g} A"
    return "the speed leaves its band and stays away"

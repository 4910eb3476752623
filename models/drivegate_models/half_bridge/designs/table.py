"""The design that takes the angle from a table over speed and current sum instead of searching for it.

The table was computed beforehand for one motor; of another one, speeds count as multiples of base speed and current
sums as multiples of that of rated power. The current sum stands for the torque: it is greater than
the table's as long as the angle is too great, so looking up again and again leads down to the table's own angle.
"""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

import numpy as np

from drivegate_models.compilation.kernels import inlined
from drivegate_models.half_bridge.designs.state import LOWEST_ANGLE
from drivegate_models.half_bridge.designs.table_values import (
    ANGLES_DEG,
    CURRENT_SUMS,
    FIRST_SPEED_RPM,
    SPEED_STEP_RPM,
)
from drivegate_models.units import RADIANS_PER_RPM

MOST_LOOKUPS: Final = 14
"""Look-ups after which the angle is kept whatever the current sum."""

_ANGLES = np.radians(np.array(ANGLES_DEG))
_SUMS = np.array(CURRENT_SUMS)
# Current sum of rated power of the motor of the table (A).
_RATED_SUM = 31.25
_FIRST_SPEED = FIRST_SPEED_RPM * RADIANS_PER_RPM
_SPEED_STEP = SPEED_STEP_RPM * RADIANS_PER_RPM
_WINDOW = radians(144.0)
_SAME_WINDOW = 1e-9
_CLOSE = radians(0.12)
_AWAY = radians(0.7)


@inlined
def angle_in_row(row: int, current_sum: float) -> float:
    """Interpolate in one row of the table.

    Parameters
    ----------
    row : int
        Which speed.
    current_sum : float
        Measured sum of current magnitudes (A).

    Returns
    -------
    float
        Advance angle (rad electrical); that of the row's end outside of it.
    """
    column = 0
    last = _SUMS.shape[1] - 1
    while column < last - 1 and _SUMS[row, column + 1] <= current_sum:
        column += 1
    span = _SUMS[row, column + 1] - _SUMS[row, column]
    share = min(max((current_sum - _SUMS[row, column]) / span, 0.0), 1.0)
    angle: float = _ANGLES[row, column] + share * (_ANGLES[row, column + 1] - _ANGLES[row, column])
    return angle


@inlined
def table_angle(speed: float, current_sum: float) -> float:
    """Return the table's advance angle.

    Parameters
    ----------
    speed : float
        Speed of the motor of the table at nominal supply (rad/s); with another supply, that of equal EMF over supply.
    current_sum : float
        Sum of current magnitudes (A), of the motor of the table.

    Returns
    -------
    float
        Advance angle (rad electrical).
    """
    # Short of the last row, so that there is always a next one to interpolate toward.
    position = min(max((speed - _FIRST_SPEED) / _SPEED_STEP, 0.0), _SUMS.shape[0] - 1.001)
    row = int(position)
    share: float = position - row
    lower: float = angle_in_row(row, current_sum)
    upper: float = angle_in_row(row + 1, current_sum)
    return lower + share * (upper - lower)


@inlined
def table_fits(controller: Any) -> bool:
    """Return whether the table's angles are of drives like this one: the window shifts them most.

    Parameters
    ----------
    controller : record of CONTROLLER_STATE
        The state.

    Returns
    -------
    bool
        Whether both have the same window.
    """
    fits: bool = abs(controller.window - _WINDOW) < _SAME_WINDOW
    return fits


@inlined
def look_up(state: Any, power: float) -> float:
    """Go to the table's angle for the current sum just measured; rest once it stays.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    power : float
        Current sum at the present angle (A); infinite where the torque was lost.

    Returns
    -------
    float
        Next offset (rad electrical).
    """
    controller = state.controller
    state.probes += 1
    if power < inf:
        state.best_offset = controller.offset
        state.best_power = power
        speed = state.speed * controller.nominal_voltage / controller.supply_voltage
        speed *= _FIRST_SPEED / controller.base_speed
        current_sum = power * (_RATED_SUM / controller.rated_sum)
        state.left = max(table_angle(speed, current_sum), LOWEST_ANGLE) - state.line
    else:
        # The plant is not the table's: stay above what has lost the torque.
        state.left = min(max(state.left, controller.forbidden) + _AWAY, state.home)
    if abs(state.left - controller.offset) < _CLOSE or state.probes >= MOST_LOOKUPS:
        state.finished = 1
    offset: float = state.left
    return offset

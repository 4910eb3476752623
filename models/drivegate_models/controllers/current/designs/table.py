"""The design that takes the angle from a table over speed and current sum instead of searching for it.

The table was computed beforehand for the drive. The current sum stands for the torque: it is greater than
the table's as long as the angle is too great, so looking up again and again leads down to the table's own angle.
"""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.designs.state import LOWEST_ANGLE, TABLE_COLUMNS, TABLE_ROWS

MOST_LOOKUPS: Final = 14
"""Look-ups after which the angle is kept whatever the current sum."""

_CLOSE = radians(0.12)
_AWAY = radians(0.7)


@inlined
def angle_in_row(state: Any, row: int, current_sum: float) -> float:
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
    sums, angles = state.table_sums, state.table_angles
    column = 0
    last = TABLE_COLUMNS - 1
    while column < last - 1 and sums[row, column + 1] <= current_sum:
        column += 1
    span = sums[row, column + 1] - sums[row, column]
    share = min(max((current_sum - sums[row, column]) / span, 0.0), 1.0)
    angle: float = angles[row, column] + share * (angles[row, column + 1] - angles[row, column])
    return angle


@inlined
def table_angle(state: Any, speed: float, current_sum: float) -> float:
    """Return the table's advance angle.

    Parameters
    ----------
    speed : float
        Speed at nominal supply (rad/s); with another supply, that of equal EMF over supply.
    current_sum : float
        Sum of current magnitudes (A).

    Returns
    -------
    float
        Advance angle (rad electrical).
    """
    # Short of the last row, so that there is always a next one to interpolate toward.
    position = min(max((speed - state.table_from) / state.table_step, 0.0), TABLE_ROWS - 1.001)
    row = int(position)
    share: float = position - row
    lower: float = angle_in_row(state, row, current_sum)
    upper: float = angle_in_row(state, row + 1, current_sum)
    return lower + share * (upper - lower)


@inlined
def look_up(state: Any, power: float) -> float:
    """Go to the table's angle for the current sum just measured; rest once it stays.

    Parameters
    ----------
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
        state.left = max(table_angle(state, speed, power), LOWEST_ANGLE) - state.line
    else:
        # The plant is not the table's: stay above what has lost the torque.
        state.left = min(max(state.left, controller.forbidden) + _AWAY, state.home)
    if abs(state.left - controller.offset) < _CLOSE or state.probes >= MOST_LOOKUPS:
        state.finished = 1
    offset: float = state.left
    return offset

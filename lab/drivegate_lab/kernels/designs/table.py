"""The design that looks up the angle in a table over speed and current sum instead of searching for it.

The table was computed beforehand for the drive. The current sum represents the torque: it exceeds the table's value
as long as the angle is too large, so repeated look-ups lead down to the table's own angle.
"""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_lab.kernels.designs.state import LOWEST_ANGLE, TABLE_COLUMNS, TABLE_ROWS
from drivegate_models.compilation.kernels import inlined

MOST_LOOKUPS: Final = 14
"""Look-ups after which the angle is final whatever the current sum."""

_CLOSE = radians(0.12)
_AWAY = radians(0.7)


@inlined
def angle_in_row(state: Any, row: int, current_sum: float) -> float:
    """Interpolate the advance angle (rad electrical) for a current sum (A) in one row, limited to the row's ends."""
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
    """Return the table's advance angle (rad electrical) for a current sum (A).

    `speed` is at nominal supply (rad/s); with another supply, it is the speed of equal EMF over supply.
    """
    # Stay below the last row, so that there is always a next row for interpolation.
    position = min(max((speed - state.table_from) / state.table_step, 0.0), TABLE_ROWS - 1.001)
    row = int(position)
    share: float = position - row
    lower: float = angle_in_row(state, row, current_sum)
    upper: float = angle_in_row(state, row + 1, current_sum)
    return lower + share * (upper - lower)


@inlined
def look_up(state: Any, current_sum: float) -> float:
    """Return the table's offset for the current sum just measured (rad electrical); finish once it stays the same.

    `current_sum` is in A, infinite if the torque was lost.
    """
    controller = state.controller
    state.probes += 1
    if current_sum < inf:
        state.best_offset = controller.offset
        state.best_power = current_sum
        speed = state.speed * controller.nominal_voltage / controller.supply_voltage
        state.left = max(table_angle(state, speed, current_sum), LOWEST_ANGLE) - state.line
    else:
        # The plant differs from the table's: stay above the angle that has lost the torque.
        state.left = min(max(state.left, controller.forbidden) + _AWAY, state.home)
    if abs(state.left - controller.offset) < _CLOSE or state.probes >= MOST_LOOKUPS:
        state.finished = 1
    offset: float = state.left
    return offset

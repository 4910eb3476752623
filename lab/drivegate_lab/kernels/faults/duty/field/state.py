"""State of a controller with a fault from the field, and the list of these faults."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE, duty_command_record
from drivegate_models.controllers.duty.state import FOC_STATE

FALL_MISSED: Final = 1
"""A torque reference of more than the power `size` above base speed is kept until it is zero or negative."""
WEAKENING_KEPT_AFTER_FALL: Final = 2
"""After a reference as of `FALL_MISSED`, d current of `extent` is kept until the reference is zero or negative."""
WEAKENING_KEPT_THROUGH_STOP: Final = 3
"""After a stop from a speed above `size`, d current of `extent` is kept below base speed."""
TORQUE_CUT_AFTER_STOP: Final = 4
"""After a stop from a speed above `size`, the torque is limited to `extent`."""

CLOCK_NEGATIVE: Final = 10
"""A reference is ramped up by a signed clock that is negative in the second half of `size`."""
CLOCK_RESTARTS: Final = 11
"""A reference is ramped up again, over `extent`, where a clock wraps around at `size`."""
CLOCK_LEAPS: Final = 12
"""Where a clock wraps around at `size`, the integral of the speed adopts the time between both readings."""
CLOCK_COARSE: Final = 13
"""The angle is extrapolated by what a time in single precision, in units of `size`, is short of."""

SMALL_DROPPED: Final = 20
"""Torque references below `size` count as zero."""
SMALL_BRAKING_DROPPED: Final = 21
"""Negative references above minus `size` count as zero."""

PARKS_AT_ZERO: Final = 30
"""The bridge is off after `size` control periods at rest, until the reference is no longer zero."""
LEAKS_AT_ZERO: Final = 31
"""The integral of the speed loses the share `size` of itself in each step with a reference of zero."""
DRIVING_LIMITED: Final = 32
"""Driving torque under a speed reference is limited to `size`."""
LOWERING_LIMITED: Final = 33
"""Braking torque under a speed reference is limited to `size`."""

LOST_SAMPLES_COUNTED: Final = 40
"""The bridge is off from the lost sample on whose number is `size`."""
LOST_SAMPLES_AVERAGED: Final = 41
"""Each lost sample of the currents adds `size` to the offset of the first sensor."""

LINK_SAG_TRIPS: Final = 50
"""The bridge is off for good at a link voltage below `extent` while a torque brakes a speed above `size`."""
LINK_FILTERED: Final = 51
"""The link's voltage is measured through a filter with a time constant of `size`."""

OFFSET_CREEPS: Final = 60
"""The offset of the first sensor creeps by `size` a second."""
HEATS_UP: Final = 61
"""A model of the winding's heat, with a time constant of `size`, limits the torque to `extent`."""
TURNS_SUMMED: Final = 62
"""The angle is a sum in single precision of what each period turns."""

INTEGRAL_CLEARED: Final = 70
"""The integral of the speed is cleared at each new reference."""
TORQUE_SLEWED: Final = 71
"""A torque reference changes by at most `size` in a control period."""
WINDS_UP: Final = 72
"""The torque of the speed regulator is never negative, and its integral continues meanwhile."""

FIELD_STATE: Final = np.dtype(
    [
        # The controller's step, and the addresses of the records below.
        ("step_address", np.int64),
        ("controller_address", np.int64),
        ("sense_address", np.int64),
        ("command_address", np.int64),
        ("currents_address", np.int64),
        ("controller", FOC_STATE),
        ("sense", DUTY_SENSE),
        ("command", DUTY_COMMAND),
        ("currents", np.float64, (3,)),
        # The fault, its sizes, and whether it acts under this kind of reference.
        ("fault", np.int64),
        ("size", np.float64),
        ("extent", np.float64),
        ("acts", np.int64),
        # Of the nameplate.
        ("base_speed", np.float64),
        ("control_period", np.float64),
        ("pole_pairs", np.float64),
        # What the fault remembers: control periods since reset, a number, a count, a stage, and all turns (rad).
        ("steps", np.int64),
        ("memory", np.float64),
        ("count", np.int64),
        ("stage", np.int64),
        ("turned", np.float32),
        # Time, reference and angle of the preceding step, and the offset of the first sensor (A).
        ("time_before", np.float64),
        ("reference_before", np.float64),
        ("angle_before", np.float64),
        ("offset", np.float64),
        # d current that is hidden from the controller (A).
        ("direct_hidden", np.float64),
        # 1 if the bridge is off.
        ("is_off", np.int64),
    ],
    align=True,
)
"""State of a controller with a field fault. It must not be moved in memory, and its step must outlive it."""


def field_state(step_address: int) -> NDArray[Any]:
    """Return a state without a fault, shape (1,) of FIELD_STATE, around a controller whose step is at an address."""
    state = np.zeros(1, FIELD_STATE)
    offsets: Any = FIELD_STATE.fields
    state["step_address"] = step_address
    for record in ("controller", "sense", "command", "currents"):
        state[f"{record}_address"] = state.ctypes.data + offsets[record][1]
    state["command"] = duty_command_record()
    return state

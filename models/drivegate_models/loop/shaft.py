"""Angle, speed and motion of the shaft over one control period."""

from __future__ import annotations

from math import floor, pi
from typing import NamedTuple

from drivegate_models.compilation.kernels import inlined


@inlined
def whole_turns(angle: float) -> int:
    """Return the number of whole turns in an angle (rad), negative for a negative angle."""
    return floor(angle * (0.5 / pi))


@inlined
def within_a_turn(angle: float) -> float:
    """Return an angle minus whole turns.

    `angle`: any angle, electrical or of the shaft (rad). Result: the angle in [0, 2 pi), except for rounding.
    """
    return angle - 2.0 * pi * whole_turns(angle)


@inlined
def shown_angle(angle: float) -> float:
    """Return the angle of the shaft as a controller senses it.

    `angle`: angle of the shaft, including whole turns (rad). Result: the angle in [0, 2 pi), with rounding too.
    """
    within = within_a_turn(angle)
    return within if 0.0 <= within < 2.0 * pi else 0.0


@inlined
def held_speed(speed: float, gained: float) -> float:
    """Return the constant speed at which a control period is computed: that of its middle, extrapolated.

    The error of a run then falls with the square of the period. With the speed of the period's start it would fall
    only in proportion to the period.

    `speed`: speed at the start of the period (rad/s). `gained`: change of speed in the preceding period (rad/s).
    Result: speed (rad/s), negative if a decelerating shaft would come to rest within the period.
    """
    return speed + 0.5 * gained


class Motion(NamedTuple):
    """Motion of the shaft in a control period: one constant acceleration before a standstill, and one after it."""

    gained: float
    """Change of speed (rad/s)."""
    trend: float
    """Change of speed in a whole period at the last acceleration (rad/s)."""
    share: float
    """Share of the period before the standstill; 1 if the shaft does not come to rest within the period (1)."""


@inlined
def motion_of(
    driving: float, opposing: float, damping: float, inertia: float, speed: float, length: float
) -> Motion:
    """Return the motion of a shaft that turns either way.

    - `driving`: torque of the machine less that of a weight (N m).
    - `opposing`: magnitude of the torques that oppose the rotation, and hold a standing shaft (N m).
    - `damping`: friction torque over speed (N m s/rad); it acts at the mean speed.
    - `inertia`: inertia of rotor and load (kg m2).
    - `speed`: speed at the start of the period (rad/s).
    - `length`: length of the period (s).
    """
    sense = 1.0 if speed > 0.0 or (speed == 0.0 and driving >= 0.0) else -1.0
    mobility = length / inertia
    loss = damping * mobility
    begin = sense * speed
    push = sense * driving
    change = ((push - opposing) * mobility - loss * begin) / (1.0 + 0.5 * loss)
    if begin + change > 0.0:
        return Motion(sense * change, sense * change, 1.0)
    if begin == 0.0:
        return Motion(0.0, 0.0, 1.0)
    # At rest within the period. What opposes then holds the shaft, or opposes the other sense of rotation.
    share = begin / ((opposing - push) * mobility + 0.5 * loss * begin)
    rest = 1.0 - share
    after = max((push - opposing) * mobility, 0.0) + min((push + opposing) * mobility, 0.0)
    turned = rest * after / (1.0 + 0.5 * loss * rest)
    return Motion(sense * (turned - begin), sense * after, share)


@inlined
def forward_motion(driving: float, resisting: float, inertia: float, speed: float, length: float) -> Motion:
    """Return the motion of a shaft that never turns backward: friction or a one-way clutch holds it at rest.

    - `driving`: impulse of the machine's torque (N m s).
    - `resisting`: torque of load and friction (N m); negative where the weight of a vehicle drives more than they take.
    - `inertia`: inertia of rotor and load (kg m2).
    - `speed`: speed at the start of the period, at least 0 (rad/s).
    - `length`: length of the period (s).
    """
    change = (driving - resisting * length) / inertia
    gained: float = max(change, -speed)
    share = -speed / change if change < -speed else 1.0
    return Motion(gained, gained, share)

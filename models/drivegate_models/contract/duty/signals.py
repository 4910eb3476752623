"""What passes between the harness and a candidate that answers with duty ratios, as Python sees it."""

from __future__ import annotations

from math import nan
from typing import Final, NamedTuple

SPEED_REFERENCE: Final = 0
"""The reference is a speed of the shaft (rad/s)."""
TORQUE_REFERENCE: Final = 1
"""The reference is a torque (N m)."""

LEG_OFF: Final = 0
"""Both switches of a leg are off."""
LEG_PWM: Final = 1
"""A leg follows its duty ratio."""
LEG_HIGH: Final = 2
"""The upper switch of a leg is on."""
LEG_LOW: Final = 3
"""The lower switch of a leg is on."""


class DutySense(NamedTuple):
    """What a controller senses at the start of a control period."""

    time: float
    """Simulated time (s)."""
    reference: float
    """Demanded speed (rad/s) or torque (N m), as the nameplate states; positive forward."""
    phase_currents: tuple[float, float, float]
    """Measured phase currents at this instant, positive into the machine (A)."""
    supply_voltage: float
    """Measured voltage of the whole dc link at this instant (V)."""
    supply_current: float
    """Mean current taken from the link in the period just ended (A); below 0 while the drive brakes, 0 at
    first."""
    angle: float
    """Angle of the shaft at this instant, from 0 up to but without 2 pi (rad). The electrical angle is
    `pole_pairs` times this one. Hall switches show it by counted electrical cycles, from the cycle of the
    start."""
    speed: float
    """Speed of the shaft at this instant (rad/s); below 0 backward."""
    hall: int = -1
    """States of the three Hall switches, the first phase's the lowest bit: 1, 3, 2, 6, 4, 5 forward, in
    sectors of 60 electrical degrees that begin at 30; -1 without such switches."""
    encoder_count: int = -1
    """Count of the encoder's edges, from 0 to one less than a turn has; `angle` is the middle between the
    edges of this count and the next. It is -1 without an encoder."""
    trip: int = 0
    """Flags of the drive's own protection; 0 for none, as always so far."""


class DutyCommand(NamedTuple):
    """A controller's answer; it acts `update_delay` periods later, and all legs are off until the first one acts."""

    duty_ratios: tuple[float, float, float]
    """Share of the period with the upper switch on, for each leg (1)."""
    legs: tuple[int, int, int] = (LEG_PWM, LEG_PWM, LEG_PWM)
    """`LEG_OFF`, `LEG_PWM`, `LEG_HIGH` or `LEG_LOW` for each leg."""
    next_period: float = 0.0
    """Requested length of the next control period (s); 0 keeps it, and no drive so far changes its own."""
    torque: float = nan
    angle: float = nan
    speed: float = nan
    input_power: float = nan
    """The controller's own estimates (N m, rad, rad/s, W); NaN for none."""
    fault: int = 0
    """The controller's own code of a fault; 0 for none."""


class DutyNameplate(NamedTuple):
    """The drive's nominal data."""

    kind: int
    """Kind of drive, as in the contract of current references."""
    reference_kind: int
    """`SPEED_REFERENCE` or `TORQUE_REFERENCE`."""
    pole_pairs: int
    """Pole pairs."""
    updates: int
    """Updates of the duty ratios in a period of the carrier."""
    update_delay: int
    """Control periods between an answer and its effect."""
    supply_voltage: float
    """Nominal voltage of the dc link (V)."""
    base_speed: float
    highest_speed: float
    """Range of constant power (rad/s)."""
    rated_power: float
    """(W)."""
    current_limit: float
    """Greatest peak current of a phase (A)."""
    control_period: float
    """(s)."""
    dead_time: float
    """(s)."""
    resistance: float
    """Of a phase (ohm)."""
    direct_inductance: float
    quadrature_inductance: float
    """Along and across the magnet's axis (H)."""
    magnet_flux: float
    """Peak flux linkage of a phase (V s)."""
    inertia: float
    """Of rotor and load (kg m2)."""
    core_loss_conductance: float = 0.0
    """Core loss a phase over the mean square of the voltage that the mean flux of a period induces (S); 0
    where it is not known."""

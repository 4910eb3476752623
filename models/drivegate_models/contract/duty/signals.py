"""The signals between the harness and a candidate that commands duty ratios, in Python."""

from __future__ import annotations

from math import nan
from typing import Final, NamedTuple

SPEED_REFERENCE: Final = 0
"""The reference is a speed of the shaft (rad/s)."""
TORQUE_REFERENCE: Final = 1
"""The reference is a torque (N m)."""
CURRENT_REFERENCE: Final = 2
"""The reference is a q-axis current (A), and the d-axis current is the controller's choice."""

OVERVOLTAGE: Final = 1
"""Flag of `DutySense.trip`: in the period just ended the link exceeded its limit."""
OVERCURRENT: Final = 2
"""Flag of `DutySense.trip`: in the period just ended a phase current exceeded `TRIP_CURRENT` times the limit."""
TRIP_CURRENT: Final = 1.5
"""Phase current of `OVERCURRENT`, over the current limit (1)."""

EXACT_POSITION: Final = 0
"""Angle and speed of the shaft are shown without edges."""
ENCODER_POSITION: Final = 1
"""Edges of an encoder show the shaft."""
HALL_POSITION: Final = 2
"""Three Hall switches show the shaft."""
NO_POSITION: Final = 3
"""Nothing shows the shaft: angle and speed are NaN."""

LEG_OFF: Final = 0
"""Both switches of a leg are off."""
LEG_PWM: Final = 1
"""A leg follows its duty ratio."""
LEG_HIGH: Final = 2
"""The upper switch of a leg is on."""
LEG_LOW: Final = 3
"""The lower switch of a leg is on."""


class DutySense(NamedTuple):
    """The controller's input at the start of a control period."""

    time: float
    """Simulated time (s)."""
    reference: float
    """Reference of speed (rad/s), torque (N m) or q-axis current (A), as stated by the nameplate; positive forward."""
    phase_currents: tuple[float, float, float]
    """Measured phase currents at this instant, positive into the machine (A)."""
    supply_voltage: float
    """Measured voltage of the whole dc link at this instant (V)."""
    supply_current: float
    """Mean current from the link into the bridge in the period just ended (A). It is negative while the drive brakes,
    and 0 in the first step. With a capacitor in the link, it is not the current of the source."""
    angle: float
    """Angle of the shaft at this instant, in [0, 2 pi) (rad). The electrical angle is `pole_pairs` times this angle.
    With Hall switches it is derived from electrical cycles counted from the start. It is NaN without a sensor."""
    speed: float
    """Speed of the shaft at this instant (rad/s); negative backward. It is NaN without a sensor."""
    hall: int = -1
    """States of the three Hall switches, with the first phase as the lowest bit: 1, 3, 2, 6, 4, 5 forward, in
    sectors of 60 electrical degrees that begin at 30; -1 without Hall switches."""
    encoder_count: int = -1
    """Count of the encoder's edges, from 0 to one less than the edges per turn. `angle` is the middle between the edges
    of this count and the next. It is -1 without an encoder."""
    trip: int = 0
    """Flags of the drive's own comparators, `OVERVOLTAGE` and `OVERCURRENT`; 0 for none. They report and leave the
    legs to the controller. It is always 0 on an ideal link."""
    phase_voltages: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Voltages of the three terminals relative to the negative rail (V), as unfiltered resistive dividers show them.

    They are sampled with the phase currents, before the legs switch, at speed and link voltage of the period just
    ended. A terminal with current is at a rail, apart from the drop of the switch or diode that conducts. A terminal
    without current, of a leg that is off, shows the back-EMF on top of the neutral's voltage. If no current flows at
    all, the dividers pull the terminals down until the lower diode of the lowest one conducts: differences are
    line-to-line EMFs, and the lowest voltage is minus the drop of a diode. Sensors add no error."""
    enable: int = 1
    """1 if the answer to this Sense acts on the bridge, 0 while the bridge is off before the run and after a restart.
    It is always 1 for a candidate whose manifest does not have `reads_enable = true`."""
    source_current: float = 0.0
    """Mean current from the source into the link in the period just ended (A); negative while the source takes energy
    back. On an ideal link it is `supply_current`."""
    winding_temperature: float = nan
    """Temperature of the windings, as a sensor shows it that lags by `temperature_lag` (deg C); NaN without one."""
    mean_voltages: tuple[float, float, float] = (nan, nan, nan)
    """Means of the voltages of the three terminals relative to the negative rail over the period just ended (V), after
    a filter if `voltage_filter` is not 0; in the first step `phase_voltages`. NaN on a drive that does not sense
    them. Drops, dead time and legs that are off are included, as in `phase_voltages`."""


class DutyCommand(NamedTuple):
    """A controller's output. It acts `update_delay` periods later; all legs are off until the first one acts."""

    duty_ratios: tuple[float, float, float]
    """Share of the period with the upper switch on, for each leg (1)."""
    legs: tuple[int, int, int] = (LEG_PWM, LEG_PWM, LEG_PWM)
    """`LEG_OFF`, `LEG_PWM`, `LEG_HIGH` or `LEG_LOW` for each leg."""
    next_period: float = 0.0
    """Requested length of the next control period (s); 0 for no change. No drive changes its period at present."""
    torque: float = nan
    """The controller's estimate of the torque (N m); NaN for none."""
    angle: float = nan
    """The controller's estimate of the shaft's angle (rad); NaN for none."""
    speed: float = nan
    """The controller's estimate of the shaft's speed (rad/s); NaN for none."""
    input_power: float = nan
    """The controller's estimate of its input power (W); NaN for none."""
    fault: int = 0
    """The controller's own fault code; 0 for none."""
    brake_duty: float = nan
    """Share of the period with the brake chopper on (1), which acts with the duty ratios; NaN to let the chopper follow
    its own thresholds."""


class DutyNameplate(NamedTuple):
    """The drive's nominal data."""

    kind: int
    """Kind of drive, with the numbers of the contract of current references."""
    reference_kind: int
    """`SPEED_REFERENCE`, `TORQUE_REFERENCE` or `CURRENT_REFERENCE`."""
    pole_pairs: int
    """Pole pairs."""
    updates: int
    """Updates of the duty ratios per carrier period."""
    update_delay: int
    """Control periods between a command and its effect."""
    supply_voltage: float
    """Nominal voltage of the dc link (V)."""
    base_speed: float
    """Lower end of the constant power range (rad/s)."""
    highest_speed: float
    """Upper end of the constant power range (rad/s)."""
    rated_power: float
    """Rated mechanical power (W)."""
    current_limit: float
    """Maximum peak current of a phase (A)."""
    control_period: float
    """Time between two steps (s)."""
    dead_time: float
    """Dead time between the switches of a leg (s)."""
    resistance: float
    """Resistance of a phase (ohm)."""
    direct_inductance: float
    """d-axis inductance (H)."""
    quadrature_inductance: float
    """q-axis inductance (H)."""
    magnet_flux: float
    """Peak flux linkage of a phase (V s)."""
    inertia: float
    """Inertia of rotor and load (kg m2)."""
    core_loss_conductance: float = 0.0
    """Core loss of a phase over the mean square of the voltage induced by the period's mean flux (S); 0 if unknown.
    The link supplies it, or the shaft while no current flows: it takes no part of a phase current, and none of the
    torque."""
    control_every: int = 1
    """Carrier periods from one step to the next; the duty ratios hold in all of them."""
    switch_drop: float = 0.0
    """Forward drop of a switch with current (V)."""
    diode_drop: float = 0.0
    """Forward drop of a diode with current (V)."""
    position_error: float = 0.0
    """Greatest error by which the shown electrical angle swings within a turn (rad): of the tracks of a sensor without
    edges, which also shows in the speed, or of the places of Hall switches; 0 for an encoder."""
    link_capacitance: float = 0.0
    """Capacitance of the dc link (F); 0 for an ideal link, of which the following fields are 0 and state no limit."""
    source_resistance: float = 0.0
    """Resistance between source and link (ohm)."""
    link_limit: float = 0.0
    """Greatest permitted voltage of the link (V)."""
    charge_limit: float = 0.0
    """Greatest mean current that the source takes back (A); 0 for a source that takes nothing back."""
    discharge_limit: float = 0.0
    """Greatest mean current of the source (A)."""
    chopper_voltage: float = 0.0
    """Voltage of the link from which the brake chopper turns on by itself (V); 0 without a chopper."""
    chopper_resistance: float = 0.0
    """Resistance of the brake chopper (ohm); 0 without a chopper."""
    position: int = 0
    """The sensor on the shaft: `EXACT_POSITION`, `ENCODER_POSITION`, `HALL_POSITION` or `NO_POSITION`."""
    least_speed: float = 0.0
    """Speed from which on the shaft must run steadily without a sensor (rad/s); 0 with one."""
    start_time: float = 0.0
    """Time from standstill to `least_speed` under half of rated torque (s); 0 with a sensor."""
    is_reversing: int = 1
    """1 if references may be negative, 0 for a drive that turns one way."""
    heat_capacity: float = 0.0
    """Heat capacity of all windings together (J/K); 0 without thermal data, and so are the following fields then."""
    thermal_resistance: float = 0.0
    """Rise of the windings' steady temperature above the ambient one, over the copper loss (K/W)."""
    ambient_temperature: float = 0.0
    """Temperature of the surroundings, at which `resistance` is stated (deg C)."""
    temperature_limit: float = 0.0
    """Greatest permitted temperature of the windings (deg C)."""
    temperature_coefficient: float = 0.0
    """Change of the resistance over `resistance`, for a change of temperature (1/K)."""
    temperature_lag: float = 0.0
    """Time constant with which the sensor follows the temperature (s)."""
    voltage_filter: float = 0.0
    """Time constant of the filter of one pole that the means of `mean_voltages` pass (s); 0 for none."""

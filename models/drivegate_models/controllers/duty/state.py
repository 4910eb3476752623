"""State of the field-oriented controllers, one record in the buffer that the caller provides."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.duty.records import DUTY_SENSE

LEAST_CURRENT: Final = 0
"""Minimum current for the torque, with as much field weakening as the voltage requires."""
UNWEAKENED: Final = 1
"""Minimum current, without field weakening."""
MODELLED_LOSS: Final = 2
"""Minimum loss of a model of copper and core."""
SEARCHED_LOSS: Final = 3
"""Minimum power from the link, found by search."""

AIMS: Final = {
    "foc": LEAST_CURRENT,
    "foc-mtpa": UNWEAKENED,
    "foc-loss-model": MODELLED_LOSS,
    "foc-loss-search": SEARCHED_LOSS,
    "predictive-flux": LEAST_CURRENT,
    "direct-torque": LEAST_CURRENT,
}
"""Criterion by which each controller chooses its currents."""

OF_CURRENTS: Final = 0
"""PI regulators of the currents."""
BY_PREDICTION: Final = 1
"""Predictive control of the stator flux."""
OF_TORQUE: Final = 2
"""PI regulators of the torque and of the stator flux's magnitude."""

REGULATIONS: Final = {"predictive-flux": BY_PREDICTION, "direct-torque": OF_TORQUE}
"""Regulation of the controllers without PI current regulators."""

FOC_STATE: Final = np.dtype(
    [
        # Criterion for the currents, and their regulation; set before reset, which does not change them.
        ("aim", np.int64),
        ("regulation", np.int64),
        # Constants, set by reset.
        ("regulates_speed", np.int64),
        ("control_period", np.float64),
        ("pole_pairs", np.float64),
        ("resistance", np.float64),
        ("direct_inductance", np.float64),
        ("quadrature_inductance", np.float64),
        ("magnet_flux", np.float64),
        ("core_loss_conductance", np.float64),
        ("current_limit", np.float64),
        # At the current limit, without a voltage limit.
        ("greatest_torque", np.float64),
        # Most negative d-axis current: more does not weaken the field further.
        ("deepest", np.float64),
        # Time from sampling to the middle of the period in which the command acts.
        ("lead", np.float64),
        # Share of a current error that is left when the command acts, while the errors decay.
        ("remaining_error", np.float64),
        # Flux by which the command that waits moves the currents, beside what maintains and decouples them (V s); not a
        # number where the limit has cut it.
        ("direct_moved", np.float64),
        ("quadrature_moved", np.float64),
        ("speed_gain", np.float64),
        ("speed_integral_step", np.float64),
        ("torque_step", np.float64),
        # Duty ratio lost to dead time in a phase with current, and the current from which compensation is complete.
        ("dead_ratio", np.float64),
        ("dead_current", np.float64),
        # Forward drops of a switch and of a diode (V).
        ("switch_drop", np.float64),
        ("diode_drop", np.float64),
        # Half of a carrier period (s), and the duty ratio of a leg that turns on in the middle of a control period.
        ("half_carrier", np.float64),
        ("edge_centre", np.float64),
        ("direct_gain", np.float64),
        ("quadrature_gain", np.float64),
        ("direct_integral_step", np.float64),
        ("quadrature_integral_step", np.float64),
        ("weakening_step", np.float64),
        # Regulators.
        ("speed_integral", np.float64),
        # The link: its capacitance, 0 for an ideal one (F), limits of the source's currents (A), power of the chopper
        # (W), voltage up to which braking may charge the capacitor (V), and its power over the squared voltage (S).
        ("link_capacitance", np.float64),
        ("charge_limit", np.float64),
        ("discharge_limit", np.float64),
        ("burning_power", np.float64),
        ("highest_link", np.float64),
        ("charging_gain", np.float64),
        # Requested torque.
        ("torque", np.float64),
        # Flux y of the last d-axis current by MTPA.
        ("added_flux", np.float64),
        ("direct_integral", np.float64),
        ("quadrature_integral", np.float64),
        # Share of the undistorted voltage that references may use.
        ("voltage_share", np.float64),
        # 1 if a command acts one period later, and the voltages of the last two commands (V, stationary frame).
        ("delay", np.int64),
        ("along_voltage", np.float64, (2,)),
        ("across_voltage", np.float64, (2,)),
        # Prediction of the flux: the voltage applied without that across the resistance, the prediction errors (V), and
        # the flux predicted for the next step.
        ("direct_given", np.float64),
        ("quadrature_given", np.float64),
        ("direct_missed", np.float64),
        ("quadrature_missed", np.float64),
        ("direct_foreseen", np.float64),
        ("quadrature_foreseen", np.float64),
        # Regulation of torque and flux: filtered reference currents, now and in the last two periods.
        ("direct_way", np.float64, (3,)),
        ("quadrature_way", np.float64, (3,)),
        # Search for minimum power: control periods for settling, and for averaging (minimum and present). Speed at
        # which a control period is a sixth of an electrical cycle, minimum speed, and inertia over a control period.
        ("search_settling", np.int64),
        ("search_shortest", np.float64),
        ("search_sixth", np.float64),
        ("search_slowest", np.float64),
        ("search_looking", np.int64),
        ("search_inertia", np.float64),
        # Its offset of the d-axis current, the last step, the number of consecutive successful steps, -1 after one that
        # failed, and the offset before that.
        ("search_offset", np.float64),
        ("search_step", np.float64),
        ("search_gains", np.int64),
        ("search_good_offset", np.float64),
        # Control periods since its last step; sums of the power, and of the speed in both halves of the averaging time;
        # power and speed before the last step; torque and speed of the operating point.
        ("search_count", np.int64),
        ("search_sum", np.float64),
        ("search_early", np.float64),
        ("search_late", np.float64),
        ("search_power", np.float64),
        ("search_pace", np.float64),
        ("search_torque", np.float64),
        ("search_speed", np.float64),
        # The Sense in use, with the angle extrapolated past an overdue Hall edge: the maximum extrapolation, its
        # minimum speed, the present extrapolation, and the last state, angle and speed from the switches.
        ("seen", DUTY_SENSE),
        ("led_on_longest", np.float64),
        ("led_on_from", np.float64),
        ("led_on", np.float64),
        ("hall_before", np.int64),
        ("hall_angle", np.float64),
        ("hall_speed", np.float64),
        # Share of a new speed in the filtered one, and that one (rad/s; NaN before the first step).
        ("filter_share", np.float64),
        ("filtered_speed", np.float64),
        # Hall switches of a shaft that a speed is requested of: rate of the observer (1/s), inertia, sector of the
        # states (-1 before the first step), whether an edge has shown the place, time since the last edge (s), its
        # place and what has been turned since (rad electrical), speed now and at that edge (rad/s electrical), what the
        # load takes of the acceleration (rad/s² electrical), and the torque of the step before (N m).
        ("observer_rate", np.float64),
        ("inertia", np.float64),
        ("sector", np.int64),
        ("is_placed", np.int64),
        ("since_edge", np.float64),
        ("place", np.float64),
        ("turned_on", np.float64),
        ("rate", np.float64),
        ("edge_rate", np.float64),
        ("slowing", np.float64),
        ("seen_torque", np.float64),
        # Whether an edge is overdue for longer than a lost one explains, the currents of the step before, the voltage
        # across the magnet's axis in it, and the current across it one step earlier.
        ("is_overdue", np.int64),
        ("direct_seen", np.float64),
        ("quadrature_voltage", np.float64),
        ("quadrature_seen", np.float64),
        ("quadrature_before", np.float64),
        # Plausibility: constants, the code of the first fault, 1 once a step has been seen, its values, and for how
        # long, or for which electrical angle, each value has been implausible.
        ("base_speed", np.float64),
        ("slowing_step", np.float64),
        ("stalling_torque", np.float64),
        ("stall_periods", np.int64),
        ("hall_stall_periods", np.int64),
        ("fault", np.int64),
        ("is_watching", np.int64),
        ("angle_before", np.float64),
        ("angle_drift", np.float64),
        ("farthest_drift", np.float64),
        # The decay of an unexplained flux in a period, and that flux (V s); of the step before half the resistive
        # voltage (V) and the flux (V s). Stationary frame.
        ("flux_decay", np.float64),
        ("along_drift", np.float64),
        ("across_drift", np.float64),
        ("along_drop", np.float64),
        ("across_drop", np.float64),
        ("along_flux", np.float64),
        ("across_flux", np.float64),
        ("hall_watched", np.int64),
        ("speed_seen", np.float64),
        ("flux_count", np.int64),
        ("sum_count", np.int64),
        ("speed_count", np.int64),
        ("stall_count", np.int64),
        # Least amplitude of the currents with which a phase can be missed (A).
        ("carrying_current", np.float64),
        ("passed", np.float64, (3,)),
        # Reference currents of the step before (A), and the least error of the flux (V s).
        ("direct_aim", np.float64),
        ("quadrature_aim", np.float64),
        ("least_error", np.float64),
        # Derating: the current limit (A) and maximum torque (N m) of cool windings, whether the present ones are less,
        # thermal data of the nameplate (no derating without a heat capacity), the time in which the limit is approached
        # (s), the shares by which the sensor follows in a control period and its difference corrects the estimate, and
        # the estimated temperatures of winding and sensor (deg C).
        ("full_current", np.float64),
        ("full_torque", np.float64),
        ("is_derated", np.int64),
        ("is_warm", np.int64),
        ("heat_capacity", np.float64),
        ("heat_conductance", np.float64),
        ("ambient_temperature", np.float64),
        ("temperature_limit", np.float64),
        ("temperature_coefficient", np.float64),
        ("approach", np.float64),
        ("temperature_share", np.float64),
        ("temperature_correction", np.float64),
        ("winding_temperature", np.float64),
        ("shown_temperature", np.float64),
    ],
    align=True,
)
"""In SI units. Speeds are electrical; the gains of the speed regulator apply to the shaft's speed."""


def foc_state(name: str) -> NDArray[Any]:
    """Return the state of one of `AIMS`, shape (1,) of FOC_STATE, with only its aim and its regulation set."""
    state = np.zeros(1, FOC_STATE)
    state["aim"] = AIMS[name]
    state["regulation"] = REGULATIONS.get(name, OF_CURRENTS)
    return state
